//! Splatting into image-aligned sheets: voxels go to the samples, where rays fetch samples from the voxels.
//!
//! Source: Squeeze, sections 4.5 and 4.6; `docs/contract/splatting.md` has the formulas, ranges and proofs.
//!
//! A voxel's place in the image is computed once and kept as a [record](Layout) of 64 bits, in the [bin](Bins) of the first sheet
//! that it reaches. Sheets gather the weights of the kernels that they cut, and weights times values ([`Sheets`]); the quotients are
//! samples, and what comes behind is the pipeline of rays ([`plane::FoldSheet`](crate::plane::FoldSheet)).
//!
//! | value | format | unit |
//! |---|---|---|
//! | step, place of a voxel | s31.32 | pixels, sheets |
//! | x, y of a record | u11.F | pixels |
//! | u of a record | U bits | sheet |
//! | v of a record | V bits | data code |
//! | width of a kernel | 16.16 | pixels, sheets |
//! | weight | 1.18 | |
//! | sample | 12.12, 12.15 | data code |
//!
//! Rounding: places to nearest, halves up; each product of weights to nearest; the quotient to nearest. Overflow: none of what
//! [`Splatting::new`] takes. State: none.

mod band;
mod bins;
mod eye;
mod kernel;
mod sheets;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod tests_from_eye;

use core::fmt;

pub use self::band::Bands;
pub use self::bins::{BLOCK, Bins, Needed, Voxels, measure_layer};
pub use self::eye::{DISTANCES, Eye, PLACE_MAX, Rays, tilted};
pub use self::kernel::{Kernel, product, weight};
pub use self::sheets::{MISSING, Sheet, Sheets, sample, slope};
use crate::format::Step;
use crate::table::ENTRIES;

/// The most voxels along a side.
pub const SIDE_MAX: u32 = 8192;
/// Whole pixels that a record can tell apart along x and along y.
pub const PIXELS: u32 = 2048;
/// Widths of a kernel, 16.16: pixels are not longer than voxels, but for rounding.
pub const WIDTHS: core::ops::RangeInclusive<u32> = 64_881..=32 << 16;
/// The most that sums of weights may come to: they have 26 bits.
const SUM_MAX: u64 = 1 << 26;
/// The largest weight.
const WEIGHT_MAX: u64 = 110_592;
/// The largest code.
const CODE_MAX: u32 = ENTRIES as u32 - 1;

/// Bits of a record: from the top x, u, y and v.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    position_bits: u32,
    depth_bits: u32,
    value_bits: u32,
}

impl Layout {
    /// Squeeze's, section 4.6.1: x 11.13, u 8, y 11.13, v 8.
    pub const PAPER: Self = Self {
        position_bits: 13,
        depth_bits: 8,
        value_bits: 8,
    };
    /// x 11.11, u 8, y 11.11, v 12: the whole of a code.
    pub const FINE: Self = Self {
        position_bits: 11,
        depth_bits: 8,
        value_bits: 12,
    };

    /// So many fraction bits of x and y, bits of u, and bits of v.
    ///
    /// # Errors
    /// [`SplatError::Layout`] for less than 6 or more than 13, less than 1 or more than 10, less than 4 or more than 12, and for what
    /// does not fit 64 bits.
    pub const fn new(position_bits: u32, depth_bits: u32, value_bits: u32) -> Result<Self, SplatError> {
        let fits = position_bits >= 6
            && position_bits <= 13
            && depth_bits >= 1
            && depth_bits <= 10
            && value_bits >= 4
            && value_bits <= 12
            && 2 * (11 + position_bits) + depth_bits + value_bits <= 64;
        if fits {
            Ok(Self {
                position_bits,
                depth_bits,
                value_bits,
            })
        } else {
            Err(SplatError::Layout {
                position_bits,
                depth_bits,
                value_bits,
            })
        }
    }

    /// Fraction bits of x and y.
    pub const fn position_bits(self) -> u32 {
        self.position_bits
    }

    /// Bits of u.
    pub const fn depth_bits(self) -> u32 {
        self.depth_bits
    }

    /// Bits of v.
    pub const fn value_bits(self) -> u32 {
        self.value_bits
    }

