//! Crop boxes: the part of a volume that a plan shows, to a fraction of a voxel, and the voxels that it needs.
//!
//! Source: `docs/contract/crop.md`. A cropped plan is the plan of the whole volume, of whose segments the box cuts more.
//!
//! | value | format | unit |
//! |---|---|---|
//! | face of a box | s15.16 | voxels; 0 is the centre of the volume's first voxel |
//! | voxels held, first .. end | 16.0 | voxels along i, j, k |
//!
//! Rounding: none. Overflow: none inside a `Plan`. State: none.

use crate::borders::Borders;
use crate::format::Position;

/// A box along x, y and z to which a plan is cropped ([`Plan::with_crop`](crate::plan::Plan::with_crop)), in voxels: 0 is the
/// centre of the first voxel. Where it reaches beyond the volume it ends there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    /// Its low faces.
    pub low: [Position; 3],
    /// Its high faces, each above the low one.
    pub high: [Position; 3],
}

impl Crop {
    /// What no volume reaches beyond: the box that cuts nothing.
    pub const NONE: Self = Self {
        low: [Position::MIN; 3],
        high: [Position::MAX; 3],
    };
}

/// The two faces of a box along one axis of the slice frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Faces {
    pub(crate) low: Position,
    pub(crate) high: Position,
    /// Whether rays along the high face belong to the box behind it.
    pub(crate) open: bool,
}

impl Faces {
    /// Of a volume with so many voxels along the axis.
    pub(crate) const fn of(voxels: u32, borders: Borders) -> Self {
        let beyond = if matches!(borders, Borders::Cells) { 1 << 15 } else { 0 };
        Self {
            low: Position::from_bits(-beyond),
            high: Position::from_bits(((voxels as i32 - 1) << 16) + beyond),
            open: false,
        }
    }

    /// What lies between these faces and others as well; nothing is left where the low one is not below the high one.
    pub(crate) const fn and(self, [low, high]: [Position; 2]) -> Self {
        Self {
            low: if low.to_bits() > self.low.to_bits() {
                low
            } else {
                self.low
            },
            high: if high.to_bits() < self.high.to_bits() {
                high
            } else {
                self.high
            },
            open: self.open,
        }
    }

    /// Whether nothing lies between them.
    pub(crate) const fn is_empty(self) -> bool {
        self.low.to_bits() >= self.high.to_bits()
    }

    /// The first voxel, of so many, that samples between them look at, and how many: middles of segments lie up to half a voxel
    /// beyond a face, and gradients look at one voxel more.
    pub(crate) const fn held(self, voxels: u32) -> (u32, u32) {
        let (half, last) = (1i64 << 15, voxels as i64 - 1);
        let first = ((self.low.to_bits() as i64 - half) >> 16) - 1;
        let end = -((-(self.high.to_bits() as i64 + half)) >> 16) + 1;
        let first = if first > 0 { first } else { 0 };
        let end = if end < last { end } else { last };
        (first as u32, (end - first + 1) as u32)
    }

    /// The same box seen from the other end of an axis with so many voxels.
    pub(crate) const fn reversed([low, high]: [Position; 2], voxels: u32) -> [Position; 2] {
        let last = (voxels as i32 - 1) << 16;
        [
            Position::from_bits(last.saturating_sub(high.to_bits())),
            Position::from_bits(last.saturating_sub(low.to_bits())),
        ]
    }
}
