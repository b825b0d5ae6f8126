//! The tolerance table: how far each stage may be from f64 on its own inputs, in units of the last place of its own
//! format (`slicecast_compare::stages`: opacity counts in 2^-16, colour in 2^-8), and why.
//!
//! An allowance is the bound that the stage's contract proves, where the test scenes come near it, or else the worst
//! that they were measured to do. A stage that exceeds its line fails, and so does a line of which a stage needs less than
//! [`STALE`]: bounds are to be tightened when the pipeline gets better.

use slicecast_compare::stages::Stage;
use slicecast_scene::PrecisionName;

/// The share of its allowance that a stage must use.
pub const STALE: f64 = 0.6;

/// A line of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Allowance {
    /// Whose output.
    pub stage: Stage,
    /// In what precision.
    pub precision: PrecisionName,
    /// Units of the last place of the stage's format.
    pub ulp: f64,
    /// Why as much as that.
    pub reason: &'static str,
}

/// The lines of samples by splines.
pub const SPLINES: [Allowance; 6] = [
    Allowance {
        stage: Stage::Interpolation,
        precision: PrecisionName::Paper,
        ulp: 7500.0,
        reason: "weights of 12 bits, cut, and of positions of 12 bits, on three axes of steps of up to 4095; measured in noise",
    },
    Allowance {
        stage: Stage::Interpolation,
        precision: PrecisionName::Compact,
        ulp: 230.0,
        reason: "both weights of an axis are within half of 2^-16, of differences of up to 4095: at most 768 on three axes; measured in noise",
    },
    Allowance {
        stage: Stage::Interpolation,
        precision: PrecisionName::Wide,
        ulp: 1850.0,
        reason: "as compact, in ulp of 12.15: at most 6144; measured in noise",
    },
    Allowance {
        stage: Stage::Gradient,
        precision: PrecisionName::Paper,
        ulp: 22600.0,
        reason: "as interpolation, on differences that are twice as steep; measured in noise",
    },
    Allowance {
        stage: Stage::Gradient,
        precision: PrecisionName::Compact,
        ulp: 630.0,
        reason: "weights of the other two axes within half of 2^-16, of slopes of up to 8190: at most 2048, and 0.5 for a spacing factor; measured in noise",
    },
    Allowance {
        stage: Stage::Gradient,
        precision: PrecisionName::Wide,
        ulp: 5000.0,
        reason: "as compact, in ulp of 12.15; measured in noise",
    },
];

