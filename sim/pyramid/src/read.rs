//! Volumes of colour and extinction from what files hold, and from scalar volumes through a transfer function.
//!
//! Source: Kraus and Bürger, equation 4: an opacity alpha over a distance d' is the extinction `tau = -ln(1 - alpha) / d'`.
//! Extinctions above `tau_max`, and above [`OPAQUE`] / d' where none is asked for, are held to it and counted. Without a `tau_max`
//! asked for it is the largest that there is, so that the root's 8 bits are spent on what there is.

use std::ops::RangeInclusive;

use slicecast_volume::colours::Colours;
use slicecast_volume::decoded::Orientation;
use slicecast_volume::values::Values;
use thiserror::Error;

use crate::volume::{RgbaVolume, Voxels};
use crate::voxel::{Codes, Entry, MAX_CODE, root};
use crate::write::{ALPHA_DISTANCE, CODES, ENTRIES, TAU_MAX, VOXEL};

/// Extinction times distance of what counts as opaque: e^-15 = 3e-7 of the light is left.
pub const OPAQUE: f64 = 15.0;

/// Distances of opacities.
const DISTANCES: RangeInclusive<f64> = 1e-9..=1e9;

/// Largest extinctions: of the faintest single-precision opacity over the longest distance, and of all above the opaque.
const TAUS: RangeInclusive<f64> = 1e-60..=1e12;

/// Where the opacity of colours without one comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OpacityRule {
    /// The luminance of the colour: 0.2126 R + 0.7152 G + 0.0722 B of the values as they are stored.
    Luminance,
    /// The luminance through a transfer function.
    Curve(Curve),
    /// The same everywhere, 0 to 1.
    Constant(f64),
}

/// Opacities by luminance: points with straight lines between them, and beyond the outermost their own opacities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curve {
    points: [[f64; 2]; Self::MOST],
    count: usize,
}

impl Curve {
    /// Points at most.
    pub const MOST: usize = 8;

    /// Of points of luminance and opacity, both 0 to 1, luminances rising; `None` of others, of fewer than two or of more than
    /// [`Curve::MOST`].
    pub fn new(given: &[[f64; 2]]) -> Option<Self> {
        let inside = given.iter().flatten().all(|value| (0.0..=1.0).contains(value));
        let rising = given.windows(2).all(|pair| pair[0][0] < pair[1][0]);
        let mut points = [[0.0; 2]; Self::MOST];
        if given.len() < 2 || !inside || !rising {
            return None;
        }
        points.get_mut(..given.len())?.copy_from_slice(given);
        let count = given.len();
        Some(Self { points, count })
    }

    /// The opacity of a luminance.
    pub fn at(&self, luminance: f64) -> f64 {
        let points = &self.points[..self.count];
        match points.iter().position(|[place, _]| *place > luminance) {
            Some(0) => points[0][1],
            None => points[self.count - 1][1],
            Some(behind) => {
                let ([from, low], [to, high]) = (points[behind - 1], points[behind]);
                low + (high - low) * (luminance - from) / (to - from)
            }
        }
    }
}

/// What the user states about a file of colours.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stated {
    /// The distance over which its opacities are meant, in the unit of the spacing; above 0.
    pub alpha_distance: Option<f64>,
    /// The largest extinction to keep, per unit of the spacing; above 0.
    pub tau_max: Option<f64>,
    /// Where opacities come from if it has none.
    pub opacity: Option<OpacityRule>,
}

