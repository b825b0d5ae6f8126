//! Blocks: the columns of a row of voxels in at most 64 pieces, so that a set of them is the bits of a word.
//!
//! What can show something is known block by block ([`Seen`]), and rows are made block by block. Where nobody knows, as
//! in a stream, a row is a single block.

use core::ops::Range;

/// How many columns a block has: a power of two, 16 or more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grain(u32);

impl Grain {
    /// A row is one block.
    pub const WHOLE: Self = Self(16);

    /// The finest grain for rows of this width.
    pub const fn of(width: usize) -> Self {
        let mut shift = 4;
        while shift < Self::WHOLE.0 && width > 64 << shift {
            shift += 1;
        }
        Self(shift)
    }

    /// Columns of a block.
    pub const fn columns(self) -> usize {
        1 << self.0
    }

    /// Columns of the runs of neighbouring blocks in a set.
    #[inline(always)]
    pub fn runs(self, blocks: u64) -> impl Iterator<Item = Range<usize>> {
        runs(blocks).map(move |run| (run.start as usize) << self.0..(run.end as usize) << self.0)
    }

    /// Columns of some blocks in a row, those of the last one cut off behind the row.
    #[inline(always)]
    pub(crate) fn span(self, blocks: Range<u32>, width: usize) -> Range<usize> {
        let column = |block: u32| ((block as usize) << self.0).min(width);
        column(blocks.start)..column(blocks.end)
    }

    /// The blocks in which some columns lie, at least one.
    #[inline(always)]
    pub(crate) fn covering(self, columns: Range<usize>) -> u64 {
        let block = |column: usize| (column >> self.0) as u32;
        set(block(columns.start)..block(columns.end.saturating_sub(1)) + 1)
    }
}

/// Which blocks can show something, for the rows of samples between two slices.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    rows: &'a [u64],
    grain: Grain,
}

impl<'a> Seen<'a> {
    /// `rows[y]`: the blocks of samples between voxel rows y and y + 1 (the last row: itself). Bit b of it stands for
    /// the samples between the first column of block b and the first of the next. Whoever leaves a bit out promises
    /// that all those samples are invisible.
    pub const fn new(rows: &'a [u64], grain: Grain) -> Self {
        Self { rows, grain }
    }

    /// How long the blocks are.
    pub(crate) const fn grain(self) -> Grain {
        self.grain
    }

    /// The blocks of a row; none where there is no row.
    #[inline(always)]
    pub fn row(self, row: usize) -> u64 {
        self.rows.get(row).copied().unwrap_or(0)
    }
}

/// Neighbouring blocks of a set, as far as they reach.
#[inline(always)]
pub(crate) fn runs(blocks: u64) -> impl Iterator<Item = Range<u32>> {
    let mut left = blocks;
    core::iter::from_fn(move || {
        // Adding the lowest bit carries over the lowest run.
        let rest = left & left.wrapping_add(left & left.wrapping_neg());
        let run = left ^ rest;
        left = rest;
        (run != 0).then(|| run.trailing_zeros()..64 - run.leading_zeros())
    })
}

/// The set of the blocks of a run.
#[inline(always)]
pub(crate) fn set(run: Range<u32>) -> u64 {
    let below = |block: u32| 1u64.checked_shl(block).unwrap_or(0).wrapping_sub(1);
    below(run.end) & !below(run.start)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    #[test]
    fn a_row_has_at_most_64_blocks() {
        for width in [1, 16, 1024, 1025, 2048, 8192, 32768] {
            let grain = Grain::of(width);
            assert!(width.div_ceil(grain.columns()) <= 64, "{width}");
            assert!(
                grain.columns() == 16 || width.div_ceil(grain.columns() >> 1) > 64,
                "{width}"
            );
        }
        assert_eq!(Grain::WHOLE.span(0..1, 500), 0..500);
    }

    proptest! {
        #[test]
        fn runs_are_the_set(blocks in any::<u64>(), mask in any::<u64>(), dense in any::<bool>()) {
            let blocks = if dense { blocks | mask } else { blocks & mask };
            let runs: Vec<_> = runs(blocks).collect();
            prop_assert_eq!(runs.iter().cloned().fold(0, |all, run| all | set(run)), blocks);
            prop_assert!(runs.iter().all(|run| !run.is_empty()));
            prop_assert!(runs.windows(2).all(|pair| pair[0].end < pair[1].start));
        }

        #[test]
        fn columns_are_covered_by_their_blocks(width in 1usize..3000, a in 0usize..3000, b in 0usize..3000) {
            let (start, last) = (a.min(b) % width, a.max(b) % width);
            let (start, end) = (start.min(last), start.max(last) + 1);
            let grain = Grain::of(width);
            let expected = (0..64).filter(|block| {
                let columns = grain.span(*block..block + 1, width);
                columns.start < end && start < columns.end
            });
            prop_assert_eq!(grain.covering(start..end), expected.fold(0, |set, block| set | 1 << block));
        }
    }

    #[test]
    fn the_whole_word_is_one_run() {
        assert_eq!(runs(!0).collect::<Vec<_>>(), [0..64]);
        assert_eq!(runs(0).count(), 0);
    }
}
