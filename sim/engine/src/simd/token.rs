//! Proofs that the processor has certain vectors.

/// The processor has been asked.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Proof;
/// No other processor has them: there is no value of this type.
#[cfg(not(target_arch = "x86_64"))]
type Proof = std::convert::Infallible;

/// Proof that the processor has AVX2, FMA, BMI1 and BMI2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Avx2Token(Proof);

/// Proof that the processor has AVX-512 (F, BW, CD, DQ, VL) and what [`Avx2Token`] proves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Avx512Token(Proof);

#[cfg(target_arch = "x86_64")]
impl Avx2Token {
    /// Asks the processor.
    pub fn detect() -> Option<Self> {
        let found = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2");
        found.then_some(Self(Proof))
    }
}

#[cfg(target_arch = "x86_64")]
impl Avx512Token {
    /// Asks the processor.
    pub fn detect() -> Option<Self> {
        let found = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512cd")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512vl")
            && Avx2Token::detect().is_some();
        found.then_some(Self(Proof))
    }

    /// The narrower vectors, which such a processor has too.
    pub const fn narrower(self) -> Avx2Token {
        Avx2Token(self.0)
    }
}

#[cfg(not(target_arch = "x86_64"))]
impl Avx2Token {
    /// None: the processor is of another kind.
    pub const fn detect() -> Option<Self> {
        None
    }

    /// There is no such value.
    pub(super) const fn absurd<R>(self) -> R {
        match self.0 {}
    }
}

#[cfg(not(target_arch = "x86_64"))]
impl Avx512Token {
    /// None: the processor is of another kind.
    pub const fn detect() -> Option<Self> {
        None
    }

    /// The narrower vectors, which such a processor has too.
    pub const fn narrower(self) -> Avx2Token {
        Avx2Token(self.0)
    }

    /// There is no such value.
    pub(super) const fn absurd<R>(self) -> R {
        match self.0 {}
    }
}
