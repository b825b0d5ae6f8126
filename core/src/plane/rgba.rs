//! Volumes of colour and extinction: samples of four channels, folded by one factor.

use core::marker::PhantomData;

use super::canvas::{AllFinished, Canvas as _, Image};
use super::clipped::{Clipped, Rest};
use super::extent::around;
use super::kept::{Kept, KeptRows};
use super::parts::{Columns, Parts, Samples};
use super::scratch::{self, Scratch, ScratchError, SourceRows};
use super::source::{Sheared, Source as _};
use super::{At, ChannelOf, Pipeline, Rows, composite};
use crate::composite::{FrontToBack, Pixel, Recurrence as _, Weighted};
use crate::extinction::{Medium, Rgba15};
use crate::lanes::Lanes;
use crate::plan::Plan;
use crate::precision::Precision;
use crate::rows::part;
use crate::shade::Unlit;
use crate::slice::Window;
use crate::stage::Stage;
use crate::tap::{Beam, Tap};

/// Compositing, front to back, of samples of colour and extinction (`extinction`), unlit.
#[derive(Clone, Debug)]
pub struct Rgba<P: Precision> {
    precision: P,
    medium: Medium,
    floor: ChannelOf<P>,
}

impl<P: Precision> Rgba<P> {
    /// A pipeline whose rays go on to the precision's own floor of transparency.
    pub fn new(precision: P, medium: Medium) -> Self {
        Self {
            precision,
            medium,
            floor: precision.pixel().floor(),
        }
    }

    /// Ends rays early, as [`Composite::with_early_termination`](super::Composite::with_early_termination) does.
    #[must_use]
    pub fn with_early_termination(self, bits: u32) -> Self {
        let floor = composite::floor_of(self.precision, bits);
        Self { floor, ..self }
    }
}

