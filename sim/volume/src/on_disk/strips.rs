//! The least and the greatest code of every strip of a file: some rows of a slice, which lie side by side in it.
//!
//! What a transfer function hides need not be read. A sample between voxels of two strips lies between the codes of both, and a
//! gradient looks beyond a sample's own cell; so a strip is left out only where nothing between the least and the greatest
//! code of itself and all strips around it can be seen. Whatever stands in its place is then never seen either.

use crate::mapping::choice::Code;
use crate::mapping::{Tally, codes};
use crate::values::Values;

/// Rows of a strip: 64 KiB of 16-bit values in a row of 2048, which a disk reads at once.
pub(super) const ROWS: usize = 16;

/// Slices before and behind that a sample of a slab, or its gradient, looks at.
const REACH: usize = 3;

/// Least and greatest stored value of the strips of a slice.
pub(super) fn measured(slice: &Values, width: usize) -> Vec<[f64; 2]> {
    fn ranges<T: Copy + PartialOrd + Into<f64>>(values: &[T], len: usize) -> Vec<[f64; 2]> {
        let range = |strip: &[T]| {
            let mut strip = strip.iter().copied();
            let first = strip.next();
            let range = first.map(|first| {
                strip.fold([first; 2], |[low, high], value| {
                    [
                        if value < low { value } else { low },
                        if value > high { value } else { high },
                    ]
                })
            });
            range.map_or([0.0; 2], |range| range.map(Into::into))
        };
        values.chunks(len).map(range).collect()
    }
    let len = (ROWS * width).max(1);
    match slice {
        Values::I8(v) => ranges(v, len),
        Values::U8(v) => ranges(v, len),
        Values::I16(v) => ranges(v, len),
        Values::U16(v) => ranges(v, len),
        Values::I32(v) => ranges(v, len),
        Values::U32(v) => ranges(v, len),
        Values::F32(v) => ranges(v, len),
        Values::F64(v) => ranges(v, len),
    }
}

/// Least and greatest code of all strips of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Strips {
    /// Slice after slice.
    codes: Vec<[u16; 2]>,
    /// Strips of a slice.
    of_slice: usize,
}

/// Which strips are to be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wanted {
    strips: Vec<bool>,
    of_slice: usize,
}

impl Strips {
    /// The codes of slices that were measured, in any order.
    pub fn coded(mut slices: Vec<(usize, Vec<[f64; 2]>)>, code: &Code) -> Self {
        slices.sort_by_key(|(z, _)| *z);
        let of_slice = slices.first().map_or(0, |(_, strips)| strips.len());
        let mut unused = Tally::default();
        let mut coded = |range: [f64; 2]| {
            let codes = codes(code, &range, &mut unused);
            [codes[0], codes[1]]
        };
        Self {
            codes: slices
                .into_iter()
                .flat_map(|(_, strips)| strips)
                .map(&mut coded)
                .collect(),
            of_slice,
        }
    }

    /// The least code of a strip.
    pub fn least(&self, slice: usize, strip: usize) -> u16 {
        let found = self.codes.get(slice * self.of_slice + strip);
        found.map_or(0, |[low, _]| *low)
    }

    /// The strips that can be seen, or whose neighbours can; `meets` tells whether anything between two codes is visible.
    pub fn wanted(&self, meets: impl Fn([u16; 2]) -> bool) -> Wanted {
        let union = |ranges: &[[u16; 2]]| {
            ranges.iter().fold([u16::MAX, 0], |[low, high], range| {
                [low.min(range[0]), high.max(range[1])]
            })
        };
        let of_slice = self.of_slice.max(1);
        let around = |at: usize, reach: usize, end: usize| at.saturating_sub(reach)..(at + reach + 1).min(end);
        // First with the strips beside, then with the slices before and behind.
        let wide: Vec<[u16; 2]> = (self.codes.chunks(of_slice))
            .flat_map(|slice| (0..slice.len()).map(|strip| union(&slice[around(strip, 1, slice.len())])))
            .collect();
        let slices = wide.len() / of_slice;
        let seen = |index: usize| {
            let (slice, strip) = (index / of_slice, index % of_slice);
            let column: Vec<[u16; 2]> = around(slice, REACH, slices)
                .map(|slice| wide[slice * of_slice + strip])
                .collect();
            meets(union(&column))
        };
        Wanted {
            strips: (0..wide.len()).map(seen).collect(),
            of_slice,
        }
    }
}

impl Wanted {
    /// Whether a strip is to be read.
    pub fn has(&self, slice: usize, strip: usize) -> bool {
        self.strips.get(slice * self.of_slice + strip).copied().unwrap_or(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_beside_what_is_seen_are_read_too() {
        let strips = Strips {
            codes: (0..11 * 5)
                .map(|index| if index == 5 * 5 + 2 { [7, 9] } else { [3, 3] })
                .collect(),
            of_slice: 5,
        };
        let wanted = strips.wanted(|[low, high]| low <= 5 && 5 <= high);
        for slice in 0..11_usize {
            for strip in 0..5_usize {
                let near = slice.abs_diff(5) <= 3 && strip.abs_diff(2) <= 1;
                assert_eq!(wanted.has(slice, strip), near, "{slice} {strip}");
            }
        }
    }
}
