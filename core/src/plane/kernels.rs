//! Row kernels of classifiers and shaders, with their lanes fixed: what the driver calls.

use core::marker::PhantomData;

use super::extent::Extent;
use super::parts::Code;
use crate::borders::{Part, WHOLE, fraction_row};
use crate::classify::{Classifier, Slab};
use crate::composite::Colours;
use crate::lanes::{Kernel, Lanes, places};
use crate::modulate::magnitude;
use crate::normalise::normalise_row;
use crate::precision::Precision;
use crate::rows::two;
use crate::shade::Shader;

/// Row kernels of a classifier.
pub(super) trait ClassifierRows<W> {
    /// The colour of every sample, where rows of it need not be made.
    fn one_colour(&self) -> Option<[u32; 3]>;
    /// Opacities of a row.
    fn opacity_row(&self, slab: Slab<'_, W>, out: &mut [W]);
    /// Colours of a row.
    fn colour_row(&self, slab: Slab<'_, W>, out: [&mut [W]; 3]);
    /// Parts into which segments of a row are cut, at most.
    fn parts(&self, slab: Slab<'_, W>) -> u32;
    /// Turns of a row of crossings.
    fn turn_row(&self, slab: Slab<'_, W>, out: &mut [W]);
}

/// Row kernels of a classifier, of a plane's parts.
pub(super) trait PartRows<W>: ClassifierRows<W> {
    /// Says of which extent rows are from now on: what of each step or segment counts.
    fn begin(&mut self, extent: &Extent, exact: Option<&'static Code>);
}

/// Row kernels of a shader.
pub(super) trait ShaderRows<W> {
    /// Whether normals are read.
    fn lit(&self) -> bool;
    /// Whether magnitudes are.
    fn modulates(&self) -> bool;
    /// Finds the places of the magnitudes of gradients.
    fn measure(&self, g: [&[W]; 3], magnitudes: &mut [W]);
    /// Puts the factors of opacities in their place, if there are any.
    fn factors(&self, magnitudes: &mut [W]) -> bool;
    /// Block-normalises gradients and makes their reciprocal lengths.
    fn normalise(&self, g: [&mut [W]; 3], r: &mut [W]);
    /// Shades colours.
    fn shade(&self, normals: ([&[W]; 3], &[W]), beside: Beside<'_, W>, colours: &mut Colours<'_, W>);
    /// Both.
    fn normalise_and_shade(
        &self,
        normals: ([&mut [W]; 3], &mut [W]),
        beside: Beside<'_, W>,
        colours: &mut Colours<'_, W>,
    );
}

/// What shading reads besides normals and colours; rows that it does not read are empty.
#[derive(Clone, Copy)]
pub(super) struct Beside<'a, W> {
    /// Of gradients.
    pub(super) magnitudes: &'a [W],
    /// Unit vectors towards the eye.
    pub(super) towards: [&'a [W]; 3],
}

/// That a precision's stages are those of 32-bit lanes: with another nothing is compiled.
pub(super) const fn staged<P: Precision>() {
    const { assert!(P::STAGED, "this precision has a pipeline of its own") };
}

/// A classifier or shader in a precision, compiled for lanes.
pub(super) struct Kernels<'a, T, P, V>(&'a T, P, Fractions, PhantomData<V>);

/// What of each step or segment counts: of a row, and of the samples at its ends, where it is less.
#[derive(Clone, Copy)]
struct Fractions {
    row: u32,
    ends: [Option<u32>; 2],
    exact: Option<&'static Code>,
}

impl<'a, T, P: Precision, V> Kernels<'a, T, P, V> {
    pub(super) const fn of(slot: &'a T, precision: P) -> Self {
        staged::<P>();
        let whole = Fractions {
            row: WHOLE,
            ends: [None; 2],
            exact: None,
        };
        Self(slot, precision, whole, PhantomData)
    }
}

impl<C: Classifier<P>, P: Precision, V: Lanes> PartRows<i32> for Kernels<'_, C, P, V> {
    #[inline(always)]
    fn begin(&mut self, extent: &Extent, exact: Option<&'static Code>) {
        self.2 = Fractions {
            row: extent.part.length(),
            ends: two(extent.ends, |end| end.map(Part::length)),
            exact,
        };
    }
}

impl<C: Classifier<P>, P: Precision, V: Lanes> ClassifierRows<i32> for Kernels<'_, C, P, V> {
    #[inline(always)]
    fn one_colour(&self) -> Option<[u32; 3]> {
        // One lane is faster without a decision at each sample.
        if const { V::COUNT > 1 } {
            self.0.one_colour(self.1)
        } else {
            None
        }
    }

    #[inline(always)]
    fn opacity_row(&self, slab: Slab<'_>, out: &mut [i32]) {
        let Fractions { row, ends, exact } = self.2;
        V::enter((OpacityRow, self, slab.at_most(row), &mut *out));
        // Segments are shorter themselves.
        let Some(exact) = exact.filter(|_| !C::SLABS) else {
            return;
        };
        let last = out.len().saturating_sub(1);
        let [first_end, last_end] = ends;
        // Of the whole opacity, which the row's fraction is about to change.
        let reduced = two([(0, first_end), (last, last_end)], |(at, fraction)| {
            match (fraction, out.get(at)) {
                (Some(fraction), Some(opacity)) if *opacity != 0 => {
                    let mut end = [*opacity];
                    (exact.reduce)(&mut end, fraction);
                    Some((at, end))
                }
                _ => None,
            }
        });
        if row < WHOLE {
            if V::SMALL {
                (exact.reduce)(out, row);
            } else {
                V::enter((FractionRow, PhantomData::<V>, &mut *out, row));
            }
        }
        for (at, [opacity]) in reduced.into_iter().flatten() {
            if let Some(out) = out.get_mut(at) {
                *out = opacity;
            }
        }
    }

    #[inline(always)]
    fn colour_row(&self, slab: Slab<'_>, out: [&mut [i32]; 3]) {
        V::enter((ColourRow, self, slab.at_most(self.2.row), out));
    }

    #[inline(always)]
    fn parts(&self, slab: Slab<'_>) -> u32 {
        if C::SLABS { V::enter((Parts, self, slab)) } else { 1 }
    }

    #[inline(always)]
    fn turn_row(&self, slab: Slab<'_>, out: &mut [i32]) {
        if C::SLABS {
            V::enter((TurnRow, self, slab, out));
        }
    }
}

struct OpacityRow;

impl<C: Classifier<P>, P: Precision, V: Lanes> Kernel for (OpacityRow, &Kernels<'_, C, P, V>, Slab<'_>, &mut [i32]) {
    type Output = ();
    const BRIEF: bool = true;

    #[inline(always)]
    fn run(self) {
        let (_, kernels, slab, out) = self;
        kernels.0.opacity_row::<V>(kernels.1, slab, out);
    }
}

struct FractionRow;

impl<V: Lanes> Kernel for (FractionRow, PhantomData<V>, &mut [i32], u32) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, _, opacities, fraction) = self;
        fraction_row::<V>(opacities, fraction);
    }
}

