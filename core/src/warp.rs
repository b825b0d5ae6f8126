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
//! A mixture is two roundings to nearest, along u and then along v: `a + ((b - a) w + 2^15) >> 16`, in 64 bits. It lies
//! between its corners. Error: 1 ulp of the channel. State: none.

use crate::composite::{Channel, Pixel, to_byte};
use crate::format::{Intensity, Step};

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

impl Warp {
    /// Where a picture pixel looks. Wraps beyond 2^31 pixels.
    #[inline]
    pub fn point(&self, x: u32, y: u32) -> Point {
        let mut point = Point {
            pixel: [0; 2],
            weight: [0; 2],
        };
        let axes = self.origin.iter().zip(self.right).zip(self.down);
        for (((o, r), d), (p, w)) in axes.zip(point.pixel.iter_mut().zip(&mut point.weight)) {
            let exact = o
                .to_bits()
                .wrapping_add(r.to_bits().wrapping_mul(i64::from(x)))
                .wrapping_add(d.to_bits().wrapping_mul(i64::from(y)));
            let rounded = exact.wrapping_add(1 << 15) >> 16;
            *p = rounded >> 16;
            *w = (rounded & 0xffff) as u32;
        }
        point
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
pub fn in_front_of<C: Channel>(pixel: Pixel<C>, background: [Intensity; 3]) -> [u8; 3] {
    let mut out = [0; 3];
    for ((o, c), k) in out.iter_mut().zip(pixel.colour).zip(background) {
        let behind = (u64::from(pixel.transparency.bits()) * u64::from(k.to_bits()) + (1 << 14)) >> 15;
        let sum = (u64::from(c.bits()) + behind).min(u64::from(C::ONE.bits()));
        *o = to_byte(C::from_bits(sum as u32));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
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
                Pixel::clear()
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
        assert_eq!(in_front_of(Pixel::<u16>::clear(), [Intensity::ONE; 3]), [255; 3]);
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
