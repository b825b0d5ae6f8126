//! docs/contract/warp.md, and the output of docs/contract/compositing.md

use super::{Mistake, Numbers, Second, towards_zero};

impl Second {
    pub(super) fn coordinate(&self, inputs: &dyn Numbers) -> [i128; 2] {
        let [origin, right, down, x, y] = ["origin", "right", "down", "x", "y"].map(|name| inputs.get(name));
        let (right, down) = if self.makes(Mistake::CoordinateOf16Bits) {
            (right >> 16 << 16, down >> 16 << 16)
        } else {
            (right, down)
        };
        let half = if self.makes(Mistake::CoordinateTruncated) {
            0
        } else {
            1 << 15
        };
        // It wraps at 64 bits.
        let p = ((origin + x * right + y * down + half) as i64 >> 16) as i128;
        [p >> 16, p & 0xffff]
    }

    fn mix(&self, a: i128, b: i128, w: i128) -> i128 {
        let half = if self.makes(Mistake::MixTruncated) { 0 } else { 1 << 15 };
        let product = (b - a) * w + half;
        a + if self.makes(Mistake::MixTowardsZero) {
            towards_zero(product, 16)
        } else {
            product >> 16
        }
    }

    pub(super) fn mixture(&self, inputs: &dyn Numbers) -> i128 {
        let [p00, p01, p10, p11] = ["p00", "p01", "p10", "p11"].map(|name| inputs.get(name));
        self.mixed([p00, p01, p10, p11], [inputs.get("weight_u"), inputs.get("weight_v")])
    }

    /// One channel of four pixels, `p_vu`.
    pub fn mixed(&self, [p00, p01, p10, p11]: [i128; 4], [wu, wv]: [i128; 2]) -> i128 {
        if self.makes(Mistake::MixDownFirst) {
            self.mix(self.mix(p00, p10, wv), self.mix(p01, p11, wv), wu)
        } else {
            self.mix(self.mix(p00, p01, wu), self.mix(p10, p11, wu), wv)
        }
    }

    pub(super) fn background(&self, inputs: &dyn Numbers) -> i128 {
        self.in_front(inputs.get("colour"), inputs.get("t"), inputs.get("background"))
    }

    /// A channel in front of a background, as a byte.
    pub fn in_front(&self, c: i128, t: i128, k: i128) -> i128 {
        let half = if self.makes(Mistake::BackgroundTruncated) {
            0
        } else {
            1 << 14
        };
        let sum = c + ((t * k + half) >> 15);
        // A byte that is not held wraps.
        if self.makes(Mistake::SumUnheld) {
            let one = self.width.one();
            return ((510 * sum + one) / (2 * one)) & 0xff;
        }
        self.byte(sum.min(self.width.one()))
    }

    pub(super) fn byte(&self, c: i128) -> i128 {
        let one = self.width.one();
        if self.makes(Mistake::ByteTruncated) {
            255 * c / one
        } else if self.makes(Mistake::ByteTopBits) {
            (256 * c / (one + one % 2)).min(255)
        } else {
            (510 * c + one) / (2 * one)
        }
    }
}
