//! Splatting in perspective: where voxels lie that an eye sees, how wide their kernels look, and what rays through a sheet are.
//!
//! Source: Squeeze, section 4.6.1; `docs/contract/splatting-in-perspective.md` has the formulas, ranges and proofs.
//!
//! Places are divided by their depth, by its reciprocal; a bin's kernels have one width, that of its middle.
//!
//! | value | format | unit |
//! |---|---|---|
//! | place from the eye | s31.32 | sheets |
//! | distance of the image | u16.16 | pixels |
//! | reciprocal of depth | 2^60 over 30 bits of it | |
//! | slope of a voxel | s2.34 | |
//! | width of a kernel | 16.16 | pixels |
//! | slope of a pixel | s4.27 | |
//!
//! Rounding: quotients and places to nearest, halves up; widths down, reach up. Overflow: none of what
//! [`Splatting::from_eye`](super::Splatting::from_eye) takes. State: none.

use core::marker::PhantomData;

use super::kernel;
use crate::lanes::{Kernel, Lanes, places};
use crate::perspective::{ALONG_K, Way, square};
use crate::rows::{part, part_mut};

/// Distances of the image from the eye, pixels, 16.16.
pub const DISTANCES: core::ops::Range<u32> = 1 << 14..1 << 31;
/// How far the first voxel may lie from the eye along each axis, sheets.
pub const PLACE_MAX: i64 = 1 << 26;
/// log2 of the widest kernel, pixels.
const WIDEST: u32 = 7;
/// 1 in 16 fraction bits.
const ONE: u32 = 1 << 16;
/// A factor of 1, s4.27.
const FACTOR_ONE: i32 = 1 << 27;
/// Half a unit of what 27 fraction bits are cut from.
const HALF: i64 = 1 << 26;
/// Fraction bits of a voxel's slope.
const SLOPE: u32 = 34;
/// Fraction bits of the slopes of pixel 0 and of the next.
const STEP: u32 = 44;
/// Magnitudes of slopes of pixels along x and along y, together: those of gradients stay within 31 bits.
const SLOPES_MAX: i64 = 7 << 27;

/// Kernels of a bin: how wide they look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scale {
    /// 1 over the widths along x and y, 24 fraction bits; `None` where tables are made for the widths.
    inverse: Option<[u32; 2]>,
    /// Along x and y, 13 fraction bits, upwards.
    pub(super) reach: [u32; 2],
}

impl Scale {
    /// Of tables that are made for the widths themselves.
    pub(super) const fn own(widths: [u32; 3]) -> Self {
        Self {
            inverse: None,
            reach: kernel::reach(widths),
        }
    }

    /// Of widths along x and y, pixels, 16.16.
    fn of([x, y]: [u32; 2]) -> Self {
        Self {
            inverse: Some([x, y].map(|width| nearest(1 << 40, width.into()) as u32)),
            reach: kernel::reach([x, y, ONE]),
        }
    }

    /// The weight at a distance in pixels along x (axis 0) or y (axis 1) with 13 fraction bits, 1.16.
    #[inline(always)]
    pub(super) fn weight(&self, kernel: &kernel::Kernel<'_>, axis: usize, pixels: u32) -> u32 {
        let Some(inverse) = self.inverse else {
            return kernel.weight(axis, pixels);
        };
        let inverse = inverse.get(axis).copied().unwrap_or(0);
        kernel::weight((u64::from(pixels) * u64::from(inverse) + (1 << 16)) >> 17)
    }
}

/// `a / b` to nearest, halves up.
const fn nearest(a: u64, b: u64) -> u64 {
    match (2 * a + b).checked_div(2 * b) {
        Some(quotient) => quotient,
        None => 0,
    }
}

/// An eye that looks along z through the middle of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Eye {
    /// Distance of the image, pixels, 16.16.
    distance: u32,
    /// The depth that bins begin at, s31.32, above 0.
    near: i64,
    /// Whether some voxels may lie in front of it.
    cut: bool,
    size: [u32; 2],
    /// Pixels before the image in a record.
    margin: [u32; 2],
    /// The largest magnitudes of a record's slopes along x and y, s2.34.
    steepest: [i64; 2],
    /// Of pixel 0, 44 fraction bits.
    start: [i64; 2],
    /// From pixel to pixel.
    growth: i64,
    /// Widths of the kernel along x, y and z, sheets, 16.16.
    widths: [u32; 3],
    rho: u32,
    /// Magnitude of the determinant of the steps, 48 fraction bits.
    volume: u128,
}

