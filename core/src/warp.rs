//! Warp: from the base-plane image to the viewer's picture, an affine map of the plane.
//!
//! Every picture pixel looks at one point of the base plane and takes the bilinear mixture of the four pixels around
//! it, in premultiplied colour and transparency, so that borders fade without a fringe. Outside the base plane all is
//! clear.
//!
//! | value | format | unit |
//! |---|---|---|
//! | origin, steps | s31.32 | base-plane pixels (all phases) |
//! | coordinate | 16 fraction bits, to nearest | base-plane pixels |
//! | pixel | the channel's | |
//!
//! A mixture is two roundings to nearest, along u and then along v: `a + (((b - a) * w + 2^15) >> 16)`, in 64 bits. It lies
//! between its corners. Error: 1 ulp of the channel. State: none.
//!
//! Row kernels mix many pixels whose corners lie side by side, and put them in front of a background. As
//! `a 2^16 + (b - a) w + 2^15` is less than 2^32 for 16-bit channels, 32 bits are enough there.

use crate::composite::{Channel, ChannelFormat, Pixel, to_byte};
use crate::format::{Intensity, Step};
use crate::lanes::{Lanes, Wide as _, places};

/// The affine map: where picture pixels look at the base plane, (u, v) each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Warp {
    /// What the centre of the picture's first pixel sees.
    pub origin: [Step; 2],
    /// One picture pixel to the right.
    pub right: [Step; 2],
    /// One picture pixel down.
    pub down: [Step; 2],
}

/// A point of the base plane: the pixel before it and the weight of the next, 0.16, along u and v.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Point {
    /// Pixels.
    pub pixel: [i64; 2],
    /// Weights.
    pub weight: [u32; 2],
}

impl Point {
    /// The point with these coordinates, s31.32, rounded to 16 fraction bits.
    #[inline(always)]
    pub fn at(exact: [i64; 2]) -> Self {
        let rounded = exact.map(|c| c.wrapping_add(1 << 15) >> 16);
        Self {
            pixel: rounded.map(|c| c >> 16),
            weight: rounded.map(|c| (c & 0xffff) as u32),
        }
    }
}

impl Warp {
    /// Every picture pixel is the base-plane pixel of its number.
    pub const IDENTITY: Self = Self {
        origin: [Step::ZERO; 2],
        right: [Step::ONE, Step::ZERO],
        down: [Step::ZERO, Step::ONE],
    };

    /// Where a picture pixel looks, before rounding: s31.32, (u, v). Wraps beyond 2^31 pixels.
    #[inline]
    pub fn exact(&self, x: u32, y: u32) -> [i64; 2] {
        let along = |o: Step, r: Step, d: Step| {
            o.to_bits()
                .wrapping_add(r.to_bits().wrapping_mul(i64::from(x)))
                .wrapping_add(d.to_bits().wrapping_mul(i64::from(y)))
        };
        let ([ou, ov], [ru, rv], [du, dv]) = (self.origin, self.right, self.down);
        [along(ou, ru, du), along(ov, rv, dv)]
    }

    /// Where a picture pixel looks. Wraps beyond 2^31 pixels.
    #[inline]
    pub fn point(&self, x: u32, y: u32) -> Point {
        Point::at(self.exact(x, y))
    }

    /// A picture pixel, from the base-plane pixels that `base(u, v)` gives.
    #[inline]
    pub fn pixel<C: Channel>(&self, x: u32, y: u32, base: impl Fn(i64, i64) -> Pixel<C>) -> Pixel<C> {
        let Point {
            pixel: [u, v],
            weight: [wu, wv],
        } = self.point(x, y);
        let row = |v: i64| mix_pixels(base(u, v), base(u.wrapping_add(1), v), wu);
        mix_pixels(row(v), row(v.wrapping_add(1)), wv)
    }
}

/// `a + (b - a) w`, to nearest, halves up. This function is the definition.
#[inline]
pub fn mix<C: Channel>(a: C, b: C, weight: u32) -> C {
    let (a, b) = (i64::from(a.bits()), i64::from(b.bits()));
    C::from_bits((a + (((b - a) * i64::from(weight) + (1 << 15)) >> 16)) as u32)
}

/// [`mix`] of all channels.
#[inline]
pub fn mix_pixels<C: Channel>(a: Pixel<C>, b: Pixel<C>, weight: u32) -> Pixel<C> {
    let mut out = a;
    for (o, b) in out.colour.iter_mut().zip(b.colour) {
        *o = mix(*o, b, weight);
    }
    out.transparency = mix(a.transparency, b.transparency, weight);
    out
}

