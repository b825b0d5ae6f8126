//! From loose slices to one stack: series told apart, slices in order, and every reason why they make no volume.

use std::path::{Path, PathBuf};

use super::file::{PixelForm, Slice};
use super::{Choice, Found, NAME, pixels};
use crate::error::{Problem, ReadError};
use crate::text::shorten;
use crate::values::{Decoded, Modality, Values, voxel_count};

/// What distances between neighbouring slices may differ by, as a part of the usual one.
const EVEN: f64 = 0.02;

/// The angle between the stack and the slices' normal from which on it counts as a tilted gantry, degrees.
const TILT: f64 = 0.1;

/// Slices of one series, lowest position along their normal first.
pub(super) struct Stack {
    slices: Vec<Found>,
    directions: Option<[[f64; 3]; 3]>,
    spacing: [f64; 3],
    notes: Vec<String>,
}

impl Stack {
    /// Takes the wanted series out of the slices and puts it in order.
    pub fn choose(slices: Vec<Found>, choice: &Choice) -> Result<Self, Problem> {
        let mut groups: Vec<Vec<Found>> = Vec::new();
        for found in slices {
            let same = |group: &&mut Vec<Found>| {
                let first = group.first();
                first.is_some_and(|first| first.slice.series_key() == found.slice.series_key())
            };
            match groups.iter_mut().find(same) {
                Some(group) => group.push(found),
                None => groups.push(vec![found]),
            }
        }
        let list = groups
            .iter()
            .map(|group| describe(group))
            .collect::<Vec<_>>()
            .join("; ");
        let several = groups.len() > 1;
        let chosen = match choice {
            // The first of several largest ones.
            Choice::Largest => (0..groups.len()).rev().max_by_key(|&i| groups[i].len()),
            Choice::Named(name) => groups.iter().position(|group| {
                let first = group.first().map(|found| &found.slice);
                first.is_some_and(|slice| [&slice.series_uid, &slice.series_number].contains(&name))
            }),
        };
        let Some(chosen) = chosen else {
            return Err(match choice {
                Choice::Named(name) if !list.is_empty() => Problem::format(
                    NAME,
                    format!("has no series `{}`, expected one of: {list}", shorten(name)),
                ),
                _ => Problem::NoImages,
            });
        };
        let slices = groups.swap_remove(chosen);
        let mut stack = Self::order(slices)?;
        if several {
            let shown = describe(&stack.slices);
            stack
                .notes
                .insert(0, format!("several series: shown is {shown}, of {list}"));
        }
        Ok(stack)
    }

    /// Sorts slices along their normal and checks that they are evenly stacked.
    fn order(slices: Vec<Found>) -> Result<Self, Problem> {
        let mut notes = Vec::new();
        let Some(first) = slices.first().map(|found| found.slice.clone()) else {
            return Err(Problem::format(NAME, "has no slices"));
        };
        voxel_count([first.columns.into(), first.rows.into(), slices.len() as u64])?;
        let spacing = in_plane(&slices, &first, &mut notes)?;
        let single = |slices, directions, notes| Self {
            slices,
            directions,
            spacing: [
                spacing[0],
                spacing[1],
                first.thickness.filter(|t| *t > 0.0).unwrap_or(1.0),
            ],
            notes,
        };
        let Some([row, column]) = first.directions else {
            if slices.len() == 1 {
                return Ok(single(slices, None, notes));
            }
            return Err(missing(&slices[0], "orientation (0020,0037)"));
        };
        let normal = cross(row, column);
        let length = dot(normal, normal).sqrt();
        if !(0.99..=1.01).contains(&length) {
            let fault = format!("image orientation {row:?}, {column:?} is not two unit vectors at right angles");
            return Err(Problem::format(NAME, fault));
        }
        let directions = Some([row, column, normal]);
        if slices.len() == 1 {
            return Ok(single(slices, directions, notes));
        }
        let mut placed = Vec::with_capacity(slices.len());
        for found in slices {
            let Some(position) = found.slice.position else {
                return Err(missing(&found, "position (0020,0032)"));
            };
            placed.push((dot(position, normal) / length, position, found));
        }
        placed.sort_by(|a, b| a.0.total_cmp(&b.0));
        let step = even_step(&placed)?;
        check_tilt(&placed, normal)?;
        if placed.iter().any(|(_, _, found)| found.slice.inverted) {
            notes.push("the file shows its smallest values white (MONOCHROME1): values are kept as they are".into());
        }
        Ok(Self {
            slices: placed.into_iter().map(|(_, _, found)| found).collect(),
            directions,
            spacing: [spacing[0], spacing[1], step],
            notes,
        })
    }

