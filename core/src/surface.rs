//! Isosurfaces: which of them a segment crosses, in which order and where.
//!
//! Source: Engel, Kraus, Ertl, "High-Quality Pre-Integrated Volume Rendering Using Hardware-Accelerated Pixel Shading"
//! (2001), section 5: a surface lies in a segment whose samples lie on both sides of its value. The paper's rule takes in both
//! ends, so that a sample on the surface is met twice, which it mends with a stencil test for one surface; here a sample is
//! inside if it is at least the value, and a segment crosses where that changes. No crossing is lost or met twice, of any
//! number of surfaces.
//!
//! | value | format | range |
//! |---|---|---|
//! | value of a surface | 16.16, a data code | 0 to 4096 |
//! | threshold, in a sample's format | 12.F, value rounded up: `s >= value` just if `s >= threshold` | |
//! | rank of a sample: thresholds that it reaches | | 0 to the number of surfaces |
//! | position of a crossing | 1.16, 0 at the front sample, 1 at the back one | 0 to 65536 |
//! | colour, opacity of a face | 1.31 | 0 to 1 |
//!
//! ```text
//! rising,  rank_b > rank_f:  crossings rank_f, ..., rank_b - 1, ascending, of front faces     s_f <  threshold <= s_b
//! falling, rank_b < rank_f:  crossings rank_f - 1, ..., rank_b, descending, of back faces     s_b <  threshold <= s_f
//! position = floor(2^16 |threshold - s_f| / |s_b - s_f|)
//! G        = G_f + ((G_b - G_f) position + 2^15 >> 16), negated for a back face
//! ```
//!
//! Position: the numerator, shifted by k as the difference is, times `reciprocal`, is the quotient or one less than it;
//! the remainder modulo 2^32 tells. Rounding: position to below, G to nearest. Error: of the position 2^-16 of a segment. Overflow: none (the
//! difference of two gradients is below 2^29). State: none.

use crate::format::Opacity;
use crate::lanes::Lanes;
use crate::precision::Precision;

/// The largest value of a surface, 16.16: no sample reaches it.
pub const VALUE_MAX: u32 = 4096 << 16;

/// One side of a surface.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Face {
    /// Red, green, blue, 1.31, not weighted by the opacity.
    pub colour: [u32; 3],
    /// The part of the light that it keeps back, whatever the step.
    pub opacity: Opacity,
}

/// An isosurface.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Surface {
    /// Its value, 16.16.
    pub value: u32,
    /// What a ray meets on which the field rises: the side of lower values.
    pub front: Face,
    /// What a ray meets on which the field falls.
    pub back: Face,
}

impl Surface {
    /// The first code that reaches the value.
    pub(crate) const fn next_code(&self) -> usize {
        (self.value as usize).div_ceil(1 << 16)
    }
}

/// Why surfaces are refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SurfaceError {
    /// A value below that of the surface before it.
    Order {
        /// Number of the surface.
        index: usize,
    },
    /// A value above [`VALUE_MAX`].
    Value {
        /// Number of the surface.
        index: usize,
        /// As given.
        value: u32,
    },
    /// A colour or opacity above 1.
    Face {
        /// Number of the surface.
        index: usize,
        /// As given.
        bits: u32,
    },
}

impl core::fmt::Display for SurfaceError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Order { index } => write!(
                f,
                "surface {index} has a lower value than the one before it; values ascend"
            ),
            Self::Value { index, value } => write!(
                f,
                "surface {index} has the value {value}/2^16; accepted: 0 to {VALUE_MAX}/2^16"
            ),
            Self::Face { index, bits } => write!(
                f,
                "surface {index} has a colour or an opacity of {bits}/2^31; accepted: at most 2^31"
            ),
        }
    }
}

impl core::error::Error for SurfaceError {}

