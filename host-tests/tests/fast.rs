//! 16-bit lanes: the same bits by rays one by one, by every vector width, in tiles and as a stream; and how near to the f64 model.

use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed};
use slicecast_compare::{ModelPositions, compare};
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::image::BaseImage;
use slicecast_engine::oriented::Oriented;
use slicecast_engine::simd::Simd;
use slicecast_host_tests::frame::Frame;
use slicecast_host_tests::record::recorded;
use slicecast_rays as rays;
use slicecast_scene::file::parse;
use slicecast_scene::{Blend, Borders, LookupName, PrecisionName};
use slicecast_volume::mapping::Window;
use slicecast_volume::open::load;

use super::frames::{frame, wide_frame};

/// Whether 16-bit lanes know all of a frame.
pub fn is_fast(frame: &Frame) -> bool {
    let plain = frame.segments.is_none() && frame.modulation.is_none() && frame.reflectance.is_none();
    let uncut = frame.clips.is_empty() && frame.cue.is_none();
    let linear = !frame.splines && frame.lookup != Some(LookupName::Nearest);
    plain && uncut && linear && frame.eye.is_none()
}

/// A frame of what 16-bit lanes know.
fn fast(frame: Frame) -> Frame {
    Frame {
        precision: PrecisionName::Fast,
        segments: None,
        modulation: None,
        reflectance: None,
        clips: Vec::new(),
        cue: None,
        lookup: Some(LookupName::Linear),
        ..frame
    }
}

/// The first pixel in which images differ.
fn difference(expected: &BaseImage, found: &BaseImage) -> Option<String> {
    if (expected.size, expected.format, expected.one) != (found.size, found.format, found.one) {
        return Some(format!("sizes {:?} and {:?}", expected.size, found.size));
    }
    (expected.planes.iter().zip(&found.planes).enumerate()).find_map(|(channel, (a, b))| {
        let at = a.iter().zip(b).position(|(a, b)| a != b)?;
        let (u, v) = (at % expected.size[0], at / expected.size[0]);
        Some(format!("channel {channel}, u {u}, v {v}: {} and {}", a[at], b[at]))
    })
}

proptest! {
    #![proptest_config(Config { cases: 600, rng_seed: RngSeed::Fixed(1612), failure_persistence: None, ..Config::default() })]

    #[test]
    fn every_way_is_that_of_rays(given in prop_oneof![3 => frame().boxed(), 1 => wide_frame().boxed()]) {
        let frame = fast(given);
        let expected = frame.with_prepared(|prepared, _| rays::render(prepared, &mut rays::Unobserved)).expect("a good material");
        for simd in Simd::available() {
            // Rows as a whole, and the runs of blocks that can be seen.
            for (rows, dense) in [(1 << 20, 0.0), (3, 0.0), (1 << 20, 2.0), (5, 2.0)] {
                let made = frame.with_prepared(|prepared, slices| {
                    let prepared = prepared.clone().with_simd(simd);
                    let volume = Oriented::of(slices).dense_from(dense);
                    let rendered = prepared.render_oriented(&volume, Layer::Tiles(rows), &|_, _| ());
                    rendered.expect("a good frame").base
                });
                let way = if dense == 0.0 { "whole" } else { "in runs" };
                prop_assert_eq!(difference(&expected, &made), None, "{} in tiles of {} rows, {}", simd.name(), rows, way);
            }
        }
        for (name, layer) in [("stream", Layer::Stream), ("tapped tiles", Layer::Tiles(7))] {
            let (made, _) = recorded(&frame, layer);
            prop_assert_eq!(difference(&expected, &made), None, "{}", name);
        }
    }
}

/// Scenes of the built-in head: equal bytes, percent. No value is a step of 1/255 off.
#[test]
fn pictures_are_close_to_the_model() {
    let volume = load(None, Window::Auto).expect("the built-in volume").volume;
    for (name, equal) in [("headsq", 98.5), ("ct-bone", 98.5), ("ct-fog", 99.4)] {
        let mut scene = slicecast_scene::file::built_in(name).expect("a built-in scene");
        scene.precision = PrecisionName::Fast;
        let prepared = Prepared::new(&scene, &volume).expect("a good scene");
        let found = compare(&prepared, ModelPositions::Pipeline, &|_, _| ())
            .expect("a small frame")
            .image;
        println!(
            "{name}: {:.2} % equal, at most {:.3}",
            found.equal_percent, found.max_lsb8
        );
        assert!(found.equal_percent >= equal && found.max_lsb8 < 1.0, "{name}");
    }
}

/// A grey ramp over all codes, 0.0623 of 1/255 a code. A sample is within 0.38 codes (three roundings of 1/16, and three weights that
/// lack up to 2^-16 of differences up to 4095), a mean rounded to within 1/16 more; the table, the look-up, what a full opacity lets
/// pass and the pixel are at most 4 of 65535: 0.05 of 1/255 in all. Roundings as scattered as these change fewer than one byte of 100.
#[test]
fn projections_are_close_to_the_model() {
    let volume = load(None, Window::Auto).expect("the built-in volume").volume;
    let [low, high] = [0.0, 4095.0].map(|code| volume.mapping.value(code));
    let ramp = format!(
        "[view]\nazimuth = 30.0\nelevation = 10.0\n[sampling]\nplanes_per_voxel = 2\n[transfer]\npoints = [\
         {{ value = {low:?}, colour = \"#000000\", opacity = 1.0 }}, {{ value = {high:?}, colour = \"#ffffff\", opacity = 1.0 }}]\n"
    );
    let mut scene = parse(&ramp, "ramp").expect("a scene");
    scene.precision = PrecisionName::Fast;
    for borders in [Borders::Whole, Borders::Cells] {
        for blend in [Blend::Maximum, Blend::Minimum, Blend::Average, Blend::Additive] {
            (scene.blend, scene.borders) = (blend, borders);
            let prepared = Prepared::new(&scene, &volume).expect("a good scene");
            let found = compare(&prepared, ModelPositions::Pipeline, &|_, _| ())
                .expect("a small frame")
                .image;
            let (equal, most) = (found.equal_percent, found.max_lsb8);
            println!("{blend:?}, {borders:?}: {equal:.2} % equal, at most {most:.4}");
            assert!(equal >= 99.0 && most <= 0.05, "{blend:?}: {equal} {most}");
        }
    }
}
