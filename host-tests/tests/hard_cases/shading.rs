//! Normalisation and powers.

use slicecast::format::Cosine;
use slicecast::normalise::{Normal, block, normalise, unit};
use slicecast::precision::{Compact, Paper, Wide};
use slicecast::root::reciprocal_root;
use slicecast::shade::{dot, power};
use slicecast_host_tests::random::Random;

type Vector = [i32; 3];

/// Gradient; block-normalised g; S; r; the unit vector in s1.15.
const NORMALS: [(Vector, Vector, u32, u32, Vector); 17] = [
    // The one S in 2.95e9 for which f64's 2^35 / sqrt(S) truncates to a wrong r, 1146074.
    (
        [29978, 328, 188],
        [29978, 328, 188],
        898_823_412,
        1_146_073,
        [32765, 358, 205],
    ),
    ([0, 0, 0], [0, 0, 0], 0, 0, [0, 0, 0]),
    ([1, 0, 0], [16384, 0, 0], 268_435_456, 2_097_152, [32768, 0, 0]),
    ([0, -1, 0], [0, -16384, 0], 268_435_456, 2_097_152, [0, -32768, 0]),
    ([1, 1, 0], [16384, 16384, 0], 536_870_912, 1_482_910, [23170, 23170, 0]),
    (
        [1, 1, 1],
        [16384, 16384, 16384],
        805_306_368,
        1_210_791,
        [18919, 18919, 18919],
    ),
    (
        [1, 2, 3],
        [8192, 16384, 24576],
        939_524_096,
        1_120_974,
        [8758, 17515, 26273],
    ),
    (
        [-3, 2, -1],
        [-24576, 16384, -8192],
        939_524_096,
        1_120_974,
        [-26273, 17515, -8758],
    ),
    ([16384, 0, 0], [16384, 0, 0], 268_435_456, 2_097_152, [32768, 0, 0]),
    ([32767; 3], [32767; 3], 3_221_028_867, 605_414, [18919; 3]),
    ([65535, 1, 0], [32767, 1, 0], 1_073_676_290, 1_048_608, [32768, 1, 0]),
    ([65535; 3], [32767; 3], 3_221_028_867, 605_414, [18919; 3]),
    (
        [131_071, -131_071, 3],
        [32767, -32767, 1],
        2_147_352_579,
        741_477,
        [23170, -23170, 1],
    ),
    (
        [536_739_840, 0, 1],
        [32760, 0, 0],
        1_073_217_600,
        1_048_832,
        [32768, 0, 0],
    ),
    (
        [268_435_456, 268_435_455, -268_435_453],
        [16384, 16384, -16384],
        805_306_368,
        1_210_791,
        [18919, 18919, -18919],
    ),
    ([20000, 1, -1], [20000, 1, -1], 400_000_002, 1_717_986, [32768, 2, -2]),
    ([3, -100_000, 7], [1, -25000, 2], 625_000_005, 1_374_389, [1, -32768, 3]),
];

#[test]
fn normals() {
    for (gradient, g, s, r, n) in NORMALS {
        assert_eq!(block(gradient), g, "{gradient:?}");
        let sum: u32 = g.iter().map(|c| (c * c) as u32).sum();
        assert_eq!((sum, reciprocal_root(s)), (s, r), "{gradient:?}");
        let normal = normalise(gradient);
        assert_eq!(normal, Normal { g, r });
        assert_eq!(unit(normal).map(|c| c.to_bits()), n, "{gradient:?}");
    }
}

#[test]
fn reciprocal_roots_that_must_not_move() {
    assert_eq!(reciprocal_root(898_823_412), 1_146_073);
    assert_eq!((2f64.powi(35) / f64::from(898_823_412).sqrt()) as u32, 1_146_074);
    assert_eq!(reciprocal_root(1 << 28), 2_097_152);
    assert_eq!(reciprocal_root(3_221_028_867), 605_414);
}

