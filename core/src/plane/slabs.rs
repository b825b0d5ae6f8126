//! The source of slabs: the samples of a plane and of the plane in front of it, on the same rays.
//!
//! The front row is made again from the same slices, unless it was kept ([`Kept`](super::Kept)). That suffices because no slab
//! straddles a slice: a plane lies between the slices of the plane in front of it, or in the second of them.

use core::marker::PhantomData;
use core::ops::Range;

use super::extent::Extent;
use super::places::Places;
use super::probe::Probes;
use super::source::{Sheared, Source, SourceAt};
use crate::classify::Slab;
use crate::lanes::{Kernel, Lanes, places};
use crate::precision::Precision;
use crate::rows::{part_mut, three};
use crate::shade::Asked;
use crate::surface::turned;

/// Rows of slabs of sheared rays.
pub(super) struct Slabs<'s, 'w, P, V, A> {
    front: Sheared<'s, 'w, P, V, A>,
    back: Sheared<'s, 'w, P, V, A>,
    /// From a voxel row of the back plane to that of the front plane.
    rows: i32,
    gradients: [&'s mut [i32]; 3],
}

impl<'s, 'w, P: Precision, V: Lanes, A: Asked> Slabs<'s, 'w, P, V, A> {
    /// Slabs between two planes whose extents cover the same pixels.
    #[inline(always)]
    pub(super) fn new(
        [front, back]: [Sheared<'s, 'w, P, V, A>; 2],
        [front_extent, back_extent]: [&Extent; 2],
        gradients: [&'s mut [i32]; 3],
    ) -> Self {
        Self {
            front,
            back,
            rows: front_extent.y.index.wrapping_sub(back_extent.y.index),
            gradients,
        }
    }
}

impl<P: Precision, V: Lanes, A: Asked> Source<i32> for Slabs<'_, '_, P, V, A> {
    #[inline(always)]
    fn make(&mut self, row: i32) {
        self.front.make(row.wrapping_add(self.rows));
        self.back.make(row);
    }

    #[inline(always)]
    fn slab(&self, row: i32) -> Slab<'_> {
        let front = self.front.slab(row.wrapping_add(self.rows));
        Slab::between(front.back, self.back.slab(row).back)
    }

    /// The sums of both ends' gradients, whose length does not count; those of crossings lie between both.
    #[inline(always)]
    fn gradients(&mut self, row: i32, span: Range<usize>, turns: Option<&[i32]>, out: [&mut [i32]; 3]) {
        let [x, y, z] = out;
        self.back
            .gradients(row, span.clone(), None, [&mut *x, &mut *y, &mut *z]);
        let len = x.len();
        let [fx, fy, fz] = three(self.gradients.each_mut(), |row| part_mut(row, 0..len));
        let front = row.wrapping_add(self.rows);
        self.front.gradients(front, span, None, [&mut *fx, &mut *fy, &mut *fz]);
        if A::GRADIENTS {
            join::<V>([x, y, z], [&*fx, &*fy, &*fz], turns);
        }
    }
}

/// Gradients of segments, given those of both ends: their sums, or those of crossings.
#[inline(always)]
fn join<V: Lanes>(backs: [&mut [i32]; 3], fronts: [&[i32]; 3], turns: Option<&[i32]>) {
    match turns {
        None => V::enter((Sum, PhantomData::<V>, backs, fronts)),
        Some(turns) => V::enter((Between, PhantomData::<V>, backs, fronts, turns)),
    }
}

struct Sum;

impl<V: Lanes> Kernel for (Sum, PhantomData<V>, [&mut [i32]; 3], [&[i32]; 3]) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, _, sums, others) = self;
        for (sum, other) in sums.into_iter().zip(others) {
            let Some(other) = other.get(..sum.len()) else { return };
            for at in places::<V>(sum.len()) {
                (V::load(sum, at) + V::load(other, at)).store(sum, at);
            }
        }
    }
}

struct Between;

impl<V: Lanes> Kernel for (Between, PhantomData<V>, [&mut [i32]; 3], [&[i32]; 3], &[i32]) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, _, backs, fronts, turns) = self;
        for (back, front) in backs.into_iter().zip(fronts) {
            for at in places::<V>(back.len()) {
                let gradient = turned(V::load(front, at), V::load(back, at), V::load(turns, at));
                gradient.store(back, at);
            }
        }
    }
}

/// Slabs of single vectors.
pub(super) struct SlabProbes<'s, 'w, P, V> {
    pub(super) front: Probes<'s, 'w, P, V>,
    pub(super) back: Probes<'s, 'w, P, V>,
    /// Of the plane in front.
    pub(super) gradients: [&'s mut [i32]; 3],
}

impl<P: Precision, V: Lanes> SlabProbes<'_, '_, P, V> {
    /// From a voxel row and column of the back plane to those of the front plane.
    #[inline(always)]
    fn offset(&self) -> [i32; 2] {
        let (front, back) = (self.front.extent, self.back.extent);
        [
            front.y.index.wrapping_sub(back.y.index),
            front.x.index.wrapping_sub(back.x.index),
        ]
    }
}

impl<P: Precision, V: Lanes> SourceAt<i32> for SlabProbes<'_, '_, P, V> {
    #[inline(always)]
    fn samples_at(&self, places: &Places<'_>, count: usize, [front, back]: [&mut [i32]; 2]) {
        self.front.samples_from(places, self.offset(), count, front);
        self.back.samples_from(places, [0; 2], count, back);
    }

    #[inline(always)]
    fn gradients_at(
        &mut self,
        places: &Places<'_>,
        count: usize,
        chosen: &[i32],
        turns: Option<&[i32]>,
        out: [&mut [i32]; 3],
    ) {
        let ([x, y, z], offset, chosen) = (out, self.offset(), (count, chosen));
        let back = [&mut *x, &mut *y, &mut *z];
        self.back.gradients_from(places, [0; 2], chosen, back);
        let [fx, fy, fz] = three(self.gradients.each_mut(), |row| part_mut(row, 0..x.len()));
        let front = [&mut *fx, &mut *fy, &mut *fz];
        self.front.gradients_from(places, offset, chosen, front);
        join::<V>([x, y, z], [fx, fy, fz], turns);
    }
}
