//! Pre-integrated classification: colour and opacity of the segment between two samples.
//!
//! Source: Engel, Kraus, Ertl, "High-Quality Pre-Integrated Volume Rendering Using Hardware-Accelerated Pixel Shading"
//! (2001), equations 5 to 10: between its two samples the field is taken to be linear, so a segment's optical depth is the
//! integral of the extinction over the values between them, times its length over their difference. The integrals are
//! cumulative (equations 8 to 10), one number per node, so no table depends on the view, the step or a pair of values.
//! Self-attenuation, which the paper leaves out here, is in: the opacity is 1 - e^-x of the depth x, and the colour the mean
//! over the segment weighted by extinction.
//!
//! | value | format | range |
//! |---|---|---|
//! | sample | 12.F | 0 to 4095 |
//! | bin of g | 2^g codes, from half a code below its first | 4096 / 2^g bins |
//! | extinction tau | per reference length | 0 to 16 |
//! | node T, K | 2^E times the integral of tau, of tau times a colour, up to the node | u32, at most 2^32 - 2^16; 15 <= E <= 28 |
//! | node coordinate u = s + 1/2 | 12.F | 0 to 4096 |
//! | length l of a segment / reference length | `floor`ed to dl = l log2(e) 2^b | u32, 11 <= b <= 27 |
//! | y, depth in powers of two | u8.24 | 0 to 2^29 - 1 |
//! | opacity | 1.31 | 0 to 1 |
//! | colour | 1.15 or 1.31 | 0 to 1 |
//!
//! A segment of less than a bin is widened to one about its middle: with equal samples it is the linear look-up of point
//! classification, and nothing jumps between the two cases. With u0 <= u1 its ends, B = F + g:
//!
//! ```text
//! cum(X, u) = X_n + ((X_(n+1) - X_n) f + 2^(B-1) >> B)     n = u >> B, f = u mod 2^B; the last node by n = N - 1, f = 2^B
//! ds = u1 - u0,  k = clz32(ds) - 5,  R = reciprocal(ds << k)
//! Q  = (R dl) >> 26
//! y  = min(2^29 - 1, ((cum(T, u1) - cum(T, u0)) Q + 2^(h-1)) >> h)           h = E - F - k + b + 2
//! a  = absorbed(y)
//! c  = min(1, (K' R') >> 21)     V, K' = dT, min(dK, dT), both << clz32(dT) >> 5;  R' = reciprocal(V) + 1
//! ```
//!
//! Why nothing overflows: ds >= 2^B >= 2^12 and < 2^27 + 1, so 0 <= k <= 14; R <= 2^26 and dl < 2^32 give Q < 2^32; dT Q < 2^64,
//! and 2 <= h <= 45. White is exact: its K equal its T, V (R' of V) >= 2^52, so c = 1 and what is folded conserves light. The
//! order of the samples does not matter (colours within a segment are mixed, not ordered). Of a fraction of a segment
//! ([`borders`](crate::borders)) the length is dl_f = (dl f + 2^15) >> 16 in place of dl, at most dl.
//!
//! Rounding: each node once, each look-up once, y to nearest, c truncated. Error against f64 on
//! the same nodes, in ulp of 1.31: opacity at most 50 + (2^-25 + 2.5 / dl) 2^31 / e, colour times opacity at most 81 (`tests`
//! has the reasons); a node's half unit is 2^-29 of a depth of 16 codes. State: none.

use crate::classify::{Classifier, Slab, Support};
use crate::composite::Recurrence as _;
use crate::exp2::{LIMIT, absorbed};
use crate::format::Opacity;
use crate::lanes::{Lanes, Wide as _, places};
use crate::plan::Plan;
use crate::precision::Precision;
use crate::rows::three;
use crate::table::{Coding, ENTRIES, Neighboured};

/// Extinction per reference length is cut at this: e^-16 is 3e-5 of an 8-bit step.
pub const EXTINCTION_MAX: u32 = 16;

/// The most that a node can be.
pub const NODE_MAX: u32 = u32::MAX - 0xffff;

