//! A view in perspective: up to six frames about the eye, and the picture that they make.
//!
//! A pipeline's rays have slopes of at most one along i and j. Rays about an eye are therefore divided by the axis along which they
//! run fastest, in voxels, and its sense: the six faces of a cube about the eye, of which a picture sees one to five. Each is a
//! [`Facet`], with a plan, a table and a base plane of its own. A pixel of the picture looks at the base plane of its own ray's facet, at
//! one point, and takes the mixture of the four pixels about it; facets overlap by some pixels, so that these four are of one.

use rayon::prelude::*;
use slicecast::composite::{Channel, Pixel, Recurrence as _};
use slicecast::format::{Direction, Step, Vector};
use slicecast::perspective::{Eye, EyeError, SLOPE_MAX, Spread};
use slicecast::plan::Plan;
use slicecast::plane::ChannelOf;
use slicecast::precision::Precision;
use slicecast::project::Sum;
use slicecast::view::View;
use slicecast::warp::{Point, Warp, mix_pixels};

use crate::camera::{Material, PICTURE_SIDE_MAX, Picture, Setup, additive, check_spacing, diagonal, planned};
use crate::error::CameraError;
use crate::error::RenderError;
use crate::frame::{Layer, Prepared};
use crate::image::{BaseImage, Frame};
use crate::oriented::{Oriented, Turned};
use crate::picture::of_base;
use crate::pipelines::compile;
use crate::progress::Progress;
use crate::simd::Simd;
use crate::with_precision;
use slicecast_scene::check::RAYS_PER_VOXEL;
use slicecast_scene::{Blend, CameraAxes, Scene, perspective};
use slicecast_volume::Volume;

/// How many pixels of a base plane facets overlap.
const OVERLAP: f64 = 2.0;

/// Where the eye is and what its pixels see.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The eye, voxels along x, y, z from the first voxel's centre.
    pub eye: [f64; 3],
    /// The picture's directions.
    pub axes: CameraAxes,
    /// Pixels across and down.
    pub size: [u32; 2],
    /// The side of a pixel at a distance of 1.
    pub pixel: f64,
    /// Distances between voxels along x, y, z.
    pub spacing: [f64; 3],
}

impl Camera {
    /// The camera of a scene in perspective on a volume.
    ///
    /// # Errors
    /// [`CameraError`] for a spacing or a size that is not taken.
    pub fn of(scene: &Scene, perspective: &perspective::Perspective, volume: &Volume) -> Result<Self, CameraError> {
        let (dims, spacing, axes) = (volume.dims, volume.spacing, scene.view.axes());
        check_spacing(spacing)?;
        let half = (perspective.fov / 2.0).to_radians();
        let middle = dims.map(|side| (side as f64 - 1.0) / 2.0);
        let far = diagonal(dims, spacing) / 2.0 / half.sin();
        let outside = || [0, 1, 2].map(|axis| middle[axis] - axes.forward[axis] * far / spacing[axis]);
        let eye = perspective.eye.map_or_else(outside, |eye| eye.in_voxels(spacing));
        let finest = spacing.iter().copied().fold(f64::INFINITY, f64::min) / f64::from(scene.sampling.rays_per_voxel);
        let natural = || {
            let side = (diagonal(dims, spacing) / finest)
                .ceil()
                .clamp(1.0, f64::from(PICTURE_SIDE_MAX));
            [side as u32; 2]
        };
        let [width, height] = scene.image.size.unwrap_or_else(natural);
        if !(1..=PICTURE_SIDE_MAX).contains(&width) || !(1..=PICTURE_SIDE_MAX).contains(&height) {
            return Err(CameraError::Picture { width, height });
        }
        Ok(Self {
            eye,
            axes,
            size: [width, height],
            pixel: 2.0 * half.tan() / f64::from(height) / scene.image.zoom,
            spacing,
        })
    }

    /// The eye in the frame of a view of a volume of these sides.
    fn eye_along(&self, view: &View, dims: [usize; 3]) -> [f64; 3] {
        let [i, j, k] = view.arrange(self.eye);
        let [_, _, depth] = view.arrange(dims);
        let from_behind = depth as f64 - 1.0 - k;
        [i, j, if view.reversed() { from_behind } else { k }]
    }

    /// The direction of a pixel's ray, voxels along x, y, z.
    pub fn direction(&self, x: u32, y: u32) -> [f64; 3] {
        let CameraAxes { right, up, forward } = self.axes;
        let [width, height] = self.size.map(f64::from);
        let across = (f64::from(x) - (width - 1.0) / 2.0) * self.pixel;
        let high = ((height - 1.0) / 2.0 - f64::from(y)) * self.pixel;
        [0, 1, 2].map(|axis| (forward[axis] + across * right[axis] + high * up[axis]) / self.spacing[axis])
    }
}

