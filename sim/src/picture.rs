//! The viewer's picture: the final warp of core, with the base plane's addresses worked out beforehand.
//!
//! A picture pixel looks at four neighbours of the base plane, which interleaves its phases. Where each column and row of
//! it lies in memory is listed once a frame; where all four are clear, or do not exist, the background is seen.

use rayon::prelude::*;
use slicecast::composite::Pixel;
use slicecast::plan::Plan;
use slicecast::plane::{ChannelOf, Pipeline};
use slicecast::stream::phase_len;
use slicecast::warp::{Point, in_front_of, mix_pixels};

use crate::camera::Picture;
use crate::engine::{Prepared, Rgb, background};

/// The picture of a base-plane image, in front of the scene's background.
pub(crate) fn picture<L: Pipeline>(prepared: &Prepared<'_>, pipeline: &L, image: &[L::Element]) -> Rgb {
    let Picture { size, warp, .. } = prepared.setup.picture;
    let background = background(prepared.scene);
    let base = Base::of(&prepared.setup.plan, pipeline, image);
    let clear = in_front_of(Pixel::<ChannelOf<L::Precision>>::clear(), background);
    let [width, height] = size.map(|side| side as usize);
    let mut bytes = vec![0; 3 * width * height];
    bytes
        .par_chunks_mut((3 * width).max(1))
        .enumerate()
        .for_each(|(y, row)| {
            for (x, out) in row.as_chunks_mut::<3>().0.iter_mut().enumerate() {
                let point = warp.point(x as u32, y as u32);
                *out = base.mixed(point).map_or(clear, |pixel| in_front_of(pixel, background));
            }
        });
    Rgb { size, bytes }
}

/// A base-plane image with its phases interleaved.
struct Base<'a, L: Pipeline> {
    pipeline: &'a L,
    image: &'a [L::Element],
    row_len: usize,
    /// Of each column: where its phase begins, and its column there.
    columns: Vec<(usize, usize)>,
    /// Of each row: where it begins in the first phase of its rows.
    rows: Vec<usize>,
}

impl<'a, L: Pipeline> Base<'a, L> {
    fn of(plan: &Plan, pipeline: &'a L, image: &'a [L::Element]) -> Self {
        let n = plan.sampling().rays_per_voxel as usize;
        let [width, height] = plan.base().map(|side| side as usize);
        let (phase_len, row_len) = (phase_len::<L>(plan), L::CHANNELS * width);
        Self {
            pipeline,
            image,
            row_len,
            columns: (0..n * width).map(|u| (u % n * phase_len, u / n)).collect(),
            rows: (0..n * height)
                .map(|v| n * (v % n) * phase_len + v / n * row_len)
                .collect(),
        }
    }

    /// The mixture of the four pixels around a point; `None` where all of them are clear.
    fn mixed(&self, point: Point) -> Option<Pixel<ChannelOf<L::Precision>>> {
        let Point {
            pixel: [u, v],
            weight: [wu, wv],
        } = point;
        let index = |place: i64| usize::try_from(place).ok();
        let columns = [u, u + 1].map(|u| index(u).and_then(|u| self.columns.get(u)));
        let rows = [v, v + 1].map(|v| index(v).and_then(|v| self.rows.get(v)));
        if columns == [None; 2] || rows == [None; 2] {
            return None;
        }
        let pixel = |row: Option<&usize>, column: Option<&(usize, usize)>| match (row, column) {
            (Some(row), Some((phase, column))) => {
                let start = row + phase;
                self.pipeline.pixel(&self.image[start..start + self.row_len], *column)
            }
            _ => Pixel::clear(),
        };
        let [a, b, c, d] = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(row, column)| pixel(rows[row], columns[column]));
        if [a, b, c, d] == [Pixel::clear(); 4] {
            return None;
        }
        Some(mix_pixels(mix_pixels(a, b, wu), mix_pixels(c, d, wu), wv))
    }
}
