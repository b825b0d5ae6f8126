//! Where the samples and segments of a ray lie, and what of them counts.

use slicecast::borders::{Borders, Part, WHOLE};
use slicecast::clip::{Remainder, halves};
use slicecast::composite::Recurrence as _;
use slicecast::format::{Position, Step, Weight};
use slicecast::locate::{cell, middle, position, settled};
use slicecast::perspective::{ALONG_K, Spread, Way, square};
use slicecast::precision::Precision;
use slicecast::sides::Side;
use slicecast::sides::about_k;
use slicecast::sides::along_k;

use super::{Cells, Rays, Visit, Witness, clips};
use slicecast_scene::Blend;

/// A sample, or a segment that ends at it.
pub(super) struct Located {
    pub(super) cells: Cells,
    /// The sample in front, of a segment.
    pub(super) front: Option<Cells>,
    pub(super) visit: Visit,
    /// What of the segment lies in the volume, 0.16.
    pub(super) fraction: u32,
    /// What clip planes leave of that; `None` is nothing.
    pub(super) left: Option<Remainder>,
    /// In perspective.
    pub(super) way: Option<Direction>,
}

/// The direction of a ray from an eye.
#[derive(Clone, Copy)]
pub(super) struct Direction {
    /// The length of its steps.
    pub(super) length: i32,
    /// Towards the eye.
    pub(super) towards: [i32; 3],
}

impl Direction {
    fn of(spread: &Spread, ray: &Ray) -> Self {
        let [i, j] = [(0, ray.column), (1, ray.row)].map(|(axis, pixel)| spread.slope(axis, pixel));
        let way = Way::of([square(i), square(j)]);
        Self {
            length: way.length(),
            towards: [i, j, ALONG_K].map(|slope| way.towards(slope)),
        }
    }
}

/// What counts of a segment: its ends, and which part of it that is.
pub(super) struct Segment {
    pub(super) ends: [Cells; 2],
    pub(super) part: Part,
    pub(super) left: Option<Remainder>,
}

/// A ray of the base plane.
pub(super) struct Ray {
    /// Where its phase starts.
    pub(super) start: [Step; 2],
    pub(super) phase: u32,
    pub(super) column: u32,
    pub(super) row: u32,
}

impl Ray {
    /// Its own place on the first slice.
    fn first(&self) -> [Step; 2] {
        let [i, j] = self.start;
        let pixel = |pixel: u32| Step::from_bits(i64::from(pixel) << 32);
        [i + pixel(self.column), j + pixel(self.row)]
    }
}

