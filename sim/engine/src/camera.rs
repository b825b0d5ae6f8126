//! From the scene's real numbers to the pipeline's: view, plan, warp, light vectors. Each is rounded once, here.

use slicecast::borders;
use slicecast::clip::{Clip, Clips, Cue};
use slicecast::crop::Crop;
use slicecast::format::{Coefficient, Direction, Distance, Intensity, Position, Step, Vector};
use slicecast::perspective::Spread;
use slicecast::plan::{Plan, Sampling, Spacing};
use slicecast::precision::{Compact, Precision};
use slicecast::project::{SHIFT_MAX, Sum};
pub use slicecast::screen::PICTURE_SIDE_MAX;
use slicecast::shade::{self, Phong, PhongError};
use slicecast::view::View;
use slicecast::warp::Warp;

use crate::error::{CameraError, SPACING, SPACING_RATIO_MAX};
use crate::geometry::Geometry;
use slicecast_pyramid::volume::RgbaVolume;
use slicecast_scene::{Borders, CameraAxes, Frame, Highlight, Interpolation, Light, Lighting, Scene};
use slicecast_volume::Volume;

/// Refuses spacings that leave no view.
///
/// # Errors
/// [`CameraError`] for a length that is none, or lengths too far apart.
pub fn check_spacing(spacing: [f64; 3]) -> Result<(), CameraError> {
    let least = spacing.iter().copied().fold(f64::INFINITY, f64::min);
    let fits = |s: &f64| SPACING.contains(s) && *s <= SPACING_RATIO_MAX * least;
    if spacing.iter().all(fits) {
        Ok(())
    } else {
        Err(CameraError::Spacing { spacing })
    }
}

/// The view of a scene on a volume.
///
/// # Errors
/// [`CameraError::Spacing`] if the spacing leaves no direction.
pub fn view(scene: &Scene, spacing: [f64; 3]) -> Result<View, CameraError> {
    check_spacing(spacing)?;
    let forward = scene.view.axes().forward;
    let voxels = [0, 1, 2].map(|a| forward[a] / spacing[a]);
    let longest = voxels.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
    let one = Direction::ONE.to_bits() as f64;
    Ok(View::new(
        voxels.map(|c| Direction::from_bits((c / longest * one).round() as i64)),
    )?)
}

/// What a plan is made of besides view and rays: sides, rates, and each spacing's share of the smallest.
pub(crate) fn planned(scene: &Scene, dims: [usize; 3], spacing: [f64; 3]) -> ([u32; 3], Sampling, Spacing) {
    let smallest = spacing.iter().copied().fold(f64::INFINITY, f64::min);
    let factor = |s: f64| Intensity::from_bits((smallest / s * 32768.0).round() as u16);
    let sampling = Sampling {
        planes_per_voxel: scene.sampling.planes_per_voxel,
        rays_per_voxel: scene.sampling.rays_per_voxel,
    };
    let dims = dims.map(|side| u32::try_from(side).unwrap_or(u32::MAX));
    (dims, sampling, Spacing(spacing.map(factor)))
}

/// The plan of a scene on a volume of this shape.
///
/// # Errors
/// [`CameraError`] for a spacing, a view or a sampling rate that the pipeline does not take.
pub fn plan(scene: &Scene, dims: [usize; 3], spacing: [f64; 3]) -> Result<Plan, CameraError> {
    if scene.perspective.is_some() {
        return Err(CameraError::InPerspective);
    }
    let view = view(scene, spacing)?;
    let (dims, sampling, factors) = planned(scene, dims, spacing);
    let borders = match scene.borders {
        Borders::Whole => borders::Borders::Whole,
        Borders::Cells => borders::Borders::Cells,
        Borders::Nodes => borders::Borders::Nodes,
    };
    let plan = Plan::with_borders(view, dims, factors, sampling, borders)?;
    let plan = match crop(scene, spacing) {
        None => plan,
        Some(crop) => plan.with_crop(crop)?,
    };
    Ok(match scene.interpolation {
        Interpolation::Linear | Interpolation::Quadratic => plan,
        Interpolation::Nearest => plan.with_nearest(),
    })
}

