//! The tables of a scene file as TOML holds them, and the defaults of what is left out.
//!
//! Whole numbers are read as `i64`, so that a negative one is refused with its field's range.

use serde::Deserialize;

use crate::check::{
    COLOURS, EARLY_TERMINATION, EXPONENTS, FieldError, IMAGE_SIDE, PIECES, PLANES_PER_VOXEL, RAYS_PER_VOXEL, whole,
};
use crate::clip::{Clip, ClipUnit};
use crate::colour::Colour;
use crate::crop::{Crop, CropUnit, parse_range};
use crate::cueing::Cueing;
use crate::modulation::Modulation;
use crate::perspective::{Eye, FOV, Perspective, Projection};
use crate::reflectance::{Filter, Reflectance, SIDES};
use crate::{
    AlphaCodeName, Blend, Borders, Classification, ColourOpacity, Colours, Face, Frame, Highlight, Image,
    Interpolation, Light, Lighting, LookupName, Point, PrecisionName, Sampling, Scene, Surface, TransferFunction, View,
};

/// A whole scene file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneFile {
    #[serde(default)]
    view: ViewPart,
    #[serde(default)]
    image: ImagePart,
    #[serde(default)]
    sampling: SamplingPart,
    crop: Option<CropPart>,
    #[serde(default)]
    clip: Vec<ClipPart>,
    cueing: Option<CueingPart>,
    modulation: Option<ModulationPart>,
    reflectance: Option<ReflectancePart>,
    transfer: Option<TransferPart>,
    colours: Option<ColoursPart>,
    #[serde(default)]
    surface: Vec<SurfacePart>,
    lighting: Option<LightingPart>,
    #[serde(default)]
    render: RenderPart,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct ViewPart {
    azimuth: Option<f64>,
    elevation: Option<f64>,
    roll: Option<f64>,
    #[serde(default)]
    projection: Projection,
    fov: Option<f64>,
    eye: Option<[f64; 3]>,
    unit: Option<ClipUnit>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct ImagePart {
    size: Option<[i64; 2]>,
    zoom: Option<f64>,
    background: Option<Colour>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct SamplingPart {
    planes_per_voxel: Option<i64>,
    rays_per_voxel: Option<i64>,
    interpolation: Option<Interpolation>,
    borders: Option<Borders>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CropPart {
    x: Option<String>,
    y: Option<String>,
    z: Option<String>,
    unit: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ClipPart {
    point: [f64; 3],
    normal: [f64; 3],
    thickness: Option<f64>,
    #[serde(default)]
    falloff: f64,
    #[serde(default)]
    keep: Keep,
    #[serde(default)]
    unit: ClipUnit,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CueingPart {
    from: Option<f64>,
    to: Option<f64>,
    strength: Option<f64>,
    colour: Option<Colour>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ModulationPart {
    #[serde(default)]
    opacity: Vec<[f64; 2]>,
    #[serde(default)]
    diffuse: Vec<[f64; 2]>,
    #[serde(default)]
    specular: Vec<[f64; 2]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ReflectancePart {
    side: i64,
    #[serde(default)]
    filter: Filter,
}

/// Which side of a clip plane's faces is drawn.
#[derive(Default, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Keep {
    #[default]
    Inside,
    Outside,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TransferPart {
    unit_distance: Option<f64>,
    points: Vec<PointPart>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ColoursPart {
    alpha_distance: Option<f64>,
    tau_max: Option<f64>,
    opacity: Option<OpacityPart>,
}

/// A number, or a rule's name.
#[derive(Deserialize)]
#[serde(untagged)]
enum OpacityPart {
    Number(f64),
    Text(String),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PointPart {
    value: f64,
    colour: Colour,
    opacity: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SurfacePart {
    value: f64,
    colour: Option<Colour>,
    opacity: Option<f64>,
    back_colour: Option<Colour>,
    back_opacity: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LightingPart {
    ambient: Option<f64>,
    diffuse: Option<f64>,
    specular: Option<f64>,
    exponent: Option<i64>,
    highlight: Option<Highlight>,
    lights: Option<Vec<LightPart>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LightPart {
    direction: [f64; 3],
    frame: Option<Frame>,
    colour: Option<Colour>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct RenderPart {
    blend: Option<Blend>,
    precision: Option<PrecisionName>,
    table: Option<AlphaCodeName>,
    lookup: Option<LookupName>,
    early_termination: Option<i64>,
    classification: Option<Classification>,
    pieces: Option<i64>,
}

impl SceneFile {
    /// Fills in the defaults; ranges are left to [`Scene::check`] where the scene's types can hold a wrong value.
    pub fn into_scene(self) -> Result<Scene, FieldError> {
        let early_termination = self.render.early_termination;
        let early_termination = early_termination
            .map(|n| whole("render.early_termination", n, EARLY_TERMINATION))
            .transpose()?;
        let surfaces = (self.surface.into_iter().enumerate())
            .map(SurfacePart::into_surface)
            .collect::<Result<Vec<_>, _>>()?;
        // What a file states decides what it leaves out: surfaces cut segments, and without a transfer function they are alone.
        let unstated = match (surfaces.is_empty(), &self.transfer) {
            (true, _) => Classification::Point,
            (false, Some(_)) => Classification::Integral,
            (false, None) => Classification::None,
        };
        let classification = self.render.classification.unwrap_or(unstated);
        let colours = self.colours.map(ColoursPart::into_colours).transpose()?;
        let transfer = match self.transfer {
            Some(_) if colours.is_some() => {
                let expected = "one of [transfer], which classifies values, and [colours]";
                return Err(FieldError::new("transfer", "given beside [colours]", expected));
            }
            Some(transfer) => transfer.into_transfer()?,
            None if colours.is_some() => TransferFunction::clear(),
            None if classification == Classification::None => TransferFunction::clear(),
            None => {
                let expected = "a table, or [[surface]]s alone, or [colours] of a volume of colours";
                return Err(FieldError::new("transfer", "missing", expected));
            }
        };
        let pieces = self.render.pieces.unwrap_or(1);
        let pieces = u32::try_from(pieces).map_err(|_| FieldError::new("render.pieces", pieces, PIECES))?;
        let perspective = self.view.perspective(self.sampling.borders)?;
        let whole = perspective.map(|_| Borders::Whole);
        Ok(Scene {
            view: self.view.into_view(),
            perspective,
            image: self.image.into_image()?,
            interpolation: self.sampling.interpolation.unwrap_or_default(),
            borders: whole.or(self.sampling.borders).unwrap_or_default(),
            crop: self.crop.map(CropPart::into_crop).transpose()?,
            clips: self.clip.into_iter().map(ClipPart::into_clip).collect(),
            cueing: self.cueing.map(CueingPart::into_cueing).transpose()?,
            modulation: self.modulation.map(ModulationPart::into_modulation),
            reflectance: self.reflectance.map(ReflectancePart::into_reflectance).transpose()?,
            sampling: self.sampling.into_sampling()?,
            transfer,
            lighting: self.lighting.map(LightingPart::into_lighting).transpose()?,
            blend: self.render.blend.unwrap_or(Blend::FrontToBack),
            precision: self.render.precision.unwrap_or(PrecisionName::Compact),
            table: self.render.table,
            lookup: self.render.lookup,
            early_termination,
            classification,
            pieces,
            surfaces,
            colours,
        })
    }
}

impl ColoursPart {
    fn into_colours(self) -> Result<Colours, FieldError> {
        let opacity = |part| match part {
            OpacityPart::Number(opacity) => Ok(ColourOpacity::Constant(opacity)),
            OpacityPart::Text(text) if text == "luminance" => Ok(ColourOpacity::Luminance),
            OpacityPart::Text(text) => {
                let expected = "\"luminance\", or a number from 0 to 1";
                Err(FieldError::new("colours.opacity", format!("{text:?}"), expected))
            }
        };
        Ok(Colours {
            alpha_distance: self.alpha_distance,
            tau_max: self.tau_max,
            opacity: self.opacity.map(opacity).transpose()?,
        })
    }
}

impl ViewPart {
    /// Rays from an eye, whose borders are whole.
    fn perspective(&self, borders: Option<Borders>) -> Result<Option<Perspective>, FieldError> {
        if self.projection == Projection::Parallel {
            let stated = [
                ("view.fov", self.fov.is_some()),
                ("view.eye", self.eye.is_some()),
                ("view.unit", self.unit.is_some()),
            ];
            return match stated.into_iter().find(|(_, stated)| *stated) {
                Some((field, _)) => Err(FieldError::new(field, "given", "view.projection \"perspective\"")),
                None => Ok(None),
            };
        }
        if borders.is_some_and(|borders| borders != Borders::Whole) {
            let expected = "\"whole\", or nothing: in perspective borders are whole";
            return Err(FieldError::new("sampling.borders", "exact", expected));
        }
        let unit = self.unit.unwrap_or_default();
        Ok(Some(Perspective {
            fov: self.fov.unwrap_or(FOV),
            eye: self.eye.map(|at| Eye { at, unit }),
        }))
    }

    fn into_view(self) -> View {
        let default = View::default();
        View {
            azimuth: self.azimuth.unwrap_or(default.azimuth),
            elevation: self.elevation.unwrap_or(default.elevation),
            roll: self.roll.unwrap_or(default.roll),
        }
    }
}

impl ImagePart {
    fn into_image(self) -> Result<Image, FieldError> {
        let default = Image::default();
        let side = |[x, y]: [i64; 2]| {
            Ok::<_, FieldError>([
                whole("image.size[0]", x, IMAGE_SIDE)?,
                whole("image.size[1]", y, IMAGE_SIDE)?,
            ])
        };
        Ok(Image {
            size: self.size.map(side).transpose()?,
            zoom: self.zoom.unwrap_or(default.zoom),
            background: colour_or("image.background", self.background, default.background)?,
        })
    }
}

impl SamplingPart {
    fn into_sampling(self) -> Result<Sampling, FieldError> {
        let default = Sampling::default();
        let planes = self.planes_per_voxel.unwrap_or(i64::from(default.planes_per_voxel));
        let rays = self.rays_per_voxel.unwrap_or(i64::from(default.rays_per_voxel));
        Ok(Sampling {
            planes_per_voxel: whole("sampling.planes_per_voxel", planes, PLANES_PER_VOXEL)?,
            rays_per_voxel: whole("sampling.rays_per_voxel", rays, RAYS_PER_VOXEL)?,
        })
    }
}

impl CropPart {
    fn into_crop(self) -> Result<Crop, FieldError> {
        let range = |name: &str, range: Option<String>| {
            let Some(range) = range else {
                return Ok([f64::NEG_INFINITY, f64::INFINITY]);
            };
            let expected = "a range such as \"10:40.5\", \":40\" or \"10:\", its first end below its second";
            parse_range(&range).map_err(|_| FieldError::new(&format!("crop.{name}"), format!("{range:?}"), expected))
        };
        let unit = match self.unit.as_deref() {
            None | Some("voxels") => CropUnit::Voxels,
            Some("mm") => CropUnit::Millimetres,
            Some(other) => {
                return Err(FieldError::new(
                    "crop.unit",
                    format!("{other:?}"),
                    "\"voxels\" or \"mm\"",
                ));
            }
        };
        Ok(Crop {
            ranges: [range("x", self.x)?, range("y", self.y)?, range("z", self.z)?],
            unit,
        })
    }
}

impl ClipPart {
    fn into_clip(self) -> Clip {
        Clip {
            point: self.point,
            normal: self.normal,
            thickness: self.thickness,
            falloff: self.falloff,
            outside: matches!(self.keep, Keep::Outside),
            unit: self.unit,
        }
    }
}

impl CueingPart {
    fn into_cueing(self) -> Result<Cueing, FieldError> {
        let default = Cueing::default();
        Ok(Cueing {
            from: self.from.unwrap_or(default.from),
            to: self.to.unwrap_or(default.to),
            strength: self.strength.unwrap_or(default.strength),
            colour: colour_or("cueing.colour", self.colour, default.colour)?,
        })
    }
}

impl ReflectancePart {
    fn into_reflectance(self) -> Result<Reflectance, FieldError> {
        Ok(Reflectance {
            side: whole("reflectance.side", self.side, SIDES)?,
            filter: self.filter,
        })
    }
}

impl ModulationPart {
    fn into_modulation(self) -> Modulation {
        Modulation {
            opacity: self.opacity,
            diffuse: self.diffuse,
            specular: self.specular,
        }
    }
}

impl TransferPart {
    fn into_transfer(self) -> Result<TransferFunction, FieldError> {
        let point = |(i, point): (usize, PointPart)| {
            let colour = colour_of(&format!("transfer.points[{i}].colour"), &point.colour)?;
            Ok(Point {
                value: point.value,
                colour,
                opacity: point.opacity,
            })
        };
        let points = self
            .points
            .into_iter()
            .enumerate()
            .map(point)
            .collect::<Result<_, FieldError>>()?;
        Ok(TransferFunction {
            unit_distance: self.unit_distance.unwrap_or(1.0),
            points,
        })
    }
}

impl SurfacePart {
    /// The back is like the front where nothing else is said.
    fn into_surface((i, part): (usize, Self)) -> Result<Surface, FieldError> {
        let default = Face::default();
        let colour = colour_or(&format!("surface[{i}].colour"), part.colour, default.colour)?;
        let opacity = part.opacity.unwrap_or(default.opacity);
        Ok(Surface {
            value: part.value,
            front: Face { colour, opacity },
            back: Face {
                colour: colour_or(&format!("surface[{i}].back_colour"), part.back_colour, colour)?,
                opacity: part.back_opacity.unwrap_or(opacity),
            },
        })
    }
}

impl LightingPart {
    fn into_lighting(self) -> Result<Lighting, FieldError> {
        let default = Lighting::default();
        let exponent_log2 = match self.exponent {
            None => default.exponent_log2,
            Some(exponent) => exponent_log2(exponent)?,
        };
        let lights = match self.lights {
            None => default.lights,
            Some(lights) => lights
                .into_iter()
                .enumerate()
                .map(LightPart::into_light)
                .collect::<Result<_, _>>()?,
        };
        Ok(Lighting {
            ambient: self.ambient.unwrap_or(default.ambient),
            diffuse: self.diffuse.unwrap_or(default.diffuse),
            specular: self.specular.unwrap_or(default.specular),
            exponent_log2,
            highlight: self.highlight.unwrap_or(default.highlight),
            lights,
        })
    }
}

impl LightPart {
    fn into_light((i, part): (usize, Self)) -> Result<Light, FieldError> {
        let field = format!("lighting.lights[{i}].direction");
        let towards = Light::towards(part.direction).ok_or_else(|| {
            FieldError::new(
                &field,
                format!("{:?}", part.direction),
                "three finite numbers, not all of them 0",
            )
        })?;
        let colour = colour_or(&format!("lighting.lights[{i}].colour"), part.colour, towards.colour)?;
        Ok(Light {
            frame: part.frame.unwrap_or(towards.frame),
            colour,
            ..towards
        })
    }
}

/// log2 of an exponent that is a power of two from 1 to 256.
fn exponent_log2(exponent: i64) -> Result<u32, FieldError> {
    match u32::try_from(exponent) {
        Ok(small) if small.is_power_of_two() && small <= 256 => Ok(small.ilog2()),
        _ => Err(FieldError::new("lighting.exponent", exponent, EXPONENTS)),
    }
}

/// A colour as numbers.
fn colour_of(field: &str, colour: &Colour) -> Result<[f64; 3], FieldError> {
    let text = |colour: &Colour| match colour {
        Colour::Text(text) => format!("{text:?}"),
        Colour::Numbers(rgb) => format!("{rgb:?}"),
    };
    colour
        .rgb()
        .ok_or_else(|| FieldError::new(field, text(colour), COLOURS))
}

/// A colour as numbers, or the default.
fn colour_or(field: &str, colour: Option<Colour>, default: [f64; 3]) -> Result<[f64; 3], FieldError> {
    colour.map_or(Ok(default), |colour| colour_of(field, &colour))
}
