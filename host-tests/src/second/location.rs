//! docs/contract/location.md

use super::{Mistake, Numbers, Second, Width};

/// Numerator / denominator to the nearest, halves up; both positive.
fn nearest(numerator: i128, denominator: i128) -> i128 {
    (2 * numerator + denominator) / (2 * denominator)
}

impl Second {
    pub(super) fn plan(&self, inputs: &dyn Numbers) -> Vec<i128> {
        let direction = inputs.three("direction", ["x", "y", "z"]);
        let sides = inputs.three("side", ["x", "y", "z"]);
        let planes_per_voxel = inputs.get("planes_per_voxel");
        let size = direction.map(i128::abs);
        let longest = size.into_iter().max().unwrap_or(0);
        let order = if self.makes(Mistake::TiesToX) {
            [0, 1, 2]
        } else {
            [2, 1, 0]
        };
        let major = order.into_iter().find(|axis| size[*axis] == longest).unwrap_or(2);
        let [i, j] = [[1, 2], [0, 2], [0, 1]][major];
        let scale = longest * planes_per_voxel;
        let step = |axis: usize| {
            let exact = size[axis] << 32;
            let magnitude = if self.makes(Mistake::StepTruncated) {
                exact / scale
            } else if self.makes(Mistake::StepHalvesUp) && direction[axis] < 0 {
                (2 * exact + scale - 1) / (2 * scale)
            } else {
                nearest(exact, scale)
            };
            if direction[axis] < 0 { -magnitude } else { magnitude }
        };
        let (step_i, step_j) = (step(i), step(j));
        let borders = inputs.get("borders");
        let rates = [planes_per_voxel, inputs.get("rays_per_voxel")];
        let planes = match borders {
            0 => (sides[major] - 1) * planes_per_voxel + 1,
            1 => sides[major] * planes_per_voxel,
            _ => (sides[major] - 1) * planes_per_voxel,
        };
        let base = |axis: usize, step: i128| {
            if borders != 0 {
                let [pixels, origin] = self.box_base(step, [sides[axis], planes], rates, borders == 1);
                return (pixels, origin);
            }
            let voxel = 1_i128 << 32;
            let n = if self.makes(Mistake::BaseOfExactStep) {
                ((planes - 1) * size[axis] + scale - 1) / scale
            } else {
                ((planes - 1) * step.abs() + voxel - 1) / voxel
            };
            let goes = if self.makes(Mistake::OriginOnOtherSide) {
                step < 0
            } else {
                step > 0
            };
            (sides[axis] + n, if goes { -n } else { 0 })
        };
        let ((columns, origin_i), (rows, origin_j)) = (base(i, step_i), base(j, step_j));
        vec![
            major as i128,
            i128::from(direction[major] < 0),
            step_i,
            step_j,
            nearest(1 << 32, planes_per_voxel),
            columns,
            rows,
            origin_i,
            origin_j,
            planes,
        ]
    }

    pub(super) fn start(&self, inputs: &dyn Numbers) -> Vec<i128> {
        let [origin, phase, rays] = ["origin", "phase", "rays_per_voxel"].map(|name| inputs.get(name));
        let offset = if self.makes(Mistake::StartTruncated) {
            (phase << 32) / rays
        } else {
            nearest(phase << 32, rays)
        };
        vec![(origin << 32) + offset]
    }

    /// The position on a plane.
    pub fn position(&self, start: i128, step: i128, plane: i128, at_nearest: bool) -> i128 {
        let exact = if self.makes(Mistake::StepOf16Bits) {
            start + plane * (((step + (1 << 15)) >> 16) << 16)
        } else {
            start + plane * step
        };
        let half = if self.makes(Mistake::PositionTruncated) {
            0
        } else if self.makes(Mistake::PositionHalvesDown) {
            (1 << 15) - 1
        } else {
            1 << 15
        };
        let position = (exact + half) >> 16;
        if at_nearest {
            let half = if self.makes(Mistake::NearestHalvesDown) {
                (1 << 15) - 1
            } else {
                1 << 15
            };
            (position + half) >> 16 << 16
        } else {
            position
        }
    }

    pub(super) fn location(&self, inputs: &dyn Numbers) -> Vec<i128> {
        let [start, step, plane] = ["start", "step", "plane"].map(|name| inputs.get(name));
        let position = self.position(start, step, plane, inputs.get("nearest") == 1);
        let [first, end] = self.extent(position, inputs.get("side"), inputs.get("pixels"));
        vec![position, position >> 16, position & 0xffff, first, end]
    }

    /// The pixels along an axis that have a sample, when pixel 0 lies at a position.
    pub fn extent(&self, position: i128, side: i128, pixels: i128) -> [i128; 2] {
        let (cell, mut weight) = (position >> 16, position & 0xffff);
        if self.makes(Mistake::ExistsBy12Bits) && self.width == Width::Paper {
            weight &= 0xfff0;
        }
        // Cells 0 to side - 2, and side - 1 where its weight is 0.
        let last = if weight == 0 && !self.makes(Mistake::LastVoxelLeftOut) {
            side - 1
        } else {
            side - 2
        };
        let first = (-cell).clamp(0, pixels);
        [first, (last - cell + 1).clamp(first, pixels)]
    }

    /// dT and dC of a plane.
    pub fn dither(&self, plane: i128) -> [i128; 2] {
        let start = if self.makes(Mistake::DitherWithoutStart) {
            0
        } else {
            9973
        };
        [(20251 * plane) % 32768, (13573 * plane + start) % 32768]
    }
}
