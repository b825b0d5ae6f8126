//! Precisions of a study, put together from parts: values, surface, pixel.

use std::marker::PhantomData;

use fixed::FixedI32;
use fixed::traits::Fixed;
use fixed::types::extra::{U4, U6, U8, U10, U14};
use slicecast::composite::{Dithered, Recurrence, Unorm16};
use slicecast::format::{Rounding, Sample12};
use slicecast::precision::{NormalForm, Power, Precision, Shading};

/// A sample of 12.4.
pub type Sample4 = FixedI32<U4>;
/// A sample of 12.6.
pub type Sample6 = FixedI32<U6>;
/// A sample of 12.8.
pub type Sample8 = FixedI32<U8>;
/// A sample of 12.10.
pub type Sample10 = FixedI32<U10>;
/// A sample of 12.14.
pub type Sample14 = FixedI32<U14>;

/// How samples are made.
pub trait Values: 'static {
    /// See [`Precision::Sample`].
    type Sample: Fixed<Bits = i32>;
    /// See [`Precision::WEIGHT_BITS`].
    const WEIGHT_BITS: u32;
    /// Whether every interpolation truncates to the sample's format, as Squeeze's does; else one rounding at the end.
    const TRUNCATED: bool;
}

/// Samples of a format, from weights of so many bits.
pub struct Blend<S, const WEIGHT: u32, const TRUNCATED: bool>(PhantomData<S>);

impl<S: Fixed<Bits = i32> + 'static, const WEIGHT: u32, const TRUNCATED: bool> Values for Blend<S, WEIGHT, TRUNCATED> {
    type Sample = S;
    const WEIGHT_BITS: u32 = WEIGHT;
    const TRUNCATED: bool = TRUNCATED;
}

/// How gradients become colours.
pub trait Surface: 'static {
    /// See [`Precision::GRADIENT_BITS`].
    const GRADIENT_BITS: u32;
    /// See [`Precision::NORMAL`].
    const NORMAL: NormalForm;
    /// See [`Precision::SHADING`].
    const SHADING: Shading;
    /// See [`Precision::POWER`].
    const POWER: Power;
}

/// The surface of `Compact`, with so many bits of the gradient.
pub struct Deferred<const GRADIENT: u32>;
/// A normal formed first, truncated to so many bits, in `Compact`'s shading.
pub struct Cut<const BITS: u32>;
/// A normal formed first, to the nearest of so many bits, in `Compact`'s shading.
pub struct Near<const BITS: u32>;
/// `Compact`'s surface with truncated squaring.
pub struct TruncatedPower;
/// `Compact`'s surface with the inverted parabola.
pub struct ParabolicPower;
/// `Compact`'s normal in Squeeze's truncated shading.
pub struct TruncatedShading;
/// The surface of `Wide`, for pixels that take 31-bit colours.
pub struct Deep;

impl<const GRADIENT: u32> Surface for Deferred<GRADIENT> {
    const GRADIENT_BITS: u32 = GRADIENT;
    const NORMAL: NormalForm = NormalForm::Deferred;
    const SHADING: Shading = Shading::Rounded16;
    const POWER: Power = Self::SHADING.power();
}

impl<const BITS: u32> Surface for Cut<BITS> {
    const GRADIENT_BITS: u32 = 15;
    const NORMAL: NormalForm = NormalForm::Formed(BITS);
    const SHADING: Shading = Shading::Rounded16;
    const POWER: Power = Self::SHADING.power();
}

impl<const BITS: u32> Surface for Near<BITS> {
    const GRADIENT_BITS: u32 = 15;
    const NORMAL: NormalForm = NormalForm::Nearest(BITS);
    const SHADING: Shading = Shading::Rounded16;
    const POWER: Power = Self::SHADING.power();
}

impl Surface for TruncatedPower {
    const GRADIENT_BITS: u32 = 15;
    const NORMAL: NormalForm = NormalForm::Deferred;
    const SHADING: Shading = Shading::Rounded16;
    const POWER: Power = Power::Truncated16;
}

impl Surface for ParabolicPower {
    const GRADIENT_BITS: u32 = 15;
    const NORMAL: NormalForm = NormalForm::Deferred;
    const SHADING: Shading = Shading::Rounded16;
    const POWER: Power = Power::Parabola;
}

impl Surface for TruncatedShading {
    const GRADIENT_BITS: u32 = 15;
    const NORMAL: NormalForm = NormalForm::Deferred;
    const SHADING: Shading = Shading::Truncated16;
    const POWER: Power = Self::SHADING.power();
}

impl Surface for Deep {
    const GRADIENT_BITS: u32 = 15;
    const NORMAL: NormalForm = NormalForm::Deferred;
    const SHADING: Shading = Shading::Rounded31;
    const POWER: Power = Self::SHADING.power();
}

/// The pixel of `Compact`.
pub type CompactPixel = Dithered<Unorm16>;
/// The samples of `Compact`.
pub type CompactValues = Blend<Sample12, 16, false>;
/// The surface of `Compact`.
pub type CompactSurface = Deferred<15>;

/// What a precision is put together from: no value of these types ever exists.
type Parts<V, S, X> = fn() -> (V, S, X);

/// A precision of three parts.
pub struct Study<V, S, X>(PhantomData<Parts<V, S, X>>);

impl<V, S, X> Clone for Study<V, S, X> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<V, S, X> Copy for Study<V, S, X> {}

impl<V, S, X> Default for Study<V, S, X> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

impl<V: Values, S: Surface, X: Recurrence> Precision for Study<V, S, X> {
    type Sample = V::Sample;
    type Pixel = X;
    const NAME: &'static str = "study";
    const BLOCKS: bool = false;
    const WEIGHT_BITS: u32 = V::WEIGHT_BITS;
    const LERP_BITS: u32 = if V::TRUNCATED { V::Sample::FRAC_NBITS } else { 16 };
    const LERP_ROUNDING: Rounding = if V::TRUNCATED {
        Rounding::Truncate
    } else {
        Rounding::Nearest
    };
    const NORMAL: NormalForm = S::NORMAL;
    const SHADING: Shading = {
        // Shading makes the colours that the pixel reads.
        assert!(
            matches!(S::SHADING, Shading::Rounded31) == (X::COLOUR_BITS == 31),
            "a pixel of 31-bit colours and shading in 31 bits belong together"
        );
        S::SHADING
    };
    const GRADIENT_BITS: u32 = S::GRADIENT_BITS;
    const POWER: Power = S::POWER;
}
