//! Volumes of colour and extinction: samples of four channels, perhaps shaded, folded by one factor.

use core::fmt::Debug;
use core::marker::PhantomData;
use core::ops::Range;

use super::canvas::{Canvas as _, Image, rows_finished};
use super::clipped::{Clipped, Rest};
use super::extent::{Extent, around};
use super::kept::{Kept, KeptRows};
use super::kernels::staged;
use super::parts::{Columns, Parts, Samples};
use super::scratch::{self, ColourScratch, RunRows, ScratchError};
use super::smooth::{self, Smooth};
use super::source::{Sheared, Source as _};
use super::{At, ChannelOf, Pipeline, Rows, composite};
use crate::absorption::Medium;
use crate::composite::{FrontToBack, Pixel, Recurrence as _, Weighted};
use crate::extinction::{Eighths, Rgba15};
use crate::lanes::{Kernel, Lanes};
use crate::normalise::normalise_row;
use crate::plan::Plan;
use crate::precision::Precision;
use crate::rows::{four, part, part_mut, three};
use crate::shade::{SamplesAlone, SamplesAndGradients, Shader, Unlit};
use crate::slice::Window;
use crate::stage::Stage;
use crate::tap::{Beam, Tap};

/// How samples of colour and extinction lie between voxels.
pub trait Filter: Copy + Debug + Sync + 'static {
    /// Whether by splines of second degree, which read three slices.
    const SMOOTH: bool;
}

/// Linearly, between eight voxels ([`interpolate`](crate::interpolate)).
#[derive(Clone, Copy, Debug)]
pub struct Trilinear;

/// By a spline about the nearest of 27 ([`quadratic`](crate::quadratic)); gradients are linear between voxels all the same.
#[derive(Clone, Copy, Debug)]
pub struct Triquadratic;

impl Filter for Trilinear {
    const SMOOTH: bool = false;
}

impl Filter for Triquadratic {
    const SMOOTH: bool = true;
}

/// Compositing, front to back, of samples of colour and extinction (`extinction`), unlit or shaded by the gradient of extinction.
#[derive(Clone, Debug)]
pub struct Rgba<P: Precision, S = Unlit, F = Trilinear> {
    precision: P,
    medium: Medium,
    shader: S,
    floor: ChannelOf<P>,
    filter: PhantomData<F>,
}

impl<P: Precision> Rgba<P> {
    /// An unlit pipeline whose rays go on to the precision's own floor of transparency.
    pub fn new(precision: P, medium: Medium) -> Self {
        Self::shaded(precision, medium, Unlit)
    }
}

impl<P: Precision, S: Shader<P>> Rgba<P, S> {
    /// The same with a shader.
    pub fn shaded(precision: P, medium: Medium, shader: S) -> Self {
        Self {
            precision,
            medium,
            shader,
            floor: precision.pixel().floor(),
            filter: PhantomData,
        }
    }
}

impl<P: Precision, S, F> Rgba<P, S, F> {
    /// The same with samples that lie between voxels otherwise.
    #[must_use]
    pub fn with_filter<G: Filter>(self, _: G) -> Rgba<P, S, G> {
        Rgba {
            precision: self.precision,
            medium: self.medium,
            shader: self.shader,
            floor: self.floor,
            filter: PhantomData,
        }
    }

    /// Ends rays early, as [`Composite::with_early_termination`](super::Composite::with_early_termination) does.
    #[must_use]
    pub fn with_early_termination(self, bits: u32) -> Self {
        let floor = composite::floor_of(self.precision, bits);
        Self { floor, ..self }
    }
}

/// What is asked of a filter while rows are made.
trait Filtering: Copy {
    fn is_smooth(self) -> bool;
}

/// One whose type is known, so that a pipeline has no code of the other.
#[derive(Clone, Copy)]
struct Known<F>(PhantomData<F>);

