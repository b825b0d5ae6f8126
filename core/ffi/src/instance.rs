//! From the opaque types to core's pipelines: one description, with its functions, for each combination that can be
//! linked.

use core::ffi::c_void;

use slicecast::classify::{Classifier, Colour16, Linear, Nearest, PointTable, Sqrt8, Sqrt16};
use slicecast::clip::Clipper;
use slicecast::composite::FrontToBack;
use slicecast::cut::Cut;
use slicecast::format::Intensity;
use slicecast::integral::{Integral, Length};
use slicecast::plan::Plan;
use slicecast::plane::{Composite, Depth, Pictured, Pipeline};
use slicecast::precision::{Compact, Paper, Precision, Wide};
use slicecast::shade::{Phong, Shader, Unlit};
use slicecast::slice::{RowRange, Voxel as _};
use slicecast::stream::{Memory, Needs, Stream};
use slicecast::surface::Surface;
use slicecast::warp::in_front_of;

use crate::error::{SLICECAST_COMPLETE, SLICECAST_INTERPOLATION, SLICECAST_SLICES, SlicecastError};
use crate::scene::{SlicecastLighting, SlicecastNeeds, SlicecastScene, SlicecastWarp};
use crate::{SLICECAST_STATE_BYTES, SlicecastStream, check, read};

/// "SLCP" and "SLCS": marks of a description and of a stream.
const PIPELINE_MARK: u32 = 0x534c_4350;
const STREAM_MARK: u32 = 0x534c_4353;

/// Begins a stream: description, scene, plan, first row, rows, memory and where its parts lie.
type Open =
    unsafe fn(&SlicecastPipeline, &SlicecastScene, Plan, u32, u32, *mut u8, &Layout) -> Result<(), SlicecastError>;

/// The description of a pipeline. Opaque; the functions named after pipelines return one.
pub struct SlicecastPipeline {
    mark: u32,
    needs: fn(&Plan, u32) -> Layout,
    open: Open,
    wanted: unsafe fn(*const Header) -> Option<u32>,
    plan: unsafe fn(*const Header) -> *const Plan,
    clip: unsafe fn(*mut Header, Clipper<'static>) -> Result<(), SlicecastError>,
    push: unsafe fn(*mut Header, &[u16]) -> Result<(), SlicecastError>,
    image: unsafe fn(*const Header) -> (*const c_void, usize),
    picture_row: unsafe fn(*const Header, &SlicecastWarp, u32, [Intensity; 3], &mut [u8]),
}

/// The start of a stream's block.
#[repr(C)]
pub(crate) struct Header {
    mark: u32,
    pipeline: *const SlicecastPipeline,
}

/// A stream in its block; its memory follows.
#[repr(C)]
struct Held<L: Pipeline + 'static> {
    header: Header,
    stream: Stream<'static, L>,
}

/// Where the parts of a block begin, bytes; all of them multiples of 8.
#[derive(Clone, Copy)]
struct Layout {
    needs: Needs,
    parts: [usize; 4],
    total: usize,
}

impl Layout {
    /// Every part begins at a multiple of this.
    const ALIGN: usize = 8;

    fn of<L: Pipeline + 'static>(plan: &Plan, rows: u32) -> Self {
        const { assert!(size_of::<Held<L>>() <= SLICECAST_STATE_BYTES) };
        let needs = Needs::of_band::<L>(plan, rows);
        let mut total = size_of::<Held<L>>().next_multiple_of(Self::ALIGN);
        let parts = needs.bytes().map(|bytes| {
            let start = total;
            total = total.saturating_add(bytes).saturating_add(Self::ALIGN - 1) & !(Self::ALIGN - 1);
            start
        });
        Self { needs, parts, total }
    }
}

