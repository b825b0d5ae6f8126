//! The `slicecast` program.
//!
//! Exit codes: 0 done; 1 the machine failed (disk, threads); 2 the request or its input is at fault. Results go to
//! standard output, errors and progress to standard error.

mod cli;
mod export;
mod framing;
mod labels;
mod legend;
mod lettering;
mod presets;
mod projection;
mod raster;
mod slab;
mod visibility;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    match cli::Cli::parse().run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("slicecast: {}", failure.message);
            ExitCode::from(failure.code)
        }
    }
}
