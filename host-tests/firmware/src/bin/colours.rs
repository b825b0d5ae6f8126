//! Volumes of colour and extinction: the dense scene's voxels as entries, streamed and composited by one factor, unlit and lit, beside
//! the same scene by points. Prints the sums of the images and what the frames cost.
#![no_std]
#![no_main]

use semihosting::println;
use slicecast::composite::{ChannelFormat, Recurrence, Unorm16, Weighted};
use slicecast::extinction::Given;
use slicecast::plane::{ChannelOf, Rgba};
use slicecast::precision::{Compact, Wide};
use slicecast::shade::{Phong, Unlit};
use slicecast::stream::{Memory, Needs, Stream};
use slicecast_firmware::frame::streamed;
use slicecast_firmware::machine::{finish, instructions_a_tick, start_counter, ticks, ticks_between};
use slicecast_firmware::memory::{Reserved, with_image};
use slicecast_firmware::scenes::{COLOURS_EXPECTED, DENSE};
use slicecast_firmware::stack;
use slicecast_firmware_shared::image;
use slicecast_firmware_shared::scene::{Lights, Model, colour_entry, colour_medium, pipeline};
use slicecast_firmware_shared::sum::Sum;
use static_cell::ConstStaticCell;

#[cfg(target_arch = "arm")]
use cortex_m_rt::entry;
#[cfg(target_arch = "riscv32")]
use riscv_rt::entry;

/// Pixels of the largest base plane.
const PIXELS: usize = 128 * 128;

/// Rows of scratch memory of four channels and gradients, and one to spare.
const SCRATCH: usize = 25 * 66;

static NARROW: ConstStaticCell<Reserved<Unorm16, { 16 * 64 * 64 }, 256, SCRATCH, { 4 * PIXELS }>> =
    ConstStaticCell::new(Reserved::new(Unorm16(0)));
static BROAD: ConstStaticCell<Reserved<u32, 0, 0, 0, { 4 * PIXELS }>> = ConstStaticCell::new(Reserved::new(0));
static ENTRIES: ConstStaticCell<[u32; 64 * 64]> = ConstStaticCell::new([0; 64 * 64]);

#[entry]
fn main() -> ! {
    stack::paint();
    start_counter();
    let narrow = NARROW.take();
    let broad = BROAD.take().lend().image;
    let entries = ENTRIES.take();
    by_points::<Compact, Unlit>(narrow.lend());
    let compact = by_colours::<Compact, Unlit>(narrow.lend(), entries);
    by_points::<Wide, Unlit>(with_image(narrow.lend(), broad));
    let wide = by_colours::<Wide, Unlit>(with_image(narrow.lend(), broad), entries);
    by_points::<Compact, Phong<Compact>>(narrow.lend());
    let compact_lit = by_colours::<Compact, Phong<Compact>>(narrow.lend(), entries);
    by_points::<Wide, Phong<Wide>>(with_image(narrow.lend(), broad));
    let wide_lit = by_colours::<Wide, Phong<Wide>>(with_image(narrow.lend(), broad), entries);
    println!("stack {}", stack::high_water());
    finish([compact, wide, compact_lit, wide_lit] == COLOURS_EXPECTED)
}

/// A frame of the dense scene by points.
#[inline(never)]
fn by_points<P: Model, S: Lights<P>>(memory: Memory<'_, ChannelOf<P>>) {
    println!("case points {} {} {}", DENSE.name, P::NAME, S::NAME);
    let (Ok(plan), Ok(pipeline)) = (DENSE.plan(), pipeline::<P, S>(DENSE)) else {
        println!("error the scene is out of range");
        return;
    };
    streamed(DENSE, plan, &pipeline, memory);
}

/// A frame of the dense scene's entries; the sum of its image.
#[inline(never)]
fn by_colours<P: Model<Pixel: Weighted + Recurrence<Channel: ChannelFormat>>, S: Lights<P>>(
    memory: Memory<'_, ChannelOf<P>>,
    entries: &mut [u32],
) -> u32 {
    println!("case colours {} {} {}", DENSE.name, P::NAME, S::NAME);
    let precision = P::default();
    let shader = S::of(precision, &DENSE.lighting);
    let (Ok(plan), Ok(medium), Ok(shader)) = (DENSE.plan(), colour_medium(), shader) else {
        println!("error the scene is out of range");
        return 0;
    };
    let [slices, ranges, scratch, image] = Needs::of::<Rgba<P, S>>(&plan).bytes();
    println!("memory {slices} {ranges} {scratch} {image}");
    let Ok(mut stream) = Stream::new(plan, Rgba::shaded(precision, medium, shader), memory) else {
        println!("error too little memory");
        return 0;
    };
    let [width, height, _] = plan.dims();
    let mut total = 0u64;
    for slice in DENSE.voxels.chunks_exact((width * height) as usize) {
        let entries = entries.get_mut(..slice.len()).unwrap_or(&mut []);
        for (entry, code) in entries.iter_mut().zip(slice) {
            *entry = colour_entry(*code);
        }
        let before = ticks();
        let pushed = stream.push(Given::Entries { entries, low: None });
        total += u64::from(ticks_between(before, ticks()));
        if pushed.is_err() {
            println!("error slice refused");
        }
    }
    println!("instructions {}", total * instructions_a_tick());
    let mut sum = Sum::new();
    image::add_rows(&mut sum, stream.image());
    println!("image {:08x}", sum.get());
    sum.get()
}