/// The crop box of a scene on a volume with this spacing.
pub fn crop(scene: &Scene, spacing: [f64; 3]) -> Option<Crop> {
    let faces = scene.crop?.faces(spacing);
    // A conversion to an integer saturates, far beyond any volume.
    let face = |end: usize| faces.map(|range| Position::from_bits((range[end] * 65536.0) as i32));
    Some(Crop {
        low: face(0),
        high: face(1),
    })
}

/// The clip planes of a scene on a volume with this spacing, and its depth cueing; `None` if it has neither.
///
/// # Errors
/// [`CameraError::Clip`] for one of them that the pipeline does not take.
pub fn clips(scene: &Scene, plan: &Plan, spacing: [f64; 3]) -> Result<Option<Clips>, CameraError> {
    if scene.clips.is_empty() && scene.cueing.is_none() {
        return Ok(None);
    }
    let length = |length: f64| Distance::from_bits((length * LENGTH) as i64);
    let slopes = |slopes: [f64; 3]| slopes.map(|slope| Vector::from_bits((slope * LENGTH) as i32));
    let clip = |clip: &slicecast_scene::clip::Clip| {
        let plane = clip.in_voxels(spacing);
        Clip {
            slope: slopes(plane.slope),
            distance: length(plane.distance),
            thickness: plane.thickness.map(length),
            falloff: length(plane.falloff),
            outside: clip.outside,
        }
    };
    let planes: Vec<Clip> = scene.clips.iter().map(clip).collect();
    let clips = Clips::new(plan, &planes)?;
    let Some(cueing) = scene.cueing else {
        return Ok(Some(clips));
    };
    let dims = plan.view().restore(plan.volume()).map(|side| side as usize);
    let plane = cueing.in_voxels(scene.view.axes().forward, dims, spacing);
    let cue = Cue {
        slope: slopes(plane.slope),
        distance: length(plane.distance),
        depth: length(plane.depth),
        most: (plane.strength * 65536.0) as u32,
        colour: cueing
            .colour
            .map(|c| Intensity::from_bits((c * 32768.0).round() as u16)),
    };
    Ok(Some(clips.with_cue(plan, &cue)?))
}

/// Units of a distance from a clip plane in a length.
const LENGTH: f64 = 1_073_741_824.0;

/// The length of a ray's step between two sample planes, in the unit of the spacing.
pub fn step_length(scene: &Scene, plan: &Plan, spacing: [f64; 3]) -> f64 {
    let forward = scene.view.axes().forward;
    let voxels = [0, 1, 2].map(|a| forward[a] / spacing[a]);
    let [_, _, k] = plan.view().orient(voxels);
    // Along the unit vector `forward` the ray covers k slices in a length of 1.
    1.0 / (k.abs() * f64::from(plan.sampling().planes_per_voxel))
}

/// The length of the diagonal of a volume's cells, in the unit of the spacing.
pub fn diagonal(dims: [usize; 3], spacing: [f64; 3]) -> f64 {
    let sides = [0, 1, 2].map(|a| dims[a] as f64 * spacing[a]);
    // Sides may be beyond what can be squared.
    let longest = sides.into_iter().fold(0.0, f64::max);
    longest * sides.iter().map(|side| (side / longest).powi(2)).sum::<f64>().sqrt()
}

/// What an additive projection makes of a sum over steps of this length: the mean over the diagonal of the volume, which no ray in
/// it is longer than.
pub(crate) fn additive(step: f64, dims: [usize; 3], spacing: [f64; 3]) -> Sum {
    let share = (step / diagonal(dims, spacing)).min(1.0);
    let shift = (-share.log2()).floor().clamp(0.0, f64::from(SHIFT_MAX)) as u32;
    let bits = (share * f64::from(32 + shift).exp2()).round();
    Sum::Additive {
        step: bits.clamp(1.0, f64::from(u32::MAX)) as u32,
        shift,
    }
}

