//! Tests of the tests: faults put into a copy of the sources one at a time, each of which a check must find.
//!
//! A fault is a replacement of text that occurs exactly once; where it no longer fits the sources, that is a failure too.
//! The host's sums stay those of the sound sources, so a fault is one on one machine.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use crate::References;
use crate::images::{Workshop, execute, first_difference, parse};
use crate::machines::Machine;
use crate::proofs::{entry, findings, library, link};
use crate::scenes::Kind;
use crate::shell::{Failure, fail, run};

/// What must find a fault.
#[derive(Clone, Copy, Debug)]
enum Finder {
    /// The sums of a case differ first at this stage (or the picture, or the views from angles).
    Bits(&'static str),
    /// The proofs name a finding of this kind.
    Proof(&'static str),
    /// The test that the committed C header is fresh.
    Header,
}

/// A fault.
#[derive(Clone, Copy, Debug)]
struct Fault {
    what: &'static str,
    file: &'static str,
    from: &'static str,
    to: &'static str,
    finder: Finder,
}

const FAULTS: [Fault; 13] = [
    Fault {
        what: "a position truncated",
        file: "core/src/locate.rs",
        from: "k as i64 * step.to_bits();\n    Position::from_bits(((exact + (1 << 15)) >> 16) as i32)",
        to: "k as i64 * step.to_bits();\n    Position::from_bits((exact >> 16) as i32)",
        finder: Finder::Bits("location"),
    },
    Fault {
        what: "interpolation rounded a quarter up",
        file: "core/src/lanes/small.rs",
        from: "i64::from(w.0 << 15) + (i64::from(bias) << 16)",
        to: "i64::from(w.0 << 15) + (i64::from(bias) << 15)",
        finder: Finder::Bits("interpolation"),
    },
    Fault {
        what: "opacities between entries rounded a quarter up",
        file: "core/src/lanes/small.rs",
        from: "i64::from(d) * i64::from(f) + (1 << 31)",
        to: "i64::from(d) * i64::from(f) + (1 << 30)",
        finder: Finder::Bits("opacity"),
    },
    Fault {
        what: "colours between entries truncated",
        file: "core/src/classify.rs",
        from: "(a * rest + b * f + V::splat(half)) >> sample_bits",
        to: "(a * rest + b * f) >> sample_bits",
        finder: Finder::Bits("colour"),
    },
    Fault {
        what: "a gradient's spacing rounded a quarter up",
        file: "core/src/lanes/small.rs",
        from: "i64::from(f.0 << 15) + (1 << 31)",
        to: "i64::from(f.0 << 15) + (1 << 30)",
        finder: Finder::Bits("gradient"),
    },
    Fault {
        what: "normals rounded a quarter up",
        file: "core/src/normalise.rs",
        from: "c.abs().shl_each(by).wrapping_add(V::splat(1 << 15))",
        to: "c.abs().shl_each(by).wrapping_add(V::splat(1 << 14))",
        finder: Finder::Bits("normal"),
    },
    Fault {
        what: "powers of cosines truncated",
        file: "core/src/lanes/small.rs",
        from: "(square >> 32) as u32 + (square as u32 >> 31)",
        to: "(square >> 32) as u32",
        finder: Finder::Bits("shading"),
    },
    Fault {
        what: "the dither of transparency half a unit off",
        file: "core/src/composite/dithered.rs",
        from: "transparency.product16_31(opacity, (2 * dither.transparency + 1) << 15)",
        to: "transparency.product16_31(opacity, (2 * dither.transparency) << 15)",
        finder: Finder::Bits("compositing"),
    },
    Fault {
        what: "picture pixels truncated to the background",
        file: "core/src/warp.rs",
        from: "(1 << 15)) >> 16)) as u32)",
        to: "(1 << 14)) >> 16)) as u32)",
        finder: Finder::Bits("picture"),
    },
    Fault {
        what: "a float that slips in",
        file: "core/src/classify/code.rs",
        from: "Opacity::from_bits((root as u32 * root as u32 + 1) >> 1)",
        to: "Opacity::from_bits(((root as f32 * root as f32 + 1.0) * 0.5) as u32)",
        finder: Finder::Proof("float"),
    },
    Fault {
        what: "an index that can panic",
        file: "core/src/rows.rs",
        from: "row.get(range).unwrap_or(&[])",
        to: "&row[range]",
        finder: Finder::Proof("panic"),
    },
    Fault {
        what: "a division that can panic",
        file: "core/src/stream/ring.rs",
        from: "(number as usize).checked_rem(shape.slices).unwrap_or(0)",
        to: "number as usize % (len >> 8)",
        finder: Finder::Proof("panic"),
    },
    Fault {
        what: "the C interface changed, its header not",
        file: "core/ffi/src/lib.rs",
        from: "pub const SLICECAST_VERSION: u32 = 7;",
        to: "pub const SLICECAST_VERSION: u32 = 8;",
        finder: Finder::Header,
    },
];

/// Puts in each fault and prints which check found it; returns the number of faults that none found.
///
/// # Errors
/// If a fault does not fit the sources, or something cannot be built at all.
pub fn show(workshop: &Workshop, machine: &Machine, references: &References) -> Result<u32, Failure> {
    let tree = workshop.directory().join("broken/tree");
    copy_sources(&workshop.root, &tree)?;
    let broken = Workshop {
        toolchain: workshop.toolchain.in_directory(&workshop.directory().join("broken")),
        root: tree.clone(),
        scenes: workshop.scenes.clone(),
    };
    let directory = broken.directory();
    fs::create_dir_all(&directory).map_err(|error| Failure(format!("{}: {error}", directory.display())))?;
    let mut missed = 0;
    for fault in &FAULTS {
        let path = tree.join(fault.file);
        let words = |error: std::io::Error| Failure(format!("{}: {error}", path.display()));
        let sound = fs::read_to_string(&path).map_err(words)?;
        let places = sound.matches(fault.from).count();
        if places != 1 {
            return fail(format!(
                "the fault \"{}\" fits {} {places} times, not once: {}",
                fault.what, fault.file, fault.from
            ));
        }
        fs::write(&path, sound.replace(fault.from, fault.to)).map_err(words)?;
        let found = find(&broken, machine, references, fault.finder);
        fs::write(&path, &sound).map_err(words)?;
        let verdict = match found? {
            Some(finding) => format!("found: {finding}"),
            None => {
                missed += 1;
                "NOT FOUND".to_owned()
            }
        };
        println!("{:<11} {:<10} {:<46} {verdict}", machine.name, machine.core, fault.what);
    }
    Ok(missed)
}

/// What the check that should find a fault says.
fn find(
    workshop: &Workshop,
    machine: &Machine,
    references: &References,
    finder: Finder,
) -> Result<Option<String>, Failure> {
    match finder {
        Finder::Bits(stage) => {
            let programs = workshop.images(machine, "release", &["bits"])?;
            let report = parse(&execute(machine, &programs.join("bits"), false)?.out)?;
            let differences = report.cases.iter().filter_map(|case| {
                let host = references
                    .iter()
                    .find(|((scene, kind), _)| case.name == format!("{scene} {}", kind.name()))?;
                let difference = first_difference(&case.sums, &host.1.0)?;
                Some((case.name.clone(), difference))
            });
            let all: Vec<_> = differences.collect();
            let named = all.iter().find(|(_, difference)| difference.contains(stage));
            Ok(named.map(|(case, difference)| {
                format!("{} of {} cases; {case}, {difference}", all.len(), report.cases.len())
            }))
        }
        Finder::Proof(kind) => {
            let archive = library(
                &workshop.toolchain,
                &workshop.root,
                "firmware",
                machine.target,
                machine.cpu,
            )?;
            let all = findings(&link(workshop, machine, &archive, &entry(Kind::COMPACT_LIT, false))?);
            Ok(all.into_iter().find(|finding| finding.contains(&format!("({kind})"))))
        }
        Finder::Header => {
            let mut command = Command::new("cargo");
            command.args(["test", "--quiet", "-p", "slicecast-ffi", "--test", "header"]);
            command
                .current_dir(&workshop.root)
                .env("CARGO_TARGET_DIR", workshop.directory().join("host"));
            let finished = run(&mut command, Duration::from_secs(900))?;
            let said = format!("{}{}", finished.out, finished.err);
            let stale = said.lines().find(|line| line.contains("is stale"));
            Ok(stale.filter(|_| !finished.passed).map(str::to_owned))
        }
    }
}

/// A fresh copy of everything that a build reads.
fn copy_sources(from: &Path, to: &Path) -> Result<(), Failure> {
    let words = |error: std::io::Error| Failure(format!("{}: {error}", to.display()));
    fs::create_dir_all(to).map_err(words)?;
    for entry in fs::read_dir(from).map_err(words)? {
        let entry = entry.map_err(words)?;
        let name = entry.file_name();
        if name == "target" || name.to_string_lossy().starts_with('.') {
            continue;
        }
        let (source, copy) = (entry.path(), to.join(&name));
        if entry.file_type().map_err(words)?.is_dir() {
            copy_sources(&source, &copy)?;
            continue;
        }
        // What is the same keeps its date, so that it is not built again.
        let bytes = fs::read(&source).map_err(words)?;
        if fs::read(&copy).ok().as_ref() != Some(&bytes) {
            fs::write(&copy, &bytes).map_err(words)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::FAULTS;

    /// What `run-firmware --break` would find only after it has built the first programs.
    #[test]
    fn every_fault_has_its_place_in_the_sources() {
        let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
        for fault in &FAULTS {
            let source = std::fs::read_to_string(format!("{root}/{}", fault.file)).unwrap();
            assert_eq!(source.matches(fault.from).count(), 1, "{}: {}", fault.file, fault.what);
            assert_ne!(fault.from, fault.to);
        }
    }
}
