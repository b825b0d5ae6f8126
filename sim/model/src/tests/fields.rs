//! Constant, linear and single-voxel volumes, thin volumes, extremes.

use crate::testing::{SAMPLING_ONCE, close, scene_along, view_along, volume_of};
use crate::{Model, Pixel, Positions};
use slicecast_scene::{Blend, Borders, Frame, Highlight, Light, Lighting, Sampling, Scene};
use slicecast_volume::Volume;

/// Every existing sample of a model's lattice, with its coordinates.
fn samples(model: &Model<'_>) -> Vec<([usize; 3], crate::ModelSample)> {
    let [width, height] = model.lattice().size;
    let mut all = Vec::new();
    for plane in 0..model.geometry().planes() {
        for v in 0..height {
            for u in 0..width {
                all.extend(model.sample(plane, u, v).map(|s| ([plane, u, v], s)));
            }
        }
    }
    all
}

fn lit(scene: Scene, direction: [f64; 3], ambient: f64, diffuse: f64) -> Scene {
    let l = direction.iter().map(|c| c * c).sum::<f64>().sqrt();
    Scene {
        lighting: Some(Lighting {
            ambient,
            diffuse,
            specular: 0.0,
            exponent_log2: 4,
            highlight: Highlight::Reflection,
            lights: vec![Light {
                direction: direction.map(|c| c / l),
                frame: Frame::Volume,
                colour: [1.0; 3],
            }],
        }),
        ..scene
    }
}

const VIEWS: [[f64; 3]; 8] = [
    [0.0, 0.0, 1.0],
    [0.25, -0.5, 1.0],
    [0.25, 0.5, -1.0],
    [1.0, 1.0, 1.0],
    [-0.4, -1.0, 0.3],
    [0.4, 1.0, 0.9],
    [1.0, -0.2, 0.7],
    [-1.0, -0.2, 0.7],
];

#[test]
fn a_constant_volume_is_constant_and_has_no_normals() {
    let volume = volume_of([5, 4, 6], |_, _, _| 1234);
    for forward in VIEWS {
        let scene = lit(scene_along(forward, &[(1234.0, 1.0)]), [0.1, 0.2, -0.9], 0.3, 0.7);
        let model = Model::natural(&scene, &volume);
        let all = samples(&model);
        assert!(all.len() > 20);
        for (_, s) in all {
            assert_eq!((s.value, s.gradient, s.normal), (1234.0, [0.0; 3], [0.0; 3]));
            assert_eq!((s.shaded, s.opacity), ([0.3; 3], 1.0));
        }
    }
}

/// The field 400 + 7 x - 5 y + 11 z on 8 x 8 x 8 voxels.
fn ramp() -> Volume {
    volume_of([8, 8, 8], |x, y, z| 400 + 7 * x + 11 * z - 5 * y)
}

const TWICE: Sampling = Sampling {
    planes_per_voxel: 2,
    rays_per_voxel: 1,
};

/// The ray of pixel (u, v) runs through world space; the field there is known without any interpolation.
#[test]
fn a_linear_field_is_exact_everywhere() {
    let volume = ramp();
    let field = |x: f64, y: f64, z: f64| 400.0 + 7.0 * x - 5.0 * y + 11.0 * z;
    // Looking along +z: i = x, j = y. Shear (0.25, -0.5) over 7 voxels: 1.75 and 3.5 voxels, so 2 columns before.
    let scene = Scene {
        sampling: TWICE,
        ..scene_along([0.25, -0.5, 1.0], &[(0.0, 0.5)])
    };
    let model = Model::natural(&scene, &volume);
    assert_eq!((model.lattice().origin, model.lattice().size), ([-2, 0], [10, 12]));
    for ([plane, u, v], s) in samples(&model) {
        let z = plane as f64 / 2.0;
        let expected = field(u as f64 - 2.0 + 0.25 * z, v as f64 - 0.5 * z, z);
        assert!((s.value - expected).abs() < 1e-9);
        close(s.gradient, [14.0, -10.0, 22.0], 1e-9);
    }
    // Looking along -y: i = x, j = z, and y falls from 7. Shear per voxel of -y: (0.25, -0.5).
    let scene = scene_along([0.25, -1.0, -0.5], &[(0.0, 0.5)]);
    let model = Model::natural(&scene, &volume);
    assert_eq!((model.geometry().order, model.geometry().flipped), ([0, 2, 1], true));
    for ([plane, u, v], s) in samples(&model) {
        let k = plane as f64;
        let expected = field(u as f64 - 2.0 + 0.25 * k, 7.0 - k, v as f64 - 0.5 * k);
        assert!((s.value - expected).abs() < 1e-9);
        close(s.gradient, [14.0, 22.0, 10.0], 1e-9);
    }
    // Looking along +x: i = y, j = z.
    let scene = scene_along([1.0, 0.5, 0.0], &[(0.0, 0.5)]);
    let model = Model::natural(&scene, &volume);
    for ([plane, u, v], s) in samples(&model) {
        let x = plane as f64;
        let expected = field(x, u as f64 - 4.0 + 0.5 * x, v as f64);
        assert!((s.value - expected).abs() < 1e-9);
    }
}

