//! One error for all steps of a frame, so that a device's set-up is a chain of `?`.

use crate::cut::CutError;
use crate::integral::IntegralError;
use crate::plan::PlanError;
use crate::plane::ScratchError;
use crate::screen::ScreenError;
use crate::shade::PhongError;
use crate::slice::SliceError;
use crate::stream::StreamError;
use crate::surface::SurfaceError;
use crate::view::ViewError;

/// Why there is no frame. Every step's own error becomes this one with `?`.
///
/// ```
/// use slicecast::Error;
/// use slicecast::format::Direction;
/// use slicecast::plan::{Plan, PlanError, Sampling, Spacing};
/// use slicecast::view::View;
///
/// fn plan(dims: [u32; 3]) -> Result<Plan, Error> {
///     let view = View::new([Direction::ZERO, Direction::ONE, Direction::ZERO])?;
///     Ok(Plan::new(view, dims, Spacing::CUBIC, Sampling::default())?)
/// }
/// assert_eq!(plan([64, 64, 0]), Err(Error::Plan(PlanError::Side { given: 0 })));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Error {
    /// The viewing direction, or the angles and spacing that it comes from.
    View(ViewError),
    /// Sizes, spacing factors, sampling rates.
    Plan(PlanError),
    /// The picture.
    Screen(ScreenError),
    /// Lights and material.
    Phong(PhongError),
    /// A table of integrals.
    Integral(IntegralError),
    /// Isosurfaces, and pieces of segments.
    Cut(CutError),
    /// Memory, bands and slices of a stream.
    Stream(StreamError),
}

impl core::fmt::Display for Error {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::View(error) => error.fmt(f),
            Self::Plan(error) => error.fmt(f),
            Self::Screen(error) => error.fmt(f),
            Self::Phong(error) => error.fmt(f),
            Self::Integral(error) => error.fmt(f),
            Self::Cut(error) => error.fmt(f),
            Self::Stream(error) => error.fmt(f),
        }
    }
}

/// It shows what the step's own error shows, so that it has no source beside it.
impl core::error::Error for Error {}

impl From<ViewError> for Error {
    fn from(error: ViewError) -> Self {
        Self::View(error)
    }
}

impl From<PlanError> for Error {
    fn from(error: PlanError) -> Self {
        Self::Plan(error)
    }
}

impl From<ScreenError> for Error {
    fn from(error: ScreenError) -> Self {
        Self::Screen(error)
    }
}

impl From<PhongError> for Error {
    fn from(error: PhongError) -> Self {
        Self::Phong(error)
    }
}

impl From<IntegralError> for Error {
    fn from(error: IntegralError) -> Self {
        Self::Integral(error)
    }
}

impl From<CutError> for Error {
    fn from(error: CutError) -> Self {
        Self::Cut(error)
    }
}

impl From<SurfaceError> for Error {
    fn from(error: SurfaceError) -> Self {
        Self::Cut(error.into())
    }
}

impl From<StreamError> for Error {
    fn from(error: StreamError) -> Self {
        Self::Stream(error)
    }
}

impl From<SliceError> for Error {
    fn from(error: SliceError) -> Self {
        Self::Stream(error.into())
    }
}

impl From<ScratchError> for Error {
    fn from(error: ScratchError) -> Self {
        Self::Stream(error.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn every_step_shows_its_own_words() {
        let slice = SliceError::Voxels { needed: 4, given: 3 };
        let scratch = ScratchError { needed: 9, given: 8 };
        let alike: [(Error, &dyn core::fmt::Display); 10] = [
            (ViewError::NoDirection.into(), &ViewError::NoDirection),
            (
                PlanError::Planes { given: 1 << 16 }.into(),
                &PlanError::Planes { given: 1 << 16 },
            ),
            (ScreenError::Side { given: 0 }.into(), &ScreenError::Side { given: 0 }),
            (PhongError::Lights { given: 9 }.into(), &PhongError::Lights { given: 9 }),
            (
                IntegralError::Grain { given: 5 }.into(),
                &IntegralError::Grain { given: 5 },
            ),
            (CutError::Pieces { given: 3 }.into(), &CutError::Pieces { given: 3 }),
            (
                SurfaceError::Order { index: 1 }.into(),
                &SurfaceError::Order { index: 1 },
            ),
            (StreamError::Complete.into(), &StreamError::Complete),
            (slice.into(), &slice),
            (scratch.into(), &StreamError::from(scratch)),
        ];
        for (error, own) in alike {
            assert_eq!(error.to_string(), own.to_string());
        }
    }
}
