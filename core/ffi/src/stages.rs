//! The stages one by one, for a simulator (DPI-C) or a bench in C: what the pipeline makes of one sample.
//!
//! Every function is core's scalar definition of a stage. Numbers are raw bits, with the widths that the contract states
//! (docs/contract/formats.md); what is out of its range is refused with SLICECAST_RANGE and never computed. Nothing is kept
//! between calls. A program that calls none of them links none of them.

use slicecast::classify::{Classifier, Colour16, Linear, Nearest, PointTable, Sqrt8, Sqrt16, Support};
use slicecast::composite::{Channel, ChannelFormat, Dither, Pixel, Recurrence, settle};
use slicecast::format::{Intensity, Opacity, Step, Weight};
use slicecast::gradient::{difference_row, space};
use slicecast::interpolate::trilinear;
use slicecast::locate::position;
use slicecast::normalise::{Normal, normalise};
use slicecast::plan::{PLANES_MAX, SIDE_MAX};
use slicecast::precision::{Compact, Paper, Precision, Wide};
use slicecast::project::{Extreme, Maximum, Minimum, resolve};
use slicecast::shade::Phong;
use slicecast::table::ENTRIES;
use slicecast::warp::{in_front_of, mix_pixels};

use crate::error::SlicecastError;
use crate::instance::Lights;
use crate::scene::{SlicecastLighting, SlicecastWarp};
use crate::{check, read, report, slice, write};

/// `precision` of the stages: widths and roundings of `paper`.
pub const SLICECAST_PAPER: u32 = 0;
/// `precision` of the stages: `compact`.
pub const SLICECAST_COMPACT: u32 = 1;
/// `precision` of the stages: `wide`.
pub const SLICECAST_WIDE: u32 = 2;

/// Evaluates an expression with the precision of a number, which is argument 1.
macro_rules! with_precision {
    ($number:expr, $precision:ident => $with:expr) => {
        match $number {
            SLICECAST_PAPER => {
                let $precision = Paper;
                $with
            }
            SLICECAST_COMPACT => {
                let $precision = Compact;
                $with
            }
            SLICECAST_WIDE => {
                let $precision = Wide;
                $with
            }
            given => Err(SlicecastError::range(1, SLICECAST_WIDE.into(), given.into())),
        }
    };
}

mod segment;

pub use segment::*;

/// Refuses a number outside `low ..= high`; the end that it passes is told.
fn within(argument: u32, given: i64, low: i64, high: i64) -> Result<(), SlicecastError> {
    if given < low {
        Err(SlicecastError::range(argument, low, given))
    } else if given > high {
        Err(SlicecastError::range(argument, high, given))
    } else {
        Ok(())
    }
}

/// [`within`] of all.
fn all_within<T: Copy + Into<i64>>(argument: u32, given: &[T], low: i64, high: i64) -> Result<(), SlicecastError> {
    given
        .iter()
        .try_for_each(|value| within(argument, (*value).into(), low, high))
}

/// An array of the caller's.
///
/// # Safety
/// Null or misaligned it may be; otherwise it points to `N` elements that are written by no one meanwhile.
unsafe fn array<T: Copy, const N: usize>(pointer: *const T, argument: u32) -> Result<[T; N], SlicecastError> {
    // SAFETY: the caller's promise.
    let elements = unsafe { slice(pointer, N, argument)? };
    elements.try_into().map_err(|_| SlicecastError::length(argument, N, 0))
}

/// Writes an array of the caller's.
///
/// # Safety
/// Null or misaligned it may be; otherwise it points to memory for `N` elements.
unsafe fn write_array<T: Copy, const N: usize>(
    pointer: *mut T,
    argument: u32,
    values: [T; N],
) -> Result<(), SlicecastError> {
    check(pointer.cast_const(), argument)?;
    // SAFETY: not null, aligned, and the caller's promise.
    unsafe { pointer.cast::<[T; N]>().write(values) };
    Ok(())
}

