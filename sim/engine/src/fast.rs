//! Scenes in 16-bit lanes: their table and lights, as the `fast` precision reads them.

use std::sync::Arc;

use slicecast::composite::{BackToFront, FrontToBack};
use slicecast::fast::table::{fill_colours, fill_roots};
use slicecast::fast::{Colours, FastPhong, RootTable, Roots};
use slicecast::plane::{Fast, FastProject};
use slicecast::project::{Maximum, Minimum, Sum};
use slicecast::shade::{PhongError, Unlit};
use slicecast::table::ENTRIES;
use slicecast_scene::{Blend, Scene};

use crate::camera::Material;
use crate::error::CameraError;
use crate::geometry::Geometry;
use crate::parameters::Parameters;
use crate::rendering::Framing;
use crate::rendering::under;
use crate::table::{AnyTable, Table, with_table};

/// A table in memory of its own.
pub type Owned = RootTable<Arc<Roots>, Arc<Colours>>;

/// A compiled table for 16-bit lanes.
pub fn table(table: &Table) -> Owned {
    let (mut roots, mut colours) = (Arc::new([0; ENTRIES]), Arc::new([[0; 4]; ENTRIES + 1]));
    let one = match (Arc::get_mut(&mut roots), Arc::get_mut(&mut colours)) {
        (Some(roots), Some(colours)) => with_table!(table.classifier(), points => {
            fill_roots(&points, roots);
            fill_colours(&points, colours)
        }),
        _ => unreachable!("nothing else has them yet"),
    };
    RootTable::new(roots, one.ok_or(colours))
}

impl Material {
    /// The shader of 16-bit lanes.
    ///
    /// # Errors
    /// As [`Material::new`].
    pub fn fast(&self) -> Result<FastPhong, PhongError> {
        FastPhong::new(
            self.ambient,
            &self.lights,
            self.viewer,
            self.highlight,
            self.exponent_log2,
        )
    }
}

/// The rendering of a scene.
///
/// # Errors
/// [`CameraError`] if the material is not one that has been checked.
pub(crate) fn rendering(
    scene: &Scene,
    points: &Table,
    parameters: Parameters<'_>,
    geometry: Geometry<'_>,
) -> Result<Box<dyn Framing>, CameraError> {
    let table = table(points);
    match scene.blend {
        Blend::FrontToBack | Blend::BackToFront => {}
        Blend::Maximum => return Ok(under(geometry, FastProject::new(table, Maximum))),
        Blend::Minimum => return Ok(under(geometry, FastProject::new(table, Minimum))),
        Blend::Average => return Ok(under(geometry, FastProject::new(table, Sum::Average))),
        Blend::Additive => return Ok(under(geometry, FastProject::new(table, parameters.additive))),
    }
    let phong = parameters.material.map(Material::fast).transpose()?;
    Ok(match (scene.blend == Blend::BackToFront, phong) {
        (true, Some(phong)) => under(geometry, Fast::<_, _, _, BackToFront>::new(table, phong)),
        (true, None) => under(geometry, Fast::<_, _, _, BackToFront>::new(table, Unlit)),
        (false, Some(phong)) => under(geometry, early(Fast::new(table, phong), scene.early_termination)),
        (false, None) => under(geometry, early(Fast::new(table, Unlit), scene.early_termination)),
    })
}

/// Ends rays early if a scene asks for it.
fn early<R, C, S>(pipeline: Fast<R, C, S, FrontToBack>, bits: Option<u32>) -> Fast<R, C, S, FrontToBack> {
    match bits {
        Some(bits) => pipeline.with_early_termination(bits),
        None => pipeline,
    }
}
