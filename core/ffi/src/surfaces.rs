//! Isosurfaces as C structures.

use slicecast::cut::CutError;
use slicecast::format::Opacity;
use slicecast::surface::{Face, Surface, SurfaceError, VALUE_MAX};

use crate::error::{SLICECAST_FACE, SLICECAST_SURFACE_ORDER, SLICECAST_SURFACE_VALUE, SlicecastError};

/// One side of an isosurface.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SlicecastFace {
    /// Red, green, blue, 1.31.
    pub colour: [u32; 3],
    /// Opacity, 1.31, whatever the step.
    pub opacity: u32,
}

/// An isosurface. docs/contract/surfaces.md
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SlicecastSurface {
    /// Its value, a voxel value, 16.16: 0 to 4096.
    pub value: u32,
    /// The side of lower values.
    pub front: SlicecastFace,
    /// The side of higher values.
    pub back: SlicecastFace,
}

// A list of the caller's is read as core's, where it lies.
const _: () = {
    assert!(size_of::<SlicecastFace>() == size_of::<Face>() && size_of::<SlicecastSurface>() == size_of::<Surface>());
    assert!(align_of::<SlicecastSurface>() == align_of::<Surface>());
    assert!(size_of::<Opacity>() == size_of::<u32>());
    assert!(core::mem::offset_of!(SlicecastFace, opacity) == core::mem::offset_of!(Face, opacity));
    assert!(core::mem::offset_of!(SlicecastSurface, value) == core::mem::offset_of!(Surface, value));
    assert!(core::mem::offset_of!(SlicecastSurface, front) == core::mem::offset_of!(Surface, front));
    assert!(core::mem::offset_of!(SlicecastSurface, back) == core::mem::offset_of!(Surface, back));
};

impl From<SurfaceError> for SlicecastError {
    fn from(error: SurfaceError) -> Self {
        let at = |index: usize, error: Self| Self {
            row: index as u32,
            ..error
        };
        match error {
            SurfaceError::Order { index } => at(index, Self::numbers(SLICECAST_SURFACE_ORDER, 0, 0)),
            SurfaceError::Value { index, value } => at(
                index,
                Self::numbers(SLICECAST_SURFACE_VALUE, VALUE_MAX.into(), value.into()),
            ),
            SurfaceError::Face { index, bits } => at(index, Self::numbers(SLICECAST_FACE, 1 << 31, bits.into())),
        }
    }
}

impl From<CutError> for SlicecastError {
    fn from(error: CutError) -> Self {
        match error {
            CutError::Surface(error) => error.into(),
            // Only one piece is asked for.
            CutError::Pieces { given } => Self::range(0, 1, given.into()),
        }
    }
}
