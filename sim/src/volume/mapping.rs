//! From a file's own values to 12-bit codes, and a report of what that cost.
//!
//! A value `v` (stored value plus the file's value offset) becomes `code = floor((v - low) * codes_per_unit + 1/2)`,
//! that is, rounded half up, held to 0 … 4095. Everything is computed in f64 and does not depend on the machine.
//!
//! [`Window::Auto`] chooses, by the *stored* values:
//!
//! | data                     | code 0 is | codes per unit | lost    |
//! |--------------------------|-----------|----------------|---------|
//! | 8-bit unsigned, signed   | 0, -128   | 16             | nothing |
//! | integers in 0 … 4095     | 0         | 1              | nothing |
//! | integers in -1024 … 3071 | -1024     | 1              | nothing |
//! | integers, range <= 4095  | minimum   | 1              | nothing |
//! | other integers, floats   | minimum   | 4095 / range   | reported |
//!
//! [`Window::Range`] maps `low` to 0 and `high` to 4095 and clips what lies outside.

mod report;

use thiserror::Error;

pub use self::report::MappingReport;
use super::values::{Decoded, Values};
use super::{Mapping, Volume};

/// The largest code.
const MAX_CODE: f64 = 4095.0;

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
}

/// Why values cannot be mapped.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum MappingError {
    /// A window that has no width, the wrong direction, or ends that are not finite.
    #[error("window is {low} to {high}, expected two finite numbers, the lower one first")]
    Window {
        /// Data value of code 0 as asked.
        low: f64,
        /// Data value of code 4095 as asked.
        high: f64,
    },
    /// A range so wide or so narrow that f64 cannot divide it into codes.
    #[error("values from {low} to {high} cannot be divided into 4096 codes, expected a range of 1e-290 to 1e300")]
    Range {
        /// Least value.
        low: f64,
        /// Greatest value.
        high: f64,
    },
}

/// Maps a volume's values to 12 bits.
///
/// # Errors
/// [`MappingError`] if the window asked for is not one, or floating-point data span a range that f64 cannot divide.
pub fn map(decoded: &Decoded, window: Window) -> Result<(Volume, MappingReport), MappingError> {
    match decoded.values() {
        Values::I8(v) => map_values(decoded, v, window, Kind::Bytes { first: -128.0 }),
        Values::U8(v) => map_values(decoded, v, window, Kind::Bytes { first: 0.0 }),
        Values::I16(v) => map_values(decoded, v, window, Kind::Integers),
        Values::U16(v) => map_values(decoded, v, window, Kind::Integers),
        Values::I32(v) => map_values(decoded, v, window, Kind::Integers),
        Values::U32(v) => map_values(decoded, v, window, Kind::Integers),
        Values::F32(v) => map_values(decoded, v, window, Kind::Floats),
        Values::F64(v) => map_values(decoded, v, window, Kind::Floats),
    }
}

/// What the choice of a mapping depends on, beside the range.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// 8-bit integers from `first` up.
    Bytes { first: f64 },
    /// Wider integers.
    Integers,
    /// Floating point.
    Floats,
}

/// Maps stored values of one type.
fn map_values<T: Copy + Into<f64>>(
    decoded: &Decoded,
    stored: &[T],
    window: Window,
    kind: Kind,
) -> Result<(Volume, MappingReport), MappingError> {
    let range = range(stored);
    let shift = decoded.value_offset();
    let coding = Coding::choose(window, range, shift, kind)?;
    let mapping = Mapping {
        scale: coding.unit,
        offset: coding.low + shift,
    };
    let mut clipped_low = 0;
    let mut clipped_high = 0;
    let mut max_rounding_error = 0.0_f64;
    let code_of = |&value: &T| {
        let value: f64 = value.into();
        if value < coding.low {
            clipped_low += 1;
            return 0;
        }
        if value > coding.high {
            clipped_high += 1;
            return MAX_CODE as u16;
        }
        let code = ((value - coding.low) * coding.codes_per_unit + 0.5)
            .floor()
            .min(MAX_CODE);
        max_rounding_error = max_rounding_error.max((value - (coding.low + code * coding.unit)).abs());
        code as u16
    };
    let voxels: Vec<u16> = stored.iter().map(code_of).collect();
    let clipped = clipped_low + clipped_high > 0;
    let report = MappingReport {
        range: range.map(|v| v + shift),
        window: [coding.low + shift, coding.high + shift],
        codes_per_unit: coding.codes_per_unit,
        clipped_low,
        clipped_high,
        lossless: !clipped
            && if kind == Kind::Floats {
                max_rounding_error == 0.0
            } else {
                max_rounding_error < 0.5
            },
        bits_lost: (kind != Kind::Floats).then(|| bits_lost(range, coding)),
        max_rounding_error,
    };
    let volume = Volume {
        name: decoded.name().to_owned(),
        dims: decoded.dims(),
        spacing: decoded.spacing(),
        voxels,
        mapping,
    };
    Ok((volume, report))
}

