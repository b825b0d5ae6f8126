//! What a scene's segments are classified by: the integrals of its transfer function, and its isosurfaces.

use std::sync::Arc;

use slicecast::cut::Cut;
use slicecast::format::Opacity;
use slicecast::integral::{Integral, Length};
use slicecast::surface::{self, VALUE_MAX};
use slicecast_scene::{Classification, Face, Scene, Surface};
use slicecast_volume::{Mapping, Volume};

use crate::integrals::{Cumulative, Nodes};

/// The classifier of a frame's segments, which owns its lists.
pub type Segments = Cut<Nodes, Arc<[surface::Surface]>>;

/// The classifier of a scene's segments on a volume.
pub fn of(scene: &Scene, volume: &Volume, length: Length) -> Segments {
    let integrals = (scene.classification != Classification::None)
        .then(|| Cumulative::of(&scene.transfer, volume, 0).classifier(length));
    cut(integrals, scene, &volume.mapping)
}

/// A scene's cuts of the segments of integrals, or of none.
///
/// # Panics
/// Never, of a scene that has been checked.
pub fn cut(integrals: Option<Integral<Nodes>>, scene: &Scene, mapping: &Mapping) -> Segments {
    Cut::new(integrals, surfaces(scene, mapping).into(), scene.pieces).unwrap_or_else(|error| unreachable!("{error}"))
}

/// A scene's surfaces on a volume's codes, in ascending order. Those with no visible side are left out, because the volume would
/// be cut at them. Values that no code reaches are never crossed.
pub fn surfaces(scene: &Scene, mapping: &Mapping) -> Vec<surface::Surface> {
    let visible = scene.surfaces.iter().filter(|surface| surface.is_visible());
    let mut surfaces: Vec<_> = visible.map(|surface| of_codes(surface, mapping)).collect();
    surfaces.sort_by_key(|surface| surface.value);
    surfaces
}

fn of_codes(Surface { value, front, back }: &Surface, mapping: &Mapping) -> surface::Surface {
    let code = (value - mapping.offset) / mapping.scale;
    let [front, back] = [front, back].map(|Face { colour, opacity }| surface::Face {
        colour: colour.map(bits),
        opacity: Opacity::from_bits(bits(*opacity)),
    });
    // Codes that fall where values rise turn a surface around.
    let (front, back) = if mapping.scale < 0.0 {
        (back, front)
    } else {
        (front, back)
    };
    surface::Surface {
        value: (code * 65536.0).ceil().clamp(0.0, f64::from(VALUE_MAX)) as u32,
        front,
        back,
    }
}

/// 0 to 1 in 1.31.
fn bits(part: f64) -> u32 {
    (part * 2_147_483_648.0).round() as u32
}
