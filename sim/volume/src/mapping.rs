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

mod labels;
mod outliers;
mod report;

use thiserror::Error;

pub use self::labels::{Label, Labels};
pub use self::report::MappingReport;
use super::text::number;
use super::values::{Decoded, Modality, Values};
use super::{Mapping, Volume};

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

impl Window {
    /// A percentile or stated window as the range that it means for this volume.
    fn resolve(self, decoded: &Decoded) -> Result<Self, MappingError> {
        match self {
            Self::Auto | Self::Range { .. } => Ok(self),
            Self::Stated => Ok(match decoded.stated_window() {
                Some([low, high]) => Self::Range { low, high },
                None => Self::Auto,
            }),
            Self::Percentile { low, high } => {
                if !(0.0 <= low && low < high && high <= 100.0) {
                    return Err(MappingError::Percentile { low, high });
                }
                let data = |stored: f64| stored * decoded.value_scale() + decoded.value_offset();
                let last = decoded.values().len().saturating_sub(1);
                let ranks = [low, high].map(|percent| (percent / 100.0 * last as f64).round() as usize);
                let [first, last] = outliers::at_ranks(decoded.values(), ranks).map(data);
                // All voxels between the two have one value: nothing can be stretched.
                let range = Self::Range { low: first, high: last };
                Ok(if first < last { range } else { Self::Auto })
            }
        }
    }
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
    let window = window.resolve(decoded)?;
    let whole = decoded.values().are_whole();
    let kind = if whole { Kind::Integers } else { Kind::Floats };
    match decoded.values() {
        Values::I8(v) => map_values(decoded, v, window, Kind::Bytes { first: -128.0 }),
        Values::U8(v) => map_values(decoded, v, window, Kind::Bytes { first: 0.0 }),
        Values::I16(v) => map_values(decoded, v, window, kind),
        Values::U16(v) => map_values(decoded, v, window, kind),
        Values::I32(v) => map_values(decoded, v, window, kind),
        Values::U32(v) => map_values(decoded, v, window, kind),
        Values::F32(v) => map_values(decoded, v, window, kind),
        Values::F64(v) => map_values(decoded, v, window, kind),
    }
}

/// What the choice of a mapping depends on, beside the range.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// 8-bit integers from `first` up.
    Bytes { first: f64 },
    /// Wider integers, and floats that are whole.
    Integers,
    /// Other floats.
    Floats,
}

/// Maps stored values of one type.
fn map_values<T: Copy + Into<f64>>(
    decoded: &Decoded,
    stored: &[T],
    window: Window,
    kind: Kind,
) -> Result<Mapped, MappingError> {
    let range = range(stored);
    let (scale, shift) = (decoded.value_scale(), decoded.value_offset());
    let data = |stored: f64| stored * scale + shift;
    let detected = Labels::detect(decoded, kind != Kind::Floats, |label| {
        Coding::linear_code(range, kind, label)
    });
    if let Some(labels) = detected
        .as_ref()
        .filter(|labels| window == Window::Auto && labels.renumbered())
    {
        return Ok(renumber(decoded, stored, range.map(data), labels.clone()));
    }
    let hounsfield = decoded.modality() == Some(Modality::Ct) && scale == 1.0;
    // Where nothing is lost, and where the unit is known, every value counts.
    let is_fixed = kind != Kind::Floats && (hounsfield || Coding::lossless(range, kind).is_some());
    let inliers = if window == Window::Auto && !is_fixed {
        outliers::inliers(decoded.values(), range)
    } else {
        range
    };
    let coding = Coding::choose(window, inliers, [scale, shift], kind, hounsfield)?;
    let window_values = [data(coding.low), data(coding.high)];
    if window_values.iter().any(|value| value.abs() > MAX_VALUE) {
        let [low, high] = range.map(data);
        return Err(match window {
            Window::Range { low, high } => MappingError::Window { low, high },
            _ => MappingError::Range { low, high },
        });
    }
    let labels = match window {
        Window::Auto => detected.clone(),
        _ => detected
            .as_ref()
            .and_then(|labels| labels.recoded(|label| coding.code(label - shift))),
    };
    let note = (detected.is_some() && labels.is_none()).then(|| {
        let [low, high] = window_values;
        format!(
            "the values look like labels, and the window {low} to {high} does not give each label a code of its own: they \
             are read as measurements; without a window they are labels"
        )
    });
    let mapping = Mapping {
        scale: coding.unit * scale,
        offset: data(coding.low),
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
        let code = coding.nearest(value);
        max_rounding_error = max_rounding_error.max((value - (coding.low + code * coding.unit)).abs());
        code as u16
    };
    let voxels: Vec<u16> = stored.iter().map(code_of).collect();
    let clipped = clipped_low + clipped_high > 0;
    let report = MappingReport {
        range: range.map(data),
        window: window_values,
        codes_per_unit: coding.codes_per_unit / scale,
        clipped_low,
        clipped_high,
        outliers: clipped && inliers != range,
        labels: None,
        lossless: !clipped
            && if kind == Kind::Floats {
                max_rounding_error == 0.0
            } else {
                max_rounding_error < 0.5
            },
        bits_lost: (kind != Kind::Floats).then(|| bits_lost(range, coding)),
        max_rounding_error: max_rounding_error * scale,
    };
    let volume = volume(decoded, voxels, mapping);
    Ok(Mapped {
        volume,
        report,
        labels,
        note,
    })
}

