//! Quadratic B-splines: a smoother value of the volume between its voxels, and its slopes.
//!
//! Source: de Boor, "A Practical Guide to Splines": the uniform B-spline of second degree is `B(x) = 3/4 - x^2` for |x| <= 1/2, `(3/2 -
//! |x|)^2 / 2` for |x| <= 3/2, and 0 beyond; a sample is the sum of the voxels times `B(x) B(y) B(z)` of their distances. Its slope has `B'`
//! in place of `B` along one axis. Beyond a face the last voxel is repeated.

use super::gradient::NOISE;
use super::grid::Grid;

/// The spline at a distance.
fn value(x: f64) -> f64 {
    match x.abs() {
        x if x <= 0.5 => 0.75 - x * x,
        x if x <= 1.5 => (1.5 - x).powi(2) / 2.0,
        _ => 0.0,
    }
}

/// Its derivative.
fn slope(x: f64) -> f64 {
    match x.abs() {
        far if far <= 0.5 => -2.0 * x,
        far if far <= 1.5 => (far - 1.5) * x.signum(),
        _ => 0.0,
    }
}

/// The sum over the voxels, each by the product of what three functions are at its distances.
fn sum(grid: &Grid<'_>, position: [f64; 3], along: [fn(f64) -> f64; 3]) -> f64 {
    let first = position.map(|c| (c - 1.5).ceil());
    let mut sum = 0.0;
    // Four, of which a position half-way between voxels meets all, two of them with 0.
    for (i, j, k) in (0..64).map(|n| (n % 4, n / 4 % 4, n / 16)) {
        let place = [0, 1, 2].map(|axis| first[axis] + [i, j, k][axis] as f64);
        let weight: f64 = (0..3).map(|axis| along[axis](position[axis] - place[axis])).product();
        if weight != 0.0 {
            let last = grid.dims().map(|side| side as f64 - 1.0);
            sum += weight * grid.voxel([0, 1, 2].map(|axis| place[axis].clamp(0.0, last[axis]) as usize));
        }
    }
    sum
}

/// The value of the spline at a position inside the volume, code units. Position: voxels, in the frame (i, j, k).
pub fn value_at(grid: &Grid<'_>, position: [f64; 3]) -> f64 {
    sum(grid, position, [value; 3])
}

/// Twice its slopes, code units per two voxels, along i, j, k, as the central differences of voxels are. Components below 2^-34 are zero.
pub fn difference_at(grid: &Grid<'_>, position: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|axis| {
        let along = [0, 1, 2].map(|a| if a == axis { slope as fn(f64) -> f64 } else { value });
        let difference = 2.0 * sum(grid, position, along);
        if difference.abs() < NOISE { 0.0 } else { difference }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rays::Geometry;
    use crate::testing::{SAMPLING_ONCE, close, volume_of};

    /// The spline keeps lines and planes, and of a parabola adds a quarter; slopes are those of the function.
    #[test]
    fn parabolas_are_a_quarter_higher() {
        let volume = volume_of([9, 8, 7], |x, y, z| x * x + 3 * y + 5 * z * y);
        let geometry = Geometry::new([0.0, 0.0, 1.0], volume.dims, [1.0; 3], SAMPLING_ONCE);
        let grid = Grid::new(&volume, &geometry);
        for [x, y, z] in [[2.0, 2.0, 2.0], [3.5, 4.5, 2.5], [4.25, 3.1, 4.9], [6.75, 5.2, 1.6]] {
            let exact = x * x + 3.0 * y + 5.0 * z * y;
            assert!((value_at(&grid, [x, y, z]) - exact - 0.25).abs() < 1e-10);
            let slopes = [2.0 * x, 3.0 + 5.0 * z, 5.0 * y];
            close(difference_at(&grid, [x, y, z]), slopes.map(|slope| 2.0 * slope), 1e-10);
        }
    }

    /// Beyond a face its voxels are repeated: at it the spline rises half as much.
    #[test]
    fn faces_are_repeated() {
        let volume = volume_of([6, 1, 1], |x, _, _| 8 * x);
        let geometry = Geometry::new([0.0, 0.0, 1.0], volume.dims, [1.0; 3], SAMPLING_ONCE);
        let grid = Grid::new(&volume, &geometry);
        assert!((value_at(&grid, [0.0, 0.0, 0.0]) - 1.0).abs() < 1e-12);
        assert!((value_at(&grid, [5.0, 0.0, 0.0]) - 39.0).abs() < 1e-12);
        close(difference_at(&grid, [0.0; 3]), [8.0, 0.0, 0.0], 1e-12);
        close(difference_at(&grid, [2.5, 0.0, 0.0]), [16.0, 0.0, 0.0], 1e-12);
    }
}
