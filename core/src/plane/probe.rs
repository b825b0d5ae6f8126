//! Samples and gradients at any place of a plane, straight from the voxels: nothing is kept from place to place. Where
//! few blocks of a volume show something this is less work than whole rows; the bits are the same.

use core::marker::PhantomData;

use super::extent::Extent;
use super::places::Places;
use super::source::{SourceAt, derivatives, spaced};
use crate::format::Intensity;
use crate::interpolate::{Difference, cut, kept, lerp_x, lerp_y};
use crate::lanes::{Kernel, Lanes};
use crate::precision::Precision;
use crate::rows::{part_mut, three};
use crate::slice::{Slice, Window};

/// The most lanes that a probe can have.
const LANES_MAX: usize = 64;

/// 1 at a single place: loaded so that this place meets one of the lanes.
static UNIT: [i32; 2 * LANES_MAX] = {
    let mut unit = [0; 2 * LANES_MAX];
    unit[LANES_MAX] = 1;
    unit
};

/// A plane between voxels, probed vector by vector.
pub(super) struct Probes<'s, 'w, P, V> {
    pub(super) extent: &'s Extent,
    pub(super) window: &'s Window<'w>,
    pub(super) spacing: [Intensity; 3],
    pub(super) precision: P,
    pub(super) lanes: PhantomData<V>,
}

impl<P: Precision, V: Lanes> SourceAt<i32> for Probes<'_, '_, P, V> {
    #[inline(always)]
    fn samples_at(&self, places: &Places<'_>, count: usize, [_, out]: [&mut [i32]; 2]) {
        self.samples_from(places, [0; 2], count, out);
    }

    #[inline(always)]
    fn gradients_at(
        &mut self,
        places: &Places<'_>,
        count: usize,
        chosen: &[i32],
        _: Option<&[i32]>,
        out: [&mut [i32]; 3],
    ) {
        self.gradients_from(places, [0; 2], (count, chosen), out);
    }
}

impl<P: Precision, V: Lanes> Probes<'_, '_, P, V> {
    /// The samples so many voxel rows and columns from the first `count` places.
    #[inline(always)]
    pub(super) fn samples_from(&self, places: &Places<'_>, offset: [i32; 2], count: usize, out: &mut [i32]) {
        V::enter((SamplesAt, self, places, offset, count, out));
    }

    /// The gradients so many voxel rows and columns from those of the first `count` places that are chosen.
    #[inline(always)]
    pub(super) fn gradients_from(
        &self,
        places: &Places<'_>,
        offset: [i32; 2],
        chosen: (usize, &[i32]),
        out: [&mut [i32]; 3],
    ) {
        V::enter((GradientsAt, self, places, offset, chosen, out));
    }

    #[inline(always)]
    fn probe(&self) -> Probe<'_, P, V> {
        Probe::new(self.precision, self.extent, self.window)
    }
}

struct SamplesAt;

impl<P: Precision, V: Lanes> Kernel
    for (
        SamplesAt,
        &Probes<'_, '_, P, V>,
        &Places<'_>,
        [i32; 2],
        usize,
        &mut [i32],
    )
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, probes, places, [rows, columns], count, out) = self;
        let probe = probes.probe();
        for number in 0..count {
            let (row, column) = places.get(number);
            let sample = probe.sample(places.voxel_row(row).wrapping_add(rows), column as i32 + columns);
            sample.store(out, number * V::COUNT);
        }
    }
}

struct GradientsAt;

impl<P: Precision, V: Lanes> Kernel
    for (
        GradientsAt,
        &Probes<'_, '_, P, V>,
        &Places<'_>,
        [i32; 2],
        (usize, &[i32]),
        [&mut [i32]; 3],
    )
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, probes, places, [rows, columns], (count, chosen), [gx, gy, gz]) = self;
        let probe = probes.probe();
        let mut at = 0;
        for number in 0..count {
            let (row, column) = places.get(number);
            let chosen = V::load(chosen, number * V::COUNT);
            let [x, y, z] = probe.gradient(places.voxel_row(row).wrapping_add(rows), column as i32 + columns);
            x.packed(chosen).store(gx, at);
            y.packed(chosen).store(gy, at);
            z.packed(chosen).store(gz, at);
            at += chosen.count();
        }
        spaced::<P, V>(
            probes.precision,
            [part_mut(gx, 0..at), part_mut(gy, 0..at), part_mut(gz, 0..at)],
            probes.spacing,
        );
    }
}

/// What a sample plane and the voxels around it are to `V::COUNT` samples side by side.
///
/// A place is a voxel row and the column of the first lane's voxel, both those before the sample. Lanes behind the last
/// column hold anything.
pub(super) struct Probe<'w, P, V> {
    window: &'w Window<'w>,
    near: Slice<'w>,
    far: Slice<'w>,
    width: i32,
    height: i32,
    in_slice: bool,
    wx: V,
    wy: V,
    wz: V,
    /// The weight along z of a single voxel.
    wz_bits: i32,
    precision: P,
}

