//! slicecast for C: a static library and the header `include/slicecast.h`.
//!
//! A stream lives in one block of the caller's memory, whose size and alignment [`slicecast_needs`] tells first. Its
//! type is opaque. Every function checks its pointers (null, alignment), lengths and the version of the structures, and
//! returns a code; the numbers behind a code are written to a [`SlicecastError`] where one is given. Nothing here can
//! panic (a test looks for panic symbols in the linked object), nothing allocates, and nothing is kept beyond the block
//! and what it borrows: the tables.
//!
//! Beside the stream there is a function a stage (`slicecast_stage_locate` to `slicecast_stage_warp`), for simulators and
//! benches.
//!
//! There is one function a pipeline ([`slicecast_compact_lit`] and so on), which returns its description; what a program
//! does not name is not linked. Pipelines named `_segments` classify the segment between two samples, by integrals that hold
//! for every view: a view is turned by opening a stream of another direction over the same table. Pipelines named `_surfaces`
//! draw isosurfaces with them, or alone; pipelines named `_depth` find where each ray meets the first of them. Pipelines named `_rgba`
//! render volumes whose voxels have a colour and an extinction of their own: no table. Those named `slicecast_fast_` work in 16-bit lanes
//! and read a table of their own, which [`slicecast_fast_table`] makes of a scene's.
#![cfg_attr(target_os = "none", no_std)]

mod clips;
mod colours;
mod error;
mod fast;
mod instance;
mod integrals;
mod scene;
mod stages;
mod surfaces;

pub use clips::{SLICECAST_CLIPS_WORDS, SlicecastClip, SlicecastClips, SlicecastCue};
pub use colours::{
    SlicecastMedium, slicecast_codes, slicecast_compact_lit_rgba, slicecast_compact_unlit_rgba,
    slicecast_wide_lit_rgba, slicecast_wide_unlit_rgba,
};
pub use error::*;
pub use fast::{SlicecastFastTable, slicecast_fast_lit, slicecast_fast_table, slicecast_fast_unlit};
pub use instance::{
    SlicecastPipeline, slicecast_compact_depth, slicecast_compact_lit, slicecast_compact_lit_colour16,
    slicecast_compact_lit_segments, slicecast_compact_lit_surfaces, slicecast_compact_unlit,
    slicecast_compact_unlit_colour16, slicecast_compact_unlit_segments, slicecast_compact_unlit_surfaces,
    slicecast_paper_depth, slicecast_paper_lit, slicecast_paper_lit_segments, slicecast_paper_lit_surfaces,
    slicecast_paper_unlit, slicecast_paper_unlit_segments, slicecast_paper_unlit_surfaces, slicecast_wide_depth,
    slicecast_wide_lit, slicecast_wide_lit_colour16, slicecast_wide_lit_segments, slicecast_wide_lit_surfaces,
    slicecast_wide_unlit, slicecast_wide_unlit_colour16, slicecast_wide_unlit_segments, slicecast_wide_unlit_surfaces,
};
pub use integrals::SlicecastIntegrals;
pub use scene::{SlicecastLight, SlicecastLighting, SlicecastNeeds, SlicecastScene, SlicecastScreen, SlicecastWarp};
pub use stages::*;
pub use surfaces::{SlicecastFace, SlicecastSurface};

use core::ffi::c_void;

use crate::instance::{Handle, Header};

/// Version of the structures in this header. Write it to `slicecast_scene.version`.
pub const SLICECAST_VERSION: u32 = 7;

/// Bytes of a stream's own state at most, on any machine. A block for a known scene has this many, and those of slices, row
/// ranges, scratch and image, each rounded up to a multiple of 8; `slicecast_needs` tells the exact number.
pub const SLICECAST_STATE_BYTES: usize = 1024;

/// A frame in the making. Opaque; it begins at the start of the block given to `slicecast_open`.
pub struct SlicecastStream {
    _header: Header,
}

/// The version of the library: equal to SLICECAST_VERSION of the header that it was built with.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_version() -> u32 {
    SLICECAST_VERSION
}