/// A vector of the scene in the slice frame (world proportions).
fn to_slice_frame(view: &View, axes: &CameraAxes, frame: Frame, v: [f64; 3]) -> [f64; 3] {
    let world = match frame {
        Frame::Volume => v,
        Frame::Camera => [0, 1, 2].map(|a| v[0] * axes.right[a] + v[1] * axes.up[a] - v[2] * axes.forward[a]),
    };
    view.orient(world)
}

/// A direction as a unit vector, s1.30.
fn unit(v: [f64; 3]) -> [Vector; 3] {
    let length = dot(v, v).sqrt();
    v.map(|c| Vector::from_bits((c / length * 1073741824.0).round() as i32))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Lights and material in the slice frame, before a precision takes what it keeps of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Ambient coefficient, a channel each.
    pub ambient: [Coefficient; 3],
    /// The lights, with their coefficients.
    pub lights: Vec<shade::Light>,
    /// Unit vector towards the eye.
    pub viewer: [Vector; 3],
    /// The form of the highlight.
    pub highlight: shade::Highlight,
    /// log2 of its exponent.
    pub exponent_log2: u32,
}

impl Material {
    /// The lights of a scene.
    ///
    /// # Errors
    /// [`CameraError::Lighting`] for more lights or a higher exponent than the pipeline takes.
    pub fn new(lighting: &Lighting, axes: &CameraAxes, view: &View) -> Result<Self, CameraError> {
        let coefficient = |k: f64| Coefficient::from_bits((k * 2147483648.0).round().clamp(0.0, 2147483648.0) as u32);
        let viewer = view.orient(axes.forward.map(|c| -c));
        let light = |light: &Light| {
            let direction = to_slice_frame(view, axes, light.frame, light.direction);
            let half = [0, 1, 2].map(|a| direction[a] + viewer[a]);
            // A light straight behind the volume has no half vector; it lights nothing that the viewer sees.
            let half = if dot(half, half) > 1e-12 { half } else { direction };
            shade::Light {
                direction: unit(direction),
                half: unit(half),
                diffuse: light.colour.map(|c| coefficient(lighting.diffuse * c)),
                specular: light.colour.map(|c| coefficient(lighting.specular * c)),
            }
        };
        let material = Self {
            ambient: [coefficient(lighting.ambient); 3],
            lights: lighting.lights.iter().map(light).collect(),
            viewer: unit(viewer),
            highlight: match lighting.highlight {
                Highlight::Reflection => shade::Highlight::Reflection,
                Highlight::HalfVector => shade::Highlight::HalfVector,
            },
            exponent_log2: lighting.exponent_log2,
        };
        // What one precision takes all of them take.
        material.phong(Compact)?;
        Ok(material)
    }

    /// The shader of a precision.
    ///
    /// # Errors
    /// As [`Material::new`].
    pub fn phong<P: Precision>(&self, precision: P) -> Result<Phong<P>, PhongError> {
        Phong::new(
            precision,
            self.ambient,
            &self.lights,
            self.viewer,
            self.highlight,
            self.exponent_log2,
        )
    }
}

/// A picture: its size and where its pixels look.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picture {
    /// Pixels across and down.
    pub size: [u32; 2],
    /// The map as the pipeline has it.
    pub warp: Warp,
    /// The same map before rounding: base-plane coordinates (u, v) of pixel (X, Y) are
    /// `origin + X right + Y down`.
    pub affine: [[f64; 2]; 3],
}

