//! Perspective: where rays from an eye cross the sample planes, how long their steps are, and where the eye lies.
//!
//! Source: Squeeze, section 4.6, for the position of a ray at a plane, P0 + k V of each ray; `docs/contract/perspective.md` has the
//! formulas, ranges and proofs.
//!
//! Rays start at the eye and pass through the pixels of an image that lies in the last slice, so many to a voxel. On plane k pixel p
//! lies at `start + p step`: both are linear in k. Slopes along i and j are at most 1.25 voxels per voxel, so that a picture of any
//! field of view is one of six frames, each about an axis of the volume, or a few of them.
//!
//! | value | format | unit |
//! |---|---|---|
//! | start, step on a plane | s19.44 | voxels |
//! | position | s15.16 | voxels |
//! | slope in lengths of the world U | s4.27 | lengths per length along k |
//! | square of a step q = 1 + U^2 + W^2 | 6.26 | steps along k |
//! | length of a step | 3.20 | steps along k |
//! | vector towards the eye | s1.30 | |
//!
//! Rounding: position to nearest, halves up; length and vector towards zero. Overflow: none inside a `Plan`. State: none.

use core::ops::Range;

use crate::format::{Intensity, Position, Step, Vector};
use crate::lanes::{Lanes, Wide as _};
use crate::plan::{Plan, PlanError, Sampling, Spacing};
use crate::view::View;

/// How far the eye may lie before the first voxel, and behind the last, along each axis, voxels.
pub const EYE_MAX: i32 = 32767;
/// The steepest ray, voxels along i or j per voxel along k, s1.30.
pub const SLOPE_MAX: Vector = Vector::from_bits(5 << 28);
/// The longest step of a ray, in steps along k; it is less.
pub const LENGTH_MAX: u32 = 8;

/// Fraction bits of starts and steps.
const FRACTION: u32 = 44;
/// Fraction bits of slopes in the world.
const SLOPE: u32 = 27;

/// Where rays come from, in the frame of a view (i, j, k).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Eye {
    /// The eye, voxels, counted from the first voxel of the whole volume.
    pub position: [Step; 3],
    /// The least slopes along i and j that are seen, voxels per voxel along k; not beyond [`SLOPE_MAX`].
    pub low: [Vector; 2],
    /// The greatest.
    pub high: [Vector; 2],
}

/// Rays that spread from an eye, of one plan ([`Plan::perspective`](crate::plan::Plan::perspective)).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spread {
    eye: [Step; 3],
    /// Rays per voxel of the last slice.
    rays: u32,
    /// Number of the first pixel along i and j, counted from the first voxel of the last slice.
    first: [i32; 2],
    /// Of plane 0.
    start: [i64; 2],
    /// From plane to plane.
    advance: [i64; 2],
    step: i64,
    growth: i64,
    /// Length of a voxel along i and j in lengths along k, 16.16.
    aspect: [u32; 2],
    planes_per_voxel: u32,
    first_plane: u32,
    base: [u32; 2],
}

/// The positions of a row or a column of pixels on a plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Line {
    /// Of pixel 0, s19.44.
    pub start: i64,
    /// From pixel to pixel, above 0.
    pub step: i64,
}

impl Line {
    /// Where a pixel lies, 16 fraction bits, perhaps beyond what a [`Position`] holds. This function is the definition.
    #[inline(always)]
    pub const fn exact(self, pixel: u32) -> i64 {
        (self.start + pixel as i64 * self.step + (1 << (FRACTION - 17))) >> (FRACTION - 16)
    }

    /// The same of a pixel that lies in the volume.
    #[inline(always)]
    pub const fn at(self, pixel: u32) -> Position {
        Position::from_bits(self.exact(pixel) as i32)
    }

    /// The pixels that lie between the first and the last of `side` voxels, both included, among so many.
    pub fn inside(self, side: u32, pixels: u32) -> Range<u32> {
        let half = 1 << (FRACTION - 17);
        // The least exact place that is rounded to 0, and the least that is rounded beyond the last voxel.
        let beyond = (((i64::from(side) - 1) << 16) + 1) << (FRACTION - 16);
        let held = |place: i64| {
            // The first pixel at a place or behind it.
            let pixel = (place - self.start + self.step - 1).checked_div_euclid(self.step);
            pixel.unwrap_or(0).max(0).min(i64::from(pixels)) as u32
        };
        let first = held(-half);
        first..held(beyond - half).max(first)
    }
}

