//! Errors and speed of one configuration, by the pipeline itself.

use std::time::{Duration, Instant};

use slicecast::locate::plane;
use slicecast::plan::Plan;
use slicecast::plane::{ChannelOf, Composite};
use slicecast::shade::Unlit;
use slicecast::slice::{Code12, Slice};

use super::codes::Coded;
use super::formats::Study;
use slicecast_compare::Tiles;
use slicecast_compare::fast::FastLockstep;
use slicecast_compare::image::{ImageFigures, base_figures};
use slicecast_compare::lockstep::Lockstep;
use slicecast_compare::stages::{StageErrors, StageReport};
use slicecast_engine::error::CameraError;
use slicecast_engine::error::RenderError;
use slicecast_engine::expanded::Expanded;
use slicecast_engine::folds::Folds;
use slicecast_engine::frame::Prepared;
use slicecast_engine::image::BaseImage;
use slicecast_engine::oriented::Turned;
use slicecast_engine::parameters::Parameters;
use slicecast_engine::pipelines::{compile, early, rendering, rendering_over};
use slicecast_engine::rendering::{Rendering, Under, in_memory_order, tapped};
use slicecast_engine::table::{Correction, Filled, fill};
use slicecast_engine::tile::TILE_ROWS;
use slicecast_engine::tile::Tile;
use slicecast_engine::{with_pixel, with_precision};
use slicecast_model::Model;
use slicecast_scene::{AlphaCodeName, LookupName, PrecisionName, Scene};

/// A scene that configurations are run on.
#[derive(Clone, Copy)]
pub struct Bench<'a> {
    /// The scene, its plan as the configuration has it.
    pub prepared: &'a Prepared<'a>,
    /// The f64 model, at the positions of the full step.
    pub model: &'a Model<'a>,
    /// The slices in the view's order.
    pub slices: &'a [Slice<'a>],
}

/// What a comparison of a configuration found.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Errors of the base-plane image.
    pub image: ImageFigures,
    /// Errors of every stage.
    pub errors: StageErrors,
    /// The base-plane image.
    pub base: BaseImage,
    /// Checksum of the base-plane image, all bits.
    pub bits: u64,
}

/// A frame that was rendered as fast as it goes.
#[derive(Clone, Copy, Debug)]
pub struct Timed {
    /// From the first plane to the last: without filling the table, without the warp.
    pub time: Duration,
    /// As [`Measured::bits`].
    pub bits: u64,
}

/// FNV-1a over the channels of an image in the order of memory, a word each.
fn checksum(image: &BaseImage, rays_per_voxel: usize) -> u64 {
    let step = |sum: u64, bits: u32| (sum ^ u64::from(bits)).wrapping_mul(0x0000_0100_0000_01b3);
    in_memory_order(image, rays_per_voxel).fold(0xcbf2_9ce4_8422_2325, step)
}

/// Evaluates an expression with the precision of a kind.
macro_rules! with_kind {
    ($kind:expr, $precision:ident => $with:expr) => {
        match $kind {
            Kind::Named(name) => with_pixel!(name, $precision => $with),
            Kind::Study($precision) => $with,
        }
    };
}

/// The precision of a configuration: one of the named ones, whose pipeline is compiled for it, or a study.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// Widths are constants.
    Named(PrecisionName),
    /// Widths are values.
    Study(Study),
}

/// What runs a configuration. The pipeline is the host's own: it reads decoded tables, so the code of the opacity
/// decides the bits of a frame and not its speed.
#[derive(Clone, Copy, Debug)]
pub struct Runner {
    kind: Kind,
    table: fn(&Prepared<'_>, LookupName) -> Expanded,
    lookup: LookupName,
}

impl Runner {
    /// That of a precision, with a table.
    pub fn of<A: Coded>(kind: Kind, lookup: LookupName) -> Self {
        Self {
            kind,
            table: table::<A>,
            lookup,
        }
    }

    /// Whether widths are values.
    pub const fn is_study(&self) -> bool {
        matches!(self.kind, Kind::Study(_))
    }

