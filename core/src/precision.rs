//! The named precisions: which formats and roundings the stages use.
//!
//! Every stage is written once, over any precision; shapes (the pixel's arithmetic) are types, and widths are numbers. A
//! named precision is a value without size, whose numbers are constants of the compiled pipeline: firmware names the one it
//! uses and pays for that one.
//!
//! | | [`Paper`] | [`Compact`] | [`Wide`] |
//! |---|---|---|---|
//! | weight | 1.12, truncated | 0.16 | 0.16 |
//! | sample | 12.12, truncated at each lerp | 12.12, rounded once | 12.15, rounded once |
//! | normal | 1.12, truncated | 15-bit block, length divided out last | as `Compact` |
//! | shading | 16.16, truncated | 1.31 dots and powers, 16-bit coefficients | 1.31 |
//! | colour | 1.15 | 1.15 | 1.31 |
//! | pixel | 1.15 truncated, 64 bits | 16 bits, 65535 is 1, telescoping with plane dither, 64 bits | 1.31 telescoping, 128 bits |

use core::fmt::Debug;

use crate::composite::{Dithered, Recurrence, Telescoping31, Truncating15};
use crate::format::Rounding;

/// The formats and roundings of a pipeline. A value of a named precision has no size, and its numbers are constants of the
/// compiled pipeline; a study may keep numbers in fields.
pub trait Precision: Copy + Debug + Send + Sync + 'static {
    /// The pixel: its channel format and the arithmetic that folds a sample into it.
    type Pixel: Recurrence;
    /// The name that reports use.
    const NAME: &'static str;
    /// Fraction bits of a voxel's word, which has 12 bits before them: none, or 3 of an extinction whose gradient is taken.
    const VOXEL_FRACTION: u32 = 0;

    /// Whether its stages are those of [`Composite`](crate::plane::Composite), of 32-bit lanes; else they are those of [`plane::Fast`](crate::plane::Fast).
    const STAGED: bool = true;

    /// Widths and roundings up to the shaded colour.
    fn formats(self) -> Formats;
    /// The pixel's arithmetic.
    fn pixel(self) -> Self::Pixel;
}

/// Widths and roundings of the stages before compositing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Formats {
    /// Bits of a 0.16 interpolation weight that are used, at most 16; the rest are cut off.
    pub weight_bits: u32,
    /// Fraction bits kept after the y interpolation, at most 16.
    pub lerp_bits: u32,
    /// How interpolation loses its low bits.
    pub lerp_rounding: Rounding,
    /// Fraction bits of a sample, 1 to 15: more would overflow the mixing of table entries.
    pub sample_bits: u32,
    /// Bits of a gradient's largest component that normalisation reads, 1 to 15; the others keep the same scale.
    pub gradient_bits: u32,
    /// How the normal reaches the dot product.
    pub normal: NormalForm,
    /// The arithmetic of shading.
    pub shading: Shading,
    /// How a highlight's power is formed.
    pub power: Power,
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

/// Sixteen bits in every lane: [`plane::Fast`](crate::plane::Fast).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fast;

impl Precision for Fast {
    type Pixel = Dithered;
    const NAME: &'static str = "fast";
    const STAGED: bool = false;

    /// The widths; the roundings are its own (`docs/contract/fast.md`).
    #[inline(always)]
    fn formats(self) -> Formats {
        Formats {
            weight_bits: 15,
            lerp_bits: 3,
            lerp_rounding: Rounding::Nearest,
            sample_bits: 3,
            gradient_bits: 15,
            normal: NormalForm::Deferred,
            shading: Shading::Rounded16,
            power: Power::Truncated16,
        }
    }

    /// Of the same format as its own.
    #[inline(always)]
    fn pixel(self) -> Dithered {
        Dithered
    }
}

impl Precision for Paper {
    type Pixel = Truncating15;
    const NAME: &'static str = "paper";

    #[inline(always)]
    fn formats(self) -> Formats {
        Formats {
            weight_bits: 12,
            lerp_bits: 12,
            lerp_rounding: Rounding::Truncate,
            sample_bits: 12,
            gradient_bits: 15,
            normal: NormalForm::Formed(12),
            shading: Shading::Truncated16,
            power: Power::Truncated16,
        }
    }

    #[inline(always)]
    fn pixel(self) -> Truncating15 {
        Truncating15
    }
}

impl Precision for Compact {
    type Pixel = Dithered;
    const NAME: &'static str = "compact";

    #[inline(always)]
    fn formats(self) -> Formats {
        Formats {
            weight_bits: 16,
            lerp_bits: 16,
            lerp_rounding: Rounding::Nearest,
            sample_bits: 12,
            gradient_bits: 15,
            normal: NormalForm::Deferred,
            shading: Shading::Rounded16,
            power: Power::Rounded31,
        }
    }

    #[inline(always)]
    fn pixel(self) -> Dithered {
        Dithered
    }
}

impl Precision for Wide {
    type Pixel = Telescoping31;
    const NAME: &'static str = "wide";

    #[inline(always)]
    fn formats(self) -> Formats {
        Formats {
            weight_bits: 16,
            lerp_bits: 16,
            lerp_rounding: Rounding::Nearest,
            sample_bits: 15,
            gradient_bits: 15,
            normal: NormalForm::Deferred,
            shading: Shading::Rounded31,
            power: Power::Rounded31,
        }
    }

    #[inline(always)]
    fn pixel(self) -> Telescoping31 {
        Telescoping31
    }
}
