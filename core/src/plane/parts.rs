//! The parts of a plane: which pixels have a sample in it, or a segment in front of it, of the same cells.
//!
//! Of whole borders there is one. A plane of exact borders has more: the pixels whose segments lie in the volume as a whole, and
//! at each end rows and columns of those whose segments are cut by a face, or whose samples are held to the voxels; of samples
//! at most one at each end, of segments two. All pixels of a part share cells and the part of the segment, so each is folded like
//! a plane of its own. A crop box is another box: its faces lie in the plan.

use core::any::Any;
use core::ops::Range;

use super::extent::Extent;
use crate::borders::{Borders, Part, fraction_row};
use crate::format::{Position, Weight};
use crate::lanes::{Lanes, Small};
use crate::locate::{Cell, Plane, cell, cut, end_plane, inside};
use crate::plan::{Exact, Plan, PlanError, Sampling, Spacing};
use crate::sides::Side;
use crate::sides::about_k;
use crate::sides::along_k;
use crate::slice::Window;
use crate::view::View;

/// The window of an end of segments, given that of their front ends: the same, or one slice further. `None` where the volume
/// has no such slice. In the second of its slices only gradients read the one behind it; others must not look at it, because
/// a ring has it no longer, or not yet, and the same rows are to be left out everywhere.
pub(super) fn window_behind<'w>(window: &Window<'w>, further: bool, lit: bool) -> Option<Window<'w>> {
    if !further {
        return Some(*window);
    }
    Some(Window {
        before: Some(window.near),
        near: window.far?,
        far: window.after.filter(|_| lit),
        // Its weight is zero.
        after: None,
    })
}

/// What samples of exact borders are to the plane layer; a plan holds a reference ([`Exact`]). Segments need none: only their drivers
/// call [`exact_segments`].
pub(super) struct Code {
    /// The next part of a plane of samples.
    samples: for<'w> fn(&mut Parts<'_>, &Window<'w>) -> Option<Samples<'w>>,
    /// Makes opacities those of a fraction, on a small machine.
    pub(super) reduce: fn(&mut [i32], u32),
}

static CODE: Code = Code {
    samples: exact_samples,
    reduce: fraction_row::<Small>,
};

static CELLS: Exact = Exact {
    borders: Borders::Cells,
    code: &CODE,
};

static NODES: Exact = Exact {
    borders: Borders::Nodes,
    code: &CODE,
};

/// The code of a plan's exact borders, if it has such.
pub(super) fn code(plan: &Plan) -> Option<&'static Code> {
    let any: &dyn Any = plan.exact()?.code;
    any.downcast_ref()
}

impl Plan {
    /// Plans a frame whose borders are [`Borders::Cells`]: volume sides along x, y, z in voxels, spacing, sampling rates.
    ///
    /// Base plane: the fewest columns and rows that hold all rays that meet the box; rays start at whole voxels (plus their
    /// phase).
    ///
    /// A `const` plan sizes arrays: `Needs::of` (`stream`) is `const` too, and `Reserved` holds what it counts.
    ///
    /// # Errors
    /// [`PlanError`], with the value that is out of range.
    pub const fn new(view: View, dims: [u32; 3], spacing: Spacing, sampling: Sampling) -> Result<Self, PlanError> {
        Self::of(view, dims, spacing, sampling, Some(&CELLS))
    }

    /// [`Plan::new`] with a choice of borders, or [`Plan::whole`].
    ///
    /// # Errors
    /// [`PlanError`], with the value that is out of range.
    pub const fn with_borders(
        view: View,
        dims: [u32; 3],
        spacing: Spacing,
        sampling: Sampling,
        borders: Borders,
    ) -> Result<Self, PlanError> {
        match borders {
            Borders::Whole => Self::whole(view, dims, spacing, sampling),
            Borders::Cells => Self::new(view, dims, spacing, sampling),
            Borders::Nodes => Self::of(view, dims, spacing, sampling, Some(&NODES)),
        }
    }
}

