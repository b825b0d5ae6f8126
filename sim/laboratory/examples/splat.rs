//! Splatting in numbers: error against the f64 model, the bits that records need, and error and time beside rays.
//!
//! `cargo run --release -p slicecast-laboratory --example splat [VOLUME SCENE]...`; times also of these volumes.

#[path = "splat/perspective.rs"]
mod perspective;

use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

use slicecast::splat::Layout;
use slicecast_compare::image::{ImageFigures, model_figures, picture_figures};
use slicecast_compare::splat::{compare, model};
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::oriented::{Oriented, Turned};
use slicecast_engine::splat::{BAND_ROWS, Splatted};
use slicecast_engine::tile::TILE_ROWS;
use slicecast_model::splat::Rounding;
use slicecast_model::{Affine, Model};
use slicecast_scene::file::built_in;
use slicecast_scene::{Classification, PrecisionName, Scene};
use slicecast_volume::Volume;
use slicecast_volume::mapping::Window;
use slicecast_volume::open::load;

/// Samples of a built-in scene.
fn scene_of(name: &str) -> Result<Scene, Box<dyn Error>> {
    let mut scene = built_in(name)?;
    scene.classification = Classification::Point;
    scene.sampling.planes_per_voxel = 1;
    scene.sampling.rays_per_voxel = 1;
    Ok(scene)
}

const SCENES: [&str; 3] = ["headsq", "ct-fog", "ct-bone"];

fn main() -> Result<(), Box<dyn Error>> {
    let head = load(None, Window::Auto)?.volume;
    errors(&head)?;
    bits(&head)?;
    converged(&head)?;
    perspective::errors(&head)?;
    perspective::bits(&head)?;
    perspective::converged(&head)?;
    println!("\n## Time of a frame, `compact`, one thread, shortest of {FRAMES}, milliseconds\n");
    println!(
        "| volume, scene | rays | splatted | of that blocks and bins | sheets | voxels, millions | records, millions | speed |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for name in SCENES {
        times("built-in head", name, &head)?;
    }
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    for pair in arguments.chunks_exact(2) {
        let volume = load(Some(pair[0].as_ref()), Window::Auto)?.volume;
        times(&volume.name, &pair[1], &volume)?;
    }
    Ok(())
}

fn errors(head: &Volume) -> Result<(), Box<dyn Error>> {
    println!("## Images against f64 of the same sheets at exact places, built-in head\n");
    println!("| scene | record | precision | equal bytes, % | mean | largest, steps of 255 |");
    println!("|---|---|---|---|---|---|");
    for name in SCENES {
        for (record, layout) in [("fine", Layout::FINE), ("paper", Layout::PAPER)] {
            for precision in PrecisionName::STAGED {
                let mut scene = scene_of(name)?;
                scene.precision = precision;
                let splatted = Splatted::new(&scene, head, layout)?;
                let found = compare(&scene, head, &splatted, &|_, _| ())?.image;
                println!(
                    "| {name} | {record} | {} | {:.2} | {:.4} | {:.3} |",
                    precision.name(),
                    found.equal_percent,
                    found.mean_lsb8,
                    found.max_lsb8
                );
            }
        }
    }
    Ok(())
}

/// Squeeze, section 4.6.1: 13 bits of x and y, 8 of u and 8 of v.
fn bits(head: &Volume) -> Result<(), Box<dyn Error>> {
    println!("\n## Bits of a record: f64 throughout, one part rounded; mean and largest error, steps of 255\n");
    println!("| part, bits | headsq | ct-fog | ct-bone |");
    println!("|---|---|---|---|");
    let scenes = [scene_of(SCENES[0])?, scene_of(SCENES[1])?, scene_of(SCENES[2])?];
    let splatted: Vec<_> = (scenes.iter())
        .map(|scene| Splatted::new(scene, head, Layout::FINE))
        .collect::<Result<_, _>>()?;
    let of = |rounding| -> Vec<_> {
        (scenes.iter().zip(&splatted))
            .map(|(scene, splatted)| model(scene, head, splatted, rounding))
            .collect()
    };
    let exact = of(Rounding::default());
    let line = |what: String, rounding| {
        let found: Vec<String> = (of(rounding).iter().zip(&exact))
            .map(|(rounded, exact)| {
                let ImageFigures {
                    mean_lsb8, max_lsb8, ..
                } = model_figures(rounded, exact);
                format!("{mean_lsb8:.4}, {max_lsb8:.3}")
            })
            .collect();
        println!("| {what} | {} |", found.join(" | "));
    };
    for bits in [2, 4, 6, 7, 8, 9, 10, 11, 12, 13] {
        let position = Some(bits);
        let rounding = Rounding {
            position,
            ..Rounding::default()
        };
        line(format!("x and y, {bits} of the fraction"), rounding);
    }
    for bits in [2, 4, 6, 8, 10] {
        let depth = Some(bits);
        let rounding = Rounding {
            depth,
            ..Rounding::default()
        };
        line(format!("u, {bits}"), rounding);
    }
    for bits in [6, 8, 10, 12] {
        let value = Some(bits);
        let rounding = Rounding {
            value,
            ..Rounding::default()
        };
        line(format!("v, {bits}"), rounding);
    }
    for (what, layout) in [("paper: 13, 8, 8", Layout::PAPER), ("fine: 11, 8, 12", Layout::FINE)] {
        let rounding = Rounding {
            position: Some(layout.position_bits()),
            depth: Some(layout.depth_bits()),
            value: Some(layout.value_bits()),
        };
        line(what.into(), rounding);
    }
    Ok(())
}

