//! docs/contract/projection.md

use super::classification::Entry;
use super::{Mistake, Numbers, Second, Width};

impl Second {
    pub(super) fn projection(&self, inputs: &dyn Numbers) -> i128 {
        let [extreme, kept, sample] = ["extreme", "kept", "sample"].map(|name| inputs.get(name));
        let unsigned = |value: i128| {
            if self.makes(Mistake::KeptUnsigned) {
                value & 0xffff_ffff
            } else {
                value
            }
        };
        let keeps = if extreme == 0 {
            unsigned(kept) >= unsigned(sample)
        } else {
            unsigned(kept) <= unsigned(sample)
        };
        if keeps { kept } else { sample }
    }

    pub(super) fn resolution(&self, inputs: &dyn Numbers) -> [i128; 4] {
        let [extreme, kept, code] = ["extreme", "kept", "code"].map(|name| inputs.get(name));
        let clear = [0, 0, 0, self.width.one()];
        let empty = if extreme == 0 {
            kept == -1 && !self.makes(Mistake::EmptyMaximumSeen)
        } else {
            kept == (1 << 31) - 1 && !self.makes(Mistake::EmptyMinimumSeen)
        };
        if empty {
            return clear;
        }
        let entries = [Entry::of(inputs, "entry"), Entry::of(inputs, "entry")];
        // It lies at its entry.
        let (opacity, colour) = self.classified(code, true, 0, &entries);
        self.resolved(opacity, colour)
    }

    /// The pixel of a projection's sample.
    pub fn resolved(&self, opacity: i128, colour: [i128; 3]) -> [i128; 4] {
        let clear = [0, 0, 0, self.width.one()];
        if self.makes(Mistake::ResolvedWithoutHalf) && self.width == Width::Compact {
            let w = (65535 * opacity) >> 31;
            let [r, g, b] = colour.map(|c| (c * w) >> 15);
            return [r, g, b, 65535 - w];
        }
        self.over(clear, opacity, colour, [0, 0])
    }
}
