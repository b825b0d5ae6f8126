//! Neighbours along an axis: how many of them are equal, which tells labels from measurements.

use super::store::Region;
use crate::values::Values;

/// A box's slice across an axis.
pub(super) fn face(region: Region, axis: usize, at: usize) -> Region {
    let Region { mut first, mut dims } = region;
    (first[axis], dims[axis]) = (at, 1);
    Region { first, dims }
}

/// The last values of a box along an axis.
pub(super) fn far_face(values: &Values, dims: [usize; 3], axis: usize) -> Values {
    fn far<T: Copy>(values: &[T], [nx, ny, nz]: [usize; 3], axis: usize) -> Vec<T> {
        match axis {
            0 => values.chunks(nx).filter_map(|row| row.last().copied()).collect(),
            1 => {
                let rows = values.chunks(nx * ny).map(|slice| &slice[nx * (ny - 1)..]);
                rows.flatten().copied().collect()
            }
            _ => values[nx * ny * (nz - 1)..].to_vec(),
        }
    }
    match values {
        Values::I8(v) => Values::I8(far(v, dims, axis)),
        Values::U8(v) => Values::U8(far(v, dims, axis)),
        Values::I16(v) => Values::I16(far(v, dims, axis)),
        Values::U16(v) => Values::U16(far(v, dims, axis)),
        Values::I32(v) => Values::I32(far(v, dims, axis)),
        Values::U32(v) => Values::U32(far(v, dims, axis)),
        Values::F32(v) => Values::F32(far(v, dims, axis)),
        Values::F64(v) => Values::F64(far(v, dims, axis)),
    }
}

/// Pairs of neighbours that are no background, and how many of them are equal.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pairs {
    pub all: u64,
    pub equal: u64,
}

impl Pairs {
    fn add<T: Copy + PartialEq>(&mut self, a: &[T], b: &[T], background: Option<T>) {
        for (a, b) in a.iter().zip(b) {
            let counts = background.is_none_or(|background| *a != background && *b != background);
            self.all += u64::from(counts);
            self.equal += u64::from(counts && a == b);
        }
    }

    /// Of a block, along an axis of the file; `before` lies before it along the axis.
    pub fn of<T: Copy + PartialEq>(
        block: &[T],
        before: &[T],
        [nx, ny, _]: [usize; 3],
        axis: usize,
        background: Option<T>,
    ) -> Self {
        let mut pairs = Self::default();
        // A line across the axis, of which the next one is a neighbour, and how many make a whole.
        let (line, whole) = match axis {
            0 => (1, nx),
            1 => (nx, nx * ny),
            _ => (nx * ny, block.len()),
        };
        for part in block.chunks(whole.max(1)) {
            pairs.add(part, part.get(line..).unwrap_or(&[]), background);
        }
        for (before, part) in before.chunks(line.max(1)).zip(block.chunks(whole.max(1))) {
            pairs.add(before, part, background);
        }
        pairs
    }

    pub fn with(self, other: Self) -> Self {
        Self {
            all: self.all + other.all,
            equal: self.equal + other.equal,
        }
    }
}
