//! The opponent: the same pipeline in 32-bit floats, to be measured against.
//!
//! Squeeze claims that fixed point is up to four times as fast as floats; that is only worth something against floats
//! that somebody has tuned. So this has the structure of the fixed-point engine (slice order, tiles through all planes,
//! rows of plane-constant weights, skipping by the same row ranges, the same blocks where few can be seen, two-pass shading), lanes of the same widths, and
//! what floats make cheap: fused multiply-adds, an estimated reciprocal root with one Newton step, no shifts. It reads
//! the same voxels, the same compiled table, plan and lights; `tests` holds its pictures against the fixed-point ones.
//! Front to back only, tables looked up linearly.

mod blocks;
mod light;
mod rows;
mod table;
#[cfg(test)]
mod tests;
mod tile;

use rayon::prelude::*;
use slicecast::composite::FrontToBack;
use slicecast::format::Intensity;
use slicecast::plan::Plan;
use slicecast::plane::{Composite, Pipeline as _};
use slicecast::precision::Compact;
use slicecast::shade::Unlit;

use self::blocks::Batch;
use self::light::FloatPhong;
use self::rows::{FIRST, row_len};
use self::table::FloatTable;
use self::tile::{FoldBlocks, FoldTile, SCRATCH_ROWS};
use slicecast_engine::expanded::Expanded;
use slicecast_engine::frame::Prepared;
use slicecast_engine::occupancy::Looks;
use slicecast_engine::oriented::Oriented;
use slicecast_engine::simd::Simd;
use slicecast_engine::simd::floats::with_floats;
use slicecast_engine::tiles::tiles;

/// A scene in floats.
#[derive(Clone, Debug)]
pub struct Opponent {
    table: FloatTable,
    phong: Option<FloatPhong>,
    /// Spacing factors along i, j, k; `None` for cubic voxels.
    spacing: Option<[f32; 3]>,
    /// Transparency below this is none: the default precision's own limit.
    floor: f32,
    /// Share of blocks that can be seen below which they are made alone (docs/speed.md).
    few: f64,
}

/// Elements of a channel's run in a row of the image: whole vectors may be written behind the last pixel.
fn run_len(plan: &Plan) -> usize {
    let [width, _] = plan.base();
    (width as usize).next_multiple_of(FIRST) + FIRST
}

impl Opponent {
    /// The scene of a prepared frame.
    pub fn of(prepared: &Prepared<'_>) -> Self {
        let spacing = prepared.setup.plan.spacing();
        Self {
            table: FloatTable::of(&prepared.table),
            phong: prepared.setup.material.as_ref().map(FloatPhong::of),
            spacing: (spacing != [Intensity::ONE; 3]).then(|| spacing.map(|f| f32::from(f.to_bits()) / 32768.0)),
            floor: 1.0 / 65535.0,
            few: 0.3,
        }
    }

    /// Elements of an image.
    pub fn image_len(plan: &Plan) -> usize {
        let [_, height] = plan.base();
        4 * run_len(plan) * height as usize * plan.phases() as usize
    }

    /// Makes an image untouched.
    pub fn clear(plan: &Plan, image: &mut [f32]) {
        for (index, run) in image.chunks_mut(run_len(plan)).enumerate() {
            run.fill(if index % 4 == 3 { 1.0 } else { 0.0 });
        }
    }

    /// Folds all planes into an image, tile by tile on rayon's current threads: rows as a whole, or the blocks that can be seen
    /// where they are few.
    pub fn fold(&self, plan: &Plan, volume: &Oriented<'_>, image: &mut [f32], tile_rows: usize, simd: Simd) {
        let looks = Looks::of(Composite::<Compact, Expanded, Unlit, FrontToBack>::SHAPE, plan);
        let occupancy = volume.occupancy();
        let few = occupancy.share(looks, self.table.support) < self.few;
        let seen = few.then(|| occupancy.sight(looks, self.table.support));
        let [width, _, _] = plan.dims();
        let scratch_len = SCRATCH_ROWS * row_len(width as usize);
        let tiles = tiles(plan, image, 4 * run_len(plan), tile_rows);
        tiles.into_par_iter().with_max_len(1).for_each_init(
            || {
                let scratch = vec![0.0; scratch_len + FIRST];
                (scratch, vec![0; row_len(width as usize)], Batch::new())
            },
            |(scratch, codes, batch), (tile, data)| {
                // Rows begin at a cache line.
                let aligned = scratch.as_ptr().align_offset(64).min(FIRST);
                let fold = FoldTile {
                    opponent: self,
                    plan,
                    slices: volume.slices,
                    tile,
                    data,
                    scratch: &mut scratch[aligned..aligned + scratch_len],
                    codes,
                    seen: seen.as_ref(),
                    batch,
                };
                if seen.is_some() {
                    with_floats(simd, FoldBlocks(fold));
                } else {
                    with_floats(simd, fold);
                }
            },
        );
    }

    /// Red, green, blue and transparency of a base-plane pixel, all phases interleaved; one that exists.
    pub fn pixel(plan: &Plan, image: &[f32], u: usize, v: usize) -> [f32; 4] {
        let n = plan.sampling().rays_per_voxel as usize;
        let [_, height] = plan.base();
        let run = run_len(plan);
        let phase = u % n + v % n * n;
        let row = 4 * run * (phase * height as usize + v / n);
        [0, 1, 2, 3].map(|channel| image[row + channel * run + u / n])
    }
}