    /// The configuration's rendering of a scene, its image untouched.
    fn begun(&self, prepared: &Prepared<'_>) -> Result<Box<dyn Rendering>, RenderError> {
        let table = (self.table)(prepared, self.lookup);
        let (parameters, geometry) = (Parameters::of(&prepared.setup, None), prepared.setup.geometry());
        let mut rendering: Box<dyn Rendering> = match self.kind {
            Kind::Named(PrecisionName::Fast) => {
                let scene = fast(prepared.scene);
                let table = compile(&scene, &prepared.volume.mapping, prepared.setup.step_length);
                let rendering = rendering(&scene, &table, parameters, geometry);
                rendering?
            }
            Kind::Named(name) => {
                let rendering = rendering_over(name, prepared.scene, table, parameters, geometry);
                rendering?
            }
            Kind::Study(study) => under(study, prepared, table)?,
        };
        rendering.begin()?;
        Ok(rendering)
    }

    /// The bits of a channel that make the picture.
    fn shown(&self) -> u32 {
        match self.kind {
            Kind::Named(_) => u32::MAX,
            Kind::Study(study) => study.pixel.scale().shown(),
        }
    }

    /// The base-plane image, as pictures show it.
    ///
    /// # Errors
    /// As [`Runner::compare`].
    pub fn render(&self, prepared: &Prepared<'_>) -> Result<BaseImage, RenderError> {
        let mut turned = Turned::new(prepared.volume, &prepared.setup.plan);
        let slices = turned.slices()?;
        let mut rendering = self.begun(prepared)?;
        rendering.fold_rows(&slices, TILE_ROWS, prepared.simd, &|_, _| ());
        Ok(self.pictured(rendering.base()))
    }

    /// An image without the bits that pictures do not show.
    fn pictured(&self, mut base: BaseImage) -> BaseImage {
        let shown = self.shown();
        base.planes.iter_mut().flatten().for_each(|bits| *bits &= shown);
        base
    }

    /// Every error, against the model.
    ///
    /// # Errors
    /// [`RenderError`] if the scene does not fit the pipeline.
    pub fn compare(&self, bench: Bench<'_>) -> Result<Measured, RenderError> {
        let Prepared { scene, setup, .. } = bench.prepared;
        let plan = &setup.plan;
        let mut rendering = self.begun(bench.prepared)?;
        let (model, blend) = (bench.model, scene.blend);
        let taps = if matches!(self.kind, Kind::Named(PrecisionName::Fast)) {
            let tap = |tile: Tile| FastLockstep::new(model, setup, blend, tile);
            let taps = tapped(&mut *rendering, bench.slices, TILE_ROWS, &|_, _| (), tap);
            taps.into_iter().map(|tap| tap.lockstep).collect()
        } else {
            let tap = |tile: Tile| match self.kind {
                Kind::Named(name) => with_precision!(name, p => Lockstep::new(p, model, setup, blend, tile)),
                Kind::Study(study) => Lockstep::new(study, model, setup, blend, tile),
            };
            tapped(&mut *rendering, bench.slices, TILE_ROWS, &|_, _| (), tap)
        };
        let rays = plan.sampling().rays_per_voxel as usize;
        let [width, _] = plan.base().map(|side| side as usize);
        let mut errors = StageErrors::default();
        let mut model = Tiles::new(bench.model.lattice().size, width, rays);
        for tap in taps {
            let (tile, tile_errors, pixels) = tap.finish();
            errors.merge(&tile_errors);
            model.place(plan, tile, &pixels);
        }
        let base = rendering.base();
        let bits = checksum(&base, rays);
        let base = self.pictured(base);
        Ok(Measured {
            image: base_figures(&base, &model.image()),
            errors,
            base,
            bits,
        })
    }

