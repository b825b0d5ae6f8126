//! Streams every scene, lit and unlit, in the three precisions, and prints the sums of every stage boundary of every
//! plane, of the image and of the viewer's picture.
#![no_std]
#![no_main]

use semihosting::println;
use slicecast::composite::Unorm16;
use slicecast::precision::{Compact, Paper, Wide};
use slicecast::shade::{Phong, Unlit};
use slicecast_firmware::boundaries::show_points;
use slicecast_firmware::machine::finish;
use slicecast_firmware::memory::{Reserved, with_image};
use slicecast_firmware::scenes::{EXPECTED, SCENES};
use slicecast_firmware::stack;
use slicecast_firmware_shared::angles;
use static_cell::ConstStaticCell;

#[cfg(target_arch = "arm")]
use cortex_m_rt::entry;
#[cfg(target_arch = "riscv32")]
use riscv_rt::entry;

/// Voxels of a slice of the largest scene.
const SLICE: usize = 64 * 64;
/// Pixels of the largest base plane.
const PIXELS: usize = 128 * 128;

static NARROW: ConstStaticCell<Reserved<Unorm16, { 4 * SLICE }, 256, { 17 * 66 }, { 4 * PIXELS }>> =
    ConstStaticCell::new(Reserved::new(Unorm16(0)));
static PAPER: ConstStaticCell<[u16; 4 * PIXELS]> = ConstStaticCell::new([0; 4 * PIXELS]);
static BROAD: ConstStaticCell<Reserved<u32, 0, 0, 0, { 4 * PIXELS }>> = ConstStaticCell::new(Reserved::new(0));

#[entry]
fn main() -> ! {
    stack::paint();
    let narrow = NARROW.take();
    let paper = PAPER.take();
    let broad = BROAD.take().lend().image;
    let mut passed = true;
    for (scene, expected) in SCENES.iter().zip(&EXPECTED) {
        let mut images = [0; 6];
        let [pu, pl, cu, cl, wu, wl] = &mut images;
        *pu = show_points::<Paper, Unlit>(scene, with_image(narrow.lend(), paper));
        *pl = show_points::<Paper, Phong<Paper>>(scene, with_image(narrow.lend(), paper));
        *cu = show_points::<Compact, Unlit>(scene, narrow.lend());
        *cl = show_points::<Compact, Phong<Compact>>(scene, narrow.lend());
        *wu = show_points::<Wide, Unlit>(scene, with_image(narrow.lend(), broad));
        *wl = show_points::<Wide, Phong<Wide>>(scene, with_image(narrow.lend(), broad));
        passed &= images == *expected;
    }
    println!("angles {:08x}", angles::sum());
    println!("stack {}", stack::high_water());
    finish(passed)
}