/// A pipeline that can be made from a C scene.
pub(crate) trait Instance: Pictured + Sized + 'static {
    /// # Safety
    /// The scene's pointers are null, misaligned or good; tables stay readable and unchanged.
    unsafe fn of(scene: &SlicecastScene, plan: &Plan) -> Result<Self, SlicecastError>;

    const DESCRIPTION: SlicecastPipeline = SlicecastPipeline {
        mark: PIPELINE_MARK,
        needs: Layout::of::<Self>,
        open: open::<Self>,
        wanted: wanted::<Self>,
        plan: plan::<Self>,
        clip: clip::<Self>,
        push: push::<Self>,
        image: image::<Self>,
        picture_row: picture_row::<Self>,
    };
}

/// # Safety
/// The scene's pointers as for [`Instance::of`]; `memory` is aligned and holds `layout.total` bytes, the stream's alone.
unsafe fn open<L: Instance>(
    description: &SlicecastPipeline,
    scene: &SlicecastScene,
    plan: Plan,
    first: u32,
    rows: u32,
    memory: *mut u8,
    layout: &Layout,
) -> Result<(), SlicecastError> {
    // SAFETY: the caller's promise.
    let pipeline = unsafe { L::of(scene, &plan)? };
    let [slices, ranges, scratch, image] = layout.parts;
    let needs = &layout.needs;
    // SAFETY: the parts lie one behind the other inside the block, aligned to 8, and all their memory is written before
    // a reference to it is formed. (The image is written again by the stream; it is cleared there.)
    let parts = unsafe {
        Memory {
            slices: fill(memory.add(slices).cast(), needs.slices, 0u16),
            ranges: fill(memory.add(ranges).cast(), needs.ranges, RowRange::EMPTY),
            scratch: fill(memory.add(scratch).cast(), needs.scratch, 0i32),
            image: fill(memory.add(image).cast(), needs.image, L::Element::default()),
        }
    };
    let stream = Stream::band(plan, pipeline, parts, first..first.saturating_add(rows))?;
    let header = Header {
        mark: STREAM_MARK,
        pipeline: description,
    };
    // SAFETY: the block begins with room for this, aligned.
    unsafe { memory.cast::<Held<L>>().write(Held { header, stream }) };
    Ok(())
}

/// Writes `count` values and returns the slice of them.
///
/// # Safety
/// `start` is aligned, and `count` elements from it are the caller's alone for the slice's life.
unsafe fn fill<T: Copy>(start: *mut T, count: usize, value: T) -> &'static mut [T] {
    for index in 0..count {
        // SAFETY: the caller's promise.
        unsafe { start.add(index).write(value) };
    }
    // SAFETY: all of it has just been written.
    unsafe { core::slice::from_raw_parts_mut(start, count) }
}

/// # Safety
/// `header` begins a `Held<L>`.
unsafe fn wanted<L: Instance>(header: *const Header) -> Option<u32> {
    // SAFETY: the caller's promise.
    unsafe { (*header.cast::<Held<L>>()).stream.wanted() }
}

/// # Safety
/// `header` begins a `Held<L>`.
unsafe fn plan<L: Instance>(header: *const Header) -> *const Plan {
    // SAFETY: the caller's promise.
    unsafe { (*header.cast::<Held<L>>()).stream.plan() }
}

/// # Safety
/// `header` begins a `Held<L>` that is in no other use.
unsafe fn clip<L: Instance>(header: *mut Header, clips: Clipper<'static>) -> Result<(), SlicecastError> {
    // SAFETY: the caller's promise.
    let held = unsafe { &mut *header.cast::<Held<L>>() };
    Ok(held.stream.clip(clips)?)
}

/// # Safety
/// `header` begins a `Held<L>` that is in no other use.
unsafe fn push<L: Instance>(header: *mut Header, voxels: &[u16]) -> Result<(), SlicecastError> {
    // SAFETY: the caller's promise.
    let held = unsafe { &mut *header.cast::<Held<L>>() };
    Ok(held.stream.push(L::Voxel::given(voxels))?)
}

/// # Safety
/// `header` begins a `Held<L>`.
unsafe fn image<L: Instance>(header: *const Header) -> (*const c_void, usize) {
    // SAFETY: the caller's promise.
    let image = unsafe { (*header.cast::<Held<L>>()).stream.image() };
    (image.as_ptr().cast(), size_of_val(image))
}

