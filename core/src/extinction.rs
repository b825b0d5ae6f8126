//! Voxels of colour and extinction: what a slice of them holds.
//!
//! Source: Kraus and Bürger, "Interpolating and Downsampling RGBA Volume Data", 2008, equations 18 to 21: extinction tau and the
//! colours times tau may be interpolated. `docs/contract/extinction.md` has the formulas of all stages.
//!
//! | value | bits | range | meaning |
//! |---|---|---|---|
//! | colour O | 0.8 | 0 to 255 | straight, not multiplied |
//! | root q | 0.16 | 0 to 65535 | `sqrt(tau / tau_max)`; of 8 bits, 257 q8 |
//! | vt | 0.15 | 0 to 32767 | tau / tau_max, 32767 is 1 |
//! | vk | 0.15 | 0 to vt | colour k times tau, on the scale of vt |
//!
//! `vt = (q² + 2^16) >> 17`, `vk = (257 O vt + 2^15) >> 16`. Rounding: nearest. Overflow: q² + 2^16 <= 4294901761 < 2^32, and 65535 ·
//! 32767 + 2^15 < 2^31. vk <= vt, and vk = vt where O is 255, by exhaustion. State: none.

mod slopes;

use core::iter::zip;

pub use self::slopes::Eighths;
use crate::rows::take;
use crate::slice::{Region, RowRange, Slice, SliceError, Voxel};

/// The code of the largest extinction.
pub const MAX_CODE: u16 = 32767;

/// The code of an extinction, from its root.
#[inline(always)]
pub const fn extinction(root: u16) -> u16 {
    ((root as u32 * root as u32 + (1 << 16)) >> 17) as u16
}

/// The code of a colour times an extinction, which is at most [`MAX_CODE`].
#[inline(always)]
pub const fn weighted(extinction: u16, colour: u8) -> u16 {
    ((extinction as u32 * (257 * colour as u32) + (1 << 15)) >> 16) as u16
}

/// The codes of an [entry](crate::classify::entry) whose root has these low bits: extinction, and red, green and blue times
/// extinction. This function is the definition.
#[inline(always)]
pub const fn decode(entry: u32, low: u8) -> [u16; 4] {
    let [red, green, blue, high] = entry.to_le_bytes();
    let tau = extinction(u16::from_le_bytes([low, high]));
    [tau, weighted(tau, red), weighted(tau, green), weighted(tau, blue)]
}

/// Four codes of 15 bits: extinction, and red, green and blue times extinction. A row of a slice is four runs, one of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rgba15;

/// A slice of voxels of colour and extinction, row after row.
#[derive(Clone, Copy, Debug)]
pub enum Given<'g> {
    /// An [entry](crate::classify::entry) each, red, green, blue and the root of extinction, with its low byte from a plane
    /// beside them; without one, roots have 8 bits.
    Entries {
        /// One a voxel.
        entries: &'g [u32],
        /// One a voxel.
        low: Option<&'g [u8]>,
    },
    /// The codes as the ring keeps them: of each row four runs.
    Codes(&'g [u16]),
}

impl Voxel for Rgba15 {
    const WORDS: usize = 4;
    type Given<'g> = Given<'g>;

    #[inline(always)]
    fn given(words: &[u16]) -> Given<'_> {
        Given::Codes(words)
    }

    fn keep(given: Given<'_>, region: Region, words: &mut [u16], ranges: &mut [RowRange]) -> Result<(), SliceError> {
        let [width, height] = region.size;
        match given {
            Given::Codes(codes) => {
                Slice::of_codes(codes, width, height, ranges)?;
                if words.len() == codes.len() {
                    words.copy_from_slice(codes);
                }
            }
            Given::Entries { entries, low } => {
                let (start, stride) = region.within(entries.len())?;
                if let Some(low) = low
                    && low.len() != entries.len()
                {
                    let (needed, given) = (entries.len(), low.len());
                    return Err(SliceError::Voxels { needed, given });
                }
                for ((row, words), range) in words.chunks_exact_mut((4 * width).max(1)).enumerate().zip(ranges) {
                    let first = start + row * stride;
                    let entries = entries.get(first..first + width).unwrap_or(&[]);
                    let low = low.map(|low| low.get(first..first + width).unwrap_or(&[]));
                    *range = decode_row(entries, low, words);
                }
            }
        }
        Ok(())
    }
}

/// Decodes a row into its four runs; the range of its extinctions.
fn decode_row(entries: &[u32], low: Option<&[u8]>, mut words: &mut [u16]) -> RowRange {
    let len = entries.len();
    let mut run = || take(&mut words, len);
    let (tau, red, green, blue) = (run(), run(), run(), run());
    let runs = zip(zip(tau, red), zip(green, blue));
    let mut range = RowRange::EMPTY;
    let mut write = |entry: u32, low: u8, ((t, r), (g, b)): ((&mut u16, &mut u16), (&mut u16, &mut u16))| {
        [*t, *r, *g, *b] = decode(entry, low);
        range = range.union(RowRange { low: *t, high: *t });
    };
    match low {
        Some(low) => zip(zip(entries, low), runs).for_each(|((entry, low), to)| write(*entry, *low, to)),
        // 257 times a byte is that byte twice.
        None => zip(entries, runs).for_each(|(entry, to)| write(*entry, (entry >> 24) as u8, to)),
    }
    range
}

