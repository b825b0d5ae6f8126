//! Reflectance map: the lights' answer to every direction, looked up by the gradient in place of being computed.
//!
//! Source: VolumePro (Pfister et al., SIGGRAPH 1999; van Scheltinga, Smit and Bosma, 1995): a cube around a sample, of which the gradient meets one
//! point. Neither a root nor a power is formed, and the number of lights does not count. Made once per view and lights ([`fill`]), in the caller's memory.
//!
//! | value | format | range |
//! |---|---|---|
//! | g | `block` of `normalise` | -32767 to 32767; the largest component m is 16384 or more, or all are 0 |
//! | q | 1.15 of twice a face's half | 0 to 2^16 |
//! | p = q (n - 1) | 16 fraction bits: node and place | 0 to (n - 1) 2^16 |
//! | entry: D, S | 1.15 each | 0 to 1: ambient and diffuse light, and specular light |
//!
//! With (a, b) the other two components, `R = floor(2^52 / (m 2^12))` and `q = ((a + m) R) >> 25`. Nearest: node `(p + 2^15) >> 16`. Bilinear: node
//! `min(p >> 16, n - 2)`, place `w = min((p - 2^16 node) >> 1, 2^15 - 1)`, and `D = D0 + (((D1 - D0) w + 2^14) >> 15)`, along a before b, S alike.
//! `c = min(1, O D + S)`, in the precision's arithmetic.
//!
//! Overflow: none. Error: docs/contract/reflectance.md. State: none.

#[cfg(test)]
mod tests;

use super::{Classified, Coloured, Matter, Phong, SamplesAndGradients, Shader, Unweighed};
use crate::composite::Colours;
use crate::lanes::{Lanes, Wide as _, places};
use crate::normalise::{block, normalise};
use crate::precision::{Precision, Shading};
use crate::rows::three;

/// The smallest and the largest number of nodes along an edge of the cube.
pub const SIDES: core::ops::RangeInclusive<u32> = 2..=256;

/// The most lanes that there are.
const LANES: usize = 16;

/// How a map is read between its nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// The nearest node.
    Nearest,
    /// Linear between four.
    Bilinear,
}

/// Why a map is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MapError {
    /// Nodes along an edge.
    Side {
        /// The number given.
        given: u32,
    },
    /// Entries for another number of nodes.
    Entries {
        /// The number needed.
        needed: usize,
        /// The number given.
        given: usize,
    },
}

impl core::fmt::Display for MapError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Side { given } => {
                let (least, most) = (SIDES.start(), SIDES.end());
                write!(
                    f,
                    "a reflectance map of {given} nodes along an edge; accepted: {least} to {most}"
                )
            }
            Self::Entries { needed, given } => {
                write!(f, "a reflectance map of {given} entries; its nodes need {needed}")
            }
        }
    }
}

impl core::error::Error for MapError {}

/// Entries of a channel: one for no gradient, and those of six faces.
const fn channel(side: u32) -> usize {
    1 + 6 * (side as usize) * (side as usize)
}

/// Entries of a map for lights, of so many nodes along an edge: of one channel where no coefficient differs between the channels, else of three.
pub fn entries<P: Precision>(phong: &Phong<P>, side: u32) -> usize {
    channel(side) * if phong.grey { 1 } else { 3 }
}

/// The answer of lights to matter of its own: one of both sums, 1.15.
#[derive(Clone, Copy)]
struct Answer {
    specular: bool,
}

impl Matter for Answer {
    #[inline(always)]
    fn colour<V: Lanes>(self, _: [&[i32]; 3], _: usize) -> [V; 3] {
        [V::splat(0); 3]
    }

    #[inline(always)]
    fn lit<P: Precision, V: Lanes>(self, p: P, _: usize, _: V, [diffuse, specular]: [V; 2]) -> V {
        let sum = if self.specular { specular } else { diffuse };
        let one = V::splat(1 << 15);
        match p.formats().shading {
            Shading::Truncated16 => (sum >> 1).at_most(one),
            // Sums of 1 are one unit short of 2^31 or beyond it.
            Shading::Rounded16 | Shading::Rounded31 => {
                let limited = sum.at_most_unsigned(V::splat(i32::MIN));
                limited.wrapping_add(V::splat(1 << 15)).shr_unsigned(16)
            }
        }
    }
}

