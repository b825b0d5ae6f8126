//! The paper's two-dimensional tables: a segment's colour and opacity by the codes at its ends.
//!
//! Source: Engel, Kraus, Ertl 2001, section 3.4 (tables), 3.5 (integral functions, local updates, linear dependence on the
//! segment's length) and equations 5 to 10.

use std::ops::RangeInclusive;

use super::function::{Function, LAST, Sums};

/// Red, green, blue, each times the opacity; opacity.
pub type Entry = [f64; 4];

/// How entries are filled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filling {
    /// Front to back in pieces of at most [`PIECE`] codes: each attenuates those behind it.
    Ordered,
    /// By integral functions, the mean colour times the opacity: attenuated within the segment, but not ordered.
    Attenuated,
    /// By integral functions as the paper has it (equations 8 and 10): colour is not attenuated within the segment.
    Unattenuated,
}

/// How a table is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading {
    /// The nearest entry.
    Nearest,
    /// Linear between the four nearest.
    Bilinear,
}

/// Codes of a piece of ordered integration.
pub const PIECE: f64 = 16.0;

/// The segment from one code to another, `length` voxels long.
pub fn segment(function: &Function, filling: Filling, [front, back]: [f64; 2], length: f64) -> Entry {
    match filling {
        Filling::Ordered => ordered(function, [front, back], length, PIECE),
        Filling::Attenuated => attenuated(function.mean(front, back), length),
        Filling::Unattenuated => {
            let [tau, r, g, b] = function.mean(front, back).map(|mean| mean * length);
            [r, g, b, -(-tau).exp_m1()]
        }
    }
}

/// A segment in pieces of at most `piece` codes, front to back.
pub fn ordered(function: &Function, [front, back]: [f64; 2], length: f64, piece: f64) -> Entry {
    let pieces = ((back - front).abs() / piece).ceil().max(1.0);
    let mut sum = [0.0; 4];
    for mean in function.means([front, back], pieces as usize) {
        over(&mut sum, attenuated(mean, length / pieces));
    }
    sum
}

/// Mean colour times opacity, and opacity, of means over a length.
fn attenuated([tau, r, g, b]: Sums, length: f64) -> Entry {
    if tau <= 0.0 {
        return [0.0; 4];
    }
    let opacity = -(-tau * length).exp_m1();
    [r / tau * opacity, g / tau * opacity, b / tau * opacity, opacity]
}

/// Puts a segment behind what there is.
pub fn over(sum: &mut Entry, behind: Entry) {
    let left = 1.0 - sum[3];
    sum.iter_mut()
        .zip(behind)
        .for_each(|(sum, behind)| *sum += left * behind);
}

/// A table of `side` x `side` entries for segments of one length.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    side: usize,
    length: f64,
    filling: Filling,
    entries: Vec<Entry>,
}

impl Table {
    /// Fills a table; `side` at least 2, `length` in voxels.
    pub fn new(function: &Function, filling: Filling, side: usize, length: f64) -> Self {
        let mut table = Self {
            side,
            length,
            filling,
            entries: vec![[0.0; 4]; side * side],
        };
        for front in 0..side {
            for back in 0..side {
                table.fill(function, front, back);
            }
        }
        table
    }

    fn code(&self, index: usize) -> f64 {
        index as f64 * LAST / (self.side - 1) as f64
    }

    fn fill(&mut self, function: &Function, front: usize, back: usize) {
        let ends = [self.code(front), self.code(back)];
        self.entries[front * self.side + back] = segment(function, self.filling, ends, self.length);
    }

    /// Fills again what a change of the function within `codes` can reach, the entries whose values between front and back
    /// meet them; returns how many those are. Extinction and colour outside must be as before.
    pub fn update(&mut self, function: &Function, codes: RangeInclusive<f64>) -> usize {
        let mut filled = 0;
        for front in 0..self.side {
            for back in 0..self.side {
                let [low, high] = [front.min(back), front.max(back)].map(|index| self.code(index));
                if low <= *codes.end() && high >= *codes.start() {
                    self.fill(function, front, back);
                    filled += 1;
                }
            }
        }
        filled
    }

