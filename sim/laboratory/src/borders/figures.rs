//! Figures 1, 2, 3 and 11: the checkerboard, and the thickness and opacity of a turned cube.

use serde::Serialize;
use slicecast_engine::error::RenderError;
use slicecast_engine::image::Rgb;
use slicecast_scene::{Borders, Sampling, Scene, View};

use super::rays::{ALL, Found, checkerboard, rays, seen};
use crate::hard::scenes::{scene, volume};

/// Planes per voxel of the errors.
const RATES: [u32; 5] = [1, 2, 4, 8, 16];
/// Opacity a voxel: the paper's figure 3.
const OPACITY: f64 = 0.5;
/// Rays per voxel, each way.
const RAYS: u32 = 8;
/// Pixels of a picture per ray.
const ZOOM: usize = 3;
/// What differences are multiplied by in pictures.
pub(super) const LOUDER: f64 = 4.0;

/// Errors of the checkerboard's base plane at a number of planes, in steps of 1/255.
#[derive(Clone, Debug, Serialize)]
pub struct Errors {
    /// Whole, cells or nodes.
    pub borders: &'static str,
    /// Planes per voxel.
    pub planes: u32,
    /// The mean.
    pub mean: f64,
    /// The largest.
    pub most: f64,
}

/// A ray through the middle of the turned cube.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Through {
    /// Where it meets the first slice, voxels.
    pub place: f64,
    /// Its length in the box, steps of one voxel along k.
    pub length: f64,
    /// The length that the rendered transparency belongs to.
    pub rendered: f64,
}

/// The rays through the middle of the turned cube.
#[derive(Clone, Debug, Serialize)]
pub struct Profile {
    /// Whole, cells or nodes.
    pub borders: &'static str,
    /// Along the row of the base plane.
    pub rays: Vec<Through>,
}

impl Profile {
    /// The largest error of a thickness, in steps.
    pub fn thickness(&self) -> f64 {
        let errors = self.rays.iter().map(|ray| (ray.rendered - ray.length).abs());
        errors.fold(0.0, f64::max)
    }

    /// The largest error of an opacity, in steps of 1/255.
    pub fn opacity(&self) -> f64 {
        let errors = self.rays.iter().map(|ray| opacity(ray.rendered) - opacity(ray.length));
        255.0 * errors.map(f64::abs).fold(0.0, f64::max)
    }
}

/// The opacity of a thickness of the turned cube.
pub fn opacity(steps: f64) -> f64 {
    1.0 - (steps * step() * (-OPACITY).ln_1p()).exp()
}

/// The view of both figures: shears of 0.577 and 0.364.
fn askew() -> View {
    View {
        azimuth: 30.0,
        elevation: 17.5,
        roll: 0.0,
    }
}

/// The view of figures 2 and 3.
fn turned() -> View {
    View {
        azimuth: 30.0,
        ..View::default()
    }
}

/// The length of a step of that view, in voxels.
fn step() -> f64 {
    1.0 / 30f64.to_radians().cos()
}

fn sampled(scene: &Scene, view: View, planes: u32, borders: Borders) -> Scene {
    Scene {
        sampling: Sampling {
            planes_per_voxel: planes,
            rays_per_voxel: RAYS,
        },
        ..seen(scene, view, planes, borders)
    }
}

/// What is left of light on each ray of the checkerboard, and what the integral over the box leaves.
fn board(planes: u32, borders: Borders) -> Result<Found<[f64; 2]>, RenderError> {
    let scene = scene(&[(0.0, 0.0), (4095.0, OPACITY)]);
    let scene = sampled(&scene, askew(), planes, borders);
    rays(&scene, &checkerboard(), |model, ray, left| {
        let voxel = model.geometry().step_length() * f64::from(planes);
        [left, ray.left(model, OPACITY, voxel)]
    })
}

