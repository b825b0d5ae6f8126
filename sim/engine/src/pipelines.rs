//! From a scene to one of core's pipeline types: the one place where run-time choices become types.

use slicecast::classify::Classifier;
use slicecast::composite::{BackToFront, ChannelFormat, FrontToBack, Recurrence};
use slicecast::modulate::{Modulated, Modulation};
use slicecast::perspective::Spread;
use slicecast::plane::{Composite, Perspective, Project, ProjectFromEye, Splines};
use slicecast::precision::Precision;
#[doc(hidden)]
pub use slicecast::precision::{Compact, Fast, Paper, Wide};
use slicecast::project::{Maximum, Minimum, Sum};
use slicecast::shade::{Shader, Unlit};

use crate::camera::Material;
use crate::error::CameraError;
use crate::expanded::Expanded;
use crate::fast;
use crate::geometry::Geometry;
use crate::parameters::Parameters;
use crate::reflectance;
use crate::rendering::Framing;
use crate::rendering::under;
use crate::segments::Segments;
use crate::table::{Correction, Table, has_fine_colours};
#[doc(hidden)]
pub use slicecast_scene::PrecisionName;
use slicecast_scene::{AlphaCodeName, Blend, Interpolation, Scene};
use slicecast_volume::Mapping;

/// Evaluates an expression with the precision of a name, of those in 32-bit lanes: `fast` has been refused before, or taken its own
/// way.
#[macro_export]
macro_rules! with_precision {
    ($name:expr, $precision:ident => $with:expr) => {
        match $name {
            $crate::pipelines::PrecisionName::Paper => {
                let $precision = $crate::pipelines::Paper;
                $with
            }
            $crate::pipelines::PrecisionName::Compact => {
                let $precision = $crate::pipelines::Compact;
                $with
            }
            $crate::pipelines::PrecisionName::Wide => {
                let $precision = $crate::pipelines::Wide;
                $with
            }
            $crate::pipelines::PrecisionName::Fast => unreachable!("fast has no stages in 32-bit lanes"),
        }
    };
}

/// Evaluates an expression with the format of a precision's pixel.
#[macro_export]
macro_rules! with_pixel {
    ($name:expr, $precision:ident => $with:expr) => {
        match $name {
            $crate::pipelines::PrecisionName::Fast => {
                let $precision = $crate::pipelines::Fast;
                $with
            }
            name => $crate::with_precision!(name, $precision => $with),
        }
    };
}

/// The table of a scene: opacities corrected for the step, or as written where rays are not composited.
pub fn compile(scene: &Scene, mapping: &Mapping, step_length: f64) -> Table {
    let correction = match scene.blend {
        Blend::FrontToBack | Blend::BackToFront => Correction::Step(step_length),
        Blend::Maximum | Blend::Minimum | Blend::Average | Blend::Additive => Correction::None,
    };
    let code = scene.table.unwrap_or_else(|| {
        let fine = scene.precision.table() == AlphaCodeName::Sqrt16 && has_fine_colours(&scene.transfer, mapping);
        if fine {
            AlphaCodeName::Colour16
        } else {
            scene.precision.table()
        }
    });
    let lookup = scene.lookup.unwrap_or(scene.precision.lookup());
    Table::compile(&scene.transfer, mapping, correction, code, lookup)
}

/// The rendering of a scene.
///
/// # Errors
/// [`CameraError`] if the material or the reflectance map is not one that has been checked.
pub fn rendering(
    scene: &Scene,
    table: &Table,
    parameters: Parameters<'_>,
    geometry: Geometry<'_>,
) -> Result<Box<dyn Framing>, CameraError> {
    if scene.precision == PrecisionName::Fast {
        return fast::rendering(scene, table, parameters, geometry);
    }
    rendering_over(scene.precision, scene, table.expanded(), parameters, geometry)
}

/// The rendering of a scene in a precision, over a table.
///
/// # Errors
/// As [`rendering`].
pub fn rendering_over(
    precision: PrecisionName,
    scene: &Scene,
    table: Expanded,
    parameters: Parameters<'_>,
    geometry: Geometry<'_>,
) -> Result<Box<dyn Framing>, CameraError> {
    with_precision!(precision, precision => of_precision(precision, scene, table, parameters, geometry))
}

