//! Table 1: what exact borders cost, by the volume's side.

use std::time::Duration;

use serde::Serialize;
use slicecast_bench::scenes::{Fog, cube, fog};
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::Prepared;
use slicecast_engine::oriented::{Oriented, Turned};
use slicecast_scene::{Sampling, Scene};

use super::rays::ALL;
use crate::clock::{one_thread, worked};

/// Sides, and rays per voxel: from 64 voxels on the base plane has about 512² pixels, as the paper's picture.
const VOLUMES: [(usize, u32); 4] = [(32, 8), (64, 8), (128, 4), (256, 2)];
/// Planes per voxel, as in the paper.
const PLANES: u32 = 2;
/// Times that every frame is rendered, each time after all others.
const ROUNDS: usize = 15;
/// Rows of a tile.
const TILE: usize = 32;

/// A line of the table.
#[derive(Clone, Debug, Serialize)]
pub struct Line {
    /// Voxels along a side.
    pub side: usize,
    /// Columns and rows of the base plane of cells.
    pub pixels: [u32; 2],
    /// Milliseconds of one processor for whole, cells and nodes.
    pub milliseconds: [f64; 3],
}

impl Line {
    /// Share of the frames per second that is lost against whole borders: by cells, which are a voxel larger, and by nodes, whose
    /// box is the same.
    pub fn drops(&self) -> [f64; 2] {
        let [whole, cells, nodes] = self.milliseconds;
        [cells, nodes].map(|exact| 1.0 - whole / exact)
    }
}

/// Dense unlit fog of `compact`, in which nothing can be skipped; `reduced` for tests.
///
/// # Errors
/// [`RenderError`] if a scene cannot be rendered.
pub fn lines(reduced: bool, progress: &(dyn Fn(usize, usize) + Sync)) -> Result<Vec<Line>, RenderError> {
    let (volumes, rounds) = if reduced {
        (&VOLUMES[..1], 1)
    } else {
        (&VOLUMES[..], ROUNDS)
    };
    let line = |(n, volume): (usize, &(usize, u32))| {
        progress(n, volumes.len());
        line(*volume, rounds)
    };
    volumes.iter().enumerate().map(line).collect()
}

fn line((side, rays): (usize, u32), rounds: usize) -> Result<Line, RenderError> {
    let volume = cube(side);
    let plain = fog(
        &volume,
        Fog {
            lights: 0,
            colourful: false,
        },
    );
    let scenes = ALL.map(|(_, borders)| Scene {
        borders,
        sampling: Sampling {
            planes_per_voxel: PLANES,
            rays_per_voxel: rays,
        },
        ..plain.clone()
    });
    let frames = (scenes.iter())
        .map(|scene| Prepared::new(scene, &volume))
        .collect::<Result<Vec<_>, _>>()?;
    let mut turned = Turned::new(&volume, &frames[0].setup.plan);
    let slices = turned.slices()?;
    let oriented = Oriented::of(&slices);
    let mut least = [Duration::MAX; 3];
    for _ in 0..rounds {
        for (prepared, least) in frames.iter().zip(&mut least) {
            let mut rendering = prepared.begun()?;
            let took = one_thread(|| {
                let begin = worked();
                rendering.fold(&oriented, TILE, prepared.simd, &|_, _| ());
                worked().saturating_sub(begin)
            });
            *least = took.min(*least);
        }
    }
    let [_, cells, _] = &frames[..] else {
        unreachable!("three borders")
    };
    Ok(Line {
        side,
        pixels: cells.setup.plan.base().map(|pixels| pixels * rays),
        milliseconds: least.map(|time| time.as_secs_f64() * 1e3),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_three_times() {
        let lines = lines(true, &|_, _| ()).unwrap();
        assert_eq!((lines.len(), lines[0].side), (1, 32));
        assert!(lines[0].milliseconds.iter().all(|time| *time > 0.0));
        assert!(lines[0].drops().iter().all(|drop| *drop < 1.0));
    }
}
