//! Compositing: fold the samples of a ray into its pixel.
//!
//! Source: Squeeze, equations 4, 6 and 9. The accurate precisions use the telescoping form
//! `w = (T * a) >> 31; T -= w; C += (c * w) >> 31` (1.31; 16 bits: `docs/contract/compositing.md`): what a sample takes from the light is exactly what it may give, so that white fog keeps
//! C + T = 1 and no clamp can fire.
//!
//! | value | format | range |
//! |---|---|---|
//! | T, C | 1.15 ([`Truncating15`]), [`Unorm16`] or 1.15 ([`Dithered`]), 1.31 ([`Telescoping31`]) | 0 to 1 |
//! | opacity a | 1.31 | 0 to 1 |
//! | colour c | 1.15 (16-bit channels) or 1.31, [`Recurrence::colour_bits`] | 0 to 1 |
//!
//! An opacity of 0 leaves a pixel as it is, and so does any sample where T is 0: skipping what is empty, stopping a
//! finished ray and going on are the same bits. T that falls below a pixel format's floor becomes 0. A higher floor is
//! early ray termination: stopping at T < 2^-t changes an 8-bit value by at most 255 * 2^-t.
//! Error a step: less than 1 ulp in T and, given the light taken, in C; [`Truncating15`] 1.5 and 3; where the floor takes
//! the rest of T, that much. Overflow: none. State: the pixel.

mod dithered;
mod rows;
mod telescoping;
#[cfg(test)]
mod tests;
mod truncating;
mod weighted;

use core::fmt::Debug;

pub use self::dithered::{Dithered, dithered_over, dithered_under};
pub(crate) use self::rows::fold_at;
pub use self::rows::{Colours, PixelRow, fold_row, fold_visible_row};
pub use self::telescoping::Telescoping31;
pub use self::truncating::Truncating15;
pub use self::weighted::Weighted;
pub(crate) use self::weighted::fold_weighted_row;
use crate::format::Opacity;
use crate::lanes::Lanes;
use crate::rows::three;

/// The memory of a channel: 0 to 1, both included, as whole multiples of 1 / [`Recurrence::one`].
pub trait Channel: Copy + Debug + Default + Ord + Send + Sync + 'static {
    /// Raw bits.
    fn bits(self) -> u32;
    /// From raw bits; those beyond the type are lost.
    fn from_bits(bits: u32) -> Self;
}

/// A channel whose type says what 1.0 is: what the warp reads.
pub trait ChannelFormat: Channel {
    /// The format's name in reports.
    const NAME: &'static str;
    /// 1.0.
    const ONE: Self;
}

/// 1.15: 32768 is 1.0.
impl ChannelFormat for u16 {
    const NAME: &'static str = "1.15";
    const ONE: Self = 1 << 15;
}

impl Channel for u16 {
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self)
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        bits as u16
    }
}

/// 1.31: 2^31 is 1.0.
impl ChannelFormat for u32 {
    const NAME: &'static str = "1.31";
    const ONE: Self = 1 << 31;
}

impl Channel for u32 {
    #[inline(always)]
    fn bits(self) -> u32 {
        self
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        bits
    }
}

/// 16 bits of which 65535 is 1.0: all of a 16-bit word, where 1.15 leaves half of its codes unused.
///
/// Squeeze (section 3) rejects such a scale because a product of two such numbers needs a correction. A telescoping
/// pixel never forms one: transparency is only ever multiplied by an opacity of 31 fraction bits and subtracted from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[repr(transparent)]
pub struct Unorm16(pub u16);

impl ChannelFormat for Unorm16 {
    const NAME: &'static str = "unorm16";
    const ONE: Self = Self(u16::MAX);
}

impl Channel for Unorm16 {
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self.0)
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self(bits as u16)
    }
}

/// A ray's light so far: colour that has reached the eye, weighted by its opacity, and the transparency left. Of one
/// ray (`C` a channel) or of several side by side (`C` the bits of their channels in lanes).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pixel<C> {
    /// Red, green, blue.
    pub colour: [C; 3],
    /// Transparency.
    pub transparency: C,
}

