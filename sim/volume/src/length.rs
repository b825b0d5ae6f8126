//! Units of length, as files of any format name them.

/// Millimetres of a unit's name; `None` of a name that is no unit of length.
///
/// The micro sign may be U+00B5, the Greek letter U+03BC, `u`, or ImageJ's escape `\u00B5`.
pub(super) fn millimetres(unit: &str) -> Option<f64> {
    let name = unit.trim().trim_matches('"').trim();
    let name = name
        .replace("\\u00B5", "u")
        .replace("\\u00b5", "u")
        .replace(['\u{b5}', '\u{3bc}'], "u");
    // Capital letters make other units of the metric symbols: Mm is no mm.
    let symbol = match name.as_str() {
        "km" => Some(1e6),
        "m" => Some(1000.0),
        "dm" => Some(100.0),
        "cm" => Some(10.0),
        "mm" => Some(1.0),
        "um" => Some(1e-3),
        "nm" => Some(1e-6),
        "pm" => Some(1e-9),
        "\u{c5}" | "\u{212b}" | "A" => Some(1e-7),
        "in" | "\"" => Some(25.4),
        "ft" => Some(304.8),
        _ => None,
    };
    symbol.or_else(|| {
        let lower = name.to_lowercase();
        let word = lower.strip_suffix('s').unwrap_or(&lower);
        let (prefix, word) = match word.strip_suffix("metre").or_else(|| word.strip_suffix("meter")) {
            Some(prefix) => (prefix, "metre"),
            None => ("", word),
        };
        match (prefix, word) {
            ("", "metre") => Some(1000.0),
            ("kilo", "metre") => Some(1e6),
            ("centi", "metre") => Some(10.0),
            ("milli", "metre") => Some(1.0),
            ("micro" | "u", "metre") | ("", "micron") => Some(1e-3),
            ("nano", "metre") => Some(1e-6),
            ("pico", "metre") => Some(1e-9),
            ("", "angstrom" | "\u{e5}ngstr\u{f6}m") => Some(1e-7),
            ("", "inch" | "inche") => Some(25.4),
            _ => None,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::millimetres;

    #[test]
    fn names_of_units_become_millimetres() {
        for (names, length) in [
            (&["m", "metre", "Meters", "\"m\""][..], 1000.0),
            (&["cm", "centimeter"], 10.0),
            (&["mm", "millimetres", " mm "], 1.0),
            (
                &[
                    "um",
                    "\u{b5}m",
                    "\u{3bc}m",
                    "\\u00B5m",
                    "micron",
                    "microns",
                    "Micrometer",
                ],
                1e-3,
            ),
            (&["nm", "nanometre"], 1e-6),
            (&["\u{c5}", "angstrom"], 1e-7),
            (&["in", "inch", "inches"], 25.4),
        ] {
            for name in names {
                assert_eq!(millimetres(name), Some(length), "{name}");
            }
        }
        for none in ["", "pixel", "s", "Mm", "reference frame", "gray value", "???"] {
            assert_eq!(millimetres(none), None, "{none}");
        }
    }
}
