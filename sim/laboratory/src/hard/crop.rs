//! Crop boxes: the length of a ray in a box, thin ones too, and two boxes that make a whole.

use std::collections::BTreeMap;

use slicecast_engine::error::RenderError;
use slicecast_scene::crop::Crop;
use slicecast_scene::{Borders, Scene};

use super::borders::{homogeneous, views};
use super::scenes::{scene, waves};
use super::{Case, Size};
use crate::borders::rays::{rays, seen};

/// Boxes of a cube of eight voxels: fractions, one voxel, thinner than any step along one axis and along all, beyond the volume,
/// between two voxels, faces at voxels.
const BOXES: [&str; 8] = [
    "1.25:6.5,:4.125,2.0:",
    "3:4,3:4,3:4",
    "2.5:3.5,4.5:5.5,0.5:1.5",
    ":,:,3.7:3.75",
    "3.1:3.13,:,:",
    "4.4:4.42,2.2:2.25,1.1:1.2",
    "-99:2.3,5.9:99,-3:3",
    ":,6.999:7.001,:",
];

fn cropped(text: &str) -> Option<Crop> {
    // Every box above is one.
    Crop::parse(text).ok()
}

/// A homogeneous cube from all sides: what is missing from, or too much of, each ray, in steps.
fn cube(size: Size) -> Result<Case, RenderError> {
    let count = match size {
        Size::Full => 104,
        Size::Reduced => 16,
    };
    let mut case = Case::new(
        "crop",
        format!("homogeneous cube of 8 voxels, opacity 0.1 a voxel, in 8 boxes, {count} views, every ray"),
        "largest error of a ray's length, steps",
        0.0,
        "what is left is exp(-tau times the ray's length in the box)",
    );
    let (cube, kinds) = homogeneous();
    let borders = [("cells", Borders::Cells), ("nodes", Borders::Nodes)];
    for ((kind, scene), (name, borders)) in kinds.iter().flat_map(|kind| borders.map(|borders| (kind, borders))) {
        let (mut worst, mut longest) = ([0.0f64; 2], 0.0f64);
        for (n, view) in views(count).enumerate() {
            let rate = [1, 2, 3, 5, 16][n % 5];
            let scene = Scene {
                crop: cropped(BOXES[n % BOXES.len()]),
                ..seen(scene, view, rate, borders)
            };
            let found = rays(&scene, &cube, |model, ray, left| {
                let tau = -(-0.1f64).ln_1p() * model.geometry().step_length();
                let steps = ray.steps(rate as usize);
                ((-left.ln() / tau - steps).abs(), steps / f64::from(rate))
            })?;
            let fine = usize::from(rate == 16);
            worst[fine] = found
                .values
                .iter()
                .fold(worst[fine], |worst, (error, _)| worst.max(*error));
            longest = found
                .values
                .iter()
                .fold(longest, |longest, (_, voxels)| longest.max(*voxels));
        }
        let [few, fine] = worst;
        let who = format!("wide, {kind}, {name}, rays of up to {longest:.2} voxels");
        case.outcome(format!("{who}, 1 to 5 planes"), few, Some(0.01));
        // Segments have no table of a step's opacities.
        let allowed = (*kind == "segments").then_some(0.01);
        case.outcome(format!("{who}, 16 planes"), fine, allowed);
    }
    case.note = Some(
        "limit: that of whole volumes (group borders), at their planes; the opacity of 1/16 voxel has a root of 0.081, whose rounding to 16 \
         bits, half of 2^-16, is 1.9e-4 of the opacity, the same way in each of 80 steps: 0.015 steps"
            .into(),
    );
    Ok(case)
}

/// A volume in two boxes with a face in common: what both leave of light is what the whole leaves.
fn halves(size: Size) -> Result<Case, RenderError> {
    let count = match size {
        Size::Full => 40,
        Size::Reduced => 10,
    };
    let mut case = Case::new(
        "crop",
        format!("waves of 9 x 8 x 7 voxels in two boxes with a face in common, {count} views, every ray"),
        "largest difference of a ray's depth, in depths of a step through the most opaque voxel",
        0.0,
        "optical depths of both boxes add up to that of the whole",
    );
    let waves = waves();
    let points = scene(&[(0.0, 0.0), (4095.0, 0.1)]);
    let pairs = [
        ["3.3:,:,:", ":3.3,:,:"],
        [":,4.0:,:", ":,:4.0,:"],
        [":,:,2.77:", ":,:,:2.77"],
    ];
    for (name, borders) in [("cells", Borders::Cells), ("nodes", Borders::Nodes)] {
        let mut worst: f64 = 0.0;
        for (n, view) in views(count).enumerate() {
            let rate = [1, 2, 3, 5][n % 4];
            let scene = seen(&points, view, rate, borders);
            // By where a ray starts, in 2^-20 voxel: base planes of boxes begin elsewhere.
            let depths = |crop: Option<Crop>| {
                let scene = Scene { crop, ..scene.clone() };
                let depths = rays(&scene, &waves, |model, ray, left| {
                    let tau = -(-0.1f64).ln_1p() * model.geometry().step_length();
                    let place = ray.start.map(|at| (at * 1_048_576.0).round() as i64);
                    (place, -left.ln() / tau)
                })?;
                Ok::<_, RenderError>(depths.values.into_iter().collect::<BTreeMap<_, _>>())
            };
            let [low, high] = pairs[n % 3].map(cropped);
            let (whole, low, high) = (depths(None)?, depths(low)?, depths(high)?);
            for (place, depth) in whole {
                let part = |half: &BTreeMap<_, f64>| half.get(&place).copied().unwrap_or(0.0);
                worst = worst.max((part(&low) + part(&high) - depth).abs());
            }
        }
        case.outcome(format!("wide, samples, {name}"), worst, Some(0.01));
    }
    case.note = Some("rays along the common face would be in both boxes; no ray of these views lies in one".into());
    Ok(case)
}

/// All of them.
///
/// # Errors
/// [`RenderError`] if a scene cannot be rendered.
pub fn cases(size: Size) -> Result<Vec<Case>, RenderError> {
    Ok(vec![cube(size)?, halves(size)?])
}
