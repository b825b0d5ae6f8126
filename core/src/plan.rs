//! The plan of a frame: a scene's geometry, checked once, and what it needs in memory.
//!
//! Everything behind a [`Plan`] can rely on it: sizes are within their limits, positions cannot overflow, and the
//! base plane covers the volume. Kernels therefore have no errors of their own.

mod faces;
mod rays;

use core::any::Any;

use crate::borders::Borders;
use crate::crop::Faces;
use crate::format::{Intensity, Step};
use crate::view::{View, ratio};

pub use rays::{LEVEL_MAX, LevelError, Rays};

/// The longest side of a volume, voxels.
pub const SIDE_MAX: u16 = 8192;
/// The largest number of sample planes behind the first: positions stay within 0.75 ulp up to here (`locate`).
pub const PLANES_MAX: u32 = 1 << 15;
/// The largest number of sample planes per voxel.
pub const PLANES_PER_VOXEL_MAX: u32 = 16;
/// The largest number of rays per voxel along one side of the base plane.
pub const RAYS_PER_VOXEL_MAX: u32 = 8;

/// Sampling rates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sampling {
    /// Sample planes per voxel along the major axis, 1 to [`PLANES_PER_VOXEL_MAX`].
    pub planes_per_voxel: u32,
    /// Rays per voxel along i and along j, 1 to [`RAYS_PER_VOXEL_MAX`]. The rays of one offset form a *phase*: an
    /// image of its own in which all samples of a plane share their weights.
    pub rays_per_voxel: u32,
}

impl Default for Sampling {
    fn default() -> Self {
        Self {
            planes_per_voxel: 1,
            rays_per_voxel: 1,
        }
    }
}

/// Voxel spacing along x, y, z, as each spacing's share of the smallest: `smallest / spacing`, 1.15. Gradients are
/// multiplied by it; unlit scenes do not read it. Only the ratios count, but factors of which none is 32768 give away
/// bits of the gradient.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spacing(pub [Intensity; 3]);

impl Spacing {
    /// Cubic voxels.
    pub const CUBIC: Self = Self([Intensity::ONE; 3]);
}

/// Which of the n x n interleaved images a ray belongs to: u and v are below n ([`Plan::phase`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Phase {
    /// Offset along i, in 1/n voxel.
    pub u: u32,
    /// Offset along j, in 1/n voxel.
    pub v: u32,
}

/// The geometry of one frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    view: View,
    volume: [u32; 3],
    faces: [Faces; 3],
    first: [u32; 3],
    dims: [u32; 3],
    spacing: [Intensity; 3],
    sampling: Sampling,
    base: [u32; 2],
    origin: [i32; 2],
    offset: [i64; 2],
    step: [Step; 3],
    nearest: bool,
    /// Whether rays come from an eye.
    spreads: bool,
    /// `None`: whole borders.
    exact: Option<&'static Exact>,
}

/// Exact borders, and the plane layer's code of them, which it knows again: a program whose plans have whole borders does not link
/// it.
pub(crate) struct Exact {
    pub(crate) borders: Borders,
    pub(crate) code: &'static (dyn Any + Sync),
}

impl PartialEq for Exact {
    fn eq(&self, other: &Self) -> bool {
        self.borders == other.borders
    }
}

impl Eq for Exact {}

impl core::fmt::Debug for Exact {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        self.borders.fmt(f)
    }
}

/// Why a scene has no plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PlanError {
    /// A side of the volume is 0 or above [`SIDE_MAX`].
    Side {
        /// The side given, voxels.
        given: u32,
    },
    /// Planes per voxel outside 1 to [`PLANES_PER_VOXEL_MAX`].
    PlanesPerVoxel {
        /// The rate given.
        given: u32,
    },
    /// Rays per voxel outside 1 to [`RAYS_PER_VOXEL_MAX`].
    RaysPerVoxel {
        /// The rate given.
        given: u32,
    },
    /// More than [`PLANES_MAX`] sample planes behind the first.
    Planes {
        /// The number that the scene has.
        given: u32,
    },
    /// A spacing factor is 0 or above 1.
    Spacing {
        /// The factor's bits, 1.15.
        bits: u16,
    },
    /// A volume one voxel thin between whose first and last voxel ([`Borders::Nodes`]) there is nothing.
    Thin,
    /// A crop box whose low face is not below its high one.
    Reversed {
        /// The axis: 0 is x, 1 is y, 2 is z.
        axis: u32,
    },
    /// A crop box that holds nothing of the volume.
    Beside {
        /// The axis along which it lies beside it.
        axis: u32,
    },
    /// A crop box in a volume with whole borders ([`Borders::Whole`]), of which a sample counts as a step or not at all.
    WholeCropped,
}