/// # Safety
/// `header` begins a `Held<L>`.
unsafe fn picture_row<L: Instance>(
    header: *const Header,
    warp: &SlicecastWarp,
    y: u32,
    background: [Intensity; 3],
    rgb: &mut [u8],
) {
    // SAFETY: the caller's promise.
    let stream = unsafe { &(*header.cast::<Held<L>>()).stream };
    let warp = warp.warp();
    for (x, out) in (0..).zip(rgb.chunks_exact_mut(3)) {
        let pixel = warp.pixel(x, y, |u, v| stream.pixel(u, v));
        for (o, c) in out.iter_mut().zip(in_front_of(pixel, background)) {
            *o = c;
        }
    }
}

impl SlicecastPipeline {
    pub(crate) fn is_genuine(&self) -> bool {
        self.mark == PIPELINE_MARK
    }

    fn layout(&self, scene: &SlicecastScene, rows: u32) -> Result<(Plan, Layout, u32), SlicecastError> {
        let plan = scene.plan()?;
        let [_, all] = plan.base();
        let rows = if rows == 0 { all } else { rows };
        Ok((plan, (self.needs)(&plan, rows), rows))
    }

    pub(crate) fn needs(&self, scene: &SlicecastScene, rows: u32) -> Result<SlicecastNeeds, SlicecastError> {
        let (plan, layout, _) = self.layout(scene, rows)?;
        let ([width, height, slices], [columns, rows]) = (plan.dims(), plan.base());
        let [_, _, _, image_bytes] = layout.needs.bytes();
        Ok(SlicecastNeeds {
            bytes: layout.total,
            align: Layout::ALIGN,
            slice_voxels: width as usize * height as usize,
            slice_width: width,
            slices,
            first: plan.first(),
            columns,
            rows,
            phases: plan.phases(),
            element_bytes: layout.needs.element_bytes as u32,
            image_bytes,
        })
    }

    /// # Safety
    /// The scene's pointers are null, misaligned or good, and so is `memory`, of `bytes` bytes.
    pub(crate) unsafe fn open(
        &self,
        scene: &SlicecastScene,
        first: u32,
        rows: u32,
        memory: *mut u8,
        bytes: usize,
    ) -> Result<*mut SlicecastStream, SlicecastError> {
        let (plan, layout, rows) = self.layout(scene, rows)?;
        if memory.addr() & (Layout::ALIGN - 1) != 0 {
            return Err(SlicecastError::misaligned(5, Layout::ALIGN, memory.addr()));
        }
        if bytes < layout.total || layout.total > isize::MAX as usize {
            return Err(SlicecastError::length(6, layout.total, bytes));
        }
        // SAFETY: aligned and long enough; the rest is the caller's promise.
        unsafe { (self.open)(self, scene, plan, first, rows, memory, &layout)? };
        Ok(memory.cast())
    }
}

/// A stream behind a pointer of the caller's, and the pipeline that made it.
#[derive(Clone, Copy)]
pub(crate) struct Handle {
    header: *mut Header,
    pipeline: &'static SlicecastPipeline,
}

impl Handle {
    /// # Safety
    /// `stream` is null, misaligned, or points to a block that a stream may begin.
    pub(crate) unsafe fn of(stream: *const SlicecastStream, argument: u32) -> Result<Self, SlicecastError> {
        let header: *mut Header = stream.cast_mut().cast();
        check(header, argument)?;
        // SAFETY: not null, aligned; the caller's promise. The pointer is read only where the mark says that `open`
        // wrote it.
        unsafe {
            if (*header).mark != STREAM_MARK {
                return Err(SlicecastError::foreign(argument));
            }
            let pipeline = &*(*header).pipeline;
            Ok(Self { header, pipeline })
        }
    }

