//! Projection: one value of the samples of each ray, plane by plane.

use core::marker::PhantomData;

use super::clipped::{Clipped, Rest};
use super::kept::{Kept, KeptRows};
use super::kernels::staged;
use super::parts::{Columns, Parts, Samples};
use super::scratch::{self, Scratch, ScratchError};
use super::source::{Sheared, Source};
use super::{At, ChannelOf, Pipeline, Rows};
use crate::classify::Classifier;
use crate::composite::Pixel;
use crate::lanes::{Kernel, Lanes};
use crate::precision::Precision;
use crate::project::{Projection, pixel};
use crate::rows::{part, part_mut, three};
use crate::shade::SamplesAlone;
use crate::slice::Code12;
use crate::stage::Stage;
use crate::tap::{Beam, Tap};

/// Projection: the largest or smallest sample, or what is made of the sum of all (`project`).
#[derive(Clone, Debug)]
pub struct Project<P, C, X> {
    precision: P,
    classifier: C,
    projection: X,
}

impl<P: Precision, C: Classifier<P>, X: Projection + Default> Project<P, C, X> {
    /// A pipeline that keeps one sample per ray and classifies it at the end.
    pub fn new(precision: P, classifier: C) -> Self {
        Self::of(precision, classifier, X::default())
    }
}

impl<P: Precision, C: Classifier<P>, X: Projection> Project<P, C, X> {
    /// A pipeline that makes one value of the samples of a ray and classifies it at the end.
    pub const fn of(precision: P, classifier: C, projection: X) -> Self {
        Self {
            precision,
            classifier,
            projection,
        }
    }
}

/// The runs of a row, or of a pixel's words.
#[inline(always)]
pub(super) fn runs(row: &mut [i32], width: usize) -> [&mut [i32]; 3] {
    let mut runs = row.chunks_mut(width.max(1));
    three([(); 3], |()| runs.next().unwrap_or(&mut []))
}

impl<P: Precision, C: Classifier<P>, X: Projection> Pipeline for Project<P, C, X> {
    type Precision = P;
    type Voxel = Code12;
    type Element = i32;
    const CHANNELS: usize = X::WORDS;
    const SLICES: usize = 2;
    const SCRATCH: scratch::Rows = scratch::Rows::Projection;
    const BACK_TO_FRONT: bool = false;

    fn precision(&self) -> P {
        self.precision
    }

    fn empty(&self, _: usize) -> i32 {
        X::EMPTY
    }

    #[inline(always)]
    fn fold<V: Lanes>(
        &self,
        at: &At<'_>,
        rows: Rows<'_, i32>,
        scratch: &mut [i32],
        _: Option<&mut Kept<'_>>,
        mut tap: Option<&mut dyn Tap>,
    ) -> Result<(), ScratchError> {
        staged::<Self::Precision>();
        let (plan, plane) = (at.plan, &at.plane);
        let [width, _, _] = plan.dims();
        let (scratch, _) = scratch::with_spare(scratch, Self::SCRATCH, width, false)?;
        if let Some(tap) = &mut tap {
            tap.plane(plane);
        }
        let base_width = plan.base()[0] as usize;
        let Some(count) = rows.data.len().checked_div(X::WORDS * base_width) else {
            return Ok(());
        };
        let rest = Rest::of(at, false, (rows.first, count), false);
        if matches!(rest, Rest::Nothing) {
            return Ok(());
        }
        let mut parts = Parts::of(plan, plane, Columns::Alone);
        while let Some(mut samples) = parts.samples::<V>(&at.window) {
            if tap.is_none() {
                rest.narrow(plan, core::slice::from_mut(&mut samples), false, (rows.first, count));
            }
            let Samples { extent, window, .. } = samples;
            let Scratch { source, .. } = Scratch::cut(&mut *scratch, Self::SCRATCH, width, !V::SMALL)?;
            let mut source = Sheared::<P, V, SamplesAlone>::new(
                self.precision,
                &extent,
                &window,
                plan.spacing(),
                source,
                KeptRows::default(),
            );
            let clipped = Clipped::of(&rest, &extent, 0);
            for row in extent.met(rows.first, count) {
                if clipped.as_ref().is_some_and(|clipped| clipped.is_empty(row)) {
                    continue;
                }
                let voxel_row = extent.voxel_row(row);
                source.make(voxel_row);
                let samples = source.slab(voxel_row).back;
                if let Some(tap) = &mut tap {
                    let beam = Beam {
                        plane,
                        row,
                        column: extent.columns.start as u32,
                        part: 0,
                    };
                    tap.row(Stage::Interpolation, beam, &[&samples]);
                }
                let start = X::WORDS * (row - rows.first) as usize * base_width;
                let row_of_words = part_mut(&mut *rows.data, start..start + X::WORDS * base_width);
                let words = runs(row_of_words, base_width);
                let [a, b, c] = three(words, |run| part_mut(run, extent.columns.clone()));
                if let Some(clipped) = &clipped {
                    clipped.each(row, 0..samples.len(), &mut |columns, left| {
                        if left.weight() > 0 {
                            let of = |run| part_mut(run, columns.clone());
                            let words = [of(&mut *a), of(&mut *b), of(&mut *c)];
                            X::fold_row::<i32>(words, part(samples, columns.clone()), clipped.fraction(left));
                        }
                    });
                } else {
                    V::enter((Fold, PhantomData::<(X, V)>, [a, b, c], samples, extent.part.length()));
                }
            }
        }
        Ok(())
    }

    fn pixel(&self, row: &[i32], column: usize) -> Pixel<ChannelOf<P>> {
        let width = row.len().checked_div(X::WORDS).unwrap_or(0);
        let word = |run: usize| {
            let inside = column < width;
            let word = row.get(run * width + column).filter(|_| inside);
            word.copied().unwrap_or(X::EMPTY)
        };
        let shown = self.projection.shown(self.precision, [word(0), word(1), word(2)]);
        pixel(self.precision, shown, &self.classifier)
    }
}

struct Fold;

impl<X: Projection, V: Lanes> Kernel for (Fold, PhantomData<(X, V)>, [&mut [i32]; 3], &[i32], u32) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, _, words, samples, share) = self;
        X::fold_row::<V>(words, samples, share);
    }
}