/// Location: where a plane lies along one axis. docs/contract/location.md
///
/// `start`: s31.32, -8192 to 8192 voxels. `step`: s31.32, -1 to 1 voxels a plane. `plane`: 0 to 32768, from the eye.
/// `position` receives s15.16: the cell in the upper bits, the weight in the lower 16. Returns SLICECAST_OK or an error code.
///
/// # Safety
/// `position` and `error` (if not null) are writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slicecast_stage_locate(
    start: i64,
    step: i64,
    plane: u32,
    position: *mut i32,
    error: *mut SlicecastError,
) -> i32 {
    let work = || {
        let side = i64::from(SIDE_MAX) << 32;
        within(1, start, -side, side)?;
        within(2, step, -(1 << 32), 1 << 32)?;
        within(3, plane.into(), 0, PLANES_MAX.into())?;
        // SAFETY: the caller's promise; null and misaligned pointers are refused.
        let out = unsafe { write(position, 4)? };
        *out = self::position(Step::from_bits(start), Step::from_bits(step), plane).to_bits();
        Ok(())
    };
    // SAFETY: the caller's promise for `error`.
    unsafe { report(work(), error) }
}

/// Interpolation: the value between eight voxels. docs/contract/interpolation.md
///
/// `precision`: SLICECAST_PAPER, SLICECAST_COMPACT or SLICECAST_WIDE. `voxels`: 8 values, i fastest, then j, then k; 0 to
/// 4095, beyond a face -4095 to 8190, derivatives along k -8190 to 8190. `weights`: 3 values along i, j, k, 0.16. `sample`
/// receives 12 fraction bits, 15 in wide. Returns SLICECAST_OK or an error code.
///
/// # Safety
/// `voxels` and `weights` are readable, `sample` and `error` (if not null) writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slicecast_stage_interpolate(
    precision: u32,
    voxels: *const i16,
    weights: *const u16,
    sample: *mut i32,
    error: *mut SlicecastError,
) -> i32 {
    let work = || {
        // SAFETY: the caller's promise; null and misaligned pointers are refused.
        let (voxels, weights, out) =
            unsafe { (array::<_, 8>(voxels, 2)?, array::<_, 3>(weights, 3)?, write(sample, 4)?) };
        all_within(2, &voxels, -8190, 8190)?;
        let [a, b, c, d, e, f, g, h] = voxels;
        let corners = [[[a, b], [c, d]], [[e, f], [g, h]]];
        let weights = weights.map(|weight: u16| Weight::from_bits(weight.into()));
        *out = with_precision!(precision, p => Ok(trilinear(p, corners, weights)))?;
        Ok(())
    };
    // SAFETY: the caller's promise for `error`.
    unsafe { report(work(), error) }
}