    /// The segment between two codes.
    pub fn read(&self, reading: Reading, ends: [f64; 2]) -> Entry {
        let scale = (self.side - 1) as f64 / LAST;
        let [front, back] = ends.map(|code| code.clamp(0.0, LAST) * scale);
        let at = |front: usize, back: usize| self.entries[front * self.side + back];
        match reading {
            Reading::Nearest => at(front.round() as usize, back.round() as usize),
            Reading::Bilinear => {
                let [f, b] = [front, back].map(|place| (place as usize).min(self.side - 2));
                let [u, v] = [front - f as f64, back - b as f64];
                let mix = |a: Entry, b: Entry, t: f64| [0, 1, 2, 3].map(|n| a[n] * (1.0 - t) + b[n] * t);
                mix(
                    mix(at(f, b), at(f, b + 1), v),
                    mix(at(f + 1, b), at(f + 1, b + 1), v),
                    u,
                )
            }
        }
    }
}

/// Tables for several lengths of a segment, linear in between.
#[derive(Clone, Debug)]
pub struct Lengths(Vec<Table>);

impl Lengths {
    /// Tables of two or more ascending lengths.
    pub fn new(function: &Function, filling: Filling, side: usize, lengths: &[f64]) -> Self {
        let table = |length: &f64| Table::new(function, filling, side, *length);
        Self(lengths.iter().map(table).collect())
    }

    /// The segment between two codes, `length` voxels long; beyond the first and the last table, of that table.
    pub fn read(&self, reading: Reading, ends: [f64; 2], length: f64) -> Entry {
        let tables = &self.0;
        let above = tables
            .partition_point(|table| table.length <= length)
            .clamp(1, tables.len() - 1);
        let [a, b] = [&tables[above - 1], &tables[above]];
        let t = ((length - a.length) / (b.length - a.length)).clamp(0.0, 1.0);
        let [x, y] = [a, b].map(|table| table.read(reading, ends));
        [0, 1, 2, 3].map(|n| x[n] * (1.0 - t) + y[n] * t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILLINGS: [Filling; 3] = [Filling::Ordered, Filling::Attenuated, Filling::Unattenuated];

    fn near(found: Entry, expected: Entry, bound: f64) {
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() <= bound, "{found} {expected}");
        }
    }

    /// Constant extinction and colour: 1 - e^-x whatever the ends, and x where colour is not attenuated.
    #[test]
    fn constant_extinction_is_its_closed_form() {
        let fog = Function::of(|_| [0.7, 0.7, 0.35, 0.0]);
        let (opacity, depth) = (-f64::exp_m1(-1.4), 1.4);
        for filling in FILLINGS {
            let table = Table::new(&fog, filling, 9, 2.0);
            let light = if filling == Filling::Unattenuated {
                depth
            } else {
                opacity
            };
            for entry in table.entries {
                near(entry, [light, light / 2.0, 0.0, opacity], 1e-9);
            }
        }
    }

    /// Extinction k s from a to b has a mean of k (a + b) / 2.
    #[test]
    fn a_ramp_is_its_closed_form() {
        let k = 1e-3;
        let ramp = Function::of(|s| [k * s, k * s, 0.0, 0.0]);
        for filling in FILLINGS {
            for [front, back] in [[0.0, 4095.0], [4095.0, 0.0], [100.0, 101.5], [2000.0, 2000.0]] {
                let depth = k * (front + back) / 2.0 * 0.5;
                let opacity = -f64::exp_m1(-depth);
                let light = if filling == Filling::Unattenuated {
                    depth
                } else {
                    opacity
                };
                near(
                    segment(&ramp, filling, [front, back], 0.5),
                    [light, 0.0, 0.0, opacity],
                    1e-9,
                );
            }
        }
    }

