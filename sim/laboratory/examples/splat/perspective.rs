//! The same from an eye: outside, and in the middle of the skull.

use std::error::Error;

use slicecast::splat::Layout;
use slicecast_compare::image::{model_figures, picture_figures};
use slicecast_compare::perspective::compare as compare_rays;
use slicecast_compare::splat::{compare, model};
use slicecast_engine::frame::Layer;
use slicecast_engine::perspective::InPerspective;
use slicecast_engine::splat::Splatted;
use slicecast_engine::tile::TILE_ROWS;
use slicecast_model::splat::Rounding;
use slicecast_scene::clip::ClipUnit;
use slicecast_scene::perspective::{Eye, Perspective};
use slicecast_scene::{Borders, PrecisionName, Scene};
use slicecast_volume::Volume;

use super::{SCENES, scene_of};

/// A field of view and where its eye is.
const EYES: [(&str, f64, Option<[f64; 3]>); 2] = [("outside", 60.0, None), ("within", 90.0, Some([31.3, 28.6, 34.2]))];

/// A built-in scene in perspective.
fn seen(name: &str, (_, fov, eye): (&str, f64, Option<[f64; 3]>)) -> Result<Scene, Box<dyn Error>> {
    let mut scene = scene_of(name)?;
    let unit = ClipUnit::Voxels;
    scene.borders = Borders::Whole;
    scene.perspective = Some(Perspective {
        fov,
        eye: eye.map(|at| Eye { at, unit }),
    });
    scene.image.size = Some([256; 2]);
    Ok(scene)
}

pub fn errors(head: &Volume) -> Result<(), Box<dyn Error>> {
    println!("\n## Perspective: images of 256 x 256 against f64 of the same sheets at exact places, built-in head\n");
    println!("| scene | eye | record | precision | equal bytes, % | mean | largest, steps of 255 |");
    println!("|---|---|---|---|---|---|---|");
    for (name, eye) in SCENES.iter().flat_map(|name| EYES.map(|eye| (name, eye))) {
        for (record, layout) in [("fine", Layout::FINE), ("paper", Layout::PAPER)] {
            for precision in [PrecisionName::Compact, PrecisionName::Wide] {
                let mut scene = seen(name, eye)?;
                scene.precision = precision;
                let splatted = Splatted::new(&scene, head, layout)?;
                let found = compare(&scene, head, &splatted, &|_, _| ())?.image;
                println!(
                    "| {name} | {}, {} degrees | {record} | {} | {:.2} | {:.4} | {:.3} |",
                    eye.0,
                    eye.1,
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

/// Squeeze, section 4.6.1: one bit more of x and y than rays need, 13.
pub fn bits(head: &Volume) -> Result<(), Box<dyn Error>> {
    println!(
        "\n## Perspective: bits of x and y, f64 throughout, 256 x 256; mean and largest error, steps of 255, outside and within\n"
    );
    println!("| bits of the fraction | headsq, outside | within | ct-bone, outside | within |");
    println!("|---|---|---|---|---|");
    let mut scenes = Vec::new();
    for name in ["headsq", "ct-bone"] {
        for eye in EYES {
            scenes.push(seen(name, eye)?);
        }
    }
    let splatted: Vec<_> = (scenes.iter())
        .map(|scene| Splatted::new(scene, head, Layout::FINE))
        .collect::<Result<_, _>>()?;
    let of = |position| -> Vec<_> {
        let rounding = Rounding {
            position,
            ..Rounding::default()
        };
        (scenes.iter().zip(&splatted))
            .map(|(scene, splatted)| model(scene, head, splatted, rounding))
            .collect()
    };
    let exact = of(None);
    for bits in [0, 2, 4, 6, 8, 9, 10, 11, 12, 13] {
        let found: Vec<String> = (of(Some(bits)).iter().zip(&exact))
            .map(|(rounded, exact)| {
                let found = model_figures(rounded, exact);
                format!("{:.4}, {:.3}", found.mean_lsb8, found.max_lsb8)
            })
            .collect();
        println!("| {bits} | {} |", found.join(" | "));
    }
    Ok(())
}

/// Planes per voxel and rays per voxel of what is taken for the integral: samples of f64. There is no exact one in perspective.
const REFERENCE: (u32, u32) = (8, 2);

/// Pictures of rays and of sheets against the integral.
pub fn converged(head: &Volume) -> Result<(), Box<dyn Error>> {
    println!(
        "\n## Perspective: pictures of 256 x 256 against rays of f64, {} samples a voxel, built-in head, `wide`\n",
        REFERENCE.0
    );
    println!("| scene | eye | planes per voxel | rays: mean | largest | dB | splatted: mean | largest | dB |");
    println!("|---|---|---|---|---|---|---|---|---|");
    for (name, eye) in SCENES.iter().flat_map(|name| EYES.map(|eye| (name, eye))) {
        let mut scene = seen(name, eye)?;
        scene.precision = PrecisionName::Wide;
        let perspective = scene.perspective.ok_or("a scene in perspective")?;
        let mut fine = scene.clone();
        (fine.sampling.planes_per_voxel, fine.sampling.rays_per_voxel) = REFERENCE;
        let reference = InPerspective::new(&fine, &perspective, head)?;
        let wanted = compare_rays(&fine, head, &reference, &|_, _| ())?.model_picture;
        for planes in [1, 2, 4] {
            let mut scene = scene.clone();
            scene.sampling.planes_per_voxel = planes;
            let sheets = Splatted::new(&scene, head, Layout::FINE)?.render(&|_, _| ())?.picture;
            scene.sampling.rays_per_voxel = REFERENCE.1;
            let rays = InPerspective::new(&scene, &perspective, head)?;
            let rays = rays.render(Layer::Tiles(TILE_ROWS), &|_, _| ())?.picture;
            let said = [rays, sheets].map(|picture| {
                let found = picture_figures(&picture, &wanted, scene.image.background);
                let db = found.psnr_db.unwrap_or(f64::INFINITY);
                format!("{:.3} | {:.0} | {db:.1}", found.mean_lsb8, found.max_lsb8)
            });
            println!(
                "| {name} | {}, {} degrees | {planes} | {} |",
                eye.0,
                eye.1,
                said.join(" | ")
            );
        }
    }
    Ok(())
}