impl core::fmt::Display for PlanError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Side { given } => write!(f, "a side of {given} voxels; accepted: 1 to {SIDE_MAX}"),
            Self::PlanesPerVoxel { given } => {
                write!(f, "{given} planes per voxel; accepted: 1 to {PLANES_PER_VOXEL_MAX}")
            }
            Self::RaysPerVoxel { given } => {
                write!(f, "{given} rays per voxel; accepted: 1 to {RAYS_PER_VOXEL_MAX}")
            }
            Self::Planes { given } => {
                write!(
                    f,
                    "{given} sample planes behind the first; accepted: at most {PLANES_MAX}"
                )
            }
            Self::Spacing { bits } => write!(f, "a spacing factor of {bits}/32768; accepted: 1 to 32768"),
            Self::Thin => {
                f.write_str("borders at the outermost voxels of a side of 1 voxel; accepted: 2 voxels or more")
            }
            Self::Reversed { axis } => {
                write!(
                    f,
                    "a crop box whose low face is not below its high one along axis {axis}"
                )
            }
            Self::Beside { axis } => {
                write!(f, "a crop box that holds nothing of the volume along {}", name(*axis))
            }
            Self::WholeCropped => {
                f.write_str("a crop box with whole borders, which cut no step; accepted with a crop box: cells, nodes")
            }
        }
    }
}

impl core::error::Error for PlanError {}

impl Plan {
    /// [`Plan::new`] with [`Borders::Whole`]. A program all of whose plans are of this kind does not link what exact borders
    /// need.
    ///
    /// Base plane: one ray per voxel of the first slice and as many more as the shear needs for every voxel of the
    /// last slice to be crossed.
    ///
    /// # Errors
    /// [`PlanError`], with the value that is out of range.
    pub const fn whole(view: View, dims: [u32; 3], spacing: Spacing, sampling: Sampling) -> Result<Self, PlanError> {
        Self::of(view, dims, spacing, sampling, None)
    }

    /// Of exact borders, or of whole ones.
    ///
    /// # Errors
    /// [`PlanError`], with the value that is out of range.
    pub(crate) const fn of(
        view: View,
        dims: [u32; 3],
        spacing: Spacing,
        sampling: Sampling,
        exact: Option<&'static Exact>,
    ) -> Result<Self, PlanError> {
        let borders = borders(exact);
        if let Some(given) = first_bad(dims, SIDE_MAX as u32) {
            return Err(PlanError::Side { given });
        }
        let rate = sampling.planes_per_voxel;
        if rate == 0 || rate > PLANES_PER_VOXEL_MAX {
            return Err(PlanError::PlanesPerVoxel { given: rate });
        }
        let rays = sampling.rays_per_voxel;
        if rays == 0 || rays > RAYS_PER_VOXEL_MAX {
            return Err(PlanError::RaysPerVoxel { given: rays });
        }
        let [fx, fy, fz] = spacing.0;
        let factors = [fx.to_bits() as u32, fy.to_bits() as u32, fz.to_bits() as u32];
        if let Some(bits) = first_bad(factors, Intensity::ONE.to_bits() as u32) {
            return Err(PlanError::Spacing { bits: bits as u16 });
        }
        let volume = view.arrange(dims);
        let [width, height, depth] = volume;
        if matches!(borders, Borders::Nodes) && (width == 1 || height == 1 || depth == 1) {
            return Err(PlanError::Thin);
        }
        let planes = planes(depth, rate, borders);
        if planes - 1 > PLANES_MAX {
            return Err(PlanError::Planes { given: planes - 1 });
        }
        let [si, sj] = view.shear(rate);
        let mut plan = Self {
            view,
            volume,
            faces: [
                Faces::of(width, borders),
                Faces::of(height, borders),
                Faces::of(depth, borders),
            ],
            first: [0; 3],
            dims: volume,
            spacing: view.arrange(spacing.0),
            sampling,
            base: [0; 2],
            origin: [0; 2],
            offset: [0; 2],
            step: [si, sj, Step::from_bits(ratio(1, 1, rate) as i64)],
            nearest: false,
            spreads: false,
            exact,
        };
        if matches!(borders, Borders::Whole) {
            let (columns, origin_i) = whole_reach(si, width, planes - 1);
            let (rows, origin_j) = whole_reach(sj, height, planes - 1);
            (plan.base, plan.origin) = ([columns, rows], [origin_i, origin_j]);
        } else {
            plan.reach();
        }
        Ok(plan)
    }

