//! Errors and speed of one configuration, by the pipeline itself.

use std::hint::black_box;
use std::time::{Duration, Instant};

use rayon::prelude::*;
use slicecast::composite::{Channel, FrontToBack, Recurrence as _};
use slicecast::locate::plane;
use slicecast::plan::Plan;
use slicecast::plane::{ChannelOf, Composite, Pipeline, clear, scratch_len};
use slicecast::precision::{Compact, Paper, Precision, Wide};
use slicecast::shade::{Shader, Unlit};
use slicecast::slice::Slice;

use super::codes::Coded;
use super::formats::Study;
use slicecast_compare::Tiles;
use slicecast_compare::image::{ImageFigures, base_figures};
use slicecast_compare::lockstep::Lockstep;
use slicecast_compare::stages::{StageErrors, StageReport};
use slicecast_engine::camera::CameraError;
use slicecast_engine::error::RenderError;
use slicecast_engine::expanded::Expanded;
use slicecast_engine::frame::Prepared;
use slicecast_engine::image::{BaseImage, new_image};
use slicecast_engine::table::{Correction, Filled, fill};
use slicecast_engine::tiles::{TILE_ROWS, Tile, fold_tile, fold_tiles};
use slicecast_model::{Model, Pixel};
use slicecast_scene::{LookupName, PrecisionName};

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

/// A tile of a configuration's image beside the model's.
struct Compared {
    tile: Tile,
    /// The tile as it lies in the image.
    bits: Vec<u32>,
    errors: StageErrors,
    model: Vec<Pixel>,
}

/// FNV-1a over whole words.
#[derive(Clone, Copy)]
struct Checksum(u64);

impl Checksum {
    const EMPTY: Self = Self(0xcbf2_9ce4_8422_2325);

    fn add(self, bits: impl IntoIterator<Item = u32>) -> Self {
        let step = |sum: u64, bits: u32| (sum ^ u64::from(bits)).wrapping_mul(0x0000_0100_0000_01b3);
        Self(bits.into_iter().fold(self.0, step))
    }
}