    /// The record of a place and a code.
    #[inline(always)]
    pub(crate) const fn pack(self, [x, y]: [u32; 2], u: u32, code: u16) -> u64 {
        let side = 11 + self.position_bits;
        let high = ((x as u64) << self.depth_bits) | u as u64;
        (((high << side) | y as u64) << self.value_bits) | self.stored(code) as u64
    }

    /// x and y, u and the code of a record.
    #[inline(always)]
    pub(crate) const fn unpack(self, record: u64) -> ([u32; 2], u32, u32) {
        let side = 11 + self.position_bits;
        let v = record & ((1 << self.value_bits) - 1);
        let rest = record >> self.value_bits;
        let y = rest & ((1 << side) - 1);
        let rest = rest >> side;
        let u = rest & ((1 << self.depth_bits) - 1);
        (
            [(rest >> self.depth_bits) as u32, y as u32],
            u as u32,
            self.code(v as u32),
        )
    }

    /// The code that a record keeps of one; it rises with it.
    pub(crate) const fn kept(self, code: u16) -> u16 {
        self.code(self.stored(code)) as u16
    }

    /// A code as it is stored: the nearest of 2^V even steps.
    const fn stored(self, code: u16) -> u32 {
        let (code, steps) = (code as u32, (1 << self.value_bits) - 1);
        if steps == CODE_MAX {
            return code;
        }
        match (2 * code * steps + CODE_MAX).checked_div(2 * CODE_MAX) {
            Some(stored) => stored,
            None => 0,
        }
    }

    /// What is stored, as a code again.
    const fn code(self, stored: u32) -> u32 {
        let steps = (1 << self.value_bits) - 1;
        if steps == CODE_MAX {
            return stored;
        }
        match (2 * stored * CODE_MAX + steps).checked_div(2 * steps) {
            Some(code) => code,
            None => 0,
        }
    }
}

/// Why voxels cannot be splatted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SplatError {
    /// A side of the volume.
    Sides {
        /// Voxels along the axes.
        dims: [u32; 3],
    },
    /// Bits of a record.
    Layout {
        /// Fraction bits of x and y.
        position_bits: u32,
        /// Bits of u.
        depth_bits: u32,
        /// Bits of v.
        value_bits: u32,
    },
    /// The voxels lie in a plane or on a line.
    Flat,
    /// The width of a kernel.
    Width {
        /// Along x, y and z, 16.16.
        widths: [u32; 3],
    },
    /// An image that a record's x and y do not reach across.
    Image {
        /// Pixels with the margins.
        size: [u32; 2],
    },
    /// Too many voxels may reach a pixel.
    Crowded {
        /// How many.
        voxels: u64,
    },
    /// Memory of another length.
    Memory {
        /// Elements needed.
        needed: usize,
        /// Elements given.
        given: usize,
    },
    /// A voxel of more than 12 bits.
    Value {
        /// Its value.
        value: u16,
    },
    /// More records than bins can count.
    Records,
    /// The distance of the image from the eye, pixels, 16.16.
    Distance {
        /// The distance's bits.
        bits: u32,
    },
    /// The first voxel is farther from the eye than [`PLACE_MAX`] sheets along an axis.
    Far,
    /// Rays that run too far to the side.
    Slopes,
    /// All voxels lie behind the eye, or too near to it.
    Nothing,
}

