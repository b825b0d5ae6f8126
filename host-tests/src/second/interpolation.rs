//! docs/contract/interpolation.md

use super::{Mistake, Numbers, Second, Width, towards_zero};

impl Second {
    pub(super) fn interpolation(&self, inputs: &dyn Numbers) -> i128 {
        let voxel = |k: usize, j: usize, i: usize| inputs.get(&format!("voxel_{k}{j}{i}"));
        self.sample(&voxel, inputs.ijk("weight"))
    }

    /// The value between the eight voxels `voxel(k, j, i)`.
    pub fn sample(&self, voxel: &dyn Fn(usize, usize, usize) -> i128, weights: [i128; 3]) -> i128 {
        let paper = self.width == Width::Paper;
        let cut = |w: i128| {
            if paper && !self.makes(Mistake::WeightUncut) {
                w & 0xfff0
            } else {
                w
            }
        };
        let [wx, wy, wz] = weights.map(cut);
        let along_z = |j, i| (voxel(0, j, i) << 16) + (voxel(1, j, i) - voxel(0, j, i)) * wz;
        let along_y = |a0: i128, a1: i128, wy: i128| {
            let product = (a1 - a0) * wy;
            if self.makes(Mistake::YTowardsZero) {
                a0 + towards_zero(product + if paper { 0 } else { 1 << 15 }, 16)
            } else if paper {
                let b = a0 + (product >> 16);
                if self.makes(Mistake::YUncut) { b } else { b >> 4 << 4 }
            } else if self.makes(Mistake::YTruncated) {
                a0 + (product >> 16)
            } else {
                a0 + ((product + (1 << 15)) >> 16)
            }
        };
        let [b0, b1, wx] = if self.makes(Mistake::XBeforeY) {
            let first = |j| along_y(along_z(j, 0), along_z(j, 1), wx);
            [first(0), first(1), wy]
        } else {
            let first = |i| along_y(along_z(0, i), along_z(1, i), wy);
            [first(0), first(1), wx]
        };
        let product = (b1 - b0) * wx;
        let step = if self.makes(Mistake::XTowardsZero) {
            towards_zero(product, 16)
        } else if self.makes(Mistake::XRoundedTwice) {
            (product + (1 << 15)) >> 16
        } else {
            product >> 16
        };
        let lost = 16 - self.width.sample_bits();
        let rounds = (!paper && !self.makes(Mistake::XTruncated)) || (paper && self.makes(Mistake::XRoundedInPaper));
        let half = if rounds { 1 << (lost - 1) } else { 0 };
        (b0 + step + half) >> lost
    }
}
