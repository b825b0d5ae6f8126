//! Whole frames. They are here and not beside what they test, because a test program of the crate's own sources that renders
//! a frame compiles all pipelines once more.

use slicecast_engine::camera::Picture;
use slicecast_engine::cutout::Cutout;
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::image::Frame;
use slicecast_scene::file::built_in;
use slicecast_scene::{
    Blend, Classification, Image, Interpolation, Point, PrecisionName, Sampling, Scene, TransferFunction, View,
};
use slicecast_volume::{Mapping, Volume};

/// Between the labels 2 and 9 lie all labels from 3 to 8, and none of them is there.
#[test]
fn nearest_samples_invent_no_label() {
    let volume = Volume {
        name: "labels".into(),
        dims: [12, 11, 10],
        spacing: [1.0; 3],
        mapping: Mapping {
            scale: 1.0,
            offset: 0.0,
        },
        voxels: (0..12 * 11 * 10).map(|n| if n % 7 < 3 { 2 } else { 9 }).collect(),
    };
    let mut scene = built_in("ct-fog").unwrap();
    let point = |value, opacity| Point {
        value,
        colour: [1.0; 3],
        opacity,
    };
    scene.transfer.points = vec![point(3.5, 0.0), point(5.0, 1.0), point(7.5, 0.0)];
    scene.lighting = None;
    scene.sampling.planes_per_voxel = 3;
    let mut opaque = |interpolation| {
        scene.interpolation = interpolation;
        let prepared = Prepared::new(&scene, &volume).unwrap();
        let base = prepared.render(Layer::Tiles(8), &|_, _| ()).unwrap().base;
        base.planes[3].iter().filter(|left| **left < base.one).count()
    };
    assert_eq!(opaque(Interpolation::Nearest), 0);
    assert!(opaque(Interpolation::Linear) > 50);
}

/// A ball in a box, seen askew.
fn framed(precision: PrecisionName, background: [f64; 3], check: impl Fn(&Frame, &Picture)) {
    let voxel = |index: usize| {
        let place = [index % 9, index / 9 % 9, index / 81].map(|c| c as f64 - 4.0);
        (4000.0 - 60.0 * place.iter().map(|c| c * c).sum::<f64>()).max(0.0) as u16
    };
    let volume = Volume {
        name: "ball".into(),
        dims: [9; 3],
        spacing: [1.0, 1.0, 1.5],
        voxels: (0..729).map(voxel).collect(),
        mapping: Mapping {
            scale: 1.0,
            offset: 0.0,
        },
    };
    let point = |value, colour, opacity| Point { value, colour, opacity };
    let scene = Scene {
        view: View {
            azimuth: 37.0,
            elevation: 21.0,
            roll: 5.0,
        },
        image: Image {
            size: Some([61, 47]),
            background,
            ..Image::default()
        },
        sampling: Sampling {
            planes_per_voxel: 1,
            rays_per_voxel: 2,
        },
        transfer: TransferFunction {
            unit_distance: 1.0,
            points: vec![point(1500.0, [1.0, 0.5, 0.2], 0.0), point(4000.0, [0.3, 0.7, 1.0], 0.4)],
        },
        lighting: None,
        blend: Blend::FrontToBack,
        precision,
        table: None,
        lookup: None,
        interpolation: Interpolation::Linear,
        borders: slicecast_scene::Borders::Whole,
        early_termination: None,
        classification: Classification::Point,
        pieces: 1,
        colours: None,
        crop: None,
        clips: Vec::new(),
        cueing: None,
        perspective: None,
        modulation: None,
        reflectance: None,
        surfaces: Vec::new(),
    };
    let prepared = Prepared::new(&scene, &volume).unwrap();
    let frame = prepared.render(Layer::Tiles(8), &|_, _| {}).unwrap();
    check(&frame, &prepared.setup.picture);
}

#[test]
fn in_front_of_the_background_it_is_the_picture() {
    let background = [0.25, 1.0, 0.625];
    for precision in PrecisionName::STAGED {
        framed(precision, background, |frame, picture| {
            let cutout = Cutout::of(&frame.base, picture);
            let one = u64::from(cutout.one);
            let bytes = cutout.pixels.iter().flat_map(|[red, green, blue, transparency]| {
                [(red, 0.25), (green, 1.0), (blue, 0.625)].map(|(channel, behind): (_, f64)| {
                    let behind = (u64::from(*transparency) * (behind * 32768.0) as u64 + (1 << 14)) >> 15;
                    let sum = (u64::from(*channel) + behind).min(one);
                    ((sum * 255 + one / 2) / one) as u8
                })
            });
            assert_eq!(bytes.collect::<Vec<_>>(), frame.picture.bytes, "{}", precision.name());
            let opaque = cutout.pixels.iter().filter(|pixel| pixel[3] < cutout.one).count();
            assert!((500..2000).contains(&opaque), "{opaque}");
        });
    }
}
