//! docs/contract/borders.md, of samples

use super::{Mistake, Numbers, Second};

/// The coefficients of -log2, s1.30, the highest power first.
const LOG: [i128; 10] = [
    5_245_131,
    -14_879_428,
    23_718_752,
    -14_282_747,
    16_495_132,
    16_985_759,
    48_787_717,
    129_059_894,
    387_271_430,
    1_549_082_000,
];

/// Those of 2^-f, u0.32, the highest power first.
const POWER: [i128; 6] = [
    469_614,
    5_479_129,
    41_146_802,
    238_333_168,
    1_031_756_226,
    2_977_043_993,
];

/// What is left of light behind a depth, u8.24, 1.31; a negative power of 2.
fn left(y: i128) -> i128 {
    let f = (y & 0xff_ffff) << 7;
    let mut sum = POWER[0];
    for c in &POWER[1..] {
        sum = c - ((sum * f) >> 31);
    }
    let taken = (((sum * f) >> 31) + 1) >> 1;
    ((1 << 31) - taken) >> (y >> 24)
}

/// The rays of a phase along an axis, at a plane.
#[derive(Clone, Copy, Debug)]
pub struct Rays {
    /// Where pixel 0's begins.
    pub start: i128,
    /// From plane to plane.
    pub step: i128,
    /// The plane's number.
    pub plane: i128,
    /// Planes per voxel.
    pub rate: i128,
    /// Whether the box is that of cells.
    pub cells: bool,
}

impl Second {
    /// Columns or rows of the base plane, and where the first lies, of a box with exact borders.
    pub(super) fn box_base(
        &self,
        step: i128,
        [side, planes]: [i128; 2],
        [rate, rays]: [i128; 2],
        cells: bool,
    ) -> [i128; 2] {
        let c = i128::from(cells);
        let (up, down) = ((2 * planes * step).max(0), (2 * planes * step).min(0));
        let b = if self.makes(Mistake::BaseOfNodes) {
            0
        } else {
            c * ((1 << 32) - rate * step)
        };
        let last_phase = if self.makes(Mistake::BaseOfFirstPhase) {
            0
        } else {
            (2 * ((rays - 1) << 32) + rays) / (2 * rays)
        };
        let faces = (side - 1 + c) << 33;
        let origin = -((b + up + 2 * last_phase) >> 33);
        [((faces - b - down) >> 33) - origin + 1, origin]
    }

    /// The position in the middle of pixel 0's segment.
    pub fn middle(&self, rays: Rays, at_nearest: bool) -> i128 {
        let Rays {
            start,
            step,
            plane,
            rate,
            cells,
        } = rays;
        let halves = 2 * plane + i128::from(!self.makes(Mistake::FrontEnd));
        let halves = halves - if cells { rate } else { 0 };
        let half = if self.makes(Mistake::MiddleTruncated) {
            0
        } else {
            1 << 16
        };
        let position = (2 * start + halves * step + half) >> 17;
        if at_nearest {
            (position + (1 << 15)) >> 16 << 16
        } else {
            position
        }
    }

    /// The part of a pixel's segment between the faces.
    pub fn part(&self, rays: Rays, pixel: i128, side: i128) -> [i128; 2] {
        let Rays {
            start,
            step,
            plane,
            rate,
            cells,
        } = rays;
        let c = i128::from(cells);
        let begin = 2 * (start + (pixel << 32)) + (2 * plane - c * rate) * step + (c << 32);
        let faces = (side - 1 + c) << 33;
        let m = 2 * step.abs();
        if m == 0 {
            let inside = if self.makes(Mistake::FaceOpen) {
                0 < begin && begin < faces
            } else {
                0 <= begin && begin <= faces
            };
            return if inside { [0, 65536] } else { [65536, 0] };
        }
        let (into, out) = if step > 0 || self.makes(Mistake::FacesExchanged) {
            (-begin, faces - begin)
        } else {
            (begin - faces, begin)
        };
        let half = if self.makes(Mistake::ShareTruncated) { 0 } else { m };
        let share = |distance: i128| (distance.clamp(0, m) * (1 << 17) + half) / (2 * m);
        [share(into), share(out)]
    }

    pub(super) fn borders(&self, inputs: &dyn Numbers) -> Vec<i128> {
        let rays = Rays {
            start: inputs.get("start"),
            step: inputs.get("step"),
            plane: inputs.get("plane"),
            rate: inputs.get("planes_per_voxel"),
            cells: inputs.get("borders") == 1,
        };
        let [side, pixel] = ["side", "pixel"].map(|name| inputs.get(name));
        let own = self.middle(rays, inputs.get("nearest") == 1) + (pixel << 16);
        let last = (side - 1) << 16;
        let held = if self.makes(Mistake::Unheld) {
            own.max(0)
        } else {
            own.clamp(0, last)
        };
        let [from, to] = self.part(rays, pixel, side);
        vec![held, from, to]
    }

    /// The opacity of a fraction of a step.
    pub fn of_fraction(&self, opacity: i128, fraction: i128) -> i128 {
        if fraction == 65536 {
            return opacity;
        }
        if self.makes(Mistake::FractionLinear) {
            return (opacity * fraction) >> 16;
        }
        let t = (1_i128 << 31) - opacity;
        if t == 0 {
            return if self.makes(Mistake::OpaqueThinned) {
                left(0) - 1
            } else {
                opacity
            };
        }
        let zeros = i128::from((t as u32).leading_zeros()).min(31);
        let w = (1_i128 << 32) - (t << zeros);
        let mut q = LOG[0];
        for c in &LOG[1..] {
            q = ((q * (w >> 1)) >> 30) + c;
        }
        let half = if self.makes(Mistake::DepthTruncated) {
            0
        } else {
            1 << 34
        };
        let y = ((zeros - 1) << 27) + ((w * q + half) >> 35);
        let half = if self.makes(Mistake::FractionTruncated) {
            0
        } else {
            1 << 18
        };
        let found = (1 << 31) - left((y * fraction + half) >> 19);
        if self.makes(Mistake::FractionUnheld) {
            found
        } else {
            found.min(opacity)
        }
    }
}