impl<C: ChannelFormat> Pixel<C> {
    /// A ray that has met nothing.
    #[inline(always)]
    pub fn clear() -> Self {
        Self {
            colour: [C::default(); 3],
            transparency: C::ONE,
        }
    }
}

impl<C: Channel> Pixel<C> {
    /// The bits of the channels.
    #[inline(always)]
    fn bits(self) -> Pixel<i32> {
        Pixel {
            colour: three(self.colour, |c| c.bits() as i32),
            transparency: self.transparency.bits() as i32,
        }
    }

    #[inline(always)]
    fn of_bits(bits: Pixel<i32>) -> Self {
        Self {
            colour: three(bits.colour, |c| C::from_bits(c as u32)),
            transparency: C::from_bits(bits.transparency as u32),
        }
    }
}

/// Rounding offsets of a plane, the same for all its pixels: 15-bit Kronecker sequences in the plane's number, which
/// spread the rounding errors of a ray evenly however its samples repeat.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dither {
    /// For transparency.
    pub transparency: u32,
    /// For colour.
    pub colour: u32,
}

impl Dither {
    /// The offsets of a part of plane `k`'s segments, where they are cut: those of plane `k + 457 part`. In the sequences
    /// 457 is a step of 0.43 and 0.30, unlike those of the planes.
    #[inline]
    pub const fn of_part(k: u32, part: u32) -> Self {
        Self::of_plane(k.wrapping_add(part.wrapping_mul(457)))
    }

    /// The offsets of plane `k`: `20251 k` and `13573 k + 9973`, modulo 2^15.
    #[inline]
    pub const fn of_plane(k: u32) -> Self {
        Self {
            transparency: k.wrapping_mul(20251) & 0x7fff,
            colour: k.wrapping_mul(13573).wrapping_add(9973) & 0x7fff,
        }
    }
}

/// The arithmetic of a pixel.
pub trait Recurrence: Copy + Debug + Send + Sync + 'static {
    /// Accumulator format.
    type Channel: Channel;

    /// The channels' format, as reports name it.
    fn format(self) -> &'static str;
    /// 1.0 of a channel.
    fn one(self) -> Self::Channel;
    /// Transparency below this becomes 0.
    fn floor(self) -> Self::Channel;
    /// Whether a sample gives exactly the light that it takes, rounding included (front to back).
    fn telescoping(self) -> bool;
    /// Fraction bits of a sample's colour: 15 or 31.
    fn colour_bits(self) -> u32;

    /// The opacity as this pixel reads it: rounded to what its products can use.
    fn read(self, opacity: Opacity) -> Opacity;

    /// A ray that has met nothing.
    #[inline(always)]
    fn clear(self) -> Pixel<Self::Channel> {
        Pixel {
            colour: [Self::Channel::default(); 3],
            transparency: self.one(),
        }
    }

    /// Pixels with one more sample behind them (front to back). `colour` has [`colour_bits`](Self::colour_bits), `opacity` is 1.31. This
    /// function is the definition; it leaves out the floor, which [`settle`] applies.
    fn over_lanes<V: Lanes>(self, pixel: Pixel<V>, colour: [V; 3], opacity: V, dither: Dither) -> Pixel<V>;

    /// Pixels with one more sample in front of them (back to front). The same picture up to rounding.
    fn under_lanes<V: Lanes>(self, pixel: Pixel<V>, colour: [V; 3], opacity: V, dither: Dither) -> Pixel<V>;

    /// [`Recurrence::over_lanes`] of two vectors of a row's pixels, one behind the other, with the floor applied: for an
    /// arithmetic that makes them together with less work.
    #[inline(always)]
    fn over_two<V: Lanes>(
        self,
        row: &mut PixelRow<'_, Self::Channel>,
        at: usize,
        [first, second]: [([V; 3], V); 2],
        dither: Dither,
        floor: V,
    ) {
        fold_at::<Self, FrontToBack, V>(self, row, at, first, dither, floor);
        fold_at::<Self, FrontToBack, V>(self, row, at + V::COUNT, second, dither, floor);
    }

    /// [`Recurrence::over_lanes`] of one pixel.
    #[inline(always)]
    fn over(
        self,
        pixel: Pixel<Self::Channel>,
        colour: [u32; 3],
        opacity: Opacity,
        dither: Dither,
    ) -> Pixel<Self::Channel> {
        let (colour, opacity) = (three(colour, |c| c as i32), opacity.to_bits() as i32);
        Pixel::of_bits(self.over_lanes(pixel.bits(), colour, opacity, dither))
    }

    /// [`Recurrence::under_lanes`] of one pixel.
    #[inline(always)]
    fn under(
        self,
        pixel: Pixel<Self::Channel>,
        colour: [u32; 3],
        opacity: Opacity,
        dither: Dither,
    ) -> Pixel<Self::Channel> {
        let (colour, opacity) = (three(colour, |c| c as i32), opacity.to_bits() as i32);
        Pixel::of_bits(self.under_lanes(pixel.bits(), colour, opacity, dither))
    }
}