    /// The same of rays that spread, with this base plane; all rays are of one phase.
    pub(crate) const fn spreading(self, base: [u32; 2]) -> Self {
        Self {
            base,
            sampling: Sampling {
                rays_per_voxel: 1,
                ..self.sampling
            },
            spreads: true,
            ..self
        }
    }

    /// Whether its rays come from an eye: those of the [`Spread`](crate::perspective::Spread) that was made with it.
    pub const fn spreads(&self) -> bool {
        self.spreads
    }

    /// Elements of the longest row: voxels of a slice or, in perspective, pixels of the image if these are more.
    pub const fn longest_row(&self) -> u32 {
        let ([width, _, _], [columns, _]) = (self.dims, self.base);
        if self.spreads && columns > width {
            columns
        } else {
            width
        }
    }

    /// The same plan with steps of fewer fraction bits, each rounded to nearest: for studies of what a machine loses that
    /// adds up a shorter step (32 bits and more change nothing). The error of a position then grows with its plane.
    #[must_use]
    pub fn with_step_bits(self, bits: u32) -> Self {
        let cut = 32u32.saturating_sub(bits);
        let round = |step: Step| Step::from_bits((step.to_bits() + ((1 << cut) >> 1)) >> cut << cut);
        Self {
            step: self.step.map(round),
            ..self
        }
    }

    /// The same plan with every sample at the voxel nearest to it, halves up: for labels, which are names and have nothing
    /// between them.
    #[must_use]
    pub const fn with_nearest(self) -> Self {
        Self { nearest: true, ..self }
    }

    /// The same plan where slices have only the voxels from `first` on, `dims` of them along i and j: for bricks of a volume that
    /// is not all at hand. Pixels, planes, phases, steps and the bits of all weights stay; positions count from the first of
    /// these voxels, and `first` from the first that was held. Samples nearer than three voxels to a face that the volume does not have are for another brick. Voxels that
    /// the volume has not are left out.
    #[must_use]
    pub const fn of_voxels(self, first: [u32; 2], dims: [u32; 2]) -> Self {
        let ([width, height, depth], [held_i, held_j, held_k]) = (self.dims, self.first);
        let (i, columns) = shortened(first[0], dims[0], width);
        let (j, rows) = shortened(first[1], dims[1], height);
        Self {
            first: [held_i + i, held_j + j, held_k],
            dims: [columns, rows, depth],
            ..self
        }
    }

    /// The same plan of an image that has only the columns from `first` on, `count` of them, which the whole image has.
    #[must_use]
    pub const fn of_columns(self, first: u32, count: u32) -> Self {
        let ([columns, rows], [oi, oj]) = (self.base, self.origin);
        let (first, count) = shortened(first, count, columns);
        Self {
            base: [count, rows],
            origin: [oi + first as i32, oj],
            ..self
        }
    }

    /// Whether samples lie at voxels ([`Plan::with_nearest`]).
    pub const fn is_nearest(&self) -> bool {
        self.nearest
    }

    /// Where the volume ends.
    #[inline(always)]
    pub const fn borders(&self) -> Borders {
        borders(self.exact)
    }