impl fmt::Display for SplatError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sides { dims: [x, y, z] } => {
                write!(
                    f,
                    "a volume of {x} x {y} x {z} voxels; accepted: 1 to {SIDE_MAX} along each axis"
                )
            }
            Self::Layout {
                position_bits,
                depth_bits,
                value_bits,
            } => write!(
                f,
                "records of {position_bits} fraction bits, {depth_bits} of depth and {value_bits} of the value; accepted: 6 to 13, 1 to 10 and 4 to \
                 12, 64 with 22 whole bits in all"
            ),
            Self::Flat => write!(f, "steps along the three axes lie in a plane"),
            Self::Width { widths } => {
                let [x, y, z] = widths.map(|width| width >> 16);
                write!(
                    f,
                    "kernels of {x} x {y} pixels and {z} sheets; accepted: 1 to 32 along each axis"
                )
            }
            Self::Image { size: [x, y] } => {
                write!(
                    f,
                    "an image of {x} x {y} pixels with its margins; accepted: at most {PIXELS} along each side"
                )
            }
            Self::Crowded { voxels } => {
                write!(f, "up to {voxels} voxels reach a pixel; accepted: fewer than 607")
            }
            Self::Memory { needed, given } => write!(f, "{needed} elements of memory are needed, {given} given"),
            Self::Value { value } => write!(f, "a voxel of {value}; accepted: 0 to {CODE_MAX}"),
            Self::Records => write!(f, "2^32 records or more"),
            Self::Distance { bits } => {
                write!(
                    f,
                    "an image {bits}/2^16 pixels from the eye; accepted: 0.25 to 32768, not included"
                )
            }
            Self::Far => write!(
                f,
                "an eye farther than {PLACE_MAX} sheets from the first voxel along an axis"
            ),
            Self::Slopes => write!(
                f,
                "rays that run too far to the side; accepted: slopes below 4 with what kernels reach beyond the image, and together below 7"
            ),
            Self::Nothing => write!(f, "no voxel lies far enough in front of the eye"),
        }
    }
}

impl core::error::Error for SplatError {}

/// How a volume lies in the frame of an image: what a plan is for rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Splatting {
    dims: [u32; 3],
    /// Place of voxel (0, 0, 0) in the record's pixels along x and y, and of depth behind the nearest voxel, s31.32.
    origin: [i64; 3],
    /// Of a voxel along each axis.
    steps: [[i64; 3]; 3],
    size: [u32; 2],
    layout: Layout,
    widths: [u32; 3],
    /// Pixels before the image in a record.
    margin: [u32; 2],
    /// Reach along z, 16.16.
    rho: u32,
    bins: u32,
    /// Half of the sum of weights within the volume.
    least: u64,
    /// Reach of a sample in voxels along each axis of the volume, and with a neighbour.
    reach: [[u32; 2]; 3],
    /// Where rays spread from.
    eye: Option<Eye>,
}

impl Splatting {
    /// A volume of these sides whose voxel (0, 0, 0) lies at `origin`, in pixels from the first of an image of `size`; the next voxel
    /// along each axis lies `steps` of it further, pixels along x and y, sheets along z.
    ///
    /// # Errors
    /// [`SplatError`], with what is out of range.
    pub fn new(
        dims: [u32; 3],
        origin: [Step; 2],
        steps: [[Step; 3]; 3],
        size: [u32; 2],
        layout: Layout,
    ) -> Result<Self, SplatError> {
        if dims.iter().any(|side| !(1..=SIDE_MAX).contains(side)) {
            return Err(SplatError::Sides { dims });
        }
        let steps = steps.map(|step| step.map(Step::to_bits));
        let widths = widths(&steps);
        if widths.iter().any(|width| !WIDTHS.contains(width)) {
            return Err(SplatError::Width { widths });
        }
        let [wx, wy, wz] = widths;
        // A pixel beyond what a kernel reaches.
        let margin = [wx, wy].map(|width| ((3 * width) >> 17) + 2);
        let [mx, my] = margin;
        whole(size, margin)?;
        let lattice = Lattice::of(&steps).ok_or(SplatError::Flat)?;
        let rho = (3 * wz + (1 << 16) + 1) >> 1;
        // Half a unit of a record besides: places are rounded.
        let unit = 1 << (15 - layout.position_bits);
        let reach = [
            ((3 * wx) >> 1) + 1 + unit,
            ((3 * wy) >> 1) + 1 + unit,
            rho + (1 << (15 - layout.depth_bits)),
        ];
        let voxels = lattice.count(reach);
        if voxels.saturating_mul(WEIGHT_MAX) >= SUM_MAX {
            return Err(SplatError::Crowded { voxels });
        }
        let [nearest, farthest] = depths(&steps, dims);
        let [ox, oy] = origin;
        let [x, y] = [(ox, mx), (oy, my)].map(|(place, margin)| place.to_bits() + (i64::from(margin) << 32));
        let bins = rounded(farthest - nearest, layout.depth_bits) >> layout.depth_bits;
        Ok(Self {
            dims,
            origin: [x, y, -nearest],
            steps,
            size,
            layout,
            widths,
            margin,
            rho,
            bins: bins as u32 + 1,
            least: nominal(widths, lattice.volume).div_ceil(2),
            reach: lattice.reach(reach),
            eye: None,
        })
    }

