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

mod rows;
#[cfg(test)]
mod tests;

use core::fmt::Debug;

pub(crate) use self::rows::fold_at;
pub use self::rows::{Colours, PixelRow, fold_row, fold_visible_row};
use crate::format::Opacity;
use crate::lanes::{Lanes, Wide as _};

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
            colour: self.colour.map(|c| c.bits() as i32),
            transparency: self.transparency.bits() as i32,
        }
    }

    #[inline(always)]
    fn of_bits(bits: Pixel<i32>) -> Self {
        Self {
            colour: bits.colour.map(|c| C::from_bits(c as u32)),
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
        let (colour, opacity) = (colour.map(|c| c as i32), opacity.to_bits() as i32);
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
        let (colour, opacity) = (colour.map(|c| c as i32), opacity.to_bits() as i32);
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

/// 1.31 in floor steps; 128 bits per pixel. At most 2^-31 is lost a step.
///
/// Over: `w = floor(T a / 2^31); T -= w; C += floor(c w / 2^31)`.
/// Under: `C = C - floor(C a / 2^31) + floor(c a / 2^31)`.
/// Close to 0 floor steps no longer move T (below 2^-20 those of an opacity under 2^-11), hence the floor there: 0.0003
/// of an 8-bit step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Telescoping31;

/// Product of two 1.31 numbers, truncated.
#[inline(always)]
fn product31<V: Lanes>(a: V, b: V) -> V {
    a.product(b).shr_narrow(31)
}

/// What an opacity leaves of a value.
#[inline(always)]
fn left31<V: Lanes>(value: V, opacity: V) -> V {
    value.wrapping_sub(product31(value, opacity))
}

impl Recurrence for Telescoping31 {
    type Channel = u32;

    #[inline(always)]
    fn format(self) -> &'static str {
        u32::NAME
    }

    #[inline(always)]
    fn one(self) -> u32 {
        u32::ONE
    }

    #[inline(always)]
    fn floor(self) -> u32 {
        1 << 11
    }

    #[inline(always)]
    fn telescoping(self) -> bool {
        true
    }

    #[inline(always)]
    fn colour_bits(self) -> u32 {
        31
    }

    #[inline(always)]
    fn read(self, opacity: Opacity) -> Opacity {
        opacity
    }

    #[inline(always)]
    fn over_lanes<V: Lanes>(self, pixel: Pixel<V>, colour: [V; 3], opacity: V, _: Dither) -> Pixel<V> {
        let w = product31(pixel.transparency, opacity);
        let [r, g, b] = pixel.colour;
        let [cr, cg, cb] = colour;
        Pixel {
            colour: [
                r.wrapping_add(product31(cr, w)),
                g.wrapping_add(product31(cg, w)),
                b.wrapping_add(product31(cb, w)),
            ],
            transparency: pixel.transparency.wrapping_sub(w),
        }
    }

    #[inline(always)]
    fn under_lanes<V: Lanes>(self, pixel: Pixel<V>, colour: [V; 3], opacity: V, _: Dither) -> Pixel<V> {
        let ([r, g, b], [cr, cg, cb]) = (pixel.colour, colour);
        Pixel {
            colour: [
                left31(r, opacity).wrapping_add(product31(cr, opacity)),
                left31(g, opacity).wrapping_add(product31(cg, opacity)),
                left31(b, opacity).wrapping_add(product31(cb, opacity)),
            ],
            transparency: left31(pixel.transparency, opacity),
        }
    }
}

/// [`Unorm16`] with a dither that changes from plane to plane; 64 bits per pixel.
///
/// With the plane's [`Dither`] d:
/// over: `w = (T a + (2 dT + 1) 2^15) >> 31; T -= w; C += (c w + dC) >> 15`;
/// under: `w` and T alike, `C += ((c - C) a + (2 dC + 1) 2^15) >> 31` with c on the channel's scale.
/// The opacity keeps its 31 bits: rounded to 1.16 it would be wrong by up to 1 % in thin fog, the same way at every
/// sample, and no dither could mend that.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dithered;

/// The arithmetic of [`Dithered`] front to back, in channels of any format of at most 16 bits.
#[inline(always)]
pub fn dithered_over<V: Lanes>(pixel: Pixel<V>, colour: [V; 3], opacity: V, dither: Dither) -> Pixel<V> {
    let w = taken(pixel.transparency, opacity, dither);
    let offset = V::splat(dither.colour as i32);
    let ([r, g, b], [cr, cg, cb]) = (pixel.colour, colour);
    Pixel {
        colour: [
            r + given(cr, w, offset),
            g + given(cg, w, offset),
            b + given(cb, w, offset),
        ],
        transparency: pixel.transparency - w,
    }
}

/// The arithmetic of [`Dithered`] back to front, in channels in which 1.0 is `one`, at most 65535.
#[inline(always)]
pub fn dithered_under<V: Lanes>(one: u32, pixel: Pixel<V>, colour: [V; 3], opacity: V, dither: Dither) -> Pixel<V> {
    let w = taken(pixel.transparency, opacity, dither);
    let half = V::Wide::splat(i64::from(2 * dither.colour + 1) << 15);
    let ([r, g, b], [cr, cg, cb], one) = (pixel.colour, colour, V::splat(one as i32));
    Pixel {
        colour: [
            dithered_mix(r, cr, opacity, one, half),
            dithered_mix(g, cg, opacity, one, half),
            dithered_mix(b, cb, opacity, one, half),
        ],
        transparency: pixel.transparency - w,
    }
}

/// The light that a sample takes: at most the transparency, and none at an opacity of 0.
#[inline(always)]
fn taken<V: Lanes>(transparency: V, opacity: V, dither: Dither) -> V {
    transparency.product16_31(opacity, (2 * dither.transparency + 1) << 15)
}

/// What a sample of this colour gives of the light that it takes.
#[inline(always)]
fn given<V: Lanes>(colour: V, taken: V, offset: V) -> V {
    colour.wrapping_mul(taken).wrapping_add(offset).shr_unsigned(15)
}

/// The same in the upper 16 bits, for twice the offset: twice the sum that is shifted by 15 need not be shifted at all.
#[inline(always)]
fn given_above<V: Lanes>(colour: V, taken: V, twice_offset: V) -> V {
    (colour + colour).wrapping_mul(taken).wrapping_add(twice_offset)
}

/// `C + ((c - C) a + half) >> 31`, with C inside the shift so that nothing is negative.
#[inline(always)]
fn dithered_mix<V: Lanes>(old: V, colour: V, opacity: V, one: V, half: V::Wide) -> V {
    let scaled = colour.wrapping_mul(one);
    let scaled = scaled.wrapping_add(V::splat(1 << 14)).shr_unsigned(15);
    let sum = V::Wide::of(old).shl(31) + scaled.product(opacity) - old.product(opacity);
    (sum + half).shr_narrow(31)
}

impl Recurrence for Dithered {
    type Channel = Unorm16;

    #[inline(always)]
    fn format(self) -> &'static str {
        Unorm16::NAME
    }

    #[inline(always)]
    fn one(self) -> Unorm16 {
        Unorm16::ONE
    }

    #[inline(always)]
    fn floor(self) -> Unorm16 {
        Unorm16(1)
    }

    #[inline(always)]
    fn telescoping(self) -> bool {
        true
    }

    #[inline(always)]
    fn colour_bits(self) -> u32 {
        15
    }

    #[inline(always)]
    fn read(self, opacity: Opacity) -> Opacity {
        opacity
    }

    #[inline(always)]
    fn over_lanes<V: Lanes>(self, pixel: Pixel<V>, colour: [V; 3], opacity: V, dither: Dither) -> Pixel<V> {
        dithered_over(pixel, colour, opacity, dither)
    }

    #[inline(always)]
    fn over_two<V: Lanes>(
        self,
        row: &mut PixelRow<'_, Unorm16>,
        at: usize,
        [first, second]: [([V; 3], V); 2],
        dither: Dither,
        floor: V,
    ) {
        // No closure and no array's `map`, which may become calls: a call keeps no vector in a register.
        let transparency = &mut *row.transparency;
        let t0: V = V::load_as(transparency, at, Unorm16::bits);
        let t1: V = V::load_as(transparency, at + V::COUNT, Unorm16::bits);
        let (w0, w1) = (taken(t0, first.1, dither), taken(t1, second.1, dither));
        let (t0, t1) = (t0 - w0, t1 - w1);
        let left = [t0.at_least_then(floor, t0), t1.at_least_then(floor, t1)];
        V::store_two_as(left, transparency, at, Unorm16::from_bits);
        let (offset, [r0, g0, b0], [r1, g1, b1]) = (V::splat(2 * dither.colour as i32), first.0, second.0);
        let [red, green, blue] = &mut row.colour;
        let given = [given_above(r0, w0, offset), given_above(r1, w1, offset)];
        V::add_upper_as(given, red, at, Unorm16::bits, Unorm16::from_bits);
        let given = [given_above(g0, w0, offset), given_above(g1, w1, offset)];
        V::add_upper_as(given, green, at, Unorm16::bits, Unorm16::from_bits);
        let given = [given_above(b0, w0, offset), given_above(b1, w1, offset)];
        V::add_upper_as(given, blue, at, Unorm16::bits, Unorm16::from_bits);
    }

    #[inline(always)]
    fn under_lanes<V: Lanes>(self, pixel: Pixel<V>, colour: [V; 3], opacity: V, dither: Dither) -> Pixel<V> {
        dithered_under(Unorm16::ONE.bits(), pixel, colour, opacity, dither)
    }
}