/// Pixels of a plane, along one side.
struct Axis {
    /// Those of which something counts.
    touched: Range<u32>,
    /// Those of them whose segments lie in the volume, and all whose samples do; empty where there are none.
    inner: Range<u32>,
    side: Side,
    voxels: u32,
}

/// Pixels of the same cells and the same part of their segments: the inner ones, or one of the others.
struct Band {
    pixels: Range<u32>,
    part: Part,
    /// Whether it is not that of the inner pixels.
    edge: bool,
}

impl Axis {
    fn of(side: Side, samples: [Position; 2], voxels: u32, pixels: u32) -> Self {
        Self {
            touched: side.touched(pixels),
            inner: shared(side.whole(pixels), between(samples, voxels, pixels)),
            side,
            voxels,
        }
    }

    /// The band that begins with a pixel, or the first one.
    fn band(&self, pixel: u32) -> Option<Band> {
        let pixel = pixel.max(self.touched.start);
        if pixel >= self.touched.end {
            return None;
        }
        let edge = pixel != self.inner.start || self.inner.is_empty();
        Some(if edge {
            Band {
                pixels: pixel..pixel + 1,
                part: self.side.part(pixel),
                edge,
            }
        } else {
            Band {
                pixels: self.inner.clone(),
                part: Part::WHOLE,
                edge,
            }
        })
    }

    /// Whether each of the pixels that are not inner is the first or the last of a row.
    fn ends_rows(&self) -> bool {
        let (touched, inner) = (&self.touched, &self.inner);
        !inner.is_empty() && inner.start <= touched.start + 1 && touched.end <= inner.end + 1
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
#[inline(always)]
fn shared(a: Range<u32>, b: Range<u32>) -> Range<u32> {
    let start = a.start.max(b.start);
    start..a.end.min(b.end).max(start)
}

/// Samples of the same cells, and their window.
pub(super) struct Samples<'w> {
    pub(super) extent: Extent,
    pub(super) window: Window<'w>,
    /// Whether rows are made as a whole: of a column at a border single samples are.
    pub(super) whole_rows: bool,
}

/// Segments whose ends have the same cells.
pub(super) struct Segments<'w> {
    /// Their front ends and their back ends.
    pub(super) ends: [Samples<'w>; 2],
    /// Whether they are whole, and their ends at their own places.
    pub(super) inner: bool,
    /// Where they lie along their rays.
    pub(super) way: Way,
}

/// Where segments lie along their rays, in planes, 16.16.
#[derive(Clone, Copy)]
pub(super) struct Way {
    from: u32,
    length: u32,
}

impl Way {
    /// What counts of segments behind a plane.
    fn of(index: u32, part: Part) -> Self {
        Self {
            from: (index << 16).wrapping_add(part.from),
            length: part.length(),
        }
    }

    /// The place of a position in a segment, 0 to 65536.
    pub(super) fn at(self, position: u32) -> u32 {
        let way = (u64::from(self.length) * u64::from(position)) >> 16;
        self.from.wrapping_add(way as u32)
    }
}

/// How the columns at borders are folded, whose samples are cut or held.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Columns {
    /// With the rows that they end, as far as these are samples.
    InRows,
    /// As parts of their own, whose samples are made one by one.
    InBlocks,
    /// As parts of their own, with a window that costs no whole rows.
    Alone,
}

/// The way through the parts of a plane. Those of which nothing counts are left out.
pub(super) struct Parts<'a> {
    plan: &'a Plan,
    plane: &'a Plane,
    columns: Columns,
    /// Column and row that the next part begins with, or an earlier one.
    next: [u32; 2],
    /// Both sides of exact borders, once they are found.
    axes: Option<[Axis; 2]>,
}