struct ColourRow;

impl<C: Classifier<P>, P: Precision, V: Lanes> Kernel
    for (ColourRow, &Kernels<'_, C, P, V>, Slab<'_>, [&mut [i32]; 3])
{
    type Output = ();
    const BRIEF: bool = true;

    #[inline(always)]
    fn run(self) {
        let (_, kernels, slab, out) = self;
        kernels.0.colour_row::<V>(kernels.1, slab, out);
    }
}

struct Parts;

impl<C: Classifier<P>, P: Precision, V: Lanes> Kernel for (Parts, &Kernels<'_, C, P, V>, Slab<'_>) {
    type Output = u32;

    #[inline(always)]
    fn run(self) -> u32 {
        let (_, kernels, slab) = self;
        kernels.0.parts::<V>(kernels.1, slab)
    }
}

struct TurnRow;

impl<C: Classifier<P>, P: Precision, V: Lanes> Kernel for (TurnRow, &Kernels<'_, C, P, V>, Slab<'_>, &mut [i32]) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, kernels, slab, out) = self;
        kernels.0.turn_row::<V>(kernels.1, slab, out);
    }
}

impl<S: Shader<P>, P: Precision, V: Lanes> ShaderRows<i32> for Kernels<'_, S, P, V> {
    #[inline(always)]
    fn lit(&self) -> bool {
        S::LIT
    }

    #[inline(always)]
    fn modulates(&self) -> bool {
        S::MODULATES
    }

    #[inline(always)]
    fn measure(&self, g: [&[i32]; 3], magnitudes: &mut [i32]) {
        if S::MODULATES {
            let bits = self.1.formats().sample_bits;
            V::enter((Measure, PhantomData::<V>, g, magnitudes, bits));
        }
    }

    #[inline(always)]
    fn factors(&self, magnitudes: &mut [i32]) -> bool {
        S::MODULATES && V::enter((FactorRow, self, magnitudes))
    }

    #[inline(always)]
    fn normalise(&self, g: [&mut [i32]; 3], r: &mut [i32]) {
        V::enter((Normalise, PhantomData::<V>, g, r));
    }

    #[inline(always)]
    fn shade(&self, (g, r): ([&[i32]; 3], &[i32]), beside: Beside<'_, i32>, colours: &mut Colours<'_, i32>) {
        V::enter((Shade, self, g, r, beside.magnitudes, colours));
    }

    #[inline(always)]
    fn normalise_and_shade(
        &self,
        ([x, y, z], r): ([&mut [i32]; 3], &mut [i32]),
        beside: Beside<'_, i32>,
        colours: &mut Colours<'_, i32>,
    ) {
        if self.0.reads_normals() {
            self.normalise([&mut *x, &mut *y, &mut *z], r);
        }
        self.shade(([x, y, z], r), beside, colours);
    }
}