/// Classification: opacity and colour of a sample. docs/contract/classification.md
///
/// `code`: 0 roots of 8 bits, 1 roots of 16, 2 roots and colours of 16. `lookup`: 0 nearest entry, 1 linear. `sample`: 0 to
/// 4095 with 12 fraction bits, 15 in wide. `entries`, `low_roots`, `low_colours`: as in `slicecast_scene`; `low_roots` is read
/// where `code` is 1 or 2, `low_colours` where it is 2. `opacity` receives 1.31, `colour` three values, 1.15, in wide 1.31.
/// Returns SLICECAST_OK or an error code.
///
/// # Safety
/// The tables that are read are readable, `opacity`, three values of `colour` and `error` (if not null) writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slicecast_stage_classify(
    precision: u32,
    code: u32,
    lookup: u32,
    sample: i32,
    entries: *const u32,
    low_roots: *const u8,
    low_colours: *const u8,
    opacity: *mut u32,
    colour: *mut u32,
    error: *mut SlicecastError,
) -> i32 {
    fn of<P: Precision>(p: P, sample: i32, table: &impl Classifier<P>) -> Result<(u32, [u32; 3]), SlicecastError> {
        within(4, sample.into(), 0, 4095 << p.formats().sample_bits)?;
        Ok((table.opacity(p, sample).to_bits(), table.colour(p, sample)))
    }
    let work = || {
        within(2, code.into(), 0, 2)?;
        within(3, lookup.into(), 0, 1)?;
        check(entries, 5)?;
        // SAFETY: not null, aligned; the caller's promise. The same below, where a table is read.
        let entries: &[u32; ENTRIES] = unsafe { &*entries.cast() };
        // SAFETY: the caller's promise; null and misaligned pointers are refused.
        let opacity = unsafe { write(opacity, 8)? };
        let roots = || -> Result<&[u8; ENTRIES], SlicecastError> {
            check(low_roots, 6)?;
            // SAFETY: as above.
            Ok(unsafe { &*low_roots.cast() })
        };
        let colours = || -> Result<&[[u8; 3]; ENTRIES], SlicecastError> {
            check(low_colours, 7)?;
            // SAFETY: as above.
            Ok(unsafe { &*low_colours.cast() })
        };
        let (found, [red, green, blue]) = with_precision!(precision, p => match (code, lookup) {
            (0, 0) => of(p, sample, &PointTable::<Sqrt8, Nearest>::new(entries, ())),
            (0, _) => of(p, sample, &PointTable::<Sqrt8, Linear>::new(entries, ())),
            (1, 0) => of(p, sample, &PointTable::<Sqrt16, Nearest>::new(entries, roots()?)),
            (1, _) => of(p, sample, &PointTable::<Sqrt16, Linear>::new(entries, roots()?)),
            (_, 0) => of(p, sample, &PointTable::<Colour16, Nearest>::new(entries, (roots()?, colours()?))),
            (_, _) => of(p, sample, &PointTable::<Colour16, Linear>::new(entries, (roots()?, colours()?))),
        })?;
        // SAFETY: the caller's promise; null and misaligned pointers are refused.
        unsafe { write_array(colour, 9, [red, green, blue])? };
        *opacity = found;
        Ok(())
    };
    // SAFETY: the caller's promise for `error`.
    unsafe { report(work(), error) }
}

/// Gradient: differences and their spacing factors. docs/contract/gradient.md
///
/// `samples`: 5 values of one precision: the samples after and before along i, those along j, and the interpolated derivative
/// along k; -8190 to 8190 in 15 fraction bits at most. `factors`: 3 values along i, j, k, 1.15, 1 to 32768. `gradient`
/// receives 3 values. Returns SLICECAST_OK or an error code.
///
/// # Safety
/// `samples` and `factors` are readable, three values of `gradient` and `error` (if not null) writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slicecast_stage_gradient(
    samples: *const i32,
    factors: *const u16,
    gradient: *mut i32,
    error: *mut SlicecastError,
) -> i32 {
    let work = || {
        // SAFETY: the caller's promise; null and misaligned pointers are refused.
        let (samples, factors) = unsafe { (array::<_, 5>(samples, 1)?, array::<u16, 3>(factors, 2)?) };
        all_within(1, &samples, -(8190 << 15), 8190 << 15)?;
        all_within(2, &factors, 1, 1 << 15)?;
        let [next_i, previous_i, next_j, previous_j, along_k] = samples;
        let mut differences = [0; 2];
        difference_row::<i32>(&[next_i, next_j], &[previous_i, previous_j], &mut differences);
        all_within(1, &differences, -(8190 << 15), 8190 << 15)?;
        let ([along_i, along_j], [fi, fj, fk]) = (differences, factors.map(Intensity::from_bits));
        // SAFETY: the caller's promise; null and misaligned pointers are refused.
        unsafe {
            write_array(
                gradient,
                3,
                [space(along_i, fi), space(along_j, fj), space(along_k, fk)],
            )
        }
    };
    // SAFETY: the caller's promise for `error`.
    unsafe { report(work(), error) }
}

/// Normalisation: direction of a gradient. docs/contract/normalisation.md
///
/// `gradient`: 3 values of one scale, any. `g` receives 3 values, -32767 to 32767, the largest with 15 bits; `r` receives
/// 2^35 / length of g, 22 bits, 0 for no gradient. Returns SLICECAST_OK or an error code.
///
/// # Safety
/// `gradient` is readable, three values of `g`, `r` and `error` (if not null) are writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slicecast_stage_normalise(
    gradient: *const i32,
    g: *mut i32,
    r: *mut u32,
    error: *mut SlicecastError,
) -> i32 {
    let work = || {
        // SAFETY: the caller's promise; null and misaligned pointers are refused.
        let (gradient, r) = unsafe { (array::<_, 3>(gradient, 1)?, write(r, 3)?) };
        let normal = normalise(gradient);
        // SAFETY: as above.
        unsafe { write_array(g, 2, normal.g)? };
        *r = normal.r;
        Ok(())
    };
    // SAFETY: the caller's promise for `error`.
    unsafe { report(work(), error) }
}

