//! One answer, whichever way the slices go: by the scalar definitions, in tiles of any height, on any number of threads,
//! or streamed through the ring.
//!
//! Frames are random and small, with everything odd about them that a volume can have. Seeds are fixed. When two runs
//! differ, the test says where first: stage, plane, phase, row, column and both bit patterns.

use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed, TestRunner};
use slicecast::borders::Borders;
use slicecast::composite::{ChannelFormat, Pixel, Unorm16};
use slicecast::format::Step;
use slicecast::warp::{Warp, in_front_of};
use slicecast_engine::camera::Picture;
use slicecast_engine::depth::depths;
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::image::{BaseImage, background};
use slicecast_engine::oriented::Oriented;
use slicecast_engine::simd::Simd;
use slicecast_engine::threads::on_threads;
use slicecast_host_tests::frame::{Frame, table_of};
use slicecast_host_tests::random::{Filling, volume};
use slicecast_host_tests::record::recorded;
use slicecast_host_tests::reference::render;
use slicecast_rays as rays;
use slicecast_scene::{Blend, PrecisionName};
use std::cell::Cell;
use std::sync::Arc;

use super::frames::{
    borders_of, crop, cropped, frame, frame_in_perspective, light, splined, wide_frame, wide_frame_in_perspective,
};

/// One tile for the whole base plane.
const WHOLE: usize = 1 << 20;

fn config(cases: u32, seed: u64) -> Config {
    Config {
        cases,
        rng_seed: RngSeed::Fixed(seed),
        failure_persistence: None,
        ..Config::default()
    }
}

/// First pixel in which two images differ.
fn image_difference(expected: &BaseImage, found: &BaseImage) -> Option<String> {
    if (expected.size, expected.format, expected.one) != (found.size, found.format, found.one) {
        return Some(format!("sizes {:?} and {:?}", expected.size, found.size));
    }
    for (channel, (a, b)) in expected.planes.iter().zip(&found.planes).enumerate() {
        if let Some(at) = a.iter().zip(b).position(|(a, b)| a != b) {
            let (u, v) = (at % expected.size[0], at / expected.size[0]);
            let (a, b) = (a[at], b[at]);
            return Some(format!(
                "image channel {channel}, u {u}, v {v}: expected {a:08x}, found {b:08x}"
            ));
        }
    }
    None
}

/// Holds every layer against the definitions.
fn hold_together(frame: &Frame) -> Result<(), String> {
    let expected = render(frame);
    let (image, whole) = recorded(frame, Layer::Tiles(WHOLE));
    if let Some(divergence) = expected.first_divergence(&whole) {
        return Err(format!("plane layer against the definitions: {divergence}"));
    }
    if let Some(difference) = image_difference(&expected.image, &image) {
        return Err(format!("plane layer against the definitions: {difference}"));
    }
    let (streamed, stream) = recorded(frame, Layer::Stream);
    if let Some(divergence) = whole.first_difference(&stream) {
        return Err(format!("stream layer against plane layer: {divergence}"));
    }
    if let Some(difference) = image_difference(&image, &streamed) {
        return Err(format!("stream layer against plane layer: {difference}"));
    }
    for rows in [1, 2, 7, 32] {
        let (tiled, tiles) = recorded(frame, Layer::Tiles(rows));
        if let Some(divergence) = whole.first_difference(&tiles) {
            return Err(format!("tiles of {rows} rows against one tile: {divergence}"));
        }
        if let Some(difference) = image_difference(&image, &tiled) {
            return Err(format!("tiles of {rows} rows against one tile: {difference}"));
        }
    }
    for simd in Simd::available() {
        for (kernel, dense_from) in KERNELS {
            for rows in [WHOLE, 3] {
                let made = rendered(frame, simd, rows, dense_from);
                if let Some(difference) = image_difference(&image, &made) {
                    return Err(format!(
                        "{} in tiles of {rows} rows, {kernel}: {difference}",
                        simd.name()
                    ));
                }
            }
        }
    }
    Ok(())
}

