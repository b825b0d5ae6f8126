//! Volumes of colour and extinction: one answer whichever way the slices go, exact answers, and errors against f64.

use super::frames::{clips_of, crop, cue_of, material};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed};
use slicecast::borders::Borders;
use slicecast::plan::PlanError;
use slicecast_colours::{Coloured, medium};
use slicecast_compare::ModelPositions;
use slicecast_compare::colours::compare_colours;
use slicecast_compare::image::ImageFigures;
use slicecast_engine::frame::Layer;
use slicecast_engine::image::Frame;
use slicecast_engine::simd::Simd;
use slicecast_engine::threads::on_threads;
use slicecast_host_tests::colours::{ColourFrame, colour_volume};
use slicecast_host_tests::random::Filling;
use slicecast_pyramid::filter::Filter;
use slicecast_pyramid::pyramid::{By, next};
use slicecast_pyramid::volume::{RgbaVolume, Voxels};
use slicecast_scene::{PrecisionName, Sampling, Scene, file};
use slicecast_volume::decoded::Orientation;

/// The precisions that have such pixels.
const PRECISIONS: [PrecisionName; 2] = [PrecisionName::Compact, PrecisionName::Wide];

fn rendered(frame: &ColourFrame, simd: Simd, layer: Layer, threads: usize) -> Frame {
    frame.with_prepared(|prepared| {
        let prepared = prepared.clone().with_simd(simd);
        on_threads(Some(threads), || prepared.render(layer, &|_, _| ()))
            .unwrap()
            .unwrap()
    })
}

fn filling() -> impl Strategy<Value = Filling> {
    prop_oneof![
        1 => (0u16..=4095).prop_map(Filling::Constant),
        3 => Just(Filling::Noise),
        2 => Just(Filling::Extremes),
        3 => Just(Filling::Sparse),
        2 => Just(Filling::Boxes),
        1 => Just(Filling::Ball),
    ]
}

prop_compose! {
    fn frame()(
        dims in [1usize..=40, 1usize..=9, 1usize..=9], turn in 0usize..3, filling in filling(), seed in any::<u64>(),
        colours in prop::option::of(any::<u64>()), direction in prop_oneof![
            prop::array::uniform3(-3i64..=3), prop::array::uniform3(-(1i64 << 30)..=1 << 30),
        ].prop_filter("a direction", |d| *d != [0; 3]),
        rates in (1u32..=3, 1u32..=2), wide in any::<bool>(),
        borders in prop_oneof![Just(Borders::Whole), Just(Borders::Cells), Just(Borders::Nodes)],
        crop in prop::option::weighted(0.4, crop()),
        medium in prop_oneof![(1u32 << 30..1 << 31, 15u32..=30).prop_map(|(m, n)| [m, n]), Just([2_013_327_358, 14])],
        early_termination in prop::option::of(1u32..=12), material in material(),
    ) -> ColourFrame {
        let mut dims = dims;
        dims.rotate_right(turn);
        let frame = ColourFrame {
            direction,
            planes_per_voxel: rates.0,
            rays_per_voxel: rates.1,
            precision: if wide { PrecisionName::Wide } else { PrecisionName::Compact },
            borders,
            crop,
            clips: if seed % 3 == 0 { clips_of(seed.rotate_left(9), dims) } else { Vec::new() },
            cue: (seed % 4 == 1).then(|| cue_of(seed.rotate_left(17))),
            medium,
            quadratic: seed % 5 < 2,
            early_termination,
            material,
            ..ColourFrame::new(colour_volume(dims, filling, seed, colours))
        };
        match frame.plan() {
            Err(PlanError::Beside { .. } | PlanError::WholeCropped) => ColourFrame { crop: None, ..frame },
            _ => frame,
        }
    }
}

