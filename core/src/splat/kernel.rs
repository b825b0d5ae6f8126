//! The kernel: a quadratic B-spline along each axis of the image, integrated over the sheets' thickness along z.

use super::{SplatError, Splatting};
use crate::rows::part;

/// log2 of the nodes of a pixel.
const NODES: u32 = 7;
/// 1 in 30 fraction bits.
const ONE: u64 = 1 << 30;
const HALF: u64 = 1 << 29;
/// Where the kernel ends.
const END: u64 = 3 << 29;

/// B(t), t and the result with 30 fraction bits.
pub(crate) const fn spline(t: u64) -> u64 {
    if t < HALF {
        ((3 * ONE) >> 2) - ((t * t) >> 30)
    } else if t < END {
        ((END - t) * (END - t)) >> 31
    } else {
        0
    }
}

/// A(t): the integral of B from 0 to t, 30 fraction bits.
pub(crate) const fn integral(t: u64) -> u64 {
    let (rest, divisor) = if t < HALF { (t, 3) } else { (END.saturating_sub(t), 6) };
    let cube = (((rest * rest) >> 30) * rest) >> 30;
    let third = match cube.checked_div(divisor) {
        Some(third) => third,
        None => 0,
    };
    if t < HALF { ((3 * t) >> 2) - third } else { HALF - third }
}

/// Tables of a kernel in the caller's memory.
#[derive(Clone, Copy, Debug)]
pub struct Kernel<'a> {
    /// Nodes from the middle outwards, 1.15, along x and y; none where kernels are as wide as they look.
    nodes: [&'a [u32]; 2],
    /// Integrals over sheets in widths, 1.16: J of each place between two sheets.
    slabs: &'a [u32],
    reached: usize,
}

/// Nodes of a kernel of this width up to the first that is 0, and one more.
const fn nodes_len(width: u32) -> usize {
    (((3 * width as u64) << NODES) >> 17) as usize + 3
}

impl<'a> Kernel<'a> {
    /// Elements of memory.
    pub const fn len(splatting: &Splatting) -> usize {
        let [x, y] = Self::nodes_len(splatting);
        let slabs = (splatting.reached() as usize) << splatting.layout.depth_bits;
        x + y + slabs
    }

    const fn nodes_len(splatting: &Splatting) -> [usize; 2] {
        let [x, y, _] = splatting.widths;
        match splatting.eye() {
            Some(_) => [0; 2],
            None => [nodes_len(x), nodes_len(y)],
        }
    }

    /// Makes the tables.
    ///
    /// # Errors
    /// [`SplatError::Memory`] if the memory has not the length of [`Kernel::len`].
    pub fn fill(splatting: &Splatting, memory: &mut [u32]) -> Result<(), SplatError> {
        let (needed, given) = (Self::len(splatting), memory.len());
        if needed != given {
            return Err(SplatError::Memory { needed, given });
        }
        let [wx, wy, wz] = splatting.widths;
        let [x, y] = Self::nodes_len(splatting);
        let (x, rest) = memory.split_at_mut(x);
        let (y, slabs) = rest.split_at_mut(y);
        for (nodes, width) in [(x, wx), (y, wy)] {
            for (number, node) in nodes.iter_mut().enumerate() {
                let t = ((number as u64) << (46 - NODES)).checked_div(width.into());
                *node = ((spline(t.unwrap_or(0)) + (1 << 14)) >> 15) as u32;
            }
        }
        let (reached, bits) = (splatting.reached() as usize, splatting.layout.depth_bits);
        for (u, slabs) in slabs.chunks_exact_mut(reached.max(1)).enumerate() {
            for (number, slab) in slabs.iter_mut().enumerate() {
                let middle = ((number as i64 + 1) << 16) - ((u as i64) << (16 - bits)) - i64::from(splatting.rho);
                let end = |place: i64| {
                    let t = (place.unsigned_abs() << 30).checked_div(wz.into());
                    place.signum() * integral(t.unwrap_or(0)) as i64
                };
                let between = end(middle + (1 << 15)) - end(middle - (1 << 15));
                *slab = ((between * i64::from(wz) + (1 << 29)) >> 30).max(0) as u32;
            }
        }
        Ok(())
    }

    /// The kernel whose tables are in memory that was [filled](Kernel::fill) for the same splatting.
    ///
    /// # Errors
    /// As [`Kernel::fill`].
    pub fn of(splatting: &Splatting, memory: &'a [u32]) -> Result<Self, SplatError> {
        let (needed, given) = (Self::len(splatting), memory.len());
        if needed != given {
            return Err(SplatError::Memory { needed, given });
        }
        let [x, y] = Self::nodes_len(splatting);
        let (x, rest) = memory.split_at(x);
        let (y, slabs) = rest.split_at(y);
        Ok(Self {
            nodes: [x, y],
            slabs,
            reached: splatting.reached() as usize,
        })
    }

    /// The weight along x or y at a distance with 13 fraction bits, 1.16, of parallel rays. This function is the definition.
    #[inline(always)]
    pub fn weight(&self, axis: usize, distance: u32) -> u32 {
        let nodes = self.nodes.get(axis).copied().unwrap_or(&[]);
        let (index, q) = ((distance >> 6) as usize, (distance & 63) as i32);
        match part(nodes, index..index + 2) {
            // They fall outwards.
            [a, b] => ((*a as i32 + (((*b as i32 - *a as i32) * q + 32) >> 6)) as u32) << 1,
            _ => 0,
        }
    }

    /// The weights of the sheets that a voxel at this place in front of the first of them reaches, 1.16.
    #[inline(always)]
    pub fn slabs(&self, u: u32) -> &'a [u32] {
        let start = u as usize * self.reached;
        part(self.slabs, start..start + self.reached)
    }
}

/// How far kernels of these widths reach along x and y, 13 fraction bits, upwards.
pub(crate) const fn reach([x, y, _]: [u32; 3]) -> [u32; 2] {
    [(3 * x + 15) >> 4, (3 * y + 15) >> 4]
}

/// First and last pixel of a record within a reach of a place, all with 13 fraction bits.
#[inline(always)]
pub(crate) const fn pixels(place: u32, reach: u32) -> [i32; 2] {
    let (place, reach) = (place as i32, reach as i32);
    [(place - reach + 0x1fff) >> 13, (place + reach) >> 13]
}

/// The weight of a kernel as wide as it looks at a distance in widths with 20 fraction bits, 1.16. This function is the definition.
#[inline(always)]
pub const fn weight(t: u64) -> u32 {
    const HALF: u64 = 1 << 19;
    const END: u64 = 3 << 19;
    let twice = if t < HALF {
        (3 << 39) - 2 * t * t
    } else if t < END {
        (END - t) * (END - t)
    } else {
        0
    };
    ((twice + (1 << 24)) >> 25) as u32
}

/// The product of three weights, of 1.16 each, 1.18. This function is the definition.
#[inline(always)]
pub const fn product(slab: u32, y: u32, x: u32) -> u32 {
    across(down(slab, y), x)
}

/// The part of [`product`] that a row of pixels shares.
#[inline(always)]
pub(crate) const fn down(slab: u32, y: u32) -> u32 {
    (slab * y + (1 << 15)) >> 16
}

/// [`product`] of what a row shares.
#[inline(always)]
pub(crate) const fn across(row: u32, x: u32) -> u32 {
    (row * x + (1 << 13)) >> 14
}
