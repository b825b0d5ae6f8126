//! What blocks of a volume hold, so that those which a table makes invisible are never interpolated.
//!
//! Between two slices and two rows, samples of a block of columns lie between the smallest and the largest of the voxels
//! around them. These ranges are measured once a volume and axis ([`Occupancy::of`]); each table then turns them into a
//! bit a block ([`Occupancy::sight`]), which core's plane layer asks before it makes anything.

use std::ops::Range;

use rayon::prelude::*;
use slicecast::blocks::{Grain, Seen};
use slicecast::classify::Support;
use slicecast::slice::{RowRange, Slice};

/// Codes are kept in steps of 64, which is as fine as a table's support knows them.
const STEP: u32 = 6;

/// Smallest and largest step of a block's voxels.
type Steps = [u8; 2];

/// The range of every block of a volume, for views along one axis and direction.
#[derive(Clone, Debug)]
pub struct Occupancy {
    /// Block after block, row after row, slice after slice.
    steps: Vec<Steps>,
    grain: Grain,
    /// Blocks of a row.
    blocks: usize,
    /// Rows of a slice.
    height: usize,
}

/// Which blocks of a volume can show something under a table.
#[derive(Clone, Debug)]
pub struct Sight {
    rows: Vec<u64>,
    grain: Grain,
    height: usize,
    /// Share of the blocks, 0 to 1.
    pub share: f64,
}

impl Occupancy {
    /// Measures slices, in parallel. Memory: 2 bytes for 16 voxels.
    pub fn of(slices: &[Slice<'_>]) -> Self {
        let [width, height] = slices.first().map_or([0; 2], |slice| [slice.width(), slice.height()]);
        let grain = Grain::of(width);
        let blocks = width.div_ceil(grain.columns());
        let mut own = vec![[u8::MAX, 0]; blocks * height * slices.len()];
        let row_len = blocks.max(1);
        let slice_len = row_len * height.max(1);
        own.par_chunks_mut(slice_len).zip(slices).for_each(|(out, slice)| {
            for (row, out) in out.chunks_mut(row_len).enumerate() {
                measure(slice.row(row), grain, out);
            }
        });
        // Samples between two slices and two rows: all four rows' blocks.
        let mut steps = own.clone();
        steps.par_chunks_mut(slice_len).enumerate().for_each(|(z, out)| {
            let near = &own[z * slice_len..(z + 1) * slice_len];
            let far = own.get((z + 1) * slice_len..(z + 2) * slice_len).unwrap_or(near);
            for side in [near, far] {
                unite(out, side);
                unite(out, &side[row_len..]);
            }
        });
        Self {
            steps,
            grain,
            blocks,
            height,
        }
    }

    /// The blocks that can show something under a table, in parallel.
    pub fn sight(&self, support: Support) -> Sight {
        let next = next_visible(support);
        let mut rows = vec![0; self.steps.len() / self.blocks.max(1)];
        let seen: u32 = (rows.par_iter_mut().with_min_len(1024))
            .zip(self.steps.par_chunks(self.blocks.max(1)))
            .map(|(row, steps)| {
                for (block, [low, high]) in steps.iter().enumerate() {
                    *row |= u64::from(next[usize::from(*low)] <= *high) << block;
                }
                row.count_ones()
            })
            .sum();
        Sight {
            share: f64::from(seen) / self.steps.len().max(1) as f64,
            rows,
            grain: self.grain,
            height: self.height,
        }
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.steps[..])
    }
}

impl Sight {
    /// The blocks between a slice and the next.
    pub fn between(&self, slice: usize) -> Seen<'_> {
        let start = slice.saturating_mul(self.height);
        let rows = start..start.saturating_add(self.height);
        Seen::new(self.rows.get(rows).unwrap_or(&[]), self.grain)
    }
}

impl Sight {
    /// The columns of a voxel row that samples of visible blocks look at, in runs; the last may end behind the row.
    pub fn around(&self, slice: usize, row: usize) -> impl Iterator<Item = Range<usize>> {
        let blocks = [slice.wrapping_sub(1), slice].map(|slice| self.between(slice).row(row));
        let blocks = blocks[0] | blocks[1];
        self.grain.runs(blocks)
    }
}

/// For each step the first that is visible, from it on; 255 where none is.
fn next_visible(support: Support) -> [u8; 64] {
    let mut next = [u8::MAX; 64];
    let mut found = u8::MAX;
    for step in (0..64u8).rev() {
        let code = u16::from(step) << STEP;
        if support.meets(RowRange { low: code, high: code }) {
            found = step;
        }
        next[usize::from(step)] = found;
    }
    next
}

/// Ranges of the blocks of a row: a block's samples look at the first voxel behind it as well.
fn measure(row: &[u16], grain: Grain, out: &mut [Steps]) {
    for (block, out) in out.iter_mut().enumerate() {
        let voxels = &row[block * grain.columns()..];
        let voxels = &voxels[..voxels.len().min(grain.columns() + 1)];
        let low = voxels.iter().fold(u16::MAX, |low, v| low.min(*v));
        let high = voxels.iter().fold(0, |high, v| high.max(*v));
        *out = [low, high].map(|code| (code >> STEP) as u8);
    }
}

/// The smallest ranges that hold both, as far as both go.
fn unite(out: &mut [Steps], other: &[Steps]) {
    for ([low, high], [other_low, other_high]) in out.iter_mut().zip(other) {
        *low = (*low).min(*other_low);
        *high = (*high).max(*other_high);
    }
}
