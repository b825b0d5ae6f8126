//! Linear maps from stored values to codes.

use super::{MAX_CODE, MappingError, Window};

/// What the choice of a mapping depends on, beside the range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    /// 8-bit integers from `first` up.
    Bytes { first: f64 },
    /// Wider integers, and floats that are whole.
    Integers,
    /// Other floats.
    Floats,
}

/// log2 of the integers per code, among those inside the window.
pub(super) fn bits_lost([low, high]: [f64; 2], coding: Coding) -> f64 {
    let integers = high.min(coding.high).floor() - low.max(coding.low).ceil() + 1.0;
    let codes = (integers * coding.codes_per_unit).ceil().min(MAX_CODE + 1.0);
    if integers > codes && codes > 0.0 {
        (integers / codes).log2()
    } else {
        0.0
    }
}

/// A linear map from stored values to codes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Coding {
    /// Stored value of code 0.
    pub low: f64,
    /// Stored value of code 4095.
    pub high: f64,
    /// Stored units per code.
    pub unit: f64,
    /// Codes per stored unit.
    pub codes_per_unit: f64,
}

impl Coding {
    /// The map for a window, the range of the stored values, the scale and offset of the data's unit, and whether that
    /// unit is known to be Hounsfield's.
    pub fn choose(
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
    pub fn lossless([min, max]: [f64; 2], kind: Kind) -> Option<Self> {
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
    pub fn linear_code(range: [f64; 2], kind: Kind, stored: f64) -> Option<u16> {
        let coding = Self::lossless(range, kind)?;
        Some(((stored - coding.low) * coding.codes_per_unit) as u16)
    }

    /// The code of a stored value inside the window.
    fn nearest(self, stored: f64) -> f64 {
        ((stored - self.low) * self.codes_per_unit + 0.5).floor().min(MAX_CODE)
    }

    /// The code of a stored value; `None` if it is outside the window.
    pub fn code(self, stored: f64) -> Option<u16> {
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

/// What becomes of values as they are coded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Tally {
    /// Voxels below the window.
    pub clipped_low: u64,
    /// Voxels above the window.
    pub clipped_high: u64,
    /// The greatest distance between a value inside the window and its code's.
    pub max_rounding_error: f64,
}

impl Tally {
    /// Both together.
    pub fn with(self, other: Self) -> Self {
        Self {
            clipped_low: self.clipped_low + other.clipped_low,
            clipped_high: self.clipped_high + other.clipped_high,
            max_rounding_error: self.max_rounding_error.max(other.max_rounding_error),
        }
    }

    /// The code of a value that `voxels` have.
    pub fn code(&mut self, coding: &Coding, value: f64, voxels: u64) -> u16 {
        if value < coding.low {
            self.clipped_low += voxels;
            return 0;
        }
        if value > coding.high {
            self.clipped_high += voxels;
            return MAX_CODE as u16;
        }
        let code = coding.nearest(value);
        let error = (value - (coding.low + code * coding.unit)).abs();
        self.max_rounding_error = self.max_rounding_error.max(error);
        code as u16
    }
}
