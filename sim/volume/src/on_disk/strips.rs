//! The least and the greatest code of every strip of a file: some rows of a slice, which lie side by side in it, or a chunk.
//!
//! What a transfer function hides need not be read. A sample between voxels of two strips lies between the codes of both, and a
//! gradient looks beyond a sample's own cell; so a strip is left out only where nothing between the least and the greatest
//! code of itself and all strips around it can be seen. Whatever stands in its place is then never seen either.

use super::store::{Blocks, ROWS, Store};
use crate::mapping::choice::Code;
use crate::mapping::{Tally, codes};
use crate::values::Values;

/// Voxels before and behind that a sample of a slab, or its gradient, looks at.
const REACH: usize = 3;

/// How a store is cut into strips: chunks are not read in pieces.
pub(super) fn cut(store: &Store) -> Blocks {
    let Blocks { dims, side } = store.blocks();
    let [nx, ny, _] = side;
    let side = if store.is_plain() { [nx, ROWS.min(ny), 1] } else { side };
    Blocks { dims, side }
}

/// Least and greatest stored value of the strips of a block, each of so many values that lie side by side.
pub(super) fn measured(block: &Values, len: usize) -> Vec<[f64; 2]> {
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
    let len = len.max(1);
    match block {
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
    /// By their numbers.
    codes: Vec<[u16; 2]>,
    cut: Blocks,
}

/// Which strips are to be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wanted {
    strips: Vec<bool>,
}

impl Strips {
    /// The codes of blocks that were measured, in any order, each of strips that follow one another.
    pub fn coded(cut: Blocks, mut blocks: Vec<(usize, Vec<[f64; 2]>)>, code: &Code) -> Self {
        blocks.sort_by_key(|(number, _)| *number);
        let mut unused = Tally::default();
        let mut coded = |range: [f64; 2]| {
            let codes = codes(code, &range, &mut unused);
            [codes[0], codes[1]]
        };
        Self {
            codes: blocks
                .into_iter()
                .flat_map(|(_, strips)| strips)
                .map(&mut coded)
                .collect(),
            cut,
        }
    }

    /// How the file is cut.
    pub const fn cut(&self) -> &Blocks {
        &self.cut
    }

    /// The least code of a strip.
    pub fn least(&self, strip: usize) -> u16 {
        self.codes.get(strip).map_or(0, |[low, _]| *low)
    }

    /// The strips that can be seen, or whose neighbours can; `meets` tells whether anything between two codes is visible.
    pub fn wanted(&self, meets: impl Fn([u16; 2]) -> bool) -> Wanted {
        let counts = self.cut.counts();
        let mut ranges = self.codes.clone();
        // With the strips beside, along one axis after the other.
        for axis in 0..3 {
            let reach = REACH.div_ceil(self.cut.side[axis].max(1));
            let step: usize = counts[..axis].iter().product();
            let wider = |strip: usize| {
                let at = strip / step % counts[axis];
                let beside = at.saturating_sub(reach)..(at + reach + 1).min(counts[axis]);
                beside.fold([u16::MAX, 0], |[low, high], other| {
                    let [least, greatest] = ranges[strip - at * step + other * step];
                    [low.min(least), high.max(greatest)]
                })
            };
            ranges = (0..ranges.len()).map(wider).collect();
        }
        Wanted {
            strips: ranges.into_iter().map(meets).collect(),
        }
    }
}

impl Wanted {
    /// Whether a strip is to be read.
    pub fn has(&self, strip: usize) -> bool {
        self.strips.get(strip).copied().unwrap_or(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Strips of a slice, and chunks thinner and thicker than what a sample looks at.
    #[test]
    fn strips_beside_what_is_seen_are_read_too() {
        for (side, reach) in [([40, 16, 1], [1, 1, 3]), ([2, 5, 3], [2, 1, 1])] {
            let cut = Blocks {
                dims: [40, 80, 11],
                side,
            };
            let counts = cut.counts();
            let seen = counts.map(|count| count / 2);
            let strips = Strips {
                codes: (0..cut.len())
                    .map(|strip| if strip == cut.number(seen) { [7, 9] } else { [3, 3] })
                    .collect(),
                cut,
            };
            let wanted = strips.wanted(|[low, high]| low <= 5 && 5 <= high);
            for strip in 0..cut.len() {
                let at = cut.place(strip);
                let near = (0..3).all(|axis| at[axis].abs_diff(seen[axis]) <= reach[axis]);
                assert_eq!(wanted.has(strip), near, "{at:?}");
            }
        }
    }
}
