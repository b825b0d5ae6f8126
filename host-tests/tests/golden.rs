//! The golden manifest: named frames in three precisions, and in `fast` where it knows them, a checksum for every stage boundary, the base-plane image and
//! the picture, as `golden/manifest.txt` has them.
//!
//! Frames are stated in integers (no sine, no logarithm), so the numbers are the same on every machine, in debug and in
//! release. A line that no frame uses and a checksum that has no line are both errors.
//!
//! When a change is meant to change bits, write the manifest anew, look at the difference and say in the change log which
//! bits changed and why:
//!
//! ```text
//! SLICECAST_BLESS=1 cargo test -p slicecast-host-tests golden::
//! ```
//!
//! That run still fails, so that it cannot pass for a check; a continuous-integration run (`CI` set) refuses it.

mod frames;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;

use slicecast::format::{Intensity, Step};
use slicecast::splat::Splatting;
use slicecast_engine::frame::Layer;
use slicecast_host_tests::checksum::{fnv, of_frame, of_image};
use slicecast_host_tests::colours::ColourFrame;
use slicecast_scene::PrecisionName;
use slicecast_splat::Splatted;

use self::frames::{colour_frames, frames, splats, splats_from_eye};
use super::fast::is_fast;

const HEAD: &str = "\
# Checksums of the frames in tests/golden.rs: frame/precision/boundary: 64 bits, hexadecimal.
# Stages: order-free sums over the visible samples (src/checksum.rs); image and picture: FNV-1a.
# Written by SLICECAST_BLESS=1 cargo test -p slicecast-host-tests golden::; never by hand.
";

fn manifest_path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("golden/manifest.txt")
}

/// The image and the picture of every frame of colour and extinction.
fn measured_colours(lines: &mut BTreeMap<String, u64>) {
    for (name, frame) in colour_frames() {
        for precision in [PrecisionName::Compact, PrecisionName::Wide] {
            let frame = ColourFrame {
                precision,
                ..frame.clone()
            };
            let made = frame.with_prepared(|prepared| prepared.render(Layer::Tiles(16), &|_, _| ()).unwrap());
            let picture = fnv(made.picture.bytes.iter().copied());
            for (boundary, checksum) in [("image", of_image(&made.base)), ("picture", picture)] {
                let line = format!("{name}/{}/{boundary}", precision.name());
                assert_eq!(lines.insert(line.clone(), checksum), None, "two frames called {line}");
            }
        }
    }
}

/// The image and the picture of every frame that is splatted, its volume's middle in the image's.
fn measured_splats(lines: &mut BTreeMap<String, u64>) {
    for (name, splat) in splats() {
        for precision in PrecisionName::STAGED {
            let frame = splat.frame.in_precision(precision);
            let made = frame.with_prepared(|prepared, _| {
                let dims = prepared.volume.dims.map(|side| side as u32);
                let origin = [0, 1].map(|axis| {
                    let along = splat
                        .steps
                        .iter()
                        .zip(dims)
                        .map(|(step, side)| step[axis] * i64::from(side - 1));
                    Step::from_bits((i64::from(splat.size[axis] - 1) * (1 << 32) - along.sum::<i64>()) / 2)
                });
                let steps = splat.steps.map(|step| step.map(Step::from_bits));
                let splatting = Splatting::new(dims, origin, steps, splat.size, splat.layout).expect("within limits");
                let spacing = splat.spacing.map(Intensity::from_bits);
                Splatted::of(prepared, splatting, spacing)
                    .render(&|_, _| ())
                    .expect("a small frame")
            });
            let picture = fnv(made.picture.bytes.iter().copied());
            for (boundary, checksum) in [("image", of_image(&made.base)), ("picture", picture)] {
                let line = format!("{name}/{}/{boundary}", precision.name());
                assert_eq!(lines.insert(line.clone(), checksum), None, "two frames called {line}");
            }
        }
    }
}