/// A pixel in front of a background colour (1.15), as 8-bit values: `C + T background`, rounded once to the channel
/// and once to 8 bits.
#[inline]
pub fn in_front_of<C: ChannelFormat>(pixel: Pixel<C>, background: [Intensity; 3]) -> [u8; 3] {
    let mut out = [0; 3];
    for ((o, c), k) in out.iter_mut().zip(pixel.colour).zip(background) {
        let behind = (u64::from(pixel.transparency.bits()) * u64::from(k.to_bits()) + (1 << 14)) >> 15;
        let sum = (u64::from(c.bits()) + behind).min(u64::from(C::ONE.bits()));
        *o = to_byte(C::from_bits(sum as u32));
    }
    out
}

/// [`mix`] of lanes.
#[inline(always)]
fn mix_lanes<C: Channel, V: Lanes>(a: V, b: V, weight: V) -> V {
    if is_short::<C>() {
        // The sum lies between 2^15 and (2^16 - 1) 2^16 + 2^15, whatever its parts do.
        let step = b.wrapping_sub(a).wrapping_mul(weight);
        let sum = (a << 16).wrapping_add(V::splat(1 << 15)).wrapping_add(step);
        sum.shr_unsigned(16)
    } else {
        // a (1 - w) + b w: the same number without a sign.
        let rest = V::splat(1 << 16) - weight;
        (a.product(rest) + b.product(weight) + V::Wide::splat(1 << 15)).shr_narrow(16)
    }
}

/// Whether a channel's values fit 16 bits.
const fn is_short<C: Channel>() -> bool {
    size_of::<C>() <= 2
}

/// Mixes rows of channels: `corners` are the upper left, upper right, lower left and lower right neighbours, `weights`
/// those along u and v. Equals [`mix`] of the upper two and of the lower two along u, then of both along v. All rows
/// equally long; with shorter ones nothing is written.
#[inline(always)]
pub fn mix_row<C: Channel, V: Lanes>(corners: [&[C]; 4], weights: [&[u16]; 2], out: &mut [C]) {
    let len = out.len();
    let ([a, b, c, d], [wu, wv]) = (corners, weights);
    let (Some(a), Some(b), Some(c), Some(d)) = (a.get(..len), b.get(..len), c.get(..len), d.get(..len)) else {
        return;
    };
    let (Some(wu), Some(wv)) = (wu.get(..len), wv.get(..len)) else {
        return;
    };
    for at in places::<V>(len) {
        let load = |row: &[C]| V::load_as(row, at, C::bits);
        let (u, v) = (V::load_voxels(wu, at), V::load_voxels(wv, at));
        let (upper, lower) = (
            mix_lanes::<C, V>(load(a), load(b), u),
            mix_lanes::<C, V>(load(c), load(d), u),
        );
        mix_lanes::<C, V>(upper, lower, v).store_as(out, at, C::from_bits);
    }
}

/// [`to_byte`] of lanes that hold at most 1.0.
#[inline(always)]
fn byte_lanes<C: ChannelFormat, V: Lanes>(channel: V) -> V {
    let one = C::ONE.bits();
    if is_short::<C>() {
        // A reciprocal of 24 bits: exact for powers of two, and close enough for 65535 (tests).
        let factor = ((255u32 << 24) + (one >> 1)).checked_div(one).unwrap_or(0);
        let scaled = channel.wrapping_mul(V::splat(factor as i32));
        scaled.wrapping_add(V::splat(1 << 23)).shr_unsigned(24)
    } else {
        let scaled = channel.product(V::splat(255)) + V::Wide::splat(i64::from(one >> 1));
        scaled.shr_narrow(one.trailing_zeros())
    }
}

