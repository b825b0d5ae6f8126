//! Numbers and volumes that are the same on every machine: integers only.

use slicecast_volume::{Mapping, Volume};

/// SplitMix64 (Steele, Lea, Flood 2014): every seed gives a different sequence of 64-bit numbers.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The sequence of a seed.
    pub const fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next number.
    pub fn next_bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mixed(self.0)
    }

    /// A number from 0 to `end - 1`, for small `end`.
    pub fn below(&mut self, end: u32) -> u32 {
        (((self.next_bits() >> 32) * u64::from(end)) >> 32) as u32
    }
}

/// SplitMix64's finaliser: a bijection in which every input bit moves about half of the output bits.
pub const fn mixed(bits: u64) -> u64 {
    let a = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let b = (a ^ (a >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    b ^ (b >> 31)
}

/// What fills a volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filling {
    /// One value everywhere.
    Constant(u16),
    /// Every voxel on its own, 0 to 4095.
    Noise,
    /// 0 or 4095: the steepest differences that there are.
    Extremes,
    /// Mostly 0, one voxel in 8 anything.
    Sparse,
    /// 0, and here and there a small box of anything: most blocks of a row are empty.
    Boxes,
    /// `400 + 7 x - 5 y + 11 z`, the study's linear field.
    Linear,
    /// A solid ball with a soft rim, in integers.
    Ball,
    /// Concentric ripples around an axis with depth modulation: what Marschner and Lobb's test signal looks like,
    /// made of integer triangle waves.
    Ripples,
}

/// A volume of this shape, 1 unit between voxels, codes as values.
pub fn volume(dims: [usize; 3], filling: Filling, seed: u64) -> Volume {
    let mut random = Random::new(seed);
    let [nx, ny, nz] = dims;
    let boxes = boxes(
        dims,
        &mut random,
        if filling == Filling::Boxes {
            1 + seed as usize % 5
        } else {
            0
        },
    );
    let mut voxels = Vec::with_capacity(nx * ny * nz);
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                voxels.push(match filling {
                    Filling::Constant(value) => value,
                    Filling::Noise => random.below(4096) as u16,
                    Filling::Extremes => 4095 * random.below(2) as u16,
                    Filling::Sparse if random.below(8) > 0 => 0,
                    Filling::Sparse => random.below(4096) as u16,
                    Filling::Boxes if !boxes.iter().any(|b| (0..3).all(|a| b[a].contains(&[x, y, z][a]))) => 0,
                    Filling::Boxes => random.below(4096) as u16,
                    Filling::Linear => ((400 + 7 * x + 11 * z).saturating_sub(5 * y) as u16).min(4095),
                    Filling::Ball => ball(dims, [x, y, z]),
                    Filling::Ripples => ripples(dims, [x, y, z]),
                });
            }
        }
    }
    Volume {
        name: format!("{filling:?} {nx} x {ny} x {nz}, seed {seed}"),
        dims,
        spacing: [1.0; 3],
        voxels,
        mapping: Mapping {
            scale: 1.0,
            offset: 0.0,
        },
    }
}

/// Boxes of up to 9 voxels a side anywhere in a volume, cut off at its faces.
fn boxes(dims: [usize; 3], random: &mut Random, count: usize) -> Vec<[std::ops::Range<usize>; 3]> {
    let mut range = |side: usize| {
        let first = random.below(side as u32) as usize;
        first..first + 1 + random.below(9) as usize
    };
    (0..count).map(|_| dims.map(&mut range)).collect()
}

/// Place of a voxel from the middle of its side, -2^12 to 2^12.
fn from_middle(place: usize, side: usize) -> i64 {
    let last = (side.max(2) - 1) as i64;
    (2 * place as i64 - last) * 4096 / last
}

fn ball(dims: [usize; 3], at: [usize; 3]) -> u16 {
    let squares = (0..3).map(|a| from_middle(at[a], dims[a]).pow(2)).sum::<i64>();
    // 0.75 of the half side; the rim is about a sixth of it wide.
    let inside = (3 << 10) * (3 << 10) - squares;
    (inside / 1024 + 2048).clamp(0, 4095) as u16
}

fn ripples(dims: [usize; 3], at: [usize; 3]) -> u16 {
    let [x, y, z] = [0, 1, 2].map(|a| from_middle(at[a], dims[a]));
    let radius = (x * x + y * y).isqrt();
    let wave = |phase: i64| (phase.rem_euclid(4096) - 2048).abs() * 2;
    ((z + 4096) / 4 + wave(radius * 3) / 2).clamp(0, 4095) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequence_is_the_published_one() {
        let mut random = Random::new(1234567);
        assert_eq!(
            [random.next_bits(), random.next_bits()],
            [6457827717110365317, 3203168211198807973]
        );
    }

    #[test]
    fn volumes_stay_within_twelve_bits_and_are_not_flat() {
        for filling in [
            Filling::Noise,
            Filling::Extremes,
            Filling::Sparse,
            Filling::Linear,
            Filling::Ball,
            Filling::Ripples,
        ] {
            let v = volume([9, 8, 7], filling, 3);
            assert_eq!(v.voxels.len(), 9 * 8 * 7);
            assert!(v.voxels.iter().all(|c| *c <= 4095));
            assert!(v.voxels.iter().any(|c| *c != v.voxels[0]), "{filling:?}");
        }
    }
}
