//! What the pipeline had on every plane of one ray, by a tap.

use slicecast::composite::{Channel, PixelRow};
use slicecast::locate::plane;
use slicecast::plane::{ChannelOf, Pipeline, clear, scratch_len};
use slicecast::slice::Slice;
use slicecast::tap::{Beam, Tap};

use crate::lockstep::{Formats, pixel_at};
use slicecast_engine::frame::Prepared;
use slicecast_engine::pipelines::Job;
use slicecast_engine::tiles::{Tile, fold_tile};
use slicecast_model::Pixel;

/// What the pipeline had on one plane.
#[derive(Clone, Debug, Default)]
pub(super) struct Step {
    pub(super) position: [f64; 3],
    pub(super) value: Option<f64>,
    pub(super) opacity: Option<f64>,
    pub(super) colour: Option<[f64; 3]>,
    pub(super) gradient: Option<[f64; 3]>,
    pub(super) normal: Option<[f64; 3]>,
    pub(super) shaded: Option<[f64; 3]>,
    pub(super) after: Option<Pixel>,
}

/// A tap that keeps one column of one row.
struct Recorder {
    column: usize,
    formats: Formats,
    steps: Vec<Step>,
    /// The plane under way.
    plane: usize,
}

impl Recorder {
    /// The place of the column in a span, and the step to fill.
    fn here(&mut self, at: Beam<'_>, len: usize) -> Option<(usize, &mut Step)> {
        let offset = self.column.checked_sub(at.column as usize)?;
        let step = self.steps.get_mut(self.plane)?;
        (offset < len).then_some((offset, step))
    }
}

impl Tap for Recorder {
    fn plane(&mut self, plane: &slicecast::locate::Plane) {
        self.plane = plane.index as usize;
    }

    fn samples(&mut self, at: Beam<'_>, samples: &[i32]) {
        let one = self.formats.sample_one;
        if let Some((offset, step)) = self.here(at, samples.len()) {
            step.value = Some(f64::from(samples[offset]) / one);
        }
    }

    fn opacities(&mut self, at: Beam<'_>, opacities: &[i32]) {
        let formats = self.formats;
        if let Some((offset, step)) = self.here(at, opacities.len()) {
            step.opacity = Some(formats.opacity(opacities[offset]));
        }
    }

    fn colours(&mut self, at: Beam<'_>, colours: [&[i32]; 3]) {
        let one = self.formats.colour_one;
        if let Some((offset, step)) = self.here(at, colours[0].len()) {
            step.colour = Some(colours.map(|c| f64::from(c[offset] as u32) / one));
        }
    }

    fn gradients(&mut self, at: Beam<'_>, gradients: [&[i32]; 3]) {
        let one = self.formats.sample_one;
        if let Some((offset, step)) = self.here(at, gradients[0].len()) {
            step.gradient = Some(gradients.map(|g| f64::from(g[offset]) / one));
        }
    }

    fn normals(&mut self, at: Beam<'_>, g: [&[i32]; 3], r: &[i32]) {
        let formats = self.formats;
        if let Some((offset, step)) = self.here(at, r.len()) {
            step.normal = Some(formats.normal(g.map(|g| g[offset]), r[offset]));
        }
    }

    fn shaded(&mut self, at: Beam<'_>, colours: [&[i32]; 3]) {
        let one = self.formats.colour_one;
        if let Some((offset, step)) = self.here(at, colours[0].len()) {
            step.shaded = Some(colours.map(|c| f64::from(c[offset] as u32) / one));
        }
    }

    fn after<C: Channel>(&mut self, at: Beam<'_>, pixels: &PixelRow<'_, C>) {
        if let Some((offset, step)) = self.here(at, pixels.transparency.len()) {
            step.after = Some(pixel_at(pixels, offset));
        }
    }
}

/// What a ray left behind.
pub(super) struct Recorded {
    pub(super) steps: Vec<Step>,
    pub(super) formats: Formats,
    pub(super) pixel: Pixel,
}

pub(super) struct Record<'a> {
    pub(super) prepared: &'a Prepared<'a>,
    pub(super) slices: &'a [Slice<'a>],
    pub(super) ray: [usize; 2],
}

impl Job for Record<'_> {
    type Output = Recorded;

    fn run<L: Pipeline>(self, pipeline: &L) -> Recorded {
        let plan = &self.prepared.setup.plan;
        let rays = plan.sampling().rays_per_voxel as usize;
        let [u, v] = self.ray;
        let (column, row) = (u / rays, v / rays);
        let tile = Tile {
            phase: (u % rays + rays * (v % rays)) as u32,
            first: row as u32,
            rows: 1,
        };
        let step = |index| {
            let at = plane(plan, plan.phase(tile.phase), index);
            let value = |bits: i32, pixel: usize| f64::from(bits) / 65536.0 + pixel as f64;
            let position = [
                value(at.x.to_bits(), column),
                value(at.y.to_bits(), row),
                value(at.z.to_bits(), 0),
            ];
            Step {
                position,
                ..Step::default()
            }
        };
        let formats = Formats::of::<L::Precision>();
        let mut recorder = Recorder {
            column,
            formats,
            steps: (0..plan.planes()).map(step).collect(),
            plane: 0,
        };
        let ([width, _], [slice_width, _, _]) = (plan.base(), plan.dims());
        let mut data = vec![L::empty(0); L::CHANNELS * width as usize];
        clear::<L>(plan, &mut data);
        let mut scratch = vec![0; scratch_len::<L>(slice_width)];
        fold_tile(
            plan,
            pipeline,
            self.slices,
            tile,
            &mut data,
            &mut scratch,
            &mut recorder,
        );
        let pixel = pipeline.pixel(&data, column);
        let value = |c: ChannelOf<L::Precision>| {
            f64::from(c.bits()) / f64::from(<ChannelOf<L::Precision> as Channel>::ONE.bits())
        };
        Recorded {
            steps: recorder.steps,
            formats,
            pixel: Pixel {
                colour: pixel.colour.map(value),
                transparency: value(pixel.transparency),
            },
        }
    }
}
