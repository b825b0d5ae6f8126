//! Voxel slices: borrowed memory whose shape and values have been checked once.
//!
//! A [`Slice`] can only be made by measuring its voxels, so every slice guarantees three things: every row has
//! `width` voxels, every voxel is at most 4095, and every row's range is known (rows that classify to nothing are
//! never read again).

use core::ops::Range;

use crate::format::VOXEL_MAX;
use crate::lanes::{Lanes, Native};

/// Smallest and largest voxel of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RowRange {
    /// Smallest voxel.
    pub low: u16,
    /// Largest voxel.
    pub high: u16,
}

impl RowRange {
    /// The range of nothing: a value to fill memory with.
    pub const EMPTY: Self = Self { low: u16::MAX, high: 0 };

    /// The smallest range that holds both.
    #[inline]
    pub fn union(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    fn of(row: &[u16]) -> Self {
        if Native::SMALL {
            return Self::of_pairs(row);
        }
        row.iter().fold(Self::EMPTY, |r, &v| r.union(Self { low: v, high: v }))
    }

    /// Two at a time, which are ordered first: three comparisons in place of four.
    fn of_pairs(row: &[u16]) -> Self {
        let (pairs, rest) = row.as_chunks::<2>();
        let rest = rest.iter().map(|&v| Self { low: v, high: v });
        let pairs = pairs.iter().map(|&[a, b]| {
            let (low, high) = if a < b { (a, b) } else { (b, a) };
            Self { low, high }
        });
        pairs.chain(rest).fold(Self::EMPTY, Self::union)
    }
}

/// A slice of voxels, 12.0.
#[derive(Clone, Copy, Debug)]
pub struct Slice<'a> {
    voxels: &'a [u16],
    ranges: &'a [RowRange],
    width: usize,
    row_stride: usize,
}

/// Why memory is not a slice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SliceError {
    /// Too few voxels for the shape.
    Voxels {
        /// Voxels that the shape needs.
        needed: usize,
        /// Voxels given.
        given: usize,
    },
    /// Rows overlap: the distance between rows is below their width.
    Stride {
        /// The width, voxels.
        needed: usize,
        /// The distance given, voxels.
        given: usize,
    },
    /// Too few row ranges.
    Ranges {
        /// One a row.
        needed: usize,
        /// Ranges given.
        given: usize,
    },
    /// A voxel has more than 12 bits.
    Voxel {
        /// Row of the first such voxel.
        row: usize,
        /// Its column.
        column: usize,
        /// Its value.
        value: u16,
    },
}

impl core::fmt::Display for SliceError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Voxels { needed, given } => write!(f, "the slice needs {needed} voxels, {given} given"),
            Self::Stride { needed, given } => {
                write!(f, "rows must be at least {needed} voxels apart, {given} given")
            }
            Self::Ranges { needed, given } => write!(f, "the slice needs {needed} row ranges, {given} given"),
            Self::Voxel { row, column, value } => {
                write!(f, "voxel {value} at row {row}, column {column} is above {VOXEL_MAX}")
            }
        }
    }
}

impl core::error::Error for SliceError {}

impl<'a> Slice<'a> {
    /// Checks and measures a slice of `width` x `height` voxels whose rows start `row_stride` voxels apart, writing
    /// the range of each row to `ranges`.
    ///
    /// # Errors
    /// [`SliceError`]; `ranges` may then hold anything.
    pub fn measure(
        voxels: &'a [u16],
        width: usize,
        height: usize,
        row_stride: usize,
        ranges: &'a mut [RowRange],
    ) -> Result<Self, SliceError> {
        if row_stride < width {
            return Err(SliceError::Stride {
                needed: width,
                given: row_stride,
            });
        }
        let needed = row_stride
            .saturating_mul(height.saturating_sub(1))
            .saturating_add(if height == 0 { 0 } else { width });
        let Some(used) = voxels.get(..needed) else {
            return Err(SliceError::Voxels {
                needed,
                given: voxels.len(),
            });
        };
        let given = ranges.len();
        let Some(ranges) = ranges.get_mut(..height) else {
            return Err(SliceError::Ranges { needed: height, given });
        };
        let mut rest = used;
        for (index, range) in ranges.iter_mut().enumerate() {
            let row = rest.get(..width).unwrap_or(&[]);
            *range = RowRange::of(row);
            if range.high > VOXEL_MAX {
                let found = row.iter().enumerate().find(|(_, v)| **v > VOXEL_MAX);
                let (column, value) = found.map_or((0, range.high), |(c, v)| (c, *v));
                return Err(SliceError::Voxel {
                    row: index,
                    column,
                    value,
                });
            }
            rest = rest.get(row_stride..).unwrap_or(&[]);
        }
        Ok(Self {
            voxels: used,
            ranges,
            width,
            row_stride,
        })
    }

