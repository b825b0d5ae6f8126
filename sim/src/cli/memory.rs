//! Sizes of memory and times on the command line.

use std::time::Duration;

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

/// What a picture may take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    /// Bytes.
    Memory(u64),
    /// A frame's time.
    Time(Duration),
}

/// `128MiB`, `200ms`, `1.5s`.
pub fn budget(text: &str) -> Result<Budget, String> {
    let seconds = |unit: &str, scale: f64| {
        let number: f64 = text.strip_suffix(unit)?.trim().parse().ok()?;
        let time = Duration::try_from_secs_f64(number * scale).ok()?;
        (1e-6..1e6).contains(&time.as_secs_f64()).then_some(Budget::Time(time))
    };
    let time = seconds("ms", 1e-3).or_else(|| seconds("s", 1.0));
    let memory = || bytes(text).ok().map(Budget::Memory);
    time.or_else(memory)
        .ok_or_else(|| "expected a size or a time, like 128MiB, 2GiB, 200ms or 1.5s".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn budgets_are_sizes_or_times() {
        assert_eq!(budget("2GiB"), Ok(Budget::Memory(2 << 30)));
        assert_eq!(budget("200ms"), Ok(Budget::Time(Duration::from_millis(200))));
        assert_eq!(budget("1.5 s"), Ok(Budget::Time(Duration::from_millis(1500))));
        for wrong in ["", "s", "0ms", "-1s", "NaNs", "infms", "1e9s", "5", "5min", "ms"] {
            assert!(budget(wrong).is_err(), "{wrong}");
        }
    }

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
