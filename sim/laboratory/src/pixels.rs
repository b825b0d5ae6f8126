//! Compositing of a study: the recurrences that Squeeze proposes, compares with or would have met.
//!
//! | arithmetic | front to back | rounding |
//! |---|---|---|
//! | [`Arithmetic::Product`] | `C += (c a) T; T = T t` (Squeeze, equation 9; back to front equation 6) | each product truncated, or half up |
//! | [`Arithmetic::Product`] on [`Scale::Full`] | the same | Blinn's correction (Squeeze, equation 1), or one shift |
//! | [`Arithmetic::Telescoping`] | `w = T a; T -= w; C += c w` | each product truncated, or half up |
//! | [`Arithmetic::Dithered`] | the same | an offset that changes from plane to plane, as core's |
//! | [`Arithmetic::Telescoping`] on [`Scale::Carrying`] | the same | what a product loses is added to the next one |
//!
//! Every one keeps to the rules of `slicecast::composite`: nothing leaves 0 to 1, and but for the uncorrected scale an
//! opacity of 0 changes nothing. Rounded products and Blinn's can add up to one unit more than 1.0 and are saturated.

mod full;
mod plain;

use slicecast::composite::{Channel as _, Dither, Pixel, Recurrence, dithered_over, dithered_under};
use slicecast::format::Opacity;
use slicecast::lanes::Lanes;

use super::channels::{Scale, Stored};

/// How a sample is folded into a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arithmetic {
    /// Squeeze's recurrence: each product loses its low bits on its own. `rounded`: half up; on a full scale, Blinn's
    /// correction instead of one shift.
    Product {
        /// Whether products are rounded.
        rounded: bool,
    },
    /// What a sample takes from the transparency is what it gives.
    Telescoping {
        /// Whether products are rounded half up.
        rounded: bool,
    },
    /// Telescoping with the plane's dither.
    Dithered,
}

/// The pixel of a study: arithmetic, format of the channels, fraction bits of a colour (15 or 31).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StudyPixel {
    /// How samples are folded.
    arithmetic: Arithmetic,
    scale: Scale,
    colour_bits: u32,
}

impl StudyPixel {
    /// A pixel that takes colours of 15 bits; `None` if the format is not one that the arithmetic has.
    pub const fn new(arithmetic: Arithmetic, scale: Scale) -> Option<Self> {
        let fits = match (arithmetic, scale) {
            (Arithmetic::Product { .. } | Arithmetic::Telescoping { .. }, Scale::Binary(bits)) => {
                1 <= bits && bits <= 31
            }
            (Arithmetic::Telescoping { rounded: false }, Scale::Carrying(bits)) => 1 <= bits && bits <= 15,
            // The dither's products with a colour have 32 bits.
            (Arithmetic::Dithered, Scale::Binary(bits)) => 1 <= bits && bits <= 15,
            (Arithmetic::Dithered | Arithmetic::Product { .. }, Scale::Full(bits)) => 2 <= bits && bits <= 16,
            _ => false,
        };
        let pixel = Self {
            arithmetic,
            scale,
            colour_bits: 15,
        };
        if fits { Some(pixel) } else { None }
    }

    /// The same with colours of 31 bits; `None` for an arithmetic that has no room for them.
    pub const fn deep(self) -> Option<Self> {
        match (self.arithmetic, self.scale) {
            (Arithmetic::Product { .. } | Arithmetic::Telescoping { .. }, Scale::Binary(_)) => Some(Self {
                colour_bits: 31,
                ..self
            }),
            _ => None,
        }
    }

    /// The format of the channels.
    pub const fn scale(self) -> Scale {
        self.scale
    }

    /// How products lose their low bits.
    pub const fn rounding(self) -> &'static str {
        match (self.arithmetic, self.scale) {
            (Arithmetic::Product { rounded: true }, Scale::Full(_)) => "full scale, Blinn",
            (Arithmetic::Product { rounded: false }, Scale::Full(_)) => "full scale, one shift",
            (Arithmetic::Product { rounded: true }, _) => "rounded",
            (Arithmetic::Product { rounded: false }, _) => "truncated",
            (Arithmetic::Telescoping { .. }, Scale::Carrying(_)) => "residual carry",
            (Arithmetic::Telescoping { rounded: true }, _) => "telescoping, rounded",
            (Arithmetic::Telescoping { rounded: false }, _) => "telescoping",
            (Arithmetic::Dithered, _) => "dithered",
        }
    }

    #[inline(always)]
    const fn plain(self, rounded: bool) -> plain::Plain {
        plain::Plain {
            rounded,
            fraction: self.scale.bits(),
            colour_bits: self.colour_bits,
        }
    }
}

impl Recurrence for StudyPixel {
    type Channel = Stored;

    fn format(self) -> &'static str {
        self.scale.name()
    }

    #[inline(always)]
    fn one(self) -> Stored {
        Stored::from_bits(self.scale.one())
    }

    #[inline(always)]
    fn floor(self) -> Stored {
        Stored::from_bits(match self.scale {
            Scale::Carrying(_) => 1 << 16,
            Scale::Binary(_) | Scale::Full(_) => 1,
        })
    }

    fn telescoping(self) -> bool {
        !matches!(self.arithmetic, Arithmetic::Product { .. })
    }

    #[inline(always)]
    fn colour_bits(self) -> u32 {
        self.colour_bits
    }

    #[inline(always)]
    fn read(self, opacity: Opacity) -> Opacity {
        match (self.arithmetic, self.scale) {
            (Arithmetic::Product { .. }, Scale::Full(bits)) => full::read(bits, opacity),
            (Arithmetic::Product { rounded }, _) => self.plain(rounded).read(opacity),
            _ => opacity,
        }
    }

    #[inline(always)]
    fn over_lanes<V: Lanes>(self, pixel: Pixel<V>, colour: [V; 3], opacity: V, dither: Dither) -> Pixel<V> {
        match (self.arithmetic, self.scale) {
            (Arithmetic::Product { rounded }, Scale::Full(bits)) => {
                full::Full { bits, rounded }.over(pixel, colour, opacity)
            }
            (Arithmetic::Product { rounded }, _) => self.plain(rounded).product_over(pixel, colour, opacity),
            (Arithmetic::Telescoping { .. }, Scale::Carrying(_)) => plain::carrying_over(pixel, colour, opacity),
            (Arithmetic::Telescoping { rounded }, _) => self.plain(rounded).telescoping_over(pixel, colour, opacity),
            (Arithmetic::Dithered, _) => dithered_over(pixel, colour, opacity, dither),
        }
    }

    #[inline(always)]
    fn under_lanes<V: Lanes>(self, pixel: Pixel<V>, colour: [V; 3], opacity: V, dither: Dither) -> Pixel<V> {
        match (self.arithmetic, self.scale) {
            (Arithmetic::Product { rounded }, Scale::Full(bits)) => {
                full::Full { bits, rounded }.under(pixel, colour, opacity)
            }
            (Arithmetic::Product { rounded }, _) => self.plain(rounded).product_under(pixel, colour, opacity),
            (Arithmetic::Telescoping { rounded }, scale) => {
                self.plain(rounded)
                    .telescoping_under(pixel, colour, opacity, scale.one())
            }
            (Arithmetic::Dithered, scale) => dithered_under(scale.one(), pixel, colour, opacity, dither),
        }
    }
}

#[cfg(test)]
mod tests;