/// 1.15, every product truncated: Squeeze, equations 9 and 6. 64 bits per pixel.
///
/// With `A = a >> 15` (1.16), `t = (2^16 - A) >> 1` and `p = (c (A >> 1)) >> 15`:
/// over: `C += (p T) >> 15; T = (T t) >> 15`; under: `C = ((C t) >> 15) + p`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Truncating15;

/// Product of two 1.15 numbers, truncated.
#[inline(always)]
fn product15<V: Lanes>(a: V, b: V) -> V {
    (a * b) >> 15
}

impl Truncating15 {
    /// Transparency and opacity of a sample, 1.15.
    #[inline(always)]
    fn sample<V: Lanes>(opacity: V) -> (V, V) {
        let a = opacity.shr_unsigned(15);
        ((V::splat(1 << 16) - a) >> 1, a >> 1)
    }
}

impl Recurrence for Truncating15 {
    type Channel = u16;

    #[inline(always)]
    fn format(self) -> &'static str {
        u16::NAME
    }

    #[inline(always)]
    fn one(self) -> u16 {
        u16::ONE
    }

    #[inline(always)]
    fn floor(self) -> u16 {
        1
    }

    #[inline(always)]
    fn telescoping(self) -> bool {
        false
    }

    #[inline(always)]
    fn colour_bits(self) -> u32 {
        15
    }

    #[inline(always)]
    fn read(self, opacity: Opacity) -> Opacity {
        Opacity::from_bits(opacity.to_bits() >> 15 << 15)
    }

    #[inline(always)]
    fn over_lanes<V: Lanes>(self, pixel: Pixel<V>, colour: [V; 3], opacity: V, _: Dither) -> Pixel<V> {
        let (t, a) = Self::sample(opacity);
        let before = pixel.transparency;
        let ([r, g, b], [cr, cg, cb]) = (pixel.colour, colour);
        Pixel {
            colour: [
                r + product15(product15(cr, a), before),
                g + product15(product15(cg, a), before),
                b + product15(product15(cb, a), before),
            ],
            transparency: product15(before, t),
        }
    }

    #[inline(always)]
    fn under_lanes<V: Lanes>(self, pixel: Pixel<V>, colour: [V; 3], opacity: V, _: Dither) -> Pixel<V> {
        let (t, a) = Self::sample(opacity);
        let ([r, g, b], [cr, cg, cb]) = (pixel.colour, colour);
        Pixel {
            colour: [
                product15(r, t) + product15(cr, a),
                product15(g, t) + product15(cg, a),
                product15(b, t) + product15(cb, a),
            ],
            transparency: product15(pixel.transparency, t),
        }
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
