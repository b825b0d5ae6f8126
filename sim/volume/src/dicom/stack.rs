//! From the slices of one phase to a stack: in order, evenly spaced, straight; and the reasons why they make none.

use std::path::Path;

use super::names::{file_name, list};
use super::slice::{PixelForm, Slice};
use super::{Found, NAME, pixels};
use crate::axes::Directions;
use crate::decoded::Decoded;
use crate::error::{Problem, ReadError};
use crate::meaning::Modality;
use crate::values::{Values, check_spacing, voxel_count};

/// How far a slice may lie off the best even stack, as a part of the distance between slices.
const EVEN: f64 = 0.05;

/// What is told of that, as the same part.
const WORTH_A_NOTE: f64 = 0.01;

/// The angle between the stack and the slices' normal up to which the stack counts as straight, degrees.
const TILT: f64 = 0.1;

/// How far a slice may lie aside, as a part of the distance between pixels; below, a greater tilt does not show.
const ASIDE: f64 = 0.5;

/// What pixel spacings of one series may differ by, as a part of them.
const SAME_SPACING: f64 = 1e-3;

/// What scales of one series may differ by, as a part of them: values of 16 bits stay within a tenth of a step.
const SAME_SCALE: f64 = 1e-6;

/// The largest cosine between a row and a column that is rounding in the file (1 degree).
const RIGHT_ANGLE: f64 = 0.0175;

/// Slices of one series, lowest position along their normal first.
pub(super) struct Stack {
    slices: Vec<Found>,
    directions: Option<[[f64; 3]; 3]>,
    spacing: [f64; 3],
    notes: Vec<String>,
}

impl Stack {
    /// Sorts slices along their normal and checks that they are evenly stacked.
    pub fn order(slices: Vec<Found>, mut notes: Vec<String>) -> Result<Self, Problem> {
        let Some(first) = slices.first().map(|found| found.slice.clone()) else {
            return Err(Problem::format(NAME, "has no slices"));
        };
        voxel_count([first.columns.into(), first.rows.into(), slices.len() as u64])?;
        let [column, row] = in_plane(&slices, &first, &mut notes)?;
        check_spacing([column, row, 1.0])?;
        if slices.iter().any(|found| found.slice.inverted) {
            notes.push("the file shows its smallest values white (MONOCHROME1): values are kept as they are".into());
        }
        let directions = axes(&first)?;
        if slices.len() == 1 {
            let thickness = first.thickness.filter(|t| *t > 0.0).unwrap_or(1.0);
            return Ok(Self {
                slices,
                directions,
                spacing: [column, row, thickness],
                notes,
            });
        }
        let Some([_, _, normal]) = directions else {
            return Err(missing(&slices[0], "orientation (0020,0037)"));
        };
        let mut placed = Vec::with_capacity(slices.len());
        for found in slices {
            let Some(position) = found.slice.position else {
                return Err(missing(&found, "position (0020,0032)"));
            };
            placed.push(Placed {
                along: dot(position, normal),
                position,
                found,
            });
        }
        placed.sort_by(|a, b| a.along.total_cmp(&b.along));
        let line = Line::fit(&placed);
        check_even(&placed, &line, normal, &mut notes)?;
        check_straight(&placed, &line, normal, ASIDE * column.min(row))?;
        // The mean over the stack, without the rounding of single positions.
        let step = (placed[placed.len() - 1].along - placed[0].along) / (placed.len() - 1) as f64;
        Ok(Self {
            slices: placed.into_iter().map(|placed| placed.found).collect(),
            directions,
            spacing: [column, row, step],
            notes,
        })
    }

    /// Reads the pixels of every slice; `bytes_of` yields a file's bytes.
    pub fn decode(
        self,
        name: &Path,
        bytes_of: impl Fn(&Path) -> Result<Vec<u8>, ReadError>,
    ) -> Result<Decoded, ReadError> {
        let fail = |problem| ReadError::new(name, problem);
        let first = self.slices[0].slice.clone();
        let dims = [first.columns as usize, first.rows as usize, self.slices.len()];
        // Slices of another form or scale meet in the data's unit; otherwise the stored integers are kept.
        let alike = |found: &Found| same_scale(found.slice.rescale, first.rescale) && found.slice.form == first.form;
        let even = self.slices.iter().all(alike);
        let mut values = empty(first.form, even);
        let mut padded = Vec::new();
        for of_file in self.slices.chunk_by(|a, b| a.path == b.path) {
            let path = &of_file[0].path;
            let at = |problem| ReadError::new(path, problem);
            let bytes = bytes_of(path)?;
            let take = |slice: &Slice, pixels: Vec<i64>| append(&mut values, &pixels, slice.rescale);
            let padding = pixels::decode(&bytes, of_file, take).map_err(at)?;
            if padding > 0 {
                padded.push(format!("{} ({padding} bytes)", file_name(path)));
            }
        }
        let mut notes = self.notes;
        if !padded.is_empty() {
            notes.push(format!(
                "padding after the pixels is ignored: {}",
                list(padded.into_iter())
            ));
        }
        if !even {
            notes.push(
                "the slices differ in scale or pixel form: values are kept in their unit, as floating point".into(),
            );
        }
        let decoded = Decoded::new(name.display().to_string(), dims, self.spacing, values)
            .map_err(|error| fail(error.into()))?
            .with_modality(Modality::from_code(&first.modality))
            .with_stated_window(first.window)
            .with_notes(notes);
        let [slope, intercept] = if even { first.rescale } else { [1.0, 0.0] };
        let decoded = decoded.with_rescale(NAME, slope, intercept).map_err(fail)?;
        match self.directions {
            Some(directions) => decoded.along(Directions::Patient(directions)).map_err(fail),
            None => Ok(decoded),
        }
    }
}

