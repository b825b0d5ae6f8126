//! Projections: of all samples of a ray, one value is shown: the largest (MIP), the smallest, their mean, or their sum.
//!
//! The pixel holds it, or the sums that it is made of, until the last plane; then it is classified once, by a table whose opacities
//! are as written (no step correction), and becomes a pixel like any other.
//!
//! | value | format | range |
//! |---|---|---|
//! | sample s, and the value shown | 12.F | 0 to 4095 |
//! | what of its segment counts, f | 0.16 | 0 to 1 |
//! | sum of s f | 12 + 15 bits before, F + 16 behind the point, in two words of 27 and 32 bits | below 2^59 units |
//! | sum of f | 16.16 | at most 2^31 + 2^16 |
//! | step of an additive projection | 32 bits and a shift | above 0, below 1 |
//!
//! Rounding: none in the sums, which are exact; the value shown is to nearest, halves up. Overflow: none up to
//! [`PLANES_MAX`](crate::plan::PLANES_MAX) planes and one. State: the pixel.

use core::fmt::Debug;

use crate::borders::WHOLE;
use crate::classify::Classifier;
use crate::composite::{Dither, Pixel, Recurrence};
use crate::lanes::{Lanes, Wide as _, places};
use crate::precision::Precision;

/// What a ray keeps of its samples, and which value it shows at the end.
pub trait Projection: Copy + Debug + Send + Sync + 'static {
    /// Words that a ray keeps, at most 3: as many runs of a row.
    const WORDS: usize;
    /// What each of them is on a ray that has met nothing.
    const EMPTY: i32;

    /// Folds one sample into each ray of a span, of which this share of a step counts, 0.16. Rows of equal length; those beyond
    /// [`Projection::WORDS`] are empty.
    fn fold_row<V: Lanes>(words: [&mut [i32]; 3], samples: &[i32], share: u32);

    /// The same of samples that stand for steps of these lengths each, 3.20 ([`share_of_length`]). Rows of equal length.
    fn fold_steps_row<V: Lanes>(words: [&mut [i32]; 3], samples: &[i32], lengths: &[i32]);

    /// The value that a ray shows, in the bits of a sample; `None` if it has met nothing.
    fn shown<P: Precision>(self, p: P, words: [i32; 3]) -> Option<i32>;
}

/// Which sample of a ray is kept.
pub trait Extreme: Copy + Debug + Send + Sync + 'static {
    /// What a ray that has met nothing holds; no sample has these bits.
    const EMPTY: i32;
    /// The samples to keep, of the bits of two each.
    fn keep<V: Lanes>(a: V, b: V) -> V;
}

/// The largest sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Maximum;

/// The smallest sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Minimum;

impl Extreme for Maximum {
    const EMPTY: i32 = -1;
    #[inline(always)]
    fn keep<V: Lanes>(a: V, b: V) -> V {
        a.at_least(b)
    }
}

impl Extreme for Minimum {
    const EMPTY: i32 = i32::MAX;
    #[inline(always)]
    fn keep<V: Lanes>(a: V, b: V) -> V {
        a.at_most(b)
    }
}

/// A sample counts as one, however little of its segment does.
impl<X: Extreme> Projection for X {
    const WORDS: usize = 1;
    const EMPTY: i32 = X::EMPTY;

    #[inline(always)]
    fn fold_row<V: Lanes>([kept, ..]: [&mut [i32]; 3], samples: &[i32], _: u32) {
        keep_row::<X, V>(kept, samples);
    }

    #[inline(always)]
    fn fold_steps_row<V: Lanes>([kept, ..]: [&mut [i32]; 3], samples: &[i32], _: &[i32]) {
        keep_row::<X, V>(kept, samples);
    }

    #[inline(always)]
    fn shown<P: Precision>(self, _: P, [kept, ..]: [i32; 3]) -> Option<i32> {
        (kept != X::EMPTY).then_some(kept)
    }
}

/// Folds one sample into each pixel of a row. Both rows equally long.
#[inline(always)]
pub fn keep_row<X: Extreme, V: Lanes>(row: &mut [i32], samples: &[i32]) {
    let len = row.len();
    let Some(samples) = samples.get(..len) else { return };
    for at in places::<V>(len) {
        X::keep(V::load(row, at), V::load(samples, at)).store(row, at);
    }
}