    /// What exact borders are to the plane layer.
    pub(crate) const fn exact(&self) -> Option<&'static Exact> {
        self.exact
    }

    /// The view.
    pub const fn view(&self) -> &View {
        &self.view
    }

    /// Voxels along i, j, k that are held: a slice's width and height, and the number of slices. Of a cropped plan these are
    /// the voxels that its box looks at; else all.
    pub const fn dims(&self) -> [u32; 3] {
        self.dims
    }

    /// The first voxel that is held, along i, j, k, counted in the whole volume.
    pub const fn first(&self) -> [u32; 3] {
        self.first
    }

    /// Voxels along i, j, k of the whole volume.
    pub const fn volume(&self) -> [u32; 3] {
        self.volume
    }

    /// Spacing factors along i, j, k, 1.15.
    pub const fn spacing(&self) -> [Intensity; 3] {
        self.spacing
    }

    /// Sampling rates.
    pub const fn sampling(&self) -> Sampling {
        self.sampling
    }

    /// Columns and rows of one phase of the base-plane image. The whole image has `rays_per_voxel` times as many.
    pub const fn base(&self) -> [u32; 2] {
        self.base
    }

    /// Where the ray of pixel (0, 0), phase (0, 0) starts on the whole volume's first slice: whole voxels along i and j.
    pub const fn origin(&self) -> [i32; 2] {
        self.origin
    }

    /// How far behind a phase's start ([`Plan::start`]) its rays start, in 2^-36 voxel, 0 to 2^36 - 1: not 0 of the rays of another
    /// plan alone ([`Plan::of_rays`]).
    pub const fn offset(&self) -> [i64; 2] {
        self.offset
    }

    /// Steps from plane to plane along i, j, k, voxels.
    pub const fn step(&self) -> [Step; 3] {
        self.step
    }

    /// Number of sample planes of the whole volume.
    pub const fn planes(&self) -> u32 {
        let [_, _, depth] = self.volume;
        planes(depth, self.sampling.planes_per_voxel, self.borders())
    }

    /// Number of planes at which segments between samples end, one more than there are segments along a ray of the whole volume:
    /// those of whole borders, and of cells [`Plan::ends_before`] more at each end.
    pub const fn ends(&self) -> u32 {
        let [_, _, depth] = self.volume;
        planes(depth, self.sampling.planes_per_voxel, Borders::Whole) + 2 * self.ends_before()
    }

    /// How many of them lie before the first slice: as many as reach half a voxel before it.
    pub const fn ends_before(&self) -> u32 {
        match self.borders() {
            Borders::Cells => self.sampling.planes_per_voxel.div_ceil(2),
            Borders::Whole | Borders::Nodes => 0,
        }
    }

    /// Number of phases, `rays_per_voxel` squared.
    pub const fn phases(&self) -> u32 {
        self.sampling.rays_per_voxel * self.sampling.rays_per_voxel
    }

    /// The phase with this number, 0 to [`Plan::phases`] - 1, counted along i first.
    pub const fn phase(&self, index: u32) -> Phase {
        let n = self.sampling.rays_per_voxel;
        match (index.checked_rem(n), index.checked_div(n)) {
            (Some(u), Some(v)) => Phase { u, v },
            _ => Phase { u: 0, v: 0 },
        }
    }

    /// Where a phase starts, voxels: its offset `u / n` rounded to 32 fraction bits.
    pub const fn start(&self, phase: Phase) -> [Step; 2] {
        let n = self.sampling.rays_per_voxel;
        let [oi, oj] = self.origin;
        [
            Step::from_bits(((oi as i64) << 32) + ratio(phase.u as u64, 1, n) as i64),
            Step::from_bits(((oj as i64) << 32) + ratio(phase.v as u64, 1, n) as i64),
        ]
    }
}

/// The name of an axis by its number.
const fn name(axis: u32) -> &'static str {
    match axis {
        0 => "x",
        1 => "y",
        _ => "z",
    }
}

/// A run of `count` from `first` on, one at least, in a side of `side`, which is not 0.
const fn shortened(first: u32, count: u32, side: u32) -> (u32, u32) {
    let first = if first < side { first } else { side - 1 };
    let left = side - first;
    let count = if count == 0 { 1 } else { count };
    (first, if count < left { count } else { left })
}

/// The borders that a plan's reference stands for.
const fn borders(exact: Option<&'static Exact>) -> Borders {
    match exact {
        None => Borders::Whole,
        Some(exact) => exact.borders,
    }
}

/// The first number that is 0 or above a limit.
const fn first_bad([x, y, z]: [u32; 3], most: u32) -> Option<u32> {
    if x == 0 || x > most {
        Some(x)
    } else if y == 0 || y > most {
        Some(y)
    } else if z == 0 || z > most {
        Some(z)
    } else {
        None
    }
}

/// Sample planes of so many slices: one in each slice and those between, or one in the middle of each segment.
const fn planes(depth: u32, rate: u32, borders: Borders) -> u32 {
    match borders {
        Borders::Whole => (depth - 1) * rate + 1,
        Borders::Cells => depth * rate,
        Borders::Nodes => (depth - 1) * rate,
    }
}