    /// Reads the pixels of every slice; `bytes_of` yields a file's bytes.
    pub fn decode(
        self,
        name: &Path,
        notes: Vec<String>,
        bytes_of: impl Fn(&Path) -> Result<Vec<u8>, ReadError>,
    ) -> Result<Decoded, ReadError> {
        let fail = |problem| ReadError::new(name, problem);
        let first = self.slices[0].slice.clone();
        let dims = [first.columns as usize, first.rows as usize, self.slices.len()];
        // Slices of another form or scale meet in the data's unit; otherwise the stored integers are kept.
        let alike = |found: &Found| found.slice.rescale == first.rescale && found.slice.form == first.form;
        let even = self.slices.iter().all(alike);
        let mut values = empty(first.form, even);
        for Found { path, slice } in &self.slices {
            let at = |problem| ReadError::new(path, problem);
            let bytes = bytes_of(path)?;
            let pixels = pixels::decode(slice, &bytes).map_err(at)?;
            append(&mut values, &pixels, slice.rescale).map_err(at)?;
        }
        let mut all = notes;
        all.extend(self.notes);
        if !even {
            all.push(
                "the slices differ in scale or pixel form: values are kept in their unit, as floating point".into(),
            );
        }
        let decoded = Decoded::new(name.display().to_string(), dims, self.spacing, values)
            .map_err(|error| fail(error.into()))?
            .with_modality(Modality::from_code(&first.modality))
            .with_stated_window(first.window)
            .with_notes(all);
        let [slope, intercept] = if even { first.rescale } else { [1.0, 0.0] };
        let decoded = decoded.with_rescale(NAME, slope, intercept).map_err(fail)?;
        match self.directions {
            Some(directions) => decoded.in_patient(directions).map_err(fail),
            None => Ok(decoded),
        }
    }
}

/// A series in words.
fn describe(group: &[Found]) -> String {
    let Some(slice) = group.first().map(|found| &found.slice) else {
        return String::new();
    };
    let number = if slice.series_number.is_empty() {
        "without number"
    } else {
        &slice.series_number
    };
    let echo = if slice.echo.is_empty() {
        String::new()
    } else {
        format!(", echo {}", shorten(&slice.echo))
    };
    format!(
        "series {} ({}{echo}, {} slices of {} x {})",
        shorten(number),
        shorten(&slice.description),
        group.len(),
        slice.columns,
        slice.rows
    )
}

/// A slice without a field that a stack needs.
fn missing(found: &Found, what: &str) -> Problem {
    let file = file_name(&found.path);
    Problem::format(
        NAME,
        format!("{file} states no {what}, without which slices cannot be stacked"),
    )
}

fn file_name(path: &Path) -> String {
    shorten(
        &PathBuf::from(path.file_name().unwrap_or_default())
            .display()
            .to_string(),
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
        if !(0..2).all(|i| (other[i] - spacing[i]).abs() <= 1e-4 * spacing[i].abs()) {
            let file = file_name(&found.path);
            let fault = format!("{file} has pixel spacing {other:?}, expected {spacing:?} as in the other slices");
            return Err(Problem::format(NAME, fault));
        }
    }
    Ok(spacing)
}

/// The one distance between neighbouring slices.
fn even_step(placed: &[(f64, [f64; 3], Found)]) -> Result<f64, Problem> {
    let steps: Vec<f64> = placed.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
    let mut sorted = steps.clone();
    sorted.sort_by(f64::total_cmp);
    let usual = sorted[sorted.len() / 2];
    let between = |i: usize| {
        let (a, b) = (&placed[i], &placed[i + 1]);
        format!(
            "{} at {:.3} mm and {} at {:.3} mm",
            file_name(&a.2.path),
            a.0,
            file_name(&b.2.path),
            b.0
        )
    };
    if let Some(i) = steps.iter().position(|&step| step < 1e-3) {
        let fault = format!(
            "slices share a position ({}), expected one each: several acquisitions or times are mixed",
            between(i)
        );
        return Err(Problem::format(NAME, fault));
    }
    let uneven = |i: &usize| (steps[*i] - usual).abs() > EVEN * usual;
    let gaps: Vec<usize> = (0..steps.len()).filter(uneven).collect();
    let Some(&first) = gaps.first() else {
        // The mean over the stack, without the rounding of single positions.
        return Ok((placed[placed.len() - 1].0 - placed[0].0) / steps.len() as f64);
    };
    let skipped = |i: usize| (steps[i] / usual).round() - 1.0;
    let whole = |&i: &usize| skipped(i) >= 1.0 && (steps[i] / usual - skipped(i) - 1.0).abs() <= EVEN * 2.0;
    let fault = if gaps.iter().all(whole) {
        let count: f64 = gaps.iter().map(|&i| skipped(i)).sum();
        format!(
            "{count} slices are missing, first between {}; slices are {usual:.3} mm apart",
            between(first)
        )
    } else {
        format!(
            "slices are unevenly spaced: {:.3} mm between {}, {usual:.3} mm elsewhere, expected one distance",
            steps[first],
            between(first)
        )
    };
    Err(Problem::format(NAME, fault))
}

/// Refuses stacks whose slices are shifted against each other.
fn check_tilt(placed: &[(f64, [f64; 3], Found)], normal: [f64; 3]) -> Result<(), Problem> {
    let start = placed[0].1;
    for (_, position, found) in placed {
        let way = [0, 1, 2].map(|i| position[i] - start[i]);
        let along = dot(way, normal);
        let square = (dot(way, way) - along * along).max(0.0);
        let angle = square.sqrt().atan2(along.abs()).to_degrees();
        // Half a hundredth of a millimetre is rounding in the file.
        if angle > TILT && square.sqrt() > 0.005 {
            let file = file_name(&found.path);
            let fault = format!(
                "slices are shifted against each other: {file} lies {:.3} mm aside, {angle:.2} degrees off their normal \
                 (a tilted gantry), expected a straight stack",
                square.sqrt()
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
