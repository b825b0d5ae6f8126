//! Location: where the samples of a plane lie.
//!
//! Source: Squeeze, section 4.6; the sum P0 + k V is formed in 32.32 and rounded once per plane, instead of being
//! accumulated in 16.16 (which drifts by a quarter of a voxel over 32,768 steps).
//!
//! | value | format | unit |
//! |---|---|---|
//! | start, step | s31.32 | voxels |
//! | position | s15.16 | voxels |
//!
//! `position(k) = (start + k * step + 2^15) >> 16`. Rounding: nearest, halves up. Error: at most
//! 0.5 + K * 2^-17 ulp after K planes, 0.75 at K = 2^15, and 2^-17 more for a phase that is no binary fraction. Overflow: none inside a `Plan`. State: none (random access
//! and streaming give the same number, because a product and a repeated sum are the same in integers).

use crate::borders::Borders;
use crate::format::{Position, Step, Weight};
use crate::plan::{Phase, Plan};

/// One sample plane of one phase: where the sample of pixel (0, 0) lies, counted from the first voxel that is held
/// ([`Plan::first`]). Pixel (i, j) lies (i, j) voxels further.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plane {
    /// Number of the plane, 0 nearest to the eye.
    pub index: u32,
    /// The interleaved image that it belongs to.
    pub phase: Phase,
    /// Position along i.
    pub x: Position,
    /// Position along j.
    pub y: Position,
    /// Position along k, slices; held to them.
    pub z: Position,
}

/// A position split into the voxel before it and the weight of the voxel behind it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// The voxel at or before the position.
    pub index: i32,
    /// Fraction of the way to the next voxel.
    pub weight: Weight,
}

/// Position after `k` steps. This function is the definition.
#[inline]
pub const fn position(start: Step, step: Step, k: u32) -> Position {
    let exact = start.to_bits() + k as i64 * step.to_bits();
    Position::from_bits(((exact + (1 << 15)) >> 16) as i32)
}

/// Position in the middle of a segment, after `halves` half steps: of segment k, 2 k + 1; `offset` 2^-36 voxel behind the start
/// ([`Plan::offset`]). This function is the definition.
#[inline]
pub const fn middle(start: Step, offset: i64, step: Step, halves: i64) -> Position {
    let exact = ((2 * start.to_bits() + halves * step.to_bits()) << 3) + offset;
    Position::from_bits(((exact + (1 << 19)) >> 20) as i32)
}

/// The position of a plan's samples on the plane with this number, before it is settled.
const fn on_plane(plan: &Plan, start: Step, offset: i64, step: Step, index: u32) -> Position {
    let halves = 2 * index as i64 + 1;
    match plan.borders() {
        Borders::Whole => position(start, step, index),
        Borders::Nodes => middle(start, offset, step, halves),
        // The first segment begins half a voxel before the first slice.
        Borders::Cells => middle(start, offset, step, halves - plan.sampling().planes_per_voxel as i64),
    }
}

/// The position of a plan's samples: as it is, or at the nearest voxel, halves up.
#[inline]
pub const fn settled(plan: &Plan, position: Position) -> Position {
    if plan.is_nearest() {
        Position::from_bits((position.to_bits() + (1 << 15)) & !0xffff)
    } else {
        position
    }
}

/// Splits a position.
#[inline]
pub const fn cell(position: Position) -> Cell {
    let bits = position.to_bits();
    Cell {
        index: bits >> 16,
        weight: Weight::from_bits((bits & 0xffff) as u32),
    }
}

/// Where segments are cut that begin at the plane with this number at which segments end: pixel (0, 0)'s positions along i, j
/// and, held to the slices, k; at a part of the segment, 0 to 65536 ([`WHOLE`](crate::borders::WHOLE)), which is the next such
/// plane. This function is the definition.
pub fn cut(plan: &Plan, phase: Phase, index: u32, part: u32) -> [Position; 3] {
    let [start_i, start_j] = plan.start(phase);
    let [step_i, step_j, step_k] = plan.step();
    let steps = i64::from(index) - i64::from(plan.ends_before());
    let [beside_i, beside_j] = plan.offset();
    let at = |start: Step, offset: i64, step: Step| {
        let way = (i64::from(part) * step.to_bits() + (1 << 15)) >> 16;
        let exact = ((start.to_bits() + steps * step.to_bits() + way) << 4) + offset;
        settled(plan, Position::from_bits(((exact + (1 << 19)) >> 20) as i32))
    };
    let (x, y) = (at(start_i, beside_i, step_i), at(start_j, beside_j, step_j));
    in_held(plan, [x, y, at(Step::ZERO, 0, step_k)])
}

/// The plane with this number at which segments end, 0 to [`Plan::ends`] - 1.
pub fn end_plane(plan: &Plan, phase: Phase, index: u32) -> Plane {
    let [x, y, z] = cut(plan, phase, index, 0);
    Plane { index, phase, x, y, z }
}