impl<F: Filter> Filtering for Known<F> {
    #[inline(always)]
    fn is_smooth(self) -> bool {
        F::SMOOTH
    }
}

/// One whose type is not.
#[derive(Clone, Copy)]
struct AnyFilter {
    smooth: bool,
}

impl Filtering for AnyFilter {
    #[inline(always)]
    fn is_smooth(self) -> bool {
        self.smooth
    }
}

/// Row kernels of a shader of colours times extinction.
trait WeightedRows {
    /// Whether normals are read.
    fn lit(&self) -> bool;
    /// Normalises gradients and shades.
    fn shade(&self, g: [&mut [i32]; 3], r: &mut [i32], extinction: &[i32], colours: [&mut [i32]; 3]);
}

/// Those of a shader in a precision, compiled for lanes.
struct Shading<'s, S, P, V>(&'s S, PhantomData<(P, V)>);

impl<S: Shader<P>, P: Precision, V: Lanes> WeightedRows for Shading<'_, S, P, V> {
    #[inline(always)]
    fn lit(&self) -> bool {
        S::LIT
    }

    #[inline(always)]
    fn shade(&self, g: [&mut [i32]; 3], r: &mut [i32], extinction: &[i32], colours: [&mut [i32]; 3]) {
        V::enter((Shade, self, g, r, extinction, colours));
    }
}

/// The slots of a plane: as those of classified samples, a small machine compiles them with its pipeline, and elsewhere what goes
/// through a plane is compiled once for a precision and its lanes.
struct Slots<'s, P: Precision, S: ?Sized, T> {
    precision: P,
    medium: &'s Medium,
    shader: &'s S,
    floor: ChannelOf<P>,
    filter: T,
    scratch: scratch::Rows,
}

/// The source of a channel's samples.
enum Run<'s, 'w, P, V, T> {
    Linear(Sheared<'s, 'w, P, V, SamplesAlone>, T),
    Smooth(Smooth<'s, 'w, P, V>, T),
}

impl<'s, 'w, P: Precision, V: Lanes, T: Filtering> Run<'s, 'w, P, V, T> {
    #[inline(always)]
    fn new(
        (precision, filter): (P, T),
        extent: &'s Extent,
        window: &'s Window<'w>,
        plan: &Plan,
        rows: RunRows<'s, i32>,
    ) -> Self {
        match rows {
            RunRows::Linear(rows) => {
                let source = Sheared::new(precision, extent, window, plan.spacing(), rows, KeptRows::default());
                Self::Linear(source, filter)
            }
            RunRows::Smooth(rows) => Self::Smooth(Smooth::new(precision, extent, window, rows), filter),
        }
    }

    #[inline(always)]
    fn make(&mut self, row: i32) {
        match self {
            Self::Linear(source, filter) if !filter.is_smooth() => source.make(row),
            Self::Smooth(source, filter) if filter.is_smooth() => source.make(row),
            _ => {}
        }
    }

    /// The samples of the row that was made last.
    #[inline(always)]
    fn samples(&self, row: i32) -> &[i32] {
        match self {
            Self::Linear(source, filter) if !filter.is_smooth() => source.slab(row).back,
            Self::Smooth(source, filter) if filter.is_smooth() => source.samples(),
            _ => &[],
        }
    }

    /// The same, to be changed.
    #[inline(always)]
    fn samples_mut(&mut self, row: i32) -> &mut [i32] {
        match self {
            Self::Linear(source, filter) if !filter.is_smooth() => source.samples_mut(row),
            Self::Smooth(source, filter) if filter.is_smooth() => source.samples_mut(),
            _ => &mut [],
        }
    }
}

