//! What the pipeline had on every plane of one ray, by a tap.

use slicecast::borders::Borders;
use slicecast::locate::plane;
use slicecast::slice::Slice;
use slicecast::stage::Stage;
use slicecast::tap::{Beam, Bits, Tap};

use crate::lockstep::{Scales, position};
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::Prepared;
use slicecast_engine::tile::Tile;
use slicecast_engine::with_precision;
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
    scales: Scales,
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

    fn row(&mut self, stage: Stage, at: Beam<'_>, rows: &[&dyn Bits]) {
        let scales = self.scales.clone();
        let len = rows.first().map_or(0, |row| row.len());
        let Some((offset, step)) = self.here(at, len) else {
            return;
        };
        let bits = |row: usize| rows[row].bits(offset) as i32;
        let three = || [0, 1, 2].map(bits);
        match stage {
            Stage::Location | Stage::Before => {}
            Stage::Interpolation => step.value = Some(f64::from(bits(0)) / scales.sample_one),
            Stage::Opacity => step.opacity = Some(scales.opacity(bits(0))),
            Stage::Colour => step.colour = Some(scales.colour(three())),
            Stage::Gradient => step.gradient = Some(three().map(|g| f64::from(g) / scales.sample_one)),
            Stage::Normal => step.normal = scales.normal(three(), bits(3)),
            Stage::Shading => step.shaded = Some(scales.colour(three())),
            Stage::After => step.after = scales.pixels(rows).get(offset).copied(),
        }
    }
}

/// What a ray left behind.
pub(super) struct Recorded {
    pub(super) steps: Vec<Step>,
    pub(super) scales: Scales,
    pub(super) pixel: Pixel,
}

/// Folds the tile around a ray by the scalar definitions and records the ray.
pub(super) fn record(prepared: &Prepared<'_>, slices: &[Slice<'_>], ray: [usize; 2]) -> Result<Recorded, RenderError> {
    let plan = &prepared.setup.plan;
    let rays = plan.sampling().rays_per_voxel as usize;
    let [u, v] = ray;
    let (column, row) = (u / rays, v / rays);
    let tile = Tile {
        phase: (u % rays + rays * (v % rays)) as u32,
        first: row as u32,
        rows: 1,
    };
    let step = |index| {
        let at = plane(plan, plan.phase(tile.phase), index);
        let mut place = position(plan, [at.x, at.y, at.z], [column as u32, row as u32]);
        if plan.borders() != Borders::Whole {
            let held = |axis: usize| place[axis].clamp(0.0, f64::from(plan.volume()[axis] - 1));
            place = [0, 1, 2].map(held);
        }
        let position = place;
        Step {
            position,
            ..Step::default()
        }
    };
    let scales = with_precision!(prepared.scene.precision, precision => Scales::of(precision));
    let mut recorder = Recorder {
        column,
        scales: scales.clone(),
        steps: (0..plan.planes()).map(step).collect(),
        plane: 0,
    };
    let mut rendering = prepared.begun()?;
    rendering.fold_tile(slices, tile, &mut recorder);
    let base = rendering.base();
    let [width, _] = base.size;
    let [red, green, blue, transparency] = base
        .planes
        .map(|plane| f64::from(plane[v * width + u]) / f64::from(base.one));
    Ok(Recorded {
        steps: recorder.steps,
        scales,
        pixel: Pixel {
            colour: [red, green, blue],
            transparency,
        },
    })
}
