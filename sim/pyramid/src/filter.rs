//! Filters that halve an axis, and how they meet its ends.
//!
//! | filter | weights             | voxels | for sampling by                 |
//! | ------ | ------------------- | ------ | ------------------------------- |
//! | `Two`  | (1,1)/2             | cells  | the usual box, for comparison   |
//! | `Four` | (1,1,1,1)/4         | cells  | trilinear, the paper's choice   |
//! | `Six`  | (3,2,3,3,2,3)/16    | cells  | trilinear, nearer a convolution |
//! | `Five` | (1,2,2,2,1)/8       | nodes  | trilinear, shared outer voxels  |
//!
//! Cells: voxel m of the coarse axis lies between 2m and 2m + 1 of the fine one, and the axis ends half a voxel beyond its last.
//! An odd axis has its last voxel twice; the axis is mirrored at its ends, outer voxels repeated. Nodes: voxel m lies at 2m, the
//! axis ends at its last voxel, an even axis has its last voxel twice, and the mirror stands in the outer voxels.
//!
//! Every voxel gives 1/2 of itself to the coarse axis (nodes: the outer ones, which count half, 1/4 to the outer and the rest to
//! others), so that sums (nodes: trapezoidal sums) are kept. An axis that cannot become shorter stays as it is: one voxel, or
//! two nodes.

use serde::Serialize;

/// A filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Filter {
    /// (1,1)/2 on cells.
    Two,
    /// (1,1,1,1)/4 on cells.
    Four,
    /// (3,2,3,3,2,3)/16 on cells.
    Six,
    /// (1,2,2,2,1)/8 on nodes.
    Five,
}

impl Filter {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Two, Self::Four, Self::Six, Self::Five];

    /// Its weights.
    pub const fn weights(self) -> &'static [u32] {
        match self {
            Self::Two => &[1, 1],
            Self::Four => &[1, 1, 1, 1],
            Self::Six => &[3, 2, 3, 3, 2, 3],
            Self::Five => &[1, 2, 2, 2, 1],
        }
    }

    /// log2 of the sum of its weights.
    pub const fn bits(self) -> u32 {
        match self {
            Self::Two => 1,
            Self::Four => 2,
            Self::Six => 4,
            Self::Five => 3,
        }
    }

    /// Whether voxels are nodes, and not cells.
    pub const fn on_nodes(self) -> bool {
        matches!(self, Self::Five)
    }

    /// Its name in messages and headers.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Two => "(1,1)/2",
            Self::Four => "(1,1,1,1)/4",
            Self::Six => "(3,2,3,3,2,3)/16",
            Self::Five => "(1,2,2,2,1)/8",
        }
    }

    /// What it does to an axis of `len` voxels.
    pub const fn axis(self, len: usize) -> Axis {
        let coarse = match (self.on_nodes(), len) {
            (false, 0 | 1) | (true, 0..=2) => len,
            (false, _) => len.div_ceil(2),
            (true, _) => len / 2 + 1,
        };
        Axis {
            filter: self,
            len,
            coarse,
        }
    }
}

/// An axis and the filter that halves it.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    filter: Filter,
    len: usize,
    /// Voxels of the coarse axis.
    pub coarse: usize,
}

impl Axis {
    /// Whether the axis becomes shorter.
    pub const fn is_reduced(&self) -> bool {
        self.coarse < self.len
    }

    /// log2 of the sum of the weights: 0 of an axis that stays.
    pub const fn bits(&self) -> u32 {
        if self.is_reduced() { self.filter.bits() } else { 0 }
    }

    /// The fine voxels behind the coarse voxel `at`, each below the fine axis' length, and their weights.
    pub fn taps(&self, at: usize) -> impl Iterator<Item = (usize, u32)> + use<> {
        let Self { filter, len, .. } = *self;
        let (weights, first): (&[u32], isize) = match (self.is_reduced(), filter) {
            (false, _) => (&[1], at as isize),
            (true, _) => {
                // Cells: as many to the left of 2m + 1/2 as to its right. Nodes: the middle is 2m.
                let half = (filter.weights().len() as isize - 1) / 2;
                (filter.weights(), 2 * at as isize - half)
            }
        };
        let taps = weights.iter().zip(first..);
        taps.map(move |(&weight, index)| (inside(index, len, filter.on_nodes()), weight))
    }
}