/// The rows of a plane's parts: four channels, and the source of gradients.
struct Sources<'s, 'w, P, V, T> {
    channels: [Run<'s, 'w, P, V, T>; 4],
    slopes: Sheared<'s, 'w, Eighths<P>, V, SamplesAndGradients>,
    g: [&'s mut [i32]; 3],
    r: &'s mut [i32],
}

/// Planes of slots whose types are not known.
#[inline(never)]
fn fold_plane_of<V: Lanes, P: Precision<Pixel: Weighted>>(
    slots: &Slots<'_, P, dyn WeightedRows + '_, AnyFilter>,
    at: &At<'_, Rgba15>,
    rows: Rows<'_, ChannelOf<P>>,
    scratch: &mut [i32],
    tap: Option<&mut dyn Tap>,
) -> Result<(), ScratchError> {
    slots.fold_plane::<V>(at, rows, scratch, tap)
}

impl<P: Precision<Pixel: Weighted>, S: WeightedRows + ?Sized, T: Filtering> Slots<'_, P, S, T> {
    #[inline(always)]
    fn fold_plane<V: Lanes>(
        &self,
        at: &At<'_, Rgba15>,
        mut rows: Rows<'_, ChannelOf<P>>,
        scratch: &mut [i32],
        mut tap: Option<&mut dyn Tap>,
    ) -> Result<(), ScratchError> {
        let [width, _, _] = at.plan.dims();
        let (scratch, _) = scratch::with_spare(scratch, self.scratch, width, false)?;
        if let Some(tap) = &mut tap {
            tap.plane(&at.plane);
        }
        let Some(count) = rows.data.len().checked_div(4 * at.plan.base()[0] as usize) else {
            return Ok(());
        };
        let rest = Rest::of(at, false, (rows.first, count), true);
        if matches!(rest, Rest::Nothing) {
            return Ok(());
        }
        // One by one, here and below: an array's `map` copies what it makes, and these are large.
        let windows = [at.window.run(0), at.window.run(1), at.window.run(2), at.window.run(3)];
        // Four runs of the same shape have the same parts.
        let of_run = || Parts::of(at.plan, &at.plane, Columns::Alone);
        let mut parts = [of_run(), of_run(), of_run(), of_run()];
        loop {
            let [t, r, g, b] = &mut parts;
            let [wt, wr, wg, wb] = &windows;
            let found = [
                t.samples::<V>(wt),
                r.samples::<V>(wr),
                g.samples::<V>(wg),
                b.samples::<V>(wb),
            ];
            let [Some(t), Some(r), Some(g), Some(b)] = found else {
                return Ok(());
            };
            let mut runs = [t, r, g, b];
            if tap.is_none() {
                rest.narrow(at.plan, &mut runs, false, (rows.first, count));
            }
            let memory = ColourScratch::cut(&mut *scratch, self.scratch, width, V::COUNT > 1)?;
            let tap: Option<&mut dyn Tap> = match &mut tap {
                Some(tap) => Some(*tap),
                None => None,
            };
            self.fold_extent::<V>((at, &rest), &runs, &mut rows, memory, tap);
        }
    }