/// Exponents that nodes can have.
pub const EXPONENTS: core::ops::RangeInclusive<u32> = 15..=28;

/// Fraction bits of a length.
pub const LENGTH_BITS: core::ops::RangeInclusive<u32> = 11..=27;

/// log2 of the codes of a bin.
pub const GRAINS: core::ops::RangeInclusive<u32> = 0..=4;

/// 1.0 of a colour, 1.31.
const ONE: u32 = 1 << 31;

/// Samples of a row that go through one step after the other together.
const TOGETHER: usize = 64;

/// Lists of a table: extinction, and extinction times red, green, blue.
const LISTS: [&str; 4] = ["extinction", "red", "green", "blue"];

/// Why numbers are not a table of integrals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum IntegralError {
    /// Not 1, 2, 4, 8 or 16 codes to a bin.
    Grain {
        /// log2 of the codes of a bin, as given.
        given: u32,
    },
    /// An exponent that no table has.
    Exponent {
        /// As given.
        given: u32,
    },
    /// A list of nodes of the wrong length.
    Nodes {
        /// One more than there are bins.
        needed: usize,
        /// Nodes given.
        given: usize,
    },
    /// Nodes that fall, or rise above [`NODE_MAX`].
    Node {
        /// Which list: 0 extinction, 1 red, 2 green, 3 blue.
        list: usize,
        /// Number of the first such node.
        index: usize,
        /// Its value.
        value: u32,
    },
    /// A colour above 1.
    Colour {
        /// As given, 1.31.
        bits: u32,
    },
    /// A length's fraction bits outside [`LENGTH_BITS`].
    Length {
        /// As given.
        bits: u32,
    },
}

impl core::fmt::Display for IntegralError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Grain { given } => write!(f, "bins of 2^{given} codes; a bin has 2^0 to 2^4"),
            Self::Exponent { given } => write!(f, "nodes of exponent {given}; it is 15 to 28"),
            Self::Nodes { needed, given } => write!(f, "the table needs {needed} nodes a list, {given} given"),
            Self::Node { list, index, value } => {
                let list = LISTS.get(*list).unwrap_or(&"");
                write!(
                    f,
                    "node {index} of {list} is {value}; nodes never fall, and end at {NODE_MAX} at most"
                )
            }
            Self::Colour { bits } => write!(f, "a colour of {bits}; 1 is {ONE}"),
            Self::Length { bits } => write!(f, "a length of {bits} fraction bits; it has 11 to 27"),
        }
    }
}

impl core::error::Error for IntegralError {}

/// The colours of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colours<L> {
    /// One for all values, 1.31.
    One([u32; 3]),
    /// Integrals of extinction times red, green, blue.
    Each([L; 3]),
}

/// The length of a view's segments: all that depends on the view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Length {
    /// `log2(e)` times the length in reference lengths.
    pub scaled: u32,
    /// Its fraction bits, [`LENGTH_BITS`].
    pub bits: u32,
}

impl Length {
    /// The length of a plan's segments in smallest spacings, with as many fraction bits as fit: of the step along each axis,
    /// divided by the axis' spacing factor, the root of the sum of squares. 30 bits of it are right for cubic voxels; a
    /// spacing factor is itself wrong by 2^-16.
    pub fn of(plan: &Plan) -> Self {
        let [i, j, k] = plan.step().map(|step| step.to_bits().unsigned_abs());
        let [fi, fj, fk] = plan.spacing().map(|factor| u64::from(factor.to_bits()));
        // 32 fraction bits; a step is at most 1, a factor at least 2^-15.
        let world = |step: u64, factor: u64| (step << 15).checked_div(factor).unwrap_or(0);
        let (i, j, k) = (world(i, fi), world(j, fj), world(k, fk));
        let spare = (i | j | k).leading_zeros().min(33);
        let square = |side: u64| (side >> (33 - spare)) * (side >> (33 - spare));
        let root = (square(i) + square(j) + square(k)).isqrt();
        // log2(e), 31 fraction bits: 63 of the product, less those that were dropped.
        let scaled = u128::from(root) * 3_098_164_009;
        let bits_of = |bits: u32| {
            let drop = 63 - bits - (33 - spare);
            (scaled + (1 << drop >> 1)) >> drop
        };
        let mut bits = *LENGTH_BITS.end();
        while bits > *LENGTH_BITS.start() && bits_of(bits) > u128::from(u32::MAX) {
            bits -= 1;
        }
        Self {
            scaled: bits_of(bits) as u32,
            bits,
        }
    }
}

