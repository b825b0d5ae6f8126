//! The `fast` precision from C: its pipelines, and the table that they look samples up in.

use core::ptr::null;

use slicecast::classify::{AlphaCode, Colour16, Linear, PointTable, Sqrt16};
use slicecast::composite::FrontToBack;
use slicecast::fast::table::{fill_colours, fill_roots};
use slicecast::fast::{Colours, FastPhong, RootTable, Roots};
use slicecast::plan::Plan;
use slicecast::plane::{Fast, Pictured};
use slicecast::shade::Unlit;
use slicecast::table::ENTRIES;

use crate::error::SlicecastError;
use crate::instance::{Instance, SlicecastPipeline};
use crate::scene::{SlicecastLighting, SlicecastScene};
use crate::{check, read, report, write};

/// The table of the pipelines named `slicecast_fast_`, in the program's memory or in flash; `slicecast_fast_table` makes it of a scene's.
/// docs/contract/fast.md
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SlicecastFastTable {
    /// 4096 words, one per voxel value: the square root of its opacity of one step, 65535 is 1, in the lower half, and that of the next
    /// value (of the last one its own) in the upper.
    pub roots: *const u32,
    /// 4097 times four numbers: red, green and blue of a voxel value, 65535 is 1, and 0; the last value's stand twice. Null: all values
    /// have one colour.
    pub colours: *const u16,
    /// That colour, red, green, blue, 65535 is 1; not read where there are colours.
    pub colour: [u16; 3],
}

impl SlicecastFastTable {
    /// The table, where it lies; `argument` is the place of the scene that names it.
    ///
    /// # Safety
    /// The pointers are null, misaligned, or point to as much, which stays readable and unchanged.
    unsafe fn table(&self, argument: u32) -> Result<RootTable<&'static Roots, &'static Colours>, SlicecastError> {
        check(self.roots, argument)?;
        // SAFETY: not null, aligned; the caller's promise.
        let roots: &Roots = unsafe { &*self.roots.cast() };
        let colours = if self.colours.is_null() {
            Ok(self.colour)
        } else {
            check(self.colours, argument)?;
            // SAFETY: as above; a colour is four numbers.
            Err(unsafe { &*self.colours.cast::<Colours>() })
        };
        Ok(RootTable::new(roots, colours))
    }
}

/// A shader of 16-bit lanes that can be made from C's lights, which are argument 2 or belong to it.
trait FastLights: Sized + 'static {
    /// # Safety
    /// `lighting`, and the lights in it, are null, misaligned or readable.
    unsafe fn of(lighting: *const SlicecastLighting) -> Result<Self, SlicecastError>;
}

impl FastLights for Unlit {
    unsafe fn of(_: *const SlicecastLighting) -> Result<Self, SlicecastError> {
        Ok(Self)
    }
}

impl FastLights for FastPhong {
    unsafe fn of(lighting: *const SlicecastLighting) -> Result<Self, SlicecastError> {
        // SAFETY: the caller's promise.
        unsafe { read(lighting, 2)?.fast() }
    }
}

impl<S: FastLights> Instance for Fast<&'static Roots, &'static Colours, S, FrontToBack>
where
    Self: Pictured,
{
    unsafe fn of(scene: &SlicecastScene, _: &Plan) -> Result<Self, SlicecastError> {
        // SAFETY: the caller's promise.
        unsafe { Ok(Self::new(read(scene.fast, 2)?.table(2)?, S::of(scene.lighting)?)) }
    }
}

/// The pipeline of the `fast` precision (16-bit lanes), without lights: 8 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_fast_unlit() -> *const SlicecastPipeline {
    const { &<Fast<&'static Roots, &'static Colours, Unlit, FrontToBack> as Instance>::DESCRIPTION }
}

/// The pipeline of the `fast` precision (16-bit lanes), lit: 8 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_fast_lit() -> *const SlicecastPipeline {
    const { &<Fast<&'static Roots, &'static Colours, FastPhong, FrontToBack> as Instance>::DESCRIPTION }
}

/// Makes the table of the pipelines named `slicecast_fast_` of a scene's: of its `entries` and `low_roots`, and of its
/// `low_colours` where they are
/// not null.
///
/// `roots`: memory for 4096 words, 16 KiB. `colours`: memory for 4 * 4097 numbers, 32 KiB; it may be null if all values have one colour.
/// `table` receives where they lie, or that colour: colours are then not written. A program whose table lies in flash needs no call
/// of this. Returns SLICECAST_OK or an error code: SLICECAST_NULL of argument 3 where values differ in colour and there is no memory for
/// that.
///
/// # Safety
/// `scene` and its table are readable; `roots`, `colours` (if not null), `table` and `error` (if not null) writable; none overlaps
/// another.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slicecast_fast_table(
    scene: *const SlicecastScene,
    roots: *mut u32,
    colours: *mut u16,
    table: *mut SlicecastFastTable,
    error: *mut SlicecastError,
) -> i32 {
    let work = || {
        // SAFETY: the caller's promise; null and misaligned pointers are refused.
        let (scene, table) = unsafe { (read(scene, 1)?, write(table, 4)?) };
        let of_scene = |error| SlicecastError { argument: 1, ..error };
        // SAFETY: as above.
        let (entries, low_roots) = unsafe {
            let low_roots = scene.low_roots().map_err(of_scene)?;
            (scene.entries().map_err(of_scene)?, low_roots)
        };
        // SAFETY: as above; an array is aligned as its elements are.
        let to_roots = unsafe { write(roots.cast::<Roots>(), 2)? };
        let to_colours = if colours.is_null() {
            None
        } else {
            // SAFETY: as above.
            Some(unsafe { write(colours.cast::<Colours>(), 3)? })
        };
        let one = if scene.low_colours.is_null() {
            let points = PointTable::<Sqrt16, Linear>::new(entries, low_roots);
            fill(&points, to_roots, to_colours)?
        } else {
            // SAFETY: as above.
            let low_colours = unsafe { scene.low_colours()? };
            let points = PointTable::<Colour16, Linear>::new(entries, (low_roots, low_colours));
            fill(&points, to_roots, to_colours)?
        };
        *table = SlicecastFastTable {
            roots,
            colours: if one.is_some() { null() } else { colours },
            colour: one.unwrap_or_default(),
        };
        Ok(())
    };
    // SAFETY: the caller's promise for `error`.
    unsafe { report(work(), error) }
}

/// Fills a table from points; the one colour, where all values have the same, which takes no memory.
fn fill<A: AlphaCode>(
    points: &PointTable<'_, A, Linear>,
    roots: &mut Roots,
    colours: Option<&mut Colours>,
) -> Result<Option<[u16; 3]>, SlicecastError> {
    fill_roots(points, roots);
    let first = points.code_colour(0);
    if (1..ENTRIES).all(|code| points.code_colour(code) == first) {
        return Ok(Some(first));
    }
    Ok(fill_colours(points, colours.ok_or(SlicecastError::null(3))?))
}
