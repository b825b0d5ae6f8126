//! The arithmetic of shading, step by step: normals, dot products, reflection, powers, sums of light. Formats and errors
//! are stated in [`shade`](super).

use crate::format::Cosine;
use crate::lanes::{Lanes, Wide as _};
use crate::normalise::Normal;
use crate::precision::{NormalForm, Power, Precision, Shading};

/// The normal N = -g r / 2^35 with its magnitudes truncated (towards zero, so that opposite gradients have opposite
/// normals) to so many fraction bits, 1 to 15.
#[inline(always)]
pub fn formed<V: Lanes>(g: [V; 3], r: V, bits: u32) -> [V; 3] {
    let [x, y, z] = g;
    [
        formed_component(x, r, bits),
        formed_component(y, r, bits),
        formed_component(z, r, bits),
    ]
}

#[inline(always)]
fn formed_component<V: Lanes>(g: V, r: V, bits: u32) -> V {
    let magnitude = g.abs().product(r).shr_narrow(35 - bits);
    magnitude.with_sign_of(V::splat(0) - g)
}

/// [`dot_lanes`] of one sample.
#[inline]
pub fn dot<P: Precision>(normal: Normal, vector: [i32; 3]) -> Cosine {
    Cosine::from_bits(dot_lanes::<P, i32>(normal.g, normal.r as i32, vector) as u32)
}

/// The normal N = -g r / 2^35 with each component to the nearest of so many fraction bits (1 to 15), at most 1; opposite
/// gradients have opposite normals.
#[inline(always)]
pub fn formed_nearest<V: Lanes>(g: [V; 3], r: V, bits: u32) -> [V; 3] {
    let [x, y, z] = g;
    [
        nearest_component(x, r, bits),
        nearest_component(y, r, bits),
        nearest_component(z, r, bits),
    ]
}

#[inline(always)]
fn nearest_component<V: Lanes>(g: V, r: V, bits: u32) -> V {
    let product = g.abs().product(r) + V::Wide::splat(1 << (34 - bits));
    let magnitude = product.shr_narrow(35 - bits).at_most(V::splat(1 << bits));
    magnitude.with_sign_of(V::splat(0) - g)
}

/// `max(0, N . L)` with N = -g r / 2^35, 1.31 in the low half of 64 bits, where further products want it. `Formed`
/// normals are truncated first, and so are their products, at 16 fraction bits; `Nearest` ones are rounded first. The
/// vector has the precision's bits ([`keep_vector`](super::keep_vector)).
#[inline(always)]
pub fn dot_lanes<P: Precision, V: Lanes>(g: [V; 3], r: V, vector: [i32; 3]) -> V::Wide {
    let zero = V::splat(0);
    let [x, y, z] = g;
    let [lx, ly, lz] = vector;
    match P::NORMAL {
        NormalForm::Deferred if P::SHADING.vector_bits() == 15 => {
            let (lx, ly, lz) = (V::splat(-lx), V::splat(-ly), V::splat(-lz));
            // |sum| <= sqrt(3) * 32767 * 32768 < 2^31 for unit vectors; wrapping keeps others from a panic.
            let sum = x.wrapping_mul(lx).wrapping_add(y.wrapping_mul(ly));
            let sum = sum.wrapping_add(z.wrapping_mul(lz));
            // d has the 15 fraction bits of the vector and r has 35; the product is brought to 31.
            let product = sum.at_least(zero).product(r) + V::Wide::splat(1 << 18);
            product.shr_to_one(19)
        }
        NormalForm::Deferred => {
            let (lx, ly, lz) = (V::splat(lx), V::splat(ly), V::splat(lz));
            let sum = V::Wide::splat(1 << 8) - x.product_signed(lx) - y.product_signed(ly) - z.product_signed(lz);
            // Nine bits make room for r: 37 and 21 bits fit 64.
            let product = sum.at_least_zero().shr(9).times(r) + V::Wide::splat(1 << 24);
            product.shr_to_one(25)
        }
        NormalForm::Formed(bits) => {
            let (lx, ly, lz) = (V::splat(lx), V::splat(ly), V::splat(lz));
            // bits + 15 fraction bits, truncated to 16.
            let [x, y, z] = formed(g, r, bits);
            let sum = ((x * lx) >> (bits - 1)) + ((y * ly) >> (bits - 1)) + ((z * lz) >> (bits - 1));
            V::Wide::of(sum.at_least(zero).at_most(V::splat(1 << 16)) << 15)
        }
        NormalForm::Nearest(bits) => {
            let (lx, ly, lz) = (V::splat(lx), V::splat(ly), V::splat(lz));
            // |sum| < 2^30 + 2^16 for unit vectors; wrapping keeps others from a panic.
            let [x, y, z] = formed_nearest(g, r, bits);
            let sum = x
                .wrapping_mul(lx)
                .wrapping_add(y.wrapping_mul(ly))
                .wrapping_add(z.wrapping_mul(lz));
            // bits + 15 fraction bits, brought to 31; a rounded normal may be longer than 1.
            let dot = V::Wide::of(sum.at_least(zero)).shl(16 - bits);
            dot.at_most(V::Wide::splat(1 << 31))
        }
    }
}

