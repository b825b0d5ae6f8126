//! Observers of the stage boundaries.
//!
//! There is one pipeline and never an instrumented copy of it: a fold takes an optional `&mut dyn Tap` and calls it once
//! per row and boundary. Error statistics, recordings and checksums are taps.

use crate::composite::Channel;
use crate::locate::Plane;
use crate::stage::Stage;

/// Where a row of values lies in the base-plane image of its phase.
#[derive(Clone, Copy, Debug)]
pub struct Beam<'a> {
    /// The sample plane.
    pub plane: &'a Plane,
    /// Row of the image.
    pub row: u32,
    /// Column of the first value.
    pub column: u32,
    /// Which part of segments it is, where they are cut ([`Classifier::parts`](crate::classify::Classifier::parts)).
    pub part: u32,
}

/// A row of raw bits, whatever word holds them.
pub trait Bits {
    /// Number of values.
    fn len(&self) -> usize;
    /// The bits of a value; 0 past the end.
    fn bits(&self, index: usize) -> u32;
    /// Whether there is no value.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Bits for &[i32] {
    fn len(&self) -> usize {
        <[i32]>::len(self)
    }
    fn bits(&self, index: usize) -> u32 {
        self.get(index).map_or(0, |value| *value as u32)
    }
}

impl<C: Channel> Bits for &[C] {
    fn len(&self) -> usize {
        <[C]>::len(self)
    }
    fn bits(&self, index: usize) -> u32 {
        self.get(index).map_or(0, |channel| channel.bits())
    }
}

/// An observer of the stage boundaries.
pub trait Tap {
    /// A plane begins ([`Stage::Location`]).
    fn plane(&mut self, _plane: &Plane) {}
    /// The values at a boundary: a row of a plane, or a visible span of it. All rows are equally long; [`Stage`] says how
    /// many there are and in which format. The rows that shading leads to end in a call of [`Stage::After`].
    fn row(&mut self, _stage: Stage, _at: Beam<'_>, _rows: &[&dyn Bits]) {}
}
