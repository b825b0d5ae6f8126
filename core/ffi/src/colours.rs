//! Volumes of colour and extinction from C: their pipelines, the scale of a scene, and the codes of entries.

use slicecast::absorption::Medium;
use slicecast::absorption::MediumError;
use slicecast::composite::Weighted;
use slicecast::extinction::{MAX_CODE, decode};
use slicecast::plan::Plan;
use slicecast::plane::{Pictured, Rgba};
use slicecast::precision::{Compact, Precision, Wide};
use slicecast::shade::{Phong, Unlit};

use crate::error::{SLICECAST_CODES, SLICECAST_MEDIUM, SlicecastError};
use crate::instance::{Instance, Lights, SlicecastPipeline};
use crate::scene::SlicecastScene;
use crate::{check, report, slice};

/// What a step through the largest extinction of a volume amounts to under a scene: `mantissa 2^-exponent = tau_max d 2^28 / 32767`, with
/// tau_max per length and d the length of a step. docs/contract/extinction.md
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SlicecastMedium {
    /// Below 2^31; at least 2^30 where the exponent is below 35, or accuracy is lost.
    pub mantissa: u32,
    /// 14 to 35. A step has an optical depth of at most 15.
    pub exponent: u32,
}

impl From<MediumError> for SlicecastError {
    fn from(error: MediumError) -> Self {
        match error {
            MediumError::Scale { mantissa, .. } if mantissa >> 31 != 0 => {
                Self::numbers(SLICECAST_MEDIUM, i64::from(i32::MAX), mantissa.into())
            }
            MediumError::Scale { exponent, .. } => {
                let passed = if exponent < 14 { 14 } else { 35 };
                Self::numbers(SLICECAST_MEDIUM, passed, exponent.into())
            }
            MediumError::Opaque => Self::numbers(SLICECAST_MEDIUM, 15, 0),
        }
    }
}

/// What is wrong with the codes of a voxel: the extinction, or the largest colour above it.
pub(crate) fn codes_error(row: usize, column: usize, [extinction, red, green, blue]: [u16; 4]) -> SlicecastError {
    let (needed, given) = if extinction > MAX_CODE {
        (MAX_CODE, extinction)
    } else {
        (extinction, red.max(green).max(blue))
    };
    SlicecastError {
        row: row as u32,
        column: column as u32,
        ..SlicecastError::numbers(SLICECAST_CODES, needed.into(), given.into())
    }
}

impl<P, S> Instance for Rgba<P, S>
where
    P: Precision<Pixel: Weighted> + Default,
    S: Lights<P>,
    Self: Pictured,
{
    unsafe fn of(scene: &SlicecastScene, _: &Plan) -> Result<Self, SlicecastError> {
        let (precision, SlicecastMedium { mantissa, exponent }) = (P::default(), scene.medium);
        let medium = Medium::new(mantissa, exponent)?;
        // SAFETY: the caller's promise.
        Ok(Self::shaded(precision, medium, unsafe {
            S::of(precision, scene.lighting)?
        }))
    }
}

/// The pipeline of the `Compact` precision (the default), without lights, of colours and extinctions: 8 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_compact_unlit_rgba() -> *const SlicecastPipeline {
    const { &<Rgba<Compact, Unlit> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Compact` precision (the default), lit, of colours and extinctions: 8 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_compact_lit_rgba() -> *const SlicecastPipeline {
    const { &<Rgba<Compact, Phong<Compact>> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Wide` precision, without lights, of colours and extinctions: 16 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_wide_unlit_rgba() -> *const SlicecastPipeline {
    const { &<Rgba<Wide, Unlit> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Wide` precision, lit, of colours and extinctions: 16 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_wide_lit_rgba() -> *const SlicecastPipeline {
    const { &<Rgba<Wide, Phong<Wide>> as Instance>::DESCRIPTION }
}

/// Makes the codes of a row of voxels of colour and extinction, as `slicecast_push` takes them from entries.
///
/// `entries`: `width` of them, red in the lowest byte, green, blue, and the root of extinction, `sqrt(tau / tau_max)`, in the highest.
/// `low_roots`: as many low bytes of the roots; null where roots have 8 bits. `codes` receives 4 * `width` numbers: the extinctions, then
/// red, green and blue times extinction. A slice is its rows, one behind the other. Returns SLICECAST_OK or an error code.
///
/// # Safety
/// `entries` and `low_roots` (if not null) are readable, `codes` and `error` (if not null) writable; none overlaps another.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slicecast_codes(
    entries: *const u32,
    low_roots: *const u8,
    width: usize,
    codes: *mut u16,
    error: *mut SlicecastError,
) -> i32 {
    let work = || {
        // SAFETY: the caller's promise; null and misaligned pointers are refused.
        let entries = unsafe { slice(entries, width, 1)? };
        let low_roots = if low_roots.is_null() {
            None
        } else {
            // SAFETY: as above.
            Some(unsafe { slice(low_roots, width, 2)? })
        };
        check(codes.cast_const(), 4)?;
        if width > isize::MAX as usize / 8 {
            return Err(SlicecastError::length(3, isize::MAX as usize / 8, width));
        }
        // SAFETY: not null, aligned, and otherwise the caller's promise.
        let codes = unsafe { core::slice::from_raw_parts_mut(codes, 4 * width) };
        for (column, entry) in entries.iter().enumerate() {
            // 257 times a byte is that byte twice.
            let low = low_roots.map_or(Some((entry >> 24) as u8), |low| low.get(column).copied());
            for (run, code) in decode(*entry, low.unwrap_or(0)).into_iter().enumerate() {
                if let Some(out) = codes.get_mut(run * width + column) {
                    *out = code;
                }
            }
        }
        Ok(())
    };
    // SAFETY: the caller's promise for `error`.
    unsafe { report(work(), error) }
}
