//! The reciprocal of a number of 27 bits.
//!
//! `R = floor(2^52 / D)` for 2^26 <= D < 2^27: 2^25 < R <= 2^26, and its relative error is below 2^-25. R is a mathematical
//! definition; each kind of lane finds it in its own way ([`Lanes::reciprocal`](crate::lanes::Lanes::reciprocal)):
//!
//! | lanes | way | why it is exact |
//! |---|---|---|
//! | one | a division of 64 bits | by definition |
//! | vectors | a division of doubles, truncated | a quotient of 2^26 at most lies at least 1/D > 2^-27 below the next whole number, and half an ulp is 2^-28 |
//! | a small machine | a division of 32 bits, one step of Newton's method, a test of the product | exhaustive |
//!
//! Rounding: floor. Overflow: none. State: none.

/// Numbers that have a reciprocal.
pub const DOMAIN: core::ops::Range<u32> = 1 << 26..1 << 27;

/// `floor(2^52 / d)`; d in [`DOMAIN`]. This function is the definition.
#[inline(always)]
pub const fn reciprocal(d: u32) -> u32 {
    match (1u64 << 52).checked_div(d as u64) {
        Some(quotient) => quotient as u32,
        None => 0,
    }
}

/// The same where 64 bits cannot be divided by an instruction: the upper 16 bits of `d`, and one, are divided by, whose quotient
/// is too small by 2^-14; squared that is a quarter of a unit. With what is truncated, upwards, the step finds R or R + 1, which
/// the product with `d`, modulo 2^32, tells.
#[inline(always)]
pub const fn reciprocal_small(d: u32) -> u32 {
    let estimate = match u32::MAX.checked_div((d >> 11) + 1) {
        Some(quotient) => quotient << 9,
        None => 0,
    };
    // 2^52 - estimate d, negative: of its 39 bits the upper 27.
    let wrong = ((estimate as u64 * d as u64) >> 12) as i32;
    let found = estimate.wrapping_sub(((estimate as i32 as i64 * wrong as i64) >> 40) as u32);
    // 2^52 is 0 modulo 2^32.
    if found.wrapping_mul(d) as i32 > 0 {
        found - 1
    } else {
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All 67,108,864 numbers.
    #[test]
    fn the_small_way_is_exact_for_every_number() {
        for d in DOMAIN {
            let found = reciprocal_small(d);
            // The definition, without its division.
            let product = u64::from(found) * u64::from(d);
            assert!(product <= 1 << 52 && product + u64::from(d) > 1 << 52, "{d}: {found}");
        }
    }

    #[test]
    fn hard_numbers() {
        for (d, r) in [
            (67_108_864, 67_108_864),
            (67_108_865, 67_108_863),
            (89_478_485, 50_331_648),
            (100_000_000, 45_035_996),
            (123_456_789, 36_479_157),
            (134_217_727, 33_554_432),
        ] {
            assert_eq!((reciprocal(d), reciprocal_small(d)), (r, r));
        }
    }
}