    pub(crate) fn wanted(self) -> Result<u32, SlicecastError> {
        // SAFETY: the header's own pipeline made what follows it.
        let number = unsafe { (self.pipeline.wanted)(self.header) };
        number.ok_or(SlicecastError::numbers(SLICECAST_COMPLETE, 0, 0))
    }

    pub(crate) fn plan(&self) -> &Plan {
        // SAFETY: the header's own pipeline made what follows it, and it stays there.
        unsafe { &*(self.pipeline.plan)(self.header) }
    }

    pub(crate) fn clip(self, clips: Clipper<'static>) -> Result<(), SlicecastError> {
        // SAFETY: as above.
        unsafe { (self.pipeline.clip)(self.header, clips) }
    }

    pub(crate) fn push(self, voxels: &[u16]) -> Result<(), SlicecastError> {
        // SAFETY: as above.
        unsafe { (self.pipeline.push)(self.header, voxels) }
    }

    pub(crate) fn image(self) -> (*const c_void, usize) {
        // SAFETY: as above.
        unsafe { (self.pipeline.image)(self.header) }
    }

    pub(crate) fn picture_row(self, warp: &SlicecastWarp, y: u32, background: &[u16], rgb: &mut [u8]) {
        let mut behind = [Intensity::ZERO; 3];
        for (b, bits) in behind.iter_mut().zip(background) {
            *b = Intensity::from_bits(*bits);
        }
        // SAFETY: as above.
        unsafe { (self.pipeline.picture_row)(self.header, warp, y, behind, rgb) };
    }
}

/// A shader that can be made from C's lights, which are argument 2 or belong to it.
pub(crate) trait Lights<P: Precision>: Shader<P> + Sized + 'static {
    /// # Safety
    /// `lighting`, and the lights in it, are null, misaligned or readable.
    unsafe fn of(precision: P, lighting: *const SlicecastLighting) -> Result<Self, SlicecastError>;
}

impl<P: Precision> Lights<P> for Unlit {
    unsafe fn of(_: P, _: *const SlicecastLighting) -> Result<Self, SlicecastError> {
        Ok(Self)
    }
}

impl<P: Precision> Lights<P> for Phong<P> {
    unsafe fn of(precision: P, lighting: *const SlicecastLighting) -> Result<Self, SlicecastError> {
        // SAFETY: the caller's promise.
        unsafe { read(lighting, 2)?.phong(precision) }
    }
}

/// The paper's table: 8-bit roots, nearest entry.
type Paper8 = PointTable<'static, Sqrt8, Nearest>;
/// The others': 16-bit roots, linear.
type Fine16 = PointTable<'static, Sqrt16, Linear>;
/// The same with colours of 16 bits.
type Colours16 = PointTable<'static, Colour16, Linear>;

/// Integrals, for segments.
type Integrals = Integral<&'static [u32]>;

/// Isosurfaces, in a volume or alone.
type Surfaces = Cut<&'static [u32], &'static [Surface]>;

/// A table that can be made from a C scene.
trait Table: Sized + 'static {
    /// # Safety
    /// As for [`Instance::of`].
    unsafe fn of(scene: &SlicecastScene, plan: &Plan) -> Result<Self, SlicecastError>;
}

impl Table for Paper8 {
    unsafe fn of(scene: &SlicecastScene, _: &Plan) -> Result<Self, SlicecastError> {
        // SAFETY: the caller's promise.
        Ok(Self::new(unsafe { scene.entries()? }, ()))
    }
}

impl Table for Fine16 {
    unsafe fn of(scene: &SlicecastScene, _: &Plan) -> Result<Self, SlicecastError> {
        // SAFETY: the caller's promise.
        Ok(unsafe { Self::new(scene.entries()?, scene.low_roots()?) })
    }
}

impl Table for Colours16 {
    unsafe fn of(scene: &SlicecastScene, _: &Plan) -> Result<Self, SlicecastError> {
        // SAFETY: the caller's promise.
        Ok(unsafe { Self::new(scene.entries()?, (scene.low_roots()?, scene.low_colours()?)) })
    }
}

