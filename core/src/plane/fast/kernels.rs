//! Row kernels of the table and of shading, with their lanes fixed.

use core::marker::PhantomData;
use core::ops::Deref;

use crate::borders::WHOLE;
use crate::classify::{Slab, opacity_of_root};
use crate::composite::Colours;
use crate::fast::{self, FastPhong, RootTable};
use crate::format::Opacity;
use crate::lanes::two::Two;
use crate::lanes::{Halves, Kernel, Lanes};
use crate::plane::extent::Extent;
use crate::plane::kernels::{Beside, ClassifierRows, ShaderRows};
use crate::plane::parts::Code;
use crate::rows::{part_mut, three};
use crate::shade::Unlit;

/// What shades in 16 bits: [`Unlit`] or [`FastPhong`].
pub trait FastShader: Sync {
    /// Whether gradients are read. Without them the pipeline holds no rows of them and two slices instead of four.
    const LIT: bool;

    /// Shades the colours of a row in place, so that its rows hold them. Rows of equal length.
    fn shade_row<H: Halves>(&self, g: [&[u16]; 3], colours: &mut Colours<'_, u16>);
}

impl FastShader for Unlit {
    const LIT: bool = false;

    #[inline(always)]
    fn shade_row<H: Halves>(&self, _: [&[u16]; 3], _: &mut Colours<'_, u16>) {}
}

impl FastShader for FastPhong {
    const LIT: bool = true;

    #[inline(always)]
    fn shade_row<H: Halves>(&self, g: [&[u16]; 3], colours: &mut Colours<'_, u16>) {
        FastPhong::shade_row::<H>(self, g, colours);
    }
}

/// A table, compiled for lanes.
pub(super) struct FastKernels<'a, T, V> {
    table: &'a T,
    /// What of each step counts, where it is less than all of it.
    part: Option<(u32, &'static Code)>,
    lanes: PhantomData<V>,
}

impl<'a, T, V> FastKernels<'a, T, V> {
    /// For the samples of an extent, whose columns count alike.
    pub(super) fn of(table: &'a T, extent: &Extent, exact: Option<&'static Code>) -> Self {
        let fraction = extent.part.length();
        Self {
            table,
            part: exact.filter(|_| fraction < WHOLE).map(|exact| (fraction, exact)),
            lanes: PhantomData,
        }
    }
}

/// Roots of opacities for parts of steps: by way of the opacities, of which there are few.
fn reduce_roots(roots: &mut [u16], fraction: u32, exact: &Code) {
    for roots in roots.chunks_mut(64) {
        let mut opacities = [0; 64];
        let opacities = part_mut(&mut opacities, 0..roots.len());
        for (opacity, root) in opacities.iter_mut().zip(&*roots) {
            *opacity = opacity_of_root(*root).to_bits() as i32;
        }
        (exact.reduce)(opacities, fraction);
        for (root, opacity) in roots.iter_mut().zip(&*opacities) {
            *root = fast::table::root_of(Opacity::from_bits(*opacity as u32));
        }
    }
}

impl<R, C, V: Lanes> ClassifierRows<u16> for FastKernels<'_, RootTable<R, C>, V>
where
    R: Deref<Target = fast::Roots>,
    C: Deref<Target = fast::Colours>,
{
    #[inline(always)]
    fn one_colour(&self) -> Option<[u32; 3]> {
        self.table.one_colour().map(|colour| three(colour, u32::from))
    }

    #[inline(always)]
    fn opacity_row(&self, slab: Slab<'_, u16>, out: &mut [u16]) {
        self.table.root_row::<V>(slab.back, out);
        if let Some((fraction, exact)) = self.part {
            reduce_roots(out, fraction, exact);
        }
    }

    #[inline(always)]
    fn colour_row(&self, slab: Slab<'_, u16>, out: [&mut [u16]; 3]) {
        self.table.colour_row::<V>(slab.back, out);
    }

    #[inline(always)]
    fn parts(&self, _: Slab<'_, u16>) -> u32 {
        1
    }

    #[inline(always)]
    fn turn_row(&self, _: Slab<'_, u16>, _: &mut [u16]) {}
}

/// A shader, compiled for lanes.
pub(super) struct Lit<'a, S, V>(&'a S, PhantomData<V>);

impl<'a, S, V> Lit<'a, S, V> {
    pub(super) const fn of(shader: &'a S) -> Self {
        Self(shader, PhantomData)
    }
}

impl<S: FastShader, V: Lanes> ShaderRows<u16> for Lit<'_, S, V> {
    #[inline(always)]
    fn lit(&self) -> bool {
        S::LIT
    }

    #[inline(always)]
    fn modulates(&self) -> bool {
        false
    }

    #[inline(always)]
    fn measure(&self, _: [&[u16]; 3], _: &mut [u16]) {}

    #[inline(always)]
    fn factors(&self, _: &mut [u16]) -> bool {
        false
    }

    /// No component is divided.
    #[inline(always)]
    fn normalise(&self, _: [&mut [u16]; 3], _: &mut [u16]) {}

    #[inline(always)]
    fn shade(&self, (g, _): ([&[u16]; 3], &[u16]), _: Beside<'_, u16>, colours: &mut Colours<'_, u16>) {
        if S::LIT {
            V::enter((ShadeRow, self, g, colours));
        }
    }

    #[inline(always)]
    fn normalise_and_shade(
        &self,
        ([x, y, z], r): ([&mut [u16]; 3], &mut [u16]),
        beside: Beside<'_, u16>,
        colours: &mut Colours<'_, u16>,
    ) {
        self.shade(([x, y, z], r), beside, colours);
    }
}

struct ShadeRow;

impl<S: FastShader, V: Lanes> Kernel for (ShadeRow, &Lit<'_, S, V>, [&[u16]; 3], &mut Colours<'_, u16>) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, lit, g, colours) = self;
        // Half as many registers would not hold two.
        if V::Halves::COUNT == 32 {
            lit.0.shade_row::<Two<V::Halves>>(g, colours);
        } else {
            lit.0.shade_row::<V::Halves>(g, colours);
        }
    }
}