    /// Two colours in order, x each: the front one is attenuated by itself, the other by both.
    #[test]
    fn order_is_kept() {
        let two = Function::of(|s| {
            if s < 2048.0 {
                [1.0, 1.0, 0.0, 0.0]
            } else {
                [1.0, 0.0, 1.0, 0.0]
            }
        });
        let [first, second] = [-f64::exp_m1(-0.5), -f64::exp_m1(-0.5) * f64::exp(-0.5)];
        let all = -f64::exp_m1(-1.0);
        near(ordered(&two, [0.0, 4095.0], 1.0, 1.0), [first, second, 0.0, all], 1e-3);
        near(ordered(&two, [4095.0, 0.0], 1.0, 1.0), [second, first, 0.0, all], 1e-3);
        let mixed = segment(&two, Filling::Attenuated, [0.0, 4095.0], 1.0);
        near(mixed, [all / 2.0, all / 2.0, 0.0, all], 1e-3);
    }

    fn spiky(changed: bool) -> Function {
        Function::of(|s| {
            let tau = 2.0 * (s / 37.0).sin().max(0.0)
                + if changed && (1000.5..=1100.25).contains(&s) {
                    3.0
                } else {
                    0.0
                };
            [tau, tau * s / LAST, tau * 0.5, tau * (1.0 - s / LAST)]
        })
    }

    /// Of one colour, order does not count.
    #[test]
    fn one_colour_needs_no_order() {
        let one = Function::of(|s| {
            let tau = 2.0 * (s / 37.0).sin().max(0.0);
            [tau, tau, tau * 0.25, 0.0]
        });
        let ordered = Table::new(&one, Filling::Ordered, 33, 1.3);
        let quick = Table::new(&one, Filling::Attenuated, 33, 1.3);
        for (a, b) in ordered.entries.iter().zip(quick.entries) {
            near(*a, b, 1e-10);
        }
    }

    /// Bit for bit, also in entries behind the change, whose integrals moved by a constant.
    #[test]
    fn a_local_update_is_a_new_table() {
        let (before, after) = (spiky(false), spiky(true));
        let mut table = Table::new(&before, Filling::Ordered, 64, 1.0);
        let old = table.clone();
        // Extinction is linear between nodes, a sixteenth of a code away.
        let filled = table.update(&after, 1000.0..=1101.0);
        let new = Table::new(&after, Filling::Ordered, 64, 1.0);
        assert_ne!(old.entries, table.entries);
        for (a, b) in table.entries.iter().zip(&new.entries) {
            assert_eq!(a.map(f64::to_bits), b.map(f64::to_bits));
        }
        assert!(filled > 64 && filled < 64 * 64 / 2, "{filled}");
    }

    #[test]
    fn nodes_are_read_exactly() {
        for filling in FILLINGS {
            let table = Table::new(&spiky(true), filling, 16, 1.0);
            for front in 0..16 {
                for back in 0..16 {
                    let ends = [front, back].map(|index| 273.0 * index as f64);
                    for reading in [Reading::Nearest, Reading::Bilinear] {
                        near(table.read(reading, ends), table.entries[front * 16 + back], 1e-12);
                    }
                }
            }
        }
    }

    /// Opacity is concave in the length, of second derivative at most tau²: linear interpolation over h is low by at most
    /// tau² h² / 8, and never high.
    #[test]
    fn lengths_are_interpolated() {
        let function = spiky(false);
        let lengths = Lengths::new(&function, Filling::Attenuated, 16, &[0.5, 1.0, 2.0]);
        for length in [0.5, 0.6, 0.75, 1.0, 1.25, 1.9, 2.0] {
            let h: f64 = if length <= 1.0 { 0.5 } else { 1.0 };
            for front in 0..16 {
                for back in 0..16 {
                    let ends = [front, back].map(|index| 273.0 * index as f64);
                    let exact = segment(&function, Filling::Attenuated, ends, length)[3];
                    let low = exact - lengths.read(Reading::Nearest, ends, length)[3];
                    let tau = function.mean(ends[0], ends[1])[0];
                    assert!(
                        (-1e-12..=tau * tau * h * h / 8.0 + 1e-12).contains(&low),
                        "{low} {length}"
                    );
                }
            }
        }
    }
}