/// A pipeline whose type is forgotten.
trait Bound: Sync {
    /// Name and 1.0 of a channel.
    fn format(&self) -> (&'static str, u32);
    /// Renders a frame with the scene's vectors on rayon's current threads, and looks at nothing.
    fn time(&self, bench: Bench<'_>) -> Result<Timed, RenderError>;
    /// Renders a tile beside the model, by the scalar definitions.
    fn compare(&self, bench: Bench<'_>, tile: Tile) -> Compared;
    /// The figures of errors that were gathered.
    fn report(&self, errors: &StageErrors) -> Vec<StageReport>;
}

impl<L: Pipeline<Element = ChannelOf<<L as Pipeline>::Precision>>> Bound for L {
    fn format(&self) -> (&'static str, u32) {
        let pixel = self.precision().pixel();
        (pixel.format(), pixel.one().bits())
    }

    fn time(&self, bench: Bench<'_>) -> Result<Timed, RenderError> {
        let Prepared { setup, simd, .. } = bench.prepared;
        let mut image = new_image(&setup.plan, self)?;
        let start = Instant::now();
        let (plan, rows) = (&setup.plan, TILE_ROWS);
        fold_tiles(plan, self, bench.slices, &mut image, rows, *simd, &|_, _| ());
        let time = start.elapsed();
        let bits = Checksum::EMPTY.add(black_box(image).into_iter().map(Channel::bits));
        Ok(Timed { time, bits: bits.0 })
    }

    fn compare(&self, bench: Bench<'_>, tile: Tile) -> Compared {
        let Prepared { scene, setup, .. } = bench.prepared;
        let plan = &setup.plan;
        let mut lockstep = Lockstep::new(self.precision(), bench.model, setup, scene.blend, tile);
        let ([width, _], [slice_width, _, _]) = (plan.base(), plan.dims());
        let mut data = vec![L::Element::default(); L::CHANNELS * width as usize * tile.rows as usize];
        clear(self, plan, &mut data);
        let mut scratch = vec![0; scratch_len::<L>(slice_width)];
        fold_tile(plan, self, bench.slices, tile, &mut data, &mut scratch, &mut lockstep)
            .unwrap_or_else(|error| unreachable!("{error}"));
        let (tile, errors, model) = lockstep.finish();
        Compared {
            tile,
            bits: data.into_iter().map(Channel::bits).collect(),
            errors,
            model,
        }
    }

    fn report(&self, errors: &StageErrors) -> Vec<StageReport> {
        errors.report(self.precision())
    }
}

/// The tiles of a frame, in the order in which they lie in the image.
fn tiles(plan: &Plan) -> Vec<Tile> {
    let [_, height] = plan.base();
    let of_phase = |phase| {
        (0..height).step_by(TILE_ROWS).map(move |first| Tile {
            phase,
            first,
            rows: (TILE_ROWS as u32).min(height - first),
        })
    };
    (0..plan.phases()).flat_map(of_phase).collect()
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

    fn with<R>(&self, prepared: &Prepared<'_>, work: impl FnOnce(&dyn Bound) -> R) -> Result<R, RenderError> {
        let table = &(self.table)(prepared, self.lookup);
        match self.kind {
            Kind::Named(PrecisionName::Paper) => with_pipeline(Paper, prepared, table, work),
            Kind::Named(PrecisionName::Compact) => with_pipeline(Compact, prepared, table, work),
            Kind::Named(PrecisionName::Wide) => with_pipeline(Wide, prepared, table, work),
            Kind::Study(study) => with_pipeline(study, prepared, table, work),
        }
    }

    /// The bits of a channel that make the picture.
    fn shown(&self) -> u32 {
        match self.kind {
            Kind::Named(_) => u32::MAX,
            Kind::Study(study) => study.pixel.scale().shown(),
        }
    }

    /// Every error, against the model.
    ///
    /// # Errors
    /// [`RenderError`] if the scene does not fit the pipeline.
    pub fn compare(&self, bench: Bench<'_>) -> Result<Measured, RenderError> {
        let plan = &bench.prepared.setup.plan;
        let ((format, one), compared) = self.with(bench.prepared, |bound| {
            let compared: Vec<_> = tiles(plan)
                .into_par_iter()
                .map(|tile| bound.compare(bench, tile))
                .collect();
            (bound.format(), compared)
        })?;
        let (rays, shown) = (plan.sampling().rays_per_voxel as usize, self.shown());
        let [width, _] = plan.base().map(|side| side as usize);
        let size = bench.model.lattice().size;
        let mut errors = StageErrors::default();
        let mut checksum = Checksum::EMPTY;
        let mut model = Tiles::new(size, width, rays);
        let mut planes = [(); 4].map(|()| vec![0; size[0] * size[1]]);
        for compared in compared {
            let Compared { tile, bits, .. } = &compared;
            errors.merge(&compared.errors);
            checksum = checksum.add(bits.iter().copied());
            model.place(plan, *tile, &compared.model);
            let phase = plan.phase(tile.phase);
            for (run, bits) in bits.chunks(width).enumerate() {
                let v = (run / 4 + tile.first as usize) * rays + phase.v as usize;
                for (column, bits) in bits.iter().enumerate() {
                    planes[run % 4][v * size[0] + column * rays + phase.u as usize] = bits & shown;
                }
            }
        }
        let base = BaseImage {
            size,
            format,
            one,
            planes,
        };
        Ok(Measured {
            image: base_figures(&base, &model.image()),
            errors,
            base,
            bits: checksum.0,
        })
    }

    /// How long one frame takes with the scene's vectors on rayon's current threads.
    ///
    /// # Errors
    /// As [`Runner::compare`].
    pub fn time(&self, bench: Bench<'_>) -> Result<Timed, RenderError> {
        self.with(bench.prepared, |bound| bound.time(bench))?
    }

    /// The figures of errors that were gathered.
    ///
    /// # Errors
    /// As [`Runner::compare`].
    pub fn report(&self, prepared: &Prepared<'_>, errors: &StageErrors) -> Result<Vec<StageReport>, RenderError> {
        self.with(prepared, |bound| bound.report(errors))
    }
}

/// The table of a scene in a code.
fn table<A: Coded>(prepared: &Prepared<'_>, lookup: LookupName) -> Expanded {
    let correction = Correction::Step(prepared.setup.step_length);
    let mapping = &prepared.volume.mapping;
    let filled: Filled = fill(&prepared.scene.transfer, mapping, correction, A::encode, A::decode);
    A::expanded(&filled, lookup)
}

/// Makes the pipeline of a lit scene or of an unlit one.
fn with_pipeline<P: Precision, R>(
    precision: P,
    prepared: &Prepared<'_>,
    table: &Expanded,
    work: impl FnOnce(&dyn Bound) -> R,
) -> Result<R, RenderError> {
    let early = prepared.scene.early_termination;
    Ok(match &prepared.setup.material {
        Some(material) => {
            let phong = material.phong(precision).map_err(CameraError::from)?;
            work(&front_to_back(Composite::new(precision, table, phong), early))
        }
        None => work(&front_to_back(Composite::new(precision, table, Unlit), early)),
    })
}

/// Ends rays early if the scene asks for it.
fn front_to_back<'t, P: Precision, S: Shader<P>>(
    pipeline: Composite<P, &'t Expanded, S, FrontToBack>,
    early: Option<u32>,
) -> Composite<P, &'t Expanded, S, FrontToBack> {
    match early {
        Some(bits) => pipeline.with_early_termination(bits),
        None => pipeline,
    }
}

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
            Plan::new(view, [5, 4, 3], Spacing::CUBIC, sampling).unwrap()
        };
        assert_eq!(samples(&plan(0, 1)), 5 * 4 * 5);
        // A shear of one: the planes at half voxels have one column less.
        assert_eq!(samples(&plan(1 << 50, 1)), 4 * (5 + 4 + 5 + 4 + 5));
        // Two rays a voxel: columns at 0, 0.5 ... 4 are nine, rows seven.
        assert_eq!(samples(&plan(0, 2)), 9 * 7 * 5);
    }
}
