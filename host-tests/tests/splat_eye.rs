//! Scenes that are splatted in perspective: the same bits whatever does the work, how near to the f64 model, where voxels are seen, and
//! what is refused.

use slicecast::splat::{Layout, SplatError};
use slicecast_compare::image::base_figures;
use slicecast_compare::splat::{compare, model};
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::Layer;
use slicecast_engine::perspective::InPerspective;
use slicecast_engine::simd::Simd;
use slicecast_engine::threads::on_threads;
use slicecast_engine::tile::TILE_ROWS;
use slicecast_host_tests::random::{Filling, volume};
use slicecast_scene::clip::ClipUnit;
use slicecast_scene::perspective::{Eye, Perspective};
use slicecast_scene::{Classification, PrecisionName, Sampling, Scene};
use slicecast_splat::{BAND_ROWS, Splatted};
use slicecast_volume::{Mapping, Volume};

use super::splat::{head, point, rounding};

/// A built-in scene seen from the outside, or from an eye.
fn scene(name: &str, precision: PrecisionName, fov: f64, eye: Option<[f64; 3]>) -> Scene {
    let mut scene = slicecast_scene::file::built_in(name).expect("a built-in scene");
    scene.precision = precision;
    scene.classification = Classification::Point;
    scene.sampling = Sampling {
        planes_per_voxel: 1,
        rays_per_voxel: 1,
    };
    scene.image.size = Some([96, 90]);
    let unit = ClipUnit::Voxels;
    scene.perspective = Some(Perspective {
        fov,
        eye: eye.map(|at| Eye { at, unit }),
    });
    scene
}

/// The middle of the skull.
const WITHIN: [f64; 3] = [31.3, 28.6, 34.2];

/// Equal values, percent, and the mean difference, steps of 1/255, of each precision from f64 of the same records. The largest
/// says nothing: where weights add up to half, a rounding decides whether a whole sample exists. In parallel 99.3 and 99.5, 0.02
/// and 0.005; here widths and depths are rounded as well.
const LIMITS: [(PrecisionName, f64, f64); 2] =
    [(PrecisionName::Compact, 99.0, 0.03), (PrecisionName::Wide, 99.3, 0.01)];

/// Frames that fall short: precision, scene, field of view. All are lit and from within, where pixels near the eye are a fiftieth of a voxel
/// apart: what a gradient is taken from are differences of weights that are rounded to 2^-18.
const SHORT: [(&str, &str, f64); 3] = [
    ("compact", "ct-bone", 90.0),
    ("wide", "headsq", 90.0),
    ("wide", "ct-bone", 90.0),
];

