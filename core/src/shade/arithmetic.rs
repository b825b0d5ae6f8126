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

/// [`dot_lanes`] of one sample and L.
#[inline]
pub fn dot<P: Precision>(p: P, normal: Normal, vector: [i32; 3]) -> Cosine {
    Cosine::from_bits(dot_lanes::<P, i32>(p, normal.g, normal.r as i32, opposite(vector)) as u32)
}

/// A vector that points the other way.
pub(super) fn opposite(vector: [i32; 3]) -> [i32; 3] {
    vector.map(|c| -c)
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
/// normals are truncated first, and so are their products, at 16 fraction bits; `Nearest` ones are rounded first. `away`
/// is -L, with the precision's bits ([`keep_vector`](super::keep_vector)): g points away from the normal.
#[inline(always)]
pub fn dot_lanes<P: Precision, V: Lanes>(p: P, g: [V; 3], r: V, away: [i32; 3]) -> V::Wide {
    let [ax, ay, az] = away;
    dot_with(p, g, r, [V::splat(ax), V::splat(ay), V::splat(az)])
}

/// [`dot_lanes`] with another vector in each lane.
#[inline(always)]
pub(super) fn dot_with<P: Precision, V: Lanes>(p: P, g: [V; 3], r: V, away: [V; 3]) -> V::Wide {
    let zero = V::splat(0);
    let [x, y, z] = g;
    let [ax, ay, az] = away;
    match p.formats().normal {
        NormalForm::Deferred if p.formats().shading.vector_bits() == 15 => {
            // |sum| <= sqrt(3) * 32767 * 32768 < 2^31 for unit vectors; wrapping keeps others from a panic.
            let sum = x.wrapping_mul(ax).wrapping_add(y.wrapping_mul(ay));
            let sum = sum.wrapping_add(z.wrapping_mul(az));
            // d has the 15 fraction bits of the vector and r has 35; the product is brought to 31.
            let product = sum.at_least(zero).product(r) + V::Wide::splat(1 << 18);
            product.shr_to_one(19)
        }
        NormalForm::Deferred => {
            let sum = V::Wide::splat(1 << 8) + x.product_signed(ax) + y.product_signed(ay) + z.product_signed(az);
            // Nine bits make room for r: 37 and 21 bits fit 64.
            let product = sum.at_least_zero().shr(9).times(r) + V::Wide::splat(1 << 24);
            product.shr_to_one(25)
        }
        NormalForm::Formed(bits) => {
            let (lx, ly, lz) = (zero - ax, zero - ay, zero - az);
            // bits + 15 fraction bits, truncated to 16.
            let [x, y, z] = formed(g, r, bits);
            let sum = ((x * lx) >> (bits - 1)) + ((y * ly) >> (bits - 1)) + ((z * lz) >> (bits - 1));
            V::Wide::of(sum.at_least(zero).at_most(V::splat(1 << 16)) << 15)
        }
        NormalForm::Nearest(bits) => {
            let (lx, ly, lz) = (zero - ax, zero - ay, zero - az);
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
pub fn reflected<P: Precision>(p: P, nv: Cosine, nl: Cosine, viewer: [i32; 3], light: [i32; 3]) -> Cosine {
    let [nv, nl] = [nv, nl].map(|c| i64::from(c.to_bits()));
    Cosine::from_bits(reflected_lanes::<P, i32>(p, nv, nl, along(viewer, light)) as u32)
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
pub(super) fn reflected_lanes<P: Precision, V: Lanes>(p: P, nv: V::Wide, nl: V::Wide, vl: i64) -> V::Wide {
    // 62 fraction bits, of which one less is kept: that doubles it. V.L is taken off before the shift, with no more bits
    // than it would have behind it.
    let (less, half, shift) = match p.formats().shading {
        Shading::Rounded31 => (vl >> 29 << 30, 1 << 29, 30),
        Shading::Rounded16 => (vl << 31, 1 << 29, 30),
        Shading::Truncated16 => (vl >> 14 << 45, 0, 45),
    };
    let product = nv.low_product(nl);
    let rl = (product + V::Wide::splat(half - less)).at_least_zero();
    let rl = match p.formats().shading {
        Shading::Truncated16 => rl.shr(shift).shl(15).at_most(V::Wide::splat(1 << 31)),
        _ => rl.shr_to_one(shift),
    };
    // Neither cosine has more than 31 bits: their product is 0 only if one of them is. With V.L from 0 on, rl is 0 then.
    if vl < 0 { product.nonzero_then(rl) } else { rl }
}

/// [`reflected_lanes`] with another V.L in each lane.
#[inline(always)]
pub(super) fn reflected_with<P: Precision, V: Lanes>(p: P, nv: V::Wide, nl: V::Wide, vl: V::Wide) -> V::Wide {
    // Bits that a shift without sign fills are shifted out again.
    let (less, half, shift) = match p.formats().shading {
        Shading::Rounded31 => (vl.shr(29).shl(30), 1 << 29, 30),
        Shading::Rounded16 => (vl.shl(31), 1 << 29, 30),
        Shading::Truncated16 => (vl.shr(14).shl(45), 0, 45),
    };
    let product = nv.low_product(nl);
    let rl = (product + V::Wide::splat(half) - less).at_least_zero();
    let rl = match p.formats().shading {
        Shading::Truncated16 => rl.shr(shift).shl(15).at_most(V::Wide::splat(1 << 31)),
        _ => rl.shr_to_one(shift),
    };
    product.nonzero_then(rl)
}

/// [`power_lanes`] of one cosine.
#[inline]
pub fn power<P: Precision>(p: P, x: Cosine, n: u32) -> Cosine {
    Cosine::from_bits(power_lanes::<P, i32>(p, i64::from(x.to_bits()), n) as u32)
}

/// `x^(2^n)` by squaring, or what a study puts in its place; 1 stays 1. Squeeze, section 4.2.2.
#[inline(always)]
pub fn power_lanes<P: Precision, V: Lanes>(p: P, x: V::Wide, n: u32) -> V {
    match p.formats().power {
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
pub(super) fn ambient<P: Precision, V: Lanes>(p: P, k: u32) -> V {
    V::splat(match p.formats().shading {
        Shading::Truncated16 => k << 1,
        Shading::Rounded16 => (k << 16).min(i32::MAX as u32),
        Shading::Rounded31 => k,
    } as i32)
}

/// A cosine (1.31) with the bits that products take.
#[inline(always)]
pub(super) fn for_products<P: Precision, V: Lanes>(p: P, x: V) -> V {
    match p.formats().shading {
        Shading::Truncated16 => x.shr_unsigned(15),
        Shading::Rounded16 => x.wrapping_add(V::splat(1 << 14)).shr_unsigned(15),
        Shading::Rounded31 => x,
    }
}

/// A cosine, with the bits that products take, times a factor, 1.15 and at most 1: to nearest, in the paper's arithmetic truncated.
#[inline(always)]
pub(crate) fn weighed<P: Precision, V: Lanes>(p: P, x: V, factor: V) -> V {
    match p.formats().shading {
        Shading::Truncated16 => x.wrapping_mul(factor).shr_unsigned(15),
        // At most 2^31 + 2^14.
        Shading::Rounded16 => x.wrapping_mul(factor).wrapping_add(V::splat(1 << 14)).shr_unsigned(15),
        Shading::Rounded31 => (x.product(factor) + V::Wide::splat(1 << 14)).shr_narrow(15),
    }
}

/// A cosine times its coefficient.
#[inline(always)]
pub(super) fn weighted<P: Precision, V: Lanes>(p: P, k: u32, x: V) -> V {
    let k = V::splat(k as i32);
    match p.formats().shading {
        Shading::Truncated16 => k.wrapping_mul(x).shr_unsigned(15),
        Shading::Rounded16 => k.wrapping_mul(x),
        Shading::Rounded31 => k.product(x).shr_narrow(31),
    }
}

/// A sum of light and one more product. It saturates where 1 is reached, or one unit below where that is the same 1.15.
#[inline(always)]
pub(super) fn brighter<P: Precision, V: Lanes>(p: P, sum: V, product: V) -> V {
    match p.formats().shading {
        Shading::Truncated16 => sum + product,
        Shading::Rounded16 => sum.wrapping_add(product).at_most_unsigned(V::splat(i32::MAX)),
        Shading::Rounded31 => sum.saturating_add(product),
    }
}

/// The colour under these sums of light.
#[inline(always)]
pub(super) fn lit<P: Precision, V: Lanes>(p: P, colour: V, [diffuse, specular]: [V; 2]) -> V {
    let (one15, one16, one31) = (V::splat(1 << 15), V::splat(1 << 16), V::splat(i32::MIN));
    match p.formats().shading {
        Shading::Truncated16 => {
            let sum = colour.wrapping_mul(diffuse.at_most(one16)).shr_unsigned(15) + specular;
            (sum >> 1).at_most(one15)
        }
        Shading::Rounded16 => {
            let m = diffuse.wrapping_add(V::splat(1 << 14)).shr_unsigned(15);
            // O m is at most 1, and what the highlight leaves of 1.
            let room = one31.wrapping_sub(specular);
            let sum = colour.wrapping_mul(m).at_most_unsigned(room);
            sum.wrapping_add(specular.wrapping_add(one15)).shr_unsigned(16)
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

/// A colour times extinction under these sums of light, at most the extinction: `min(s_t, (s_k D + s_t E + 2^30) >> 31)`, D and E
/// in 1.31. Extinctions are below 2^30, so no product passes 2^61.
#[inline(always)]
pub(super) fn lit_weighted<P: Precision, V: Lanes>(p: P, extinction: V, colour: V, [diffuse, specular]: [V; 2]) -> V {
    let (one16, one31) = (V::splat(1 << 16), V::splat(i32::MIN));
    let [diffuse, specular] = match p.formats().shading {
        Shading::Truncated16 => [diffuse.at_most(one16) << 15, specular.at_most(one16) << 15],
        // 1.16 first, in which ambient light of 1 is 1.
        Shading::Rounded16 => [diffuse.wrapping_add(V::splat(1 << 14)).shr_unsigned(15) << 15, specular],
        Shading::Rounded31 => [diffuse.at_most_unsigned(one31), specular.at_most_unsigned(one31)],
    };
    let sum = colour.product(diffuse) + extinction.product(specular) + V::Wide::splat(1 << 30);
    sum.shr_narrow(31).at_most(extinction)
}
