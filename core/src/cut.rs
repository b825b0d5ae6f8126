//! Segments cut into parts: at the isosurfaces that they cross, and into pieces.
//!
//! Source: Engel, Kraus, Ertl, "High-Quality Pre-Integrated Volume Rendering Using Hardware-Accelerated Pixel Shading"
//! (2001), section 5. The paper draws one surface in place of its segment, or in a pass of its own; here a segment is folded
//! as a sequence of parts, each like a segment: volume in front of the first crossing, the crossing, volume up to the next,
//! and so on. Several surfaces in a segment and the volume between them are composited in their order.
//!
//! | part | of a segment with n crossings | opacity, colour |
//! |---|---|---|
//! | 2 j, j = 0 to n | volume between crossings j - 1 and j | of [`Integral`], of the part's integrals |
//! | 2 j + 1, j = 0 to n - 1 | crossing j | of the surface's face |
//! | 2 j, j = 0 to m - 1 | n = 0: piece j of m | of [`Integral`], of the piece's integrals |
//!
//! A part of the volume lies between two values of the segment, v and w: the front sample, thresholds in their order, the back
//! sample. The whole segment's rate Q is that of all its parts:
//!
//! ```text
//! y = (|cum(T, w) - cum(T, v)| Q + 2^(h-1)) >> h
//! a segment of less than a bin:  y = (Y position_w >> 16) - (Y position_v >> 16),  Y that of the whole; its one colour
//! ```
//!
//! Of a segment that the volume's borders cut, the ends are the samples at the cuts, and Q has the length of what lies between
//! them: all the rest is that of a whole segment.
//!
//! The differences add up to the segment's, so that cutting changes the depth by roundings alone.
//!
//! Pieces order the colours within a segment, which are mixed otherwise: 2 or 4 pieces of equal difference, where the segment has
//! as many bins, no crossing, more than one colour, and a depth of more than 1/4 ([`PIECES_FROM`]).
//!
//! Rounding and error: as [`Integral`], a part. State: none.

use crate::borders::WHOLE;
use crate::classify::{Classifier, Slab, Support};
use crate::composite::Recurrence as _;
use crate::exp2::absorbed;
use crate::format::Opacity;
use crate::integral::{Bound, Integral};
use crate::lanes::{Lanes, Small, places};
use crate::precision::Precision;
use crate::rows::three;
use crate::surface::{Crossings, Face, Surface, SurfaceError, Turn, check, position, ranks, threshold};
use crate::table::ENTRIES;

/// A segment is cut into pieces where y is more than this, u8.24: log2(e) / 4.
pub const PIECES_FROM: u32 = 6_051_102;

/// Why segments cannot be cut so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CutError {
    /// Surfaces that cannot be drawn.
    Surface(SurfaceError),
    /// Not 1, 2 or 4 pieces.
    Pieces {
        /// As given.
        given: u32,
    },
}

impl From<SurfaceError> for CutError {
    fn from(error: SurfaceError) -> Self {
        Self::Surface(error)
    }
}

impl core::fmt::Display for CutError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Surface(error) => error.fmt(f),
            Self::Pieces { given } => write!(f, "{given} pieces of a segment; accepted: 1, 2, 4"),
        }
    }
}

impl core::error::Error for CutError {}

/// Which voxel ranges can hold a crossing: a segment that crosses a value lies on both sides of it, so between voxels of which
/// one is the next code or above.
pub fn crossed(surfaces: &[Surface]) -> Support {
    let next = |code: usize| surfaces.iter().any(|surface| surface.next_code() == code);
    Support::of((0..ENTRIES).map(next))
}

/// A classifier of segments that are cut: over lists of nodes `L` ([`Integral`]), or of surfaces alone, and a list of surfaces
/// `S`.
#[derive(Clone, Copy, Debug)]
pub struct Cut<L, S> {
    volume: Option<Integral<L>>,
    surfaces: S,
    pieces: u32,
    support: Support,
}

