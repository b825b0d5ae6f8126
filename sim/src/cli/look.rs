//! Fields of a scene as options: how the volume looks.

use std::ops::RangeInclusive;

use slicecast_scene::check::{EXPONENT_LOG2, FRACTION, TURN, UNIT_DISTANCE, ZOOM};
use slicecast_scene::{Light, Lighting, Scene};

use super::Failure;
use super::inputs::numbers;

/// A number in a range.
fn within(text: &str, range: RangeInclusive<f64>) -> Result<f64, String> {
    let number = text.trim().parse().ok().filter(|number| range.contains(number));
    number.ok_or_else(|| format!("expected a number from {} to {}", range.start(), range.end()))
}

fn zoom(text: &str) -> Result<f64, String> {
    within(text, ZOOM)
}

fn turn(text: &str) -> Result<f64, String> {
    within(text, TURN)
}

fn fraction(text: &str) -> Result<f64, String> {
    within(text, FRACTION)
}

fn unit_distance(text: &str) -> Result<f64, String> {
    within(text, UNIT_DISTANCE)
}

/// log2 of a power of two.
fn exponent(text: &str) -> Result<u32, String> {
    let number: Option<u32> = text.trim().parse().ok().filter(|n: &u32| n.is_power_of_two());
    let log2 = number
        .map(u32::ilog2)
        .filter(|n| EXPONENT_LOG2.contains(&i64::from(*n)));
    log2.ok_or_else(|| "expected a power of two from 1 to 256".into())
}

/// A light in the camera's frame.
fn light(text: &str) -> Result<Light, String> {
    let direction = numbers(text, ',', "-1,1,1.5")?;
    Light::towards(direction).ok_or_else(|| "expected three finite numbers, not all of them 0".into())
}

/// How the volume looks.
#[derive(clap::Args, Default)]
pub struct LookArgs {
    /// Magnification, 0.01 to 100, 1 being the whole volume; without it, the scene's.
    #[arg(long, value_name = "FACTOR", value_parser = zoom)]
    zoom: Option<f64>,
    /// Turn of the picture clockwise, degrees; without it, the scene's.
    #[arg(long, value_name = "DEGREES", value_parser = turn, allow_hyphen_values = true)]
    roll: Option<f64>,
    /// The length that the transfer function's opacities are meant for; without it, the scene's.
    #[arg(long, value_name = "LENGTH", value_parser = unit_distance)]
    unit_distance: Option<f64>,
    /// A white light from this direction (x to the right, y up, z towards the viewer) in place of the scene's lights; may
    /// be given several times.
    #[arg(long, value_name = "X,Y,Z", value_parser = light, allow_hyphen_values = true)]
    light: Vec<Light>,
    /// No light: the colours of the transfer function.
    #[arg(long, conflicts_with_all = ["light", "ambient", "diffuse", "specular", "exponent"])]
    unlit: bool,
    /// Light from everywhere, 0 to 1; without it, the scene's.
    #[arg(long, value_name = "SHARE", value_parser = fraction)]
    ambient: Option<f64>,
    /// Matt reflection, 0 to 1; without it, the scene's.
    #[arg(long, value_name = "SHARE", value_parser = fraction)]
    diffuse: Option<f64>,
    /// Highlights, 0 to 1; without it, the scene's.
    #[arg(long, value_name = "SHARE", value_parser = fraction)]
    specular: Option<f64>,
    /// Sharpness of highlights, a power of two from 1 to 256; without it, the scene's.
    #[arg(long, value_name = "N", value_parser = exponent)]
    exponent: Option<u32>,
}