/// Checks a list of surfaces.
///
/// # Errors
/// [`SurfaceError`] names the first that cannot be drawn.
pub fn check(surfaces: &[Surface]) -> Result<(), SurfaceError> {
    let mut last = 0;
    for (index, surface) in surfaces.iter().enumerate() {
        let Surface { value, front, back } = *surface;
        if value > VALUE_MAX {
            return Err(SurfaceError::Value { index, value });
        }
        if value < last {
            return Err(SurfaceError::Order { index });
        }
        last = value;
        for face in [front, back] {
            for bits in face.colour.into_iter().chain([face.opacity.to_bits()]) {
                if bits > Opacity::ONE.to_bits() {
                    return Err(SurfaceError::Face { index, bits });
                }
            }
        }
    }
    Ok(())
}

/// A surface's value in the format of a precision's samples, to above.
#[inline(always)]
pub fn threshold<P: Precision>(p: P, surface: &Surface) -> i32 {
    let cut = 16u32.saturating_sub(p.formats().sample_bits);
    (surface.value.saturating_add((1 << cut) - 1) >> cut) as i32
}

/// How many thresholds samples reach.
#[inline(always)]
pub fn ranks<P: Precision, V: Lanes>(p: P, surfaces: &[Surface], samples: V) -> V {
    let mut rank = V::splat(0);
    for surface in surfaces {
        rank = rank + samples.at_least_then(V::splat(threshold(p, surface)), V::splat(1));
    }
    rank
}

/// The surfaces that a segment crosses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crossings {
    /// Ranks of the front and the back sample.
    ranks: [u32; 2],
}

impl Crossings {
    /// Those between two samples.
    #[inline(always)]
    pub fn between<P: Precision>(p: P, surfaces: &[Surface], ends: [i32; 2]) -> Self {
        Self {
            ranks: ends.map(|sample| ranks::<P, i32>(p, surfaces, sample) as u32),
        }
    }

    /// How many they are.
    #[inline(always)]
    pub const fn count(self) -> u32 {
        let [front, back] = self.ranks;
        front.abs_diff(back)
    }

    /// Whether they show their back faces.
    #[inline(always)]
    pub const fn falling(self) -> bool {
        let [front, back] = self.ranks;
        back < front
    }

    /// Number of the surface that is met after so many.
    #[inline(always)]
    pub const fn surface(self, met: u32) -> Option<usize> {
        let [front, _] = self.ranks;
        if met >= self.count() {
            return None;
        }
        let index = if self.falling() {
            front.wrapping_sub(met).wrapping_sub(1)
        } else {
            front.wrapping_add(met)
        };
        Some(index as usize)
    }
}

/// Where between two samples a value is taken, 1.16: the samples differ, and the value does not lie outside.
#[inline(always)]
pub fn position<V: Lanes>([front, back]: [i32; 2], value: i32) -> u32 {
    let (part, whole) = (value.abs_diff(front), back.abs_diff(front));
    let k = whole.leading_zeros().wrapping_sub(5);
    let mut reciprocal = [0];
    V::splat((whole << k) as i32).reciprocal().store(&mut reciprocal, 0);
    let [reciprocal] = reciprocal;
    let quotient = ((u64::from(part) << k).wrapping_mul(u64::from(reciprocal as u32)) >> 36) as u32;
    let rest = (part << 16).wrapping_sub(quotient.wrapping_mul(whole));
    quotient.wrapping_add(u32::from(rest >= whole))
}

/// Where between the gradients of a segment's ends that of a crossing lies, and whether it is turned around.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Turn(i32);

impl Turn {
    /// That of a crossing's position.
    #[inline(always)]
    pub const fn at(position: u32, back_face: bool) -> Self {
        let position = position as i32;
        Self(if back_face { !position } else { position })
    }

    /// From the bits of a row.
    #[inline(always)]
    pub const fn from_bits(bits: i32) -> Self {
        Self(bits)
    }

    /// The position, or its complement for a back face.
    #[inline(always)]
    pub const fn to_bits(self) -> i32 {
        self.0
    }

    /// The turn of the same face at another position.
    #[must_use]
    pub(crate) fn moved(self, place: impl FnOnce(u32) -> u32) -> Self {
        let back_face = self.0 < 0;
        let position = if back_face { !self.0 } else { self.0 };
        Self::at(place(position as u32), back_face)
    }

