//! The viewer as highlights see him: one vector in a parallel view, another in each column of rays that spread.

use super::arithmetic::{reflected_lanes, reflected_with};
use super::{Normals, Source};
use crate::lanes::{Lanes, Wide as _};
use crate::precision::Precision;

/// Where the viewer is.
pub(crate) trait Gaze: Copy {
    /// `max(0, N . V)`, 1.31.
    fn facing<P: Precision, V: Lanes>(self, p: P, normals: Normals<'_>, at: usize) -> V::Wide;
    /// `R . L` of the reflected viewing vector, 0 to 1, and 0 where N.V or N.L is 0.
    fn reflected<P: Precision, V: Lanes>(self, p: P, at: usize, light: &Source, nv: V::Wide, nl: V::Wide) -> V::Wide;
    /// `max(0, N . H)` of the half vector.
    fn half_way<P: Precision, V: Lanes>(self, p: P, normals: Normals<'_>, at: usize, light: &Source) -> V::Wide;
}

/// A parallel view.
#[derive(Clone, Copy)]
pub(crate) struct Parallel {
    /// -V.
    pub(super) away: [i32; 3],
}

impl Gaze for Parallel {
    #[inline(always)]
    fn facing<P: Precision, V: Lanes>(self, p: P, normals: Normals<'_>, at: usize) -> V::Wide {
        normals.dot::<P, V>(p, at, self.away)
    }

    #[inline(always)]
    fn reflected<P: Precision, V: Lanes>(self, p: P, _: usize, light: &Source, nv: V::Wide, nl: V::Wide) -> V::Wide {
        reflected_lanes::<P, V>(p, nv, nl, light.along)
    }

    #[inline(always)]
    fn half_way<P: Precision, V: Lanes>(self, p: P, normals: Normals<'_>, at: usize, light: &Source) -> V::Wide {
        normals.dot::<P, V>(p, at, light.away_from_half)
    }
}

/// Rays that spread: unit vectors towards the eye, s1.30.
#[derive(Clone, Copy)]
pub(crate) struct Spreading<'a> {
    pub(super) towards: [&'a [i32]; 3],
}

impl Spreading<'_> {
    /// V with the precision's bits, to nearest.
    #[inline(always)]
    fn kept<P: Precision, V: Lanes>(self, p: P, at: usize) -> [V; 3] {
        let [x, y, z] = self.towards;
        let cut = 30 - p.formats().shading.vector_bits();
        [
            rounded(V::load(x, at), cut),
            rounded(V::load(y, at), cut),
            rounded(V::load(z, at), cut),
        ]
    }
}

/// Without so many low bits, to nearest.
#[inline(always)]
fn rounded<V: Lanes>(c: V, cut: u32) -> V {
    if cut == 0 {
        c
    } else {
        (c + V::splat(1 << cut >> 1)) >> cut
    }
}

/// The vector that points the other way.
#[inline(always)]
fn opposite<V: Lanes>([x, y, z]: [V; 3]) -> [V; 3] {
    let zero = V::splat(0);
    [zero - x, zero - y, zero - z]
}

/// Half of a vector and of the opposite of another.
#[inline(always)]
fn half<V: Lanes>([x, y, z]: [V; 3], [ax, ay, az]: [V; 3]) -> [V; 3] {
    let one = V::splat(1);
    [(x - ax + one) >> 1, (y - ay + one) >> 1, (z - az + one) >> 1]
}

/// The same vector in all lanes.
#[inline(always)]
fn splat<V: Lanes>([x, y, z]: [i32; 3]) -> [V; 3] {
    [V::splat(x), V::splat(y), V::splat(z)]
}

/// a . b of vectors, with twice their fraction bits.
#[inline(always)]
fn product<V: Lanes>([ax, ay, az]: [V; 3], [bx, by, bz]: [V; 3]) -> V::Wide {
    ax.product_signed(bx) + ay.product_signed(by) + az.product_signed(bz)
}

impl Gaze for Spreading<'_> {
    #[inline(always)]
    fn facing<P: Precision, V: Lanes>(self, p: P, normals: Normals<'_>, at: usize) -> V::Wide {
        normals.dot_with::<P, V>(p, at, opposite(self.kept(p, at)))
    }

    #[inline(always)]
    fn reflected<P: Precision, V: Lanes>(self, p: P, at: usize, light: &Source, nv: V::Wide, nl: V::Wide) -> V::Wide {
        reflected_with::<P, V>(
            p,
            nv,
            nl,
            product(self.kept::<P, V>(p, at), opposite(splat(light.away))),
        )
    }

    /// With h = (L + V) / 2, which is as long as the cosine of half the angle between them: `(N . h) / |h|`, at most 1. No vector H is
    /// formed.
    #[inline(always)]
    fn half_way<P: Precision, V: Lanes>(self, p: P, normals: Normals<'_>, at: usize, light: &Source) -> V::Wide {
        let h: [V; 3] = half(self.kept(p, at), splat(light.away));
        let nh = normals.dot_with::<P, V>(p, at, opposite(h));
        let bits = 2 * p.formats().shading.vector_bits();
        let square = product(h, h);
        // 30 fraction bits; at most 1 and what rounding adds.
        let square = if bits >= 30 {
            square.shr(bits - 30).narrow()
        } else {
            square.shl(30 - bits).narrow()
        };
        let raised = square.leading_zeros() & V::splat(30);
        let root = square.shl_each(raised).shr_unsigned(2).reciprocal_root();
        let quotient = nh.times(root).shr_each(V::splat(21) - raised.shr_unsigned(1));
        // The square of the shortest h is 0, and so is its root.
        quotient.at_most(V::Wide::splat(1 << 31))
    }
}
