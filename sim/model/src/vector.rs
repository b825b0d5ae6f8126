//! Vectors of three f64: the few operations that the stages share.

/// Scalar product `a . b`.
pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Euclidean length.
pub(super) fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// `a + b`.
pub(super) fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// `a * s`.
pub(super) fn scale(a: [f64; 3], s: f64) -> [f64; 3] {
    a.map(|c| c * s)
}

/// The unit vector along `a`; the zero vector stays zero.
pub(super) fn unit(a: [f64; 3]) -> [f64; 3] {
    match length(a) {
        0.0 => [0.0; 3],
        l => a.map(|c| c / l),
    }
}
