//! What is reckoned of rows of segments: what is left of them, fades, and colours that turn.

use core::marker::PhantomData;
use core::ops::Range;

use super::pieces::{Boxed, Distances, Left, Pieces, of_rows};
use super::{CLIPS_MAX, Clips, CuePlane, Remainder, cue, halves, times};
use crate::borders::{fraction_row, fractions_row};
use crate::lanes::{Kernel, Lanes, Native};
use crate::plan::{Phase, Plan};
use crate::rows::{part, part_mut};

/// What is reckoned of rows, compiled for lanes.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowKernels {
    /// Makes opacities those of shares of the step.
    fade: fn(&mut [i32], &[i32]),
    /// Turns a channel of colours into another by shares.
    turn: fn(&mut [i32], u32, &[i32]),
}

impl RowKernels {
    pub(super) const fn of<V: Lanes>() -> Self {
        Self {
            fade: fade_by::<V>,
            turn: cue::turn_by::<V>,
        }
    }
}

fn fade_by<V: Lanes>(opacities: &mut [i32], shares: &[i32]) {
    V::enter((Fade, PhantomData::<V>, opacities, shares));
}

struct Fade;

impl<V: Lanes> Kernel for (Fade, PhantomData<V>, &mut [i32], &[i32]) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, _, opacities, shares) = self;
        fractions_row::<V>(opacities, shares);
    }
}

/// Columns whose shares are at hand at a time.
const BATCH: usize = 64;

/// What the plane layer asks of clip planes. Behind a reference, so that a program without them does not link it.
pub(crate) trait Clipping: core::fmt::Debug + Sync {
    /// The distances of the ends of pixel (0, 0)'s segment: of those about the samples of a plane, or of those that end at it.
    fn distances(&self, plan: &Plan, phase: Phase, index: u32, slabs: bool) -> Distances;
    /// The columns of a row of which something may be left, and a range of those that a plane may cut.
    fn reach(&self, distances: &Distances, boxed: &Boxed, row: u32) -> [Range<usize>; 2];
    /// What is left of some rows and columns.
    fn left(&self, distances: &Distances, columns: &Range<usize>, rows: &Range<u32>) -> Left;
    /// Goes through a span of a row, counted from the first column: what is left of runs of segments.
    fn each(
        &self,
        distances: &Distances,
        boxed: &Boxed,
        at: (u32, Range<usize>),
        see: &mut dyn FnMut(Range<usize>, Remainder),
    );
    /// Makes the opacities of such a span, of samples, those of what is left.
    fn weigh(&self, distances: &Distances, boxed: &Boxed, at: (u32, Range<usize>), opacities: &mut [i32]);
    /// Makes opacities those of a share of the step.
    fn fade(&self, opacities: &mut [i32], share: u32);
    /// Whether colours turn with depth.
    fn cues(&self) -> bool;
    /// Turns the colours, of so many bits, of a row of segments, from a column of pixels on.
    fn turn(&self, distances: &Distances, at: (u32, usize), colours: [&mut [i32]; 3], bits: u32);
    /// Turns colours times extinction alike.
    fn turn_weighted(&self, distances: &Distances, at: (u32, usize), extinction: &[i32], colours: [&mut [i32]; 3]);
}

impl Clipping for Clips {
    fn distances(&self, plan: &Plan, phase: Phase, index: u32, slabs: bool) -> Distances {
        let halves = halves(plan, index, slabs);
        let [start_i, start_j] = plan.start(phase);
        let at = |halves: i64| {
            let [i, j, k] = plan.step().map(|step| halves * step.to_bits());
            [2 * start_i.to_bits() + i, 2 * start_j.to_bits() + j, k]
        };
        let ends = [at(halves), at(halves + 2)];
        let of =
            |[i, j, k]: [i64; 3], first: i64| ends.map(|[x, y, z]| first + times(i, x) + times(j, y) + times(k, z));
        let mut distances = [[0; 2]; CLIPS_MAX + 1];
        for (plane, distances) in self.planes().iter().zip(&mut distances) {
            *distances = of(plane.slope, plane.distance);
        }
        if let (Some(cue), [.., distances]) = (&self.cue, &mut distances) {
            *distances = of(cue.slope, cue.distance);
        }
        distances
    }

