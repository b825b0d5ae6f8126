//! The `slicecast` program, as a library: it needs no other crate's code to be compiled, and is compiled while that is.
//!
//! Exit codes: 0 done; 1 the machine failed (disk, threads), or what was checked does not hold; 2 the request or its input
//! is at fault. Results go to standard output, errors and progress to standard error.

mod cli;
mod framing;
mod labels;
mod legend;
mod lettering;
mod losses;
mod presets;
mod projection;
mod raster;
mod shards;
mod slab;
mod visibility;

use std::process::ExitCode;

/// Does what the command line asks for.
pub fn run() -> ExitCode {
    // Whatever reads the output may have enough of it (`slicecast inspect scan.nrrd | head`): that is no fault.
    sigpipe::reset();
    match cli::Cli::of_command_line().run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("slicecast: {}", failure.message);
            ExitCode::from(failure.code)
        }
    }
}