impl Eye {
    /// Bins that begin at the voxel nearest to the eye, or as near to it as kernels may be looked at.
    pub(super) fn new(
        distance: u32,
        nearest_voxel: i64,
        size: [u32; 2],
        (widths, rho, volume): ([u32; 3], u32, u128),
    ) -> Self {
        let [wx, wy, _] = widths;
        let widest = u64::from(wx.max(wy));
        let least = (widest << 17)
            .max(2 << 32)
            .max(((widest * u64::from(distance)) >> WIDEST) + 1) as i64;
        let growth = nearest(1 << (STEP + 16), distance.into()) as i64;
        let mut eye = Self {
            distance,
            near: least.max(nearest_voxel),
            cut: nearest_voxel < least,
            size,
            margin: [0; 2],
            steepest: [0; 2],
            start: size.map(|side| -((i64::from(side) - 1) * growth) >> 1),
            growth,
            widths,
            rho,
            volume,
        };
        // The widest are those of the first bin.
        eye.margin = eye.pixels(0).map(|width| ((3 * width) >> 17) + 2);
        let mut edges = eye.steepest.iter_mut().zip(size).zip(eye.margin);
        edges.by_ref().for_each(|((steepest, side), margin)| {
            let edge = (i64::from(side) << 49) + (i64::from(margin) << 50);
            *steepest = edge.checked_div(distance.into()).unwrap_or(0) + 1;
        });
        eye
    }

    /// Distance of the image, pixels, 16.16.
    pub const fn distance(&self) -> u32 {
        self.distance
    }

    /// Widths of the kernel along x, y and z, sheets, 16.16.
    pub const fn widths(&self) -> [u32; 3] {
        self.widths
    }

    /// The depth that bins begin at, s31.32.
    pub const fn near(&self) -> i64 {
        self.near
    }

    /// Pixels before the image in a record.
    pub const fn margin(&self) -> [u32; 2] {
        self.margin
    }

    /// Whether slopes fit their formats, with the record's margins.
    pub(super) fn fits(&self) -> bool {
        let [x, y] = self.largest();
        self.steepest.iter().all(|slope| *slope < 4 << SLOPE) && x + y < SLOPES_MAX
    }

    /// The largest magnitudes of pixels' slopes along x and y, s4.27.
    fn largest(&self) -> [i64; 2] {
        self.start.map(|start| (start.unsigned_abs() >> (STEP - 27)) as i64 + 1)
    }

    /// The same, 16 fraction bits, upwards.
    pub(super) fn edges(&self) -> [u32; 2] {
        self.largest().map(|slope| (slope >> 11) as u32 + 1)
    }

    /// The first sheet that no voxel in front of the nearest depth reaches, of those that kernels which reach so many begin at.
    pub(super) const fn first(&self, reached: u32) -> u32 {
        if self.cut { reached - 1 } else { 0 }
    }

    /// A voxel's place in the record's pixels along x and y, with so many fraction bits, from its place from the eye; none where it is
    /// beyond them. This function is the definition.
    #[inline(always)]
    pub fn project(&self, [x, y, z]: [i64; 3], bits: u32) -> Option<[u32; 2]> {
        let cut = (34 - z.leading_zeros() as i32).max(1) as u32;
        let short = |c: i64| (c + (1 << (cut - 1))) >> cut;
        let depth = short(z);
        if depth <= 0 {
            return None;
        }
        let reciprocal = nearest(1 << 60, depth as u64) as i64;
        let mut place = [0; 2];
        for (axis, (place, c)) in place.iter_mut().zip([x, y]).enumerate() {
            let c = short(c);
            if c.unsigned_abs() >= 4 * depth as u64 {
                return None;
            }
            let slope = (c * reciprocal + (1 << 25)) >> (60 - SLOPE);
            let [steepest, side, margin] = [
                self.steepest.get(axis).copied()?,
                self.size.get(axis).copied()?.into(),
                self.margin.get(axis).copied()?.into(),
            ];
            if slope.abs() > steepest {
                return None;
            }
            let exact = slope * i64::from(self.distance) + ((side - 1) << 49) + (margin << 50);
            let near = (exact + (1 << (49 - bits))) >> (50 - bits);
            if !(0..=(side + 2 * margin - 1) << bits).contains(&near) {
                return None;
            }
            *place = near as u32;
        }
        Some(place)
    }

    /// Widths of a bin's kernels along x and y, pixels, 16.16. This function is the definition.
    fn pixels(&self, bin: u32) -> [u32; 2] {
        let middle = (self.near + (i64::from(bin) << 32) + (1 << 31)) >> 16;
        let [x, y, _] = self.widths;
        [x, y].map(|width| {
            let looked = (u64::from(width) * u64::from(self.distance)).checked_div(middle as u64);
            (looked.unwrap_or(0) as u32).max(ONE)
        })
    }