/// Fills a map of [`entries`] with the answer of lights to the gradients at its nodes.
///
/// # Errors
/// [`MapError`]; nothing is written then.
pub fn fill<P: Precision>(phong: &Phong<P>, side: u32, map: &mut [u32]) -> Result<(), MapError> {
    check(side, map.len(), entries(phong, side))?;
    let last = (side - 1) as i32;
    let answer = |gradient: [i32; 3]| {
        let normal = normalise(gradient);
        let [x, y, z] = normal.g.map(|c| [c]);
        let sum = |specular| {
            let [mut red, mut green, mut blue] = [[0]; 3];
            let rows = [&mut red[..], &mut green, &mut blue];
            let normals = ([&x[..], &y, &z], &[normal.r as i32][..]);
            phong.shade_matter::<i32, _, _, _>(phong.parallel(), Unweighed, normals, Answer { specular }, rows);
            [red, green, blue].map(|[sum]| sum as u32)
        };
        let ([d0, d1, d2], [s0, s1, s2]) = (sum(false), sum(true));
        [d0 | s0 << 16, d1 | s1 << 16, d2 | s2 << 16]
    };
    // -32767 to 32767, to nearest.
    let along = |node: i32| (32767 * (2 * node - last) * 2 + last).div_euclid(2 * last);
    let channel = channel(side);
    let nodes = (0..6).flat_map(|face| (0..=last).flat_map(move |b| (0..=last).map(move |a| (face, a, b))));
    let gradients = nodes.map(|(face, a, b)| {
        let major = if face & 1 == 1 { -32767 } else { 32767 };
        let (a, b) = (along(a), along(b));
        match face >> 1 {
            0 => [major, a, b],
            1 => [a, major, b],
            _ => [a, b, major],
        }
    });
    for (at, gradient) in core::iter::once([0; 3]).chain(gradients).enumerate() {
        for (plane, entry) in map.chunks_exact_mut(channel).zip(answer(gradient)) {
            if let Some(place) = plane.get_mut(at) {
                *place = entry;
            }
        }
    }
    Ok(())
}

/// Checks a number of nodes along an edge.
///
/// # Errors
/// [`MapError::Side`] if it is none of [`SIDES`].
pub fn check_side(side: u32) -> Result<(), MapError> {
    if SIDES.contains(&side) {
        Ok(())
    } else {
        Err(MapError::Side { given: side })
    }
}

fn check(side: u32, given: usize, needed: usize) -> Result<(), MapError> {
    check_side(side)?;
    if given != needed {
        return Err(MapError::Entries { needed, given });
    }
    Ok(())
}

/// A shader by a reflectance map.
#[derive(Clone, Debug)]
pub struct Mapped<M, P> {
    map: M,
    side: u32,
    filter: Filter,
    grey: bool,
    precision: P,
}

impl<M: AsRef<[u32]> + Sync, P: Precision> Mapped<M, P> {
    /// A shader by a map that [`fill`] has filled for these lights.
    ///
    /// # Errors
    /// [`MapError`] if it is of another size.
    pub fn new(phong: &Phong<P>, side: u32, filter: Filter, map: M) -> Result<Self, MapError> {
        check(side, map.as_ref().len(), entries(phong, side))?;
        Ok(Self {
            map,
            side,
            filter,
            grey: phong.grey,
            precision: phong.precision,
        })
    }

    /// The colour of a sample with this gradient and classified colour. This function is the definition: a row of one.
    pub fn shade(&self, gradient: [i32; 3], colour: [u32; 3]) -> [u32; 3] {
        let [x, y, z] = gradient.map(|c| [c]);
        let [mut red, mut green, mut blue] = colour.map(|c| [c as i32]);
        let rows = [&mut red[..], &mut green, &mut blue];
        self.shade_matter::<i32, _>([&x, &y, &z], 1, Classified(None), rows);
        [red, green, blue].map(|[c]| c as u32)
    }

    #[inline(always)]
    fn shade_matter<V: Lanes, K: Matter>(
        &self,
        [x, y, z]: [&[i32]; 3],
        len: usize,
        matter: K,
        [red, green, blue]: [&mut [i32]; 3],
    ) {
        let map = self.map.as_ref();
        let (Some(x), Some(y), Some(z)) = (x.get(..len), y.get(..len), z.get(..len)) else {
            return;
        };
        let (Some(red), Some(green), Some(blue)) = (red.get_mut(..len), green.get_mut(..len), blue.get_mut(..len))
        else {
            return;
        };
        let channel = channel(self.side);
        for at in places::<V>(len) {
            let place = Place::<V>::of([V::load(x, at), V::load(y, at), V::load(z, at)], self.side, self.filter);
            let first = self.answer(part_of(map, 0, channel), place);
            let [second, third] = if self.grey {
                [first; 2]
            } else {
                [
                    self.answer(part_of(map, 1, channel), place),
                    self.answer(part_of(map, 2, channel), place),
                ]
            };
            let [r, g, b] = matter.colour([red, green, blue], at);
            matter.lit::<P, V>(self.precision, at, r, first).store(red, at);
            matter.lit::<P, V>(self.precision, at, g, second).store(green, at);
            matter.lit::<P, V>(self.precision, at, b, third).store(blue, at);
        }
    }

    /// Both sums of light of a channel, as the precision's arithmetic has them.
    #[inline(always)]
    fn answer<V: Lanes>(&self, entries: &[u32], place: Place<V>) -> [V; 2] {
        let side = self.side as i32;
        let index = place.index;
        let [diffuse, specular] = match self.filter {
            Filter::Nearest => halves(entries, index),
            Filter::Bilinear => {
                let [d0, s0] = halves(entries, index);
                let [d1, s1] = halves(entries, index + V::splat(1));
                let [d2, s2] = halves(entries, index + V::splat(side));
                let [d3, s3] = halves(entries, index + V::splat(side + 1));
                let weights = place.weights;
                [between([d0, d1, d2, d3], weights), between([s0, s1, s2, s3], weights)]
            }
        };
        match self.precision.formats().shading {
            Shading::Truncated16 => [diffuse << 1, specular << 1],
            Shading::Rounded16 | Shading::Rounded31 => [diffuse << 16, specular << 16],
        }
    }
}

