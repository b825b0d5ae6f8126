//! Sheets: sums of weights, and of weights times values, and the samples that they make.

use core::marker::PhantomData;
use core::ops::Range;

use super::{Kernel, Rays, SplatError, Splatting, kernel};
use crate::format::Intensity;
use crate::lanes::{Kernel as LaneKernel, Lanes};
use crate::rows::{part, part_mut};

/// In place of a sample that does not exist.
pub const MISSING: i32 = i32::MIN;

/// Where the sum of weights begins in the word of a pixel; below it is that of weights times values.
const WEIGHTS: u32 = 38;
/// Pixels along an axis that a kernel covers, at most: 3 times 128, as near to an eye.
const TAPS: usize = 386;
/// Sheets of samples that are kept where there are gradients.
const KEPT: usize = 3;

/// The sample of a pixel's sums, with so many fraction bits. This function is the definition.
#[inline(always)]
pub const fn sample(sums: u64, least: u64, bits: u32) -> i32 {
    let (weights, values) = (sums >> WEIGHTS, sums & ((1 << WEIGHTS) - 1));
    if weights < least {
        return MISSING;
    }
    match ((values << bits) + (weights >> 1)).checked_div(weights) {
        Some(sample) => sample as i32,
        None => MISSING,
    }
}

/// The difference of a sample's neighbours along an axis; twice that to one of them where the other does not exist; 0 of a sample that
/// does not exist itself and has one neighbour. This function is the definition.
#[inline(always)]
pub const fn slope(before: i32, at: i32, behind: i32) -> i32 {
    match (before == MISSING, at == MISSING, behind == MISSING) {
        (false, _, false) => behind - before,
        (true, false, false) => 2 * (behind - at),
        (false, false, true) => 2 * (at - before),
        (true, _, true) | (_, true, _) => 0,
    }
}

/// Sheets that are being filled, and the samples of the last, of some rows of an image.
#[derive(Debug)]
pub struct Sheets<'a> {
    splatting: &'a Splatting,
    kernel: Kernel<'a>,
    first: u32,
    rows: usize,
    /// Elements of a row: its pixels, and whether any was added to.
    stride: usize,
    sums: &'a mut [u64],
    samples: &'a mut [i32],
    kept: usize,
}

impl<'a> Sheets<'a> {
    /// Elements of sums and of samples that so many rows need, with gradients or without.
    pub const fn len(splatting: &Splatting, rows: u32, lit: bool) -> [usize; 2] {
        let [width, _] = splatting.size;
        let sheet = rows as usize * (width as usize + 1);
        [sheet * splatting.reached() as usize, sheet * if lit { KEPT } else { 1 }]
    }

    /// Empty sheets of rows from `first` on, in memory of which more may be given than is needed.
    ///
    /// # Errors
    /// [`SplatError::Memory`] if less is.
    pub fn new(
        splatting: &'a Splatting,
        kernel: Kernel<'a>,
        (first, rows): (u32, u32),
        lit: bool,
        sums: &'a mut [u64],
        samples: &'a mut [i32],
    ) -> Result<Self, SplatError> {
        let needed = Self::len(splatting, rows, lit);
        for (needed, given) in needed.into_iter().zip([sums.len(), samples.len()]) {
            if given < needed {
                return Err(SplatError::Memory { needed, given });
            }
        }
        let [of_sums, of_samples] = needed;
        let (sums, samples) = (part_mut(sums, 0..of_sums), part_mut(samples, 0..of_samples));
        sums.fill(0);
        samples.fill(0);
        Ok(Self {
            splatting,
            kernel,
            first,
            rows: rows as usize,
            stride: splatting.size[0] as usize + 1,
            sums,
            samples,
            kept: if lit { KEPT } else { 1 },
        })
    }

    /// Spreads records to the sheet of their bin and those behind it, with these lanes' instructions.
    pub fn add<V: Lanes>(&mut self, bin: u32, records: &[u64]) {
        V::enter((Add, PhantomData::<V>, self, bin, records));
    }

    #[inline(always)]
    fn spread(&mut self, bin: u32, records: &[u64]) {
        let Self {
            splatting,
            kernel,
            first,
            rows,
            stride,
            ..
        } = *self;
        let (layout, reached) = (splatting.layout, splatting.reached());
        let [margin_x, margin_y] = splatting.margin.map(|margin| margin as i32);
        let [across, down] = [
            margin_x..splatting.size[0] as i32 + margin_x,
            first as i32 + margin_y..(first as i32 + rows as i32) + margin_y,
        ];
        let sheet = rows * stride;
        let (up, scale) = (13 - layout.position_bits(), splatting.scale(bin));
        let mut weights = [0; TAPS];
        let distance = |pixel: i32, place: u32| ((pixel << 13) - place as i32).unsigned_abs();
        for &record in records {
            let (place, u, value) = layout.unpack(record);
            let [x, y] = place.map(|c| c << up);
            let covered = |axis: usize, place: u32, all: &Range<i32>| {
                let [from, to] = kernel::pixels(place, scale.reach.get(axis).copied().unwrap_or(0));
                from.max(all.start)..(to + 1).min(all.end)
            };
            let (columns, lines) = (covered(0, x, &across), covered(1, y, &down));
            if columns.is_empty() || lines.is_empty() {
                continue;
            }
            let weights = part_mut(&mut weights, 0..columns.len());
            for (pixel, weight) in columns.clone().zip(weights.iter_mut()) {
                *weight = scale.weight(&kernel, 0, distance(pixel, x));
            }
            let column = (columns.start - margin_x) as usize;
            for line in lines {
                let height = scale.weight(&kernel, 1, distance(line, y));
                let row = (line - down.start) as usize * stride;
                for (number, &slab) in (bin..).zip(kernel.slabs(u)) {
                    let shared = kernel::down(slab, height);
                    if shared == 0 {
                        continue;
                    }
                    let slot = number.checked_rem(reached).unwrap_or(0) as usize;
                    let start = slot * sheet + row;
                    let row = part_mut(self.sums, start..start + stride);
                    if let Some((touched, row)) = row.split_last_mut() {
                        *touched = 1;
                        for (sum, &weight) in part_mut(row, column..column + weights.len()).iter_mut().zip(&*weights) {
                            let weight = kernel::across(shared, weight);
                            *sum += (u64::from(weight) << WEIGHTS) + u64::from(weight * value);
                        }
                    }
                }
            }
        }
    }

