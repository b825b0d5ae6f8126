//! A volume of colours as its file states it, three or four values a voxel; or of shares of materials, one to eight.

use std::collections::HashMap;

use super::axes::Directions;
use super::decoded::Orientation;
use super::error::{Problem, ShapeError};
use super::values::{Values, check_spacing, voxel_count};

/// A volume of colours. Shape and spacing are checked; what the values mean, and whether they are in range, is not.
#[derive(Clone, Debug, PartialEq)]
pub struct Colours {
    name: String,
    dims: [usize; 3],
    spacing: [f64; 3],
    components: usize,
    values: Values,
    orientation: Orientation,
    keys: HashMap<String, String>,
    notes: Vec<String>,
}

impl Colours {
    /// Checks and joins the parts: `values` are those of a voxel side by side, `components` of them: 3 or 4, of shares 1 to 8.
    ///
    /// # Errors
    /// [`ShapeError`] if a side or the whole is empty or too large, a spacing is no length, or values are missing.
    pub fn new(
        name: String,
        dims: [usize; 3],
        spacing: [f64; 3],
        components: usize,
        values: Values,
    ) -> Result<Self, ShapeError> {
        let expected = voxel_count(dims.map(|d| d as u64))? * components as u64;
        check_spacing(spacing)?;
        if values.len() as u64 != expected {
            return Err(ShapeError::Values {
                expected,
                found: values.len() as u64,
            });
        }
        Ok(Self {
            name,
            dims,
            spacing,
            components,
            values,
            orientation: Orientation::Unknown,
            keys: HashMap::new(),
            notes: Vec::new(),
        })
    }

    /// Adds what the file says beside: keys of its header, and notes for the user.
    #[must_use]
    pub(super) fn with(mut self, keys: HashMap<String, String>, notes: Vec<String>) -> Self {
        self.keys = keys;
        self.notes.extend(notes);
        self
    }

    /// Brings the voxels into the order of the patient's axes (LPS), or of a space's.
    ///
    /// # Errors
    /// [`Problem::Axes`] if the directions are no axes; [`Problem::Memory`] if a second copy does not fit.
    pub(super) fn along(mut self, directions: Directions) -> Result<Self, Problem> {
        let turn = directions.turn()?;
        self.notes.extend(turn.notes(directions.space()));
        self.values = turn.values(self.values, self.components, self.dims)?;
        self.dims = turn.permuted(self.dims);
        self.spacing = turn.permuted(self.spacing);
        self.orientation = Orientation::of(directions, &turn);
        Ok(self)
    }

    /// Where it came from, for messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Voxels along x, y and z.
    pub const fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// Distance between voxels along x, y and z, in the file's unit.
    pub const fn spacing(&self) -> [f64; 3] {
        self.spacing
    }

    /// Values of a voxel: 3 or 4, of shares 1 to 8.
    pub const fn components(&self) -> usize {
        self.components
    }

    /// The values, those of a voxel side by side, x fastest; floats may be anything.
    pub const fn values(&self) -> &Values {
        &self.values
    }

    /// How the volume lies in the patient.
    pub const fn orientation(&self) -> &Orientation {
        &self.orientation
    }

    /// The value of a key of the file's header.
    pub fn key(&self, name: &str) -> Option<&str> {
        self.keys.get(name).map(String::as_str)
    }

    /// What the user should know about how the file was read, a sentence each.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }
}
