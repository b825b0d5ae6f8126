//! The parts of a plane: which pixels have a sample in it, or a segment in front of it, of the same cells.
//!
//! Of whole borders there is one. A plane of exact borders has more: the pixels whose segments lie in the volume as a whole, and
//! at each end rows and columns of those whose segments are cut by a face, or whose samples are held to the voxels; of samples
//! at most one at each end, of segments two. All pixels of a part share cells and the part of the segment, so each is folded like
//! a plane of its own. Crop boxes change this file.

use core::ops::Range;

use super::extent::Extent;
use super::slabs::window_behind;
use crate::borders::{Borders, Part, Side, along_k};
use crate::format::{Position, Weight};
use crate::locate::{Cell, Plane, cell, cut, end_plane, inside};
use crate::plan::Plan;
use crate::slice::Window;

/// Pixels of a plane, along one side.
#[derive(Clone)]
struct Axis {
    /// Those of which something counts.
    touched: Range<u32>,
    /// Those of them whose segments lie in the volume, and all whose samples do; empty where there are none.
    inner: Range<u32>,
    /// The segments; `None`: whole borders.
    side: Option<Side>,
    voxels: u32,
}

/// Pixels of the same cells and the same part of their segments: the inner ones, or one of the others.
#[derive(Clone)]
struct Band {
    pixels: Range<u32>,
    part: Part,
    /// Whether it is not that of the inner pixels.
    edge: bool,
}

impl Axis {
    fn of(side: Option<Side>, samples: [Position; 2], voxels: u32, pixels: u32) -> Self {
        let [a, b] = samples.map(|at| inside(cell(at), voxels, pixels));
        let both = shared(a, b);
        let Some(side) = side else {
            let touched = both.clone();
            return Self {
                touched,
                inner: both,
                side: None,
                voxels,
            };
        };
        Self {
            touched: side.touched(pixels),
            inner: shared(side.whole(pixels), both),
            side: Some(side),
            voxels,
        }
    }

    /// The band that begins with a pixel.
    fn band(&self, pixel: u32) -> Option<Band> {
        if pixel >= self.touched.end {
            return None;
        }
        let edge = pixel != self.inner.start || self.inner.is_empty();
        Some(match self.side {
            Some(side) if edge => Band {
                pixels: pixel..pixel + 1,
                part: side.part(pixel),
                edge,
            },
            _ => Band {
                pixels: self.inner.clone(),
                part: Part::WHOLE,
                edge,
            },
        })
    }

    /// The cell of a band's samples, held to the voxels, given where that of pixel 0 lies.
    fn cell(&self, band: &Band, at: Position) -> Cell {
        let at = cell(at);
        if !band.edge {
            return at;
        }
        let (first, last) = (band.pixels.start as i32, self.voxels as i32 - 1);
        let voxel = at.index.wrapping_add(first);
        let held = voxel.min(last).max(0);
        let weight = if held == voxel && held < last {
            at.weight
        } else {
            Weight::ZERO
        };
        Cell {
            index: held.wrapping_sub(first),
            weight,
        }
    }
}

/// What two ranges have in common.
fn shared(a: Range<u32>, b: Range<u32>) -> Range<u32> {
    let start = a.start.max(b.start);
    start..a.end.min(b.end).max(start)
}

/// A part of a plane: columns and rows, and what counts of their segments.
pub(super) struct Patch {
    columns: Band,
    rows: Band,
    part: Part,
}

impl Patch {
    /// Whether its rows are read as a whole: a column at a border has a window of its own.
    pub(super) fn has_whole_rows(&self) -> bool {
        !self.columns.edge
    }

    /// Where its segments lie, which end at the plane with this number.
    pub(super) fn way(&self, index: u32) -> Way {
        Way {
            from: (index.wrapping_sub(1) << 16).wrapping_add(self.part.from),
            length: self.part.length(),
        }
    }

    /// Whether its samples are those of whole segments, at their own places.
    pub(super) fn is_inner(&self) -> bool {
        !self.columns.edge && !self.rows.edge && self.part == Part::WHOLE
    }
}