proptest! {
    #![proptest_config(Config { cases: 300, rng_seed: RngSeed::Fixed(1717), failure_persistence: None, ..Config::default() })]

    /// The scalar definitions in one tile (held to the formulas by core/tests/rgba.rs) against every width of vectors, tiles of
    /// any height, threads and the stream.
    #[test]
    fn every_way_has_the_same_bits(frame in frame()) {
        if frame.plan().is_err() {
            return Ok(());
        }
        let expected = rendered(&frame, Simd::Scalar, Layer::Tiles(1 << 20), 1);
        prop_assert!(rendered(&frame, Simd::Scalar, Layer::Stream, 1) == expected, "stream");
        for simd in Simd::available() {
            for (rows, threads) in [(1, 1), (3, 2), (32, 2)] {
                let found = rendered(&frame, simd, Layer::Tiles(rows), threads);
                prop_assert!(found == expected, "{}, tiles of {} rows", simd.name(), rows);
            }
        }
    }
}

/// A volume of codes.
fn of_codes(dims: [usize; 3], tau_max: f64, code: impl Fn([usize; 3]) -> [u16; 4]) -> RgbaVolume {
    let [x, y, z] = dims;
    let places = (0..z).flat_map(|k| (0..y).flat_map(move |j| (0..x).map(move |i| [i, j, k])));
    RgbaVolume {
        name: "made".into(),
        dims,
        spacing: [1.0; 3],
        orientation: Orientation::Unknown,
        tau_max,
        alpha_distance: None,
        voxels: Voxels::Codes(places.map(code).collect()),
    }
}

/// What a frame's rays block along z: the opacity of a pixel of the base plane.
fn blocked(
    volume: &RgbaVolume,
    planes_per_voxel: u32,
    borders: Borders,
    pixel: [usize; 2],
    precision: PrecisionName,
) -> f64 {
    let scale = medium(volume.tau_max, 1.0 / f64::from(planes_per_voxel)).unwrap();
    let frame = ColourFrame {
        planes_per_voxel,
        borders,
        precision,
        ..ColourFrame::new(volume.clone())
    };
    frame.with_prepared(|prepared| {
        let prepared = Coloured {
            medium: scale,
            ..prepared.clone()
        };
        let base = prepared.render(Layer::Tiles(32), &|_, _| ()).unwrap().base;
        1.0 - f64::from(base.planes[3][pixel[1] * base.size[0] + pixel[0]]) / f64::from(base.one)
    })
}

/// Kraus and Bürger, figures 1 and 4 (a step of 1/m is exact at every phase), 2 and 3 (0.9817 at level 0 and at level 1, where
/// opacities have 0.7408).
#[test]
fn the_papers_voxels() {
    for (precision, within) in [(PrecisionName::Wide, 1.1e-5), (PrecisionName::Compact, 4e-5)] {
        for tau in [1.0, 2.0, 4.0, 8.0] {
            let sheet = of_codes(
                [3, 3, 5],
                tau,
                |[_, _, k]| if k == 2 { [0, 0, 0, 32767] } else { [0; 4] },
            );
            for planes in [1, 2, 3, 8] {
                let found = blocked(&sheet, planes, Borders::Whole, [1, 1], precision);
                assert!(
                    (found + (-tau).exp_m1()).abs() < within,
                    "tau {tau}, {planes} planes: {found}"
                );
            }
        }
        let half = of_codes(
            [2, 2, 2],
            4.0,
            |[_, _, k]| if k == 0 { [0, 0, 0, 32767] } else { [0; 4] },
        );
        let coarse = next(&half, Filter::Two, By::Extinction).unwrap();
        let coarse = RgbaVolume {
            spacing: [1.0; 3],
            tau_max: 8.0,
            ..coarse
        };
        for volume in [&half, &coarse] {
            let found = blocked(volume, 4, Borders::Cells, [0, 0], precision);
            assert!((found - 0.981_684_361).abs() < 2.0 * within, "{found}");
        }
    }
}

/// A homogeneous cube of 8 voxels and an opacity of 0.1 a voxel: 1 - 0.9^8 as cells, 1 - 0.9^7 as nodes, 145.23 and 133.03 of 255,
/// whatever the planes.
#[test]
fn a_cube_is_as_thick_as_it_is() {
    let cube = of_codes([8; 3], -(0.9f64.ln()), |_| [32767; 4]);
    for planes in [1, 2, 4, 16] {
        for (borders, voxels) in [(Borders::Cells, 8), (Borders::Nodes, 7)] {
            let found = blocked(&cube, planes, borders, [3, 3], PrecisionName::Wide);
            let left = 0.9f64.powi(voxels);
            // The error of phi, over the whole depth.
            let within = 7.1e-6 * -left.ln() * left + 1e-8;
            assert!((found + left - 1.0).abs() < within, "{borders:?} {planes}: {found}");
        }
    }
}

