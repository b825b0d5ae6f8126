//! A scene as the user states it: real numbers, in the data's own units.
//!
//! The pipeline's tables, shears and light vectors are made from it (`table`, `camera`), and the f64 model reads it
//! directly: nothing here has been rounded to a hardware format.
//!
//! [`mod@file`] reads scenes from TOML, [`check`] holds the range of every field, [`transfer`] evaluates transfer functions,
//! [`colour`] reads colours.

pub mod check;
pub mod clip;
pub mod colour;
pub mod crop;
pub mod cueing;
pub mod file;
pub mod import;
pub mod materials;
pub mod modulation;
pub mod perspective;
pub mod reflectance;
pub mod transfer;

use serde::{Deserialize, Serialize};

/// Everything that decides a picture, apart from the volume.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Where the viewer stands.
    pub view: View,
    /// Rays from an eye; `None` is a parallel view.
    pub perspective: Option<perspective::Perspective>,
    /// The viewer's image.
    pub image: Image,
    /// How densely rays and planes sample the volume.
    pub sampling: Sampling,
    /// The value between voxels.
    pub interpolation: Interpolation,
    /// Where the volume ends, and what a sample at its borders counts.
    pub borders: Borders,
    /// The part of the volume that is drawn; `None` is all of it.
    pub crop: Option<crop::Crop>,
    /// Clip planes, at most [`check::CLIPS`].
    pub clips: Vec<clip::Clip>,
    /// Depth cueing, if colours turn with depth.
    pub cueing: Option<cueing::Cueing>,
    /// Factors by the magnitude of the gradient, if there are any.
    pub modulation: Option<modulation::Modulation>,
    /// Colour and opacity of data values.
    pub transfer: TransferFunction,
    /// Lights and material; `None` is an unlit scene.
    pub lighting: Option<Lighting>,
    /// A map that light is looked up in; `None` computes it.
    pub reflectance: Option<reflectance::Reflectance>,
    /// How samples along a ray combine.
    pub blend: Blend,
    /// Number formats.
    pub precision: PrecisionName,
    /// Transfer-function table encoding; `None` takes the precision's own.
    pub table: Option<AlphaCodeName>,
    /// Table look-up; `None` takes the precision's own.
    pub lookup: Option<LookupName>,
    /// Rays stop when their transparency falls below 2^-n; `None` never stops them early.
    pub early_termination: Option<u32>,
    /// What is classified along a ray.
    pub classification: Classification,
    /// Pieces, 1, 2 or 4, that a segment of strong colours is cut into.
    pub pieces: u32,
    /// Isosurfaces, drawn with the volume or alone.
    pub surfaces: Vec<Surface>,
    /// What is said of a volume of colours, whose voxels nothing classifies; `None` is a scene of values.
    pub colours: Option<Colours>,
}

/// What a scene says of a volume of colours, in place of a transfer function. What it leaves out the file states, or the
/// command line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Colours {
    /// The distance over which the volume's opacities are meant, in its unit of spacing.
    pub alpha_distance: Option<f64>,
    /// The largest extinction, per unit of the spacing, to which larger ones are held.
    pub tau_max: Option<f64>,
    /// Opacities of colours without any.
    pub opacity: Option<ColourOpacity>,
}

/// Where the opacity of colours without one comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ColourOpacity {
    /// The luminance of the colour.
    Luminance,
    /// The same everywhere, 0 to 1.
    Constant(f64),
}

/// The viewing direction as angles, in degrees.
///
/// At 0, 0, 0 the viewer looks along +y with +z up and +x to the right (a patient in LPS axes, seen from the front).
/// Azimuth turns the viewer about +z, counter-clockwise seen from above (positive: the viewer moves towards +x); elevation lifts
/// the viewer towards +z; roll turns the picture clockwise about its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Turn about the z axis, degrees.
    pub azimuth: f64,
    /// Height above the xy plane, degrees, -90 to 90.
    pub elevation: f64,
    /// Turn of the picture, degrees.
    pub roll: f64,
}