    /// Kernels of a bin.
    pub(super) fn scale(&self, bin: u32) -> Scale {
        Scale::of(self.pixels(bin))
    }

    /// Distance of the pixels of a sheet, sheets, 16.16, and that of a depth.
    fn apart(&self, depth: i64) -> u32 {
        let apart = depth.max(0).checked_div(self.distance.into()).unwrap_or(0);
        apart.min(i64::from(u32::MAX)) as u32
    }

    /// Depth of the middle of a sheet, s31.32.
    fn middle(&self, sheet: u32) -> i64 {
        self.near + ((i64::from(sheet) + 1) << 32) - (i64::from(self.rho) << 16)
    }

    /// The sum of weights from which on a sample of a sheet exists.
    pub(super) fn least(&self, sheet: u32) -> u64 {
        let (apart, [x, y, z]) = (self.apart(self.middle(sheet)), self.widths);
        super::nominal([apart.max(x), apart.max(y), z], self.volume).div_ceil(2)
    }

    /// Factors of differences on a sheet, of those along x and y and of those from sheet to sheet, 4.27: the greater length is one.
    fn factors(&self, sheet: u32) -> [i32; 2] {
        let middle = self.middle(sheet).max(0);
        let apart = self.apart(middle).max(1);
        if apart <= ONE {
            // The middle is at most 2^16 + 1 times the distance, below 2^48.
            let along = (middle << 11).checked_div(self.distance.into()).unwrap_or(0);
            [FACTOR_ONE, along.min(FACTOR_ONE.into()) as i32]
        } else {
            [nearest(1 << 43, apart.into()) as i32, FACTOR_ONE]
        }
    }

    /// Half sides of the box about a ray whose voxels reach a pixel, sheets, 16.16, upwards; `unit` is half a unit of a record.
    pub(super) fn reach(&self, farthest: i64, unit: u32) -> [u32; 2] {
        let (far, [x, y, _]) = (self.apart(farthest).saturating_add(1), self.widths);
        let rounded = u64::from(unit) + 5;
        [x, y].map(|width| {
            let nearer = (u64::from(width) << 31)
                .checked_div(self.near as u64 >> 16)
                .unwrap_or(0);
            let looked = u64::from(far).max(u64::from(width) + (nearer >> 16) + 1);
            let rounded = (rounded * u64::from(far.max(ONE))) >> 16;
            u32::try_from(((3 * looked) >> 1) + 1 + rounded + 1).unwrap_or(u32::MAX)
        })
    }

    /// How far the pixels of the farthest sheet lie apart, sheets, 16.16, upwards.
    pub(super) fn coarsest(&self, farthest: i64) -> u32 {
        self.apart(farthest).saturating_add(1)
    }

    /// The slope of a pixel along x (axis 0) or y (axis 1), s4.27. This function is the definition.
    #[inline]
    pub fn slope(&self, axis: usize, pixel: u32) -> i32 {
        let start = self.start.get(axis).copied().unwrap_or(0);
        ((start + i64::from(pixel) * self.growth) >> (STEP - 27)) as i32
    }
}

/// Rays through the pixels of some rows of an image.
#[derive(Clone, Copy, Debug)]
pub struct Rays<'a> {
    pub(super) eye: &'a Eye,
    /// Of the sheet that is folded.
    pub(super) factors: [i32; 2],
    /// Number of the first row.
    pub(super) first: u32,
    pub(super) width: usize,
    /// Lengths of steps, 3.20, and where there is light unit vectors towards the eye, s1.30.
    pub(super) rows: [&'a [i32]; 4],
}

impl<'a> Rays<'a> {
    /// Words of so many rows.
    pub const fn len(size: [u32; 2], rows: u32, lit: bool) -> usize {
        let [width, _] = size;
        width as usize * rows as usize * if lit { 4 } else { 1 }
    }

    /// Makes the rays of rows from `first` on, in memory of [`Rays::len`].
    pub(crate) fn make<V: Lanes>(eye: &'a Eye, rows: (u32, u32), lit: bool, memory: &'a mut [i32]) -> Self {
        V::enter((Make, PhantomData::<V>, eye, rows, lit, memory))
    }