/// Figures 1 and 11: errors of the checkerboard.
///
/// # Errors
/// [`RenderError`] if a scene cannot be rendered.
pub fn errors() -> Result<Vec<Errors>, RenderError> {
    let mut all = Vec::new();
    for (name, borders) in ALL {
        for planes in RATES {
            let found = board(planes, borders)?.values;
            // Rays that miss the box and leave all light say nothing.
            let errors: Vec<f64> = (found.iter())
                .filter(|[left, exact]| left.min(*exact) < 1.0)
                .map(|[left, exact]| 255.0 * (left - exact).abs())
                .collect();
            all.push(Errors {
                borders: name,
                planes,
                mean: errors.iter().sum::<f64>() / errors.len().max(1) as f64,
                most: errors.iter().copied().fold(0.0, f64::max),
            });
        }
    }
    Ok(all)
}

/// Figures 2 and 3: thickness of a homogeneous cube of 4 voxels a side, turned by 30 degrees, planes one voxel apart.
///
/// # Errors
/// [`RenderError`] if a scene cannot be rendered.
pub fn profiles() -> Result<Vec<Profile>, RenderError> {
    let cube = volume([4; 3], [1.0; 3], |_| 1000.0);
    let scene = scene(&[(0.0, OPACITY)]);
    ALL.into_iter()
        .map(|(name, borders)| {
            let found = rays(&sampled(&scene, turned(), 1, borders), &cube, |_, ray, left| {
                let rendered = left.ln() / (step() * (-OPACITY).ln_1p());
                (ray.start, ray.steps(1), rendered)
            })?;
            let [width, height] = found.size;
            let row = &found.values[height / 2 * width..][..width];
            let through = row.iter().map(|(start, length, rendered)| Through {
                place: start[0],
                length: *length,
                rendered: *rendered,
            });
            Ok(Profile {
                borders: name,
                rays: through.collect(),
            })
        })
        .collect()
}

/// Grey levels of a base plane, enlarged.
pub(super) fn grey(size: [usize; 2], zoom: usize, level: impl Fn(usize) -> f64) -> Rgb {
    let [width, height] = size.map(|side| side * zoom);
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| y / zoom * size[0] + x / zoom));
    Rgb {
        size: [width as u32, height as u32],
        bytes: pixels
            .flat_map(|at| [(255.0 * level(at)).round().clamp(0.0, 255.0) as u8; 3])
            .collect(),
    }
}

/// Figure 1: the opacity of the checkerboard's base plane at two planes per voxel, as in the paper: the integral, rendered, and
/// four times their difference; with whole steps, and by cells.
///
/// # Errors
/// [`RenderError`] if a scene cannot be rendered.
pub fn pictures() -> Result<Vec<(String, Rgb)>, RenderError> {
    let mut parts = Vec::new();
    for (name, borders) in [("whole", Borders::Whole), ("cells", Borders::Cells)] {
        let Found { size, values } = board(2, borders)?;
        parts.push((format!("{name}: integral"), grey(size, ZOOM, |at| 1.0 - values[at][1])));
        parts.push(("rendered".into(), grey(size, ZOOM, |at| 1.0 - values[at][0])));
        let difference = |at: usize| LOUDER * (values[at][0] - values[at][1]).abs();
        parts.push(("difference x 4".into(), grey(size, ZOOM, difference)));
    }
    Ok(parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paper's claims: whole steps are wrong by up to a step whatever the ray, exact borders are not.
    #[test]
    fn thickness_is_exact_with_exact_borders() {
        let profiles = profiles().unwrap();
        let of = |name: &str| profiles.iter().find(|profile| profile.borders == name).unwrap();
        assert!(of("whole").thickness() > 0.9 && of("whole").opacity() > 50.0);
        for name in ["cells", "nodes"] {
            assert!(of(name).thickness() < 0.01, "{name}: {}", of(name).thickness());
            assert!(of(name).opacity() < 0.1, "{name}: {}", of(name).opacity());
            assert!(of(name).rays.iter().any(|ray| ray.length > 2.9));
        }
    }

    #[test]
    fn more_planes_do_not_mend_whole_steps() {
        let errors = errors().unwrap();
        let most = |name: &str, planes: u32| {
            let found = errors.iter().find(|line| (line.borders, line.planes) == (name, planes));
            found.unwrap().most
        };
        assert!(most("whole", 16) > 10.0 && most("cells", 16) < 0.3 && most("nodes", 16) < 0.3);
    }
}
