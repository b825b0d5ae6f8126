//! Homogeneous fog: the transparency of a ray depends on its length alone.

use crate::Model;
use crate::testing::{scene_along, volume_of};
use slicecast_scene::{Sampling, Scene};

/// Viewing directions with every major axis and sign; unit vectors.
const DIRECTIONS: [[f64; 3]; 7] = [
    [0.0, 0.0, 1.0],
    [0.48, -0.6, 0.64],
    [-0.64, 0.48, -0.6],
    [0.36, 0.8, 0.48],
    [0.0, -0.6, 0.8],
    [0.96, 0.28, 0.0],
    [-0.8, 0.36, -0.48],
];

const SPACINGS: [[f64; 3]; 3] = [[1.0, 1.0, 1.0], [0.7, 1.1, 0.4], [0.5, 0.5, 2.5]];

/// Samples of one ray by counting, from the direction in voxels alone.
fn count(forward: [f64; 3], spacing: [f64; 3], dims: [usize; 3], start: [f64; 3], major: usize, r: u32) -> u32 {
    let v = [0, 1, 2].map(|a| forward[a] / spacing[a]);
    (0..=(dims[major] as u32 - 1) * r)
        .filter(|&p| {
            (0..3).all(|a| {
                let at = start[a] + f64::from(p) / f64::from(r) * v[a] / v[major].abs();
                (-1e-6..=(dims[a] - 1) as f64 + 1e-6).contains(&at)
            })
        })
        .count() as u32
}

/// T = (1 - a)^(N L / unit): N samples of L = spacing_m / (|forward_m| r), for every ray.
#[test]
fn transparency_is_the_power_of_the_length() {
    let dims = [7, 6, 8];
    let alpha = 0.0625_f64;
    let mut rays = 0;
    for forward in DIRECTIONS {
        for spacing in SPACINGS {
            for r in [1, 2, 3, 8] {
                let mut volume = volume_of(dims, |_, _, _| 900);
                volume.spacing = spacing;
                let mut scene = Scene {
                    sampling: Sampling {
                        planes_per_voxel: r,
                        rays_per_voxel: 1,
                    },
                    ..scene_along(forward, &[(0.0, alpha)])
                };
                scene.transfer.unit_distance = 1.7;
                let model = Model::natural(&scene, &volume);
                let [i, j, m] = model.geometry().order;
                let step = spacing[m] / forward[m].abs() / f64::from(r);
                let image = model.render();
                for v in 0..image.size[1] {
                    for u in 0..image.size[0] {
                        let mut start = [0.0; 3];
                        start[i] = model.lattice().origin[0] as f64 + u as f64;
                        start[j] = model.lattice().origin[1] as f64 + v as f64;
                        if forward[m] < 0.0 {
                            start[m] = (dims[m] - 1) as f64;
                        }
                        let n = count(forward, spacing, dims, start, m, r);
                        let expected = (1.0 - alpha).powf(f64::from(n) * step / 1.7);
                        let pixel = image.pixel(u as i64, v as i64);
                        assert!(
                            (pixel.transparency - expected).abs() < 1e-12,
                            "{forward:?} {spacing:?} {r} {n}"
                        );
                        assert!((pixel.colour[2] - (1.0 - expected)).abs() < 1e-12);
                        rays += usize::from(n > 1);
                    }
                }
            }
        }
    }
    assert!(rays > 1000, "{rays}");
}

/// The ray through the middle of a cube looked at along an axis: D planes of voxels, (D - 1) r + 1 samples.
#[test]
fn samples_of_the_central_ray() {
    let volume = volume_of([9, 9, 9], |_, _, _| 1);
    for forward in [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]] {
        for r in [1, 2, 16] {
            let scene = Scene {
                sampling: Sampling {
                    planes_per_voxel: r,
                    rays_per_voxel: 1,
                },
                ..scene_along(forward, &[(0.0, 0.5)])
            };
            let model = Model::natural(&scene, &volume);
            let hits = (0..model.geometry().planes())
                .filter(|&p| model.sample(p, 4, 4).is_some())
                .count();
            assert_eq!(hits, 8 * r as usize + 1);
            // 8 voxels and one step more of alpha = 0.5 per voxel.
            let expected = 0.5_f64.powf(8.0 + 1.0 / f64::from(r));
            assert!((model.ray(4, 4).transparency - expected).abs() < 1e-15);
        }
    }
}

/// At 45 degrees, in the diagonal plane of a cube: the step is sqrt 2, or sqrt 3 along the space diagonal, and the
/// two views that a tie could be resolved to agree.
#[test]
fn forty_five_degrees() {
    let volume = volume_of([9, 9, 9], |_, _, _| 1);
    for (forward, step) in [
        ([1.0, 0.0, 1.0], 2.0_f64.sqrt()),
        ([0.0, -1.0, 1.0], 2.0_f64.sqrt()),
        ([-1.0, 1.0, 0.0], 2.0_f64.sqrt()),
        ([1.0, 1.0, 1.0], 3.0_f64.sqrt()),
        ([-1.0, 1.0, -1.0], 3.0_f64.sqrt()),
    ] {
        let scene = scene_along(forward, &[(0.0, 0.25)]);
        let model = Model::natural(&scene, &volume);
        let geometry = model.geometry();
        assert!((geometry.step_length() - step).abs() < 1e-14, "{geometry:?}");
        // Shear 0 needs 9 columns, shear 1 needs 17.
        for a in 0..2 {
            let expected = if geometry.shear[a].abs() < 0.5 { 9 } else { 17 };
            assert_eq!(model.lattice().size[a], expected, "{forward:?}");
        }
        // The longest ray meets all nine planes.
        let image = model.render();
        let least = image.t.iter().copied().fold(1.0, f64::min);
        assert!((least - 0.75_f64.powf(9.0 * step)).abs() < 1e-12);
    }
}
