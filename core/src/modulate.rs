//! Modulation: factors of opacity, diffuse and specular light by the magnitude of the gradient.
//!
//! Source: VolumePro (Pfister et al., SIGGRAPH 1999, gradient magnitude modulation). What is flat is weakened,
//! and surfaces remain. The magnitude is never formed: a factor is looked up by the logarithm of its square, linear between powers of 2
//! and half of them, without root and without division.
//!
//! | value | format | range |
//! |---|---|---|
//! | gradient G | s13.F | codes over two voxels of the finest spacing, -8190 to 8190 |
//! | place e of \|G\|^2 | u6.16 in half octaves, 6.15: node and fraction | 0 to 2^21 - 1 |
//! | factor f | 1.15 | 0 to 1, 1 changes nothing |
//! | opacity a | 1.31 | 0 to 1 |
//!
//! With q = |G|^2 in codes, node n of 65 stands at `q = 2^(n / 2 - 4)` (n even) or `1.5 * 2^((n - 1) / 2 - 4)` (n odd);
//! `f = t[n] + (t[n + 1] - t[n]) w` with w linear in q, to nearest. Below q = 1/16 the factor is `t[0]`.
//! `a' = (a f + 2^14) >> 15`.
//!
//! Overflow: none. Error: docs/contract/modulation.md. State: none.

#[cfg(test)]
mod tests;

use crate::composite::Colours;
use crate::format::{Intensity, Opacity};
use crate::lanes::{Lanes, Wide as _, places};
use crate::normalise::{Normal, block, room, square_of};
use crate::precision::Precision;
use crate::rows::part;
use crate::shade::{Phong, SamplesAndGradients, Shader, Weights, weighed};
use crate::table::Coding;

/// Nodes of a table of factors.
pub const NODES: usize = 65;
/// Bits of the place between two nodes.
const FRACTION: u32 = 15;
/// log2 of q at node 0.
const FIRST: i32 = -4;

/// Factors by the magnitude of the gradient.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Factors([u32; NODES]);

/// A factor above 1: it could make visible what the table makes transparent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FactorError {
    /// The node.
    pub node: usize,
    /// The factor's bits, 1.15.
    pub bits: u16,
}

impl core::fmt::Display for FactorError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { node, bits } = self;
        write!(f, "a factor of {bits}/2^15 at node {node}; accepted: at most 2^15")
    }
}

impl core::error::Error for FactorError {}

impl Default for Factors {
    /// 1, whatever the magnitude.
    fn default() -> Self {
        Self([1 << 15; NODES])
    }
}

impl Factors {
    /// Factors at the nodes.
    ///
    /// # Errors
    /// [`FactorError`], with the first factor above 1.
    pub fn new(factors: &[Intensity; NODES]) -> Result<Self, FactorError> {
        if let Some((node, factor)) = (factors.iter().enumerate()).find(|(_, factor)| **factor > Intensity::ONE) {
            let bits = factor.to_bits();
            return Err(FactorError { node, bits });
        }
        Ok(Self(factors.map(|factor| u32::from(factor.to_bits()))))
    }

    /// The factors of the places `at ..` of a row.
    #[inline(always)]
    fn at<V: Lanes>(&self, magnitudes: &[i32], at: usize) -> V {
        let coding = Coding {
            offset: 0,
            bits: FRACTION,
        };
        let [factor, next] = V::look_up(&self.0, magnitudes, at, coding);
        let fraction = V::load(magnitudes, at) & V::splat((1 << FRACTION) - 1);
        factor.mix(next, fraction, FRACTION)
    }
}

/// The place of a gradient's magnitude among the nodes, from its components with so many fraction bits.
///
/// Block normalisation has brought the largest component to 15 bits: `|G|^2 = S 2^(32 - 2 room)`, and the highest bit of S, 28 to 31,
/// is the octave.
#[inline(always)]
pub fn magnitude<V: Lanes>(gradient: [V; 3], sample_bits: u32) -> V {
    let square = square_of(block(gradient));
    let room = room(gradient);
    // No gradient has 31 too: its octave is far below the first.
    let above = square.leading_zeros().at_most(V::splat(31));
    let octave = V::splat(63 - FIRST - 2 * sample_bits as i32) - above - room - room;
    let fraction = (square.shl_each(above) & V::splat(i32::MAX)).shr_unsigned(15);
    ((octave << (FRACTION + 1)) + fraction).at_least(V::splat(0))
}

/// An opacity times a factor, to nearest. This function is the definition.
///
/// Range: the opacity at most 2^31, the factor at most 2^15.
#[inline(always)]
pub fn modulated<V: Lanes>(opacity: V, factor: V) -> V {
    (opacity.product(factor) + V::Wide::splat(1 << 14)).shr_narrow(15)
}

