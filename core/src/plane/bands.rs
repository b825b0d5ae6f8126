//! Bands of an image that is splatted, gone through sheet by sheet.

use super::Rows;
use super::sheets::FoldSheet;
use crate::format::Intensity;
use crate::lanes::Lanes;
use crate::precision::Precision as _;
use crate::rows::part;
use crate::splat::{Bands, Bins, Kernel, Rays, Sheets, SplatError, Splatting};

/// Memory of a band.
#[derive(Debug)]
pub struct BandMemory<'a> {
    /// See [`Sheets::len`], for [`Bands::most`] rows.
    pub sums: &'a mut [u64],
    /// The same.
    pub samples: &'a mut [i32],
    /// [`Shape::scratch_len`](super::Shape::scratch_len) of the image's width.
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
    memory: BandMemory<'_>,
) -> Result<(), SplatError> {
    let BandMemory {
        sums,
        samples,
        scratch,
        rays,
    } = memory;
    let needed = [L::SCRATCH.len(splatting.size()[0]), bands.rays_len(splatting)];
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
    let width = splatting.size()[0] as usize;
    let mut rows = data.chunks_exact((4 * width).max(1));
    rows.all(|row| part(row, 3 * width..4 * width).iter().all(|left| L::is_zero(*left)))
}