/// The facet of a direction, by its number, and the direction in its frame: slopes along i and j.
fn facet_of(direction: [f64; 3]) -> (usize, [f64; 2]) {
    let [x, y, z] = direction.map(f64::abs);
    // Ties as those of parallel views.
    let (axis, across) = if z >= y && z >= x {
        (2, [0, 1])
    } else if y >= x {
        (1, [0, 2])
    } else {
        (0, [1, 2])
    };
    let along = direction[axis];
    let number = 2 * axis + usize::from(along < 0.0);
    (number, across.map(|other| direction[other] / along.abs()))
}

/// The view of a facet.
fn view_of(number: usize) -> Result<View, CameraError> {
    let one = if number.is_multiple_of(2) {
        Direction::ONE
    } else {
        -Direction::ONE
    };
    let mut direction = [Direction::ZERO; 3];
    direction[number / 2] = one;
    Ok(View::new(direction)?)
}

/// The rays about an eye that run fastest along one axis and sense of the volume.
#[derive(Clone, Debug)]
pub struct Facet<'a> {
    /// Its number: twice the axis, and 1 more against it.
    number: usize,
    /// Its frame.
    pub prepared: Prepared<'a>,
}

impl Facet<'_> {
    /// The axis of the volume along which its rays run fastest: 0 is x, 1 is y, 2 is z.
    pub const fn axis(&self) -> usize {
        self.number / 2
    }

    /// Its rays.
    pub const fn spread(&self) -> Option<&Spread> {
        self.prepared.setup.spread.as_ref()
    }
}

/// A scene in perspective on a volume, ready to be rendered.
#[derive(Clone, Debug)]
pub struct InPerspective<'a> {
    scene: &'a Scene,
    /// Where the eye is.
    pub camera: Camera,
    /// What it sees.
    pub facets: Vec<Facet<'a>>,
    simd: Simd,
}

impl<'a> InPerspective<'a> {
    /// Prepares a scene that is seen in this perspective.
    ///
    /// # Errors
    /// [`CameraError`], also where nothing of the volume is seen.
    pub fn new(
        scene: &'a Scene,
        perspective: &perspective::Perspective,
        volume: &'a Volume,
    ) -> Result<Self, CameraError> {
        let camera = Camera::of(scene, perspective, volume)?;
        let mut facets = Vec::new();
        for (number, slopes) in seen(&camera).into_iter().enumerate() {
            let Some(slopes) = slopes else { continue };
            match facet(number, scene, volume, &camera, slopes) {
                Ok(facet) => facets.push(facet),
                Err(CameraError::Eye(EyeError::Nothing)) => {}
                Err(error) => return Err(error),
            }
        }
        if facets.is_empty() {
            return Err(EyeError::Nothing.into());
        }
        Ok(Self {
            scene,
            camera,
            facets,
            simd: Simd::widest(),
        })
    }

    /// The same, with these vectors.
    #[must_use]
    pub fn with_simd(mut self, simd: Simd) -> Self {
        for facet in &mut self.facets {
            facet.prepared.simd = simd;
        }
        Self { simd, ..self }
    }

    /// The picture's own map: its frame is the picture already.
    pub fn picture(&self) -> Picture {
        Picture {
            size: self.camera.size,
            warp: Warp::IDENTITY,
            affine: [[0.0; 2], [1.0, 0.0], [0.0, 1.0]],
        }
    }

    /// Renders the picture: its base image is the picture before a background. `progress` is told how many steps of how many are done.
    ///
    /// # Errors
    /// As [`Prepared::render`].
    pub fn render(&self, layer: Layer, progress: Progress<'_>) -> Result<Frame, RenderError> {
        Ok(self.frame(&self.bases(layer, progress)?))
    }

    /// Renders the base planes of all facets.
    ///
    /// # Errors
    /// As [`Prepared::render`].
    pub fn bases(&self, layer: Layer, progress: Progress<'_>) -> Result<Vec<BaseImage>, RenderError> {
        let all = self.facets.len();
        let base = |(before, facet): (usize, &Facet<'_>)| {
            let prepared = &facet.prepared;
            let mut turned = Turned::new(prepared.volume, &prepared.setup.plan);
            let slices = turned.slices()?;
            let mut rendering = prepared.begun()?;
            let of_all = |done: usize, of: usize| progress(before * of + done, all * of);
            match layer {
                Layer::Tiles(rows) => rendering.fold(&Oriented::of(&slices), rows, prepared.simd, &of_all),
                Layer::Stream => rendering.stream(&slices, &of_all, None)?,
            }
            Ok(rendering.base())
        };
        self.facets.iter().enumerate().map(base).collect()
    }

