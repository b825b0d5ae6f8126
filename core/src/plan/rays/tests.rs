use super::*;
use crate::borders::Part;
use crate::crop::Crop;
use crate::format::{Direction, Position};
use crate::locate::{cut, plane};
use crate::plan::{Sampling, Spacing};
use crate::sides::Side;
use crate::sides::about_k;
use crate::sides::along_k;
use crate::view::View;
use proptest::prelude::*;
use std::vec::Vec;

/// A view along z or against it, with shears of none, one, the shortest step, or any.
fn direction() -> impl Strategy<Value = [i64; 3]> {
    let one = 1i64 << 58;
    let shear = || {
        prop_oneof![
            2 => Just(0),
            1 => Just(one),
            1 => Just(-one),
            1 => (-3i64..=3).prop_map(|bits| bits << 26),
            4 => -one..=one,
        ]
    };
    (shear(), shear(), prop_oneof![Just(one), Just(-one)]).prop_map(|(i, j, k)| [i, j, k])
}

fn plan(direction: [i64; 3], dims: [u32; 3], [planes, rays]: [u32; 2]) -> Plan {
    let sampling = Sampling {
        planes_per_voxel: planes,
        rays_per_voxel: rays,
    };
    let view = View::new(direction.map(Direction::from_bits)).unwrap();
    Plan::new(view, dims, Spacing::CUBIC, sampling).unwrap()
}

/// The faces of finest voxels `from .. to` on a level's scale.
fn crop(ranges: [[u32; 2]; 3], level: u32) -> Crop {
    let face = |end: usize| ranges.map(|range| Position::from_bits(((range[end] << 16 >> level) as i32) - (1 << 15)));
    Crop {
        low: face(0),
        high: face(1),
    }
}

/// A volume cut once along each axis, at multiples of 8 or not at all, and the level of each of the eight boxes.
type Boxes = Vec<([[u32; 2]; 3], u32)>;

fn boxes(dims: [u32; 3], cuts: [u32; 3], levels: [u32; 8]) -> Boxes {
    let sides = [0, 1, 2].map(|axis| {
        let cut = (cuts[axis] * 8).min(dims[axis]);
        [[0, cut], [cut, dims[axis]]]
    });
    let all = (0..8).map(|n| ([0, 1, 2].map(|axis| sides[axis][n >> axis & 1]), levels[n]));
    all.filter(|(ranges, _)| ranges.iter().all(|[from, to]| from < to))
        .collect()
}

/// The plans of a box: one for each of the rays that lie side by side in a voxel of its level.
fn bundles(finest: &Plan, dims: [u32; 3], (ranges, level): ([[u32; 2]; 3], u32)) -> Vec<(Rays, Plan)> {
    let rates = [finest.sampling().planes_per_voxel, 1];
    let direction = finest.view().direction().map(|c| c.to_bits());
    let coarse = plan(direction, dims.map(|side| side.div_ceil(1 << level)), rates);
    let coarse = coarse.with_crop(crop(ranges, level)).unwrap();
    let mut all = Vec::new();
    for phase in (0..finest.phases()).map(|number| finest.phase(number)) {
        for first in (0..1 << (2 * level)).map(|n| [n & ((1 << level) - 1), n >> level]) {
            let [across, down] = [0, 1].map(|axis| {
                let left = finest.base()[axis].saturating_sub(first[axis]);
                left.div_ceil(1 << level)
            });
            if across > 0 && down > 0 {
                let rays = Rays {
                    phase,
                    first,
                    count: [across, down],
                };
                all.push((rays, coarse.of_rays(finest, level, rays).unwrap()));
            }
        }
    }
    all
}

