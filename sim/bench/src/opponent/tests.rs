//! The opponent renders what the fixed-point pipeline renders: no straw man.

use super::*;
use slicecast_engine::frame::Layer;
use slicecast_engine::oriented::Turned;
use slicecast_engine::tile::TILE_ROWS;
use slicecast_scene::{Borders, Highlight, Light, PrecisionName, Sampling, Scene, file};
use slicecast_volume::mapping::Window;
use slicecast_volume::open::load;
use slicecast_volume::{Mapping, Volume};

/// Largest difference of any premultiplied value of the base plane from the fixed-point frame, in steps of 1/255, over
/// all widths; and that of the fog's transparency alone.
fn difference(scene: &Scene, volume: &Volume) -> f64 {
    let prepared = Prepared::new(scene, volume).unwrap();
    let expected = prepared.render(Layer::Tiles(TILE_ROWS), &|_, _| ()).unwrap().base;
    let plan = &prepared.setup.plan;
    let mut opponent = Opponent::of(&prepared);
    let usual = opponent.few;
    let mut worst = 0.0f64;
    let mut seen = 0.0f64;
    let mut turned = Turned::new(volume, plan);
    let slices = turned.slices().unwrap();
    let oriented = Oriented::of(&slices);
    for simd in Simd::available() {
        opponent.few = 0.0;
        let image = folded(&opponent, plan, &oriented, simd);
        // Whatever is left out, the bits are the same: of all blocks, and of those that are taken.
        for few in [2.0, usual] {
            opponent.few = few;
            let blocks = folded(&opponent, plan, &oriented, simd);
            for (u, v) in (0..expected.size[1]).flat_map(|v| (0..expected.size[0]).map(move |u| (u, v))) {
                let [rows, blocks] =
                    [&image, &blocks].map(|image| Opponent::pixel(plan, image, u, v).map(f32::to_bits));
                assert_eq!(rows, blocks, "{simd:?} at {u}, {v}");
            }
        }
        let [width, height] = expected.size;
        for (u, v) in (0..height).flat_map(|v| (0..width).map(move |u| (u, v))) {
            let found = Opponent::pixel(plan, &image, u, v);
            for (found, plane) in found.into_iter().zip(&expected.planes) {
                let exact = f64::from(plane[v * width + u]) / f64::from(expected.one);
                let difference = 255.0 * (f64::from(found) - exact).abs();
                assert!(difference.is_finite(), "{simd:?} at {u}, {v}");
                worst = worst.max(difference);
                seen = seen.max(exact * f64::from(u8::from(exact < 1.0)));
            }
        }
    }
    assert!(seen > 0.05, "a picture of nothing proves nothing");
    worst
}

fn folded(opponent: &Opponent, plan: &Plan, oriented: &Oriented<'_>, simd: Simd) -> Vec<f32> {
    let mut image = vec![f32::NAN; Opponent::image_len(plan)];
    Opponent::clear(plan, &mut image);
    opponent.fold(plan, oriented, &mut image, TILE_ROWS, simd);
    image
}

/// Steps of 1/255 that a value may differ from the fixed-point one. Two sources: `Wide` against f64 stays within 0.012
/// (docs/results.md), and f32 adds up to 600 roundings of 2^-24 a ray, a reciprocal root of 22 bits and a cosine raised
/// to the 32nd power, which multiplies that error by 32.
const TOLERANCE: f64 = 0.05;

fn head() -> Volume {
    load(None, Window::Auto).unwrap().volume
}

fn in_wide(name: &str) -> Scene {
    Scene {
        precision: PrecisionName::Wide,
        borders: Borders::Whole,
        ..file::built_in(name).unwrap()
    }
}

#[test]
fn scenes_of_the_head_are_the_fixed_point_ones() {
    let head = head();
    for name in ["headsq", "ct-bone", "ct-fog", "ct-vessels"] {
        let worst = difference(&in_wide(name), &head);
        assert!(worst < TOLERANCE, "{name}: {worst}");
    }
}

#[test]
fn noise_between_unequal_spacings_under_coloured_lights_is_the_fixed_point_one() {
    let dims = [37, 21, 18];
    let mut state = 7u64;
    let mut voxel = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 52) as u16
    };
    let volume = Volume {
        name: "noise".into(),
        dims,
        spacing: [1.0, 1.5, 0.75],
        voxels: (0..dims.iter().product()).map(|_| voxel()).collect(),
        mapping: Mapping {
            scale: 1.0,
            offset: -1000.0,
        },
    };
    let mut scene = in_wide("ct-bone");
    scene.sampling = Sampling {
        planes_per_voxel: 3,
        rays_per_voxel: 2,
    };
    let lighting = scene.lighting.as_mut().unwrap();
    lighting.lights.push(Light {
        direction: [0.5, 0.5, 0.5],
        colour: [0.2, 0.5, 0.1],
        ..Light::default()
    });
    for (highlight, azimuth, elevation) in [
        (Highlight::Reflection, 20.0, -15.0),
        (Highlight::HalfVector, 100.0, 30.0),
        (Highlight::Reflection, 10.0, 80.0),
    ] {
        scene.view.azimuth = azimuth;
        scene.view.elevation = elevation;
        scene.lighting.as_mut().unwrap().highlight = highlight;
        let worst = difference(&scene, &volume);
        assert!(worst < TOLERANCE, "{azimuth}: {worst}");
    }
}
