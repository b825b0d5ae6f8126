//! One pipeline alone in a program: what it takes in flash, RAM, stack and instructions.

use semihosting::println;
use slicecast::composite::Channel;
use slicecast::plan::Plan;
use slicecast::plane::{ChannelOf, Pipeline};
use slicecast::slice::Code12;
use slicecast::stream::{Memory, Needs, Stream};
use slicecast_firmware_shared::image;
use slicecast_firmware_shared::scene::{Lights, Model, SceneData, pipeline};
use slicecast_firmware_shared::sum::Sum;

use crate::machine::{instructions_a_tick, start_counter, ticks, ticks_between};

/// Streams the scene and prints the memory lent, the instructions and the image's sum. Returns the sum, 0 for none.
pub fn measure<P: Model, S: Lights<P>>(scene: &SceneData, memory: Memory<'_, ChannelOf<P>>) -> u32 {
    println!("case {} {} {}", scene.name, P::NAME, S::NAME);
    let (Ok(plan), Ok(pipeline)) = (scene.plan(), pipeline::<P, S>(scene)) else {
        println!("error the scene is out of range");
        return 0;
    };
    start_counter();
    streamed(scene, plan, &pipeline, memory)
}

/// Streams a scene's voxels under a plan; prints the memory lent, the instructions and the image's sum. Returns the sum, 0 for none.
#[inline(always)]
pub fn streamed<L: Pipeline<Voxel = Code12, Element: Channel>>(
    scene: &SceneData,
    plan: Plan,
    pipeline: &L,
    memory: Memory<'_, L::Element>,
) -> u32 {
    let [slices, ranges, scratch, image] = Needs::of::<L>(&plan).bytes();
    println!("memory {slices} {ranges} {scratch} {image}");
    let Ok(mut stream) = Stream::new(plan, pipeline, memory) else {
        println!("error too little memory");
        return 0;
    };
    let [width, height, _] = plan.dims();
    let tick = instructions_a_tick();
    let mut total = 0u64;
    for slice in scene.voxels.chunks_exact((width * height) as usize) {
        let before = ticks();
        let pushed = stream.push(slice);
        total += u64::from(ticks_between(before, ticks()));
        if pushed.is_err() {
            println!("error slice refused");
        }
    }
    println!("instructions {}", total * tick);
    let mut sum = Sum::new();
    image::add_rows(&mut sum, stream.image());
    println!("image {:08x}", sum.get());
    sum.get()
}

/// The program of one pipeline: precision, shader, and a channel of its image that is 0.
#[macro_export]
macro_rules! frame_program {
    ($precision:ty, $shader:ty, $zero:expr) => {
        use slicecast::plane::{ChannelOf, Pipeline};
        use slicecast_firmware::memory::Reserved;
        use slicecast_firmware::{frame, machine, scenes, stack};
        use slicecast_firmware_shared::scene::PipelineOf;

        #[cfg(target_arch = "arm")]
        use cortex_m_rt::entry;
        #[cfg(target_arch = "riscv32")]
        use riscv_rt::entry;

        type Frame = PipelineOf<'static, $precision, $shader>;
        const SLICES: usize = <Frame as Pipeline>::SLICES;
        const WORDS: usize = <Frame as Pipeline>::SCRATCH.len(64);
        type Lent =
            Reserved<ChannelOf<$precision>, { SLICES * 64 * 64 }, { SLICES * 64 }, { WORDS }, { 4 * 128 * 128 }>;

        static MEMORY: static_cell::ConstStaticCell<Lent> = static_cell::ConstStaticCell::new(Reserved::new($zero));

        #[entry]
        fn main() -> ! {
            stack::paint();
            let memory = MEMORY.take();
            let mut passed = true;
            for scene in scenes::COSTED {
                passed &= frame::measure::<$precision, $shader>(scene, memory.lend()) != 0;
            }
            semihosting::println!("stack {}", stack::high_water());
            machine::finish(passed)
        }
    };
}
