//! Clip planes: what half spaces and slabs leave of each segment of a ray, with a hard face or a soft one.
//!
//! Source: the cut planes of VolumePro (Pfister et al. 1999); `docs/contract/clip.md` has the formulas and ranges.
//!
//! | value | format | unit |
//! |---|---|---|
//! | slope of a plane along x, y, z | s1.30 | lengths per voxel |
//! | distance v, thickness, falloff | s33.30 | lengths |
//! | cut of a segment, from .. to | 0.16, both ends included | segments |
//! | fade | 0.16, 65536 is 1 | share of the optical depth |
//!
//! A length is what the caller says: a voxel, or a millimetre divided so that no slope is above 1. Rounding: a distance down, to
//! 2^-30 a term; cuts and fades to nearest. Overflow: none inside [`Clips`]. State: none.

mod cue;
mod pieces;
mod remainder;
mod rows;

pub use self::cue::{Cue, CuePlane};
pub(crate) use self::pieces::{Boxed, Distances, Left};
use self::remainder::Ramp;
pub use self::remainder::Remainder;
pub(crate) use self::rows::Clipping;
use self::rows::RowKernels;
use crate::borders::{Borders, Part, WHOLE};
use crate::format::{Distance, Intensity, Vector};
use crate::lanes::{Lanes, Native};
use crate::plan::Plan;

/// The most clip planes of a scene.
pub const CLIPS_MAX: usize = 6;
/// The longest distance, thickness and falloff, lengths.
pub const DISTANCE_MAX: Distance = Distance::from_bits(1 << 46);

/// A clip plane: it leaves what lies on the side that its normal points to, or a slab of some thickness behind it there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clip {
    /// By how many lengths the distance grows per voxel along x, y and z, none beyond -1 to 1: the normal.
    pub slope: [Vector; 3],
    /// The distance of the centre of the volume's first voxel, above 0 on the side that is left.
    pub distance: Distance,
    /// Where what is left ends again, behind the plane.
    pub thickness: Option<Distance>,
    /// The width of the ramp on which the optical depth goes from none to all, half of it on each side of a face.
    pub falloff: Distance,
    /// Whether the slab, or the side, is cut away, and everything else left.
    pub outside: bool,
}

/// Why clip planes are none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ClipError {
    /// More than [`CLIPS_MAX`].
    TooMany {
        /// How many.
        given: usize,
    },
    /// A plane's slopes are all 0.
    NoNormal {
        /// Number of the plane.
        number: usize,
    },
    /// A plane's slope is beyond -1 to 1.
    Slope {
        /// Number of the plane.
        number: usize,
    },
    /// A plane's distance is beyond [`DISTANCE_MAX`], its falloff is as well or below 0, or its thickness is not above 0.
    Length {
        /// Number of the plane.
        number: usize,
    },
    /// Depth cueing has a slope, a distance, a depth, a share or a colour that is out of range.
    Cue,
}

impl core::fmt::Display for ClipError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::TooMany { given } => write!(f, "{given} clip planes; accepted: at most {CLIPS_MAX}"),
            Self::Cue => f.write_str(
                "depth cueing has a slope, a distance, a depth, a share or a colour out of range; accepted: -1 to 1, -65536 to 65536, above 0 to 65536, \
                 0 to 1, 0 to 1",
            ),
            Self::NoNormal { number } => write!(f, "clip plane {number} has no normal"),
            Self::Slope { number } => write!(f, "clip plane {number} has a slope beyond -1 to 1"),
            Self::Length { number } => write!(
                f,
                "clip plane {number} has a distance, thickness or falloff out of range; accepted: -65536 to 65536, above 0 to 65536, 0 to 65536"
            ),
        }
    }
}

impl core::error::Error for ClipError {}

/// A clip plane in the slice frame of a view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClipPlane {
    /// Slopes along i, j and k, 2^-30 length per voxel.
    pub slope: [i64; 3],
    /// The distance of the slice frame's first voxel, 2^-30 length.
    pub distance: i64,
    /// The distance of the far face; 0: there is none.
    pub thickness: i64,
    /// What fades; `None`: segments are cut.
    ramp: Option<Ramp>,
    /// Whether what lies between the faces is cut away.
    outside: bool,
}

impl ClipPlane {
    fn of(plan: &Plan, clip: &Clip) -> Self {
        let (slope, distance) = arranged(plan, clip.slope, clip.distance);
        let falloff = clip.falloff.to_bits();
        let mut along = 0;
        for (slope, step) in slope.iter().zip(plan.step()) {
            along += times(*slope, 2 * step.to_bits());
        }
        Self {
            slope,
            distance,
            thickness: clip.thickness.map_or(0, Distance::to_bits),
            // A ramp that lies within a segment is a face.
            ramp: (falloff > along.abs()).then(|| Ramp::of(falloff)),
            outside: clip.outside,
        }
    }

