//! Where a sample plane meets the image, and which rows of it can show something.

use core::ops::Range;

use super::Rows;
use crate::blocks::{Grain, Seen};
use crate::classify::Support;
use crate::format::Weight;
use crate::locate::{Cell, Plane, cell, inside};
use crate::plan::Plan;
use crate::slice::{RowRange, Slice, Window};

/// Where a plane meets the image: its cells, and the pixels whose samples lie inside the volume.
pub(super) struct Meeting {
    pub(super) x: Cell,
    pub(super) y: Cell,
    pub(super) z: Cell,
    pub(super) columns: Range<usize>,
    pub(super) rows: Range<u32>,
    /// Column of the volume under the first of `columns`.
    pub(super) voxel: usize,
    pub(super) width: usize,
    pub(super) height: i32,
    pub(super) grain: Grain,
}

impl Meeting {
    pub(super) fn of(plan: &Plan, plane: &Plane, window: &Window<'_>) -> Self {
        let [width, height, _] = plan.dims();
        let [base_width, base_height] = plan.base();
        let (x, y, z) = (cell(plane.x), cell(plane.y), cell(plane.z));
        let columns = inside(x, width, base_width);
        Self {
            x,
            y,
            z,
            voxel: (i64::from(columns.start) + i64::from(x.index)).max(0) as usize,
            columns: columns.start as usize..columns.end as usize,
            rows: inside(y, height, base_height),
            width: width as usize,
            height: height as i32,
            grain: window.seen.map_or(Grain::WHOLE, Seen::grain),
        }
    }

    /// Whether the plane lies in a slice.
    pub(super) fn in_slice(&self) -> bool {
        self.z.weight == Weight::ZERO
    }

    /// The weights along x and y.
    pub(super) fn weights(&self) -> [Weight; 2] {
        [self.x.weight, self.y.weight]
    }

    /// The samples of some blocks, counted from the first of `columns`.
    #[inline(always)]
    pub(super) fn samples(&self, blocks: Range<u32>) -> Range<usize> {
        let Range { start, end } = self.grain.span(blocks, self.width);
        let sample = |column: usize| column.saturating_sub(self.voxel).min(self.columns.len());
        sample(start)..sample(end)
    }

    /// The voxel rows around a row of samples: its own and the next, which is itself behind the last.
    pub(super) fn voxel_rows(&self, row: i32) -> (usize, usize) {
        let last = self.height - 1;
        // Not `clamp`, which may panic.
        (row.min(last).max(0) as usize, (row + 1).min(last).max(0) as usize)
    }
}

/// The rows of the image that the plane meets: number of the row, its elements, and the voxel row before its samples.
///
/// No closure does the work: a vector of the processor stays one only in functions that are always inlined.
#[inline(always)]
pub(super) fn met_rows<'m, E>(
    meeting: &'m Meeting,
    rows: Rows<'m, E>,
    row_len: usize,
) -> impl Iterator<Item = (u32, &'m mut [E], i32)> {
    let numbered = (rows.first..).zip(rows.data.chunks_exact_mut(row_len.max(1)));
    let met = numbered.filter(|(row, _)| meeting.rows.contains(row));
    met.map(|(row, data)| (row, data, row as i32 + meeting.y.index))
}

/// The blocks of a row of samples that can be visible.
#[inline(always)]
pub(super) fn seen(support: Support, window: &Window<'_>, (row, next): (usize, usize)) -> u64 {
    if let Some(seen) = window.seen {
        return seen.row(row);
    }
    let far = window.far_or_near();
    let range = |s: &Slice<'_>| s.range(row).union(s.range(next));
    let range: RowRange = range(&window.near).union(range(&far));
    u64::from(support.meets(range))
}