/// What is modulated, and by which factors.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Modulation {
    /// Of opacities.
    pub opacity: Option<Factors>,
    /// Of diffuse light.
    pub diffuse: Option<Factors>,
    /// Of specular light.
    pub specular: Option<Factors>,
}

/// A shader whose light, and opacities under it, are modulated.
#[derive(Clone, Debug)]
pub struct Modulated<P> {
    phong: Option<Phong<P>>,
    modulation: Modulation,
    precision: P,
}

impl<P: Precision> Modulated<P> {
    /// Lights, or none, with a modulation.
    pub const fn new(precision: P, phong: Option<Phong<P>>, modulation: Modulation) -> Self {
        Self {
            phong,
            modulation,
            precision,
        }
    }

    fn magnitude(&self, gradient: [i32; 3]) -> [i32; 1] {
        [magnitude(gradient, self.precision.formats().sample_bits)]
    }

    /// The opacity of a sample with this gradient. This function is the definition.
    pub fn opacity(&self, gradient: [i32; 3], opacity: Opacity) -> Opacity {
        match &self.modulation.opacity {
            Some(factors) => {
                let factor = factors.at::<i32>(&self.magnitude(gradient), 0);
                Opacity::from_bits(modulated(opacity.to_bits() as i32, factor) as u32)
            }
            None => opacity,
        }
    }

    /// The colour of a sample with this gradient and classified colour. This function is the definition: a row of one.
    pub fn shade(&self, gradient: [i32; 3], Normal { g, r }: Normal, colour: [u32; 3]) -> [u32; 3] {
        let [x, y, z] = g.map(|c| [c]);
        let [mut red, mut green, mut blue] = colour.map(|c| [c as i32]);
        let mut colours = Colours {
            one: None,
            rows: [&mut red, &mut green, &mut blue],
        };
        self.shade_modulated_row::<i32>([&x, &y, &z], &[r as i32], &self.magnitude(gradient), &mut colours);
        [red, green, blue].map(|[c]| c as u32)
    }
}

/// The factors of light along a row.
#[derive(Clone, Copy)]
struct Light<'a> {
    modulation: &'a Modulation,
    magnitudes: &'a [i32],
}

impl Light<'_> {
    #[inline(always)]
    fn weigh<P: Precision, V: Lanes>(&self, p: P, factors: Option<&Factors>, at: usize, x: V) -> V {
        match factors {
            Some(factors) => weighed::<P, V>(p, x, factors.at(self.magnitudes, at)),
            None => x,
        }
    }
}

impl Weights for Light<'_> {
    #[inline(always)]
    fn diffuse<P: Precision, V: Lanes>(&self, p: P, at: usize, x: V) -> V {
        self.weigh(p, self.modulation.diffuse.as_ref(), at, x)
    }

    #[inline(always)]
    fn specular<P: Precision, V: Lanes>(&self, p: P, at: usize, y: V) -> V {
        self.weigh(p, self.modulation.specular.as_ref(), at, y)
    }
}

impl<P: Precision> Shader<P> for Modulated<P> {
    type Asked = SamplesAndGradients;
    const MODULATES: bool = true;

    fn reads_normals(&self) -> bool {
        self.phong.is_some()
    }

    #[inline(always)]
    fn shade_row<V: Lanes>(&self, g: [&[i32]; 3], r: &[i32], colours: &mut Colours<'_, i32>) {
        self.shade_modulated_row::<V>(g, r, &[], colours);
    }

    #[inline(always)]
    fn shade_modulated_row<V: Lanes>(
        &self,
        g: [&[i32]; 3],
        r: &[i32],
        magnitudes: &[i32],
        colours: &mut Colours<'_, i32>,
    ) {
        if let Some(phong) = &self.phong {
            let light = Light {
                modulation: &self.modulation,
                magnitudes: part(magnitudes, 0..r.len()),
            };
            return phong.shade_weighed_row::<V, _>(g, r, colours, light);
        }
        if let Some(one) = colours.one.take() {
            for (row, colour) in colours.rows.iter_mut().zip(one) {
                row.fill(colour as i32);
            }
        }
    }

    /// Of volumes of colours, which do not take this shader.
    #[inline(always)]
    fn shade_weighted_row<V: Lanes>(&self, g: [&[i32]; 3], r: &[i32], extinction: &[i32], colours: [&mut [i32]; 3]) {
        if let Some(phong) = &self.phong {
            phong.shade_weighted_row::<V>(g, r, extinction, colours);
        }
    }

    #[inline(always)]
    fn factor_row<V: Lanes>(&self, magnitudes: &mut [i32]) -> bool {
        let Some(factors) = &self.modulation.opacity else {
            return false;
        };
        for at in places::<V>(magnitudes.len()) {
            factors.at::<V>(magnitudes, at).store(magnitudes, at);
        }
        true
    }
}