/// How the voxels around a place are read: `INNER`, all of them exist, of every lane; `WHOLE`, the plane lies in a slice besides, so
/// that nothing is interpolated along z and voxels stay whole numbers until they meet along y.
impl<'w, P: Precision, V: Lanes> Probe<'w, P, V> {
    #[inline(always)]
    fn new(precision: P, extent: &Extent, window: &'w Window<'w>) -> Self {
        const { assert!(V::COUNT <= LANES_MAX) };
        let [wx, wy, wz] = three([extent.x, extent.y, extent.z], |cell| cut(precision, cell.weight));
        Self {
            window,
            near: window.near,
            far: window.far_or_near(),
            width: window.near.width() as i32,
            height: extent.height,
            in_slice: extent.in_slice(),
            wx: V::splat(wx),
            wy: V::splat(wy),
            wz: V::splat(wz),
            wz_bits: wz,
            precision,
        }
    }

    /// Whether columns `from` to `to` beyond the last lane and rows `above` to `below` exist.
    #[inline(always)]
    fn has(&self, columns: [i32; 2], rows: [i32; 2]) -> bool {
        let ([from, to], [above, below]) = (columns, rows);
        from >= 0 && to + V::COUNT as i32 <= self.width && above >= 0 && below < self.height
    }

    /// The samples at a place. A neighbour that does not exist counts with a weight of 0.
    #[inline(always)]
    fn sample(&self, row: i32, from: i32) -> V {
        let next = (row + 1).min(self.height - 1);
        if self.in_slice {
            self.sample_of::<true>([row, next], from)
        } else {
            self.sample_of::<false>([row, next], from)
        }
    }

    #[inline(always)]
    fn sample_of<const WHOLE: bool>(&self, [row, next]: [i32; 2], from: i32) -> V {
        let a = self.z_of_sample::<WHOLE>(row, from);
        let b = self.z_of_sample::<WHOLE>(row, from + 1);
        let c = self.z_of_sample::<WHOLE>(next, from);
        let d = self.z_of_sample::<WHOLE>(next, from + 1);
        self.x(self.y::<WHOLE>(a, c), self.y::<WHOLE>(b, d))
    }

    /// The gradients of the samples at a place, before the spacing factors.
    #[inline(always)]
    fn gradient(&self, row: i32, from: i32) -> [V; 3] {
        if !self.has([from - 1, from + 2], [row - 1, row + 2]) {
            // Much code and seldom run: out of line.
            V::enter((GradientAtFace, self, row, from))
        } else if self.in_slice {
            self.gradient_of::<true, true>(row, from)
        } else {
            self.gradient_of::<false, true>(row, from)
        }
    }

    #[inline(always)]
    fn gradient_of<const WHOLE: bool, const INNER: bool>(&self, row: i32, from: i32) -> [V; 3] {
        // Columns from - 1 to from + 2 of the rows around the sample, the two in the middle of those beyond.
        let b = self.z::<WHOLE, INNER>(row - 1, from);
        let c = self.z::<WHOLE, INNER>(row - 1, from + 1);
        let e = self.z::<WHOLE, INNER>(row, from - 1);
        let f = self.z::<WHOLE, INNER>(row, from);
        let g = self.z::<WHOLE, INNER>(row, from + 1);
        let h = self.z::<WHOLE, INNER>(row, from + 2);
        let i = self.z::<WHOLE, INNER>(row + 1, from - 1);
        let j = self.z::<WHOLE, INNER>(row + 1, from);
        let k = self.z::<WHOLE, INNER>(row + 1, from + 1);
        let l = self.z::<WHOLE, INNER>(row + 1, from + 2);
        let n = self.z::<WHOLE, INNER>(row + 2, from);
        let o = self.z::<WHOLE, INNER>(row + 2, from + 1);
        let right = self.x(self.y::<WHOLE>(g, k), self.y::<WHOLE>(h, l));
        let left = self.x(self.y::<WHOLE>(e, i), self.y::<WHOLE>(f, j));
        let below = self.x(self.y::<WHOLE>(j, n), self.y::<WHOLE>(k, o));
        let above = self.x(self.y::<WHOLE>(b, f), self.y::<WHOLE>(c, g));

        let (column, last) = (from as usize, self.height - 1);
        let this = derivatives(self.window, row.min(last).max(0) as usize);
        let next = derivatives(self.window, (row + 1).min(last).max(0) as usize);
        let here = self.y::<WHOLE>(
            self.derivative::<WHOLE, INNER>(&this, column),
            self.derivative::<WHOLE, INNER>(&next, column),
        );
        let there = self.y::<WHOLE>(
            self.derivative::<WHOLE, INNER>(&this, column + 1),
            self.derivative::<WHOLE, INNER>(&next, column + 1),
        );
        [right - left, below - above, self.x(here, there)]
    }