/// The rendering of a composited scene whose segments are classified.
///
/// # Errors
/// As [`rendering`].
pub fn rendering_of_segments(
    scene: &Scene,
    segments: &Segments,
    parameters: Parameters<'_>,
    geometry: Geometry<'_>,
) -> Result<Box<dyn Framing>, CameraError> {
    let back_to_front = scene.blend == Blend::BackToFront;
    with_precision!(scene.precision, p => composited(p, scene, segments.clone(), parameters, geometry, back_to_front))
}

fn of_precision<P: Precision<Pixel: Recurrence<Channel: ChannelFormat>>>(
    precision: P,
    scene: &Scene,
    table: Expanded,
    parameters: Parameters<'_>,
    geometry: Geometry<'_>,
) -> Result<Box<dyn Framing>, CameraError> {
    if let Some(spread) = parameters.spread {
        let sum = match scene.blend {
            Blend::FrontToBack | Blend::BackToFront => {
                return in_perspective(precision, scene, table, (parameters.material, spread), geometry);
            }
            Blend::Maximum => {
                let pipeline = Project::<_, _, Maximum>::new(precision, table);
                return Ok(under(geometry, ProjectFromEye::new(pipeline, *spread)));
            }
            Blend::Minimum => {
                let pipeline = Project::<_, _, Minimum>::new(precision, table);
                return Ok(under(geometry, ProjectFromEye::new(pipeline, *spread)));
            }
            Blend::Average => Sum::Average,
            Blend::Additive => parameters.additive,
        };
        let pipeline = Project::of(precision, table, sum);
        return Ok(under(geometry, ProjectFromEye::new(pipeline, *spread)));
    }
    if let (true, Some(modulation)) = (scene.blend.is_composited(), parameters.modulation) {
        return modulated(precision, scene, table, (parameters.material, modulation), geometry);
    }
    if let (true, Some(map), Some(material)) = (scene.blend.is_composited(), scene.reflectance, parameters.material) {
        let shader = reflectance::of(&material.phong(precision)?, map)?;
        return Ok(shaded(precision, scene, table, shader, geometry));
    }
    if scene.interpolation == Interpolation::Quadratic {
        return splined(precision, scene, table, parameters, geometry);
    }
    Ok(match scene.blend {
        Blend::FrontToBack => return composited(precision, scene, table, parameters, geometry, false),
        Blend::BackToFront => return composited(precision, scene, table, parameters, geometry, true),
        Blend::Maximum => under(geometry, Project::<_, _, Maximum>::new(precision, table)),
        Blend::Minimum => under(geometry, Project::<_, _, Minimum>::new(precision, table)),
        Blend::Average => under(geometry, Project::of(precision, table, Sum::Average)),
        Blend::Additive => under(geometry, Project::of(precision, table, parameters.additive)),
    })
}

fn composited<P, C>(
    precision: P,
    scene: &Scene,
    classifier: C,
    parameters: Parameters<'_>,
    geometry: Geometry<'_>,
    back_to_front: bool,
) -> Result<Box<dyn Framing>, CameraError>
where
    P: Precision<Pixel: Recurrence<Channel: ChannelFormat>>,
    C: Classifier<P> + Send + 'static,
{
    Ok(match (back_to_front, parameters.material) {
        (false, Some(material)) => {
            let phong = material.phong(precision)?;
            let pipeline = Composite::new(precision, classifier, phong);
            under(geometry, early(pipeline, scene.early_termination))
        }
        (false, None) => {
            let pipeline = Composite::new(precision, classifier, Unlit);
            under(geometry, early(pipeline, scene.early_termination))
        }
        (true, Some(material)) => {
            let phong = material.phong(precision)?;
            under(
                geometry,
                Composite::<_, _, _, BackToFront>::new(precision, classifier, phong),
            )
        }
        (true, None) => under(
            geometry,
            Composite::<_, _, _, BackToFront>::new(precision, classifier, Unlit),
        ),
    })
}

