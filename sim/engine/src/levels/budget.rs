//! Levels by a budget: the voxels that the picture loses least by are the first to become longer.
//!
//! A volume is a grid of bricks of [`SIDE`] voxels. The *loss* of a brick at a level is how much the transfer function makes of it: over all
//! its voxels, the sum of the largest difference of opacity, or of a colour times opacity (over the unit distance), between the voxel and the mean that stands for it.
//! What the table hides loses nothing, nor does what has one value. Its *work* at a level is the samples that meet what the table shows: each visible voxel
//! of level m has 2^m x 2^m of the finest rays. Starting with all bricks at level 0, the one that loses least per
//! byte, or per sample, saved goes one level up, until all of them fit; gradients and what lies in front are not looked at. How long
//! so many samples take is not foretold but measured ([`timed`](super::timed)).

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::fmt;

use rayon::prelude::*;
use slicecast::plan::LEVEL_MAX;
use slicecast_pyramid::scalar::halved;
use slicecast_scene::TransferFunction;
use slicecast_volume::{Mapping, Volume};

use super::tree::Tree;
use crate::error::LevelsError;
use crate::error::RenderError;
use crate::frame::Prepared;
use crate::parts::PROGRAM;
use crate::progress::Progress;
use crate::source::SIDE;
use crate::source::Source;

/// Levels that there are.
const LEVELS: usize = LEVEL_MAX as usize + 1;

/// The levels of a volume's bricks, chosen.
#[derive(Clone, Debug)]
pub struct Chosen {
    /// The boxes.
    pub tree: Tree,
    /// Bricks of each level.
    pub bricks: [usize; LEVELS],
    /// Boxes, after bricks of one level that make a box have become one.
    pub boxes: usize,
    /// Bytes of their voxels.
    pub bytes: u64,
    /// Bytes of all that a picture takes.
    pub all: u64,
    /// Visible samples of one ray and one plane per voxel.
    pub work: f64,
    /// Mean loss of a voxel, in steps of 1/255.
    pub loss: f64,
}

/// What levels are chosen by.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    /// Bytes of all that a picture takes.
    pub memory: Option<u64>,
    /// Visible samples, as of [`Chosen::work`].
    pub work: Option<f64>,
}

impl fmt::Display for Chosen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [finest, two, four, eight] = self.bricks;
        let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
        write!(
            f,
            "{finest} bricks of {SIDE} voxels at level 0, {two} at level 1, {four} at level 2 and {eight} at level 3, in {} boxes: {:.1} MiB of \
             voxels, {:.1} MiB with all else; {:.3} of 255 lost a voxel",
            self.boxes,
            mib(self.bytes),
            mib(self.all),
            self.loss,
        )
    }
}

/// What a brick loses and costs at a level.
#[derive(Clone, Copy, Debug, Default)]
struct Price {
    loss: f64,
    work: f64,
}

/// Losses and work of every brick at every level, x fastest.
#[derive(Clone, Debug)]
pub struct Losses {
    dims: [usize; 3],
    bricks: Vec<[Price; LEVELS]>,
}

impl Losses {
    /// Measures a volume under a scene's transfer function: reads it once. `progress` is told how many rows of bricks of how many are done.
    ///
    /// # Errors
    /// [`RenderError::Read`] if a file cannot be read any more.
    pub fn of(prepared: &Prepared<'_>, source: &dyn Source, progress: Progress<'_>) -> Result<Self, RenderError> {
        let dims = prepared.volume.dims;
        let looks = looks(&prepared.scene.transfer, &prepared.volume.mapping);
        let [across, down, deep] = dims.map(|side| side.div_ceil(SIDE));
        let mut bricks = Vec::with_capacity(across * down * deep);
        for row in 0..down * deep {
            progress(row, down * deep);
            let at = [0, row % down * SIDE, row / down * SIDE];
            let size = [dims[0], SIDE.min(dims[1] - at[1]), SIDE.min(dims[2] - at[2])];
            let voxels = source.voxels(at, size)?;
            let of_brick = |brick: usize| {
                let first = [brick * SIDE, 0, 0];
                let width = SIDE.min(dims[0] - first[0]);
                let brick = voxels.voxels(first, [width, size[1], size[2]])?;
                Ok::<_, RenderError>(of_levels(&brick, &looks))
            };
            let row: Vec<_> = (0..across).into_par_iter().map(of_brick).collect::<Result<_, _>>()?;
            bricks.extend(row);
        }
        Ok(Self { dims, bricks })
    }

