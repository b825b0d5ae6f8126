//! Properties that hold for every input, with a stride so that a sample of them can be checked in passing.
//!
//! `cargo run --release -p slicecast-host-tests --bin exhaustive` checks every input of each; the tests take strides.

use std::marker::PhantomData;
use std::ops::RangeInclusive;

use slicecast::classify::{colour_of_byte, colour_of_word, colour_of_words, opacity_of_root};
use slicecast::composite::{Dither, Dithered, Pixel, Recurrence, Unorm16};
use slicecast::format::{Cosine, Opacity, Weight};
use slicecast::interpolate::trilinear;
use slicecast::lanes::{Kernel, Lanes, places};
use slicecast::precision::{Compact, Paper, Wide};
use slicecast::root::reciprocal_root;
use slicecast::shade::power;
use slicecast_engine::simd::{OverLanes, Simd, with_lanes};

/// A property: its name, what it says, and its check over every `stride`-th input, which gives the number of inputs or
/// the first counterexample found.
#[derive(Clone, Copy)]
pub struct Property {
    /// What the command calls it.
    pub name: &'static str,
    /// What holds.
    pub claim: &'static str,
    /// The check.
    pub check: fn(stride: u64) -> Result<u64, String>,
    /// A stride that takes about a second in a debug run; a prime, so that it meets all low bits.
    pub sample_stride: u64,
}

/// All of them.
pub const PROPERTIES: [Property; 8] = [
    Property {
        name: "roots",
        claim: "reciprocal_root(S) is the largest r with r^2 S <= 2^70, S from 2^28 to 3 * 32767^2",
        check: roots,
        sample_stride: 293,
    },
    Property {
        name: "vector-roots",
        claim: "reciprocal_root of every vector width that the processor has is the scalar one, all S",
        check: vector_roots,
        sample_stride: 211,
    },
    Property {
        name: "over",
        claim: "Compact's over takes what it gives, errs by less than a unit, and keeps 0 and 1: all T, all opacities that \
                an 8- or 16-bit root can have, extreme and ordinary dithers",
        check: over,
        sample_stride: 997,
    },
    Property {
        name: "opacity",
        claim: "opacity_of_root is q^2 / 2 to the nearest, halves up, for all 65536 roots",
        check: opacity,
        sample_stride: 1,
    },
    Property {
        name: "colour",
        claim: "colour_of_word is the nearest 1.15 and 1.31 of all 65536 colours, in lanes too; 65535 is 1, and a byte twice \
                is that byte",
        check: colour,
        sample_stride: 1,
    },
    Property {
        name: "power",
        claim: "power::<Compact> is within 2^(n-1) units of f64, never above its base and never falls, all 2^31 + 1 \
                cosines at exponents 1 to 256",
        check: powers,
        sample_stride: 4999,
    },
    Property {
        name: "paper-power",
        claim: "power::<Paper> truncates: at most x^(2^n), less than 2^n units of 1.16 below it, all 65537 cosines",
        check: paper_powers,
        sample_stride: 1,
    },
    Property {
        name: "interpolate",
        claim: "a sample between two voxels is the formula in 64 bits, all differences, all weights, three precisions",
        check: interpolate,
        sample_stride: 127,
    },
];

/// Splits a range over the processors; the first error in the order of the range is returned.
fn everywhere(
    range: RangeInclusive<u64>,
    stride: u64,
    check: impl Fn(u64) -> Result<u64, String> + Sync,
) -> Result<u64, String> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from) as u64;
    let (first, last) = (*range.start(), *range.end());
    let steps = (last - first) / stride + 1;
    let share = steps.div_ceil(threads);
    let check = &check;
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads)
            .map(|t| {
                let own = t * share..((t + 1) * share).min(steps);
                scope.spawn(move || own.map(|n| check(first + n * stride)).sum::<Result<u64, String>>())
            })
            .collect();
        workers
            .into_iter()
            .map(|w| w.join().unwrap_or_else(|_| Err("a check panicked".to_owned())))
            .sum()
    })
}

