//! Prints the table of mutations: each mistake of the second model, how many directed vectors find it, and the first of them.
//! Exits with 1 if a mistake is not found.

use std::process::ExitCode;

use slicecast_host_tests::found::{mutations, table};

fn main() -> ExitCode {
    let found = mutations();
    print!("{}", table(&found));
    let missed = found.iter().filter(|found| found.vectors == 0).count();
    println!("\n{} mistakes, {missed} not found.", found.len());
    if missed == 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}