impl<'a> Slice<'a, Rgba15> {
    /// Checks and measures a slice of codes: each row is four runs of `width`, extinction, red, green and blue. The ranges are
    /// those of extinction.
    ///
    /// # Errors
    /// [`SliceError`]; `ranges` may then hold anything.
    pub fn of_codes(
        codes: &'a [u16],
        width: usize,
        height: usize,
        ranges: &'a mut [RowRange],
    ) -> Result<Self, SliceError> {
        let needed = width.saturating_mul(height).saturating_mul(4);
        if codes.len() != needed {
            let given = codes.len();
            return Err(SliceError::Voxels { needed, given });
        }
        let given = ranges.len();
        let Some(ranges) = ranges.get_mut(..height) else {
            return Err(SliceError::Ranges { needed: height, given });
        };
        for (row, (range, codes)) in zip(&mut *ranges, codes.chunks_exact((4 * width).max(1))).enumerate() {
            *range = measure(codes, width).map_err(|(column, codes)| SliceError::Colour { row, column, codes })?;
        }
        Ok(Self::measured(codes, ranges, width))
    }
}

/// The range of a row's extinctions, or the first voxel that is none.
fn measure(codes: &[u16], width: usize) -> Result<RowRange, (usize, [u16; 4])> {
    let run = |number: usize| codes.get(number * width..(number + 1) * width).unwrap_or(&[]);
    let colours = zip(run(1), zip(run(2), run(3)));
    let mut range = RowRange::EMPTY;
    for (column, (&tau, (&red, (&green, &blue)))) in zip(run(0), colours).enumerate() {
        if tau > MAX_CODE || red > tau || green > tau || blue > tau {
            return Err((column, [tau, red, green, blue]));
        }
        range = range.union(RowRange { low: tau, high: tau });
    }
    Ok(range)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::classify::entry;
    use std::vec;
    use std::vec::Vec;

    /// Every root with every colour.
    #[test]
    fn no_colour_exceeds_its_extinction() {
        let mut last = 0;
        for root in 0..=u16::MAX {
            let tau = extinction(root);
            assert!((last..=MAX_CODE).contains(&tau), "root {root}");
            assert!((f64::from(tau) - f64::from(root).powi(2) / 131_072.0).abs() <= 0.5);
            last = tau;
            let mut before = 0;
            for colour in 0..=u8::MAX {
                let found = weighted(tau, colour);
                assert!((before..=tau).contains(&found), "root {root}, colour {colour}");
                before = found;
            }
            assert_eq!([weighted(tau, 0), weighted(tau, 255)], [0, tau], "root {root}");
        }
        assert_eq!([extinction(0), extinction(u16::MAX)], [0, MAX_CODE]);
    }

    /// Roots of 8 bits are roots of 16 bits; runs and ranges are where they belong, and what was decoded is accepted.
    #[test]
    fn entries_are_decoded_into_runs() {
        let entries: Vec<u32> = (0..24u32).map(|i| i.wrapping_mul(0x9e37_79b9)).collect();
        let low: Vec<u8> = entries.iter().map(|entry| (entry >> 24) as u8).collect();
        let (mut words, mut ranges) = (vec![7; 96], vec![RowRange::EMPTY; 4]);
        let given = |low| Given::Entries { entries: &entries, low };
        Rgba15::keep(given(None), Region::all([6, 4]), &mut words, &mut ranges).unwrap();
        for (index, entry) in entries.iter().enumerate() {
            let [red, green, blue, root] = entry.to_le_bytes();
            let tau = extinction(257 * u16::from(root));
            let codes = [tau, weighted(tau, red), weighted(tau, green), weighted(tau, blue)];
            let (row, column) = (index / 6, index % 6);
            assert_eq!([0, 1, 2, 3].map(|run| words[24 * row + 6 * run + column]), codes);
            assert!((ranges[row].low..=ranges[row].high).contains(&tau));
        }
        let (mut again, mut measured) = (vec![9; 96], vec![RowRange::EMPTY; 4]);
        Rgba15::keep(given(Some(&low)), Region::all([6, 4]), &mut again, &mut measured).unwrap();
        assert_eq!((&again, &measured), (&words, &ranges));
        Rgba15::keep(Given::Codes(&words), Region::all([6, 4]), &mut again, &mut measured).unwrap();
        assert_eq!((&again, &measured), (&words, &ranges));
    }

    #[test]
    fn what_is_no_slice_is_refused_with_numbers() {
        let mut ranges = [RowRange::EMPTY; 1];
        let mut refused = |codes: &[u16]| Slice::of_codes(codes, 2, 1, &mut ranges).err();
        assert_eq!(refused(&[0; 7]), Some(SliceError::Voxels { needed: 8, given: 7 }));
        assert_eq!(refused(&[32767, 9, 32767, 9, 0, 9, 0, 9]), None);
        for codes in [[32768, 0, 0, 0], [5, 6, 0, 0], [5, 0, 6, 5], [5, 0, 0, 6]] {
            let [t, r, g, b] = codes;
            let error = SliceError::Colour {
                row: 0,
                column: 1,
                codes,
            };
            assert_eq!(refused(&[9, t, 0, r, 0, g, 9, b]), Some(error));
        }
        let entries = [entry([255; 3], 255); 2];
        let mut words = [0; 8];
        let short = Given::Entries {
            entries: &entries,
            low: Some(&[1]),
        };
        let refused = Rgba15::keep(short, Region::all([2, 1]), &mut words, &mut ranges);
        assert_eq!(refused, Err(SliceError::Voxels { needed: 2, given: 1 }));
    }
}
