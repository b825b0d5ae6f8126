//! Samples of what `cargo run --release -p slicecast-host-tests --bin exhaustive` checks for every input.

use slicecast_host_tests::exhaustive::PROPERTIES;

fn holds(name: &str) {
    let property = PROPERTIES.iter().find(|p| p.name == name).unwrap();
    let cases = (property.check)(property.sample_stride).unwrap_or_else(|fault| panic!("{}: {fault}", property.claim));
    println!("{name}: {cases} cases, stride {}", property.sample_stride);
    assert!(cases > 60_000, "{cases}");
}

#[test]
fn reciprocal_roots() {
    holds("roots");
}

#[test]
fn reciprocal_roots_in_vectors() {
    holds("vector-roots");
}

#[test]
fn compositing_with_dither() {
    holds("over");
}

#[test]
fn opacities() {
    holds("opacity");
}

#[test]
fn colours() {
    holds("colour");
}

#[test]
fn powers() {
    holds("power");
}

#[test]
fn truncated_powers() {
    holds("paper-power");
}

#[test]
fn interpolation() {
    holds("interpolate");
}

#[test]
fn no_property_is_left_out() {
    let sampled = [
        "roots",
        "vector-roots",
        "over",
        "opacity",
        "colour",
        "power",
        "paper-power",
        "interpolate",
    ];
    assert_eq!(PROPERTIES.map(|p| p.name), sampled);
}