/// A pixel per voxel, and one per whole voxel that a ray travels, rounded up; the first starts back by as much where it
/// travels up.
const fn whole_reach(step: Step, side: u32, planes: u32) -> (u32, i32) {
    let total = step.to_bits() * planes as i64;
    let voxels = (total.unsigned_abs() + 0xffff_ffff) >> 32;
    let origin = if total > 0 { -(voxels as i32) } else { 0 };
    (side + voxels as u32, origin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::Direction;

    fn plan(direction: [f64; 3], dims: [u32; 3], sampling: Sampling) -> Result<Plan, PlanError> {
        let view = View::new(direction.map(|c| Direction::from_bits((c * (1u64 << 58) as f64) as i64))).unwrap();
        Plan::whole(view, dims, Spacing::CUBIC, sampling)
    }

    #[test]
    fn base_plane_of_an_axis_aligned_view_is_the_slice() {
        let p = plan([0.0, 1.0, 0.0], [5, 7, 3], Sampling::default()).unwrap();
        assert_eq!((p.base(), p.origin(), p.planes()), ([5, 3], [0, 0], 7));
    }

    #[test]
    fn base_plane_grows_with_the_shear_on_the_right_side() {
        let p = plan([0.5, -0.25, 1.0], [8, 8, 9], Sampling::default()).unwrap();
        assert_eq!((p.base(), p.origin()), ([12, 10], [-4, 0]));
        // Just beyond a whole voxel: one more column.
        let p = plan([0.500001, -0.25, 1.0], [8, 8, 9], Sampling::default()).unwrap();
        assert_eq!((p.base(), p.origin()), ([13, 10], [-5, 0]));
    }

    #[test]
    fn shorter_steps_are_the_nearest() {
        let p = plan(
            [0.5, -0.3, 1.0],
            [8, 8, 9],
            Sampling {
                planes_per_voxel: 3,
                rays_per_voxel: 1,
            },
        )
        .unwrap();
        assert_eq!(p.with_step_bits(32), p);
        assert_eq!(p.with_step_bits(40), p);
        for bits in [6u32, 12, 16] {
            for (short, exact) in p.with_step_bits(bits).step().into_iter().zip(p.step()) {
                let unit = 1i64 << (32 - bits);
                assert_eq!(short.to_bits() % unit, 0);
                assert!((short.to_bits() - exact.to_bits()).abs() <= unit / 2);
            }
        }
        // A third of a voxel in six bits: 21/64.
        assert_eq!(p.with_step_bits(6).step().map(|s| s.to_bits() >> 26), [11, -6, 21]);
    }

    /// Samples of a brick lie where those of the whole do, whatever their phase and plane.
    #[test]
    fn bricks_have_the_positions_of_the_whole() {
        let sampling = Sampling {
            planes_per_voxel: 3,
            rays_per_voxel: 3,
        };
        for borders in [Borders::Whole, Borders::Cells, Borders::Nodes] {
            let view = View::new([0.37, -0.61, 1.0].map(|c| Direction::from_bits((c * (1u64 << 58) as f64) as i64)));
            let whole = Plan::with_borders(view.unwrap(), [40, 50, 60], Spacing::CUBIC, sampling, borders).unwrap();
            let brick = whole.of_voxels([7, 11], [20, 100]).of_columns(5, 9);
            assert_eq!((brick.dims(), brick.base()), ([20, 39, 60], [9, whole.base()[1]]));
            for phase in (0..whole.phases()).map(|number| whole.phase(number)) {
                for index in 0..whole.planes() {
                    let [a, b] = [whole, brick].map(|plan| crate::locate::plane(&plan, phase, index));
                    assert_eq!(a.x.to_bits() - b.x.to_bits(), (7 - 5) << 16);
                    assert_eq!(a.y.to_bits() - b.y.to_bits(), 11 << 16);
                    assert_eq!(a.z, b.z);
                }
            }
        }
        assert_eq!(
            (shortened(9, 0, 4), shortened(0, 9, 4), shortened(1, 2, 4)),
            ((3, 1), (0, 4), (1, 2))
        );
    }

    #[test]
    fn limits_are_named() {
        let rate = |planes_per_voxel, rays_per_voxel| Sampling {
            planes_per_voxel,
            rays_per_voxel,
        };
        let z = [0.0, 0.0, 1.0];
        assert_eq!(plan(z, [0, 1, 1], rate(1, 1)), Err(PlanError::Side { given: 0 }));
        assert_eq!(plan(z, [1, 8193, 1], rate(1, 1)), Err(PlanError::Side { given: 8193 }));
        assert_eq!(
            plan(z, [1, 1, 1], rate(17, 1)),
            Err(PlanError::PlanesPerVoxel { given: 17 })
        );
        assert_eq!(
            plan(z, [1, 1, 1], rate(1, 0)),
            Err(PlanError::RaysPerVoxel { given: 0 })
        );
        assert_eq!(
            plan(z, [1, 1, 8192], rate(16, 1)),
            Err(PlanError::Planes { given: 8191 * 16 })
        );
        assert!(plan(z, [1, 1, 2049], rate(16, 1)).is_ok());
        let view = View::new([Direction::ZERO, Direction::ZERO, Direction::from_bits(1)]).unwrap();
        let flat = Spacing([Intensity::ONE, Intensity::ZERO, Intensity::ONE]);
        assert_eq!(
            Plan::whole(view, [1; 3], flat, Sampling::default()),
            Err(PlanError::Spacing { bits: 0 })
        );
    }
}
