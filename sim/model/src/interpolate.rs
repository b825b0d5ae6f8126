//! Interpolation: the value of the volume between its voxels.
//!
//! Source: paper, section 4.5, equations 13 and 14: trilinear interpolation as seven linear ones.

use super::grid::Grid;

/// The cell of eight voxels around a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// The voxel at the cell's lower corner (the integer part of the position).
    pub lower: [usize; 3],
    /// The voxel at its upper corner: one further along each axis, except at the last voxel, which is its own
    /// neighbour (the weight is 0 there).
    pub upper: [usize; 3],
    /// The position's fraction along i, j, k, in [0, 1).
    pub weight: [f64; 3],
}

impl Cell {
    /// The cell of a position inside a grid of `dims` voxels, 0 to dims - 1 along each axis.
    pub fn at(position: [f64; 3], dims: [usize; 3]) -> Self {
        let lower = [0, 1, 2].map(|a| (position[a].floor() as usize).min(dims[a] - 1));
        Self {
            lower,
            upper: [0, 1, 2].map(|a| (lower[a] + 1).min(dims[a] - 1)),
            weight: [0, 1, 2].map(|a| position[a] - lower[a] as f64),
        }
    }

    /// Something at each of the eight corners; corner `c` has i in bit 0, j in bit 1, k in bit 2.
    pub fn corners<T>(&self, mut f: impl FnMut([usize; 3]) -> T) -> [T; 8] {
        std::array::from_fn(|c| f([0, 1, 2].map(|a| if c >> a & 1 == 1 { self.upper[a] } else { self.lower[a] })))
    }
}

/// Linear interpolation (paper, equation 14): `w (b - a) + a`.
pub fn linear(a: f64, b: f64, w: f64) -> f64 {
    w * (b - a) + a
}

/// Trilinear interpolation of eight corner values with weights along i, j, k.
///
/// Corner `c` has i in bit 0, j in bit 1, k in bit 2 (so `v[1]` lies one voxel along i). Reduced along k, then j,
/// then i; in exact arithmetic the order does not matter. Unit: the corners'.
pub fn trilinear(v: [f64; 8], w: [f64; 3]) -> f64 {
    let [wi, wj, wk] = w;
    let in_plane: [f64; 4] = std::array::from_fn(|c| linear(v[c], v[c + 4], wk));
    let in_line = [
        linear(in_plane[0], in_plane[2], wj),
        linear(in_plane[1], in_plane[3], wj),
    ];
    linear(in_line[0], in_line[1], wi)
}

/// The volume's value at a position inside it, code units. Position: voxels, in the frame (i, j, k).
pub fn value_at(grid: &Grid<'_>, position: [f64; 3]) -> f64 {
    let cell = Cell::at(position, grid.dims());
    trilinear(cell.corners(|c| grid.voxel(c)), cell.weight)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numeric study's section 6, I: weights in units of 2^-16, f64 answers.
    #[test]
    fn the_studys_hard_cases() {
        let m = 4095.0;
        for (v, w, answer) in [
            (
                [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, m],
                [65535, 65535, 65535],
                4_094.812_548_636_677,
            ),
            ([m; 8], [1, 65535, 32768], 4095.0),
            ([0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [1, 0, 0], 1.0 / 65536.0),
            ([0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [32768, 32768, 32768], 0.125),
            ([m, 0.0, 0.0, m, 0.0, m, m, 0.0], [32767, 32769, 32768], 2047.5),
            (
                [0.0, m, m, 0.0, m, 0.0, 0.0, m],
                [21845, 43691, 10923],
                2_199.173_609_415_688,
            ),
            ([7.0, 8.0, 8.0, 7.0, 8.0, 7.0, 7.0, 8.0], [1, 1, 1], 7.000_045_774_970),
            (
                [m, m - 1.0, m, m - 1.0, m, m - 1.0, m, m - 1.0],
                [65535, 3, 9],
                4_094.000_015_258_789,
            ),
        ] {
            let got = trilinear(v, w.map(|q: u32| f64::from(q) / 65536.0));
            assert!((got - answer).abs() < 1e-12 * 4096.0, "{v:?} {w:?}: {got}");
        }
    }

    /// A trilinear function a + b x + c y + ... + h x y z is its own interpolant.
    #[test]
    fn trilinear_functions_are_exact() {
        let f =
            |x: f64, y: f64, z: f64| 3.0 - x + 2.0 * y + 5.0 * z - 7.0 * x * y + x * z + 4.0 * y * z - 2.0 * x * y * z;
        let v = std::array::from_fn(|c| f((c & 1) as f64, (c >> 1 & 1) as f64, (c >> 2) as f64));
        for [x, y, z] in [[0.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.25, 0.5, 0.125], [0.1, 0.7, 0.9]] {
            assert!((trilinear(v, [x, y, z]) - f(x, y, z)).abs() < 1e-14);
        }
    }

    #[test]
    fn the_last_voxel_is_its_own_neighbour() {
        let cell = Cell::at([3.0, 0.0, 1.75], [4, 1, 3]);
        assert_eq!((cell.lower, cell.upper), ([3, 0, 1], [3, 0, 2]));
        assert_eq!(cell.weight, [0.0, 0.0, 0.75]);
    }
}
