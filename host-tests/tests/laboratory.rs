//! The configurations of the precision laboratory, bit for bit: checksums of a lit and of an unlit frame of each, as
//! `golden/laboratory.txt` has them.
//!
//! ```text
//! SLICECAST_BLESS=1 cargo test -p slicecast-host-tests laboratory::
//! ```
//!
//! writes the file anew and fails, as for the golden manifest (`golden.rs`).

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::sync::Arc;

use slicecast::format::{Coefficient, Vector};
use slicecast::shade::{Highlight, Light};
use slicecast_compare::{ModelPositions, model};
use slicecast_engine::camera::Material;
use slicecast_engine::frame::Prepared;
use slicecast_host_tests::frame::{Frame, table_of};
use slicecast_host_tests::random::{Filling, volume};
use slicecast_laboratory::catalogue;
use slicecast_laboratory::measure::Bench;
use slicecast_scene::{Point, Scene, TransferFunction};

const HEAD: &str = "\
# Checksums of the base-plane image of tests/laboratory.rs, FNV-1a over the channels as they are stored: a configuration,
# its lit frame, its unlit frame.
# Written by SLICECAST_BLESS=1 cargo test -p slicecast-host-tests laboratory::; never by hand.
";

fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("golden/laboratory.txt")
}

/// A light with a reflection, so that every stage takes part.
fn material() -> Material {
    let vector = |v: [i32; 3]| v.map(|c| Vector::from_bits((c << 15) - 4_321 * c.signum()));
    let coefficient = |units: u32| Coefficient::from_bits((units << 16) + 9_876);
    Material {
        ambient: [coefficient(5_000); 3],
        lights: vec![Light {
            direction: vector([-16_384, -16_384, -23_170]),
            half: vector([-8_867, -8_867, -30_273]),
            diffuse: [20_000, 18_000, 15_000].map(coefficient),
            specular: [coefficient(6_000); 3],
        }],
        viewer: vector([0, 0, -32_768]),
        highlight: Highlight::Reflection,
        exponent_log2: 4,
    }
}

/// A frame through every code of the table, at an angle, two planes per voxel.
fn frame(material: Option<Material>) -> Frame {
    Frame {
        direction: [300, -200, 1000],
        planes_per_voxel: 2,
        material,
        ..Frame::new(
            Arc::new(volume([23, 19, 17], Filling::Ripples, 5)),
            table_of(&[(0, [0; 3], 0)]),
        )
    }
}

fn checksums(frame: &Frame) -> BTreeMap<String, u64> {
    let point = |value, colour, opacity| Point { value, colour, opacity };
    let scene = Scene {
        transfer: TransferFunction {
            unit_distance: 1.0,
            points: vec![
                point(700.0, [1.0, 0.125, 0.25], 0.0),
                point(1500.0, [0.25, 1.0, 0.5], 0.03),
                point(2600.0, [0.9375, 0.875, 0.625], 0.2),
                point(4095.0, [0.1875, 0.125, 1.0], 0.9),
            ],
        },
        ..frame.scene()
    };
    frame.with_prepared(|prepared, slices| {
        let prepared = Prepared {
            scene: &scene,
            ..prepared.clone()
        };
        let model = model(&prepared, ModelPositions::Pipeline);
        let mut sums = BTreeMap::new();
        for configuration in catalogue::all() {
            let plan = prepared.setup.plan.with_step_bits(configuration.step_bits);
            let mut stepped = prepared.clone();
            stepped.setup.plan = plan;
            let bench = Bench {
                prepared: &stepped,
                model: &model,
                slices,
            };
            let compared = configuration.runner.compare(bench).unwrap();
            let timed = configuration.runner.time(bench).unwrap();
            assert_eq!(compared.bits, timed.bits, "{}: vectors", configuration.name);
            sums.insert(configuration.name, compared.bits);
        }
        sums
    })
}

#[test]
fn every_configuration_has_its_bits() {
    let lit = checksums(&frame(Some(material())));
    let unlit = checksums(&frame(None));
    let mut text = HEAD.to_owned();
    for (name, sum) in &lit {
        writeln!(text, "{name}: {sum:016x} {:016x}", unlit[name]).unwrap();
    }
    if std::env::var_os("SLICECAST_BLESS").is_some_and(|value| value == "1") {
        assert!(
            std::env::var_os("CI").is_none(),
            "a manifest is not written in continuous integration"
        );
        std::fs::write(path(), text).unwrap();
        panic!("wrote {} lines to {}", lit.len(), path().display());
    }
    let listed = std::fs::read_to_string(path()).unwrap();
    let differs = text.lines().zip(listed.lines()).find(|(found, listed)| found != listed);
    assert_eq!(differs, None, "{}", path().display());
    assert_eq!(text.len(), listed.len(), "{}", path().display());
}