/// Diffuse light on the linear field, the same on every sample, borders included, and therefore the same in every
/// ray's first, opaque sample.
///
/// The lights are those of the numeric study's section 6. It prints 0.787665 and 0.958623, which are 1.4e-5 and
/// 0.9e-5 away from the cosines of the vectors it names; the cosines are asserted here.
#[test]
fn diffuse_light_on_a_linear_field() {
    let volume = ramp();
    for (light, cosine) in [([0.1, 0.2, -0.9], 0.787_650_659), ([-0.6, 0.3, -0.5], 0.958_631_503)] {
        // cos of the angle between -(7, -5, 11) and the light.
        let against = -(7.0 * light[0] - 5.0 * light[1] + 11.0 * light[2]);
        let norm = light.iter().map(|c| c * c).sum::<f64>().sqrt() * 195.0_f64.sqrt();
        let diffuse: f64 = against / norm;
        assert!((diffuse - cosine).abs() < 5.1e-10);
        for forward in VIEWS {
            let scene = Scene {
                sampling: TWICE,
                ..lit(scene_along(forward, &[(0.0, 1.0)]), light, 0.0, 1.0)
            };
            let model = Model::natural(&scene, &volume);
            for (at, s) in samples(&model) {
                assert!((s.shaded[1] - diffuse).abs() < 1e-12, "{forward:?} {at:?}");
                let pixel = model.ray(at[1], at[2]);
                close(pixel.colour, [diffuse; 3], 1e-12);
            }
        }
    }
}

/// Anisotropic voxels: the world gradient is (7 / sx, -5 / sy, 11 / sz).
#[test]
fn normals_stand_on_surfaces_of_the_world() {
    let mut volume = ramp();
    volume.spacing = [0.5, 2.0, 1.25];
    let world = [7.0 / 0.5, -5.0 / 2.0, 11.0 / 1.25];
    let light = [0.3, 0.4, -0.5];
    let cosine = |a: [f64; 3], b: [f64; 3]| {
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        dot(a, b) / (dot(a, a) * dot(b, b)).sqrt()
    };
    let expected = cosine(world.map(|c: f64| -c), light).max(0.0);
    for forward in VIEWS {
        let scene = lit(scene_along(forward, &[(0.0, 1.0)]), light, 0.1, 0.9);
        let model = Model::natural(&scene, &volume);
        for (_, s) in samples(&model) {
            close(s.shaded, [0.1 + 0.9 * expected; 3], 1e-12);
        }
    }
}

#[test]
fn a_single_voxel_is_a_tent() {
    let volume = volume_of([5, 5, 5], |x, y, z| if (x, y, z) == (2, 1, 3) { 4000 } else { 0 });
    let tent = |d: f64| (1.0 - d.abs()).max(0.0);
    let sampling = Sampling {
        planes_per_voxel: 3,
        rays_per_voxel: 4,
    };
    let scene = Scene {
        sampling,
        ..scene_along([0.375, -0.75, 1.0], &[(0.0, 0.5)])
    };
    let model = Model::natural(&scene, &volume);
    // 4 * 0.375 = 1.5 and 4 * 0.75 = 3 voxels of shear; 4 pixels per voxel.
    assert_eq!((model.lattice().origin, model.lattice().size), ([-2, 0], [28, 32]));
    let mut inside = 0;
    for ([plane, u, v], s) in samples(&model) {
        let z = plane as f64 / 3.0;
        let (x, y) = (u as f64 / 4.0 - 2.0 + 0.375 * z, v as f64 / 4.0 - 0.75 * z);
        let expected = 4000.0 * tent(x - 2.0) * tent(y - 1.0) * tent(z - 3.0);
        assert!((s.value - expected).abs() < 1e-9);
        inside += usize::from(expected > 0.0);
    }
    // Planes strictly between z = 2 and the last one, 4: five; in each, 7 or 8 columns and rows strictly inside.
    assert!((5 * 7 * 7..=5 * 8 * 8).contains(&inside), "{inside}");
}

#[test]
fn one_voxel_is_one_sample() {
    let volume = volume_of([1, 1, 1], |_, _, _| 7);
    for forward in VIEWS {
        let scene = Scene {
            sampling: Sampling {
                planes_per_voxel: 4,
                rays_per_voxel: 2,
            },
            ..lit(scene_along(forward, &[(7.0, 1.0)]), [0.0, 0.0, 1.0], 0.5, 0.5)
        };
        let model = Model::natural(&scene, &volume);
        assert_eq!((model.geometry().planes(), model.lattice().size), (1, [2, 2]));
        let image = model.render();
        assert_eq!(image.pixel(0, 0), Pixel::of_sample([0.5; 3], 1.0));
        assert_eq!([image.pixel(1, 0), image.pixel(0, 1)], [Pixel::TRANSPARENT; 2]);
    }
}

