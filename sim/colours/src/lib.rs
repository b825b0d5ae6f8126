//! A scene on a volume of colour and extinction, and the frame that it renders to.
//!
//! Voxels are decoded once, along the view: 8 bytes each. Whole rows are folded; what has no extinction is left out by core.

use rayon::prelude::*;
use slicecast::absorption::Medium;
use slicecast::composite::{ChannelFormat, Recurrence, Weighted};
use slicecast::extinction::Rgba15;
use slicecast::plan::Plan;
use slicecast::plane::{ChannelOf, Filter, Rgba, Triquadratic};
use slicecast::precision::{Compact, Precision, Wide};
use slicecast::shade::Shader;
use slicecast::slice::{RowRange, Slice, SliceError};
use slicecast_engine::camera::{Setup, set_up};
use slicecast_engine::error::{CameraError, ColourError, RenderError};
use slicecast_engine::folds::Frames;
use slicecast_engine::frame::{Layer, rows_of};
use slicecast_engine::image::Frame;
use slicecast_engine::oriented::Held;
use slicecast_engine::progress::Progress;
use slicecast_engine::simd::Simd;
use slicecast_pyramid::volume::RgbaVolume;
use slicecast_scene::{Blend, Interpolation, PrecisionName, Scene};

/// The scale of a volume's extinctions over a step.
///
/// # Errors
/// [`ColourError::Opaque`] for an optical depth above 15.
pub fn medium(tau_max: f64, step: f64) -> Result<Medium, ColourError> {
    let opaque = ColourError::Opaque { step, tau_max };
    let depth = tau_max * step;
    if depth.is_nan() || depth > 15.0 {
        return Err(opaque);
    }
    let scaled = |exponent: u32| depth * 268_435_456.0 / 32767.0 * f64::from(exponent).exp2();
    // The mantissa has 31 bits, or as many as the largest exponent leaves.
    let exponent = (15..=35).rev().find(|n| scaled(*n).round() < 2_147_483_648.0);
    // The largest depth is not to be passed.
    let (mantissa, exponent) = exponent.map_or((scaled(14).floor(), 14), |n| (scaled(n).round(), n));
    Medium::new(mantissa as u32, exponent).map_err(|_| opaque)
}

/// The codes of a volume as a view reads them, with room for what is measured of them.
#[derive(Clone, Debug)]
pub struct TurnedColours {
    words: Vec<u16>,
    /// Width and height of a slice.
    size: [usize; 2],
    reversed: bool,
    /// Of each row of each slice.
    ranges: Vec<RowRange>,
}

impl TurnedColours {
    /// What a plan holds of a volume.
    pub fn new(volume: &RgbaVolume, plan: &Plan) -> Self {
        let [nx, ny, _] = volume.dims;
        let strides = plan.view().arrange([1, nx, nx * ny]);
        let [width, height, depth] = plan.dims().map(|side| side as usize);
        let [x, y, z] = Held::of(plan).first;
        let corner = x + nx * (y + ny * z);
        let mut words = vec![0; 4 * width * height * depth];
        words.par_chunks_mut(4 * width).enumerate().for_each(|(row, words)| {
            let first = corner + row % height * strides[1] + row / height * strides[2];
            for i in 0..width {
                let [red, green, blue, extinction] = volume.voxels.codes(first + i * strides[0]);
                for (run, code) in [extinction, red, green, blue].into_iter().enumerate() {
                    words[run * width + i] = code;
                }
            }
        });
        Self {
            words,
            size: [width, height],
            reversed: plan.view().reversed(),
            ranges: vec![RowRange::EMPTY; height * depth],
        }
    }

    /// Measures the slices, in the order in which the view meets them.
    ///
    /// # Errors
    /// [`SliceError`] if a code is above 32767, or a colour above its extinction.
    pub fn slices(&mut self) -> Result<Vec<Slice<'_, Rgba15>>, SliceError> {
        let [width, height] = self.size;
        let ranges = self.ranges.par_chunks_mut(height);
        let slices = self.words.par_chunks(4 * width * height).zip(ranges);
        let mut slices = slices
            .map(|(words, ranges)| Slice::of_codes(words, width, height, ranges))
            .collect::<Result<Vec<_>, _>>()?;
        if self.reversed {
            slices.reverse();
        }
        Ok(slices)
    }
}

/// A scene on a volume of colour and extinction, ready to be rendered.
#[derive(Clone, Debug)]
pub struct Coloured<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The volume.
    pub volume: &'a RgbaVolume,
    /// Geometry and picture.
    pub setup: Setup,
    /// The scale of its extinctions.
    pub medium: Medium,
    /// Which vectors fold tiles.
    pub simd: Simd,
}

