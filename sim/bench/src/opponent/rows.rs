//! The opponent's row kernels: the stages of `slicecast::{interpolate, gradient, normalise, shade, composite}` in f32.
//!
//! A row has whole vectors of room before its first voxel (at [`FIRST`]) and behind its last, so that no kernel but
//! the one that reads voxels has a remainder. What lies there is finite, and nothing of it is kept.

use super::light::FloatPhong;
use slicecast_engine::simd::floats::Floats;

/// Place of the first voxel of a row.
pub(super) const FIRST: usize = 16;

/// Length of a row for slices of this width: a vector before, and room for two behind.
pub(super) const fn row_len(width: usize) -> usize {
    FIRST + width.next_multiple_of(FIRST) + 3 * FIRST
}

/// z interpolation of a row of voxels; `out` begins at the first voxel.
#[inline(always)]
pub(super) fn z_row<F: Floats>(near: &[u16], far: &[u16], weight: f32, out: &mut [f32]) {
    if weight == 0.0 {
        for at in (0..near.len()).step_by(F::COUNT) {
            F::load_voxels(near, at).store(out, at);
        }
        return;
    }
    let w = F::splat(weight);
    for at in (0..near.len()).step_by(F::COUNT) {
        F::load_voxels(near, at)
            .towards(F::load_voxels(far, at), w)
            .store(out, at);
    }
}

/// `2 edge - inner`: a row one voxel beyond a face.
#[inline(always)]
pub(super) fn extend_row<F: Floats>(edge: &mut [f32], inner: &[f32]) {
    for at in (0..edge.len()).step_by(F::COUNT) {
        let e = F::load(edge, at);
        (e + e - F::load(inner, at)).store(edge, at);
    }
}

/// The volume continued linearly by a voxel at both ends of a whole row.
#[inline(always)]
pub(super) fn extend_ends(row: &mut [f32], width: usize) {
    let last = FIRST + width - 1;
    let inner = usize::from(width > 1);
    row[FIRST - 1] = 2.0 * row[FIRST] - row[FIRST + inner];
    row[last + 1] = 2.0 * row[last] - row[last - inner];
}

/// The derivative along z at a slice: scale, voxels behind, voxels before (`slicecast::interpolate::Difference`).
#[derive(Clone, Copy)]
pub(super) struct Slope<'a>(pub f32, pub &'a [u16], pub &'a [u16]);

impl Slope<'_> {
    #[inline(always)]
    fn lanes<F: Floats>(self, at: usize) -> F {
        F::load_voxels(self.1, at) - F::load_voxels(self.2, at)
    }
}

/// z interpolation of derivatives along z at a place.
#[inline(always)]
pub(super) fn slope_at<F: Floats>(near: Slope<'_>, far: Slope<'_>, weight: f32, at: usize) -> F {
    let a = near.lanes::<F>(at) * F::splat(near.0);
    if weight == 0.0 {
        return a;
    }
    a.towards(far.lanes::<F>(at) * F::splat(far.0), F::splat(weight))
}

/// z interpolation of derivatives along z; `out` begins at the first of them.
#[inline(always)]
pub(super) fn z_slope_row<F: Floats>(near: Slope<'_>, far: Slope<'_>, weight: f32, out: &mut [f32]) {
    let n = near.1.len();
    if weight == 0.0 {
        let scale = F::splat(near.0);
        for at in (0..n).step_by(F::COUNT) {
            (near.lanes::<F>(at) * scale).store(out, at);
        }
        return;
    }
    let w = F::splat(weight);
    let inside = near.0 == 1.0 && far.0 == 1.0;
    for at in (0..n).step_by(F::COUNT) {
        let (mut a, mut b) = (near.lanes::<F>(at), far.lanes::<F>(at));
        if !inside {
            a = a * F::splat(near.0);
            b = b * F::splat(far.0);
        }
        a.towards(b, w).store(out, at);
    }
}

/// What y and x interpolation reads: voxels, where a plane lies in a slice, or what z interpolation has made of them.
pub(super) trait Elements {
    /// Elements `at ..`.
    fn lanes<F: Floats>(&self, at: usize) -> F;
}

impl Elements for [u16] {
    #[inline(always)]
    fn lanes<F: Floats>(&self, at: usize) -> F {
        F::load_voxels(self, at)
    }
}

impl Elements for [f32] {
    #[inline(always)]
    fn lanes<F: Floats>(&self, at: usize) -> F {
        F::load(self, at)
    }
}

/// y interpolation between two rows and x interpolation along the result, as far as `out` goes.
#[inline(always)]
pub(super) fn yx_row<F: Floats>(
    a: &(impl Elements + ?Sized),
    b: &(impl Elements + ?Sized),
    [wx, wy]: [f32; 2],
    out: &mut [f32],
) {
    let (wx, wy) = (F::splat(wx), F::splat(wy));
    let mut here = a.lanes::<F>(0).towards(b.lanes(0), wy);
    for at in (0..out.len()).step_by(F::COUNT) {
        let behind = at + F::COUNT;
        let next = a.lanes::<F>(behind).towards(b.lanes(behind), wy);
        here.towards(here.followed_by(next), wx).store(out, at);
        here = next;
    }
}

