//! Views, orders and positions that must agree with each other.

use crate::testing::{close, scene_along, volume_of};
use crate::{Model, ModelImage, Positions};
use slicecast_scene::{Blend, Frame, Highlight, Light, Lighting, Sampling, Scene};
use slicecast_volume::Volume;

/// A ball in a cube, the same from every axis and both sides.
fn ball() -> Volume {
    volume_of([9, 9, 9], |x, y, z| {
        let square = |c: usize| (2 * c).abs_diff(8).pow(2);
        3000_usize.saturating_sub(10 * (square(x) + square(y) + square(z)))
    })
}

/// No symmetry at all: a hash of the coordinates.
fn noise() -> Volume {
    volume_of([7, 8, 6], |x, y, z| {
        (x * 7919 + y * 104_729 + z * 1_299_709 + x * y * z * 31) % 4096
    })
}

/// A lamp at the viewer's forehead, so that the light turns with the view.
fn headlight() -> Lighting {
    Lighting {
        ambient: 0.1,
        diffuse: 0.6,
        specular: 0.3,
        exponent_log2: 3,
        highlight: Highlight::Reflection,
        lights: vec![Light {
            direction: [0.0, 0.0, 1.0],
            frame: Frame::Camera,
            colour: [1.0, 0.9, 0.5],
        }],
    }
}

fn lit_scene(forward: [f64; 3]) -> Scene {
    Scene {
        lighting: Some(headlight()),
        ..scene_along(forward, &[(1000.0, 0.0), (2500.0, 0.4), (3000.0, 1.0)])
    }
}

/// Fails unless `got(u, v)` is `expected(u, v)`, the pixels of `got` mirrored along the axes in `mirror`.
#[track_caller]
fn same_picture(got: &ModelImage, expected: &ModelImage, mirror: [bool; 2]) {
    assert_eq!(got.size, expected.size);
    let [width, height] = got.size.map(|n| n as i64);
    for v in 0..height {
        for u in 0..width {
            let a = got.pixel(
                if mirror[0] { width - 1 - u } else { u },
                if mirror[1] { height - 1 - v } else { v },
            );
            let b = expected.pixel(u, v);
            close(a.colour, b.colour, 1e-11);
            assert!((a.transparency - b.transparency).abs() < 1e-11);
        }
    }
}

#[test]
fn a_symmetric_object_looks_the_same_from_all_axes_and_sides() {
    let volume = ball();
    for (a, b) in [(0.0, 0.0), (0.3, 0.45), (0.25, 0.0), (0.9, 0.7)] {
        let reference = lit_scene([a, b, 1.0]);
        let reference = Model::natural(&reference, &volume).render();
        assert!(reference.t.iter().any(|&t| t < 0.1));
        for major in [1.0, -1.0] {
            for (sa, sb) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
                let (a, b) = (sa * a, sb * b);
                for forward in [[a, b, major], [a, major, b], [major, a, b]] {
                    let scene = lit_scene(forward);
                    let image = Model::natural(&scene, &volume).render();
                    same_picture(&image, &reference, [sa < 0.0, sb < 0.0]);
                }
            }
        }
    }
}

#[test]
fn both_orders_of_compositing_agree() {
    let volume = noise();
    for forward in [[0.2, 0.4, 1.0], [-0.3, -1.0, 0.8], [1.0, 0.1, 0.2]] {
        let mut scene = lit_scene(forward);
        scene.sampling.planes_per_voxel = 3;
        let front = Model::natural(&scene, &volume).render();
        scene.blend = Blend::BackToFront;
        let back = Model::natural(&scene, &volume).render();
        same_picture(&back, &front, [false, false]);
        for (f, b) in front.rgb.iter().flatten().zip(back.rgb.iter().flatten()) {
            assert!((f - b).abs() < 1e-12);
        }
    }
}

#[test]
fn rays_between_rays_leave_the_others_alone() {
    let volume = noise();
    let mut scene = lit_scene([0.2, -0.4, 1.0]);
    let coarse = Model::natural(&scene, &volume).render();
    for n in [2, 3] {
        scene.sampling.rays_per_voxel = n;
        let fine = Model::natural(&scene, &volume).render();
        let n = n as usize;
        assert_eq!(fine.size, coarse.size.map(|s| n * s));
        for v in 0..coarse.size[1] as i64 {
            for u in 0..coarse.size[0] as i64 {
                assert_eq!(fine.pixel(u * n as i64, v * n as i64), coarse.pixel(u, v));
            }
        }
    }
}

