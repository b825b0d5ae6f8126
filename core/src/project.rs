//! Projection of the largest or the smallest sample of each ray (MIP and its twin).
//!
//! The pixel holds a sample until the last plane; then it is classified once, by a table whose opacities are as
//! written (no step correction), and becomes a pixel like any other. Rounding: that of the sample. State: the pixel.

use crate::classify::Classifier;
use crate::composite::{Dither, Pixel, Recurrence};
use crate::lanes::{Lanes, places};
use crate::precision::Precision;

/// Which sample of a ray is kept.
pub trait Extreme: Copy + Send + Sync + 'static {
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

/// Folds one sample into each pixel of a row. Both rows equally long.
#[inline(always)]
pub fn keep_row<X: Extreme, V: Lanes>(row: &mut [i32], samples: &[i32]) {
    let len = row.len();
    let Some(samples) = samples.get(..len) else { return };
    for at in places::<V>(len) {
        X::keep(V::load(row, at), V::load(samples, at)).store(row, at);
    }
}

/// The picture's pixel of a kept sample.
#[inline]
pub fn resolve<P: Precision, X: Extreme>(
    p: P,
    kept: i32,
    classifier: &impl Classifier<P>,
) -> Pixel<<P::Pixel as Recurrence>::Channel> {
    let clear = p.pixel().clear();
    if kept == X::EMPTY {
        return clear;
    }
    let none = Dither {
        transparency: 0,
        colour: 0,
    };
    p.pixel()
        .over(clear, classifier.colour(p, kept), classifier.opacity(p, kept), none)
}