    /// The order in which bricks go one level up, by what each loses per unit of what it saves: samples or bytes.
    fn order(&self, by_work: bool) -> Vec<usize> {
        let mut levels = vec![0; self.bricks.len()];
        let cost = |brick: usize, level: usize| {
            if by_work {
                self.bricks[brick][level].work
            } else {
                (SIDE >> level).pow(3) as f64
            }
        };
        // Losses are sums of numbers from 0 to 1, and costs are not below 0: their bits are in order.
        let price = |brick: usize, level: usize| {
            let [now, next] = [self.bricks[brick][level].loss, self.bricks[brick][level + 1].loss];
            let saved = (cost(brick, level) - cost(brick, level + 1)).max(f64::MIN_POSITIVE);
            ((next - now).max(0.0) / saved).to_bits()
        };
        let mut heap: BinaryHeap<_> = (0..levels.len())
            .map(|brick| Reverse((price(brick, 0), brick)))
            .collect();
        let mut order = Vec::new();
        while let Some(Reverse((_, brick))) = heap.pop() {
            order.push(brick);
            levels[brick] += 1;
            if levels[brick] < LEVELS - 1 {
                heap.push(Reverse((price(brick, levels[brick]), brick)));
            }
        }
        order
    }

    /// The tree after so many bricks have gone one level up.
    fn after(&self, steps: &[usize]) -> (Tree, Vec<usize>) {
        let mut levels = vec![0; self.bricks.len()];
        steps.iter().for_each(|brick| levels[*brick] += 1);
        let [across, down, _] = self.dims.map(|side| side.div_ceil(SIDE));
        let level = |[i, j, k]: [usize; 3]| levels[(k * down + j) * across + i] as u32;
        (Tree::of_grid(self.dims, SIDE, &level), levels)
    }

    /// The order in which bricks become coarser: by what each loses per sample that it saves where there is a limit of work, else per
    /// byte.
    ///
    /// # Errors
    /// [`RenderError`] if the scene has no pipeline.
    pub fn ordered(
        &self,
        prepared: &Prepared<'_>,
        source: &dyn Source,
        by_work: bool,
    ) -> Result<Ordered<'_>, RenderError> {
        Ok(Ordered {
            losses: self,
            order: self.order(by_work),
            beside: beside(prepared, source)?,
        })
    }

    /// The levels after so many bricks have gone one level up.
    fn chosen(&self, steps: &[usize], beside: u64) -> Result<Chosen, LevelsError> {
        let (tree, levels) = self.after(steps);
        let leaves = tree.leaves(self.dims, [true; 3])?;
        let sizes = leaves
            .iter()
            .map(|leaf| 2 * leaf.held(self.dims).iter().product::<usize>() as u64);
        let (bytes, largest) = sizes.fold((0, 0), |(all, most): (u64, u64), size| (all + size, most.max(size)));
        let mut bricks = [0; LEVELS];
        let mut sum = Price::default();
        for (level, brick) in levels.iter().zip(&self.bricks) {
            bricks[*level] += 1;
            sum.loss += brick[*level].loss;
            sum.work += brick[*level].work;
        }
        Ok(Chosen {
            tree,
            bricks,
            boxes: leaves.len(),
            bytes,
            // A brick as its view reads it, and what is measured of it.
            all: beside + bytes + largest + largest / 4,
            work: sum.work,
            loss: 255.0 * sum.loss / self.dims.iter().product::<usize>().max(1) as f64,
        })
    }
}