impl<L: AsRef<[u32]>, S: AsRef<[Surface]>> Cut<L, S> {
    /// Cuts the segments of a volume, or of none, at surfaces in ascending order of their values, and into pieces. A surface
    /// cuts the volume even if both its faces have an opacity of 0.
    ///
    /// # Errors
    /// [`CutError`].
    pub fn new(volume: Option<Integral<L>>, surfaces: S, pieces: u32) -> Result<Self, CutError> {
        check(surfaces.as_ref())?;
        if !matches!(pieces, 1 | 2 | 4) {
            return Err(CutError::Pieces { given: pieces });
        }
        let several = volume.as_ref().is_some_and(Integral::has_colours);
        let crossed = crossed(surfaces.as_ref());
        let visible = volume.as_ref().map_or(Support::NONE, Integral::visible);
        Ok(Self {
            support: visible.union(crossed),
            volume,
            surfaces,
            pieces: if several { pieces } else { 1 },
        })
    }

    /// The integrals of the volume.
    pub const fn volume(&self) -> Option<&Integral<L>> {
        self.volume.as_ref()
    }

    /// The surfaces.
    pub fn surfaces(&self) -> &[Surface] {
        self.surfaces.as_ref()
    }

    /// Parts of a segment.
    pub fn parts_of<P: Precision>(&self, p: P, ends: [i32; 2]) -> u32 {
        match Crossings::between(p, self.surfaces(), ends).count() {
            0 => 2 * self.pieces - 1,
            n => 2 * n + 1,
        }
    }

    /// Whether no segment is cut.
    #[inline(always)]
    fn is_whole(&self) -> bool {
        self.surfaces().is_empty() && self.pieces == 1
    }

    /// What a part of a segment is.
    #[inline(always)]
    fn part<P: Precision, V: Lanes>(&self, p: P, ends: [i32; 2], fraction: u32, part: u32) -> Part<'_> {
        let [front, back] = ends;
        let (surfaces, met) = (self.surfaces(), part >> 1);
        let crossings = Crossings::between(p, surfaces, ends);
        let surface = |met: u32| surfaces.get(crossings.surface(met)?);
        if part & 1 == 1 {
            return surface(met).map_or(Part::None, |surface| Part::Crossing {
                face: if crossings.falling() {
                    &surface.back
                } else {
                    &surface.front
                },
                turn: Turn::at(position::<V>(ends, threshold(p, surface)), crossings.falling()),
            });
        }
        let n = crossings.count();
        if n == 0 {
            return self.piece::<P, V>(p, ends, fraction, met);
        }
        if met > n || self.volume.is_none() {
            return Part::None;
        }
        let bound = |surface: &Surface| {
            let value = threshold(p, surface);
            Bound {
                value,
                position: position::<V>(ends, value),
            }
        };
        let first = Bound {
            value: front,
            position: 0,
        };
        let last = Bound {
            value: back,
            position: 1 << 16,
        };
        let before = met.checked_sub(1).and_then(surface).map_or(first, bound);
        Part::Volume([before, surface(met).map_or(last, bound)])
    }

    /// A piece of a segment without a crossing.
    #[inline(always)]
    fn piece<P: Precision, V: Lanes>(&self, p: P, ends: [i32; 2], fraction: u32, number: u32) -> Part<'_> {
        let [front, back] = ends;
        let Some(volume) = &self.volume else { return Part::None };
        let bound = |value, position| Bound { value, position };
        let whole = [bound(front, 0), bound(back, 1 << 16)];
        let difference = back.abs_diff(front);
        let cut = self.pieces > 1
            && difference >= volume.bins(p, self.pieces).unsigned_abs()
            && volume.part_depth::<P, V>(p, ends, fraction, whole) > PIECES_FROM;
        if !cut {
            return if number == 0 { Part::Volume(whole) } else { Part::None };
        }
        if number >= self.pieces {
            return Part::None;
        }
        let up_to = |number: u32| {
            // From the lower sample: both directions are cut at the same values.
            let from_low = if back < front { self.pieces - number } else { number };
            let way = (u64::from(difference) * u64::from(from_low)) >> self.pieces.trailing_zeros();
            bound(front.min(back).wrapping_add(way as i32), 0)
        };
        Part::Volume([up_to(number), up_to(number + 1)])
    }

    #[inline(never)]
    fn part_opacity_by<P: Precision, V: Lanes>(&self, p: P, ends: [i32; 2], fraction: u32, part: u32) -> i32 {
        match (self.part::<P, V>(p, ends, fraction, part), &self.volume) {
            (Part::Crossing { face, .. }, _) => face.opacity.to_bits() as i32,
            (Part::Volume(bounds), Some(volume)) => {
                let mut out = [0];
                let y = volume.part_depth::<P, V>(p, ends, fraction, bounds);
                absorbed(V::splat(y as i32)).store(&mut out, 0);
                let [opacity] = out;
                opacity
            }
            _ => 0,
        }
    }

    #[inline(never)]
    fn part_colour_by<P: Precision, V: Lanes>(&self, p: P, ends: [i32; 2], fraction: u32, part: u32) -> [u32; 3] {
        match (self.part::<P, V>(p, ends, fraction, part), &self.volume) {
            (Part::Crossing { face, .. }, _) => {
                let cut = 31 - p.pixel().colour_bits();
                three(face.colour, |c| c.wrapping_add(1 << cut >> 1) >> cut)
            }
            (Part::Volume(bounds), Some(volume)) => volume.part_colour_by::<P, V>(p, ends, bounds),
            _ => [0; 3],
        }
    }

    /// Turn of a crossing; that of the front sample for what is none.
    #[inline(never)]
    fn turn_by<P: Precision, V: Lanes>(&self, p: P, ends: [i32; 2], part: u32) -> Turn {
        // Crossings do not ask for the length.
        match self.part::<P, V>(p, ends, WHOLE, part) {
            Part::Crossing { turn, .. } => turn,
            _ => Turn::default(),
        }
    }

    /// Calls what is done with each segment that may be cut: its place in the row and its ends.
    #[inline(always)]
    fn each_cut<P: Precision, V: Lanes>(
        &self,
        p: P,
        slab: Slab<'_>,
        len: usize,
        mut done: impl FnMut(usize, [i32; 2]),
    ) {
        let surfaces = self.surfaces();
        let beyond = (ENTRIES as u32) << p.formats().sample_bits;
        // Below this difference there are no pieces.
        let least = match &self.volume {
            Some(volume) if self.pieces > 1 => volume.bins(p, self.pieces),
            _ => i32::MAX,
        };
        for at in places::<V>(len) {
            let (front, back) = (V::load(slab.front, at), V::load(slab.back, at));
            let crossed = ranks(p, surfaces, front) ^ ranks(p, surfaces, back);
            let far = (front - back).abs().at_least_then(V::splat(least), V::splat(1));
            if (crossed | far).all_zero() {
                continue;
            }
            let ends = slab.front.iter().zip(slab.back).take(len);
            for (n, (&front, &back)) in ends.enumerate().skip(at).take(V::COUNT) {
                // Lanes beyond the volume hold anything.
                if (front as u32).max(back as u32) < beyond {
                    done(n, [front, back]);
                }
            }
        }
    }
}

