//! A volume as its file states it, checked once.

use std::fmt;

use super::axes::{Directions, Turn};
use super::choice::NanRule;
use super::error::{Problem, ShapeError};
use super::meaning::Meaning;
use super::meaning::Modality;
use super::values::{Values, check_spacing, voxel_count};

/// What is known about how the volume lies in the patient.
#[derive(Clone, Debug, PartialEq)]
pub enum Orientation {
    /// The file does not say: the axes are the file's own, and left and right may be exchanged.
    Unknown,
    /// The file states a space that is not a patient's; the volume's axes run along it.
    Space,
    /// The volume's axes run to the patient's left, back and head.
    Patient {
        /// Where the file's own axes ran to, such as `RAS`.
        file_axes: String,
        /// The largest angle between an axis and its patient axis, degrees.
        tilt: f64,
    },
}

impl Orientation {
    /// That of a volume whose axes a turn has brought to where they run.
    pub(super) fn of(directions: Directions, turn: &Turn) -> Self {
        match directions {
            Directions::Space(_) => Self::Space,
            Directions::Patient(_) => Self::Patient {
                file_axes: turn.letters(),
                tilt: turn.tilt,
            },
        }
    }
}

impl fmt::Display for Orientation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown => write!(f, "not stated; the file's own axes, left and right may be exchanged"),
            Self::Space => write!(f, "along the file's space, which is not a patient's"),
            Self::Patient { file_axes, tilt } if *tilt < 0.05 => write!(f, "LPS (in the file: {file_axes})"),
            Self::Patient { file_axes, tilt } => {
                write!(f, "LPS (in the file: {file_axes}, {tilt:.1} degrees oblique)")
            }
        }
    }
}

/// A volume as its file states it. Its fields are checked by [`Decoded::new`], so they are read-only.
#[derive(Clone, Debug, PartialEq)]
pub struct Decoded {
    name: String,
    dims: [usize; 3],
    spacing: [f64; 3],
    values: Values,
    value_scale: f64,
    value_offset: f64,
    orientation: Orientation,
    modality: Option<Modality>,
    stated_window: Option<[f64; 2]>,
    notes: Vec<String>,
}

impl Decoded {
    /// Checks and joins the parts of a volume.
    ///
    /// `dims` are voxels along x, y, z; `spacing` is the distance between voxels; `values` are x fastest.
    ///
    /// # Errors
    /// [`ShapeError`] if a side or the whole is empty or too large, a spacing is no length, the values
    /// are not one per voxel, or one of them is not finite.
    pub fn new(name: String, dims: [usize; 3], spacing: [f64; 3], values: Values) -> Result<Self, ShapeError> {
        let voxels = voxel_count(dims.map(|d| d as u64))?;
        check_spacing(spacing)?;
        if values.len() as u64 != voxels {
            return Err(ShapeError::Values {
                expected: voxels,
                found: values.len() as u64,
            });
        }
        if let Some((index, value)) = values.first_not_finite() {
            let voxel = [index % dims[0], index / dims[0] % dims[1], index / dims[0] / dims[1]];
            return Err(ShapeError::NotFinite { voxel, value });
        }
        Ok(Self {
            name,
            dims,
            spacing,
            values,
            value_scale: 1.0,
            value_offset: 0.0,
            orientation: Orientation::Unknown,
            modality: None,
            stated_window: None,
            notes: Vec::new(),
        })
    }

    /// As [`Decoded::new`], with NaN treated by `rule`; `scale` is the factor from stored values to the data's unit.
    ///
    /// # Errors
    /// As [`Decoded::new`]; [`ShapeError::AllNan`] if nothing is left to be background.
    pub(super) fn with_nan(
        name: String,
        dims: [usize; 3],
        spacing: [f64; 3],
        mut values: Values,
        (rule, scale): (NanRule, f64),
    ) -> Result<Self, ShapeError> {
        let filled = match rule {
            NanRule::Refuse => 0,
            NanRule::Background => values.fill_nan(scale < 0.0).ok_or(ShapeError::AllNan)?,
        };
        let mut decoded = Self::new(name, dims, spacing, values)?;
        if filled > 0 {
            let all = decoded.values.len();
            decoded.notes.push(format!(
                "{filled} of {all} voxels are NaN: they are background, with the least value of the volume"
            ));
        }
        Ok(decoded)
    }

