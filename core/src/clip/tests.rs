use super::*;
use crate::borders::fraction_of;
use crate::format::{Direction, Opacity};
use crate::lanes::Small;
use crate::plan::{Sampling, Spacing};
use crate::view::View;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use std::vec::Vec;

fn config(cases: u32, seed: u64) -> ProptestConfig {
    ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(seed),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

fn plan(direction: [i64; 3], dims: [u32; 3], rates: [u32; 2], borders: Borders) -> Option<Plan> {
    let view = View::new(direction.map(|c| Direction::from_bits(c << 28))).ok()?;
    let [planes_per_voxel, rays_per_voxel] = rates;
    let sampling = Sampling {
        planes_per_voxel,
        rays_per_voxel,
    };
    Plan::with_borders(view, dims, Spacing::CUBIC, sampling, borders).ok()
}

fn slopes() -> impl Strategy<Value = [i32; 3]> {
    let one = 1i32 << 30;
    prop_oneof![
        Just([one, 0, 0]),
        Just([0, 0, -one]),
        Just([one / 2, -one, one / 4]),
        Just([1, 0, 0]),
        prop::array::uniform3(-one..=one),
    ]
    .prop_filter("a normal", |slope| *slope != [0; 3])
}

fn clip() -> impl Strategy<Value = Clip> {
    let length = prop_oneof![Just(0i64), 1i64..1 << 29, 1i64 << 29..1 << 34, Just(1 << 46)];
    let distance = prop_oneof![Just(0i64), -(1i64 << 34)..1 << 34, Just(1 << 46), Just(-(1 << 46))];
    (slopes(), distance, length.clone(), length, any::<bool>()).prop_map(
        |(slope, distance, thickness, falloff, outside)| Clip {
            slope: slope.map(Vector::from_bits),
            distance: Distance::from_bits(distance),
            thickness: (thickness > 0).then(|| Distance::from_bits(thickness)),
            falloff: Distance::from_bits(falloff),
            outside,
        },
    )
}

fn frame() -> impl Strategy<Value = (Plan, Vec<Clip>)> {
    let direction = prop_oneof![
        prop::array::uniform3(-3i64..=3),
        prop::array::uniform3(-(1i64 << 30)..=1 << 30),
        Just([1, 0, 1 << 30]),
    ];
    let borders = prop_oneof![Just(Borders::Whole), Just(Borders::Cells), Just(Borders::Nodes)];
    let dims = prop::array::uniform3(2u32..=9);
    let long = prop_oneof![4 => dims, 1 => Just([8192, 3, 2]), 1 => Just([2, 3, 2000])];
    (
        direction,
        long,
        [1u32..=16, 1u32..=3],
        borders,
        prop::collection::vec(clip(), 1..=3),
    )
        .prop_filter_map("a plan", |(direction, dims, rates, borders, clips)| {
            Some((plan(direction, dims, rates, borders)?, clips))
        })
}

proptest! {
    #![proptest_config(config(3000, 3)) ]

    /// Runs and pieces of a row are the definition, column by column; rows said to be empty are.
    #[test]
    fn pieces_are_the_definition((plan, clips) in frame(), place in any::<[u32; 4]>(), slabs in any::<bool>()) {
        let clips = Clips::new(&plan, &clips).unwrap();
        let [a, b, c, d] = place;
        let [columns, rows] = plan.base();
        let (phase, index) = (plan.phase(a % plan.phases()), b % plan.planes().max(1) + u32::from(slabs));
        let (row, first) = (c % rows, (d % columns) as usize);
        let distances = clips.distances(&plan, phase, index, slabs);
        let boxed = Boxed {
            columns: first..(first + 40).min(columns as usize),
            part: Part { from: 100, to: 60_000 },
            ends: [Some(Part { from: 0, to: 9 }), None],
        };
        let mut expected = Vec::new();
        for (n, column) in boxed.columns.clone().enumerate() {
            let mut left = Remainder::WHOLE;
            for (plane, ends) in clips.planes().iter().zip(&distances) {
                let [i, j, _] = plane.slope;
                let own = ends.map(|end| end + i * column as i64 + j * i64::from(row));
                left = left.and(plane.cut(own));
            }
            let part = if n == 0 { Part { from: 0, to: 9 } } else { boxed.part };
            expected.push(left.of(part));
        }
        let mut found = Vec::new();
        clips.each(&distances, &boxed, (row, 0..boxed.columns.len()), &mut |run, left| {
            assert_eq!(run.start, found.len());
            found.extend(run.map(|_| left));
        });
        prop_assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(&expected) {
            if expected.weight() == 0 || found.weight() == 0 {
                prop_assert_eq!(found.weight(), expected.weight());
            } else {
                prop_assert_eq!(found, expected);
            }
        }
        let [touched, cut] = clips.reach(&distances, &boxed, row);
        for (column, left) in boxed.columns.clone().zip(&expected) {
            prop_assert!(left.weight() == 0 || touched.contains(&column));
            let doubtful = cut.contains(&column) || !touched.contains(&column);
            prop_assert!(*left == Remainder::WHOLE || doubtful, "{:?} at {}", left, column);
        }
    }

    /// What is said of some rows is true of each of their segments, and opacities are weighed by the definition, in any lanes.
    #[test]
    fn rows_are_left_as_their_segments_are(
        (plan, clips) in frame(), place in any::<[u32; 4]>(), count in 1u32..=9, slabs in any::<bool>(),
        opacities in prop::collection::vec(prop_oneof![Just(0i32), Just(i32::MIN), 0..=i32::MAX], 90),
    ) {
        let clips = Clips::new(&plan, &clips).unwrap();
        let [a, b, c, d] = place;
        let [columns, rows] = plan.base();
        let (phase, index) = (plan.phase(a % plan.phases()), b % plan.planes().max(1) + u32::from(slabs));
        let (row, first) = (c % rows, (d % columns) as usize);
        let rows = row..(row + count).min(rows);
        let boxed = Boxed {
            columns: first..(first + 90).min(columns as usize),
            part: Part::WHOLE,
            ends: [None; 2],
        };
        let distances = clips.distances(&plan, phase, index, slabs);
        let left = clips.left(&distances, &boxed.columns, &rows);
        for row in rows {
            let mut weights = Vec::new();
            clips.each(&distances, &boxed, (row, 0..boxed.columns.len()), &mut |run, rest| {
                weights.extend(run.map(|_| rest.weight()));
                assert!(!left.whole || rest == Remainder::WHOLE, "{rest:?} of {clips:?}");
            });
            for (column, weight) in boxed.columns.clone().zip(&weights) {
                prop_assert!(*weight == 0 || left.columns.contains(&column), "{} of {:?}", column, left.columns);
            }
            let expected: Vec<i32> = opacities.iter().zip(&weights).map(|(opacity, weight)| match weight {
                0 => 0,
                weight => fraction_of(Opacity::from_bits(*opacity as u32), *weight).to_bits() as i32,
            }).collect();
            for clips in [clips.clone(), clips.clone().in_lanes::<Small>(), clips.clone().in_lanes::<i32>()] {
                let mut found = opacities[..weights.len()].to_vec();
                clips.weigh(&distances, &boxed, (row, 0..weights.len()), &mut found);
                prop_assert_eq!(&found, &expected);
                // Some columns alone.
                let span = weights.len() / 3..weights.len();
                let mut found = opacities[span.clone()].to_vec();
                clips.weigh(&distances, &boxed, (row, span.clone()), &mut found);
                prop_assert_eq!(&found, &expected[span]);
            }
        }
    }

    /// What is hidden of a box is hidden of all segments in it; and a box around a whole side is.
    #[test]
    fn boxes_that_are_hidden_hide_their_segments((plan, clips) in frame(), low in prop::array::uniform3(-3i64..9), side in prop::array::uniform3(0i64..4)) {
        let clips = Clips::new(&plan, &clips).unwrap();
        let high = [0, 1, 2].map(|axis| low[axis] + side[axis]);
        let corners: Vec<[i64; 3]> = (0..8).map(|n| [0, 1, 2].map(|axis| if n >> axis & 1 == 0 { low[axis] } else { high[axis] })).collect();
        let distance = |plane: &ClipPlane, at: [i64; 3]| {
            plane.distance + plane.slope.iter().zip(at).map(|(slope, at)| slope * at).sum::<i64>()
        };
        let hidden = clips.hides(low, high);
        let gone = |plane: &ClipPlane| corners.iter().all(|a| {
            corners.iter().all(|b| plane.cut([distance(plane, *a), distance(plane, *b)]).weight() == 0)
        });
        if hidden {
            prop_assert!(clips.planes().iter().any(gone), "{:?} {:?}", clips, low);
        }
        // The other way, for half spaces.
        if clips.planes().iter().any(|plane| plane.thickness == 0 && !plane.is_outside() && gone(plane)) {
            prop_assert!(hidden);
        }
    }

    /// What hard faces leave of a ray is its length behind them, and a soft plane and its outside are the whole.
    #[test]
    fn rays_have_their_lengths((plan, clips) in frame(), place in any::<[u32; 2]>()) {
        let [phase, _] = place.map(|n| n % plan.phases());
        let phase = plan.phase(phase);
        for clip in clips {
            let sums = [false, true].map(|outside| {
                let clips = Clips::new(&plan, &[Clip { outside, ..clip }]).unwrap();
                let plane = clips.planes()[0];
                let mut sum = 0;
                for index in 0..plan.planes() {
                    let [ends, ..] = clips.distances(&plan, phase, index, false);
                    sum += u64::from(plane.cut(ends).weight());
                }
                sum
            });
            let whole = u64::from(plan.planes()) << 16;
            prop_assert!(sums.iter().sum::<u64>().abs_diff(whole) <= 2, "{:?} of {}", sums, whole);
            if clip.falloff != Distance::ZERO {
                continue;
            }
            // The ends of the whole ray, and where its distance passes 0 and the thickness.
            let clips = Clips::new(&plan, &[Clip { outside: false, ..clip }]).unwrap();
            let plane = clips.planes()[0];
            let end = |index| clips.distances(&plan, phase, index, false)[0];
            let ([from, _], [_, to]) = (end(0), end(plan.planes() - 1));
            let way = (to - from) as f64;
            let place = |face: f64| if way == 0.0 { f64::NAN } else { ((face - from as f64) / way).clamp(0.0, 1.0) };
            let far = if plane.thickness > 0 { plane.thickness as f64 } else { 1e300 };
            if way.abs() < 1e6 {
                continue;
            }
            let (a, b) = (place(0.0), place(far));
            let length = (b - a).abs() * f64::from(plan.planes());
            let found = sums[0] as f64 / 65536.0;
            // Distances are rounded down to 2^-30 a term: as far as that is along the ray, and each face once.
            let slack = 8.0 * f64::from(plan.planes()) / way.abs() * 3.0 + 2.0 / 65536.0;
            prop_assert!((found - length).abs() <= slack, "{} instead of {} ({})", found, length, slack);
        }
    }
}

/// A ramp's share is the nearest but for one, whatever its width.
#[test]
fn ramps_are_straight() {
    for falloff in [1, 2, 3, 1000, (1 << 30) - 1, 1 << 30, (1 << 46) - 7, 1 << 46] {
        let ramp = Ramp::of(falloff);
        for n in 0..=1000i64 {
            let sum = (i128::from(2 * falloff) * i128::from(n) / 1000) as i64;
            let exact = (i128::from(sum) * 65536 + i128::from(falloff)) / i128::from(2 * falloff);
            assert!((i128::from(ramp.share(sum)) - exact).abs() <= 1, "{falloff} {n}");
        }
        assert_eq!((ramp.share(-1), ramp.share(0), ramp.share(2 * falloff)), (0, 0, WHOLE));
    }
}

#[test]
fn planes_that_are_none_are_named() {
    let plan = plan([1, 2, 3], [5, 6, 7], [1, 1], Borders::Cells).unwrap();
    let good = Clip {
        slope: [Vector::from_bits(1 << 30), Vector::ZERO, Vector::ZERO],
        distance: Distance::ZERO,
        thickness: None,
        falloff: Distance::ZERO,
        outside: false,
    };
    let made = |clips: &[Clip]| Clips::new(&plan, clips).map(|clips| clips.planes().len());
    assert_eq!(made(&[good; 6]), Ok(6));
    assert_eq!(made(&[good; 7]), Err(ClipError::TooMany { given: 7 }));
    let none = Clip {
        slope: [Vector::ZERO; 3],
        ..good
    };
    assert_eq!(made(&[good, none]), Err(ClipError::NoNormal { number: 1 }));
    let steep = Clip {
        slope: [Vector::from_bits(-(1 << 30) - 1); 3],
        ..good
    };
    assert_eq!(made(&[steep]), Err(ClipError::Slope { number: 0 }));
    for thickness in [0, -5] {
        let thin = Clip {
            thickness: Some(Distance::from_bits(thickness)),
            ..good
        };
        assert_eq!(made(&[thin]), Err(ClipError::Length { number: 0 }));
    }
}

/// A colour that has turned as far as it can is the other, and one that has not is itself.
#[test]
fn colours_turn_all_the_way() {
    let plan = plan([0, 0, 1], [5, 6, 7], [1, 1], Borders::Cells).unwrap();
    let cue = Cue {
        slope: [Vector::ZERO, Vector::ZERO, Vector::from_bits(1 << 30)],
        distance: Distance::from_bits(-1 << 30),
        depth: Distance::from_bits(2 << 30),
        most: WHOLE,
        colour: [Intensity::ONE, Intensity::ZERO, Intensity::from_bits(12_345)],
    };
    let clips = Clips::new(&plan, &[]).unwrap().with_cue(&plan, &cue).unwrap();
    let cue = clips.cue().unwrap();
    for (bits, one) in [(15, 1u32 << 15), (31, 1 << 31)] {
        let own = [0, one, one / 3];
        assert_eq!(cue.turned(own, bits, 0), own);
        assert_eq!(cue.turned(own, bits, WHOLE), [one, 0, 12_345 << (bits - 15)]);
        assert_eq!(cue.turned(own, bits, WHOLE / 2)[..2], [one / 2, one / 2]);
    }
    // Rows are the definition, in any lanes.
    for bits in [12, 15, 31] {
        let shares: Vec<i32> = (0..=256).map(|n| n * 256).collect();
        for own in [0, 1, 77, 1u32 << bits >> 1, (1 << bits) - 1, 1 << bits] {
            for (channel, other) in cue.target(bits).into_iter().enumerate() {
                let mut rows = [(); 2].map(|()| std::vec![own as i32; shares.len()]);
                let [one, small] = &mut rows;
                super::cue::turn_by::<i32>(one, other, &shares);
                super::cue::turn_by::<Small>(small, other, &shares);
                for (at, share) in shares.iter().enumerate() {
                    let expected = cue.turned([own; 3], bits, *share as u32)[channel];
                    assert_eq!(
                        [one[at] as u32, small[at] as u32],
                        [expected; 2],
                        "{own} {share} {bits}"
                    );
                }
            }
        }
    }
    // Depths -1.5 to 5.5 from the box's front face on, of which 0 to 2 turn.
    let shares: Vec<_> = (0..7)
        .map(|index| cue.share(clips.distances(&plan, plan.phase(0), index, false)[CLIPS_MAX]))
        .collect();
    assert_eq!(shares, [0, 0, WHOLE / 2, WHOLE, WHOLE, WHOLE, WHOLE]);
}
