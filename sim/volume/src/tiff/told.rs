//! What is said about a stack: planes, distances, calibration.

use super::planes::Planes;
use crate::length::millimetres;

/// A distance and the length of its unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Length {
    /// In the unit stated.
    pub number: f64,
    /// Millimetres of that unit; `None` of a unit that is none, such as a pixel.
    pub unit: Option<f64>,
}

impl Length {
    /// A number and the name of its unit.
    pub fn new(number: f64, unit: Option<&str>) -> Self {
        let unit = unit.and_then(millimetres);
        Self { number, unit }
    }
}

/// What is said about a stack.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Description {
    /// Channels, slices, time points, if they are told apart.
    pub planes: Option<Planes>,
    /// Distances along x, y and z.
    pub spacing: [Option<Length>; 3],
    /// The data's unit is the stored value times the first plus the second.
    pub calibration: Option<[f64; 2]>,
    /// What the user should know.
    pub notes: Vec<String>,
}

impl Description {
    /// The spacing in millimetres, or in the ratio stated, and what had to be assumed.
    pub fn spacing(&self) -> ([f64; 3], Vec<String>) {
        let mut notes = Vec::new();
        let lengths = match self.spacing {
            [None, None, None] => {
                return ([1.0; 3], vec!["the file states no spacing: 1 is assumed".into()]);
            }
            [None, None, Some(z)] => {
                notes.push("the file states no distance between pixels: that of slices is assumed".into());
                [z; 3]
            }
            [x, y, z] => {
                let pixel = x.or(y).unwrap_or(Length {
                    number: 1.0,
                    unit: None,
                });
                if z.is_none() {
                    notes.push("the file states no distance between slices: that of pixels is assumed".into());
                }
                [x.unwrap_or(pixel), y.unwrap_or(pixel), z.unwrap_or(pixel)]
            }
        };
        if let [Some(x), Some(y), Some(z)] = lengths.map(|length| length.unit) {
            let unit = [x, y, z];
            return ([0, 1, 2].map(|axis| lengths[axis].number * unit[axis]), notes);
        }
        let spacing = lengths.map(|length| length.number);
        if spacing == [1.0; 3] && self.spacing[2].is_none() {
            return (spacing, vec!["the file states no spacing: 1 is assumed".into()]);
        }
        let [x, y, z] = spacing;
        notes.push(format!(
            "the file states no unit of length that is known: only the ratio {x} : {y} : {z} is"
        ));
        (spacing, notes)
    }
}