/// The length of each ray of a plan in the box of its volume, segments; phase after phase, row after row.
fn lengths(finest: &Plan) -> Vec<f64> {
    let [columns, rows] = finest.base();
    let mut all = Vec::new();
    let rate = f64::from(finest.sampling().planes_per_voxel);
    for phase in (0..finest.phases()).map(|number| finest.phase(number)) {
        for (v, u) in (0..rows).flat_map(|v| (0..columns).map(move |u| (v, u))) {
            let (mut from, mut to) = (0.0f64, f64::from(finest.planes()));
            for (axis, pixel) in [u, v].into_iter().enumerate() {
                let step = finest.step()[axis].to_bits() as f64 / 4_294_967_296.0;
                let first =
                    finest.start(phase)[axis].to_bits() as f64 / 4_294_967_296.0 + f64::from(pixel) - rate * step / 2.0;
                let side = [-0.5, f64::from(finest.volume()[axis]) - 0.5];
                if step == 0.0 {
                    if !(side[0]..=side[1]).contains(&first) {
                        to = from;
                    }
                    continue;
                }
                let [a, b] = side.map(|face| (face - first) / step);
                (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
            }
            all.push((to - from).max(0.0));
        }
    }
    all
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 250, rng_seed: proptest::test_runner::RngSeed::Fixed(12), ..ProptestConfig::default() })]

    /// What all boxes have of a ray adds up to its length, whatever their levels: samples' segments, and those between samples.
    #[test]
    fn boxes_of_all_levels_have_the_whole_ray(
        direction in direction(),
        dims in prop::array::uniform3(1u32..=13),
        rates in [1u32..=3, 1u32..=3],
        cuts in prop::array::uniform3(0u32..=1),
        levels in prop::array::uniform8(0u32..=3),
    ) {
        let finest = plan(direction, dims, rates);
        let [columns, rows] = finest.base().map(|side| side as usize);
        let exact = lengths(&finest);
        let mut sums = [exact.iter().map(|_| 0u64).collect::<Vec<_>>(), exact.iter().map(|_| 0u64).collect()];
        // Ulp that a ray may lack, one a box that it meets, of the box's segments.
        let mut ulps = exact.iter().map(|_| 0u64).collect::<Vec<_>>();
        for (ranges, level) in boxes(dims, cuts, levels) {
            for (Rays { phase, first, .. }, plan) in bundles(&finest, dims, (ranges, level)) {
                let [start_i, start_j] = plan.start(Phase::default());
                let [across, down] = plan.base();
                for (v, u) in (0..down).flat_map(|v| (0..across).map(move |u| (v, u))) {
                    let about = |index: u32| {
                        let part = Side::of(&plan, start_i, 0, index).part(u);
                        part.and(Side::of(&plan, start_j, 1, index).part(v)).and(about_k(&plan, index))
                    };
                    let behind = |index: u32| {
                        let part = Side::behind(&plan, start_i, 0, index).part(u);
                        part.and(Side::behind(&plan, start_j, 1, index).part(v)).and(along_k(&plan, index))
                    };
                    let sum = |parts: &mut dyn Iterator<Item = Part>| parts.map(|part| u64::from(part.length())).sum::<u64>() << level;
                    let found = [sum(&mut plan.planes_met().map(about)), sum(&mut (plan.ends_met().start..plan.ends_met().end - 1).map(behind))];
                    let number = (phase.v * rates[1] + phase.u) as usize;
                    let [x, y] = [(first[0] + (u << level)) as usize, (first[1] + (v << level)) as usize];
                    let at = (number * rows + y) * columns + x;
                    for (sums, found) in sums.iter_mut().zip(found) {
                        sums[at] += found;
                    }
                    ulps[at] += u64::from(found != [0; 2]) << level;
                }
            }
        }
        for sums in sums {
            for (at, (sum, exact)) in sums.iter().zip(&exact).enumerate() {
                let away = (*sum as f64 - exact * 65536.0).abs();
                prop_assert!(away <= ulps[at] as f64 + 0.01, "ray {}: {} of {}", at, sum, exact * 65536.0);
            }
        }
    }

    /// A level's samples lie on the finest plan's rays, to the rounding of a position; of level 0 they are its own.
    #[test]
    fn samples_of_a_level_lie_on_the_same_rays(
        direction in direction(),
        dims in prop::array::uniform3(1u32..=13),
        rates in [1u32..=4, 1u32..=8],
        level in 0u32..=3,
    ) {
        let finest = plan(direction, dims, rates);
        let ranges = dims.map(|side| [0, side]);
        for (Rays { phase, first, .. }, of_level) in bundles(&finest, dims, (ranges, level)) {
            let before = if direction[2] < 0 { (of_level.volume()[2] << level) - dims[2] } else { 0 };
            let exact = |axis: usize, halves: i128| {
                // From the front face of the finest box, in 2^-33 of its voxels.
                let (start, step) = (finest.start(phase)[axis].to_bits(), finest.step()[axis].to_bits());
                let from_front = halves - i128::from(2 * before * rates[0]) - i128::from(rates[0]);
                let fine = 2 * i128::from(start) + (i128::from(first[axis]) << 33) + from_front * i128::from(step);
                let coarse = fine + (1 << 32) - (1 << (32 + level));
                ((coarse + (1 << (16 + level))) >> (17 + level)) as i32
            };
            for index in 0..of_level.planes() {
                let at = plane(&of_level, Phase::default(), index);
                let halves = i128::from(2 * index + 1) << level;
                prop_assert_eq!([at.x.to_bits(), at.y.to_bits()], [exact(0, halves), exact(1, halves)]);
                if level == 0 {
                    let own = plane(&finest, phase, index);
                    prop_assert_eq!(own.z, at.z);
                    let pixel = first.map(|pixel| (pixel as i32) << 16);
                    prop_assert_eq!([own.x.to_bits() + pixel[0], own.y.to_bits() + pixel[1]], [at.x.to_bits(), at.y.to_bits()]);
                }
            }
            // Ends follow one another on it too.
            for index in 0..of_level.ends() - 1 {
                prop_assert_eq!(cut(&of_level, Phase::default(), index, 65536), cut(&of_level, Phase::default(), index + 1, 0));
            }
        }
    }
}

