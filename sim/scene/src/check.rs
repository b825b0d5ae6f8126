//! The range of every field of a scene, in one place: scene files and command lines are both held to it.

use std::ops::RangeInclusive;

use thiserror::Error;

use crate::reflectance::SIDES;

use super::{
    Borders, Classification, ColourOpacity, Colours, Image, Interpolation, Light, Lighting, LookupName, PrecisionName,
    Sampling, Scene, TransferFunction, View,
};

/// Angles about an axis, degrees.
pub const TURN: RangeInclusive<f64> = -360.0..=360.0;
/// Angle above the horizon, degrees.
pub const ELEVATION: RangeInclusive<f64> = -90.0..=90.0;
/// Pixels along a side of the image.
pub const IMAGE_SIDE: RangeInclusive<i64> = 1..=16384;
/// Field of view from the top of a picture to its bottom, degrees.
pub const FOV: RangeInclusive<f64> = 5.0..=120.0;
/// Magnification.
pub const ZOOM: RangeInclusive<f64> = 0.01..=100.0;
/// Colours, opacities, coefficients.
pub const FRACTION: RangeInclusive<f64> = 0.0..=1.0;
/// Sample planes per voxel.
pub const PLANES_PER_VOXEL: RangeInclusive<i64> = 1..=16;
/// Rays per voxel and axis.
pub const RAYS_PER_VOXEL: RangeInclusive<i64> = 1..=8;
/// The length that opacities refer to, in the volume's unit.
pub const UNIT_DISTANCE: RangeInclusive<f64> = 1e-6..=1e6;
/// Distances of the opacities of a volume of colours, in its unit, and extinctions per unit.
pub const LENGTHS: RangeInclusive<f64> = 1e-6..=1e6;
/// Data values of a transfer function's points: all of 64-bit integers and of single precision.
pub const VALUE: RangeInclusive<f64> = -1e100..=1e100;
/// Points of a transfer function.
pub const POINTS: RangeInclusive<usize> = 1..=4096;
/// Isosurfaces of a scene.
pub const SURFACES: RangeInclusive<usize> = 0..=256;
/// Lights of a lit scene.
pub const LIGHTS: RangeInclusive<usize> = 1..=8;
/// log2 of the specular exponent.
pub const EXPONENT_LOG2: RangeInclusive<i64> = 0..=8;
/// n of the transparency 2^-n at which rays stop.
pub const EARLY_TERMINATION: RangeInclusive<i64> = 1..=20;

/// A field with a value that no scene can have.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("`{field}` is {value}, expected {expected}")]
pub struct FieldError {
    /// The field's full name, such as `transfer.points[2].opacity`; indices count from 0.
    pub field: String,
    /// The value given.
    pub value: String,
    /// The values accepted.
    pub expected: String,
}

impl FieldError {
    /// Joins the three parts.
    pub(super) fn new(field: &str, value: impl ToString, expected: impl ToString) -> Self {
        Self {
            field: field.to_owned(),
            value: value.to_string(),
            expected: expected.to_string(),
        }
    }
}

/// The most clip planes of a scene.
pub const CLIPS: usize = 6;

impl Scene {
    /// Checks every field; what passes can be rendered.
    ///
    /// # Errors
    /// [`FieldError`] names the first field that is out of range, its value and the range.
    pub fn check(&self) -> Result<(), FieldError> {
        view(&self.view)?;
        self.perspective()?;
        self.fast()?;
        image(&self.image)?;
        sampling(self.sampling)?;
        transfer(&self.transfer)?;
        if let Some(n) = self.early_termination {
            whole("render.early_termination", i64::from(n), EARLY_TERMINATION)?;
        }
        if self.crop.is_some() && self.borders == Borders::Whole {
            let expected = "sampling.borders \"cells\" or \"nodes\": whole borders cut no step";
            return Err(FieldError::new("crop", "given", expected));
        }
        self.clips()?;
        self.cueing()?;
        self.modulation()?;
        self.reflectance()?;
        self.splines()?;
        self.colours()?;
        self.classification()?;
        self.surfaces()?;
        self.lighting.as_ref().map_or(Ok(()), lighting)
    }