/// Why colours are no volume of colour and extinction.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RgbaError {
    /// Opacities without a distance.
    #[error(
        "has opacities, but does not say over which distance they are meant; --alpha-distance states it, in the unit of the spacing"
    )]
    NoDistance,
    /// Colours without opacities.
    #[error(
        "has colours without opacities; --opacity luminance or --opacity NUMBER says what they are to be, --alpha-distance over which distance"
    )]
    NoOpacity,
    /// A rule for opacities that are there.
    #[error("has opacities of its own, expected no --opacity")]
    OwnOpacity,
    /// Statements about a file that makes its own.
    #[error("states extinctions of its own, expected none of --alpha-distance, --tau-max and --opacity")]
    OwnExtinction,
    /// A number type without a full scale.
    #[error("has colours of type {found}, expected uint8, uint16, float or double")]
    Type {
        /// The type's name.
        found: &'static str,
    },
    /// A value that is no fraction, in a file of floats.
    #[error("voxel ({}, {}, {}) has the value {value}, expected colours and opacities from 0 to 1", .voxel[0], .voxel[1], .voxel[2])]
    Fraction {
        /// x, y, z of the first such voxel.
        voxel: [usize; 3],
        /// The value.
        value: f64,
    },
    /// A key of the header that cannot be understood.
    #[error("header key `{key}` is `{value}`, expected {expected}")]
    Key {
        /// The key.
        key: &'static str,
        /// Its value.
        value: String,
        /// What can be read.
        expected: &'static str,
    },
    /// A key that has to be there.
    #[error("header has no key `{key}`, expected {expected}")]
    NoKey {
        /// The key.
        key: &'static str,
        /// What it should say.
        expected: &'static str,
    },
    /// Values that are none of the kind of voxel that the header states.
    #[error("has {components} values of type {found} a voxel, expected {expected} for `{VOXEL}:={kind}`")]
    Kind {
        /// Values of a voxel.
        components: usize,
        /// Their type.
        found: &'static str,
        /// What the kind needs.
        expected: &'static str,
        /// The kind.
        kind: &'static str,
    },
    /// Codes that no voxel has.
    #[error(
        "voxel ({}, {}, {}) is {codes:?}, expected an extinction of at most {MAX_CODE} and no colour above it",
        .voxel[0], .voxel[1], .voxel[2]
    )]
    Codes {
        /// x, y, z of the first such voxel.
        voxel: [usize; 3],
        /// What it has.
        codes: Codes,
    },
}

/// A volume, and what became of its voxels.
#[derive(Clone, Debug)]
pub struct Read {
    /// The volume.
    pub volume: RgbaVolume,
    /// Voxels held to the largest extinction.
    pub capped: usize,
    /// Voxels with an extinction too small for its root, which is 0.
    pub lost: usize,
}

impl Read {
    /// What the user should know, a sentence each.
    pub fn notes(&self) -> Vec<String> {
        let (all, tau_max) = (self.volume.voxels.len(), self.volume.tau_max);
        let mut notes = Vec::new();
        if self.capped > 0 {
            notes.push(format!(
                "{} of {all} voxels block more than tau_max = {tau_max:.6} can: they are held to it",
                self.capped
            ));
        }
        if self.lost > 0 {
            let least = tau_max / (4.0 * 255.0 * 255.0);
            notes.push(format!(
                "{} of {all} voxels block less than {least:.3e} a unit and become invisible; a smaller --tau-max keeps them",
                self.lost
            ));
        }
        notes
    }
}

/// The extinction of an opacity over a distance; infinite of an opacity of 1.
pub fn extinction_of(opacity: f64, distance: f64) -> f64 {
    -(-opacity).ln_1p() / distance
}

/// A volume of what a file holds: extinctions of its own, or colours and opacities.
///
/// # Errors
/// [`RgbaError`] if a meaning is missing, or a value has none.
pub fn of_colours(colours: &Colours, stated: &Stated) -> Result<Read, RgbaError> {
    match colours.key(VOXEL) {
        Some(kind) => own(colours, kind, stated),
        None => converted(colours, stated),
    }
}

/// A key's number in a range.
fn number(
    colours: &Colours,
    key: &'static str,
    range: RangeInclusive<f64>,
    expected: &'static str,
) -> Result<Option<f64>, RgbaError> {
    let Some(text) = colours.key(key) else { return Ok(None) };
    let number = text.trim().parse().ok().filter(|number| range.contains(number));
    number.map(Some).ok_or_else(|| RgbaError::Key {
        key,
        value: text.chars().take(40).collect(),
        expected,
    })
}

