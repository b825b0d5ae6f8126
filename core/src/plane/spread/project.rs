//! Projection of rays that spread: one value of the samples of each ray, plane by plane.

use core::marker::PhantomData;

use super::source::{Source, Spreads};
use super::{Reach, reach};
use crate::classify::Classifier;
use crate::composite::Pixel;
use crate::lanes::{Kernel, Lanes};
use crate::perspective::Spread;
use crate::plane::kept::Kept;
use crate::plane::kernels::staged;
use crate::plane::project::{Project, runs};
use crate::plane::scratch::{self, ScratchError, SpreadScratch};
use crate::plane::{At, ChannelOf, Pipeline, Rows};
use crate::precision::Precision;
use crate::project::Projection;
use crate::rows::{part_mut, three};
use crate::shade::SamplesAlone;
use crate::slice::Code12;
use crate::stage::Stage;
use crate::tap::{Beam, Tap};

/// [`Project`] of rays that spread from an eye: whole borders. It folds planes of the plan that was made with its rays
/// ([`Plan::perspective`](crate::plan::Plan::perspective)), and nothing of others.
#[derive(Clone, Debug)]
pub struct ProjectFromEye<P, C, X> {
    pipeline: Project<P, C, X>,
    spread: Spread,
}

impl<P: Precision, C: Classifier<P>, X: Projection> ProjectFromEye<P, C, X> {
    /// The same pipeline over these rays.
    pub const fn new(pipeline: Project<P, C, X>, spread: Spread) -> Self {
        Self { pipeline, spread }
    }
}

impl<P: Precision, C: Classifier<P>, X: Projection> Pipeline for ProjectFromEye<P, C, X> {
    type Precision = P;
    type Voxel = Code12;
    type Element = i32;
    const CHANNELS: usize = X::WORDS;
    const SLICES: usize = 2;
    const SCRATCH: scratch::Rows = scratch::Rows::Spread;
    const SPREADS: bool = true;
    const BACK_TO_FRONT: bool = false;

    fn precision(&self) -> P {
        self.pipeline.precision()
    }

    fn empty(&self, channel: usize) -> i32 {
        self.pipeline.empty(channel)
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
        staged::<P>();
        let (plan, plane) = (at.plan, &at.plane);
        let (memory, _) = SpreadScratch::cut(scratch, Self::SCRATCH, plan.longest_row(), !V::SMALL)?;
        if let Some(tap) = &mut tap {
            tap.plane(plane);
        }
        let width = plan.base()[0] as usize;
        let Some(count) = rows.data.len().checked_div(X::WORDS * width) else {
            return Ok(());
        };
        let Some(Reach { lines, columns, met }) = reach(&self.spread, at, (rows.first, count)) else {
            return Ok(());
        };
        let around = (plan, &self.spread, plane);
        let mut source =
            Source::<P, V, SamplesAlone>::new(self.precision(), around, lines, columns.clone(), &at.window, memory);
        for row in met {
            source.make(row, 0..columns.len());
            let samples = source.samples();
            if let Some(tap) = &mut tap {
                let beam = Beam {
                    plane,
                    row,
                    column: columns.start as u32,
                    part: 0,
                };
                tap.row(Stage::Interpolation, beam, &[&samples]);
            }
            let start = X::WORDS * (row - rows.first) as usize * width;
            let words = runs(part_mut(&mut *rows.data, start..start + X::WORDS * width), width);
            let words = three(words, |run| part_mut(run, columns.clone()));
            V::enter((FoldSteps, PhantomData::<(X, V)>, words, samples, source.lengths()));
        }
        Ok(())
    }

    fn pixel(&self, row: &[i32], column: usize) -> Pixel<ChannelOf<P>> {
        self.pipeline.pixel(row, column)
    }
}

struct FoldSteps;

impl<X: Projection, V: Lanes> Kernel for (FoldSteps, PhantomData<(X, V)>, [&mut [i32]; 3], &[i32], &[i32]) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, _, words, samples, lengths) = self;
        X::fold_steps_row::<V>(words, samples, lengths);
    }
}