/// Least and greatest value; 0, 0 of none.
fn range<T: Copy + Into<f64>>(stored: &[T]) -> [f64; 2] {
    let first = stored.first().map_or(0.0, |&v| v.into());
    stored.iter().fold([first; 2], |[low, high], &v| {
        let v: f64 = v.into();
        [low.min(v), high.max(v)]
    })
}

/// log2 of the integers per code, among those inside the window.
fn bits_lost([low, high]: [f64; 2], coding: Coding) -> f64 {
    let integers = high.min(coding.high).floor() - low.max(coding.low).ceil() + 1.0;
    let codes = (integers * coding.codes_per_unit).ceil().min(MAX_CODE + 1.0);
    if integers > codes && codes > 0.0 {
        (integers / codes).log2()
    } else {
        0.0
    }
}

/// A linear map from stored values to codes.
#[derive(Clone, Copy, Debug)]
struct Coding {
    /// Stored value of code 0.
    low: f64,
    /// Stored value of code 4095.
    high: f64,
    /// Stored units per code.
    unit: f64,
    /// Codes per stored unit.
    codes_per_unit: f64,
}

impl Coding {
    /// The map for a window, the range of the stored values and the offset of the data's unit.
    fn choose(window: Window, [min, max]: [f64; 2], shift: f64, kind: Kind) -> Result<Self, MappingError> {
        match (window, kind) {
            (Window::Range { low, high }, _) => {
                let error = MappingError::Window { low, high };
                if !(low.is_finite() && high.is_finite() && low < high) {
                    return Err(error);
                }
                Self::between(low - shift, high - shift).ok_or(error)
            }
            (Window::Auto, Kind::Bytes { first }) => Ok(Self::exact(first, 16.0)),
            (Window::Auto, Kind::Integers) if min >= 0.0 && max <= MAX_CODE => Ok(Self::exact(0.0, 1.0)),
            (Window::Auto, Kind::Integers) if min >= -1024.0 && max <= 3071.0 => Ok(Self::exact(-1024.0, 1.0)),
            (Window::Auto, Kind::Integers) if max - min <= MAX_CODE => Ok(Self::exact(min, 1.0)),
            // All values are the same: code 0.
            (Window::Auto, _) if min == max => Ok(Self::exact(min, 1.0)),
            (Window::Auto, _) => {
                let error = MappingError::Range {
                    low: min + shift,
                    high: max + shift,
                };
                Self::between(min, max).ok_or(error)
            }
        }
    }

    /// A power of two of codes per unit, from `low` up.
    fn exact(low: f64, codes_per_unit: f64) -> Self {
        let unit = 1.0 / codes_per_unit;
        Self {
            low,
            high: low + MAX_CODE * unit,
            unit,
            codes_per_unit,
        }
    }

    /// The codes spread from `low` to `high`; `None` if their difference is too great or too small.
    fn between(low: f64, high: f64) -> Option<Self> {
        let range = high - low;
        let (unit, codes_per_unit) = (range / MAX_CODE, MAX_CODE / range);
        let usable = (1e-290..=1e300).contains(&range);
        usable.then_some(Self {
            low,
            high,
            unit,
            codes_per_unit,
        })
    }
}

#[cfg(test)]
mod tests;