/// Losses in the order in which bricks become coarser.
#[derive(Clone, Debug)]
pub struct Ordered<'l> {
    losses: &'l Losses,
    order: Vec<usize>,
    /// Bytes that a picture takes beside the voxels.
    beside: u64,
}

impl Ordered<'_> {
    /// The finest levels whose picture takes no more than some limits, in memory all that the program takes. Where no limit of
    /// work can be kept, the coarsest.
    ///
    /// # Errors
    /// [`LevelsError::Budget`] if not even the coarsest fit in the memory.
    pub fn within(&self, limits: Limits) -> Result<Chosen, LevelsError> {
        let fits = |chosen: &Chosen| {
            limits.memory.is_none_or(|memory| chosen.all <= memory)
                && limits.work.is_none_or(|work| chosen.work <= work)
        };
        let taken = |steps: usize| self.losses.chosen(&self.order[..steps], self.beside);
        let coarsest = taken(self.order.len())?;
        if let Some(memory) = limits.memory.filter(|memory| coarsest.all > *memory) {
            let least = coarsest.all;
            return Err(LevelsError::Budget { memory, least });
        }
        // The first number of steps that fits; more take less, but for what bricks have beside them.
        let (mut over, mut least, mut found) = (None, self.order.len(), coarsest);
        loop {
            let middle = over.map_or(0, |over: usize| usize::midpoint(over, least).max(over + 1));
            if middle >= least {
                return Ok(found);
            }
            let chosen = taken(middle)?;
            if fits(&chosen) {
                (least, found) = (middle, chosen);
            } else {
                over = Some(middle);
            }
        }
    }
}

/// What a picture takes beside the voxels.
fn beside(prepared: &Prepared<'_>, source: &dyn Source) -> Result<u64, RenderError> {
    let plan = &prepared.setup.plan;
    let needs = prepared.rendering()?.needs();
    let image = needs.image as u64 * needs.element_bytes as u64;
    let [across, down] = plan.base().map(u64::from);
    let rays = u64::from(plan.sampling().rays_per_voxel);
    let [width, height] = prepared.setup.picture.size.map(u64::from);
    // Copies of pixels while they are folded; then four channels of 32 bits, the picture in bytes and again as its file is made.
    let out = across * down * rays * rays * 16 + width * height * 16;
    Ok(PROGRAM + image + image.max(out) + source.reading_bytes())
}

/// What the transfer function makes of each code: red, green and blue times opacity, and opacity.
fn looks(transfer: &TransferFunction, mapping: &Mapping) -> Vec<[f32; 4]> {
    let look = |code: u32| {
        let ([red, green, blue], opacity) = transfer.evaluate(mapping.value(f64::from(code)));
        [red * opacity, green * opacity, blue * opacity, opacity].map(|part| part as f32)
    };
    (0..4096).map(look).collect()
}

/// What a brick loses and costs, level after level.
fn of_levels(brick: &Volume, looks: &[[f32; 4]]) -> [Price; LEVELS] {
    let look = |code: u16| looks.get(usize::from(code)).copied().unwrap_or_default();
    let visible = |volume: &Volume| {
        let seen = volume.voxels.iter().filter(|code| {
            let [_, _, _, opacity] = look(**code);
            opacity > 0.0
        });
        seen.count() as f64
    };
    let [nx, ny, _] = brick.dims;
    let mut prices = [Price::default(); LEVELS];
    prices[0].work = visible(brick);
    let mut coarse = halved(brick);
    for (level, price) in prices.iter_mut().enumerate().skip(1) {
        if level > 1 {
            coarse = halved(&coarse);
        }
        price.work = visible(&coarse) * f64::from(1 << (2 * level));
        let [cx, cy, _] = coarse.dims;
        for (at, code) in brick.voxels.iter().enumerate() {
            let [x, y, z] = [at % nx, at / nx % ny, at / nx / ny].map(|place| place >> level);
            let mean = coarse.voxels[(z * cy + y) * cx + x];
            if mean != *code {
                let (exact, found) = (look(*code), look(mean));
                let away = exact.iter().zip(found).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                price.loss += f64::from(away);
            }
        }
    }
    prices
}