impl<'a> Parts<'a> {
    pub(super) fn of(plan: &'a Plan, plane: &'a Plane, columns: Columns) -> Self {
        Self {
            plan,
            plane,
            columns,
            next: [0; 2],
            axes: None,
        }
    }

    /// The next samples.
    #[inline(always)]
    pub(super) fn samples<'w, V: Lanes>(&mut self, window: &Window<'w>) -> Option<Samples<'w>> {
        if V::SMALL {
            self.next_samples(window)
        } else {
            self.samples_once(window)
        }
    }

    /// The next segments that end at the plane, given the window of their front ends; none end at the first.
    #[inline(always)]
    pub(super) fn segments<'w, V: Lanes>(&mut self, window: &Window<'w>, lit: bool) -> Option<Segments<'w>> {
        if V::SMALL {
            self.next_segments(window, lit)
        } else {
            self.segments_once(window, lit)
        }
    }

    /// A host has the code once for all pipelines.
    #[inline(never)]
    fn samples_once<'w>(&mut self, window: &Window<'w>) -> Option<Samples<'w>> {
        self.next_samples(window)
    }

    #[inline(never)]
    fn segments_once<'w>(&mut self, window: &Window<'w>, lit: bool) -> Option<Segments<'w>> {
        self.next_segments(window, lit)
    }

    #[inline(always)]
    fn next_samples<'w>(&mut self, window: &Window<'w>) -> Option<Samples<'w>> {
        if let Some(code) = code(self.plan) {
            return (code.samples)(self, window);
        }
        let Plane { x, y, z, .. } = *self.plane;
        let pixels = self.whole([[x; 2], [y; 2]])?;
        Some(Samples {
            extent: Extent::of(pixels, [x, y, z].map(cell), self.height(), Part::WHOLE),
            window: *window,
            whole_rows: true,
        })
    }

    #[inline(always)]
    fn next_segments<'w>(&mut self, window: &Window<'w>, lit: bool) -> Option<Segments<'w>> {
        if self.plan.exact().is_some() {
            return exact_segments(self, window, lit);
        }
        let index = self.plane.index.checked_sub(1)?;
        let front = end_plane(self.plan, self.plane.phase, index);
        let ends = [&front, self.plane];
        let pixels = self.whole([ends.map(|end| end.x), ends.map(|end| end.y)])?;
        let [front, back] = ends.map(|end| {
            Some(Samples {
                extent: Extent::of(
                    pixels.clone(),
                    [end.x, end.y, end.z].map(cell),
                    self.height(),
                    Part::WHOLE,
                ),
                window: window_behind(window, cell(end.z).index != cell(front.z).index, lit)?,
                whole_rows: true,
            })
        });
        Some(Segments {
            ends: [front?, back?],
            inner: true,
            way: Way::of(index, Part::WHOLE),
        })
    }

    /// The pixels, along both sides, of whole borders, whose only part comes first.
    #[inline(always)]
    fn whole(&mut self, [x, y]: [[Position; 2]; 2]) -> Option<[Range<u32>; 2]> {
        let [next, _] = &mut self.next;
        if core::mem::replace(next, 1) > 0 {
            return None;
        }
        let ([width, height, _], [columns, rows]) = (self.plan.dims(), self.plan.base());
        Some([between(x, width, columns), between(y, height, rows)])
    }

    /// Rows of a slice.
    fn height(&self) -> u32 {
        let [_, height, _] = self.plan.dims();
        height
    }

    /// The next part of exact borders of which something counts: its bands and its part of the segments.
    fn next_of(&mut self, [columns, rows]: &[Axis; 2], along: Part) -> Option<([Band; 2], Part)> {
        loop {
            let [column, row] = self.next;
            let row = rows.band(row)?;
            let Some(column) = columns.band(column) else {
                self.next = [0, row.pixels.end];
                continue;
            };
            self.next = [column.pixels.end, row.pixels.start];
            let part = column.part.and(row.part).and(along);
            if part.length() > 0 {
                return Some(([column, row], part));
            }
        }
    }
}