/// Shading: the colour of a sample under lights. docs/contract/shading.md
///
/// `lighting`: as in a scene; its vectors are unit vectors. `g`: 3 values, -32767 to 32767, and `r`, as normalisation makes
/// them. `colour`: 3 values as classification makes them, 1.15, in wide 1.31. `shaded` receives as many, in the same format.
/// Returns SLICECAST_OK or an error code.
///
/// # Safety
/// `lighting`, its lights, `g` and `colour` are readable, three values of `shaded` and `error` (if not null) writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slicecast_stage_shade(
    precision: u32,
    lighting: *const SlicecastLighting,
    g: *const i32,
    r: u32,
    colour: *const u32,
    shaded: *mut u32,
    error: *mut SlicecastError,
) -> i32 {
    let work = || {
        // SAFETY: the caller's promise; null and misaligned pointers are refused.
        let (g, colour) = unsafe { (array::<_, 3>(g, 3)?, array::<u32, 3>(colour, 5)?) };
        all_within(3, &g, -32767, 32767)?;
        within(4, r.into(), 0, 1 << 21)?;
        let found = with_precision!(precision, p => {
            all_within(5, &colour, 0, 1 << p.pixel().colour_bits())?;
            // SAFETY: the caller's promise.
            let phong = unsafe { <Phong<_> as Lights<_>>::of(p, lighting)? };
            Ok(phong.shade(Normal { g, r }, colour))
        })?;
        // SAFETY: the caller's promise; null and misaligned pointers are refused.
        unsafe { write_array(shaded, 6, found) }
    };
    // SAFETY: the caller's promise for `error`.
    unsafe { report(work(), error) }
}

/// A pixel of raw bits: red, green, blue, transparency, each at most 1.0.
fn pixel<P: Precision>(
    p: P,
    argument: u32,
    bits: [u32; 4],
) -> Result<Pixel<<P::Pixel as Recurrence>::Channel>, SlicecastError> {
    all_within(argument, &bits, 0, p.pixel().one().bits().into())?;
    let [red, green, blue, transparency] = bits;
    Ok(Pixel {
        colour: [red, green, blue].map(Channel::from_bits),
        transparency: Channel::from_bits(transparency),
    })
}

/// The bits of a pixel.
fn bits<C: Channel>(pixel: Pixel<C>) -> [u32; 4] {
    let [red, green, blue] = pixel.colour.map(Channel::bits);
    [red, green, blue, pixel.transparency.bits()]
}

