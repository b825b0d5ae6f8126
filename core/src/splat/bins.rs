//! Which voxels are needed, and their records in the bins of the sheets.

use core::ops::Range;

use super::{Bands, CODE_MAX, SplatError, Splatting, kernel, rounded};
use crate::classify::Support;
use crate::rows::{part, part_mut};
use crate::slice::RowRange;

/// Voxels along a side of a block.
pub const BLOCK: u32 = 4;

/// Voxels of some slices of a volume, x fastest.
#[derive(Clone, Copy, Debug)]
pub struct Voxels<'a> {
    voxels: &'a [u16],
    /// Number of the first slice.
    first: u32,
    slices: u32,
}

impl<'a> Voxels<'a> {
    /// Voxels of some slices.
    ///
    /// # Errors
    /// [`SplatError::Memory`] for another number of voxels, [`SplatError::Value`] for one of more than 12 bits.
    pub fn new(splatting: &Splatting, slices: Range<u32>, voxels: &'a [u16]) -> Result<Self, SplatError> {
        let ([width, height, depth], given) = (splatting.dims, voxels.len());
        let slices = slices.start.min(depth)..slices.end.min(depth);
        let needed = width as usize * height as usize * slices.len();
        if needed != given {
            return Err(SplatError::Memory { needed, given });
        }
        match voxels.iter().max() {
            Some(&value) if u32::from(value) > CODE_MAX => Err(SplatError::Value { value }),
            _ => Ok(Self {
                voxels,
                first: slices.start,
                slices: slices.len() as u32,
            }),
        }
    }
}

/// Which blocks of voxels are needed.
#[derive(Clone, Copy, Debug)]
pub struct Needed<'a> {
    blocks: &'a [u8],
    sides: [u32; 3],
}

/// The smallest and the largest voxel of each block of a layer of them: of four slices, fewer at the end.
///
/// # Errors
/// [`SplatError::Memory`] if there is not a range for each block.
pub fn measure_layer(splatting: &Splatting, voxels: &Voxels<'_>, ranges: &mut [RowRange]) -> Result<(), SplatError> {
    let [width, height, _] = splatting.dims;
    let across = width.div_ceil(BLOCK) as usize;
    let (needed, given) = (across * height.div_ceil(BLOCK) as usize, ranges.len());
    if needed != given {
        return Err(SplatError::Memory { needed, given });
    }
    ranges.fill(RowRange::EMPTY);
    for slice in voxels.voxels.chunks_exact((width * height) as usize) {
        for (y, row) in slice.chunks_exact(width as usize).enumerate() {
            let first = (y >> 2) * across;
            for (range, voxels) in part_mut(ranges, first..first + across)
                .iter_mut()
                .zip(row.chunks(BLOCK as usize))
            {
                for &voxel in voxels {
                    *range = range.union(RowRange {
                        low: voxel,
                        high: voxel,
                    });
                }
            }
        }
    }
    Ok(())
}

const SEEN: u8 = 1;
const NEEDED: u8 = 2;

impl<'a> Needed<'a> {
    /// Blocks along the axes.
    pub const fn sides(splatting: &Splatting) -> [u32; 3] {
        let [x, y, z] = splatting.dims;
        [x.div_ceil(BLOCK), y.div_ceil(BLOCK), z.div_ceil(BLOCK)]
    }

    /// How many blocks.
    pub const fn len(splatting: &Splatting) -> usize {
        let [x, y, z] = Self::sides(splatting);
        x as usize * y as usize * z as usize
    }

    /// Finds the blocks that are needed for samples of this support, from the ranges of all ([`measure_layer`]).
    ///
    /// # Errors
    /// [`SplatError::Memory`] if there is not a place and a range for each block.
    pub fn find(
        splatting: &Splatting,
        ranges: &[RowRange],
        support: Support,
        blocks: &'a mut [u8],
    ) -> Result<Self, SplatError> {
        let needed = Self::len(splatting);
        for given in [ranges.len(), blocks.len()] {
            if needed != given {
                return Err(SplatError::Memory { needed, given });
            }
        }
        let sides = Self::sides(splatting);
        let about = |reach: usize| {
            splatting.reach.map(|own| {
                // From a place between half a voxel before a block and half a voxel behind.
                let voxels = (u64::from(*own.get(reach).unwrap_or(&0)) + (7 << 15)) >> 16;
                u32::try_from(voxels >> 2).unwrap_or(u32::MAX)
            })
        };
        let (seen, near) = (about(0), about(1));
        each_block(sides, |at, index| {
            let mut range = RowRange::EMPTY;
            within(sides, at, seen, |other| {
                range = range.union(ranges.get(other).copied().unwrap_or(RowRange::EMPTY));
            });
            // As records have them: fewer bits may lie beyond the range of the codes.
            let kept = |code: u16| splatting.layout.kept(code);
            if range.low <= range.high {
                (range.low, range.high) = (kept(range.low), kept(range.high));
            }
            if let Some(block) = blocks.get_mut(index) {
                *block = if support.meets(range) { SEEN } else { 0 };
            }
        });
        each_block(sides, |at, index| {
            let mut any = 0;
            within(sides, at, near, |other| any |= blocks.get(other).copied().unwrap_or(0));
            if let Some(block) = blocks.get_mut(index)
                && any & SEEN != 0
            {
                *block |= NEEDED;
            }
        });
        Ok(Self { blocks, sides })
    }

