//! Bands: rows of the image that are gone through sheet by sheet, each for itself.

use core::ops::Range;

use super::{Rays, Splatting};

/// How an image is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bands {
    rows: u32,
    pub(crate) lit: bool,
}

impl Bands {
    /// Of so many rows, at least 1; with the row above and the one below where there are gradients.
    pub const fn new(rows: u32, lit: bool) -> Self {
        Self {
            rows: if rows == 0 { 1 } else { rows },
            lit,
        }
    }

    /// How many.
    pub const fn count(self, splatting: &Splatting) -> u32 {
        splatting.size[1].div_ceil(self.rows)
    }

    /// First row and number of rows of a band.
    pub const fn rows(self, splatting: &Splatting, band: u32) -> (u32, u32) {
        let first = band.saturating_mul(self.rows);
        let left = splatting.size[1].saturating_sub(first);
        (first, if left < self.rows { left } else { self.rows })
    }

    /// The rows whose samples a band needs.
    pub(crate) const fn sampled(self, splatting: &Splatting, band: u32) -> (u32, u32) {
        let (first, rows) = self.rows(splatting, band);
        if !self.lit {
            return (first, rows);
        }
        let (before, end) = (first.saturating_sub(1), first + rows);
        let end = if end < splatting.size[1] { end + 1 } else { end };
        (before, end - before)
    }

    /// The most rows whose samples a band needs.
    pub const fn most(self) -> u32 {
        self.rows + if self.lit { 2 } else { 0 }
    }

    /// Words that the rays of a band need: none where they are parallel.
    pub const fn rays_len(self, splatting: &Splatting) -> usize {
        match splatting.eye() {
            Some(_) => Rays::len(splatting.size, self.rows, self.lit),
            None => 0,
        }
    }

    /// The bands that need rows which a kernel covers, in a record's pixels.
    #[inline(always)]
    pub(crate) fn reached(self, splatting: &Splatting, [from, to]: [i32; 2]) -> Range<u32> {
        let (margin, height) = (splatting.margin[1] as i32, splatting.size[1] as i32);
        let (from, to, beside) = (
            (from - margin).max(0),
            (to - margin).min(height - 1),
            i32::from(self.lit),
        );
        if from > to {
            return 0..0;
        }
        let band = |row: i32| (row.max(0) as u32).checked_div(self.rows).unwrap_or(0);
        band(from - beside)..band((to + beside).min(height - 1)) + 1
    }
}