    /// In perspective there are samples of the whole volume.
    fn perspective(&self) -> Result<(), FieldError> {
        let Some(perspective) = &self.perspective else {
            return Ok(());
        };
        number("view.fov", perspective.fov, FOV)?;
        if let Some(eye) = perspective.eye.filter(|eye| !eye.is_near()) {
            let shown = format!("{:?}", eye.at);
            return Err(FieldError::new("view.eye", shown, "three numbers from -1e9 to 1e9"));
        }
        self.plain_samples(
            "a view in perspective",
            [
                ("sampling.borders", self.borders == Borders::Whole, "\"whole\""),
                (
                    "sampling.interpolation",
                    self.interpolation == Interpolation::Linear,
                    "\"linear\"",
                ),
                ("crop", self.crop.is_none(), "no crop box"),
            ],
        )
    }

    /// In 16-bit lanes there are samples of parallel rays, linear in the table, which nothing clips.
    fn fast(&self) -> Result<(), FieldError> {
        if self.precision != PrecisionName::Fast {
            return Ok(());
        }
        self.plain_samples(
            "precision \"fast\"",
            [
                (
                    "sampling.interpolation",
                    self.interpolation != Interpolation::Quadratic,
                    "\"linear\" or \"nearest\"",
                ),
                ("view.projection", self.perspective.is_none(), "\"parallel\""),
                (
                    "render.lookup",
                    self.lookup.is_none_or(|lookup| lookup == LookupName::Linear),
                    "\"linear\"",
                ),
            ],
        )
    }

    /// That there are samples of values, which nothing clips, turns or modulates, and what is asked besides.
    fn plain_samples<const N: usize>(&self, who: &str, besides: [(&str, bool, &str); N]) -> Result<(), FieldError> {
        let segments = !matches!(self.classification, Classification::Point) || !self.surfaces.is_empty();
        let common = [
            ("clip", self.clips.is_empty(), "no clip planes"),
            ("cueing", self.cueing.is_none(), "no depth cueing"),
            ("modulation", self.modulation.is_none(), "no modulation"),
            ("reflectance", self.reflectance.is_none(), "no reflectance map"),
            ("colours", self.colours.is_none(), "a volume of one value a voxel"),
            ("render.classification", !segments, "\"point\", without surfaces"),
        ];
        match besides.into_iter().chain(common).find(|(_, known, _)| !known) {
            Some((field, _, expected)) => {
                let expected = format!("{expected}: {who} knows no other");
                Err(FieldError::new(field, "given", expected))
            }
            None => Ok(()),
        }
    }

    fn cueing(&self) -> Result<(), FieldError> {
        let Some(cueing) = self.cueing else { return Ok(()) };
        let named = |(name, value, expected)| FieldError::new(&format!("cueing.{name}"), value, expected);
        cueing.check().map_err(named)?;
        if !self.blend.is_composited() {
            let expected = "render.blend \"front_to_back\" or \"back_to_front\": a projection has no depth";
            return Err(FieldError::new("cueing", "given", expected));
        }
        Ok(())
    }

    /// Modulation is of composited samples.
    fn modulation(&self) -> Result<(), FieldError> {
        let Some(modulation) = &self.modulation else {
            return Ok(());
        };
        let named =
            |(name, value, expected): (String, _, _)| FieldError::new(&format!("modulation.{name}"), value, expected);
        modulation.check().map_err(named)?;
        let expected = if !self.blend.is_composited() {
            "render.blend \"front-to-back\" or \"back-to-front\": a projection has neither opacities of steps nor light"
        } else if self.colours.is_some() {
            "a scene of values, not of [colours]"
        } else if self.classification != Classification::Point {
            "render.classification \"point\", without surfaces: a segment has two gradients"
        } else if self.interpolation == Interpolation::Quadratic {
            "sampling.interpolation \"linear\" or \"nearest\""
        } else if self.lighting.is_none() && modulation.lights() {
            "[lighting]: without it there is no light to modulate, and opacity alone can be"
        } else {
            return Ok(());
        };
        Err(FieldError::new("modulation", "given", expected))
    }

