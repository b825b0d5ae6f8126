//! Zarr stores in a folder, versions 2 and 3, and the images of OME-NGFF in them.
//!
//! A path is a store's, or leads to a group or an array inside of it: of an image of several levels the finest, or the one
//! that the path names. Read: integers of 8 to 64 bits, float, double; either order of bytes and of axes; chunks that are
//! packed by gzip, zlib, zstd, blosc (its own packer, lz4, zlib, zstd), lz4 or bz2, with a sum or without; shards; chunks
//! that are missing, whose voxels have the fill value. Axes are told by OME-NGFF, by `dimension_names` or xarray's
//! `_ARRAY_DIMENSIONS`, or are z, y and x.

mod array;
mod axes;
mod blosc;
mod chunks;
mod codecs;
mod fill;
mod image;
mod node;
mod shard;
#[cfg(test)]
pub(super) mod tests;
mod unpacked;

use std::path::Path;
use std::sync::Arc;

use self::chunks::Chunks;

use self::array::Array;
use super::choice::Choice;
use super::error::ReadError;
use super::payload::{ByteSkip, Encoding, Layout, Tail};
use super::placed::{Place, Placed};

/// The format's name in messages.
const NAME: &str = "Zarr";

/// Whether a path is a store, a node of one, or leads into one to something that is not there.
pub(super) fn recognise(path: &Path) -> bool {
    if path.exists() {
        let named = path
            .extension()
            .is_some_and(|extension| extension.eq_ignore_ascii_case("zarr"));
        return node::is_node(path) || (named && path.is_dir());
    }
    path.ancestors().skip(1).any(node::is_node)
}

/// What a store says of a volume, and where its chunks are.
///
/// # Errors
/// [`ReadError`] names the file, what was wrong and what was expected.
pub(super) fn place(path: &Path, choice: &Choice) -> Result<Placed, ReadError> {
    let (node, told) = image::find(path)?;
    let fail = |problem| ReadError::new(&node.file, problem);
    let array = Array::of(&node)?;
    let chosen = axes::choose(&array, told, choice).map_err(fail)?;
    let layout = Layout {
        dims: [0; 3],
        components: 1,
        value_type: array.value_type,
        endian: array.endian,
        encoding: Encoding::Raw,
        line_skip: 0,
        byte_skip: ByteSkip::Bytes(0),
        tail: Tail::Refused,
    };
    let chunks = Chunks::new(array, chosen.space, chosen.at).map_err(fail)?;
    Ok(Placed {
        name: path.display().to_string(),
        format: NAME,
        layout: Layout {
            dims: chunks.dims(),
            ..layout
        },
        place: Place::Chunks(Arc::new(chunks)),
        spacing: chosen.spacing,
        directions: None,
        rescale: None,
        modality: None,
        stated_window: chosen.stated_window,
        packed_len: None,
        notes: chosen.notes,
    })
}