    /// How long one frame takes with the scene's vectors on rayon's current threads.
    ///
    /// # Errors
    /// As [`Runner::compare`].
    pub fn time(&self, bench: Bench<'_>) -> Result<Timed, RenderError> {
        let Prepared { setup, simd, .. } = bench.prepared;
        let mut rendering = self.begun(bench.prepared)?;
        let start = Instant::now();
        rendering.fold_rows(bench.slices, TILE_ROWS, *simd, &|_, _| ());
        let time = start.elapsed();
        let rays = setup.plan.sampling().rays_per_voxel as usize;
        let bits = checksum(&rendering.base(), rays);
        Ok(Timed { time, bits })
    }

    /// The figures of errors that were gathered.
    pub fn report(&self, errors: &StageErrors) -> Vec<StageReport> {
        with_kind!(self.kind, precision => errors.report(precision))
    }
}

/// The table of a scene in a code.
fn table<A: Coded>(prepared: &Prepared<'_>, lookup: LookupName) -> Expanded {
    let correction = Correction::Step(prepared.setup.step_length);
    let mapping = &prepared.volume.mapping;
    let filled: Filled = fill(&prepared.scene.transfer, mapping, correction, A::encode, A::decode);
    A::expanded(&filled, lookup)
}

/// A scene in 16-bit lanes, its table with colours of 8 bits as those of other configurations.
pub fn fast(scene: &Scene) -> Scene {
    Scene {
        precision: PrecisionName::Fast,
        table: Some(AlphaCodeName::Sqrt16),
        ..scene.clone()
    }
}

/// The rendering of a study, of a lit scene or of an unlit one.
fn under(precision: Study, prepared: &Prepared<'_>, table: Expanded) -> Result<Box<dyn Rendering>, RenderError> {
    let (geometry, bits) = (prepared.setup.geometry(), prepared.scene.early_termination);
    let pipeline: Box<Pipeline> = match &prepared.setup.material {
        Some(material) => {
            let phong = material.phong(precision).map_err(CameraError::from)?;
            Box::new(early(Composite::new(precision, table, phong), bits))
        }
        None => Box::new(early(Composite::new(precision, table, Unlit), bits)),
    };
    Ok(Box::new(Under::new(geometry, pipeline)))
}

/// A study's pipeline.
type Pipeline = dyn Folds<Voxel = Code12, Element = ChannelOf<Study>>;

/// The samples of a frame: those inside the volume, whether they are skipped or not.
pub fn samples(plan: &Plan) -> u64 {
    let [width, height, _] = plan.dims();
    let [base_width, base_height] = plan.base();
    // Pixels along one side whose samples lie between the first voxel and the last.
    let along = |start: i32, side: u32, pixels: u32| {
        let inside = |pixel: &u32| {
            let at = i64::from(start) + (i64::from(*pixel) << 16);
            (0..=i64::from(side - 1) << 16).contains(&at)
        };
        (0..pixels).filter(inside).count() as u64
    };
    let mut count = 0;
    for phase in 0..plan.phases() {
        for index in 0..plan.planes() {
            let at = plane(plan, plan.phase(phase), index);
            count += along(at.x.to_bits(), width, base_width) * along(at.y.to_bits(), height, base_height);
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;
    use slicecast::format::Direction;
    use slicecast::plan::{Sampling, Spacing};
    use slicecast::view::View;

    #[test]
    fn samples_are_counted_inside_the_volume() {
        let plan = |x: i64, rays_per_voxel| {
            let view = View::new([Direction::from_bits(x), Direction::ZERO, Direction::from_bits(1 << 50)]).unwrap();
            let sampling = Sampling {
                planes_per_voxel: 2,
                rays_per_voxel,
            };
            Plan::whole(view, [5, 4, 3], Spacing::CUBIC, sampling).unwrap()
        };
        assert_eq!(samples(&plan(0, 1)), 5 * 4 * 5);
        // A shear of one: the planes at half voxels have one column less.
        assert_eq!(samples(&plan(1 << 50, 1)), 4 * (5 + 4 + 5 + 4 + 5));
        // Two rays per voxel: columns at 0, 0.5 ... 4 are nine, rows seven.
        assert_eq!(samples(&plan(0, 2)), 9 * 7 * 5);
    }
}