/// Tells what a band of `rows` rows of the base-plane image (of each phase) takes; `rows` 0 asks for the whole image.
///
/// `pipeline`: from one of the functions named after pipelines. `needs` receives the answer. `error` may be null.
/// Returns SLICECAST_OK or an error code.
///
/// # Safety
/// `scene` and what it points to are readable, `needs` and `error` (if not null) writable, as C structures of their
/// types.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slicecast_needs(
    pipeline: *const SlicecastPipeline,
    scene: *const SlicecastScene,
    rows: u32,
    needs: *mut SlicecastNeeds,
    error: *mut SlicecastError,
) -> i32 {
    let work = || {
        // SAFETY: the caller's promise; null and misaligned pointers are refused.
        let (pipeline, scene, needs) = unsafe { (read(pipeline, 1)?, read(scene, 2)?, write(needs, 4)?) };
        *needs = pipeline.needs(scene, rows)?;
        Ok(())
    };
    // SAFETY: the caller's promise for `error`.
    unsafe { report(work(), error) }
}

/// Begins a frame, or a band of it, in the caller's memory, and clears its image.
///
/// Pipelines of segments check all nodes of the scene's integrals here, which is little beside a frame, and take the length of
/// the view's segments from the scene.
///
/// `first`, `rows`: the band, in rows of the base-plane image; `rows` 0 takes the whole image. `memory`: a block of
/// `bytes` bytes, at least `needs.bytes` of them, aligned to `needs.align` bytes. `stream` receives the stream, which is
/// the start of the block. The stream ends when the block is used for something else; there is nothing to release.
/// Returns SLICECAST_OK or an error code; `*stream` is then null.
///
/// # Safety
/// As for `slicecast_needs`; the block is the stream's alone, and the scene's tables stay readable and unchanged, as
/// long as the stream is used. (Scene and lights themselves are copied.)
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slicecast_open(
    pipeline: *const SlicecastPipeline,
    scene: *const SlicecastScene,
    first: u32,
    rows: u32,
    memory: *mut c_void,
    bytes: usize,
    stream: *mut *mut SlicecastStream,
    error: *mut SlicecastError,
) -> i32 {
    let work = || {
        // SAFETY: the caller's promise; null and misaligned pointers are refused.
        let stream = unsafe { write(stream, 7)? };
        *stream = core::ptr::null_mut();
        // SAFETY: as above.
        let (pipeline, scene) = unsafe { (read(pipeline, 1)?, read(scene, 2)?) };
        if memory.is_null() {
            return Err(SlicecastError::null(5));
        }
        // SAFETY: the caller lends the block.
        *stream = unsafe { pipeline.open(scene, first, rows, memory.cast(), bytes)? };
        Ok(())
    };
    // SAFETY: the caller's promise for `error`.
    unsafe { report(work(), error) }
}

/// Tells the number of the slice, along the viewing axis of the whole volume, that is wanted next: written to `number`.
///
/// Returns SLICECAST_OK, SLICECAST_COMPLETE when the frame is complete (`number` is then untouched), or an error code.
///
/// # Safety
/// `stream` comes from `slicecast_open`, its block is untouched; `number` and `error` (if not null) are writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slicecast_wanted(
    stream: *const SlicecastStream,
    number: *mut u32,
    error: *mut SlicecastError,
) -> i32 {
    let work = || {
        // SAFETY: the caller's promise; null, misaligned and foreign pointers are refused.
        let (stream, number) = unsafe { (Handle::of(stream, 1)?, write(number, 2)?) };
        *number = stream.wanted()?;
        Ok(())
    };
    // SAFETY: the caller's promise for `error`.
    unsafe { report(work(), error) }
}

/// Puts a frame behind clip planes, or gives it depth cueing, before its first slice.
///
/// `planes`: `count` of them, at most 6; null if there are none. `cue`: null without depth cueing. Both are copied. `clips`: memory for
/// what is made of them. Pipelines of depths have no colours that turn. Returns SLICECAST_OK or an error
/// code; the stream is then as it was.
///
/// # Safety
/// `stream` as for `slicecast_wanted`; `planes` readable; `clips` the stream's alone as long as it is used.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slicecast_clip(
    stream: *mut SlicecastStream,
    planes: *const SlicecastClip,
    count: usize,
    cue: *const SlicecastCue,
    clips: *mut SlicecastClips,
    error: *mut SlicecastError,
) -> i32 {
    let work = || {
        // SAFETY: the caller's promise; null, misaligned and foreign pointers are refused.
        let (stream, clips) = unsafe { (Handle::of(stream, 1)?, write(clips, 5)?) };
        // SAFETY: as above.
        let planes = if count == 0 {
            &[]
        } else {
            unsafe { slice(planes, count, 2)? }
        };
        // SAFETY: as above.
        let cue = if cue.is_null() {
            None
        } else {
            Some(unsafe { read(cue, 4)? })
        };
        clips.give(planes, cue, stream)
    };
    // SAFETY: the caller's promise for `error`.
    unsafe { report(work(), error) }
}