/// Transparency with the floor applied.
#[inline(always)]
pub fn settle<C: Channel>(transparency: C, floor: C) -> C {
    if transparency < floor {
        C::default()
    } else {
        transparency
    }
}

/// The order in which the planes of a ray are folded.
pub trait Order: Copy + Send + Sync + 'static {
    /// Whether planes go from the last to the first.
    const BACK_TO_FRONT: bool;
    /// Folds one sample into each pixel.
    fn fold<R: Recurrence, V: Lanes>(
        recurrence: R,
        pixel: Pixel<V>,
        colour: [V; 3],
        opacity: V,
        dither: Dither,
        floor: V,
    ) -> Pixel<V>;
    /// Folds samples, colour and opacity, into two vectors of a row's pixels, one behind the other.
    #[inline(always)]
    fn fold_two<R: Recurrence, V: Lanes>(
        recurrence: R,
        row: &mut PixelRow<'_, R::Channel>,
        at: usize,
        [first, second]: [([V; 3], V); 2],
        dither: Dither,
        floor: V,
    ) {
        fold_at::<R, Self, V>(recurrence, row, at, first, dither, floor);
        fold_at::<R, Self, V>(recurrence, row, at + V::COUNT, second, dither, floor);
    }
}

/// Nearest plane first. The default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrontToBack;

/// Farthest plane first; for comparison. No ray ever stops early.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BackToFront;

impl Order for FrontToBack {
    const BACK_TO_FRONT: bool = false;
    #[inline(always)]
    fn fold<R: Recurrence, V: Lanes>(
        recurrence: R,
        pixel: Pixel<V>,
        colour: [V; 3],
        opacity: V,
        dither: Dither,
        floor: V,
    ) -> Pixel<V> {
        let mut out = recurrence.over_lanes(pixel, colour, opacity, dither);
        out.transparency = out.transparency.at_least_then(floor, out.transparency);
        out
    }
    #[inline(always)]
    fn fold_two<R: Recurrence, V: Lanes>(
        recurrence: R,
        row: &mut PixelRow<'_, R::Channel>,
        at: usize,
        samples: [([V; 3], V); 2],
        dither: Dither,
        floor: V,
    ) {
        recurrence.over_two(row, at, samples, dither, floor);
    }
}

impl Order for BackToFront {
    const BACK_TO_FRONT: bool = true;
    #[inline(always)]
    fn fold<R: Recurrence, V: Lanes>(
        recurrence: R,
        pixel: Pixel<V>,
        colour: [V; 3],
        opacity: V,
        dither: Dither,
        _: V,
    ) -> Pixel<V> {
        recurrence.under_lanes(pixel, colour, opacity, dither)
    }
}

/// A channel as an 8-bit value, exactly rounded, halves up: `min(255, floor(255 C / ONE + 1/2))`.
#[inline]
pub fn to_byte<C: ChannelFormat>(channel: C) -> u8 {
    let one = u64::from(C::ONE.bits());
    // The divisor is a constant of the type, never 0.
    let rounded = (u64::from(channel.bits()) * 510 + one).checked_div(2 * one);
    rounded.unwrap_or(0).min(255) as u8
}
