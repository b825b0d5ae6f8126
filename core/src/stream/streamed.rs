//! What a stream asks of a pipeline.

use crate::lanes::{Lanes as _, Native};
use crate::plan::Plan;
use crate::plane::{At, Pipeline, Rows, ScratchError, Shape, clear};
use crate::slice::Voxel;
use crate::tap::Tap;

/// A pipeline as a stream sees it. Every [`Pipeline`] is one; a program that holds pipelines as objects implements it for what it
/// holds, and has one stream for all of them.
pub trait Streamed {
    /// What its slices are made of.
    type Voxel: Voxel;
    /// What its images are made of.
    type Element: Copy;

    /// How its images, planes and memory are laid out.
    fn shape(&self) -> Shape;

    /// Fills rows with what an untouched image holds.
    fn clear(&self, plan: &Plan, data: &mut [Self::Element]);

    /// Folds a plane into rows by the scalar definitions.
    ///
    /// # Errors
    /// [`ScratchError`] if the scratch memory is too small.
    fn fold_plane(
        &self,
        at: &At<'_, Self::Voxel>,
        rows: Rows<'_, Self::Element>,
        scratch: &mut [i32],
        tap: Option<&mut dyn Tap>,
    ) -> Result<(), ScratchError>;
}

impl<L: Pipeline> Streamed for L {
    type Voxel = L::Voxel;
    type Element = L::Element;

    #[inline(always)]
    fn shape(&self) -> Shape {
        L::SHAPE
    }

    #[inline(always)]
    fn clear(&self, plan: &Plan, data: &mut [L::Element]) {
        clear(self, plan, data);
    }

    #[inline(always)]
    fn fold_plane(
        &self,
        at: &At<'_, L::Voxel>,
        rows: Rows<'_, L::Element>,
        scratch: &mut [i32],
        tap: Option<&mut dyn Tap>,
    ) -> Result<(), ScratchError> {
        // A small machine has no other that folds.
        if Native::SMALL {
            self.fold::<Native>(at, rows, scratch, None, tap)
        } else {
            self.fold_native(at, rows, scratch, None, tap)
        }
    }
}
