//! Places of vectors in the blocks of a plane.

use core::ops::Range;

/// Places of vectors in a plane: the row of the image that each lies in, counted from the first, and its first column in the
/// volume.
pub(super) struct Places<'s> {
    pub(super) rows: &'s mut [i32],
    pub(super) columns: &'s mut [i32],
    /// Voxel row before the samples of the first row.
    pub(super) voxel_row: i32,
    /// Columns of a block.
    pub(super) block: usize,
    /// Column of the volume under `first`, and behind the last sample.
    pub(super) inside: Range<usize>,
    /// First column of the image.
    pub(super) first: usize,
    pub(super) lanes: usize,
}

impl Places<'_> {
    #[inline(always)]
    pub(super) fn set(&mut self, number: usize, (row, column): (usize, usize)) {
        if let (Some(r), Some(c)) = (self.rows.get_mut(number), self.columns.get_mut(number)) {
            (*r, *c) = (row as i32, column as i32);
        }
    }

    #[inline(always)]
    pub(super) fn get(&self, number: usize) -> (usize, usize) {
        match (self.rows.get(number), self.columns.get(number)) {
            (Some(row), Some(column)) => (*row as usize, *column as usize),
            _ => (0, 0),
        }
    }

    /// Voxel row before the samples of a row.
    #[inline(always)]
    pub(super) fn voxel_row(&self, row: usize) -> i32 {
        self.voxel_row.wrapping_add(row as i32)
    }

    /// Columns of the image that the vector at a column of the volume covers: those of its block.
    #[inline(always)]
    pub(super) fn pixels(&self, column: usize) -> Range<usize> {
        let block_end = (column & !(self.block - 1)) + self.block;
        let end = block_end.min(column + self.lanes).min(self.inside.end);
        let first = self.first + (column - self.inside.start);
        first..first + end.saturating_sub(column)
    }
}