#[test]
fn a_larger_lattice_shows_the_same_rays() {
    let volume = noise();
    let scene = lit_scene([0.2, -0.4, 1.0]);
    let natural = Model::natural(&scene, &volume);
    let mut lattice = natural.lattice();
    lattice.origin = [lattice.origin[0] - 3, lattice.origin[1] - 1];
    lattice.size = [lattice.size[0] + 5, lattice.size[1] + 1];
    let (small, large) = (
        natural.render(),
        Model::new(&scene, &volume, lattice, Positions::Exact).render(),
    );
    for v in 0..lattice.size[1] as i64 {
        for u in 0..lattice.size[0] as i64 {
            close(large.pixel(u, v).colour, small.pixel(u - 3, v - 1).colour, 1e-12);
        }
    }
}

#[test]
fn given_positions_are_used_as_they_are() {
    let volume = volume_of([4, 4, 4], |x, y, z| 100 + 16 * x + 64 * y + 256 * z);
    let scene = Scene {
        sampling: Sampling {
            planes_per_voxel: 2,
            rays_per_voxel: 2,
        },
        ..scene_along([0.3, 0.2, 1.0], &[(0.0, 0.5)])
    };
    let lattice = Model::geometry_of(&scene, &volume).natural_lattice();
    let field = |[x, y, z]: [f64; 3]| 100.0 + 16.0 * x + 64.0 * y + 256.0 * z;
    // 16.16 numbers: the real ones, floored.
    let geometry = Model::geometry_of(&scene, &volume);
    let rounded = |plane, u, v| {
        geometry
            .position(lattice, plane, u, v)
            .map(|c| (c * 65536.0).floor() / 65536.0)
    };
    let model = Model::new(&scene, &volume, lattice, Positions::Given(Box::new(rounded)));
    let mut seen = 0;
    for plane in 0..geometry.planes() {
        for v in 0..lattice.size[1] {
            for u in 0..lattice.size[0] {
                let at = rounded(plane, u, v);
                let exists = at.iter().all(|c| (0.0..=3.0).contains(c));
                let value = model.sample_value(plane, u, v);
                assert_eq!(value.is_some(), exists);
                if let Some(value) = value {
                    assert!((value - field(at)).abs() < 1e-12 * 4096.0);
                    seen += 1;
                }
            }
        }
    }
    assert!(seen > 200, "{seen}");
    // No tolerance at the faces: outside by less than half a unit of 16.16 is outside.
    for (x, exists) in [(0.0, true), (3.0, true), (-1e-6, false), (3.0 + 1e-6, false)] {
        let model = Model::new(
            &scene,
            &volume,
            lattice,
            Positions::Given(Box::new(move |_, _, _| [x, 1.0, 1.0])),
        );
        assert_eq!(model.sample(0, 0, 0).is_some(), exists);
    }
}

/// What a ray folds is what `sample` reports, and other lights can be put in.
#[test]
fn a_ray_is_the_fold_of_its_samples() {
    let volume = noise();
    let scene = lit_scene([0.2, -0.4, 1.0]);
    let model = Model::natural(&scene, &volume);
    for (u, v) in [(1, 3), (4, 5), (6, 7)] {
        let (mut colour, mut t) = ([0.0; 3], 1.0);
        for plane in 0..model.geometry().planes() {
            if let Some(s) = model.sample(plane, u, v) {
                colour = [0, 1, 2].map(|c| colour[c] + t * s.opacity * s.shaded[c]);
                t *= 1.0 - s.opacity;
            }
        }
        close(model.ray(u, v).colour, colour, 1e-14);
        assert!((model.ray(u, v).transparency - t).abs() < 1e-14);
    }
    let unlit = Model::natural(&scene, &volume).with_lights(None).render();
    let plain = Scene {
        lighting: None,
        ..scene.clone()
    };
    assert_eq!(unlit, Model::natural(&plain, &volume).render());
    assert_ne!(unlit, model.render());
}
