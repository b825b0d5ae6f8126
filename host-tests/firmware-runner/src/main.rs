//! Builds slicecast for bare metal, runs it in QEMU and holds every stage boundary to the host's checksums.
//!
//! Started by `host-tests/run-firmware`. Nothing is skipped: what cannot be had is a failure that says what to install.

mod c;
mod colours;
mod cost;
mod exported;
mod fast;
mod faults;
mod footprint;
mod images;
mod machines;
mod perspective;
mod proofs;
mod reference;
mod scenes;
mod segments;
mod shell;
mod toolchain;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::mpsc::channel;
use std::thread;

use clap::Parser;
use slicecast_firmware_shared::angles;

use crate::colours::Colours;
use crate::fast::Fast;
use crate::footprint::Footprint;
use crate::images::{Case, Report, Workshop, execute, first_difference, parse};
use crate::machines::{BUILT_ONLY, MACHINES, Machine};
use crate::perspective::Perspective;
use crate::reference::{Counts, Sums, reference};
use crate::scenes::{Kind, Named};
use crate::segments::Segments;
use crate::shell::{Failure, fail};
use crate::toolchain::{Toolchain, need_program};

/// Runs slicecast on emulated microcontrollers and compares every bit with the host.
#[derive(Debug, Parser)]
struct Arguments {
    /// Measure the cost and write docs/firmware-cost.md, instead of comparing bits.
    #[arg(long)]
    cost: bool,
    /// Put faults into a copy of the sources and show that each is found, instead of comparing bits.
    #[arg(long = "break", conflicts_with = "cost")]
    faults: bool,
    /// Take Debian's compiler and core source although rustup has core for the machines.
    #[arg(long)]
    debian: bool,
    /// Machines by QEMU's name or the processor's (mps2-an386, Cortex-M4); all of them if none is named.
    machines: Vec<String>,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("FAILED: {error}");
            ExitCode::FAILURE
        }
    }
}

