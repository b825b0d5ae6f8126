//! Perspective: the dense scene from an eye in front of it, beside the same scene in a parallel view, unlit and lit. Prints the sums of
//! the images and what the frames cost.
#![no_std]
#![no_main]

use semihosting::println;
use slicecast::composite::Unorm16;
use slicecast::plane::{ChannelOf, Perspective};
use slicecast::precision::{Compact, Wide};
use slicecast::shade::{Phong, Unlit};
use slicecast::stream::Memory;
use slicecast_firmware::frame::streamed;
use slicecast_firmware::machine::{finish, start_counter};
use slicecast_firmware::memory::{Reserved, with_image};
use slicecast_firmware::scenes::{DENSE, PERSPECTIVE_EXPECTED};
use slicecast_firmware::stack;
use slicecast_firmware_shared::scene::{Lights, Model, pipeline, plan_in_perspective};
use static_cell::ConstStaticCell;

#[cfg(target_arch = "arm")]
use cortex_m_rt::entry;
#[cfg(target_arch = "riscv32")]
use riscv_rt::entry;

/// Pixels of the largest base plane.
const PIXELS: usize = 128 * 128;

/// Rows of scratch memory in perspective, lit, as long as the image's.
const SCRATCH: usize = 28 * 130;

static NARROW: ConstStaticCell<Reserved<Unorm16, { 4 * 64 * 64 }, 256, SCRATCH, { 4 * PIXELS }>> =
    ConstStaticCell::new(Reserved::new(Unorm16(0)));
static BROAD: ConstStaticCell<Reserved<u32, 0, 0, 0, { 4 * PIXELS }>> = ConstStaticCell::new(Reserved::new(0));

#[entry]
fn main() -> ! {
    stack::paint();
    start_counter();
    let narrow = NARROW.take();
    let broad = BROAD.take().lend().image;
    parallel::<Compact, Unlit>(narrow.lend());
    let compact = in_perspective::<Compact, Unlit>(narrow.lend());
    parallel::<Wide, Unlit>(with_image(narrow.lend(), broad));
    let wide = in_perspective::<Wide, Unlit>(with_image(narrow.lend(), broad));
    parallel::<Compact, Phong<Compact>>(narrow.lend());
    let compact_lit = in_perspective::<Compact, Phong<Compact>>(narrow.lend());
    parallel::<Wide, Phong<Wide>>(with_image(narrow.lend(), broad));
    let wide_lit = in_perspective::<Wide, Phong<Wide>>(with_image(narrow.lend(), broad));
    println!("stack {}", stack::high_water());
    finish([compact, wide, compact_lit, wide_lit] == PERSPECTIVE_EXPECTED)
}

/// A frame of the dense scene in a parallel view.
#[inline(never)]
fn parallel<P: Model, S: Lights<P>>(memory: Memory<'_, ChannelOf<P>>) {
    println!("case parallel {} {} {}", DENSE.name, P::NAME, S::NAME);
    let (Ok(plan), Ok(pipeline)) = (DENSE.plan(), pipeline::<P, S>(DENSE)) else {
        println!("error the scene is out of range");
        return;
    };
    streamed(DENSE, plan, &pipeline, memory);
}

/// A frame of the same voxels in perspective; the sum of its image.
#[inline(never)]
fn in_perspective<P: Model, S: Lights<P>>(memory: Memory<'_, ChannelOf<P>>) -> u32 {
    println!("case perspective {} {} {}", DENSE.name, P::NAME, S::NAME);
    let plan = DENSE.plan().ok().and_then(|plan| plan_in_perspective(&plan).ok());
    let (Some((plan, spread)), Ok(pipeline)) = (plan, pipeline::<P, S>(DENSE)) else {
        println!("error the scene is out of range");
        return 0;
    };
    streamed(DENSE, plan, &Perspective::new(pipeline, spread), memory)
}
