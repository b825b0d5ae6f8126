//! Rows of samples: interpolation along z, then y and x, each row once.

use core::marker::PhantomData;

use super::meeting::Meeting;
use super::take_row;
use crate::interpolate::{extend_ends, extend_row, yx_row, yx_row_in_slice, z_row};
use crate::lanes::{Lanes, SMALL};
use crate::precision::Precision;
use crate::rows::{part, part_mut};
use crate::slice::Window;

/// Rows of samples of one plane, made when asked for and kept while their neighbours may need them.
///
/// With `LIT` every buffer has a place for the voxel before the first and one for the voxel behind the last (the volume
/// continued linearly), because gradients look one sample beyond the row.
pub(super) struct Sampler<'s, P, const LIT: bool> {
    z: [&'s mut [i32]; 2],
    z_row: [i32; 2],
    inner: &'s mut [i32],
    samples: [&'s mut [i32]; 3],
    sample_row: [i32; 3],
    precision: PhantomData<P>,
}

/// Words of a line of the cache.
const LINE: u32 = 16;

/// Scratch memory for some rows of slices of this width, and the room to give to each row: where there is enough, rows
/// begin with a line of the cache, so that vectors are not stored across two.
#[inline(always)]
pub(super) fn aligned(scratch: &mut [i32], rows: usize, width: u32) -> (&mut [i32], u32) {
    if SMALL {
        // No such lines, and no memory to spare.
        return (scratch, width);
    }
    let words = (width + 2).next_multiple_of(LINE);
    let first = scratch.as_ptr().align_offset(4 * LINE as usize);
    if scratch.len() < first.saturating_add(rows * words as usize) {
        (scratch, width)
    } else {
        (scratch.get_mut(first..).unwrap_or(&mut []), words - 2)
    }
}

/// A row number that no row has.
const NO_ROW: i32 = i32::MIN;

impl<'s, P: Precision, const LIT: bool> Sampler<'s, P, LIT> {
    /// Place of the first voxel, and of the sample behind it, in a row.
    pub(super) const FIRST: usize = LIT as usize;
    /// Rows of scratch memory.
    pub(super) const ROWS: usize = if LIT { 6 } else { 3 };

    /// Rows for slices of this width, cut from memory with room for `room` voxels a row.
    #[inline(always)]
    pub(super) fn new(memory: &mut &'s mut [i32], width: u32, room: u32) -> Self {
        let len = width as usize + 2 * Self::FIRST;
        let mut row = || part_mut(take_row(memory, room), 0..len);
        let z = [row(), row()];
        let (samples, inner) = if LIT {
            ([row(), row(), row()], row())
        } else {
            ([row(), &mut [], &mut []], &mut [][..])
        };
        Self {
            z,
            z_row: [NO_ROW; 2],
            samples,
            sample_row: [NO_ROW; 3],
            inner,
            precision: PhantomData,
        }
    }

    /// Where the samples of a row are kept.
    #[inline(always)]
    fn slot(row: i32) -> usize {
        if LIT { (row + 1).rem_euclid(3) as usize } else { 0 }
    }

    /// The samples of a row, from [`Sampler::FIRST`] on. Empty unless [`Sampler::make`] made it.
    #[inline(always)]
    pub(super) fn row(&self, row: i32) -> &[i32] {
        self.samples.get(Self::slot(row)).map_or(&[], |s| s)
    }

    /// Makes the samples between voxel rows `row` and `row + 1`; a lit scene may ask for one row beyond each face.
    #[inline(always)]
    pub(super) fn make<V: Lanes>(&mut self, meeting: &Meeting, window: &Window<'_>, row: i32) {
        if self.sample_row.get(Self::slot(row)) == Some(&row) {
            return;
        }
        if SMALL {
            self.make_once::<V>(meeting, window, row);
        } else {
            self.make_anew::<V>(meeting, window, row);
        }
    }

    /// Small machines have the code once: it may be called, because it holds no vectors.
    #[inline(never)]
    fn make_once<V: Lanes>(&mut self, meeting: &Meeting, window: &Window<'_>, row: i32) {
        self.make_anew::<V>(meeting, window, row);
    }

    #[inline(always)]
    fn make_anew<V: Lanes>(&mut self, meeting: &Meeting, window: &Window<'_>, row: i32) {
        let slot = Self::slot(row);
        let beyond = if LIT { meeting.height } else { meeting.height - 1 };
        // Behind the last row there is none; its weight is zero.
        let next = if row < beyond { row + 1 } else { row };
        if !LIT && !SMALL && meeting.in_slice() {
            let voxels = |row: i32| window.near.row(row.max(0) as usize);
            if let (Some(out), Some(key)) = (self.samples.get_mut(slot), self.sample_row.get_mut(slot)) {
                yx_row_in_slice::<P, V>(voxels(row), voxels(next), meeting.weights(), out);
                *key = row;
            }
            return;
        }
        self.make_z::<V>(meeting, window, row);
        self.make_z::<V>(meeting, window, next);
        let [even, odd] = &self.z;
        let pick = |row: i32| if row & 1 == 0 { &**even } else { &**odd };
        if let (Some(out), Some(key)) = (self.samples.get_mut(slot), self.sample_row.get_mut(slot)) {
            yx_row::<P, V>(pick(row), pick(next), meeting.in_slice(), meeting.weights(), out);
            *key = row;
        }
    }

    /// Makes the z interpolation of a voxel row.
    #[inline(always)]
    fn make_z<V: Lanes>(&mut self, meeting: &Meeting, window: &Window<'_>, row: i32) {
        let [even, odd] = &mut self.z;
        let [even_row, odd_row] = &mut self.z_row;
        let (out, key) = if row & 1 == 0 { (even, even_row) } else { (odd, odd_row) };
        if *key == row {
            return;
        }
        *key = row;
        let voxels = Self::FIRST..out.len().saturating_sub(Self::FIRST);
        let far = window.far_or_near();
        let last = meeting.height - 1;
        let edge = row.min(last).max(0);
        let rows = |row: i32| (window.near.row(row as usize), far.row(row as usize));
        let (near_row, far_row) = rows(edge);
        z_row::<P, V>(near_row, far_row, meeting.z.weight, part_mut(out, voxels.clone()));
        if LIT {
            if edge != row {
                // One row beyond a face: twice the edge less the row inside it.
                let inner = if row < 0 { 1.min(last) } else { (last - 1).max(0) };
                let (near_row, far_row) = rows(inner);
                z_row::<P, V>(
                    near_row,
                    far_row,
                    meeting.z.weight,
                    part_mut(self.inner, voxels.clone()),
                );
                extend_row(part_mut(out, voxels.clone()), part(self.inner, voxels));
            }
            extend_ends(out);
        }
    }
}