    /// The picture of base planes.
    pub fn frame(&self, bases: &[BaseImage]) -> Frame {
        let precision = self.scene.precision;
        let base = with_precision!(precision, p => self.mixed(p, bases));
        let picture = of_base(
            &base,
            precision,
            &self.picture(),
            self.scene.image.background,
            self.simd,
        );
        Frame { base, picture }
    }

    /// Where a pixel of the picture looks: a facet's place among those that are seen, and base-plane coordinates there.
    pub fn point(&self, x: u32, y: u32) -> Option<(usize, [f64; 2])> {
        let (number, slopes) = facet_of(self.camera.direction(x, y));
        let place = self.facets.iter().position(|facet| facet.number == number)?;
        let facet = &self.facets[place];
        let (spread, [_, _, depth]) = (facet.spread()?, facet.prepared.setup.plan.volume());
        let [ei, ej, ek] = spread.eye().map(|c| c.to_bits() as f64 / 4294967296.0);
        let way = f64::from(depth) - 1.0 - ek;
        let [first_i, first_j] = spread.first().map(f64::from);
        let rays = f64::from(spread.rays_per_voxel());
        let along = |eye: f64, slope: f64, first: f64| (eye + way * slope) * rays - first;
        Some((place, [along(ei, slopes[0], first_i), along(ej, slopes[1], first_j)]))
    }

    /// The picture's pixels, each a mixture of four of a facet's base plane.
    fn mixed<P: Precision>(&self, p: P, bases: &[BaseImage]) -> BaseImage {
        let [width, height] = self.camera.size.map(|side| side as usize);
        let clear: Pixel<ChannelOf<P>> = p.pixel().clear();
        let row = |y: u32| {
            let pixel = |x: u32| {
                let Some((place, at)) = self.point(x, y) else {
                    return clear;
                };
                let base = &bases[place];
                let Point {
                    pixel: [u, v],
                    weight: [wu, wv],
                } = Point::at(at.map(|c| (c * 4294967296.0).round() as i64));
                let row = |v: i64| {
                    mix_pixels(
                        pixel_of::<P>(base, [u, v], clear),
                        pixel_of::<P>(base, [u + 1, v], clear),
                        wu,
                    )
                };
                mix_pixels(row(v), row(v + 1), wv)
            };
            (0..width as u32).map(pixel).collect::<Vec<_>>()
        };
        let pixels: Vec<_> = (0..height as u32).into_par_iter().flat_map_iter(row).collect();
        let channel = |number: usize| {
            let of = |pixel: &Pixel<ChannelOf<P>>| match number {
                3 => pixel.transparency.bits(),
                number => pixel.colour[number].bits(),
            };
            pixels.iter().map(of).collect::<Vec<u32>>()
        };
        BaseImage {
            size: [width, height],
            format: p.pixel().format(),
            one: p.pixel().one().bits(),
            planes: [channel(0), channel(1), channel(2), channel(3)],
        }
    }
}

/// Rays that a pixel may lack without being blurred to the eye.
const RAYS_TOLERANCE: f64 = 0.05;

/// Rays per voxel at which a picture is sharp: in the last slice of each facet they are not farther apart than its pixels.
///
/// # Errors
/// As [`Camera::of`].
pub fn sharp(scene: &Scene, perspective: &perspective::Perspective, volume: &Volume) -> Result<u32, CameraError> {
    let camera = Camera::of(scene, perspective, volume)?;
    let [low, high] = [*RAYS_PER_VOXEL.start(), *RAYS_PER_VOXEL.end()].map(|rays| rays as f64);
    let mut most = low;
    for (number, slopes) in seen(&camera).into_iter().enumerate() {
        let view = view_of(number)?;
        let [_, _, ek] = camera.eye_along(&view, volume.dims);
        let way = view.arrange(volume.dims)[2] as f64 - 1.0 - ek;
        if slopes.is_some() && way > 0.0 {
            // The least voxels that a pixel in the middle of the facet is wide.
            let [across, down, along] = view.arrange(volume.spacing);
            let pixel = way * camera.pixel * along / across.max(down);
            most = most.max((1.0 / pixel - RAYS_TOLERANCE).ceil());
        }
    }
    Ok(most.min(high) as u32)
}

