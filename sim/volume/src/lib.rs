//! A volume in memory, as the machine sees it: 12-bit voxels with their shape, spacing and unit.
//!
//! [`open`] finds the reader for a file or folder ([`nrrd`], [`nifti`], [`metaimage`], [`dicom`], [`tiff`], [`raw`], `zarr`), which
//! yields the values as the file states them ([`values`]), in the patient's axes where the file tells them ([`axes`]);
//! [`mapping`] turns those into codes and says what that cost. A further format is one more file beside `nrrd.rs` and a
//! line in `open.rs`.

pub mod axes;
pub mod choice;
mod chunked;
pub mod colours;
mod companion;
pub mod decoded;
pub mod dicom;
pub mod error;
mod file;
mod files;
mod gzip;
mod length;
pub mod limits;
pub mod mapping;
pub mod meaning;
pub mod metaimage;
pub mod nifti;
pub mod nrrd;
pub mod on_disk;
pub mod open;
mod payload;
mod placed;
pub mod raw;
pub mod statistics;
mod text;
pub mod tiff;
pub mod values;
mod zarr;

/// How 12-bit codes map back to the data's own unit: `value = code * scale + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mapping {
    /// Data units per code.
    pub scale: f64,
    /// The data value of code 0.
    pub offset: f64,
}

impl Mapping {
    /// The data value of a code (or of a sample between codes).
    pub fn value(&self, code: f64) -> f64 {
        code * self.scale + self.offset
    }

    /// The code, with fraction, of a data value. It may lie outside 0 to 4095.
    pub fn code(&self, value: f64) -> f64 {
        (value - self.offset) / self.scale
    }
}

/// A volume of 12-bit voxels.
#[derive(Clone, Debug)]
pub struct Volume {
    /// Where it came from, for messages.
    pub name: String,
    /// Voxels along x, y and z.
    pub dims: [usize; 3],
    /// Distance between voxels along x, y and z, in the file's unit (millimetres for medical data).
    pub spacing: [f64; 3],
    /// Voxels, x fastest, each 0 to 4095; none of a volume that is read in parts ([`on_disk`]).
    pub voxels: Vec<u16>,
    /// From codes back to the data's unit.
    pub mapping: Mapping,
}