/// A slice and where it lies.
struct Placed {
    along: f64,
    position: [f64; 3],
    found: Found,
}

/// The line through evenly spaced points that is nearest to the slices' positions, by least squares.
struct Line {
    start: [f64; 3],
    step: [f64; 3],
}

impl Line {
    fn fit(placed: &[Placed]) -> Self {
        let count = placed.len() as f64;
        let middle = (count - 1.0) / 2.0;
        let (mut mean, mut step) = ([0.0; 3], [0.0; 3]);
        for (i, Placed { position, .. }) in placed.iter().enumerate() {
            for axis in 0..3 {
                mean[axis] += position[axis] / count;
                step[axis] += (i as f64 - middle) * position[axis];
            }
        }
        // The sum of (i - middle)².
        let weight = count * (count * count - 1.0) / 12.0;
        let step = step.map(|s| s / weight);
        Self {
            start: [0, 1, 2].map(|axis| mean[axis] - middle * step[axis]),
            step,
        }
    }

    /// How far a position lies off the point of slice `i`.
    fn off(&self, i: usize, position: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis| position[axis] - self.start[axis] - i as f64 * self.step[axis])
    }
}

/// The unit vector at right angles to a slice.
pub(super) fn normal_of(slice: &Slice) -> Option<[f64; 3]> {
    axes(slice).ok().flatten().map(|[_, _, normal]| normal)
}

/// Unit vectors along a row, down a column and along the normal; rounding in the file is taken off the column.
fn axes(slice: &Slice) -> Result<Option<[[f64; 3]; 3]>, Problem> {
    let Some([row, column]) = slice.directions else {
        return Ok(None);
    };
    let (lengths, cosine) = ([row, column].map(|v| dot(v, v).sqrt()), dot(row, column));
    if !(lengths.iter().all(|length| (0.99..=1.01).contains(length)) && cosine.abs() <= RIGHT_ANGLE) {
        let fault = format!("image orientation {row:?}, {column:?} is not two unit vectors at right angles");
        return Err(Problem::format(NAME, fault));
    }
    let normal = unit(cross(row, column));
    let row = unit(row);
    Ok(Some([row, cross(normal, row), normal]))
}

/// A slice without a field that a stack needs.
fn missing(found: &Found, what: &str) -> Problem {
    let file = file_name(&found.path);
    Problem::format(
        NAME,
        format!("{file} states no {what}, without which slices cannot be stacked"),
    )
}

/// The distance between pixels, which all slices have to agree on.
fn in_plane(slices: &[Found], first: &Slice, notes: &mut Vec<String>) -> Result<[f64; 2], Problem> {
    let Some(spacing) = first.pixel_spacing else {
        notes.push("the file states no pixel spacing: 1 is assumed".into());
        return Ok([1.0; 2]);
    };
    for found in slices {
        let other = found.slice.pixel_spacing.unwrap_or([f64::NAN; 2]);
        if !(0..2).all(|i| (other[i] - spacing[i]).abs() <= SAME_SPACING * spacing[i].abs()) {
            let file = file_name(&found.path);
            let fault = format!("{file} has pixel spacing {other:?}, expected {spacing:?} as in the other slices");
            return Err(Problem::format(NAME, fault));
        }
    }
    Ok(spacing)
}

/// Whether two scales yield the same values, to a small part of a stored step.
fn same_scale([slope, intercept]: [f64; 2], [other_slope, other_intercept]: [f64; 2]) -> bool {
    (slope - other_slope).abs() <= SAME_SCALE * other_slope.abs()
        && (intercept - other_intercept).abs() <= 0.1 * other_slope.abs()
}