impl Parts<'_> {
    /// The next rows of exact borders, with the columns at their ends.
    fn next_rows(&mut self, [columns, rows]: &[Axis; 2], along: Part, [x, y, z]: [Position; 3]) -> Option<Extent> {
        loop {
            let [_, next] = self.next;
            let row = rows.band(next)?;
            self.next = [0, row.pixels.end];
            let part = row.part.and(along);
            if part.length() == 0 {
                continue;
            }
            let (touched, inner) = (&columns.touched, &columns.inner);
            let end = |pixel: u32, inside: bool| {
                let end = columns.side.part(pixel).and(part);
                (!inside && end.length() > 0).then_some(end)
            };
            let ends = [
                end(touched.start, touched.start == inner.start),
                end(inner.end, touched.end == inner.end),
            ];
            let [low, high] = ends.map(|end| u32::from(end.is_some()));
            let pixels = [inner.start - low..inner.end + high, row.pixels.clone()];
            let cells = [cell(x), rows.cell(&row, y), cell(z)];
            let extent = Extent::of(pixels, cells, rows.voxels, part);
            return Some(extent.with_ends(ends, columns.voxels));
        }
    }
}

/// The pixels along one side whose samples lie between the outermost voxels, on both of two planes.
#[inline(always)]
fn between(samples: [Position; 2], voxels: u32, pixels: u32) -> Range<u32> {
    let [a, b] = samples.map(|at| inside(cell(at), voxels, pixels));
    shared(a, b)
}

/// The extent of a part of exact borders whose samples lie so for pixel (0, 0).
fn extent([columns, rows]: &[Axis; 2], [column, row]: &[Band; 2], part: Part, [x, y, z]: [Position; 3]) -> Extent {
    let cells = [columns.cell(column, x), rows.cell(row, y), cell(z)];
    let pixels = [column.pixels.clone(), row.pixels.clone()];
    Extent::of(pixels, cells, rows.voxels, part)
}