/// The distance that a header states.
fn stated_distance(colours: &Colours) -> Result<Option<f64>, RgbaError> {
    number(colours, ALPHA_DISTANCE, DISTANCES, "a number from 1e-9 to 1e9")
}

/// A volume that this library has written.
fn own(colours: &Colours, kind: &str, stated: &Stated) -> Result<Read, RgbaError> {
    if *stated != Stated::default() {
        return Err(RgbaError::OwnExtinction);
    }
    let tau_max = number(colours, TAU_MAX, TAUS, "a number from 1e-60 to 1e12")?.ok_or(RgbaError::NoKey {
        key: TAU_MAX,
        expected: "the largest extinction, per unit of the spacing",
    })?;
    let dims = colours.dims();
    let wrong = |expected, kind| RgbaError::Kind {
        components: colours.components(),
        found: colours.values().value_type().name(),
        expected,
        kind,
    };
    let voxels = match (kind, colours.values(), colours.components()) {
        (ENTRIES, Values::U8(values), 4) => Voxels::Entries(values.as_chunks::<4>().0.to_vec()),
        (ENTRIES, ..) => return Err(wrong("4 of uint8", ENTRIES)),
        (CODES, Values::U16(values), 4) => {
            let codes = values.as_chunks::<4>().0;
            let bad = |codes: &Codes| codes[3] > MAX_CODE || codes.iter().any(|code| *code > codes[3]);
            if let Some(index) = codes.iter().position(bad) {
                return Err(RgbaError::Codes {
                    voxel: place(index, dims),
                    codes: codes[index],
                });
            }
            Voxels::Codes(codes.to_vec())
        }
        (CODES, ..) => return Err(wrong("4 of uint16", CODES)),
        (other, ..) => {
            return Err(RgbaError::Key {
                key: VOXEL,
                value: other.chars().take(40).collect(),
                expected: "`root8` or `extinction15`",
            });
        }
    };
    Ok(Read {
        volume: RgbaVolume {
            name: colours.name().to_owned(),
            dims,
            spacing: colours.spacing(),
            orientation: colours.orientation().clone(),
            tau_max,
            alpha_distance: stated_distance(colours)?,
            voxels,
        },
        capped: 0,
        lost: 0,
    })
}

/// A volume of colours and opacities.
fn converted(colours: &Colours, stated: &Stated) -> Result<Read, RgbaError> {
    match (colours.components(), stated.opacity) {
        (3, None) => return Err(RgbaError::NoOpacity),
        (4, Some(_)) => return Err(RgbaError::OwnOpacity),
        _ => {}
    }
    let distance = stated
        .alpha_distance
        .map_or_else(|| stated_distance(colours), |stated| Ok(Some(stated)))?;
    let distance = distance.ok_or(RgbaError::NoDistance)?;
    let dims = colours.dims();
    let voxels = match colours.values() {
        Values::U8(values) => fractions(values, dims, colours.components(), stated.opacity, 255.0)?,
        Values::U16(values) => fractions(values, dims, colours.components(), stated.opacity, 65535.0)?,
        Values::F32(values) => fractions(values, dims, colours.components(), stated.opacity, 1.0)?,
        Values::F64(values) => fractions(values, dims, colours.components(), stated.opacity, 1.0)?,
        other => {
            return Err(RgbaError::Type {
                found: other.value_type().name(),
            });
        }
    };
    let mut read = of_extinctions(
        voxels
            .iter()
            .map(|(colour, opacity)| (*colour, extinction_of(f64::from(*opacity), distance))),
        stated.tau_max,
        distance,
    );
    read.volume.name = colours.name().to_owned();
    read.volume.dims = dims;
    read.volume.spacing = colours.spacing();
    read.volume.orientation = colours.orientation().clone();
    read.volume.alpha_distance = Some(distance);
    Ok(read)
}