    /// Blocks that were found before.
    #[cfg(test)]
    pub(crate) fn of_blocks(splatting: &Splatting, blocks: &'a [u8]) -> Self {
        let sides = Self::sides(splatting);
        Self { blocks, sides }
    }

    /// The blocks of a row of voxels.
    #[inline(always)]
    fn row(&self, y: u32, z: u32) -> &'a [u8] {
        let [across, down, _] = self.sides;
        let start = ((z >> 2) as usize * down as usize + (y >> 2) as usize) * across as usize;
        part(self.blocks, start..start + across as usize)
    }

    /// How many blocks are needed.
    pub fn count(&self) -> usize {
        self.blocks.iter().filter(|block| **block & NEEDED != 0).count()
    }
}

fn each_block([across, down, deep]: [u32; 3], mut each: impl FnMut([u32; 3], usize)) {
    let mut index = 0;
    for z in 0..deep {
        for y in 0..down {
            for x in 0..across {
                each([x, y, z], index);
                index += 1;
            }
        }
    }
}

/// Blocks no farther than this along each axis.
fn within(sides: [u32; 3], at: [u32; 3], reach: [u32; 3], mut each: impl FnMut(usize)) {
    let [across, down, deep] = sides;
    let ([x, y, z], [rx, ry, rz]) = (at, reach);
    let [xs, ys, zs] = [(x, rx, across), (y, ry, down), (z, rz, deep)].map(|(at, reach, side): (u32, u32, u32)| {
        at.saturating_sub(reach)..at.saturating_add(reach).saturating_add(1).min(side)
    });
    for z in zs {
        for y in ys.clone() {
            let row = (z as usize * down as usize + y as usize) * across as usize;
            xs.clone().for_each(|x| each(row + x as usize));
        }
    }
}

/// Records of some slices, in the bins of bands and sheets.
#[derive(Clone, Copy, Debug)]
pub struct Bins<'a> {
    /// Where each bin begins; the end of the last.
    starts: &'a [u32],
    records: &'a [u64],
    bins: usize,
}

impl<'a> Bins<'a> {
    /// Numbers that the bins of all bands need.
    pub const fn len(splatting: &Splatting, bands: Bands) -> usize {
        bands.count(splatting) as usize * splatting.bins as usize + 1
    }

    /// Counts the records of each bin into `starts`; how many records there are.
    ///
    /// # Errors
    /// [`SplatError::Memory`] if `starts` has not the length of [`Bins::len`], [`SplatError::Records`] for too many.
    pub fn count(
        splatting: &Splatting,
        bands: Bands,
        voxels: &Voxels<'_>,
        needed: Option<&Needed<'_>>,
        starts: &mut [u32],
    ) -> Result<usize, SplatError> {
        let (expected, given) = (Self::len(splatting, bands), starts.len());
        if expected != given {
            return Err(SplatError::Memory {
                needed: expected,
                given,
            });
        }
        starts.fill(0);
        each_record(splatting, bands, voxels, needed, |bin, _| {
            if let Some(count) = starts.get_mut(bin) {
                *count = count.saturating_add(1);
            }
        });
        let mut all = 0u32;
        for start in starts {
            all = all
                .checked_add(*start)
                .filter(|all| *all < u32::MAX)
                .ok_or(SplatError::Records)?;
            *start = all;
        }
        Ok(all as usize)
    }