    /// Interpolation along x: samples.
    #[inline(always)]
    fn x(&self, a: V, b: V) -> V {
        lerp_x(self.precision, a, b, self.wx)
    }

    /// Interpolation along y.
    #[inline(always)]
    fn y<const WHOLE: bool>(&self, a: V, b: V) -> V {
        if WHOLE {
            kept(self.precision, a.between16(b, self.wy))
        } else {
            lerp_y::<P, V, false>(self.precision, a, b, self.wy)
        }
    }

    /// Interpolation along z of the voxels of a row from a column on.
    #[inline(always)]
    fn z_of_sample<const WHOLE: bool>(&self, row: i32, from: i32) -> V {
        let (row, column) = (row as usize, from as usize);
        let near = V::load_voxels(self.near.row(row), column);
        if WHOLE {
            return near;
        }
        near.between16(V::load_voxels(self.far.row(row), column), self.wz)
    }

    /// The same around a sample; one voxel beyond each face the volume is continued linearly.
    #[inline(always)]
    fn z<const WHOLE: bool, const INNER: bool>(&self, row: i32, from: i32) -> V {
        if INNER {
            let (row, column) = (row as usize, from as usize);
            let near = V::load_inner_voxels(self.near.row(row), column);
            if WHOLE {
                return near;
            }
            return near.between16(V::load_inner_voxels(self.far.row(row), column), self.wz);
        }
        let last = self.height - 1;
        let edge = row.min(last).max(0);
        // Out of line: there are twelve of these, and few places lie at a face.
        let voxels = V::enter((ZWithEnds, self, edge as usize, from));
        if edge == row {
            return voxels;
        }
        // Twice the edge less the row inside it.
        let inner = if row < 0 { 1.min(last) } else { (last - 1).max(0) };
        voxels + voxels - V::enter((ZWithEnds, self, inner as usize, from))
    }

    /// The same inside the rows of a slice; a place to the left of the first column and to the right of the last one is
    /// made up, further ones are 0.
    #[inline(always)]
    fn z_with_ends(&self, row: usize, from: i32) -> V {
        let (near, far) = (self.near.row(row), self.far.row(row));
        let start = from.max(0) as usize;
        let mut voxels = V::load_voxels(near, start).between16(V::load_voxels(far, start), self.wz);
        let one = |column: i32| {
            let voxel = |row| i32::load_voxels(row, column.max(0) as usize);
            voxel(near).between16(voxel(far), self.wz_bits)
        };
        let last = self.width - 1;
        let lane = (last + 1).checked_sub(start as i32).unwrap_or(-1);
        if (0..V::COUNT as i32).contains(&lane) {
            let beyond = 2 * one(last) - one((last - 1).max(0));
            voxels = voxels + V::load(&UNIT, LANES_MAX - lane as usize) * V::splat(beyond);
        }
        if from < 0 {
            let mut shifted = [0; LANES_MAX + 1];
            voxels.store(&mut shifted, 1);
            if let Some(first) = shifted.first_mut() {
                *first = 2 * one(0) - one(1.min(last));
            }
            voxels = V::load(&shifted, 0);
        }
        voxels
    }

    /// Interpolation along z of derivatives along z.
    #[inline(always)]
    fn derivative<const WHOLE: bool, const INNER: bool>(
        &self,
        (near, far): &(Difference<'_>, Difference<'_>),
        from: usize,
    ) -> V {
        match (INNER, WHOLE) {
            (true, true) => near.inner(from),
            (true, false) => near.inner::<V>(from).between16(far.inner(from), self.wz),
            (false, true) => near.outer(from),
            (false, false) => near.outer::<V>(from).between16(far.outer(from), self.wz),
        }
    }
}

struct GradientAtFace;

impl<P: Precision, V: Lanes> Kernel for (GradientAtFace, &Probe<'_, P, V>, i32, i32) {
    type Output = [V; 3];

    #[inline(always)]
    fn run(self) -> [V; 3] {
        let (_, probe, row, from) = self;
        probe.gradient_of::<false, false>(row, from)
    }
}

struct ZWithEnds;

impl<P: Precision, V: Lanes> Kernel for (ZWithEnds, &Probe<'_, P, V>, usize, i32) {
    type Output = V;

    #[inline(always)]
    fn run(self) -> V {
        let (_, probe, row, from) = self;
        probe.z_with_ends(row, from)
    }
}