/// Refuses plans that have no segments.
fn has_segments(plan: &Plan) -> Result<(), SlicecastError> {
    if plan.is_nearest() {
        return Err(SlicecastError::numbers(SLICECAST_INTERPOLATION, 0, 1));
    }
    if plan.ends() < 2 {
        let [_, _, slices] = plan.dims();
        return Err(SlicecastError::numbers(SLICECAST_SLICES, 2, slices.into()));
    }
    Ok(())
}

impl Table for Surfaces {
    unsafe fn of(scene: &SlicecastScene, plan: &Plan) -> Result<Self, SlicecastError> {
        has_segments(plan)?;
        let volume = if scene.integrals.is_null() {
            None
        } else {
            // SAFETY: the caller's promise.
            Some(unsafe { Integrals::of(scene, plan)? })
        };
        // SAFETY: the caller's promise.
        Ok(Self::new(volume, unsafe { scene.surfaces(2)? }, 1)?)
    }
}

impl Table for Integrals {
    unsafe fn of(scene: &SlicecastScene, plan: &Plan) -> Result<Self, SlicecastError> {
        has_segments(plan)?;
        // SAFETY: the caller's promise.
        unsafe { read(scene.integrals, 2)?.table(2, Length::of(plan)) }
    }
}

impl<P: Precision + Default> Instance for Depth<P, &'static [Surface]>
where
    Self: Pictured,
{
    unsafe fn of(scene: &SlicecastScene, plan: &Plan) -> Result<Self, SlicecastError> {
        has_segments(plan)?;
        // SAFETY: the caller's promise.
        Ok(Self::new(P::default(), unsafe { scene.surfaces(2)? }, plan)?)
    }
}

impl<P, T, S> Instance for Composite<P, T, S, FrontToBack>
where
    P: Precision + Default,
    T: Classifier<P> + Table,
    S: Lights<P>,
    Self: Pictured,
{
    unsafe fn of(scene: &SlicecastScene, plan: &Plan) -> Result<Self, SlicecastError> {
        let precision = P::default();
        // SAFETY: the caller's promise.
        Ok(unsafe { Self::new(precision, T::of(scene, plan)?, S::of(precision, scene.lighting)?) })
    }
}

