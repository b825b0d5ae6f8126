//! A scene streamed under a tap that prints the sums of every stage boundary.

use semihosting::println;
use slicecast::classify::Classifier;
use slicecast::composite::{ChannelFormat, FrontToBack, Recurrence};
use slicecast::format::Intensity;
use slicecast::plane::{ChannelOf, Composite};
use slicecast::precision::Precision;
use slicecast::stream::{Memory, Stream};
use slicecast_firmware_shared::boundary::Boundaries;
use slicecast_firmware_shared::image;
use slicecast_firmware_shared::scene::{Lights, Model, SceneData, pipeline};
use slicecast_firmware_shared::sum::Sum;

/// Renders a scene with its point table and returns the sum of its image; 0 if it cannot.
#[inline(never)]
pub fn show_points<P: Model, S: Lights<P>>(scene: &SceneData, memory: Memory<'_, ChannelOf<P>>) -> u32 {
    println!("case {} {} {}", scene.name, P::NAME, S::NAME);
    match pipeline::<P, S>(scene) {
        Ok(pipeline) => show(scene, &pipeline, memory),
        Err(error) => {
            println!("error {error:?}");
            0
        }
    }
}

/// Renders a scene with a pipeline, prints what it makes, and returns the sum of its image; 0 if it cannot.
pub fn show<P, C, S>(
    scene: &SceneData,
    pipeline: &Composite<P, C, S, FrontToBack>,
    memory: Memory<'_, ChannelOf<P>>,
) -> u32
where
    P: Precision<Pixel: Recurrence<Channel: ChannelFormat>>,
    C: Classifier<P>,
    S: Lights<P>,
{
    let plan = match scene.plan() {
        Ok(plan) => plan,
        Err(error) => {
            println!("error {error:?}");
            return 0;
        }
    };
    let mut stream = match Stream::new(plan, pipeline, memory) {
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