/// Codes that count labels; `range` is that of the labels.
fn renumber<T: Copy + Into<f64>>(decoded: &Decoded, stored: &[T], range: [f64; 2], labels: Labels) -> Mapped {
    let shift = decoded.value_offset();
    // Equal voxels follow each other: each run is looked up once.
    let mut last = (f64::NAN, 0);
    let code_of = |&value: &T| {
        let value: f64 = value.into();
        if value != last.0 {
            last = (value, labels.code_of(value + shift).unwrap_or(0));
        }
        last.1
    };
    let voxels = stored.iter().map(code_of).collect();
    let count = labels.entries().len();
    let report = MappingReport {
        range,
        window: [0.0, MAX_CODE],
        codes_per_unit: 1.0,
        clipped_low: 0,
        clipped_high: 0,
        outliers: false,
        labels: Some(count),
        lossless: true,
        bits_lost: Some(0.0),
        max_rounding_error: 0.0,
    };
    let codes = Mapping {
        scale: 1.0,
        offset: 0.0,
    };
    Mapped {
        volume: volume(decoded, voxels, codes),
        report,
        labels: Some(labels),
        note: None,
    }
}

/// The volume with its codes.
fn volume(decoded: &Decoded, voxels: Vec<u16>, mapping: Mapping) -> Volume {
    Volume {
        name: decoded.name().to_owned(),
        dims: decoded.dims(),
        spacing: decoded.spacing(),
        voxels,
        mapping,
    }
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
    /// The map for a window, the range of the stored values, the scale and offset of the data's unit, and whether that
    /// unit is known to be Hounsfield's.
    fn choose(
        window: Window,
        [min, max]: [f64; 2],
        [scale, shift]: [f64; 2],
        kind: Kind,
        hounsfield: bool,
    ) -> Result<Self, MappingError> {
        if let Window::Range { low, high } = window {
            let error = MappingError::Window { low, high };
            if !(low.is_finite() && high.is_finite() && low < high) {
                return Err(error);
            }
            return Self::between((low - shift) / scale, (high - shift) / scale).ok_or(error);
        }
        if let Some(coding) = Self::lossless([min, max], kind) {
            return Ok(coding);
        }
        // Padding below air or metal above bone must not cost the unit: those are clipped instead.
        if hounsfield && kind == Kind::Integers {
            return Ok(Self::exact(-1024.0 - shift, 1.0));
        }
        let error = MappingError::Range {
            low: min * scale + shift,
            high: max * scale + shift,
        };
        Self::between(min, max).ok_or(error)
    }

    /// The map that loses nothing, where there is one without a look at each value.
    fn lossless([min, max]: [f64; 2], kind: Kind) -> Option<Self> {
        match kind {
            Kind::Bytes { first } => Some(Self::exact(first, 16.0)),
            Kind::Integers if min >= 0.0 && max <= MAX_CODE => Some(Self::exact(0.0, 1.0)),
            Kind::Integers if min >= -1024.0 && max <= 3071.0 => Some(Self::exact(-1024.0, 1.0)),
            Kind::Integers if max - min <= MAX_CODE => Some(Self::exact(min, 1.0)),
            // All values are the same: code 0.
            _ if min == max => Some(Self::exact(min, 1.0)),
            _ => None,
        }
    }

    /// The code of a stored integer, if the data have a map that loses nothing.
    fn linear_code(range: [f64; 2], kind: Kind, stored: f64) -> Option<u16> {
        let coding = Self::lossless(range, kind)?;
        Some(((stored - coding.low) * coding.codes_per_unit) as u16)
    }

    /// The code of a stored value inside the window.
    fn nearest(self, stored: f64) -> f64 {
        ((stored - self.low) * self.codes_per_unit + 0.5).floor().min(MAX_CODE)
    }

    /// The code of a stored value; `None` if it is outside the window.
    fn code(self, stored: f64) -> Option<u16> {
        (self.low..=self.high)
            .contains(&stored)
            .then(|| self.nearest(stored) as u16)
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
