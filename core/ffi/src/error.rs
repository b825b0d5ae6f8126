//! Codes and the numbers behind them.

use slicecast::integral::IntegralError;
use slicecast::plan::PlanError;
use slicecast::screen::ScreenError;
use slicecast::shade::PhongError;
use slicecast::slice::SliceError;
use slicecast::stream::StreamError;
use slicecast::view::ViewError;

use crate::colours::codes_error;

/// Done.
pub const SLICECAST_OK: i32 = 0;
/// All slices of the volume have been taken. Not an error.
pub const SLICECAST_COMPLETE: i32 = 1;
/// A pointer is null: `argument` is its place in the function's list, from 1.
pub const SLICECAST_NULL: i32 = -1;
/// A pointer is misaligned: `argument`; `needed` bytes; `given` is its address.
pub const SLICECAST_MISALIGNED: i32 = -2;
/// A buffer is too short or of the wrong length: `argument`; `needed` and `given` elements.
pub const SLICECAST_LENGTH: i32 = -3;
/// The scene's version is not the library's: `needed`, `given`.
pub const SLICECAST_VERSION_MISMATCH: i32 = -4;
/// A pointer is not to what the function expects (no stream, or its block was overwritten): `argument`.
pub const SLICECAST_FOREIGN: i32 = -5;
/// The viewing direction is zero, or a component is beyond -1 to 1: `given` is the component, s5.58.
pub const SLICECAST_DIRECTION: i32 = -6;
/// A side of the volume is 0 or above `needed`: `given` voxels.
pub const SLICECAST_SIDE: i32 = -7;
/// Planes per voxel outside 1 to `needed`: `given`.
pub const SLICECAST_PLANES_PER_VOXEL: i32 = -8;
/// Rays per voxel outside 1 to `needed`: `given`.
pub const SLICECAST_RAYS_PER_VOXEL: i32 = -9;
/// More than `needed` sample planes behind the first: `given`.
pub const SLICECAST_PLANES: i32 = -10;
/// A spacing factor is 0 or above `needed`: `given`, 1.15.
pub const SLICECAST_SPACING: i32 = -11;
/// More than `needed` lights: `given`.
pub const SLICECAST_LIGHTS: i32 = -12;
/// log2 of the exponent above `needed`: `given`.
pub const SLICECAST_EXPONENT: i32 = -13;
/// A component of a vector is beyond -`needed` to `needed`: `given`, s1.30.
pub const SLICECAST_VECTOR: i32 = -14;
/// A coefficient is above `needed`: `given`, 1.31.
pub const SLICECAST_COEFFICIENT: i32 = -15;
/// The band is not inside the image: it would end at row `given`, the image has `needed`.
pub const SLICECAST_BAND: i32 = -16;
/// A voxel has more than 12 bits: `given` at `row`, `column`; `needed` is the largest accepted.
pub const SLICECAST_VOXEL: i32 = -17;
/// The highlight is neither 0 (reflection) nor 1 (half vector): `given`.
pub const SLICECAST_HIGHLIGHT: i32 = -18;
/// The interpolation is neither 0 (linear) nor 1 (nearest), or not 0 where segments are classified: `given`; `needed` is the
/// largest accepted.
pub const SLICECAST_INTERPOLATION: i32 = -19;
/// A side of the picture is 0 or above `needed`: `given` pixels.
pub const SLICECAST_PICTURE: i32 = -20;
/// From one picture pixel to the next there are more than `needed` voxels along an axis: `given`, both s31.32.
pub const SLICECAST_PIXEL: i32 = -21;
/// A number given to a stage is out of its range: `argument`; `needed` is the end of the range that it passes; `given`.
pub const SLICECAST_RANGE: i32 = -22;

/// A table of integrals has neither 1 list (extinction) nor 4: `given`.
pub const SLICECAST_LISTS: i32 = -23;
/// log2 of the codes of a bin is above `needed`: `given`.
pub const SLICECAST_GRAIN: i32 = -24;
/// The exponent of integrals is outside 15 to 28: `needed` is the end of the range that it passes; `given`.
pub const SLICECAST_NODE_EXPONENT: i32 = -25;
/// A node is less than the one before, or above `needed`: `given`, node `column` of list `row` (0 extinction, 1 red, 2 green,
/// 3 blue).
pub const SLICECAST_NODE: i32 = -26;
/// The colour of a table of integrals is above `needed`: `given`, 1.31.
pub const SLICECAST_COLOUR: i32 = -27;
/// Segments of whole borders lie between slices, and the volume has fewer than `needed` along the viewing axis: `given`.
pub const SLICECAST_SLICES: i32 = -28;

