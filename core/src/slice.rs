//! Voxel slices: borrowed memory whose shape and values have been checked once.
//!
//! A [`Slice`] can only be made by measuring its voxels, so every slice guarantees three things: every row has
//! `width` voxels, every voxel is at most 4095, and every row's range is known (rows that classify to nothing are
//! never read again).

use core::fmt::Debug;
use core::marker::PhantomData;
use core::ops::Range;

use crate::format::VOXEL_MAX;
use crate::lanes::{Lanes, Native};

/// What a slice is made of.
pub trait Voxel: Copy + Debug + Send + Sync + 'static {
    /// Words of 16 bits that a voxel has.
    const WORDS: usize;
    /// A slice as a stream is given it, row after row.
    type Given<'g>: Copy;

    /// A slice given as the words that a ring keeps.
    fn given(words: &[u16]) -> Self::Given<'_>;

    /// Checks what is kept of a slice, and keeps its words and the range of each row.
    ///
    /// # Errors
    /// [`SliceError`]; what is kept may then be anything.
    fn keep(
        given: Self::Given<'_>,
        region: Region,
        words: &mut [u16],
        ranges: &mut [RowRange],
    ) -> Result<(), SliceError>;
}

/// What is kept of a slice of a volume.
#[derive(Clone, Copy, Debug)]
pub struct Region {
    /// Width and height of the slice.
    pub whole: [usize; 2],
    /// The first column and the first row that are kept.
    pub first: [usize; 2],
    /// How many.
    pub size: [usize; 2],
}

impl Region {
    /// All of a slice.
    pub const fn all(size: [usize; 2]) -> Self {
        Self {
            whole: size,
            first: [0; 2],
            size,
        }
    }

    /// Where the kept voxels begin among so many that are given, and how far their rows are apart: among those of the whole
    /// slice, or among themselves alone.
    pub(crate) fn within(&self, given: usize) -> Result<(usize, usize), SliceError> {
        let ([width, height], [columns, rows], [column, row]) = (self.whole, self.size, self.first);
        let needed = columns * rows;
        if given == needed {
            Ok((0, columns))
        } else if given == width * height {
            Ok((row * width + column, width))
        } else {
            Err(SliceError::Voxels { needed, given })
        }
    }
}

/// A value of 12 bits, which a transfer function classifies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Code12;

impl Voxel for Code12 {
    const WORDS: usize = 1;
    type Given<'g> = &'g [u16];

    #[inline(always)]
    fn given(words: &[u16]) -> &[u16] {
        words
    }

    #[inline(always)]
    fn keep(given: &[u16], region: Region, words: &mut [u16], ranges: &mut [RowRange]) -> Result<(), SliceError> {
        let ([width, height], (start, stride)) = (region.size, region.within(given.len())?);
        let given = given.get(start..).unwrap_or(&[]);
        Slice::measure(given, width, height, stride, ranges)?;
        for (kept, row) in words.chunks_exact_mut(width.max(1)).zip(given.chunks(stride.max(1))) {
            if let Some(row) = row.get(..kept.len()) {
                kept.copy_from_slice(row);
            }
        }
        Ok(())
    }
}

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

/// A slice of voxels: 12.0, or another kind of them.
#[derive(Clone, Copy, Debug)]
pub struct Slice<'a, X = Code12> {
    voxels: &'a [u16],
    ranges: &'a [RowRange],
    width: usize,
    row_stride: usize,
    voxel: PhantomData<X>,
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
        /// Row of the first such voxel, of those that are kept.
        row: usize,
        /// Its column, likewise.
        column: usize,
        /// Its value.
        value: u16,
    },
    /// A voxel of colour and extinction has a code of more than 15 bits, or a colour above its extinction.
    Colour {
        /// Row of the first such voxel.
        row: usize,
        /// Its column.
        column: usize,
        /// Its extinction, and red, green and blue times extinction.
        codes: [u16; 4],
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
            Self::Colour { row, column, codes } => {
                let [extinction, colours @ ..] = codes;
                write!(
                    f,
                    "voxel at row {row}, column {column} has the extinction {extinction} and colours {colours:?}; accepted: \
                     an extinction of at most 32767, and colours of at most the extinction"
                )
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
            voxel: PhantomData,
        })
    }
}

