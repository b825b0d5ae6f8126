//! The hard cases of the numeric study (its section 6), exactly.
//!
//! Numbers are the study's unless a line says otherwise. Derived anew, with exact rational arithmetic (Python's
//! `fractions`) from the formulas at the head of each stage, not with core: the 12.12 columns of the interpolation, the
//! 1.31 columns of the powers (the study's are in 1.16), and everything about gradients (the study's rule was another
//! one).

mod compositing;
mod fields;
mod shading;

use slicecast::classify::{Classifier, Linear, Nearest, PointTable, Sqrt16, entry, opacity_of_root};
use slicecast::format::{Position, Step, Weight};
use slicecast::interpolate::trilinear;
use slicecast::locate::{Cell, cell, position};
use slicecast::precision::{Compact, Paper, Wide};
use slicecast::table::ENTRIES;

/// `(p0 + k step + 2^15) >> 16`: start, step, k, 16.16 bits, cell, weight.
#[test]
fn location() {
    for (start, step, k, bits, index, weight) in [
        // Three planes per voxel: plane 6141 hits slice 2047 although 1/3 has no end.
        (0, 1_431_655_765, 6141, 134_152_192, 2047, 0),
        (0, 268_435_456, 32_752, 134_152_192, 2047, 0),
        // A negative shear, -0.3717 / 16, from 600.
        (2_576_980_377_600, -99_777_459, 32_768, -10_567_129, -162, 49_703),
        // Halves go up, on both sides of zero.
        (32_768, 0, 0, 1, 0, 1),
        (-32_768, 0, 0, 0, 0, 0),
        (0, 189_812_531, 32_768, 94_906_266, 1448, 10_138),
    ] {
        let p = position(Step::from_bits(start), Step::from_bits(step), k);
        assert_eq!(p, Position::from_bits(bits), "{start} {step} {k}");
        let weight = Weight::from_bits(weight);
        assert_eq!(cell(p), Cell { index, weight });
        // Streaming adds the step k times: the same number.
        let streamed = (0..k).fold(start, |sum, _| sum + step);
        assert_eq!(position(Step::from_bits(streamed), Step::ZERO, 0), p);
    }
}

/// Voxels in z, y, x order, weights along x, y, z; then 12.15 (the study's), 12.12 with one rounding (`Compact`) and
/// 12.12 truncated at each step with weights of 12 bits (`Paper`), both derived anew.
#[test]
fn interpolation() {
    const M: i16 = 4095;
    const H: u32 = 32768;
    let cases: [([i16; 8], [u32; 3], [i32; 3]); 11] = [
        (
            [0, 0, 0, 0, 0, 0, 0, M],
            [65535; 3],
            [134_178_818, 16_772_352, 16_760_836],
        ),
        ([M; 8], [1, 65535, H], [134_184_960, 16_773_120, 16_773_120]),
        ([0, 1, 0, 0, 0, 0, 0, 0], [1, 0, 0], [1, 0, 0]),
        ([0, 1, 0, 0, 0, 0, 0, 0], [H; 3], [4096, 512, 512]),
        ([1, 0, 0, 0, 0, 0, 0, 0], [H; 3], [4096, 512, 512]),
        (
            [M, 0, 0, M, 0, M, M, 0],
            [32767, 32769, H],
            [67_092_480, 8_386_560, 8_386_560],
        ),
        (
            [0, M, M, 0, M, 0, 0, M],
            [21845, 43691, 10923],
            [72_062_521, 9_007_815, 9_007_785],
        ),
        ([7, 8, 8, 7, 8, 7, 7, 8], [1; 3], [229_377, 28_672, 28_672]),
        (
            [M, 4094, M, 4094, M, 4094, M, 4094],
            [65535, 3, 9],
            [134_152_193, 16_769_024, 16_769_025],
        ),
        // Not the study's: the y interpolation's own rounding decides, 0.5 and 7.5 units of 2^-16 going up.
        ([0, 0, 0, 0, 0, 0, 1, 1], [0, H, 1], [1, 0, 0]),
        ([0, 0, 0, 0, 0, 0, 1, 1], [0, H, 15], [4, 1, 0]),
    ];
    for (v, w, [wide, compact, paper]) in cases {
        let corners = [0, 1].map(|z| [0, 1].map(|y| [0, 1].map(|x| v[4 * z + 2 * y + x])));
        let weights = w.map(Weight::from_bits);
        assert_eq!(trilinear(Wide, corners, weights), wide, "{v:?} {w:?}");
        assert_eq!(trilinear(Compact, corners, weights), compact, "{v:?} {w:?}");
        assert_eq!(trilinear(Paper, corners, weights), paper, "{v:?} {w:?}");
    }
}