/// Surface `row` of a list has a lower value than the one before it.
pub const SLICECAST_SURFACE_ORDER: i32 = -29;
/// The value of surface `row` is above `needed`: `given`, 16.16.
pub const SLICECAST_SURFACE_VALUE: i32 = -30;
/// A colour or an opacity of surface `row` is above `needed`: `given`, 1.31.
pub const SLICECAST_FACE: i32 = -31;
/// The borders are none of 0 (whole), 1 (cells), 2 (nodes), or 2 and a side of the volume is one voxel: `given`; `needed` is
/// the largest accepted.
pub const SLICECAST_BORDERS: i32 = -32;
/// A crop box whose low face is not below its high one (`needed` 0), or that holds nothing of the volume (`needed` 1), along axis
/// `given` (0 x, 1 y, 2 z); or one with borders 0, which cut no step (`needed` 2).
pub const SLICECAST_CROP: i32 = -33;
/// More clip planes than `needed`: `given`.
pub const SLICECAST_CLIP_COUNT: i32 = -34;
/// Clip plane `row` has no normal (`needed` 1), a slope beyond -1 to 1 (`needed` 2^30), or a distance, thickness or falloff out of
/// range (`needed` the largest, 2^46; a thickness and a falloff are not below 0).
pub const SLICECAST_CLIP: i32 = -35;
/// Clip planes or depth cueing were given to a stream that has taken a slice.
pub const SLICECAST_BEGUN: i32 = -36;
/// Depth cueing has a slope, a distance, a depth, a share or a colour that is out of range.
pub const SLICECAST_CUE: i32 = -37;
/// The scale of extinctions has a mantissa above `needed`, or an exponent outside 14 to 35 (`needed` is the end of the range that it
/// passes): `given`; or an optical depth of a step above 15 (`needed`; `given` is 0).
pub const SLICECAST_MEDIUM: i32 = -38;
/// An extinction above `needed`, 32767, or a colour times extinction above its extinction, `needed`: `given` at `row`, `column`.
pub const SLICECAST_CODES: i32 = -39;

/// A code and the numbers behind it; which of them mean something is said with the code.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SlicecastError {
    /// One of the codes.
    pub code: i32,
    /// Place of the argument, from 1.
    pub argument: u32,
    /// What would have been accepted.
    pub needed: i64,
    /// What was given.
    pub given: i64,
    /// Row of a voxel, a list, or a surface.
    pub row: u32,
    /// Column of a voxel, or a node.
    pub column: u32,
}

impl SlicecastError {
    pub(crate) const NONE: Self = Self::numbers(SLICECAST_OK, 0, 0);

    pub(crate) const fn numbers(code: i32, needed: i64, given: i64) -> Self {
        Self {
            code,
            argument: 0,
            needed,
            given,
            row: 0,
            column: 0,
        }
    }

    const fn at(self, argument: u32) -> Self {
        Self { argument, ..self }
    }

    pub(crate) const fn null(argument: u32) -> Self {
        Self::numbers(SLICECAST_NULL, 0, 0).at(argument)
    }

    pub(crate) const fn misaligned(argument: u32, needed: usize, given: usize) -> Self {
        Self::numbers(SLICECAST_MISALIGNED, needed as i64, given as i64).at(argument)
    }

    pub(crate) const fn length(argument: u32, needed: usize, given: usize) -> Self {
        Self::numbers(SLICECAST_LENGTH, needed as i64, given as i64).at(argument)
    }

    pub(crate) const fn range(argument: u32, needed: i64, given: i64) -> Self {
        Self::numbers(SLICECAST_RANGE, needed, given).at(argument)
    }

    pub(crate) const fn foreign(argument: u32) -> Self {
        Self::numbers(SLICECAST_FOREIGN, 0, 0).at(argument)
    }
}

impl From<ViewError> for SlicecastError {
    fn from(error: ViewError) -> Self {
        let given = match error {
            ViewError::TooLong { bits } => bits,
            // The last two are those of views from angles, which C does not make.
            ViewError::NoDirection | ViewError::Angle | ViewError::Spacing { .. } => 0,
        };
        Self::numbers(SLICECAST_DIRECTION, 1 << 58, given)
    }
}

impl From<PlanError> for SlicecastError {
    fn from(error: PlanError) -> Self {
        use slicecast::plan::{PLANES_MAX, PLANES_PER_VOXEL_MAX, RAYS_PER_VOXEL_MAX, SIDE_MAX};
        let (code, needed, given) = match error {
            PlanError::Side { given } => (SLICECAST_SIDE, SIDE_MAX.into(), given),
            PlanError::PlanesPerVoxel { given } => (SLICECAST_PLANES_PER_VOXEL, PLANES_PER_VOXEL_MAX, given),
            PlanError::RaysPerVoxel { given } => (SLICECAST_RAYS_PER_VOXEL, RAYS_PER_VOXEL_MAX, given),
            PlanError::Planes { given } => (SLICECAST_PLANES, PLANES_MAX, given),
            PlanError::Spacing { bits } => (SLICECAST_SPACING, 1 << 15, bits.into()),
            PlanError::Thin => (SLICECAST_BORDERS, 1u16.into(), 2),
            PlanError::Reversed { axis } => (SLICECAST_CROP, 0, axis),
            PlanError::Beside { axis } => (SLICECAST_CROP, 1, axis),
            PlanError::WholeCropped => (SLICECAST_CROP, 2, 0),
        };
        Self::numbers(code, needed.into(), given.into())
    }
}