/// A position in the volume, its place along k held to the slices, counted from the first voxel that is held.
fn in_held(plan: &Plan, [x, y, z]: [Position; 3]) -> [Position; 3] {
    let ([_, _, depth], [i, j, k]) = (plan.volume(), plan.first());
    let last = (depth as i32 - 1) << 16;
    let from = |bits: i32, first: u32| Position::from_bits(bits.wrapping_sub((first as i32) << 16));
    [
        from(x.to_bits(), i),
        from(y.to_bits(), j),
        // Only cells reach beyond the slices.
        from(z.to_bits().min(last).max(0), k),
    ]
}

/// The sample plane with this number.
pub fn plane(plan: &Plan, phase: Phase, index: u32) -> Plane {
    let [start_i, start_j] = plan.start(phase);
    let [step_i, step_j, step_k] = plan.step();
    let [beside_i, beside_j] = plan.offset();
    let at = |start, offset, step| settled(plan, on_plane(plan, start, offset, step, index));
    let (x, y) = (at(start_i, beside_i, step_i), at(start_j, beside_j, step_j));
    let [x, y, z] = in_held(plan, [x, y, at(Step::ZERO, 0, step_k)]);
    Plane { index, phase, x, y, z }
}

/// The pixels along one side whose samples lie inside `side` voxels: `first .. end`, both within `0 ..= pixels`.
///
/// A sample is inside from the first voxel to the last, both included: cell 0 to side - 2, and side - 1 when its
/// weight is zero.
pub fn inside(at: Cell, side: u32, pixels: u32) -> core::ops::Range<u32> {
    let cells = i64::from(side) - i64::from(at.weight != Weight::ZERO);
    let clamp = |p: i64| p.clamp(0, i64::from(pixels)) as u32;
    let first = clamp(-i64::from(at.index));
    first..clamp(cells - i64::from(at.index)).max(first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::Direction;
    use crate::plan::{Sampling, Spacing};
    use crate::view::View;
    use proptest::prelude::*;

    /// To the nearest voxel, halves up, along all three axes.
    #[test]
    fn nearest_samples_lie_at_voxels() {
        let direction = [300, -200, 1000].map(|c| Direction::from_bits(c << 40));
        let sampling = Sampling {
            planes_per_voxel: 4,
            rays_per_voxel: 3,
        };
        let linear = Plan::whole(View::new(direction).unwrap(), [9, 8, 7], Spacing::CUBIC, sampling).unwrap();
        let nearest = linear.with_nearest();
        let mut halves = 0;
        for index in 0..linear.planes() {
            for number in 0..linear.phases() {
                let [exact, settled] = [linear, nearest].map(|plan| plane(&plan, plan.phase(number), index));
                for (exact, settled) in [(exact.x, settled.x), (exact.y, settled.y), (exact.z, settled.z)] {
                    assert_eq!(cell(settled).weight, Weight::ZERO);
                    let away = settled.to_bits() - exact.to_bits();
                    assert!((-0x7fff..=0x8000).contains(&away), "{away}");
                    halves += usize::from(away == 0x8000);
                }
            }
        }
        assert!(halves > 5);
    }

    #[test]
    fn inside_covers_the_closed_volume() {
        let at = |index, bits| Cell {
            index,
            weight: Weight::from_bits(bits),
        };
        assert_eq!(inside(at(0, 0), 4, 10), 0..4);
        assert_eq!(inside(at(0, 1), 4, 10), 0..3);
        assert_eq!(inside(at(-2, 1), 4, 10), 2..5);
        assert_eq!(inside(at(3, 0), 4, 10), 0..1);
        assert_eq!(inside(at(3, 1), 4, 10), 0..0);
        assert_eq!(inside(at(-20, 0), 4, 10), 10..10);
        assert_eq!(inside(at(0, 0), 1, 1), 0..1);
        assert_eq!(inside(at(0, 5), 1, 1), 0..0);
    }

    proptest! {
        #[test]
        fn error_stays_below_three_quarters_of_an_ulp(
            slope in -1.0f64..=1.0, origin in -8192i32..=0, k in 0u32..=32768, rate in 1u32..=16,
        ) {
            // As far as the longest volume reaches.
            prop_assume!(k <= 8191 * rate);
            let step = slope / f64::from(rate);
            let bits = (step * 4294967296.0).round() as i64;
            let start = Step::from_bits(i64::from(origin) << 32);
            let p = position(start, Step::from_bits(bits), k);
            // The exact sum, in units of 2^-16, split so that f64 keeps its fraction.
            let exact = f64::from(origin) * 65536.0 + f64::from(k) * step * 65536.0;
            prop_assert!((f64::from(p.to_bits()) - exact).abs() <= 0.75 + 1e-5);
        }

        #[test]
        fn the_last_plane_lies_on_the_last_slice(depth in 1u32..=2049, rate in 1u32..=16) {
            let view = View::new([Direction::ZERO, Direction::ZERO, Direction::from_bits(1 << 50)]).unwrap();
            let sampling = Sampling { planes_per_voxel: rate, rays_per_voxel: 1 };
            let plan = Plan::whole(view, [3, 2, depth], Spacing::CUBIC, sampling).unwrap();
            let last = plane(&plan, Phase::default(), plan.planes() - 1);
            prop_assert_eq!(cell(last.z), Cell { index: depth as i32 - 1, weight: Weight::ZERO });
        }
    }
}
