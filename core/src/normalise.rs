//! Normalisation: a gradient's direction, whatever its length.
//!
//! The largest component is brought to 15 bits (block normalisation: weak gradients keep their direction), and the
//! reciprocal length of the result is kept beside it. Shading multiplies by it last; the normal itself is formed only
//! for export and for the `Paper` precision (Squeeze, section 4.3.2: 1.12).
//!
//! | value | format | range |
//! |---|---|---|
//! | G | s13.F, any scale | below 2^31 |
//! | g | s15.0 | -32767 to 32767 |
//! | S = g . g | u32 | 0, or 2^28 to 3 * 32767^2 |
//! | r = floor(2^35 / sqrt(S)) | u32 | 605414 to 2^21; 0 for S = 0 |
//!
//! Rounding of g: to nearest on magnitudes (negating G negates g), saturated at 32767. r is a mathematical
//! definition, the largest r with r^2 S <= 2^70; any implementation can meet it with one residual test. Error: 3
//! millidegrees of angle, 2^-19.2 of length. Overflow: none. State: none.

use crate::format::{ReciprocalNorm, Unit};
use crate::lanes::{Lanes, places};
use crate::rows::{part_mut, three};

/// A block-normalised gradient and its reciprocal length: the direction is `g * r / 2^35`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Normal {
    /// Components, 15 bits and sign.
    pub g: [i32; 3],
    /// Reciprocal length; 0 for no gradient.
    pub r: ReciprocalNorm,
}

/// Direction of a gradient. This function is the definition.
#[inline]
pub fn normalise(gradient: [i32; 3]) -> Normal {
    let g = block(gradient);
    let r = square_of(g).reciprocal_root() as u32;
    Normal { g, r }
}

/// S.
#[inline(always)]
pub(crate) fn square_of<V: Lanes>([x, y, z]: [V; 3]) -> V {
    (x * x).wrapping_add(y * y).wrapping_add(z * z)
}

/// Brings the largest component of a gradient to 15 bits: to 31 first, which loses nothing, and 16 are rounded off.
#[inline(always)]
pub fn block<V: Lanes>(gradient: [V; 3]) -> [V; 3] {
    let ([x, y, z], room) = (gradient, room(gradient));
    [raised(x, room), raised(y, room), raised(z, room)]
}

/// Bits that the largest component of a gradient has above it.
#[inline(always)]
pub(crate) fn room<V: Lanes>([x, y, z]: [V; 3]) -> V {
    // -2^31 has no room, and counts as 2^31 - 1.
    ((x.abs() | y.abs() | z.abs()).leading_zeros() - V::splat(1)).at_least(V::splat(0))
}

/// The upper 15 bits of a component's 31 after a left shift, its magnitude rounded to nearest and saturated at 32767.
#[inline(always)]
fn raised<V: Lanes>(c: V, by: V) -> V {
    let magnitude = c.abs().shl_each(by).wrapping_add(V::splat(1 << 15)).shr_unsigned(16);
    magnitude.limited(32767).with_sign_of(c)
}

/// The unit normal, s1.15, `min(32768, (|g| r + 2^19) >> 20)` with the sign of g: for export.
#[inline]
pub fn unit(normal: Normal) -> [Unit; 3] {
    normal.g.map(|c| {
        let magnitude = ((u64::from(c.unsigned_abs()) * u64::from(normal.r) + (1 << 19)) >> 20).min(32768) as i32;
        Unit::from_bits(if c < 0 { -magnitude } else { magnitude })
    })
}

/// Applies [`normalise`] along rows, in place; `r` receives the reciprocal lengths. All rows equally long.
///
/// In two passes over a few vectors at a time: one chain of dependent operations as long as both would leave a
/// processor waiting.
#[inline(always)]
pub fn normalise_row<V: Lanes>(g: [&mut [i32]; 3], r: &mut [i32]) {
    let ([x, y, z], len) = (g, r.len());
    let (Some(x), Some(y), Some(z)) = (x.get_mut(..len), y.get_mut(..len), z.get_mut(..len)) else {
        return;
    };
    if const { V::COUNT > 1 } {
        return normalise_row_by::<V, 4>([x, y, z], r);
    }
    for at in places::<V>(len) {
        let one = at..at + 1;
        let g = three([&mut *x, &mut *y, &mut *z], |row| part_mut(row, one.clone()));
        normalise_row_by::<V, 1>(g, part_mut(r, one));
    }
}

