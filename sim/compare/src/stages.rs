//! The stages that are compared, their formats and what Squeeze asks of them.

use serde::Serialize;
use slicecast::composite::{Channel, Recurrence};
use slicecast::precision::{NormalForm, Precision};

use super::statistics::{Errors, Figures};

/// A stage boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub enum Stage {
    /// Sample position.
    Location,
    /// Sample value.
    Interpolation,
    /// Opacity of a step.
    Opacity,
    /// Classified colour.
    Colour,
    /// Gradient with spacing factors.
    Gradient,
    /// Unit normal.
    Normal,
    /// Shaded colour.
    Shading,
    /// Transparency left.
    Transparency,
    /// Colour gathered.
    Compositing,
}

impl Stage {
    /// All of them, in the order of the pipeline.
    pub const ALL: [Self; 9] = [
        Self::Location,
        Self::Interpolation,
        Self::Opacity,
        Self::Colour,
        Self::Gradient,
        Self::Normal,
        Self::Shading,
        Self::Transparency,
        Self::Compositing,
    ];

    /// The name that reports use.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Location => "location",
            Self::Interpolation => "interpolation",
            Self::Opacity => "classification: opacity",
            Self::Colour => "classification: colour",
            Self::Gradient => "gradient",
            Self::Normal => "gradient: normal",
            Self::Shading => "shading",
            Self::Transparency => "compositing: transparency",
            Self::Compositing => "compositing: colour",
        }
    }

    /// The name that heads a narrow column.
    pub const fn head(self) -> &'static str {
        match self {
            Self::Location => "place",
            Self::Interpolation => "sample",
            Self::Opacity => "opacity",
            Self::Colour => "colour",
            Self::Gradient => "gradient",
            Self::Normal => "normal",
            Self::Shading => "shading",
            Self::Transparency => "T",
            Self::Compositing => "C",
        }
    }

    /// The format of the stage's output, as error figures count it: its name, and how many ulp are 1.0.
    pub fn format<P: Precision>(self, p: P) -> (String, f64) {
        let fixed = |integer: u32, fraction: u32| (format!("{integer}.{fraction}"), f64::from(fraction).exp2());
        match self {
            Self::Location => fixed(16, 16),
            Self::Interpolation | Self::Gradient => fixed(12, p.formats().sample_bits),
            Self::Opacity => fixed(0, 16),
            Self::Colour => fixed(0, 8),
            Self::Normal => match p.formats().normal {
                NormalForm::Deferred => fixed(1, 15),
                NormalForm::Formed(bits) | NormalForm::Nearest(bits) => fixed(1, bits),
            },
            // In 16-bit lanes as pixels are.
            Self::Shading if P::STAGED => fixed(1, p.pixel().colour_bits()),
            Self::Shading => (p.pixel().format().to_owned(), f64::from(p.pixel().one().bits())),
            Self::Transparency | Self::Compositing => {
                (p.pixel().format().to_owned(), f64::from(p.pixel().one().bits()))
            }
        }
    }

    /// How many ulp of the stage's output are 1.0.
    pub fn per_unit<P: Precision>(self, p: P) -> f64 {
        self.format(p).1
    }

    /// Fraction bits that Squeeze requires of a stage's output (its section 5; table entries: section 4.4). Of the
    /// gradient it requires the normal; the vector before it is internal.
    pub const fn required(self) -> Option<u32> {
        match self {
            Self::Location | Self::Interpolation | Self::Normal => Some(12),
            Self::Gradient => None,
            Self::Colour => Some(8),
            Self::Opacity | Self::Shading | Self::Transparency | Self::Compositing => Some(15),
        }
    }
}

/// Local and carried errors of every stage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StageErrors {
    /// Against f64 on the stage's own inputs.
    pub local: [Errors; Stage::ALL.len()],
    /// Against the f64 model from the beginning.
    pub carried: [Errors; Stage::ALL.len()],
}

impl StageErrors {
    /// Adds what another tile has gathered.
    pub fn merge(&mut self, other: &Self) {
        for (a, b) in self.local.iter_mut().zip(&other.local) {
            a.merge(b);
        }
        for (a, b) in self.carried.iter_mut().zip(&other.carried) {
            a.merge(b);
        }
    }

    /// The figures of all stages that the scene has.
    pub fn report<P: Precision>(&self, p: P) -> Vec<StageReport> {
        let mut reports = Vec::new();
        for stage in Stage::ALL {
            let (format, per_unit) = stage.format(p);
            let local = self.local[stage as usize].figures(per_unit);
            if local.samples == 0 {
                continue;
            }
            reports.push(StageReport {
                name: stage.name(),
                format,
                required_bits: stage.required(),
                meets_required: stage
                    .required()
                    .map(|required| local.bits.is_none_or(|b| b >= f64::from(required) - 1e-9)),
                local,
                carried: self.carried[stage as usize].figures(per_unit),
            });
        }
        reports
    }
}

/// One line of the stage table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StageReport {
    /// The stage.
    pub name: &'static str,
    /// Its output format, integer.fraction bits.
    pub format: String,
    /// Fraction bits that Squeeze requires of it.
    pub required_bits: Option<u32>,
    /// Whether every local error is at most 2^-required.
    pub meets_required: Option<bool>,
    /// Against f64 on the stage's own (already rounded) inputs.
    pub local: Figures,
    /// Against the f64 model from the beginning.
    pub carried: Figures,
}
