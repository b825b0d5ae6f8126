//! Levels of volumes of one value a voxel: each voxel the mean of the eight that it covers.
//!
//! Weights are (1,1)/2 along each axis, on cells. What lies beyond the last voxel is that voxel again; every axis becomes
//! ceil(n/2) long, so that voxels are twice as long along all of them, also along one of a single voxel. A linear field stays one in
//! the same place, values stay between the smallest and the largest of the eight, and a part of a volume that begins at an even
//! voxel has the level's own values.
//!
//! Rounding: nearest, halves to even, because halves up would make each level lighter by 1/16 of a code. Range: eight codes are at
//! most 8 * 65535.

use slicecast_volume::Volume;

/// The mean of a sum of eight codes.
pub const fn mean(sum: u32) -> u16 {
    // 3 below a half rounds down, 4 is one: up where the quotient is odd.
    ((sum + 3 + ((sum >> 3) & 1)) >> 3) as u16
}

/// The next level of a volume, whose sides are not 0.
pub fn halved(volume: &Volume) -> Volume {
    let [nx, ny, nz] = volume.dims;
    let dims = volume.dims.map(|side| side.div_ceil(2));
    let mut voxels = Vec::with_capacity(dims.iter().product());
    let row = |y: usize, z: usize| {
        let start = (z.min(nz - 1) * ny + y.min(ny - 1)) * nx;
        &volume.voxels[start..start + nx]
    };
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            let rows = [
                row(2 * y, 2 * z),
                row(2 * y + 1, 2 * z),
                row(2 * y, 2 * z + 1),
                row(2 * y + 1, 2 * z + 1),
            ];
            let sum = |x: usize| rows.iter().map(|row| u32::from(row[x.min(nx - 1)])).sum::<u32>();
            voxels.extend((0..dims[0]).map(|x| mean(sum(2 * x) + sum(2 * x + 1))));
        }
    }
    Volume {
        name: volume.name.clone(),
        dims,
        spacing: volume.spacing.map(|side| 2.0 * side),
        voxels,
        mapping: volume.mapping,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use slicecast_model::pyramid::Halving;
    use slicecast_volume::Mapping;

    fn volume(dims: [usize; 3], voxels: Vec<u16>) -> Volume {
        Volume {
            name: "v".into(),
            dims,
            spacing: [1.0, 2.0, 3.0],
            voxels,
            mapping: Mapping {
                scale: 1.0,
                offset: 0.0,
            },
        }
    }

    /// Every sum of eight codes of 12 bits.
    #[test]
    fn means_are_the_nearest_and_halves_even() {
        let mut away = 0i64;
        for sum in 0..=8 * 4095u32 {
            assert_eq!(f64::from(mean(sum)), (f64::from(sum) / 8.0).round_ties_even());
            // Over whole periods of both halves nothing is added.
            if sum < 8 * 4094 {
                away += i64::from(mean(sum)) * 8 - i64::from(sum);
            }
        }
        assert_eq!(away, 0);
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 200, rng_seed: proptest::test_runner::RngSeed::Fixed(8), ..ProptestConfig::default() })]

        /// Half a code a level from the model's pyramid; and of a part the same codes.
        #[test]
        fn levels_are_those_of_the_model(dims in prop::array::uniform3(1usize..=9), seed in any::<u64>()) {
            let mut state = seed;
            let mut code = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 52) as u16
            };
            let fine = volume(dims, (0..dims.iter().product()).map(|_| code()).collect());
            let halving = Halving { weights: &[1.0, 1.0], on_nodes: false };
            let (mut of_model, mut level) = ((dims, fine.voxels.iter().map(|v| [f64::from(*v); 4]).collect::<Vec<_>>()), fine.clone());
            for number in 1..=3 {
                of_model = halving.volume(of_model.0, &of_model.1);
                level = halved(&level);
                prop_assert_eq!(level.dims, of_model.0);
                prop_assert_eq!(level.spacing, fine.spacing.map(|side| side * f64::from(1 << number)));
                for (found, exact) in level.voxels.iter().zip(&of_model.1) {
                    prop_assert!((f64::from(*found) - exact[0]).abs() <= 0.5 * f64::from(number) + 1e-9);
                }
            }
            // The part behind the first two slices.
            if dims[2] > 2 {
                let part = volume([dims[0], dims[1], dims[2] - 2], fine.voxels[2 * dims[0] * dims[1]..].to_vec());
                let (all, part) = (halved(&fine), halved(&part));
                prop_assert_eq!(&all.voxels[all.dims[0] * all.dims[1]..], &part.voxels[..]);
            }
        }
    }

    #[test]
    fn a_linear_field_stays() {
        let fine = volume(
            [8, 8, 8],
            (0..512)
                .map(|n| (n % 8 * 16 + n / 8 % 8 * 32 + n / 64 * 64) as u16)
                .collect(),
        );
        let coarse = halved(&fine);
        // Voxel m lies at 2 m + 1/2.
        for (n, code) in coarse.voxels.iter().enumerate() {
            let [x, y, z] = [n % 4, n / 4 % 4, n / 16].map(|m| 2 * m);
            assert_eq!(usize::from(*code), x * 16 + 8 + y * 32 + 16 + z * 64 + 32);
        }
    }
}
