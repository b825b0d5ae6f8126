//! The extent of a sample plane: which pixels have a sample in it, and which rows of them can be visible.
//!
//! A plane of exact borders has up to nine parts ([`Parts`]): the pixels whose segments lie in the volume as a whole, and at
//! each end a row and a column of those whose segments do not, or whose samples are held to the voxels. All pixels of a part
//! share cells and fraction, so each is folded like a plane of its own. Crop boxes change this file.

use core::ops::Range;

use crate::borders::{Borders, Part, Side, WHOLE};
use crate::format::{Step, Weight};
use crate::locate::{Cell, Plane, cell, inside};
use crate::plan::Plan;
use crate::slice::{Code12, RowRange, Slice, Voxel, Window};

/// The cells of a plane, and the pixels whose samples lie inside the volume.
pub(super) struct Extent {
    pub(super) x: Cell,
    pub(super) y: Cell,
    pub(super) z: Cell,
    pub(super) columns: Range<usize>,
    pub(super) rows: Range<u32>,
    /// Column of the volume under the first of `columns`.
    pub(super) voxel: usize,
    pub(super) height: i32,
    /// What of the pixels' segments lies in the volume, 0.16.
    pub(super) fraction: u32,
}

impl Extent {
    pub(super) fn of(plan: &Plan, plane: &Plane) -> Self {
        let [width, height, _] = plan.dims();
        let [base_width, base_height] = plan.base();
        let (x, y, z) = (cell(plane.x), cell(plane.y), cell(plane.z));
        let columns = inside(x, width, base_width);
        Self {
            x,
            y,
            z,
            voxel: (i64::from(columns.start) + i64::from(x.index)).max(0) as usize,
            columns: columns.start as usize..columns.end as usize,
            rows: inside(y, height, base_height),
            height: height as i32,
            fraction: WHOLE,
        }
    }

    /// The extents of two neighbouring planes where both have samples: what slabs between them there are.
    pub(super) fn of_slab(plan: &Plan, [front, back]: [&Plane; 2]) -> [Self; 2] {
        let mut extents = [Self::of(plan, front), Self::of(plan, back)];
        let [front, back] = &extents;
        let start = front.columns.start.max(back.columns.start);
        let columns = start..front.columns.end.min(back.columns.end).max(start);
        let start = front.rows.start.max(back.rows.start);
        let rows = start..front.rows.end.min(back.rows.end).max(start);
        for extent in &mut extents {
            (extent.columns, extent.rows) = (columns.clone(), rows.clone());
            extent.voxel = (columns.start as i64 + i64::from(extent.x.index)).max(0) as usize;
        }
        extents
    }

    /// Whether the plane lies in a slice.
    pub(super) fn in_slice(&self) -> bool {
        self.z.weight == Weight::ZERO
    }

    /// The weights along x and y.
    pub(super) fn weights(&self) -> [Weight; 2] {
        [self.x.weight, self.y.weight]
    }

    /// The voxel row before the samples of a row of the image.
    pub(super) fn voxel_row(&self, row: u32) -> i32 {
        (row as i32).wrapping_add(self.y.index)
    }

    /// The voxel rows around the samples behind a voxel row: that row and the next, which is the last one itself behind it.
    pub(super) fn voxel_rows(&self, row: i32) -> (usize, usize) {
        let last = self.height - 1;
        // Not `clamp`, which may panic.
        (row.min(last).max(0) as usize, (row + 1).min(last).max(0) as usize)
    }

    /// Rows of the image that the plane meets, among `count` from `first` on.
    pub(super) fn met(&self, first: u32, count: usize) -> Range<u32> {
        let end = first.saturating_add(u32::try_from(count).unwrap_or(u32::MAX));
        let start = self.rows.start.max(first);
        start..self.rows.end.min(end).max(start)
    }
}