/// Both kernels, by the share of visible blocks from which on rows are made as a whole.
const KERNELS: [(&str, f64); 2] = [("whole rows", 0.0), ("visible blocks", 2.0)];

/// The base plane by these vectors.
fn rendered(frame: &Frame, simd: Simd, rows: usize, dense_from: f64) -> BaseImage {
    frame.with_prepared(|prepared, slices| {
        let volume = Oriented::of(slices).dense_from(dense_from);
        let prepared = prepared.clone().with_simd(simd);
        prepared
            .render_oriented(&volume, Layer::Tiles(rows), &|_, _| ())
            .expect("a good frame")
            .base
    })
}

proptest! {
    #![proptest_config(config(2000, 2026))]

    #[test]
    fn every_layer_follows_the_definitions(frame in frame()) {
        for precision in PrecisionName::STAGED {
            if let Err(difference) = hold_together(&frame.in_precision(precision)) {
                prop_assert!(false, "{}: {difference}", precision.name());
            }
        }
    }
}

proptest! {
    #![proptest_config(config(1000, 21))]

    /// Rays from an eye.
    #[test]
    fn every_layer_follows_the_definitions_in_perspective(frame in frame_in_perspective()) {
        for precision in PrecisionName::STAGED {
            if let Err(difference) = hold_together(&frame.in_precision(precision)) {
                prop_assert!(false, "{}: {difference}", precision.name());
            }
        }
    }
}

proptest! {
    #![proptest_config(config(500, 17))]

    #[test]
    fn splines_follow_the_definitions(frame in prop_oneof![9 => frame().boxed(), 1 => wide_frame().boxed()]) {
        let frame = splined(frame);
        for precision in PrecisionName::STAGED {
            if let Err(difference) = hold_together(&frame.in_precision(precision)) {
                prop_assert!(false, "{}: {difference}", precision.name());
            }
        }
    }
}

proptest! {
    #![proptest_config(config(1000, 16))]

    /// By every vector width, and in blocks or rows.
    #[test]
    fn depths_are_the_definition(frame in frame()) {
        for precision in PrecisionName::STAGED {
            frame.in_precision(precision).with_prepared(|prepared, slices| {
                let expected = rays::depths(prepared).expect("a material that core takes");
                for simd in Simd::available() {
                    for (kernel, dense_from) in KERNELS {
                        let volume = Oriented::of(slices).dense_from(dense_from);
                        let prepared = prepared.clone().with_simd(simd);
                        let found = depths(&prepared, &volume, &|_, _| ()).expect("a small frame");
                        prop_assert_eq!(found.map(|image| image.depths), expected.clone(), "{}, {}", simd.name(), kernel);
                    }
                }
                Ok(())
            })?;
        }
    }
}