/// Where segments lie along their rays, in planes, 16.16.
#[derive(Clone, Copy)]
pub(super) struct Way {
    from: u32,
    length: u32,
}

impl Way {
    /// The place of a position in a segment, 0 to 65536.
    pub(super) fn at(self, position: u32) -> u32 {
        // At most 2^32: of a position of 1 in a whole segment.
        let way = (u64::from(self.length) * u64::from(position)) >> 16;
        self.from.wrapping_add(way as u32)
    }
}

/// The parts of a plane. Those of which nothing counts are left out.
pub(super) struct Parts<'a> {
    plan: &'a Plan,
    plane: &'a Plane,
    columns: Axis,
    rows: Axis,
    along: Part,
    /// The band of rows whose parts come next, and the first column of the next one.
    row: Option<Band>,
    column: u32,
}

impl<'a> Parts<'a> {
    /// Of a plane of samples.
    pub(super) fn of_samples(plan: &'a Plan, plane: &'a Plane) -> Self {
        let [start_i, start_j] = plan.start(plane.phase);
        let exact = plan.borders() != Borders::Whole;
        let sides =
            [(0, start_i), (1, start_j)].map(|(axis, start)| exact.then(|| Side::of(plan, start, axis, plane.index)));
        Self::of(plan, plane, sides, [[plane.x; 2], [plane.y; 2]], Part::WHOLE)
    }

    /// Of the segments that end at a plane; none end at the first.
    pub(super) fn of_segments(plan: &'a Plan, plane: &'a Plane) -> Option<Self> {
        let index = plane.index.checked_sub(1)?;
        let [start_i, start_j] = plan.start(plane.phase);
        let exact = plan.borders() != Borders::Whole;
        let sides =
            [(0, start_i), (1, start_j)].map(|(axis, start)| exact.then(|| Side::behind(plan, start, axis, index)));
        let front = end_plane(plan, plane.phase, index);
        let samples = [[front.x, plane.x], [front.y, plane.y]];
        Some(Self::of(plan, plane, sides, samples, along_k(plan, index)))
    }

    fn of(
        plan: &'a Plan,
        plane: &'a Plane,
        [side_i, side_j]: [Option<Side>; 2],
        [x, y]: [[Position; 2]; 2],
        along: Part,
    ) -> Self {
        let ([width, height, _], [columns, rows]) = (plan.dims(), plan.base());
        let (columns, rows) = (Axis::of(side_i, x, width, columns), Axis::of(side_j, y, height, rows));
        Self {
            plan,
            plane,
            row: rows.band(rows.touched.start),
            column: columns.touched.start,
            columns,
            rows,
            along,
        }
    }

