//! The named precisions: which formats and roundings the stages use.
//!
//! A precision is a type with constants and nothing else; every stage is written once, over any precision. Firmware
//! names the one it uses and pays for that one.
//!
//! | | [`Paper`] | [`Compact`] | [`Wide`] |
//! |---|---|---|---|
//! | weight | 1.12, truncated | 0.16 | 0.16 |
//! | sample | 12.12, truncated at each lerp | 12.12, rounded once | 12.15, rounded once |
//! | normal | 1.12, truncated | 15-bit block, length divided out last | as `Compact` |
//! | shading | 16.16, truncated | 1.31 dots and powers, 16-bit coefficients | 1.31 |
//! | colour | 1.15 | 1.15 | 1.31 |
//! | pixel | 1.15 truncated, 64 bits | 16 bits, 65535 is 1, telescoping with plane dither, 64 bits | 1.31 telescoping, 128 bits |

use fixed::traits::Fixed;

use crate::composite::{Dithered, Recurrence, Telescoping31, Truncating15, Unorm16};
use crate::format::{Rounding, Sample12, Sample15};

/// The formats and roundings of a pipeline.
pub trait Precision: Copy + Default + Send + Sync + 'static {
    /// Sample format: 32 bits with at most 15 fraction bits (more would overflow the mixing of table entries).
    type Sample: Fixed<Bits = i32>;
    /// The pixel: its channel format and the arithmetic that folds a sample into it.
    type Pixel: Recurrence;
    /// The name that reports use.
    const NAME: &'static str;
    /// Bits of a 0.16 interpolation weight that are used; the rest are cut off.
    const WEIGHT_BITS: u32;
    /// Fraction bits kept after the y interpolation, at most 16.
    const LERP_BITS: u32;
    /// How interpolation loses its low bits.
    const LERP_ROUNDING: Rounding;
    /// How the normal reaches the dot product.
    const NORMAL: NormalForm;
    /// The arithmetic of shading.
    const SHADING: Shading;

    /// Whether pipelines of it fold blocks of columns. Without, they fold whole rows, which are the same bits: a study has
    /// many pipelines to compile, and times none of them by blocks.
    const BLOCKS: bool = true;
    /// Bits of a gradient's largest component that normalisation reads, 1 to 15; the others keep the same scale.
    const GRADIENT_BITS: u32 = 15;
    /// How a highlight's power is formed.
    const POWER: Power = Self::SHADING.power();
    /// Fraction bits of a colour: 15 or 31, as the pixel takes it.
    const COLOUR_BITS: u32 = <Self::Pixel as Recurrence>::COLOUR_BITS;
    /// Fraction bits of a sample.
    const SAMPLE_BITS: u32 = Self::Sample::FRAC_NBITS;
}

/// How a normal takes part in a dot product.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NormalForm {
    /// The block-normalised gradient goes into the product, the reciprocal length is multiplied in last.
    Deferred,
    /// The normal is formed first, each component truncated to this many fraction bits (at most 15).
    Formed(u32),
    /// The normal is formed first, each component to the nearest with this many fraction bits (1 to 15); its products
    /// are exact. For shading that keeps 15 bits of a vector.
    Nearest(u32),
}

/// How coefficients, dot products and powers of the lighting are multiplied and summed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shading {
    /// 16.16, every product truncated; vectors and coefficients 1.15.
    Truncated16,
    /// Dots and powers in 1.31, then rounded to 1.16; vectors and coefficients 1.15; products with them fit 32 bits.
    Rounded16,
    /// All in 1.31, vectors 1.30; products with coefficients truncated.
    Rounded31,
}

/// The power of a cosine that makes a highlight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Power {
    /// Squared again and again in 1.31, each time to nearest.
    Rounded31,
    /// Squared again and again in 1.16, truncated.
    Truncated16,
    /// An inverted parabola in the angle, `max(0, 1 - (1 - x)(2^n + 1) / 2)`: the same top and the same area, and a
    /// kink where it reaches 0. For comparison (Squeeze, section 4.2.2, after Knittel).
    Parabola,
}

impl Shading {
    /// The power that belongs to this arithmetic.
    pub const fn power(self) -> Power {
        match self {
            Self::Truncated16 => Power::Truncated16,
            Self::Rounded16 | Self::Rounded31 => Power::Rounded31,
        }
    }

    /// Fraction bits of the components of light and viewing vectors.
    pub const fn vector_bits(self) -> u32 {
        match self {
            Self::Truncated16 | Self::Rounded16 => 15,
            Self::Rounded31 => 30,
        }
    }

    /// Fraction bits of a lighting coefficient.
    pub const fn coefficient_bits(self) -> u32 {
        match self {
            Self::Truncated16 | Self::Rounded16 => 15,
            Self::Rounded31 => 31,
        }
    }
}

/// Squeeze to the letter: the baseline that the others are measured against.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Paper;

/// The same widths with every rounding placed for accuracy. The default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Compact;

/// Reference quality in 32-bit channels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wide;

impl Precision for Paper {
    type Sample = Sample12;
    type Pixel = Truncating15;
    const NAME: &'static str = "paper";
    const WEIGHT_BITS: u32 = 12;
    const LERP_BITS: u32 = 12;
    const LERP_ROUNDING: Rounding = Rounding::Truncate;
    const NORMAL: NormalForm = NormalForm::Formed(12);
    const SHADING: Shading = Shading::Truncated16;
}

impl Precision for Compact {
    type Sample = Sample12;
    type Pixel = Dithered<Unorm16>;
    const NAME: &'static str = "compact";
    const WEIGHT_BITS: u32 = 16;
    const LERP_BITS: u32 = 16;
    const LERP_ROUNDING: Rounding = Rounding::Nearest;
    const NORMAL: NormalForm = NormalForm::Deferred;
    const SHADING: Shading = Shading::Rounded16;
}

impl Precision for Wide {
    type Sample = Sample15;
    type Pixel = Telescoping31;
    const NAME: &'static str = "wide";
    const WEIGHT_BITS: u32 = 16;
    const LERP_BITS: u32 = 16;
    const LERP_ROUNDING: Rounding = Rounding::Nearest;
    const NORMAL: NormalForm = NormalForm::Deferred;
    const SHADING: Shading = Shading::Rounded31;
}