impl<P: Precision> Rays<'_, P> {
    /// The ray of pixel (u, v).
    pub(super) fn ray(&self, [u, v]: [u32; 2]) -> Ray {
        let n = self.plan.sampling().rays_per_voxel;
        let [oi, oj] = self.plan.origin();
        // The phase's offset to the nearest 2^-32, halves up.
        let start = |origin: i32, phase: u32| {
            let offset = ((u64::from(phase) << 33) + u64::from(n)) / (2 * u64::from(n));
            Step::from_bits((i64::from(origin) << 32) + offset as i64)
        };
        Ray {
            start: [start(oi, u % n), start(oj, v % n)],
            phase: u % n + v % n * n,
            column: u / n,
            row: v / n,
        }
    }

    /// Cells of a ray's sample on a plane, those of the sample in front of it where segments are classified, and the fraction
    /// of its segment in the volume, or `None` outside.
    #[inline(always)]
    pub(super) fn locate<W: Witness>(&self, ray: &Ray, step: u32, witness: &mut W) -> Option<Located> {
        let index = self.index(step);
        if let Some(spread) = self.spread {
            return self.locate_in_perspective(spread, ray, step, witness);
        }
        let positions = match self.segments {
            None => self.positions(ray, index),
            Some(_) => self.cut(ray, index, 0),
        };
        let visit = Visit {
            step,
            phase: ray.phase,
            row: ray.row,
            column: ray.column,
            part: 0,
        };
        witness.location(step, visit.phase, self.in_held(positions));
        if self.segments.is_some() {
            // No segment ends at the first plane.
            let Segment {
                ends: [front, cells],
                part,
                left,
            } = self.segment(ray, index.checked_sub(1)?)?;
            return Some(Located {
                cells,
                front: Some(front),
                visit,
                fraction: part.length(),
                left,
                way: None,
            });
        }
        if self.plan.borders() == Borders::Whole {
            let cells = self.cells(ray, positions)?;
            let left = self.left(ray, index, false, Part::WHOLE);
            return Some(Located {
                cells,
                front: None,
                visit,
                fraction: WHOLE,
                left,
                way: None,
            });
        }
        let part = |axis: usize, pixel| Side::of(self.plan, ray.start[axis], axis, index).part(pixel);
        let part = part(0, ray.column).and(part(1, ray.row)).and(about_k(self.plan, index));
        let fraction = part.length();
        (fraction > 0).then(|| Located {
            cells: self.held(ray, positions),
            front: None,
            visit,
            fraction,
            left: self.left(ray, index, false, part),
            way: None,
        })
    }

    /// [`Rays::locate`] of a ray from an eye.
    fn locate_in_perspective<W: Witness>(
        &self,
        spread: &Spread,
        ray: &Ray,
        step: u32,
        witness: &mut W,
    ) -> Option<Located> {
        let index = self.index(step);
        let [_, _, sk] = self.plan.step();
        let z = position(Step::ZERO, sk, index);
        let lines = spread.lines(index);
        let at = [lines[0].exact(ray.column), lines[1].exact(ray.row)];
        let visit = Visit {
            step,
            phase: 0,
            row: ray.row,
            column: ray.column,
            part: 0,
        };
        // A plane has no place of its own along i and j.
        witness.location(step, 0, [0, 0, z.to_bits()]);
        if index < spread.first_plane() {
            return None;
        }
        let sides = at.iter().zip(self.grid.last);
        let inside = sides
            .into_iter()
            .all(|(at, last)| (0..=i64::from(last) << 16).contains(at));
        inside.then(|| Located {
            cells: [at[0], at[1], z.to_bits().into()].map(|at| cell(Position::from_bits(at as i32))),
            front: None,
            visit,
            fraction: WHOLE,
            left: Some(Remainder::WHOLE),
            way: Some(Direction::of(spread, ray)),
        })
    }

    /// What counts of a ray's segment behind a plane at which segments end: what lies in the volume, from sample to sample.
    #[inline(always)]
    pub(super) fn segment(&self, ray: &Ray, index: u32) -> Option<Segment> {
        if self.plan.borders() == Borders::Whole {
            let ends = [index, index + 1].map(|index| self.cells(ray, self.cut(ray, index, 0)));
            let [Some(front), Some(back)] = ends else { return None };
            return Some(Segment {
                ends: [front, back],
                part: Part::WHOLE,
                left: self.left(ray, index + 1, true, Part::WHOLE),
            });
        }
        let along = |axis: usize, pixel| Side::behind(self.plan, ray.start[axis], axis, index).part(pixel);
        let part = along(0, ray.column)
            .and(along(1, ray.row))
            .and(along_k(self.plan, index));
        let ends = [part.from, part.to].map(|place| self.held(ray, self.cut(ray, index, place)));
        (part.length() > 0).then(|| Segment {
            ends,
            part,
            left: self.left(ray, index + 1, true, part),
        })
    }

    /// What clip planes leave of a part of a ray's segment: of that about a plane's sample, or of that which ends at a plane.
    /// `None` is nothing.
    #[inline(always)]
    fn left(&self, ray: &Ray, index: u32, segments: bool, part: Part) -> Option<Remainder> {
        if self.clips.is_empty() {
            return Some(Remainder::WHOLE);
        }
        let left = clips::left(
            self.clips,
            self.plan,
            ray.first(),
            halves(self.plan, index, segments),
            part,
        );
        (left.weight() > 0).then_some(left)
    }

    /// A colour as depth cueing turns it.
    pub(super) fn turned(&self, ray: &Ray, index: u32, colour: [u32; 3]) -> [u32; 3] {
        let Some(cue) = self.cue else { return colour };
        let halves = halves(self.plan, index, self.segments.is_some());
        let ends = clips::ends(cue.slope, cue.distance, self.plan, ray.first(), halves);
        cue.turned(colour, self.precision.pixel().colour_bits(), cue.share(ends))
    }

    /// Where the first pixel of a ray's phase lies at a place of the segment behind a plane at which segments end.
    #[inline(always)]
    fn cut(&self, ray: &Ray, index: u32, place: u32) -> [Position; 3] {
        let [si, sj, sk] = self.plan.step();
        let [start_i, start_j] = ray.start;
        let before = match self.plan.borders() {
            Borders::Cells => self.plan.sampling().planes_per_voxel.div_ceil(2),
            Borders::Whole | Borders::Nodes => 0,
        };
        let [oi, oj] = self.plan.offset();
        let [x, y, z] = [(start_i, oi, si), (start_j, oj, sj), (Step::ZERO, 0, sk)].map(|(start, offset, step)| {
            // The place to the nearest 2^-32 voxel, halves up; then the sum to the nearest 2^-16.
            let part = (i64::from(place) * step.to_bits() + 0x8000) >> 16;
            let steps = i64::from(index) - i64::from(before);
            let exact = 16 * (start.to_bits() + steps * step.to_bits() + part) + offset;
            settled(self.plan, Position::from_bits(((exact + 0x80000) >> 20) as i32))
        });
        [x, y, self.in_slices(z)]
    }

    /// A position in the volume, counted from the first voxel that the plan holds. Rays look at the whole volume: what a plan holds
    /// must do as well.
    pub(super) fn in_held(&self, position: [Position; 3]) -> [i32; 3] {
        let first = self.plan.first();
        [0, 1, 2].map(|axis| position[axis].to_bits() - ((first[axis] as i32) << 16))
    }

    /// A position along k held to the slices.
    fn in_slices(&self, z: Position) -> Position {
        Position::from_bits(z.to_bits().clamp(0, self.grid.last[2] << 16))
    }

    /// Where the first pixel of a ray's phase lies on a plane.
    #[inline(always)]
    fn positions(&self, ray: &Ray, index: u32) -> [Position; 3] {
        let [si, sj, sk] = self.plan.step();
        let [start_i, start_j] = ray.start;
        let halves = 2 * i64::from(index) + 1;
        let rate = i64::from(self.plan.sampling().planes_per_voxel);
        let [oi, oj] = self.plan.offset();
        let [x, y, z] = [(start_i, oi, si), (start_j, oj, sj), (Step::ZERO, 0, sk)].map(|(start, offset, step)| {
            let at = match self.plan.borders() {
                Borders::Whole => position(start, step, index),
                Borders::Nodes => middle(start, offset, step, halves),
                Borders::Cells => middle(start, offset, step, halves - rate),
            };
            settled(self.plan, at)
        });
        [x, y, self.in_slices(z)]
    }

    /// The cells of a ray's sample, held to the voxels.
    fn held(&self, ray: &Ray, positions: [Position; 3]) -> Cells {
        let [x, y, z] = positions.map(|position| i64::from(position.to_bits()));
        let own = [x + (i64::from(ray.column) << 16), y + (i64::from(ray.row) << 16), z];
        [0, 1, 2].map(|axis| {
            let last = i64::from(self.grid.last[axis]) << 16;
            cell(Position::from_bits(own[axis].clamp(0, last) as i32))
        })
    }

    /// The cells of a ray's sample, or `None` outside the volume.
    #[inline(always)]
    fn cells(&self, ray: &Ray, positions: [Position; 3]) -> Option<Cells> {
        let mut cells = positions.map(cell);
        cells[0].index += ray.column as i32;
        cells[1].index += ray.row as i32;
        for (cell, last) in cells.iter().zip(&self.grid.last) {
            let inside = 0 <= cell.index && (cell.index < *last || cell.index == *last && cell.weight == Weight::ZERO);
            if !inside {
                return None;
            }
        }
        Some(cells)
    }

    /// Planes of samples, or those at which segments end.
    pub(super) fn planes(&self) -> u32 {
        match self.segments {
            None => self.plan.planes(),
            Some(_) => self.plan.ends(),
        }
    }

    pub(super) fn index(&self, step: u32) -> u32 {
        if self.blend == Blend::BackToFront {
            self.planes() - 1 - step
        } else {
            step
        }
    }
}