/// How far the corners of a scene's volume reach from one end to the other, across the picture and up it, as lengths.
pub fn extent(scene: &Scene, dims: [usize; 3], spacing: [f64; 3]) -> [f64; 2] {
    let CameraAxes { right, up, .. } = scene.view.axes();
    let voxels = |side: usize| match scene.borders {
        Borders::Whole | Borders::Nodes => side.max(2) - 1,
        Borders::Cells => side,
    };
    let sides = [0, 1, 2].map(|a| voxels(dims[a]) as f64 * spacing[a]);
    [right, up].map(|axis| (0..3).map(|a| sides[a] * axis[a].abs()).sum())
}

/// The length of a picture pixel's side at which an extent fits into a size, with half a pixel of margin on each side.
pub fn fitting_pixel([across, high]: [f64; 2], [width, height]: [u32; 2]) -> f64 {
    (across / f64::from(width.max(2) - 1)).max(high / f64::from(height.max(2) - 1))
}

/// Pixels across and down that show an extent at pixels of this side, at most [`PICTURE_SIDE_MAX`].
pub fn size_at(extent: [f64; 2], pixel: f64) -> [u32; 2] {
    extent.map(|length| ((length / pixel).ceil() as u32).saturating_add(1).min(PICTURE_SIDE_MAX))
}

/// Places the picture: the middle of the volume in its middle, the whole volume inside it at a zoom of 1.
///
/// Without a size the picture has square pixels as long as a voxel's shortest side divided by the rays per voxel.
///
/// # Errors
/// [`CameraError::Picture`] for a size of 0 or beyond [`PICTURE_SIDE_MAX`].
pub fn picture(scene: &Scene, plan: &Plan, dims: [usize; 3], spacing: [f64; 3]) -> Result<Picture, CameraError> {
    let axes = scene.view.axes();
    let view = plan.view();
    let [si, sj, sk] = view.arrange(spacing);
    let world = |v: [f64; 3]| view.orient(v);
    let (right, up, forward) = (world(axes.right), world(axes.up), world(axes.forward));
    let [ni, nj, nk] = plan.volume().map(f64::from);
    let rays = f64::from(plan.sampling().rays_per_voxel);

    let extent = extent(scene, dims, spacing);
    let finest = spacing.iter().copied().fold(f64::INFINITY, f64::min) / rays;
    let [width, height] = scene.image.size.unwrap_or_else(|| size_at(extent, finest));
    if !(1..=PICTURE_SIDE_MAX).contains(&width) || !(1..=PICTURE_SIDE_MAX).contains(&height) {
        return Err(CameraError::Picture { width, height });
    }
    let pixel = fitting_pixel(extent, [width, height]) / scene.image.zoom;
    let pixel = if pixel > 0.0 { pixel } else { finest };

    // A point p of the picture plane (world, from the volume's middle) lies on the ray that meets the first slice at
    // p + t forward, where its k is that of the slice.
    let middle = [ni - 1.0, nj - 1.0, nk - 1.0].map(|n| n / 2.0);
    let [oi, oj] = plan.origin().map(f64::from);
    let base = |p: [f64; 3]| {
        let t = -(middle[2] * sk + p[2]) / forward[2];
        let i = middle[0] + (p[0] + t * forward[0]) / si;
        let j = middle[1] + (p[1] + t * forward[1]) / sj;
        [(i - oi) * rays, (j - oj) * rays]
    };
    let at = |x: f64, y: f64| {
        let (a, b) = (
            (x - (f64::from(width) - 1.0) / 2.0) * pixel,
            ((f64::from(height) - 1.0) / 2.0 - y) * pixel,
        );
        base([0, 1, 2].map(|c| a * right[c] + b * up[c]))
    };
    let origin = at(0.0, 0.0);
    let step = |p: [f64; 2]| [p[0] - origin[0], p[1] - origin[1]];
    // Steps are taken over the whole picture, so that their own rounding does not add up.
    let (far_x, far_y) = (f64::from(width.max(2) - 1), f64::from(height.max(2) - 1));
    let right_step = step(at(far_x, 0.0)).map(|c| c / far_x);
    let down_step = step(at(0.0, far_y)).map(|c| c / far_y);
    let bits = |v: [f64; 2]| v.map(|c| Step::from_bits((c * 4294967296.0).round() as i64));
    Ok(Picture {
        size: [width, height],
        warp: Warp {
            origin: bits(origin),
            right: bits(right_step),
            down: bits(down_step),
        },
        affine: [origin, right_step, down_step],
    })
}

