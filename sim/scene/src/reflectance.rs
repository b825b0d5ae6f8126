//! A reflectance map as the user states it: light that is looked up by the gradient's direction.

use serde::{Deserialize, Serialize};

/// Nodes along an edge of the cube.
pub const SIDES: std::ops::RangeInclusive<i64> = 2..=256;

/// A reflectance map: a cube whose faces hold the lights' answer to so many directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reflectance {
    /// Nodes along an edge.
    pub side: u32,
    /// What is taken between them.
    pub filter: Filter,
}

/// How the map is read between its nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Filter {
    /// The nearest node.
    Nearest,
    /// Linear between four.
    #[default]
    Bilinear,
}

impl Reflectance {
    /// Reads `32` or `32,nearest`.
    ///
    /// # Errors
    /// What was wrong and what is expected.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (side, filter) = text.split_once(',').unwrap_or((text, "bilinear"));
        let side = side.trim().parse().ok().filter(|side| SIDES.contains(side));
        let filter = match filter.trim() {
            "nearest" => Some(Filter::Nearest),
            "bilinear" => Some(Filter::Bilinear),
            _ => None,
        };
        match (side.and_then(|side| u32::try_from(side).ok()), filter) {
            (Some(side), Some(filter)) => Ok(Self { side, filter }),
            _ => Err(format!(
                "{text:?}: expected nodes along an edge, {} to {}, and perhaps nearest or bilinear: 32,nearest",
                SIDES.start(),
                SIDES.end()
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_are_read_and_refused() {
        let of = |side, filter| Ok(Reflectance { side, filter });
        assert_eq!(Reflectance::parse("32"), of(32, Filter::Bilinear));
        assert_eq!(Reflectance::parse("256, nearest"), of(256, Filter::Nearest));
        for text in ["", "1", "257", "-8", "32,", "32,cubic", "nearest", "1e1"] {
            let error = Reflectance::parse(text).unwrap_err();
            assert!(error.contains("expected nodes along an edge, 2 to 256"), "{error}");
        }
    }
}