/// Takes the slice that is wanted next and folds every sample plane that it completes.
///
/// `voxels`: `count` = `needs.slice_voxels` values of 0 to 4095, row after row; they are copied. To a scene that is cropped a
/// slice may be given whole, as one that is not cropped takes it: what the box looks at is copied. Pipelines of colours and
/// extinctions take `count` = 4 * `needs.slice_voxels` codes: of each row the extinctions, 0 to 32767, and red, green and blue times
/// extinction, none above it (`slicecast_codes`); of a cropped scene those of what the box looks at alone. Returns SLICECAST_OK,
/// SLICECAST_COMPLETE if no slice is wanted any more, or an error code; the slice is then not taken, and a good one may
/// follow.
///
/// # Safety
/// `stream` as for `slicecast_wanted`, used by one thread at a time; `voxels` readable and outside the stream's block.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slicecast_push(
    stream: *mut SlicecastStream,
    voxels: *const u16,
    count: usize,
    error: *mut SlicecastError,
) -> i32 {
    let work = || {
        // SAFETY: the caller's promise; null, misaligned and foreign pointers are refused.
        let (stream, voxels) = unsafe { (Handle::of(stream, 1)?, slice(voxels, count, 2)?) };
        stream.push(voxels)
    };
    // SAFETY: the caller's promise for `error`.
    unsafe { report(work(), error) }
}

/// Gives the image (or the band of it) as it stands: `image` receives where it lies inside the block, `bytes` its length.
///
/// Phase after phase, row after row; a row is red, green, blue and transparency, `needs.columns` elements each, of
/// `needs.element_bytes` bytes: 2 (`paper`: 32768 is 1; `compact` and `fast`: 65535 is 1) or 4 (`wide`: 2147483648 is 1).
/// Colours are weighted by opacity.
/// Returns SLICECAST_OK or an error code.
///
/// # Safety
/// `stream` as for `slicecast_wanted`; `image`, `bytes` and `error` (if not null) are writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slicecast_image(
    stream: *const SlicecastStream,
    image: *mut *const c_void,
    bytes: *mut usize,
    error: *mut SlicecastError,
) -> i32 {
    let work = || {
        // SAFETY: the caller's promise; null, misaligned and foreign pointers are refused.
        let (stream, image, bytes) = unsafe { (Handle::of(stream, 1)?, write(image, 2)?, write(bytes, 3)?) };
        (*image, *bytes) = stream.image();
        Ok(())
    };
    // SAFETY: the caller's promise for `error`.
    unsafe { report(work(), error) }
}

/// Makes the warp of a view: where the pixels of a picture look at the base plane of a scene (its dims, direction and rates).
///
/// `screen`: where the pixels lie in the volume. `warp` receives the answer, for `slicecast_picture_row`. Returns SLICECAST_OK
/// or an error code.
///
/// # Safety
/// `scene` and `screen` are readable, `warp` and `error` (if not null) writable, as C structures of their types.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slicecast_warp(
    scene: *const SlicecastScene,
    screen: *const SlicecastScreen,
    warp: *mut SlicecastWarp,
    error: *mut SlicecastError,
) -> i32 {
    let work = || {
        // SAFETY: the caller's promise; null and misaligned pointers are refused.
        let (scene, screen, warp) = unsafe { (read(scene, 1)?, read(screen, 2)?, write(warp, 3)?) };
        *warp = screen.warp(scene)?;
        Ok(())
    };
    // SAFETY: the caller's promise for `error`.
    unsafe { report(work(), error) }
}