    fn reach(&self, distances: &Distances, boxed: &Boxed, row: u32) -> [Range<usize>; 2] {
        Pieces::of(self, distances, boxed, row).reach()
    }

    fn left(&self, distances: &Distances, columns: &Range<usize>, rows: &Range<u32>) -> Left {
        of_rows(self, distances, columns, rows)
    }

    fn each(
        &self,
        distances: &Distances,
        boxed: &Boxed,
        (row, span): (u32, Range<usize>),
        see: &mut dyn FnMut(Range<usize>, Remainder),
    ) {
        for (columns, left) in Pieces::of(self, distances, boxed, row).span(&span) {
            see(columns, left);
        }
    }

    fn weigh(&self, distances: &Distances, boxed: &Boxed, (row, span): (u32, Range<usize>), opacities: &mut [i32]) {
        // Columns that are cut, side by side.
        let (mut shares, mut first, mut count) = ([0; BATCH], 0, 0);
        for (columns, left) in Pieces::of(self, distances, boxed, row).span(&span) {
            let columns = columns.start - span.start..columns.end - span.start;
            if columns.start != first + count || count == BATCH {
                (self.rows.fade)(part_mut(&mut *opacities, first..first + count), part(&shares, 0..count));
                (first, count) = (columns.start, 0);
            }
            if left == Remainder::WHOLE {
                continue;
            }
            let weight = left.weight();
            match (weight, shares.get_mut(count)) {
                (1.., Some(share)) if columns.len() == 1 => {
                    *share = weight as i32;
                    count += 1;
                }
                _ => self.fade(part_mut(&mut *opacities, columns), weight),
            }
        }
        (self.rows.fade)(part_mut(opacities, first..first + count), part(&shares, 0..count));
    }

    fn fade(&self, opacities: &mut [i32], share: u32) {
        if share == 0 {
            opacities.fill(0);
        } else {
            fraction_row::<Native>(opacities, share);
        }
    }

    fn cues(&self) -> bool {
        self.cue.is_some()
    }

    fn turn(&self, distances: &Distances, at: (u32, usize), colours: [&mut [i32]; 3], bits: u32) {
        let Some(cue) = &self.cue else { return };
        let [red, green, blue] = colours;
        let (mut shares_of, mut shares) = (shares(cue, distances, at), [0; BATCH]);
        for first in (0..red.len()).step_by(BATCH) {
            let columns = first..(first + BATCH).min(red.len());
            let shares = part_mut(&mut shares, 0..columns.len());
            for (share, own) in shares.iter_mut().zip(&mut shares_of) {
                *share = own as i32;
            }
            let channels = [&mut *red, &mut *green, &mut *blue];
            for (channel, other) in channels.into_iter().zip(cue.target(bits)) {
                (self.rows.turn)(part_mut(channel, columns.clone()), other, shares);
            }
        }
    }

    fn turn_weighted(&self, distances: &Distances, at: (u32, usize), extinction: &[i32], colours: [&mut [i32]; 3]) {
        let Some(cue) = &self.cue else { return };
        let [red, green, blue] = colours;
        let colours = red.iter_mut().zip(green).zip(blue);
        for ((((r, g), b), t), share) in colours.zip(extinction).zip(shares(cue, distances, at)) {
            let turned = cue.turned_weighted([*r as u32, *g as u32, *b as u32], *t as u32, share);
            [*r, *g, *b] = turned.map(|c| c as i32);
        }
    }
}

/// How far colours have turned about the segments of a row, from a column of pixels on.
fn shares<'c>(
    cue: &'c CuePlane,
    distances: &Distances,
    (row, column): (u32, usize),
) -> impl Iterator<Item = u32> + use<'c> {
    let [along_i, along_j, _] = cue.slope;
    let [.., ends] = distances;
    let mut ends = ends.map(|end| end + along_j * i64::from(row) + along_i * column as i64);
    core::iter::from_fn(move || {
        let share = cue.share(ends);
        ends = ends.map(|end| end + along_i);
        Some(share)
    })
}
