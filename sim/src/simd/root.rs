//! What the vectors' reciprocal roots share (`slicecast::normalise::reciprocal_root`).

use slicecast::normalise::reciprocal_root;

/// 2^35.
pub const SCALE: f64 = 34_359_738_368.0;

/// More than the error of a root formed in f64: 2^35 / sqrt(s) is at most 2^21, and a dozen roundings of 2^-53 each
/// stay below 2^-28.
pub const MARGIN: f64 = 1.0 / 268_435_456.0;

/// The definition, lane by lane: for vectors of which a root lies within the margin of a whole number.
#[cold]
#[inline(never)]
pub fn scalar_roots<const N: usize>(s: [i32; N]) -> [i32; N] {
    s.map(|s| reciprocal_root(s as u32) as i32)
}
