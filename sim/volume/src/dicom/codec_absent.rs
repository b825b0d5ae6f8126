//! What stands in for the decoders in a build without the feature `jpeg`.

use super::file::Packing;
use super::slice::PixelForm;
use crate::error::Problem;

/// Refuses every packed frame; [`Packing::check`] does so before, with the same words.
pub(super) fn unpack(packing: &Packing, _: &[u8], _: [u32; 2], _: PixelForm) -> Result<Vec<u32>, Problem> {
    packing.check().map(|()| Vec::new())
}
