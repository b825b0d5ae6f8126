//! What `render` and `turntable` share: the options of a picture, and its way into a file or to standard output.

use std::ffi::OsStr;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use slicecast_engine::camera::{Picture, Shape};
use slicecast_engine::image::Frame;
use slicecast_engine::shard::Shard;
use slicecast_scene::check::{FRACTION, IMAGE_SIDE};
use slicecast_scene::colour::hexadecimal;
use slicecast_scene::{Sampling, Scene};

use super::Failure;
use super::inputs::{SceneArgs, numbers};
use super::output::{check_free, write_file};
use crate::framing::{Framing, Stated};
use crate::raster::{Depth, Finish, Raster};

/// `WxH`.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    let size: [u32; 2] = numbers(text, 'x', "512x512")?;
    if size.iter().all(|side| IMAGE_SIDE.contains(&i64::from(*side))) {
        Ok(size)
    } else {
        Err(format!("expected 1 to {} pixels along each side", IMAGE_SIDE.end()))
    }
}

/// The name of a PNG file.
pub fn png_file(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.extension() {
        Some(ending) if ending.eq_ignore_ascii_case("png") => Ok(path),
        _ => Err("expected a name that ends in .png".into()),
    }
}

/// What stands behind the volume.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Background {
    None,
    Colour([f64; 3]),
}

fn background(text: &str) -> Result<Background, String> {
    let named = match text {
        "none" => return Ok(Background::None),
        "black" => Some([0.0; 3]),
        "white" => Some([1.0; 3]),
        _ => hexadecimal(text.strip_prefix('#').unwrap_or(text)),
    };
    let listed = || numbers(text, ',', "0,0.5,1").ok();
    let colour = named
        .or_else(listed)
        .filter(|rgb: &[f64; 3]| rgb.iter().all(|c| FRACTION.contains(c)));
    let expected = "expected none, black, white, six hexadecimal digits like ff8800, or three numbers from 0 to 1";
    colour.map(Background::Colour).ok_or_else(|| expected.into())
}

#[derive(Clone, Copy, ValueEnum)]
enum DepthArg {
    #[value(name = "8")]
    Eight,
    #[value(name = "16")]
    Sixteen,
}

/// The picture.
#[derive(clap::Args)]
pub struct PictureArgs {
    /// Size of the picture; without it, the scene's, or one that shows every ray, 512 pixels along the longer side at least.
    /// Rays and planes follow, so that the picture is sharp, unless --rays and --planes say otherwise.
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
    #[command(flatten)]
    finish: FinishArgs,
}

/// How a picture is written.
#[derive(clap::Args)]
pub struct FinishArgs {
    /// Behind the volume: none (the PNG has straight alpha), black, white, six hexadecimal digits, or R,G,B from 0 to 1;
    /// without it, the scene's.
    #[arg(long, value_name = "COLOUR", value_parser = background)]
    background: Option<Background>,
    /// Bits of a channel.
    #[arg(long, value_enum, default_value = "8")]
    depth: DepthArg,
}

impl PictureArgs {
    /// Whether it has 8 bits, in front of a background.
    pub fn is_plain(&self) -> bool {
        self.finish.is_plain()
    }

    /// The size asked for.
    pub const fn size(&self) -> Option<[u32; 2]> {
        self.size
    }

    /// Puts the options in the place of the scene's fields.
    pub fn apply(&self, scene: &mut Scene) {
        if let Some(Background::Colour(colour)) = self.finish.background {
            scene.image.background = colour;
        }
    }

    /// Frames a scene seen from these sides, and says where sharpness needs more samples than the scene has.
    pub fn frame(&self, scenes: &[Scene], volume: impl Into<Shape>, asked: &SceneArgs) -> Result<Framing, Failure> {
        let [rays, planes] = asked.sampling_stated();
        let stated = Stated {
            size: self.size,
            rays,
            planes,
        };
        let framing = Framing::of(scenes, volume, stated)?;
        let own = scenes.first().map(|scene| scene.sampling);
        if own.is_some_and(|own| own != framing.sampling) {
            let [width, height] = framing.size;
            let Sampling {
                planes_per_voxel: planes,
                rays_per_voxel: rays,
            } = framing.sampling;
            eprintln!(
                "sampling: --rays {rays} and --planes {planes} per voxel, for a sharp picture of {width} x {height} pixels"
            );
        }
        Ok(framing)
    }

