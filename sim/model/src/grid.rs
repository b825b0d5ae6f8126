//! The volume's voxels in the frame (i, j, k), continued by one voxel beyond each face.

use super::rays::Geometry;
use slicecast_volume::Volume;

/// The voxels of a volume, addressed in the frame of a view. Values are 12-bit code units.
#[derive(Clone, Copy, Debug)]
pub struct Grid<'a> {
    voxels: &'a [u16],
    dims: [usize; 3],
    /// Index of voxel (0, 0, 0) of the frame.
    first: isize,
    /// Index steps along i, j and k.
    stride: [isize; 3],
}

impl<'a> Grid<'a> {
    /// Addresses `volume` in the frame of `geometry`.
    ///
    /// # Panics
    /// If the number of voxels is not the product of the dimensions, or the geometry is another volume's.
    pub fn new(volume: &'a Volume, geometry: &Geometry) -> Self {
        let [nx, ny, nz] = volume.dims;
        assert_eq!(volume.voxels.len(), nx * ny * nz, "voxels of {}", volume.name);
        assert_eq!(
            geometry.dims,
            geometry.order.map(|a| volume.dims[a]),
            "geometry of another volume"
        );
        let along = [1, nx as isize, (nx * ny) as isize];
        let mut stride = geometry.order.map(|a| along[a]);
        let mut first = 0;
        if geometry.flipped {
            first = (geometry.dims[2] as isize - 1) * stride[2];
            stride[2] = -stride[2];
        }
        Self {
            voxels: &volume.voxels,
            dims: geometry.dims,
            first,
            stride,
        }
    }

    /// Voxels along i, j and k.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// The voxel (i, j, k), code units.
    ///
    /// # Panics
    /// May panic if the voxel does not exist.
    pub fn voxel(&self, at: [usize; 3]) -> f64 {
        let [i, j, k] = at.map(|c| c as isize);
        let [si, sj, sk] = self.stride;
        let index = self.first + i * si + j * sj + k * sk;
        f64::from(self.voxels[index as usize])
    }

    /// The difference of the two neighbours of a voxel along one axis of the frame, `V[i+1] - V[i-1]`, not halved:
    /// code units per two voxels. Twice the paper's gradient component (its section 4.3).
    ///
    /// A neighbour beyond a face is the volume continued linearly, `V[-1] = 2 V[0] - V[1]` and
    /// `V[n] = 2 V[n-1] - V[n-2]`, so that a linear field has the same difference on its faces as inside. Along an
    /// axis of one voxel the volume is continued as a constant: difference 0.
    pub fn central_difference(&self, at: [usize; 3], axis: usize) -> f64 {
        let n = self.dims[axis];
        if n == 1 {
            return 0.0;
        }
        let value = |c: usize| {
            let mut neighbour = at;
            neighbour[axis] = c;
            self.voxel(neighbour)
        };
        let c = at[axis];
        let before = if c == 0 {
            2.0 * value(0) - value(1)
        } else {
            value(c - 1)
        };
        let after = if c == n - 1 {
            2.0 * value(n - 1) - value(n - 2)
        } else {
            value(c + 1)
        };
        after - before
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{SAMPLING_ONCE, volume_of};

    #[test]
    fn every_view_addresses_the_same_voxels() {
        let dims = [3, 4, 5];
        let volume = volume_of(dims, |x, y, z| 100 * x + 10 * y + z);
        let at = |order: [usize; 3], flipped: bool, ijk: [usize; 3]| {
            let mut xyz = [0; 3];
            for a in 0..3 {
                xyz[order[a]] = ijk[a];
            }
            if flipped {
                xyz[order[2]] = dims[order[2]] - 1 - xyz[order[2]];
            }
            (100 * xyz[0] + 10 * xyz[1] + xyz[2]) as f64
        };
        for (forward, order, flipped) in [
            ([0.0, 0.0, 1.0], [0, 1, 2], false),
            ([0.0, 0.0, -1.0], [0, 1, 2], true),
            ([0.0, 1.0, 0.0], [0, 2, 1], false),
            ([0.0, -1.0, 0.0], [0, 2, 1], true),
            ([1.0, 0.0, 0.0], [1, 2, 0], false),
            ([-1.0, 0.0, 0.0], [1, 2, 0], true),
        ] {
            let geometry = Geometry::new(forward, dims, [1.0; 3], SAMPLING_ONCE);
            let grid = Grid::new(&volume, &geometry);
            let [w, h, d] = grid.dims();
            for i in 0..w {
                for j in 0..h {
                    for k in 0..d {
                        assert_eq!(grid.voxel([i, j, k]), at(order, flipped, [i, j, k]));
                    }
                }
            }
        }
    }

    #[test]
    fn differences_at_the_faces_are_one_sided_and_doubled() {
        let volume = volume_of([4, 1, 1], |x, _, _| [10, 13, 40, 0][x]);
        let geometry = Geometry::new([0.0, 0.0, 1.0], [4, 1, 1], [1.0; 3], SAMPLING_ONCE);
        let grid = Grid::new(&volume, &geometry);
        let differences = [0, 1, 2, 3].map(|i| grid.central_difference([i, 0, 0], 0));
        assert_eq!(differences, [6.0, 30.0, -13.0, -80.0]);
        assert_eq!(grid.central_difference([2, 0, 0], 1), 0.0);
        assert_eq!(grid.central_difference([2, 0, 0], 2), 0.0);
    }
}