/// Colours in 8 bits, and opacities, of values whose full scale is `one`.
fn fractions<T: Copy + Into<f64>>(
    values: &[T],
    dims: [usize; 3],
    components: usize,
    rule: Option<OpacityRule>,
    one: f64,
) -> Result<Vec<([u8; 3], f32)>, RgbaError> {
    let voxel = |(index, values): (usize, &[T])| {
        let mut fractions = [0.0; 4];
        for (fraction, value) in fractions.iter_mut().zip(values) {
            let value: f64 = (*value).into();
            // NaN is in no range.
            if !(0.0..=one).contains(&value) {
                return Err(RgbaError::Fraction {
                    voxel: place(index, dims),
                    value,
                });
            }
            *fraction = value / one;
        }
        let [red, green, blue, alpha] = fractions;
        let opacity = match rule {
            None => alpha,
            Some(OpacityRule::Luminance) => luminance(red, green, blue),
            Some(OpacityRule::Curve(curve)) => curve.at(luminance(red, green, blue)),
            Some(OpacityRule::Constant(opacity)) => opacity,
        };
        Ok(([red, green, blue].map(|c| (255.0 * c).round() as u8), opacity as f32))
    };
    values.chunks_exact(components).enumerate().map(voxel).collect()
}

/// The luminance of a colour as it is stored.
fn luminance(red: f64, green: f64, blue: f64) -> f64 {
    0.2126 * red + 0.7152 * green + 0.0722 * blue
}

/// The voxel of an index.
fn place(index: usize, dims: [usize; 3]) -> [usize; 3] {
    [index % dims[0], index / dims[0] % dims[1], index / dims[0] / dims[1]]
}

/// A scalar volume through a transfer function: `classified` has, for each of its 4096 codes, a colour and an opacity over
/// `distance`.
///
/// # Panics
/// If a voxel has a code beyond `classified`.
pub fn of_scalars(
    volume: &slicecast_volume::Volume,
    orientation: &Orientation,
    classified: &[([f64; 3], f64)],
    distance: f64,
    tau_max: Option<f64>,
) -> Read {
    let of_code = |(colour, opacity): &([f64; 3], f64)| {
        let colour = colour.map(|c| (255.0 * c.clamp(0.0, 1.0)).round() as u8);
        (colour, extinction_of(*opacity, distance))
    };
    let table: Vec<([u8; 3], f64)> = classified.iter().map(of_code).collect();
    let mut read = of_extinctions(
        volume.voxels.iter().map(|code| table[usize::from(*code)]),
        tau_max,
        distance,
    );
    read.volume.name = volume.name.clone();
    read.volume.dims = volume.dims;
    read.volume.spacing = volume.spacing;
    read.volume.orientation = orientation.clone();
    read.volume.alpha_distance = Some(distance);
    read
}

/// Entries of colours and extinctions, as a volume without a shape.
fn of_extinctions(voxels: impl Iterator<Item = ([u8; 3], f64)> + Clone, tau_max: Option<f64>, distance: f64) -> Read {
    let limit = tau_max.unwrap_or(OPAQUE / distance);
    let largest = voxels.clone().map(|(_, tau)| tau.min(limit)).fold(0.0, f64::max);
    // A volume of nothing has no largest extinction of its own.
    let tau_max = tau_max.unwrap_or(if largest > 0.0 { largest } else { limit });
    let (mut capped, mut lost) = (0, 0);
    let entry = |([red, green, blue], tau): ([u8; 3], f64)| {
        let root = root(tau / tau_max);
        capped += usize::from(tau > tau_max);
        lost += usize::from(tau > 0.0 && root == 0);
        [red, green, blue, root]
    };
    let entries: Vec<Entry> = voxels.map(entry).collect();
    Read {
        volume: RgbaVolume {
            name: String::new(),
            dims: [entries.len(), 1, 1],
            spacing: [1.0; 3],
            orientation: Orientation::Unknown,
            tau_max,
            alpha_distance: None,
            voxels: Voxels::Entries(entries),
        },
        capped,
        lost,
    }
}

#[cfg(test)]
mod tests;
