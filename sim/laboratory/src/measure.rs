//! Errors and speed of one configuration, by the pipeline itself.

use std::hint::black_box;
use std::time::{Duration, Instant};

use rayon::prelude::*;
use slicecast::classify::Lookup;
use slicecast::composite::{self, Channel, FrontToBack};
use slicecast::lanes::Lanes;
use slicecast::locate::plane;
use slicecast::plan::Plan;
use slicecast::plane::{At, ChannelOf, Composite, Pipeline, Rows, ScratchError, ScratchRows, clear, scratch_len};
use slicecast::precision::Precision;
use slicecast::shade::{Shader, Unlit};
use slicecast::slice::Slice;
use slicecast::tap::Tap;

use super::codes::Coded;
use super::pixels::Described;
use slicecast_compare::Tiles;
use slicecast_compare::image::{ImageFigures, base_figures};
use slicecast_compare::lockstep::Lockstep;
use slicecast_compare::stages::{StageErrors, StageReport};
use slicecast_engine::camera::CameraError;
use slicecast_engine::error::RenderError;
use slicecast_engine::expanded::Expanded;
use slicecast_engine::frame::Prepared;
use slicecast_engine::image::{BaseImage, new_image};
use slicecast_engine::simd::Simd;
use slicecast_engine::table::{Correction, Filled, fill};
use slicecast_engine::tiles::{TILE_ROWS, Tile, fold_tile, fold_tiles};
use slicecast_model::{Model, Pixel};
use slicecast_scene::LookupName;

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

/// The most lanes that configurations are compiled for.
const LANES: usize = 8;

/// The vectors that render a study's frames, where a scene would be rendered with these.
pub fn narrowed(simd: Simd) -> Simd {
    match simd {
        Simd::Avx512(token) => Simd::Avx2(token.narrower()),
        Simd::Avx2(_) | Simd::Scalar => simd,
    }
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

/// A pipeline that is not compiled for sixteen lanes. A study has a hundred pipelines, which would take minutes more to
/// build; what it compares is decided in eight lanes as well.
struct Narrow<'a, L>(&'a L);

impl<L: Pipeline> Pipeline for Narrow<'_, L> {
    type Precision = L::Precision;
    type Element = L::Element;
    const CHANNELS: usize = L::CHANNELS;
    const SLICES: usize = L::SLICES;
    const SCRATCH: ScratchRows = L::SCRATCH;
    const BACK_TO_FRONT: bool = L::BACK_TO_FRONT;

    fn empty(channel: usize) -> Self::Element {
        L::empty(channel)
    }

    #[inline(always)]
    fn fold<V: Lanes>(
        &self,
        at: &At<'_>,
        rows: Rows<'_, Self::Element>,
        scratch: &mut [i32],
        tap: Option<&mut dyn Tap>,
    ) -> Result<(), ScratchError> {
        if const { V::COUNT <= LANES } {
            self.0.fold::<V>(at, rows, scratch, tap)?;
        }
        Ok(())
    }

    fn pixel(&self, row: &[Self::Element], column: usize) -> composite::Pixel<ChannelOf<L::Precision>> {
        self.0.pixel(row, column)
    }
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

