//! Scenes as a device holds them: numbers of the pipeline's own formats, in flash.

use slicecast::absorption::Medium;
use slicecast::absorption::MediumError;
use slicecast::classify::{AlphaCode, Colour16, Linear, Lookup, Nearest, PointTable, Sqrt8, Sqrt16};
use slicecast::composite::{ChannelFormat, FrontToBack, Recurrence};
use slicecast::cut::CutError;
use slicecast::fast::FastPhong;
use slicecast::format::{Coefficient, Direction, Intensity, Opacity, Step, Vector};
use slicecast::integral::{Colours, Integral, IntegralError, Length};
use slicecast::perspective::{Eye, EyeError, Spread};
use slicecast::plan::{Plan, PlanError, Sampling, Spacing};
use slicecast::plane::Composite;
use slicecast::precision::{Compact, Paper, Precision, Wide};
use slicecast::shade::{Highlight, Light, Phong, PhongError, Shader, Unlit};
use slicecast::surface::{Face, Surface};
use slicecast::table::ENTRIES;
use slicecast::view::{View, ViewError};
use slicecast::warp::Warp;

/// A scene.
#[derive(Debug)]
pub struct SceneData {
    /// Its name in reports.
    pub name: &'static str,
    /// Viewing direction, s5.58 bits.
    pub direction: [i64; 3],
    /// Voxels along x, y, z.
    pub dims: [u32; 3],
    /// Spacing factors, 1.15 bits.
    pub spacing: [u16; 3],
    /// Planes and rays per voxel.
    pub sampling: [u32; 2],
    /// Voxels of the slices, in the order in which the view meets them.
    pub voxels: &'static [u16],
    /// The table of the `Paper` precision.
    pub entries8: &'static [u32; ENTRIES],
    /// The table of `Compact`,
    pub entries16: &'static [u32; ENTRIES],
    /// and the roots' low bytes, which are those of `Wide`, too.
    pub plane16: &'static [u8; ENTRIES],
    /// The table of `Wide`, whose colours have 16 bits,
    pub entries_wide: &'static [u32; ENTRIES],
    /// and the colours' low bytes.
    pub colours_wide: &'static [[u8; 3]; ENTRIES],
    /// Lights and material.
    pub lighting: Lighting,
    /// The viewer's picture: pixels across and down.
    pub picture: [u32; 2],
    /// The map to the base plane: origin, right, down, s31.32 bits.
    pub warp: [[i64; 2]; 3],
}

/// Lights and material, bits of their formats.
#[derive(Debug)]
pub struct Lighting {
    /// Ambient coefficient, 1.31.
    pub ambient: [u32; 3],
    /// Vector towards the eye, s1.30.
    pub viewer: [i32; 3],
    /// Whether the highlight takes the half vector.
    pub half_vector: bool,
    /// log2 of the highlight's exponent.
    pub exponent_log2: u32,
    /// The lights.
    pub lights: &'static [LightBits],
}

/// A light: direction and half vector (s1.30), diffuse and specular coefficients (1.31).
pub type LightBits = ([i32; 3], [i32; 3], [u32; 3], [u32; 3]);

/// Why a scene's numbers make no scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneError {
    /// The view.
    View(ViewError),
    /// The geometry.
    Plan(PlanError),
    /// The lights.
    Phong(PhongError),
    /// The integrals.
    Integral(IntegralError),
    /// The surfaces.
    Cut(CutError),
}

/// A translucent skin whose sides differ, and a skull: the surfaces of the head on every machine.
pub const SURFACES: [Surface; 2] = {
    const fn face(colour: [u32; 3], opacity: u32) -> Face {
        let [red, green, blue] = colour;
        Face {
            colour: [red << 23, green << 23, blue << 23],
            opacity: Opacity::from_bits(opacity << 23),
        }
    }
    [
        Surface {
            value: 500 << 16,
            front: face([255, 190, 150], 90),
            back: face([120, 30, 40], 40),
        },
        Surface {
            value: (1150 << 16) + 12_345,
            front: face([255, 250, 230], 256),
            back: face([200, 200, 220], 256),
        },
    ]
};

