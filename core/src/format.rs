//! Every number format of the pipeline, in one place.
//!
//! `I.F` means I integer and F fraction bits; a leading `s` adds a sign bit. Rows in kernels carry raw bits (`i32`
//! lanes, one lane width for the vectoriser); the stage's page says which of these formats they hold.
//!
//! | type | format | range | unit | made by | read by |
//! |---|---|---|---|---|---|
//! | `u16` voxel | 12.0 | 0 to 4095 | data code | caller | interpolation, gradient |
//! | [`Direction`] | s5.58 | -1 to 1 | any scale | caller | view |
//! | [`Step`] | s31.32 | at most 1 (step), at most 2^15 (start) | voxels | plan | location |
//! | [`Position`] | s15.16 | below 2^15 | voxels | location | interpolation |
//! | [`Weight`] | 0.16 | 0 to 65535 | fraction of a voxel | location | interpolation |
//! | [`Blend16`] | s15.16 | -4095 to 8190 beyond a face; -16380 to 20475 beyond an edge, read with weight 0 only | data code | z and y interpolation | x interpolation |
//! | sample | 12.12, 12.15 | 0 to 4095 | data code | interpolation | classification, gradient |
//! | gradient | s13.12, s13.15 | -8190 to 8190 | data code over two voxels | gradient | normalisation |
//! | [`Vector`] | s1.30 | -1 to 1 | | caller | shading, clip planes |
//! | [`Distance`] | s33.30 | -2^16 to 2^16 | lengths | caller | clip planes |
//! | [`Unit`] | s1.15 | -1 to 1 | | normalisation | export |
//! | [`ReciprocalNorm`] | u32 | 605414 to 2^21 | 2^35 / norm | normalisation | shading |
//! | [`Opacity`] | 1.31 | 0 to 1 | fraction of light blocked by a step | classification | compositing |
//! | [`Cosine`] | 1.31 | 0 to 1 | | shading | shading |
//! | [`Coefficient`] | 1.31 | 0 to 1 | | caller | shading |
//! | colour | 1.15, or 1.31 (`Wide`) | 0 to 1 | | classification, shading | compositing |
//! | [`Intensity`] | 1.15 | 0 to 1 | | caller | gradient (spacing), background |
//! | `u16` channel | 1.15 | 0 to 1 | | compositing (`Paper`) | warp |
//! | `Unorm16` channel | 16 bits, 65535 is 1 | 0 to 1 | | compositing (`Compact`) | warp |
//! | `u32` channel | 1.31 | 0 to 1 | | compositing (`Wide`) | warp |
//!
//! Rounding is named as hardware tools name it: *truncate* is towards minus infinity (AP_TRN), *nearest* is half up
//! (AP_RND), *saturate* is AP_SAT and always stated.

use fixed::types::extra::{U15, U16, U30, U31, U32, U58};
use fixed::{FixedI32, FixedI64, FixedU16, FixedU32};

/// A component of a viewing direction in voxel units, s5.58, -1 to 1; the vector's length does not matter.
pub type Direction = FixedI64<U58>;
/// A ray's start or its step from plane to plane, voxels, s31.32. Made by `plan`.
pub type Step = FixedI64<U32>;
/// A sample position, voxels, s15.16. Made by `locate`.
pub type Position = FixedI32<U16>;
/// A distance from a clip plane, or a thickness, s33.30, in lengths of the caller's choice.
pub type Distance = FixedI64<U30>;
/// An interpolation weight, 0.16: the fraction of a [`Position`].
pub type Weight = FixedU32<U16>;
/// A partly interpolated value, s15.16. Lives inside `interpolate`.
pub type Blend16 = FixedI32<U16>;
/// A component of a light or viewing vector, s1.30. A precision may keep fewer bits of it.
pub type Vector = FixedI32<U30>;
/// A component of a normal made for export, s1.15; 32768 is 1.0.
pub type Unit = FixedI32<U15>;
/// The reciprocal length of a block-normalised gradient, floor(2^35 / sqrt(S)).
pub type ReciprocalNorm = u32;
/// The opacity of one step along a ray, 1.31.
pub type Opacity = FixedU32<U31>;
/// A clamped dot product of two unit vectors, or its power, 1.31.
pub type Cosine = FixedU32<U31>;
/// A lighting coefficient (the material's times the light's), 1.31. A precision may keep fewer bits of it.
pub type Coefficient = FixedU32<U31>;
/// A spacing factor or a background colour, 1.15; 32768 is 1.0.
pub type Intensity = FixedU16<U15>;

/// The largest voxel value: 12 bits.
pub const VOXEL_MAX: u16 = 4095;

/// How a product loses its low bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rounding {
    /// Towards minus infinity (AP_TRN).
    Truncate,
    /// To the nearest, halves up (AP_RND).
    Nearest,
}

impl Rounding {
    /// What to add before `bits` low bits are shifted out.
    #[inline(always)]
    pub(crate) const fn bias(self, bits: u32) -> u32 {
        match self {
            Self::Truncate => 0,
            Self::Nearest => (1 << bits) >> 1,
        }
    }
}