/// A pipeline whose type is forgotten. What is behind it is compiled once a configuration and lighting: one tile with a
/// tap, and one without for each kind of vectors.
trait Bound: Sync {
    /// Name, 1.0 and shown bits of a channel.
    fn format(&self) -> (&'static str, u32, u32);
    /// Renders a frame with the scene's vectors on rayon's current threads, and looks at nothing.
    fn time(&self, bench: Bench<'_>) -> Result<Timed, RenderError>;
    /// Renders a tile beside the model, by the scalar definitions.
    fn compare(&self, bench: Bench<'_>, tile: Tile) -> Compared;
}

impl<L: Pipeline<Element = ChannelOf<<L as Pipeline>::Precision>>> Bound for L
where
    <L::Precision as Precision>::Pixel: Described,
{
    fn format(&self) -> (&'static str, u32, u32) {
        let shown = <<L::Precision as Precision>::Pixel as Described>::SHOWN;
        (L::Element::NAME, L::Element::ONE.bits(), shown)
    }

    fn time(&self, bench: Bench<'_>) -> Result<Timed, RenderError> {
        let Prepared { setup, simd, .. } = bench.prepared;
        let simd = narrowed(*simd);
        let mut image = new_image::<L>(&setup.plan)?;
        let start = Instant::now();
        let (plan, pipeline, rows) = (&setup.plan, Narrow(self), TILE_ROWS);
        fold_tiles(plan, &pipeline, bench.slices, &mut image, rows, simd, &|_, _| ());
        let time = start.elapsed();
        let bits = Checksum::EMPTY.add(black_box(image).into_iter().map(Channel::bits));
        Ok(Timed { time, bits: bits.0 })
    }

    fn compare(&self, bench: Bench<'_>, tile: Tile) -> Compared {
        let Prepared { scene, setup, .. } = bench.prepared;
        let plan = &setup.plan;
        let mut lockstep = Lockstep::new::<L::Precision>(bench.model, setup, scene.blend, tile);
        let ([width, _], [slice_width, _, _]) = (plan.base(), plan.dims());
        let mut data = vec![L::empty(0); L::CHANNELS * width as usize * tile.rows as usize];
        clear::<L>(plan, &mut data);
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

/// Lends a configuration's pipeline over a table.
type With = fn(&Prepared<'_>, &Expanded, &mut dyn FnMut(&dyn Bound)) -> Result<(), RenderError>;

/// What runs a configuration. The pipeline is the host's own: it reads decoded tables, so the code of the opacity
/// decides the bits of a frame and not its speed.
#[derive(Clone, Copy, Debug)]
pub struct Runner {
    with: With,
    table: fn(&Prepared<'_>) -> Expanded,
    report: fn(&StageErrors) -> Vec<StageReport>,
}

impl Runner {
    /// That of a precision; in scenes without lights that of another one, which differs from it in the surface alone.
    pub fn of<P, U, A, L>() -> Self
    where
        P: Precision<Pixel: Described>,
        U: Precision<Pixel: Described>,
        A: Coded,
        L: Lookup,
    {
        Self {
            with: with_pipeline::<P, U>,
            table: table::<A, L>,
            report: StageErrors::report::<P>,
        }
    }

    fn with<R>(&self, prepared: &Prepared<'_>, work: impl FnOnce(&dyn Bound) -> R) -> Result<R, RenderError> {
        let table = (self.table)(prepared);
        let (mut work, mut result) = (Some(work), None);
        (self.with)(prepared, &table, &mut |bound| {
            result = work.take().map(|work| work(bound));
        })?;
        // What lends a pipeline without an error has called the function.
        Ok(result.expect("a pipeline was lent"))
    }

    /// Every error, against the model.
    ///
    /// # Errors
    /// [`RenderError`] if the scene does not fit the pipeline.
    pub fn compare(&self, bench: Bench<'_>) -> Result<Measured, RenderError> {
        let plan = &bench.prepared.setup.plan;
        let ((format, one, shown), compared) = self.with(bench.prepared, |bound| {
            let compared: Vec<_> = tiles(plan)
                .into_par_iter()
                .map(|tile| bound.compare(bench, tile))
                .collect();
            (bound.format(), compared)
        })?;
        let rays = plan.sampling().rays_per_voxel as usize;
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
    pub fn report(&self, errors: &StageErrors) -> Vec<StageReport> {
        (self.report)(errors)
    }
}

/// The table of a scene in a code.
fn table<A: Coded, L: Lookup>(prepared: &Prepared<'_>) -> Expanded {
    let correction = Correction::Step(prepared.setup.step_length);
    let mapping = &prepared.volume.mapping;
    let filled: Filled = fill(&prepared.scene.transfer, mapping, correction, A::encode, A::decode);
    let lookup = if L::LINEAR {
        LookupName::Linear
    } else {
        LookupName::Nearest
    };
    A::expanded(&filled, lookup)
}

/// Lends the pipeline of a lit scene's precision or of an unlit one's.
fn with_pipeline<P: Precision<Pixel: Described>, U: Precision<Pixel: Described>>(
    prepared: &Prepared<'_>,
    table: &Expanded,
    work: &mut dyn FnMut(&dyn Bound),
) -> Result<(), RenderError> {
    match &prepared.setup.material {
        Some(material) => {
            let phong = material.phong::<P>().map_err(CameraError::from)?;
            work(&early::<P, _>(Composite::new(table, phong), prepared));
        }
        None => work(&early::<U, _>(Composite::new(table, Unlit), prepared)),
    }
    Ok(())
}

/// Ends rays early if the scene asks for it.
fn early<'t, P: Precision, S: Shader<P>>(
    pipeline: Composite<P, &'t Expanded, S, FrontToBack>,
    prepared: &Prepared<'_>,
) -> Composite<P, &'t Expanded, S, FrontToBack> {
    match prepared.scene.early_termination {
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
