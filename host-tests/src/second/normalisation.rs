//! docs/contract/normalisation.md

use super::{Mistake, Second};

impl Second {
    /// g and r of a gradient.
    pub fn normalisation(&self, gradient: [i128; 3]) -> [i128; 4] {
        let bits = |value: i128| (128 - value.leading_zeros()) as i32;
        let most = if self.makes(Mistake::BlockOf32Bits) { 32 } else { 31 };
        let all = gradient.iter().fold(0, |all, c| all | c.abs());
        let g = gradient.map(|c| {
            let n = bits(if self.makes(Mistake::BlockEach) { c.abs() } else { all }).min(most);
            if n <= 15 {
                return c << (15 - n);
            }
            if self.makes(Mistake::BlockHalvesUp) {
                return ((c + (1 << (n - 16))) >> (n - 15)).clamp(-32767, 32767);
            }
            let half = if self.makes(Mistake::BlockTruncated) {
                0
            } else {
                1 << (n - 16)
            };
            let mut magnitude = (c.abs() + half) >> (n - 15);
            if !self.makes(Mistake::BlockUnsaturated) {
                magnitude = magnitude.min(32767);
            }
            if c < 0 { -magnitude } else { magnitude }
        });
        let s: i128 = g.iter().map(|c| c * c).sum();
        let [x, y, z] = g;
        [x, y, z, self.reciprocal(s)]
    }

    /// The largest r with r^2 S <= 2^70.
    fn reciprocal(&self, s: i128) -> i128 {
        if s == 0 {
            return if self.makes(Mistake::RootOfNothing) { 1 << 21 } else { 0 };
        }
        if self.makes(Mistake::RootInF64) {
            return (2f64.powi(35) / (s as f64).sqrt()) as i128;
        }
        let (mut low, mut high) = (0_i128, 1_i128 << 36);
        while high - low > 1 {
            let middle = (low + high) / 2;
            if middle * middle * s <= 1 << 70 {
                low = middle;
            } else {
                high = middle;
            }
        }
        // (r + 1/2)^2 S <= 2^70
        if self.makes(Mistake::RootNearest) && (2 * low + 1) * (2 * low + 1) * s <= 1 << 72 {
            low += 1;
        }
        low
    }

    pub(super) fn export(&self, g: [i128; 3], r: i128) -> [i128; 3] {
        g.map(|c| {
            if self.makes(Mistake::ExportHalvesUp) {
                return ((c * r + (1 << 19)) >> 20).clamp(-32768, 32768);
            }
            let half = if self.makes(Mistake::ExportTruncated) {
                0
            } else {
                1 << 19
            };
            let magnitude = ((c.abs() * r + half) >> 20).min(32768);
            let negative = (c < 0) != self.makes(Mistake::ExportReversed);
            if negative { -magnitude } else { magnitude }
        })
    }
}
