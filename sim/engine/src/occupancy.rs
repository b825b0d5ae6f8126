//! What blocks of a volume hold, so that those which a table makes invisible are never interpolated.
//!
//! Samples of a block of columns lie between the smallest and the largest of the voxels around them. These ranges are
//! measured once per volume and axis ([`Occupancy::of`]). For each table their counts say which share of the blocks can be
//! seen ([`Occupancy::share`]); where it is small the ranges are turned into a bit a block ([`Occupancy::sight`]), which
//! core's plane layer asks before it makes anything.

use std::sync::OnceLock;

use rayon::prelude::*;
use slicecast::borders::Borders;
use slicecast::classify::Support;
use slicecast::plan::Plan;
use slicecast::plane::Shape;
use slicecast::seen::{Grain, Seen};
use slicecast::slice::{RowRange, Slice};

/// Codes are kept in steps of 64, which is as fine as a table's support knows them.
const STEP: u32 = 6;

/// Smallest and largest step of a block's voxels.
type Steps = [u8; 2];

/// How many steps there are.
const STEPS: usize = 64;

/// The range of every block of a volume, for views along one axis and direction.
#[derive(Clone, Debug)]
pub struct Occupancy {
    /// Of samples that lie in a slice.
    inside: Ranges,
    /// Of samples between a slice and the next.
    between: Ranges,
    /// Of slabs between a slice and the next; made when they are first asked for.
    slabs: OnceLock<Ranges>,
    grain: Grain,
    /// Blocks of a row.
    blocks: usize,
    /// Rows of a slice.
    height: usize,
}

/// What a pipeline looks at of a slice and the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Looks {
    /// Samples that lie in slices.
    Slices,
    /// Samples of single planes.
    Planes,
    /// Samples of a plane and of the one in front of it, which lie up to a voxel beside each other.
    Slabs,
}

impl Looks {
    /// What pipelines of a shape look at for the planes of a view.
    pub fn of(shape: Shape, plan: &Plan) -> Self {
        if shape.slabs {
            Self::Slabs
        } else {
            Self::of_planes(plan)
        }
    }

    fn of_planes(plan: &Plan) -> Self {
        let [_, _, step] = plan.step();
        // Of nodes, planes lie in the middle between slices.
        if step.frac() == 0 && plan.borders() != Borders::Nodes {
            Self::Slices
        } else {
            Self::Planes
        }
    }
}

/// Ranges of all blocks.
#[derive(Clone, Debug)]
struct Ranges {
    /// Block after block, row after row, slice after slice.
    steps: Vec<Steps>,
    /// How many blocks have each range: the smallest step times [`STEPS`], and the largest.
    counts: Vec<usize>,
}

impl Ranges {
    fn of(steps: Vec<Steps>) -> Self {
        let none = || vec![0; STEPS * STEPS];
        let place = |[low, high]: Steps| STEPS * usize::from(low) + usize::from(high);
        let count = |mut counts: Vec<usize>, steps: &[Steps]| {
            for steps in steps {
                counts[place(*steps)] += 1;
            }
            counts
        };
        let sum = |mut counts: Vec<usize>, others: Vec<usize>| {
            counts.iter_mut().zip(others).for_each(|(count, other)| *count += other);
            counts
        };
        let counts = steps.par_chunks(1 << 16).fold(none, count).reduce(none, sum);
        Self { steps, counts }
    }
}

/// Which blocks of a volume can show something under a table.
#[derive(Clone, Debug)]
pub struct Sight {
    rows: Vec<u64>,
    grain: Grain,
    height: usize,
}