    /// Two numbers that grow with the distances of a segment's ends from a face: below 0 the first says that nothing is left of
    /// it, from 0 on the second says that all is.
    fn bounds(&self, [front, back]: [i64; 2]) -> [i64; 2] {
        match self.ramp {
            None => [front.max(back), front.min(back)],
            Some(Ramp { width, .. }) => {
                let sum = (front + back + (width >> 1)) >> 1;
                [sum, sum - (width >> 1)]
            }
        }
    }

    /// Whether what lies between the faces is cut away.
    const fn is_outside(&self) -> bool {
        self.outside
    }

    /// Whether nothing is left of segments whose ends have distances from `least` to `most`.
    fn hides(&self, [least, most]: [i64; 2]) -> bool {
        let from_behind = |distance: i64| self.thickness - distance;
        if self.outside {
            let [_, near] = self.bounds([least; 2]);
            let [_, far] = self.bounds([from_behind(most); 2]);
            return near >= 0 && (self.thickness == 0 || far >= 0);
        }
        let [near, _] = self.bounds([most; 2]);
        let [far, _] = self.bounds([from_behind(least); 2]);
        near < 0 || self.thickness > 0 && far < 0
    }

    /// What a face leaves of a segment whose ends have these distances from it.
    fn face(&self, [front, back]: [i64; 2]) -> Remainder {
        if let Some(ramp) = self.ramp {
            let falloff = ramp.width >> 1;
            return Remainder {
                part: Part::WHOLE,
                fade: ramp.share(front + back + falloff),
            };
        }
        let part = match (front >= 0, back >= 0) {
            (true, true) => Part::WHOLE,
            (false, false) => Part::NONE,
            (false, true) => Part {
                from: share(-front, back - front),
                to: WHOLE,
            },
            (true, false) => Part {
                from: 0,
                to: share(front, front - back),
            },
        };
        Remainder { part, fade: WHOLE }
    }

    /// What the plane leaves of a segment, given the distances of its front and its back end. This function is the definition.
    pub fn cut(&self, ends: [i64; 2]) -> Remainder {
        let mut inside = self.face(ends);
        if self.thickness > 0 {
            inside = inside.and(self.face(ends.map(|distance| self.thickness - distance)));
        }
        if !self.outside {
            return inside;
        }
        let Remainder {
            part: Part { from, to },
            fade,
        } = inside;
        // A fade, or a piece in the middle, takes its share of the whole segment; a piece at an end leaves the other.
        let (whole, none) = (inside.part.length() > 0, Part::WHOLE);
        match (whole && fade == WHOLE, from, to) {
            (true, 0, to) => Remainder {
                part: Part { from: to, to: WHOLE },
                fade,
            },
            (true, from, WHOLE) => Remainder {
                part: Part { from: 0, to: from },
                fade,
            },
            _ => Remainder {
                part: none,
                fade: WHOLE - inside.weight(),
            },
        }
    }
}

/// A distance that is linear along x, y and z, along i, j and k: its slopes, and its value at the slice frame's first voxel.
fn arranged(plan: &Plan, slope: [Vector; 3], distance: Distance) -> ([i64; 3], i64) {
    let view = plan.view();
    let [_, _, depth] = plan.volume();
    let [i, j, k] = view.arrange(slope.map(|slope| i64::from(slope.to_bits())));
    let distance = distance.to_bits();
    if view.reversed() {
        ([i, j, -k], distance + k * (i64::from(depth) - 1))
    } else {
        ([i, j, k], distance)
    }
}

/// A distance along a segment of this length, as its share, to nearest. A segment is at most 2^33 long.
fn share(distance: i64, length: i64) -> u32 {
    let (distance, length) = (distance as u64, length as u64);
    ((distance << 17) + length).checked_div(2 * length).unwrap_or(0) as u32
}

/// `slope x`, rounded down: x in units of 2^-33 voxel, below 2^48.
const fn times(slope: i64, x: i64) -> i64 {
    // The nested floors are the floor of the whole.
    (slope * (x >> 17) + ((slope * (x & 0x1_ffff)) >> 17)) >> 16
}

/// The clip planes of a plan, and its depth cueing.
#[derive(Clone, Debug)]
pub struct Clips {
    planes: [ClipPlane; CLIPS_MAX],
    count: usize,
    cue: Option<CuePlane>,
    rows: RowKernels,
}

