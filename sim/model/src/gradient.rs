//! Gradients and normals.
//!
//! Source: paper, section 4.3 (central differences), taken on the voxel grid and interpolated at the sample
//! (design.md, section 2); spacing after the numeric study.
//!
//! | value      | unit                                                                            |
//! | difference | code units per two voxels, along i, j, k                                        |
//! | gradient   | code units per two voxels of the finest axis, along i, j, k in world directions |
//! | normal     | 1 (unit vector), or all zero where the gradient is zero                         |

use super::grid::Grid;
use super::interpolate::{Cell, trilinear};
use super::vector::length;

/// What turns differences per voxel into a world gradient: `f_a = min(spacing) / spacing_a`, at most 1.
///
/// The world gradient is `G_a / spacing_a`; only its direction is used, and the common factor `min(spacing)` keeps
/// the numbers near those of the differences.
pub fn spacing_factors(spacing: [f64; 3]) -> [f64; 3] {
    let least = spacing.iter().copied().fold(f64::INFINITY, f64::min);
    spacing.map(|s| least / s)
}

/// Components smaller than this are rounding noise of the interpolation (eight corners of up to 2^14, each good to
/// 2^-52 of itself) and count as zero: otherwise the centre of a symmetric object would get a random normal.
pub(super) const NOISE: f64 = 1.0 / (1_u64 << 34) as f64;

/// The voxel grid's central differences ([`Grid::central_difference`]), trilinearly interpolated at a position
/// inside the volume. No spacing factors: code units per two voxels, along i, j, k. Components below 2^-34 are zero.
pub fn difference_at(grid: &Grid<'_>, position: [f64; 3]) -> [f64; 3] {
    let cell = Cell::at(position, grid.dims());
    [0, 1, 2].map(|axis| {
        let d = trilinear(cell.corners(|c| grid.central_difference(c, axis)), cell.weight);
        if d.abs() < NOISE { 0.0 } else { d }
    })
}

/// The normal of a gradient: `N = -G / |G|`, towards lower values; zero if the gradient is zero.
///
/// With this sign a bright object in dark surroundings has outward normals.
pub fn normalise(gradient: [f64; 3]) -> [f64; 3] {
    // Scaled by the largest component first, so that no square leaves the range of f64.
    let largest = gradient.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
    if largest == 0.0 {
        return [0.0; 3];
    }
    let scaled = gradient.map(|c| c / largest);
    let l = length(scaled);
    scaled.map(|c| -c / l)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rays::Geometry;
    use crate::testing::{SAMPLING_ONCE, close, volume_of};

    #[test]
    fn spacing_factors_make_a_world_gradient() {
        assert_eq!(spacing_factors([1.0, 1.0, 1.0]), [1.0; 3]);
        assert_eq!(spacing_factors([0.5, 1.0, 2.0]), [1.0, 0.5, 0.25]);
    }

    /// The numeric study's section 6, G: expected components are N in units of 2^-15, sign as the study's (towards G).
    #[test]
    fn normals_of_the_studys_hard_cases() {
        for (g, n) in [
            ([29978.0, 328.0, 188.0], [32765.395, 358.498, 205.480]),
            ([1.0, 0.0, 0.0], [32768.0, 0.0, 0.0]),
            ([1.0, 2.0, 3.0], [8757.616, 17515.233, 26272.849]),
            ([-3.0, 2.0, -1.0], [-26272.849, 17515.233, -8757.616]),
            ([3.0, -100_000.0, 7.0], [0.983, -32768.0, 2.294]),
            ([1e-200, 1e-200, 1e-200], [18918.614; 3]),
        ] {
            let got = normalise(g).map(|c| -c * 32768.0);
            for a in 0..3 {
                assert!((got[a] - n[a]).abs() < 5.1e-4, "{g:?}: {got:?}");
            }
        }
        assert_eq!(normalise([0.0, -0.0, 0.0]), [0.0; 3]);
    }

    #[test]
    fn a_linear_field_has_one_gradient_borders_included() {
        let volume = volume_of([5, 4, 6], |x, y, z| 400 + 7 * x + 11 * z - 5 * y);
        for (forward, expected) in [
            ([0.0, 0.0, 1.0], [14.0, -10.0, 22.0]),
            ([0.0, 0.0, -1.0], [14.0, -10.0, -22.0]),
            ([0.0, -1.0, 0.0], [14.0, 22.0, 10.0]),
            ([1.0, 0.0, 0.0], [-10.0, 22.0, 14.0]),
        ] {
            let geometry = Geometry::new(forward, volume.dims, [1.0; 3], SAMPLING_ONCE);
            let grid = Grid::new(&volume, &geometry);
            let last = grid.dims().map(|d| (d - 1) as f64);
            for t in [0.0, 0.1, 0.5, 0.95, 1.0] {
                for s in [0.0, 0.3, 1.0] {
                    close(
                        difference_at(&grid, [t * last[0], s * last[1], t * last[2]]),
                        expected,
                        1e-12,
                    );
                    close(
                        difference_at(&grid, [s * last[0], t * last[1], s * last[2]]),
                        expected,
                        1e-12,
                    );
                }
            }
        }
    }

    /// V = x^2: the difference (x+1)^2 - (x-1)^2 = 4x, linear, so exact between voxels too.
    #[test]
    fn a_parabola_has_a_linear_gradient_inside() {
        let volume = volume_of([9, 3, 3], |x, _, _| x * x);
        let geometry = Geometry::new([0.0, 0.0, 1.0], volume.dims, [1.0; 3], SAMPLING_ONCE);
        let grid = Grid::new(&volume, &geometry);
        for x in [1.0, 1.25, 3.7, 6.5, 7.0] {
            close(difference_at(&grid, [x, 1.3, 0.4]), [4.0 * x, 0.0, 0.0], 1e-12);
        }
        // On the face: twice the one-sided difference, 2 (1 - 0) = 2; half-way to the next voxel (2 + 4) / 2.
        close(difference_at(&grid, [0.0, 1.0, 1.0]), [2.0, 0.0, 0.0], 0.0);
        close(difference_at(&grid, [0.5, 1.0, 1.0]), [3.0, 0.0, 0.0], 0.0);
    }
}