/// An end of a part of a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Bound {
    /// The value that the segment takes there, in a sample's format.
    pub(crate) value: i32,
    /// Where that is: 1.16, 0 at the front sample.
    pub(crate) position: u32,
}

/// A classifier over lists of nodes: borrowed ones (`&[u32]`) where memory is the caller's, or owned ones.
#[derive(Clone, Copy, Debug)]
pub struct Integral<L> {
    extinction: L,
    colours: Colours<L>,
    grain: u32,
    exponent: u32,
    length: Length,
    support: Support,
    /// The last node before which nothing is visible.
    first: u32,
}

/// Nodes that a list has for bins of 2^`grain` codes.
pub const fn nodes(grain: u32) -> usize {
    (ENTRIES >> grain) + 1
}

impl<L: AsRef<[u32]>> Integral<L> {
    /// A table of bins of 2^`grain` codes, whose nodes are 2^`exponent` times the integrals, for segments of a length.
    ///
    /// # Errors
    /// [`IntegralError`] for what is no such table.
    pub fn new(
        extinction: L,
        colours: Colours<L>,
        grain: u32,
        exponent: u32,
        length: Length,
    ) -> Result<Self, IntegralError> {
        if !GRAINS.contains(&grain) {
            return Err(IntegralError::Grain { given: grain });
        }
        if !EXPONENTS.contains(&exponent) {
            return Err(IntegralError::Exponent { given: exponent });
        }
        if !LENGTH_BITS.contains(&length.bits) {
            return Err(IntegralError::Length { bits: length.bits });
        }
        check(0, extinction.as_ref(), grain)?;
        match &colours {
            Colours::One(colour) => {
                if let Some(&bits) = colour.iter().find(|bits| **bits > ONE) {
                    return Err(IntegralError::Colour { bits });
                }
            }
            Colours::Each(lists) => {
                for (number, list) in (1..).zip(lists) {
                    check(number, list.as_ref(), grain)?;
                }
            }
        }
        let list = extinction.as_ref();
        let visible = |bin: usize| match (list.get(bin), list.get(bin + 1)) {
            (Some(a), Some(b)) => a != b,
            _ => false,
        };
        // A bin's own codes; widened segments of wider bins reach the bins beside it.
        let seen = |code: usize| {
            let bin = code >> grain;
            visible(bin) || grain > 0 && (visible(bin + 1) || bin > 0 && visible(bin - 1))
        };
        let support = Support::of((0..ENTRIES).map(seen));
        let first = (0..ENTRIES >> grain).take_while(|bin| !visible(*bin)).count() as u32;
        Ok(Self {
            extinction,
            colours,
            grain,
            exponent,
            length,
            support,
            first,
        })
    }

    /// The same table for segments of another length.
    ///
    /// # Errors
    /// [`IntegralError::Length`].
    pub fn with_length(self, length: Length) -> Result<Self, IntegralError> {
        if !LENGTH_BITS.contains(&length.bits) {
            return Err(IntegralError::Length { bits: length.bits });
        }
        Ok(Self { length, ..self })
    }

    /// Bits of a node coordinate inside a bin.
    #[inline(always)]
    fn bin_bits<P: Precision>(&self, p: P) -> u32 {
        p.formats().sample_bits + self.grain
    }

    /// The scaled length of a fraction of a segment, to nearest. This function is the definition.
    #[inline(always)]
    fn scaled(&self, fraction: u32) -> u32 {
        ((u64::from(self.length.scaled) * u64::from(fraction) + (1 << 15)) >> 16) as u32
    }