    /// A reflectance map is of lit samples that are composited.
    fn reflectance(&self) -> Result<(), FieldError> {
        let Some(map) = &self.reflectance else {
            return Ok(());
        };
        whole("reflectance.side", i64::from(map.side), SIDES)?;
        let expected = if !self.blend.is_composited() {
            "render.blend \"front-to-back\" or \"back-to-front\": a projection has no light"
        } else if self.colours.is_some() {
            "a scene of values, not of [colours]"
        } else if self.classification != Classification::Point {
            "render.classification \"point\", without surfaces"
        } else if self.modulation.is_some() {
            "no [modulation], which weighs each light by itself"
        } else if self.interpolation == Interpolation::Quadratic {
            "sampling.interpolation \"linear\" or \"nearest\""
        } else if self.lighting.is_none() {
            "[lighting]: without it there is no light to look up"
        } else {
            return Ok(());
        };
        Err(FieldError::new("reflectance", "given", expected))
    }

    fn clips(&self) -> Result<(), FieldError> {
        if self.clips.len() > CLIPS {
            return Err(FieldError::new("clip", self.clips.len(), "at most 6 planes"));
        }
        for (i, clip) in self.clips.iter().enumerate() {
            let named = |(name, value, expected): (&str, String, &str)| {
                FieldError::new(&format!("clip[{i}].{name}"), value, expected)
            };
            clip.check().map_err(named)?;
        }
        Ok(())
    }

    /// Splines are of composited samples.
    fn splines(&self) -> Result<(), FieldError> {
        if self.interpolation != Interpolation::Quadratic || self.blend.is_composited() {
            return Ok(());
        }
        let expected =
            "\"linear\" or \"nearest\" under a projection, or render.blend \"front-to-back\" or \"back-to-front\"";
        Err(FieldError::new("sampling.interpolation", "\"quadratic\"", expected))
    }

    /// What classifies values has no place beside colours, nor what samples colours beside values.
    fn colours(&self) -> Result<(), FieldError> {
        let Some(colours) = self.colours else {
            return Ok(());
        };
        let Colours {
            alpha_distance,
            tau_max,
            opacity,
        } = colours;
        for (name, length) in [("colours.alpha_distance", alpha_distance), ("colours.tau_max", tau_max)] {
            length.map_or(Ok(()), |length| number(name, length, LENGTHS))?;
        }
        if let Some(ColourOpacity::Constant(opacity)) = opacity {
            number("colours.opacity", opacity, FRACTION)?;
        }
        let stated = [
            ("surface", !self.surfaces.is_empty()),
            ("render.classification", self.classification != Classification::Point),
            ("render.table", self.table.is_some()),
            ("render.lookup", self.lookup.is_some()),
            ("render.pieces", self.pieces != 1),
        ];
        match stated.into_iter().find(|(_, stated)| *stated) {
            Some((field, _)) => Err(FieldError::new(
                field,
                "given",
                "nothing beside [colours]: it classifies values",
            )),
            None => Ok(()),
        }
    }

    /// Segments need rays that are composited and values between voxels, and surfaces need segments.
    fn classification(&self) -> Result<(), FieldError> {
        let (given, needs) = match self.classification {
            Classification::Integral if self.surfaces.is_empty() => ("\"integral\"", "\"point\""),
            Classification::Integral => ("\"integral\"", "no [[surface]], and \"point\""),
            Classification::None if self.surfaces.is_empty() => {
                let expected = "a [[surface]], or \"point\", \"integral\", \"auto\": nothing would be drawn";
                return Err(FieldError::new("render.classification", "\"none\"", expected));
            }
            Classification::None => ("\"none\"", "no [[surface]]"),
            Classification::Point if !self.surfaces.is_empty() => {
                let expected = "\"integral\" beside surfaces, or \"none\" for surfaces alone: surfaces cut segments";
                return Err(FieldError::new("render.classification", "\"point\"", expected));
            }
            Classification::Auto if !self.surfaces.is_empty() => ("\"auto\"", "no [[surface]]"),
            Classification::Point | Classification::Auto => return Ok(()),
        };
        let refused = |why: &str| {
            Err(FieldError::new(
                "render.classification",
                given,
                format!("{needs} {why}"),
            ))
        };
        if !self.blend.is_composited() {
            return refused("under a projection, which keeps single samples");
        }
        if self.interpolation == Interpolation::Nearest {
            return refused("with nearest interpolation: between labels lie values that no voxel has");
        }
        if self.interpolation == Interpolation::Quadratic {
            return refused("with quadratic interpolation: segments lie between linear samples");
        }
        Ok(())
    }

