//! The C example: on the machines and on the host, the same source and the same sums.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use crate::exported;
use crate::images::{Workshop, execute, parse};
use crate::machines::Machine;
use crate::shell::{Failure, Finished, run, run_well};
use crate::toolchain::{build, need_program};

const LIMIT: Duration = Duration::from_secs(120);
/// Frames of `frame.c`.
const CASES: usize = 9;
const WARNINGS: [&str; 5] = ["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror"];

/// Builds and runs the example on a machine; returns the number of failures.
///
/// # Errors
/// If it cannot be built.
pub fn on_machine(workshop: &Workshop, machine: &Machine, library: &Path) -> Result<u32, Failure> {
    let finished = build_and_run(workshop, machine, library, "frame.c")?;
    Ok(verdict(
        &format!("{:<11} {:<10}", machine.name, machine.core),
        &finished,
    ))
}

/// Builds a program of one source with the library, and runs it on a machine.
///
/// # Errors
/// If it cannot be built.
pub fn build_and_run(
    workshop: &Workshop,
    machine: &Machine,
    library: &Path,
    source: &str,
) -> Result<Finished, Failure> {
    need_program(machine.gcc)?;
    let program = workshop.directory().join(format!("{}-{source}.elf", machine.name));
    let sources = workshop.root.join("host-tests/firmware");
    let mut command = Command::new(machine.gcc);
    command
        .args(machine.gcc_flags)
        .args(WARNINGS)
        .args(["-O2", "-ffreestanding", "-nostdlib", "-Wl,--gc-sections"]);
    command
        .arg("-I")
        .arg(workshop.root.join("core/ffi/include"))
        .arg("-I")
        .arg(workshop.directory())
        .arg("-I")
        .arg(exported::directory(workshop));
    command.arg(format!(
        "-Wl,-T,{}",
        sources.join("c").join(format!("{}.x", machine.name)).display()
    ));
    command
        .arg("-Wl,-T")
        .arg(format!("-Wl,{}", sources.join("c/bare.ld").display()));
    command
        .arg(sources.join("c").join(source))
        .arg(sources.join("c/bare.c"))
        .arg(library);
    command.arg("-o").arg(&program);
    run_well(&mut command, LIMIT)?;
    execute(machine, &program, false)
}

/// Builds and runs the example on the host; returns the number of failures.
///
/// # Errors
/// If it cannot be built.
pub fn on_host(workshop: &Workshop) -> Result<u32, Failure> {
    need_program("cc")?;
    let target = workshop.directory().join("host");
    let mut cargo = Command::new("cargo");
    cargo.args(["build", "--profile", "firmware", "-p", "slicecast-ffi", "--lib"]);
    cargo.current_dir(&workshop.root).env("CARGO_TARGET_DIR", &target);
    build(&mut cargo)?;
    let program = target.join("frame");
    let sources = workshop.root.join("host-tests/firmware/c");
    let mut command = Command::new("cc");
    command.args(WARNINGS).arg("-O2");
    command
        .arg("-I")
        .arg(workshop.root.join("core/ffi/include"))
        .arg("-I")
        .arg(workshop.directory());
    command.arg(sources.join("frame.c")).arg(sources.join("host.c"));
    command
        .arg(target.join("firmware/libslicecast_ffi.a"))
        .args(["-lpthread", "-ldl", "-lm"]);
    command.arg("-o").arg(&program);
    run_well(&mut command, LIMIT)?;
    let finished = run(&mut Command::new(&program), LIMIT)?;
    Ok(verdict(&format!("{:<22}", "host"), &finished))
}

/// Prints the result; the program has compared its sums with the host's itself.
fn verdict(place: &str, finished: &Finished) -> u32 {
    // QEMU writes what a program says by SYS_WRITE0 to its standard error.
    let report = parse(&format!("{}{}", finished.out, finished.err));
    let complete = report.as_ref().is_ok_and(|r| r.verdict && r.cases.len() == CASES);
    let sums = report.map_or_else(
        |error| error.to_string(),
        |r| {
            r.cases
                .iter()
                .map(|c| format!("{:08x}", c.sums.image))
                .collect::<Vec<_>>()
                .join(" ")
        },
    );
    let good = finished.passed && complete;
    println!(
        "{place} C: {CASES} frames             {sums}  {}",
        if good { "equal" } else { "FAILED" }
    );
    u32::from(!good)
}
