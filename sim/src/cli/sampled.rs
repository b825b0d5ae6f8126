//! Sampling of volumes of colours by opacities, in f64: the comparator of sampling by extinctions.

use clap::ValueEnum;
use slicecast_model::Interpolated;
use slicecast_pyramid::volume::RgbaVolume;

use super::Failure;

/// What is interpolated between the voxels of a volume of colours.
#[derive(clap::Args, Default)]
pub struct SampledArgs {
    /// What is interpolated between voxels of colours: extinctions, by the pipeline; or opacities over --alpha-distance and colours
    /// times opacity, brought to the step, in f64 for comparison: as real numbers, or rounded to 16 or 8 bits a channel before.
    #[arg(long, value_enum, default_value = "extinction")]
    sampling: SamplingArg,
}

#[derive(Clone, Copy, Default, PartialEq, ValueEnum)]
enum SamplingArg {
    #[default]
    Extinction,
    Opacity,
    Opacity16,
    Opacity8,
}

impl SampledArgs {
    /// What the model interpolates of a volume of colours, if not the pipeline renders it.
    pub fn interpolated(&self, volume: &RgbaVolume) -> Result<Option<Interpolated>, Failure> {
        let one = match self.sampling {
            SamplingArg::Extinction => return Ok(None),
            SamplingArg::Opacity => None,
            SamplingArg::Opacity16 => Some(u32::from(u16::MAX)),
            SamplingArg::Opacity8 => Some(u32::from(u8::MAX)),
        };
        let distance = volume.alpha_distance.ok_or_else(|| {
            Failure::input(format!(
                "{}: states extinctions, and no distance over which opacities are meant, expected no --sampling by opacity",
                volume.name
            ))
        })?;
        Ok(Some(Interpolated::Opacities { distance, one }))
    }

    /// For a volume of one value a voxel that is classified sample by sample.
    pub fn check_none(&self, name: &str) -> Result<(), Failure> {
        if self.sampling == SamplingArg::Extinction {
            return Ok(());
        }
        Err(Failure::input(format!(
            "{name}: has one value a voxel and is classified sample by sample, expected no --sampling without --level"
        )))
    }
}
