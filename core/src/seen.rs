//! What can be seen: for each row of samples the blocks of columns that are not known to be empty.
//!
//! A row is divided into at most 64 blocks, one bit each in a `u64`. A caller that holds the whole volume builds these masks
//! once per table; the plane layer then visits only the set blocks ([`At::seen`](crate::plane::At::seen)).

use core::ops::Range;

/// How many columns a block has: a power of two, 16 or more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grain(u32);

impl Grain {
    /// The finest grain for rows of this width.
    pub const fn of(width: usize) -> Self {
        let mut shift = 4;
        while shift < 16 && width > 64 << shift {
            shift += 1;
        }
        Self(shift)
    }

    /// Columns of a block.
    pub const fn columns(self) -> usize {
        1 << self.0
    }

    /// The columns of a block.
    #[inline(always)]
    pub(crate) const fn block(self, number: u32) -> Range<usize> {
        (number as usize) << self.0..(number as usize + 1) << self.0
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
    /// the samples from the first column of block b up to the first of the next. A bit left out promises
    /// that all those samples are invisible.
    pub const fn new(rows: &'a [u64], grain: Grain) -> Self {
        Self { rows, grain }
    }

    /// How long the blocks are.
    #[inline(always)]
    pub const fn grain(self) -> Grain {
        self.grain
    }

    /// The blocks of a row; none where there is no row.
    #[inline(always)]
    pub fn row(self, row: usize) -> u64 {
        self.rows.get(row).copied().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
    }
}