impl<P: Precision<Pixel: Weighted>> Rgba<P> {
    #[inline(always)]
    fn fold_plane<V: Lanes>(
        &self,
        at: &At<'_, Rgba15>,
        mut rows: Rows<'_, ChannelOf<P>>,
        scratch: &mut [i32],
        mut tap: Option<&mut dyn Tap>,
    ) -> Result<(), ScratchError> {
        let [width, _, _] = at.plan.dims();
        let (scratch, _) = scratch::with_spare(scratch, Self::SCRATCH, width, false)?;
        if let Some(tap) = &mut tap {
            tap.plane(&at.plane);
        }
        let Some(count) = rows.data.len().checked_div(4 * at.plan.base()[0] as usize) else {
            return Ok(());
        };
        let rest = Rest::of(at, false, (rows.first, count), false);
        if matches!(rest, Rest::Nothing) {
            return Ok(());
        }
        let windows: [Window<'_>; 4] = [0, 1, 2, 3].map(|run| at.window.run(run));
        // Four runs of the same shape have the same parts.
        let mut parts = windows
            .each_ref()
            .map(|_| Parts::of(at.plan, &at.plane, Columns::Alone));
        loop {
            let [t, r, g, b] = &mut parts;
            let [wt, wr, wg, wb] = &windows;
            let found = [t.samples(wt), r.samples(wr), g.samples(wg), b.samples(wb)];
            let [Some(t), Some(r), Some(g), Some(b)] = found else {
                return Ok(());
            };
            let mut runs = [t, r, g, b];
            if tap.is_none() {
                rest.narrow(at, &mut runs, false, (rows.first, count));
            }
            let memory = Scratch::cut_runs(&mut *scratch, width, V::COUNT > 1)?;
            let tap: Option<&mut dyn Tap> = match &mut tap {
                Some(tap) => Some(*tap),
                None => None,
            };
            self.fold_extent::<V>((at, &rest), runs, &mut rows, memory, tap);
        }
    }

    #[inline(always)]
    fn fold_extent<V: Lanes>(
        &self,
        (at, rest): (&At<'_, Rgba15>, &Rest<'_>),
        runs: [Samples<'_>; 4],
        rows: &mut Rows<'_, ChannelOf<P>>,
        memory: [SourceRows<'_, i32>; 4],
        mut tap: Option<&mut dyn Tap>,
    ) {
        let (plan, plane, precision) = (at.plan, &at.plane, self.precision);
        let [depths, ..] = &runs;
        let extent = &depths.extent;
        let reading = at.reading.filter(|_| depths.whole_rows);
        let base_width = plan.base()[0] as usize;
        let Some(count) = rows.data.len().checked_div(4 * base_width) else {
            return;
        };
        if extent.columns.is_empty() {
            return;
        }
        let bits = precision.formats().sample_bits;
        let absorption = self.medium.absorption(bits, extent.part.length());
        let clipped = Clipped::of(rest, at, extent, false, 0);
        let mut image = Image::<P::Pixel, FrontToBack, V>::new(
            (rows.first, &mut *rows.data),
            base_width,
            extent,
            plane.index,
            (precision.pixel(), self.floor),
        );
        let [t, r, g, b] = memory;
        let [wt, wr, wg, wb] = runs.each_ref().map(|run| &run.window);
        let mut channels = [(wt, t), (wr, r), (wg, g), (wb, b)].map(|(window, memory)| {
            Sheared::<P, V, Unlit>::new(precision, extent, window, plan.spacing(), memory, KeptRows::default())
        });
        for row in extent.met(rows.first, count) {
            let voxel_row = extent.voxel_row(row);
            if around(wt, extent.voxel_rows(voxel_row)).high == 0
                || image.finished(row)
                || clipped.as_ref().is_some_and(|clipped| clipped.is_empty(row))
            {
                continue;
            }
            if let Some(reading) = reading {
                reading.row(voxel_row);
            }
            for channel in &mut channels {
                channel.make(voxel_row);
            }
            let samples = channels.each_ref().map(|channel| channel.slab(voxel_row).back);
            let beam = Beam {
                plane,
                row,
                column: extent.columns.start as u32,
                part: 0,
            };
            if let Some(tap) = &mut tap {
                let [t, r, g, b] = &samples;
                tap.row(Stage::Interpolation, beam, &[t, r, g, b]);
                image.look(row, 0..t.len(), &mut |rows| tap.row(Stage::Before, beam, rows));
            }
            if let Some(clipped) = &clipped {
                clipped.each(row, 0..extent.columns.len(), &mut |columns, left| {
                    if left.weight() > 0 {
                        let absorption = self.medium.absorption(bits, clipped.fraction(left));
                        let samples = samples.map(|run| part(run, columns.clone()));
                        image.absorb(row, columns, samples, absorption);
                    }
                });
            } else {
                image.absorb(row, 0..extent.columns.len(), samples, absorption);
            }
            if let Some(tap) = &mut tap {
                let all = 0..extent.columns.len();
                image.look(row, all, &mut |rows| tap.row(Stage::After, beam, rows));
            }
        }
    }
}

impl<P: Precision<Pixel: Weighted>> Pipeline for Rgba<P> {
    type Precision = P;
    type Voxel = Rgba15;
    type Element = ChannelOf<P>;
    const CHANNELS: usize = 4;
    const SLICES: usize = 2;
    const SCRATCH: scratch::Rows = scratch::Rows::Colours;
    const BACK_TO_FRONT: bool = false;

    fn precision(&self) -> P {
        self.precision
    }

    fn empty(&self, channel: usize) -> ChannelOf<P> {
        composite::empty(self.precision, channel)
    }

    #[inline(always)]
    fn fold<V: Lanes>(
        &self,
        at: &At<'_, Rgba15>,
        rows: Rows<'_, ChannelOf<P>>,
        scratch: &mut [i32],
        _: Option<&mut Kept<'_>>,
        tap: Option<&mut dyn Tap>,
    ) -> Result<(), ScratchError> {
        // The products of a small machine's own lane are made for 14 bits.
        if V::SMALL {
            self.fold_plane::<i32>(at, rows, scratch, tap)
        } else {
            self.fold_plane::<V>(at, rows, scratch, tap)
        }
    }

    #[inline(always)]
    fn finished<V: Lanes>(&self, plan: &Plan, data: &[ChannelOf<P>]) -> bool {
        let width = plan.base()[0] as usize;
        let mut rows = data.chunks_exact((4 * width).max(1));
        rows.all(|row| V::enter((AllFinished, PhantomData::<V>, part(row, 3 * width..4 * width))))
    }

    fn pixel(&self, row: &[ChannelOf<P>], column: usize) -> Pixel<ChannelOf<P>> {
        composite::pixel_of_runs(self.precision, row, column)
    }
}
