//! Taps: whoever wants to look at the stage boundaries.
//!
//! There is one pipeline and never an instrumented copy of it. A tap is a generic parameter; its methods do nothing
//! unless they are implemented, and [`NoTap`] vanishes in the compiler.

use crate::composite::{Channel, PixelRow};
use crate::locate::Plane;

/// Where a row of samples lies in the base-plane image of its phase.
#[derive(Clone, Copy, Debug)]
pub struct Beam<'a> {
    /// The sample plane.
    pub plane: &'a Plane,
    /// Row of the image.
    pub row: u32,
    /// Column of the first sample.
    pub column: u32,
}

/// An observer of the stage boundaries. Rows hold raw bits of the formats that the stages' pages name.
pub trait Tap {
    /// Whether it looks at anything. For one that does not, what only taps see need not be made.
    const LOOKS: bool = true;
    /// Location: a plane begins.
    fn plane(&mut self, _plane: &Plane) {}
    /// Interpolation: the samples of a row.
    fn samples(&mut self, _at: Beam<'_>, _samples: &[i32]) {}
    /// Classification: the opacities of the same row, bits of 1.31.
    fn opacities(&mut self, _at: Beam<'_>, _opacities: &[i32]) {}
    /// Classification: the colours of a visible span, 1.15 or 1.31.
    fn colours(&mut self, _at: Beam<'_>, _colours: [&[i32]; 3]) {}
    /// Gradient: a visible span of a lit scene, after the spacing factors.
    fn gradients(&mut self, _at: Beam<'_>, _gradients: [&[i32]; 3]) {}
    /// Normalisation: the same span, block-normalised components and reciprocal lengths.
    fn normals(&mut self, _at: Beam<'_>, _g: [&[i32]; 3], _r: &[i32]) {}
    /// Shading: the colours of the same span, in the same format.
    fn shaded(&mut self, _at: Beam<'_>, _colours: [&[i32]; 3]) {}
    /// Compositing: the pixels of a visible span before its samples are folded in.
    fn before<C: Channel>(&mut self, _at: Beam<'_>, _pixels: &PixelRow<'_, C>) {}
    /// Compositing: the same pixels afterwards.
    fn after<C: Channel>(&mut self, _at: Beam<'_>, _pixels: &PixelRow<'_, C>) {}
}

/// Nobody looks.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoTap;

impl Tap for NoTap {
    const LOOKS: bool = false;
}