    fn surfaces(&self) -> Result<(), FieldError> {
        if !matches!(self.pieces, 1 | 2 | 4) {
            return Err(FieldError::new("render.pieces", self.pieces, PIECES));
        }
        count("surface", self.surfaces.len(), SURFACES)?;
        for (i, surface) in self.surfaces.iter().enumerate() {
            let name = |part: &str| format!("surface[{i}].{part}");
            number(&name("value"), surface.value, VALUE)?;
            colour(&name("colour"), surface.front.colour)?;
            number(&name("opacity"), surface.front.opacity, FRACTION)?;
            colour(&name("back_colour"), surface.back.colour)?;
            number(&name("back_opacity"), surface.back.opacity, FRACTION)?;
        }
        Ok(())
    }
}

/// The pieces that a file may state.
pub(super) const PIECES: &str = "1, 2 or 4";

fn view(view: &View) -> Result<(), FieldError> {
    number("view.azimuth", view.azimuth, TURN)?;
    number("view.elevation", view.elevation, ELEVATION)?;
    number("view.roll", view.roll, TURN)
}

fn image(image: &Image) -> Result<(), FieldError> {
    for (i, side) in image.size.iter().flatten().enumerate() {
        whole(&format!("image.size[{i}]"), i64::from(*side), IMAGE_SIDE)?;
    }
    number("image.zoom", image.zoom, ZOOM)?;
    colour("image.background", image.background)
}

fn sampling(sampling: Sampling) -> Result<(), FieldError> {
    whole(
        "sampling.planes_per_voxel",
        i64::from(sampling.planes_per_voxel),
        PLANES_PER_VOXEL,
    )?;
    whole(
        "sampling.rays_per_voxel",
        i64::from(sampling.rays_per_voxel),
        RAYS_PER_VOXEL,
    )?;
    Ok(())
}

pub(super) fn transfer(transfer: &TransferFunction) -> Result<(), FieldError> {
    number("transfer.unit_distance", transfer.unit_distance, UNIT_DISTANCE)?;
    count("transfer.points", transfer.points.len(), POINTS)?;
    for (i, point) in transfer.points.iter().enumerate() {
        let name = |part: &str| format!("transfer.points[{i}].{part}");
        number(&name("value"), point.value, VALUE)?;
        colour(&name("colour"), point.colour)?;
        number(&name("opacity"), point.opacity, FRACTION)?;
    }
    for (i, pair) in transfer.points.windows(2).enumerate() {
        if pair[1].value < pair[0].value {
            let expected = format!("{} or more: points ascend", pair[0].value);
            return Err(FieldError::new(
                &format!("transfer.points[{}].value", i + 1),
                pair[1].value,
                expected,
            ));
        }
    }
    for (i, three) in transfer.points.windows(3).enumerate() {
        if three[2].value == three[0].value {
            let expected = "at most two points of a value: the one between would never be seen";
            return Err(FieldError::new(
                &format!("transfer.points[{}].value", i + 2),
                three[2].value,
                expected,
            ));
        }
    }
    Ok(())
}

pub(super) fn lighting(lighting: &Lighting) -> Result<(), FieldError> {
    number("lighting.ambient", lighting.ambient, FRACTION)?;
    number("lighting.diffuse", lighting.diffuse, FRACTION)?;
    number("lighting.specular", lighting.specular, FRACTION)?;
    if !EXPONENT_LOG2.contains(&i64::from(lighting.exponent_log2)) {
        let value = format!("2^{}", lighting.exponent_log2);
        return Err(FieldError::new("lighting.exponent", value, EXPONENTS));
    }
    count("lighting.lights", lighting.lights.len(), LIGHTS)?;
    lighting
        .lights
        .iter()
        .enumerate()
        .try_for_each(|(i, one)| light(i, one))
}

fn light(i: usize, light: &Light) -> Result<(), FieldError> {
    let length = light.direction.iter().map(|c| c * c).sum::<f64>().sqrt();
    if !(1.0 - 1e-9..=1.0 + 1e-9).contains(&length) {
        let value = format!("{:?}", light.direction);
        return Err(FieldError::new(
            &format!("lighting.lights[{i}].direction"),
            value,
            "a unit vector",
        ));
    }
    colour(&format!("lighting.lights[{i}].colour"), light.colour)
}

/// The exponents that a file may state.
pub(super) const EXPONENTS: &str = "a power of two from 1 to 256";

