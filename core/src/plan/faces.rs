//! The box of a plan of exact borders, of the whole volume or cropped: base plane, planes and voxels that it needs.
//!
//! `docs/contract/crop.md` has the formulas and ranges.

use core::ops::Range;

use super::{Plan, PlanError, Sampling};
use crate::borders::Borders;
use crate::crop::{Crop, Faces};
use crate::format::{Position, Step};
use crate::view::ratio;

impl Plan {
    /// The same plan of what lies in a box too. Planes, positions and weights of what is left are those of the whole volume's
    /// plan. What is smaller: the base plane, which is as large as the box's shadow, the voxels held ([`Plan::dims`]), and the
    /// planes that are folded.
    ///
    /// # Errors
    /// [`PlanError::Reversed`], [`PlanError::Beside`], and [`PlanError::WholeCropped`] for a plan of whole borders.
    pub const fn with_crop(mut self, crop: Crop) -> Result<Self, PlanError> {
        if matches!(self.borders(), Borders::Whole) {
            return Err(PlanError::WholeCropped);
        }
        let ([lx, ly, lz], [hx, hy, hz]) = (crop.low, crop.high);
        if let Some(axis) = first_true([
            lx.to_bits() >= hx.to_bits(),
            ly.to_bits() >= hy.to_bits(),
            lz.to_bits() >= hz.to_bits(),
        ]) {
            return Err(PlanError::Reversed { axis });
        }
        let [i, j, mut k] = self.view.arrange([[lx, hx], [ly, hy], [lz, hz]]);
        let ([a, b, c], [width, height, depth]) = (self.faces, self.volume);
        if self.view.reversed() {
            k = Faces::reversed(k, depth);
        }
        let [a, b, c] = [a.and(i), b.and(j), c.and(k)];
        if let Some(axis) = first_true(self.view.restore([a.is_empty(), b.is_empty(), c.is_empty()])) {
            return Err(PlanError::Beside { axis });
        }
        let (held_i, held_j, held_k) = (a.held(width), b.held(height), c.held(depth));
        self.faces = [a, b, c];
        self.first = [held_i.0, held_j.0, held_k.0];
        self.dims = [held_i.1, held_j.1, held_k.1];
        self.reach();
        Ok(self)
    }

    /// Sets the base plane of exact borders: the fewest whole voxels that hold all rays that meet the box.
    pub(super) const fn reach(&mut self) {
        let ([i, j, k], [si, sj, _]) = (self.faces, self.step);
        let (columns, origin_i) = reach(si, i, k, self.sampling);
        let (rows, origin_j) = reach(sj, j, k, self.sampling);
        self.base = [columns, rows];
        self.origin = [origin_i, origin_j];
    }

    /// The faces of the box along i, j, k.
    pub(crate) const fn faces(&self) -> [Faces; 3] {
        self.faces
    }

    /// The box along i, j and k, low and high face, voxels of the whole volume: what counts of it ends there.
    pub const fn box_of_volume(&self) -> [[Position; 2]; 3] {
        let [i, j, k] = self.faces;
        [[i.low, i.high], [j.low, j.high], [k.low, k.high]]
    }

    /// The sample planes whose segments meet the box.
    pub const fn planes_met(&self) -> Range<u32> {
        match self.borders() {
            Borders::Whole => 0..self.planes(),
            Borders::Cells => self.segments_met(self.sampling.planes_per_voxel),
            Borders::Nodes => self.segments_met(0),
        }
    }

    /// The planes at which segments between samples end that meet the box, the front end of the first included.
    pub const fn ends_met(&self) -> Range<u32> {
        match self.borders() {
            Borders::Whole => 0..self.ends(),
            Borders::Cells | Borders::Nodes => {
                let Range { start, end } = self.segments_met(2 * self.ends_before());
                start..end + 1
            }
        }
    }

    /// The numbers of the segments that meet the box along k, the first of which begins so many half segments before the first
    /// slice.
    const fn segments_met(&self, halves_before: u32) -> Range<u32> {
        let [_, _, Faces { low, high, .. }] = self.faces;
        let rate = self.sampling.planes_per_voxel as i64;
        let before = (halves_before as i64) << 15;
        let (first, end) = (
            rate * low.to_bits() as i64 + before,
            rate * high.to_bits() as i64 + before,
        );
        (first >> 16) as u32..-(-end >> 16) as u32
    }
}

/// The first of some that is true.
const fn first_true([a, b, c]: [bool; 3]) -> Option<u32> {
    if a {
        Some(0)
    } else if b {
        Some(1)
    } else if c {
        Some(2)
    } else {
        None
    }
}

/// Pixels of the base plane along a side of a box, and where the first of them starts.
const fn reach(step: Step, side: Faces, along_k: Faces, sampling: Sampling) -> (u32, i32) {
    // In units of 2^-48 voxel: how far a ray has moved where it enters by the front face, and leaves by the back face.
    let shear = step.to_bits() * sampling.planes_per_voxel as i64;
    let (front, back) = (
        along_k.low.to_bits() as i64 * shear,
        along_k.high.to_bits() as i64 * shear,
    );
    let (up, down) = if front < back { (back, front) } else { (front, back) };
    let (low, high) = ((side.low.to_bits() as i64) << 32, (side.high.to_bits() as i64) << 32);
    // The last phase of the first pixel, and the first of the last one, meet the box.
    let rays = sampling.rays_per_voxel;
    let last_phase = (ratio(rays as u64 - 1, 1, rays) as i64) << 16;
    let first = -((up + last_phase - low) >> 48);
    let last = (high - down) >> 48;
    // A box thinner than the distance of rays may lie between two of them.
    let columns = if last < first { 1 } else { last - first + 1 };
    (columns as u32, first as i32)
}