impl<'a, X: Voxel> Slice<'a, X> {
    /// A slice that has been measured before and copied, whole, to memory of its own.
    pub(crate) fn measured(voxels: &'a [u16], ranges: &'a [RowRange], width: usize) -> Self {
        Self {
            voxels,
            ranges,
            width,
            row_stride: X::WORDS * width,
            voxel: PhantomData,
        }
    }

    /// One of the runs that a whole row consists of, as a slice of single words; they need not be of 12 bits.
    pub(crate) fn run(self, number: usize) -> Slice<'a> {
        // No division: the words of a voxel are a power of two.
        let start = number * (self.row_stride >> X::WORDS.ilog2());
        Slice {
            voxels: self.voxels.get(start..).unwrap_or(&[]),
            ranges: self.ranges,
            width: self.width,
            row_stride: self.row_stride,
            voxel: PhantomData,
        }
    }

    /// The words of a whole row.
    #[inline]
    pub fn words(&self, row: usize) -> &'a [u16] {
        let start = row * self.row_stride;
        self.voxels.get(start..start + X::WORDS * self.width).unwrap_or(&[])
    }

    /// Some of its columns, with the ranges of whole rows.
    pub(crate) fn columns(self, columns: Range<usize>) -> Self {
        Self {
            voxels: self.voxels.get(columns.start..).unwrap_or(&[]),
            width: columns.len(),
            ..self
        }
    }

    /// Few columns, whose ranges are found when they are asked for.
    pub(crate) fn of_few(self) -> Self {
        Self { ranges: &[], ..self }
    }

    /// Voxels in a row.
    pub const fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub const fn height(&self) -> usize {
        self.ranges.len()
    }

    /// A row of voxels, or the first word of each; empty where there is none.
    #[inline]
    pub fn row(&self, row: usize) -> &'a [u16] {
        let start = row * self.row_stride;
        self.voxels.get(start..start + self.width).unwrap_or(&[])
    }

    /// The range of a row; [`RowRange::EMPTY`] where there is none.
    #[inline]
    pub fn range(&self, row: usize) -> RowRange {
        self.ranges.get(row).copied().unwrap_or_else(|| self.range_of_few(row))
    }

    /// The range of a row of few columns.
    #[cold]
    #[inline(never)]
    fn range_of_few(&self, row: usize) -> RowRange {
        RowRange::of(self.row(row))
    }
}

/// The slices around a sample plane. `near` and `far` enclose it; `before` and `after` are their outer neighbours,
/// which only gradients read. At a face of the volume the neighbour is absent; `far` is absent behind the last slice.
#[derive(Clone, Copy, Debug)]
pub struct Window<'a, X = Code12> {
    /// Slice z - 1.
    pub before: Option<Slice<'a, X>>,
    /// Slice z.
    pub near: Slice<'a, X>,
    /// Slice z + 1.
    pub far: Option<Slice<'a, X>>,
    /// Slice z + 2.
    pub after: Option<Slice<'a, X>>,
}

impl<'a, X: Voxel> Window<'a, X> {
    /// The window at slice `z` of slices that can be had by number.
    pub fn at(z: i32, slice: impl Fn(i32) -> Option<Slice<'a, X>>) -> Option<Self> {
        Some(Self {
            before: slice(z - 1),
            near: slice(z)?,
            far: slice(z + 1),
            after: slice(z + 2),
        })
    }

    /// Some columns of all slices.
    pub(crate) fn columns(self, columns: Range<usize>) -> Self {
        let of = |slice: Slice<'a, X>| slice.columns(columns.clone());
        Self {
            before: self.before.map(of),
            near: of(self.near),
            far: self.far.map(of),
            after: self.after.map(of),
        }
    }

    /// Slices of few columns ([`Slice::of_few`]).
    pub(crate) fn of_few(self) -> Self {
        Self {
            before: self.before.map(Slice::of_few),
            near: self.near.of_few(),
            far: self.far.map(Slice::of_few),
            after: self.after.map(Slice::of_few),
        }
    }

    /// One of the runs of all slices' rows ([`Slice::run`]).
    pub(crate) fn run(self, number: usize) -> Window<'a> {
        let of = |slice: Slice<'a, X>| slice.run(number);
        Window {
            before: self.before.map(of),
            near: of(self.near),
            far: self.far.map(of),
            after: self.after.map(of),
        }
    }

    /// The slice behind the plane, or the one before it where there is none (its weight is then zero).
    #[inline]
    pub fn far_or_near(&self) -> Slice<'a, X> {
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