/// A number in a range; NaN is in none.
pub(super) fn number(field: &str, value: f64, range: RangeInclusive<f64>) -> Result<(), FieldError> {
    if range.contains(&value) {
        return Ok(());
    }
    let expected = format!("a number from {} to {}", shown(*range.start()), shown(*range.end()));
    Err(FieldError::new(field, shown(value), expected))
}

/// A number for a message: one of very many digits with its exponent.
pub fn shown(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        v if !(1e-6..1e15).contains(&v) && v.is_finite() => format!("{value:e}"),
        _ => value.to_string(),
    }
}

/// A whole number in a range that fits 32 bits.
pub(super) fn whole(field: &str, value: i64, range: RangeInclusive<i64>) -> Result<u32, FieldError> {
    match u32::try_from(value) {
        Ok(small) if range.contains(&value) => Ok(small),
        _ => {
            let expected = format!("a whole number from {} to {}", range.start(), range.end());
            Err(FieldError::new(field, value, expected))
        }
    }
}

/// The length of a list.
fn count(field: &str, len: usize, range: RangeInclusive<usize>) -> Result<(), FieldError> {
    if range.contains(&len) {
        return Ok(());
    }
    let value = format!("a list of {len}");
    Err(FieldError::new(
        field,
        value,
        format!("{} to {} entries", range.start(), range.end()),
    ))
}

/// Red, green, blue.
fn colour(field: &str, rgb: [f64; 3]) -> Result<(), FieldError> {
    if rgb.iter().all(|channel| FRACTION.contains(channel)) {
        return Ok(());
    }
    Err(FieldError::new(field, format!("{rgb:?}"), COLOURS))
}

/// The colours that a file may state.
pub(super) const COLOURS: &str = "\"#rrggbb\" or three numbers from 0 to 1";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file;

    /// Changes the default scene as a command line would and returns the field that is refused.
    fn refused(change: impl Fn(&mut Scene, &mut Lighting)) -> String {
        let mut scene = file::built_in(file::DEFAULT).unwrap();
        let mut lighting = scene.lighting.clone().unwrap();
        change(&mut scene, &mut lighting);
        scene.lighting = Some(lighting);
        scene.check().unwrap_err().field
    }

    #[test]
    fn scenes_changed_in_memory_are_held_to_the_same_ranges() {
        assert_eq!(refused(|_, l| l.exponent_log2 = 9), "lighting.exponent");
        assert_eq!(
            refused(|_, l| l.lights[1].direction = [0.0, 0.0, 1.001]),
            "lighting.lights[1].direction"
        );
        assert_eq!(
            refused(|_, l| l.lights[1].direction = [f64::NAN; 3]),
            "lighting.lights[1].direction"
        );
        assert_eq!(refused(|_, l| l.lights.clear()), "lighting.lights");
        assert_eq!(refused(|s, _| s.view.azimuth = f64::NAN), "view.azimuth");
        assert_eq!(refused(|s, _| s.image.size = Some([1, u32::MAX])), "image.size[1]");
        assert_eq!(
            refused(|s, _| s.sampling.planes_per_voxel = 0),
            "sampling.planes_per_voxel"
        );
        assert_eq!(
            refused(|s, _| s.early_termination = Some(21)),
            "render.early_termination"
        );
        assert_eq!(refused(|s, _| s.transfer.points.swap(0, 1)), "transfer.points[1].value");
    }

    #[test]
    fn values_of_64_bits_can_be_stated_and_those_beyond_are_shown_in_few_digits() {
        let mut scene = file::built_in(file::DEFAULT).unwrap();
        let last = scene.transfer.points.len() - 1;
        let mut stated = |value| {
            scene.transfer.points[last].value = value;
            scene.check().map_err(|error| error.to_string())
        };
        assert_eq!(stated(u64::MAX as f64), Ok(()));
        assert_eq!(stated(f64::from(f32::MAX)), Ok(()));
        let expected = format!("`transfer.points[{last}].value` is 2.5e120, expected a number from -1e100 to 1e100");
        assert_eq!(stated(2.5e120), Err(expected));
        let numbers = [0.0, -0.5, 100.0, 1e-320, f64::INFINITY, 1e15].map(shown);
        assert_eq!(numbers, ["0", "-0.5", "100", "1e-320", "inf", "1e15"]);
    }
}
