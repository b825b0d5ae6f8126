//! Projection: the largest or smallest sample of each ray, plane by plane.

use core::marker::PhantomData;

use super::clipped::{Clipped, Rest};
use super::kept::{Kept, KeptRows};
use super::parts::{Columns, Parts, Samples};
use super::scratch::{self, Scratch, ScratchError};
use super::source::{Sheared, Source};
use super::{At, ChannelOf, Pipeline, Rows};
use crate::classify::Classifier;
use crate::composite::Pixel;
use crate::lanes::{Kernel, Lanes};
use crate::precision::Precision;
use crate::project::{Extreme, keep_row, resolve};
use crate::rows::{part, part_mut};
use crate::shade::Unlit;
use crate::slice::Code12;
use crate::stage::Stage;
use crate::tap::{Beam, Tap};

/// Projection of the largest or smallest sample (`project`).
#[derive(Clone, Debug)]
pub struct Project<P, C, X> {
    precision: P,
    classifier: C,
    extreme: PhantomData<X>,
}

impl<P: Precision, C: Classifier<P>, X: Extreme> Project<P, C, X> {
    /// A pipeline that keeps one sample per ray and classifies it at the end.
    pub fn new(precision: P, classifier: C) -> Self {
        Self {
            precision,
            classifier,
            extreme: PhantomData,
        }
    }
}

impl<P: Precision, C: Classifier<P>, X: Extreme> Pipeline for Project<P, C, X> {
    type Precision = P;
    type Voxel = Code12;
    type Element = i32;
    const CHANNELS: usize = 1;
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
        let (plan, plane) = (at.plan, &at.plane);
        let [width, _, _] = plan.dims();
        let (scratch, _) = scratch::with_spare(scratch, Self::SCRATCH, width, false)?;
        if let Some(tap) = &mut tap {
            tap.plane(plane);
        }
        let base_width = plan.base()[0] as usize;
        let Some(count) = rows.data.len().checked_div(base_width) else {
            return Ok(());
        };
        let rest = Rest::of(at, false, (rows.first, count), false);
        if matches!(rest, Rest::Nothing) {
            return Ok(());
        }
        // A sample counts as one, however little of its segment lies in the volume.
        let mut parts = Parts::of(plan, plane, Columns::Alone);
        while let Some(mut samples) = parts.samples(&at.window) {
            if tap.is_none() {
                rest.narrow(at, core::slice::from_mut(&mut samples), false, (rows.first, count));
            }
            let Samples { extent, window, .. } = samples;
            let Scratch { source, .. } = Scratch::cut(&mut *scratch, Self::SCRATCH, width, !V::SMALL)?;
            let mut source = Sheared::<P, V, Unlit>::new(
                self.precision,
                &extent,
                &window,
                plan.spacing(),
                source,
                KeptRows::default(),
            );
            let clipped = Clipped::of(&rest, at, &extent, false, 0);
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
                let start = (row - rows.first) as usize * base_width;
                let columns = start + extent.columns.start..start + extent.columns.end;
                let kept = part_mut(&mut *rows.data, columns);
                if let Some(clipped) = &clipped {
                    clipped.each(row, 0..samples.len(), &mut |columns, left| {
                        if left.weight() > 0 {
                            keep_row::<X, i32>(part_mut(&mut *kept, columns.clone()), part(samples, columns));
                        }
                    });
                } else {
                    V::enter((Keep, PhantomData::<(X, V)>, kept, samples));
                }
            }
        }
        Ok(())
    }

    fn pixel(&self, row: &[i32], column: usize) -> Pixel<ChannelOf<P>> {
        let kept = row.get(column).copied().unwrap_or(X::EMPTY);
        resolve::<P, X>(self.precision, kept, &self.classifier)
    }
}

struct Keep;

impl<X: Extreme, V: Lanes> Kernel for (Keep, PhantomData<(X, V)>, &mut [i32], &[i32]) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, _, row, samples) = self;
        keep_row::<X, V>(row, samples);
    }
}