/// 16-bit roots and the opacities that they decode to, 1.31; then what the light keeps.
#[test]
fn opacity_codes() {
    for (root, opacity, left) in [
        (0, 0, 2_147_483_648u32),
        (1, 1, 2_147_483_647),
        (2, 2, 2_147_483_646),
        (4, 8, 2_147_483_640),
        (16, 128, 2_147_483_520),
        (256, 32_768, 2_147_450_880),
        (257, 33_025, 2_147_450_623),
        (16_384, 134_217_728, 2_013_265_920),
        (32_768, 536_870_912, 1_610_612_736),
        (46_341, 1_073_744_141, 1_073_739_507),
        (65_534, 2_147_352_578, 131_070),
        (65_535, 2_147_418_113, 65_535),
    ] {
        let a = opacity_of_root(root).to_bits();
        assert_eq!((a, (1 << 31) - a), (opacity, left), "{root}");
    }
}

/// 8-bit codes expand to `257 q`.
#[test]
fn byte_codes() {
    for (byte, root, opacity) in [
        (1u32, 257, 33_025),
        (2, 514, 132_098),
        (127, 32_639, 532_652_161),
        (128, 32_896, 541_073_408),
        (254, 65_278, 2_130_608_642),
        (255, 65_535, 2_147_418_113),
    ] {
        assert_eq!(opacity_of_root(root).to_bits(), opacity);
        let entries = [byte << 24; ENTRIES];
        let table = PointTable::<slicecast::classify::Sqrt8, Nearest>::new(&entries, ());
        assert_eq!(Classifier::opacity(&table, Wide, 0).to_bits(), opacity);
    }
}

/// Table indices come from the stored sample. The table's root at code i is 16 i, so that an opacity says which
/// entry it came from.
#[test]
fn table_indices() {
    let root = |i: usize| 16 * i as u16;
    let entries: [u32; ENTRIES] = std::array::from_fn(|i| entry([0; 3], root(i).to_le_bytes()[1]));
    let plane: [u8; ENTRIES] = std::array::from_fn(|i| root(i).to_le_bytes()[0]);
    let nearest = PointTable::<Sqrt16, Nearest>::new(&entries, &plane);
    let linear = PointTable::<Sqrt16, Linear>::new(&entries, &plane);
    let of = |i: usize| i64::from(opacity_of_root(root(i.min(4095))).to_bits());
    // Sample 12.15; nearest entry; entry and fraction of the linear look-up; the nearest entry of the sample stored in
    // 12.12 (rounded once more by 8 = half of 2^3, which is what the study calls doubly rounded).
    for (bits, index, i, f, index12) in [
        (0, 0, 0, 0, 0),
        (16_383, 0, 0, 16_383, 1),
        (16_384, 1, 0, 16_384, 1),
        (3_260_415, 99, 99, 16_383, 100),
        (3_260_416, 100, 99, 16_384, 100),
        (134_168_576, 4095, 4094, 16_384, 4095),
        (134_184_960, 4095, 4095, 0, 4095),
    ] {
        let sample = bits;
        assert_eq!(
            i64::from(Classifier::opacity(&nearest, Wide, sample).to_bits()),
            of(index),
            "{bits}"
        );
        let between = of(i) + (((of(i + 1) - of(i)) * f + (1 << 14)) >> 15);
        assert_eq!(
            i64::from(Classifier::opacity(&linear, Wide, sample).to_bits()),
            between,
            "{bits}"
        );
        let stored = (bits + 4) >> 3;
        assert_eq!(
            i64::from(Classifier::opacity(&nearest, Compact, stored).to_bits()),
            of(index12),
            "{bits}"
        );
    }
}
