//! Classified segments: one table of integrals, and views that turn without a new one; surfaces in a volume, and their depths. Prints the sums of every stage
//! boundary as `bits` does, and what a frame of the dense scene costs, by points and by segments.
#![no_std]
#![no_main]

use semihosting::println;
use slicecast::classify::Classifier;
use slicecast::composite::{FrontToBack, Unorm16};
use slicecast::cut::Cut;
use slicecast::integral::Integral;
use slicecast::plane::{ChannelOf, Composite, Depth};
use slicecast::precision::{Compact, Wide};
use slicecast::shade::{Phong, Unlit};
use slicecast::stream::{Memory, Stream};
use slicecast_firmware::boundaries::show;
use slicecast_firmware::frame::streamed;
use slicecast_firmware::machine::{finish, start_counter};
use slicecast_firmware::memory::{Reserved, with_image};
use slicecast_firmware::scenes::{
    DENSE, DENSE_INTEGRALS, DEPTHS_EXPECTED, SURFACES_EXPECTED, TURN_INTEGRALS, TURNS, TURNS_EXPECTED,
};
use slicecast_firmware::stack;
use slicecast_firmware_shared::scene;
use slicecast_firmware_shared::scene::{IntegralData, Lights, Model, SURFACES, SceneData, SceneError};
use slicecast_firmware_shared::sum::Sum;
use static_cell::ConstStaticCell;

#[cfg(target_arch = "arm")]
use cortex_m_rt::entry;
#[cfg(target_arch = "riscv32")]
use riscv_rt::entry;

/// Pixels of the largest base plane.
const PIXELS: usize = 128 * 128;

/// Rows of scratch memory of two planes, lit, and one to spare.
const SCRATCH: usize = 28 * 66;

static NARROW: ConstStaticCell<Reserved<Unorm16, { 4 * 64 * 64 }, 256, SCRATCH, { 4 * PIXELS }>> =
    ConstStaticCell::new(Reserved::new(Unorm16(0)));
static BROAD: ConstStaticCell<Reserved<u32, 0, 0, 0, { 4 * PIXELS }>> = ConstStaticCell::new(Reserved::new(0));

#[entry]
fn main() -> ! {
    stack::paint();
    start_counter();
    let narrow = NARROW.take();
    let broad = BROAD.take().lend().image;
    let mut passed = true;
    for (scene, expected) in TURNS.iter().zip(&TURNS_EXPECTED) {
        let mut images = [0; 4];
        let [cu, cl, wu, wl] = &mut images;
        *cu = shown::<Compact, Unlit>(scene, narrow.lend());
        *cl = shown::<Compact, Phong<Compact>>(scene, narrow.lend());
        *wu = shown::<Wide, Unlit>(scene, with_image(narrow.lend(), broad));
        *wl = shown::<Wide, Phong<Wide>>(scene, with_image(narrow.lend(), broad));
        passed &= images == *expected;
    }
    if let Some(scene) = TURNS.first() {
        let surfaces = [
            cut::<Compact, Unlit>(scene, narrow.lend()),
            cut::<Compact, Phong<Compact>>(scene, narrow.lend()),
            cut::<Wide, Unlit>(scene, with_image(narrow.lend(), broad)),
            cut::<Wide, Phong<Wide>>(scene, with_image(narrow.lend(), broad)),
        ];
        passed &= surfaces == SURFACES_EXPECTED;
        passed &= depths(scene, with_image(narrow.lend(), broad)) == DEPTHS_EXPECTED;
    }
    by_points::<Compact, Unlit>(narrow.lend());
    by_segments::<Compact, Unlit>(narrow.lend());
    by_points::<Compact, Phong<Compact>>(narrow.lend());
    by_segments::<Compact, Phong<Compact>>(narrow.lend());
    by_points::<Wide, Unlit>(with_image(narrow.lend(), broad));
    by_segments::<Wide, Unlit>(with_image(narrow.lend(), broad));
    by_points::<Wide, Phong<Wide>>(with_image(narrow.lend(), broad));
    by_segments::<Wide, Phong<Wide>>(with_image(narrow.lend(), broad));
    println!("stack {}", stack::high_water());
    finish(passed)
}

