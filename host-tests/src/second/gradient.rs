//! docs/contract/gradient.md

use super::{Mistake, Numbers, Second};

impl Second {
    pub(super) fn gradient(&self, inputs: &dyn Numbers) -> [i128; 3] {
        let [next_i, previous_i, next_j, previous_j, along_k] =
            ["next_i", "previous_i", "next_j", "previous_j", "along_k"].map(|name| inputs.get(name));
        let [fi, fj, fk] = inputs.ijk("factor");
        if self.makes(Mistake::SpacingBeforeDifference) {
            return [
                self.spaced(next_i, fi) - self.spaced(previous_i, fi),
                self.spaced(next_j, fj) - self.spaced(previous_j, fj),
                self.spaced(along_k, fk),
            ];
        }
        [
            self.spaced(next_i - previous_i, fi),
            self.spaced(next_j - previous_j, fj),
            self.spaced(along_k, fk),
        ]
    }

    /// A component times its spacing factor.
    pub fn spaced(&self, component: i128, factor: i128) -> i128 {
        let product = component * factor;
        if self.makes(Mistake::SpacingTruncated) {
            product >> 15
        } else if self.makes(Mistake::SpacingHalvesAway) && product < 0 {
            -((-product + (1 << 14)) >> 15)
        } else {
            (product + (1 << 14)) >> 15
        }
    }
}