/// Refuses slices that do not lie where an even stack has them.
fn check_even(placed: &[Placed], line: &Line, normal: [f64; 3], notes: &mut Vec<String>) -> Result<(), Problem> {
    let step = dot(line.step, normal);
    let off = |i: usize| dot(line.off(i, placed[i].position), normal);
    let worst = (0..placed.len()).fold(0, |worst, i| if off(i).abs() > off(worst).abs() { i } else { worst });
    let part = off(worst).abs() / step;
    if part <= EVEN {
        if part > WORTH_A_NOTE {
            notes.push(format!(
                "slices lie up to {:.3} mm off an even stack of {step:.4} mm, {:.1} % of it",
                off(worst).abs(),
                100.0 * part
            ));
        }
        return Ok(());
    }
    let steps: Vec<f64> = placed.windows(2).map(|pair| pair[1].along - pair[0].along).collect();
    let mut sorted = steps.clone();
    sorted.sort_by(f64::total_cmp);
    let usual = sorted[sorted.len() / 2];
    let between = |i: usize| {
        let place = |placed: &Placed| format!("{} at {:.3} mm", file_name(&placed.found.path), placed.along);
        format!("{} and {}", place(&placed[i]), place(&placed[i + 1]))
    };
    let uneven = |i: &usize| (steps[*i] - usual).abs() > 2.0 * EVEN * usual;
    let gaps: Vec<usize> = (0..steps.len()).filter(uneven).collect();
    let skipped = |i: usize| (steps[i] / usual).round() - 1.0;
    let whole = |&i: &usize| skipped(i) >= 1.0 && (steps[i] / usual - skipped(i) - 1.0).abs() <= 2.0 * EVEN;
    let fault = match gaps.first() {
        Some(&first) if gaps.iter().all(whole) => {
            let count: f64 = gaps.iter().map(|&i| skipped(i)).sum();
            format!(
                "{count} slices are missing, first between {}; slices are {usual:.3} mm apart",
                between(first)
            )
        }
        Some(&first) => format!(
            "slices are unevenly spaced: {:.3} mm between {}, {usual:.3} mm elsewhere, expected one distance",
            steps[first],
            between(first)
        ),
        None => format!(
            "slices are unevenly spaced: {} lies {:.3} mm off an even stack of {step:.3} mm, expected at most {:.3}",
            file_name(&placed[worst].found.path),
            off(worst).abs(),
            EVEN * step
        ),
    };
    Err(Problem::format(NAME, fault))
}

/// Refuses stacks that lean, and slices that lie aside, by more than `aside` mm.
fn check_straight(placed: &[Placed], line: &Line, normal: [f64; 3], aside: f64) -> Result<(), Problem> {
    let sideways = |way: [f64; 3]| {
        let along = dot(way, normal);
        (dot(way, way) - along * along).max(0.0).sqrt()
    };
    let angle = sideways(line.step).atan2(dot(line.step, normal)).to_degrees();
    let shift = sideways(line.step) * (placed.len() - 1) as f64;
    if angle > TILT && shift > aside {
        let fault = format!(
            "the stack leans by {angle:.2} degrees off its slices' normal (a tilted gantry), {shift:.3} mm from the first \
             slice to the last, expected a straight stack (at most {TILT} degrees or {aside:.3} mm)"
        );
        return Err(Problem::format(NAME, fault));
    }
    for (i, Placed { position, found, .. }) in placed.iter().enumerate() {
        let off = sideways(line.off(i, *position));
        if off > aside {
            let file = file_name(&found.path);
            let fault = format!(
                "slices are shifted against each other: {file} lies {off:.3} mm aside, expected at most {aside:.3} mm, half \
                 a pixel"
            );
            return Err(Problem::format(NAME, fault));
        }
    }
    Ok(())
}

/// No values yet, in a type that holds those to come.
fn empty(form: PixelForm, even: bool) -> Values {
    match (form.bytes, form.signed) {
        (4, _) if !even => Values::F64(Vec::new()),
        _ if !even => Values::F32(Vec::new()),
        (1, false) => Values::U8(Vec::new()),
        (1, true) => Values::I8(Vec::new()),
        (2, false) => Values::U16(Vec::new()),
        (2, true) => Values::I16(Vec::new()),
        (_, false) => Values::U32(Vec::new()),
        (_, true) => Values::I32(Vec::new()),
    }
}

/// Adds a slice's pixels. Integers fit their type by its choice in [`empty`]; floating point takes
/// values in the data's unit.
fn append(values: &mut Values, pixels: &[i64], [slope, intercept]: [f64; 2]) -> Result<(), Problem> {
    fn extend<T>(values: &mut Vec<T>, pixels: &[i64], convert: impl Fn(i64) -> T) -> Result<(), Problem> {
        values.try_reserve(pixels.len()).map_err(|_| Problem::Memory {
            bytes: ((values.len() + pixels.len()) * size_of::<T>()) as u64,
        })?;
        values.extend(pixels.iter().map(|&pixel| convert(pixel)));
        Ok(())
    }
    match values {
        Values::U8(v) => extend(v, pixels, |p| p as u8),
        Values::I8(v) => extend(v, pixels, |p| p as i8),
        Values::U16(v) => extend(v, pixels, |p| p as u16),
        Values::I16(v) => extend(v, pixels, |p| p as i16),
        Values::U32(v) => extend(v, pixels, |p| p as u32),
        Values::I32(v) => extend(v, pixels, |p| p as i32),
        Values::F32(v) => extend(v, pixels, |p| (p as f64 * slope + intercept) as f32),
        Values::F64(v) => extend(v, pixels, |p| p as f64 * slope + intercept),
    }
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = dot(a, a).sqrt();
    a.map(|c| c / length)
}
