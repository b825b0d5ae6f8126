//! From a file's own values to 12-bit codes, and a report of what that cost.
//!
//! A value `v` (stored value plus the file's value offset) becomes `code = floor((v - low) * codes_per_unit + 1/2)`,
//! that is, rounded half up, held to 0 … 4095. Everything is computed in f64 and does not depend on the machine.
//!
//! [`Window::Auto`] chooses, by the *stored* values; floats that are all whole count as integers:
//!
//! | data                     | code 0 is | codes per unit | lost    |
//! |--------------------------|-----------|----------------|---------|
//! | 8-bit unsigned, signed   | 0, -128   | 16             | nothing |
//! | integers in 0 … 4095     | 0         | 1              | nothing |
//! | integers in -1024 … 3071 | -1024     | 1              | nothing |
//! | integers, range <= 4095  | minimum   | 1              | nothing |
//! | labels above 4095 ([`Labels`]) | the first label | codes count labels | nothing |
//! | CT in Hounsfield units, integers, range > 4095 | -1024 HU | 1 | what is below -1024 or above 3071 HU |
//! | other integers, floats   | minimum   | 4095 / range   | reported |
//!
//! The range of the last line is that of the data without outliers: at most 0.01 % of the voxels at each end (or one
//! voxel) that lie beyond all others by more than twice the others' range. They are clipped and counted.
//!
//! [`Window::Range`] maps `low` to 0 and `high` to 4095 and clips what lies outside; [`Window::Percentile`] and
//! [`Window::Stated`] are ranges that come from the data and from the file. Where the file scales its values
//! (`value = stored * scale + offset`), the codes are chosen on the stored values and reported in the data's unit.

pub(crate) mod census;
pub(crate) mod choice;
mod coding;
pub(crate) mod in_memory;
pub mod labels;
mod outliers;
mod report;

use thiserror::Error;

use self::choice::{Code, choose};
pub(crate) use self::coding::Tally;
use self::in_memory::InMemory;
pub use self::labels::{Label, Labels};
pub use self::report::MappingReport;
use super::Volume;
use super::decoded::Decoded;
use super::text::number;
use super::values::Values;

/// The largest code.
const MAX_CODE: f64 = 4095.0;

/// The greatest magnitude of the value of a code: scenes cannot speak of values beyond.
const MAX_VALUE: f64 = 1e12;

/// Which data values the codes 0 to 4095 stand for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Window {
    /// Without loss where the data allow it, otherwise the data's whole range.
    Auto,
    /// From `low` (code 0) to `high` (code 4095), in the data's unit; values outside are clipped.
    Range {
        /// Data value of code 0.
        low: f64,
        /// Data value of code 4095.
        high: f64,
    },
    /// From the value below which `low` percent of the voxels lie to the one below which `high` percent lie.
    Percentile {
        /// Percent, 0 to 100.
        low: f64,
        /// Percent, 0 to 100.
        high: f64,
    },
    /// As the file asks for; [`Window::Auto`] if it does not.
    Stated,
}

/// Why values cannot be mapped.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum MappingError {
    /// A window that has no width, the wrong direction, or ends that are not finite.
    #[error(
        "window is {} to {}, expected two numbers from -{MAX_VALUE:e} to {MAX_VALUE:e}, the lower one first",
        number(*low), number(*high)
    )]
    Window {
        /// Data value of code 0 as asked.
        low: f64,
        /// Data value of code 4095 as asked.
        high: f64,
    },
    /// Percentiles that are none.
    #[error("percentiles are {low} and {high}, expected two numbers from 0 to 100, the lower one first")]
    Percentile {
        /// The lower one as asked.
        low: f64,
        /// The higher one as asked.
        high: f64,
    },
    /// A range too narrow to be divided into codes, or values beyond those that scenes can speak of.
    #[error(
        "values from {} to {} cannot be divided into 4096 codes, expected a range of at least 1e-290 within \
         -{MAX_VALUE:e} to {MAX_VALUE:e}",
        number(*low), number(*high)
    )]
    Range {
        /// Least value.
        low: f64,
        /// Greatest value.
        high: f64,
    },
}

/// A volume in codes, and what is known about them.
#[derive(Clone, Debug)]
pub struct Mapped {
    /// The volume.
    pub volume: Volume,
    /// What the mapping did.
    pub report: MappingReport,
    /// The labels, if the volume is a label map and its codes tell them apart.
    pub labels: Option<Labels>,
    /// What the user has to know of it beside the report, a sentence.
    pub note: Option<String>,
}

/// Maps a volume's values to 12 bits.
///
/// # Errors
/// [`MappingError`] if the window asked for is not one, or the data span a range that cannot be divided.
pub fn map(decoded: &Decoded, window: Window) -> Result<Mapped, MappingError> {
    let values = decoded.values();
    let census = InMemory {
        values,
        width: decoded.dims()[0],
    };
    let chosen = choose(&decoded.meaning(), &census, window)?;
    let mut tally = Tally::default();
    let voxels = match values {
        Values::I8(v) => codes(&chosen.code, v, &mut tally),
        Values::U8(v) => codes(&chosen.code, v, &mut tally),
        Values::I16(v) => codes(&chosen.code, v, &mut tally),
        Values::U16(v) => codes(&chosen.code, v, &mut tally),
        Values::I32(v) => codes(&chosen.code, v, &mut tally),
        Values::U32(v) => codes(&chosen.code, v, &mut tally),
        Values::F32(v) => codes(&chosen.code, v, &mut tally),
        Values::F64(v) => codes(&chosen.code, v, &mut tally),
    };
    let volume = Volume {
        name: decoded.name().to_owned(),
        dims: decoded.dims(),
        spacing: decoded.spacing(),
        voxels,
        mapping: chosen.mapping,
    };
    Ok(Mapped {
        volume,
        report: chosen.report(&tally),
        labels: chosen.labels,
        note: chosen.note,
    })
}

/// The codes of stored values of one type.
pub(crate) fn codes<T: Copy + Into<f64>>(code: &Code, stored: &[T], tally: &mut Tally) -> Vec<u16> {
    match code {
        Code::Linear(coding) => {
            // A tally of its own stays in registers.
            let mut own = *tally;
            let codes = stored.iter().map(|&value| own.code(coding, value.into(), 1)).collect();
            *tally = own;
            codes
        }
        Code::Labels(labels, offset) => {
            // Equal voxels follow each other: each run is looked up once.
            let mut last = (f64::NAN, 0);
            let code_of = |&value: &T| {
                let value: f64 = value.into();
                if value != last.0 {
                    last = (value, labels.code_of(value + offset).unwrap_or(0));
                }
                last.1
            };
            stored.iter().map(code_of).collect()
        }
    }
}

#[cfg(test)]
mod tests;
