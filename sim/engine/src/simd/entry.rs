//! The two entries to code for vectors. Only the lanes of `avx2` and `avx512` call them, and only [`super::with_lanes`] and
//! [`super::floats::with_floats`], which hold a token, name those lanes.

#![expect(unsafe_code, reason = "the entries to code for vectors")]

use slicecast::lanes::Kernel;

/// Runs a kernel compiled for AVX-512; all that it calls is inlined.
#[inline(always)]
pub fn avx512<K: Kernel>(kernel: K) -> K::Output {
    #[target_feature(enable = "avx512f,avx512bw,avx512cd,avx512dq,avx512vl,avx2,bmi1,bmi2,fma")]
    #[inline(never)]
    fn entry<K: Kernel>(kernel: K) -> K::Output {
        kernel.run()
    }
    // SAFETY: an `Avx512Token` has been made, so the processor has these instructions.
    unsafe { entry(kernel) }
}

/// Runs a kernel compiled for AVX2; all that it calls is inlined.
#[inline(always)]
pub fn avx2<K: Kernel>(kernel: K) -> K::Output {
    #[target_feature(enable = "avx2,bmi1,bmi2,fma")]
    #[inline(never)]
    fn entry<K: Kernel>(kernel: K) -> K::Output {
        kernel.run()
    }
    // SAFETY: an `Avx2Token` has been made, so the processor has these instructions.
    unsafe { entry(kernel) }
}