/// [`in_front_of`] of rows of channels: each with its pixel's transparency and its background (1.15). All rows equally
/// long; with shorter ones nothing is written.
#[inline(always)]
pub fn in_front_of_row<C: ChannelFormat, V: Lanes>(
    channels: &[C],
    transparency: &[C],
    background: &[u16],
    out: &mut [u8],
) {
    let len = out.len();
    let (Some(channels), Some(transparency)) = (channels.get(..len), transparency.get(..len)) else {
        return;
    };
    let Some(background) = background.get(..len) else {
        return;
    };
    let one = V::splat(C::ONE.bits() as i32);
    for at in places::<V>(len) {
        let (c, t) = (V::load_as(channels, at, C::bits), V::load_as(transparency, at, C::bits));
        let k = V::load_voxels(background, at);
        let behind = if is_short::<C>() {
            t.wrapping_mul(k).wrapping_add(V::splat(1 << 14)).shr_unsigned(15)
        } else {
            (t.product(k) + V::Wide::splat(1 << 14)).shr_narrow(15)
        };
        let sum = c.saturating_add(behind).at_most_unsigned(one);
        byte_lanes::<C, V>(sum).store_as(out, at, |bits| bits as u8);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::composite::Unorm16;
    use crate::composite::{Recurrence as _, Telescoping31, Truncating15};
    use proptest::prelude::*;

    #[test]
    fn whole_pixels_come_through_unchanged() {
        let warp = Warp {
            origin: [Step::from_num(-1), Step::from_num(2)],
            right: [Step::ONE, Step::ZERO],
            down: [Step::ZERO, Step::ONE],
        };
        let base = |u: i64, v: i64| Pixel {
            colour: [u as u16 & 0xff, v as u16 & 0xff, 7],
            transparency: 9,
        };
        assert_eq!(warp.pixel(4, 5, base), base(3, 7));
        assert_eq!(
            warp.point(0, 0),
            Point {
                pixel: [-1, 2],
                weight: [0, 0]
            }
        );
    }

    #[test]
    fn a_white_edge_fades_to_nothing() {
        let half = Warp {
            origin: [Step::from_num(-0.5), Step::ZERO],
            right: [Step::ONE, Step::ZERO],
            down: [Step::ZERO, Step::ONE],
        };
        let base = |u: i64, _: i64| {
            if u >= 0 {
                Pixel {
                    colour: [u32::ONE; 3],
                    transparency: 0,
                }
            } else {
                Telescoping31.clear()
            }
        };
        let edge = half.pixel(0, 0, base);
        assert_eq!(
            edge,
            Pixel {
                colour: [1 << 30; 3],
                transparency: 1 << 30
            }
        );
        let black = [Intensity::ZERO; 3];
        assert_eq!(in_front_of(edge, black), [128; 3]);
        assert_eq!(in_front_of(edge, [Intensity::ONE; 3]), [255; 3]);
        assert_eq!(in_front_of(Truncating15.clear(), [Intensity::ONE; 3]), [255; 3]);
    }

    /// Channels that are hard to round, and any.
    fn channel<C: ChannelFormat>() -> impl Strategy<Value = C> {
        let one = C::ONE.bits();
        prop_oneof![
            3 => 0..=one,
            1 => 0..=3u32,
            1 => one - 3..=one,
            1 => (0u32..=255, 0u32..5).prop_map(move |(byte, more)| {
                // Where the byte changes.
                let place = u64::from(2 * byte + 1) * u64::from(one) / 510;
                (place as u32 + more).saturating_sub(2).min(one)
            }),
        ]
        .prop_map(C::from_bits)
    }

    fn weight() -> impl Strategy<Value = u16> {
        prop_oneof![4 => any::<u16>(), 1 => 0u16..3, 1 => 65533u16..=65535, 1 => 32767u16..32770]
    }

    /// Row kernels on rows of pixels, channel after channel, against the definitions.
    fn rows_follow_the_definitions<C: ChannelFormat>(
        pixels: &[([[C; 4]; 4], [u16; 2])],
        background: [u16; 3],
    ) -> Result<(), TestCaseError> {
        let [red, green, blue] = background;
        let corners = [0, 1, 2, 3].map(|corner| {
            let row = pixels.iter().flat_map(|(corners, _)| corners[corner]);
            row.collect::<std::vec::Vec<C>>()
        });
        let weights = [0, 1].map(|axis| {
            let row = pixels.iter().flat_map(|(_, weights)| [weights[axis]; 4]);
            row.collect::<std::vec::Vec<u16>>()
        });
        let behind: std::vec::Vec<u16> = pixels.iter().flat_map(|_| [red, green, blue, 0]).collect();
        let mut mixed = std::vec![C::default(); 4 * pixels.len()];
        mix_row::<C, i32>(
            corners.each_ref().map(|row| &row[..]),
            weights.each_ref().map(|row| &row[..]),
            &mut mixed,
        );
        let transparency: std::vec::Vec<C> = mixed.chunks(4).flat_map(|pixel| [pixel[3]; 4]).collect();
        let mut bytes = std::vec![0; mixed.len()];
        in_front_of_row::<C, i32>(&mixed, &transparency, &behind, &mut bytes);
        let pixel = |[r, g, b, transparency]: [C; 4]| Pixel {
            colour: [r, g, b],
            transparency,
        };
        for ((at, ([a, b, c, d], [wu, wv])), bytes) in pixels.iter().enumerate().zip(bytes.chunks(4)) {
            let (wu, wv) = (u32::from(*wu), u32::from(*wv));
            let (upper, lower) = (
                mix_pixels(pixel(*a), pixel(*b), wu),
                mix_pixels(pixel(*c), pixel(*d), wu),
            );
            let expected = mix_pixels(upper, lower, wv);
            let found = [0, 1, 2, 3].map(|channel| mixed[4 * at + channel]);
            prop_assert_eq!(pixel(found), expected);
            let shown = in_front_of(expected, background.map(Intensity::from_bits));
            prop_assert_eq!(&bytes[..3], &shown[..]);
        }
        Ok(())
    }

    fn pixels<C: ChannelFormat>() -> impl Strategy<Value = std::vec::Vec<([[C; 4]; 4], [u16; 2])>> {
        let corners = || prop::array::uniform4(prop::array::uniform4(channel::<C>()));
        let clear_or_not = prop_oneof![
            4 => corners(),
            // Opaque and clear, the largest differences.
            1 => (corners(), 0usize..4).prop_map(|(mut corners, at)| {
                let none = C::default();
                corners[at] = [none, none, none, C::ONE];
                corners[3 - at] = [C::ONE, C::ONE, C::ONE, none];
                corners
            }),
        ];
        prop::collection::vec((clear_or_not, prop::array::uniform2(weight())), 0..9)
    }

    /// Every value of the 16-bit channels.
    #[test]
    fn rows_of_short_channels_become_the_same_bytes() {
        fn all<C: ChannelFormat>() {
            let row: std::vec::Vec<C> = (0..=C::ONE.bits()).map(C::from_bits).collect();
            let mut bytes = std::vec![0; row.len()];
            let opaque = std::vec![C::default(); row.len()];
            in_front_of_row::<C, i32>(&row, &opaque, &std::vec![0; row.len()], &mut bytes);
            for (channel, byte) in row.iter().zip(&bytes) {
                assert_eq!(*byte, to_byte(*channel), "{channel:?}");
            }
        }
        all::<u16>();
        all::<Unorm16>();
    }

    #[test]
    fn shorter_rows_write_nothing() {
        let (four, five) = ([7u16; 4], [9u16; 5]);
        let mut out = [1; 5];
        mix_row::<u16, i32>([&five, &five, &four, &five], [&five; 2], &mut out);
        mix_row::<u16, i32>([&five; 4], [&five, &four], &mut out);
        let mut bytes = [1; 5];
        in_front_of_row::<u16, i32>(&five, &four, &five, &mut bytes);
        assert_eq!((out, bytes), ([1; 5], [1; 5]));
    }

    #[test]
    fn points_step_as_the_definition_does() {
        let warp = Warp {
            origin: [Step::from_bits(i64::MAX - 5), Step::from_bits(-(7 << 30) - 1)],
            right: [Step::from_bits((3 << 31) + 1), Step::from_bits(i64::MIN)],
            down: [Step::from_bits(-12_345_678_901), Step::from_bits(0x8000)],
        };
        let mut at = warp.exact(0, 9);
        for x in 0..100 {
            assert_eq!(warp.point(x, 9), Point::at(at));
            at = [0, 1].map(|axis| at[axis].wrapping_add(warp.right[axis].to_bits()));
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2_000))]
        #[test]
        fn rows_are_the_definitions(
            short in pixels::<u16>(),
            full in pixels::<Unorm16>(),
            long in pixels::<u32>(),
            background in prop::array::uniform3(prop_oneof![Just(0u16), Just(32768), 0..=32768u16]),
        ) {
            rows_follow_the_definitions(&short, background)?;
            rows_follow_the_definitions(&full, background)?;
            rows_follow_the_definitions(&long, background)?;
        }
    }

    proptest! {
        #[test]
        fn a_mixture_lies_between_its_ends(a in 0u32..=1 << 31, b in 0u32..=1 << 31, w in 0u32..65536) {
            let m = mix(a, b, w);
            prop_assert!(m >= a.min(b) && m <= a.max(b));
            let exact = f64::from(a) + (f64::from(b) - f64::from(a)) * f64::from(w) / 65536.0;
            prop_assert!((f64::from(m) - exact).abs() <= 0.5 + 1e-6);
        }
    }
}
