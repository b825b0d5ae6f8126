//! From a scene's lights to a reflectance map.

use slicecast::precision::Precision;
use slicecast::shade::Phong;
use slicecast::shade::map::{self, MapError, Mapped};
use slicecast_scene::reflectance::{Filter, Reflectance};

/// The shader by a map of these lights.
///
/// # Errors
/// [`MapError`] for a number of nodes that no scene may state.
pub fn of<P: Precision>(
    phong: &Phong<P>,
    Reflectance { side, filter }: Reflectance,
) -> Result<Mapped<Vec<u32>, P>, MapError> {
    map::check_side(side)?;
    let mut entries = vec![0; map::entries(phong, side)];
    map::fill(phong, side, &mut entries)?;
    let filter = match filter {
        Filter::Nearest => map::Filter::Nearest,
        Filter::Bilinear => map::Filter::Bilinear,
    };
    Mapped::new(phong, side, filter, entries)
}