fn roots(stride: u64) -> Result<u64, String> {
    const LARGEST: u64 = 3 * 32767 * 32767;
    let check = |s: u64| {
        let r = u128::from(reciprocal_root(s as u32));
        let wide = u128::from(s);
        if r * r * wide <= 1 << 70 && (r + 1) * (r + 1) * wide > 1 << 70 {
            Ok(1)
        } else {
            Err(format!("S = {s}: r = {r}"))
        }
    };
    let mut count = everywhere(1 << 28..=LARGEST, stride, check)?;
    // The ends, the seam between the two scalings, and the value that f64 gets wrong.
    for s in [1 << 28, (1 << 30) - 1, 1 << 30, 898_823_412, LARGEST - 1, LARGEST] {
        count += check(s)?;
    }
    Ok(count)
}

/// Squares that are checked together.
const TOGETHER: u64 = 4096;

/// Reciprocal roots of consecutive squares.
struct Roots(Vec<i32>);

impl OverLanes for &Roots {
    type Output = Vec<i32>;

    #[inline(always)]
    fn run<V: Lanes>(self) -> Vec<i32> {
        let mut out = vec![0; self.0.len()];
        V::enter(EachRoot::<V>(&self.0, &mut out, PhantomData));
        out
    }
}

struct EachRoot<'a, V>(&'a [i32], &'a mut [i32], PhantomData<V>);

impl<V: Lanes> Kernel for EachRoot<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for at in places::<V>(self.0.len()) {
            V::load(self.0, at).reciprocal_root().store(self.1, at);
        }
    }
}

fn vector_roots(stride: u64) -> Result<u64, String> {
    const FIRST: u64 = 1 << 28;
    const LARGEST: u64 = 3 * 32767 * 32767;
    everywhere(0..=(LARGEST - FIRST) / TOGETHER, stride, |block| {
        let first = FIRST + block * TOGETHER;
        let squares = first..=(first + TOGETHER - 1).min(LARGEST);
        let roots = Roots(squares.map(|s| s as i32).collect());
        let expected = with_lanes(Simd::Scalar, &roots);
        for simd in Simd::available() {
            let found = with_lanes(simd, &roots);
            if let Some(at) = expected.iter().zip(&found).position(|(a, b)| a != b) {
                let (s, e, f) = (first + at as u64, expected[at], found[at]);
                return Err(format!("S = {s}: {f} by {}, {e} by the definition", simd.name()));
            }
        }
        Ok(expected.len() as u64)
    })
}

/// Dithers: the extremes of both sequences, and those of planes 0 and 1.
const DITHERS: [Dither; 4] = [
    Dither {
        transparency: 0,
        colour: 0,
    },
    Dither {
        transparency: 0x7fff,
        colour: 0x7fff,
    },
    Dither::of_plane(0),
    Dither::of_plane(1),
];

fn over(stride: u64) -> Result<u64, String> {
    // Input n stands for T and an opacity: that of root n % 65537, or 1.
    const OPACITIES: u64 = 65537;
    const ONE: u16 = u16::MAX;
    let check = |n: u64| {
        let t = (n / OPACITIES) as u16;
        let root = n % OPACITIES;
        let a = if root == 65536 {
            1 << 31
        } else {
            opacity_of_root(root as u16).to_bits()
        };
        let pixel = Pixel {
            colour: [Unorm16(0), Unorm16(0), Unorm16(ONE - t)],
            transparency: Unorm16(t),
        };
        for dither in DITHERS {
            let out = Dithered.over(pixel, [1 << 15, 1, 1 << 15], Opacity::from_bits(a), dither);
            let [white, faint, full] = out.colour.map(|c| c.0);
            let left = out.transparency.0;
            let exact = i64::from(t) * ((1 << 31) - i64::from(a));
            let right = left <= t
                && white == t - left
                && faint <= white
                && u32::from(full) + u32::from(left) == u32::from(ONE)
                && ((i64::from(left) << 31) - exact).abs() < 1 << 31
                && (a != 0 || out == pixel)
                && (a != 1 << 31 || left == 0);
            if !right {
                return Err(format!("T = {t}, a = {a}, {dither:?}: {out:?}"));
            }
        }
        Ok(DITHERS.len() as u64)
    };
    let last = OPACITIES * 65536 - 1;
    let mut count = everywhere(0..=last, stride, check)?;
    for t in [0, 1, 2, 32767, 32768, 65534, 65535] {
        for root in [0, 1, 2, 181, 182, 32768, 65534, 65535, 65536] {
            count += check(t * OPACITIES + root)?;
        }
    }
    Ok(count)
}