impl SceneData {
    /// The frame's geometry.
    ///
    /// # Errors
    /// [`SceneError`] if the numbers are out of range.
    pub fn plan(&self) -> Result<Plan, SceneError> {
        let view = View::new(self.direction.map(Direction::from_bits)).map_err(SceneError::View)?;
        let [planes_per_voxel, rays_per_voxel] = self.sampling;
        let sampling = Sampling {
            planes_per_voxel,
            rays_per_voxel,
        };
        let spacing = Spacing(self.spacing.map(Intensity::from_bits));
        Plan::whole(view, self.dims, spacing, sampling).map_err(SceneError::Plan)
    }

    /// The map to the viewer's picture.
    pub fn warp(&self) -> Warp {
        let [origin, right, down] = self.warp.map(|v| v.map(Step::from_bits));
        Warp { origin, right, down }
    }
}

/// A table of integrals, whatever the view.
#[derive(Debug)]
pub struct IntegralData {
    /// Integrals of extinction.
    pub extinction: &'static [u32],
    /// Integrals of extinction times red, green, blue; or one colour, 1.31.
    pub colours: Colours<&'static [u32]>,
    /// log2 of the codes of a bin.
    pub grain: u32,
    /// log2 of what the integrals were multiplied by.
    pub exponent: u32,
}

impl IntegralData {
    /// The classifier of a view: only the segments' length depends on it.
    ///
    /// # Errors
    /// [`SceneError::Integral`] if the numbers are no such table.
    pub fn classifier(&self, plan: &Plan) -> Result<Integral<&'static [u32]>, SceneError> {
        Integral::new(
            self.extinction,
            self.colours,
            self.grain,
            self.exponent,
            Length::of(plan),
        )
        .map_err(SceneError::Integral)
    }
}

/// A precision with the table that belongs to it.
pub trait Model: Precision<Pixel: Recurrence<Channel: ChannelFormat>> + Default {
    /// How its table holds opacities.
    type Alpha: AlphaCode;
    /// How samples find entries.
    type Lookup: Lookup;
    /// The table of a scene.
    fn table(scene: &SceneData) -> PointTable<'_, Self::Alpha, Self::Lookup>;
}

impl Model for Paper {
    type Alpha = Sqrt8;
    type Lookup = Nearest;
    fn table(scene: &SceneData) -> PointTable<'_, Sqrt8, Nearest> {
        PointTable::new(scene.entries8, ())
    }
}

impl Model for Compact {
    type Alpha = Sqrt16;
    type Lookup = Linear;
    fn table(scene: &SceneData) -> PointTable<'_, Sqrt16, Linear> {
        PointTable::new(scene.entries16, scene.plane16)
    }
}

impl Model for Wide {
    type Alpha = Colour16;
    type Lookup = Linear;
    fn table(scene: &SceneData) -> PointTable<'_, Colour16, Linear> {
        PointTable::new(scene.entries_wide, (scene.plane16, scene.colours_wide))
    }
}

/// A shader that can be made from a scene.
pub trait Lights<P: Precision>: Shader<P> + Sized {
    /// Its name in reports.
    const NAME: &'static str;
    /// The shader of a scene.
    ///
    /// # Errors
    /// [`SceneError::Phong`] if a number is out of range.
    fn of(precision: P, lighting: &Lighting) -> Result<Self, SceneError>;
}

impl<P: Precision> Lights<P> for Unlit {
    const NAME: &'static str = "unlit";
    fn of(_: P, _: &Lighting) -> Result<Self, SceneError> {
        Ok(Self)
    }
}