/// The sum of a ray's samples, and what is made of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sum {
    /// The mean of the ray: the sum over the number of its samples, of which each counts by its share of a step.
    Average,
    /// The mean over one length for all rays, so that a ray shows more the more it crosses.
    Additive {
        /// A step as a share of that length, in units of 2^-(32 + shift). From where the sum reaches 4095, that is shown.
        step: u32,
        /// What small shares are raised by, at most [`SHIFT_MAX`].
        shift: u32,
    },
}

/// The largest shift of an additive projection's step.
pub const SHIFT_MAX: u32 = 42;

/// What counts of a step of a length, 3.20, that a ray from an eye has: an eighth of it, 0.16, to nearest, halves up. Lengths are below
/// 8, so that it is at most [`WHOLE`]. This function is the definition.
#[inline]
pub const fn share_of_length(length: i32) -> u32 {
    (length as u32 + 64) >> 7
}

/// Bits of the lower word of a sum.
const LOW: u32 = 27;

/// The lower word's bits.
const LOWEST: i32 = (1 << LOW) - 1;

impl Sum {
    /// The words of a ray after one more sample s of which a share f counts: the sum of s f, above and below its bit 27, and the sum
    /// of f. This function is the definition.
    ///
    /// Range: s at most 4095 * 2^15, f at most [`WHOLE`], at most 2^15 + 1 samples.
    #[inline]
    pub const fn add([high, low, length]: [i32; 3], sample: i32, share: u32) -> [i32; 3] {
        let sum = (high as u32 as u64) << LOW | low as u64;
        let sum = sum.wrapping_add(sample as u64 * share as u64);
        [
            (sum >> LOW) as i32,
            sum as i32 & LOWEST,
            length.wrapping_add(share as i32),
        ]
    }
}

impl Sum {
    /// [`Sum::add`] along a row of samples of at most 15 bits, whose products have 31.
    #[inline(always)]
    pub(crate) fn fold_short_row<V: Lanes>([high, low, length]: [&mut [i32]; 3], samples: &[u16], share: u32) {
        let len = samples.len();
        let (Some(high), Some(low), Some(length)) = (high.get_mut(..len), low.get_mut(..len), length.get_mut(..len))
        else {
            return;
        };
        let (lowest, whole) = (V::splat(LOWEST), share >= WHOLE);
        for at in places::<V>(len) {
            let sample = V::load_voxels(samples, at);
            let [above, below] = if whole {
                [sample.shr_unsigned(LOW - 16), (sample << 16) & lowest]
            } else {
                let product = sample * V::splat(share as i32);
                [product.shr_unsigned(LOW), product & lowest]
            };
            add_words([high, low, length], at, [above, below], V::splat(share as i32));
        }
    }
}

/// Adds the words of a sample's product, and its share, to those of rays. Both lower words are below 2^27, their sum below 2^28.
#[inline(always)]
fn add_words<V: Lanes>([high, low, length]: [&mut [i32]; 3], at: usize, [above, below]: [V; 2], share: V) {
    let sum = V::load(low, at) + below;
    let carried = above + sum.shr_unsigned(LOW);
    (sum & V::splat(LOWEST)).store(low, at);
    V::load(high, at).wrapping_add(carried).store(high, at);
    V::load(length, at).wrapping_add(share).store(length, at);
}

impl Projection for Sum {
    const WORDS: usize = 3;
    const EMPTY: i32 = 0;

    /// [`Sum::add`] along a row.
    #[inline(always)]
    fn fold_row<V: Lanes>([high, low, length]: [&mut [i32]; 3], samples: &[i32], share: u32) {
        let len = samples.len();
        let (Some(high), Some(low), Some(length)) = (high.get_mut(..len), low.get_mut(..len), length.get_mut(..len))
        else {
            return;
        };
        let (lowest, whole) = (V::splat(LOWEST), share >= WHOLE);
        for at in places::<V>(len) {
            let sample = V::load(samples, at);
            let [above, below] = if whole {
                // A product with 2^16 is a shift.
                [sample.shr_unsigned(LOW - 16), (sample << 16) & lowest]
            } else {
                let product = sample.product(V::splat(share as i32));
                [product.shr_narrow(LOW), product.narrow() & lowest]
            };
            add_words([high, low, length], at, [above, below], V::splat(share as i32));
        }
    }