/// The figures of a scene against f64 on the same voxels.
fn figures(volume: &RgbaVolume, precision: PrecisionName, scene: &str) -> ImageFigures {
    let scene = Scene {
        precision,
        ..file::parse(scene, "colours").unwrap()
    };
    let prepared = Coloured::new(&scene, volume).unwrap();
    let comparison = compare_colours(&prepared, ModelPositions::Pipeline, &|_, _| ()).unwrap();
    // For the page that states them; shown with `--nocapture`.
    let Sampling {
        planes_per_voxel: planes,
        ..
    } = scene.sampling;
    let (lit, spline) = (scene.lighting.is_some(), scene.interpolation);
    println!(
        "{}: tau_max {}, {planes} planes, {:?}, lit {lit}, {spline:?}: {:?}",
        precision.name(),
        volume.tau_max,
        scene.borders,
        comparison.image
    );
    comparison.image
}

/// A soft ball of four waves of colour.
fn soft_ball(tau_max: f64) -> RgbaVolume {
    let soft = colour_volume([40, 36, 44], Filling::Ball, 3, None);
    let wave = |at: usize, period: usize| 128 + (at * 997 / period % 254).abs_diff(127) as u16;
    of_codes(soft.dims, tau_max, |[i, j, k]| {
        let tau = u32::from(soft.voxels.codes(i + 40 * (j + 36 * k))[3]);
        let colour = |byte: u16| (tau * u32::from(byte.min(255)) / 255) as u16;
        [
            colour(wave(i, 90)),
            colour(wave(j, 70)),
            colour(wave(k + i, 120)),
            tau as u16,
        ]
    })
}

/// Lights and depth cueing of a scene of colours.
const LIT: &str = "[lighting]\nambient = 0.2\ndiffuse = 0.6\nspecular = 0.3\nexponent = 16\n";
const LIT_BLINN: &str = "[lighting]\nhighlight = \"half-vector\"\nexponent = 64\n[[lighting.lights]]\ndirection = [0.3, 0.5, 1.0]\n\
    colour = \"#ffd0a0\"\n[[lighting.lights]]\ndirection = [-1.0, 0.2, 0.4]\n[cueing]\nstrength = 0.6\n";

/// Frames of the soft ball against f64: the same bars, of equal bytes over all frames together. A frame has some 3700 values, of which a
/// thousandth is 3.7, and what differs lies at the edge of a rounding: single frames have up to five of them.
fn soft_frames_are_near(frames: &[(f64, u32, &str, &str)], sampling: &str) {
    for (precision, equal, largest) in [(PrecisionName::Compact, 98.0, 0.12), (PrecisionName::Wide, 99.9, 0.012)] {
        let mut all = Vec::new();
        for (tau_max, planes, borders, light) in frames {
            let scene = format!(
                "[view]\nazimuth = 33.0\nelevation = 17.0\n[sampling]\nplanes_per_voxel = {planes}\nborders = \"{borders}\"\n\
                 {sampling}{light}[colours]\n"
            );
            let found = figures(&soft_ball(*tau_max), precision, &scene);
            assert!(
                found.max_lsb8 <= largest,
                "tau_max {tau_max}, {planes} planes, {borders}, {}: {found:?}",
                precision.name()
            );
            all.push(found);
        }
        let all = ImageFigures::together(&all);
        assert!(
            all.values > 10_000 && all.equal_percent >= equal,
            "{}: {all:?}",
            precision.name()
        );
    }
}

/// Under light, and under coloured lights and depth cueing.
#[test]
fn soft_volumes_are_as_near_under_light() {
    let ways = [
        (1, "whole", LIT),
        (2, "cells", LIT),
        (1, "cells", LIT_BLINN),
        (3, "nodes", LIT_BLINN),
    ];
    let frames: Vec<_> = [0.25, 1.0, 4.0, 8.0]
        .into_iter()
        .flat_map(|tau_max| ways.map(|(planes, borders, light)| (tau_max, planes, borders, light)))
        .collect();
    soft_frames_are_near(&frames, "");
}

