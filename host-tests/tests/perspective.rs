//! Views in perspective: how near to the f64 model, where frames about the eye meet, and what is seen from within.

use slicecast_compare::perspective::compare;
use slicecast_engine::frame::Layer;
use slicecast_engine::perspective::InPerspective;
use slicecast_engine::simd::Simd;
use slicecast_scene::clip::ClipUnit;
use slicecast_scene::perspective::{Eye, Perspective};
use slicecast_scene::{Borders, Classification, PrecisionName, Sampling, Scene};
use slicecast_volume::Volume;
use slicecast_volume::mapping::Window;
use slicecast_volume::open::load;

fn head() -> Volume {
    load(None, Window::Auto).expect("the built-in volume").volume
}

fn scene(name: &str, precision: PrecisionName, size: u32) -> Scene {
    let mut scene = slicecast_scene::file::built_in(name).expect("a built-in scene");
    scene.precision = precision;
    scene.borders = Borders::Whole;
    scene.classification = Classification::Point;
    scene.sampling = Sampling {
        planes_per_voxel: 1,
        rays_per_voxel: 1,
    };
    scene.image.size = Some([size; 2]);
    scene
}

/// From outside, far and near, and from within the skull, where four facets are seen.
const EYES: [(f64, Option<[f64; 3]>); 4] = [
    (30.0, None),
    (90.0, None),
    (120.0, Some([31.3, 28.6, 34.2])),
    (60.0, Some([32.0, 12.0, 36.25])),
];

fn perspective((fov, eye): (f64, Option<[f64; 3]>)) -> Perspective {
    let unit = ClipUnit::Voxels;
    Perspective {
        fov,
        eye: eye.map(|at| Eye { at, unit }),
    }
}

/// Equal bytes, percent, and the largest difference, steps of 1/255, of each precision.
const LIMITS: [(PrecisionName, f64, f64); 2] =
    [(PrecisionName::Compact, 99.3, 0.25), (PrecisionName::Wide, 99.5, 0.05)];

#[test]
fn pictures_are_close_to_the_model() {
    let volume = head();
    for (precision, equal, largest) in LIMITS {
        for name in ["headsq", "ct-fog", "ct-bone"] {
            let scene = scene(name, precision, 96);
            for eye in EYES {
                let perspective = perspective(eye);
                let prepared = InPerspective::new(&scene, &perspective, &volume).expect("something is seen");
                let found = compare(&scene, &volume, &prepared, &|_, _| ()).expect("a small frame");
                let [image, picture] = [found.image, found.picture];
                println!(
                    "{} {name} {eye:?}: {} facets, base planes {:.3} % equal, {:.4} mean, {:.3} most; picture {:.3} %, {:.3}",
                    precision.name(),
                    prepared.facets.len(),
                    image.equal_percent,
                    image.mean_lsb8,
                    image.max_lsb8,
                    picture.equal_percent,
                    picture.max_lsb8,
                );
                assert!(image.values > 1000 && picture.values > 1000);
                assert!(image.equal_percent >= equal && image.max_lsb8 <= largest, "{image:?}");
            }
        }
    }
}

/// By every vector width, number of threads and layer, through the engine as a program uses it.
#[test]
fn pictures_do_not_depend_on_the_machine() {
    let volume = head();
    let scene = scene("headsq", PrecisionName::Compact, 64);
    let perspective = perspective(EYES[2]);
    let prepared = InPerspective::new(&scene, &perspective, &volume).expect("something is seen");
    assert_eq!(prepared.facets.len(), 4);
    let expected = prepared.render(Layer::Stream, &|_, _| ()).expect("a small frame");
    for simd in Simd::available() {
        for rows in [1, 7, 32] {
            let prepared = prepared.clone().with_simd(simd);
            let found = prepared.render(Layer::Tiles(rows), &|_, _| ()).expect("a small frame");
            assert_eq!(found, expected, "{}, {rows} rows", simd.name());
        }
    }
}