/// Rays per voxel of the converged integral, so that its own picture is sharp.
const REFERENCE: u32 = 3;

/// Pictures of rays and of sheets against the converged integral, both in pixels of their own.
fn converged(head: &Volume) -> Result<(), Box<dyn Error>> {
    println!("\n## Pictures against the converged integral, built-in head, `wide`, 8-bit values of the natural size\n");
    println!("| scene | planes per voxel | rays: mean | largest | dB | splatted: mean | largest | dB |");
    println!("|---|---|---|---|---|---|---|---|");
    for name in SCENES {
        for planes in [1, 2, 4] {
            let mut scene = scene_of(name)?;
            scene.precision = PrecisionName::Wide;
            scene.sampling.planes_per_voxel = planes;
            let prepared = Prepared::new(&scene, head)?;
            let mut fine = scene.clone();
            fine.image.size = Some(prepared.setup.picture.size);
            fine.sampling.rays_per_voxel = REFERENCE;
            let reference = Prepared::new(&fine, head)?;
            let integral = Model::natural(&fine, head).render_integral();
            let [origin, right, down] = reference.setup.picture.affine;
            let along = |axis: usize| [origin[axis], right[axis], down[axis]];
            let map = Affine {
                u: along(0),
                v: along(1),
            };
            let wanted = integral.warp(fine.image.size.unwrap_or_default().map(|side| side as usize), map);
            let rays = prepared.render(Layer::Tiles(TILE_ROWS), &|_, _| ())?.picture;
            let sheets = Splatted::new(&scene, head, Layout::FINE)?.render(&|_, _| ())?.picture;
            let said = [rays, sheets].map(|picture| {
                let found = picture_figures(&picture, &wanted, scene.image.background);
                let db = found.psnr_db.unwrap_or(f64::INFINITY);
                format!("{:.3} | {:.0} | {db:.1}", found.mean_lsb8, found.max_lsb8)
            });
            println!("| {name} | {planes} | {} |", said.join(" | "));
        }
    }
    Ok(())
}

/// Frames of each.
const FRAMES: usize = 5;

fn times(volume_name: &str, name: &str, volume: &Volume) -> Result<(), Box<dyn Error>> {
    let scene = scene_of(name)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let prepared = Prepared::new(&scene, volume)?;
    let splatted = Splatted::new(&scene, volume, Layout::FINE)?;
    let mut turned = Turned::new(volume, &prepared.setup.plan);
    let slices = turned.slices()?;
    let oriented = Oriented::of(&slices);
    let (mut rays, mut bins, mut sheets) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
    let mut count = 0;
    pool.install(|| -> Result<(), Box<dyn Error + Send + Sync>> {
        for _ in 0..FRAMES {
            let start = Instant::now();
            black_box(prepared.render_oriented(&oriented, Layer::Tiles(TILE_ROWS), &|_, _| ())?);
            rays = rays.min(start.elapsed().as_secs_f64());
            let start = Instant::now();
            let records = splatted.records(true, BAND_ROWS)?;
            bins = bins.min(start.elapsed().as_secs_f64());
            let start = Instant::now();
            black_box(splatted.frame(splatted.image(&records, &|_, _| ())?));
            sheets = sheets.min(start.elapsed().as_secs_f64());
            count = records.count();
        }
        Ok(())
    })
    .map_err(|error| error.to_string())?;
    println!(
        "| {volume_name}, {name} | {:.1} | {:.1} | {:.1} | {:.1} | {:.2} | {:.2} | {:.3} |",
        1e3 * rays,
        1e3 * (bins + sheets),
        1e3 * bins,
        1e3 * sheets,
        volume.voxels.len() as f64 / 1e6,
        count as f64 / 1e6,
        rays / (bins + sheets)
    );
    Ok(())
}