/// The same of frames that are splatted from an eye.
fn measured_splats_from_eye(lines: &mut BTreeMap<String, u64>) {
    for (name, splat) in splats_from_eye() {
        for precision in PrecisionName::STAGED {
            let frame = splat.frame.in_precision(precision);
            let made = frame.with_prepared(|prepared, _| {
                let dims = prepared.volume.dims.map(|side| side as u32);
                let [first, steps @ ..] =
                    [splat.first, splat.steps[0], splat.steps[1], splat.steps[2]].map(|step| step.map(Step::from_bits));
                let image = (splat.distance, splat.size);
                let splatting = Splatting::from_eye(dims, first, steps, image, splat.layout).expect("within limits");
                Splatted::of(prepared, splatting, [Intensity::ONE; 3])
                    .render(&|_, _| ())
                    .expect("a small frame")
            });
            let picture = fnv(made.picture.bytes.iter().copied());
            for (boundary, checksum) in [("image", of_image(&made.base)), ("picture", picture)] {
                let line = format!("{name}/{}/{boundary}", precision.name());
                assert_eq!(lines.insert(line.clone(), checksum), None, "two frames called {line}");
            }
        }
    }
}

fn measured() -> BTreeMap<String, u64> {
    let mut lines = BTreeMap::new();
    measured_colours(&mut lines);
    measured_splats(&mut lines);
    measured_splats_from_eye(&mut lines);
    for (name, frame) in frames() {
        let fast = is_fast(&frame).then_some(PrecisionName::Fast);
        for precision in PrecisionName::STAGED.into_iter().chain(fast) {
            for (boundary, checksum) in of_frame(&frame.in_precision(precision)) {
                let line = format!("{name}/{}/{boundary}", precision.name());
                assert_eq!(lines.insert(line.clone(), checksum), None, "two frames called {line}");
            }
        }
    }
    lines
}

fn write(lines: &BTreeMap<String, u64>) -> String {
    let mut text = HEAD.to_owned();
    for (name, checksum) in lines {
        writeln!(text, "{name}: {checksum:016x}").unwrap();
    }
    text
}

fn read(text: &str) -> BTreeMap<String, u64> {
    let mut lines = BTreeMap::new();
    for line in text.lines().filter(|line| !line.starts_with('#') && !line.is_empty()) {
        let (name, checksum) = line
            .split_once(": ")
            .unwrap_or_else(|| panic!("no checksum in {line:?}"));
        let checksum = u64::from_str_radix(checksum, 16).unwrap_or_else(|e| panic!("{line:?}: {e}"));
        assert_eq!(lines.insert(name.to_owned(), checksum), None, "{name} is listed twice");
    }
    lines
}

#[test]
fn every_checksum_is_the_manifests() {
    let found = measured();
    if std::env::var_os("SLICECAST_BLESS").is_some_and(|v| v == "1") {
        assert!(
            std::env::var_os("CI").is_none(),
            "a manifest is not written in continuous integration"
        );
        std::fs::write(manifest_path(), write(&found)).unwrap();
        panic!(
            "wrote {} lines to {}; now run without SLICECAST_BLESS",
            found.len(),
            manifest_path().display()
        );
    }
    let text = std::fs::read_to_string(manifest_path()).unwrap();
    let listed = read(&text);
    let mut faults = String::new();
    for (name, checksum) in &found {
        match listed.get(name) {
            None => writeln!(faults, "{name}: {checksum:016x} is not listed").unwrap(),
            Some(golden) if golden != checksum => {
                writeln!(faults, "{name}: {checksum:016x}, golden {golden:016x}").unwrap();
            }
            Some(_) => {}
        }
    }
    for name in listed.keys().filter(|name| !found.contains_key(*name)) {
        writeln!(faults, "{name} is listed, and no frame makes it").unwrap();
    }
    assert!(faults.is_empty(), "{}:\n{faults}", manifest_path().display());
    assert_eq!(text, write(&listed), "the manifest's own form");
}

/// Every frame in every precision is an image of its own: two that were alike would test the same thing twice.
#[test]
fn checksums_tell_frames_apart() {
    let listed = read(&std::fs::read_to_string(manifest_path()).unwrap());
    let images: Vec<_> = listed.iter().filter(|(name, _)| name.ends_with("/image")).collect();
    let fast = frames().iter().filter(|(_, frame)| is_fast(frame)).count();
    assert_eq!(
        images.len(),
        3 * (frames().len() + splats().len() + splats_from_eye().len()) + 2 * colour_frames().len() + fast
    );
    for (n, (name, checksum)) in images.iter().enumerate() {
        for (other, same) in &images[n + 1..] {
            // The dither of `compact` and `fast` is the same, and what it does to fog of one opacity.
            if (name.as_str(), other.as_str()) != ("fog/compact/image", "fog/fast/image") {
                assert_ne!(checksum, same, "{name} and {other}");
            }
        }
    }
}
