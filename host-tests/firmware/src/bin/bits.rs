//! Streams every scene, lit and unlit, in the three precisions, and prints the sums of every stage boundary of every
//! plane, of the image and of the viewer's picture.
#![no_std]
#![no_main]

use semihosting::println;
use slicecast::composite::Unorm16;
use slicecast::format::Intensity;
use slicecast::plane::ChannelOf;
use slicecast::precision::{Compact, Paper, Wide};
use slicecast::shade::{Phong, Unlit};
use slicecast::stream::{Memory, Stream};
use slicecast_firmware::machine::finish;
use slicecast_firmware::memory::{Reserved, with_image};
use slicecast_firmware::scenes::{EXPECTED, SCENES};
use slicecast_firmware::stack;
use slicecast_firmware_shared::boundary::Boundaries;
use slicecast_firmware_shared::scene::{Lights, Model, SceneData, pipeline};
use slicecast_firmware_shared::sum::Sum;
use slicecast_firmware_shared::{angles, image};
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
        *pu = run::<Paper, Unlit>(scene, with_image(narrow.lend(), paper));
        *pl = run::<Paper, Phong<Paper>>(scene, with_image(narrow.lend(), paper));
        *cu = run::<Compact, Unlit>(scene, narrow.lend());
        *cl = run::<Compact, Phong<Compact>>(scene, narrow.lend());
        *wu = run::<Wide, Unlit>(scene, with_image(narrow.lend(), broad));
        *wl = run::<Wide, Phong<Wide>>(scene, with_image(narrow.lend(), broad));
        passed &= images == *expected;
    }
    println!("angles {:08x}", angles::sum());
    println!("stack {}", stack::high_water());
    finish(passed)
}

/// Renders a scene and returns the sum of its image; 0 if it cannot.
#[inline(never)]
fn run<P: Model, S: Lights<P>>(scene: &SceneData, memory: Memory<'_, ChannelOf<P>>) -> u32 {
    println!("case {} {} {}", scene.name, P::NAME, S::NAME);
    let (plan, pipeline) = match (scene.plan(), pipeline::<P, S>(scene)) {
        (Ok(plan), Ok(pipeline)) => (plan, pipeline),
        (Err(error), _) | (_, Err(error)) => {
            println!("error {error:?}");
            return 0;
        }
    };
    let mut stream = match Stream::new(plan, &pipeline, memory) {
        Ok(stream) => stream,
        Err(error) => {
            println!("error {error}");
            return 0;
        }
    };
    let mut tap = Boundaries::new(|plane| {
        let [a, b, c, d, e, f, g, h, i] = plane.sums;
        println!(
            "plane {} {} {} {a:08x} {b:08x} {c:08x} {d:08x} {e:08x} {f:08x} {g:08x} {h:08x} {i:08x}",
            plane.index, plane.phase.u, plane.phase.v
        );
    });
    let [width, height, _] = plan.dims();
    for slice in scene.voxels.chunks_exact((width * height) as usize) {
        if let Err(error) = stream.push_tapped(slice, &mut tap) {
            println!("error {error}");
        }
    }
    tap.finish();
    let mut sum = Sum::new();
    image::add_rows(&mut sum, stream.image());
    println!("image {:08x}", sum.get());
    let picture = image::picture(&stream, scene.picture, &scene.warp(), [Intensity::ZERO; 3]);
    println!("picture {picture:08x}");
    sum.get()
}
