//! Splatted scenes: the same bits whatever does the work, how near to the f64 model, where voxels are seen, and what is refused.

use slicecast::splat::Layout;
use slicecast_compare::image::base_figures;
use slicecast_compare::splat::{compare, model};
use slicecast_engine::error::RenderError;
use slicecast_engine::simd::Simd;
use slicecast_engine::threads::on_threads;
use slicecast_host_tests::random::{Filling, volume};
use slicecast_model::splat::Rounding;
use slicecast_scene::{Blend, Classification, Face, Interpolation, Point, PrecisionName, Sampling, Scene, Surface};
use slicecast_splat::{BAND_ROWS, Splatted};
use slicecast_volume::mapping::Window;
use slicecast_volume::open::load;
use slicecast_volume::{Mapping, Volume};

pub(super) fn head() -> Volume {
    load(None, Window::Auto).expect("the built-in volume").volume
}

fn scene(name: &str, precision: PrecisionName) -> Scene {
    let mut scene = slicecast_scene::file::built_in(name).expect("a built-in scene");
    scene.precision = precision;
    scene.classification = Classification::Point;
    scene.sampling = Sampling {
        planes_per_voxel: 1,
        rays_per_voxel: 1,
    };
    scene
}

/// Equal bytes, percent, and the mean difference, steps of 1/255, of each precision from f64 of the same records. The largest says nothing:
/// where weights add up to half, a rounding decides whether a whole sample exists.
const LIMITS: [(PrecisionName, f64, f64); 2] =
    [(PrecisionName::Compact, 99.3, 0.02), (PrecisionName::Wide, 99.5, 0.005)];

/// Frames that fall short: precision, scene, planes and rays per voxel.
const SHORT: [(&str, &str, u32, u32); 1] = [("compact", "ct-fog", 1, 1)];

/// What the default record rounds.
pub(super) fn rounding() -> Rounding {
    Rounding {
        position: Some(Layout::FINE.position_bits()),
        depth: Some(Layout::FINE.depth_bits()),
        value: Some(Layout::FINE.value_bits()),
    }
}

#[test]
fn pictures_are_close_to_the_model() {
    let volume = head();
    let mut short = Vec::new();
    for (precision, equal, mean) in LIMITS {
        for name in ["headsq", "ct-fog", "ct-bone"] {
            for (planes, rays) in [(1, 1), (2, 1), (1, 2)] {
                let mut scene = scene(name, precision);
                scene.sampling = Sampling {
                    planes_per_voxel: planes,
                    rays_per_voxel: rays,
                };
                let splatted = Splatted::new(&scene, &volume, Layout::FINE).expect("a scene to be splatted");
                let found = compare(&scene, &volume, &splatted, &|_, _| ()).expect("a small frame");
                let records = model(&scene, &volume, &splatted, rounding());
                let (image, exact) = (base_figures(&found.frame.base, &records), found.image);
                println!(
                    "{} {name} {planes} {rays}: {:.3} % equal, {:.4} mean, {:.3} most; exact places {:.3} %, {:.4}, {:.3}",
                    precision.name(),
                    image.equal_percent,
                    image.mean_lsb8,
                    image.max_lsb8,
                    exact.equal_percent,
                    exact.mean_lsb8,
                    exact.max_lsb8,
                );
                assert!(image.values > 1000);
                // Places that are rounded are seen, and no more than that.
                assert!(exact.equal_percent >= 96.0 && exact.mean_lsb8 <= 0.05, "{exact:?}");
                if image.equal_percent < equal || image.mean_lsb8 > mean {
                    short.push((precision.name(), name, planes, rays));
                }
            }
        }
    }
    assert_eq!(short, SHORT);
}

/// Threads, bands, vectors, and whether all voxels are splatted or those that are needed.
#[test]
fn bits_do_not_depend_on_the_work() {
    let mut filled = volume([37, 29, 33], Filling::Noise, 5);
    filled.spacing = [1.0, 1.25, 0.9];
    for (number, volume) in [head(), filled].iter().enumerate() {
        for precision in PrecisionName::STAGED {
            for name in ["headsq", "ct-fog"] {
                let mut scene = scene(name, precision);
                scene.view.azimuth = 21.0 + 40.0 * number as f64;
                scene.sampling.planes_per_voxel = 1 + number as u32;
                let splatted = Splatted::new(&scene, volume, Layout::FINE).expect("a scene to be splatted");
                let splatted = splatted.with_simd(Simd::Scalar);
                let all = splatted.records(false, 1000).expect("few records");
                let wanted = splatted.image(&all, &|_, _| ()).expect("a small frame");
                assert!(wanted.planes[3].iter().any(|left| *left != wanted.one));
                for (threads, rows) in [(1, BAND_ROWS), (2, 7), (5, 1)] {
                    for simd in Simd::available() {
                        let splatted = splatted.clone().with_simd(simd);
                        let (records, found) = on_threads(Some(threads), || {
                            let records = splatted.records(true, rows).expect("few records");
                            let found = splatted.image(&records, &|_, _| ()).expect("a small frame");
                            (records.count(), found)
                        })
                        .expect("threads");
                        assert!(found == wanted, "{name} {threads} {rows} {}", simd.name());
                        // Air is left out of the head; each further band has records of its own.
                        let all = splatted.records(false, rows).expect("few records").count();
                        assert!(number > 0 || records < all, "{records} of {all}");
                    }
                }
            }
        }
    }
}

