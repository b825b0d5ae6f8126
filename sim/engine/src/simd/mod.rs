//! The processor's vectors as core's lanes: chosen once a frame, the same bits with any of them.

#[cfg(target_arch = "x86_64")]
pub(crate) mod avx2;
#[cfg(target_arch = "x86_64")]
pub(crate) mod avx512;
pub mod floats;
#[cfg(target_arch = "x86_64")]
pub(crate) mod partial;
#[cfg(target_arch = "x86_64")]
mod root;
#[cfg(test)]
mod tests;

use slicecast::lanes::Lanes;

/// Which vectors do the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Simd {
    /// One lane: the scalar definition.
    Scalar,
    /// Eight lanes of AVX2 (and FMA, BMI1, BMI2).
    Avx2,
    /// Sixteen lanes of AVX-512 (F, BW, CD, DQ, VL), on processors that have the former too.
    Avx512,
}

impl Simd {
    /// All of them, narrowest first.
    pub const ALL: [Self; 3] = [Self::Scalar, Self::Avx2, Self::Avx512];

    /// The name on the command line and in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Scalar => "scalar",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }

    /// Whether this processor has it.
    pub fn available(self) -> bool {
        match self {
            Self::Scalar => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => {
                is_x86_feature_detected!("avx2")
                    && is_x86_feature_detected!("fma")
                    && is_x86_feature_detected!("bmi1")
                    && is_x86_feature_detected!("bmi2")
            }
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512bw")
                    && is_x86_feature_detected!("avx512cd")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512vl")
                    && Self::Avx2.available()
            }
            #[cfg(not(target_arch = "x86_64"))]
            _ => false,
        }
    }

    /// The widest that this processor has.
    pub fn widest() -> Self {
        let mut all = Self::ALL.into_iter().rev();
        all.find(|simd| simd.available()).unwrap_or(Self::Scalar)
    }
}

/// Work that is written over lanes.
pub trait OverLanes {
    /// What comes of it.
    type Output;
    /// Does it. An implementation is `#[inline(always)]`, and so is all that it calls: vectors stay in registers only
    /// inside the function that is compiled for them.
    fn run<V: Lanes>(self) -> Self::Output;
}

/// Does some work with these vectors; with the scalar definition where the processor has not got them.
pub fn with_lanes<W: OverLanes>(simd: Simd, work: W) -> W::Output {
    match simd {
        #[cfg(target_arch = "x86_64")]
        Simd::Avx512 if simd.available() => {
            #[target_feature(enable = "avx512f,avx512bw,avx512cd,avx512dq,avx512vl,avx2,bmi1,bmi2,fma")]
            fn entry<W: OverLanes>(work: W) -> W::Output {
                work.run::<avx512::Avx512>()
            }
            #[expect(unsafe_code, reason = "the one entry to code for AVX-512")]
            // SAFETY: the processor has it.
            unsafe {
                entry(work)
            }
        }
        #[cfg(target_arch = "x86_64")]
        Simd::Avx2 if simd.available() => {
            #[target_feature(enable = "avx2,bmi1,bmi2,fma")]
            fn entry<W: OverLanes>(work: W) -> W::Output {
                work.run::<avx2::Avx2>()
            }
            #[expect(unsafe_code, reason = "the one entry to code for AVX2")]
            // SAFETY: the processor has it.
            unsafe {
                entry(work)
            }
        }
        _ => work.run::<i32>(),
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