    /// A slice that has been measured before and copied, whole, to memory of its own.
    pub(crate) fn measured(voxels: &'a [u16], ranges: &'a [RowRange], width: usize) -> Self {
        Self {
            voxels,
            ranges,
            width,
            row_stride: width,
        }
    }

    /// Some of its columns, with the ranges of whole rows.
    pub(crate) fn columns(self, columns: Range<usize>) -> Self {
        Self {
            voxels: self.voxels.get(columns.start..).unwrap_or(&[]),
            width: columns.len(),
            ..self
        }
    }

    /// Voxels in a row.
    pub const fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub const fn height(&self) -> usize {
        self.ranges.len()
    }

    /// A row of voxels; empty where there is none.
    #[inline]
    pub fn row(&self, row: usize) -> &'a [u16] {
        let start = row * self.row_stride;
        self.voxels.get(start..start + self.width).unwrap_or(&[])
    }

    /// The range of a row; [`RowRange::EMPTY`] where there is none.
    #[inline]
    pub fn range(&self, row: usize) -> RowRange {
        self.ranges.get(row).copied().unwrap_or(RowRange::EMPTY)
    }
}

/// The slices around a sample plane. `near` and `far` enclose it; `before` and `after` are their outer neighbours,
/// which only gradients read. At a face of the volume the neighbour is absent; `far` is absent behind the last slice.
#[derive(Clone, Copy, Debug)]
pub struct Window<'a> {
    /// Slice z - 1.
    pub before: Option<Slice<'a>>,
    /// Slice z.
    pub near: Slice<'a>,
    /// Slice z + 1.
    pub far: Option<Slice<'a>>,
    /// Slice z + 2.
    pub after: Option<Slice<'a>>,
}

impl<'a> Window<'a> {
    /// The window at slice `z` of slices that can be had by number.
    pub fn at(z: i32, slice: impl Fn(i32) -> Option<Slice<'a>>) -> Option<Self> {
        Some(Self {
            before: slice(z - 1),
            near: slice(z)?,
            far: slice(z + 1),
            after: slice(z + 2),
        })
    }

    /// Some columns of all slices.
    pub(crate) fn columns(self, columns: Range<usize>) -> Self {
        let of = |slice: Slice<'a>| slice.columns(columns.clone());
        Self {
            before: self.before.map(of),
            near: of(self.near),
            far: self.far.map(of),
            after: self.after.map(of),
        }
    }

    /// The slice behind the plane, or the one before it where there is none (its weight is then zero).
    #[inline]
    pub fn far_or_near(&self) -> Slice<'a> {
        self.far.unwrap_or(self.near)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_found_in_pairs_too() {
        let row: std::vec::Vec<u16> = (0..40u16).map(|i| i.wrapping_mul(24_593) >> 4).collect();
        for first in 0..34 {
            for len in 0..7 {
                let row = &row[first..(first + len).min(row.len())];
                let (low, high) = (row.iter().copied().min(), row.iter().copied().max());
                let expected = RowRange {
                    low: low.unwrap_or(u16::MAX),
                    high: high.unwrap_or(0),
                };
                assert_eq!((RowRange::of(row), RowRange::of_pairs(row)), (expected, expected));
            }
        }
    }

    #[test]
    fn a_strided_slice_is_measured_row_by_row() {
        let voxels = [1, 2, 9, 3, 4, 9, 0, 4095];
        let mut ranges = [RowRange::EMPTY; 3];
        let s = Slice::measure(&voxels, 2, 3, 3, &mut ranges).unwrap();
        assert_eq!(
            (s.row(0), s.row(1), s.row(2), s.row(3)),
            (&[1, 2][..], &[3, 4][..], &[0, 4095][..], &[][..])
        );
        assert_eq!(s.range(2), RowRange { low: 0, high: 4095 });
        assert_eq!((s.width(), s.height()), (2, 3));
    }

    #[test]
    fn what_is_not_a_slice_is_refused_with_numbers() {
        let mut ranges = [RowRange::EMPTY; 2];
        let mut measure = |voxels: &[u16], w, h, stride| Slice::measure(voxels, w, h, stride, &mut ranges).err();
        assert_eq!(
            measure(&[0; 3], 2, 2, 2),
            Some(SliceError::Voxels { needed: 4, given: 3 })
        );
        assert_eq!(
            measure(&[0; 4], 2, 2, 1),
            Some(SliceError::Stride { needed: 2, given: 1 })
        );
        assert_eq!(
            measure(&[0; 9], 3, 3, 3),
            Some(SliceError::Ranges { needed: 3, given: 2 })
        );
        assert_eq!(
            measure(&[0, 1, 2, 4096], 2, 2, 2),
            Some(SliceError::Voxel {
                row: 1,
                column: 1,
                value: 4096
            })
        );
        assert_eq!(
            measure(&[], usize::MAX, 2, usize::MAX).map(|e| matches!(e, SliceError::Voxels { .. })),
            Some(true)
        );
    }
}