/// The range of the voxels around the samples between voxel rows.
pub(super) fn around<X: Voxel>(window: &Window<'_, X>, (row, next): (usize, usize)) -> RowRange {
    let far = window.far_or_near();
    let range = |s: &Slice<'_, X>| s.range(row).union(s.range(next));
    range(&window.near).union(range(&far))
}

/// Pixels of a plane, along one side, of the same cell and the same part of their segments.
#[derive(Clone)]
struct Band {
    pixels: Range<u32>,
    cell: Cell,
    part: Part,
}

impl Band {
    /// One pixel at a border, or none, its sample held to the voxels.
    fn edge(pixels: Range<u32>, at: Cell, voxels: u32, side: Side) -> Self {
        let (first, last) = (pixels.start as i32, voxels as i32 - 1);
        let voxel = at.index.wrapping_add(first);
        let held = voxel.min(last).max(0);
        let weight = if held == voxel && held < last {
            at.weight
        } else {
            Weight::ZERO
        };
        Self {
            part: side.part(pixels.start),
            pixels,
            cell: Cell {
                index: held.wrapping_sub(first),
                weight,
            },
        }
    }
}

/// The bands of a plane along i (axis 0) or j (axis 1): before, between and behind the faces.
fn bands(plan: &Plan, index: u32, (axis, start): (usize, Step), at: Cell, (voxels, pixels): (u32, u32)) -> [Band; 3] {
    let inside = inside(at, voxels, pixels);
    let band = |pixels, part| Band { pixels, cell: at, part };
    if plan.borders() == Borders::Whole {
        return [
            band(0..0, Part::NONE),
            band(inside, Part::WHOLE),
            band(0..0, Part::NONE),
        ];
    }
    let side = Side::of(plan, start, axis, index);
    let (touched, whole) = (side.touched(pixels), side.whole(pixels));
    let first = whole.start.max(inside.start);
    let mut inner = first..whole.end.min(inside.end);
    if inner.is_empty() {
        // Two pixels at most, each at a border.
        let split = (touched.start + 1).min(touched.end);
        inner = split..split;
    }
    [
        Band::edge(touched.start..inner.start, at, voxels, side),
        band(inner.clone(), Part::WHOLE),
        Band::edge(inner.end..touched.end, at, voxels, side),
    ]
}

/// The parts of a plane, each with its own extent and window. Of whole borders there is one.
pub(super) struct Parts<'w, X = Code12> {
    columns: [Band; 3],
    rows: [Band; 3],
    z: Cell,
    dims: [u32; 2],
    window: Window<'w, X>,
    /// Numbers of the next part's bands.
    next: [usize; 2],
}

impl<'w, X: Voxel> Parts<'w, X> {
    pub(super) fn of(plan: &Plan, plane: &Plane, window: &Window<'w, X>) -> Self {
        let ([width, height, _], [columns, rows]) = (plan.dims(), plan.base());
        let [start_i, start_j] = plan.start(plane.phase);
        let index = plane.index;
        Self {
            columns: bands(plan, index, (0, start_i), cell(plane.x), (width, columns)),
            rows: bands(plan, index, (1, start_j), cell(plane.y), (height, rows)),
            z: cell(plane.z),
            dims: [width, height],
            window: *window,
            next: [0; 2],
        }
    }

    /// The part of two bands. The window of a column holds what its gradients look at, and so costs no whole rows.
    fn part(&self, columns: &Band, rows: &Band, column: bool) -> (Extent, Window<'w, X>) {
        let [width, height] = self.dims.map(|side| side as usize);
        let (mut x, mut window) = (columns.cell, self.window);
        let pixels = columns.pixels.start as usize..columns.pixels.end as usize;
        let mut voxel = (i64::from(columns.pixels.start) + i64::from(x.index)).max(0) as usize;
        if column {
            let kept = voxel.saturating_sub(1)..(voxel + 3).min(width);
            (x.index, voxel) = (x.index.wrapping_sub(kept.start as i32), voxel - kept.start);
            window = window.columns(kept);
        }
        let extent = Extent {
            x,
            y: rows.cell,
            z: self.z,
            columns: pixels,
            rows: rows.pixels.clone(),
            voxel,
            height: height as i32,
            fraction: columns.part.fraction(rows.part),
        };
        (extent, window)
    }
}

