//! Depth: where each ray meets its first surface.

use core::marker::PhantomData;

use super::clipped::{Clipped, Rest};
use super::extent::around;
use super::kept::Kept;
use super::kernels::staged;
use super::parts::{Columns, Parts, Segments, Way};
use super::scratch::{self, Scratch, ScratchError};
use super::source::{Sheared, Source};
use super::{At, ChannelOf, Pipeline, Rows};
use crate::classify::{Slab, Support};
use crate::clip::Remainder;
use crate::composite::{Channel, Pixel, Recurrence};
use crate::cut::crossed;
use crate::format::Opacity;
use crate::lanes::{Kernel, Lanes, Small, places};
use crate::plan::Plan;
use crate::precision::Precision;
use crate::rows::part_mut;
use crate::shade::SamplesAlone;
use crate::slice::Code12;
use crate::surface::{Crossings, Surface, SurfaceError, check, position, ranks, threshold};
use crate::tap::Tap;

/// What a ray holds that has met no surface.
pub const NO_DEPTH: u32 = u32::MAX;

/// The depth of the first surface that each ray meets, in planes from the first, 16.16: the number of the plane in front of the
/// crossing, and the crossing's position. Planes are those at which segments end ([`Plan::ends`]). [`NO_DEPTH`] where there is none. A face of opacity 0 is not met.
#[derive(Clone, Debug)]
pub struct Depth<P, S> {
    precision: P,
    surfaces: S,
    support: Support,
    planes: u32,
}

impl<P: Precision, S: AsRef<[Surface]>> Depth<P, S> {
    /// A pipeline that looks for surfaces, in ascending order of their values, on the planes of a plan.
    ///
    /// # Errors
    /// [`SurfaceError`] names the first that cannot be drawn.
    pub fn new(precision: P, surfaces: S, plan: &Plan) -> Result<Self, SurfaceError> {
        check(surfaces.as_ref())?;
        Ok(Self {
            precision,
            support: crossed(surfaces.as_ref()),
            surfaces,
            planes: plan.ends(),
        })
    }

    /// The position in a segment of the first surface that is met: the definition.
    pub fn first(&self, ends: [i32; 2]) -> Option<u32> {
        self.first_by::<i32>(ends)
    }

    #[inline(never)]
    fn first_by<V: Lanes>(&self, ends: [i32; 2]) -> Option<u32> {
        let (p, surfaces) = (self.precision, self.surfaces.as_ref());
        let crossings = Crossings::between(p, surfaces, ends);
        let visible = |surface: &&Surface| {
            let face = if crossings.falling() {
                &surface.back
            } else {
                &surface.front
            };
            face.opacity > Opacity::ZERO
        };
        let mut met = (0..crossings.count()).filter_map(|met| surfaces.get(crossings.surface(met)?));
        met.find(visible)
            .map(|surface| position::<V>(ends, threshold(p, surface)))
    }
}

impl<P: Precision, S: AsRef<[Surface]>> Depth<P, S> {
    /// The first surfaces in what clip planes leave of segments.
    fn find_left(&self, way: Way, depths: &mut [u32], slab: Slab<'_>, left: Remainder) {
        if left.weight() == 0 {
            return;
        }
        for (depth, (&front, &back)) in depths.iter_mut().zip(slab.front.iter().zip(slab.back)) {
            if *depth == NO_DEPTH
                && let Some(first) = self.first(left.ends([front, back]))
            {
                *depth = way.at(left.place(first));
            }
        }
    }
}

impl<P: Precision, S: AsRef<[Surface]> + Sync> Pipeline for Depth<P, S> {
    type Precision = P;
    type Voxel = Code12;
    type Element = u32;
    const CHANNELS: usize = 1;
    const SLICES: usize = 2;
    const SCRATCH: scratch::Rows = scratch::Rows::UnlitSlabs;
    const SLABS: bool = true;
    const BACK_TO_FRONT: bool = false;

    fn support(&self) -> Option<Support> {
        Some(self.support)
    }

    fn precision(&self) -> P {
        self.precision
    }

    fn empty(&self, _: usize) -> u32 {
        NO_DEPTH
    }