/// The entries of a channel.
#[inline(always)]
fn part_of(map: &[u32], number: usize, channel: usize) -> &[u32] {
    map.get(number * channel..(number + 1) * channel).unwrap_or(&[])
}

/// Diffuse and specular light of the entries at these places.
#[inline(always)]
fn halves<V: Lanes>(entries: &[u32], index: V) -> [V; 2] {
    let entry = gathered(entries, index);
    [entry & V::splat(0xffff), entry.shr_unsigned(16)]
}

/// Between four entries, by weights along a and b.
#[inline(always)]
fn between<V: Lanes>([first, second, third, fourth]: [V; 4], [a, b]: [V; 2]) -> V {
    first.mix(second, a, 15).mix(third.mix(fourth, a, 15), b, 15)
}

/// Entries at these places.
#[inline(always)]
fn gathered<V: Lanes>(entries: &[u32], index: V) -> V {
    let (mut places, mut found) = ([0; LANES], [0; LANES]);
    let (Some(places), Some(found)) = (places.get_mut(..V::COUNT), found.get_mut(..V::COUNT)) else {
        return V::splat(0);
    };
    index.store(places, 0);
    for (place, found) in places.iter().zip(&mut *found) {
        *found = entries.get(*place as usize).copied().unwrap_or(0) as i32;
    }
    V::load(found, 0)
}

/// Where gradients meet the cube.
#[derive(Clone, Copy)]
struct Place<V> {
    /// The entry.
    index: V,
    /// Towards the next ones along a and b, 15 bits; 0 of the nearest.
    weights: [V; 2],
}

impl<V: Lanes> Place<V> {
    #[inline(always)]
    fn of(gradient: [V; 3], side: u32, filter: Filter) -> Self {
        let [x, y, z] = block(gradient);
        let (ones, side) = (V::splat(-1), side as i32);
        let [ax, ay, az] = [x.abs(), y.abs(), z.abs()];
        let along_x = ax.at_least_then(ay.at_least(az), ones);
        let along_z = (ay.at_least_then(az, ones) | along_x) ^ ones;
        let along_y = (along_x | along_z) ^ ones;
        let major = (x & along_x) | (y & along_y) | (z & along_z);
        let a = (y & along_x) | (x & (along_x ^ ones));
        let b = (y & along_z) | (z & (along_z ^ ones));
        let length = major.abs();
        // No gradient has no reciprocal, and the first entry.
        let m = length.at_least(V::splat(1 << 14));
        let reciprocal = (m << 12).reciprocal();
        let a = (a + m).product(reciprocal).shr_narrow(25) * V::splat(side - 1);
        let b = (b + m).product(reciprocal).shr_narrow(25) * V::splat(side - 1);
        let face = (along_y & V::splat(2)) | (along_z & V::splat(4)) | ((major >> 31) & V::splat(1));
        let ([u, v], [along_u, along_v]) = match filter {
            Filter::Nearest => {
                let half = V::splat(1 << 15);
                ([(a + half) >> 16, (b + half) >> 16], [V::splat(0); 2])
            }
            Filter::Bilinear => {
                let (last, most) = (V::splat(side - 2), V::splat((1 << 15) - 1));
                let (u, v) = ((a >> 16).at_most(last), (b >> 16).at_most(last));
                let along_u = ((a - (u << 16)) >> 1).at_most(most);
                let along_v = ((b - (v << 16)) >> 1).at_most(most);
                ([u, v], [along_u, along_v])
            }
        };
        let index = (face * V::splat(side) + v) * V::splat(side) + u + V::splat(1);
        Self {
            index: length.nonzero_then(index),
            weights: [length.nonzero_then(along_u), length.nonzero_then(along_v)],
        }
    }
}

impl<M: AsRef<[u32]> + Sync, P: Precision> Shader<P> for Mapped<M, P> {
    type Asked = SamplesAndGradients;

    fn reads_normals(&self) -> bool {
        false
    }

    #[inline(always)]
    fn shade_row<V: Lanes>(&self, g: [&[i32]; 3], r: &[i32], colours: &mut Colours<'_, i32>) {
        let classified = Classified(colours.one.take());
        let rows = three(colours.rows.each_mut(), |row| &mut **row);
        self.shade_matter::<V, _>(g, r.len(), classified, rows);
    }

    #[inline(always)]
    fn shade_weighted_row<V: Lanes>(&self, g: [&[i32]; 3], r: &[i32], extinction: &[i32], colours: [&mut [i32]; 3]) {
        if let Some(extinction) = extinction.get(..r.len()) {
            self.shade_matter::<V, _>(g, r.len(), Coloured(extinction), colours);
        }
    }
}
