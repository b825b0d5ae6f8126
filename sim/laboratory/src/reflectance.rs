//! Reflectance maps by their size: how far their light is from Phong's, and what they cost beside it.

use std::time::Instant;

use serde::Serialize;
use slicecast_compare::image::{ImageFigures, base_figures};
use slicecast_compare::{ModelPositions, model};
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::Prepared;
use slicecast_engine::image::BaseImage;
use slicecast_engine::oriented::Turned;
use slicecast_engine::progress::Progress;
use slicecast_engine::simd::Simd;
use slicecast_engine::tile::TILE_ROWS;
use slicecast_scene::Scene;
use slicecast_scene::reflectance::{Filter, Reflectance};
use slicecast_volume::Volume;

use crate::clock::one_thread;

/// Nodes along an edge.
const SIDES: [u32; 5] = [8, 16, 32, 64, 128];

/// A map, or none.
#[derive(Clone, Debug, Serialize)]
pub struct Line {
    /// Nodes along an edge; `None` computes light.
    pub side: Option<u32>,
    /// Whether it is read bilinear.
    pub bilinear: bool,
    /// Bytes of the map.
    pub bytes: usize,
    /// Error of the base plane against f64, which computes light.
    pub image: ImageFigures,
    /// Milliseconds that making the map takes.
    pub made: f64,
    /// Time of a frame's base plane, in the scene's vectors and by one lane, in that without a map: above 1 the map is quicker.
    pub speed: [f64; 2],
}

/// One configuration under way.
struct Way<'a> {
    map: Option<Reflectance>,
    prepared: Prepared<'a>,
    /// The quickest frame with each of the vectors, seconds.
    best: [f64; 2],
}

/// A lit scene by maps of every size, and without one, in turns; frames take one thread.
///
/// # Errors
/// [`RenderError`] if the scene cannot be rendered.
pub fn lines(scene: &Scene, volume: &Volume, rounds: u32, progress: Progress<'_>) -> Result<Vec<Line>, RenderError> {
    let filters = [Filter::Nearest, Filter::Bilinear];
    let maps = SIDES
        .into_iter()
        .flat_map(|side| filters.map(|filter| Reflectance { side, filter }));
    let scenes: Vec<Scene> = std::iter::once(None)
        .chain(maps.map(Some))
        .map(|reflectance| Scene {
            reflectance,
            ..scene.clone()
        })
        .collect();
    let mut ways = Vec::new();
    for scene in &scenes {
        ways.push(Way {
            map: scene.reflectance,
            prepared: Prepared::new(scene, volume)?,
            best: [f64::INFINITY; 2],
        });
    }
    let steps = rounds as usize + 1;
    for round in 0..rounds {
        progress(round as usize, steps);
        for way in &mut ways {
            for (best, simd) in way.best.iter_mut().zip([Simd::widest(), Simd::Scalar]) {
                let (time, _) = frame(&way.prepared, simd)?;
                *best = best.min(time);
            }
        }
    }
    progress(steps - 1, steps);
    let exact = match ways.first() {
        Some(way) => model(&way.prepared, ModelPositions::Pipeline).render(),
        None => return Ok(Vec::new()),
    };
    let alone = ways.first().map_or([1.0; 2], |way| way.best);
    let mut lines = Vec::new();
    for Way { map, prepared, best } in ways {
        let begin = Instant::now();
        drop(prepared.rendering()?);
        let made = begin.elapsed().as_secs_f64() * 1e3;
        let (_, base) = frame(&prepared, Simd::widest())?;
        lines.push(Line {
            side: map.map(|map| map.side),
            bilinear: map.is_some_and(|map| map.filter == Filter::Bilinear),
            bytes: map.map_or(0, |map| bytes(scene, map.side)),
            image: base_figures(&base, &exact),
            made,
            speed: [0, 1].map(|lanes| alone[lanes] / best[lanes]),
        });
    }
    progress(steps, steps);
    Ok(lines)
}

/// Bytes of a map: one channel where lights are grey, else three.
fn bytes(scene: &Scene, side: u32) -> usize {
    let grey = |light: &slicecast_scene::Light| light.colour.iter().all(|c| *c == light.colour[0]);
    let channels = match &scene.lighting {
        Some(lighting) if !lighting.lights.iter().all(grey) => 3,
        _ => 1,
    };
    4 * channels * (1 + 6 * (side * side) as usize)
}

/// The time of a frame's base plane on one thread, seconds, and the plane.
fn frame(prepared: &Prepared<'_>, simd: Simd) -> Result<(f64, BaseImage), RenderError> {
    let mut turned = Turned::new(prepared.volume, &prepared.setup.plan);
    let slices = turned.slices()?;
    let mut rendering = prepared.begun()?;
    let time = one_thread(|| {
        let begin = crate::clock::worked();
        rendering.fold_rows(&slices, TILE_ROWS, simd, &|_, _| ());
        (crate::clock::worked() - begin).as_secs_f64()
    });
    Ok((time, rendering.base()))
}