impl<'a> Coloured<'a> {
    /// Prepares a scene.
    ///
    /// # Errors
    /// [`RenderError`] if the scene does not fit the pipeline.
    pub fn new(scene: &'a Scene, volume: &'a RgbaVolume) -> Result<Self, RenderError> {
        let refused = match scene {
            Scene {
                precision: PrecisionName::Paper | PrecisionName::Fast,
                ..
            } => Some(ColourError::Paper),
            Scene { blend, .. } if *blend != Blend::FrontToBack => Some(ColourError::Blend),
            _ => None,
        };
        if let Some(refused) = refused {
            return Err(refused.into());
        }
        let setup = set_up(scene, volume)?;
        Ok(Self {
            medium: medium(volume.tau_max, setup.step_length)?,
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

    /// Renders the frame. `progress` is told how many steps of how many are done (tiles, or slices of a stream).
    ///
    /// # Errors
    /// [`RenderError`]; nothing is rendered then.
    pub fn render(&self, layer: Layer, progress: Progress<'_>) -> Result<Frame, RenderError> {
        let mut turned = TurnedColours::new(self.volume, &self.setup.plan);
        self.render_slices(&turned.slices()?, layer, progress)
    }

    /// Renders the frame from slices as its view meets them.
    ///
    /// # Errors
    /// As [`Coloured::render`].
    pub fn render_slices(
        &self,
        slices: &[Slice<'_, Rgba15>],
        layer: Layer,
        progress: Progress<'_>,
    ) -> Result<Frame, RenderError> {
        match self.scene.precision {
            PrecisionName::Paper | PrecisionName::Fast => Err(ColourError::Paper.into()),
            PrecisionName::Compact => self.frame(Compact, slices, layer, progress),
            PrecisionName::Wide => self.frame(Wide, slices, layer, progress),
        }
    }

    fn frame<P>(
        &self,
        p: P,
        slices: &[Slice<'_, Rgba15>],
        layer: Layer,
        progress: Progress<'_>,
    ) -> Result<Frame, RenderError>
    where
        P: Precision<Pixel: Weighted + Recurrence<Channel: ChannelFormat>>,
    {
        match &self.setup.material {
            None => self.filtered(Rgba::new(p, self.medium), slices, layer, progress),
            Some(material) => {
                let phong = material.phong(p).map_err(CameraError::from)?;
                self.filtered(Rgba::shaded(p, self.medium, phong), slices, layer, progress)
            }
        }
    }

    fn filtered<P, S>(
        &self,
        pipeline: Rgba<P, S>,
        slices: &[Slice<'_, Rgba15>],
        layer: Layer,
        progress: Progress<'_>,
    ) -> Result<Frame, RenderError>
    where
        P: Precision<Pixel: Weighted + Recurrence<Channel: ChannelFormat>>,
        S: Shader<P> + Send,
    {
        match self.scene.interpolation {
            Interpolation::Quadratic => self.fold(pipeline.with_filter(Triquadratic), slices, layer, progress),
            Interpolation::Linear | Interpolation::Nearest => self.fold(pipeline, slices, layer, progress),
        }
    }

    fn fold<P, S, F>(
        &self,
        mut pipeline: Rgba<P, S, F>,
        slices: &[Slice<'_, Rgba15>],
        layer: Layer,
        progress: Progress<'_>,
    ) -> Result<Frame, RenderError>
    where
        P: Precision<Pixel: Weighted + Recurrence<Channel: ChannelFormat>>,
        S: Shader<P> + Send,
        F: Filter + Send,
    {
        if let Some(bits) = self.scene.early_termination {
            pipeline = pipeline.with_early_termination(bits);
        }
        let pipeline: &dyn Frames<Voxel = Rgba15, Element = ChannelOf<P>> = &pipeline;
        let behind = self.scene.image.background;
        rows_of(pipeline, slices, &self.setup, behind, layer, self.simd, progress)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// M 2^-N is the scale to half a unit of M, and M has 31 bits but for the thinnest.
    #[test]
    fn media_are_the_nearest() {
        for exponent in -60..12 {
            for share in [1.0, 1.2, 1.6, 1.875] {
                let depth = f64::from(exponent).exp2() * share;
                let made = medium(depth, 1.0);
                if depth > 15.0 {
                    assert_eq!(
                        made,
                        Err(ColourError::Opaque {
                            step: 1.0,
                            tau_max: depth
                        })
                    );
                    continue;
                }
                let absorption = made.unwrap().absorption(0, slicecast::borders::WHOLE);
                let unit = (-f64::from(absorption.shift)).exp2();
                let away = f64::from(absorption.scale) * unit - depth * 268_435_456.0 / 32767.0;
                // The largest are rounded down.
                let within = if absorption.shift == 14 { 1.0 } else { 0.500_001 };
                assert!(away.abs() <= within * unit, "{depth}");
                assert!(absorption.shift == 35 || absorption.scale >> 30 == 1, "{depth}");
            }
        }
        assert!(medium(f64::MAX, 1e300).is_err());
    }
}
