//! The integer pyramid against the f64 model, level after level.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use slicecast_model::pyramid::{Halving, Voxel};
use slicecast_pyramid::filter::Filter;
use slicecast_pyramid::pyramid::{By, next};
use slicecast_pyramid::volume::{RgbaVolume, Voxels};
use slicecast_pyramid::voxel::{Codes, MAX_CODE};
use slicecast_volume::decoded::Orientation;

fn volume(dims: [usize; 3], codes: Vec<Codes>) -> RgbaVolume {
    RgbaVolume {
        name: "t".into(),
        dims,
        spacing: [1.0; 3],
        orientation: Orientation::Unknown,
        tau_max: 4.0,
        alpha_distance: None,
        voxels: Voxels::Codes(codes),
    }
}

fn real(volume: &RgbaVolume) -> Vec<Voxel> {
    (0..volume.voxels.len())
        .map(|index| volume.voxels.codes(index).map(f64::from))
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig {
        rng_seed: RngSeed::Fixed(1704), failure_persistence: None, ..ProptestConfig::with_cases(150)
    })]

    /// Extinctions err by less than an ulp a level, colours by less than two; errors of the levels below are averaged.
    #[test]
    fn levels_are_those_of_the_model(
        filter in (0..4_usize).prop_map(|index| Filter::ALL[index]),
        dims in [1..20_usize, 1..20_usize, 1..12_usize],
        seed in any::<u64>(),
    ) {
        let mut state = seed | 1;
        let mut random = |bound: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % bound
        };
        let codes: Vec<Codes> = (0..dims.iter().product())
            .map(|_| {
                let tau = match random(4) {
                    0 => 0,
                    1 => random(8),
                    _ => random(u64::from(MAX_CODE) + 1),
                };
                let colour = [(); 3].map(|()| random(tau + 1) as u16);
                [colour[0], colour[1], colour[2], tau as u16]
            })
            .collect();
        let weights: Vec<f64> = filter.weights().iter().map(|w| f64::from(*w)).collect();
        let halving = Halving { weights: &weights, on_nodes: filter.on_nodes() };
        let mut level = volume(dims, codes);
        let mut model = (dims, real(&level));
        let mut depth = 0.0;
        while let Some(coarse) = next(&level, filter, By::Extinction) {
            model = halving.volume(model.0, &model.1);
            depth += 1.0;
            prop_assert_eq!(coarse.dims, model.0);
            for (found, expected) in real(&coarse).iter().zip(&model.1) {
                for k in 0..4 {
                    let bound = if k == 3 { depth } else { 2.0 * depth };
                    prop_assert!((found[k] - expected[k]).abs() < bound, "{found:?} {expected:?}");
                }
            }
            level = coarse;
        }
    }
}

/// Levels of ordinary sizes: how many, how large, and what they keep.
#[test]
fn content_is_kept_through_all_levels() {
    for (filter, dims, last) in [
        (Filter::Two, [16, 8, 4], [1, 1, 1]),
        (Filter::Four, [16, 16, 16], [1, 1, 1]),
        (Filter::Six, [8, 32, 1], [1, 1, 1]),
        (Filter::Five, [17, 9, 5], [2, 2, 2]),
    ] {
        let codes = (0..dims.iter().product::<usize>()).map(|i| {
            let tau = (i * i * 7919 % 30011) as u16;
            [tau / 2, tau / 3, 0, tau]
        });
        let mut level = volume(dims, codes.collect());
        let content = level.content(filter.on_nodes());
        while let Some(coarse) = next(&level, filter, By::Extinction) {
            let change = coarse.content(filter.on_nodes()) / content - 1.0;
            assert!(change.abs() < 1e-3, "{filter:?} {:?}: {change}", coarse.dims);
            level = coarse;
        }
        assert_eq!(level.dims, last, "{filter:?}");
    }
}

/// Figures 2 and 3 of Kraus and Bürger: four of eight voxels have an extinction of 4; the coarse voxel is 2 long.
#[test]
fn figures_2_and_3() {
    let codes: Vec<Codes> = (0..8)
        .map(|i| if i % 2 == 0 { [MAX_CODE; 4] } else { [0; 4] })
        .collect();
    let fine = volume([2, 2, 2], codes);
    let opacity = |by| {
        let coarse = next(&fine, Filter::Two, by).unwrap();
        assert_eq!((coarse.dims, coarse.spacing), ([1; 3], [2.0; 3]));
        -(-2.0 * coarse.tau(coarse.voxels.codes(0)[3])).exp_m1()
    };
    // An ulp of extinction over this length is 4.5e-6 of the light.
    assert!((opacity(By::Extinction) - 0.981_684_361).abs() < 5e-6);
    assert!((opacity(By::Opacity { distance: 1.0 }) - 0.740_758_315).abs() < 7e-5);
}
