//! The reciprocal root that normalises gradients: a table, one Newton step and an exact residual, in 32-bit products.

use crate::format::ReciprocalNorm;

/// `floor(2^35 / sqrt(s))` for 2^28 <= s < 2^32; 0 for 0.
///
/// A table of 193 points, linear between them, is within 2^-15; one Newton step brings that to a unit either way; the
/// residual 2^70 - r^2 s, which fits 64 wrapping bits, decides. Checked against the definition for every s in range
/// (host-tests).
#[inline]
pub fn reciprocal_root(s: u32) -> ReciprocalNorm {
    if s == 0 {
        return 0;
    }
    // s = t / 4^q with t in 2^30 .. 2^32, so 1/sqrt(s) = 2^q / sqrt(t).
    let q = if s < 1 << 30 { 1 } else { 0 };
    let t = s << (2 * q);
    let index = ((t >> 24) as usize).saturating_sub(64);
    let at = |i: usize| SEED.get(i).copied().unwrap_or(0);
    let (a, b) = (at(index), at(index + 1));
    let fraction = t & 0x00ff_ffff;
    // y ~ 2^47 / sqrt(t): 2^31 to 2^32.
    let product = |a: u32, b: u32| u64::from(a) * u64::from(b);
    let upper = |a: u32, b: u32| (product(a, b) >> 32) as u32;
    let y = a - (product(a - b, fraction) >> 24) as u32;
    // Newton: y (3 - t y^2) / 2, with t y^2 ~ 2^94 taken in steps of 32 by 32 bits.
    let correction = (3u32 << 30).wrapping_sub(upper(upper(y, y), t));
    let r = upper(y >> 1, correction) >> (10 - q);
    // The exact answer is r - 1, r or r + 1: of 2^70 - r^2 s the low 64 bits tell.
    let square = product(r, r).wrapping_mul(u64::from(s));
    let next = square.wrapping_add(product(2 * r + 1, s));
    let negative = |residual: u64| (residual as i64) < 0;
    if negative(0u64.wrapping_sub(square)) {
        r - 1
    } else if negative(0u64.wrapping_sub(next)) {
        r
    } else {
        r + 1
    }
}

/// First guesses `floor(2^35 / sqrt(i))` for i = 64 to 256, that is 2^47 / sqrt(t) at t = i * 2^24; the first one,
/// 2^32, is kept in 32 bits as 2^32 - 1.
static SEED: [u32; 193] = seeds();

#[expect(clippy::indexing_slicing, reason = "evaluated by the compiler, never on the target")]
const fn seeds() -> [u32; 193] {
    let mut table = [0; 193];
    let mut i = 0;
    while i < 193 {
        table[i] = seed_root(i as u128 + 64);
        i += 1;
    }
    table
}

/// `min(2^32 - 1, floor(2^35 / sqrt(i)))` by bisection, at compile time.
const fn seed_root(i: u128) -> u32 {
    let (mut low, mut high) = (0u128, 1u128 << 32);
    while high - low > 1 {
        let middle = (low + high) >> 1;
        if middle * middle * i <= 1 << 70 {
            low = middle;
        } else {
            high = middle;
        }
    }
    low as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_root(s: u32, r: u32) -> bool {
        let (s, r) = (u128::from(s), u128::from(r));
        r * r * s <= 1 << 70 && (r + 1) * (r + 1) * s > 1 << 70
    }

    #[test]
    fn reciprocal_roots_of_the_study() {
        assert_eq!(reciprocal_root(898_823_412), 1_146_073);
        assert_eq!(reciprocal_root(1 << 28), 1 << 21);
        assert_eq!(reciprocal_root(3_221_028_867), 605_414);
        assert_eq!(reciprocal_root(0), 0);
    }

    #[test]
    fn reciprocal_root_is_exact_on_a_stride_and_at_the_ends() {
        let ends = [
            1u32 << 28,
            (1 << 28) + 1,
            (1 << 30) - 1,
            1 << 30,
            3_221_028_867,
            3_221_028_866,
        ];
        for s in ends.into_iter().chain((1 << 28..=3_221_028_867).step_by(977)) {
            assert!(is_root(s, reciprocal_root(s)), "{s}");
        }
    }
}
