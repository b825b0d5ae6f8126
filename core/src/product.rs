//! Products that lose their low bits, written the way that suits the machine.
//!
//! A machine with vectors wants 32-bit lanes throughout: a product of 28 by 16 bits is split into two of 16 by 16. A
//! small machine without them has one instruction for the upper half of a 64-bit product, or two (SMMULR, SMULL, MULH).
//! Both are exact before the one rounding, so they are the same bits; the tests hold them together.

/// Whether the machine is one without vectors, where a branch also costs less than the work that it saves.
pub(crate) const SCALAR: bool = cfg!(any(target_arch = "arm", target_arch = "riscv32"));

/// `floor((d * w + bias) / 2^16)`: |d| < 2^30, 0 <= w < 2^16, bias < 2^16.
#[inline(always)]
pub(crate) fn scale16(d: i32, w: i32, bias: u32) -> i32 {
    if SCALAR {
        upper16(d, w, bias)
    } else {
        split16(d, w, bias)
    }
}

#[inline(always)]
fn split16(d: i32, w: i32, bias: u32) -> i32 {
    let low = ((d & 0xffff) as u32 * w as u32 + bias) >> 16;
    (d >> 16) * w + low as i32
}

#[inline(always)]
fn upper16(d: i32, w: i32, bias: u32) -> i32 {
    ((i64::from(d << 1) * i64::from(w << 15) + (i64::from(bias) << 16)) >> 32) as i32
}

/// `floor((g * f + 2^14) / 2^15)`: |g| < 2^29, 0 <= f <= 2^15.
#[inline(always)]
pub(crate) const fn round15(g: i32, f: i32) -> i32 {
    if SCALAR { upper15(g, f) } else { split15(g, f) }
}

const fn split15(g: i32, f: i32) -> i32 {
    (g >> 15) * f + (((g & 0x7fff) * f + (1 << 14)) >> 15)
}

const fn upper15(g: i32, f: i32) -> i32 {
    (((g << 2) as i64 * (f << 15) as i64 + (1 << 31)) >> 32) as i32
}

/// `(a << 16) + (b - a) w`, exact: |a|, |b| < 2^14, 0 <= w < 2^16.
#[inline(always)]
pub(crate) fn between16(a: i32, b: i32, w: i32) -> i32 {
    if SCALAR {
        two_products(a, b, w)
    } else {
        one_product(a, b, w)
    }
}

#[inline(always)]
fn one_product(a: i32, b: i32, w: i32) -> i32 {
    (a << 16) + (b - a) * w
}

/// Where a product and a sum are one instruction.
#[inline(always)]
fn two_products(a: i32, b: i32, w: i32) -> i32 {
    a * ((1 << 16) - w) + b * w
}

/// `a + floor(((b - a) f + 2^(bits - 1)) / 2^bits)`: |b - a| < 2^31, 0 <= f < 2^bits, bits 1 to 15.
#[inline(always)]
pub(crate) fn mix(a: u32, b: u32, f: i32, bits: u32) -> u32 {
    if SCALAR {
        upper_mix(a, b, f, bits)
    } else {
        split_mix(a, b, f, bits)
    }
}

#[inline(always)]
fn split_mix(a: u32, b: u32, f: i32, bits: u32) -> u32 {
    let d = b.wrapping_sub(a) as i32;
    let low = ((d & 0xffff) * f + (1 << bits >> 1)) >> bits;
    a.wrapping_add(((((d >> 16) * f) << (16 - bits)) + low) as u32)
}

/// The fraction as a signed number that fills 32 bits: from one half on it counts backwards from b.
#[inline(always)]
fn upper_mix(a: u32, b: u32, f: i32, bits: u32) -> u32 {
    let f = f << (32 - bits);
    let (end, d) = (if f < 0 { b } else { a }, b.wrapping_sub(a) as i32);
    let sum = (i64::from(end as i32) << 32).wrapping_add(i64::from(d) * i64::from(f) + (1 << 31));
    (sum >> 32) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn d() -> impl Strategy<Value = i32> {
        let limit = 16380 << 16;
        prop_oneof![-limit..=limit, Just(limit), Just(-limit), -70_000..70_000]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]
        #[test]
        fn both_ways_are_the_same_bits(d in d(), w in 0i32..65536, bias in 0u32..65536) {
            let exact = (i64::from(d) * i64::from(w) + i64::from(bias)) >> 16;
            prop_assert_eq!(i64::from(split16(d, w, bias)), exact);
            prop_assert_eq!(i64::from(upper16(d, w, bias)), exact);
        }

        #[test]
        fn both_roundings_are_the_same_bits(g in -(1i32 << 29)..(1 << 29), f in 0i32..=32768) {
            let exact = (i64::from(g) * i64::from(f) + (1 << 14)) >> 15;
            prop_assert_eq!(i64::from(split15(g, f)), exact);
            prop_assert_eq!(i64::from(upper15(g, f)), exact);
        }
    }

    proptest! {
        #[test]
        fn both_mixes_are_the_same_bits(
            a in 0u32..=1 << 31, b in 0u32..=1 << 31, f in 0i32..1 << 15, bits in prop_oneof![Just(12u32), Just(15)],
        ) {
            // Two values that are 2^31 apart do not occur: no entry is quite opaque.
            let (b, f) = (b.min(a.saturating_add((1 << 31) - 1)), f & ((1 << bits) - 1));
            let a = a.min(b.saturating_add((1 << 31) - 1));
            let product = (i64::from(b) - i64::from(a)) * i64::from(f);
            let exact = i64::from(a) + ((product + (1 << bits >> 1)) >> bits);
            prop_assert_eq!(i64::from(split_mix(a, b, f, bits)), exact);
            prop_assert_eq!(i64::from(upper_mix(a, b, f, bits)), exact);
        }

        #[test]
        fn both_ways_between_are_the_same_bits(a in -8190i32..=8190, b in -8190i32..=8190, w in 0i32..65536) {
            prop_assert_eq!(one_product(a, b, w), two_products(a, b, w));
        }
    }

    #[test]
    fn the_ends_of_the_ranges_are_the_same_bits() {
        for d in [-(16380 << 16), 16380 << 16, -1, 0, 1, -65536, 65535] {
            for w in [0, 1, 32767, 32768, 65535] {
                for bias in [0, 1 << 15] {
                    assert_eq!(split16(d, w, bias), upper16(d, w, bias));
                }
            }
        }
        for g in [-(1 << 29) + 1, (1 << 29) - 1, -1, 0, 1] {
            for f in [0, 1, 32767, 32768] {
                assert_eq!(split15(g, f), upper15(g, f));
            }
        }
    }
}