    /// Opacity of a segment by a lane, of this scaled length.
    #[inline(always)]
    fn opacity_by<P: Precision, V: Lanes>(&self, p: P, front: i32, back: i32, scaled: u32) -> i32 {
        let bits = self.bin_bits(p);
        let [low, length] = widened(front, back, p.formats().sample_bits, bits);
        let depth = over::<V>(self.extinction.as_ref(), [low, length], bits);
        if depth.all_zero() {
            return 0;
        }
        let mut out = [0];
        absorbed(self.depth(p, depth, V::splat(length), scaled)).store(&mut out, 0);
        let [out] = out;
        out
    }

    /// Colour of a segment by a lane.
    #[inline(always)]
    fn colour_by<P: Precision, V: Lanes>(&self, p: P, front: i32, back: i32) -> [u32; 3] {
        let colour_bits = p.pixel().colour_bits();
        let lists = match &self.colours {
            Colours::One(colour) => return colour.map(|c| kept(c as i32, colour_bits) as u32),
            Colours::Each(lists) => lists.each_ref().map(AsRef::as_ref),
        };
        let bits = self.bin_bits(p);
        let segment = widened(front, back, p.formats().sample_bits, bits);
        let mean = Mean::<V>::of(over(self.extinction.as_ref(), segment, bits));
        lists.map(|list| {
            let mut out = [0];
            kept(mean.of_list(over(list, segment, bits)), colour_bits).store(&mut out, 0);
            let [out] = out;
            out as u32
        })
    }

    /// Whether values have colours of their own.
    pub(crate) const fn has_colours(&self) -> bool {
        matches!(self.colours, Colours::Each(_))
    }

    /// Which voxel ranges can hold a visible segment.
    pub(crate) const fn visible(&self) -> Support {
        self.support
    }

    /// The difference of samples that are so many bins apart.
    #[inline(always)]
    pub(crate) fn bins<P: Precision>(&self, p: P, count: u32) -> i32 {
        (count << self.bin_bits(p)) as i32
    }

    /// Whether a segment is shorter than a bin, and looked up as one of a bin.
    #[inline(always)]
    pub(crate) fn is_widened<P: Precision>(&self, p: P, [front, back]: [i32; 2]) -> bool {
        back.abs_diff(front) < 1 << self.bin_bits(p)
    }

    /// Integral of a list over a part of a segment.
    #[inline(always)]
    fn over_part<P: Precision, V: Lanes>(&self, p: P, list: &[u32], values: [i32; 2]) -> V {
        let half = 1 << p.formats().sample_bits >> 1;
        let (low, high) = (values[0].min(values[1]), values[0].max(values[1]));
        over(list, [low.wrapping_add(half), high.wrapping_sub(low)], self.bin_bits(p))
    }

    /// y of a part of a segment by a lane.
    #[inline(always)]
    pub(crate) fn part_depth<P: Precision, V: Lanes>(
        &self,
        p: P,
        ends: [i32; 2],
        fraction: u32,
        part: [Bound; 2],
    ) -> u32 {
        let scaled = self.scaled(fraction);
        let bits = self.bin_bits(p);
        let [front, back] = ends;
        let [low, length] = widened(front, back, p.formats().sample_bits, bits);
        let depth = |integral: V| -> u32 {
            if integral.all_zero() {
                return 0;
            }
            let mut out = [0];
            self.depth(p, integral, V::splat(length), scaled).store(&mut out, 0);
            let [y] = out;
            y as u32
        };
        let list = self.extinction.as_ref();
        if self.is_widened(p, ends) {
            let y = depth(over(list, [low, length], bits));
            // At most 2^29, and a position of 1 is all of it.
            let up_to = |bound: Bound| ((u64::from(y) * u64::from(bound.position)) >> 16) as u32;
            return up_to(part[1]).wrapping_sub(up_to(part[0]));
        }
        depth(self.over_part(p, list, part.map(|bound| bound.value)))
    }