/// Compositing: a pixel and one more sample. docs/contract/compositing.md
///
/// `order`: 0 front to back, 1 back to front. `plane`: the plane's number from the eye, 0 to 32768, for its offsets.
/// `floor`: transparency below it becomes 0, front to back only; the precision's own is 1, in wide 2048. `opacity`: 1.31, at
/// most 2^31. `colour`: 3 values, 1.15, in wide 1.31. `pixel`: 4 values, red, green, blue, transparency, at most 1.0 each
/// (32768 in paper, 65535 in compact, 2^31 in wide); front to back no colour and the transparency together more than 1.0.
/// It receives the pixel afterwards. Returns SLICECAST_OK or an error code.
///
/// # Safety
/// `colour` is readable, `pixel` readable and writable, `error` (if not null) writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slicecast_stage_composite(
    precision: u32,
    order: u32,
    plane: u32,
    floor: u32,
    opacity: u32,
    colour: *const u32,
    pixel: *mut u32,
    error: *mut SlicecastError,
) -> i32 {
    let work = || {
        within(2, order.into(), 0, 1)?;
        within(3, plane.into(), 0, PLANES_MAX.into())?;
        within(5, opacity.into(), 0, 1 << 31)?;
        // SAFETY: the caller's promise; null and misaligned pointers are refused.
        let (colour, before) = unsafe { (array::<u32, 3>(colour, 6)?, array::<u32, 4>(pixel.cast_const(), 7)?) };
        let (dither, opacity) = (Dither::of_plane(plane), Opacity::from_bits(opacity));
        let after = with_precision!(precision, p => {
            let one = i64::from(p.pixel().one().bits());
            within(4, floor.into(), 0, one)?;
            all_within(6, &colour, 0, 1 << p.pixel().colour_bits())?;
            let from = self::pixel(p, 7, before)?;
            if order == 1 {
                Ok(bits(p.pixel().under(from, colour, opacity, dither)))
            } else {
                let [red, green, blue, transparency] = before;
                all_within(7, &[red, green, blue], 0, one - i64::from(transparency))?;
                let mut after = p.pixel().over(from, colour, opacity, dither);
                after.transparency = settle(after.transparency, Channel::from_bits(floor));
                Ok(bits(after))
            }
        })?;
        // SAFETY: the caller's promise; null and misaligned pointers are refused.
        unsafe { write_array(pixel, 7, after) }
    };
    // SAFETY: the caller's promise for `error`.
    unsafe { report(work(), error) }
}

/// Projection: the larger or the smaller of a kept sample and one more. docs/contract/projection.md
///
/// `extreme`: 0 maximum, 1 minimum. `kept` holds the kept sample, at first -1 (maximum) or 2^31 - 1 (minimum), and receives
/// the one that is kept. Returns SLICECAST_OK or an error code.
///
/// # Safety
/// `kept` is readable and writable, `error` (if not null) writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slicecast_stage_project(
    extreme: u32,
    sample: i32,
    kept: *mut i32,
    error: *mut SlicecastError,
) -> i32 {
    let work = || {
        within(1, extreme.into(), 0, 1)?;
        within(2, sample.into(), 0, 4095 << 15)?;
        // SAFETY: the caller's promise; null and misaligned pointers are refused.
        let kept = unsafe { write(kept, 3)? };
        *kept = if extreme == 0 {
            Maximum::keep(*kept, sample)
        } else {
            Minimum::keep(*kept, sample)
        };
        Ok(())
    };
    // SAFETY: the caller's promise for `error`.
    unsafe { report(work(), error) }
}

/// One opacity and one colour, whatever the sample.
struct Known(Opacity, [u32; 3]);

impl<P: Precision> Classifier<P> for Known {
    fn opacity(&self, _: P, _: i32) -> Opacity {
        self.0
    }
    fn colour(&self, _: P, _: i32) -> [u32; 3] {
        self.1
    }
    fn support(&self) -> Support {
        Support::NONE
    }
}

/// Projection: the pixel of a kept sample, when all planes are folded. docs/contract/projection.md
///
/// `extreme`: 0 maximum, 1 minimum. `kept`: the kept sample. `opacity` (1.31) and `colour` (3 values, 1.15, in wide 1.31):
/// what classification makes of it; they count for nothing where the ray has met nothing. `pixel` receives 4 values, red,
/// green, blue, transparency. Returns SLICECAST_OK or an error code.
///
/// # Safety
/// `colour` is readable, four values of `pixel` and `error` (if not null) writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slicecast_stage_resolve(
    precision: u32,
    extreme: u32,
    kept: i32,
    opacity: u32,
    colour: *const u32,
    pixel: *mut u32,
    error: *mut SlicecastError,
) -> i32 {
    let work = || {
        within(2, extreme.into(), 0, 1)?;
        within(4, opacity.into(), 0, 1 << 31)?;
        // SAFETY: the caller's promise; null and misaligned pointers are refused.
        let colour = unsafe { array::<u32, 3>(colour, 5)? };
        let found = with_precision!(precision, p => {
            all_within(5, &colour, 0, 1 << p.pixel().colour_bits())?;
            let known = Known(Opacity::from_bits(opacity), colour);
            Ok(bits(if extreme == 0 {
                resolve::<_, Maximum>(p, kept, &known)
            } else {
                resolve::<_, Minimum>(p, kept, &known)
            }))
        })?;
        // SAFETY: the caller's promise; null and misaligned pointers are refused.
        unsafe { write_array(pixel, 6, found) }
    };
    // SAFETY: the caller's promise for `error`.
    unsafe { report(work(), error) }
}

