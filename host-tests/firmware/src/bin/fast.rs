//! 16-bit lanes: the dense scene and the head in `fast` beside `compact`, unlit and lit. Prints the sums of the images and what the frames cost.
#![no_std]
#![no_main]

use semihosting::println;
use slicecast::composite::{FrontToBack, Unorm16};
use slicecast::fast::table::{fill_colours, fill_roots};
use slicecast::fast::{Colours, RootTable, Roots};
use slicecast::plane::{Fast, Pipeline};
use slicecast::precision::Compact;
use slicecast::shade::{Phong, Unlit};
use slicecast::slice::Code12;
use slicecast::stream::Memory;
use slicecast::table::ENTRIES;
use slicecast_firmware::frame::streamed;
use slicecast_firmware::machine::{finish, start_counter};
use slicecast_firmware::memory::{Reserved, with_image};
use slicecast_firmware::scenes::{COSTED, FAST_EXPECTED};
use slicecast_firmware::stack;
use slicecast_firmware_shared::scene::{Lights, Model, SceneData, pipeline};
use static_cell::ConstStaticCell;

#[cfg(target_arch = "arm")]
use cortex_m_rt::entry;
#[cfg(target_arch = "riscv32")]
use riscv_rt::entry;

/// Pixels of the largest base plane.
const PIXELS: usize = 128 * 128;

/// Rows of scratch memory of `compact`, lit.
const SCRATCH: usize = 16 * 66;

static WORDS: ConstStaticCell<Reserved<Unorm16, { 4 * 64 * 64 }, 256, SCRATCH, { 4 * PIXELS }>> =
    ConstStaticCell::new(Reserved::new(Unorm16(0)));
static HALVES: ConstStaticCell<Reserved<u16, 0, 0, 0, { 4 * PIXELS }>> = ConstStaticCell::new(Reserved::new(0));
static ROOTS: ConstStaticCell<Roots> = ConstStaticCell::new([0; ENTRIES]);
static COLOURS: ConstStaticCell<Colours> = ConstStaticCell::new([[0; 4]; ENTRIES + 1]);

#[entry]
fn main() -> ! {
    stack::paint();
    start_counter();
    let words = WORDS.take();
    let halves = HALVES.take().lend().image;
    let (roots, colours) = (ROOTS.take(), COLOURS.take());
    let mut found = [[0; 2]; 2];
    for (scene, found) in COSTED.into_iter().zip(&mut found) {
        let points = Compact::table(scene);
        fill_roots(&points, roots);
        let one = fill_colours(&points, colours);
        let table = RootTable::new(&*roots, one.ok_or(&*colours));

        compact::<Unlit>(scene, words.lend());
        let unlit = &Fast::<_, _, _, FrontToBack>::new(table, Unlit);
        let unlit = fast(scene, "unlit", unlit, with_image(words.lend(), halves));
        compact::<Phong<Compact>>(scene, words.lend());
        let lit = match scene.lighting.fast() {
            Ok(phong) => {
                let lit = &Fast::<_, _, _, FrontToBack>::new(table, phong);
                fast(scene, "lit", lit, with_image(words.lend(), halves))
            }
            Err(_) => 0,
        };
        *found = [unlit, lit];
    }
    println!("stack {}", stack::high_water());
    finish(found == FAST_EXPECTED)
}

/// A frame in 32-bit lanes.
#[inline(never)]
fn compact<S: Lights<Compact>>(scene: &SceneData, memory: Memory<'_, Unorm16>) {
    println!("case {} compact {}", scene.name, S::NAME);
    let (Ok(plan), Ok(pipeline)) = (scene.plan(), pipeline::<Compact, S>(scene)) else {
        println!("error the scene is out of range");
        return;
    };
    streamed(scene, plan, &pipeline, memory);
}

/// The same in 16-bit lanes; the sum of its image.
#[inline(never)]
fn fast<L: Pipeline<Voxel = Code12, Element = u16>>(
    scene: &SceneData,
    name: &str,
    pipeline: &L,
    memory: Memory<'_, u16>,
) -> u32 {
    println!("case {} fast {}", scene.name, name);
    let Ok(plan) = scene.plan() else {
        println!("error the scene is out of range");
        return 0;
    };
    streamed(scene, plan, pipeline, memory)
}
