//! The scene that core's example and the README show: what is compiled, what the README prints, and whose bits it has.

use std::fs;
use std::path::Path;

use slicecast::stream::Stream;
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::oriented::{Turned, packed};
use slicecast_engine::rendering::in_memory_order;
use slicecast_scene::Sampling;
use slicecast_scene::file::built_in;
use slicecast_volume::mapping::Window;
use slicecast_volume::open::load;

#[path = "../../core/examples/exported/head.rs"]
mod head;

#[test]
fn the_exported_head_has_the_engines_bits() {
    let volume = load(None, Window::Auto).unwrap().volume;
    let mut scene = built_in("headsq").unwrap();
    scene.sampling = Sampling::default();
    let prepared = Prepared::new(&scene, &volume).unwrap();
    let frame = prepared.render(Layer::Tiles(32), &|_, _| ()).unwrap();

    let mut memory = Box::new(head::memory());
    let mut stream: Stream<'_, head::Pipeline> = head::stream(&mut memory).unwrap();
    let mut turned = Turned::new(&volume, &head::PLAN);
    let slices = turned.slices().unwrap();
    while let Some(number) = stream.wanted() {
        stream.push(&packed(&slices[number as usize])).unwrap();
    }
    let image: Vec<u32> = stream.image().iter().map(|channel| channel.0.into()).collect();
    assert!(image == in_memory_order(&frame.base, 1).collect::<Vec<_>>());
    let [columns, rows] = head::PICTURE;
    let pixels = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
    let picture: Vec<u8> = pixels.flat_map(|(x, y)| head::pixel(&stream, x, y)).collect();
    assert!(picture == frame.picture.bytes);
}

/// The README's code is the example's, which is compiled, RAM figure and all.
#[test]
fn the_readme_shows_the_example() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let read = |path: &str| fs::read_to_string(root.join(path)).unwrap();
    let (readme, example) = (read("README.md"), read("core/examples/exported/main.rs"));
    let shown = readme.split("```rust\n").nth(1).unwrap().split("```").next().unwrap();
    assert!(
        shown.lines().count() > 20 && example.contains(shown),
        "README.md shows what is not in the example"
    );
    assert!(readme.contains("151,096 bytes"));
}
