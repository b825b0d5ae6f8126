//! Lanes of f32, the opponent's counterpart of core's integer lanes: one definition, `f32` or a processor's vectors.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;

#[cfg(target_arch = "x86_64")]
use std::marker::PhantomData;
use std::ops::{Add, Mul, Sub};

use slicecast::lanes::{Kernel, Lanes};
use slicecast::table::{Coding, Neighboured};

use crate::simd::Simd;

/// How whole parts are looked up: they are codes.
pub const AS_IT_IS: Coding = Coding { offset: 0, bits: 0 };

/// Some lanes of 32-bit floats.
pub trait Floats: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    /// How many lanes.
    const COUNT: usize;

    /// Runs a kernel compiled for these lanes: a function of its own ([`Lanes::enter`]).
    fn enter<K: Kernel>(kernel: K) -> K::Output;
    /// The same number in all lanes.
    fn splat(value: f32) -> Self;
    /// Elements `at ..` of a row; 0 behind its end.
    fn load(row: &[f32], at: usize) -> Self;
    /// Writes to elements `at ..` of a row, as far as it goes.
    fn store(self, row: &mut [f32], at: usize);
    /// Voxels `at ..` of a row; 0 behind its end.
    fn load_voxels(row: &[u16], at: usize) -> Self;
    /// Writes whole parts to elements `at ..` of a row that goes as far.
    fn store_whole(self, row: &mut [i32], at: usize);
    /// Whole parts `at ..` of such a row.
    fn load_whole(row: &[i32], at: usize) -> Self;
    /// The table's values, which are the bits of floats, at the codes `at ..` of a row, and the next ones. Codes are not
    /// negative; what lies above the last has its low 12 bits.
    fn look_up(values: &Neighboured, codes: &[i32], at: usize) -> [Self; 2];
    /// Red, green and blue, 0 to 255, of a table's entries there and the next ones.
    fn look_up_colours(entries: &Neighboured, codes: &[i32], at: usize) -> [[Self; 3]; 2];

    /// Lanes 1 .. of this and the first of `next`: each lane's right neighbour.
    fn followed_by(self, next: Self) -> Self;
    /// `self * factor + term`.
    fn times_plus(self, factor: Self, term: Self) -> Self;
    /// The smaller.
    fn at_most(self, other: Self) -> Self;
    /// The larger.
    fn at_least(self, other: Self) -> Self;
    /// `value` where this is above 0, else 0.
    fn positive_then(self, value: Self) -> Self;
    /// `value` where this is at least `floor`, else 0.
    fn at_least_then(self, floor: Self, value: Self) -> Self;
    /// Whether any lane is above 0.
    fn any_positive(self) -> bool;
    /// How many lanes are above 0.
    fn count_positive(self) -> usize;
    /// The lanes where `chosen` is above 0, in their order, in the first lanes; the others hold anything finite.
    fn packed(self, chosen: Self) -> Self;
    /// The first lanes, in their order, in those where `chosen` is above 0; the others hold anything finite.
    fn spread(self, chosen: Self) -> Self;
    /// `1 / sqrt(x)` to about 22 bits: the processor's estimate and one Newton step. 0 for 0.
    fn reciprocal_root(self) -> Self;

    /// `self + (b - self) * w`.
    #[inline(always)]
    fn towards(self, b: Self, w: Self) -> Self {
        (b - self).times_plus(w, self)
    }
}

impl Floats for f32 {
    const COUNT: usize = 1;

    #[inline(always)]
    fn enter<K: Kernel>(kernel: K) -> K::Output {
        i32::enter(kernel)
    }
    #[inline(always)]
    fn splat(value: f32) -> Self {
        value
    }
    #[inline(always)]
    fn load(row: &[f32], at: usize) -> Self {
        row.get(at).copied().unwrap_or(0.0)
    }
    #[inline(always)]
    fn store(self, row: &mut [f32], at: usize) {
        if let Some(place) = row.get_mut(at) {
            *place = self;
        }
    }
    #[inline(always)]
    fn load_voxels(row: &[u16], at: usize) -> Self {
        row.get(at).copied().map_or(0.0, Self::from)
    }
    #[inline(always)]
    fn store_whole(self, row: &mut [i32], at: usize) {
        if let Some(place) = row.get_mut(at) {
            *place = self as i32;
        }
    }
    #[inline(always)]
    fn load_whole(row: &[i32], at: usize) -> Self {
        row.get(at).map_or(0.0, |whole| *whole as Self)
    }
    #[inline(always)]
    fn look_up(values: &Neighboured, codes: &[i32], at: usize) -> [Self; 2] {
        i32::look_up(values, codes, at, AS_IT_IS).map(|bits| Self::from_bits(bits as u32))
    }
    #[inline(always)]
    fn look_up_colours(entries: &Neighboured, codes: &[i32], at: usize) -> [[Self; 3]; 2] {
        let channels = |entry: i32| [0, 8, 16].map(|channel| Self::from((entry >> channel) as u8));
        i32::look_up(entries, codes, at, AS_IT_IS).map(channels)
    }
    #[inline(always)]
    fn followed_by(self, next: Self) -> Self {
        next
    }
    #[inline(always)]
    fn times_plus(self, factor: Self, term: Self) -> Self {
        // Not fused: without the instruction that would be a call.
        self * factor + term
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    #[inline(always)]
    fn at_least(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn positive_then(self, value: Self) -> Self {
        if self > 0.0 { value } else { 0.0 }
    }
    #[inline(always)]
    fn at_least_then(self, floor: Self, value: Self) -> Self {
        if self >= floor { value } else { 0.0 }
    }
    #[inline(always)]
    fn any_positive(self) -> bool {
        self > 0.0
    }
    #[inline(always)]
    fn count_positive(self) -> usize {
        usize::from(self > 0.0)
    }
    #[inline(always)]
    fn packed(self, _: Self) -> Self {
        self
    }
    #[inline(always)]
    fn spread(self, _: Self) -> Self {
        self
    }
    #[inline(always)]
    fn reciprocal_root(self) -> Self {
        self.positive_then(1.0 / self.sqrt())
    }
}

/// Work that is written over lanes of floats.
pub trait OverFloats {
    /// What comes of it.
    type Output;
    /// The work in these lanes. It is `#[inline(always)]`, and so is all that it calls, except by [`Floats::enter`].
    fn run<F: Floats>(self) -> Self::Output;
}

/// Work with vectors of a width.
#[cfg(target_arch = "x86_64")]
struct Run<W, F>(W, PhantomData<F>);

#[cfg(target_arch = "x86_64")]
impl<W: OverFloats, F: Floats> Kernel for Run<W, F> {
    type Output = W::Output;

    #[inline(always)]
    fn run(self) -> W::Output {
        self.0.run::<F>()
    }
}

/// Does some work with vectors of this width.
pub fn with_floats<W: OverFloats>(simd: Simd, work: W) -> W::Output {
    match simd {
        Simd::Scalar => work.run::<f32>(),
        #[cfg(target_arch = "x86_64")]
        Simd::Avx2(_) => super::entry::avx2(Run::<_, avx2::Avx2>(work, PhantomData)),
        #[cfg(target_arch = "x86_64")]
        Simd::Avx512(_) => super::entry::avx512(Run::<_, avx512::Avx512>(work, PhantomData)),
        #[cfg(not(target_arch = "x86_64"))]
        Simd::Avx2(never) => never.absurd(),
        #[cfg(not(target_arch = "x86_64"))]
        Simd::Avx512(never) => never.absurd(),
    }
}
