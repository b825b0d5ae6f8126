//! From a scene to one of core's pipeline types: the one place where run-time choices become types.

use slicecast::composite::{BackToFront, ChannelFormat, FrontToBack, Recurrence};
use slicecast::plane::{Composite, Pictured, Project};
use slicecast::precision::{Compact, Paper, Precision, Wide};
use slicecast::project::{Maximum, Minimum};
use slicecast::shade::{PhongError, Shader, Unlit};

use crate::camera::Material;
use crate::expanded::Expanded;
use crate::table::{Correction, Table};
use slicecast_scene::{Blend, PrecisionName, Scene};
use slicecast_volume::Mapping;

/// Something that can be done with any pipeline of a scene.
pub trait Job {
    /// What comes of it.
    type Output;
    /// Does it.
    fn run<L: Pictured>(self, pipeline: &L) -> Self::Output;
}

/// The table of a scene: opacities corrected for the step, or as written where rays are not composited.
pub fn compile(scene: &Scene, mapping: &Mapping, step_length: f64) -> Table {
    let correction = match scene.blend {
        Blend::FrontToBack | Blend::BackToFront => Correction::Step(step_length),
        Blend::Maximum | Blend::Minimum => Correction::None,
    };
    let code = scene.table.unwrap_or(scene.precision.table());
    let lookup = scene.lookup.unwrap_or(scene.precision.lookup());
    Table::compile(&scene.transfer, mapping, correction, code, lookup)
}

/// Does a job with the pipeline of a scene.
///
/// # Errors
/// [`PhongError`] if the material is not one that [`Material::new`] has checked.
pub fn dispatch<J: Job>(
    scene: &Scene,
    table: &Table,
    material: Option<&Material>,
    job: J,
) -> Result<J::Output, PhongError> {
    let expanded = table.expanded();
    let table = &expanded;
    match scene.precision {
        PrecisionName::Paper => with_precision(Paper, scene, table, material, job),
        PrecisionName::Compact => with_precision(Compact, scene, table, material, job),
        PrecisionName::Wide => with_precision(Wide, scene, table, material, job),
    }
}

fn with_precision<P: Precision<Pixel: Recurrence<Channel: ChannelFormat>>, J: Job>(
    precision: P,
    scene: &Scene,
    table: &Expanded,
    material: Option<&Material>,
    job: J,
) -> Result<J::Output, PhongError> {
    Ok(match (scene.blend, material) {
        (Blend::FrontToBack, Some(material)) => job.run(&early(
            Composite::new(precision, table, material.phong(precision)?),
            scene,
        )),
        (Blend::FrontToBack, None) => job.run(&early(Composite::new(precision, table, Unlit), scene)),
        (Blend::BackToFront, Some(material)) => job.run(&Composite::<_, _, _, BackToFront>::new(
            precision,
            table,
            material.phong(precision)?,
        )),
        (Blend::BackToFront, None) => job.run(&Composite::<_, _, _, BackToFront>::new(precision, table, Unlit)),
        (Blend::Maximum, _) => job.run(&Project::<_, _, Maximum>::new(precision, table)),
        (Blend::Minimum, _) => job.run(&Project::<_, _, Minimum>::new(precision, table)),
    })
}

/// Ends rays early if the scene asks for it.
fn early<'t, P: Precision, S: Shader<P>>(
    pipeline: Composite<P, &'t Expanded, S, FrontToBack>,
    scene: &Scene,
) -> Composite<P, &'t Expanded, S, FrontToBack> {
    match scene.early_termination {
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
            PrecisionName::ALL.map(PrecisionName::name),
            [Paper::NAME, Compact::NAME, Wide::NAME]
        );
    }
}
