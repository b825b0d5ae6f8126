//! The precision of a study: its widths and its pixel are values, so that all studies are one pipeline.

use slicecast::precision::{Compact, Formats, Precision};

use super::channels::Scale;
use super::pixels::{Arithmetic, StudyPixel};

/// A precision whose numbers are chosen at run time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Study {
    /// Widths and roundings before compositing.
    pub formats: Formats,
    /// The pixel.
    pub pixel: StudyPixel,
}

impl Study {
    /// `Compact`, as a study has it.
    pub fn compact() -> Self {
        let pixel = StudyPixel::new(Arithmetic::Dithered, Scale::Full(16));
        Self {
            formats: Compact.formats(),
            pixel: pixel.expect("a format of 16 bits"),
        }
    }
}

impl Precision for Study {
    type Pixel = StudyPixel;
    const NAME: &'static str = "study";

    #[inline(always)]
    fn formats(self) -> Formats {
        self.formats
    }

    #[inline(always)]
    fn pixel(self) -> StudyPixel {
        self.pixel
    }
}