impl LookArgs {
    /// Puts the options in the place of the scene's fields.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), Failure> {
        if let Some(zoom) = self.zoom {
            scene.image.zoom = zoom;
        }
        if let Some(roll) = self.roll {
            scene.view.roll = roll;
        }
        if let Some(unit_distance) = self.unit_distance {
            scene.transfer.unit_distance = unit_distance;
        }
        if self.unlit {
            scene.lighting = None;
        }
        if !self.light.is_empty() {
            let lighting = scene.lighting.get_or_insert_with(Lighting::default);
            lighting.lights.clone_from(&self.light);
        }
        let material = [
            ("--ambient", self.ambient.is_some()),
            ("--diffuse", self.diffuse.is_some()),
            ("--specular", self.specular.is_some()),
            ("--exponent", self.exponent.is_some()),
        ];
        match &mut scene.lighting {
            Some(lighting) => {
                lighting.ambient = self.ambient.unwrap_or(lighting.ambient);
                lighting.diffuse = self.diffuse.unwrap_or(lighting.diffuse);
                lighting.specular = self.specular.unwrap_or(lighting.specular);
                lighting.exponent_log2 = self.exponent.unwrap_or(lighting.exponent_log2);
            }
            None => {
                if let Some((flag, _)) = material.into_iter().find(|(_, given)| *given) {
                    return Err(Failure::input(format!(
                        "{flag}: the scene is not lit; --light 0,0,1 lights it from the viewer"
                    )));
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use slicecast_scene::file::built_in;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        look: LookArgs,
    }

    fn looked(scene: &str, options: &[&str]) -> Result<Scene, String> {
        let mut scene = built_in(scene).unwrap();
        let line = Line::try_parse_from([&["slicecast"], options].concat()).map_err(|error| error.to_string())?;
        line.look.apply(&mut scene).map_err(|failure| failure.message)?;
        scene.check().map_err(|error| error.to_string())?;
        Ok(scene)
    }

    #[test]
    fn options_replace_fields() {
        let options = "--zoom 2 --roll -30 --unit-distance 0.5 --ambient 0.1 --diffuse 0.5 --specular 0 --exponent 64";
        let scene = looked("ct-bone", &options.split(' ').collect::<Vec<_>>()).unwrap();
        assert_eq!(
            (scene.image.zoom, scene.view.roll, scene.transfer.unit_distance),
            (2.0, -30.0, 0.5)
        );
        let lighting = scene.lighting.unwrap();
        assert_eq!((lighting.ambient, lighting.diffuse, lighting.specular), (0.1, 0.5, 0.0));
        assert_eq!((lighting.exponent_log2, lighting.lights.len()), (6, 2));
        assert_eq!(looked("ct-bone", &["--unlit"]).unwrap().lighting, None);
    }

    #[test]
    fn lights_light_a_scene() {
        let scene = looked("ct-fog", &["--light", "0,0,7", "--light", "-3,0,4", "--ambient", "0"]).unwrap();
        let lighting = scene.lighting.unwrap();
        let directions: Vec<_> = lighting.lights.iter().map(|light| light.direction).collect();
        assert_eq!(directions, [[0.0, 0.0, 1.0], [-0.6, 0.0, 0.8]]);
        assert_eq!(lighting.ambient, 0.0);
    }

    #[test]
    fn what_no_scene_can_have_is_refused_by_the_name_of_the_option() {
        for (options, said) in [
            (
                "--zoom 0",
                "invalid value '0' for '--zoom <FACTOR>': expected a number from 0.01 to 100",
            ),
            ("--roll nan", "'--roll <DEGREES>': expected a number from -360 to 360"),
            (
                "--exponent 3",
                "'--exponent <N>': expected a power of two from 1 to 256",
            ),
            (
                "--exponent 512",
                "'--exponent <N>': expected a power of two from 1 to 256",
            ),
            ("--light 0,0,0", "expected three finite numbers, not all of them 0"),
            ("--light 1,2", "expected 3 numbers like -1,1,1.5"),
            ("--diffuse 2", "'--diffuse <SHARE>': expected a number from 0 to 1"),
            (
                "--specular 0.5",
                "--specular: the scene is not lit; --light 0,0,1 lights it from the viewer",
            ),
            ("--unlit --ambient 1", "cannot be used with"),
        ] {
            let error = looked("ct-fog", &options.split(' ').collect::<Vec<_>>()).unwrap_err();
            assert!(error.contains(said), "{options}: {error}");
        }
    }
}
