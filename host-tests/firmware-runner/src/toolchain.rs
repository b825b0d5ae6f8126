//! A compiler with a core library for the machines: rustup's, or Debian's compiler and library source.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use crate::machines::Machine;
use crate::shell::{Failure, answers, fail, run, run_well};

/// How long `rustup target add` may take; it is a small download where there is a network.
const RUSTUP_LIMIT: Duration = Duration::from_secs(60);
/// How long a package installation or a build may take.
const LONG: Duration = Duration::from_secs(1800);
/// Debian's compiler,
const DEBIAN_RUSTC: &str = "/usr/bin/rustc";
/// and its lints.
const DEBIAN_CLIPPY: &str = "/usr/bin/clippy-driver";

/// Where core comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Library {
    /// rustup has it ready.
    Ready,
    /// Built from Debian's source by Debian's compiler.
    Debian,
}

/// A way to build for the machines.
#[derive(Clone, Debug)]
pub struct Toolchain {
    library: Library,
    linker: PathBuf,
    directory: PathBuf,
}

/// Names of the packages that provide what a command needs.
const PACKAGES: [(&str, &str); 4] = [
    ("qemu-system-arm", "qemu-system-arm"),
    ("qemu-system-riscv32", "qemu-system-misc"),
    ("arm-none-eabi-gcc", "gcc-arm-none-eabi"),
    ("riscv64-unknown-elf-gcc", "gcc-riscv64-unknown-elf"),
];

/// Makes sure that a program is there, installing its Debian package where that can be done.
///
/// # Errors
/// With the package to install.
pub fn need_program(program: &str) -> Result<(), Failure> {
    if answers(program) {
        return Ok(());
    }
    let package = PACKAGES
        .iter()
        .find(|(p, _)| *p == program)
        .map_or(program, |(_, package)| package);
    install(&[package])?;
    if answers(program) {
        return Ok(());
    }
    fail(format!("{program} is missing: install the package {package}"))
}

/// Installs Debian packages if this user may.
fn install(packages: &[&str]) -> Result<(), Failure> {
    let list = packages.join(" ");
    let root = run(Command::new("id").arg("-u"), Duration::from_secs(10)).is_ok_and(|f| f.out.trim() == "0");
    if !root || !answers("apt-get") {
        return fail(format!(
            "{list}: not installed. Install with: sudo apt-get install {list}"
        ));
    }
    eprintln!("installing {list}");
    run_well(Command::new("apt-get").arg("update"), LONG)?;
    let mut command = Command::new("apt-get");
    command
        .args(["install", "-y", "--no-install-recommends"])
        .args(packages);
    command.env("DEBIAN_FRONTEND", "noninteractive");
    run_well(&mut command, LONG)
        .map(drop)
        .map_err(|error| Failure(format!("{list} cannot be installed: {error}")))
}

impl Toolchain {
    /// Finds or installs a compiler for these targets; `debian` leaves rustup's libraries aside.
    ///
    /// # Errors
    /// With what to install.
    pub fn find(targets: &[&str], directory: &Path, debian: bool) -> Result<Self, Failure> {
        let linker = linker()?;
        let ready = !debian && targets.iter().all(|target| has_core(target) || add(target));
        let library = if ready {
            Library::Ready
        } else {
            if !debian_is_there() {
                install(&["rustc-web", "rust-web-src", "rust-web-clippy"]).map_err(|error| {
                    let list = targets.join(" ");
                    Failure(format!(
                        "no core library for the machines. Either: rustup target add {list}\nor: {error}"
                    ))
                })?;
            }
            Library::Debian
        };
        Ok(Self {
            library,
            linker,
            directory: directory.to_owned(),
        })
    }

    /// The same with another directory for what is built.
    pub fn in_directory(&self, directory: &Path) -> Self {
        Self {
            directory: directory.to_owned(),
            ..self.clone()
        }
    }

    /// In words.
    pub fn describe(&self) -> String {
        let version = |rustc: &str| {
            run_well(Command::new(rustc).arg("--version"), Duration::from_secs(20))
                .unwrap_or_default()
                .trim()
                .to_owned()
        };
        match self.library {
            Library::Ready => format!("{} and rustup's core", version("rustc")),
            Library::Debian => format!("{} and Debian's core source", version(DEBIAN_RUSTC)),
        }
    }

