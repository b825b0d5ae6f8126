//! Instructions of every stage: a tap that reads the counter at the stage boundaries, and the same pipeline in f32.
#![no_std]
#![no_main]

use semihosting::println;
use slicecast::composite::Unorm16;
use slicecast::locate::Plane;
use slicecast::plane::ChannelOf;
use slicecast::precision::{Compact, Paper, Wide};
use slicecast::shade::{Phong, Unlit};
use slicecast::stage::Stage;
use slicecast::stream::{Memory, Stream};
use slicecast::tap::{Beam, Bits, Tap};
use slicecast_firmware::float::{self, Buffers};
use slicecast_firmware::machine::{finish, instructions_a_tick, start_counter, ticks, ticks_between};
use slicecast_firmware::memory::{Reserved, with_image};
use slicecast_firmware::scenes::COSTED;
use slicecast_firmware_shared::scene::{Lights, Model, SceneData, pipeline};
use static_cell::ConstStaticCell;

#[cfg(target_arch = "arm")]
use cortex_m_rt::entry;
#[cfg(target_arch = "riscv32")]
use riscv_rt::entry;

static NARROW: ConstStaticCell<Reserved<Unorm16, { 4 * 64 * 64 }, 256, { 17 * 66 }, { 4 * 128 * 128 }>> =
    ConstStaticCell::new(Reserved::new(Unorm16(0)));
static PAPER: ConstStaticCell<[u16; 4 * 128 * 128]> = ConstStaticCell::new([0; 4 * 128 * 128]);
static BROAD: ConstStaticCell<Reserved<u32, 0, 0, 0, { 4 * 128 * 128 }>> = ConstStaticCell::new(Reserved::new(0));
static FLOAT: ConstStaticCell<Buffers> = ConstStaticCell::new(Buffers::new());

#[entry]
fn main() -> ! {
    start_counter();
    let narrow = NARROW.take();
    let paper = PAPER.take();
    let broad = BROAD.take().lend().image;
    let buffers = FLOAT.take();
    let mut passed = true;
    for scene in COSTED {
        run::<Paper, Unlit>(scene, with_image(narrow.lend(), paper));
        run::<Paper, Phong<Paper>>(scene, with_image(narrow.lend(), paper));
        run::<Compact, Unlit>(scene, narrow.lend());
        run::<Compact, Phong<Compact>>(scene, narrow.lend());
        run::<Wide, Unlit>(scene, with_image(narrow.lend(), broad));
        passed &= run_float(scene, false, buffers, broad);
        run::<Wide, Phong<Wide>>(scene, with_image(narrow.lend(), broad));
        passed &= run_float(scene, true, buffers, broad);
    }
    finish(passed)
}

/// The f32 pipeline; whether its picture is that of `Wide`, which was rendered just before, within an 8-bit step.
fn run_float(scene: &SceneData, lit: bool, buffers: &mut Buffers, wide: &[u32]) -> bool {
    println!("case {} f32 {}", scene.name, if lit { "lit" } else { "unlit" });
    let mut clock = Clock::new();
    let rendered = float::render(scene, lit, buffers, &mut |stage| clock.mark(stage));
    clock.report();
    let difference = scene
        .plan()
        .map_or(1.0, |plan| float::largest_difference(&plan, buffers, wide));
    println!(
        "f32 differs from wide by at most {} millionths",
        (difference * 1e6) as u32
    );
    rendered && difference < 1.0 / 255.0
}

#[inline(never)]
fn run<P: Model, S: Lights<P>>(scene: &SceneData, memory: Memory<'_, ChannelOf<P>>) {
    println!("case {} {} {}", scene.name, P::NAME, S::NAME);
    let (Ok(plan), Ok(pipeline)) = (scene.plan(), pipeline::<P, S>(scene)) else {
        println!("error the scene is out of range");
        return;
    };
    let Ok(mut stream) = Stream::new(plan, &pipeline, memory) else {
        println!("error too little memory");
        return;
    };
    let [width, height, _] = plan.dims();
    let mut clock = Clock::new();
    for slice in scene.voxels.chunks_exact((width * height) as usize) {
        if stream.push_tapped(slice, &mut clock).is_err() {
            println!("error slice refused");
        }
    }
    clock.mark(Stage::Location);
    clock.report();
}

/// Charges the time since the last boundary to the stage that ends at this one; location is what lies between planes.
struct Clock {
    last: u32,
    stages: [u64; Stage::ALL.len()],
}

impl Clock {
    fn new() -> Self {
        Self {
            last: ticks(),
            stages: [0; Stage::ALL.len()],
        }
    }

    #[inline(always)]
    fn mark(&mut self, stage: Stage) {
        let now = ticks();
        if let Some(sum) = self.stages.get_mut(stage as usize) {
            *sum += u64::from(ticks_between(self.last, now));
        }
        // Read again: the bookkeeping belongs to no stage.
        self.last = ticks();
    }

    fn report(&self) {
        let tick = instructions_a_tick();
        for (stage, count) in Stage::ALL.iter().zip(self.stages) {
            println!("stage {} {}", count * tick, stage.name());
        }
    }
}

impl Tap for Clock {
    fn plane(&mut self, _: &Plane) {
        self.mark(Stage::Location);
    }
    fn row(&mut self, stage: Stage, _: Beam<'_>, _: &[&dyn Bits]) {
        self.mark(stage);
    }
}