    /// States that the data's unit is the stored value plus `offset` (for CT: Hounsfield units).
    ///
    /// `offset` comes from a file as an integer; every value plus it is exact in f64.
    #[must_use]
    pub fn with_value_offset(mut self, offset: i32) -> Self {
        self.value_offset = f64::from(offset);
        self
    }

    /// States that the data's unit is the stored value times `scale` plus `offset`.
    ///
    /// A negative scale changes the stored values' type, so that a greater stored value always means a greater value.
    ///
    /// # Errors
    /// [`Problem::Format`] if the scale is 0 or one of the two is not finite or too great to be computed with.
    pub(super) fn with_rescale(mut self, format: &'static str, scale: f64, offset: f64) -> Result<Self, Problem> {
        check_rescale(format, scale, offset)?;
        if scale < 0.0 {
            self.values = self.values.rescaled(scale, offset)?;
            if let Some((_, value)) = self.values.first_not_finite() {
                return Err(Problem::format(
                    format,
                    format!("a value becomes {value} when it is rescaled, expected finite numbers"),
                ));
            }
        } else {
            self.value_scale = scale;
            self.value_offset = offset;
        }
        Ok(self)
    }

    /// Adds something that the user should know about how the file was read.
    #[must_use]
    pub fn with_notes(mut self, notes: Vec<String>) -> Self {
        self.notes.extend(notes);
        self
    }

    /// States what made the values.
    #[must_use]
    pub fn with_modality(mut self, modality: Option<Modality>) -> Self {
        self.modality = modality;
        self
    }

    /// States the window that the file asks for, in the data's unit; one that is none is left out.
    #[must_use]
    pub fn with_stated_window(mut self, window: Option<[f64; 2]>) -> Self {
        self.stated_window = window.filter(|[low, high]| low.is_finite() && high.is_finite() && low < high);
        self
    }

    /// Brings the voxels into the order of the patient's axes (LPS), or of a space's.
    ///
    /// # Errors
    /// [`Problem::Axes`] if the directions are no axes; [`Problem::Memory`] if a second copy does not fit.
    pub(super) fn along(mut self, directions: Directions) -> Result<Self, Problem> {
        let turn = directions.turn()?;
        self.notes.extend(turn.notes(directions.space()));
        self.values = turn.values(self.values, 1, self.dims)?;
        self.dims = turn.permuted(self.dims);
        self.spacing = turn.permuted(self.spacing);
        self.orientation = Orientation::of(directions, &turn);
        Ok(self)
    }

    /// Where it came from, for messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Voxels along x, y and z, each 1 to [`MAX_AXIS`](super::limits::MAX_AXIS).
    pub const fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// Distance between voxels along x, y and z, in the file's unit; finite and above 0.
    pub const fn spacing(&self) -> [f64; 3] {
        self.spacing
    }

    /// The stored values, x fastest, all finite.
    pub const fn values(&self) -> &Values {
        &self.values
    }

    /// What to multiply a stored value by to get the data's unit; above 0.
    pub const fn value_scale(&self) -> f64 {
        self.value_scale
    }

    /// What to add to a stored value, once scaled, to get the data's unit.
    pub const fn value_offset(&self) -> f64 {
        self.value_offset
    }

    /// What the stored values mean.
    pub(super) const fn meaning(&self) -> Meaning {
        Meaning {
            value_type: self.values.value_type(),
            scale: self.value_scale,
            offset: self.value_offset,
            modality: self.modality,
            stated_window: self.stated_window,
        }
    }

    /// How the volume lies in the patient.
    pub const fn orientation(&self) -> &Orientation {
        &self.orientation
    }

    /// What made the values, if the file says so.
    pub const fn modality(&self) -> Option<Modality> {
        self.modality
    }

    /// The window that the file asks for, in the data's unit.
    pub const fn stated_window(&self) -> Option<[f64; 2]> {
        self.stated_window
    }

    /// What the user should know about how the file was read, a sentence each.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }
}

/// Refuses scales and offsets that are not usable.
pub(super) fn check_rescale(format: &'static str, scale: f64, offset: f64) -> Result<(), Problem> {
    let usable = (1e-30..=1e30).contains(&scale.abs()) && offset.abs() <= 1e30;
    if usable {
        return Ok(());
    }
    Err(Problem::format(
        format,
        format!("values are scaled by {scale} plus {offset}, expected finite numbers up to 1e30, and no scale of 0"),
    ))
}