    /// Colour of a part of a segment by a lane.
    #[inline(always)]
    pub(crate) fn part_colour_by<P: Precision, V: Lanes>(&self, p: P, ends: [i32; 2], part: [Bound; 2]) -> [u32; 3] {
        let Colours::Each(lists) = &self.colours else {
            return self.colour_by::<P, V>(p, 0, 0);
        };
        if self.is_widened(p, ends) {
            let [front, back] = ends;
            return self.colour_by::<P, V>(p, front, back);
        }
        let values = part.map(|bound| bound.value);
        let mean = Mean::<V>::of(self.over_part(p, self.extinction.as_ref(), values));
        three(lists.each_ref(), |list| {
            let mut out = [0];
            let colour = mean.of_list(self.over_part(p, list.as_ref(), values));
            kept(colour, p.pixel().colour_bits()).store(&mut out, 0);
            let [out] = out;
            out as u32
        })
    }

    /// y: the depth in powers of two of a segment of a scaled length whose integral of the extinction this is, over a
    /// difference of samples.
    #[inline(always)]
    fn depth<P: Precision, V: Lanes>(&self, p: P, integral: V, length: V, scaled: u32) -> V {
        let k = length.leading_zeros() - V::splat(5);
        let rate = length.shl_each(k).reciprocal();
        let rate = rate.product(V::splat(scaled as i32)).shr_narrow(26);
        // One bit less, and rounded then.
        let shift = (self.exponent + self.length.bits + 1).wrapping_sub(p.formats().sample_bits);
        let y = integral.product(rate).shr_each(V::splat(shift as i32) - k);
        let y = (y + V::Wide::splat(1)).shr(1);
        y.at_most(V::Wide::splat(i64::from(LIMIT))).narrow()
    }
}

/// Whether so few segments of a row are visible that it is quicker to move them side by side.
#[inline(always)]
const fn is_sparse(visible: usize, len: usize) -> bool {
    2 * visible < len
}

/// Numbers of a row that are not 0.
#[inline(always)]
fn count<V: Lanes>(row: &[i32]) -> usize {
    let mut count = 0;
    for at in places::<V>(row.len()) {
        count += V::load(row, at).count();
    }
    count
}

/// A list's integral up to a node coordinate.
#[inline(always)]
fn up_to<V: Lanes>(list: &[u32], u: i32, bits: u32) -> V {
    let last = list.len().saturating_sub(2);
    let n = (u as u32 >> bits) as usize;
    let n = if n < last { n } else { last };
    let at = |n: usize| V::splat(list.get(n).map_or(0, |node| *node as i32));
    let f = u.wrapping_sub((n << bits) as i32);
    between(at(n), at(n + 1), V::splat(f), bits)
}

/// A list's integral over a segment.
#[inline(always)]
fn over<V: Lanes>(list: &[u32], [low, length]: [i32; 2], bits: u32) -> V {
    up_to::<V>(list, low + length, bits).wrapping_sub(up_to(list, low, bits))
}

/// The nodes as vectors look them up: one per code.
#[inline(always)]
fn by_code(list: &[u32]) -> Option<&Neighboured> {
    list.try_into().ok()
}

/// Checks a list of nodes, by its place in [`LISTS`].
fn check(number: usize, list: &[u32], grain: u32) -> Result<(), IntegralError> {
    let (needed, given) = (nodes(grain), list.len());
    if given != needed {
        return Err(IntegralError::Nodes { needed, given });
    }
    let mut last = 0;
    for (index, &value) in list.iter().enumerate() {
        if value < last || value > NODE_MAX {
            return Err(IntegralError::Node {
                list: number,
                index,
                value,
            });
        }
        last = value;
    }
    Ok(())
}

/// The lower end of a segment as a node coordinate and its length, at least a bin of 2^`bits`.
#[inline(always)]
fn widened<V: Lanes>(front: V, back: V, sample_bits: u32, bits: u32) -> [V; 2] {
    let difference = (front - back).abs();
    let length = difference.at_least(V::splat(1 << bits));
    let missing = length - difference;
    let low = front.at_most(back) + V::splat(1 << sample_bits >> 1) - ((missing + V::splat(1)) >> 1);
    let room = V::splat((ENTRIES as i32) << sample_bits) - length;
    [low.at_least(V::splat(0)).at_most(room), length]
}