/// The camera's axes as unit vectors in the volume's x, y, z (world lengths, not voxels).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraAxes {
    /// To the right of the picture.
    pub right: [f64; 3],
    /// To the top of the picture.
    pub up: [f64; 3],
    /// From the eye into the scene: the viewing direction.
    pub forward: [f64; 3],
}

impl Default for View {
    /// From the front, level, upright.
    fn default() -> Self {
        Self {
            azimuth: 0.0,
            elevation: 0.0,
            roll: 0.0,
        }
    }
}

impl View {
    /// The view from a side of the patient, for volumes whose x, y, z run to the patient's left, back and head.
    ///
    /// `anterior` (or `front`), `posterior` (`back`), `left`, `right`, `superior` (`top`), `inferior` (`bottom`): where
    /// the viewer stands. From above and from below the patient's front is at the top of the picture.
    pub fn named(name: &str) -> Option<Self> {
        let [azimuth, elevation] = match name {
            "anterior" | "front" => [0.0, 0.0],
            "posterior" | "back" => [180.0, 0.0],
            "left" => [90.0, 0.0],
            "right" => [-90.0, 0.0],
            "superior" | "top" => [180.0, 90.0],
            "inferior" | "bottom" => [0.0, -90.0],
            _ => return None,
        };
        Some(Self {
            azimuth,
            elevation,
            roll: 0.0,
        })
    }

    /// The view after the viewer has walked so many degrees, 0 to 360, about the z axis.
    #[must_use]
    pub fn turned(self, degrees: f64) -> Self {
        Self {
            azimuth: (self.azimuth + degrees + 360.0).rem_euclid(720.0) - 360.0,
            ..self
        }
    }

    /// The camera's axes. Components smaller than 1e-15 are exactly zero, so that axis-aligned views are exact.
    pub fn axes(&self) -> CameraAxes {
        let (sa, ca) = sin_cos_degrees(self.azimuth);
        let (se, ce) = sin_cos_degrees(self.elevation);
        let (sr, cr) = sin_cos_degrees(self.roll);
        let forward = [-sa * ce, ca * ce, -se];
        let right0 = [ca, sa, 0.0];
        let up0 = [-sa * se, ca * se, ce];
        let combine = |a: f64, b: f64| [0, 1, 2].map(|i| a * right0[i] + b * up0[i]);
        CameraAxes {
            right: clean(combine(cr, sr)),
            up: clean(combine(-sr, cr)),
            forward: clean(forward),
        }
    }
}

/// Sine and cosine of an angle in degrees, exact at multiples of 90 and equal in size at odd multiples of 45, so that
/// 45-degree views are true ties whatever the machine's own sine does.
fn sin_cos_degrees(degrees: f64) -> (f64, f64) {
    let turn = degrees.rem_euclid(360.0);
    let quarter = (turn / 90.0).floor();
    let rest = turn - 90.0 * quarter;
    let (s, c) = match rest {
        0.0 => (0.0, 1.0),
        45.0 => (std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_SQRT_2),
        r => r.to_radians().sin_cos(),
    };
    match quarter as u32 {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

/// Sets components that are rounding noise to zero.
fn clean(v: [f64; 3]) -> [f64; 3] {
    v.map(|c| if c.abs() < 1e-15 { 0.0 } else { c })
}

/// The viewer's image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Image {
    /// Pixels across and down; `None` chooses a size that shows every ray.
    pub size: Option<[u32; 2]>,
    /// Magnification; 1 fits the whole volume.
    pub zoom: f64,
    /// Colour behind the volume, 0 to 1 each.
    pub background: [f64; 3],
}

impl Default for Image {
    /// Large enough to show every ray, the whole volume, on black.
    fn default() -> Self {
        Self {
            size: None,
            zoom: 1.0,
            background: [0.0; 3],
        }
    }
}

/// Sampling rates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampling {
    /// Sample planes per voxel along the major axis, 1 to 16.
    pub planes_per_voxel: u32,
    /// Rays per voxel along each axis of the base plane, 1 to 8.
    pub rays_per_voxel: u32,
}

