//! Samples and gradients of parallel rays in 16 bits.
//!
//! No row lies beyond the voxels. Where a sample's neighbour along an axis would, the component is made of the difference on one side
//! and of what rises between the two voxels at the face, each halved; the other components are halved too, for a direction has no
//! length. So nothing saturates (`docs/contract/fast.md`).

use core::marker::PhantomData;
use core::ops::Range;

use super::kernels::FastShader;
use crate::classify::Slab;
use crate::fast::sample::{
    Slope, VOXEL_SHIFT, difference_row, face_row, halve_row, lerp, mixed_row, short, slope_row, slopes_row, space_row,
    yx_row, z_row,
};
use crate::format::Intensity;
use crate::interpolate::Difference;
use crate::lanes::{Halves, Kernel, Lanes};
use crate::plane::extent::Extent;
use crate::plane::scratch::NO_ROW;
use crate::plane::source::{Source, derivatives};
use crate::rows::{part, part_mut};
use crate::slice::Window;

/// Whether the samples before and behind lie beyond the voxels.
#[derive(Clone, Copy)]
pub(super) struct Faces {
    pub(super) low: bool,
    pub(super) high: bool,
}

impl Faces {
    /// Of the cell of this number, of so many voxels.
    #[inline(always)]
    pub(super) fn of(cell: i32, weight: u16, voxels: i32) -> Self {
        Self {
            low: cell <= 0,
            high: cell >= voxels - 1 - i32::from(weight != 0),
        }
    }

    #[inline(always)]
    pub(super) fn any(self) -> bool {
        self.low || self.high
    }
}

/// The voxel before the first sample of an extent.
#[inline(always)]
fn first(extent: &Extent) -> usize {
    (extent.x.index as isize)
        .wrapping_add_unsigned(extent.columns.start)
        .max(0) as usize
}