impl<S: Shader<P>, P: Precision, V: Lanes> Kernels<'_, S, P, V> {
    /// By a constant, so that shaders that do not modulate are compiled without.
    #[inline(always)]
    fn shaded(&self, g: [&[i32]; 3], r: &[i32], magnitudes: &[i32], colours: &mut Colours<'_, i32>) {
        if S::MODULATES {
            self.0.shade_modulated_row::<V>(g, r, magnitudes, colours);
        } else {
            self.0.shade_row::<V>(g, r, colours);
        }
    }
}

struct Measure;

impl<V: Lanes> Kernel for (Measure, PhantomData<V>, [&[i32]; 3], &mut [i32], u32) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, _, [x, y, z], magnitudes, bits) = self;
        for at in places::<V>(magnitudes.len()) {
            let gradient = [V::load(x, at), V::load(y, at), V::load(z, at)];
            magnitude(gradient, bits).store(magnitudes, at);
        }
    }
}

struct FactorRow;

impl<S: Shader<P>, P: Precision, V: Lanes> Kernel for (FactorRow, &Kernels<'_, S, P, V>, &mut [i32]) {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let (_, kernels, magnitudes) = self;
        kernels.0.factor_row::<V>(magnitudes)
    }
}

struct Normalise;

impl<V: Lanes> Kernel for (Normalise, PhantomData<V>, [&mut [i32]; 3], &mut [i32]) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, _, g, r) = self;
        normalise_row::<V>(g, r);
    }
}

struct Shade;

impl<S: Shader<P>, P: Precision, V: Lanes> Kernel
    for (
        Shade,
        &Kernels<'_, S, P, V>,
        [&[i32]; 3],
        &[i32],
        &[i32],
        &mut Colours<'_, i32>,
    )
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, kernels, g, r, magnitudes, colours) = self;
        kernels.shaded(g, r, magnitudes, colours);
    }
}

/// A shader of rays that spread, whose viewer is another in each column.
pub(super) struct Towards<'a, S, P, V>(pub(super) Kernels<'a, S, P, V>);

impl<S: Shader<P>, P: Precision, V: Lanes> ShaderRows<i32> for Towards<'_, S, P, V> {
    #[inline(always)]
    fn lit(&self) -> bool {
        S::LIT
    }

    #[inline(always)]
    fn modulates(&self) -> bool {
        false
    }

    #[inline(always)]
    fn measure(&self, _: [&[i32]; 3], _: &mut [i32]) {}

    #[inline(always)]
    fn factors(&self, _: &mut [i32]) -> bool {
        false
    }

    #[inline(always)]
    fn normalise(&self, g: [&mut [i32]; 3], r: &mut [i32]) {
        self.0.normalise(g, r);
    }

    #[inline(always)]
    fn shade(&self, (g, r): ([&[i32]; 3], &[i32]), beside: Beside<'_, i32>, colours: &mut Colours<'_, i32>) {
        V::enter((ShadeTowards, self, (g, r), beside.towards, colours));
    }

    #[inline(always)]
    fn normalise_and_shade(
        &self,
        ([x, y, z], r): ([&mut [i32]; 3], &mut [i32]),
        beside: Beside<'_, i32>,
        colours: &mut Colours<'_, i32>,
    ) {
        self.0.normalise([&mut *x, &mut *y, &mut *z], r);
        self.shade(([x, y, z], r), beside, colours);
    }
}

struct ShadeTowards;

impl<S: Shader<P>, P: Precision, V: Lanes> Kernel
    for (
        ShadeTowards,
        &Towards<'_, S, P, V>,
        ([&[i32]; 3], &[i32]),
        [&[i32]; 3],
        &mut Colours<'_, i32>,
    )
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, Towards(kernels), (g, r), towards, colours) = self;
        kernels.0.shade_towards_row::<V>(g, r, towards, colours);
    }
}