/// `a + ((b - a) f + 2^(bits - 1) >> bits)` of unsigned numbers, a <= b, f <= 2^bits.
#[inline(always)]
fn between<V: Lanes>(a: V, b: V, f: V, bits: u32) -> V {
    let part = b.wrapping_sub(a).product(f) + V::Wide::splat(1 << bits >> 1);
    a.wrapping_add(part.shr_narrow(bits))
}

/// A colour of 31 bits with the bits that a pixel reads, to nearest.
#[inline(always)]
fn kept<V: Lanes>(colour: V, bits: u32) -> V {
    if bits == 31 {
        colour
    } else {
        colour.wrapping_add(V::splat(1 << (30 - bits))).shr_unsigned(31 - bits)
    }
}

/// Division by an integral of extinction: the mean of what is weighted with it.
#[derive(Clone, Copy)]
struct Mean<V> {
    integral: V,
    zeros: V,
    reciprocal: V,
}

impl<V: Lanes> Mean<V> {
    #[inline(always)]
    fn of(integral: V) -> Self {
        let zeros = integral.leading_zeros().limited(31);
        let raised = integral.shl_each(zeros).shr_unsigned(5);
        // No extinction: a mean of 0.
        let reciprocal = raised.at_least(V::splat(1 << 26)).reciprocal() + V::splat(1);
        Self {
            integral,
            zeros,
            reciprocal,
        }
    }

    /// The mean, 1.31, whose integral this is.
    #[inline(always)]
    fn of_list(self, weighted: V) -> V {
        let weighted = weighted.at_most_unsigned(self.integral);
        let raised = weighted.shl_each(self.zeros).shr_unsigned(5);
        raised.product(self.reciprocal).shr_to_one(21).narrow()
    }
}

/// The segments of some samples, on their way through the look-ups.
struct Segments<'r> {
    /// Node coordinates of the lower ends.
    low: &'r mut [i32],
    /// Those of the upper ends, but that of the last node a unit less: its bin is the last.
    high: &'r mut [i32],
    length: &'r mut [i32],
    bits: u32,
}

impl Segments<'_> {
    /// Writes the segments of a slab, from one of its samples on.
    #[inline(always)]
    fn fill<P: Precision, V: Lanes>(&mut self, p: P, slab: Slab<'_>, from: usize, len: usize) {
        let last = V::splat(((ENTRIES as i32) << p.formats().sample_bits) - 1);
        for at in places::<V>(len) {
            let (front, back) = (V::load(slab.front, from + at), V::load(slab.back, from + at));
            let [l, d] = widened(front, back, p.formats().sample_bits, self.bits);
            l.store(self.low, at);
            d.store(self.length, at);
            (l + d).at_most(last).store(self.high, at);
        }
    }

    /// Moves the chosen ones side by side.
    #[inline(always)]
    fn pack<V: Lanes>(&mut self, chosen: &[i32]) {
        let mut end = 0;
        for at in places::<V>(chosen.len()) {
            let chosen = V::load(chosen, at);
            V::load(self.low, at).packed(chosen).store(self.low, end);
            V::load(self.high, at).packed(chosen).store(self.high, end);
            V::load(self.length, at).packed(chosen).store(self.length, end);
            end += chosen.count();
        }
    }

    /// Moves what stands side by side back to the chosen places; the others hold anything.
    #[inline(always)]
    fn spread<V: Lanes>(&mut self, chosen: &[i32], mut end: usize) {
        // From the last: what stands before `end` has not been written to.
        for at in (0..chosen.len()).step_by(V::COUNT).rev() {
            let chosen = V::load(chosen, at);
            end -= chosen.count();
            V::load(self.low, end).spread(chosen).store(self.low, at);
            V::load(self.high, end).spread(chosen).store(self.high, at);
            V::load(self.length, end).spread(chosen).store(self.length, at);
        }
    }

    /// Whether all end before a node.
    #[inline(always)]
    fn end_before<V: Lanes>(&self, node: u32, len: usize) -> bool {
        let least = V::splat(((node << self.bits) + 1) as i32);
        let mut beyond = V::splat(0);
        for at in places::<V>(len) {
            let high = V::load(self.high, at);
            beyond = beyond | high.at_least_then(least, high);
        }
        beyond.all_zero()
    }

    /// A list's integrals up to some ends, whose bins are those of a row.
    #[inline(always)]
    fn up_to<V: Lanes>(&self, list: &Neighboured, bins: &[i32], end: V, at: usize) -> V {
        let coding = Coding {
            offset: 0,
            bits: self.bits,
        };
        let start = V::load(bins, at) & V::splat(-1 << self.bits);
        let [a, b] = V::look_up(list, bins, at, coding);
        between(a, b, end - start, self.bits)
    }

    /// A list's integrals over the segments.
    #[inline(always)]
    fn over<V: Lanes>(&self, list: &Neighboured, at: usize) -> V {
        let low = V::load(self.low, at);
        let high = low + V::load(self.length, at);
        self.up_to(list, self.high, high, at)
            .wrapping_sub(self.up_to(list, self.low, low, at))
    }
}

