//! The choice of a mapping.

use super::census::Census;
use super::coding::{Coding, Kind, Tally, bits_lost};
use super::labels::Labels;
use super::outliers;
use super::report::MappingReport;
use super::{MAX_CODE, MAX_VALUE, MappingError, Window};
use crate::Mapping;
use crate::meaning::Meaning;
use crate::meaning::Modality;
use crate::values::ValueType;

/// How stored values become codes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Code {
    /// By a line.
    Linear(Coding),
    /// Codes count labels; the offset leads from stored values to them.
    Labels(Labels, f64),
}

/// A mapping that has been chosen, and what is known of it before a value is coded.
#[derive(Clone, Debug)]
pub(crate) struct Chosen {
    pub code: Code,
    /// From codes to the data's unit.
    pub mapping: Mapping,
    /// The labels, if the volume is a label map and its codes tell them apart.
    pub labels: Option<Labels>,
    /// What the user has to know of it beside the report, a sentence.
    pub note: Option<String>,
    meaning: Meaning,
    kind: Kind,
    /// Least and greatest stored value.
    range: [f64; 2],
    /// Whether some of them are outliers.
    has_outliers: bool,
}

impl Window {
    /// A percentile or stated window as the range that it means for this volume.
    fn resolve(self, meaning: &Meaning, census: &dyn Census) -> Result<Self, MappingError> {
        match self {
            Self::Auto | Self::Range { .. } => Ok(self),
            Self::Stated => Ok(match meaning.stated_window {
                Some([low, high]) => Self::Range { low, high },
                None => Self::Auto,
            }),
            Self::Percentile { low, high } => {
                if !(0.0 <= low && low < high && high <= 100.0) {
                    return Err(MappingError::Percentile { low, high });
                }
                let last = census.count().saturating_sub(1);
                let ranks = [low, high].map(|percent| (percent / 100.0 * last as f64).round() as u64);
                let [first, last] = census.at_ranks(ranks).map(|stored| meaning.data(stored));
                // All voxels between the two have one value: nothing can be stretched.
                let range = Self::Range { low: first, high: last };
                Ok(if first < last { range } else { Self::Auto })
            }
        }
    }
}

/// Chooses how the values of a volume become codes.
///
/// # Errors
/// [`MappingError`] if the window asked for is not one, or the data span a range that cannot be divided.
pub(crate) fn choose(meaning: &Meaning, census: &dyn Census, window: Window) -> Result<Chosen, MappingError> {
    let window = window.resolve(meaning, census)?;
    let kind = match meaning.value_type {
        ValueType::I8 => Kind::Bytes { first: -128.0 },
        ValueType::U8 => Kind::Bytes { first: 0.0 },
        _ if census.is_whole() => Kind::Integers,
        _ => Kind::Floats,
    };
    let range = census.range();
    let detected = Labels::detect(meaning, census, kind != Kind::Floats, |label| {
        Coding::linear_code(range, kind, label)
    });
    let chosen = |code, mapping, labels, note, has_outliers| Chosen {
        code,
        mapping,
        labels,
        note,
        meaning: *meaning,
        kind,
        range,
        has_outliers,
    };
    if let Some(labels) = detected
        .as_ref()
        .filter(|labels| window == Window::Auto && labels.renumbered())
    {
        let codes = Mapping {
            scale: 1.0,
            offset: 0.0,
        };
        let code = Code::Labels(labels.clone(), meaning.offset);
        return Ok(chosen(code, codes, Some(labels.clone()), None, false));
    }
    let hounsfield = meaning.modality == Some(Modality::Ct) && meaning.scale == 1.0;
    // Where nothing is lost, and where the unit is known, every value counts.
    let is_fixed = kind != Kind::Floats && (hounsfield || Coding::lossless(range, kind).is_some());
    let inliers = if window == Window::Auto && !is_fixed {
        outliers::inliers(census, range)
    } else {
        range
    };
    let coding = Coding::choose(window, inliers, [meaning.scale, meaning.offset], kind, hounsfield)?;
    let window_values = [coding.low, coding.high].map(|stored| meaning.data(stored));
    if window_values.iter().any(|value| value.abs() > MAX_VALUE) {
        let [low, high] = range.map(|stored| meaning.data(stored));
        return Err(match window {
            Window::Range { low, high } => MappingError::Window { low, high },
            _ => MappingError::Range { low, high },
        });
    }
    let labels = match window {
        Window::Auto => detected.clone(),
        _ => detected
            .as_ref()
            .and_then(|labels| labels.recoded(|label| coding.code(label - meaning.offset))),
    };
    let note = (detected.is_some() && labels.is_none()).then(|| {
        let [low, high] = window_values;
        format!(
            "the values look like labels, and the window {low} to {high} does not give each label a code of its own: they \
             are read as measurements; without a window they are labels"
        )
    });
    let mapping = Mapping {
        scale: coding.unit * meaning.scale,
        offset: meaning.data(coding.low),
    };
    Ok(chosen(Code::Linear(coding), mapping, labels, note, inliers != range))
}

impl Chosen {
    /// What the mapping did to values that were tallied.
    pub fn report(&self, tally: &Tally) -> MappingReport {
        let meaning = &self.meaning;
        let range = self.range.map(|stored| meaning.data(stored));
        let coding = match &self.code {
            Code::Linear(coding) => coding,
            Code::Labels(labels, _) => {
                return MappingReport {
                    range,
                    window: [0.0, MAX_CODE],
                    codes_per_unit: 1.0,
                    clipped_low: 0,
                    clipped_high: 0,
                    outliers: false,
                    labels: Some(labels.entries().len()),
                    lossless: true,
                    bits_lost: Some(0.0),
                    max_rounding_error: 0.0,
                };
            }
        };
        let is_clipped = tally.clipped_low + tally.clipped_high > 0;
        let has_floats = self.kind == Kind::Floats;
        let is_exact = if has_floats {
            tally.max_rounding_error == 0.0
        } else {
            tally.max_rounding_error < 0.5
        };
        MappingReport {
            range,
            window: [coding.low, coding.high].map(|stored| meaning.data(stored)),
            codes_per_unit: coding.codes_per_unit / meaning.scale,
            clipped_low: tally.clipped_low,
            clipped_high: tally.clipped_high,
            outliers: is_clipped && self.has_outliers,
            labels: None,
            lossless: !is_clipped && is_exact,
            bits_lost: (!has_floats).then(|| bits_lost(self.range, *coding)),
            max_rounding_error: tally.max_rounding_error * meaning.scale,
        }
    }

    /// Whether the values are whole numbers, whatever their type.
    pub fn has_integers(&self) -> bool {
        self.kind != Kind::Floats
    }
}