    /// A volume of these sides that is seen from an eye, which looks along z through the middle of an image of `size`. Voxel
    /// (0, 0, 0) lies at `first` from the eye, the next voxel along each axis `steps` further: x to the right, y down, z away,
    /// all in sheets. The image lies `distance` pixels from the eye, 16.16.
    ///
    /// # Errors
    /// [`SplatError`], with what is out of range.
    pub fn from_eye(
        dims: [u32; 3],
        first: [Step; 3],
        steps: [[Step; 3]; 3],
        (distance, size): (u32, [u32; 2]),
        layout: Layout,
    ) -> Result<Self, SplatError> {
        if dims.iter().any(|side| !(1..=SIDE_MAX).contains(side)) {
            return Err(SplatError::Sides { dims });
        }
        if !DISTANCES.contains(&distance) {
            return Err(SplatError::Distance { bits: distance });
        }
        let origin = first.map(Step::to_bits);
        if origin.iter().any(|c| c.unsigned_abs() >> 32 >= PLACE_MAX as u64) {
            return Err(SplatError::Far);
        }
        let steps = steps.map(|step| step.map(Step::to_bits));
        let widths = widths(&steps);
        if widths.iter().any(|width| !WIDTHS.contains(width)) {
            return Err(SplatError::Width { widths });
        }
        let lattice = Lattice::of(&steps).ok_or(SplatError::Flat)?;
        let [_, _, wz] = widths;
        let rho = (3 * wz + (1 << 16) + 1) >> 1;
        let [_, _, z] = origin;
        let [nearest, farthest] = depths(&steps, dims).map(|depth| z + depth);
        let eye = Eye::new(distance, nearest, size, (widths, rho, lattice.volume));
        if farthest < eye.near() {
            return Err(SplatError::Nothing);
        }
        let margin = eye.margin();
        whole(size, margin)?;
        if !eye.fits() {
            return Err(SplatError::Slopes);
        }
        let unit = 1 << (15 - layout.position_bits);
        let ([hx, hy], [px, py]) = (eye.reach(farthest, unit), eye.edges());
        let deep = rho + (1 << (15 - layout.depth_bits));
        let voxels = lattice.tilted([px, py]).count([hx, hy, deep]);
        if voxels.saturating_mul(WEIGHT_MAX) >= SUM_MAX {
            return Err(SplatError::Crowded { voxels });
        }
        let beside = |edge: u32, half: u32| {
            let beside = (u64::from(edge) * u64::from(deep)) >> 16;
            half.saturating_add(u32::try_from(beside).unwrap_or(u32::MAX))
                .saturating_add(1)
        };
        let own = [beside(px, hx), beside(py, hy), deep];
        let apart = eye.coarsest(farthest);
        let next = [apart.max(px), apart.max(py), 1 << 16];
        let bins = rounded(farthest - eye.near(), layout.depth_bits) >> layout.depth_bits;
        Ok(Self {
            dims,
            origin: [origin[0], origin[1], z],
            steps,
            size,
            layout,
            // The spline of a pixel: bins scale it.
            widths: [1 << 16, 1 << 16, wz],
            margin,
            rho,
            bins: bins as u32 + 1,
            least: 0,
            reach: lattice.reach_and_beside(own, next),
            eye: Some(eye),
        })
    }

    /// Where rays spread from; none where they are parallel.
    pub const fn eye(&self) -> Option<&Eye> {
        self.eye.as_ref()
    }

    /// The first sheet that no voxel is missing from.
    pub const fn first_sheet(&self) -> u32 {
        match &self.eye {
            Some(eye) => eye.first(self.reached()),
            None => 0,
        }
    }

