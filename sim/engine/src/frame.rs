//! A scene on a volume, and the frame that it renders to.

use slicecast::integral::Length;
use slicecast::modulate::Modulation;
use slicecast::slice::Slice;
use slicecast_scene::{Classification, Interpolation, PrecisionName, Scene};
use slicecast_volume::Volume;

use crate::base::{base_image, new_image};
use crate::camera::{Setup, set_up};
use crate::error::RenderError;
use crate::fineness::{self, Finest};
use crate::folds::Frames;
use crate::image::{BaseImage, Frame};
use crate::modulation;
use crate::oriented::{Oriented, Turned};
use crate::parameters::Parameters;
use crate::picture::Shown;
use crate::pipelines::{compile, rendering, rendering_of_segments};
use crate::progress::Progress;
use crate::rendering::Framing;
use crate::segments::{self, Segments};
use crate::shard::Shard;
use crate::simd::Simd;
use crate::source::Source;
use crate::stream::fold_stream;
use crate::table::Table;
use crate::tiles::fold_tiles;

/// A scene on a volume, ready to be rendered.
#[derive(Clone, Debug)]
pub struct Prepared<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The volume.
    pub volume: &'a Volume,
    /// Geometry, picture and lights.
    pub setup: Setup,
    /// The table of points.
    pub table: Table,
    /// What segments are classified by, where they are.
    pub segments: Option<Segments>,
    /// Factors by the magnitude of the gradient, if there are any.
    pub modulation: Option<Modulation>,
    /// The finest peak of the transfer function, where `auto` chose by it.
    pub finest: Option<Finest>,
    /// Which vectors fold tiles.
    pub simd: Simd,
}

/// How slices reach the pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layer {
    /// The plane layer on the volume in memory, in tiles of this many rows.
    Tiles(usize),
    /// The stream layer, one slice at a time on one thread.
    Stream,
}