impl Occupancy {
    /// Measures slices, in parallel. Memory: 4 bytes for 16 voxels, and 64 KiB.
    pub fn of(slices: &[Slice<'_>]) -> Self {
        let [width, height] = slices.first().map_or([0; 2], |slice| [slice.width(), slice.height()]);
        let grain = Grain::of(width);
        let blocks = width.div_ceil(grain.columns());
        let row_len = blocks.max(1);
        let slice_len = row_len * height.max(1);
        let mut inside = vec![[u8::MAX, 0]; blocks * height * slices.len()];
        inside.par_chunks_mut(slice_len).zip(slices).for_each(|(out, slice)| {
            for (row, out) in out.chunks_mut(row_len).enumerate() {
                measure(slice.row(row), grain, out);
            }
            // Each row with the next one, which is as it was measured when its turn comes.
            for block in 0..out.len() - row_len {
                out[block] = union(out[block], out[block + row_len]);
            }
        });
        let mut between = inside.clone();
        between
            .par_iter_mut()
            .zip(&inside[slice_len.min(inside.len())..])
            .for_each(|(near, far)| *near = union(*near, *far));
        Self {
            inside: Ranges::of(inside),
            between: Ranges::of(between),
            slabs: OnceLock::new(),
            grain,
            blocks,
            height,
        }
    }

    /// The ranges of what a pipeline looks at.
    fn ranges(&self, looks: Looks) -> &Ranges {
        match looks {
            Looks::Slices => &self.inside,
            Looks::Planes => &self.between,
            Looks::Slabs => self.slabs.get_or_init(|| self.of_slabs()),
        }
    }

    /// Ranges of slabs: those of a block with its neighbours', of the row before and the row behind as well.
    fn of_slabs(&self) -> Ranges {
        let row_len = self.blocks.max(1);
        let slice_len = row_len * self.height.max(1);
        let steps = &self.between.steps;
        let mut slabs = vec![[u8::MAX, 0]; steps.len()];
        let slices = slabs.par_chunks_mut(slice_len).zip(steps.par_chunks(slice_len));
        slices.for_each(|(out, steps)| {
            let rows = steps.len() / row_len;
            for (row, out) in out.chunks_mut(row_len).enumerate() {
                for (block, out) in out.iter_mut().enumerate() {
                    for row in row.saturating_sub(1)..(row + 2).min(rows) {
                        for block in block.saturating_sub(1)..(block + 2).min(row_len) {
                            *out = union(*out, steps[row * row_len + block]);
                        }
                    }
                }
            }
        });
        Ranges::of(slabs)
    }

    /// The share of blocks that can show something under a table, 0 to 1.
    pub fn share(&self, looks: Looks, support: Support) -> f64 {
        let ranges = self.ranges(looks);
        let next = next_visible(support);
        let by_low = next.iter().zip(ranges.counts.chunks_exact(STEPS));
        let seen: usize = by_low
            .flat_map(|(next, counts)| counts.iter().skip(usize::from(*next)))
            .sum();
        seen as f64 / ranges.steps.len().max(1) as f64
    }

    /// The blocks that can show something under a table; in parallel.
    pub fn sight(&self, looks: Looks, support: Support) -> Sight {
        let next = next_visible(support);
        let steps = &self.ranges(looks).steps;
        let mut rows = vec![0; steps.len() / self.blocks.max(1)];
        (rows.par_iter_mut().with_min_len(1024))
            .zip(steps.par_chunks(self.blocks.max(1)))
            .for_each(|(row, steps)| {
                for (block, [low, high]) in steps.iter().enumerate() {
                    *row |= u64::from(next[usize::from(*low)] <= *high) << block;
                }
            });
        Sight {
            rows,
            grain: self.grain,
            height: self.height,
        }
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        let bytes = |ranges: &Ranges| size_of_val(&ranges.steps[..]) + size_of_val(&ranges.counts[..]);
        bytes(&self.inside) + bytes(&self.between) + self.slabs.get().map_or(0, bytes)
    }
}

impl Sight {
    /// The blocks of planes at a slice, or between it and the next.
    pub fn at(&self, slice: usize) -> Seen<'_> {
        let start = slice.saturating_mul(self.height);
        let rows = start..start.saturating_add(self.height);
        Seen::new(self.rows.get(rows).unwrap_or(&[]), self.grain)
    }
}