/// The table.
pub const TABLE: [Allowance; 35] = [
    Allowance {
        stage: Stage::Location,
        precision: PrecisionName::Paper,
        ulp: 0.502,
        reason: "one rounding: a half; the step's own 32 bits add 2^-17 a plane, and there are up to 186 planes",
    },
    Allowance {
        stage: Stage::Location,
        precision: PrecisionName::Compact,
        ulp: 0.502,
        reason: "one rounding: a half; the step's own 32 bits add 2^-17 a plane, and there are up to 186 planes",
    },
    Allowance {
        stage: Stage::Location,
        precision: PrecisionName::Wide,
        ulp: 0.502,
        reason: "one rounding: a half; the step's own 32 bits add 2^-17 a plane, and there are up to 186 planes",
    },
    Allowance {
        stage: Stage::Interpolation,
        precision: PrecisionName::Paper,
        ulp: 5300.0,
        reason: "weights cut to 12 bits: 15/65536 of a step of up to 4095 along three axes; measured in noise",
    },
    Allowance {
        stage: Stage::Interpolation,
        precision: PrecisionName::Compact,
        ulp: 0.53125,
        reason: "0.5 of 12.12, and 1/32 for y in 16 fraction bits: proved",
    },
    Allowance {
        stage: Stage::Interpolation,
        precision: PrecisionName::Wide,
        ulp: 0.75,
        reason: "0.5 of 12.15, and 1/4 for y in 16 fraction bits: proved",
    },
    Allowance {
        stage: Stage::Opacity,
        precision: PrecisionName::Paper,
        ulp: 520.0,
        reason: "half an entry on the head's steepest slope; a code of the 8-bit root is up to 514 units wide; measured",
    },
    Allowance {
        stage: Stage::Opacity,
        precision: PrecisionName::Compact,
        ulp: 1.75,
        reason: "a code of the 16-bit root is 2 sqrt(a) units wide: half of one, and what the last entry hands on; measured",
    },
    Allowance {
        stage: Stage::Opacity,
        precision: PrecisionName::Wide,
        ulp: 1.75,
        reason: "a code of the 16-bit root is 2 sqrt(a) units wide: half of one, and what the last entry hands on; measured",
    },
    Allowance {
        stage: Stage::Colour,
        precision: PrecisionName::Paper,
        ulp: 0.71,
        reason: "half a code, and half an entry of a colour that changes by 160 codes in 400 entries",
    },
    Allowance {
        stage: Stage::Colour,
        precision: PrecisionName::Compact,
        ulp: 0.0098,
        reason: "half a code of 16 bits, 2^-9 units of 2^-8; half a unit of 1.15 for an entry and for the mixture, 2^-8 each: proved",
    },
    Allowance {
        stage: Stage::Colour,
        precision: PrecisionName::Wide,
        ulp: 0.00196,
        reason: "half a code of 16 bits, 2^-9 units of 2^-8, as colours have 31 bits: proved",
    },
    Allowance {
        stage: Stage::Gradient,
        precision: PrecisionName::Paper,
        ulp: 17300.0,
        reason: "as interpolation, twice, on differences that are twice as steep; measured in noise",
    },
    Allowance {
        stage: Stage::Gradient,
        precision: PrecisionName::Compact,
        ulp: 1.5625,
        reason: "two samples of 0.53 each, and 0.5 for a spacing factor: proved",
    },
    Allowance {
        stage: Stage::Gradient,
        precision: PrecisionName::Wide,
        ulp: 2.0,
        reason: "two samples of 0.75 each, and 0.5 for a spacing factor: proved",
    },
    Allowance {
        stage: Stage::Normal,
        precision: PrecisionName::Paper,
        ulp: 1.23,
        reason: "truncated to 1.12: below 1, and 1.79 / 8 from the 15 bits before: proved",
    },
    Allowance {
        stage: Stage::Normal,
        precision: PrecisionName::Compact,
        ulp: 1.79,
        reason: "three halves across 16384, sqrt(3) of a unit; the reciprocal length's last bit adds 0.054: proved",
    },
    Allowance {
        stage: Stage::Normal,
        precision: PrecisionName::Wide,
        ulp: 1.79,
        reason: "three halves across 16384, sqrt(3) of a unit; the reciprocal length's last bit adds 0.054: proved",
    },
    Allowance {
        stage: Stage::Shading,
        precision: PrecisionName::Paper,
        ulp: 100.0,
        reason: "truncated cosines lose 3 units of 1.16, and an exponent of 256 makes that 256 times as much; measured",
    },
    Allowance {
        stage: Stage::Shading,
        precision: PrecisionName::Compact,
        ulp: 1.0,
        reason: "cosines to 1.16 and one rounding; the stage's contract",
    },
    Allowance {
        stage: Stage::Shading,
        precision: PrecisionName::Wide,
        ulp: 40.0,
        reason: "half of a cosine's last bit and 8 roundings of the power, doubled by each squaring, times 0.4; measured",
    },
    Allowance {
        stage: Stage::Transparency,
        precision: PrecisionName::Paper,
        ulp: 1.5,
        reason: "opacity cut to 1.16 and its complement to 1.15 (-0.5 to 0.5), product truncated: proved",
    },
    Allowance {
        stage: Stage::Transparency,
        precision: PrecisionName::Compact,
        ulp: 1.0,
        reason: "dither: below 1: proved",
    },
    Allowance {
        stage: Stage::Transparency,
        precision: PrecisionName::Wide,
        ulp: 1.0,
        reason: "truncated once: proved",
    },
    Allowance {
        stage: Stage::Compositing,
        precision: PrecisionName::Paper,
        ulp: 3.0,
        reason: "three truncations in a row: proved",
    },
    Allowance {
        stage: Stage::Compositing,
        precision: PrecisionName::Compact,
        ulp: 1.0,
        reason: "dither: below 1 given the light taken: proved",
    },
    Allowance {
        stage: Stage::Compositing,
        precision: PrecisionName::Wide,
        ulp: 2.0,
        reason: "truncated once given the light taken; where the floor hides it, truncated twice: proved",
    },
    Allowance {
        stage: Stage::Location,
        precision: PrecisionName::Fast,
        ulp: 0.502,
        reason: "one rounding: a half; the step's own 32 bits add 2^-17 a plane, and there are up to 186 planes",
    },
    Allowance {
        stage: Stage::Interpolation,
        precision: PrecisionName::Fast,
        ulp: 1.8,
        reason: "a half of 12.3 for each of three steps; weights of 15 bits lack up to 2^-16 of differences of up to 32760, a half each: at most 3; \
                 measured in noise",
    },
    Allowance {
        stage: Stage::Opacity,
        precision: PrecisionName::Fast,
        ulp: 92.5,
        reason: "the root is straight between two codes: (q1 - q0)^2 / 4, at the foot of the head's skull, where 0.003 a code over a step of 1.876: 92.2",
    },
    Allowance {
        stage: Stage::Colour,
        precision: PrecisionName::Fast,
        ulp: 0.0059,
        reason: "half a code of 16 bits and below one for the look-up, of 65535: 1.5 of them are 0.00586 units of 2^-8: proved",
    },
    Allowance {
        stage: Stage::Gradient,
        precision: PrecisionName::Fast,
        ulp: 4.8,
        reason: "at a face twice what the halves are off, (6 + 4) / 2 of two differences and 1 that they lose, and 1 for a spacing factor: at most 13; \
                 measured",
    },
    Allowance {
        stage: Stage::Shading,
        precision: PrecisionName::Fast,
        ulp: 98.0,
        reason: "8 + 19 ks 2^n of 65535, of a highlight of 0.4 whose exponent is 256: at most 1954; measured",
    },
    Allowance {
        stage: Stage::Transparency,
        precision: PrecisionName::Fast,
        ulp: 1.5,
        reason: "dither: below 1, and half a unit of the product with the root: proved",
    },
    Allowance {
        stage: Stage::Compositing,
        precision: PrecisionName::Fast,
        ulp: 1.75,
        reason: "dither: below 1; 65536 for 65535, w / 65536 of the light taken, at most 0.73 of a step: proved",
    },
];