impl<P: Precision, L: AsRef<[u32]> + Sync> Classifier<P> for Integral<L> {
    const SLABS: bool = true;

    #[inline]
    fn opacity(&self, p: P, sample: i32) -> Opacity {
        self.segment_opacity(p, [sample; 2])
    }

    #[inline]
    fn colour(&self, p: P, sample: i32) -> [u32; 3] {
        self.segment_colour(p, [sample; 2])
    }

    #[inline]
    fn segment_opacity(&self, p: P, [front, back]: [i32; 2]) -> Opacity {
        Opacity::from_bits(self.opacity_by::<P, i32>(p, front, back, self.length.scaled) as u32)
    }

    #[inline]
    fn segment_colour(&self, p: P, [front, back]: [i32; 2]) -> [u32; 3] {
        self.colour_by::<P, i32>(p, front, back)
    }

    #[inline]
    fn part_opacity(&self, p: P, [front, back]: [i32; 2], fraction: u32, part: u32) -> Opacity {
        if part > 0 {
            return Opacity::ZERO;
        }
        Opacity::from_bits(self.opacity_by::<P, i32>(p, front, back, self.scaled(fraction)) as u32)
    }

    fn support(&self) -> Support {
        self.support
    }

    #[inline(always)]
    fn one_colour(&self, p: P) -> Option<[u32; 3]> {
        match &self.colours {
            Colours::One(colour) => Some(colour.map(|c| kept(c as i32, p.pixel().colour_bits()) as u32)),
            Colours::Each(_) => None,
        }
    }

    #[inline(always)]
    fn opacity_row<V: Lanes>(&self, p: P, slab: Slab<'_>, out: &mut [i32]) {
        let list = match by_code(self.extinction.as_ref()) {
            Some(list) if V::COUNT > 1 => list,
            _ if V::SMALL => return self.opacity_row_small(p, slab, out),
            _ => return self.opacity_row_single(p, slab, out),
        };
        let mut memory = [[0; TOGETHER]; 3];
        let mut integrals = [0; TOGETHER];
        let [low, high, length] = &mut memory;
        let (bits, scaled) = (self.bin_bits(p), self.scaled(slab.fraction));
        let mut segments = Segments {
            low,
            high,
            length,
            bits,
        };
        let mut from = 0;
        for out in out.chunks_mut(TOGETHER) {
            let len = out.len();
            segments.fill::<P, V>(p, slab, from, len);
            from += TOGETHER;
            if segments.end_before::<V>(self.first, len) {
                out.fill(0);
                continue;
            }
            for at in places::<V>(len) {
                segments.over::<V>(list, at).store(out, at);
            }
            let visible = count::<V>(out);
            if visible == 0 {
                continue;
            }
            if !is_sparse(visible, len) {
                for at in places::<V>(len) {
                    let y = self.depth(p, V::load(out, at), V::load(segments.length, at), scaled);
                    absorbed(y).store(out, at);
                }
                continue;
            }
            // Visible ones alone go on, side by side, and back to their places.
            let mut end = 0;
            for at in places::<V>(len) {
                let (integral, length) = (V::load(out, at), V::load(segments.length, at));
                integral.packed(integral).store(&mut integrals, end);
                length.packed(integral).store(segments.length, end);
                end += integral.count();
            }
            for at in places::<V>(visible) {
                let y = self.depth(p, V::load(&integrals, at), V::load(segments.length, at), scaled);
                absorbed(y).store(&mut integrals, at);
            }
            for at in (0..len).step_by(V::COUNT).rev() {
                let chosen = V::load(out, at);
                end -= chosen.count();
                chosen
                    .nonzero_then(V::load(&integrals, end).spread(chosen))
                    .store(out, at);
            }
        }
    }