/// Why an eye has no plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum EyeError {
    /// Volume or sampling.
    Plan(PlanError),
    /// The eye is farther than [`EYE_MAX`] voxels from the volume along an axis of the view's frame.
    Far {
        /// The axis: 0 is i, 1 is j, 2 is k.
        axis: u32,
    },
    /// A slope beyond [`SLOPE_MAX`].
    Slope {
        /// The slope's bits, s1.30.
        bits: i32,
    },
    /// Nothing of the volume lies before the eye and between the slopes.
    Nothing,
    /// A ray whose steps are longer than [`LENGTH_MAX`] steps along k: voxels are too long across the view.
    Length,
}

impl core::fmt::Display for EyeError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Plan(error) => error.fmt(f),
            Self::Far { axis } => write!(
                f,
                "an eye more than {EYE_MAX} voxels from the volume along axis {axis} of the view"
            ),
            Self::Slope { bits } => write!(f, "a slope of {bits}/2^30; accepted: -1.25 to 1.25"),
            Self::Nothing => f.write_str("nothing of the volume lies in front of the eye"),
            Self::Length => write!(
                f,
                "voxels so long across the view that a ray's steps are {LENGTH_MAX} times as long as along it"
            ),
        }
    }
}

impl core::error::Error for EyeError {}

impl From<PlanError> for EyeError {
    fn from(error: PlanError) -> Self {
        Self::Plan(error)
    }
}

impl Plan {
    /// A plan of rays that spread from an eye ([`perspective`](crate::perspective)), with [`Borders::Whole`](crate::borders::Borders::Whole), and these rays, which a pipeline
    /// in perspective has beside it ([`plane::Perspective`](crate::plane::Perspective)). Of the view only axis and
    /// sense count. `rays_per_voxel` is of the last slice; all rays are of one phase.
    ///
    /// Base plane: the columns and rows of pixels in the last slice whose rays meet the volume in front of the eye.
    ///
    /// # Errors
    /// [`EyeError`], with what is out of range.
    pub fn perspective(
        view: View,
        dims: [u32; 3],
        spacing: Spacing,
        sampling: Sampling,
        eye: Eye,
    ) -> Result<(Self, Spread), EyeError> {
        let plan = Self::whole(view.straight(), dims, spacing, sampling)?;
        let rate = (sampling.rays_per_voxel, sampling.planes_per_voxel);
        let spread = Spread::of(eye, plan.volume(), plan.spacing(), rate)?;
        Ok((plan.spreading(spread.base()), spread))
    }
}

/// `a / b` to nearest, halves up; `b` above 0.
fn quotient(a: i128, b: i128) -> i64 {
    (2 * a + b).checked_div_euclid(2 * b).unwrap_or(0) as i64
}

