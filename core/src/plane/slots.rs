//! The slots of a plane: a classifier's and a shader's kernels, and the canvas, with what else its rows need.
//!
//! A small machine compiles them with its pipeline. Elsewhere they are trait objects, and what goes through a plane is compiled once for
//! a precision and its lanes.

use super::canvas::{Canvas, Packing};
use super::fold::{Batches, fold};
use super::kernels::{PartRows, ShaderRows};
use super::scratch::BatchRows;
use crate::classify::Support;
use crate::tap::Tap;

/// What is called for rows of a plane.
pub(super) struct Slots<'s, P, C: ?Sized, S: ?Sized, X: ?Sized> {
    pub(super) precision: P,
    pub(super) classifier: &'s mut C,
    pub(super) shader: &'s S,
    pub(super) canvas: &'s mut X,
    pub(super) support: Support,
    /// Number of the image's first row.
    pub(super) first: u32,
    /// Rows of the image.
    pub(super) count: usize,
}

/// Slots whose types are not known.
pub(super) type AnySlots<'s, 'o, P> =
    Slots<'s, P, dyn PartRows<i32> + 'o, dyn ShaderRows<i32> + 'o, dyn Packing<i32> + 'o>;

impl<P: Copy, C: PartRows<i32>, S: ShaderRows<i32>, X: Packing<i32>> Slots<'_, P, C, S, X> {
    /// The same, without their types.
    #[inline(always)]
    pub(super) fn any<'o>(&mut self) -> AnySlots<'_, 'o, P>
    where
        C: 'o,
        S: 'o,
        X: 'o,
    {
        Slots {
            precision: self.precision,
            classifier: &mut *self.classifier,
            shader: self.shader,
            canvas: &mut *self.canvas,
            support: self.support,
            first: self.first,
            count: self.count,
        }
    }
}

impl<P, C, S, X> Slots<'_, P, C, S, X>
where
    C: PartRows<i32> + ?Sized,
    S: ShaderRows<i32> + ?Sized,
    X: Canvas<i32> + ?Sized,
{
    /// Folds all batches of a way through the plane, compiled as one with it.
    #[inline(always)]
    pub(super) fn fold<B: Batches<i32, X>>(
        &mut self,
        batches: &mut B,
        memory: BatchRows<'_, i32>,
        tap: Option<&mut dyn Tap>,
    ) {
        fold(
            batches,
            (&*self.classifier, self.shader),
            &mut *self.canvas,
            memory,
            tap,
        );
    }

    /// The same, of which there is one copy for a way.
    #[inline(always)]
    pub(super) fn fold_apart<B: Batches<i32, X>>(
        &mut self,
        batches: &mut B,
        memory: BatchRows<'_, i32>,
        tap: Option<&mut dyn Tap>,
    ) {
        fold_apart(
            batches,
            (&*self.classifier, self.shader),
            &mut *self.canvas,
            memory,
            tap,
        );
    }
}

/// A way through the driver, for all precisions and lanes.
#[inline(never)]
fn fold_apart<B, C, S, X>(
    batches: &mut B,
    slots: (&C, &S),
    canvas: &mut X,
    memory: BatchRows<'_, i32>,
    tap: Option<&mut dyn Tap>,
) where
    B: Batches<i32, X>,
    C: PartRows<i32> + ?Sized,
    S: ShaderRows<i32> + ?Sized,
    X: Canvas<i32> + ?Sized,
{
    fold(batches, slots, canvas, memory, tap);
}
