//! The extent of samples: which pixels have one of the same cells, and which rows of them can be visible.

use core::ops::Range;

use crate::borders::Part;
use crate::format::Weight;
use crate::locate::Cell;
use crate::slice::{RowRange, Slice, Window};

/// The cells of some samples of a plane, or of some ends of segments, and their pixels.
#[derive(Clone)]
pub(super) struct Extent {
    pub(super) x: Cell,
    pub(super) y: Cell,
    pub(super) z: Cell,
    pub(super) columns: Range<usize>,
    pub(super) rows: Range<u32>,
    /// Column of the volume under the first of `columns`.
    pub(super) voxel: usize,
    pub(super) height: i32,
    /// Which part of the pixels' segments lies in the volume.
    pub(super) part: Part,
    /// The same of the first and of the last column, where it is another.
    pub(super) ends: [Option<Part>; 2],
    /// Whether the samples of the first and of the last column lie beyond the voxels and are held to them.
    pub(super) held: [bool; 2],
}

impl Extent {
    /// Of some pixels whose samples have these cells.
    #[inline(always)]
    pub(super) fn of([columns, rows]: [Range<u32>; 2], [x, y, z]: [Cell; 3], height: u32, part: Part) -> Self {
        Self {
            x,
            y,
            z,
            voxel: (i64::from(columns.start) + i64::from(x.index)).max(0) as usize,
            columns: columns.start as usize..columns.end as usize,
            rows,
            height: height as i32,
            part,
            ends: [None; 2],
            held: [false; 2],
        }
    }

    /// The same with columns at both ends that are cut otherwise, or held, in slices of this width.
    pub(super) fn with_ends(mut self, ends: [Option<Part>; 2], width: u32) -> Self {
        let last = width as i32 - 1;
        let behind = self.x.index.wrapping_add(self.columns.end as i32 - 1);
        let [low, high] = ends;
        self.held = [
            low.is_some() && self.x.index.wrapping_add(self.columns.start as i32) < 0,
            high.is_some() && (behind > last || behind == last && self.x.weight != Weight::ZERO),
        ];
        self.ends = ends;
        self
    }

    /// Leaves some of its columns; without one, no row either.
    pub(super) fn keep(&mut self, columns: Range<usize>) {
        if columns.is_empty() {
            self.rows.end = self.rows.start;
        }
        let [low, high] = [columns.start > self.columns.start, columns.end < self.columns.end];
        for ((end, held), cut) in self.ends.iter_mut().zip(&mut self.held).zip([low, high]) {
            if cut {
                (*end, *held) = (None, false);
            }
        }
        self.voxel = (columns.start as isize + self.x.index as isize).max(0) as usize;
        self.columns = columns;
    }

    /// Whether rows have places beyond their voxels.
    pub(super) fn is_wide(&self) -> bool {
        self.held != [false; 2]
    }

    /// The same samples in a window that begins with this column of the volume.
    pub(super) fn narrow(&mut self, first: usize) {
        self.x.index = self.x.index.wrapping_sub(first as i32);
        self.voxel = self.voxel.saturating_sub(first);
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