    #[inline(always)]
    fn made<V: Lanes>(eye: &'a Eye, (first, rows): (u32, u32), lit: bool, memory: &'a mut [i32]) -> Self {
        let width = eye.size[0] as usize;
        let len = width * rows as usize;
        let (lengths, rest) = memory.split_at_mut(len.min(memory.len()));
        let lit = if lit { len } else { 0 };
        let (x, rest) = rest.split_at_mut(lit.min(rest.len()));
        let (y, rest) = rest.split_at_mut(lit.min(rest.len()));
        let z = part_mut(rest, 0..lit);
        for row in 0..rows {
            let at = row as usize * width..(row as usize + 1) * width;
            let lengths = part_mut(lengths, at.clone());
            let down = eye.slope(1, first + row);
            for (column, length) in (0..).zip(&mut *lengths) {
                *length = eye.slope(0, column);
            }
            if lit > 0 {
                let towards = [part_mut(x, at.clone()), part_mut(y, at.clone()), part_mut(z, at)];
                make_towards::<V>(lengths, down, towards);
            }
            make_lengths::<V>(lengths, down);
        }
        Self {
            eye,
            factors: [FACTOR_ONE; 2],
            first,
            width,
            rows: [lengths, x, y, z],
        }
    }

    /// The same through a sheet.
    pub(super) fn through(self, sheet: u32) -> Self {
        Self {
            factors: self.eye.factors(sheet),
            ..self
        }
    }

    /// A row of the image of these; empty where there is none.
    fn row(&self, number: usize, row: u32) -> &'a [i32] {
        let start = (row.saturating_sub(self.first) as usize).saturating_mul(self.width);
        let rows = self.rows.get(number).copied().unwrap_or(&[]);
        part(rows, start..start.saturating_add(self.width))
    }

    /// Lengths of the steps of a row, 3.20.
    #[inline]
    pub fn lengths(&self, row: u32) -> &'a [i32] {
        self.row(0, row)
    }

    /// Unit vectors towards the eye, s1.30.
    #[inline]
    pub fn towards(&self, row: u32) -> [&'a [i32]; 3] {
        [1, 2, 3].map(|number| self.row(number, row))
    }

    /// Brings differences of a row, from a column on, to the lengths between pixels and sheets, and those along rays to z.
    #[inline(always)]
    pub fn tilt(&self, (row, column): (u32, usize), [gx, gy, gz]: [&mut [i32]; 3]) {
        let [across, along] = self.factors;
        if across != FACTOR_ONE {
            for component in gx.iter_mut().chain(&mut *gy) {
                *component = ((i64::from(*component) * i64::from(across) + HALF) >> 27) as i32;
            }
        }
        let down = self.eye.slope(1, row);
        for (column, ((gx, gy), gz)) in (column as u32..).zip(gx.iter().zip(gy).zip(gz)) {
            *gz = tilted([*gx, *gy, *gz], along, [self.eye.slope(0, column), down]);
        }
    }
}

struct Make;

impl<'a, V: Lanes> Kernel for (Make, PhantomData<V>, &'a Eye, (u32, u32), bool, &'a mut [i32]) {
    type Output = Rays<'a>;

    #[inline(always)]
    fn run(self) -> Rays<'a> {
        let (_, _, eye, rows, lit, memory) = self;
        Rays::made::<V>(eye, rows, lit, memory)
    }
}

/// A difference along a ray of these slopes, times a factor of at most 1, as one along z; slopes and factor s4.27, to nearest, halves up. This
/// function is the definition.
#[inline(always)]
pub const fn tilted([gx, gy, gz]: [i32; 3], along: i32, [x, y]: [i32; 2]) -> i32 {
    let sum = gz as i64 * along as i64 - gx as i64 * x as i64 - gy as i64 * y as i64;
    ((sum + HALF) >> 27) as i32
}

/// Makes a row of slopes along x one of lengths.
#[inline(always)]
fn make_lengths<V: Lanes>(slopes: &mut [i32], down: i32) {
    let down = V::splat(square(down));
    for at in places::<V>(slopes.len()) {
        let way = Way::of([square(V::load(slopes, at)), down]);
        way.length().store(slopes, at);
    }
}

/// Unit vectors of a row of slopes along x.
#[inline(always)]
fn make_towards<V: Lanes>(slopes: &[i32], down: i32, [x, y, z]: [&mut [i32]; 3]) {
    let (slope, square_down) = (V::splat(down), V::splat(square(down)));
    for at in places::<V>(slopes.len()) {
        let along = V::load(slopes, at);
        let way = Way::of([square(along), square_down]);
        way.towards(along).store(x, at);
        way.towards(slope).store(y, at);
        way.towards(V::splat(ALONG_K)).store(z, at);
    }
}