/// The frame of any pipeline: all planes of slices, as the view meets them, folded in whole rows.
///
/// # Errors
/// [`RenderError::Memory`] before anything too large is allocated, [`RenderError::Stream`] if the stream layer refuses a slice.
pub fn rows_of<F: Frames + ?Sized>(
    pipeline: &F,
    slices: &[Slice<'_, F::Voxel>],
    setup: &Setup,
    behind: [f64; 3],
    layer: Layer,
    simd: Simd,
    progress: Progress<'_>,
) -> Result<Frame, RenderError> {
    let (plan, geometry) = (&setup.plan, setup.geometry());
    let mut image = new_image(plan, pipeline)?;
    match layer {
        Layer::Tiles(rows) => {
            fold_tiles(
                geometry,
                pipeline,
                (slices, None),
                &mut image,
                rows.into(),
                simd,
                progress,
            );
        }
        Layer::Stream => fold_stream(geometry, pipeline, slices, &mut image, progress, None)?,
    }
    Ok(Frame {
        base: base_image(plan, pipeline, &image),
        picture: pipeline.picture(&Shown::new(&setup.picture, behind, simd), plan, &image),
    })
}

impl<'a> Prepared<'a> {
    /// Prepares a scene.
    ///
    /// # Errors
    /// [`RenderError::Camera`] if the scene does not fit the pipeline.
    pub fn new(scene: &'a Scene, volume: &'a Volume) -> Result<Self, RenderError> {
        Self::of(scene, volume, volume)
    }

    /// Prepares a scene on a volume without voxels: what is to be known of them comes from a source.
    ///
    /// # Errors
    /// As [`Prepared::new`], and [`RenderError::Read`] if a file cannot be read.
    pub fn of(scene: &'a Scene, volume: &'a Volume, source: &dyn Source) -> Result<Self, RenderError> {
        let setup = set_up(scene, volume)?;
        // Splines have samples alone.
        let splines = scene.interpolation == Interpolation::Quadratic;
        let automatic = scene.classification == Classification::Auto && !splines;
        let finest = if automatic {
            fineness::of(scene, volume, source)?
        } else {
            None
        };
        let segments = match scene.classification {
            Classification::Point => false,
            Classification::Integral | Classification::None => true,
            Classification::Auto if splines => false,
            Classification::Auto => !scene.surfaces.is_empty() || finest.is_some_and(|finest| finest.is_missed()),
        };
        if segments && scene.precision == PrecisionName::Fast {
            return Err(RenderError::FastSegments);
        }
        if segments && setup.plan.ends() < 2 {
            return Err(RenderError::Segments);
        }
        Ok(Self {
            table: compile(scene, &volume.mapping, setup.step_length),
            segments: segments.then(|| segments::of(scene, volume, Length::of(&setup.plan))),
            modulation: modulation::of(scene, &volume.mapping, volume.spacing),
            finest,
            scene,
            volume,
            setup,
            simd: Simd::widest(),
        })
    }

    /// The same, with these vectors.
    #[must_use]
    pub fn with_simd(self, simd: Simd) -> Self {
        Self { simd, ..self }
    }

    /// For what knows classified samples alone.
    ///
    /// # Errors
    /// [`RenderError::PointsOnly`] if segments are classified.
    pub fn check_points(&self) -> Result<(), RenderError> {
        match (&self.segments, self.scene.classification) {
            (None, _) => Ok(()),
            (Some(_), Classification::None) => Err(RenderError::PointsOnly {
                asked: "\"none\", for surfaces alone",
            }),
            (Some(_), Classification::Auto) => Err(RenderError::PointsOnly {
                asked: "\"auto\", which chose them",
            }),
            (Some(_), _) => Err(RenderError::PointsOnly { asked: "\"integral\"" }),
        }
    }

    /// For what knows the whole volume alone.
    ///
    /// # Errors
    /// [`RenderError::Cropped`] if the scene has a crop box, [`RenderError::Clipped`] if it has clip planes or depth cueing.
    pub fn check_uncropped(&self) -> Result<(), RenderError> {
        match self.scene.crop {
            Some(_) => Err(RenderError::Cropped),
            None => self.check_unclipped(),
        }
    }

    /// For what knows neither clip planes nor depth cueing nor modulation nor reflectance maps nor splines.
    ///
    /// # Errors
    /// [`RenderError::Clipped`], [`RenderError::Modulated`], [`RenderError::Mapped`] or [`RenderError::Splines`] if the scene has one.
    pub fn check_unclipped(&self) -> Result<(), RenderError> {
        match self.setup.clips {
            Some(_) => Err(RenderError::Clipped),
            None => self.check_unmodulated().and_then(|()| self.check_linear()),
        }
    }

    /// For what knows no splines.
    ///
    /// # Errors
    /// [`RenderError::Splines`] if the scene asks for them.
    pub fn check_linear(&self) -> Result<(), RenderError> {
        match self.scene.interpolation {
            Interpolation::Quadratic => Err(RenderError::Splines),
            Interpolation::Linear | Interpolation::Nearest => Ok(()),
        }
    }

    /// For what knows the stages of 32-bit lanes alone.
    ///
    /// # Errors
    /// [`RenderError::Fast`] if the scene asks for 16-bit lanes.
    pub fn check_staged(&self) -> Result<(), RenderError> {
        match self.scene.precision {
            PrecisionName::Fast => Err(RenderError::Fast),
            PrecisionName::Paper | PrecisionName::Compact | PrecisionName::Wide => Ok(()),
        }
    }

    /// For what knows neither modulation nor reflectance maps.
    ///
    /// # Errors
    /// [`RenderError::Modulated`] or [`RenderError::Mapped`] if the scene has one.
    pub fn check_unmodulated(&self) -> Result<(), RenderError> {
        match (&self.modulation, self.scene.reflectance) {
            (Some(_), _) => Err(RenderError::Modulated),
            (None, Some(_)) => Err(RenderError::Mapped),
            (None, None) => Ok(()),
        }
    }

    /// How the picture of its image is made.
    pub fn shown(&self) -> Shown<'_> {
        Shown::new(&self.setup.picture, self.scene.image.background, self.simd)
    }

    /// The rendering of this scene, without an image.
    ///
    /// # Errors
    /// [`RenderError::Camera`] if the setup's material has been changed to one that the pipeline does not take.
    pub fn rendering(&self) -> Result<Box<dyn Framing>, RenderError> {
        let (parameters, geometry) = (
            Parameters::of(&self.setup, self.modulation.as_ref()),
            self.setup.geometry(),
        );
        let rendering = match &self.segments {
            Some(segments) => rendering_of_segments(self.scene, segments, parameters, geometry),
            None => rendering(self.scene, &self.table, parameters, geometry),
        };
        Ok(rendering?)
    }

    /// The rendering of this scene, its image untouched.
    ///
    /// # Errors
    /// As [`Prepared::rendering`], and [`RenderError::Memory`] if the image is too large.
    pub fn begun(&self) -> Result<Box<dyn Framing>, RenderError> {
        let mut rendering = self.rendering()?;
        rendering.begin()?;
        Ok(rendering)
    }

    /// Renders the frame. `progress` is told how many steps of how many are done (tiles, or slices of a stream).
    ///
    /// # Errors
    /// [`RenderError`]; nothing is rendered then.
    pub fn render(&self, layer: Layer, progress: &(dyn Fn(usize, usize) + Sync)) -> Result<Frame, RenderError> {
        let mut turned = Turned::new(self.volume, &self.setup.plan);
        self.render_oriented(&Oriented::of(&turned.slices()?), layer, progress)
    }

    /// Renders one shard of the frame: its base-plane image, of which only [`Shard::rows`] are to be read.
    ///
    /// # Errors
    /// As [`Prepared::render`].
    pub fn render_shard(
        &self,
        shard: Shard,
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<BaseImage, RenderError> {
        let mut turned = Turned::new(self.volume, &self.setup.plan);
        let mut rendering = self.begun()?;
        let slices = turned.slices()?;
        for part in rendering.parts(slices.len()) {
            rendering.fold_part(&Oriented::of(&slices), &part, shard, self.simd, progress);
        }
        Ok(rendering.base())
    }

    /// Renders the frame from a volume that has been turned for a view along the same axis and direction.
    ///
    /// # Errors
    /// As [`Prepared::render`].
    pub fn render_oriented(
        &self,
        volume: &Oriented<'_>,
        layer: Layer,
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Frame, RenderError> {
        let mut rendering = self.begun()?;
        match layer {
            Layer::Tiles(rows) => rendering.fold(volume, rows, self.simd, progress),
            Layer::Stream => rendering.stream(volume.slices, progress, None)?,
        }
        Ok(Frame {
            base: rendering.base(),
            picture: rendering.picture(&self.shown()),
        })
    }
}
