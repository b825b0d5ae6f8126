//! A volume of 64^3 voxels, lit, in 64 KiB of RAM: the image is rendered band by band, the slices read again for each.
//! The linker script gives this program 64 KiB for statics and stack together.
#![no_std]
#![no_main]

use semihosting::println;
use slicecast::composite::Unorm16;
use slicecast::precision::Compact;
use slicecast::shade::Phong;
use slicecast::stream::{Needs, Stream};
use slicecast_firmware::machine::{finish, instructions_a_tick, start_counter, ticks, ticks_between};
use slicecast_firmware::memory::Reserved;
use slicecast_firmware::scenes::{LARGE, LARGE_COMPACT_LIT};
use slicecast_firmware::stack;
use slicecast_firmware_shared::image;
use slicecast_firmware_shared::scene::{PipelineOf, pipeline};
use slicecast_firmware_shared::sum::Sum;
use static_cell::ConstStaticCell;

#[cfg(target_arch = "arm")]
use cortex_m_rt::entry;
#[cfg(target_arch = "riscv32")]
use riscv_rt::entry;

/// Elements of a band.
const BAND: usize = 20 * 1024 / 2;

static MEMORY: ConstStaticCell<Reserved<Unorm16, { 4 * 64 * 64 }, 256, { 17 * 66 }, BAND>> =
    ConstStaticCell::new(Reserved::new(Unorm16(0)));

#[entry]
fn main() -> ! {
    stack::paint();
    start_counter();
    println!("case {} compact lit", LARGE.name);
    let memory = MEMORY.take();
    let (Ok(plan), Ok(pipeline)) = (LARGE.plan(), pipeline::<Compact, Phong<Compact>>(LARGE)) else {
        println!("error the scene is out of range");
        finish(false)
    };
    let [_, base_height] = plan.base();
    let [width, height, _] = plan.dims();
    // As many rows as fit.
    let one = Needs::of_band::<PipelineOf<'_, Compact, Phong<Compact>>>(&plan, 1).image;
    let rows = (BAND / one) as u32;
    let mut sum = Sum::new();
    let (mut first, mut bands, mut total) = (0, 0, 0u64);
    while first < base_height {
        let end = (first + rows).min(base_height);
        let Ok(mut stream) = Stream::band(plan, &pipeline, memory.lend(), first..end) else {
            println!("error too little memory for rows {first} to {end}");
            finish(false)
        };
        for slice in LARGE.voxels.chunks_exact((width * height) as usize) {
            let before = ticks();
            let pushed = stream.push(slice);
            total += u64::from(ticks_between(before, ticks()));
            if pushed.is_err() {
                println!("error slice refused");
            }
        }
        image::add_rows(&mut sum, stream.image());
        (first, bands) = (end, bands + 1);
    }
    println!("bands {bands} of {rows} rows");
    println!("instructions {}", total * instructions_a_tick());
    println!("image {:08x}", sum.get());
    println!("stack {}", stack::high_water());
    finish(sum.get() == LARGE_COMPACT_LIT)
}