/// Composited samples of rays from an eye.
fn in_perspective<P: Precision<Pixel: Recurrence<Channel: ChannelFormat>>>(
    precision: P,
    scene: &Scene,
    table: Expanded,
    (material, spread): (Option<&Material>, &Spread),
    geometry: Geometry<'_>,
) -> Result<Box<dyn Framing>, CameraError> {
    let back_to_front = scene.blend == Blend::BackToFront;
    Ok(match material {
        Some(material) if back_to_front => {
            let phong = material.phong(precision)?;
            let pipeline = Composite::<_, _, _, BackToFront>::new(precision, table, phong);
            under(geometry, Perspective::new(pipeline, *spread))
        }
        None if back_to_front => {
            let pipeline = Composite::<_, _, _, BackToFront>::new(precision, table, Unlit);
            under(geometry, Perspective::new(pipeline, *spread))
        }
        Some(material) => {
            let pipeline = Composite::new(precision, table, material.phong(precision)?);
            let pipeline = early(pipeline, scene.early_termination);
            under(geometry, Perspective::new(pipeline, *spread))
        }
        None => {
            let pipeline = early(Composite::new(precision, table, Unlit), scene.early_termination);
            under(geometry, Perspective::new(pipeline, *spread))
        }
    })
}

/// Composited samples by splines.
fn splined<P: Precision<Pixel: Recurrence<Channel: ChannelFormat>>>(
    precision: P,
    scene: &Scene,
    table: Expanded,
    parameters: Parameters<'_>,
    geometry: Geometry<'_>,
) -> Result<Box<dyn Framing>, CameraError> {
    let phong = parameters
        .material
        .map(|material| material.phong(precision))
        .transpose()?;
    Ok(match (scene.blend == Blend::BackToFront, phong) {
        (true, Some(phong)) => under(
            geometry,
            Splines(Composite::<_, _, _, BackToFront>::new(precision, table, phong)),
        ),
        (true, None) => under(
            geometry,
            Splines(Composite::<_, _, _, BackToFront>::new(precision, table, Unlit)),
        ),
        (false, Some(phong)) => {
            let pipeline = early(Composite::new(precision, table, phong), scene.early_termination);
            under(geometry, Splines(pipeline))
        }
        (false, None) => {
            let pipeline = early(Composite::new(precision, table, Unlit), scene.early_termination);
            under(geometry, Splines(pipeline))
        }
    })
}

/// Composited samples under a modulation: lit or not is a value, so that it is compiled once.
fn modulated<P: Precision<Pixel: Recurrence<Channel: ChannelFormat>>>(
    precision: P,
    scene: &Scene,
    table: Expanded,
    (material, modulation): (Option<&Material>, &Modulation),
    geometry: Geometry<'_>,
) -> Result<Box<dyn Framing>, CameraError> {
    let phong = material.map(|material| material.phong(precision)).transpose()?;
    let shader = Modulated::new(precision, phong, modulation.clone());
    Ok(shaded(precision, scene, table, shader, geometry))
}

/// Composited samples under a shader, in the scene's order.
fn shaded<P: Precision<Pixel: Recurrence<Channel: ChannelFormat>>, S: Shader<P> + Send + 'static>(
    precision: P,
    scene: &Scene,
    table: Expanded,
    shader: S,
    geometry: Geometry<'_>,
) -> Box<dyn Framing> {
    if scene.blend == Blend::BackToFront {
        under(
            geometry,
            Composite::<_, _, _, BackToFront>::new(precision, table, shader),
        )
    } else {
        under(
            geometry,
            early(Composite::new(precision, table, shader), scene.early_termination),
        )
    }
}

/// Ends rays early if a scene asks for it.
pub fn early<P: Precision, C: Classifier<P>, S: Shader<P>>(
    pipeline: Composite<P, C, S, FrontToBack>,
    bits: Option<u32>,
) -> Composite<P, C, S, FrontToBack> {
    match bits {
        Some(bits) => pipeline.with_early_termination(bits),
        None => pipeline,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_name_precisions_as_core_does() {
        assert_eq!(
            PrecisionName::STAGED.map(PrecisionName::name),
            [Paper::NAME, Compact::NAME, Wide::NAME]
        );
    }
}
