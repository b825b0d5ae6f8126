//! Where the final error came from: the pixel with one stage after the other in the pipeline's arithmetic.

use super::Share;
use super::record::{Recorded, Step};
use slicecast_model::gradient::normalise;
use slicecast_model::{Model, Pixel, Place};

/// The stages whose results are handed over one after the other.
const CHAIN: [&str; 7] = [
    "location",
    "interpolation",
    "classification",
    "gradient",
    "normal",
    "shading",
    "compositing",
];

/// The pixel where the first `fixed` stages of [`CHAIN`] have the pipeline's results and the others are the model's.
fn hybrid(steps: &[Step], exact: &Model<'_>, rounded: &Model<'_>, [u, v]: [usize; 2], fixed: usize) -> Pixel {
    let mut pixel = Pixel::TRANSPARENT;
    let mut left = 1.0;
    for (index, step) in steps.iter().enumerate() {
        let model = if fixed >= 1 { rounded } else { exact };
        let Some(Place {
            position,
            fraction,
            left: rest,
            turned,
            ..
        }) = model.place(index, u, v)
        else {
            continue;
        };
        let value = match step.value {
            Some(value) if fixed >= 2 => value,
            _ => model.value_at(position),
        };
        let classified = model.classify(value).of_fraction(fraction * rest.weight());
        let (mut opacity, mut colour) = (classified.opacity, classified.colour);
        if fixed >= 3 {
            // A row that was skipped while light was left was found empty.
            opacity = step.opacity.unwrap_or(if left > 0.0 { 0.0 } else { opacity });
            colour = step.colour.unwrap_or(colour);
        }
        if opacity > 0.0 {
            let own = || {
                if model.lights().is_some() {
                    normalise(model.gradient_at(position))
                } else {
                    [0.0; 3]
                }
            };
            let normal = match (step.normal, step.gradient) {
                (Some(normal), _) if fixed >= 5 => normal,
                (_, Some(gradient)) if fixed >= 4 => normalise(gradient),
                _ => own(),
            };
            let shaded = match step.shaded {
                Some(shaded) if fixed >= 6 => shaded,
                // What is not lit has turned as it was classified.
                _ if model.lights().is_none() && fixed >= 3 && step.colour.is_some() => colour,
                _ => model.cued(model.shade(normal, colour), turned),
            };
            pixel = pixel.front_to_back(shaded, opacity);
        }
        left = step.after.map_or(left, |after| after.transparency);
    }
    pixel
}

/// The model's pixel, and what each stage adds on the way from it to the pipeline's.
pub(super) fn shares(
    record: &Recorded,
    exact: &Model<'_>,
    rounded: &Model<'_>,
    ray: [usize; 2],
) -> (Pixel, Vec<Share>) {
    let first = hybrid(&record.steps, exact, rounded, ray, 0);
    let lit = exact.lights().is_some();
    let mut last = first;
    let mut shares = Vec::new();
    for (number, stage) in (1..).zip(CHAIN) {
        let next = if stage == "compositing" {
            record.pixel
        } else {
            hybrid(&record.steps, exact, rounded, ray, number)
        };
        let skipped = !lit && ["gradient", "normal", "shading"].contains(&stage);
        if !skipped {
            shares.push(Share {
                stage,
                lsb8: [0, 1, 2].map(|c| 255.0 * (next.colour[c] - last.colour[c])),
            });
        }
        last = next;
    }
    (first, shares)
}
