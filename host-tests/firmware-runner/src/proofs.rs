//! What the shipped library must not contain: the C library is linked for a machine, one pipeline at a time with
//! everything that it does not reach left out, and the symbols of the result are read.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use crate::footprint::Footprint;
use crate::images::Workshop;
use crate::line;
use crate::machines::Machine;
use crate::scenes::Kind;
use crate::shell::{Failure, run_well};
use crate::toolchain::{Toolchain, build};

/// The functions that every program uses.
const FUNCTIONS: [&str; 7] = [
    "slicecast_version",
    "slicecast_needs",
    "slicecast_open",
    "slicecast_wanted",
    "slicecast_push",
    "slicecast_image",
    "slicecast_picture_row",
];

/// Builds the static library for a target in a profile: `firmware`, or `firmware-small`.
///
/// # Errors
/// With what the compiler said.
pub fn library(
    toolchain: &Toolchain,
    root: &Path,
    profile: &str,
    target: &str,
    cpu: Option<&str>,
) -> Result<PathBuf, Failure> {
    let (mut command, directory) = toolchain.cargo("build", profile, target, cpu);
    command.current_dir(root).args(["-p", "slicecast-ffi", "--lib"]);
    build(&mut command)?;
    Ok(directory.join("libslicecast_ffi.a"))
}

/// Builds core with all its features for a machine: none of them may need what only a host has.
///
/// # Errors
/// With what the compiler said.
pub fn all_features(workshop: &Workshop, machine: &Machine) -> Result<(), Failure> {
    let (mut command, _) = workshop
        .toolchain
        .cargo("build", "firmware", machine.target, machine.cpu);
    command
        .current_dir(&workshop.root)
        .args(["-p", "slicecast", "--lib", "--all-features"]);
    build(&mut command)
}

/// The function of a kind's pipeline: of points, or of segments.
pub fn entry(kind: Kind, segments: bool) -> String {
    let suffix = if segments { "_segments" } else { "" };
    format!("slicecast_{}{suffix}", kind.name().replace(' ', "_"))
}

/// Links one pipeline of a library, by its function.
///
/// # Errors
/// With what the linker said: a symbol that the library does not bring is one too.
pub fn link(workshop: &Workshop, machine: &Machine, library: &Path, entry: &str) -> Result<Footprint, Failure> {
    let program = workshop.directory().join(format!("{}-{entry}.elf", machine.name));
    let mut command = Command::new(workshop.toolchain.linker());
    command.args(["-flavor", "gnu", "--gc-sections", "-e", entry]);
    for function in FUNCTIONS {
        command.arg(format!("--undefined={function}"));
    }
    command.arg("-o").arg(&program).arg(library);
    run_well(&mut command, Duration::from_secs(60))?;
    Footprint::of(&program)
}

/// Proves it for every pipeline; returns the number of failures.
///
/// # Errors
/// If a pipeline cannot be linked.
pub fn prove(workshop: &Workshop, machine: &Machine, library: &Path) -> Result<u32, Failure> {
    let mut failed = 0;
    let kinds = Kind::all().flat_map(|kind| [(kind, false), (kind, true)]);
    for (kind, segments) in kinds {
        let footprint = link(workshop, machine, library, &entry(kind, segments))?;
        let found = findings(&footprint);
        let wanted = FUNCTIONS.iter().find(|f| !footprint.symbols.contains(**f));
        let failure = match (wanted, found.as_slice()) {
            (Some(function), _) => Some(format!("{function} was not linked: the proof proves nothing")),
            (None, []) => None,
            (None, found) => Some(found.join(", ")),
        };
        let what = format!("proofs {}{}", kind.name(), if segments { ", segments" } else { "" });
        failed += line(machine, &what, "", failure.map(|f| format!("reachable: {f}")));
    }
    Ok(failed)
}

/// What must not be there.
pub fn findings(footprint: &Footprint) -> Vec<String> {
    let mut found: Vec<String> = footprint.symbols.iter().filter_map(|s| forbidden(s)).collect();
    if let Some(function) = &footprint.float_in {
        found.push(format!("a floating-point instruction in {function} (float)"));
    }
    found
}

/// Why a symbol must not be there.
fn forbidden(symbol: &str) -> Option<String> {
    let demangled = symbol.replace("..", "::");
    let kind = if demangled.contains("panicking")
        || symbol.contains("rust_begin_unwind")
        || symbol.contains("panic_handler")
    {
        "panic"
    } else if is_float_routine(symbol) {
        "float"
    } else if symbol.contains("__rust_alloc") || symbol.contains("__rg_alloc") || symbol == "malloc" {
        "heap"
    } else {
        return None;
    };
    Some(format!("{symbol} ({kind})"))
}

/// The names that compilers give to arithmetic and conversions of floats in software.
fn is_float_routine(symbol: &str) -> bool {
    if let Some(rest) = symbol.strip_prefix("__aeabi_") {
        // f2iz, fadd, dmul, i2f, ul2d, cfcmple …; not memcpy, lmul, uidiv, llsl, ulcmp.
        let to_float = ["i2f", "ui2f", "l2f", "ul2f", "i2d", "ui2d", "l2d", "ul2d", "h2f"];
        return rest.starts_with('f')
            || rest.starts_with('d') && rest != "dummy"
            || rest.starts_with("cf")
            || rest.starts_with("cd")
            || to_float.contains(&rest);
    }
    symbol.starts_with("__") && ["sf", "df", "hf", "tf"].iter().any(|kind| symbol.contains(kind))
}

#[cfg(test)]
mod tests {
    use super::forbidden;

    #[test]
    fn symbols_are_told_apart() {
        for symbol in [
            "_ZN4core9panicking5panic17h0123456789abcdefE",
            "_RNvNtCs1234_4core9panicking18panic_bounds_check",
            "rust_begin_unwind",
            "__aeabi_fadd",
            "__aeabi_ui2d",
            "__aeabi_dcmplt",
            "__addsf3",
            "__fixunsdfsi",
            "__rust_alloc",
        ] {
            assert!(forbidden(symbol).is_some(), "{symbol}");
        }
        for symbol in [
            "memcpy",
            "__aeabi_memcpy4",
            "__aeabi_lmul",
            "__aeabi_uldivmod",
            "slicecast_open",
            "__muldi3",
        ] {
            assert_eq!(forbidden(symbol), None);
        }
    }
}
