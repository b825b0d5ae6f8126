//! Projections in 16-bit lanes: the largest or smallest sample of a ray, their mean, or their sum.
//!
//! A maximum and a minimum are kept in 16 bits; sums in the words of [`project`](crate::project), of samples of 12.3.
//!
//! | kept | words | range |
//! |---|---|---|
//! | maximum | s + 1, 0 of a ray that has met nothing | 0 to 32761 |
//! | minimum | s, 65535 of a ray that has met nothing | 0 to 32760, 65535 |
//! | sum of s f, and of f | those of [`Sum::add`] | |
//!
//! Rounding: none in what is kept; the value shown is to nearest of 12.3, halves up. Overflow: none up to
//! [`PLANES_MAX`](crate::plan::PLANES_MAX) planes and one (`docs/contract/fast.md`). State: the pixel.

use core::fmt::Debug;

use crate::lanes::{Halves, Lanes, each};
use crate::precision::Fast;
use crate::project::{Maximum, Minimum, Projection, Sum};

/// What a ray keeps of its samples of 12.3, and which value it shows at the end.
pub trait FastProjection: Copy + Debug + Send + Sync + 'static {
    /// What is kept in.
    type Word: Copy + Debug + Default + Send + Sync + 'static;
    /// Words that a ray keeps, at most 3: as many runs of a row.
    const WORDS: usize;
    /// What each of them is on a ray that has met nothing.
    const EMPTY: Self::Word;

    /// Folds one sample into each ray of a span, of which this share of a step counts, 0.16, above 0. Rows of equal length; those beyond
    /// [`FastProjection::WORDS`] are empty. With one lane this is the definition.
    fn fold_row<V: Lanes>(words: [&mut [Self::Word]; 3], samples: &[u16], share: u32);

    /// The value that a ray shows, 12.3; `None` if it has met nothing.
    fn shown(self, words: [Self::Word; 3]) -> Option<u16>;
}

/// A sample counts as one, however little of its step does.
impl FastProjection for Maximum {
    type Word = u16;
    const WORDS: usize = 1;
    const EMPTY: u16 = 0;

    #[inline(always)]
    fn fold_row<V: Lanes>([kept, ..]: [&mut [u16]; 3], samples: &[u16], _: u32) {
        let Some(kept) = kept.get_mut(..samples.len()) else {
            return;
        };
        let one = V::Halves::splat(1);
        each!(V::Halves, samples.len(), |at, WHOLE| {
            let (old, sample) = (
                V::Halves::load::<WHOLE>(kept, at),
                V::Halves::load::<WHOLE>(samples, at),
            );
            // The larger of two unsigned numbers.
            old.plus(sample.plus(one).minus_saturating(old))
                .store::<WHOLE>(kept, at);
        });
    }

    #[inline]
    fn shown(self, [kept, ..]: [u16; 3]) -> Option<u16> {
        kept.checked_sub(1)
    }
}

/// A sample counts as one, however little of its step does.
impl FastProjection for Minimum {
    type Word = u16;
    const WORDS: usize = 1;
    const EMPTY: u16 = u16::MAX;

    #[inline(always)]
    fn fold_row<V: Lanes>([kept, ..]: [&mut [u16]; 3], samples: &[u16], _: u32) {
        let Some(kept) = kept.get_mut(..samples.len()) else {
            return;
        };
        each!(V::Halves, samples.len(), |at, WHOLE| {
            let (old, sample) = (
                V::Halves::load::<WHOLE>(kept, at),
                V::Halves::load::<WHOLE>(samples, at),
            );
            // The smaller of two unsigned numbers.
            old.minus(old.minus_saturating(sample)).store::<WHOLE>(kept, at);
        });
    }

    #[inline]
    fn shown(self, [kept, ..]: [u16; 3]) -> Option<u16> {
        (kept != <Self as FastProjection>::EMPTY).then_some(kept)
    }
}

impl FastProjection for Sum {
    type Word = i32;
    const WORDS: usize = <Self as Projection>::WORDS;
    const EMPTY: i32 = <Self as Projection>::EMPTY;

    /// [`Sum::add`] along a row.
    #[inline(always)]
    fn fold_row<V: Lanes>(words: [&mut [i32]; 3], samples: &[u16], share: u32) {
        Self::fold_short_row::<V>(words, samples, share);
    }

    #[inline]
    fn shown(self, words: [i32; 3]) -> Option<u16> {
        Projection::shown(self, Fast, words).map(|value| value as u16)
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use proptest::prelude::*;

    use super::*;
    use crate::borders::WHOLE;
    use crate::plan::PLANES_MAX;

    /// The words of a ray after these samples and shares.
    fn words<X: FastProjection>(samples: &[(u16, u32)]) -> [X::Word; 3] {
        let mut words = [[X::EMPTY]; 3];
        for (sample, share) in samples {
            let [a, b, c] = &mut words;
            X::fold_row::<i32>([a, b, c], &[*sample], *share);
        }
        words.map(|[word]| word)
    }

    #[test]
    fn the_longest_ray_of_the_largest_samples_shows_them() {
        for share in [WHOLE, WHOLE - 1, 1] {
            let samples: Vec<_> = (0..=PLANES_MAX).map(|_| (32760, share)).collect();
            let shown = FastProjection::shown(Sum::Average, words::<Sum>(&samples));
            assert_eq!(shown, Some(32760));
        }
    }

    #[test]
    fn rays_that_have_met_nothing_show_nothing() {
        fn of<X: FastProjection>(projection: X) {
            assert_eq!(projection.shown([X::EMPTY; 3]), None);
            for sample in [0, 32760] {
                assert_eq!(projection.shown(words::<X>(&[(sample, WHOLE)])), Some(sample));
            }
        }
        of(Maximum);
        of(Minimum);
        of(Sum::Average);
    }

    proptest! {
        #[test]
        fn values_are_those_of_the_stage_in_32_bits(
            samples in prop::collection::vec((0..=32760u16, prop_oneof![Just(WHOLE), 1..=WHOLE]), 1..80),
            step in 1u32.., shift in 0..=crate::project::SHIFT_MAX,
        ) {
            let values = samples.iter().map(|(sample, _)| *sample);
            prop_assert_eq!(FastProjection::shown(Maximum, words::<Maximum>(&samples)), values.clone().max());
            prop_assert_eq!(FastProjection::shown(Minimum, words::<Minimum>(&samples)), values.min());
            let kept = samples.iter().fold([0; 3], |kept, (s, f)| Sum::add(kept, (*s).into(), *f));
            prop_assert_eq!(words::<Sum>(&samples), kept);
            for sum in [Sum::Average, Sum::Additive { step, shift }] {
                let expected = Projection::shown(sum, Fast, kept);
                prop_assert_eq!(FastProjection::shown(sum, words::<Sum>(&samples)).map(i32::from), expected);
            }
        }
    }
}
