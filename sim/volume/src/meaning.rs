//! What stored values mean.

use super::values::ValueType;

/// The machine that made the values, as far as the file says so.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Modality {
    /// Computed tomography: values are Hounsfield units.
    Ct,
    /// Magnetic resonance: values in no unit.
    Mr,
    /// Something else.
    Other,
}

impl Modality {
    /// The modality of a DICOM code or the like; `None` of an empty text.
    pub fn from_code(code: &str) -> Option<Self> {
        match code.trim().to_ascii_uppercase().as_str() {
            "" => None,
            "CT" => Some(Self::Ct),
            "MR" | "MRI" => Some(Self::Mr),
            _ => Some(Self::Other),
        }
    }
}

/// What stored values mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Meaning {
    /// Their number type.
    pub value_type: ValueType,
    /// What to multiply a stored value by to get the data's unit; above 0.
    pub scale: f64,
    /// What to add then.
    pub offset: f64,
    /// What made them.
    pub modality: Option<Modality>,
    /// The window that the file asks for, in the data's unit.
    pub stated_window: Option<[f64; 2]>,
}

impl Meaning {
    /// A stored value in the data's unit.
    pub fn data(&self, stored: f64) -> f64 {
        stored * self.scale + self.offset
    }

    /// Whether the values are stored as integers.
    pub const fn has_integers(&self) -> bool {
        !matches!(self.value_type, ValueType::F32 | ValueType::F64)
    }
}
