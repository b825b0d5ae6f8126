//! Rays of a plan through a box of the same volume at a coarser level, whose voxels are 2^m as long.
//!
//! Source: LaMar, adaptive border sampling, bricks of several resolutions; `docs/contract/levels.md` has the formula and the
//! proof. The level is a volume with a plan of its own, cropped to the box; what it takes from the finest plan are the rays: every
//! 2^m-th one of a phase, because those lie a whole voxel of the level apart and share all weights.
//!
//! | value | format | unit |
//! |---|---|---|
//! | start of a level's ray | s27.36 | voxels of the level |
//!
//! Rounding: none. Overflow: none. State: none.

use super::{Phase, Plan};
use crate::borders::Borders;
use crate::crop::Faces;

/// The coarsest level: voxels 2^3 as long as those of the finest, along each axis.
pub const LEVEL_MAX: u32 = 3;

/// Some rays of one phase of a plan, for a level m: every 2^m-th column and row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rays {
    /// The phase.
    pub phase: Phase,
    /// Its first column and row that count.
    pub first: [u32; 2],
    /// How many columns and rows.
    pub count: [u32; 2],
}

/// Why a plan does not take the rays of another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum LevelError {
    /// A level above [`LEVEL_MAX`].
    Level {
        /// The level given.
        given: u32,
    },
    /// Borders other than [`Borders::Cells`]: half a voxel of a level is not half a voxel of another.
    Borders,
    /// Another view, other planes per voxel, or a volume that has not 2^-m times the voxels along each axis, rounded up.
    Other,
    /// No rays, or rays that the plan does not have.
    Rays {
        /// Columns and rows of a phase of the plan.
        base: [u32; 2],
    },
}

impl core::fmt::Display for LevelError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Level { given } => write!(f, "level {given}; accepted: 0 to {LEVEL_MAX}"),
            Self::Borders => f.write_str("levels without borders of cells; accepted: cells"),
            Self::Other => f.write_str("a plan that is not of a level of the same volume, seen alike"),
            Self::Rays { base: [columns, rows] } => {
                write!(
                    f,
                    "rays that a plan of {columns} x {rows} pixels a phase does not have, or none"
                )
            }
        }
    }
}

impl core::error::Error for LevelError {}

impl Plan {
    /// The plan of a level `m`, cropped perhaps, with rays of the finest level's plan as its pixels, in one phase: pixel (i, j) is
    /// the ray of pixel `first + 2^m (i, j)` there. Planes, voxels held and the box stay. Rays that run along a high face which lies within
    /// the finest plan's box are left to the box behind it, so that boxes side by side count each ray once.
    ///
    /// # Errors
    /// [`LevelError`]; see there.
    pub const fn of_rays(mut self, finest: &Self, level: u32, rays: Rays) -> Result<Self, LevelError> {
        if level > LEVEL_MAX {
            return Err(LevelError::Level { given: level });
        }
        if !matches!((self.borders(), finest.borders()), (Borders::Cells, Borders::Cells)) {
            return Err(LevelError::Borders);
        }
        let beside = self.excess(finest, level);
        let Some([_, _, beyond]) = beside else {
            return Err(LevelError::Other);
        };
        let ([columns, rows], [i, j], [across, down]) = (finest.base, rays.first, rays.count);
        if !reaches(i, across, level, columns) || !reaches(j, down, level, rows) {
            return Err(LevelError::Rays { base: finest.base });
        }
        // Voxels of the finest level that the first slices reach before its own.
        let before = if self.view.reversed() { beyond } else { 0 };
        let [start_i, start_j] = finest.start(rays.phase);
        let [si, sj, _] = self.step;
        let rate = self.sampling.planes_per_voxel as i64;
        let i = start(start_i.to_bits(), i, si.to_bits() * rate, level, before);
        let j = start(start_j.to_bits(), j, sj.to_bits() * rate, level, before);
        self.origin = [(i >> 36) as i32, (j >> 36) as i32];
        self.offset = [i & 0xf_ffff_ffff, j & 0xf_ffff_ffff];
        self.base = rays.count;
        self.sampling.rays_per_voxel = 1;
        let ([a, b, c], [x, y, _]) = (self.faces, finest.faces);
        self.faces = [a.beside(x, level), b.beside(y, level), c];
        Ok(self)
    }

    /// By how many voxels of the finest level this one is longer, along each axis; `None` if it is no such level.
    const fn excess(&self, finest: &Self, level: u32) -> Option<[i64; 3]> {
        let ([a, b, c], [x, y, z]) = (self.volume, finest.volume);
        let excess = [
            ((a as i64) << level) - x as i64,
            ((b as i64) << level) - y as i64,
            ((c as i64) << level) - z as i64,
        ];
        let [x, y, z] = excess;
        let least = if x < y { x } else { y };
        let least = if least < z { least } else { z };
        let most = if x > y { x } else { y };
        let most = if most > z { most } else { z };
        let ([si, sj, sk], [ti, tj, tk]) = (self.step, finest.step);
        let steps = si.to_bits() == ti.to_bits() && sj.to_bits() == tj.to_bits() && sk.to_bits() == tk.to_bits();
        let [held_i, held_j] = finest.offset;
        let alike = steps
            && self.view.major() as u8 == finest.view.major() as u8
            && self.view.reversed() == finest.view.reversed()
            && self.nearest == finest.nearest
            && held_i == 0
            && held_j == 0;
        if alike && least >= 0 && most < 1 << level {
            Some(excess)
        } else {
            None
        }
    }
}

impl Faces {
    /// The same faces of a level, open where the volume goes on behind them.
    const fn beside(self, finest: Self, level: u32) -> Self {
        let high = ((self.high.to_bits() as i64 + (1 << 15)) << level) - (1 << 15);
        Self {
            open: high < finest.high.to_bits() as i64,
            ..self
        }
    }
}

/// Whether so many pixels, 2^level apart, are some and end within a side.
const fn reaches(first: u32, count: u32, level: u32, side: u32) -> bool {
    count > 0 && first as u64 + (((count - 1) as u64) << level) < side as u64
}

/// Where the ray of a pixel meets the first slice of a level, 2^-36 of its voxels: from the phase's start on the finest first slice, and
/// the way of a voxel along k, both in 2^-32 voxel.
const fn start(phase: i64, pixel: u32, way: i64, level: u32, before: i64) -> i64 {
    let longer = (1 << level) - 1;
    let doubled = 2 * (phase + ((pixel as i64) << 32)) + (longer - 2 * before) * way - (longer << 32);
    doubled << (LEVEL_MAX - level)
}

#[cfg(test)]
mod tests;