/// The lines of classified segments, which differ from those of samples: opacity and colour of the segments between samples
/// against f64 of the same bins; what bins leave out of a transfer function is the error of the table, not of the arithmetic.
pub const SEGMENTS: [Allowance; 4] = [
    Allowance {
        stage: Stage::Opacity,
        precision: PrecisionName::Compact,
        ulp: 0.14,
        reason: "nodes rounded to half a unit, their difference to one: measured in ripples and noise",
    },
    Allowance {
        stage: Stage::Opacity,
        precision: PrecisionName::Wide,
        ulp: 0.12,
        reason: "nodes rounded to half a unit, their difference to one: measured in ripples and noise",
    },
    Allowance {
        stage: Stage::Colour,
        precision: PrecisionName::Compact,
        ulp: 177.0,
        reason: "a segment whose integral is a few units of its nodes has any colour; weighted by its opacity it is within 81 of 2^-31 (core)",
    },
    Allowance {
        stage: Stage::Colour,
        precision: PrecisionName::Wide,
        ulp: 177.0,
        reason: "a segment whose integral is a few units of its nodes has any colour; weighted by its opacity it is within 81 of 2^-31 (core)",
    },
];

/// The lines of samples that differ where borders are exact: other samples, and opacities of fractions.
pub const CELLS: [Allowance; 1] = [Allowance {
    stage: Stage::Opacity,
    precision: PrecisionName::Paper,
    ulp: 550.0,
    reason: "as with whole borders, of samples that lie elsewhere; measured",
}];

/// The same, of segments.
pub const CELLS_SEGMENTS: [Allowance; 2] = [
    Allowance {
        stage: Stage::Opacity,
        precision: PrecisionName::Compact,
        ulp: 0.66,
        reason: "what is left of a segment to half of 2^-16 segment, which an opacity of 1 takes as half a unit: measured",
    },
    Allowance {
        stage: Stage::Opacity,
        precision: PrecisionName::Wide,
        ulp: 0.66,
        reason: "what is left of a segment to half of 2^-16 segment, which an opacity of 1 takes as half a unit: measured",
    },
];