/// `B` vectors at a time.
#[inline(always)]
fn normalise_row_by<V: Lanes, const B: usize>(g: [&mut [i32]; 3], r: &mut [i32]) {
    let [x, y, z] = g;
    for start in (0..r.len()).step_by(B * V::COUNT) {
        let places = (start..r.len()).step_by(V::COUNT);
        let mut squares = [V::splat(0); B];
        for (square, at) in squares.iter_mut().zip(places.clone()) {
            let [gx, gy, gz] = block([V::load(x, at), V::load(y, at), V::load(z, at)]);
            *square = square_of([gx, gy, gz]);
            gx.store(x, at);
            gy.store(y, at);
            gz.store(z, at);
        }
        for (square, at) in squares.into_iter().zip(places) {
            square.reciprocal_root().store(r, at);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn is_root(s: u32, r: u32) -> bool {
        let (s, r) = (u128::from(s), u128::from(r));
        r * r * s <= 1 << 70 && (r + 1) * (r + 1) * s > 1 << 70
    }

    #[test]
    fn the_lowest_number_is_a_gradient_too() {
        assert_eq!(block([i32::MIN, 1 << 30, -(1 << 15)]), [-32767, 1 << 14, -1]);
        assert_eq!(block([-i32::MAX, 1 << 30, -(1 << 15)]), [-32767, 1 << 14, -1]);
    }

    proptest! {
        #[test]
        fn block_rounds_magnitudes_to_nearest(g in prop::array::uniform3(any::<i32>()), shift in 0u32..32) {
            let g = g.map(|c| c >> shift);
            let bits = 32 - g.iter().fold(0, |all, c| all | c.unsigned_abs()).leading_zeros();
            let scale = 2f64.powi(15 - bits as i32);
            for (b, c) in block(g).into_iter().zip(g) {
                let magnitude = (f64::from(c).abs() * scale + 0.5).floor().min(32767.0);
                prop_assert_eq!(f64::from(b), magnitude.copysign(f64::from(c)) + 0.0);
            }
        }

        #[test]
        fn block_keeps_the_direction(g in prop::array::uniform3(-(1i32 << 30)..(1 << 30)), shift in 0u32..30) {
            let g = g.map(|c| c >> shift);
            let n = normalise(g);
            if g == [0; 3] {
                prop_assert_eq!(n, Normal::default());
            } else {
                prop_assert!(is_root(n.g.iter().map(|c| (c * c) as u32).sum(), n.r));
                let length = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
                let (a, b) = (g.map(f64::from), n.g.map(f64::from));
                let [ax, ay, az] = a;
                let [bx, by, bz] = b;
                let cross = [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx];
                prop_assert!(length(cross) / (length(a) * length(b)) < 3e-3f64.to_radians());
                let mirrored = normalise(g.map(|c| -c));
                prop_assert_eq!((mirrored.g.map(|c| -c), mirrored.r), (n.g, n.r));
            }
        }

        #[test]
        fn rows_are_the_scalar(rows in prop::collection::vec(any::<[i16; 3]>(), 0..34)) {
            let mut g = [0, 1, 2].map(|a| rows.iter().map(|v| i32::from(v[a])).collect::<std::vec::Vec<_>>());
            let mut r = std::vec![0; rows.len()];
            let [x, y, z] = &mut g;
            normalise_row::<i32>([x, y, z], &mut r);
            for (i, v) in rows.iter().enumerate() {
                let n = normalise(v.map(i32::from));
                prop_assert_eq!(([g[0][i], g[1][i], g[2][i]], r[i] as u32), (n.g, n.r));
            }
        }
    }
}
