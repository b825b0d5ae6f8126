//! Checks properties for every input, which takes minutes: `exhaustive [NAME …]`, all of them without a name. Exits with 1
//! if one does not hold and with 2 if a name is unknown.

use std::process::ExitCode;
use std::time::Instant;

use slicecast_host_tests::exhaustive::PROPERTIES;

fn main() -> ExitCode {
    let names: Vec<String> = std::env::args().skip(1).collect();
    for name in &names {
        if !PROPERTIES.iter().any(|p| p.name == name) {
            let known = PROPERTIES.map(|p| p.name).join(", ");
            eprintln!("no property is called {name}; there are: {known}");
            return ExitCode::from(2);
        }
    }
    let mut verdict = ExitCode::SUCCESS;
    for property in PROPERTIES {
        if !names.is_empty() && !names.iter().any(|name| name == property.name) {
            continue;
        }
        println!("{}: {}", property.name, property.claim);
        let start = Instant::now();
        match (property.check)(1) {
            Ok(count) => println!("  holds for all {count} cases ({:.1} s)", start.elapsed().as_secs_f64()),
            Err(counterexample) => {
                println!("  FAILS: {counterexample}");
                verdict = ExitCode::FAILURE;
            }
        }
    }
    verdict
}
