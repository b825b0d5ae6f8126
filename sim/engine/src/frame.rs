//! A scene on a volume, and the frame that it renders to.

use slicecast::plane::Pictured;
use slicecast_scene::Scene;
use slicecast_volume::Volume;

use crate::camera::{CameraError, Setup, set_up};
use crate::error::RenderError;
use crate::image::{Frame, base_image, new_image};
use crate::oriented::{Oriented, with_slices};
use crate::picture::picture;
use crate::pipelines::{Job, compile, dispatch};
use crate::simd::Simd;
use crate::stream::fold_stream;
use crate::table::Table;
use crate::tiles::fold_oriented;

/// A scene on a volume, ready to be rendered.
#[derive(Clone, Debug)]
pub struct Prepared<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The volume.
    pub volume: &'a Volume,
    /// Geometry, picture and lights.
    pub setup: Setup,
    /// The table.
    pub table: Table,
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

impl<'a> Prepared<'a> {
    /// Prepares a scene.
    ///
    /// # Errors
    /// [`RenderError::Camera`] if the scene does not fit the pipeline.
    pub fn new(scene: &'a Scene, volume: &'a Volume) -> Result<Self, RenderError> {
        let setup = set_up(scene, volume)?;
        Ok(Self {
            table: compile(scene, &volume.mapping, setup.step_length),
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

    /// Does a job with this scene's pipeline.
    ///
    /// # Errors
    /// [`RenderError::Camera`] if the setup's material has been changed to one that the pipeline does not take.
    pub fn dispatch<J: Job>(&self, job: J) -> Result<J::Output, RenderError> {
        let material = self.setup.material.as_ref();
        Ok(dispatch(self.scene, &self.table, material, job).map_err(CameraError::from)?)
    }

    /// Renders the frame. `progress` is told how many steps of how many are done (tiles, or slices of a stream).
    ///
    /// # Errors
    /// [`RenderError`]; nothing is rendered then.
    pub fn render(&self, layer: Layer, progress: &(dyn Fn(usize, usize) + Sync)) -> Result<Frame, RenderError> {
        with_slices(self.volume, self.setup.plan.view(), |slices| {
            self.render_oriented(&Oriented::of(slices), layer, progress)
        })?
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
        self.dispatch(Render {
            prepared: self,
            volume,
            layer,
            progress,
        })?
    }
}

struct Render<'a> {
    prepared: &'a Prepared<'a>,
    volume: &'a Oriented<'a>,
    layer: Layer,
    progress: &'a (dyn Fn(usize, usize) + Sync),
}

impl Job for Render<'_> {
    type Output = Result<Frame, RenderError>;

    fn run<L: Pictured>(self, pipeline: &L) -> Self::Output {
        let plan = &self.prepared.setup.plan;
        let mut image = new_image(plan, pipeline)?;
        match self.layer {
            Layer::Tiles(rows) => {
                let simd = self.prepared.simd;
                fold_oriented(plan, pipeline, self.volume, &mut image, rows, simd, self.progress);
            }
            Layer::Stream => fold_stream(plan, pipeline, self.volume.slices, &mut image, self.progress, None)?,
        }
        Ok(Frame {
            base: base_image(plan, pipeline, &image),
            picture: picture(self.prepared, pipeline, &image),
        })
    }
}
