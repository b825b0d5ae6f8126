//! Views in perspective: how near to the f64 model, where frames about the eye meet, and what is seen from within.

use slicecast_compare::perspective::compare;
use slicecast_engine::frame::Layer;
use slicecast_engine::perspective::InPerspective;
use slicecast_engine::simd::Simd;
use slicecast_scene::clip::ClipUnit;
use slicecast_scene::perspective::{Eye, Perspective};
use slicecast_scene::{Blend, Borders, Classification, Point, PrecisionName, Sampling, Scene};
use slicecast_volume::mapping::Window;
use slicecast_volume::open::load;
use slicecast_volume::{Mapping, Volume};

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

/// A projection over a ramp of all codes.
fn projection(blend: Blend, precision: PrecisionName, mapping: Mapping) -> Scene {
    let mut scene = scene("headsq", precision, 96);
    (scene.blend, scene.lighting) = (blend, None);
    let code = |code: f64| mapping.offset + code * mapping.scale;
    let ends = [(code(0.0), 0.0), (code(4095.0), 1.0)];
    let first = scene.transfer.points[0];
    scene.transfer.points = ends
        .map(|(value, opacity)| Point {
            value,
            opacity,
            ..first
        })
        .into();
    scene
}

/// Within the limits of composited samples.
#[test]
fn projections_are_close_to_the_model() {
    let volume = head();
    for (precision, equal, largest) in LIMITS {
        for blend in [Blend::Maximum, Blend::Minimum, Blend::Average, Blend::Additive] {
            let scene = projection(blend, precision, volume.mapping);
            for eye in EYES {
                let perspective = perspective(eye);
                let prepared = InPerspective::new(&scene, &perspective, &volume).expect("something is seen");
                let found = compare(&scene, &volume, &prepared, &|_, _| ()).expect("a small frame");
                let image = found.image;
                assert!(image.values > 1000);
                assert!(
                    image.equal_percent >= equal && image.max_lsb8 <= largest,
                    "{} {blend:?} {eye:?}: {image:?}",
                    precision.name()
                );
            }
        }
    }
}

/// A step is at most an eighth of the diagonal.
#[test]
fn a_sum_of_few_steps_is_refused() {
    let mut volume = head();
    volume.dims = [3; 3];
    volume.voxels.truncate(27);
    let mut scene = projection(Blend::Additive, PrecisionName::Compact, volume.mapping);
    let seen = perspective(EYES[0]);
    let refused = InPerspective::new(&scene, &seen, &volume)
        .map(|_| ())
        .expect_err("few steps");
    assert!(refused.to_string().contains("eight steps or more"), "{refused}");
    scene.sampling.planes_per_voxel = 8;
    InPerspective::new(&scene, &seen, &volume).expect("enough steps");
}

/// Where a place of the volume is seen, pixels from the upper left one, and its distance along the viewing direction: the pinhole, written
/// from the camera's angles alone.
fn seen_at(scene: &Scene, fov: f64, eye: [f64; 3], spacing: [f64; 3], place: [f64; 3]) -> ([f64; 2], f64) {
    let axes = scene.view.axes();
    let along = |axis: [f64; 3]| -> f64 { (0..3).map(|a| (place[a] - eye[a]) * spacing[a] * axis[a]).sum() };
    let (right, up, forward) = (along(axes.right), along(axes.up), along(axes.forward));
    let size = f64::from(scene.image.size.expect("a stated size")[1]);
    let scale = size / 2.0 / (fov / 2.0).to_radians().tan();
    let middle = (size - 1.0) / 2.0;
    (
        [middle + right / forward * scale, middle - up / forward * scale],
        forward,
    )
}

/// A bright voxel appears where a pinhole puts it, through every facet, whatever the spacing.
#[test]
fn places_are_seen_where_a_pinhole_puts_them() {
    let mut facets = std::collections::BTreeSet::new();
    let (fov, spacing) = (100.0, [1.0, 0.8, 1.4]);
    let eye = [14.2, 16.7, 12.1];
    for place in [
        [4, 14, 9],
        [25, 18, 14],
        [16, 5, 10],
        [12, 28, 15],
        [13, 15, 3],
        [17, 19, 21],
        [24, 27, 19],
        [5, 6, 5],
    ] {
        let mut voxels = vec![0; 30 * 34 * 25];
        voxels[place[0] + 30 * (place[1] + 34 * place[2])] = 4095;
        let volume = Volume {
            name: "a voxel".into(),
            dims: [30, 34, 25],
            spacing,
            voxels,
            mapping: Mapping {
                scale: 1.0,
                offset: 0.0,
            },
        };
        let mut scene = scene("ct-fog", PrecisionName::Wide, 240);
        scene.lighting = None;
        scene.sampling = Sampling {
            planes_per_voxel: 4,
            rays_per_voxel: 8,
        };
        let point = |value, opacity| Point {
            value,
            colour: [1.0; 3],
            opacity,
        };
        scene.transfer.points = vec![point(0.0, 0.0), point(4095.0, 0.05)];
        let at = place.map(|c| c as f64);
        // Towards the voxel, but not straight at it.
        let towards = [0, 1, 2].map(|a| (at[a] - eye[a]) * spacing[a]);
        scene.view.azimuth = (-towards[0]).atan2(towards[1]).to_degrees() + 17.0;
        scene.view.elevation =
            ((-towards[2]).atan2(towards[0].hypot(towards[1])).to_degrees() + 11.0).clamp(-90.0, 90.0);
        scene.view.roll = 30.0;
        let perspective = perspective((fov, Some(eye)));
        let prepared = InPerspective::new(&scene, &perspective, &volume).expect("something is seen");
        let frame = prepared.render(Layer::Tiles(32), &|_, _| ()).expect("a small frame");
        let ([x, y], distance) = seen_at(&scene, fov, eye, spacing, at);
        assert!(distance > 2.0 && (5.0..235.0).contains(&x) && (5.0..235.0).contains(&y));
        let (place_of_pixel, _) = prepared.point(x.round() as u32, y.round() as u32).expect("a facet");
        facets.insert((
            prepared.facets[place_of_pixel].axis(),
            towards[prepared.facets[place_of_pixel].axis()] < 0.0,
        ));
        let (mut light, mut sums) = (0.0, [0.0; 2]);
        for (index, red) in frame.base.planes[0].iter().enumerate() {
            let red = f64::from(*red);
            light += red;
            sums[0] += red * (index % 240) as f64;
            sums[1] += red * (index / 240) as f64;
        }
        // A voxel's blot is some pixels wide and not quite even: nearer parts are larger.
        let off = [sums[0] / light - x, sums[1] / light - y].map(f64::abs);
        assert!(off[0].max(off[1]) < 1.0, "{place:?}: {off:?} pixels off {x}, {y}");
    }
    assert_eq!(facets.len(), 6, "every facet is looked through: {facets:?}");
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
