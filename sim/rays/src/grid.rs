//! The voxels that a ray looks at: the volume in the slice frame, continued by one voxel beyond its faces.

use slicecast::locate::Cell;
use slicecast::plan::Plan;
use slicecast::view::Axis;

use super::{Cells, Corners};
use slicecast_volume::Volume;

/// A volume in the slice frame.
pub(super) struct Grid<'a> {
    voxels: &'a [u16],
    /// Last voxels along i, j, k.
    pub(super) last: [i32; 3],
    /// Where voxel (0, 0, 0) lies, and how far its neighbours are.
    start: isize,
    pub(super) stride: [isize; 3],
}

impl<'a> Grid<'a> {
    pub(super) fn of(volume: &'a Volume, plan: &Plan) -> Self {
        let [nx, ny, _] = volume.dims.map(|side| side as isize);
        let [i, j, mut k] = match plan.view().major() {
            Axis::X => [nx, nx * ny, 1],
            Axis::Y => [1, nx * ny, nx],
            Axis::Z => [1, nx, nx * ny],
        };
        let last = plan.volume().map(|side| side as i32 - 1);
        let mut start = 0;
        if plan.view().reversed() {
            start = last[2] as isize * k;
            k = -k;
        }
        Self {
            voxels: &volume.voxels,
            last,
            start,
            stride: [i, j, k],
        }
    }

    /// Whether a sample of this cell and all its neighbours look at voxels that exist.
    #[inline(always)]
    pub(super) fn is_inner(&self, cells: Cells) -> bool {
        let inner = |(cell, last): (&Cell, &i32)| 1 <= cell.index && cell.index < last - 1;
        cells.iter().zip(&self.last).all(inner)
    }

    /// Where the first voxel of an inner cell lies.
    #[inline(always)]
    pub(super) fn place(&self, [x, y, z]: Cells) -> isize {
        let [i, j, k] = self.stride;
        self.start + x.index as isize * i + y.index as isize * j + z.index as isize * k
    }

    /// The voxels from a place on.
    #[inline(always)]
    pub(super) fn corners(&self, at: isize) -> Corners {
        let [i, j, k] = self.stride;
        let voxel = |offset: isize| self.voxels[(at + offset) as usize] as i16;
        [
            [[voxel(0), voxel(i)], [voxel(j), voxel(i + j)]],
            [[voxel(k), voxel(i + k)], [voxel(j + k), voxel(i + j + k)]],
        ]
    }

    /// A voxel; the last one stands for those behind it.
    pub(super) fn voxel(&self, ijk: [i32; 3]) -> i32 {
        let mut at = self.start;
        for ((place, last), stride) in ijk.into_iter().zip(self.last).zip(self.stride) {
            at += place.min(last) as isize * stride;
        }
        i32::from(self.voxels[at as usize])
    }

    /// The voxel nearest to a sample, halves up, and its neighbours, `[z][y][x]`; beyond a face the last one is repeated.
    pub(super) fn about(&self, cells: Cells) -> [[[u16; 3]; 3]; 3] {
        let [i, j, k] = cells.map(|c| {
            if c.weight.to_bits() >= 0x8000 {
                c.index + 1
            } else {
                c.index
            }
        });
        let voxel = |place: [i32; 3]| self.voxel(place.map(|c| c.max(0))) as u16;
        [-1, 0, 1].map(|z| [-1, 0, 1].map(|y| [-1, 0, 1].map(|x| voxel([i + x, j + y, k + z]))))
    }

    /// The volume continued by one voxel along i and j. Further out only weights of 0 reach.
    pub(super) fn continued(&self, [i, j, k]: [i32; 3]) -> i32 {
        let [ni, nj, _] = self.last.map(|last| last + 1);
        beyond(i.min(ni), ni, |i| beyond(j.min(nj), nj, |j| self.voxel([i, j, k])))
    }

    /// `V[k+1] - V[k-1]`, the volume continued along k.
    pub(super) fn derivative(&self, [i, j, k]: [i32; 3]) -> i32 {
        let last = self.last[2];
        let along_k = |k: i32| beyond(k, last + 1, |k| self.voxel([i, j, k]));
        let k = k.min(last);
        along_k(k + 1) - along_k(k - 1)
    }
}

/// A line of `n` voxels continued linearly by one at each end; a single voxel is continued with itself.
fn beyond(place: i32, n: i32, line: impl Fn(i32) -> i32) -> i32 {
    match place {
        _ if n == 1 => line(0),
        -1 => 2 * line(0) - line(1),
        p if p == n => 2 * line(n - 1) - line(n - 2),
        p => line(p),
    }
}
