//! What a configuration is made of, in words and numbers: the columns of a sweep, and the stages of `--vary`.

use serde::{Deserialize, Serialize};
use slicecast::format::Rounding;
use slicecast::precision::{Formats, NormalForm, Power, Shading};
use slicecast_scene::LookupName;

/// A parameter: its name and the value that a configuration has. Values are compared as text.
pub type Parameter = (Name, String);

/// The name of a parameter, STAGE.WIDTH on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Name {
    /// Fraction bits of a ray's step, summed up; 32 are rounded once per plane.
    #[serde(rename = "position.bits")]
    PositionBits,
    /// Bits of an interpolation weight.
    #[serde(rename = "weight.bits")]
    WeightBits,
    /// Fraction bits of a sample.
    #[serde(rename = "sample.bits")]
    SampleBits,
    /// Rounding of the interpolation.
    #[serde(rename = "sample.rounding")]
    SampleRounding,
    /// Bits of the gradient that normalisation reads.
    #[serde(rename = "gradient.bits")]
    GradientBits,
    /// Fraction bits of a normal that is formed; 0 where none is.
    #[serde(rename = "normal.bits")]
    NormalBits,
    /// How the normal takes part.
    #[serde(rename = "normal.form")]
    NormalForm,
    /// Arithmetic of the shading.
    #[serde(rename = "shading.form")]
    ShadingForm,
    /// Power of the highlight.
    #[serde(rename = "power.form")]
    PowerForm,
    /// Opacity code of the table.
    #[serde(rename = "table.code")]
    TableCode,
    /// Look-up in the table.
    #[serde(rename = "table.lookup")]
    TableLookup,
    /// Bits of the pixel's channels.
    #[serde(rename = "compositing.bits")]
    CompositingBits,
    /// Rounding of the compositing.
    #[serde(rename = "compositing.rounding")]
    CompositingRounding,
}

impl Name {
    /// All of them, in the order of the pipeline.
    pub const ALL: [Self; 13] = [
        Self::PositionBits,
        Self::WeightBits,
        Self::SampleBits,
        Self::SampleRounding,
        Self::GradientBits,
        Self::NormalBits,
        Self::NormalForm,
        Self::ShadingForm,
        Self::PowerForm,
        Self::TableCode,
        Self::TableLookup,
        Self::CompositingBits,
        Self::CompositingRounding,
    ];

    /// The name on the command line and in tables.
    pub const fn text(self) -> &'static str {
        match self {
            Self::PositionBits => "position.bits",
            Self::WeightBits => "weight.bits",
            Self::SampleBits => "sample.bits",
            Self::SampleRounding => "sample.rounding",
            Self::GradientBits => "gradient.bits",
            Self::NormalBits => "normal.bits",
            Self::NormalForm => "normal.form",
            Self::ShadingForm => "shading.form",
            Self::PowerForm => "power.form",
            Self::TableCode => "table.code",
            Self::TableLookup => "table.lookup",
            Self::CompositingBits => "compositing.bits",
            Self::CompositingRounding => "compositing.rounding",
        }
    }

    /// The stage that it belongs to.
    pub fn stage(self) -> &'static str {
        self.text().split('.').next().unwrap_or("")
    }

    /// The parameter with this name.
    pub fn from_text(text: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|name| name.text() == text)
    }
}

/// The parameters of a configuration: its formats, bits and rounding of its pixel, code and look-up of its table.
pub fn of(formats: Formats, pixel: (u32, &str), code: &str, lookup: LookupName) -> Vec<Parameter> {
    let (form, normal_bits) = match formats.normal {
        NormalForm::Deferred => ("deferred", 0),
        NormalForm::Formed(bits) => ("truncated", bits),
        NormalForm::Nearest(bits) => ("nearest", bits),
    };
    let (pixel_bits, pixel_rounding) = pixel;
    let value = |name| match name {
        Name::PositionBits => "32".to_owned(),
        Name::WeightBits => formats.weight_bits.to_string(),
        Name::SampleBits => formats.sample_bits.to_string(),
        Name::SampleRounding => match formats.lerp_rounding {
            Rounding::Truncate => "truncated",
            Rounding::Nearest => "rounded",
        }
        .into(),
        Name::GradientBits => formats.gradient_bits.to_string(),
        Name::NormalBits => normal_bits.to_string(),
        Name::NormalForm => form.into(),
        Name::ShadingForm => match formats.shading {
            Shading::Truncated16 => "truncated16",
            Shading::Rounded16 => "rounded16",
            Shading::Rounded31 => "rounded31",
        }
        .into(),
        Name::PowerForm => match formats.power {
            Power::Rounded31 => "rounded",
            Power::Truncated16 => "truncated",
            Power::Parabola => "parabola",
        }
        .into(),
        Name::TableCode => code.to_owned(),
        Name::TableLookup => match lookup {
            LookupName::Linear => "linear",
            LookupName::Nearest => "nearest",
        }
        .into(),
        Name::CompositingBits => pixel_bits.to_string(),
        Name::CompositingRounding => pixel_rounding.to_owned(),
    };
    Name::ALL.into_iter().map(|name| (name, value(name))).collect()
}
