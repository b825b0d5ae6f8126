//! A volume cut into boxes of several levels, and the order in which rays meet them.
//!
//! Each cut is a plane across one axis that divides all of its node, so that rays pass from one side of it to the other and never
//! back: the side that lies against their direction comes first. `docs/contract/levels.md` has the proof.

use std::ops::Range;

use crate::error::LevelsError;

/// A node of the tree.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Tree {
    /// A box of this level: its voxels are 2^level as long as the volume's.
    Leaf(u32),
    /// A cut.
    Cut {
        /// The axis that it lies across: 0 is x, 1 is y, 2 is z.
        axis: usize,
        /// The first voxel of the volume behind it.
        at: usize,
        /// What lies before it and what behind it.
        parts: Box<[Self; 2]>,
    },
}

/// A box of a volume and its level.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Leaf {
    /// Its voxels along x, y and z, of the volume.
    pub voxels: [Range<usize>; 3],
    /// Its level.
    pub level: u32,
}

impl Leaf {
    /// Voxels of its level along x, y and z.
    pub fn dims(&self) -> [usize; 3] {
        self.voxels.each_ref().map(|side| side.len().div_ceil(1 << self.level))
    }

    /// Voxels of its level that are held along x, y and z, of a volume of this size: two more on each side, as far as there are.
    pub fn held(&self, dims: [usize; 3]) -> [usize; 3] {
        [0, 1, 2].map(|axis| {
            let last = dims[axis].div_ceil(1 << self.level);
            let first = (self.voxels[axis].start >> self.level).saturating_sub(2);
            (self.voxels[axis].end.div_ceil(1 << self.level) + 2).min(last) - first
        })
    }
}

impl Tree {
    /// The tree of a grid of equal bricks with a level each: halves of halves, as far as a node has bricks of several levels. Bricks
    /// have `side` voxels along each axis, the last along an axis fewer.
    pub fn of_grid(dims: [usize; 3], side: usize, level: &dyn Fn([usize; 3]) -> u32) -> Self {
        let bricks = dims.map(|voxels| 0..voxels.div_ceil(side));
        Self::of_bricks(&bricks, side, level)
    }

    fn of_bricks(bricks: &[Range<usize>; 3], side: usize, level: &dyn Fn([usize; 3]) -> u32) -> Self {
        let [x, y, z] = bricks;
        let mut levels = (z.clone())
            .flat_map(|k| y.clone().flat_map(move |j| x.clone().map(move |i| [i, j, k])))
            .map(level);
        let first = levels.next().unwrap_or(0);
        if levels.all(|level| level == first) {
            return Self::Leaf(first);
        }
        let axis = (0..3).max_by_key(|axis| bricks[*axis].len()).unwrap_or(0);
        let middle = bricks[axis].start + bricks[axis].len() / 2;
        let part = |range: Range<usize>| {
            let mut bricks = bricks.clone();
            bricks[axis] = range;
            Self::of_bricks(&bricks, side, level)
        };
        Self::Cut {
            axis,
            at: middle * side,
            parts: Box::new([part(bricks[axis].start..middle), part(middle..bricks[axis].end)]),
        }
    }

    /// The boxes of a volume of this size, in the order of rays that rise or fall along x, y and z.
    ///
    /// # Errors
    /// [`LevelsError`] for a cut that lies beside its node, and a box with a face within a voxel of its level.
    pub fn leaves(&self, dims: [usize; 3], rising: [bool; 3]) -> Result<Vec<Leaf>, LevelsError> {
        let mut leaves = Vec::new();
        self.collect(dims, &dims.map(|side| 0..side), rising, &mut leaves)?;
        Ok(leaves)
    }

    fn collect(
        &self,
        dims: [usize; 3],
        voxels: &[Range<usize>; 3],
        rising: [bool; 3],
        leaves: &mut Vec<Leaf>,
    ) -> Result<(), LevelsError> {
        match self {
            Self::Leaf(level) => {
                let whole = |at: usize| at.is_multiple_of(1 << level);
                for (side, all) in voxels.iter().zip(dims) {
                    if !whole(side.start) || (side.end < all && !whole(side.end)) {
                        let [from, to] = [side.start, side.end];
                        return Err(LevelsError::Face {
                            level: *level,
                            from,
                            to,
                        });
                    }
                }
                leaves.push(Leaf {
                    voxels: voxels.clone(),
                    level: *level,
                });
            }
            Self::Cut { axis, at, parts } => {
                let [from, to] = [voxels[*axis].start, voxels[*axis].end];
                if *at <= from || *at >= to {
                    return Err(LevelsError::Cut { at: *at, from, to });
                }
                let [before, behind] = &**parts;
                let mut sides = [(before, from..*at), (behind, *at..to)];
                if !rising[*axis] {
                    sides.reverse();
                }
                for (part, range) in sides {
                    let mut voxels = voxels.clone();
                    voxels[*axis] = range;
                    part.collect(dims, &voxels, rising, leaves)?;
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_level_is_one_box() {
        let tree = Tree::of_grid([100, 33, 9], 16, &|_| 2);
        assert_eq!(tree, Tree::Leaf(2));
        let leaves = tree.leaves([100, 33, 9], [true; 3]).unwrap();
        assert_eq!(leaves.len(), 1);
        assert_eq!(leaves[0].dims(), [25, 9, 3]);
    }

    /// Every voxel is in one box, of its brick's level; the reversed directions give the reversed order.
    #[test]
    fn boxes_of_a_grid_are_its_bricks() {
        let (dims, side) = ([37, 24, 50], 8);
        let level = |[i, j, k]: [usize; 3]| ((i * 7 + j * 3 + k * 5) % 4) as u32;
        let tree = Tree::of_grid(dims, side, &level);
        let leaves = tree.leaves(dims, [true, false, true]).unwrap();
        let mut seen = vec![0; dims.iter().product()];
        for Leaf {
            voxels: [x, y, z],
            level: of_box,
        } in &leaves
        {
            for (k, j, i) in z
                .clone()
                .flat_map(|k| y.clone().flat_map(move |j| x.clone().map(move |i| (k, j, i))))
            {
                seen[(k * dims[1] + j) * dims[0] + i] += 1;
                assert_eq!(level([i / side, j / side, k / side]), *of_box);
            }
        }
        assert!(seen.iter().all(|count| *count == 1));
        let mut back = tree.leaves(dims, [false, true, false]).unwrap();
        back.reverse();
        assert_eq!(leaves, back);
    }

    #[test]
    fn faces_lie_between_voxels_of_their_level() {
        let cut = |at, levels: [u32; 2]| Tree::Cut {
            axis: 0,
            at,
            parts: Box::new(levels.map(Tree::Leaf)),
        };
        let refused = |tree: Tree| tree.leaves([20; 3], [true; 3]).unwrap_err();
        assert!(cut(4, [2, 1]).leaves([20; 3], [true; 3]).is_ok());
        assert_eq!(
            refused(cut(4, [3, 1])),
            LevelsError::Face {
                level: 3,
                from: 0,
                to: 4
            }
        );
        assert_eq!(
            refused(cut(3, [0, 1])),
            LevelsError::Face {
                level: 1,
                from: 3,
                to: 20
            }
        );
        assert_eq!(
            refused(cut(20, [0, 0])),
            LevelsError::Cut {
                at: 20,
                from: 0,
                to: 20
            }
        );
    }
}