    /// A component of the crossing's gradient, of those of the segment's ends.
    #[inline(always)]
    pub fn gradient(self, front: i32, back: i32) -> i32 {
        turned(front, back, self.0)
    }
}

/// [`Turn::gradient`] of lanes.
#[inline(always)]
pub fn turned<V: Lanes>(front: V, back: V, turn: V) -> V {
    let (position, d) = (turn ^ (turn >> 31), back - front);
    // The low product is at most 65535 * 65536 and a half.
    let low = (d & V::splat(0xffff))
        .wrapping_mul(position)
        .wrapping_add(V::splat(1 << 15));
    (front + ((d >> 16) * position + low.shr_unsigned(16))).with_sign_of(turn)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Small;
    use crate::precision::{Compact, Wide};
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;
    use std::vec::Vec;

    const NONE: Face = Face {
        colour: [0; 3],
        opacity: Opacity::ZERO,
    };

    fn surfaces(codes: &[f64]) -> Vec<Surface> {
        let surface = |code: &f64| Surface {
            value: (code * 65536.0) as u32,
            front: NONE,
            back: NONE,
        };
        codes.iter().map(surface).collect()
    }

    /// Number, side and position of every crossing of a segment.
    fn met(codes: &[f64], ends: [f64; 2]) -> Vec<(usize, bool, u32)> {
        let (list, ends) = (surfaces(codes), ends.map(|end| (end * 32768.0) as i32));
        let crossings = Crossings::between(Wide, &list, ends);
        (0..crossings.count())
            .map(|n| {
                let number = crossings.surface(n).unwrap();
                let value = threshold(Wide, &list[number]);
                assert_eq!(position::<i32>(ends, value), position::<Small>(ends, value));
                (number, crossings.falling(), position::<i32>(ends, value))
            })
            .collect()
    }

    /// The study's hard cases, by their raw answers.
    #[test]
    fn hard_cases() {
        let (front, back) = (false, true);
        assert_eq!(met(&[1234.0], [1200.0, 1300.0]), [(0, front, 22282)]);
        assert_eq!(met(&[2800.0], [2800.0, 2700.0]), [(0, back, 0)]);
        assert_eq!(met(&[2800.0], [2900.0, 2800.0]), []);
        assert_eq!(met(&[1200.0], [1100.0, 1200.0]), [(0, front, 65536)]);
        assert_eq!(met(&[1200.0], [1200.0, 1300.0]), []);
        assert_eq!(met(&[50.0], [45.0, 58.0]), [(0, front, 25206)]);
        assert_eq!(met(&[20.0], [10.0, 20.0]), [(0, front, 65536)]);
        assert_eq!(met(&[20.0], [20.0, 20.0]), []);
        assert_eq!(met(&[20.0], [20.0, 10.0]), [(0, back, 0)]);
        let three = [15.0, 17.0, 19.0];
        assert_eq!(
            met(&three, [10.0, 20.0]),
            [(0, front, 32768), (1, front, 45875), (2, front, 58982)]
        );
        assert_eq!(
            met(&three, [20.0, 10.0]),
            [(2, back, 6553), (1, back, 19660), (0, back, 32768)]
        );
        // Equal values are both met, in the order of the list and against it.
        assert_eq!(met(&[5.0, 5.0], [0.0, 10.0]), [(0, front, 32768), (1, front, 32768)]);
        assert_eq!(met(&[5.0, 5.0], [10.0, 0.0]), [(1, back, 32768), (0, back, 32768)]);
        // The ends of the range: every sample reaches 0, and 4095 is reached by the largest alone.
        assert_eq!(met(&[0.0], [0.0, 4095.0]), []);
        assert_eq!(met(&[4095.0], [0.0, 4095.0]), [(0, front, 65536)]);
        assert_eq!(met(&[4096.0], [0.0, 4095.0]), []);
    }

    /// All values and pairs of samples of six bits and of rays of three: crossings are the changes of one predicate, so that
    /// entries and exits alternate and none is lost or met twice.
    #[test]
    fn every_crossing_is_met_once() {
        for value in 0..64 {
            let list = surfaces(&[f64::from(value)]);
            for first in 0..64i32 {
                for second in 0..64i32 {
                    let inside = |sample: i32| sample >= value;
                    let found = Crossings::between(Compact, &list, [first << 12, second << 12]);
                    assert_eq!(found.count(), u32::from(inside(first) != inside(second)));
                    if found.count() > 0 {
                        assert_eq!(found.falling(), inside(first));
                        assert_eq!(found.surface(0), Some(0));
                    }
                    assert_eq!(found.surface(found.count()), None);
                }
            }
        }
    }

    /// All pairs up to a thousand, and the farthest apart.
    #[test]
    fn positions_are_the_quotient() {
        for whole in 1..1000i32 {
            for part in 0..=whole {
                let expected = (part as u64 * 65536 / whole as u64) as u32;
                assert_eq!(position::<i32>([0, whole], part), expected);
                assert_eq!(position::<Small>([whole, 0], whole - part), expected);
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 20_000, rng_seed: RngSeed::Fixed(16), failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn positions_of_all_widths_are_the_quotient(ends in prop::array::uniform2(0i32..=4095 << 15), share in 0.0..=1.0f64) {
            prop_assume!(ends[0] != ends[1]);
            let value = ends[0] + (f64::from(ends[1] - ends[0]) * share) as i32;
            let (part, whole) = (u64::from(value.abs_diff(ends[0])), u64::from(ends[1].abs_diff(ends[0])));
            let expected = (part * 65536 / whole) as u32;
            prop_assert_eq!(position::<i32>(ends, value), expected);
            prop_assert_eq!(position::<Small>(ends, value), expected);
        }

        /// Thresholds of all precisions mean the value itself.
        #[test]
        fn a_threshold_is_reached_with_its_value(value in 0..=VALUE_MAX, sample in 0i32..=4095 << 15) {
            let surface = Surface { value, front: NONE, back: NONE };
            prop_assert_eq!(sample >= threshold(Wide, &surface), 2 * i64::from(sample) >= i64::from(value));
            let sample = sample >> 3;
            prop_assert_eq!(sample >= threshold(Compact, &surface), 16 * i64::from(sample) >= i64::from(value));
        }

        /// The gradient is the nearest to the straight line between both, and exactly the back one at its end.
        #[test]
        fn gradients_lie_between_those_of_the_ends(front in -(1i32 << 28)..1 << 28, back in -(1i32 << 28)..1 << 28, position in 0u32..=65536) {
            let exact = i64::from(front) + (((i64::from(back) - i64::from(front)) * i64::from(position) + (1 << 15)) >> 16);
            prop_assert_eq!(i64::from(Turn::at(position, false).gradient(front, back)), exact);
            prop_assert_eq!(i64::from(Turn::at(position, true).gradient(front, back)), -exact);
            prop_assert_eq!(turned(Small::splat(front), Small::splat(back), Small::splat(position as i32)).store_one(), exact as i32);
            prop_assert_eq!(Turn::at(65536, false).gradient(front, back), back);
        }
    }

    trait StoreOne {
        fn store_one(self) -> i32;
    }

    impl<V: Lanes> StoreOne for V {
        fn store_one(self) -> i32 {
            let mut out = [0];
            self.store(&mut out, 0);
            out[0]
        }
    }

    #[test]
    fn lists_that_cannot_be_drawn_are_refused() {
        assert_eq!(check(&surfaces(&[1.0, 1.0, 4096.0])), Ok(()));
        assert_eq!(check(&surfaces(&[2.0, 1.0])), Err(SurfaceError::Order { index: 1 }));
        let mut list = surfaces(&[1.0, 2.0]);
        list[1].value = VALUE_MAX + 1;
        assert_eq!(
            check(&list),
            Err(SurfaceError::Value {
                index: 1,
                value: VALUE_MAX + 1
            })
        );
        let mut list = surfaces(&[1.0]);
        list[0].back.colour[2] = (1 << 31) + 1;
        assert_eq!(
            check(&list),
            Err(SurfaceError::Face {
                index: 0,
                bits: (1 << 31) + 1
            })
        );
    }
}
