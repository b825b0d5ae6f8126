//! The processor's vectors as core's lanes: chosen once per frame, the same bits with any of them.
//!
//! A choice of vectors holds a token that only detection makes, and the lanes themselves cannot be named outside this
//! module: safe code therefore runs no instruction that the processor lacks. All `unsafe` code of the program is here.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
#[cfg(target_arch = "x86_64")]
mod entry;
pub mod floats;
#[cfg(target_arch = "x86_64")]
mod partial;
#[cfg(target_arch = "x86_64")]
mod root;
#[cfg(test)]
mod tests;
mod token;

use slicecast::lanes::Lanes;

pub use self::token::{Avx2Token, Avx512Token};

/// Which vectors do the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Simd {
    /// One lane: the scalar definition.
    Scalar,
    /// Eight lanes of AVX2 (and FMA, BMI1, BMI2).
    Avx2(Avx2Token),
    /// Sixteen lanes of AVX-512 (F, BW, CD, DQ, VL), on processors that have the former too.
    Avx512(Avx512Token),
}

impl Simd {
    /// The names on the command line and in reports, narrowest first.
    pub const NAMES: [&'static str; 3] = ["scalar", "avx2", "avx512"];

    /// Those that this processor has, narrowest first.
    pub fn available() -> impl DoubleEndedIterator<Item = Self> {
        let avx2 = Avx2Token::detect().map(Self::Avx2);
        let avx512 = Avx512Token::detect().map(Self::Avx512);
        [Some(Self::Scalar), avx2, avx512].into_iter().flatten()
    }

    /// The widest that this processor has.
    pub fn widest() -> Self {
        Self::available().next_back().unwrap_or(Self::Scalar)
    }

    /// The name on the command line and in reports.
    pub const fn name(self) -> &'static str {
        let [scalar, avx2, avx512] = Self::NAMES;
        match self {
            Self::Scalar => scalar,
            Self::Avx2(_) => avx2,
            Self::Avx512(_) => avx512,
        }
    }
}

/// Work that is written over lanes.
pub trait OverLanes {
    /// What comes of it.
    type Output;
    /// Does it with these lanes. Kernels enter code for the processor's instructions by [`Lanes::enter`].
    fn run<V: Lanes>(self) -> Self::Output;
}

/// Does some work with these vectors.
pub fn with_lanes<W: OverLanes>(simd: Simd, work: W) -> W::Output {
    match simd {
        Simd::Scalar => work.run::<i32>(),
        #[cfg(target_arch = "x86_64")]
        Simd::Avx2(_) => work.run::<avx2::Avx2>(),
        #[cfg(target_arch = "x86_64")]
        Simd::Avx512(_) => work.run::<avx512::Avx512>(),
        #[cfg(not(target_arch = "x86_64"))]
        Simd::Avx2(never) => never.absurd(),
        #[cfg(not(target_arch = "x86_64"))]
        Simd::Avx512(never) => never.absurd(),
    }
}

/// Asks for a row of voxels, which will be read soon, from memory. Nothing but time depends on it.
#[inline(always)]
pub fn prefetch(row: &[u16]) {
    #[cfg(target_arch = "x86_64")]
    for line in row.chunks(32) {
        use std::arch::x86_64::{_MM_HINT_T1, _mm_prefetch};
        #[expect(unsafe_code, reason = "the instruction reads nothing that the program could see")]
        // SAFETY: every x86-64 processor has it, and it cannot fail.
        unsafe {
            _mm_prefetch::<_MM_HINT_T1>(line.as_ptr().cast());
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = row;
}
