//! Text in pictures.

use std::convert::Infallible;

use embedded_graphics::Drawable;
use embedded_graphics::mono_font::MonoTextStyle;
use embedded_graphics::mono_font::ascii::FONT_7X13;
use embedded_graphics::pixelcolor::{Rgb888, RgbColor};
use embedded_graphics::prelude::{DrawTarget, OriginDimensions, Pixel, Point, Size};
use embedded_graphics::text::{Baseline, Text};
use slicecast_engine::image::Rgb;

/// Pixels from a line of text to the next.
pub const LINE: u32 = 16;

/// Pixels from a letter to the next.
pub const LETTER: u32 = 7;

/// A picture to draw on.
pub struct Sheet(pub Rgb);

impl Sheet {
    /// A black picture.
    pub fn black(size: [u32; 2]) -> Self {
        let [width, height] = size.map(|side| side as usize);
        Self(Rgb {
            size,
            bytes: vec![0; 3 * width * height],
        })
    }

    /// Writes white text with its upper left corner at a place. What lies outside is cut off; letters that ASCII does
    /// not have become question marks.
    pub fn write(&mut self, text: &str, at: [u32; 2]) {
        // Beyond the picture the font's own sums overflow.
        let outside = at.iter().zip(self.0.size).any(|(place, side)| *place >= side);
        let [Ok(x), Ok(y)] = at.map(i32::try_from) else { return };
        if outside {
            return;
        }
        let style = MonoTextStyle::new(&FONT_7X13, Rgb888::WHITE);
        let written: Result<_, Infallible> =
            Text::with_baseline(text, Point::new(x, y), style, Baseline::Top).draw(self);
        let Ok(_) = written;
    }

    /// Fills a rectangle, cut off where the picture ends.
    pub fn fill(&mut self, [x, y]: [u32; 2], [width, height]: [u32; 2], colour: [u8; 3]) {
        for row in y..y + height {
            for column in x..x + width {
                self.set([column, row], colour);
            }
        }
    }

    fn set(&mut self, [x, y]: [u32; 2], colour: [u8; 3]) {
        let [width, height] = self.0.size;
        if x < width && y < height {
            let start = 3 * (y as usize * width as usize + x as usize);
            self.0.bytes[start..start + 3].copy_from_slice(&colour);
        }
    }
}

/// A picture with a line of text below it, and as wide as that at least.
pub fn captioned(picture: Rgb, text: &str) -> Rgb {
    let [width, height] = picture.size;
    let letters = u32::try_from(text.chars().count()).unwrap_or(u32::MAX);
    let wide = width.max(LETTER.saturating_mul(letters.saturating_add(1)));
    let mut sheet = Sheet::black([wide, height + LINE]);
    let rows = picture.bytes.chunks_exact((3 * width as usize).max(1));
    for (out, row) in sheet.0.bytes.chunks_exact_mut(3 * wide as usize).zip(rows) {
        out[..row.len()].copy_from_slice(row);
    }
    sheet.write(text, [LETTER / 2, height + 1]);
    sheet.0
}

impl OriginDimensions for Sheet {
    fn size(&self) -> Size {
        let [width, height] = self.0.size;
        Size::new(width, height)
    }
}

impl DrawTarget for Sheet {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        for Pixel(Point { x, y }, colour) in pixels {
            if let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) {
                self.set([x, y], [colour.r(), colour.g(), colour.b()]);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lit(sheet: &Sheet) -> usize {
        sheet.0.bytes.chunks(3).filter(|pixel| *pixel != [0; 3]).count()
    }

    #[test]
    fn text_is_drawn_and_cut_off() {
        let written = |text: &str, at| {
            let mut sheet = Sheet::black([40, 16]);
            sheet.write(text, at);
            sheet
        };
        let one = written("8", [0, 0]);
        assert!(lit(&one) > 10);
        // No letter is wider than its place.
        assert!(
            one.0
                .bytes
                .chunks(3 * 40)
                .all(|row| row[3 * LETTER as usize..].iter().all(|b| *b == 0))
        );
        assert_eq!(lit(&written("8 8", [0, 0])), 2 * lit(&one));
        assert!(lit(&written("88", [36, 0])) < lit(&one));
        assert_eq!(lit(&written("8", [400, u32::MAX])), 0);
    }

    #[test]
    fn captions_stand_below_the_picture() {
        let picture = Rgb {
            size: [2, 3],
            bytes: vec![9; 18],
        };
        let with = captioned(picture, "0.5");
        assert_eq!(with.size, [28, 3 + LINE]);
        let pixel = |x: usize, y: usize| &with.bytes[3 * (28 * y + x)..][..3];
        assert_eq!((pixel(1, 2), pixel(2, 2)), (&[9; 3][..], &[0; 3][..]));
        assert!(with.bytes[3 * 28 * 3..].contains(&255));
    }

    #[test]
    fn rectangles_are_cut_off_where_the_picture_ends() {
        let mut sheet = Sheet::black([10, 4]);
        sheet.fill([8, 1], [5, 2], [1, 2, 3]);
        assert_eq!(lit(&sheet), 4);
    }
}