    #[inline(always)]
    fn fold_extent<V: Lanes>(
        &self,
        (at, rest): (&At<'_, Rgba15>, &Rest<'_>),
        runs: &[Samples<'_>; 4],
        rows: &mut Rows<'_, ChannelOf<P>>,
        memory: ColourScratch<'_, i32>,
        mut tap: Option<&mut dyn Tap>,
    ) {
        let (plan, plane, precision) = (at.plan, &at.plane, self.precision);
        let [depths, red, green, blue] = runs;
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
        let clipped = Clipped::of(rest, extent, 0);
        let mut image = Image::<P::Pixel, FrontToBack, V>::new(
            (rows.first, &mut *rows.data),
            base_width,
            extent.columns.clone(),
            plane.index,
            (precision.pixel(), self.floor),
        );
        let [wt, wr, wg, wb] = [&depths.window, &red.window, &green.window, &blue.window];
        let [t, r, g, b] = memory.runs;
        let filtered = (precision, self.filter);
        let mut sources = Sources::<P, V, T> {
            channels: [
                Run::new(filtered, extent, wt, plan, t),
                Run::new(filtered, extent, wr, plan, r),
                Run::new(filtered, extent, wg, plan, g),
                Run::new(filtered, extent, wb, plan, b),
            ],
            slopes: Sheared::new(
                Eighths(precision),
                extent,
                wt,
                plan.spacing(),
                memory.slopes,
                KeptRows::default(),
            ),
            g: memory.g,
            r: memory.r,
        };
        let cues = clipped.as_ref().is_some_and(Clipped::cues);
        let all = 0..extent.columns.len();
        for row in extent.met(rows.first, count) {
            let voxel_row = extent.voxel_row(row);
            let range = if self.filter.is_smooth() {
                smooth::around(wt, extent, voxel_row)
            } else {
                around(wt, extent.voxel_rows(voxel_row))
            };
            if range.high == 0 || image.finished(row) || clipped.as_ref().is_some_and(|clipped| clipped.is_empty(row)) {
                continue;
            }
            if let Some(reading) = reading {
                reading.row(voxel_row);
            }
            for channel in &mut sources.channels {
                channel.make(voxel_row);
            }
            let beam = Beam {
                plane,
                row,
                column: extent.columns.start as u32,
                part: 0,
            };
            if let Some(tap) = &mut tap {
                let [t, r, g, b] = four(sources.channels.each_ref(), |channel| channel.samples(voxel_row));
                tap.row(Stage::Interpolation, beam, &[&t, &r, &g, &b]);
                image.look(row, all.clone(), &mut |rows| tap.row(Stage::Before, beam, rows));
            }
            if self.shader.lit() {
                sources.slopes.make(voxel_row);
                let mut from = 0;
                while let Some(span) = image.visible(row, sources.extinction(voxel_row), from) {
                    from = span.end;
                    let tap: Option<&mut dyn Tap> = match &mut tap {
                        Some(tap) => Some(*tap),
                        None => None,
                    };
                    self.shade_span(&mut sources, (voxel_row, span), beam, tap);
                }
            }
            let [t, colours @ ..] = &mut sources.channels;
            let t = t.samples(voxel_row);
            if cues && let Some(clipped) = &clipped {
                let colours = three(colours.each_mut(), |channel| channel.samples_mut(voxel_row));
                clipped.turn_weighted(row, 0, t, colours);
            }
            if let Some(tap) = &mut tap
                && (self.shader.lit() || cues)
            {
                let [r, g, b] = three(colours.each_ref(), |channel| channel.samples(voxel_row));
                tap.row(Stage::Shading, beam, &[&r, &g, &b]);
            }
            let [r, g, b] = three(colours.each_ref(), |channel| channel.samples(voxel_row));
            let samples = [t, r, g, b];
            if let Some(clipped) = &clipped {
                clipped.each(row, all.clone(), &mut |columns, left| {
                    if left.weight() > 0 {
                        let absorption = self.medium.absorption(bits, clipped.fraction(left));
                        let samples = four(samples, |run| part(run, columns.clone()));
                        image.absorb(row, columns, samples, absorption);
                    }
                });
            } else {
                image.absorb(row, all.clone(), samples, absorption);
            }
            if let Some(tap) = &mut tap {
                image.look(row, all.clone(), &mut |rows| tap.row(Stage::After, beam, rows));
            }
        }
    }

    /// Shades the samples of a span of the row that was made last, in place.
    #[inline(always)]
    fn shade_span<V: Lanes>(
        &self,
        sources: &mut Sources<'_, '_, P, V, T>,
        (row, span): (i32, Range<usize>),
        beam: Beam<'_>,
        mut tap: Option<&mut dyn Tap>,
    ) {
        let n = span.len();
        let beam = Beam {
            column: beam.column + span.start as u32,
            ..beam
        };
        let [gx, gy, gz] = three(sources.g.each_mut(), |row| part_mut(row, 0..n));
        let r = part_mut(sources.r, 0..n);
        let gradient = [&mut *gx, &mut *gy, &mut *gz];
        sources.slopes.gradients(row, span.clone(), None, gradient);
        if let Some(tap) = &mut tap {
            tap.row(Stage::Gradient, beam, &[&&*gx, &&*gy, &&*gz]);
        }
        let [t, colours @ ..] = &mut sources.channels;
        let t = part(t.samples(row), span.clone());
        let colours = three(colours.each_mut(), |channel| {
            part_mut(channel.samples_mut(row), span.clone())
        });
        let g = [&mut *gx, &mut *gy, &mut *gz];
        self.shader.shade(g, &mut *r, t, colours);
        if let Some(tap) = &mut tap {
            tap.row(Stage::Normal, beam, &[&&*gx, &&*gy, &&*gz, &&*r]);
        }
    }
}

impl<P: Precision, V: Lanes, T: Filtering> Sources<'_, '_, P, V, T> {
    /// The extinctions of the row that was made last.
    #[inline(always)]
    fn extinction(&self, row: i32) -> &[i32] {
        let [t, ..] = &self.channels;
        t.samples(row)
    }
}

/// Normalises gradients and shades colours times extinction.
struct Shade;

impl<P: Precision, S: Shader<P>, V: Lanes> Kernel
    for (
        Shade,
        &Shading<'_, S, P, V>,
        [&mut [i32]; 3],
        &mut [i32],
        &[i32],
        [&mut [i32]; 3],
    )
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, Shading(shader, _), [x, y, z], r, extinction, colours) = self;
        normalise_row::<V>([&mut *x, &mut *y, &mut *z], r);
        shader.shade_weighted_row::<V>([x, y, z], r, extinction, colours);
    }
}