/// The voxel that stands for one outside: the axis is made even (cells) or odd (nodes) by its last voxel, then mirrored.
fn inside(index: isize, len: usize, on_nodes: bool) -> usize {
    // Filters reach two voxels beyond the ends at most, and an axis that is reduced has at least two cells or three nodes.
    let last = len as isize - 1;
    let mirrored = if on_nodes {
        let end = last + last % 2;
        if index > end { 2 * end - index } else { index.abs() }
    } else {
        let end = last + 1 - last % 2;
        match index {
            ..0 => -1 - index,
            _ if index > end => 2 * end + 1 - index,
            _ => index,
        }
    };
    mirrored.clamp(0, last) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_up() {
        for filter in Filter::ALL {
            assert_eq!(filter.weights().iter().sum::<u32>(), 1 << filter.bits());
            let name: Vec<String> = filter.weights().iter().map(u32::to_string).collect();
            assert_eq!(filter.name(), format!("({})/{}", name.join(","), 1 << filter.bits()));
            assert!(filter.weights().iter().eq(filter.weights().iter().rev()));
        }
    }

    #[test]
    fn lengths_halve() {
        let lengths = |filter: Filter| [1, 2, 3, 4, 5, 8, 9].map(|len| filter.axis(len).coarse);
        for filter in [Filter::Two, Filter::Four, Filter::Six] {
            assert_eq!(lengths(filter), [1, 1, 2, 2, 3, 4, 5]);
        }
        assert_eq!(lengths(Filter::Five), [1, 2, 2, 3, 3, 5, 5]);
    }

    /// What each fine voxel gives to the coarse axis, in parts of the sum of the weights: one half of what it counts, the
    /// repeated last voxel twice.
    #[test]
    fn sums_are_kept() {
        for filter in Filter::ALL {
            for len in 1..=70 {
                let axis = filter.axis(len);
                let mut given = vec![0; len];
                for at in 0..axis.coarse {
                    let outer = filter.on_nodes() && (at == 0 || at + 1 == axis.coarse);
                    for (voxel, weight) in axis.taps(at) {
                        given[voxel] += if outer { weight } else { 2 * weight };
                    }
                }
                let whole = 2 << axis.bits();
                let expected: Vec<u32> = (0..len)
                    .map(|voxel| match (axis.is_reduced(), filter.on_nodes()) {
                        (false, false) => whole,
                        (false, true) => {
                            if len == 1 || voxel == 0 || voxel + 1 == len {
                                whole / 2
                            } else {
                                whole
                            }
                        }
                        (true, false) if voxel + 1 == len && len % 2 == 1 => whole,
                        (true, false) => whole / 2,
                        // An even axis: the last two are one and a half.
                        (true, true) if voxel + 1 == len && len % 2 == 0 => 3 * whole / 4,
                        (true, true) if voxel == 0 || voxel + 1 == len => whole / 4,
                        (true, true) => whole / 2,
                    })
                    .collect();
                assert_eq!(given, expected, "{filter:?} {len}");
            }
        }
    }

    #[test]
    fn taps_lie_around_their_voxel() {
        let of = |filter: Filter, len, at| filter.axis(len).taps(at).map(|(voxel, _)| voxel).collect::<Vec<_>>();
        assert_eq!(of(Filter::Two, 8, 1), [2, 3]);
        assert_eq!(of(Filter::Four, 8, 0), [0, 0, 1, 2]);
        assert_eq!(of(Filter::Four, 7, 3), [5, 6, 6, 6]);
        assert_eq!(of(Filter::Six, 8, 0), [1, 0, 0, 1, 2, 3]);
        assert_eq!(of(Filter::Six, 2, 0), [1, 0, 0, 1, 1, 0]);
        assert_eq!(of(Filter::Five, 9, 0), [2, 1, 0, 1, 2]);
        assert_eq!(of(Filter::Five, 9, 4), [6, 7, 8, 7, 6]);
        assert_eq!(of(Filter::Five, 4, 2), [2, 3, 3, 3, 2]);
        assert_eq!(of(Filter::Five, 2, 1), [1]);
    }
}