/// R.L = 2 (N.V)(N.L) - V.L, 0 to 1, and 0 where N.V or N.L is 0. The vectors have the precision's bits.
#[inline]
pub fn reflected<P: Precision>(nv: Cosine, nl: Cosine, viewer: [i32; 3], light: [i32; 3]) -> Cosine {
    let [nv, nl] = [nv, nl].map(|c| i64::from(c.to_bits()));
    Cosine::from_bits(reflected_lanes::<P, i32>(nv, nl, along(viewer, light)) as u32)
}

/// V.L, with twice the vectors' fraction bits.
pub(super) fn along(viewer: [i32; 3], light: [i32; 3]) -> i64 {
    viewer
        .iter()
        .zip(light)
        .map(|(v, l)| i64::from(*v) * i64::from(l))
        .sum()
}

/// [`reflected`] with V.L at hand.
#[inline(always)]
pub(super) fn reflected_lanes<P: Precision, V: Lanes>(nv: V::Wide, nl: V::Wide, vl: i64) -> V::Wide {
    // 62 fraction bits, of which one less is kept: that doubles it. V.L is taken off before the shift, with no more bits
    // than it would have behind it.
    let product = nv.low_product(nl);
    let less = |vl: i64, shift: u32| product + V::Wide::splat(-(vl << shift));
    let rl = match P::SHADING {
        Shading::Rounded31 => (less(vl >> 29, 30) + V::Wide::splat(1 << 29))
            .at_least_zero()
            .shr_to_one(30),
        Shading::Rounded16 => (less(vl << 1, 30) + V::Wide::splat(1 << 29))
            .at_least_zero()
            .shr_to_one(30),
        Shading::Truncated16 => {
            let rl = less(vl >> 14, 45).at_least_zero().shr(45).shl(15);
            rl.at_most(V::Wide::splat(1 << 31))
        }
    };
    // Neither cosine has more than 31 bits: their product is 0 only if one of them is.
    product.nonzero_then(rl)
}

/// [`power_lanes`] of one cosine.
#[inline]
pub fn power<P: Precision>(x: Cosine, n: u32) -> Cosine {
    Cosine::from_bits(power_lanes::<P, i32>(i64::from(x.to_bits()), n) as u32)
}

/// `x^(2^n)` by squaring, or what a study puts in its place; 1 stays 1. Squeeze, section 4.2.2.
#[inline(always)]
pub fn power_lanes<P: Precision, V: Lanes>(x: V::Wide, n: u32) -> V {
    match P::POWER {
        Power::Rounded31 => {
            let mut x = x;
            for _ in 0..n {
                x = x.square31();
            }
            x.narrow()
        }
        Power::Truncated16 => {
            let mut x = x.shr(15);
            for _ in 0..n {
                x = x.low_product(x).shr(16);
            }
            x.narrow() << 15
        }
        Power::Parabola => {
            let one = V::splat(i32::MIN);
            let fall = one.wrapping_sub(x.narrow()).product(V::splat((1 << n) + 1)).shr(1);
            one.wrapping_sub(fall.at_most(V::Wide::splat(1 << 31)).narrow())
        }
    }
}

/// The ambient coefficient as a sum of products begins with it.
#[inline(always)]
pub(super) fn ambient<P: Precision, V: Lanes>(k: u32) -> V {
    V::splat(match P::SHADING {
        Shading::Truncated16 => k << 1,
        Shading::Rounded16 => k << 16,
        Shading::Rounded31 => k,
    } as i32)
}

/// A cosine (1.31) with the bits that products take.
#[inline(always)]
pub(super) fn for_products<P: Precision, V: Lanes>(x: V) -> V {
    match P::SHADING {
        Shading::Truncated16 => x.shr_unsigned(15),
        Shading::Rounded16 => x.wrapping_add(V::splat(1 << 14)).shr_unsigned(15),
        Shading::Rounded31 => x,
    }
}

/// A cosine times its coefficient.
#[inline(always)]
pub(super) fn weighted<P: Precision, V: Lanes>(k: u32, x: V) -> V {
    let k = V::splat(k as i32);
    match P::SHADING {
        Shading::Truncated16 => k.wrapping_mul(x).shr_unsigned(15),
        Shading::Rounded16 => k.wrapping_mul(x),
        Shading::Rounded31 => k.product(x).shr_narrow(31),
    }
}

/// The colour under this sum of light.
#[inline(always)]
pub(super) fn lit<P: Precision, V: Lanes>(colour: V, [diffuse, specular]: [V; 2]) -> V {
    let (one15, one16, one31) = (V::splat(1 << 15), V::splat(1 << 16), V::splat(i32::MIN));
    match P::SHADING {
        Shading::Truncated16 => {
            let sum = colour.wrapping_mul(diffuse.at_most(one16)).shr_unsigned(15) + specular;
            (sum >> 1).at_most(one15)
        }
        Shading::Rounded16 => {
            let m = diffuse
                .at_most_unsigned(one31)
                .wrapping_add(V::splat(1 << 14))
                .shr_unsigned(15);
            // O m is at most 1. So is the highlight; one unit less of it is the same 1.15, and keeps the sum from 2^32.
            let highlight = specular.at_most_unsigned(V::splat(i32::MAX));
            let sum = colour.wrapping_mul(m).wrapping_add(highlight);
            sum.at_most_unsigned(one31).wrapping_add(one15).shr_unsigned(16)
        }
        Shading::Rounded31 => {
            let product = colour.product(diffuse.at_most_unsigned(one31)) + V::Wide::splat(1 << 30);
            product
                .shr(31)
                .narrow()
                .saturating_add(specular)
                .at_most_unsigned(one31)
        }
    }
}
