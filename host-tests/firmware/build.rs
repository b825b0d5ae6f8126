//! Places the program in a machine's memory and passes on where the scenes are.

use std::path::PathBuf;
use std::{env, fs};

fn variable(name: &str) -> String {
    println!("cargo:rerun-if-env-changed={name}");
    env::var(name).unwrap_or_else(|_| panic!("{name} is not set: build these programs with host-tests/run-firmware"))
}

fn main() {
    let machine = variable("SLICECAST_MACHINE");
    let scenes = variable("SLICECAST_SCENES");
    println!("cargo:rerun-if-changed={scenes}");
    println!("cargo:rustc-env=SLICECAST_SCENES={scenes}");
    let exported = variable("SLICECAST_EXPORTED");
    println!("cargo:rerun-if-changed={exported}");
    println!("cargo:rustc-env=SLICECAST_EXPORTED={exported}");

    let layout = format!("memory/{machine}.x");
    println!("cargo:rerun-if-changed={layout}");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    fs::copy(&layout, out.join("memory.x")).unwrap_or_else(|error| panic!("{layout}: {error}"));
    println!("cargo:rustc-link-search={}", out.display());

    let riscv = env::var("CARGO_CFG_TARGET_ARCH").is_ok_and(|arch| arch == "riscv32");
    if riscv {
        // riscv-rt's script, told where things go first.
        println!("cargo:rustc-link-arg-bins=-Tmemory.x");
    }
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    println!("cargo:rustc-link-arg-bins=--nmagic");
    // The bands program gets 64 KiB of RAM, statics and stack together.
    println!("cargo:rustc-link-arg-bin=bands=--defsym=_stack_start=_ram_64k");
}