    /// The samples of a part and their window.
    pub(super) fn samples<'w>(&self, patch: &Patch, window: &Window<'w>) -> (Extent, Window<'w>) {
        let Plane { x, y, z, .. } = *self.plane;
        let (mut extent, mut window) = (self.extent(patch, [x, y, z]), *window);
        if patch.columns.edge {
            self.narrow([(&mut extent, &mut window)]);
        }
        (extent, window)
    }

    /// The front and the back ends of the segments of a part, and their windows, given that of the plane. `None` where the
    /// volume has no such slice.
    pub(super) fn segments<'w>(
        &self,
        patch: &Patch,
        window: &Window<'w>,
        lit: bool,
    ) -> Option<[(Extent, Window<'w>); 2]> {
        let Plane { index, phase, .. } = *self.plane;
        let index = index.checked_sub(1)?;
        let near = cell(end_plane(self.plan, phase, index).z).index;
        let Part { from, to } = patch.part;
        let end = |part| {
            let extent = self.extent(patch, cut(self.plan, phase, index, part));
            let window = window_behind(window, extent.z.index != near, lit)?;
            Some((extent, window))
        };
        let [mut front, mut back] = [end(from)?, end(to)?];
        if patch.columns.edge {
            self.narrow([(&mut front.0, &mut front.1), (&mut back.0, &mut back.1)]);
        }
        Some([front, back])
    }

    /// The extent of a part whose samples lie so for pixel (0, 0).
    fn extent(&self, patch: &Patch, [x, y, z]: [Position; 3]) -> Extent {
        let Patch { columns, rows, part } = patch;
        let cells = [self.columns.cell(columns, x), self.rows.cell(rows, y), cell(z)];
        let pixels = [columns.pixels.clone(), rows.pixels.clone()];
        Extent::of(pixels, cells, self.rows.voxels, part.length())
    }

    /// Gives the samples of a column windows that hold what gradients look at, and so cost no whole rows.
    fn narrow<const N: usize>(&self, mut ends: [(&mut Extent, &mut Window<'_>); N]) {
        let voxels = || ends.iter().map(|(extent, _)| extent.voxel);
        let (first, last) = (voxels().fold(usize::MAX, Ord::min), voxels().fold(0, Ord::max));
        let kept = first.saturating_sub(1)..(last + 3).min(self.columns.voxels as usize);
        for (extent, window) in &mut ends {
            extent.narrow(kept.start);
            **window = window.columns(kept.clone());
        }
    }
}

impl Parts<'_> {
    /// The next part.
    pub(super) fn next_patch(&mut self) -> Option<Patch> {
        loop {
            let rows = self.row.as_ref()?;
            let Some(columns) = self.columns.band(self.column) else {
                self.row = self.rows.band(rows.pixels.end);
                self.column = self.columns.touched.start;
                continue;
            };
            self.column = columns.pixels.end;
            let part = columns.part.and(rows.part).and(self.along);
            if part.length() > 0 {
                let rows = rows.clone();
                return Some(Patch { columns, rows, part });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::Direction;
    use crate::locate::plane;
    use crate::plan::{Sampling, Spacing};
    use crate::slice::{RowRange, Slice};
    use crate::view::View;
    use proptest::prelude::*;
    use proptest::test_runner::TestCaseError;
    use std::collections::BTreeMap;
    use std::vec;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 400, rng_seed: proptest::test_runner::RngSeed::Fixed(4), ..ProptestConfig::default() })]

        /// Every pixel with a fraction lies in one part, at its own position held to the voxels, and no other pixel does: of
        /// samples, and of both ends of segments.
        #[test]
        fn parts_are_the_pixels_with_a_fraction(
            i in prop_oneof![Just(0i64), Just(1 << 58), Just(-1 << 58), -(1i64 << 58)..=1 << 58],
            j in -(1i64 << 58)..=1 << 58,
            dims in prop::array::uniform3(1u32..=6), rate in 1u32..=4, rays in 1u32..=3, cells in any::<bool>(), nearest in any::<bool>(),
        ) {
            let view = View::new([i, j, 1 << 58].map(Direction::from_bits)).unwrap();
            let sampling = Sampling { planes_per_voxel: rate, rays_per_voxel: rays };
            let borders = if cells { Borders::Cells } else { Borders::Nodes };
            let Ok(plan) = Plan::with_borders(view, dims, Spacing::CUBIC, sampling, borders) else { return Ok(()) };
            let plan = if nearest { plan.with_nearest() } else { plan };
            let [width, height, _] = plan.dims();
            let voxels = vec![0; (width * height) as usize];
            let mut ranges = vec![RowRange::EMPTY; height as usize];
            let near = Slice::measure(&voxels, width as usize, height as usize, width as usize, &mut ranges).unwrap();
            let window = Window { before: None, near, far: Some(near), after: None };
            for phase in (0..plan.phases()).map(|number| plan.phase(number)) {
                let [start_i, start_j] = plan.start(phase);
                for index in 0..plan.planes() {
                    let at = plane(&plan, phase, index);
                    let mut parts = Parts::of_samples(&plan, &at);
                    let mut found = BTreeMap::new();
                    while let Some(patch) = parts.next_patch() {
                        noted(&mut found, &patch, &parts.samples(&patch, &window))?;
                    }
                    let side = |axis, start| Side::of(&plan, start, axis, index);
                    let part = |u, v| side(0, start_i).part(u).and(side(1, start_j).part(v));
                    held(&plan, &found, part, |_| [at.x, at.y, at.z])?;
                }
                for index in 0..plan.ends() - 1 {
                    let at = end_plane(&plan, phase, index + 1);
                    let mut parts = Parts::of_segments(&plan, &at).unwrap();
                    let mut found = [BTreeMap::new(), BTreeMap::new()];
                    while let Some(patch) = parts.next_patch() {
                        let ends = parts.segments(&patch, &window, true).unwrap();
                        for (found, end) in found.iter_mut().zip(&ends) {
                            noted(found, &patch, end)?;
                        }
                        if patch.is_inner() {
                            let front = end_plane(&plan, phase, index);
                            let cells = ends.each_ref().map(|(extent, _)| [extent.x, extent.y, extent.z]);
                            prop_assert_eq!(cells, [[front.x, front.y, front.z].map(cell), [at.x, at.y, at.z].map(cell)]);
                        }
                    }
                    let side = |axis, start| Side::behind(&plan, start, axis, index);
                    let part = |u, v| side(0, start_i).part(u).and(side(1, start_j).part(v)).and(along_k(&plan, index));
                    held(&plan, &found[0], part, |part| cut(&plan, phase, index, part.from))?;
                    held(&plan, &found[1], part, |part| cut(&plan, phase, index, part.to))?;
                }
            }
        }
    }

    /// Fraction, cells, and column of the window, of each pixel that has been found.
    type Found = BTreeMap<[u32; 2], (u32, [i32; 5], Option<usize>)>;

    fn noted(found: &mut Found, patch: &Patch, (extent, window): &(Extent, Window<'_>)) -> Result<(), TestCaseError> {
        for (row, column) in extent
            .rows
            .clone()
            .flat_map(|v| extent.columns.clone().map(move |u| (v, u)))
        {
            // Columns of a window that is narrower are counted from its first voxel.
            let first = (column - extent.columns.start) + extent.voxel;
            prop_assert_eq!(first as i32, column as i32 + extent.x.index);
            prop_assert!(patch.has_whole_rows() || extent.columns.len() == 1);
            prop_assert!(first < window.near.width());
            let [wx, wy, wz] = [extent.x, extent.y, extent.z].map(|cell| cell.weight.to_bits() as i32);
            let cells = [extent.y.index + row as i32, extent.z.index, wx, wy, wz];
            let voxel = patch.has_whole_rows().then_some(first);
            prop_assert_eq!(
                found.insert([column as u32, row], (extent.fraction, cells, voxel)),
                None
            );
        }
        Ok(())
    }

    /// Holds what was found against every pixel's own part and position.
    fn held(
        plan: &Plan,
        found: &Found,
        part: impl Fn(u32, u32) -> Part,
        at: impl Fn(Part) -> [Position; 3],
    ) -> Result<(), TestCaseError> {
        let ([width, height, depth], [columns, rows]) = (plan.dims(), plan.base());
        for (u, v) in (0..columns).flat_map(|u| (0..rows).map(move |v| (u, v))) {
            let part = part(u, v);
            let Some((fraction, cells, voxel)) = found.get(&[u, v]) else {
                prop_assert_eq!(part.length(), 0, "pixel {} {} is in no part", u, v);
                continue;
            };
            prop_assert_eq!(*fraction, part.length());
            let held = |at: Position, pixel: u32, side: u32| {
                (at.to_bits() + ((pixel as i32) << 16)).clamp(0, (side as i32 - 1) << 16)
            };
            let [x, y, z] = at(part);
            let [x, y, z] = [held(x, u, width), held(y, v, height), held(z, 0, depth)];
            prop_assert_eq!(*cells, [y >> 16, z >> 16, x & 0xffff, y & 0xffff, z & 0xffff]);
            prop_assert!(voxel.is_none_or(|voxel| voxel as i32 == x >> 16));
        }
        Ok(())
    }
}