/// Samples of a plan in perspective that lie in the volume.
pub fn samples(plan: &Plan, spread: &Spread) -> u64 {
    let ([width, height, _], [columns, rows]) = (plan.dims(), plan.base());
    let of_plane = |plane| {
        let [across, down] = spread.lines(plane);
        across.inside(width, columns).len() as u64 * down.inside(height, rows).len() as u64
    };
    (spread.first_plane()..plan.planes()).map(of_plane).sum()
}

/// A pixel of a base plane, clear outside of it.
fn pixel_of<P: Precision>(base: &BaseImage, [u, v]: [i64; 2], clear: Pixel<ChannelOf<P>>) -> Pixel<ChannelOf<P>> {
    let [width, height] = base.size.map(|side| side as i64);
    if !(0..width).contains(&u) || !(0..height).contains(&v) {
        return clear;
    }
    let [red, green, blue, transparency] = base
        .planes
        .each_ref()
        .map(|plane| ChannelOf::<P>::from_bits(plane[(v * width + u) as usize]));
    Pixel {
        colour: [red, green, blue],
        transparency,
    }
}

/// The least and the greatest slopes along i and j of the picture's rays in each facet.
fn seen(camera: &Camera) -> [Option<[[f64; 2]; 2]>; 6] {
    let [width, height] = camera.size;
    let row = |y: u32| {
        let mut slopes = [None; 6];
        for x in 0..width {
            let (number, at) = facet_of(camera.direction(x, y));
            slopes[number] = Some(joined(slopes[number].unwrap_or([at, at]), [at, at]));
        }
        slopes
    };
    let both = |a: [Option<[[f64; 2]; 2]>; 6], b: [Option<[[f64; 2]; 2]>; 6]| {
        std::array::from_fn(|number| match (a[number], b[number]) {
            (Some(a), Some(b)) => Some(joined(a, b)),
            (a, b) => a.or(b),
        })
    };
    (0..height).into_par_iter().map(row).reduce(|| [None; 6], both)
}

/// What holds two ranges of slopes.
fn joined([[a, b], [c, d]]: [[f64; 2]; 2], [[e, f], [g, h]]: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    [[a.min(e), b.min(f)], [c.max(g), d.max(h)]]
}

/// What an additive projection makes of sums of eighths of steps: the mean over the volume's diagonal.
fn sum_of_steps(step: f64, volume: &Volume) -> Result<Sum, CameraError> {
    let diagonal = diagonal(volume.dims, volume.spacing);
    let eight = 8.0 * step;
    if eight > diagonal {
        return Err(CameraError::Additive { diagonal, eight });
    }
    Ok(additive(eight, volume.dims, volume.spacing))
}

/// One facet of a picture.
fn facet<'a>(
    number: usize,
    scene: &'a Scene,
    volume: &'a Volume,
    camera: &Camera,
    [low, high]: [[f64; 2]; 2],
) -> Result<Facet<'a>, CameraError> {
    let view = view_of(number)?;
    let (dims, sampling, factors) = planned(scene, volume.dims, volume.spacing);
    let position = camera.eye_along(&view, volume.dims);
    let way = view.arrange(volume.dims)[2] as f64 - 1.0 - position[2];
    if way <= 0.0 {
        return Err(EyeError::Nothing.into());
    }
    let margin = OVERLAP / (f64::from(scene.sampling.rays_per_voxel) * way);
    let most = f64::from(SLOPE_MAX.to_bits()) / 1073741824.0;
    let slope = |slope: f64| Vector::from_bits((slope.clamp(-most, most) * 1073741824.0) as i32);
    let eye = Eye {
        position: position.map(|c| Step::from_bits((c * 4294967296.0).round() as i64)),
        low: low.map(|s| slope(s - margin)),
        high: high.map(|s| slope(s + margin)),
    };
    let (plan, spread) = Plan::perspective(view, dims, factors, sampling, eye)?;
    let [_, _, along] = view.arrange(volume.spacing);
    let step_length = along / f64::from(sampling.planes_per_voxel);
    let setup = Setup {
        picture: Picture {
            size: [1; 2],
            warp: Warp::IDENTITY,
            affine: [[0.0; 2], [1.0, 0.0], [0.0, 1.0]],
        },
        material: match &scene.lighting {
            Some(lighting) => Some(Material::new(lighting, &camera.axes, &view)?),
            None => None,
        },
        additive: match scene.blend {
            Blend::Additive => sum_of_steps(step_length, volume)?,
            _ => Sum::Average,
        },
        step_length,
        clips: None,
        spread: Some(spread),
        plan,
    };
    Ok(Facet {
        number,
        prepared: Prepared {
            table: compile(scene, &volume.mapping, setup.step_length),
            segments: None,
            modulation: None,
            finest: None,
            scene,
            volume,
            setup,
            simd: Simd::widest(),
        },
    })
}
