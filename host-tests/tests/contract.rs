//! The head of a stage's module and the stage's page of the contract state the same formulas.

use std::fs;
use std::path::Path;

const STAGES: [(&str, &str); 11] = [
    ("locate", "location"),
    ("interpolate", "interpolation"),
    ("classify", "classification"),
    ("gradient", "gradient"),
    ("normalise", "normalisation"),
    ("shade", "shading"),
    ("shade/map", "reflectance"),
    ("modulate", "modulation"),
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

/// A number as the page of widths writes it: a sum of products of whole numbers and powers of 2, such as `-3 * 2^16 + 1`.
fn number(text: &str) -> i128 {
    let factor = |text: &str| -> i128 {
        let (base, power) = text.split_once('^').unwrap_or((text, "1"));
        let base: i128 = base.parse().unwrap_or_else(|_| panic!("`{text}` is no number"));
        let power: u32 = power.parse().unwrap_or_else(|_| panic!("`{text}` is no power"));
        // A sign stands before the whole: -2^3 is -8 whatever the power.
        base.signum() * base.abs().pow(power)
    };
    let terms = text.replace(" - ", " + -");
    terms
        .split(" + ")
        .map(|term| term.split(" * ").map(factor).product::<i128>())
        .sum()
}

/// The fewest bits that hold a range: `u` without, `s` with a sign.
fn fewest_bits(least: i128, largest: i128) -> String {
    let magnitude = |value: i128| i128::BITS - value.leading_zeros();
    if least < 0 {
        // -2^n needs no more bits than 2^n - 1.
        format!("s{}", magnitude(largest).max(magnitude(-least - 1)) + 1)
    } else {
        format!("u{}", magnitude(largest))
    }
}

#[test]
fn widths_hold_their_ranges_and_no_bit_more() {
    assert_eq!(number("-3 * 2^16 + 1 - 2^3"), -196_615);
    assert_eq!((fewest_bits(-8, 7), fewest_bits(0, 8)), ("s4".into(), "u4".into()));
    let page = read("docs/hardware.md");
    let widths = page.split("\n## Widths\n").nth(1).expect("a section of widths");
    let mut held = 0;
    for line in widths.lines().filter(|line| line.starts_with('|')) {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let [value, least, largest, bits, _] = cells[..] else {
            panic!("five columns: {line}");
        };
        if value == "value" || value.starts_with("---") {
            continue;
        }
        assert_eq!(bits, fewest_bits(number(least), number(largest)), "{line}");
        held += 1;
    }
    assert!(held > 80, "{held}");
}