impl Spread {
    /// Rays through a volume of so many voxels along i, j, k: `rays` to a voxel of the last
    /// slice, `rate` planes per voxel.
    ///
    /// # Errors
    /// [`EyeError`].
    pub(crate) fn of(
        eye: Eye,
        volume: [u32; 3],
        spacing: [Intensity; 3],
        (rays, rate): (u32, u32),
    ) -> Result<Self, EyeError> {
        let [_, _, depth] = volume;
        let limit = i64::from(EYE_MAX) << 32;
        for (axis, (at, side)) in (0..).zip(eye.position.into_iter().zip(volume)) {
            let behind = at.to_bits() - (i64::from(side) << 32);
            if at.to_bits() < -limit || behind > limit {
                return Err(EyeError::Far { axis });
            }
        }
        for slope in eye.low.into_iter().chain(eye.high) {
            if slope.unsigned_abs() > SLOPE_MAX.unsigned_abs() {
                return Err(EyeError::Slope { bits: slope.to_bits() });
            }
        }
        let [ei, ej, ek] = eye.position.map(Step::to_bits);
        // The first plane whose step lies in front of the eye as a whole.
        let first_plane = ((ek * i64::from(rate) + (1 << 31) + 0xffff_ffff) >> 32).max(0);
        if first_plane > (i64::from(depth) - 1) * i64::from(rate) {
            return Err(EyeError::Nothing);
        }
        // Along k, from the eye to the last slice and to the first plane, in 2^-32 voxel.
        let way = ((i64::from(depth) - 1) << 32) - ek;
        let nearest = quotient(i128::from(first_plane) << 32, i128::from(rate)) - ek;
        let image = Image { rays, way, nearest };
        let (columns, first_i) = image.side(ei, volume[0], [eye.low[0], eye.high[0]])?;
        let (rows, first_j) = image.side(ej, volume[1], [eye.low[1], eye.high[1]])?;
        let per_plane = i128::from(rate) * i128::from(way);
        // From the eye to pixel 0, in the last slice.
        let beside =
            |first: i32, eye: i64| quotient(i128::from(first) << FRACTION, i128::from(rays)) - (eye << (FRACTION - 32));
        let lateral = [beside(first_i, ei), beside(first_j, ej)];
        let start = |eye: i64, beside: i64| {
            (eye << (FRACTION - 32)) + quotient(-i128::from(beside) * i128::from(ek), way.into())
        };
        let aspect = |axis: usize| {
            let [_, _, along] = spacing.map(|factor| u32::from(factor.to_bits()));
            let across = spacing.get(axis).map_or(1, |factor| u32::from(factor.to_bits()));
            (along << 16).checked_div(across).unwrap_or(0)
        };
        let spread = Self {
            eye: eye.position,
            rays,
            first: [first_i, first_j],
            start: [start(ei, lateral[0]), start(ej, lateral[1])],
            advance: lateral.map(|beside| quotient(i128::from(beside) << 32, per_plane)),
            step: quotient(-i128::from(ek) << FRACTION, i128::from(way) * i128::from(rays)),
            growth: quotient(1 << (FRACTION + 32), per_plane * i128::from(rays)),
            aspect: [aspect(0), aspect(1)],
            planes_per_voxel: rate,
            first_plane: first_plane as u32,
            base: [columns, rows],
        };
        let steepest = |axis: usize, pixels: u32| {
            let ends = [0, pixels - 1].map(|pixel| spread.exact_slope(axis, pixel).unsigned_abs());
            ends.into_iter().fold(0, u64::max)
        };
        let square = |slope: u64| (u128::from(slope).pow(2) >> (2 * SLOPE - 26)) as u64;
        if (1 << 26) + square(steepest(0, columns)) + square(steepest(1, rows))
            >= u64::from(LENGTH_MAX * LENGTH_MAX - 1) << 26
        {
            return Err(EyeError::Length);
        }
        Ok(spread)
    }

    /// The same with starts and steps of fewer fraction bits, each rounded to nearest: for studies of what a machine loses that adds
    /// up shorter ones (44 bits and more change nothing).
    #[must_use]
    pub fn with_step_bits(self, bits: u32) -> Self {
        let cut = FRACTION.saturating_sub(bits);
        let round = |bits: i64| (bits + ((1 << cut) >> 1)) >> cut << cut;
        Self {
            start: self.start.map(round),
            advance: self.advance.map(round),
            step: round(self.step),
            growth: round(self.growth),
            ..self
        }
    }

    /// The eye, voxels of the whole volume along i, j, k.
    pub const fn eye(&self) -> [Step; 3] {
        self.eye
    }

    /// Columns and rows of the image.
    pub const fn base(&self) -> [u32; 2] {
        self.base
    }

    /// Rays per voxel of the last slice.
    pub const fn rays_per_voxel(&self) -> u32 {
        self.rays
    }

    /// Where pixel 0 lies in the last slice along i and j, in pixels from its first voxel.
    pub const fn first(&self) -> [i32; 2] {
        self.first
    }

    /// The first plane that is folded.
    pub const fn first_plane(&self) -> u32 {
        self.first_plane
    }

    /// The positions of pixels along i and j on a plane. This function is the definition.
    pub fn lines(&self, plane: u32) -> [Line; 2] {
        let k = i64::from(plane);
        let step = self.step + k * self.growth;
        let ([i, j], [along_i, along_j]) = (self.start, self.advance);
        [
            Line {
                start: i + k * along_i,
                step,
            },
            Line {
                start: j + k * along_j,
                step,
            },
        ]
    }

