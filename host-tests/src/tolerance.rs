//! The tolerance table: how far each stage may be from f64 on its own inputs, in units of the last place of its own
//! format, and why.
//!
//! An allowance is the bound that the stage's contract proves, where the test scenes come near it, or else the worst
//! that they were measured to do. A stage that exceeds its line fails, and so does a line of which a stage needs less than
//! [`STALE`]: bounds are to be tightened when the pipeline gets better.

use slicecast_sim::scene::PrecisionName;

use crate::measure::Quantity;

/// The share of its allowance that a stage must use.
pub const STALE: f64 = 0.6;

/// A line of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Allowance {
    /// What may err.
    pub quantity: Quantity,
    /// In what precision.
    pub precision: PrecisionName,
    /// Units of the last place of the stage's format.
    pub ulp: f64,
    /// Why as much as that.
    pub reason: &'static str,
}

/// The table.
pub const TABLE: [Allowance; 27] = [
    Allowance {
        quantity: Quantity::Location,
        precision: PrecisionName::Paper,
        ulp: 0.502,
        reason: "one rounding: a half; the step's own 32 bits add 2^-17 a plane, and there are up to 186 planes",
    },
    Allowance {
        quantity: Quantity::Location,
        precision: PrecisionName::Compact,
        ulp: 0.502,
        reason: "one rounding: a half; the step's own 32 bits add 2^-17 a plane, and there are up to 186 planes",
    },
    Allowance {
        quantity: Quantity::Location,
        precision: PrecisionName::Wide,
        ulp: 0.502,
        reason: "one rounding: a half; the step's own 32 bits add 2^-17 a plane, and there are up to 186 planes",
    },
    Allowance {
        quantity: Quantity::Interpolation,
        precision: PrecisionName::Paper,
        ulp: 5300.0,
        reason: "weights cut to 12 bits: 15/65536 of a step of up to 4095 along three axes; measured in noise",
    },
    Allowance {
        quantity: Quantity::Interpolation,
        precision: PrecisionName::Compact,
        ulp: 0.53125,
        reason: "0.5 of 12.12, and 1/32 for y in 16 fraction bits: proved",
    },
    Allowance {
        quantity: Quantity::Interpolation,
        precision: PrecisionName::Wide,
        ulp: 0.75,
        reason: "0.5 of 12.15, and 1/4 for y in 16 fraction bits: proved",
    },
    Allowance {
        quantity: Quantity::Opacity,
        precision: PrecisionName::Paper,
        ulp: 10500000.0,
        reason: "half an entry on the head's steepest slope, and half a code of the 8-bit root; measured",
    },
    Allowance {
        quantity: Quantity::Opacity,
        precision: PrecisionName::Compact,
        ulp: 33000.0,
        reason: "half a code of the 16-bit root is 2 sqrt(a) 2^-17, 32768 units at a = 1; the step's curve between two entries",
    },
    Allowance {
        quantity: Quantity::Opacity,
        precision: PrecisionName::Wide,
        ulp: 33000.0,
        reason: "half a code of the 16-bit root is 2 sqrt(a) 2^-17, 32768 units at a = 1; the step's curve between two entries",
    },
    Allowance {
        quantity: Quantity::Colour,
        precision: PrecisionName::Paper,
        ulp: 90.5,
        reason: "half a code of 8 bits, and half an entry of a colour that changes by 160 codes in 400 entries",
    },
    Allowance {
        quantity: Quantity::Colour,
        precision: PrecisionName::Compact,
        ulp: 64.8,
        reason: "half a code of 8 bits, 64.25 units, and half a unit: proved for colours linear between entries",
    },
    Allowance {
        quantity: Quantity::Colour,
        precision: PrecisionName::Wide,
        ulp: 64.8,
        reason: "half a code of 8 bits, 64.25 units, and half a unit: proved for colours linear between entries",
    },
    Allowance {
        quantity: Quantity::Gradient,
        precision: PrecisionName::Paper,
        ulp: 17300.0,
        reason: "as interpolation, twice, on differences that are twice as steep; measured in noise",
    },
    Allowance {
        quantity: Quantity::Gradient,
        precision: PrecisionName::Compact,
        ulp: 1.5625,
        reason: "two samples of 0.53 each, and 0.5 for a spacing factor: proved",
    },
    Allowance {
        quantity: Quantity::Gradient,
        precision: PrecisionName::Wide,
        ulp: 2.0,
        reason: "two samples of 0.75 each, and 0.5 for a spacing factor: proved",
    },
    Allowance {
        quantity: Quantity::Normal,
        precision: PrecisionName::Paper,
        ulp: 1.79,
        reason: "three halves across 16384, sqrt(3) of a unit; the reciprocal length's last bit adds 0.054: proved",
    },
    Allowance {
        quantity: Quantity::Normal,
        precision: PrecisionName::Compact,
        ulp: 1.79,
        reason: "three halves across 16384, sqrt(3) of a unit; the reciprocal length's last bit adds 0.054: proved",
    },
    Allowance {
        quantity: Quantity::Normal,
        precision: PrecisionName::Wide,
        ulp: 1.79,
        reason: "three halves across 16384, sqrt(3) of a unit; the reciprocal length's last bit adds 0.054: proved",
    },
    Allowance {
        quantity: Quantity::Shading,
        precision: PrecisionName::Paper,
        ulp: 860.0,
        reason: "a normal of 12 truncated bits under an exponent of 256 (the study: 6.7 8-bit steps of 128 at 64); measured",
    },
    Allowance {
        quantity: Quantity::Shading,
        precision: PrecisionName::Compact,
        ulp: 1.0,
        reason: "cosines to 1.16 and one rounding; the stage's contract",
    },
    Allowance {
        quantity: Quantity::Shading,
        precision: PrecisionName::Wide,
        ulp: 1.0,
        reason: "cosines to 1.16 and one rounding; the stage's contract",
    },
    Allowance {
        quantity: Quantity::Transparency,
        precision: PrecisionName::Paper,
        ulp: 1.5,
        reason: "opacity cut to 1.16 and its complement to 1.15 (-0.5 to 0.5), product truncated: proved",
    },
    Allowance {
        quantity: Quantity::Transparency,
        precision: PrecisionName::Compact,
        ulp: 1.25,
        reason: "dither: below 1; opacity in 1.16 adds a quarter: proved",
    },
    Allowance {
        quantity: Quantity::Transparency,
        precision: PrecisionName::Wide,
        ulp: 1.0,
        reason: "truncated once: proved",
    },
    Allowance {
        quantity: Quantity::PixelColour,
        precision: PrecisionName::Paper,
        ulp: 3.0,
        reason: "three truncations in a row: proved",
    },
    Allowance {
        quantity: Quantity::PixelColour,
        precision: PrecisionName::Compact,
        ulp: 1.0,
        reason: "dither: below 1 given the light taken: proved",
    },
    Allowance {
        quantity: Quantity::PixelColour,
        precision: PrecisionName::Wide,
        ulp: 2.0,
        reason: "truncated once given the light taken; where the floor hides it, truncated twice: proved",
    },
];
