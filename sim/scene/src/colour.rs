//! Colours as scene files and command lines write them: `"#rrggbb"` or three numbers.

use std::fmt;

use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};

/// A colour as written, not yet checked.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Colour {
    /// `"#rrggbb"`, or what stands in its place.
    Text(String),
    /// Red, green, blue.
    Numbers([f64; 3]),
}

impl Colour {
    /// Red, green, blue of a text `#rrggbb`, 255 being 1; `None` if it is not one. Numbers come back unchecked.
    pub fn rgb(&self) -> Option<[f64; 3]> {
        match self {
            Self::Numbers(rgb) => Some(*rgb),
            Self::Text(text) => hexadecimal(text.strip_prefix('#')?),
        }
    }
}

/// Red, green, blue of six hexadecimal digits, 255 being 1; `None` if they are not six or not hexadecimal.
pub fn hexadecimal(digits: &str) -> Option<[f64; 3]> {
    if digits.len() != 6 || !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
        return None;
    }
    let [_, rgb @ ..] = u32::from_str_radix(digits, 16).ok()?.to_be_bytes();
    Some(rgb.map(|channel| f64::from(channel) / 255.0))
}

impl<'de> Deserialize<'de> for Colour {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ColourVisitor)
    }
}

struct ColourVisitor;

impl<'de> Visitor<'de> for ColourVisitor {
    type Value = Colour;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a colour: \"#rrggbb\" or three numbers from 0 to 1")
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Colour, E> {
        Ok(Colour::Text(text.to_owned()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Colour, A::Error> {
        let mut rgb = [0.0; 3];
        for (i, channel) in rgb.iter_mut().enumerate() {
            *channel = seq.next_element()?.ok_or_else(|| A::Error::invalid_length(i, &self))?;
        }
        match seq.next_element::<f64>()? {
            None => Ok(Colour::Numbers(rgb)),
            Some(_) => Err(A::Error::invalid_length(4, &self)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_six_hexadecimal_digits_are_a_colour() {
        let rgb = |text: &str| Colour::Text(text.into()).rgb();
        assert_eq!(rgb("#ff0033"), Some([1.0, 0.0, 0.2]));
        assert_eq!(rgb("#FFFFFF"), Some([1.0; 3]));
        for bad in ["", "#", "ff0033", "#ff003", "#ff00333", "#+f0033", "#ff00é", "red"] {
            assert_eq!(rgb(bad), None, "{bad}");
        }
    }
}