/// By splines, unlit and lit.
#[test]
fn soft_volumes_are_as_near_by_splines() {
    let frames = [
        (0.25, 1, "whole", ""),
        (4.0, 2, "cells", LIT),
        (8.0, 1, "nodes", LIT_BLINN),
    ];
    soft_frames_are_near(&frames, "interpolation = \"quadratic\"\n");
}

/// Soft volumes of four colours under oblique views: the bars, at every step and scale of extinction. What `Wide` keeps below 0.0004
/// steps would be 0.0008 with values of phi that lie above it.
#[test]
fn soft_volumes_are_as_near_as_stated() {
    for tau_max in [0.25, 1.0, 4.0, 8.0] {
        let soft = soft_ball(tau_max);
        for planes in [1, 2, 4] {
            for borders in ["whole", "cells"] {
                let scene = format!(
                    "[view]\nazimuth = 33.0\nelevation = 17.0\n[sampling]\nplanes_per_voxel = {planes}\nborders = \"{borders}\"\n[colours]\n"
                );
                for (precision, equal, largest) in [
                    (PrecisionName::Compact, 98.0, 0.12),
                    (PrecisionName::Wide, 99.9, 0.0004),
                ] {
                    let found = figures(&soft, precision, &scene);
                    assert!(found.values > 3000);
                    assert!(
                        found.equal_percent >= equal && found.max_lsb8 <= largest,
                        "tau_max {tau_max}, {planes} planes, {borders}, {}: {found:?}",
                        precision.name()
                    );
                }
            }
        }
    }
}

/// Everything odd: every view, sharp voxels, exact borders.
#[test]
fn noise_is_near_the_model() {
    for (azimuth, elevation) in [
        (0.0, 0.0),
        (90.0, 0.0),
        (0.0, 90.0),
        (45.0, 0.0),
        (200.0, -35.0),
        (-80.0, 60.0),
    ] {
        let noise = colour_volume([13, 11, 12], Filling::Sparse, 9, Some(4));
        for borders in ["whole", "cells", "nodes"] {
            let scene = format!(
                "[view]\nazimuth = {azimuth:?}\nelevation = {elevation:?}\n[sampling]\nplanes_per_voxel = 2\nrays_per_voxel = 2\n\
                 borders = \"{borders}\"\n[colours]\n"
            );
            for (precision, largest) in PRECISIONS.into_iter().zip([0.15, 0.02]) {
                let found = figures(&noise, precision, &scene);
                assert!(
                    found.max_lsb8 <= largest,
                    "{azimuth} {elevation} {borders} {}: {found:?}",
                    precision.name()
                );
            }
        }
    }
}

/// What a scene of colours may not ask for, in words.
#[test]
fn what_there_is_not_is_refused() {
    let volume = colour_volume([4, 4, 4], Filling::Noise, 1, None);
    let refused = |text: &str, volume: &RgbaVolume| {
        let scene = file::parse(text, "colours").unwrap();
        Coloured::new(&scene, volume).err().map(|error| error.to_string())
    };
    for (text, word) in [
        (
            "[colours]\n[render]\nprecision = \"paper\"",
            "--precision compact or wide",
        ),
        ("[colours]\n[render]\nblend = \"back-to-front\"", "from front to back"),
        ("[colours]\n[render]\nblend = \"maximum\"", "from front to back"),
    ] {
        let found = refused(text, &volume).unwrap();
        assert!(found.contains(word), "{text}: {found}");
    }
    assert_eq!(refused("[colours]", &volume), None);
    let dense = RgbaVolume {
        tau_max: 16.0,
        ..volume
    };
    let found = refused("[colours]", &dense).unwrap();
    assert!(found.contains("optical depth 16, expected at most 15"), "{found}");
    assert_eq!(refused("[colours]\n[sampling]\nplanes_per_voxel = 2", &dense), None);
}