    /// [`Sum::add`] along a row, of the shares of lengths.
    #[inline(always)]
    fn fold_steps_row<V: Lanes>([high, low, length]: [&mut [i32]; 3], samples: &[i32], lengths: &[i32]) {
        let len = samples.len();
        let (Some(high), Some(low), Some(length)) = (high.get_mut(..len), low.get_mut(..len), length.get_mut(..len))
        else {
            return;
        };
        let lowest = V::splat(LOWEST);
        for at in places::<V>(len) {
            let share = (V::load(lengths, at) + V::splat(64)).shr_unsigned(7);
            let product = V::load(samples, at).product(share);
            let words = [product.shr_narrow(LOW), product.narrow() & lowest];
            add_words([high, low, length], at, words, share);
        }
    }

    #[inline]
    fn shown<P: Precision>(self, p: P, words: [i32; 3]) -> Option<i32> {
        let [high, low, length] = words.map(|word| u64::from(word as u32));
        if length == 0 {
            return None;
        }
        let value = match self {
            // Below 2^60. No mean is above the largest sample.
            Self::Average => ((high << LOW) + low + (length >> 1)).checked_div(length)?,
            // The sum times the step, over 2^(48 + shift); the product's lower part counts by what it carries. Below 2^64: the upper word is
            // at most 2^31 + 2^16, and half a unit at most 2^62.
            Self::Additive { step, shift } => {
                let (step, shift) = (u64::from(step), shift.min(SHIFT_MAX) + 48 - LOW);
                let product = high * step + ((low * step) >> LOW);
                (product >> shift) + (product >> (shift - 1) & 1)
            }
        };
        Some(value.min(4095 << p.formats().sample_bits) as i32)
    }
}

/// The picture's pixel of a kept sample.
#[inline]
pub fn resolve<P: Precision, X: Extreme>(
    p: P,
    kept: i32,
    classifier: &impl Classifier<P>,
) -> Pixel<<P::Pixel as Recurrence>::Channel> {
    pixel(p, (kept != X::EMPTY).then_some(kept), classifier)
}

