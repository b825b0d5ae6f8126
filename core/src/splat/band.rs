//! Bands: rows of the image that are gone through sheet by sheet, each for itself.

use core::ops::Range;

use super::{Bins, Kernel, Rays, Sheets, SplatError, Splatting};
use crate::format::Intensity;
use crate::lanes::Lanes;
use crate::plane::{FoldSheet, Rows};
use crate::precision::Precision as _;
use crate::rows::part;

/// How an image is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bands {
    rows: u32,
    lit: bool,
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
    const fn sampled(self, splatting: &Splatting, band: u32) -> (u32, u32) {
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

/// Memory of a band.
#[derive(Debug)]
pub struct Memory<'a> {
    /// See [`Sheets::len`], for [`Bands::most`] rows.
    pub sums: &'a mut [u64],
    /// The same.
    pub samples: &'a mut [i32],
    /// [`Shape::scratch_len`](crate::plane::Shape::scratch_len) of the image's width.
    pub scratch: &'a mut [i32],
    /// [`Bands::rays_len`].
    pub rays: &'a mut [i32],
}

/// Folds all sheets into the rows of a band, from the bins of all runs of slices: sums do not depend on how many there are.
///
/// # Errors
/// [`SplatError::Memory`] for memory that is too short; no row is changed then.
pub fn fold_band<L: FoldSheet, V: Lanes>(
    pipeline: &L,
    (splatting, kernel, spacing): (&Splatting, Kernel<'_>, [Intensity; 3]),
    runs: &[Bins<'_>],
    (bands, band): (Bands, u32),
    data: &mut [L::Element],
    memory: Memory<'_>,
) -> Result<(), SplatError> {
    let Memory {
        sums,
        samples,
        scratch,
        rays,
    } = memory;
    let needed = [L::SCRATCH.len(splatting.size[0]), bands.rays_len(splatting)];
    for (needed, given) in needed.into_iter().zip([scratch.len(), rays.len()]) {
        if given < needed {
            return Err(SplatError::Memory { needed, given });
        }
    }
    let rows = bands.sampled(splatting, band);
    let mut sheets = Sheets::new(splatting, kernel, rows, bands.lit, sums, samples)?;
    let bits = pipeline.precision().formats().sample_bits;
    let (first, count) = bands.rows(splatting, band);
    let rays = splatting
        .eye()
        .map(|eye| Rays::make::<V>(eye, (first, count), bands.lit, rays));
    let whole = splatting.first_sheet();
    // Where there are gradients, a sheet is folded when the one behind it is made.
    let behind = u32::from(bands.lit);
    let count = splatting.sheets();
    for number in 0..count + behind {
        if number < count {
            for bins in runs {
                sheets.add::<V>(number, bins.records(band, number));
            }
            sheets.settle(number, bits);
            if number < whole {
                sheets.none(number);
            }
        } else {
            sheets.none(number);
        }
        let Some(number) = number.checked_sub(behind) else {
            continue;
        };
        let rows = Rows {
            first,
            data: &mut *data,
        };
        // Its memory has been looked at.
        let folded = pipeline.fold_sheet::<V>(&sheets.sheet(number, spacing, rays), rows, scratch);
        if folded.is_err() || finished::<L>(splatting, data) {
            break;
        }
    }
    Ok(())
}

/// Whether all rays of a band have terminated.
fn finished<L: FoldSheet>(splatting: &Splatting, data: &[L::Element]) -> bool {
    let width = splatting.size[0] as usize;
    let mut rows = data.chunks_exact((4 * width).max(1));
    rows.all(|row| part(row, 3 * width..4 * width).iter().all(|left| L::is_zero(*left)))
}
