//! docs/contract/classification.md

use super::{Mistake, Numbers, Second, Width, towards_zero};

/// An entry as the memories hold it.
pub struct Entry {
    word: i128,
    low_root: i128,
    low: [i128; 3],
}

impl Entry {
    /// The entry of this name.
    pub fn of(inputs: &dyn Numbers, name: &str) -> Self {
        Self {
            word: inputs.get(name),
            low_root: inputs.get(&format!("{name}_low_root")),
            low: inputs.rgb(&format!("{name}_low")),
        }
    }
}

impl Second {
    pub(super) fn classification(&self, inputs: &dyn Numbers) -> Vec<i128> {
        let [code, lookup, sample] = ["code", "lookup", "sample"].map(|name| inputs.get(name));
        let entries = [Entry::of(inputs, "entry"), Entry::of(inputs, "next")];
        let (opacity, [red, green, blue]) = self.classified(code, lookup == 1, sample, &entries);
        vec![opacity, red, green, blue]
    }

    /// q, 0.16.
    fn root(&self, code: i128, entry: &Entry) -> i128 {
        let high = entry.word >> 24;
        if code == 0 {
            if self.makes(Mistake::ByteTimes256) {
                256 * high
            } else {
                257 * high
            }
        } else if self.makes(Mistake::LowRootLeftOut) {
            256 * high
        } else {
            256 * high + entry.low_root
        }
    }

    /// a of q.
    fn squared(&self, root: i128) -> i128 {
        let half = i128::from(!self.makes(Mistake::OpacityTruncated));
        (root * root + half) >> 1
    }

    fn colours(&self, code: i128, entry: &Entry) -> [i128; 3] {
        let byte = |channel: usize| entry.word >> (8 * channel) & 0xff;
        [0, 1, 2].map(|channel| {
            let high = byte(if self.makes(Mistake::BlueFirst) {
                2 - channel
            } else {
                channel
            });
            let low = entry.low[if self.makes(Mistake::LowBlueFirst) {
                2 - channel
            } else {
                channel
            }];
            let o = if code == 2 { 256 * high + low } else { 257 * high };
            let half = i128::from(!self.makes(Mistake::ColourTruncated));
            let c15 = (o + half) >> 1;
            match self.width {
                Width::Wide if self.makes(Mistake::WideColourOf15Bits) => c15 << 16,
                Width::Wide => (o << 15) + c15,
                _ => c15,
            }
        })
    }

    /// Opacity and colour of a sample between two entries.
    pub fn classified(&self, code: i128, linear: bool, sample: i128, entries: &[Entry; 2]) -> (i128, [i128; 3]) {
        let bits = self.width.sample_bits();
        let f = sample & ((1 << bits) - 1);
        let roots = [self.root(code, &entries[0]), self.root(code, &entries[1])];
        let colours = [self.colours(code, &entries[0]), self.colours(code, &entries[1])];
        if !linear {
            let half = if self.makes(Mistake::NearestTruncated) {
                0
            } else {
                1 << (bits - 1)
            };
            let at = usize::from((f + half) >> bits == 1);
            return (self.squared(roots[at]), colours[at]);
        }
        let mix = |a: i128, b: i128| {
            let half = if self.makes(Mistake::LinearTruncated) {
                0
            } else {
                1 << (bits - 1)
            };
            let f = if self.makes(Mistake::NextIndexed) {
                (1 << bits) - f
            } else {
                f
            };
            let product = (b - a) * f + half;
            a + if self.makes(Mistake::LinearTowardsZero) {
                towards_zero(product, bits)
            } else {
                product >> bits
            }
        };
        let opacity = if self.makes(Mistake::RootsMixed) {
            self.squared(mix(roots[0], roots[1]))
        } else {
            mix(self.squared(roots[0]), self.squared(roots[1]))
        };
        (
            opacity,
            [0, 1, 2].map(|channel| mix(colours[0][channel], colours[1][channel])),
        )
    }
}