/// What a row of gradients is made of. All rows begin at the first sample, `left` and `right` one beside it.
pub(super) struct Around<'a> {
    pub left: &'a [f32],
    pub right: &'a [f32],
    pub previous: &'a [f32],
    pub next: &'a [f32],
    /// Derivatives along z of the voxel rows before and behind.
    pub slopes: [&'a [f32]; 2],
    pub weights: [f32; 2],
    /// Spacing factors; `None` for cubic voxels.
    pub spacing: Option<[f32; 3]>,
}

/// Unit normals, towards lower values, as far as `out` goes.
#[inline(always)]
pub(super) fn normal_row<F: Floats>(around: &Around<'_>, out: [&mut [f32]; 3]) {
    match around.spacing {
        None => normals::<F, true>(around, [1.0; 3], out),
        Some(spacing) => normals::<F, false>(around, spacing, out),
    }
}

#[inline(always)]
fn normals<F: Floats, const CUBIC: bool>(around: &Around<'_>, spacing: [f32; 3], [nx, ny, nz]: [&mut [f32]; 3]) {
    let ([a, b], [wx, wy], [fx, fy, fz]) = (around.slopes, around.weights, spacing);
    let (wx, wy) = (F::splat(wx), F::splat(wy));
    let (fx, fy, fz) = (F::splat(fx), F::splat(fy), F::splat(fz));
    let mut here = F::load(a, 0).towards(F::load(b, 0), wy);
    for at in (0..nx.len()).step_by(F::COUNT) {
        let behind = at + F::COUNT;
        let next = F::load(a, behind).towards(F::load(b, behind), wy);
        let mut x = F::load(around.left, at) - F::load(around.right, at);
        let mut y = F::load(around.previous, at) - F::load(around.next, at);
        let mut z = here.towards(here.followed_by(next), wx);
        here = next;
        if !CUBIC {
            (x, y, z) = (x * fx, y * fy, z * fz);
        }
        // x and y are negative already.
        let r = x.times_plus(x, y.times_plus(y, z * z)).reciprocal_root();
        (x * r).store(nx, at);
        (y * r).store(ny, at);
        (z * (F::splat(0.0) - r)).store(nz, at);
    }
}

/// The unit normal, towards lower values, of differences of which those along x and y point there already.
#[inline(always)]
pub(super) fn normal<F: Floats, const CUBIC: bool>([mut x, mut y, mut z]: [F; 3], [fx, fy, fz]: [F; 3]) -> [F; 3] {
    if !CUBIC {
        (x, y, z) = (x * fx, y * fy, z * fz);
    }
    let r = x.times_plus(x, y.times_plus(y, z * z)).reciprocal_root();
    [x * r, y * r, z * (F::splat(0.0) - r)]
}

/// Rows of pixels: red, green, blue, transparency.
pub(super) type Pixels<'a> = [&'a mut [f32]; 4];

/// Shades the samples of a row and folds them into its pixels, as far as `opacities` goes.
#[inline(always)]
pub(super) fn shade_and_fold_row<F: Floats>(
    phong: &FloatPhong,
    [nx, ny, nz]: [&[f32]; 3],
    [cr, cg, cb]: [&[f32]; 3],
    opacities: &[f32],
    pixels: &mut Pixels<'_>,
    floor: f32,
) {
    for at in (0..opacities.len()).step_by(F::COUNT) {
        let normal = [F::load(nx, at), F::load(ny, at), F::load(nz, at)];
        let colour = [F::load(cr, at), F::load(cg, at), F::load(cb, at)];
        over(phong.shade(normal, colour), F::load(opacities, at), pixels, at, floor);
    }
}

/// Folds the samples of a row into its pixels, as far as `opacities` goes.
#[inline(always)]
pub(super) fn fold_row<F: Floats>([cr, cg, cb]: [&[f32]; 3], opacities: &[f32], pixels: &mut Pixels<'_>, floor: f32) {
    for at in (0..opacities.len()).step_by(F::COUNT) {
        let colour = [F::load(cr, at), F::load(cg, at), F::load(cb, at)];
        over(colour, F::load(opacities, at), pixels, at, floor);
    }
}

/// Folds samples of one colour; vectors in which nothing is visible are left out.
#[inline(always)]
pub(super) fn fold_one_colour_row<F: Floats>(colour: [f32; 3], opacities: &[f32], pixels: &mut Pixels<'_>, floor: f32) {
    let colour = [F::splat(colour[0]), F::splat(colour[1]), F::splat(colour[2])];
    for at in (0..opacities.len()).step_by(F::COUNT) {
        let opacity = F::load(opacities, at);
        if opacity.any_positive() {
            over(colour, opacity, pixels, at, floor);
        }
    }
}

/// `w = T a; T -= w; C += c w`; T below the floor becomes 0.
#[inline(always)]
pub(super) fn over<F: Floats>([cr, cg, cb]: [F; 3], opacity: F, pixels: &mut Pixels<'_>, at: usize, floor: f32) {
    let [red, green, blue, transparency] = pixels;
    let before = F::load(transparency, at);
    let w = before * opacity;
    let after = before - w;
    after.at_least_then(F::splat(floor), after).store(transparency, at);
    cr.times_plus(w, F::load(red, at)).store(red, at);
    cg.times_plus(w, F::load(green, at)).store(green, at);
    cb.times_plus(w, F::load(blue, at)).store(blue, at);
}
