//! 16-bit lanes: the same bits by rays one by one, by every vector width, in tiles and as a stream; and how near to the f64 model.

use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed};
use slicecast_compare::{ModelPositions, compare};
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::image::BaseImage;
use slicecast_engine::oriented::Oriented;
use slicecast_engine::rays;
use slicecast_engine::simd::Simd;
use slicecast_host_tests::frame::Frame;
use slicecast_host_tests::record::recorded;
use slicecast_scene::{Blend, LookupName, PrecisionName};
use slicecast_volume::mapping::Window;
use slicecast_volume::open::load;

use super::frames::{frame, wide_frame};

/// Whether 16-bit lanes know all of a frame.
pub fn is_fast(frame: &Frame) -> bool {
    let plain = frame.segments.is_none() && frame.modulation.is_none() && frame.reflectance.is_none();
    let uncut = frame.clips.is_empty() && frame.cue.is_none();
    let linear = !frame.splines && frame.lookup != Some(LookupName::Nearest);
    plain && uncut && linear && frame.eye.is_none() && frame.blend.is_composited()
}

/// A frame of what 16-bit lanes know.
fn fast(frame: Frame) -> Frame {
    Frame {
        precision: PrecisionName::Fast,
        blend: match frame.blend {
            Blend::BackToFront => Blend::BackToFront,
            _ => Blend::FrontToBack,
        },
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
            for rows in [1 << 20, 3] {
                let made = frame.with_prepared(|prepared, slices| {
                    let prepared = prepared.clone().with_simd(simd);
                    let rendered = prepared.render_oriented(&Oriented::of(slices), Layer::Tiles(rows), &|_, _| ());
                    rendered.expect("a good frame").base
                });
                prop_assert_eq!(difference(&expected, &made), None, "{} in tiles of {} rows", simd.name(), rows);
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