/// The picture's pixel of a value that is shown, in the bits of a sample.
#[inline]
pub fn pixel<P: Precision>(
    p: P,
    shown: Option<i32>,
    classifier: &impl Classifier<P>,
) -> Pixel<<P::Pixel as Recurrence>::Channel> {
    let clear = p.pixel().clear();
    let Some(sample) = shown else { return clear };
    let none = Dither {
        transparency: 0,
        colour: 0,
    };
    p.pixel()
        .over(clear, classifier.colour(p, sample), classifier.opacity(p, sample), none)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::PLANES_MAX;
    use crate::precision::{Compact, Wide};
    use proptest::prelude::*;

    /// The exact sums of a list of samples and shares.
    fn exact(samples: &[(i32, u32)]) -> (u128, u128) {
        let sum = samples.iter().map(|(s, f)| *s as u128 * u128::from(*f)).sum();
        (sum, samples.iter().map(|(_, f)| u128::from(*f)).sum())
    }

    fn words(samples: &[(i32, u32)]) -> [i32; 3] {
        samples.iter().fold([0; 3], |words, (s, f)| Sum::add(words, *s, *f))
    }

    #[test]
    fn the_longest_ray_of_the_largest_samples_fits() {
        let (sample, samples) = (4095 << 15, PLANES_MAX + 1);
        let words = (0..samples).fold([0; 3], |words, _| Sum::add(words, sample, WHOLE));
        let [high, low, length] = words.map(|word| u64::from(word as u32));
        let sum = u64::from(samples) * sample as u64 * u64::from(WHOLE);
        assert_eq!(
            ((high << 27) + low, length),
            (sum, u64::from(samples) * u64::from(WHOLE))
        );
        assert_eq!(Sum::Average.shown(Wide, words), Some(sample));
        // As long as the length that it is spread over, and a little longer.
        let additive = |step, shift| Sum::Additive { step, shift }.shown(Wide, words);
        let step = ((1u64 << 47) / u64::from(samples)) as u32;
        assert!((sample - 2..=sample).contains(&additive(step, 15).unwrap()));
        assert_eq!(additive(step + 2, 15), Some(sample));
        assert_eq!(additive(u32::MAX, 0), Some(sample));
        assert_eq!(additive(1, SHIFT_MAX), Some(0));
    }

    #[test]
    fn rays_that_have_met_nothing_show_nothing() {
        for sum in [
            Sum::Average,
            Sum::Additive {
                step: 1 << 20,
                shift: 0,
            },
        ] {
            assert_eq!(sum.shown(Compact, [0; 3]), None);
            // One that has met zeroes shows zero.
            assert_eq!(sum.shown(Compact, Sum::add([0; 3], 0, 1)), Some(0));
        }
    }

    proptest! {
        #[test]
        fn values_are_the_nearest(
            samples in prop::collection::vec((0..=4095i32 << 15, prop_oneof![Just(WHOLE), 1..=WHOLE]), 1..60),
            step in 1u32..,
            shift in 0..=SHIFT_MAX,
        ) {
            let ((sum, length), words) = (exact(&samples), words(&samples));
            prop_assert_eq!(Sum::Average.shown(Wide, words), Some(((sum + length / 2) / length) as i32));
            let additive = (sum * u128::from(step) + (1 << (47 + shift))) >> (48 + shift);
            prop_assert_eq!(Sum::Additive { step, shift }.shown(Wide, words), Some(additive.min(4095 << 15) as i32));
        }

        #[test]
        fn rows_are_the_scalar(
            rays in prop::collection::vec((any::<[u32; 2]>(), any::<i32>(), 0..=4095i32 << 15), 0..34),
            share in prop_oneof![Just(WHOLE), 1..=WHOLE],
        ) {
            let mut rows = [(); 3].map(|()| std::vec::Vec::new());
            for ([high, low], length, _) in &rays {
                rows[0].push(*high as i32);
                rows[1].push(*low as i32 & LOWEST);
                rows[2].push(*length);
            }
            let samples: std::vec::Vec<i32> = rays.iter().map(|(_, _, sample)| *sample).collect();
            let before = rows.clone();
            let [high, low, length] = &mut rows;
            Sum::fold_row::<i32>([high, low, length], &samples, share);
            for (at, sample) in samples.iter().enumerate() {
                let expected = Sum::add([0, 1, 2].map(|row| before[row][at]), *sample, share);
                prop_assert_eq!([0, 1, 2].map(|row| rows[row][at]), expected);
            }
        }

        /// From the shortest step to the longest that there is.
        #[test]
        fn rows_of_steps_are_the_scalar(
            rays in prop::collection::vec((any::<[u32; 2]>(), 0..=4095i32 << 15, 1i32 << 20..1 << 23), 0..34),
        ) {
            let mut rows = [(); 3].map(|()| std::vec::Vec::new());
            for ([high, low], ..) in &rays {
                rows[0].push(*high as i32);
                rows[1].push(*low as i32 & LOWEST);
                rows[2].push((*low ^ *high) as i32);
            }
            let samples: std::vec::Vec<i32> = rays.iter().map(|(_, sample, _)| *sample).collect();
            let lengths: std::vec::Vec<i32> = rays.iter().map(|(.., length)| *length).collect();
            let before = rows.clone();
            let [high, low, length] = &mut rows;
            Sum::fold_steps_row::<i32>([high, low, length], &samples, &lengths);
            for (at, (_, sample, length)) in rays.iter().enumerate() {
                let share = share_of_length(*length);
                prop_assert!(share <= WHOLE && (8.0 * f64::from(share) - f64::from(*length) / 16.0).abs() <= 4.0);
                let expected = Sum::add([0, 1, 2].map(|row| before[row][at]), *sample, share);
                prop_assert_eq!([0, 1, 2].map(|row| rows[row][at]), expected);
            }
        }
    }
}