/// Holds both kernels of every width of vectors against whole rows by one lane.
fn by_rows_and_blocks(frame: &Frame) -> Result<(), TestCaseError> {
    for precision in PrecisionName::STAGED {
        let frame = frame.in_precision(precision);
        let expected = rendered(&frame, Simd::Scalar, WHOLE, 0.0);
        for simd in Simd::available() {
            for (kernel, dense_from) in KERNELS {
                let difference = image_difference(&expected, &rendered(&frame, simd, 5, dense_from));
                prop_assert_eq!(difference, None, "{}, {}, {}", precision.name(), simd.name(), kernel);
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(config(100, 40))]

    /// Nor in boxes of them.
    #[test]
    fn blocks_of_boxes_that_are_not_seen_change_nothing(frame in wide_frame(), crop in crop()) {
        let borders = match frame.borders {
            Borders::Whole => Borders::Cells,
            exact => exact,
        };
        by_rows_and_blocks(&cropped(Frame { borders, crop: Some(crop), ..frame }))?;
    }
}

/// What is left out changes nothing: many views, tables and lights. A quarter of the frames and more leave something out.
#[test]
fn blocks_that_are_not_seen_change_nothing() {
    by_rows_and_blocks_of(&wide_frame(), 400);
}

/// Nor from an eye.
#[test]
fn blocks_that_are_not_seen_change_nothing_in_perspective() {
    by_rows_and_blocks_of(&wide_frame_in_perspective(), 400);
}

/// Holds both kernels together over so many frames, of which a quarter and more leave something out.
fn by_rows_and_blocks_of(all: &impl Strategy<Value = Frame>, cases: u32) {
    let [frames, skipping, chosen] = [(); 3].map(|()| Cell::new(0));
    let count = |counter: &Cell<usize>, counted: bool| counter.set(counter.get() + usize::from(counted));
    let tried = TestRunner::new(config(cases, 16)).run(all, |frame| {
        let (share, few) = frame.with_prepared(|prepared, slices| chosen_blocks(prepared, &Oriented::of(slices)));
        count(&frames, true);
        count(&chosen, few);
        count(&skipping, share.is_some_and(|share| share > 0.0 && share < 1.0));
        by_rows_and_blocks(&frame)
    });
    tried.unwrap_or_else(|difference| panic!("{difference}"));
    let [frames, skipping, chosen] = [frames, skipping, chosen].map(|counter| counter.get());
    assert!(
        skipping * 4 > frames && chosen * 4 > frames,
        "of {frames} frames {skipping} have blocks of both kinds, {chosen} few that are seen"
    );
}

/// The share of blocks that a frame's pipeline can show, and whether vectors make those alone.
fn chosen_blocks(prepared: &Prepared<'_>, volume: &Oriented<'_>) -> (Option<f64>, bool) {
    let rendering = prepared.rendering().expect("a good frame");
    let (looks, support, back_to_front) = (rendering.looks(), rendering.support(), rendering.back_to_front());
    let share = support.map(|support| volume.occupancy().share(looks, support));
    let chosen = |simd| volume.sight(looks, support, back_to_front, simd).is_some();
    // One lane takes them more rarely.
    assert!(chosen(Simd::widest()) || !chosen(Simd::Scalar));
    (share, chosen(Simd::widest()))
}

proptest! {
    #![proptest_config(config(60, 11))]

    #[test]
    fn any_number_of_threads_makes_the_same_frame(frame in frame()) {
        let all = [1, 2, 3, 7].map(|threads| {
            frame.with_prepared(|prepared, _| {
                on_threads(Some(threads), || prepared.render(Layer::Tiles(3), &|_, _| ())).unwrap().unwrap()
            })
        });
        let streamed = frame.with_prepared(|prepared, _| prepared.render(Layer::Stream, &|_, _| ()).unwrap());
        for (threads, made) in [1, 2, 3, 7].iter().zip(&all) {
            prop_assert_eq!(image_difference(&streamed.base, &made.base), None, "{} threads", threads);
            prop_assert!(streamed.picture == made.picture, "the picture of {} threads", threads);
        }
    }
}

/// The picture of a base plane by the definition of the warp.
fn warped<C: ChannelFormat>(prepared: &Prepared<'_>, base: &BaseImage) -> Vec<u8> {
    let Picture { size, warp, .. } = prepared.setup.picture;
    let [width, height] = base.size;
    let pixel = |u: i64, v: i64| -> Pixel<C> {
        let find = |side: usize, place: i64| usize::try_from(place).ok().filter(|place| *place < side);
        let Some((u, v)) = find(width, u).zip(find(height, v)) else {
            return Pixel::clear();
        };
        let [red, green, blue, transparency] =
            [0, 1, 2, 3].map(|plane| C::from_bits(base.planes[plane][v * width + u]));
        Pixel {
            colour: [red, green, blue],
            transparency,
        }
    };
    let background = background(prepared.scene.image.background);
    let places = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    places
        .flat_map(|(x, y)| in_front_of(warp.pixel(x, y, pixel), background))
        .collect()
}

/// The same, in the channel of the image.
fn by_definition(prepared: &Prepared<'_>, base: &BaseImage) -> Vec<u8> {
    match base.one {
        0x8000 => warped::<u16>(prepared, base),
        0xffff => warped::<Unorm16>(prepared, base),
        _ => warped::<u32>(prepared, base),
    }
}

proptest! {
    #![proptest_config(config(200, 7))]

    #[test]
    fn pictures_are_the_definition_of_the_warp(frame in frame()) {
        for precision in PrecisionName::STAGED {
            frame.in_precision(precision).with_prepared(|prepared, _| {
                let made = prepared.render(Layer::Tiles(5), &|_, _| ()).unwrap();
                prop_assert!(made.picture.bytes == by_definition(prepared, &made.base), "{}", precision.name());
                Ok(())
            })?;
        }
    }
}

/// Bits of a warp's steps: of all lengths, so that the base plane is enlarged, kept or shrunk to nothing, straight or not.
fn step() -> impl Strategy<Value = i64> {
    prop_oneof![
        2 => Just(0i64),
        6 => (24u32..=32, -300i64..=300).prop_map(|(log2, part)| (part << log2) / 200),
        2 => (0u32..=62, -300i64..=300).prop_map(|(log2, part)| ((i128::from(part) << log2) / 200) as i64),
        1 => any::<i64>(),
    ]
}

/// Bits of a warp's origin: near the base plane, or anywhere, also where the coordinate wraps.
fn origin() -> impl Strategy<Value = i64> {
    prop_oneof![
        8 => (-20i64..=60, any::<u32>()).prop_map(|(pixel, part)| (pixel << 32) + i64::from(part)),
        1 => any::<i64>(),
        1 => (-3i64..=3).prop_map(|near| i64::MAX.wrapping_add(near << 31)),
    ]
}

fn warps() -> impl Strategy<Value = Picture> {
    let pair = || prop::array::uniform2(step());
    // Tiles are 64 x 32 pixels at most.
    let size = prop_oneof![
        1 => [1u32..=3, 1u32..=3],
        2 => [1u32..=140, 1u32..=70],
        1 => [63u32..=65, 31u32..=33],
    ];
    (size, prop::array::uniform2(origin()), pair(), pair()).prop_map(|(size, origin, right, down)| Picture {
        size,
        warp: Warp {
            origin: origin.map(Step::from_bits),
            right: right.map(Step::from_bits),
            down: down.map(Step::from_bits),
        },
        affine: [[0.0; 2]; 3],
    })
}

proptest! {
    #![proptest_config(config(400, 13))]

    #[test]
    fn any_picture_is_the_definition_of_the_warp(
        frame in frame(),
        rays_per_voxel in 1u32..=8,
        picture in warps(),
        background in prop_oneof![Just([0.0; 3]), Just([1.0; 3]), prop::array::uniform3(0.0..=1.0f64)],
    ) {
        for precision in PrecisionName::STAGED {
            let frame = Frame { rays_per_voxel, ..frame.in_precision(precision) };
            frame.with_prepared(|prepared, _| {
                let mut scene = prepared.scene.clone();
                scene.image.background = background;
                let mut prepared = Prepared { scene: &scene, ..prepared.clone() };
                prepared.setup.picture = picture;
                for simd in Simd::available() {
                    let made = prepared.clone().with_simd(simd).render(Layer::Tiles(5), &|_, _| ()).unwrap();
                    prop_assert!(made.picture.bytes == by_definition(&prepared, &made.base), "{} {}", precision.name(), simd.name());
                }
                Ok(())
            })?;
        }
    }
}

/// Shapes, views and blends that random frames might meet too rarely, all combinations.
#[test]
fn thin_volumes_from_every_side() {
    let table = table_of(&[
        (0, [10, 200, 30], 0),
        (600, [250, 10, 90], 40000),
        (4095, [255, 255, 255], 9000),
    ]);
    let mut frames = 0;
    for (index, dims) in [
        [1, 1, 1],
        [1, 5, 4],
        [4, 1, 5],
        [5, 4, 1],
        [1, 1, 6],
        [6, 1, 1],
        [2, 2, 2],
        [3, 1, 2],
    ]
    .into_iter()
    .enumerate()
    {
        let volume = Arc::new(volume(dims, Filling::Extremes, index as u64));
        for direction in [
            [0, 0, 1],
            [0, 0, -1],
            [0, 1, 0],
            [0, -1, 0],
            [1, 0, 0],
            [-1, 0, 0],
            [1, 1, 1],
            [-1, 1, -1],
            [1, -1, 0],
            [0, 1, -1],
            [3, -2, 1],
        ] {
            let blends = [
                Blend::FrontToBack,
                Blend::BackToFront,
                Blend::Maximum,
                Blend::Minimum,
                Blend::Average,
                Blend::Additive,
            ];
            let all =
                blends.map(|blend| [Borders::Whole, Borders::Cells, Borders::Nodes].map(|borders| (blend, borders)));
            for (blend, borders) in all.into_iter().flatten() {
                if borders_of(borders, dims) != borders {
                    continue;
                }
                let frame = Frame {
                    direction,
                    blend,
                    borders,
                    planes_per_voxel: 2,
                    material: Some(light(3, 1)),
                    precision: PrecisionName::STAGED[frames % 3],
                    ..Frame::new(volume.clone(), table.clone())
                };
                if let Err(difference) = hold_together(&frame) {
                    panic!(
                        "{dims:?} {direction:?} {blend:?} {borders:?} {:?}: {difference}",
                        frame.precision
                    );
                }
                frames += 1;
            }
        }
    }
    // Nodes of the only volume that is not thin.
    assert_eq!(frames, (8 * 2 + 1) * 11 * 6);
}

/// A volume so long that a step's last bits matter, 16 planes per voxel, from both ends.
#[test]
fn long_volumes_keep_their_positions() {
    let table = table_of(&[(0, [90, 20, 200], 300), (4095, [255, 255, 255], 3000)]);
    let long = Arc::new(volume([3, 2, 120], Filling::Noise, 4));
    for (direction, precision) in [
        ([7, 0, 30], PrecisionName::Wide),
        ([-5, 1, -1_000], PrecisionName::Compact),
    ] {
        let frame = Frame {
            direction,
            planes_per_voxel: 16,
            material: Some(light(5, 2)),
            precision,
            ..Frame::new(long.clone(), table.clone())
        };
        if let Err(difference) = hold_together(&frame) {
            panic!("{direction:?} {precision:?}: {difference}");
        }
    }
}

/// The first divergence is found and named: a recording with one value changed.
#[test]
fn a_changed_value_is_reported_with_its_place_and_bits() {
    let table = table_of(&[(0, [255; 3], 20000)]);
    let frame = Frame {
        material: Some(light(2, 0)),
        ..Frame::new(Arc::new(volume([4, 3, 3], Filling::Noise, 5)), table)
    };
    let expected = render(&frame);
    let (_, mut run) = recorded(&frame, Layer::Tiles(WHOLE));
    assert_eq!(expected.first_divergence(&run), None);
    let place = *run.values.keys().rev().nth(40).unwrap();
    run.values.get_mut(&place).unwrap()[0] ^= 1;
    let divergence = expected.first_divergence(&run).unwrap();
    assert_eq!(divergence.place, place);
    let text = divergence.to_string();
    for part in [
        place.stage.name(),
        &format!("row {}", place.row),
        "expected [",
        "found [",
    ] {
        assert!(text.contains(part), "{text}");
    }
    // And a visible value left out.
    run.values.remove(&place);
    assert_eq!(expected.first_divergence(&run).unwrap().found, None);
}
