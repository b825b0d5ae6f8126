//! The binary power of a negative number: what is left of light behind an optical depth.
//!
//! | value | format | range |
//! |---|---|---|
//! | y | u8.24 | 0 to 2^29 - 1 |
//! | 2^-y | 1.31 | 0 to 2^31 |
//!
//! `2^-y = 2^-f >> n` with n the whole part of y and f its fraction; `2^-f = 1 - f (c1 - f (c2 - ... f c6))`, coefficients and
//! products u0.32, truncated, the last product to nearest. The polynomial is the one through both ends, 1 and 1/2, that
//! interpolates 2^-f at Chebyshev nodes (its error: 4.2 ulp of 1.31). Six products and no table: a gather costs a vector as
//! much as all of them, and firmware keeps its flash.
//!
//! Rounding: truncated. Error: at most [`ERROR`] ulp of 1.31 for n = 0, and half of that and one ulp for each further n
//! (exhaustive over all fractions). Exactly 1 at y = 0; never rises with y. Overflow: none. State: none.

use crate::lanes::Lanes;

/// The largest error for y < 1, ulp of 1.31.
pub const ERROR: f64 = 5.5;

/// The largest y, u8.24: from there on nothing is left.
pub const LIMIT: u32 = (1 << 29) - 1;

/// c6 to c1, u0.32.
const COEFFICIENTS: [u32; 6] = [
    0x0007_2a6e,
    0x0053_9ad9,
    0x0273_d9b2,
    0x0e34_acf0,
    0x3d7f_59c2,
    0xb172_1619,
];

/// `1 - 2^-y`, 1.31: the opacity of an optical depth of y ln 2. y at most [`LIMIT`]. This function is the definition.
#[inline(always)]
pub fn absorbed<V: Lanes>(y: V) -> V {
    let f = (y & V::splat(0x00ff_ffff)) << 7;
    let [first, rest @ ..] = COEFFICIENTS;
    let mut sum = V::splat(first as i32);
    for c in rest {
        sum = V::splat(c as i32).wrapping_sub(sum.product31(f));
    }
    let one = V::splat(i32::MIN);
    let taken = sum.product31(f).wrapping_add(V::splat(1)).shr_unsigned(1);
    one.wrapping_sub(one.wrapping_sub(taken).shr_each(y.shr_unsigned(24)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Small;

    fn left(y: u32) -> u32 {
        (1 << 31) - absorbed(y as i32) as u32
    }

    /// Every fraction: the stated error, and never a rise.
    #[test]
    fn every_fraction_is_as_near_as_stated() {
        let (mut worst, mut last): (f64, u32) = (0.0, 1 << 31);
        for f in 0..=1u32 << 24 {
            let found = left(f);
            let exact = (31.0 - f64::from(f) / 16_777_216.0).exp2();
            worst = worst.max((f64::from(found) - exact).abs());
            assert!(found <= last, "{f}");
            last = found;
        }
        assert!(worst <= ERROR, "{worst}");
        assert!(worst > 0.9 * ERROR, "stale: {worst}");
    }

    #[test]
    fn whole_parts_halve() {
        assert_eq!((left(0), left(1 << 24), left(LIMIT)), (1 << 31, 1 << 30, 0));
        for n in 0..32u32 {
            assert_eq!(left(n << 24), (1u32 << 31) >> n);
            for f in [1u32, 0x800000, 0xffffff] {
                assert_eq!(left(n << 24 | f), left(f) >> n);
            }
        }
    }

    #[test]
    fn a_small_machine_has_the_same_bits() {
        for y in (0..1u32 << 29).step_by(4_099) {
            let mut out = [0];
            absorbed(Small::splat(y as i32)).store(&mut out, 0);
            assert_eq!(out, [absorbed(y as i32)]);
        }
    }
}