/// A part of a segment.
enum Part<'a> {
    /// There is none.
    None,
    /// Between two of its values.
    Volume([Bound; 2]),
    /// Of a surface.
    Crossing { face: &'a Face, turn: Turn },
}

impl<P, L, S> Classifier<P> for Cut<L, S>
where
    P: Precision,
    L: AsRef<[u32]> + Sync,
    S: AsRef<[Surface]> + Sync,
{
    const SLABS: bool = true;

    #[inline]
    fn opacity(&self, p: P, sample: i32) -> Opacity {
        self.segment_opacity(p, [sample; 2])
    }

    #[inline]
    fn colour(&self, p: P, sample: i32) -> [u32; 3] {
        self.segment_colour(p, [sample; 2])
    }

    /// Of the volume in a whole segment.
    #[inline]
    fn segment_opacity(&self, p: P, ends: [i32; 2]) -> Opacity {
        match &self.volume {
            Some(volume) => volume.segment_opacity(p, ends),
            None => Opacity::ZERO,
        }
    }

    /// Of the volume in a whole segment.
    #[inline]
    fn segment_colour(&self, p: P, ends: [i32; 2]) -> [u32; 3] {
        match &self.volume {
            Some(volume) => volume.segment_colour(p, ends),
            None => [0; 3],
        }
    }

    #[inline]
    fn part_opacity(&self, p: P, ends: [i32; 2], fraction: u32, part: u32) -> Opacity {
        Opacity::from_bits(self.part_opacity_by::<P, i32>(p, ends, fraction, part) as u32)
    }

    #[inline]
    fn part_colour(&self, p: P, ends: [i32; 2], fraction: u32, part: u32) -> [u32; 3] {
        self.part_colour_by::<P, i32>(p, ends, fraction, part)
    }

    #[inline]
    fn turn(&self, p: P, ends: [i32; 2], part: u32) -> Turn {
        self.turn_by::<P, i32>(p, ends, part)
    }

    #[inline(always)]
    fn parts<V: Lanes>(&self, p: P, slab: Slab<'_>) -> u32 {
        let surfaces = self.surfaces();
        let pieces = 2 * self.pieces - 1;
        if surfaces.is_empty() {
            return pieces;
        }
        let mut most = V::splat(0);
        for at in places::<V>(slab.back.len()) {
            let front = ranks(p, surfaces, V::load(slab.front, at));
            let back = ranks(p, surfaces, V::load(slab.back, at));
            most = most.at_least((front - back).abs());
        }
        let mut all = [0; 64];
        most.store(&mut all, 0);
        let crossings = all.iter().take(V::COUNT).fold(0, |most, n| most.max(*n)) as u32;
        pieces.max(2 * crossings + 1)
    }

    fn support(&self) -> Support {
        self.support
    }

    #[inline(always)]
    fn one_colour(&self, p: P) -> Option<[u32; 3]> {
        match &self.volume {
            Some(volume) if self.surfaces().is_empty() => volume.one_colour(p),
            _ => None,
        }
    }

    #[inline(always)]
    fn opacity_row<V: Lanes>(&self, p: P, slab: Slab<'_>, out: &mut [i32]) {
        match &self.volume {
            Some(volume) if slab.part == 0 => volume.opacity_row::<V>(p, slab, out),
            _ => out.fill(0),
        }
        // Between surfaces that are alone there is nothing.
        let empty = self.volume.is_none() && slab.part & 1 == 0;
        if !self.is_whole() && !empty {
            self.cut_opacities::<P, V>(p, slab, out);
        }
    }

    #[inline(always)]
    fn colour_row<V: Lanes>(&self, p: P, slab: Slab<'_>, [red, green, blue]: [&mut [i32]; 3]) {
        match &self.volume {
            Some(volume) if slab.part == 0 => volume.colour_row::<V>(p, slab, [&mut *red, &mut *green, &mut *blue]),
            _ => {
                red.fill(0);
                green.fill(0);
                blue.fill(0);
            }
        }
        if !self.is_whole() {
            self.cut_colours::<P, V>(p, slab, [red, green, blue]);
        }
    }

    #[inline(always)]
    fn turn_row<V: Lanes>(&self, p: P, slab: Slab<'_>, out: &mut [i32]) {
        out.fill(0);
        self.each_cut::<P, V>(p, slab, out.len(), |n, ends| {
            let turn = if V::SMALL {
                self.turn_by::<P, Small>(p, ends, slab.part)
            } else {
                self.turn_by::<P, i32>(p, ends, slab.part)
            };
            if let Some(out) = out.get_mut(n) {
                *out = turn.to_bits();
            }
        });
    }
}