/// The pipeline of a scene with a table of integrals.
type Segmented<P, S> = Composite<P, Integral<&'static [u32]>, S, FrontToBack>;

fn pipeline<P: Model, S: Lights<P>>(scene: &SceneData, table: &IntegralData) -> Result<Segmented<P, S>, SceneError> {
    let (precision, plan) = (P::default(), scene.plan()?);
    let classifier = table.classifier(&plan)?;
    Ok(Composite::new(
        precision,
        classifier,
        S::of(precision, &scene.lighting)?,
    ))
}

/// Renders a turned scene; the sum of its image, 0 if it cannot.
#[inline(never)]
fn shown<P: Model, S: Lights<P>>(scene: &SceneData, memory: Memory<'_, ChannelOf<P>>) -> u32 {
    println!("case {} {} {}", scene.name, P::NAME, S::NAME);
    match pipeline::<P, S>(scene, TURN_INTEGRALS) {
        Ok(pipeline) => show(scene, &pipeline, memory),
        Err(error) => {
            println!("error {error:?}");
            0
        }
    }
}

/// Renders a scene with surfaces in its volume; the sum of its image, 0 if it cannot.
#[inline(never)]
fn cut<P: Model, S: Lights<P>>(scene: &SceneData, memory: Memory<'_, ChannelOf<P>>) -> u32 {
    println!("case surfaces {} {} {}", scene.name, P::NAME, S::NAME);
    let pipeline = || -> Result<_, SceneError> {
        let (precision, plan) = (P::default(), scene.plan()?);
        let volume = TURN_INTEGRALS.classifier(&plan)?;
        let cut = Cut::new(Some(volume), &SURFACES, 1).map_err(SceneError::Cut)?;
        Ok(Composite::<P, _, S, FrontToBack>::new(
            precision,
            cut,
            S::of(precision, &scene.lighting)?,
        ))
    };
    match pipeline() {
        Ok(pipeline) => show(scene, &pipeline, memory),
        Err(error) => {
            println!("error {error:?}");
            0
        }
    }
}

/// The sum of the depths of a scene's surfaces; 0 if there are none.
#[inline(never)]
fn depths(scene: &SceneData, memory: Memory<'_, u32>) -> u32 {
    println!("case depths {}", scene.name);
    let found = || -> Option<u32> {
        let plan = scene.plan().ok()?;
        let pipeline = Depth::new(Compact, &SURFACES, &plan).ok()?;
        let mut stream = Stream::new(plan, pipeline, memory).ok()?;
        let [width, height, _] = plan.dims();
        for slice in scene.voxels.chunks_exact((width * height) as usize) {
            stream.push(slice).ok()?;
        }
        let mut sum = Sum::new();
        stream.image().iter().for_each(|depth| sum.word(*depth));
        Some(sum.get())
    };
    let sum = found().unwrap_or(0);
    println!("image {sum:08x}");
    sum
}

/// Counts a frame of the dense scene by points.
#[inline(never)]
fn by_points<P: Model, S: Lights<P>>(memory: Memory<'_, ChannelOf<P>>) {
    println!("case points {} {} {}", DENSE.name, P::NAME, S::NAME);
    counted(scene::pipeline::<P, S>(DENSE), memory);
}

/// Counts a frame of the dense scene by segments.
#[inline(never)]
fn by_segments<P: Model, S: Lights<P>>(memory: Memory<'_, ChannelOf<P>>) {
    println!("case segments {} {} {}", DENSE.name, P::NAME, S::NAME);
    counted(pipeline::<P, S>(DENSE, DENSE_INTEGRALS), memory);
}

/// Prints the memory lent to a frame of the dense scene, its instructions and its image's sum.
#[inline(always)]
fn counted<P: Model, C: Classifier<P>, S: Lights<P>>(
    pipeline: Result<Composite<P, C, S, FrontToBack>, SceneError>,
    memory: Memory<'_, ChannelOf<P>>,
) {
    let (Ok(plan), Ok(pipeline)) = (DENSE.plan(), pipeline) else {
        println!("error the scene is out of range");
        return;
    };
    streamed(DENSE, plan, &pipeline, memory);
}
