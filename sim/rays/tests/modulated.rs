//! Modulated scenes and sums: every layer and every vector width has the bits of the reference by rays.

use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::image::BaseImage;
use slicecast_engine::simd::Simd;
use slicecast_rays::{Unobserved, render};
use slicecast_scene::file::built_in;
use slicecast_scene::modulation::Modulation;
use slicecast_scene::reflectance::{Filter, Reflectance};
use slicecast_scene::{Blend, Borders, PrecisionName, Scene};
use slicecast_volume::{Mapping, Volume};

/// Shells around an empty middle, wide enough for blocks that cannot be seen.
fn volume() -> Volume {
    let dims = [70, 21, 23];
    let voxel = |index: usize| {
        let place = [index % dims[0], index / dims[0] % dims[1], index / dims[0] / dims[1]];
        let radius = (0..3)
            .map(|a| (place[a] as f64 - dims[a] as f64 / 2.3).powi(2))
            .sum::<f64>()
            .sqrt();
        (1500.0 + 1500.0 * (radius / 1.7).cos() * f64::from(u8::from(radius < 9.0))) as u16
    };
    Volume {
        name: "shells".into(),
        dims,
        spacing: [1.0, 0.7, 1.3],
        voxels: (0..dims.iter().product()).map(voxel).collect(),
        mapping: Mapping {
            scale: 1.0,
            offset: -1000.0,
        },
    }
}

/// The base-plane image by every layer and width.
fn same(scene: &Scene, volume: &Volume) -> BaseImage {
    let prepared = Prepared::new(scene, volume).unwrap();
    let expected = render(&prepared, &mut Unobserved).unwrap();
    let of = |prepared: &Prepared<'_>, layer| prepared.render(layer, &|_, _| ()).unwrap().base;
    assert!(of(&prepared, Layer::Stream) == expected, "stream: {scene:?}");
    for simd in Simd::available() {
        let prepared = prepared.clone().with_simd(simd);
        for rows in [1, 5, 32] {
            assert!(
                of(&prepared, Layer::Tiles(rows)) == expected,
                "{simd:?}, {rows} rows: {scene:?}"
            );
        }
    }
    expected
}

#[test]
fn modulated_scenes_are_the_reference() {
    let volume = volume();
    let steps = Modulation {
        opacity: vec![[0.0, 0.0], [150.0, 0.1], [400.0, 1.0]],
        diffuse: vec![[100.0, 0.25], [300.0, 1.0]],
        specular: vec![[0.0, 1.0], [300.0, 0.0]],
    };
    let ones = Modulation {
        opacity: vec![[0.0, 1.0]],
        diffuse: vec![[0.0, 1.0]],
        specular: vec![[0.0, 1.0]],
    };
    for (number, precision) in PrecisionName::STAGED.into_iter().enumerate() {
        for (lit, blend) in [
            (true, Blend::FrontToBack),
            (true, Blend::BackToFront),
            (false, Blend::FrontToBack),
            (false, Blend::BackToFront),
        ] {
            let mut scene = built_in(["headsq", "ct-fog", "ct-bone"][number]).unwrap();
            scene.precision = precision;
            scene.blend = blend;
            scene.borders = [Borders::Cells, Borders::Whole, Borders::Nodes][number];
            scene.view.azimuth = 20.0 + 50.0 * number as f64;
            if !lit {
                scene.lighting = None;
            } else if scene.lighting.is_none() {
                scene.lighting = Some(slicecast_scene::Lighting::default());
            }
            let plain = same(&scene, &volume);
            let mut of = |modulation: &Modulation| {
                scene.modulation = Some(modulation.clone());
                if !lit {
                    let modulation = scene.modulation.as_mut().unwrap();
                    (modulation.diffuse, modulation.specular) = (Vec::new(), Vec::new());
                }
                scene.check().unwrap();
                same(&scene, &volume)
            };
            assert!(of(&ones) == plain, "factors of 1 change {precision:?}, lit {lit}");
            assert!(of(&steps) != plain, "factors change nothing: {precision:?}, lit {lit}");
        }
    }
}

#[test]
fn mapped_scenes_are_the_reference() {
    let volume = volume();
    for (number, precision) in PrecisionName::STAGED.into_iter().enumerate() {
        for blend in [Blend::FrontToBack, Blend::BackToFront] {
            let mut scene = built_in(["headsq", "ct-soft-tissue", "ct-bone"][number]).unwrap();
            scene.precision = precision;
            scene.blend = blend;
            scene.borders = [Borders::Cells, Borders::Whole, Borders::Nodes][number];
            // Coloured light takes three channels.
            if number == 1 {
                scene.lighting.as_mut().unwrap().lights[0].colour = [1.0, 0.5, 0.25];
            }
            let plain = same(&scene, &volume);
            let mut of = |filter| {
                scene.reflectance = Some(Reflectance { side: 24, filter });
                scene.check().unwrap();
                same(&scene, &volume)
            };
            let (nearest, bilinear) = (of(Filter::Nearest), of(Filter::Bilinear));
            assert!(
                nearest != plain && bilinear != plain && nearest != bilinear,
                "{precision:?}"
            );
        }
    }
}

#[test]
fn sums_are_the_reference() {
    let volume = volume();
    for precision in PrecisionName::STAGED {
        for borders in [Borders::Whole, Borders::Cells, Borders::Nodes] {
            let mut scene = built_in("headsq").unwrap();
            scene.precision = precision;
            scene.borders = borders;
            let mut found = [Blend::Maximum, Blend::Average, Blend::Additive].map(|blend| {
                scene.blend = blend;
                same(&scene, &volume)
            });
            found.sort_by_key(|image| image.planes.clone());
            assert!(
                found[0] != found[1] && found[1] != found[2],
                "{precision:?} {borders:?}"
            );
        }
    }
}
