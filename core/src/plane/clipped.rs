//! What clip planes leave of the segments of an extent.

use core::ops::Range;

use super::extent::Extent;
use super::kernels::ClassifierRows;
use super::parts::Samples;
use super::{At, parts};
use crate::borders::WHOLE;
use crate::classify::Slab;
use crate::clip::{Boxed, Clipper, Clipping, Distances, Left, Remainder};
use crate::plan::Plan;
use crate::rows::{part_mut, three};
use crate::surface::Turn;

/// What clip planes leave of rows of a plane.
pub(super) enum Rest<'c> {
    /// Nothing.
    Nothing,
    /// All of it, and no colour turns.
    All,
    /// Some, or colours turn.
    Some {
        clips: &'c dyn Clipping,
        distances: Distances,
    },
}

impl<'c> Rest<'c> {
    /// Of so many rows from the first on of a plane of samples, or of the segments that end at it. Colours may turn where there
    /// are any.
    pub(super) fn of<X>(at: &At<'c, X>, slabs: bool, (first, count): (u32, usize), colours: bool) -> Self {
        let Some(Clipper(clips)) = at.clips else {
            return Self::All;
        };
        let [width, _] = at.plan.base();
        let distances = clips.distances(at.plan, at.plane.phase, at.plane.index, slabs);
        let Left { columns, whole } = clips.left(&distances, &(0..width as usize), &(first..first + count as u32));
        if columns.is_empty() {
            Self::Nothing
        } else if whole && !(colours && clips.cues()) {
            Self::All
        } else {
            Self::Some { clips, distances }
        }
    }

    /// Whether something is cut that the blocks of a plane do not cut: segments and colours lie in rows.
    pub(super) fn cuts_rows(&self, slabs: bool) -> bool {
        matches!(self, Self::Some { clips, .. } if slabs || clips.cues())
    }

    /// Narrows samples of a plane, or both ends of segments, to the columns of which something may be left in one of some rows;
    /// whether it did. Both ends of narrowed segments are made anew, for which half of the columns must be cut away. Not for observers,
    /// to whom rows are the same in tiles of any size.
    pub(super) fn narrow(
        &self,
        plan: &Plan,
        samples: &mut [Samples<'_>],
        slabs: bool,
        (first, count): (u32, usize),
    ) -> bool {
        let (Self::Some { clips, distances }, [.., Samples { extent, .. }]) = (self, &*samples) else {
            return false;
        };
        let (all, rows) = (&extent.columns, extent.met(first, count));
        let Left { columns, .. } = clips.left(distances, all, &rows);
        if columns == *all || slabs && 2 * columns.len() > all.len() {
            return false;
        }
        for Samples { extent, .. } in &mut *samples {
            extent.keep(columns.clone());
        }
        if !columns.is_empty() {
            let [width, _, _] = plan.dims();
            parts::narrow(samples, width);
        }
        true
    }
}

/// An extent under clip planes.
pub(super) struct Clipped<'c> {
    clips: &'c dyn Clipping,
    distances: &'c Distances,
    boxed: Boxed,
    /// Bits of a colour after 1.0.
    colour_bits: u32,
}

impl<'c> Clipped<'c> {
    /// Of an extent of the plane; `None` where nothing is cut.
    #[inline(always)]
    pub(super) fn of(rest: &'c Rest<'_>, extent: &Extent, colour_bits: u32) -> Option<Self> {
        let Rest::Some { clips, distances } = rest else {
            return None;
        };
        Some(Self {
            clips: *clips,
            distances,
            boxed: Boxed {
                columns: extent.columns.clone(),
                part: extent.part,
                ends: extent.ends,
            },
            colour_bits,
        })
    }

    /// Whether nothing is left of a row.
    pub(super) fn is_empty(&self, row: u32) -> bool {
        let [left, _] = self.reach(row);
        left.is_empty()
    }

    /// The columns of a row of which something may be left, and a range of those that may be cut.
    pub(super) fn reach(&self, row: u32) -> [Range<usize>; 2] {
        self.clips.reach(self.distances, &self.boxed, row)
    }

    /// Goes through a span of a row, counted from the extent's first column.
    pub(super) fn each(&self, row: u32, span: Range<usize>, see: &mut dyn FnMut(Range<usize>, Remainder)) {
        self.clips.each(self.distances, &self.boxed, (row, span), see);
    }

    /// Makes the opacities of a span of samples those of what is left.
    pub(super) fn weigh(&self, row: u32, span: Range<usize>, opacities: &mut [i32]) {
        self.clips.weigh(self.distances, &self.boxed, (row, span), opacities);
    }

    /// Makes opacities those of a share of the step.
    pub(super) fn fade(&self, opacities: &mut [i32], share: u32) {
        self.clips.fade(opacities, share);
    }

    /// Whether colours turn with depth.
    pub(super) fn cues(&self) -> bool {
        self.clips.cues()
    }

    /// Turns colours times extinction alike.
    pub(super) fn turn_weighted(&self, row: u32, first: usize, extinction: &[i32], colours: [&mut [i32]; 3]) {
        let column = self.boxed.columns.start + first;
        self.clips
            .turn_weighted(self.distances, (row, column), extinction, colours);
    }

