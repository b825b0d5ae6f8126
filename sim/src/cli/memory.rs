//! Sizes of memory on the command line.

/// Units, and what they are in bytes.
const UNITS: [(&str, u64); 7] = [
    ("KiB", 1 << 10),
    ("MiB", 1 << 20),
    ("GiB", 1 << 30),
    ("TiB", 1 << 40),
    ("kB", 1000),
    ("MB", 1_000_000),
    ("GB", 1_000_000_000),
];

/// `2GiB`, `1.5GB`, `800MiB`.
pub fn bytes(text: &str) -> Result<u64, String> {
    let unit = UNITS
        .into_iter()
        .find(|(name, _)| text.to_ascii_lowercase().ends_with(&name.to_ascii_lowercase()));
    let sized = unit.and_then(|(name, bytes)| {
        let number: f64 = text[..text.len() - name.len()].trim().parse().ok()?;
        let size = number * bytes as f64;
        (1.0..1e18).contains(&size).then_some(size as u64)
    });
    sized.ok_or_else(|| "expected a number above 0 and a unit, like 512MiB, 2GiB or 1.5GB".into())
}

#[cfg(test)]
mod tests {
    use super::bytes;

    #[test]
    fn sizes_have_a_number_and_a_unit() {
        assert_eq!(bytes("2GiB"), Ok(2 << 30));
        assert_eq!(bytes("1.5 gb"), Ok(1_500_000_000));
        assert_eq!(bytes("512MiB"), Ok(512 << 20));
        for wrong in [
            "",
            "2",
            "GiB",
            "-1GiB",
            "0MB",
            "1e30GiB",
            "NaNMB",
            "infKiB",
            "2Gi",
            "two GiB",
            "\u{e9}GiB",
            "\u{e9}",
        ] {
            assert!(bytes(wrong).is_err(), "{wrong}");
        }
    }
}