/// Negating a gradient negates g and leaves S and r as they are.
#[test]
fn opposite_gradients_have_opposite_normals() {
    let mut random = Random::new(1);
    let drawn = (0..20_000).map(|_| [(); 3].map(|()| random.next_bits() as i32 >> (1 + random.below(31))));
    for gradient in drawn.chain(NORMALS.map(|n| n.0)) {
        let (a, b) = (normalise(gradient), normalise(gradient.map(|c| -c)));
        assert_eq!((a.g.map(|c| -c), a.r), (b.g, b.r), "{gradient:?}");
    }
}

/// A cosine is the 1.31 number nearest to `-(g . L) r / 2^35`, halves up, from 0 to 1.
#[test]
fn cosines_are_rounded_to_nearest() {
    let mut random = Random::new(2);
    for _ in 0..20_000 {
        let normal = normalise([(); 3].map(|()| random.next_bits() as i32 >> (1 + random.below(31))));
        let light = [(); 3].map(|()| random.below(37_837) as i32 - 18_918);
        let product: i64 = normal.g.into_iter().zip(light).map(|(g, l)| i64::from(-g * l)).sum();
        let exact = i128::from(product.max(0)) * i128::from(normal.r);
        let nearest = ((exact + (1 << 18)) >> 19).min(1 << 31);
        let found = dot(Compact, normal, light);
        assert_eq!(i128::from(found.to_bits()), nearest, "{normal:?} {light:?}");
        // A light of 30 bits whose low 15 are 0 is the same light.
        assert_eq!(dot(Wide, normal, light.map(|l| l << 15)), found);
    }
}

/// x in 1.16, then x^64 and x^256: 1.31 by `Compact` and `Wide`, and 1.16 truncated by `Paper`.
///
/// The study squares in 1.16 and rounds; the pipeline squares in 1.31, so those columns are derived anew: n times
/// `(x x + 2^30) >> 31` on whole numbers. The truncated column is the study's.
const POWERS: [(u32, [u32; 2], [u32; 2]); 12] = [
    (65_536, [2_147_483_648, 2_147_483_648], [65_536, 65_536]),
    (65_535, [2_145_387_520, 2_139_111_404], [65_472, 65_280]),
    (65_534, [2_143_293_374, 2_130_771_545], [65_408, 65_025]),
    (65_387, [1_856_370_599, 1_199_137_899], [56_632, 36_542]),
    (65_282, [1_674_924_278, 794_677_861], [51_070, 24_166]),
    (65_141, [1_458_469_225, 456_877_196], [44_491, 13_919]),
    (64_349, [666_637_366, 19_942_014], [20_331, 606]),
    (60_000, [7_566_488, 0], [230, 0]),
    (46_341, [1, 0], [0, 0]),
    (256, [0, 0], [0, 0]),
    (181, [0, 0], [0, 0]),
    (1, [0, 0], [0, 0]),
];

#[test]
fn powers() {
    for (x, nearest, truncated) in POWERS {
        let cosine = Cosine::from_bits(x << 15);
        for (n, (nearest, truncated)) in [6u32, 8].into_iter().zip(nearest.into_iter().zip(truncated)) {
            assert_eq!(power(Compact, cosine, n).to_bits(), nearest, "{x} {n}");
            assert_eq!(power(Wide, cosine, n).to_bits(), nearest, "{x} {n}");
            assert_eq!(power(Paper, cosine, n).to_bits(), truncated << 15, "{x} {n}");
        }
    }
}

/// Every 1.16 cosine against f64: each squaring doubles the relative error and adds half a unit, so that n of them
/// stay within 2^(n-1) units of 1.31, 1/256 of a unit of 1.16 at an exponent of 256. The study's 1.16 form was 50
/// units of 1.16 off at x = 65387.
#[test]
fn powers_keep_to_f64() {
    for n in 0..=8u32 {
        let mut worst = 0.0f64;
        for x in 0..=65_536u32 {
            let exact = (f64::from(x) / 65_536.0).powi(1 << n) * 2f64.powi(31);
            let found = f64::from(power(Compact, Cosine::from_bits(x << 15), n).to_bits());
            worst = worst.max((found - exact).abs());
        }
        assert!(worst <= f64::from(1u32 << n) / 2.0, "n {n}: {worst} units of 1.31");
    }
}