/// For each step the first that is visible, from it on; 255 where none is.
fn next_visible(support: Support) -> [u8; STEPS] {
    let mut next = [u8::MAX; STEPS];
    let mut found = u8::MAX;
    for step in (0..STEPS as u8).rev() {
        let code = u16::from(step) << STEP;
        if support.meets(RowRange { low: code, high: code }) {
            found = step;
        }
        next[usize::from(step)] = found;
    }
    next
}

/// Ranges of the blocks of a row: a block's samples look at the first voxel behind it as well.
fn measure(row: &[u16], grain: Grain, out: &mut [Steps]) {
    for (block, out) in out.iter_mut().enumerate() {
        let voxels = &row[block * grain.columns()..];
        let voxels = &voxels[..voxels.len().min(grain.columns() + 1)];
        let low = voxels.iter().fold(u16::MAX, |low, v| low.min(*v));
        let high = voxels.iter().fold(0, |high, v| high.max(*v));
        *out = [low, high].map(|code| (code >> STEP) as u8);
    }
}

/// The smallest range that holds both.
fn union([low, high]: Steps, [other_low, other_high]: Steps) -> Steps {
    [low.min(other_low), high.max(other_high)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;
    use slicecast::format::Direction;
    use slicecast::plan::{Sampling, Spacing};
    use slicecast::view::View;

    /// A plan straight along z.
    fn plan(dims: [usize; 3], planes_per_voxel: u32) -> Plan {
        let view = View::new([Direction::ZERO, Direction::ZERO, Direction::ONE]).unwrap();
        let sampling = Sampling {
            planes_per_voxel,
            rays_per_voxel: 1,
        };
        Plan::whole(view, dims.map(|side| side as u32), Spacing::CUBIC, sampling).unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 300, rng_seed: RngSeed::Fixed(64), failure_persistence: None, ..ProptestConfig::default() })]

        /// A bit is what the table's support says of all voxels around the block's samples.
        #[test]
        fn bits_are_the_support_of_the_voxels_around(
            dims in (1usize..70, 1usize..5, 1usize..5),
            few in prop::collection::vec((any::<u32>(), 0u16..=4095), 0..9),
            ground in 0u16..=4095,
            visible in any::<u64>(),
            sparse in any::<u64>(),
            between in any::<bool>(),
        ) {
            let dims = [dims.0, dims.1, dims.2];
            let [nx, ny, nz] = dims;
            let mut voxels = vec![ground; nx * ny * nz];
            for (place, value) in few {
                let len = voxels.len();
                voxels[place as usize % len] = value;
            }
            let visible = visible & sparse;
            let support = Support::of((0..4096).map(|code| visible >> (code >> 6) & 1 != 0));
            let mut ranges = vec![RowRange::EMPTY; ny * nz];
            let slices: Vec<_> = (voxels.chunks(nx * ny).zip(ranges.chunks_mut(ny)))
                .map(|(voxels, ranges)| Slice::measure(voxels, nx, ny, nx, ranges).unwrap())
                .collect();
            let occupancy = Occupancy::of(&slices);
            let plan = plan(dims, if between { 3 } else { 1 });
            let sight = occupancy.sight(Looks::of_planes(&plan), support);
            let mut seen = 0;
            for (z, y) in (0..nz).flat_map(|z| (0..ny).map(move |y| (z, y))) {
                let mut expected = 0;
                for first in (0..nx).step_by(16) {
                    let mut range = RowRange::EMPTY;
                    let last = |first: usize, side: usize| (first + 1).min(side - 1);
                    for k in z..=if between { last(z, nz) } else { z } {
                        for j in y..=last(y, ny) {
                            for v in &voxels[(k * ny + j) * nx..][first..=(first + 16).min(nx - 1)] {
                                range = range.union(RowRange { low: *v, high: *v });
                            }
                        }
                    }
                    expected |= u64::from(support.meets(range)) << (first / 16);
                }
                prop_assert_eq!(sight.at(z).row(y), expected, "slice {}, row {}", z, y);
                seen += expected.count_ones() as usize;
            }
            let share = seen as f64 / (nx.div_ceil(16) * ny * nz) as f64;
            prop_assert!((occupancy.share(Looks::of_planes(&plan), support) - share).abs() < 1e-12);
        }
    }
}
