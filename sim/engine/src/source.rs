//! Where the voxels of a volume come from: memory, or its file.

use std::borrow::Cow;

use slicecast_volume::Volume;
use slicecast_volume::on_disk::OnDisk;

use crate::error::RenderError;

/// Voxels of a brick along each axis: whole voxels of every level.
pub const SIDE: usize = 32;

/// Where the voxels of a volume come from.
pub trait Source: Sync {
    /// Some voxels, `dims` from `first` on, along x, y and z.
    ///
    /// # Errors
    /// [`RenderError::Read`] if a file cannot be read any more.
    fn voxels(&self, first: [usize; 3], dims: [usize; 3]) -> Result<Cow<'_, Volume>, RenderError>;
    /// Bytes that reading takes beside them.
    fn reading_bytes(&self) -> u64;
}

/// Bytes of slices that are read at a time where all of a volume is looked at.
pub const AT_A_TIME: u64 = 16 << 20;

/// Goes through the codes of a volume of this size slice by slice along z, of which so many bytes, and a slice at least, are read at a time.
///
/// # Errors
/// As [`Source::voxels`].
pub fn each_slice(
    source: &dyn Source,
    dims: [usize; 3],
    bytes: u64,
    see: &mut dyn FnMut(&[u16]),
) -> Result<(), RenderError> {
    let [nx, ny, nz] = dims;
    let many = usize::try_from(bytes / (2 * nx * ny).max(1) as u64)
        .unwrap_or(nz)
        .clamp(1, nz.max(1));
    for z in (0..nz).step_by(many) {
        let slices = source.voxels([0, 0, z], [nx, ny, many.min(nz - z)])?;
        slices.voxels.chunks_exact((nx * ny).max(1)).for_each(&mut *see);
    }
    Ok(())
}

impl Source for Volume {
    fn voxels(&self, first: [usize; 3], dims: [usize; 3]) -> Result<Cow<'_, Volume>, RenderError> {
        if dims == self.dims {
            return Ok(Cow::Borrowed(self));
        }
        let [width, height, _] = self.dims;
        let mut voxels = Vec::with_capacity(dims.iter().product());
        for (z, y) in (0..dims[2]).flat_map(|z| (0..dims[1]).map(move |y| (z, y))) {
            let start = ((first[2] + z) * height + first[1] + y) * width + first[0];
            voxels.extend_from_slice(&self.voxels[start..start + dims[0]]);
        }
        Ok(Cow::Owned(Self {
            name: self.name.clone(),
            dims,
            voxels,
            ..*self
        }))
    }

    fn reading_bytes(&self) -> u64 {
        0
    }
}

impl Source for OnDisk {
    fn voxels(&self, first: [usize; 3], dims: [usize; 3]) -> Result<Cow<'_, Volume>, RenderError> {
        let (volume, _) = self.read(first, dims, None)?;
        Ok(Cow::Owned(volume))
    }

    fn reading_bytes(&self) -> u64 {
        // Rows of bricks, and rows of a level as they are made, are at most as large again.
        let [width, _, _] = self.dims();
        Self::reading_bytes(self, rayon::current_num_threads()) + 4 * (width * SIDE * SIDE) as u64
    }
}
