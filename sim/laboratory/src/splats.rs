//! Splatting by the widths of its records: error against f64 and against the integral along rays, and time beside rays.
//!
//! Squeeze, section 4.6.1, gives x and y 13 fraction bits, the depth u 8 and the value v 8. Each part is varied alone: in f64, with
//! all else exact, and through the pipeline, in the record that is nearest to [`Layout::FINE`] otherwise.

use std::hint::black_box;

use serde::Serialize;
use slicecast::splat::Layout;
use slicecast_compare::image::{ImageFigures, base_figures, model_figures, picture_figures};
use slicecast_compare::perspective::compare as compare_in_perspective;
use slicecast_compare::splat::model;
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::image::{BaseImage, Rgb};
use slicecast_engine::perspective::{InPerspective, samples as samples_in_perspective};
use slicecast_engine::progress::Progress;
use slicecast_engine::tile::TILE_ROWS;
use slicecast_model::splat::Rounding;
use slicecast_model::{Affine, Model, ModelImage};
use slicecast_scene::{Classification, Scene};
use slicecast_splat::{BAND_ROWS, Splatted};
use slicecast_volume::Volume;

use crate::clock::{one_thread, worked};
use crate::measure::samples;

/// Planes per voxel and rays per voxel of the f64 samples that stand for the integral in perspective, where it has no exact form.
const IN_PERSPECTIVE: (u32, u32) = (8, 2);

/// Rays per voxel of the integral in a parallel view, so that its own picture is sharp.
const PARALLEL: u32 = 3;

/// Widths that are tried one by one, bits. Those that no record has are tried in f64 alone.
#[derive(Clone, Debug)]
pub struct Widths {
    /// Fraction bits of x and y.
    pub position: Vec<u32>,
    /// Bits of u.
    pub depth: Vec<u32>,
    /// Bits of v.
    pub value: Vec<u32>,
}

/// What a picture is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Way {
    /// Rays.
    Rays,
    /// Records of [`Layout::FINE`].
    Fine,
    /// Squeeze's records.
    Paper,
    /// Records with so many fraction bits of x and y.
    Position(u32),
    /// Records with so many bits of u.
    Depth(u32),
    /// Records with so many bits of v.
    Value(u32),
}

impl Way {
    /// The record, if there is one.
    fn layout(self) -> Option<Layout> {
        let [fine_position, fine_depth, fine_value] = widths(Layout::FINE);
        // What the other parts leave of 64 bits.
        let value = |position: u32, depth: u32| fine_value.min(64u32.saturating_sub(2 * (11 + position) + depth));
        match self {
            Self::Rays => None,
            Self::Fine => Some(Layout::FINE),
            Self::Paper => Some(Layout::PAPER),
            Self::Position(bits) => Layout::new(bits, fine_depth, value(bits, fine_depth)).ok(),
            Self::Depth(bits) => Layout::new(fine_position, bits, value(fine_position, bits)).ok(),
            Self::Value(bits) => Layout::new(fine_position, fine_depth, bits).ok(),
        }
    }

    /// What f64 rounds of it.
    fn rounding(self) -> Option<Rounding> {
        let exact = Rounding::default();
        let all = |layout| {
            let [position, depth, value] = widths(layout).map(Some);
            Rounding { position, depth, value }
        };
        match self {
            Self::Rays => None,
            Self::Fine => Some(all(Layout::FINE)),
            Self::Paper => Some(all(Layout::PAPER)),
            Self::Position(bits) => Some(Rounding {
                position: Some(bits),
                ..exact
            }),
            Self::Depth(bits) => Some(Rounding {
                depth: Some(bits),
                ..exact
            }),
            Self::Value(bits) => Some(Rounding {
                value: Some(bits),
                ..exact
            }),
        }
    }
}

/// Bits of x and y, of u and of v.
fn widths(layout: Layout) -> [u32; 3] {
    [layout.position_bits(), layout.depth_bits(), layout.value_bits()]
}

/// What the pipeline makes of a way.
#[derive(Clone, Debug, Serialize)]
pub struct Made {
    /// Bits of x and y, of u and of v in the record; `None` of rays.
    pub record: Option<[u32; 3]>,
    /// The image against f64 of the same sheets at exact places; `None` of rays, which `compare` measures.
    pub image: Option<ImageFigures>,
    /// The 8-bit picture against the integral along rays.
    pub picture: ImageFigures,
    /// The shortest frame from the voxels to the picture, one thread.
    pub milliseconds: f64,
    /// How many times as long as rays.
    pub against_rays: f64,
    /// Samples of rays, or records.
    pub count: u64,
}

