//! What identifies a volume under a scene.

use slicecast_scene::{PrecisionName, Scene};

use crate::frame::Prepared;

/// The inputs of a frame but for its precision, table and look-up: the volume, the scene with its view, and the program's version.
pub fn key(prepared: &Prepared<'_>) -> String {
    let mut voxels = crc32fast::Hasher::new();
    for voxel in &prepared.volume.voxels {
        voxels.update(&voxel.to_le_bytes());
    }
    let volume = &prepared.volume;
    let shape = format!("{:?} {:?} {:?}", volume.dims, volume.spacing, volume.mapping);
    let scene = Scene {
        precision: PrecisionName::Compact,
        table: None,
        lookup: None,
        ..prepared.scene.clone()
    };
    let words = format!("{} {shape} {scene:?}", env!("CARGO_PKG_VERSION"));
    format!("{:08x}-{:08x}", voxels.finalize(), crc32fast::hash(words.as_bytes()))
}