impl Clips {
    /// Clip planes, along x, y, z in the volume of a plan.
    ///
    /// # Errors
    /// [`ClipError`], with the number of the plane, counted from 0.
    pub fn new(plan: &Plan, clips: &[Clip]) -> Result<Self, ClipError> {
        let mut planes = [ClipPlane::default(); CLIPS_MAX];
        if clips.len() > CLIPS_MAX {
            return Err(ClipError::TooMany { given: clips.len() });
        }
        for (number, (clip, plane)) in clips.iter().zip(&mut planes).enumerate() {
            check(number, clip)?;
            *plane = ClipPlane::of(plan, clip);
        }
        Ok(Self {
            planes,
            count: clips.len(),
            cue: None,
            rows: RowKernels::of::<Native>(),
        })
    }

    /// The same, which fade and turn rows in these lanes; the bits do not depend on them.
    #[must_use]
    pub const fn in_lanes<V: Lanes>(self) -> Self {
        Self {
            rows: RowKernels::of::<V>(),
            ..self
        }
    }

    /// The same with depth cueing.
    ///
    /// # Errors
    /// [`ClipError::Cue`].
    pub fn with_cue(self, plan: &Plan, cue: &Cue) -> Result<Self, ClipError> {
        let most = DISTANCE_MAX.to_bits();
        let depth = cue.depth.to_bits();
        let far = cue.distance.to_bits().unsigned_abs() > most.unsigned_abs();
        let bright = cue.colour.iter().any(|c| *c > Intensity::ONE);
        if cue.slope.iter().any(is_steep) || far || bright || !(1..=most).contains(&depth) || cue.most > WHOLE {
            return Err(ClipError::Cue);
        }
        let cue = CuePlane::of(cue, arranged(plan, cue.slope, cue.distance));
        Ok(Self { cue: Some(cue), ..self })
    }

    /// Depth cueing.
    pub const fn cue(&self) -> Option<&CuePlane> {
        self.cue.as_ref()
    }

    /// For [`At::clips`](crate::plane::At::clips).
    pub fn clipper(&self) -> Clipper<'_> {
        Clipper(self)
    }

    /// Whether nothing is left of segments that lie between two places of the slice frame, in whole voxels within 2^15 along
    /// i, j and k: what a program need not read.
    pub fn hides(&self, low: [i64; 3], high: [i64; 3]) -> bool {
        self.planes().iter().any(|plane| {
            let (mut least, mut most) = (plane.distance, plane.distance);
            for ((slope, low), high) in plane.slope.iter().zip(low).zip(high) {
                let ends = [slope * low, slope * high];
                least += ends[0].min(ends[1]);
                most += ends[0].max(ends[1]);
            }
            plane.hides([least, most])
        })
    }

    /// The planes.
    pub fn planes(&self) -> &[ClipPlane] {
        self.planes.get(..self.count).unwrap_or(&[])
    }
}

/// Clip planes as the plane layer takes them ([`Clips::clipper`]): a program that makes none does not link them.
#[derive(Clone, Copy, Debug)]
pub struct Clipper<'c>(pub(crate) &'c dyn Clipping);

/// Where a segment begins, in half steps from the first slice: that about the samples of a plane with this number, or that which
/// ends at it.
pub fn halves(plan: &Plan, index: u32, slabs: bool) -> i64 {
    let (twice, rate) = (2 * i64::from(index), i64::from(plan.sampling().planes_per_voxel));
    match plan.borders() {
        _ if slabs => twice - 2 - 2 * i64::from(plan.ends_before()),
        Borders::Whole => twice - 1,
        Borders::Nodes => twice,
        Borders::Cells => twice - rate,
    }
}

/// Whether a slope is beyond -1 to 1.
fn is_steep(slope: &Vector) -> bool {
    slope.to_bits().unsigned_abs() > 1 << 30
}

fn check(number: usize, clip: &Clip) -> Result<(), ClipError> {
    let most = DISTANCE_MAX.to_bits();
    let thickness = clip.thickness.map_or(1, Distance::to_bits);
    if clip.slope.iter().all(|slope| slope.to_bits() == 0) {
        Err(ClipError::NoNormal { number })
    } else if clip.slope.iter().any(is_steep) {
        Err(ClipError::Slope { number })
    } else if clip.distance.to_bits().unsigned_abs() > most.unsigned_abs()
        || !(1..=most).contains(&thickness)
        || !(0..=most).contains(&clip.falloff.to_bits())
    {
        Err(ClipError::Length { number })
    } else {
        Ok(())
    }
}

#[cfg(test)]
mod tests;