impl Default for Sampling {
    /// One plane and one ray per voxel.
    fn default() -> Self {
        Self {
            planes_per_voxel: 1,
            rays_per_voxel: 1,
        }
    }
}

/// Colour and opacity as piecewise linear functions of the data value.
///
/// Below the first point and above the last the function is constant. Two points of the same value make a step (the
/// later one holds at the value itself).
#[derive(Clone, Debug, PartialEq)]
pub struct TransferFunction {
    /// The length over which a point's opacity is meant, in the volume's unit of spacing.
    pub unit_distance: f64,
    /// Points in ascending order of value; at least one.
    pub points: Vec<Point>,
}

/// One point of a transfer function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Data value, in the data's unit.
    pub value: f64,
    /// Red, green, blue, 0 to 1.
    pub colour: [f64; 3],
    /// Opacity over one unit distance, 0 to 1.
    pub opacity: f64,
}

/// An isosurface: where the field takes a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Data value, in the data's unit.
    pub value: f64,
    /// The side of lower values.
    pub front: Face,
    /// The side of higher values.
    pub back: Face,
}

/// One side of an isosurface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Red, green, blue, 0 to 1.
    pub colour: [f64; 3],
    /// Opacity, 0 to 1, whatever the step.
    pub opacity: f64,
}

impl Surface {
    /// A surface with both sides alike.
    pub const fn of(value: f64, face: Face) -> Self {
        Self {
            value,
            front: face,
            back: face,
        }
    }

    /// Whether a side of it is seen.
    pub fn is_visible(&self) -> bool {
        self.front.opacity > 0.0 || self.back.opacity > 0.0
    }
}

impl Default for Face {
    /// Opaque, the colour of ivory.
    fn default() -> Self {
        Self {
            colour: [1.0, 0.94, 0.86],
            opacity: 1.0,
        }
    }
}

/// Lights and the material that they fall on (Squeeze, equation 10).
#[derive(Clone, Debug, PartialEq)]
pub struct Lighting {
    /// Ambient, diffuse and specular coefficient, 0 to 1 each.
    pub ambient: f64,
    /// See [`Lighting::ambient`].
    pub diffuse: f64,
    /// See [`Lighting::ambient`].
    pub specular: f64,
    /// log2 of the specular exponent, 0 to 8.
    pub exponent_log2: u32,
    /// Which dot product the exponent is applied to.
    pub highlight: Highlight,
    /// 1 to 8 lights.
    pub lights: Vec<Light>,
}

impl Default for Lighting {
    /// A matt surface with a small highlight (exponent 32) under one white light from the viewer.
    fn default() -> Self {
        Self {
            ambient: 0.2,
            diffuse: 0.7,
            specular: 0.2,
            exponent_log2: 5,
            highlight: Highlight::Reflection,
            lights: vec![Light::default()],
        }
    }
}

/// The two forms of the specular term.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Highlight {
    /// Phong: the reflected viewing vector and the light vector (R.L).
    Reflection,
    /// Blinn: the normal and the half vector (N.H).
    HalfVector,
}

/// A directional light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Unit vector towards the light, in the frame below.
    pub direction: [f64; 3],
    /// What the direction refers to.
    pub frame: Frame,
    /// Red, green, blue intensity, 0 to 1.
    pub colour: [f64; 3],
}

impl Default for Light {
    /// White, from the viewer.
    fn default() -> Self {
        Self {
            direction: [0.0, 0.0, 1.0],
            frame: Frame::Camera,
            colour: [1.0; 3],
        }
    }
}

impl Light {
    /// A light towards a vector of any length but 0; `None` of one that has no direction. Very long and very short ones
    /// have one.
    pub fn towards(v: [f64; 3]) -> Option<Self> {
        let largest = v.iter().fold(0.0, |most: f64, c| most.max(c.abs()));
        if v.iter().any(|c| !c.is_finite()) || largest == 0.0 {
            return None;
        }
        let scaled = v.map(|c| c / largest);
        let length = scaled.iter().map(|c| c * c).sum::<f64>().sqrt();
        Some(Self {
            direction: scaled.map(|c| c / length),
            ..Self::default()
        })
    }
}