    /// Makes the samples of a sheet that nothing will be added to, with so many fraction bits, and empties it.
    pub fn settle(&mut self, number: u32, bits: u32) {
        let (sheet, least) = (self.rows * self.stride, self.splatting.least(number));
        let slot = number.checked_rem(self.splatting.reached()).unwrap_or(0) as usize;
        let kept = (number as usize).checked_rem(self.kept).unwrap_or(0);
        let sums = part_mut(self.sums, slot * sheet..(slot + 1) * sheet);
        let samples = part_mut(self.samples, kept * sheet..(kept + 1) * sheet);
        let rows = sums
            .chunks_exact_mut(self.stride)
            .zip(samples.chunks_exact_mut(self.stride));
        for (sums, samples) in rows {
            let (Some((touched, sums)), Some((any, samples))) = (sums.split_last_mut(), samples.split_last_mut())
            else {
                continue;
            };
            *any = 0;
            if *touched == 0 {
                continue;
            }
            *touched = 0;
            for (sum, out) in sums.iter_mut().zip(samples) {
                *out = sample(*sum, least, bits);
                *any |= i32::from(*out != MISSING);
                *sum = 0;
            }
        }
    }

    /// Says that there is no sheet of this number.
    pub fn none(&mut self, number: u32) {
        let sheet = self.rows * self.stride;
        let kept = (number as usize).checked_rem(self.kept).unwrap_or(0);
        part_mut(self.samples, kept * sheet..(kept + 1) * sheet).fill(0);
    }

    /// A sheet whose samples, and those of the sheets about it where there are gradients, are made.
    /// `spacing` is that of parallel rays; where they spread, sheets have factors of their own, and `rays` besides.
    pub fn sheet<'s>(&'s self, number: u32, spacing: [Intensity; 3], rays: Option<Rays<'s>>) -> Sheet<'s> {
        let sheet = self.rows * self.stride;
        let of = |number: u32| {
            let kept = (number as usize).checked_rem(self.kept).unwrap_or(0);
            part(self.samples, kept * sheet..(kept + 1) * sheet)
        };
        let about = |number: u32| if self.kept == KEPT { of(number) } else { &[] };
        Sheet {
            number,
            first: self.first,
            stride: self.stride,
            // Two further on lies the one in front.
            samples: [about(number + 2), of(number), about(number + 1)],
            spacing,
            rays: rays.map(|rays| rays.through(number)),
        }
    }
}

struct Add;

impl<V: Lanes> LaneKernel for (Add, PhantomData<V>, &mut Sheets<'_>, u32, &[u64]) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, _, sheets, bin, records) = self;
        sheets.spread(bin, records);
    }
}

/// Samples of a sheet in some rows of the image.
#[derive(Clone, Copy, Debug)]
pub struct Sheet<'a> {
    number: u32,
    first: u32,
    stride: usize,
    /// Of the sheet in front, this one, and the one behind.
    samples: [&'a [i32]; 3],
    spacing: [Intensity; 3],
    rays: Option<Rays<'a>>,
}

impl<'a> Sheet<'a> {
    /// Its number.
    pub const fn number(&self) -> u32 {
        self.number
    }

    /// Pixels of a row.
    pub const fn width(&self) -> usize {
        self.stride - 1
    }

    /// The spacing factors of gradients, of parallel rays.
    pub const fn spacing(&self) -> [Intensity; 3] {
        self.spacing
    }

    /// Rays of its pixels, where they spread.
    pub const fn rays(&self) -> Option<Rays<'a>> {
        self.rays
    }

    /// Samples of a row of the image: in front (0), of this sheet (1), behind (2). Empty where none exists.
    #[inline]
    pub fn row(&self, sheet: usize, row: i64) -> &'a [i32] {
        let samples = self.samples.get(sheet).copied().unwrap_or(&[]);
        let row = usize::try_from(row - i64::from(self.first)).unwrap_or(usize::MAX);
        let start = row.saturating_mul(self.stride);
        match part(samples, start..start.saturating_add(self.stride)).split_last() {
            Some((any, row)) if *any != 0 => row,
            _ => &[],
        }
    }
}
