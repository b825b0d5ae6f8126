//! Projection: the largest or smallest sample of each ray, plane by plane.

use core::marker::PhantomData;

use super::meeting::{Meeting, met_rows};
use super::sampler::{Sampler, aligned};
use super::{ChannelOf, Pipeline, Rows, scratch_len};
use crate::classify::Classifier;
use crate::composite::Pixel;
use crate::lanes::Lanes;
use crate::locate::Plane;
use crate::plan::Plan;
use crate::precision::Precision;
use crate::project::{Extreme, keep_row, resolve};
use crate::rows::{part, part_mut};
use crate::slice::Window;
use crate::tap::{Beam, Tap};

/// Projection of the largest or smallest sample (`project`).
#[derive(Clone, Debug)]
pub struct Project<P, C, X> {
    classifier: C,
    kinds: PhantomData<(P, X)>,
}

impl<P: Precision, C: Classifier<P>, X: Extreme> Project<P, C, X> {
    /// A pipeline that keeps one sample a ray and classifies it at the end.
    pub fn new(classifier: C) -> Self {
        Self {
            classifier,
            kinds: PhantomData,
        }
    }
}

impl<P: Precision, C: Classifier<P>, X: Extreme> Pipeline for Project<P, C, X> {
    type Precision = P;
    type Element = i32;
    const CHANNELS: usize = 1;
    const SLICES: usize = 2;
    const SCRATCH_ROWS: usize = Sampler::<P, false>::ROWS;
    const BACK_TO_FRONT: bool = false;

    fn empty(_: usize) -> i32 {
        X::EMPTY
    }

    #[inline(always)]
    fn fold<V: Lanes, T: Tap>(
        &self,
        plan: &Plan,
        plane: &Plane,
        window: &Window<'_>,
        rows: Rows<'_, i32>,
        scratch: &mut [i32],
        tap: &mut T,
    ) {
        let [slice_width, _, _] = plan.dims();
        if scratch.len() < scratch_len::<Self>(slice_width) {
            return;
        }
        tap.plane(plane);
        let meeting = Meeting::of(plan, plane);
        let n = meeting.columns.len();
        if n == 0 {
            return;
        }
        let [base_width, _] = plan.base().map(|side| side as usize);
        let (mut scratch, room) = aligned(scratch, Self::SCRATCH_ROWS, slice_width);
        let mut sampler = Sampler::<P, false>::new(&mut scratch, slice_width, room);
        for (row, data, voxel_row) in met_rows(&meeting, rows, base_width) {
            sampler.make::<V>(&meeting, window, voxel_row);
            let place = meeting.voxel + Sampler::<P, false>::FIRST;
            let samples = part(sampler.row(voxel_row), place..place + n);
            let at = Beam {
                plane,
                row,
                column: meeting.columns.start as u32,
            };
            tap.samples(at, samples);
            keep_row::<X, V>(part_mut(data, meeting.columns.clone()), samples);
        }
    }

    fn pixel(&self, row: &[i32], column: usize) -> Pixel<ChannelOf<P>> {
        let kept = row.get(column).copied().unwrap_or(X::EMPTY);
        resolve::<P, X>(kept, &self.classifier)
    }
}
