//! The pieces of a row of segments: which columns the clip planes leave whole, which they leave nothing of, and which they cut.

use core::ops::Range;

use super::{CLIPS_MAX, ClipPlane, Clips, Distances, Remainder};
use crate::borders::Part;

/// Segments of some columns, side by side, and the part of them that the volume's box leaves.
#[derive(Clone, Debug)]
pub(crate) struct Boxed {
    /// The columns, counted from that of pixel 0.
    pub(crate) columns: Range<usize>,
    pub(crate) part: Part,
    /// The parts of the first and of the last column, where they are others.
    pub(crate) ends: [Option<Part>; 2],
}

impl Boxed {
    fn part(&self, column: usize) -> Part {
        let [first, last] = self.ends;
        let end = if column == self.columns.start {
            first
        } else if column + 1 == self.columns.end {
            last
        } else {
            None
        };
        end.unwrap_or(self.part)
    }
}

/// A way through the columns of a row: runs of segments that are left whole, or of which nothing is left, and single segments
/// that are cut.
#[derive(Clone, Debug)]
pub(crate) struct Pieces<'c> {
    planes: &'c [ClipPlane],
    /// Of the segment of pixel 0 of the row.
    distances: Distances,
    boxed: &'c Boxed,
    /// The columns of which something may be left.
    touched: Range<usize>,
    /// Those of them that a plane may cut.
    doubtful: [[Range<usize>; 2]; CLIPS_MAX],
    next: usize,
    end: usize,
}

/// A run of columns, counted from the first, and what is left of the parts of their segments that the box leaves.
pub(crate) type Piece = (Range<usize>, Remainder);

/// Nothing.
const NONE: Remainder = Remainder {
    part: Part::NONE,
    fade: 0,
};

impl<'c> Pieces<'c> {
    /// Of a row of the image, given the distances of pixel (0, 0)'s segment.
    pub(crate) fn of(clips: &'c Clips, distances: &Distances, boxed: &'c Boxed, row: u32) -> Self {
        let planes = clips.planes();
        let mut pieces = Self {
            planes,
            distances: *distances,
            touched: boxed.columns.clone(),
            doubtful: [const { [0..0, 0..0] }; CLIPS_MAX],
            next: boxed.columns.start,
            end: boxed.columns.end,
            boxed,
        };
        let Self {
            distances,
            touched,
            doubtful,
            ..
        } = &mut pieces;
        for ((plane, distances), doubtful) in planes.iter().zip(distances).zip(doubtful) {
            let [along_i, along_j, _] = plane.slope;
            for distance in &mut *distances {
                *distance += along_j * i64::from(row);
            }
            let columns = &boxed.columns;
            let near = reach(plane.bounds(*distances), along_i, columns);
            let far = if plane.thickness > 0 {
                let from_behind = distances.map(|distance| plane.thickness - distance);
                reach(plane.bounds(from_behind), -along_i, columns)
            } else {
                Reach::all(columns)
            };
            let inside = shared(&near.touched, &far.touched);
            *doubtful = if plane.is_outside() {
                [inside, 0..0]
            } else {
                *touched = shared(touched, &inside);
                [near.doubtful, far.doubtful]
            };
        }
        pieces
    }

    /// The columns of which something may be left, and a range of those that a plane may cut.
    pub(crate) fn reach(&self) -> [Range<usize>; 2] {
        let cut = self.doubtful.iter().flatten().filter(|range| !range.is_empty());
        let hull = |[start, end]: [usize; 2], range: &Range<usize>| [start.min(range.start), end.max(range.end)];
        let [start, end] = cut.fold([usize::MAX, 0], hull);
        [self.touched.clone(), start..end]
    }

    /// Some of the columns, counted from the first, alone.
    pub(crate) fn span(mut self, span: &Range<usize>) -> Self {
        let first = self.boxed.columns.start;
        self.next = first + span.start;
        self.end = (first + span.end).min(self.boxed.columns.end);
        self
    }

    fn cut(&self, column: usize) -> Remainder {
        let mut cut = Remainder::WHOLE;
        for (plane, distances) in self.planes.iter().zip(&self.distances) {
            let [along, _, _] = plane.slope;
            cut = cut.and(plane.cut(distances.map(|distance| distance + along * column as i64)));
        }
        cut.of(self.boxed.part(column))
    }
}

impl Iterator for Pieces<'_> {
    type Item = Piece;

    fn next(&mut self) -> Option<Piece> {
        let (start, columns, touched) = (self.next, &self.boxed.columns, &self.touched);
        if start >= self.end {
            return None;
        }
        let (end, cut) = if touched.is_empty() || start >= touched.end {
            (columns.end, NONE)
        } else if start < touched.start {
            (touched.start, NONE)
        } else if self.doubtful.iter().flatten().any(|range| range.contains(&start)) {
            (start + 1, self.cut(start))
        } else {
            let ahead = |range: &Range<usize>| Some(range.start).filter(|at| *at > start && !range.is_empty());
            let cuts = self.doubtful.iter().flatten().filter_map(ahead);
            (cuts.fold(touched.end, Ord::min), Remainder::WHOLE)
        };
        let end = end.min(self.end);
        self.next = end;
        Some((start - columns.start..end - columns.start, cut))
    }
}

/// The columns that a face touches.
struct Reach {
    /// Of which it may leave something.
    touched: Range<usize>,
    /// Of which it may take something.
    doubtful: Range<usize>,
}

impl Reach {
    fn all(columns: &Range<usize>) -> Self {
        Self {
            touched: columns.clone(),
            doubtful: 0..0,
        }
    }
}

/// Of a face that leaves nothing of column 0 below the first bound and all of it from the second on, each 0 where that begins;
/// both grow by a slope per column.
fn reach([none, whole]: [i64; 2], slope: i64, columns: &Range<usize>) -> Reach {
    let held = |column: i64| (column.max(columns.start as i64) as usize).min(columns.end);
    // The first column where a bound is at least 0; growing down, the one behind the last.
    let place = |bound: i64| {
        if slope > 0 {
            held(-bound.checked_div_euclid(slope).unwrap_or(0))
        } else if slope < 0 {
            held(bound.checked_div_euclid(-slope).unwrap_or(0) + 1)
        } else if bound >= 0 {
            columns.end
        } else {
            columns.start
        }
    };
    let (none, whole) = (place(none), place(whole));
    if slope > 0 {
        Reach {
            touched: none..columns.end,
            doubtful: none..whole.max(none),
        }
    } else {
        Reach {
            touched: columns.start..none,
            doubtful: whole.min(none)..none,
        }
    }
}

fn shared(a: &Range<usize>, b: &Range<usize>) -> Range<usize> {
    let start = a.start.max(b.start);
    start..a.end.min(b.end).max(start)
}
