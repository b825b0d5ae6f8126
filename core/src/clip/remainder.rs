//! What is left of a segment: a part of it, and a share of its optical depth; and the ramp by which a soft face fades.

use crate::borders::{Part, WHOLE};
use crate::surface::Turn;

/// What is left of a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Remainder {
    /// From where to where it counts.
    pub part: Part,
    /// Which share of its optical depth counts there, 0.16.
    pub fade: u32,
}

impl Remainder {
    /// All of it.
    pub const WHOLE: Self = Self {
        part: Part::WHOLE,
        fade: WHOLE,
    };

    /// What this cut and another leave.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self {
            part: self.part.and(other.part),
            fade: product(self.fade, other.fade),
        }
    }

    /// What is left of the part of a segment that the volume's box leaves, which is not empty: `from` and `to` are places of that
    /// part.
    #[must_use]
    pub fn of(self, part: Part) -> Self {
        if part == Part::WHOLE && self.part.length() > 0 {
            return self;
        }
        let (both, length) = (self.part.and(part), u64::from(part.length()));
        if both.length() == 0 {
            return Self {
                part: Part::NONE,
                fade: self.fade,
            };
        }
        let place = |at: u32| {
            let way = (u64::from(at.saturating_sub(part.from)) << 17) + length;
            way.checked_div(2 * length).unwrap_or(0) as u32
        };
        Self {
            part: Part {
                from: place(both.from),
                to: place(both.to),
            },
            fade: self.fade,
        }
    }

    /// The share of the segment's optical depth that counts, 0.16.
    pub const fn weight(self) -> u32 {
        product(self.part.length(), self.fade)
    }

    /// The samples at the ends of what is left of a segment.
    pub fn ends(self, [front, back]: [i32; 2]) -> [i32; 2] {
        let way = i64::from(back) - i64::from(front);
        let at = |place: u32| {
            let steps = (way * i64::from(place) + (1 << 15)) >> 16;
            front.wrapping_add(steps as i32)
        };
        [at(self.part.from), at(self.part.to)]
    }

    /// The turn of a crossing in what is left, as one in the segment.
    #[must_use]
    pub fn turn(self, turn: Turn) -> Turn {
        turn.moved(|position| self.place(position))
    }

    /// Where a place of what is left lies in the segment.
    pub fn place(self, position: u32) -> u32 {
        let way = (u64::from(self.part.length()) * u64::from(position)) >> 16;
        self.part.from.wrapping_add(way as u32)
    }
}

/// The product of two shares, 0.16, to nearest.
pub(super) const fn product(a: u32, b: u32) -> u32 {
    ((a as u64 * b as u64 + (1 << 15)) >> 16) as u32
}

/// A ramp, by which a soft face fades: `65536 x / d`, to nearest, for x from 0 to d.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Ramp {
    /// Twice the falloff: d.
    pub(super) width: i64,
    /// `d 2^shift` has 31 bits.
    pub(super) shift: i32,
    /// `2^62 / (d 2^shift)`, at most 2^32 - 1.
    pub(super) reciprocal: u32,
}

impl Ramp {
    /// Of a falloff above 0.
    pub(super) fn of(falloff: i64) -> Self {
        let width = 2 * falloff;
        let shift = width.leading_zeros() as i32 - 33;
        let scaled = shifted(width, shift) as u64;
        let reciprocal = (1u64 << 62).checked_div(scaled).unwrap_or(0);
        Self {
            width,
            shift,
            reciprocal: reciprocal.min(u64::from(u32::MAX)) as u32,
        }
    }

    /// The share of a sum of the distances of both ends and the falloff.
    pub(super) fn share(self, sum: i64) -> u32 {
        if sum <= 0 {
            0
        } else if sum >= self.width {
            WHOLE
        } else {
            ((shifted(sum, self.shift) as u64 * u64::from(self.reciprocal) + (1 << 45)) >> 46) as u32
        }
    }
}

/// Shifted up, or down where the shift is negative.
const fn shifted(x: i64, shift: i32) -> i64 {
    if shift < 0 { x >> -shift } else { x << shift }
}