/// Sheared rays, in 16 bits.
pub(super) struct Short<'s, 'w, V, S> {
    extent: &'s Extent,
    window: &'s Window<'w>,
    spacing: [Intensity; 3],
    /// Along x, y and z, 0.15.
    weights: [u16; 3],
    /// Voxels of a row.
    width: usize,
    /// Those that samples and their neighbours look at.
    reach: Range<usize>,
    z: [&'s mut [u16]; 2],
    z_row: [i32; 2],
    samples: [&'s mut [u16]; 3],
    names: [i32; 3],
    derivatives: [&'s mut [u16]; 2],
    /// Which row and which of its columns the derivatives are of.
    made: [(usize, Range<usize>); 2],
    slope: &'s mut [u16],
    /// What rises between the first two and between the last two voxels along x, of each row of samples.
    rises: [[u16; 2]; 3],
    kinds: PhantomData<(V, S)>,
}

impl<'s, 'w, V: Lanes, S: FastShader> Short<'s, 'w, V, S> {
    #[inline(always)]
    pub(super) fn new(
        (extent, window): (&'s Extent, &'s Window<'w>),
        spacing: [Intensity; 3],
        (z, samples): ([&'s mut [u16]; 2], [&'s mut [u16]; 3]),
        (derivatives, slope): ([&'s mut [u16]; 2], &'s mut [u16]),
    ) -> Self {
        let first = first(extent);
        Self {
            extent,
            window,
            spacing,
            weights: [short(extent.x.weight), short(extent.y.weight), short(extent.z.weight)],
            width: window.near.width(),
            reach: first.saturating_sub(1)..(first + extent.columns.len() + 2).min(window.near.width()),
            z,
            z_row: [NO_ROW; 2],
            samples,
            names: [NO_ROW; 3],
            derivatives,
            made: [(0, 0..0), (0, 0..0)],
            slope,
            rises: [[0; 2]; 3],
            kinds: PhantomData,
        }
    }

    #[inline(always)]
    fn slot(row: i32) -> usize {
        if S::LIT { (row + 1).rem_euclid(3) as usize } else { 0 }
    }

    /// The samples of a row that has been made, by voxels.
    #[inline(always)]
    fn whole(&self, row: i32) -> &[u16] {
        self.samples
            .get(Self::slot(row))
            .map_or(&[], |row| part(row, 0..self.width))
    }

    #[inline(always)]
    fn make_row(&mut self, row: i32) {
        let slot = Self::slot(row);
        if self.names.get(slot).is_some_and(|name| *name == row) {
            return;
        }
        let ([wx, wy, wz], reach) = (self.weights, self.reach.clone());
        // Behind the last row there is none; its weight is 0.
        let next = (row + 1).min(self.extent.height - 1);
        if wz != 0 {
            self.make_z(row);
            self.make_z(next);
        }
        let (Some(out), Some(name)) = (self.samples.get_mut(slot), self.names.get_mut(slot)) else {
            return;
        };
        *name = row;
        let out = part_mut(out, reach.clone());
        let voxels = |row: i32| part(self.window.near.row(row.max(0) as usize), reach.clone());
        let [even, odd] = &self.z;
        let made = |row: i32| part(if row & 1 == 0 { even } else { odd }, reach.clone());
        if wz == 0 {
            yx_row::<V::Halves>(voxels(row), voxels(next), VOXEL_SHIFT, [wx, wy], out);
        } else {
            yx_row::<V::Halves>(made(row), made(next), 0, [wx, wy], out);
        }
        if S::LIT {
            self.keep_rises(slot, [row, next]);
        }
    }

    /// Keeps what rises between the voxels at both ends of a row of samples between two rows of voxels, while these are at hand.
    #[inline(always)]
    fn keep_rises(&mut self, slot: usize, [row, next]: [i32; 2]) {
        let ([_, wy, wz], last) = (self.weights, self.width.saturating_sub(1));
        let ([even, odd], near) = (&self.z, self.window.near);
        let of = |row: i32| match (wz, row & 1) {
            (0, _) => (near.row(row.max(0) as usize), VOXEL_SHIFT),
            (_, 0) => (&**even, 0),
            _ => (&**odd, 0),
        };
        let rows = [of(row), of(next)];
        let rises = [
            rise(rows, [1.min(last), 0], wy),
            rise(rows, [last, last.saturating_sub(1)], wy),
        ];
        if let Some(kept) = self.rises.get_mut(slot) {
            *kept = rises;
        }
    }

    /// Makes the z interpolation of a voxel row.
    #[inline(always)]
    fn make_z(&mut self, row: i32) {
        let ([even, odd], [even_row, odd_row]) = (&mut self.z, &mut self.z_row);
        let (out, name) = if row & 1 == 0 { (even, even_row) } else { (odd, odd_row) };
        if *name == row {
            return;
        }
        *name = row;
        let ([_, _, wz], row, reach) = (self.weights, row.max(0) as usize, self.reach.clone());
        let (near, far) = (self.window.near.row(row), self.window.far_or_near().row(row));
        let voxels = |slice| part(slice, reach.clone());
        z_row::<V::Halves>(voxels(near), voxels(far), wz, part_mut(out, reach.clone()));
    }

    /// Makes some columns of the z interpolation of a voxel row's derivatives along z; at a face of the volume halved.
    #[inline(always)]
    fn make_derivatives(&mut self, row: usize, columns: &Range<usize>, halved: bool) {
        let ([even, odd], [even_made, odd_made]) = (&mut self.derivatives, &mut self.made);
        let (out, made) = if row & 1 == 0 {
            (even, even_made)
        } else {
            (odd, odd_made)
        };
        if made.0 == row && made.1.start <= columns.start && columns.end <= made.1.end {
            return;
        }
        *made = (row, columns.clone());
        let (near, far) = derivatives(self.window, row);
        let [_, _, wz] = self.weights;
        let (near, far) = (slope(near, columns, halved), slope(far, columns, halved));
        slopes_row::<V::Halves>(near, far, wz, part_mut(out, columns.clone()));
    }

    #[inline(always)]
    fn make_gradients(&mut self, row: i32, span: Range<usize>, [gx, gy, gz]: [&mut [u16]; 3]) {
        let ([wx, wy, _], width, height) = (self.weights, self.width, self.extent.height);
        let along_y = Faces::of(row, wy, height);
        if along_y.any() {
            self.make_slope(row);
        }
        if !along_y.low {
            self.make_row(row - 1);
        }
        if !along_y.high {
            self.make_row(row + 1);
        }
        let (first, behind_z) = (first(self.extent), at_face_along_z(self.window, self.weights[2]));
        let places = first + span.start..first + span.end;
        let columns = places.start..(places.end + 1).min(width);
        let (this, next) = self.extent.voxel_rows(row);
        self.make_derivatives(this, &columns, behind_z);
        self.make_derivatives(next, &columns, behind_z);
        let [even, odd] = &self.derivatives;
        let pick = |row: usize| part(if row & 1 == 0 { even } else { odd }, columns.clone());
        mixed_row::<V::Halves>(pick(this), pick(next), [wx, wy], gz);

        let here = self.whole(row);
        let (before, behind) = (
            part(here, places.start.saturating_sub(1)..width),
            part(here, (places.start + 1).min(width)..width),
        );
        if places.start > 0 {
            difference_row::<V::Halves>(behind, before, gx);
        } else if let Some((_, gx)) = gx.split_first_mut() {
            difference_row::<V::Halves>(part(here, 2.min(width)..width), here, gx);
        }
        let at = |row: i32| part(self.whole(row), places.clone());
        let (above, below) = (
            at(if along_y.low { row } else { row - 1 }),
            at(if along_y.high { row } else { row + 1 }),
        );
        difference_row::<V::Halves>(below, above, gy);

        let halved = behind_z || along_y.any();
        if halved {
            let slope = part(self.slope, places.clone());
            match along_y {
                Faces { low: true, high: true } => gy.copy_from_slice(part(slope, 0..gy.len())),
                faces if faces.any() => face_row::<V::Halves>(slope, gy),
                _ => halve_row::<V::Halves>(gy),
            }
            halve_row::<V::Halves>(gx);
            if !behind_z {
                halve_row::<V::Halves>(gz);
            }
        }
        self.mend_ends(row, places, halved, [&mut *gx, &mut *gy, &mut *gz]);
        let [fx, fy, fz] = self.spacing;
        space_row::<V::Halves>(gx, fx);
        space_row::<V::Halves>(gy, fy);
        space_row::<V::Halves>(gz, fz);
    }

    /// Makes what rises between the two rows of voxels at a face, x interpolated.
    #[inline(always)]
    fn make_slope(&mut self, row: i32) {
        let (last, [wx, _, _], reach) = (self.extent.height - 1, self.weights, self.reach.clone());
        let low = row.min(last - 1).max(0);
        let high = (low + 1).min(last);
        self.make_z(low);
        self.make_z(high);
        let [even, odd] = &self.z;
        let pick = |row: i32| part(if row & 1 == 0 { even } else { odd }, reach.clone());
        slope_row::<V::Halves>(pick(low), pick(high), wx, part_mut(self.slope, reach.clone()));
    }

    /// Makes the gradients of samples whose neighbours along x lie beyond the voxels.
    #[inline(always)]
    fn mend_ends(&self, row: i32, places: Range<usize>, halved: bool, [gx, gy, gz]: [&mut [u16]; 3]) {
        let ([wx, _, _], width, last) = (self.weights, self.width, self.width.saturating_sub(1));
        let here = self.whole(row);
        let sample = |place: usize| here.get(place).copied().unwrap_or(0);
        let [low, high] = self.rises.get(Self::slot(row)).copied().unwrap_or_default();
        let highest = last.saturating_sub(usize::from(wx != 0));
        for (place, rise) in [(0, low), (highest, high)] {
            let faces = Faces::of(place as i32, wx, width as i32);
            let at = place.checked_sub(places.start).filter(|_| place < places.end);
            let Some(at) = at.filter(|_| faces.any() && (place > 0 || faces.low)) else {
                continue;
            };
            let half = |v: u16| v.shr_signed(1);
            if let (Some(gx), Some(gy), Some(gz)) = (gx.get_mut(at), gy.get_mut(at), gz.get_mut(at)) {
                *gx = match faces {
                    Faces { low: true, high: true } => rise,
                    Faces { low: true, .. } => half(sample(place + 1).minus(sample(place))).plus(half(rise)),
                    Faces { .. } => half(sample(place).minus(sample(place.saturating_sub(1)))).plus(half(rise)),
                };
                if !halved {
                    (*gy, *gz) = (half(*gy), half(*gz));
                }
            }
            if highest == 0 {
                break;
            }
        }
    }
}

/// Whether a derivative along z is of one side.
#[inline(always)]
pub(super) fn at_face_along_z(window: &Window<'_>, wz: u16) -> bool {
    window.before.is_none() || window.far.is_none() || wz != 0 && window.after.is_none()
}

/// What rises between two places of a row of samples, of two rows shifted left first.
#[inline(always)]
fn rise([(a, shift), (b, _)]: [(&[u16], u32); 2], [to, from]: [usize; 2], wy: u16) -> u16 {
    let between = |place: usize| {
        let of = |row: &[u16]| row.get(place).copied().unwrap_or(0) << shift;
        lerp(of(a), of(b), wy)
    };
    between(to).minus(between(from))
}

/// Some columns of a derivative, 12.3, or of half of it.
#[inline(always)]
pub(super) fn slope<'a>(of: Difference<'a>, columns: &Range<usize>, halved: bool) -> Slope<'a> {
    Slope {
        minuend: part(of.minuend, columns.clone()),
        subtrahend: part(of.subtrahend, columns.clone()),
        shift: VOXEL_SHIFT - u32::from(halved) + u32::from(of.scale == 2),
    }
}

impl<V: Lanes, S: FastShader> Source<u16> for Short<'_, '_, V, S> {
    #[inline(always)]
    fn make(&mut self, row: i32) {
        V::enter((MakeRow, self, row));
    }

    #[inline(always)]
    fn slab(&self, row: i32) -> Slab<'_, u16> {
        let first = first(self.extent);
        Slab::of(part(self.whole(row), first..first + self.extent.columns.len()))
    }

    #[inline(always)]
    fn gradients(&mut self, row: i32, span: Range<usize>, _: Option<&[u16]>, out: [&mut [u16]; 3]) {
        if S::LIT {
            V::enter((MakeGradients, self, row, span, out));
        }
    }
}

struct MakeRow;

impl<V: Lanes, S: FastShader> Kernel for (MakeRow, &mut Short<'_, '_, V, S>, i32) {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, source, row) = self;
        source.make_row(row);
    }
}

struct MakeGradients;

impl<V: Lanes, S: FastShader> Kernel
    for (
        MakeGradients,
        &mut Short<'_, '_, V, S>,
        i32,
        Range<usize>,
        [&mut [u16]; 3],
    )
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (_, source, row, span, out) = self;
        source.make_gradients(row, span, out);
    }
}
