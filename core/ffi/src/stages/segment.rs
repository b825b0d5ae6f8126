//! Classification of segments.

use slicecast::classify::Classifier;
use slicecast::integral::{Integral, Length};
use slicecast::precision::{Compact, Paper, Precision, Wide};

use super::{SLICECAST_COMPACT, SLICECAST_PAPER, SLICECAST_WIDE, within, write_array};
use crate::error::SlicecastError;
use crate::integrals::SlicecastIntegrals;
use crate::scene::SlicecastScene;
use crate::{read, report, write};

/// The length of a view's segments.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SlicecastLength {
    /// log2(e) times the length in smallest voxel spacings.
    pub scaled: u32,
    /// Its fraction bits, 11 to 27.
    pub bits: u32,
}

/// Classification of segments: the length of a scene's segments. docs/contract/integral.md
///
/// `length` receives all that depends on the view; of the scene its tables and lights are not read. Returns SLICECAST_OK or an
/// error code.
///
/// # Safety
/// `scene` is readable, `length` and `error` (if not null) are writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slicecast_stage_length(
    scene: *const SlicecastScene,
    length: *mut SlicecastLength,
    error: *mut SlicecastError,
) -> i32 {
    let work = || {
        // SAFETY: the caller's promise; null and misaligned pointers are refused.
        let (scene, out) = unsafe { (read(scene, 1)?, write(length, 2)?) };
        let Length { scaled, bits } = Length::of(&scene.plan()?);
        *out = SlicecastLength { scaled, bits };
        Ok(())
    };
    // SAFETY: the caller's promise for `error`.
    unsafe { report(work(), error) }
}

/// Classification of segments: opacity and colour between two samples. docs/contract/integral.md
///
/// `front`, `back`: the samples, 0 to 4095 with 12 fraction bits, 15 in wide. `opacity` receives 1.31, `colour` three values,
/// 1.15, in wide 1.31. Every call checks all nodes of the table. Returns SLICECAST_OK or an error code.
///
/// # Safety
/// `integrals`, its lists and `length` are readable, `opacity`, three values of `colour` and `error` (if not null) writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slicecast_stage_segment(
    precision: u32,
    integrals: *const SlicecastIntegrals,
    length: *const SlicecastLength,
    front: i32,
    back: i32,
    opacity: *mut u32,
    colour: *mut u32,
    error: *mut SlicecastError,
) -> i32 {
    fn of<P: Precision>(
        p: P,
        table: &Integral<&[u32]>,
        [front, back]: [i32; 2],
    ) -> Result<(u32, [u32; 3]), SlicecastError> {
        let last = 4095 << p.formats().sample_bits;
        within(4, front.into(), 0, last)?;
        within(5, back.into(), 0, last)?;
        let opacity = table.segment_opacity(p, [front, back]).to_bits();
        Ok((opacity, table.segment_colour(p, [front, back])))
    }
    let work = || {
        // SAFETY: the caller's promise; null and misaligned pointers are refused.
        let (integrals, length, opacity) = unsafe { (read(integrals, 2)?, read(length, 3)?, write(opacity, 6)?) };
        let SlicecastLength { scaled, bits } = *length;
        // SAFETY: the caller's promise.
        let table = unsafe { integrals.table(2, Length { scaled, bits })? };
        let (found, [red, green, blue]) = with_precision!(precision, p => of(p, &table, [front, back]))?;
        // SAFETY: the caller's promise; null and misaligned pointers are refused.
        unsafe { write_array(colour, 7, [red, green, blue])? };
        *opacity = found;
        Ok(())
    };
    // SAFETY: the caller's promise for `error`.
    unsafe { report(work(), error) }
}