    /// Puts the records of the same voxels, counted before, into their bins.
    ///
    /// # Errors
    /// [`SplatError::Memory`] if there is not a place for each record that was counted.
    pub fn fill(
        splatting: &Splatting,
        bands: Bands,
        voxels: &Voxels<'_>,
        needed: Option<&Needed<'_>>,
        starts: &'a mut [u32],
        records: &'a mut [u64],
    ) -> Result<Self, SplatError> {
        let (expected, given) = (starts.last().copied().unwrap_or(0) as usize, records.len());
        if expected != given {
            return Err(SplatError::Memory {
                needed: expected,
                given,
            });
        }
        // Each bin from its end to its start.
        each_record(splatting, bands, voxels, needed, |bin, record| {
            if let Some(start) = starts.get_mut(bin) {
                *start = start.saturating_sub(1);
                if let Some(place) = records.get_mut(*start as usize) {
                    *place = record;
                }
            }
        });
        Ok(Self::of(splatting, starts, records))
    }

    /// Bins that were [filled](Bins::fill) for the same splatting.
    pub const fn of(splatting: &Splatting, starts: &'a [u32], records: &'a [u64]) -> Self {
        Self {
            starts,
            records,
            bins: splatting.bins as usize,
        }
    }

    /// Records of a band whose first sheet is this.
    #[inline]
    pub fn records(&self, band: u32, sheet: u32) -> &'a [u64] {
        if sheet as usize >= self.bins {
            return &[];
        }
        let bin = band as usize * self.bins + sheet as usize;
        match part(self.starts, bin..bin + 2) {
            [start, end] => part(self.records, *start as usize..*end as usize),
            _ => &[],
        }
    }

    /// How many records there are.
    pub const fn total(&self) -> usize {
        self.records.len()
    }
}

/// Goes through the records of voxels that are needed: bin and record.
fn each_record(
    splatting: &Splatting,
    bands: Bands,
    voxels: &Voxels<'_>,
    needed: Option<&Needed<'_>>,
    mut each: impl FnMut(usize, u64),
) {
    let [width, height, _] = splatting.dims;
    let (layout, bins) = (splatting.layout, splatting.bins as usize);
    let [_, reach] = kernel::reach(splatting.widths);
    let mut of_bin = (usize::MAX, reach);
    let near = splatting.eye.as_ref().map_or(0, super::Eye::near);
    let mut rows = voxels.voxels.chunks_exact(width as usize);
    for z in voxels.first..voxels.first + voxels.slices {
        for y in 0..height {
            let Some(row) = rows.next() else { return };
            let blocks = needed.map(|needed| needed.row(y, z));
            if blocks.is_some_and(|blocks| blocks.iter().all(|block| block & NEEDED == 0)) {
                continue;
            }
            for (number, codes) in row.chunks(BLOCK as usize).enumerate() {
                if blocks.is_some_and(|blocks| blocks.get(number).is_none_or(|block| block & NEEDED == 0)) {
                    continue;
                }
                let [mut x, mut down, mut depth] = splatting.place([number as u32 * BLOCK, y, z]);
                let [along_x, along_y, along_z] = splatting.along();
                for &code in codes {
                    if let Some(place) = stored(splatting, [x, down, depth]) {
                        let q = rounded(depth - near, layout.depth_bits);
                        let (bin, u) = (
                            (q >> layout.depth_bits) as usize,
                            q as u32 & ((1 << layout.depth_bits) - 1),
                        );
                        // Neighbours often share a bin.
                        if let Some(eye) = splatting.eye.as_ref().filter(|_| of_bin.0 != bin) {
                            let [_, reach] = eye.scale(bin as u32).reach;
                            of_bin = (bin, reach);
                        }
                        let (_, reach) = of_bin;
                        let record = layout.pack(place, u, code);
                        let [_, at] = place.map(|c| c << (13 - layout.position_bits));
                        for band in bands.reached(splatting, kernel::pixels(at, reach)) {
                            each(band as usize * bins + bin, record);
                        }
                    }
                    x += along_x;
                    down += along_y;
                    depth += along_z;
                }
            }
        }
    }
}

/// x and y as records have them, of a voxel whose kernel may reach the image.
#[inline(always)]
fn stored(splatting: &Splatting, place: [i64; 3]) -> Option<[u32; 2]> {
    let bits = splatting.layout.position_bits;
    let [x, y, depth] = place;
    if let Some(eye) = &splatting.eye {
        return if depth < eye.near() {
            None
        } else {
            eye.project(place, bits)
        };
    }
    let [x, y] = [x, y].map(|c| rounded(c, bits));
    let ([width, height], [mx, my]) = (splatting.size, splatting.margin);
    let [right, below] = [width + 2 * mx, height + 2 * my].map(|side| i64::from(side - 1) << bits);
    ((0..=right).contains(&x) && (0..=below).contains(&y)).then_some([x as u32, y as u32])
}