    #[inline(always)]
    fn colour_row<V: Lanes>(&self, p: P, slab: Slab<'_>, out: [&mut [i32]; 3]) {
        let bits = p.pixel().colour_bits();
        let [red, green, blue] = out;
        let lists = match &self.colours {
            Colours::One(colour) => {
                for (row, c) in [red, green, blue].into_iter().zip(colour) {
                    row.fill(kept(*c as i32, bits));
                }
                return;
            }
            Colours::Each(lists) => lists.each_ref().map(AsRef::as_ref),
        };
        let (Some(extinction), [Some(r), Some(g), Some(b)], true) =
            (by_code(self.extinction.as_ref()), lists.map(by_code), V::COUNT > 1)
        else {
            let out = [red, green, blue];
            return if V::SMALL {
                self.colour_row_small(p, slab, out)
            } else {
                self.colour_row_single(p, slab, out)
            };
        };
        // The rows hold the segments until their colours are there: spans are short, and other memory would cost more.
        let len = red.len();
        let mut segments = Segments {
            low: red,
            high: green,
            length: blue,
            bits: self.bin_bits(p),
        };
        segments.fill::<P, V>(p, slab, 0, len);
        let visible = count::<V>(slab.opacities);
        let sparse = slab.opacities.len() == len && is_sparse(visible, len);
        if sparse {
            segments.pack::<V>(slab.opacities);
        }
        for at in places::<V>(if sparse { visible } else { len }) {
            let mean = Mean::of(segments.over::<V>(extinction, at));
            let red = kept(mean.of_list(segments.over(r, at)), bits);
            let green = kept(mean.of_list(segments.over(g, at)), bits);
            let blue = kept(mean.of_list(segments.over(b, at)), bits);
            red.store(segments.low, at);
            green.store(segments.high, at);
            blue.store(segments.length, at);
        }
        if sparse {
            segments.spread::<V>(slab.opacities, visible);
        }
    }
}

impl<L: AsRef<[u32]>> Integral<L> {
    /// Opacities segment by segment.
    #[inline(never)]
    fn opacity_row_single<P: Precision>(&self, p: P, slab: Slab<'_>, out: &mut [i32]) {
        let scaled = self.scaled(slab.fraction);
        for ((o, &front), &back) in out.iter_mut().zip(slab.front).zip(slab.back) {
            *o = self.opacity_by::<P, i32>(p, front, back, scaled);
        }
    }

    /// Colours segment by segment.
    #[inline(never)]
    fn colour_row_single<P: Precision>(&self, p: P, slab: Slab<'_>, [red, green, blue]: [&mut [i32]; 3]) {
        let out = red.iter_mut().zip(green).zip(blue);
        for ((((r, g), b), &front), &back) in out.zip(slab.front).zip(slab.back) {
            [*r, *g, *b] = self.colour_by::<P, i32>(p, front, back).map(|c| c as i32);
        }
    }
}

mod small;

#[cfg(test)]
mod tests;