/// Gives the samples of a column windows that cost no whole rows.
fn narrow_column(samples: &mut [Samples<'_>], voxels: u32, columns: Columns) {
    for samples in &mut *samples {
        samples.whole_rows = false;
    }
    if columns == Columns::InBlocks {
        return;
    }
    narrow(samples, voxels);
    for samples in samples {
        samples.window = samples.window.of_few();
    }
}

/// Gives samples of some columns of slices of this width windows that hold what gradients look at, and no more.
pub(super) fn narrow(samples: &mut [Samples<'_>], voxels: u32) {
    let (mut first, mut end) = (usize::MAX, 0);
    for Samples { extent, .. } in &*samples {
        first = first.min(extent.voxel);
        end = end.max(extent.voxel + extent.columns.len());
    }
    let kept = first.saturating_sub(1)..(end + 2).min(voxels as usize);
    for samples in samples {
        samples.extent.narrow(kept.start);
        samples.window = samples.window.columns(kept.clone());
    }
}

fn exact_samples<'w>(parts: &mut Parts<'_>, window: &Window<'w>) -> Option<Samples<'w>> {
    let (plan, Plane { index, phase, x, y, z }) = (parts.plan, *parts.plane);
    let ([width, height, _], [columns, rows]) = (plan.dims(), plan.base());
    let axes = parts.axes.take().unwrap_or_else(|| {
        let [start_i, start_j] = plan.start(phase);
        [
            Axis::of(Side::of(plan, start_i, 0, index), [x; 2], width, columns),
            Axis::of(Side::of(plan, start_j, 1, index), [y; 2], height, rows),
        ]
    });
    let along = about_k(plan, index);
    let [across, _] = &axes;
    if parts.columns == Columns::InRows && across.ends_rows() {
        let extent = parts.next_rows(&axes, along, [x, y, z]);
        parts.axes = Some(axes);
        return Some(Samples {
            extent: extent?,
            window: *window,
            whole_rows: true,
        });
    }
    let (bands, part) = parts.next_of(&axes, along)?;
    let mut samples = [Samples {
        extent: extent(&axes, &bands, part, [x, y, z]),
        window: *window,
        whole_rows: true,
    }];
    parts.axes = Some(axes);
    let [column, _] = &bands;
    if column.edge {
        narrow_column(&mut samples, width, parts.columns);
    }
    let [samples] = samples;
    Some(samples)
}

/// A pipeline's tiles, lanes and orders share one.
#[inline(never)]
fn exact_segments<'w>(parts: &mut Parts<'_>, window: &Window<'w>, lit: bool) -> Option<Segments<'w>> {
    let (plan, back) = (parts.plan, *parts.plane);
    let (index, phase) = (back.index.checked_sub(1)?, back.phase);
    let front = end_plane(plan, phase, index);
    let ([width, height, _], [columns, rows]) = (plan.dims(), plan.base());
    let axes = parts.axes.take().unwrap_or_else(|| {
        let [start_i, start_j] = plan.start(phase);
        [
            Axis::of(Side::behind(plan, start_i, 0, index), [front.x, back.x], width, columns),
            Axis::of(Side::behind(plan, start_j, 1, index), [front.y, back.y], height, rows),
        ]
    });
    let (bands, part) = parts.next_of(&axes, along_k(plan, index))?;
    let end = |place| {
        let extent = extent(&axes, &bands, part, cut(plan, phase, index, place));
        Some(Samples {
            window: window_behind(window, extent.z.index != cell(front.z).index, lit)?,
            extent,
            whole_rows: true,
        })
    };
    let mut ends = [end(part.from)?, end(part.to)?];
    parts.axes = Some(axes);
    let [column, row] = &bands;
    if column.edge {
        narrow_column(&mut ends, width, parts.columns);
    }
    Some(Segments {
        ends,
        inner: !column.edge && !row.edge && part == Part::WHOLE,
        way: Way::of(index, part),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crop::Crop;
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
            low in prop::array::uniform3(-40_000i32..=350_000), side in prop::array::uniform3(prop_oneof![1i32..=300, 1i32..=400_000]),
            crops in any::<bool>(),
        ) {
            let view = View::new([i, j, 1 << 58].map(Direction::from_bits)).unwrap();
            let sampling = Sampling { planes_per_voxel: rate, rays_per_voxel: rays };
            let borders = if cells { Borders::Cells } else { Borders::Nodes };
            let Ok(plan) = Plan::with_borders(view, dims, Spacing::CUBIC, sampling, borders) else { return Ok(()) };
            let plan = if nearest { plan.with_nearest() } else { plan };
            let crop = Crop {
                low: low.map(Position::from_bits),
                high: [0, 1, 2].map(|axis| Position::from_bits(low[axis] + side[axis])),
            };
            let plan = match plan.with_crop(crop) {
                Ok(cropped) if crops => cropped,
                _ => plan,
            };
            let [width, height, _] = plan.dims();
            let voxels = vec![0; (width * height) as usize];
            let mut ranges = vec![RowRange::EMPTY; height as usize];
            let near = Slice::measure(&voxels, width as usize, height as usize, width as usize, &mut ranges).unwrap();
            let window = Window { before: None, near, far: Some(near), after: None };
            for phase in (0..plan.phases()).map(|number| plan.phase(number)) {
                let [start_i, start_j] = plan.start(phase);
                for index in 0..plan.planes() {
                    let at = plane(&plan, phase, index);
                    for columns in [Columns::InRows, Columns::InBlocks, Columns::Alone] {
                        let mut parts = Parts::of(&plan, &at, columns);
                        let mut found = BTreeMap::new();
                        while let Some(samples) = parts.samples::<i32>(&window) {
                            noted(&mut found, &samples)?;
                        }
                        let side = |axis, start| Side::of(&plan, start, axis, index);
                        let part = |u, v| side(0, start_i).part(u).and(side(1, start_j).part(v)).and(about_k(&plan, index));
                        held(&plan, &found, part, |_| [at.x, at.y, at.z])?;
                    }
                }
                for index in 0..plan.ends() - 1 {
                    let at = end_plane(&plan, phase, index + 1);
                    let mut parts = Parts::of(&plan, &at, Columns::InRows);
                    let mut found = [BTreeMap::new(), BTreeMap::new()];
                    while let Some(Segments { ends, inner, .. }) = parts.segments::<i32>(&window, true) {
                        for (found, end) in found.iter_mut().zip(&ends) {
                            noted(found, end)?;
                        }
                        if inner {
                            let front = end_plane(&plan, phase, index);
                            let cells = ends.each_ref().map(|Samples { extent, .. }| [extent.x, extent.y, extent.z]);
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

    fn noted(
        found: &mut Found,
        Samples {
            extent,
            window,
            whole_rows,
        }: &Samples<'_>,
    ) -> Result<(), TestCaseError> {
        for (row, column) in extent
            .rows
            .clone()
            .flat_map(|v| extent.columns.clone().map(move |u| (v, u)))
        {
            // Columns of a window that is narrower are counted from its first voxel.
            let own = column as i32 + extent.x.index;
            let last = window.near.width() as i32 - 1;
            let at_end = [column == extent.columns.start, column + 1 == extent.columns.end];
            let is_held = at_end.into_iter().zip(extent.held).any(|(at_end, held)| at_end && held);
            let voxel = if is_held { own.clamp(0, last) } else { own };
            prop_assert!((0..=last).contains(&voxel));
            prop_assert!(extent.is_wide() || own - voxel_of(extent, column) == 0);
            prop_assert!(*whole_rows || extent.columns.len() == 1);
            let [mut wx, wy, wz] = [extent.x, extent.y, extent.z].map(|cell| cell.weight.to_bits() as i32);
            if is_held {
                prop_assert!(own != voxel || wx != 0 && own == last);
                wx = 0;
            }
            let ends = at_end.into_iter().zip(extent.ends);
            let fraction = ends.filter_map(|(at_end, end)| end.filter(|_| at_end)).next();
            let fraction = fraction.unwrap_or(extent.part).length();
            let cells = [extent.y.index + row as i32, extent.z.index, wx, wy, wz];
            let voxel = whole_rows.then_some(voxel as usize);
            prop_assert_eq!(found.insert([column as u32, row], (fraction, cells, voxel)), None);
        }
        Ok(())
    }

    /// The voxel under a column, counted from that under the first.
    fn voxel_of(extent: &Extent, column: usize) -> i32 {
        ((column - extent.columns.start) + extent.voxel) as i32
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
            let own = [held(x, u, width), held(y, v, height), held(z, 0, depth)];
            // Nothing but the volume's own faces holds a sample, and gradients look at voxels that are held too.
            let axes = own.into_iter().zip([
                x.to_bits() + ((u as i32) << 16),
                y.to_bits() + ((v as i32) << 16),
                z.to_bits(),
            ]);
            let sides = plan.dims().into_iter().zip(plan.first()).zip(plan.volume());
            for ((at, free), ((held, first), all)) in axes.zip(sides) {
                let (cell, last) = (at >> 16, (at + 0xffff) >> 16);
                prop_assert!(first == 0 || cell >= 1);
                prop_assert!(first + held == all || last <= held as i32 - 2);
                prop_assert!(at == free || first == 0 && at == 0 || first + held == all && at >> 16 == held as i32 - 1);
            }
            let [x, y, z] = own;
            prop_assert_eq!(*cells, [y >> 16, z >> 16, x & 0xffff, y & 0xffff, z & 0xffff]);
            prop_assert!(voxel.is_none_or(|voxel| voxel as i32 == x >> 16));
        }
        Ok(())
    }
}
