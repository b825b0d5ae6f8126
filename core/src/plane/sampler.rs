//! Rows of samples: interpolation along z, then y and x, each row once.

use core::marker::PhantomData;
use core::ops::Range;

use super::meeting::Meeting;
use super::take_row;
use crate::blocks::runs;
use crate::interpolate::{extend_end, extend_row, extend_start, yx_row, z_row};
use crate::lanes::{Lanes, SMALL};
use crate::precision::Precision;
use crate::rows::{part, part_mut};
use crate::slice::Window;

/// Rows of samples of one plane, made when asked for and kept while their neighbours may need them.
///
/// Every buffer has a place for the voxel before the first and one for the voxel behind the last; `LIT` fills them
/// (the volume continued linearly), because gradients look one sample beyond the row.
pub(super) struct Sampler<'s, P, const LIT: bool> {
    z: [&'s mut [i32]; 4],
    z_made: [Made; 4],
    inner: &'s mut [i32],
    samples: [&'s mut [i32]; 3],
    samples_made: [Made; 3],
    precision: PhantomData<P>,
}

/// What a kept row holds: which blocks of which row.
#[derive(Clone, Copy)]
pub(super) struct Made {
    row: i32,
    blocks: u64,
}

impl Made {
    /// Blocks of a row that no row is.
    pub(super) const NOTHING: Self = Self {
        row: i32::MIN,
        blocks: 0,
    };

    /// Those of some blocks that have not been made yet; from now on they are.
    #[inline(always)]
    pub(super) fn missing(&mut self, row: i32, blocks: u64) -> u64 {
        if self.row != row {
            *self = Self { row, blocks: 0 };
        }
        let missing = blocks & !self.blocks;
        self.blocks |= blocks;
        missing
    }
}

impl<'s, P: Precision, const LIT: bool> Sampler<'s, P, LIT> {
    /// Rows of scratch memory.
    pub(super) const ROWS: usize = if LIT { 4 + Self::Z_ROWS } else { 1 + Self::Z_ROWS };

    /// Voxel rows that are kept. Two make the samples between them; where only spans of the rows beside are made, these
    /// would drive each other out.
    const Z_ROWS: usize = if LIT && !SMALL { 4 } else { 2 };

    #[inline(always)]
    pub(super) fn new(memory: &mut &'s mut [i32], width: u32) -> Self {
        let mut z = [(); 4].map(|()| &mut [][..]);
        for row in z.iter_mut().take(Self::Z_ROWS) {
            *row = take_row(memory, width);
        }
        let (samples, inner) = if LIT {
            let samples = [(); 3].map(|()| take_row(memory, width));
            (samples, take_row(memory, width))
        } else {
            ([take_row(memory, width), &mut [], &mut []], &mut [][..])
        };
        Self {
            z,
            z_made: [Made::NOTHING; 4],
            samples,
            samples_made: [Made::NOTHING; 3],
            inner,
            precision: PhantomData,
        }
    }

    /// Where the samples of a row are kept.
    #[inline(always)]
    fn slot(row: i32) -> usize {
        if LIT { (row + 1).rem_euclid(3) as usize } else { 0 }
    }

    /// Where the z interpolation of a voxel row is kept.
    #[inline(always)]
    const fn z_slot(row: i32) -> usize {
        row as usize & (Self::Z_ROWS - 1)
    }

    /// The samples of a row, one place beyond each end included. Empty unless [`Sampler::make`] made it.
    #[inline(always)]
    pub(super) fn row(&self, row: i32) -> &[i32] {
        self.samples.get(Self::slot(row)).map_or(&[], |s| s)
    }

    /// Makes blocks of the samples between voxel rows `row` and `row + 1`; a lit scene may ask for one row beyond each
    /// face, and gets one sample more at both ends of a run of blocks.
    #[inline(always)]
    pub(super) fn make<V: Lanes>(&mut self, meeting: &Meeting, window: &Window<'_>, row: i32, blocks: u64) {
        let Some(made) = self.samples_made.get_mut(Self::slot(row)) else {
            return;
        };
        let missing = made.missing(row, blocks);
        if missing == 0 {
            return;
        }
        if SMALL {
            self.make_once::<V>(meeting, window, row, missing);
        } else {
            self.make_anew::<V>(meeting, window, row, missing);
        }
    }

    /// Small machines have the code once: it may be called, because it holds no vectors.
    #[inline(never)]
    fn make_once<V: Lanes>(&mut self, meeting: &Meeting, window: &Window<'_>, row: i32, blocks: u64) {
        self.make_anew::<V>(meeting, window, row, blocks);
    }

    #[inline(always)]
    fn make_anew<V: Lanes>(&mut self, meeting: &Meeting, window: &Window<'_>, row: i32, blocks: u64) {
        let beyond = if LIT { meeting.height } else { meeting.height - 1 };
        // Behind the last row there is none; its weight is zero.
        let next = if row < beyond { row + 1 } else { row };
        self.make_z::<V>(meeting, window, row, blocks);
        self.make_z::<V>(meeting, window, next, blocks);
        let z = &self.z;
        let pick = |row: i32| z.get(Self::z_slot(row)).map_or(&[][..], |z| &**z);
        let Some(out) = self.samples.get_mut(Self::slot(row)) else {
            return;
        };
        // A place is one column further.
        let end = if LIT { meeting.width + 2 } else { meeting.width + 1 };
        for run in runs(blocks) {
            let columns = meeting.grain.span(run, meeting.width);
            let places = if LIT {
                columns.start..columns.end + 2
            } else {
                columns.start + 1..columns.end + 1
            };
            let inner = places.start..(places.end + 1).min(end);
            let (a, b) = (part(pick(row), inner.clone()), part(pick(next), inner));
            yx_row::<P, V>(a, b, meeting.in_slice(), meeting.weights(), part_mut(out, places));
        }
    }

    /// Makes blocks of the z interpolation of a voxel row, and as much beside them as their samples look at.
    #[inline(always)]
    fn make_z<V: Lanes>(&mut self, meeting: &Meeting, window: &Window<'_>, row: i32, blocks: u64) {
        let slot = Self::z_slot(row);
        let (Some(out), Some(made)) = (self.z.get_mut(slot), self.z_made.get_mut(slot)) else {
            return;
        };
        let far = window.far_or_near();
        let last = meeting.height - 1;
        let edge = row.min(last).max(0);
        let rows = |row: i32| (window.near.row(row as usize), far.row(row as usize));
        for run in runs(made.missing(row, blocks)) {
            let Range { start, end } = meeting.grain.span(run, meeting.width);
            let columns = if LIT {
                start.saturating_sub(1)..(end + 2).min(meeting.width)
            } else {
                start..(end + 1).min(meeting.width)
            };
            let places = columns.start + 1..columns.end + 1;
            let (near_row, far_row) = rows(edge);
            let (near_row, far_row) = (part(near_row, columns.clone()), part(far_row, columns.clone()));
            z_row::<P, V>(near_row, far_row, meeting.z.weight, part_mut(out, places.clone()));
            if LIT {
                if edge != row {
                    // One row beyond a face: twice the edge less the row inside it.
                    let inner = if row < 0 { 1.min(last) } else { (last - 1).max(0) };
                    let (near_row, far_row) = rows(inner);
                    let (near_row, far_row) = (part(near_row, columns.clone()), part(far_row, columns.clone()));
                    let inner = part_mut(self.inner, places.clone());
                    z_row::<P, V>(near_row, far_row, meeting.z.weight, inner);
                    extend_row(part_mut(out, places.clone()), inner);
                }
                if columns.start == 0 {
                    extend_start(out);
                }
                if columns.end == meeting.width {
                    extend_end(out);
                }
            }
        }
    }
}