/// A ray along the face of two boxes is in one of them, at every level; along the volume's own face it counts.
#[test]
fn rays_along_a_seam_count_once() {
    let one = 1i64 << 58;
    let finest = plan([0, 0, one], [16, 16, 8], [1, 2]);
    // The phase that starts half a voxel behind the first runs along all faces.
    let along = |level: u32, ranges: [[u32; 2]; 3]| {
        let mut met = Vec::new();
        for (Rays { phase, first, .. }, plan) in bundles(&finest, [16, 16, 8], (ranges, level)) {
            let side = Side::of(&plan, plan.start(Phase::default())[0], 0, 0);
            let pixels = (0..plan.base()[0]).filter(|pixel| side.part(*pixel).length() > 0);
            let places = pixels.map(|pixel| 2 * (first[0] + (pixel << level)) + phase.u);
            met.extend(places.filter(|_| phase.v == 0 && first[1] == 0));
        }
        met.sort_unstable();
        met
    };
    // Half voxels from half a voxel before the first: base planes begin a whole voxel before it.
    let [low, high] = [[0, 8], [8, 16]];
    let (all, deep) = ([0, 16], [0, 8]);
    for levels in [[0, 0], [0, 1], [2, 0], [3, 1]] {
        let mut met = along(levels[0], [low, all, deep]);
        met.extend(along(levels[1], [high, all, deep]));
        let whole = along(0, [all, all, deep]);
        assert_eq!(met, whole, "{levels:?}");
        assert_eq!(whole.len(), 33);
    }
}

#[test]
fn what_is_no_level_is_refused() {
    let one = 1i64 << 58;
    let finest = plan([one / 3, 0, one], [9, 9, 9], [2, 1]);
    let level = plan([one / 3, 0, one], [5, 5, 5], [2, 1]);
    let rays = Rays {
        phase: Phase::default(),
        first: [0, 0],
        count: [2, 2],
    };
    assert!(level.of_rays(&finest, 1, rays).is_ok());
    assert_eq!(level.of_rays(&finest, 4, rays), Err(LevelError::Level { given: 4 }));
    assert_eq!(level.of_rays(&finest, 0, rays), Err(LevelError::Other));
    assert_eq!(level.of_rays(&finest, 2, rays), Err(LevelError::Other));
    for other in [
        plan([one / 4, 0, one], [5, 5, 5], [2, 1]),
        plan([one / 3, 0, -one], [5, 5, 5], [2, 1]),
        plan([one / 3, 0, one], [5, 5, 5], [4, 1]),
        plan([one / 3, 0, one], [5, 6, 5], [2, 1]),
        level.with_nearest(),
    ] {
        assert_eq!(other.of_rays(&finest, 1, rays), Err(LevelError::Other));
    }
    let [columns, rows] = finest.base();
    for wrong in [
        Rays { count: [0, 1], ..rays },
        Rays {
            first: [columns, 0],
            count: [1, 1],
            ..rays
        },
        Rays {
            first: [0, 1],
            count: [1, rows],
            ..rays
        },
    ] {
        let expected = LevelError::Rays { base: finest.base() };
        assert_eq!(level.of_rays(&finest, 1, wrong), Err(expected));
    }
    let whole = Plan::whole(*finest.view(), [5; 3], Spacing::CUBIC, finest.sampling()).unwrap();
    assert_eq!(whole.of_rays(&finest, 1, rays), Err(LevelError::Borders));
    assert_eq!(level.of_rays(&whole, 1, rays), Err(LevelError::Borders));
}