    /// U.
    fn exact_slope(&self, axis: usize, pixel: u32) -> i64 {
        let advance = self.advance.get(axis).copied().unwrap_or(0);
        let aspect = self.aspect.get(axis).copied().unwrap_or(0);
        let along = (advance + i64::from(pixel) * self.growth) * i64::from(self.planes_per_voxel);
        // s1.30 first, which leaves room for the aspect.
        ((along >> (FRACTION - 30)) * i64::from(aspect)) >> (46 - SLOPE)
    }

    /// The slope of a pixel's ray along i (axis 0) or j (axis 1) in lengths of the world, s4.27. This function is the definition.
    #[inline]
    pub fn slope(&self, axis: usize, pixel: u32) -> i32 {
        self.exact_slope(axis, pixel) as i32
    }
}

/// The image in the last slice.
struct Image {
    rays: u32,
    way: i64,
    nearest: i64,
}

impl Image {
    /// Pixels along a side, and the first of them: those whose rays meet `side` voxels of a plane between the nearest and the last
    /// slice, and lie between the slopes.
    fn side(&self, eye: i64, side: u32, slopes: [Vector; 2]) -> Result<(u32, i32), EyeError> {
        let faces = [0, (i64::from(side) - 1) << 32];
        // A face seen on the nearest plane lies farther out in the last slice.
        let thrown = |face: i64| eye + quotient(i128::from(face - eye) * i128::from(self.way), self.nearest.into());
        let [low, high] = faces;
        let (low, high) = (low.min(thrown(low)), high.max(thrown(high)));
        let [least, greatest] =
            slopes.map(|slope| eye + ((i128::from(self.way) * i128::from(slope.to_bits())) >> 30) as i64);
        let (low, high) = (low.max(least), high.min(greatest));
        let rays = i128::from(self.rays);
        let (first, last) = (-(-(i128::from(low) * rays) >> 32), (i128::from(high) * rays) >> 32);
        if last < first {
            return Err(EyeError::Nothing);
        }
        Ok(((last - first + 1) as u32, first as i32))
    }
}

/// The square of a slope in the world, u6.26.
#[inline(always)]
pub fn square<V: Lanes>(slope: V) -> V {
    let slope = slope.abs();
    (slope.product(slope) + V::Wide::splat(1 << (2 * SLOPE - 27))).shr_narrow(2 * SLOPE - 26)
}

/// A ray's direction: what its step's length and the vector towards the eye are made of.
#[derive(Clone, Copy, Debug)]
pub struct Way<V> {
    /// The square, brought to 28 to 30 bits.
    square: V,
    /// [`Lanes::reciprocal_root`] of it.
    root: V,
    /// Half of the bits by which it was brought there, 0 to 2.
    half: V,
}

impl<V: Lanes> Way<V> {
    /// Of the squares of the slopes along i and j. This function is the definition.
    #[inline(always)]
    pub fn of([i, j]: [V; 2]) -> Self {
        let q = i.wrapping_add(j).wrapping_add(V::splat(1 << 26));
        let raised = q.leading_zeros() & V::splat(6);
        let square = q.shl_each(raised).shr_unsigned(2);
        Self {
            square,
            root: square.reciprocal_root(),
            half: raised.shr_unsigned(1),
        }
    }

    /// The length of a step, 3.20, in steps along k.
    #[inline(always)]
    pub fn length(self) -> V {
        let length = self.square.product(self.root);
        length.shr_each(self.half + V::splat(27)).narrow()
    }

    /// A component of the unit vector towards the eye, s1.30, of a slope along the same axis; along k the slope is 1
    /// ([`ALONG_K`]).
    #[inline(always)]
    pub fn towards(self, slope: V) -> V {
        let magnitude = slope.abs().product(self.root).shr_each(V::splat(20) - self.half);
        magnitude.narrow().with_sign_of(V::splat(0) - slope)
    }
}

/// The slope of a ray along k, s4.27.
pub const ALONG_K: i32 = 1 << SLOPE;

#[cfg(test)]
mod tests;
