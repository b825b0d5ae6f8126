//! Runs: the columns of a plane's rows that hold blocks that can be seen.
//!
//! Rows beside each other mostly see the same blocks. Of such rows a run of blocks is folded as whole rows are, with rows of samples of
//! that length: vectors of 16-bit lanes are longer than a block, so blocks are not packed one by one.

use core::ops::Range;

use crate::plane::extent::Extent;
use crate::seen::Seen;

/// Rows of the image and their columns that can be seen.
pub(super) struct Runs<'s> {
    seen: Seen<'s>,
    extent: &'s Extent,
    /// Rows that are left.
    rows: Range<u32>,
    /// Rows that see the same blocks, and what is left of those.
    alike: Range<u32>,
    blocks: u64,
}

impl<'s> Runs<'s> {
    /// Of some rows of an extent.
    pub(super) fn of(seen: Seen<'s>, extent: &'s Extent, rows: Range<u32>) -> Self {
        Self {
            seen,
            extent,
            rows,
            alike: 0..0,
            blocks: 0,
        }
    }

    /// The blocks of a row; a single one between two that can be seen is taken with them.
    fn blocks(&self, row: u32) -> u64 {
        let blocks = self.seen.row(self.extent.voxel_row(row) as usize);
        blocks | (blocks << 1 & blocks >> 1)
    }
}

impl Iterator for Runs<'_> {
    type Item = (Range<u32>, Range<usize>);

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            while self.blocks == 0 {
                let start = self.rows.next()?;
                self.blocks = self.blocks(start);
                while self.rows.start < self.rows.end && self.blocks(self.rows.start) == self.blocks {
                    self.rows.start += 1;
                }
                self.alike = start..self.rows.start;
            }
            let first = self.blocks.trailing_zeros();
            let last = first + (self.blocks >> first).trailing_ones() - 1;
            // A carry clears the run.
            self.blocks &= self.blocks.wrapping_add(1 << first);
            let (grain, voxel, columns) = (self.seen.grain(), self.extent.voxel, &self.extent.columns);
            let column = |of: usize| (columns.start + of.saturating_sub(voxel)).min(columns.end);
            let run = column(grain.block(first).start)..column(grain.block(last).end);
            if !run.is_empty() {
                return Some((self.alike.clone(), run));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;
    use crate::borders::Part;
    use crate::format::Weight;
    use crate::locate::Cell;
    use crate::seen::Grain;

    /// Pixels 3 to 102 of rows 2 to 9 above the voxels 1 to 100, whose blocks have 16 columns.
    #[test]
    fn runs_are_the_blocks_of_rows_that_see_alike() {
        let cell = |index| Cell {
            index,
            weight: Weight::ZERO,
        };
        let extent = Extent::of([3..103, 2..10], [cell(-2), cell(1), cell(0)], 64, Part::WHOLE);
        let mut rows = [0u64; 11];
        // A single block between two others, and one at the end.
        rows[3] = 0b100_0101;
        rows[4] = 0b100_0101;
        // Two blocks that nothing joins; row 6 sees nothing.
        rows[5] = 0b1001;
        // Beyond the pixels alone.
        rows[7] = 1 << 7;
        rows[9] = u64::MAX;
        let runs: Vec<_> = Runs::of(Seen::new(&rows, Grain::of(100)), &extent, 2..10).collect();
        let expected = [
            (2..4, 3..50),
            (2..4, 98..103),
            (4..5, 3..18),
            (4..5, 50..66),
            (8..9, 3..103),
        ];
        assert_eq!(runs, expected);
    }
}
