//! What several subcommands take: a volume, a scene and what overrides its fields, threads.

mod scene;
mod threads;
mod volume;

use std::ops::RangeInclusive;
use std::str::FromStr;

use slicecast_scene::check;

pub use self::scene::SceneArgs;
pub use self::threads::ThreadArgs;
pub use self::volume::VolumeArgs;

/// The parser of a number that a scene's field may have.
pub fn number_in(range: RangeInclusive<f64>) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| {
        let number = text.parse().ok().filter(|number| range.contains(number));
        let [low, high] = [range.start(), range.end()].map(|end| check::shown(*end));
        number.ok_or_else(|| format!("expected a number from {low} to {high}"))
    }
}

/// As [`number_in`], of a whole number.
pub fn whole_in(range: RangeInclusive<i64>) -> impl Fn(&str) -> Result<u32, String> + Clone {
    move |text| {
        let number = text.parse::<i64>().ok().filter(|number| range.contains(number));
        let number = number.and_then(|number| u32::try_from(number).ok());
        number.ok_or_else(|| format!("expected a whole number from {} to {}", range.start(), range.end()))
    }
}

/// Numbers separated by `x` or commas.
pub fn numbers<T: FromStr, const N: usize>(text: &str, separator: char, example: &str) -> Result<[T; N], String> {
    let parts: Option<Vec<T>> = text.split(separator).map(|part| part.trim().parse().ok()).collect();
    parts
        .and_then(|parts| parts.try_into().ok())
        .ok_or_else(|| format!("expected {N} numbers like {example}"))
}

/// `WxHxD`.
pub fn dims(text: &str) -> Result<[u64; 3], String> {
    numbers(text, 'x', "256x256x108")
}

/// `x,y,z`.
pub fn spacing(text: &str) -> Result<[f64; 3], String> {
    let spacing: [f64; 3] = numbers(text, ',', "0.5,0.5,1.2")?;
    if spacing.iter().all(|s| s.is_finite() && *s > 0.0) {
        Ok(spacing)
    } else {
        Err("expected three lengths above 0".into())
    }
}