impl<P: Precision<Pixel: Weighted>, S: Shader<P>, F: Filter> Pipeline for Rgba<P, S, F> {
    type Precision = P;
    type Voxel = Rgba15;
    type Element = ChannelOf<P>;
    const CHANNELS: usize = 4;
    const SLICES: usize = if S::LIT || F::SMOOTH { 4 } else { 2 };
    const SCRATCH: scratch::Rows = match (S::LIT, F::SMOOTH) {
        (false, false) => scratch::Rows::Colours,
        (true, false) => scratch::Rows::LitColours,
        (false, true) => scratch::Rows::SmoothColours,
        (true, true) => scratch::Rows::LitSmoothColours,
    };
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
        staged::<Self::Precision>();
        const { assert!(!S::MODULATES, "modulation is of classified samples") };
        // The products of a small machine's own lane are made for 14 bits.
        if V::SMALL {
            let slots = Slots {
                precision: self.precision,
                medium: &self.medium,
                shader: &Shading::<_, _, i32>(&self.shader, PhantomData),
                floor: self.floor,
                filter: Known::<F>(PhantomData),
                scratch: Self::SCRATCH,
            };
            slots.fold_plane::<i32>(at, rows, scratch, tap)
        } else {
            let shader: &dyn WeightedRows = &Shading::<_, _, V>(&self.shader, PhantomData);
            let slots = Slots {
                precision: self.precision,
                medium: &self.medium,
                shader,
                floor: self.floor,
                filter: AnyFilter { smooth: F::SMOOTH },
                scratch: Self::SCRATCH,
            };
            fold_plane_of::<V, _>(&slots, at, rows, scratch, tap)
        }
    }

    #[inline(always)]
    fn finished<V: Lanes>(&self, plan: &Plan, data: &[ChannelOf<P>]) -> bool {
        rows_finished::<_, V>(plan.base()[0] as usize, data)
    }

    fn pixel(&self, row: &[ChannelOf<P>], column: usize) -> Pixel<ChannelOf<P>> {
        composite::pixel_of_runs(self.precision, row, column)
    }
}
