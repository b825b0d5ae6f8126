//! The `slicecast` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    slicecast_sim::run()
}