/// What the host knows of every case: by scene and kind.
pub(crate) type References = BTreeMap<(&'static str, Kind), (Sums, Counts)>;

fn run(arguments: &Arguments) -> Result<(), Failure> {
    let machines = chosen(&arguments.machines)?;
    for machine in &machines {
        need_program(machine.qemu)?;
        need_program(machine.gcc)?;
    }
    let root = root()?;
    let directory = root.join("target/firmware");
    fs::create_dir_all(&directory).map_err(|error| Failure(format!("{}: {error}", directory.display())))?;
    let mut targets: Vec<&str> = machines.iter().map(|m| m.target).chain(BUILT_ONLY).collect();
    targets.dedup();
    let toolchain = Toolchain::find(&targets, &directory, arguments.debian)?;
    println!("compiler: {}", toolchain.describe());

    let scenes = scenes::all()?;
    let references = references(&scenes)?;
    let segments = Segments::new(&scenes)?;
    let colours = Colours::new(&scenes)?;
    let perspective = Perspective::new(&scenes)?;
    let fast = Fast::new(&scenes)?;
    let mut source = scenes::source(&scenes, |named, kind| references[&(named.name, kind)].0.image)?;
    source.push_str(&segments.source()?);
    source.push_str(&colours.source());
    source.push_str(&perspective.source());
    source.push_str(&fast.source());
    let workshop = Workshop {
        toolchain,
        scenes: directory.join("scenes.rs"),
        root,
    };
    write_if_changed(&workshop.scenes, &source)?;
    let head = exported::write(&workshop)?;
    if arguments.cost {
        return cost::write(&workshop, &machines, &references, (&segments, &fast));
    }
    if let Some(small) = scenes.first() {
        let sums = |kind| references[&(small.name, kind)].0.image;
        let header = small.c(sums)? + &fast::c(small)?;
        write_if_changed(&workshop.directory().join("scene.h"), &header)?;
    }

    let mut failed = 0;
    if arguments.faults {
        for machine in &machines {
            failed += faults::show(&workshop, machine, &references)?;
        }
        return if failed == 0 {
            Ok(())
        } else {
            fail(format!("{failed} faults were not found"))
        };
    }
    // One machine of each architecture: the programs are the same for the others.
    for arm in [true, false] {
        if let Some(machine) = machines.iter().find(|m| m.is_arm() == arm) {
            workshop.lint(machine)?;
            line(machine, "lints", "", None);
            proofs::all_features(&workshop, machine)?;
            line(machine, "core with all features", "", None);
        }
    }
    let (send, built) = channel();
    thread::scope(|scope| {
        // A failure drops `built` with this scope; the other thread cannot send then, and builds no more.
        let (workshop, machines, built) = (&workshop, &machines, built);
        // The next machine's programs are built while this one's run.
        scope.spawn(move || {
            machines
                .iter()
                .all(|machine| send.send(Built::of(workshop, machine)).is_ok())
        });
        for machine in machines {
            let Built { programs, library } = built
                .recv()
                .unwrap_or_else(|_| fail(format!("{}: nothing was built", machine.name)))?;
            failed += bits(&programs, machine, &references)?;
            failed += bands(&programs, machine, &references)?;
            failed += queue(&programs, machine, &references)?;
            failed += segments.check(workshop, &programs, machine, &library)?;
            failed += colours.check(&programs, machine)?;
            failed += perspective.check(&programs, machine)?;
            failed += fast.check(&programs, machine)?;
            failed += proofs::prove(workshop, machine, &library)?;
            failed += c::on_machine(workshop, machine, &library)?;
            if machine.name == exported::MACHINE {
                failed += exported::on_machine(workshop, machine, &programs, &library, head)?;
            }
        }
        Ok::<(), Failure>(())
    })?;
    failed += c::on_host(&workshop)?;
    for target in BUILT_ONLY {
        proofs::library(&workshop.toolchain, &workshop.root, "firmware", target, None)?;
        println!("{target}: builds");
    }
    if failed > 0 {
        return fail(format!("{failed} checks"));
    }
    Ok(())
}

/// What is built for a machine.
struct Built {
    /// The directory of its programs.
    programs: PathBuf,
    /// The C library.
    library: PathBuf,
}

impl Built {
    fn of(workshop: &Workshop, machine: &Machine) -> Result<Self, Failure> {
        let mut names = vec!["bits", "segments", "colours", "perspective", "fast", "bands", "queue"];
        names.extend((machine.name == exported::MACHINE).then_some("exported"));
        Ok(Self {
            programs: workshop.images(machine, "release", &names)?,
            library: proofs::library(
                &workshop.toolchain,
                &workshop.root,
                "firmware",
                machine.target,
                machine.cpu,
            )?,
        })
    }
}

fn chosen(names: &[String]) -> Result<Vec<Machine>, Failure> {
    if names.is_empty() {
        return Ok(MACHINES.to_vec());
    }
    let find = |name: &String| {
        Machine::find(name).ok_or_else(|| {
            let known: Vec<&str> = MACHINES.iter().map(|m| m.name).collect();
            Failure(format!("no machine {name:?}; known: {}", known.join(", ")))
        })
    };
    names.iter().map(find).collect()
}

/// The repository that this program was built in.
fn root() -> Result<PathBuf, Failure> {
    let here = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    match here.ancestors().nth(2) {
        Some(root) => Ok(root.to_owned()),
        None => fail("the repository is not where this program was built"),
    }
}

pub(crate) fn write_if_changed(path: &Path, text: &str) -> Result<(), Failure> {
    if fs::read_to_string(path).is_ok_and(|old| old == text) {
        return Ok(());
    }
    fs::write(path, text).map_err(|error| Failure(format!("{}: {error}", path.display())))
}

fn references(scenes: &[Named]) -> Result<References, Failure> {
    let mut all = References::new();
    for named in scenes {
        for kind in Kind::all() {
            all.insert((named.name, kind), reference(named, kind)?);
        }
    }
    Ok(all)
}

/// Every stage boundary of every scene and kind on a machine. Returns the number of failures.
fn bits(programs: &Path, machine: &Machine, references: &References) -> Result<u32, Failure> {
    let finished = execute(machine, &programs.join("bits"), false)?;
    let report: Report = parse(&finished.out)?;
    let mut failed = 0;
    for scene in ["small", "large", "dense"] {
        for kind in Kind::all() {
            let (host, _) = &references[&(scene, kind)];
            let name = format!("{scene} {}", kind.name());
            let verdict = match report.cases.iter().find(|case| case.name == name) {
                Some(case) => first_difference(&case.sums, host),
                None => Some("did not run".to_owned()),
            };
            failed += line(machine, &name, &format!("{:08x}", host.image), verdict);
        }
    }
    let host = angles::sum();
    let differs = (report.angles != Some(host)).then(|| format!("{:08x?}, host {host:08x}", report.angles));
    failed += line(machine, "views from angles", &format!("{host:08x}"), differs);
    let verdict = (!finished.passed || !report.verdict).then(|| "its own verdict: fail".to_owned());
    failed += line(machine, "exit", "", verdict);
    Ok(failed)
}

/// 64^3 voxels, lit, in 64 KiB of RAM, band by band.
fn bands(programs: &Path, machine: &Machine, references: &References) -> Result<u32, Failure> {
    const RAM: u64 = 64 << 10;
    let program = programs.join("bands");
    let finished = execute(machine, &program, true)?;
    let report = parse(&finished.out)?;
    let (case, expected) = image_of(&report, references, "large")?;
    let statics = Footprint::of(&program)?.ram;
    let stack = report.stack.unwrap_or(u64::MAX);
    let mut verdict = None;
    if case.sums.image != expected || !finished.passed {
        verdict = Some(format!("image {:08x}, host {expected:08x}", case.sums.image));
    } else if statics.saturating_add(stack) > RAM {
        verdict = Some(format!(
            "{statics} bytes of statics and {stack} of stack, more than {RAM}"
        ));
    }
    let failed = line(machine, "64^3 lit in bands", &format!("{expected:08x}"), verdict);
    let note = case.notes.first().map_or("", |n| n.as_str());
    println!(
        "    {note}; RAM {statics} static + {stack} stack = {} bytes of {RAM}",
        statics.saturating_add(stack)
    );
    Ok(failed)
}

/// Slices through a queue that an interrupt fills.
fn queue(programs: &Path, machine: &Machine, references: &References) -> Result<u32, Failure> {
    let finished = execute(machine, &programs.join("queue"), true)?;
    let report = parse(&finished.out)?;
    let (case, expected) = image_of(&report, references, "dense")?;
    let failure = (case.sums.image != expected || !finished.passed)
        .then(|| format!("image {:08x}, host {expected:08x}", case.sums.image));
    let failed = line(machine, "slices from interrupts", &format!("{expected:08x}"), failure);
    println!("    {}", case.notes.first().map_or("", |n| n.as_str()));
    Ok(failed)
}

/// The one case of a program, and the sum that the host has for that scene, compact and lit.
fn image_of<'r>(report: &'r Report, references: &References, scene: &'static str) -> Result<(&'r Case, u32), Failure> {
    let kind = Kind::COMPACT_LIT;
    match (report.cases.first(), references.get(&(scene, kind))) {
        (Some(case), Some((sums, _))) if case.name == format!("{scene} {}", kind.name()) => Ok((case, sums.image)),
        _ => fail(format!("the program did not report {scene} {}", kind.name())),
    }
}

/// Prints a line of the result; 1 for a failure.
pub(crate) fn line(machine: &Machine, what: &str, sum: &str, failure: Option<String>) -> u32 {
    let good = if sum.is_empty() { "good" } else { "equal" };
    let verdict = failure.as_deref().map_or(good.to_owned(), |f| format!("FAILED {f}"));
    println!(
        "{:<11} {:<10} {what:<22} {sum:<8}  {verdict}",
        machine.name, machine.core
    );
    u32::from(failure.is_some())
}