impl<'w, X: Voxel> Iterator for Parts<'w, X> {
    /// A part and its window, and whether that is the plane's, of whole rows.
    type Item = (Extent, Window<'w, X>, bool);

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let [column, row] = self.next;
            let (columns, rows) = (self.columns.get(column), self.rows.get(row)?);
            let Some(columns) = columns.filter(|_| !rows.pixels.is_empty()) else {
                self.next = [0, row + 1];
                continue;
            };
            self.next = [column + 1, row];
            if columns.pixels.is_empty() {
                continue;
            }
            let edge = column != 1;
            let (extent, window) = self.part(columns, rows, edge);
            if extent.fraction > 0 {
                return Some((extent, window, !edge));
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
    use crate::view::View;
    use proptest::prelude::*;
    use std::collections::BTreeMap;
    use std::vec;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 400, rng_seed: proptest::test_runner::RngSeed::Fixed(4), ..ProptestConfig::default() })]

        /// Every pixel with a fraction lies in one part, at its own position held to the voxels, and no other pixel does.
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
            let ([width, height, _], [columns, rows]) = (plan.dims(), plan.base());
            let voxels = vec![0; (width * height) as usize];
            let mut ranges = vec![RowRange::EMPTY; height as usize];
            let near = Slice::measure(&voxels, width as usize, height as usize, width as usize, &mut ranges).unwrap();
            let window = Window { before: None, near, far: None, after: None };
            for (number, index) in (0..plan.phases()).flat_map(|p| (0..plan.planes()).map(move |k| (p, k))) {
                let at = plane(&plan, plan.phase(number), index);
                let mut found = BTreeMap::new();
                for (extent, window, whole_rows) in Parts::of(&plan, &at, &window) {
                    for (row, column) in extent.rows.clone().flat_map(|v| extent.columns.clone().map(move |u| (v, u))) {
                        // Columns of a window that is narrower are counted from its first voxel.
                        let first = (column - extent.columns.start) + extent.voxel;
                        prop_assert_eq!(first as i32, column as i32 + extent.x.index);
                        prop_assert!(whole_rows || extent.columns.len() == 1);
                        prop_assert!(first < window.near.width());
                        let cell = [extent.y.index + row as i32, extent.y.weight.to_bits() as i32, extent.x.weight.to_bits() as i32];
                        let voxel = whole_rows.then_some(first);
                        prop_assert_eq!(found.insert((column as u32, row), (extent.fraction, cell, voxel)), None);
                    }
                }
                let [start_i, start_j] = plan.start(at.phase);
                let (x, y) = (Side::of(&plan, start_i, 0, index), Side::of(&plan, start_j, 1, index));
                for (u, v) in (0..columns).flat_map(|u| (0..rows).map(move |v| (u, v))) {
                    let fraction = x.part(u).fraction(y.part(v));
                    let held = |bits: i32, pixel: u32, side: u32| (bits + ((pixel as i32) << 16)).clamp(0, (side as i32 - 1) << 16);
                    let (px, py) = (held(at.x.to_bits(), u, width), held(at.y.to_bits(), v, height));
                    let Some((found, cell, voxel)) = found.get(&(u, v)) else {
                        prop_assert_eq!(fraction, 0, "pixel {} {} is in no part", u, v);
                        continue;
                    };
                    prop_assert_eq!(*found, fraction);
                    prop_assert_eq!(*cell, [py >> 16, py & 0xffff, px & 0xffff]);
                    prop_assert!(voxel.is_none_or(|voxel| voxel as i32 == px >> 16));
                }
            }
        }
    }
}