#[test]
fn pictures_are_close_to_the_model() {
    let volume = head();
    let mut short = Vec::new();
    for (precision, equal, mean) in LIMITS {
        for name in ["headsq", "ct-fog", "ct-bone"] {
            for (fov, eye) in [(20.0, None), (60.0, None), (90.0, Some(WITHIN))] {
                let scene = scene(name, precision, fov, eye);
                let splatted = Splatted::new(&scene, &volume, Layout::FINE).expect("a scene to be splatted");
                let found = compare(&scene, &volume, &splatted, &|_, _| ()).expect("a small frame");
                let records = model(&scene, &volume, &splatted, rounding());
                let (image, exact) = (base_figures(&found.frame.base, &records), found.image);
                println!(
                    "{} {name} {fov}: {:.3} % equal, {:.4} mean, {:.3} most; exact places {:.3} %, {:.4}, {:.3}",
                    precision.name(),
                    image.equal_percent,
                    image.mean_lsb8,
                    image.max_lsb8,
                    exact.equal_percent,
                    exact.mean_lsb8,
                    exact.max_lsb8,
                );
                assert!(image.values > 1000);
                if image.equal_percent < equal || image.mean_lsb8 > mean {
                    short.push((precision.name(), name, fov));
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
            for (name, fov, eye) in [
                ("headsq", 40.0, None),
                ("ct-fog", 60.0, None),
                ("headsq", 100.0, Some([18.0, 14.5, 16.0])),
            ] {
                let mut scene = scene(name, precision, fov, eye);
                scene.view.azimuth = 21.0 + 40.0 * number as f64;
                let splatted = Splatted::new(&scene, volume, Layout::FINE).expect("a scene to be splatted");
                let splatted = splatted.with_simd(Simd::Scalar);
                let all = splatted.records(false, 1000).expect("few records");
                let wanted = splatted.image(&all, &|_, _| ()).expect("a small frame");
                assert!(wanted.planes[3].iter().any(|left| *left != wanted.one));
                for (threads, rows) in [(1, BAND_ROWS), (2, 7), (5, 1)] {
                    for simd in Simd::available() {
                        let splatted = splatted.clone().with_simd(simd);
                        let found = on_threads(Some(threads), || {
                            let records = splatted.records(true, rows).expect("few records");
                            splatted.image(&records, &|_, _| ()).expect("a small frame")
                        })
                        .expect("threads");
                        assert!(found == wanted, "{name} {fov} {threads} {rows} {}", simd.name());
                    }
                }
            }
        }
    }
}

/// A bright voxel is seen where its ray meets the image, whatever the volume's sides, spacing and view.
#[test]
fn voxels_are_where_the_eye_sees_them() {
    let (dims, spacing) = ([13usize, 11, 15], [1.0, 0.8, 1.3]);
    for place in [[6, 5, 7], [3, 2, 4], [9, 8, 11]] {
        let mut voxels = vec![0; dims.iter().product()];
        voxels[place[0] + dims[0] * (place[1] + dims[1] * place[2])] = 4000;
        let volume = Volume {
            name: "one".into(),
            dims,
            spacing,
            voxels,
            mapping: Mapping {
                scale: 1.0,
                offset: 0.0,
            },
        };
        for (azimuth, elevation, fov) in [(0.0, 0.0, 30.0), (33.0, 21.0, 60.0), (200.0, -50.0, 90.0)] {
            let mut scene = scene("ct-fog", PrecisionName::Wide, fov, None);
            scene.lighting = None;
            scene.view.azimuth = azimuth;
            scene.view.elevation = elevation;
            scene.image.size = Some([200, 160]);
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
            let half = (fov / 2.0).to_radians();
            let radius = (0..3)
                .map(|a| (dims[a] as f64 * spacing[a]).powi(2))
                .sum::<f64>()
                .sqrt()
                / 2.0;
            let beside = |axis: [f64; 3]| -> f64 {
                (0..3)
                    .map(|a| (place[a] as f64 - (dims[a] as f64 - 1.0) / 2.0) * spacing[a] * axis[a])
                    .sum()
            };
            // As far away as the sphere about the volume's voxels, with half a voxel around them, just fits.
            let depth = beside(axes.forward) + radius / half.sin();
            let distance = base.size[1] as f64 / 2.0 / half.tan();
            for (c, axis) in [(0, axes.right), (1, axes.up.map(|c| -c))] {
                let wanted = beside(axis) / depth * distance + (base.size[c] as f64 - 1.0) / 2.0;
                let found = at[c] / weights;
                // A kernel's front half looks larger than its rear half: a tenth of a voxel.
                let most = 0.15 / depth * distance + 0.15 * (wanted - base.size[c] as f64 / 2.0).abs();
                assert!(
                    (found - wanted).abs() < most,
                    "{place:?} {azimuth} {c}: {found} {wanted}, {most}"
                );
            }
        }
    }
}

/// Both see the same object in the same pixels: rays in perspective and splats.
#[test]
fn pictures_are_those_of_rays() {
    let volume = head();
    for (fov, eye) in [(40.0, None), (90.0, Some(WITHIN))] {
        let mut scene = scene("ct-bone", PrecisionName::Wide, fov, eye);
        scene.lighting = None;
        scene.sampling.rays_per_voxel = 2;
        let seen = scene.perspective.expect("a perspective");
        let rays = InPerspective::new(&scene, &seen, &volume).expect("a view");
        let rays = rays.render(Layer::Tiles(TILE_ROWS), &|_, _| ()).expect("a small frame");
        let splats = Splatted::new(&scene, &volume, Layout::FINE).expect("a scene to be splatted");
        let splats = splats.render(&|_, _| ()).expect("a small frame");
        let (a, b) = (&rays.picture.bytes, &splats.picture.bytes);
        assert_eq!(a.len(), b.len());
        let mean = |bytes: &[u8]| bytes.iter().map(|b| f64::from(*b)).sum::<f64>() / bytes.len() as f64;
        let both: f64 = (a.iter().zip(b))
            .map(|(x, y)| (f64::from(*x) - mean(a)) * (f64::from(*y) - mean(b)))
            .sum();
        let own = |bytes: &[u8]| bytes.iter().map(|x| (f64::from(*x) - mean(bytes)).powi(2)).sum::<f64>();
        let correlation = both / (own(a) * own(b)).sqrt();
        println!("{fov}: correlation {correlation:.4}");
        assert!(correlation > 0.9, "{fov}: {correlation}");
    }
}

#[test]
fn what_is_out_of_range_is_named() {
    let volume = head();
    let behind = scene("headsq", PrecisionName::Compact, 40.0, Some([32.0, 500.0, 32.0]));
    assert!(matches!(
        Splatted::new(&behind, &volume, Layout::FINE),
        Err(RenderError::Splat(SplatError::Nothing))
    ));
    let mut large = scene("headsq", PrecisionName::Compact, 40.0, None);
    large.image.size = Some([2048, 2048]);
    assert!(matches!(
        Splatted::new(&large, &volume, Layout::FINE),
        Err(RenderError::Splat(SplatError::Image { .. }))
    ));
    let mut broad = scene("headsq", PrecisionName::Compact, 120.0, Some(WITHIN));
    broad.image.size = Some([420, 120]);
    assert!(matches!(
        Splatted::new(&broad, &volume, Layout::FINE),
        Err(RenderError::Splat(SplatError::Slopes))
    ));
}
