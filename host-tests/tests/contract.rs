//! The head of a stage's module and the stage's page of the contract state the same formulas.

use std::fs;
use std::path::Path;

const STAGES: [(&str, &str); 9] = [
    ("locate", "location"),
    ("interpolate", "interpolation"),
    ("classify", "classification"),
    ("gradient", "gradient"),
    ("normalise", "normalisation"),
    ("shade", "shading"),
    ("composite", "compositing"),
    ("project", "projection"),
    ("warp", "warp"),
];

fn read(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn without_spaces(text: &str) -> String {
    text.split_whitespace().collect()
}

/// What a module's head says in code and computes something.
fn formulas(head: &str) -> Vec<String> {
    let in_code = head.split('`').skip(1).step_by(2);
    let computes = |code: &&str| {
        [">>", "<<", "^", " * ", " = ", "min("]
            .iter()
            .any(|sign| code.contains(sign))
    };
    in_code.filter(computes).map(str::to_owned).collect()
}

#[test]
fn module_heads_state_the_contracts_formulas() {
    let mut held = 0;
    for (module, page) in STAGES {
        let source = read(&format!("core/src/{module}.rs"));
        let head: Vec<&str> = source.lines().map_while(|line| line.strip_prefix("//!")).collect();
        assert!(!head.is_empty(), "{module}");
        let text = without_spaces(&read(&format!("docs/contract/{page}.md")));
        for formula in formulas(&head.join(" ")) {
            // Steps of one formula stand apart on a page.
            for step in formula.split(';') {
                assert!(
                    text.contains(&without_spaces(step)),
                    "core/src/{module}.rs: `{step}` is not in docs/contract/{page}.md"
                );
                held += 1;
            }
        }
    }
    assert!(held > 15, "{held}");
}