    /// A frame as it is to be written.
    pub fn raster(&self, scene: &Scene, picture: &Picture, frame: Frame) -> Raster {
        self.finish.raster(frame, picture, scene.image.background)
    }
}

impl FinishArgs {
    fn is_plain(&self) -> bool {
        matches!(self.depth, DepthArg::Eight) && self.background != Some(Background::None)
    }

    /// A frame as it is to be written; its own picture has the background given.
    pub fn raster(&self, frame: Frame, picture: &Picture, background: [f64; 3]) -> Raster {
        let finish = Finish {
            depth: match self.depth {
                DepthArg::Eight => Depth::Eight,
                DepthArg::Sixteen => Depth::Sixteen,
            },
            transparent: self.background == Some(Background::None),
        };
        Raster::of(frame, picture, background, finish)
    }
}

/// `I/N`.
pub fn shard(text: &str) -> Result<Shard, String> {
    let parts = text.split_once('/');
    let parsed = parts.and_then(|(i, n)| Shard::new(i.parse().ok()?, n.parse().ok()?));
    parsed.ok_or_else(|| "expected I/N with I from 1 to N, like 2/8".into())
}

/// Where pictures go.
pub enum Target {
    /// Standard output.
    Standard,
    /// Files.
    Files(Vec<PathBuf>),
}

impl Target {
    /// The target of `-o`, found fit to be written before there is anything to write.
    pub fn checked(output: &Path, files: Vec<PathBuf>, force: bool) -> Result<Self, Failure> {
        if output == "-" {
            return if io::stdout().is_terminal() {
                Err(Failure::input(
                    "-o -: standard output is a terminal, expected a file or a pipe",
                ))
            } else {
                Ok(Self::Standard)
            };
        }
        let ending = output.extension().and_then(OsStr::to_str).unwrap_or("");
        if !["png", "apng"].contains(&ending.to_ascii_lowercase().as_str()) {
            return Err(Failure::input(format!(
                "{}: pictures are written as PNG, expected a name that ends in .png, or - for standard output",
                output.display()
            )));
        }
        check_free(&files, force)?;
        Ok(Self::Files(files))
    }

    /// Writes one picture a file, and says so.
    pub fn write(&self, force: bool, pictures: &[Vec<u8>], said: &str) -> Result<(), Failure> {
        match self {
            Self::Standard => {
                let mut out = io::stdout().lock();
                for picture in pictures {
                    let written = out.write_all(picture).and_then(|()| out.flush());
                    written.map_err(|error| Failure::machine(format!("standard output: {error}")))?;
                }
                eprintln!("standard output: {said}");
            }
            Self::Files(files) => {
                for (path, picture) in files.iter().zip(pictures) {
                    write_file(path, force, picture)?;
                }
                if let Some(first) = files.first() {
                    println!("{}: {said}", first.display());
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn backgrounds_are_colours_or_none() {
        assert_eq!(background("none"), Ok(Background::None));
        for (text, colour) in [
            ("black", [0.0; 3]),
            ("ff0033", [1.0, 0.0, 0.2]),
            ("#FF0033", [1.0, 0.0, 0.2]),
            ("0, 0.5,1", [0.0, 0.5, 1.0]),
        ] {
            assert_eq!(background(text), Ok(Background::Colour(colour)), "{text}");
        }
        for text in ["", "nothing", "fff", "0,0,2", "0,0,nan", "1,1"] {
            assert!(background(text).is_err(), "{text}");
        }
    }

    #[test]
    fn endings_that_are_not_written_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.jpg", "a", "a.png.tif", "v1.2"] {
            let path = folder.path().join(name);
            let failure = Target::checked(&path, vec![path.clone()], false).err().unwrap();
            assert_eq!(failure.code, 2);
            assert!(
                failure.message.contains("expected a name that ends in .png"),
                "{}",
                failure.message
            );
        }
        let path = folder.path().join("new/folder/a.PNG");
        assert!(matches!(
            Target::checked(&path, vec![path.clone()], false),
            Ok(Target::Files(_))
        ));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