fn opacity(stride: u64) -> Result<u64, String> {
    everywhere(0..=65535, stride, |q| {
        let a = u64::from(opacity_of_root(q as u16).to_bits());
        if (2 * a).abs_diff(q * q) <= 1 && 2 * a >= q * q {
            Ok(1)
        } else {
            Err(format!("root {q}: {a}"))
        }
    })
}

fn colour(stride: u64) -> Result<u64, String> {
    everywhere(0..=65535, stride, |word| {
        for bits in [15, 31] {
            let c = colour_of_word(word as u16, bits);
            // 2 |c - 2^bits word / 65535| is at most 1.
            let near = (2 * 65535 * u64::from(c)).abs_diff(word << (bits + 1)) <= 65535;
            let lanes = colour_of_words(word as i32, bits) as u32 == c;
            let byte = word % 257 != 0 || colour_of_byte((word / 257) as u8, bits) == c;
            let one = word != 65535 || c == 1 << bits;
            if !(near && lanes && byte && one) {
                return Err(format!("colour {word}, {bits} bits: {c}"));
            }
        }
        Ok(1)
    })
}

fn powers(stride: u64) -> Result<u64, String> {
    const ONE: u64 = 1 << 31;
    let check = |x: u64| {
        let mut exact = x as f64 / ONE as f64;
        for n in 1..=8 {
            exact *= exact;
            let y = power(Compact, Cosine::from_bits(x as u32), n).to_bits();
            let next = power(Compact, Cosine::from_bits((x + 1).min(ONE) as u32), n).to_bits();
            let off = (f64::from(y) - exact * ONE as f64).abs();
            if u64::from(y) > x || next < y || off > f64::from(1u32 << (n - 1)) {
                return Err(format!("x = {x}, n = {n}: {y}, next {next}, off by {off}"));
            }
        }
        Ok(8)
    };
    Ok(everywhere(0..=ONE, stride, check)? + check(0)? + check(1)? + check(ONE - 1)? + check(ONE)?)
}

fn paper_powers(stride: u64) -> Result<u64, String> {
    everywhere(0..=65536, stride, |x| {
        let mut exact = x as f64 / 65536.0;
        for n in 1..=8 {
            exact *= exact;
            let y = power(Paper, Cosine::from_bits((x as u32) << 15), n).to_bits();
            let short = exact * 65536.0 - f64::from(y >> 15);
            if y & 0x7fff != 0 || short < -1e-6 || short >= f64::from(1u32 << n) {
                return Err(format!("x = {x}, n = {n}: {y}, {short} units short"));
            }
        }
        Ok(8)
    })
}

fn interpolate(stride: u64) -> Result<u64, String> {
    // Input n stands for a difference of -4095 to 4095 and a weight.
    everywhere(0..=8191 * 65536 - 1, stride, |n| {
        let (difference, weight) = ((n >> 16) as i64 - 4095, (n & 0xffff) as i64);
        let from = if difference < 0 { 4095 } else { 0 };
        let row = [from as i16, (from + difference) as i16];
        let weights = [Weight::from_bits(weight as u32), Weight::ZERO, Weight::ZERO];
        let at = |weight: i64| (from << 16) + difference * weight;
        let nearest = |bits: u32| (at(weight) + (1 << (15 - bits))) >> (16 - bits);
        let found = [
            trilinear(Paper, [[row; 2]; 2], weights),
            trilinear(Compact, [[row; 2]; 2], weights),
            trilinear(Wide, [[row; 2]; 2], weights),
        ];
        let expected = [at(weight & !15) >> 4, nearest(12), nearest(15)];
        if found.map(i64::from) == expected {
            Ok(3)
        } else {
            Err(format!(
                "difference {difference}, weight {weight}: {found:?}, expected {expected:?}"
            ))
        }
    })
}