    /// The linker.
    pub fn linker(&self) -> &Path {
        &self.linker
    }

    /// A `cargo` command that builds for a target in a profile, and the directory that the result appears in.
    pub fn cargo(&self, verb: &str, profile: &str, target: &str, cpu: Option<&str>) -> (Command, PathBuf) {
        let mut command = Command::new("cargo");
        command.args([verb, "--profile", profile, "--target", target]);
        let mut flags = format!("-Clinker={} -Clinker-flavor=ld.lld", self.linker.display());
        if let Some(cpu) = cpu {
            flags.push_str(&format!(" -Ctarget-cpu={cpu}"));
        }
        if self.library == Library::Debian {
            command.arg("-Zbuild-std=core");
            command.env("RUSTC", DEBIAN_RUSTC).env("RUSTC_BOOTSTRAP", "1");
        }
        let library = if self.library == Library::Debian {
            "debian"
        } else {
            "rustup"
        };
        let directory = self.directory.join(library).join(cpu.unwrap_or("generic"));
        command.env("RUSTFLAGS", flags).env("CARGO_TARGET_DIR", &directory);
        command
            .env_remove("RUSTUP_TOOLCHAIN")
            .env_remove("CARGO_ENCODED_RUSTFLAGS");
        (command, directory.join(target).join(profile))
    }

    /// A `cargo` command that lints for a machine.
    pub fn clippy(&self, machine: &Machine) -> Command {
        match self.library {
            Library::Ready => self.cargo("clippy", "release", machine.target, machine.cpu).0,
            Library::Debian => {
                let (mut command, _) = self.cargo("check", "release", machine.target, machine.cpu);
                command.env("RUSTC_WORKSPACE_WRAPPER", DEBIAN_CLIPPY);
                command
            }
        }
    }
}

impl Toolchain {
    /// Ends a `clippy` command: what is only a warning is a failure.
    pub fn deny_warnings(&self, command: &mut Command) {
        match self.library {
            Library::Ready => command.args(["--", "-Dwarnings"]),
            // As `cargo clippy` hands its arguments to the driver.
            Library::Debian => command.env("CLIPPY_ARGS", "-Dwarnings__CLIPPY_HACKERY__"),
        };
    }
}

/// Runs a `cargo` command.
///
/// # Errors
/// With what the compiler said.
pub fn build(command: &mut Command) -> Result<(), Failure> {
    run_well(command, LONG).map(drop)
}

fn has_core(target: &str) -> bool {
    let mut command = Command::new("rustc");
    command.args(["--print", "target-libdir", "--target", target]);
    run(&mut command, Duration::from_secs(20)).is_ok_and(|f| {
        std::fs::read_dir(f.out.trim()).is_ok_and(|entries| {
            entries
                .flatten()
                .any(|e| e.file_name().to_string_lossy().starts_with("libcore-"))
        })
    })
}

/// Asks rustup for a target, once for all: where it fails for one it is not asked again.
fn add(target: &str) -> bool {
    static FAILED: std::sync::atomic::AtomicBool = std::sync::atomic::AtomicBool::new(false);
    if FAILED.load(std::sync::atomic::Ordering::Relaxed) {
        return false;
    }
    let mut command = Command::new("rustup");
    command.args(["target", "add", target]);
    let added = run(&mut command, RUSTUP_LIMIT).is_ok_and(|f| f.passed) && has_core(target);
    FAILED.store(!added, std::sync::atomic::Ordering::Relaxed);
    added
}

fn debian_is_there() -> bool {
    answers(DEBIAN_RUSTC) && answers(DEBIAN_CLIPPY) && Path::new("/usr/lib/rustlib/src/rust/library/core").exists()
}

/// rust-lld, which rustup installs for the host.
fn linker() -> Result<PathBuf, Failure> {
    let sysroot = run_well(
        Command::new("rustc").args(["--print", "sysroot"]),
        Duration::from_secs(20),
    )?;
    let host = run_well(
        Command::new("rustc").args(["--print", "host-tuple"]),
        Duration::from_secs(20),
    )?;
    let path = Path::new(sysroot.trim())
        .join("lib/rustlib")
        .join(host.trim())
        .join("bin/rust-lld");
    if path.exists() {
        Ok(path)
    } else {
        fail(format!("{} is missing: install Rust with rustup", path.display()))
    }
}
