//! The scene of core's example is what `slicecast export --scene headsq --rays 1 --planes 1 --format rust --name head` writes.

use std::path::Path;

use slicecast_engine::frame::Prepared;
use slicecast_export::{Format, files};
use slicecast_scene::Sampling;
use slicecast_scene::file::built_in;
use slicecast_volume::mapping::Window;
use slicecast_volume::open::load;

/// `SLICECAST_WRITE_HEAD=1 cargo test -p slicecast-export --test head` writes it anew.
#[test]
fn the_examples_scene_is_fresh() {
    let volume = load(None, Window::Auto).unwrap().volume;
    let mut scene = built_in("headsq").unwrap();
    scene.sampling = Sampling::default();
    let prepared = Prepared::new(&scene, &volume).unwrap();
    let files = files(&prepared, Format::Rust, "head", false).unwrap();
    let [(name, text)] = &files[..] else {
        panic!("{} files", files.len());
    };
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../core/examples/exported")
        .join(name);
    if std::env::var_os("SLICECAST_WRITE_HEAD").is_some() {
        std::fs::write(&path, text).unwrap();
    }
    let committed = std::fs::read_to_string(&path).unwrap();
    assert!(
        committed == *text,
        "{} is stale; SLICECAST_WRITE_HEAD=1 writes it",
        path.display()
    );
}
