//! The depth of the first surface that each ray meets, on the base plane and in the viewer's picture.

use slicecast::plan::Plan;
use slicecast::plane::{Depth, NO_DEPTH};
use slicecast::precision::Precision;
use slicecast::slice::Code12;

use crate::base::new_image;
use crate::camera::Picture;
use crate::error::RenderError;
use crate::folds::Folds;
use crate::frame::Prepared;
use crate::oriented::Oriented;
use crate::progress::Progress;
use crate::tile::TILE_ROWS;
use crate::tiles::fold_oriented;
use crate::with_precision;

/// Depths of a frame, planes from the first, 16.16; [`NO_DEPTH`] where no surface is met.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DepthImage {
    /// Pixels across and down.
    pub size: [usize; 2],
    /// Row after row.
    pub depths: Vec<u32>,
}

/// The depths of a frame's rays, all phases interleaved; `None` if the scene has no visible surface.
///
/// # Errors
/// [`RenderError::Memory`] before anything too large is allocated.
pub fn depths(
    prepared: &Prepared<'_>,
    volume: &Oriented<'_>,
    progress: Progress<'_>,
) -> Result<Option<DepthImage>, RenderError> {
    with_precision!(prepared.scene.precision, p => of_precision(p, prepared, volume, progress))
}

fn of_precision<P: Precision>(
    precision: P,
    prepared: &Prepared<'_>,
    volume: &Oriented<'_>,
    progress: Progress<'_>,
) -> Result<Option<DepthImage>, RenderError> {
    let plan = &prepared.setup.plan;
    let surfaces = prepared
        .segments
        .as_ref()
        .map_or(&[][..], |segments| segments.surfaces());
    if surfaces.is_empty() {
        return Ok(None);
    }
    let pipeline = Depth::new(precision, surfaces, plan).unwrap_or_else(|error| unreachable!("{error}"));
    let pipeline: &dyn Folds<Voxel = Code12, Element = u32> = &pipeline;
    let mut image = new_image(plan, pipeline)?;
    fold_oriented(
        prepared.setup.geometry(),
        pipeline,
        volume,
        &mut image,
        TILE_ROWS.into(),
        prepared.simd,
        progress,
    );
    Ok(Some(interleaved(plan, &image)))
}

/// An image with its phases interleaved.
fn interleaved(plan: &Plan, image: &[u32]) -> DepthImage {
    let n = plan.sampling().rays_per_voxel as usize;
    let [base_width, base_height] = plan.base().map(|side| side as usize);
    let size = [base_width * n, base_height * n];
    let place = |u: usize, v: usize| {
        let phase = u % n + v % n * n;
        (phase * base_height + v / n) * base_width + u / n
    };
    let pixels = (0..size[1]).flat_map(|v| (0..size[0]).map(move |u| (u, v)));
    DepthImage {
        size,
        depths: pixels.map(|(u, v)| image[place(u, v)]).collect(),
    }
}

impl DepthImage {
    /// The picture's depths, those of the nearest rays.
    pub fn warped(&self, picture: &Picture) -> Self {
        let size = picture.size.map(|side| side as usize);
        let nearest = |x: usize, y: usize| {
            let place = |axis: usize| {
                let [from, right, down] =
                    [picture.warp.origin, picture.warp.right, picture.warp.down].map(|v| i128::from(v[axis].to_bits()));
                let at = from + right * x as i128 + down * y as i128;
                usize::try_from((at + (1 << 31)) >> 32)
                    .ok()
                    .filter(|at| *at < self.size[axis])
            };
            match (place(0), place(1)) {
                (Some(u), Some(v)) => self.depths[v * self.size[0] + u],
                _ => NO_DEPTH,
            }
        };
        let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
        Self {
            size,
            depths: pixels.map(|(x, y)| nearest(x, y)).collect(),
        }
    }

    /// 16-bit levels: 1 for the first plane to 65535 for the last one, to nearest; 0 where no surface is met.
    pub fn levels(&self, planes: u32) -> Vec<u16> {
        let all = f64::from(planes.saturating_sub(1).max(1)) * 65536.0;
        let level = |depth: &u32| match *depth {
            NO_DEPTH => 0,
            depth => 1 + (f64::from(depth) / all * 65534.0).round().min(65534.0) as u16,
        };
        self.depths.iter().map(level).collect()
    }
}