    /// The share of a segment's step that lies in the box and is left, 0.16.
    pub(super) fn fraction(&self, left: Remainder) -> u32 {
        ((u64::from(self.boxed.part.length()) * u64::from(left.weight()) + (1 << 15)) >> 16) as u32
    }
}

/// What clip planes leave of rows of words `W`: nothing is done to rows of words that know no clip planes.
pub(super) trait ClipRows<W> {
    /// Leaves of the opacities of a part of a row what is left of its samples or segments.
    #[inline(always)]
    fn clip<C: ClassifierRows<W> + ?Sized>(&self, _row: u32, _slab: Slab<'_, W>, _by: (&C, u32), _opacities: &mut [W]) {
    }

    /// Makes the colours of a span of visible segments those of what is left of them.
    #[inline(always)]
    fn clip_colours<C: ClassifierRows<W> + ?Sized>(
        &self,
        _row: u32,
        _of: (Slab<'_, W>, Range<usize>),
        _by: (&C, u32),
        _colours: [&mut [W]; 3],
    ) {
    }

    /// Makes the turns of a span of visible crossings those of what is left of their segments.
    #[inline(always)]
    fn clip_turns<C: ClassifierRows<W> + ?Sized>(
        &self,
        _row: u32,
        _of: (Slab<'_, W>, Range<usize>),
        _by: (&C, u32),
        _turns: &mut [W],
    ) {
    }

    /// Turns the colours of a row of segments, from a column on, counted from the extent's first.
    #[inline(always)]
    fn turn(&self, _row: u32, _first: usize, _colours: [&mut [W]; 3]) {}
}

impl ClipRows<u16> for Clipped<'_> {}

/// The ends of what is left of a segment.
fn rest(slab: Slab<'_>, columns: &Range<usize>, left: Remainder) -> [i32; 2] {
    let Slab { front, back, .. } = slab.span(columns.clone());
    match (front.first(), back.first()) {
        (Some(front), Some(back)) => left.ends([*front, *back]),
        _ => [0; 2],
    }
}

/// A segment alone.
fn one([front, back]: &[i32; 2]) -> Slab<'_> {
    Slab::between(core::slice::from_ref(front), core::slice::from_ref(back))
}

impl Clipped<'_> {
    /// Goes through those segments of a span that are cut: their places in it, what is left of them, its ends, and its share of
    /// a step.
    #[inline(always)]
    fn each_rest(
        &self,
        row: u32,
        (slab, span): (Slab<'_>, Range<usize>),
        see: &mut dyn FnMut(usize, Remainder, [i32; 2], u32),
    ) {
        if slab.front.is_empty() {
            return;
        }
        let first = span.start;
        self.each(row, span, &mut |columns, left| {
            if left != Remainder::WHOLE && left.weight() > 0 {
                see(
                    columns.start - first,
                    left,
                    rest(slab, &columns, left),
                    self.fraction(left),
                );
            }
        });
    }
}

impl ClipRows<i32> for Clipped<'_> {
    #[inline(always)]
    fn clip<C: ClassifierRows<i32> + ?Sized>(
        &self,
        row: u32,
        slab: Slab<'_>,
        (classifier, part): (&C, u32),
        opacities: &mut [i32],
    ) {
        let all = 0..opacities.len();
        if slab.front.is_empty() {
            self.weigh(row, all, opacities);
            return;
        }
        self.each(row, all, &mut |columns, left| {
            let opacities = part_mut(&mut *opacities, columns.clone());
            if left.weight() == 0 {
                opacities.fill(0);
            } else if left != Remainder::WHOLE {
                let ends = rest(slab, &columns, left);
                classifier.opacity_row(
                    one(&ends).of_part(part).of_fraction(self.fraction(left)),
                    &mut *opacities,
                );
                // The opacity of a surface has no length.
                if part & 1 == 1 && left.fade < WHOLE {
                    self.fade(opacities, left.fade);
                }
            }
        });
    }

    #[inline(always)]
    fn clip_colours<C: ClassifierRows<i32> + ?Sized>(
        &self,
        row: u32,
        of: (Slab<'_>, Range<usize>),
        (classifier, part): (&C, u32),
        [red, green, blue]: [&mut [i32]; 3],
    ) {
        self.each_rest(row, of, &mut |at, _, ends, fraction| {
            let colours = [&mut *red, &mut *green, &mut *blue];
            let colours = three(colours, |row| part_mut(row, at..at + 1));
            classifier.colour_row(one(&ends).of_part(part).of_fraction(fraction), colours);
        });
    }

    #[inline(always)]
    fn clip_turns<C: ClassifierRows<i32> + ?Sized>(
        &self,
        row: u32,
        of: (Slab<'_>, Range<usize>),
        (classifier, part): (&C, u32),
        turns: &mut [i32],
    ) {
        self.each_rest(row, of, &mut |at, left, ends, _| {
            let turns = part_mut(&mut *turns, at..at + 1);
            classifier.turn_row(one(&ends).of_part(part), &mut *turns);
            for turn in turns {
                *turn = left.turn(Turn::from_bits(*turn)).to_bits();
            }
        });
    }

    fn turn(&self, row: u32, first: usize, colours: [&mut [i32]; 3]) {
        let column = self.boxed.columns.start + first;
        self.clips
            .turn(self.distances, (row, column), colours, self.colour_bits);
    }
}