    #[inline(always)]
    fn fold<V: Lanes>(
        &self,
        at: &At<'_>,
        rows: Rows<'_, u32>,
        scratch: &mut [i32],
        kept: Option<&mut Kept<'_>>,
        mut tap: Option<&mut dyn Tap>,
    ) -> Result<(), ScratchError> {
        staged::<Self::Precision>();
        let (plan, plane) = (at.plan, &at.plane);
        let [width, _, _] = plan.dims();
        let (scratch, _) = scratch::with_spare(scratch, Self::SCRATCH, width, false)?;
        if let Some(tap) = &mut tap {
            tap.plane(plane);
        }
        let base_width = plan.base()[0] as usize;
        let Some(count) = rows.data.len().checked_div(base_width) else {
            return Ok(());
        };
        let rest = Rest::of(at, true, (rows.first, count), false);
        if matches!(rest, Rest::Nothing) {
            return Ok(());
        }
        let mut parts = Parts::of(plan, plane, Columns::Alone);
        let (spacing, mut kept) = (plan.spacing(), kept.filter(|_| !V::SMALL));
        while let Some(Segments { mut ends, inner, way }) = parts.segments::<V>(&at.window, false) {
            let narrowed = rest.narrow(plan, &mut ends, true, (rows.first, count));
            let [front, back] = &ends;
            let (ahead, window, extent, behind) = (&front.extent, &front.window, &back.extent, &back.window);
            let [front_rows, back_rows] = match &mut kept {
                Some(kept) if inner && !narrowed => kept.of(plane.index, [ahead, extent]),
                _ => Default::default(),
            };
            let Scratch { source, front, .. } = Scratch::cut(&mut *scratch, Self::SCRATCH, width, !V::SMALL)?;
            let mut front =
                Sheared::<P, V, SamplesAlone>::new(self.precision, ahead, window, spacing, front, front_rows);
            let mut back =
                Sheared::<P, V, SamplesAlone>::new(self.precision, extent, behind, spacing, source, back_rows);
            let clipped = Clipped::of(&rest, extent, 0);
            for row in extent.met(rows.first, count) {
                let (front_row, back_row) = (ahead.voxel_row(row), extent.voxel_row(row));
                let range = around(behind, extent.voxel_rows(back_row));
                if !self
                    .support
                    .meets(range.union(around(window, ahead.voxel_rows(front_row))))
                {
                    continue;
                }
                let start = (row - rows.first) as usize * base_width;
                let depths = part_mut(
                    &mut *rows.data,
                    start + extent.columns.start..start + extent.columns.end,
                );
                if depths.iter().all(|depth| *depth != NO_DEPTH) {
                    continue;
                }
                front.make(front_row);
                back.make(back_row);
                let slab = Slab::between(front.slab(front_row).back, back.slab(back_row).back);
                if let Some(clipped) = &clipped {
                    clipped.each(row, 0..depths.len(), &mut |columns, left| {
                        self.find_left(way, part_mut(&mut *depths, columns.clone()), slab.span(columns), left);
                    });
                } else {
                    V::enter((Find, PhantomData::<V>, self, way, depths, slab));
                }
            }
        }
        Ok(())
    }

    fn finished<V: Lanes>(&self, _: &Plan, data: &[u32]) -> bool {
        data.iter().all(|depth| *depth != NO_DEPTH)
    }

    /// A grey level: white on the first plane, black on the last one; clear where no surface is met.
    fn pixel(&self, row: &[u32], column: usize) -> Pixel<ChannelOf<P>> {
        let clear = self.precision.pixel().clear();
        let Some(depth) = row.get(column).filter(|depth| **depth != NO_DEPTH) else {
            return clear;
        };
        let one = u64::from(clear.transparency.bits());
        let all = u64::from(self.planes.saturating_sub(1).max(1)) << 16;
        let far = (u64::from(*depth) * one).checked_div(all).unwrap_or(0).min(one);
        Pixel {
            colour: [ChannelOf::<P>::from_bits((one - far) as u32); 3],
            transparency: ChannelOf::<P>::default(),
        }
    }
}

struct Find;

impl<P: Precision, S: AsRef<[Surface]>, V: Lanes> Kernel
    for (Find, PhantomData<V>, &Depth<P, S>, Way, &mut [u32], Slab<'_>)
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, _, pipeline, way, depths, slab) = self;
        let (p, surfaces) = (pipeline.precision, pipeline.surfaces.as_ref());
        for at in places::<V>(depths.len()) {
            let front = ranks(p, surfaces, V::load(slab.front, at));
            let back = ranks(p, surfaces, V::load(slab.back, at));
            if (front ^ back).all_zero() {
                continue;
            }
            let ends = slab.front.iter().zip(slab.back);
            for (depth, (&front, &back)) in depths.iter_mut().zip(ends).skip(at).take(V::COUNT) {
                if *depth != NO_DEPTH {
                    continue;
                }
                let first = if V::SMALL {
                    pipeline.first_by::<Small>([front, back])
                } else {
                    pipeline.first_by::<i32>([front, back])
                };
                if let Some(first) = first {
                    *depth = way.at(first);
                }
            }
        }
    }
}