/// Makes a row of the viewer's picture from a finished whole image.
///
/// `warp`: where picture pixels look at the base plane. `y`: the row. `background`: red, green, blue, 1.15. `rgb`
/// receives `bytes / 3` pixels, 8 bits per channel; `bytes` must be a multiple of 3. Returns SLICECAST_OK or an error code.
///
/// # Safety
/// `stream` as for `slicecast_wanted`; `warp` and three values of `background` readable, `rgb` writable for `bytes`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slicecast_picture_row(
    stream: *const SlicecastStream,
    warp: *const SlicecastWarp,
    y: u32,
    background: *const u16,
    rgb: *mut u8,
    bytes: usize,
    error: *mut SlicecastError,
) -> i32 {
    let work = || {
        // SAFETY: the caller's promise; null, misaligned and foreign pointers are refused.
        let (stream, warp, background) = unsafe { (Handle::of(stream, 1)?, read(warp, 2)?, slice(background, 3, 4)?) };
        if rgb.is_null() {
            return Err(SlicecastError::null(5));
        }
        if bytes.checked_rem(3) != Some(0) {
            return Err(SlicecastError::length(6, bytes - bytes % 3, bytes));
        }
        // SAFETY: the caller's promise: writable for `bytes`.
        let rgb = unsafe { core::slice::from_raw_parts_mut(rgb, bytes) };
        stream.picture_row(warp, y, background, rgb);
        Ok(())
    };
    // SAFETY: the caller's promise for `error`.
    unsafe { report(work(), error) }
}

/// A reference from a pointer of the caller's; `argument` is its place in the function's list, from 1.
///
/// # Safety
/// Null or misaligned it may be; otherwise it points to a `T` that is written by no one meanwhile.
unsafe fn read<'a, T: Checked>(pointer: *const T, argument: u32) -> Result<&'a T, SlicecastError> {
    check(pointer, argument)?;
    // SAFETY: not null, aligned, and otherwise the caller's promise.
    let value = unsafe { &*pointer };
    if value.is_genuine() {
        Ok(value)
    } else {
        Err(SlicecastError::foreign(argument))
    }
}

/// A reference to write through; see [`read`].
///
/// # Safety
/// Null or misaligned it may be; otherwise it points to memory for a `T` that is the caller's alone.
unsafe fn write<'a, T>(pointer: *mut T, argument: u32) -> Result<&'a mut T, SlicecastError> {
    check(pointer, argument)?;
    // SAFETY: not null, aligned, and otherwise the caller's promise.
    Ok(unsafe { &mut *pointer })
}

/// A slice of the caller's.
///
/// # Safety
/// Null or misaligned it may be; otherwise it points to `count` elements that is written by no one meanwhile.
unsafe fn slice<'a, T>(pointer: *const T, count: usize, argument: u32) -> Result<&'a [T], SlicecastError> {
    check(pointer, argument)?;
    if count > isize::MAX as usize / size_of::<T>().max(1) {
        return Err(SlicecastError::length(argument, 0, count));
    }
    // SAFETY: not null, aligned, not longer than memory can be, and otherwise the caller's promise.
    Ok(unsafe { core::slice::from_raw_parts(pointer, count) })
}

fn check<T>(pointer: *const T, argument: u32) -> Result<(), SlicecastError> {
    if pointer.is_null() {
        return Err(SlicecastError::null(argument));
    }
    if !pointer.is_aligned() {
        return Err(SlicecastError::misaligned(argument, align_of::<T>(), pointer.addr()));
    }
    Ok(())
}

/// What can be told of a value behind a pointer.
trait Checked {
    /// Whether it is what the pointer's type says, as far as can be seen.
    fn is_genuine(&self) -> bool {
        true
    }
}

impl Checked for SlicecastScene {}
impl Checked for SlicecastCue {}
impl Checked for SlicecastFastTable {}
impl Checked for SlicecastScreen {}
impl Checked for SlicecastWarp {}
impl Checked for SlicecastLighting {}
impl Checked for SlicecastIntegrals {}
impl Checked for SlicecastLength {}
impl Checked for SlicecastPipeline {
    fn is_genuine(&self) -> bool {
        self.is_genuine()
    }
}

/// Writes the numbers behind an outcome where they are wanted, and returns its code.
///
/// # Safety
/// `error` is null or writable (misaligned, it is left alone).
unsafe fn report(outcome: Result<(), SlicecastError>, error: *mut SlicecastError) -> i32 {
    let found = outcome.err().unwrap_or(SlicecastError::NONE);
    if !error.is_null() && error.is_aligned() {
        // SAFETY: not null, aligned, and the caller's promise.
        unsafe { error.write(found) };
    }
    found.code
}

#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    // Cannot be reached: the object is tested for it. A static library must name a handler all the same.
    loop {
        core::hint::spin_loop();
    }
}