impl<P: Precision> Lights<P> for Phong<P> {
    const NAME: &'static str = "lit";
    fn of(precision: P, lighting: &Lighting) -> Result<Self, SceneError> {
        let lights = lighting.lights();
        Self::new(
            precision,
            lighting.ambient.map(Coefficient::from_bits),
            lights.get(..lighting.lights.len()).unwrap_or(&lights),
            lighting.viewer.map(Vector::from_bits),
            lighting.highlight(),
            lighting.exponent_log2,
        )
        .map_err(SceneError::Phong)
    }
}

impl Lighting {
    /// The lights as core takes them; behind them dark ones.
    fn lights(&self) -> [Light; slicecast::shade::LIGHTS_MAX] {
        let dark = Light {
            direction: [Vector::ZERO; 3],
            half: [Vector::ZERO; 3],
            diffuse: [Coefficient::ZERO; 3],
            specular: [Coefficient::ZERO; 3],
        };
        let mut lights = [dark; slicecast::shade::LIGHTS_MAX];
        for (light, (direction, half, diffuse, specular)) in lights.iter_mut().zip(self.lights) {
            *light = Light {
                direction: direction.map(Vector::from_bits),
                half: half.map(Vector::from_bits),
                diffuse: diffuse.map(Coefficient::from_bits),
                specular: specular.map(Coefficient::from_bits),
            };
        }
        lights
    }

    const fn highlight(&self) -> Highlight {
        if self.half_vector {
            Highlight::HalfVector
        } else {
            Highlight::Reflection
        }
    }

    /// The shader of 16-bit lanes.
    ///
    /// # Errors
    /// [`SceneError::Phong`] if a number is out of range.
    pub fn fast(&self) -> Result<FastPhong, SceneError> {
        let lights = self.lights();
        FastPhong::new(
            self.ambient.map(Coefficient::from_bits),
            lights.get(..self.lights.len()).unwrap_or(&lights),
            self.viewer.map(Vector::from_bits),
            self.highlight(),
            self.exponent_log2,
        )
        .map_err(SceneError::Phong)
    }
}

/// The pipeline of a precision and a shader on a point table.
pub type PipelineOf<'a, P, S> = Composite<P, PointTable<'a, <P as Model>::Alpha, <P as Model>::Lookup>, S, FrontToBack>;

/// The pipeline of a scene.
///
/// # Errors
/// [`SceneError::Phong`] if the lights are out of range.
pub fn pipeline<P: Model, S: Lights<P>>(scene: &SceneData) -> Result<PipelineOf<'_, P, S>, SceneError> {
    let precision = P::default();
    Ok(Composite::new(
        precision,
        P::table(scene),
        S::of(precision, &scene.lighting)?,
    ))
}

/// The entry of colour and extinction that stands for a code where a scene's voxels are rendered as such.
pub const fn colour_entry(code: u16) -> u32 {
    let byte = (code >> 4) as u8;
    u32::from_le_bytes([byte, 255 - byte, (code as u8).wrapping_mul(5), byte])
}

/// Their scale, mantissa and exponent: the largest extinction has an optical depth of 1/8 a step.
pub const COLOUR_SCALE: [u32; 2] = [1_073_774_593, 20];

/// The same as core takes it.
///
/// # Errors
/// None: the scale is one.
pub const fn colour_medium() -> Result<Medium, MediumError> {
    let [mantissa, exponent] = COLOUR_SCALE;
    Medium::new(mantissa, exponent)
}

/// The plan and the rays of a scene in perspective: along the axis and sense of its view, from an eye in front of a volume of 64 voxels.
///
/// # Errors
/// [`EyeError`] if the volume is another.
pub fn plan_in_perspective(parallel: &Plan) -> Result<(Plan, Spread), EyeError> {
    let one = Vector::ONE;
    Plan::perspective(
        *parallel.view(),
        parallel.view().restore(parallel.volume()),
        Spacing(parallel.view().restore(parallel.spacing())),
        parallel.sampling(),
        Eye {
            // 20.3, 36.6 and 100 voxels before the first slice.
            position: [87_187_836_109, 157_195_803_034, -429_496_729_600].map(Step::from_bits),
            low: [-one; 2],
            high: [one; 2],
        },
    )
}