/// A frame of reference for directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Frame {
    /// x to the right of the picture, y up, z towards the viewer.
    Camera,
    /// The volume's own axes.
    Volume,
}

/// How samples along a ray combine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Blend {
    /// Alpha compositing, nearest sample first.
    FrontToBack,
    /// Alpha compositing, farthest sample first.
    BackToFront,
    /// The largest sample of the ray, then classified.
    Maximum,
    /// The smallest sample of the ray, then classified.
    Minimum,
    /// The mean of the ray's samples, then classified.
    Average,
    /// The mean of the ray's samples over the length of the volume's diagonal, outside of the volume the value of code 0: what a ray
    /// sums up. Then classified.
    Additive,
}

impl Blend {
    /// Whether samples are composited, not projected.
    pub const fn is_composited(self) -> bool {
        matches!(self, Self::FrontToBack | Self::BackToFront)
    }
}

/// The named precisions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PrecisionName {
    /// Squeeze to the letter.
    Paper,
    /// 64-bit pixel.
    Compact,
    /// 128-bit pixel.
    Wide,
    /// 16 bits in every lane.
    Fast,
}

impl PrecisionName {
    /// Those of one set of stages, in 32-bit lanes, in the order of reports.
    pub const STAGED: [Self; 3] = [Self::Paper, Self::Compact, Self::Wide];

    /// All of them.
    pub const ALL: [Self; 4] = [Self::Fast, Self::Paper, Self::Compact, Self::Wide];

    /// The name in scenes and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Compact => "compact",
            Self::Wide => "wide",
            Self::Fast => "fast",
        }
    }

    /// The table code that belongs to the precision, for scenes whose visible colours have 8 bits; others take
    /// [`AlphaCodeName::Colour16`] where this has a root of 16 bits.
    pub const fn table(self) -> AlphaCodeName {
        match self {
            Self::Paper => AlphaCodeName::Sqrt8,
            Self::Compact | Self::Wide | Self::Fast => AlphaCodeName::Sqrt16,
        }
    }

    /// The table look-up that belongs to the precision.
    pub const fn lookup(self) -> LookupName {
        match self {
            Self::Paper => LookupName::Nearest,
            Self::Compact | Self::Wide | Self::Fast => LookupName::Linear,
        }
    }
}

/// How a table entry holds its opacity and colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AlphaCodeName {
    /// The square root in 8 bits, colours in 8 bits.
    Sqrt8,
    /// The square root in 16 bits, colours in 8 bits.
    Sqrt16,
    /// The square root in 16 bits, and colours in 16 bits.
    Colour16,
}

/// What is classified along a composited ray.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Classification {
    /// Samples.
    #[default]
    Point,
    /// Segments between samples: the transfer function integrated over the values between them.
    Integral,
    /// Segments where the transfer function is finer than what neighbouring samples differ by or surfaces cut them, else
    /// samples.
    Auto,
    /// Nothing: surfaces alone are drawn.
    None,
}

/// The value of a sample between voxels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Interpolation {
    /// Linear between the eight voxels around it.
    #[default]
    Linear,
    /// That of the nearest voxel: for labels, which are names.
    Nearest,
    /// A spline of second degree about the nearest of 27 voxels, which smooths.
    Quadratic,
}

/// Where the volume ends, and what a sample at its borders counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Borders {
    /// At the outermost voxels, of which every sample counts as a whole step.
    Whole,
    /// Half a voxel beyond them, exactly: a sample counts by the part of its step inside.
    #[default]
    Cells,
    /// At them, exactly.
    Nodes,
}

/// How a sample finds its table entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LookupName {
    /// The nearest entry.
    Nearest,
    /// Linear between the two neighbouring entries.
    Linear,
}