/// One voxel thin: samples only where the ray meets the sheet exactly; no derivative across it.
#[test]
fn thin_volumes() {
    let sheet = volume_of([1, 4, 5], |_, y, z| 100 + 10 * y + 3 * z);
    // Edge-on, shear 0.5 across the sheet: every second plane has a ray in it.
    let scene = scene_along([0.5, 0.0, 1.0], &[(0.0, 0.5)]);
    let model = Model::natural(&scene, &sheet);
    let all = samples(&model);
    assert_eq!(all.len(), 3 * 4);
    for ([plane, u, v], s) in all {
        assert_eq!((plane % 2, 2 * u + plane), (0, 4));
        assert_eq!(s.value, (100 + 10 * v + 3 * plane) as f64);
        assert_eq!(s.gradient, [0.0, 20.0, 6.0]);
    }
    // Face-on: a single plane.
    let scene = scene_along([1.0, 0.3, 0.2], &[(0.0, 0.5)]);
    let model = Model::natural(&scene, &sheet);
    assert_eq!(model.geometry().planes(), 1);
    assert_eq!(samples(&model).len(), 4 * 5);
    assert_eq!(
        model.sample(0, 1, 2).map(|s| (s.value, s.gradient)),
        Some((116.0, [20.0, 6.0, 0.0]))
    );
}

#[test]
fn extremes_are_classified_once_as_written() {
    let volume = volume_of([3, 3, 4], |x, y, z| {
        [[10, 40, 20, 30], [5, 5, 5, 5], [50, 60, 7, 8]][x][z] + y
    });
    let mut scene = lit(
        scene_along([0.0, 0.0, 1.0], &[(0.0, 0.0), (100.0, 1.0)]),
        [0.0, 0.0, 1.0],
        0.0,
        0.1,
    );
    scene.sampling = TWICE;
    for (blend, values) in [(Blend::Maximum, [40, 5, 60]), (Blend::Minimum, [10, 5, 7])] {
        scene.blend = blend;
        let image = Model::natural(&scene, &volume).render();
        assert_eq!(image.size, [3, 3]);
        for (x, value) in values.into_iter().enumerate() {
            for y in 0..3 {
                let a = (value + y) as f64 / 100.0;
                let pixel = image.pixel(x as i64, y as i64);
                close(pixel.colour, [a; 3], 1e-15);
                assert!((pixel.transparency - (1.0 - a)).abs() < 1e-15);
            }
        }
    }
    // A ray that misses everything.
    scene.view = view_along([0.5, 0.0, 1.0]);
    scene.sampling = SAMPLING_ONCE;
    let mut lattice = Model::geometry_of(&scene, &volume).natural_lattice();
    lattice.origin[0] -= 1;
    for blend in [Blend::Minimum, Blend::Average, Blend::Additive] {
        scene.blend = blend;
        let model = Model::new(&scene, &volume, lattice, Positions::Exact);
        assert_eq!(model.ray(0, 0), Pixel::TRANSPARENT);
        assert_ne!(model.ray(2, 0), Pixel::TRANSPARENT);
    }
}

/// A volume of one value: its mean is that value on every ray, its sum grows with the ray's length, which is the length of the ray in
/// the box of cells.
#[test]
fn sums_of_a_constant_are_lengths() {
    let volume = volume_of([5, 5, 7], |_, _, _| 60);
    let mut scene = scene_along([0.0, 0.0, 1.0], &[(0.0, 0.0), (100.0, 1.0)]);
    for (direction, borders) in [
        ([0.0, 0.0, 1.0], Borders::Cells),
        ([0.4, -0.2, 1.0], Borders::Cells),
        ([0.4, -0.2, 1.0], Borders::Whole),
    ] {
        scene.view = view_along(direction);
        scene.borders = borders;
        scene.sampling = TWICE;
        let of = |blend| Scene { blend, ..scene.clone() };
        let scenes = [of(Blend::Average), of(Blend::Additive)];
        let [mean, sum] = scenes.each_ref().map(|scene| Model::natural(scene, &volume));
        let [width, height] = mean.lattice().size;
        let mut longest: f64 = 0.0;
        for (u, v) in (0..width).flat_map(|u| (0..height).map(move |v| (u, v))) {
            let met = |plane| sum.place(plane, u, v).map_or(0.0, |place| place.fraction);
            let steps: f64 = (0..sum.planes()).map(met).sum();
            let (mean, sum) = (mean.ray(u, v).transparency, sum.ray(u, v).transparency);
            if steps == 0.0 {
                assert_eq!([mean, sum], [1.0; 2]);
                continue;
            }
            assert!((mean - 0.4).abs() < 1e-12);
            let step = (direction.map(|c| c * c).iter().sum::<f64>()).sqrt() / 2.0;
            let diagonal = (25.0f64 + 25.0 + 49.0).sqrt();
            assert!((1.0 - sum - 0.6 * steps * step / diagonal).abs() < 1e-12);
            longest = longest.max(steps * step);
        }
        // The middle ray goes from face to face.
        let way = direction.map(|c| c * c).iter().sum::<f64>().sqrt();
        if borders == Borders::Cells {
            assert!((longest - 7.0 * way).abs() < 1e-9, "{longest}");
        }
    }
}