/// A line of the table.
#[derive(Clone, Debug, Serialize)]
pub struct Line {
    /// What the picture is made of.
    pub way: Way,
    /// f64 with records so rounded, against f64 of exact ones; `None` of rays.
    pub rounded: Option<ImageFigures>,
    /// What the pipeline makes of it, if it has such records.
    pub made: Option<Made>,
}

/// A way to a picture, ready to be gone.
enum Ready<'a> {
    Parallel(Box<Prepared<'a>>),
    Perspective(Box<InPerspective<'a>>),
    Splatted(Box<Splatted<'a>>),
}

/// A picture, what it was made of, and how many samples or records that took.
struct Frame {
    picture: Rgb,
    base: BaseImage,
    count: u64,
}

impl<'a> Ready<'a> {
    fn rays(scene: &'a Scene, volume: &'a Volume) -> Result<Self, RenderError> {
        Ok(match &scene.perspective {
            None => Self::Parallel(Box::new(Prepared::new(scene, volume)?)),
            Some(seen) => Self::Perspective(Box::new(InPerspective::new(scene, seen, volume)?)),
        })
    }

    fn frame(&self) -> Result<Frame, RenderError> {
        let layer = Layer::Tiles(TILE_ROWS);
        let (frame, count) = match self {
            Self::Parallel(prepared) => (prepared.render(layer, &|_, _| ())?, samples(&prepared.setup.plan)),
            Self::Perspective(prepared) => {
                let facets = prepared.facets.iter();
                let samples = facets.filter_map(|facet| {
                    let spread = facet.spread()?;
                    Some(samples_in_perspective(&facet.prepared.setup.plan, spread))
                });
                (prepared.render(layer, &|_, _| ())?, samples.sum())
            }
            Self::Splatted(splatted) => {
                let records = splatted.records(true, BAND_ROWS)?;
                let base = splatted.image(&records, &|_, _| ())?;
                (splatted.frame(base), records.count() as u64)
            }
        };
        Ok(Frame {
            picture: frame.picture,
            base: frame.base,
            count,
        })
    }
}

/// The scene by rays and splatted from records of several widths, in samples: pictures of one size. Frames take one
/// thread and turns; `rounds` of each, of which the shortest counts.
///
/// # Errors
/// [`RenderError`] if the scene cannot be rendered or splatted.
pub fn lines(
    scene: &Scene,
    volume: &Volume,
    widths: &Widths,
    rounds: u32,
    progress: Progress<'_>,
) -> Result<Vec<Line>, RenderError> {
    let mut scene = Scene {
        classification: match scene.classification {
            Classification::Auto => Classification::Point,
            stated => stated,
        },
        ..scene.clone()
    };
    // Pictures of the natural size need no enlarging, where it is the same for both.
    if scene.perspective.is_none() {
        let natural = Prepared::new(&scene, volume)?.setup.picture.size;
        if Splatted::new(&scene, volume, Layout::FINE)?.picture.size != natural {
            scene.image.size = Some(natural);
        }
    }
    let scene = &scene;
    let position = widths.position.iter().copied().map(Way::Position);
    let depth = widths.depth.iter().copied().map(Way::Depth);
    let value = widths.value.iter().copied().map(Way::Value);
    let ways = [Way::Rays, Way::Fine, Way::Paper].into_iter();
    let ways: Vec<Way> = ways.chain(position).chain(depth).chain(value).collect();
    let mut ready = vec![(Way::Rays, Ready::rays(scene, volume)?)];
    for (way, layout) in ways.iter().filter_map(|way| Some((*way, way.layout()?))) {
        ready.push((way, Ready::Splatted(Box::new(Splatted::new(scene, volume, layout)?))));
    }
    let steps = 2 + rounds as usize + ways.len();
    let mut done = 0;
    let mut step = || {
        progress(done, steps);
        done += 1;
    };
    step();
    let wanted = converged(scene, volume)?;
    let fine = Splatted::new(scene, volume, Layout::FINE)?;
    let exact = model(scene, volume, &fine, Rounding::default());
    let mut times = vec![f64::INFINITY; ready.len()];
    for _ in 0..rounds {
        step();
        for ((_, ready), best) in ready.iter().zip(&mut times) {
            let time = one_thread(|| {
                let begin = worked();
                black_box(ready.frame()?);
                Ok::<_, RenderError>((worked() - begin).as_secs_f64())
            })?;
            *best = best.min(time);
        }
    }
    let alone = times.first().copied().unwrap_or(1.0);
    let mut lines = Vec::new();
    for way in ways {
        step();
        let rounded = way
            .rounding()
            .map(|rounding| model_figures(&model(scene, volume, &fine, rounding), &exact));
        let mut made = None;
        if let Some(((_, ready), time)) = ready.iter().zip(&times).find(|((own, _), _)| *own == way) {
            let frame = ready.frame()?;
            made = Some(Made {
                record: way.layout().map(self::widths),
                image: way.layout().map(|_| base_figures(&frame.base, &exact)),
                picture: picture_figures(&frame.picture, &wanted, scene.image.background),
                milliseconds: 1e3 * time,
                against_rays: time / alone,
                count: frame.count,
            });
        }
        lines.push(Line { way, rounded, made });
    }
    progress(steps, steps);
    Ok(lines)
}

/// The integral along the rays of the scene's pixels, as a picture: exact in a parallel view, else of fine samples.
fn converged(scene: &Scene, volume: &Volume) -> Result<ModelImage, RenderError> {
    let mut fine = scene.clone();
    if let Some(seen) = &scene.perspective {
        (fine.sampling.planes_per_voxel, fine.sampling.rays_per_voxel) = IN_PERSPECTIVE;
        let prepared = InPerspective::new(&fine, seen, volume)?;
        return Ok(compare_in_perspective(&fine, volume, &prepared, &|_, _| ())?.model_picture);
    }
    fine.image.size = Some(Prepared::new(scene, volume)?.setup.picture.size);
    fine.sampling.rays_per_voxel = PARALLEL;
    let picture = Prepared::new(&fine, volume)?.setup.picture;
    let [origin, right, down] = picture.affine;
    let along = |axis: usize| [origin[axis], right[axis], down[axis]];
    let map = Affine {
        u: along(0),
        v: along(1),
    };
    let integral = Model::natural(&fine, volume).render_integral();
    Ok(integral.warp(picture.size.map(|side| side as usize), map))
}

#[cfg(test)]
mod tests {
    use super::*;
    use slicecast_scene::file::built_in;
    use slicecast_scene::perspective::Perspective;
    use slicecast_volume::mapping::Window;
    use slicecast_volume::open::load;

    /// More bits are nearer to exact places, in f64 and in the pipeline; what no record has is not made.
    #[test]
    fn bits_bring_records_nearer() {
        let volume = load(None, Window::Auto).unwrap().volume;
        let widths = Widths {
            position: vec![3, 6, 11],
            depth: vec![2, 8],
            value: vec![6, 12],
        };
        for perspective in [None, Some(Perspective { fov: 40.0, eye: None })] {
            let mut scene = built_in("ct-fog").unwrap();
            scene.perspective = perspective;
            scene.borders = slicecast_scene::Borders::Whole;
            scene.image.size = Some([48; 2]);
            scene.sampling.planes_per_voxel = 1;
            scene.sampling.rays_per_voxel = 1;
            let lines = lines(&scene, &volume, &widths, 1, &|_, _| ()).unwrap();
            let ways = lines.iter().map(|line| line.way);
            let [rays, fine, paper] = [Way::Rays, Way::Fine, Way::Paper];
            let [x3, x6, x11] = [3, 6, 11].map(Way::Position);
            let [u2, u8, v6, v12] = [Way::Depth(2), Way::Depth(8), Way::Value(6), Way::Value(12)];
            assert_eq!(
                ways.collect::<Vec<_>>(),
                [rays, fine, paper, x3, x6, x11, u2, u8, v6, v12]
            );
            let of = |way| lines.iter().find(|line| line.way == way).unwrap();
            assert!(of(x3).made.is_none() && of(rays).rounded.is_none());
            assert_eq!(of(rays).made.as_ref().unwrap().against_rays, 1.0);
            let rounded = |way| of(way).rounded.unwrap().mean_lsb8;
            let made = |way| of(way).made.as_ref().unwrap().image.unwrap().mean_lsb8;
            for (few, many) in [(x6, x11), (u2, u8), (v6, v12)] {
                assert!(rounded(few) > 2.0 * rounded(many), "{few:?}");
                assert!(made(few) > made(many), "{few:?}");
            }
            assert!(rounded(x3) > rounded(x6));
            assert_eq!(of(x11).made.as_ref().unwrap().record, Some([11, 8, 12]));
            assert_eq!(of(Way::Paper).made.as_ref().unwrap().record, Some([13, 8, 8]));
            for line in &lines {
                let Some(made) = &line.made else { continue };
                assert!(made.count > 1000 && made.milliseconds > 0.0, "{line:?}");
                assert!(made.picture.psnr_db.unwrap() > 20.0, "{line:?}");
            }
        }
    }
}
