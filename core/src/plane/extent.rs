//! The extent of a sample plane: which pixels have a sample in it, and which rows of them can be visible.
//!
//! Every pixel inside counts with a whole step. Crop boxes and border fractions change this file: the ranges, and a fraction
//! for the columns and rows at their ends.

use core::ops::Range;

use crate::format::Weight;
use crate::locate::{Cell, Plane, cell, inside};
use crate::plan::Plan;
use crate::slice::{RowRange, Slice, Window};

/// The cells of a plane, and the pixels whose samples lie inside the volume.
pub(super) struct Extent {
    pub(super) x: Cell,
    pub(super) y: Cell,
    pub(super) z: Cell,
    pub(super) columns: Range<usize>,
    pub(super) rows: Range<u32>,
    /// Column of the volume under the first of `columns`.
    pub(super) voxel: usize,
    pub(super) height: i32,
}

impl Extent {
    pub(super) fn of(plan: &Plan, plane: &Plane) -> Self {
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
            height: height as i32,
        }
    }

    /// The extents of two neighbouring planes where both have samples: what slabs between them there are.
    pub(super) fn of_slab(plan: &Plan, [front, back]: [&Plane; 2]) -> [Self; 2] {
        let mut extents = [Self::of(plan, front), Self::of(plan, back)];
        let [front, back] = &extents;
        let start = front.columns.start.max(back.columns.start);
        let columns = start..front.columns.end.min(back.columns.end).max(start);
        let start = front.rows.start.max(back.rows.start);
        let rows = start..front.rows.end.min(back.rows.end).max(start);
        for extent in &mut extents {
            (extent.columns, extent.rows) = (columns.clone(), rows.clone());
            extent.voxel = (columns.start as i64 + i64::from(extent.x.index)).max(0) as usize;
        }
        extents
    }

    /// Whether the plane lies in a slice.
    pub(super) fn in_slice(&self) -> bool {
        self.z.weight == Weight::ZERO
    }

    /// The weights along x and y.
    pub(super) fn weights(&self) -> [Weight; 2] {
        [self.x.weight, self.y.weight]
    }

    /// The voxel row before the samples of a row of the image.
    pub(super) fn voxel_row(&self, row: u32) -> i32 {
        (row as i32).wrapping_add(self.y.index)
    }

    /// The voxel rows around the samples behind a voxel row: that row and the next, which is the last one itself behind it.
    pub(super) fn voxel_rows(&self, row: i32) -> (usize, usize) {
        let last = self.height - 1;
        // Not `clamp`, which may panic.
        (row.min(last).max(0) as usize, (row + 1).min(last).max(0) as usize)
    }

    /// Rows of the image that the plane meets, among `count` from `first` on.
    pub(super) fn met(&self, first: u32, count: usize) -> Range<u32> {
        let end = first.saturating_add(u32::try_from(count).unwrap_or(u32::MAX));
        let start = self.rows.start.max(first);
        start..self.rows.end.min(end).max(start)
    }
}

/// The range of the voxels around the samples between voxel rows.
pub(super) fn around(window: &Window<'_>, (row, next): (usize, usize)) -> RowRange {
    let far = window.far_or_near();
    let range = |s: &Slice<'_>| s.range(row).union(s.range(next));
    range(&window.near).union(range(&far))
}