/// What the pipeline needs to know of a scene on a volume, apart from the table.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The geometry.
    pub plan: Plan,
    /// Clip planes, if there are any.
    pub clips: Option<Clips>,
    /// The rays of a plan in perspective.
    pub spread: Option<Spread>,
    /// The picture.
    pub picture: Picture,
    /// Lights; `None` is an unlit scene.
    pub material: Option<Material>,
    /// Length of a ray's step, in the unit of the spacing.
    pub step_length: f64,
    /// What an additive projection makes of a sum: the mean over the volume's diagonal.
    pub additive: Sum,
}

impl Setup {
    /// What a frame is folded with.
    pub const fn geometry(&self) -> Geometry<'_> {
        Geometry {
            plan: &self.plan,
            clips: self.clips.as_ref(),
        }
    }
}

/// What a view sees of a volume without looking into it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Voxels along x, y and z.
    pub dims: [usize; 3],
    /// Distance between voxels along x, y and z.
    pub spacing: [f64; 3],
}

impl From<&RgbaVolume> for Shape {
    fn from(volume: &RgbaVolume) -> Self {
        Self {
            dims: volume.dims,
            spacing: volume.spacing,
        }
    }
}

impl From<&Volume> for Shape {
    fn from(volume: &Volume) -> Self {
        Self {
            dims: volume.dims,
            spacing: volume.spacing,
        }
    }
}

/// Sets up a scene on a volume.
///
/// # Errors
/// [`CameraError`], with what is out of range.
pub fn set_up(scene: &Scene, volume: impl Into<Shape>) -> Result<Setup, CameraError> {
    let Shape { dims, spacing } = volume.into();
    let plan = plan(scene, dims, spacing)?;
    let axes = scene.view.axes();
    Ok(Setup {
        picture: picture(scene, &plan, dims, spacing)?,
        material: match &scene.lighting {
            Some(lighting) => Some(Material::new(lighting, &axes, plan.view())?),
            None => None,
        },
        additive: additive(step_length(scene, &plan, spacing), dims, spacing),
        step_length: step_length(scene, &plan, spacing),
        clips: clips(scene, &plan, spacing)?,
        spread: None,
        plan,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spacings_that_leave_no_view_are_named() {
        let scene = slicecast_scene::file::built_in(slicecast_scene::file::DEFAULT).unwrap();
        let planned = |spacing| plan(&scene, [4; 3], spacing);
        for spacing in [
            [1e-320; 3],
            [1e-320, 1.0, 1.0],
            [1.0, 1e308, 1.0],
            [1.0, f64::NAN, 1.0],
            [1.0, 1.0, 0.0],
            [-1.0, 1.0, 1.0],
            [1.0, 32769.0, 1.0],
        ] {
            let error = planned(spacing).unwrap_err();
            assert!(matches!(error, CameraError::Spacing { .. }), "{spacing:?}: {error}");
        }
        let error = planned([1e-9, 1.0, 1.0]).unwrap_err().to_string();
        assert!(
            error.starts_with("a voxel spacing of 1e-9 x 1 x 1; accepted: 1e-100 to 1e100 along "),
            "{error}"
        );
        for (spacing, factors) in [
            ([1.0, 32768.0, 1.0], [32768, 1, 32768]),
            ([1e-100; 3], [32768; 3]),
            ([1e100; 3], [32768; 3]),
        ] {
            let plan = planned(spacing).unwrap();
            let arranged = plan.view().arrange(factors);
            assert_eq!(plan.spacing().map(Intensity::to_bits), arranged, "{spacing:?}");
            assert!(step_length(&scene, &plan, spacing).is_normal());
        }
    }
}
