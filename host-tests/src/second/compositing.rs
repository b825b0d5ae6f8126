//! docs/contract/compositing.md

use super::{Mistake, Numbers, Second, Width};

impl Second {
    /// What a sample brings to a pixel of this name.
    fn sample_of(&self, inputs: &dyn Numbers) -> ([i128; 4], i128, [i128; 3], [i128; 2]) {
        let mut dither = self.dither(inputs.get("plane"));
        if self.makes(Mistake::DithersExchanged) {
            dither.reverse();
        }
        (
            inputs.pixel("before"),
            inputs.get("opacity"),
            inputs.rgb("colour"),
            dither,
        )
    }

    pub(super) fn front_to_back(&self, inputs: &dyn Numbers) -> [i128; 4] {
        let (before, opacity, colour, dither) = self.sample_of(inputs);
        let mut after = self.over(before, opacity, colour, dither);
        let floor = inputs.get("floor") + i128::from(self.makes(Mistake::FloorIncluded));
        if after[3] < floor && !self.makes(Mistake::FloorLeftOut) {
            after[3] = 0;
        }
        after
    }

    /// w of `Compact`.
    fn taken(&self, t: i128, a: i128, dither_t: i128) -> i128 {
        let a = if self.makes(Mistake::OpacityOf16Bits) {
            (a + (1 << 14)) >> 15 << 15
        } else {
            a
        };
        if self.makes(Mistake::TakenRounded) {
            return (t * a + (1 << 30)) >> 31;
        }
        let one = i128::from(!self.makes(Mistake::TransparencyHalfUnit));
        (t * a + ((2 * dither_t + one) << 15)) >> 31
    }

    /// t and A of `Paper`.
    fn step_of_paper(&self, a: i128) -> [i128; 2] {
        let taken = a >> 15;
        let t = if self.makes(Mistake::OpacityUncut) {
            ((1 << 31) - a) >> 16
        } else {
            ((1 << 16) - taken) >> 1
        };
        [t, taken]
    }

    /// A sample behind a pixel, before the floor.
    pub(super) fn over(&self, before: [i128; 4], a: i128, c: [i128; 3], [dither_t, dither_c]: [i128; 2]) -> [i128; 4] {
        let [red, green, blue, t] = before;
        let colour = [red, green, blue];
        let (given, left): (Box<dyn Fn(i128) -> i128>, i128) = match self.width {
            Width::Wide => {
                let half = if self.makes(Mistake::TakenRounded) { 1 << 30 } else { 0 };
                let w = (t * a + half) >> 31;
                let light = if self.makes(Mistake::ColourAfter) { t - w } else { w };
                (Box::new(move |c| (c * light) >> 31), t - w)
            }
            Width::Compact => {
                let w = self.taken(t, a, dither_t);
                let light = if self.makes(Mistake::ColourAfter) { t - w } else { w };
                let offset = if self.makes(Mistake::ColourUndithered) {
                    0
                } else {
                    dither_c
                };
                (Box::new(move |c| (c * light + offset) >> 15), t - w)
            }
            Width::Paper => {
                let [step, taken] = self.step_of_paper(a);
                let left = (t * step) >> 15;
                let light = if self.makes(Mistake::ColourAfter) { left } else { t };
                let first = self.makes(Mistake::PaperOrder);
                let given = move |c: i128| {
                    if first {
                        (((c * light) >> 15) * (taken >> 1)) >> 15
                    } else {
                        (((c * (taken >> 1)) >> 15) * light) >> 15
                    }
                };
                (Box::new(given), left)
            }
        };
        let [r, g, b] = [0, 1, 2].map(|channel| colour[channel] + given(c[channel]));
        [r, g, b, left]
    }

    pub(super) fn back_to_front(&self, inputs: &dyn Numbers) -> [i128; 4] {
        let ([red, green, blue, t], a, c, [dither_t, dither_c]) = self.sample_of(inputs);
        let colour = [red, green, blue];
        let mix = |old: i128, c: i128| match self.width {
            Width::Wide if self.makes(Mistake::BackInOneProduct) => old + (((c - old) * a) >> 31),
            Width::Wide => old - ((old * a) >> 31) + ((c * a) >> 31),
            Width::Compact => {
                let half = if self.makes(Mistake::ScaledTruncated) {
                    0
                } else {
                    1 << 14
                };
                let scaled = if self.makes(Mistake::ScaledTwice) {
                    2 * c
                } else {
                    (c * 65535 + half) >> 15
                };
                let one = i128::from(!self.makes(Mistake::ColourHalfUnit));
                let offset = if self.makes(Mistake::ColourUndithered) {
                    0
                } else {
                    dither_c
                };
                old + (((scaled - old) * a + ((2 * offset + one) << 15)) >> 31)
            }
            Width::Paper => {
                let [step, taken] = self.step_of_paper(a);
                ((old * step) >> 15) + ((c * (taken >> 1)) >> 15)
            }
        };
        let [r, g, b] = [0, 1, 2].map(|channel| mix(colour[channel], c[channel]));
        let left = match self.width {
            Width::Wide => t - ((t * a) >> 31),
            Width::Compact => t - self.taken(t, a, dither_t),
            Width::Paper => (t * self.step_of_paper(a)[0]) >> 15,
        };
        [r, g, b, left]
    }
}