    /// Kernels of a bin.
    pub(crate) fn scale(&self, bin: u32) -> eye::Scale {
        match &self.eye {
            Some(eye) => eye.scale(bin),
            None => eye::Scale::own(self.widths),
        }
    }

    /// Voxels along the axes.
    pub const fn dims(&self) -> [u32; 3] {
        self.dims
    }

    /// Pixels of the image across and down.
    pub const fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Bits of records.
    pub const fn layout(&self) -> Layout {
        self.layout
    }

    /// Widths of the kernel along x, y and z, 16.16.
    pub const fn widths(&self) -> [u32; 3] {
        self.widths
    }

    /// Sheets that are the first one that some voxel reaches.
    pub const fn bins(&self) -> u32 {
        self.bins
    }

    /// Sheets that a voxel reaches, J.
    pub const fn reached(&self) -> u32 {
        (2 * self.rho).div_ceil(1 << 16)
    }

    /// Sheets in all.
    pub const fn sheets(&self) -> u32 {
        self.bins + self.reached() - 1
    }

    /// The sum of weights from which on a sample of a sheet exists; of parallel rays the same in all.
    pub fn least(&self, sheet: u32) -> u64 {
        match &self.eye {
            Some(eye) => eye.least(sheet),
            None => self.least,
        }
    }

    /// How far along each axis of the volume the voxels of a sample lie, in voxels, 16.16; and those of its neighbours.
    pub const fn reach(&self) -> [[u32; 2]; 3] {
        self.reach
    }

    /// Place of a voxel: x and y in the record's pixels, and the depth, s31.32.
    #[inline(always)]
    pub(crate) fn place(&self, [i, j, k]: [u32; 3]) -> [i64; 3] {
        let [a, b, c] = self.steps;
        let (i, j, k) = (i64::from(i), i64::from(j), i64::from(k));
        let mut place = self.origin;
        for (place, ((a, b), c)) in place.iter_mut().zip(a.into_iter().zip(b).zip(c)) {
            *place += i * a + j * b + k * c;
        }
        place
    }

    /// The step along the first axis.
    #[inline(always)]
    pub(crate) const fn along(&self) -> [i64; 3] {
        self.steps[0]
    }
}

/// Depths of the nearest and the farthest voxel behind voxel (0, 0, 0).
fn depths(steps: &[[i64; 3]; 3], dims: [u32; 3]) -> [i64; 2] {
    let depth = |step: &[i64; 3], side: u32| step[2] * i64::from(side - 1);
    let depths = steps.iter().zip(dims).map(|(step, side)| depth(step, side));
    depths.fold([0, 0], |[low, high], depth| [low + depth.min(0), high + depth.max(0)])
}

/// An image that a record reaches across, with its margins.
fn whole([width, height]: [u32; 2], [mx, my]: [u32; 2]) -> Result<(), SplatError> {
    let size = [width.saturating_add(2 * mx), height.saturating_add(2 * my)];
    if width == 0 || height == 0 || size.iter().any(|side| *side > PIXELS) {
        return Err(SplatError::Image { size });
    }
    Ok(())
}

/// The sum of weights within, 18 fraction bits, of kernels of these widths over cells of this volume, 48 fraction bits.
fn nominal(widths: [u32; 3], volume: u128) -> u64 {
    let product: u128 = widths.map(u128::from).into_iter().product();
    let nominal = (product << 18).checked_div(volume).unwrap_or(0);
    u64::try_from(nominal).unwrap_or(u64::MAX)
}

/// A number of 32 fraction bits with so many of them, halves up.
#[inline(always)]
pub(crate) const fn rounded(number: i64, bits: u32) -> i64 {
    (number + (1 << (31 - bits))) >> (32 - bits)
}

/// What is along each axis of the image of the steps along each axis of the volume.
const fn axes<T: Copy>([[ax, ay, az], [bx, by, bz], [cx, cy, cz]]: &[[T; 3]; 3]) -> [[T; 3]; 3] {
    [[*ax, *bx, *cx], [*ay, *by, *cy], [*az, *bz, *cz]]
}

