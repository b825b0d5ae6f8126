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

/// `floor((d * f + 2^(bits - 1)) / 2^bits)`: 0 <= f < 2^bits, bits 1 to 15.
#[inline(always)]
pub(crate) fn part(d: i32, f: i32, bits: u32) -> i32 {
    if SCALAR {
        whole_part(d, f, bits)
    } else {
        split_part(d, f, bits)
    }
}

#[inline(always)]
fn split_part(d: i32, f: i32, bits: u32) -> i32 {
    let low = ((d & 0xffff) * f + (1 << bits >> 1)) >> bits;
    (((d >> 16) * f) << (16 - bits)) + low
}

#[inline(always)]
fn whole_part(d: i32, f: i32, bits: u32) -> i32 {
    ((i64::from(d) * i64::from(f) + (1 << bits >> 1)) >> bits) as i32
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
        fn both_parts_are_the_same_bits(d in any::<i32>(), f in 0i32..1 << 15, bits in prop_oneof![Just(12u32), Just(15)]) {
            let f = f & ((1 << bits) - 1);
            prop_assert_eq!(split_part(d, f, bits), whole_part(d, f, bits));
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
