//! The type of a page's pixels, from its tags, and what is read of it.

use tiff::ColorType;
use tiff::tags::{ExtraSamples, PlanarConfiguration, Tag};

use super::NAME;
use super::damage::damaged;
use super::patched::{Decoder, Patched, Source};
use crate::error::Problem;
use crate::values::ValueType;

/// What pages are read for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wanted {
    /// One value a pixel.
    Grey,
    /// Red, green, blue, and perhaps opacity.
    Colours,
}

/// What a pixel has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Pixel {
    /// Bits of a value.
    pub bits: u64,
    /// Values side by side.
    pub components: u64,
}

impl Pixel {
    /// The current page's, which has to be of the wanted kind.
    pub fn of(decoder: &mut Decoder<'_>, wanted: Wanted) -> Result<Self, Problem> {
        let found = decoder.colortype().map_err(damaged)?;
        let unsupported = |found: String, expected| Problem::Unsupported {
            format: NAME,
            found,
            expected,
        };
        let (bits, components) = match (wanted, found) {
            (Wanted::Grey, ColorType::Gray(bits @ (8 | 16 | 32 | 64))) => return Ok(Self::new(bits, 1)),
            (Wanted::Grey, other) => {
                let expected = "grey of 8, 16 or 32 bits";
                return Err(unsupported(format!("a page of colour type {other:?}"), expected));
            }
            (Wanted::Colours, ColorType::RGB(bits @ (8 | 16))) => (bits, 3),
            (Wanted::Colours, ColorType::RGBA(bits @ (8 | 16))) => (bits, 4),
            (Wanted::Colours, other) => {
                let expected = "RGB or RGBA of 8 or 16 bits";
                return Err(unsupported(format!("a page of colour type {other:?}"), expected));
            }
        };
        let mut tag = |tag| decoder.find_tag_unsigned_vec::<u16>(tag).map_err(damaged);
        if let Some([planes]) = tag(Tag::PlanarConfiguration)?.as_deref()
            && *planes != PlanarConfiguration::Chunky.to_u16()
        {
            return Err(unsupported(
                "a page of one plane a colour".into(),
                "the colours of a pixel side by side",
            ));
        }
        let extra = tag(Tag::ExtraSamples)?.unwrap_or_default();
        if components == 4 && extra.first() == Some(&ExtraSamples::AssociatedAlpha.to_u16()) {
            let expected = "colours that are not multiplied by their opacity";
            return Err(unsupported("a page of associated opacity".into(), expected));
        }
        Ok(Self::new(bits, components))
    }

    fn new(bits: u8, components: u64) -> Self {
        Self {
            bits: bits.into(),
            components,
        }
    }

    /// The type of the page's values.
    pub fn value_type(self, decoder: &mut Decoder<'_>) -> Result<ValueType, Problem> {
        let format = decoder.find_tag_unsigned::<u16>(Tag::SampleFormat).map_err(damaged)?;
        match (format.unwrap_or(1), self.bits) {
            (1, 8) => Ok(ValueType::U8),
            (1, 16) => Ok(ValueType::U16),
            (1, 32) => Ok(ValueType::U32),
            (2, 8) => Ok(ValueType::I8),
            (2, 16) => Ok(ValueType::I16),
            (2, 32) => Ok(ValueType::I32),
            (3, 32) => Ok(ValueType::F32),
            (3, 64) => Ok(ValueType::F64),
            (format, bits) => Err(Problem::Unsupported {
                format: NAME,
                found: format!("a page of {bits} bits of sample format {format}"),
                expected: "integers of 8 to 32 bits, float or double",
            }),
        }
    }
}

/// Whether the first page has colours.
pub(super) fn is_coloured(source: &mut dyn Source) -> bool {
    let colour = Decoder::new(Patched::new(source)).and_then(|mut decoder| decoder.colortype());
    matches!(colour, Ok(ColorType::RGB(_) | ColorType::RGBA(_)))
}