impl<L: AsRef<[u32]>, S: AsRef<[Surface]>> Cut<L, S> {
    /// The opacities of those segments of a row that are cut.
    #[inline(always)]
    fn cut_opacities<P: Precision, V: Lanes>(&self, p: P, slab: Slab<'_>, out: &mut [i32]) {
        self.each_cut::<P, V>(p, slab, out.len(), |n, ends| {
            if let Some(out) = out.get_mut(n) {
                *out = if V::SMALL {
                    self.part_opacity_by::<P, Small>(p, ends, slab.fraction, slab.part)
                } else {
                    self.part_opacity_by::<P, i32>(p, ends, slab.fraction, slab.part)
                };
            }
        });
    }

    /// The colours of those segments of a row that are cut.
    #[inline(always)]
    fn cut_colours<P: Precision, V: Lanes>(&self, p: P, slab: Slab<'_>, [red, green, blue]: [&mut [i32]; 3]) {
        self.each_cut::<P, V>(p, slab, red.len(), |n, ends| {
            let colour = if V::SMALL {
                self.part_colour_by::<P, Small>(p, ends, slab.fraction, slab.part)
            } else {
                self.part_colour_by::<P, i32>(p, ends, slab.fraction, slab.part)
            };
            if let (Some(r), Some(g), Some(b)) = (red.get_mut(n), green.get_mut(n), blue.get_mut(n)) {
                [*r, *g, *b] = three(colour, |c| c as i32);
            }
        });
    }
}