pub(super) fn point(value: f64, opacity: f64) -> Point {
    Point {
        value,
        colour: [1.0; 3],
        opacity,
    }
}

/// A bright voxel appears where the camera's angles put it, whatever the spacing, also at the corners of the volume.
#[test]
fn voxels_are_seen_where_the_camera_puts_them() {
    let (dims, spacing) = ([20, 26, 15], [1.0, 0.8, 1.4]);
    for place in [[0, 0, 0], [19, 25, 14], [10, 13, 7], [3, 20, 14], [19, 0, 5]] {
        let mut voxels = vec![0; 20 * 26 * 15];
        voxels[place[0] + 20 * (place[1] + 26 * place[2])] = 4095;
        let volume = Volume {
            name: "a voxel".into(),
            dims,
            spacing,
            voxels,
            mapping: Mapping {
                scale: 1.0,
                offset: 0.0,
            },
        };
        for (azimuth, elevation, roll) in [(0.0, 0.0, 0.0), (33.0, 21.0, 10.0), (200.0, -50.0, 77.0)] {
            let mut scene = scene("ct-fog", PrecisionName::Wide);
            scene.lighting = None;
            scene.view.azimuth = azimuth;
            scene.view.elevation = elevation;
            scene.view.roll = roll;
            scene.sampling = Sampling {
                planes_per_voxel: 2,
                rays_per_voxel: 4,
            };
            scene.transfer.points = vec![point(0.0, 0.0), point(4095.0, 0.3)];
            let splatted = Splatted::new(&scene, &volume, Layout::FINE).expect("a scene to be splatted");
            let base = splatted.render(&|_, _| ()).expect("a small frame").base;
            let (mut weights, mut at) = (0.0, [0.0; 2]);
            for (index, left) in base.planes[3].iter().enumerate() {
                let taken = f64::from(base.one - left);
                weights += taken;
                at[0] += taken * (index % base.size[0]) as f64;
                at[1] += taken * (index / base.size[0]) as f64;
            }
            assert!(weights > 0.0, "{place:?}");
            let axes = scene.view.axes();
            let pixel = 0.8 / 4.0;
            for (c, axis) in [(0, axes.right), (1, axes.up.map(|c| -c))] {
                let along: f64 = (0..3)
                    .map(|a| (place[a] as f64 - (dims[a] as f64 - 1.0) / 2.0) * spacing[a] * axis[a])
                    .sum();
                let wanted = along / pixel + (base.size[c] as f64 - 1.0) / 2.0;
                let found = at[c] / weights;
                // At a face of the volume half of the kernel, about, has samples.
                let inside = (0..3).all(|a| place[a] > 1 && place[a] + 2 < dims[a]);
                let most = if inside { 0.05 } else { 4.0 };
                assert!(
                    (found - wanted).abs() < most,
                    "{place:?} {azimuth} {c}: {found} {wanted}"
                );
            }
        }
    }
}

/// Where half of the kernel is missing there is nothing, and nothing is an error.
#[test]
fn empty_sheets_and_volumes_of_one_voxel_are_clear() {
    let empty = volume([9, 8, 7], Filling::Constant(0), 1);
    let mut one = volume([1, 1, 1], Filling::Constant(4000), 1);
    one.spacing = [2.0; 3];
    let mut scene = scene("ct-fog", PrecisionName::Compact);
    scene.transfer.points = vec![point(0.0, 0.0), point(4095.0, 0.9)];
    for volume in [&empty, &one] {
        let splatted = Splatted::new(&scene, volume, Layout::PAPER).expect("a scene to be splatted");
        let frame = splatted.render(&|_, _| ()).expect("a small frame");
        assert!(frame.base.planes[3].iter().all(|left| *left == frame.base.one));
    }
}

#[test]
fn what_splatting_does_not_know_is_named() {
    let volume = head();
    let refused = |change: &dyn Fn(&mut Scene)| {
        let mut scene = scene("headsq", PrecisionName::Compact);
        change(&mut scene);
        match Splatted::new(&scene, &volume, Layout::FINE).map(|_| ()) {
            Err(error @ RenderError::Unsplattable { field, .. }) => {
                assert!(
                    error.to_string().starts_with("splatting knows other scenes: "),
                    "{error}"
                );
                field
            }
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(
        refused(&|scene| scene.interpolation = Interpolation::Nearest),
        "sampling.interpolation"
    );
    assert_eq!(
        refused(&|scene| scene.classification = Classification::Integral),
        "render.classification"
    );
    assert_eq!(refused(&|scene| scene.blend = Blend::Maximum), "render.blend");
    assert_eq!(refused(&|scene| scene.blend = Blend::BackToFront), "render.blend");
    let surface = Surface::of(200.0, Face::default());
    assert_eq!(refused(&|scene| scene.surfaces = vec![surface]), "surfaces");
    let mut large = scene("headsq", PrecisionName::Compact);
    large.sampling.rays_per_voxel = 8;
    let mut long = volume.clone();
    long.dims = [volume.voxels.len() / 8, 4, 2];
    assert!(matches!(
        Splatted::new(&large, &long, Layout::FINE),
        Err(RenderError::Splat(_))
    ));
}