/// The pipeline of the `Paper` precision, without lights: 8 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_paper_unlit() -> *const SlicecastPipeline {
    const { &<Composite<Paper, Paper8, Unlit, FrontToBack> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Paper` precision, lit: 8 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_paper_lit() -> *const SlicecastPipeline {
    const { &<Composite<Paper, Paper8, Phong<Paper>, FrontToBack> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Compact` precision (the default), without lights: 8 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_compact_unlit() -> *const SlicecastPipeline {
    const { &<Composite<Compact, Fine16, Unlit, FrontToBack> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Compact` precision (the default), lit: 8 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_compact_lit() -> *const SlicecastPipeline {
    const { &<Composite<Compact, Fine16, Phong<Compact>, FrontToBack> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Wide` precision, without lights: 16 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_wide_unlit() -> *const SlicecastPipeline {
    const { &<Composite<Wide, Fine16, Unlit, FrontToBack> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Wide` precision, lit: 16 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_wide_lit() -> *const SlicecastPipeline {
    const { &<Composite<Wide, Fine16, Phong<Wide>, FrontToBack> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Compact` precision (the default), without lights, with colours of 16 bits: 8 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_compact_unlit_colour16() -> *const SlicecastPipeline {
    const { &<Composite<Compact, Colours16, Unlit, FrontToBack> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Compact` precision (the default), lit, with colours of 16 bits: 8 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_compact_lit_colour16() -> *const SlicecastPipeline {
    const { &<Composite<Compact, Colours16, Phong<Compact>, FrontToBack> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Wide` precision, without lights, with colours of 16 bits: 16 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_wide_unlit_colour16() -> *const SlicecastPipeline {
    const { &<Composite<Wide, Colours16, Unlit, FrontToBack> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Wide` precision, lit, with colours of 16 bits: 16 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_wide_lit_colour16() -> *const SlicecastPipeline {
    const { &<Composite<Wide, Colours16, Phong<Wide>, FrontToBack> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Paper` precision, without lights, of segments: 8 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_paper_unlit_segments() -> *const SlicecastPipeline {
    const { &<Composite<Paper, Integrals, Unlit, FrontToBack> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Paper` precision, lit, of segments: 8 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_paper_lit_segments() -> *const SlicecastPipeline {
    const { &<Composite<Paper, Integrals, Phong<Paper>, FrontToBack> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Compact` precision (the default), without lights, of segments: 8 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_compact_unlit_segments() -> *const SlicecastPipeline {
    const { &<Composite<Compact, Integrals, Unlit, FrontToBack> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Compact` precision (the default), lit, of segments: 8 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_compact_lit_segments() -> *const SlicecastPipeline {
    const { &<Composite<Compact, Integrals, Phong<Compact>, FrontToBack> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Wide` precision, without lights, of segments: 16 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_wide_unlit_segments() -> *const SlicecastPipeline {
    const { &<Composite<Wide, Integrals, Unlit, FrontToBack> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Wide` precision, lit, of segments: 16 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_wide_lit_segments() -> *const SlicecastPipeline {
    const { &<Composite<Wide, Integrals, Phong<Wide>, FrontToBack> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Paper` precision, without lights, of isosurfaces, in a volume or alone: 8 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_paper_unlit_surfaces() -> *const SlicecastPipeline {
    const { &<Composite<Paper, Surfaces, Unlit, FrontToBack> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Paper` precision, lit, of isosurfaces, in a volume or alone: 8 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_paper_lit_surfaces() -> *const SlicecastPipeline {
    const { &<Composite<Paper, Surfaces, Phong<Paper>, FrontToBack> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Paper` precision that finds the depth of the first isosurface: 4 bytes per pixel, a uint32_t, in
/// planes from the first, 16.16, and 4294967295 where a ray meets none. A picture of it is grey, white on the first plane.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_paper_depth() -> *const SlicecastPipeline {
    const { &<Depth<Paper, &'static [Surface]> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Compact` precision (the default), without lights, of isosurfaces, in a volume or alone: 8 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_compact_unlit_surfaces() -> *const SlicecastPipeline {
    const { &<Composite<Compact, Surfaces, Unlit, FrontToBack> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Compact` precision (the default), lit, of isosurfaces, in a volume or alone: 8 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_compact_lit_surfaces() -> *const SlicecastPipeline {
    const { &<Composite<Compact, Surfaces, Phong<Compact>, FrontToBack> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Compact` precision (the default) that finds the depth of the first isosurface: 4 bytes per pixel, a uint32_t, in
/// planes from the first, 16.16, and 4294967295 where a ray meets none. A picture of it is grey, white on the first plane.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_compact_depth() -> *const SlicecastPipeline {
    const { &<Depth<Compact, &'static [Surface]> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Wide` precision, without lights, of isosurfaces, in a volume or alone: 16 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_wide_unlit_surfaces() -> *const SlicecastPipeline {
    const { &<Composite<Wide, Surfaces, Unlit, FrontToBack> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Wide` precision, lit, of isosurfaces, in a volume or alone: 16 bytes per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_wide_lit_surfaces() -> *const SlicecastPipeline {
    const { &<Composite<Wide, Surfaces, Phong<Wide>, FrontToBack> as Instance>::DESCRIPTION }
}

/// The pipeline of the `Wide` precision that finds the depth of the first isosurface: 4 bytes per pixel, a uint32_t, in
/// planes from the first, 16.16, and 4294967295 where a ray meets none. A picture of it is grey, white on the first plane.
#[unsafe(no_mangle)]
pub extern "C" fn slicecast_wide_depth() -> *const SlicecastPipeline {
    const { &<Depth<Wide, &'static [Surface]> as Instance>::DESCRIPTION }
}