/// Warp: where a picture pixel looks. docs/contract/warp.md
///
/// `x`, `y`: the picture pixel. `pixel` receives 2 values, the base-plane pixel before the point along u and v (all phases;
/// beyond 2^31 it wraps), `weight` 2 values, the weights of the next, 0.16. Returns SLICECAST_OK or an error code.
///
/// # Safety
/// `warp` is readable, two values of `pixel` and of `weight` and `error` (if not null) are writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slicecast_stage_point(
    warp: *const SlicecastWarp,
    x: u32,
    y: u32,
    pixel: *mut i32,
    weight: *mut u16,
    error: *mut SlicecastError,
) -> i32 {
    let work = || {
        // SAFETY: the caller's promise; null and misaligned pointers are refused.
        let point = unsafe { read(warp, 1)? }.warp().point(x, y);
        // 64 bits less 32: it fits, and so does a weight.
        let (at, weights) = (point.pixel.map(|c| c as i32), point.weight.map(|w| w as u16));
        check(weight.cast_const(), 5)?;
        // SAFETY: as above.
        unsafe { write_array(pixel, 4, at).and_then(|()| write_array(weight, 5, weights)) }
    };
    // SAFETY: the caller's promise for `error`.
    unsafe { report(work(), error) }
}

/// Warp: the mixture of four base-plane pixels, and what it is in front of a background. docs/contract/warp.md
///
/// `corners`: 16 values, the pixels at (u, v), (u + 1, v), (u, v + 1) and (u + 1, v + 1), each red, green, blue,
/// transparency, at most 1.0. `weights`: 2 values along u and v, 0.16. `background`: 3 values, 1.15, at most 32768. `mixed`
/// receives 4 values, `rgb` 3 values of 8 bits. Returns SLICECAST_OK or an error code.
///
/// # Safety
/// `corners`, `weights` and `background` are readable, four values of `mixed`, three of `rgb` and `error` (if not null)
/// writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slicecast_stage_warp(
    precision: u32,
    corners: *const u32,
    weights: *const u16,
    background: *const u16,
    mixed: *mut u32,
    rgb: *mut u8,
    error: *mut SlicecastError,
) -> i32 {
    fn of<P: Precision<Pixel: Recurrence<Channel: ChannelFormat>>>(
        p: P,
        corners: [[u32; 4]; 4],
        weights: [u16; 2],
        background: [u16; 3],
    ) -> Result<([u32; 4], [u8; 3]), SlicecastError> {
        let [a, b, c, d] = corners;
        let (upper, lower) = ([pixel(p, 2, a)?, pixel(p, 2, b)?], [pixel(p, 2, c)?, pixel(p, 2, d)?]);
        let ([wu, wv], mix) = (weights.map(u32::from), mix_pixels);
        let mixed = mix(mix(upper[0], upper[1], wu), mix(lower[0], lower[1], wu), wv);
        Ok((bits(mixed), in_front_of(mixed, background.map(Intensity::from_bits))))
    }
    let work = || {
        // SAFETY: the caller's promise; null and misaligned pointers are refused.
        let corners = unsafe { array::<[u32; 4], 4>(corners.cast(), 2)? };
        // SAFETY: the same.
        let (weights, background) = unsafe { (array::<u16, 2>(weights, 3)?, array::<u16, 3>(background, 4)?) };
        all_within(4, &background, 0, 1 << 15)?;
        let (pixel, bytes) = with_precision!(precision, p => of(p, corners, weights, background))?;
        check(rgb.cast_const(), 6)?;
        // SAFETY: the same.
        unsafe { write_array(mixed, 5, pixel).and_then(|()| write_array(rgb, 6, bytes)) }
    };
    // SAFETY: the caller's promise for `error`.
    unsafe { report(work(), error) }
}