impl From<PhongError> for SlicecastError {
    fn from(error: PhongError) -> Self {
        use slicecast::shade::{EXPONENT_LOG2_MAX, LIGHTS_MAX};
        match error {
            PhongError::Lights { given } => Self::numbers(SLICECAST_LIGHTS, LIGHTS_MAX as i64, given as i64),
            PhongError::Exponent { given } => Self::numbers(SLICECAST_EXPONENT, EXPONENT_LOG2_MAX.into(), given.into()),
            PhongError::Vector { bits } => Self::numbers(SLICECAST_VECTOR, 1 << 30, bits.into()),
            PhongError::Coefficient { bits } => Self::numbers(SLICECAST_COEFFICIENT, 1 << 31, bits.into()),
            // Scenes of C state vectors and coefficients of full width.
            PhongError::KeptVector { given, one } => Self::numbers(SLICECAST_VECTOR, one.into(), given.into()),
            PhongError::KeptCoefficient { given, one } => {
                Self::numbers(SLICECAST_COEFFICIENT, one.into(), given.into())
            }
        }
    }
}

impl From<IntegralError> for SlicecastError {
    fn from(error: IntegralError) -> Self {
        use slicecast::integral::{EXPONENTS, GRAINS, LENGTH_BITS, NODE_MAX};
        let passed = |range: core::ops::RangeInclusive<u32>, given: u32| {
            let (low, high) = range.into_inner();
            i64::from(if given < low { low } else { high })
        };
        match error {
            IntegralError::Grain { given } => Self::numbers(SLICECAST_GRAIN, passed(GRAINS, given), given.into()),
            IntegralError::Exponent { given } => {
                Self::numbers(SLICECAST_NODE_EXPONENT, passed(EXPONENTS, given), given.into())
            }
            IntegralError::Nodes { needed, given } => Self::length(2, needed, given),
            IntegralError::Node { list, index, value } => Self {
                row: list as u32,
                column: index as u32,
                ..Self::numbers(SLICECAST_NODE, NODE_MAX.into(), value.into())
            },
            IntegralError::Colour { bits } => Self::numbers(SLICECAST_COLOUR, 1 << 31, bits.into()),
            IntegralError::Length { bits } => Self::range(3, passed(LENGTH_BITS, bits), bits.into()),
        }
    }
}

impl From<ScreenError> for SlicecastError {
    fn from(error: ScreenError) -> Self {
        use slicecast::screen::{PICTURE_SIDE_MAX, PIXEL_MAX};
        match error {
            ScreenError::Side { given } => Self::numbers(SLICECAST_PICTURE, PICTURE_SIDE_MAX.into(), given.into()),
            ScreenError::Pixel { bits } => Self::numbers(SLICECAST_PIXEL, i64::from(PIXEL_MAX) << 32, bits),
            // That of screens from angles, which C does not make.
            ScreenError::Length => Self::numbers(SLICECAST_PIXEL, i64::from(PIXEL_MAX) << 32, 0),
        }
    }
}

impl From<slicecast::Error> for SlicecastError {
    fn from(error: slicecast::Error) -> Self {
        match error {
            slicecast::Error::View(error) => error.into(),
            slicecast::Error::Plan(error) => error.into(),
            slicecast::Error::Screen(error) => error.into(),
            slicecast::Error::Phong(error) => error.into(),
            slicecast::Error::Integral(error) => error.into(),
            slicecast::Error::Cut(error) => error.into(),
            slicecast::Error::Stream(error) => error.into(),
        }
    }
}

impl From<StreamError> for SlicecastError {
    fn from(error: StreamError) -> Self {
        match error {
            StreamError::Memory { needed, given, .. } => Self::length(6, needed, given),
            StreamError::Band { end, rows, .. } => Self::numbers(SLICECAST_BAND, rows.into(), end.into()),
            StreamError::Complete => Self::numbers(SLICECAST_COMPLETE, 0, 0),
            StreamError::Begun => Self::numbers(SLICECAST_BEGUN, 0, 0),
            // No plan of this interface is in perspective.
            StreamError::Rays => Self::numbers(SLICECAST_BAND, 0, 0),
            StreamError::Slice(SliceError::Voxel { row, column, value }) => Self {
                row: row as u32,
                column: column as u32,
                ..Self::numbers(SLICECAST_VOXEL, slicecast::format::VOXEL_MAX.into(), value.into())
            },
            StreamError::Slice(
                SliceError::Voxels { needed, given }
                | SliceError::Stride { needed, given }
                | SliceError::Ranges { needed, given },
            ) => Self::length(3, needed, given),
            StreamError::Slice(SliceError::Colour { row, column, codes }) => codes_error(row, column, codes),
        }
    }
}