/// Roots of the sums of squares of the steps along each axis of the image, 16.16.
fn widths(steps: &[[i64; 3]; 3]) -> [u32; 3] {
    axes(steps).map(|steps| {
        let square = |step: i64| {
            let step = u128::from((step >> 16).unsigned_abs());
            step * step
        };
        let sum: u128 = steps.into_iter().map(square).sum();
        u32::try_from(sum.isqrt()).unwrap_or(u32::MAX)
    })
}

/// The lattice of the voxels, to 16 fraction bits of its steps, which are below 2^22 then.
struct Lattice {
    /// Magnitudes of the steps.
    sizes: [[u64; 3]; 3],
    /// Magnitudes of the cofactors, 32 fraction bits.
    cofactors: [[u128; 3]; 3],
    /// Magnitude of the determinant, 48 fraction bits.
    volume: u128,
}

impl Lattice {
    /// Not of steps in a plane.
    fn of(steps: &[[i64; 3]; 3]) -> Option<Self> {
        let s = steps.map(|step| step.map(|c| i128::from(c >> 16)));
        let [a, b, c] = s;
        let cross = |[ax, ay, az]: [i128; 3], [bx, by, bz]: [i128; 3]| {
            [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]
        };
        let cofactors = [cross(b, c), cross(c, a), cross(a, b)];
        let [cx, cy, cz] = cofactors[0];
        let [ax, ay, az] = a;
        let volume = (ax * cx + ay * cy + az * cz).unsigned_abs();
        (volume > 0).then(|| Self {
            sizes: s.map(|step| step.map(|c| c.unsigned_abs() as u64)),
            cofactors: cofactors.map(|row| row.map(i128::unsigned_abs)),
            volume,
        })
    }

    /// How many voxels can lie in a box of these half sides, 16.16, at most; of a box far too large the most.
    fn count(&self, half: [u32; 3]) -> u64 {
        let sides = axes(&self.sizes).into_iter().zip(half).map(|(steps, half)| {
            let cell: u64 = steps.into_iter().sum();
            // A unit for what was cut off the steps.
            u128::from(2 * u64::from(half) + cell + 3)
        });
        let count = sides.product::<u128>().checked_div(self.volume);
        u64::try_from(count.unwrap_or(u128::MAX)).unwrap_or(u64::MAX)
    }

    /// In coordinates that rays of slopes up to these, 16.16, are straight in: as far as cells may then extend.
    fn tilted(&self, [px, py]: [u32; 2]) -> Self {
        let along = |size: u64, edge: u32, z: u64| size + ((u64::from(edge) * z) >> 16) + 1;
        Self {
            sizes: self.sizes.map(|[x, y, z]| [along(x, px, z), along(y, py, z), z]),
            ..*self
        }
    }

    /// How far along each axis of the volume a box of these half sides reaches, voxels, 16.16, rounded up; and one of half sides longer
    /// by so much.
    fn reach_and_beside(&self, half: [u32; 3], longer: [u32; 3]) -> [[u32; 2]; 3] {
        let [own, beside] = [half, longer].map(|half| self.reach(half).map(|[reach, _]| reach));
        core::array::from_fn(|axis| {
            let at = |of: &[u32; 3]| of.get(axis).copied().unwrap_or(u32::MAX);
            [at(&own), at(&own).saturating_add(at(&beside))]
        })
    }

    /// How far along each axis of the volume a box of these half sides reaches, voxels, 16.16, rounded up; and with a unit along one
    /// axis of the image besides.
    fn reach(&self, half: [u32; 3]) -> [[u32; 2]; 3] {
        self.cofactors.map(|row| {
            // 64 fraction bits over 48, and a 64th of a voxel for places that were rounded.
            let over = |product: u128| product.checked_div(self.volume).unwrap_or(u128::MAX);
            let reach = row
                .iter()
                .zip(half)
                .map(|(c, half)| over((c * u128::from(half)) << 16) + 1)
                .sum::<u128>()
                + (1 << 10);
            let longest = row.iter().map(|c| over(c << 32) + 1).max().unwrap_or(0);
            [reach, reach + longest].map(|reach| u32::try_from(reach).unwrap_or(u32::MAX))
        })
    }
}
