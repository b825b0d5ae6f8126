//! The four precisions side by side: base planes against the f64 model at the pipeline's positions.
//!
//! `cargo run --release -p slicecast-laboratory --example accuracy`

use std::error::Error;

use slicecast_compare::{ModelPositions, compare};
use slicecast_engine::frame::Prepared;
use slicecast_laboratory::hard::fast::signal;
use slicecast_scene::file::built_in;
use slicecast_scene::{PrecisionName, Scene};
use slicecast_volume::Volume;
use slicecast_volume::mapping::Window;
use slicecast_volume::open::load;

fn main() -> Result<(), Box<dyn Error>> {
    println!("Equal 8-bit values, largest and mean difference in steps of 1/255\n");
    println!("| volume and scene | `fast` | `paper` | `compact` | `wide` |");
    println!("|---|---|---|---|---|");
    let head = load(None, Window::Auto)?.volume;
    for name in ["headsq", "ct-bone", "ct-fog", "ct-fog8"] {
        row(&format!("built-in head, {name}"), &head, &built_in(name)?)?;
    }
    for planes in [2, 8] {
        let (volume, scene) = signal(41, planes);
        row(
            &format!("Marschner-Lobb 41\u{b3}, {planes} planes per voxel"),
            &volume,
            &scene,
        )?;
    }
    Ok(())
}

fn row(name: &str, volume: &Volume, scene: &Scene) -> Result<(), Box<dyn Error>> {
    print!("| {name} |");
    for precision in PrecisionName::ALL {
        let scene = Scene {
            precision,
            ..scene.clone()
        };
        let prepared = Prepared::new(&scene, volume)?;
        let found = compare(&prepared, ModelPositions::Pipeline, &|_, _| ())?.image;
        let (equal, largest, mean) = (found.equal_percent, found.max_lsb8, found.mean_lsb8);
        print!(" {equal:.2} %, {largest:.3}, {mean:.4} |");
    }
    println!();
    Ok(())
}
