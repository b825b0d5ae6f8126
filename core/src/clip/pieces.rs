//! The pieces of a row of segments: which columns the clip planes leave whole, which they leave nothing of, and which they cut.

use core::ops::Range;

use super::{CLIPS_MAX, ClipPlane, Clips, Remainder};
use crate::borders::Part;

/// What clip planes leave of some rows of a plane.
pub(crate) struct Left {
    /// Columns outside of which nothing is left.
    pub(crate) columns: Range<usize>,
    /// Whether all of it is left.
    pub(crate) whole: bool,
}

/// The distances of the ends of pixel (0, 0)'s segment from each clip plane, and behind them the depths of depth cueing.
pub(crate) type Distances = [[i64; 2]; CLIPS_MAX + 1];

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
        let first = first.filter(|_| column == self.columns.start);
        let last = last.filter(|_| column + 1 == self.columns.end);
        first.or(last).unwrap_or(self.part)
    }
}

/// A way through the columns of a row: runs of segments that are left whole, or of which nothing is left, and single segments
/// that are cut.
pub(crate) struct Pieces<'c> {
    planes: &'c [ClipPlane],
    /// Of the segment of pixel (0, 0).
    distances: &'c Distances,
    row: u32,
    boxed: &'c Boxed,
    /// The columns of which something may be left.
    touched: Range<usize>,
    /// Those of them that a face may cut, first and end; of each plane two ranges, empty where it has none.
    doubtful: [[u32; 2]; 2 * CLIPS_MAX],
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
    pub(crate) fn of(clips: &'c Clips, distances: &'c Distances, boxed: &'c Boxed, row: u32) -> Self {
        let (planes, columns) = (clips.planes(), &boxed.columns);
        let (mut touched, mut doubtful) = (columns.clone(), [[0; 2]; 2 * CLIPS_MAX]);
        let as_pair = |range: Range<usize>| [range.start as u32, range.end as u32];
        for ((plane, distances), doubtful) in planes.iter().zip(distances).zip(doubtful.as_chunks_mut().0) {
            let [near, far] = faces(plane, at_row(plane, distances, row), columns);
            let inside = shared(&near.touched, &far.touched);
            *doubtful = if plane.is_outside() {
                [as_pair(inside), [0; 2]]
            } else {
                touched = shared(&touched, &inside);
                [as_pair(near.doubtful), as_pair(far.doubtful)]
            };
        }
        Self {
            planes,
            distances,
            row,
            touched,
            doubtful,
            next: columns.start,
            end: columns.end,
            boxed,
        }
    }

    /// The ranges of columns that a face may cut.
    fn doubtful(&self) -> impl Iterator<Item = Range<usize>> {
        let of_planes = self.doubtful.get(..2 * self.planes.len()).unwrap_or(&[]);
        let ranges = of_planes.iter().map(|[start, end]| *start as usize..*end as usize);
        ranges.filter(|range| !range.is_empty())
    }

    /// The columns of which something may be left, and a range of those that a plane may cut.
    pub(crate) fn reach(&self) -> [Range<usize>; 2] {
        let hull = |[start, end]: [usize; 2], range: Range<usize>| [start.min(range.start), end.max(range.end)];
        let [start, end] = self.doubtful().fold([usize::MAX, 0], hull);
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
        for (plane, distances) in self.planes.iter().zip(self.distances) {
            let [along, ..] = plane.slope;
            let here = at_row(plane, distances, self.row).map(|distance| distance + along * column as i64);
            cut = cut.and(plane.cut(here));
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
        } else if self.doubtful().any(|range| range.contains(&start)) {
            (start + 1, self.cut(start))
        } else {
            let ahead = self.doubtful().map(|range| range.start).filter(|at| *at > start);
            (ahead.fold(touched.end, Ord::min), Remainder::WHOLE)
        };
        let end = end.min(self.end);
        self.next = end;
        Some((start - columns.start..end - columns.start, cut))
    }
}

/// What clip planes leave of some rows of the image, whose segments lie in some columns: where something may be left, and
/// whether all of it is. What a face touches moves one way with the row, so that the first row and the last tell of all.
pub(super) fn of_rows(clips: &Clips, distances: &Distances, columns: &Range<usize>, rows: &Range<u32>) -> Left {
    let (mut left, mut whole) = (columns.clone(), true);
    let ends = [rows.start, rows.end.saturating_sub(1)];
    for (plane, distances) in clips.planes().iter().zip(distances) {
        let [[near, far], [near_last, far_last]] = ends.map(|row| faces(plane, at_row(plane, distances, row), columns));
        let inside = shared(&either(&near, &near_last), &either(&far, &far_last));
        if plane.is_outside() {
            whole &= inside.is_empty();
        } else {
            whole &= [near, far, near_last, far_last]
                .iter()
                .all(|face| face.is_whole(columns));
            left = shared(&left, &inside);
        }
    }
    Left { columns: left, whole }
}

/// The distances of a row's first segment, given those of pixel (0, 0)'s.
fn at_row(plane: &ClipPlane, distances: &[i64; 2], row: u32) -> [i64; 2] {
    let [_, along, _] = plane.slope;
    distances.map(|distance| distance + along * i64::from(row))
}

/// What the near and the far face of a plane touch of a row, given the distances of its first segment.
fn faces(plane: &ClipPlane, distances: [i64; 2], columns: &Range<usize>) -> [Reach; 2] {
    let [along, _, _] = plane.slope;
    let far = if plane.thickness > 0 {
        let from_behind = distances.map(|distance| plane.thickness - distance);
        reach(plane.bounds(from_behind), -along, columns)
    } else {
        Reach::all(columns)
    };
    [reach(plane.bounds(distances), along, columns), far]
}

/// The columns that a face touches.
struct Reach {
    /// Of which it may leave something.
    touched: Range<usize>,
    /// Of which it may take something.
    doubtful: Range<usize>,
}

impl Reach {
    /// Whether it takes nothing.
    fn is_whole(&self, columns: &Range<usize>) -> bool {
        self.touched == *columns && self.doubtful.is_empty()
    }

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

/// The least range that holds what both touch.
fn either(a: &Reach, b: &Reach) -> Range<usize> {
    let (a, b) = (&a.touched, &b.touched);
    if a.is_empty() {
        b.clone()
    } else if b.is_empty() {
        a.clone()
    } else {
        a.start.min(b.start)..a.end.max(b.end)
    }
}
