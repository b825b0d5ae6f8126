//! Samples that are kept from plane to plane, so that the rows in front of slabs need not be made again.
//!
//! A host that takes some rows of the image through all planes has the memory: two banks, for planes of even and of odd
//! numbers. The samples of a plane, made as the back of one slab, are found as the front of the next, in either order of the
//! planes. Rows that were left out, or of which nothing is kept, are made from the slices: the same bits.

use super::extent::Extent;
use super::scratch::{LINE, NO_ROW, ScratchError};
use crate::rows::take;

/// Rows of samples of the two planes that were folded last, for some rows of the image.
#[derive(Debug)]
pub struct Kept<'m> {
    /// First of the image's rows.
    first: u32,
    stride: usize,
    banks: [Bank<'m>; 2],
}

/// Rows of samples of one plane.
#[derive(Debug)]
struct Bank<'m> {
    plane: Option<u32>,
    /// Voxel row before the samples of each row that is held.
    names: &'m mut [i32],
    words: &'m mut [i32],
}

/// Rows beyond those of the image, at which gradients look.
const BEYOND: usize = 2;

/// Words of a row: the voxels of a slice's row and one place at each end, up to a line of the cache.
const fn stride(width: u32) -> usize {
    (width as usize + 2).next_multiple_of(LINE)
}

impl<'m> Kept<'m> {
    /// Words of memory for so many rows of the image over slices of this width.
    pub const fn len(rows: usize, width: u32) -> usize {
        2 * (rows + BEYOND) * (stride(width) + 1) + LINE
    }

    /// Nothing yet, of `rows` rows of one phase of the image from `first` on. Another frame, other rows or another phase
    /// begin anew.
    ///
    /// # Errors
    /// [`ScratchError`] if the memory is shorter than [`Kept::len`].
    pub fn new(memory: &'m mut [i32], first: u32, rows: usize, width: u32) -> Result<Self, ScratchError> {
        let (needed, given) = (Self::len(rows, width), memory.len());
        if given < needed {
            return Err(ScratchError { needed, given });
        }
        let (mut rest, held) = (memory, rows + BEYOND);
        let line = rest.as_ptr().align_offset(size_of::<i32>() * LINE);
        take(&mut rest, line.min(LINE));
        let words = held * stride(width);
        let [even, odd] = [take(&mut rest, words), take(&mut rest, words)];
        let mut bank = |words| Bank {
            plane: None,
            names: take(&mut rest, held),
            words,
        };
        Ok(Self {
            first,
            stride: stride(width),
            banks: [bank(even), bank(odd)],
        })
    }

    /// What is kept of a plane and of the one in front of it; of others nothing is kept any longer.
    pub(super) fn of(&mut self, plane: u32, [front, back]: [&Extent; 2]) -> [KeptRows<'_>; 2] {
        let (first, stride) = (self.first, self.stride);
        let [even, odd] = &mut self.banks;
        let [ahead, behind] = if plane & 1 == 1 { [even, odd] } else { [odd, even] };
        [
            ahead.rows(plane.wrapping_sub(1), front.voxel_row(first), stride),
            behind.rows(plane, back.voxel_row(first), stride),
        ]
    }
}

impl Bank<'_> {
    /// The rows of a plane, given the voxel row of the image's first one.
    fn rows(&mut self, plane: u32, voxel_row: i32, stride: usize) -> KeptRows<'_> {
        if self.plane != Some(plane) {
            self.plane = Some(plane);
            self.names.fill(NO_ROW);
        }
        KeptRows {
            first: voxel_row.wrapping_sub(1),
            len: stride,
            stride,
            names: self.names,
            words: self.words,
        }
    }
}

/// Rows of samples of a plane that outlive its fold. Without memory there are none.
#[derive(Debug, Default)]
pub(super) struct KeptRows<'k> {
    /// Voxel row of the first.
    first: i32,
    len: usize,
    stride: usize,
    names: &'k mut [i32],
    words: &'k mut [i32],
}

impl KeptRows<'_> {
    /// Rows of this length; none where they do not fit.
    #[inline(always)]
    pub(super) fn of_len(self, len: usize) -> Self {
        if len > self.stride {
            return Self::default();
        }
        Self { len, ..self }
    }

    /// Number of a voxel row, where there is memory for it.
    #[inline(always)]
    pub(super) fn number(&self, row: i32) -> Option<usize> {
        let number = row.wrapping_sub(self.first) as u32 as usize;
        (number < self.names.len()).then_some(number)
    }

    /// The voxel row that is held, and its samples.
    #[inline(always)]
    pub(super) fn row(&self, number: usize) -> Option<(i32, &[i32])> {
        let start = number * self.stride;
        Some((*self.names.get(number)?, self.words.get(start..start + self.len)?))
    }

    /// To be written.
    #[inline(always)]
    pub(super) fn row_mut(&mut self, number: usize) -> Option<(&mut i32, &mut [i32])> {
        let start = number * self.stride;
        Some((
            self.names.get_mut(number)?,
            self.words.get_mut(start..start + self.len)?,
        ))
    }
}
