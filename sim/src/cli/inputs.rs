//! What several subcommands take: a volume, a scene and what overrides its fields.

use std::path::PathBuf;
use std::str::FromStr;

use clap::ValueEnum;
use slicecast_sim::scene::{self, AlphaCodeName, Blend, LookupName, PrecisionName, Scene};
use slicecast_sim::volume::mapping::Window;
use slicecast_sim::volume::open::{Loaded, load, prepare};
use slicecast_sim::volume::raw::{self, RawShape};
use slicecast_sim::volume::values::{Endian, ValueType};

use super::Failure;

/// Numbers separated by `x` or commas.
fn numbers<T: FromStr, const N: usize>(text: &str, separator: char, example: &str) -> Result<[T; N], String> {
    let parts: Option<Vec<T>> = text.split(separator).map(|part| part.trim().parse().ok()).collect();
    parts
        .and_then(|parts| parts.try_into().ok())
        .ok_or_else(|| format!("expected {N} numbers like {example}"))
}

/// `WxHxD`.
pub fn dims(text: &str) -> Result<[u64; 3], String> {
    numbers(text, 'x', "256x256x108")
}

/// `WxH`.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    numbers(text, 'x', "512x512")
}

/// `x,y,z`.
pub fn spacing(text: &str) -> Result<[f64; 3], String> {
    let spacing: [f64; 3] = numbers(text, ',', "0.5,0.5,1.2")?;
    if spacing.iter().all(|s| s.is_finite() && *s > 0.0) {
        Ok(spacing)
    } else {
        Err("expected three lengths above 0".into())
    }
}

fn window(text: &str) -> Result<Window, String> {
    let [low, high] = numbers(text, ',', "-1000,2000")?;
    Ok(Window::Range { low, high })
}

fn value_type(text: &str) -> Result<ValueType, String> {
    ValueType::from_name(text)
        .ok_or_else(|| "expected int8, uint8, int16, uint16, int32, uint32, float or double".into())
}

#[derive(Clone, Copy, ValueEnum)]
enum ByteOrder {
    Little,
    Big,
}

/// The volume.
#[derive(clap::Args)]
pub struct VolumeArgs {
    /// The volume file (NRRD); without one, the built-in CT head.
    volume: Option<PathBuf>,
    /// Values mapped to codes 0 to 4095; without it, the data's own range, without loss where 12 bits hold it.
    #[arg(long, value_name = "LOW,HIGH", value_parser = window, allow_hyphen_values = true)]
    window: Option<Window>,
    /// The file is raw voxels of this shape, x fastest.
    #[arg(long, value_name = "WxHxD", value_parser = dims, requires = "volume")]
    raw_dims: Option<[u64; 3]>,
    /// Type of a raw voxel.
    #[arg(long, value_name = "TYPE", value_parser = value_type, default_value = "uint16", requires = "raw_dims")]
    raw_type: ValueType,
    /// Byte order of a raw voxel.
    #[arg(long, value_enum, default_value = "little", requires = "raw_dims")]
    raw_endian: ByteOrder,
    /// Bytes before the first raw voxel.
    #[arg(long, value_name = "BYTES", default_value_t = 0, requires = "raw_dims")]
    raw_skip: u64,
    /// Distance between raw voxels.
    #[arg(long, value_name = "X,Y,Z", value_parser = spacing, default_value = "1,1,1", requires = "raw_dims")]
    raw_spacing: [f64; 3],
}

impl VolumeArgs {
    /// Loads it, and says on standard error how its values were mapped.
    pub fn load(&self) -> Result<Loaded, Failure> {
        let window = self.window.unwrap_or(Window::Auto);
        let loaded = match (self.raw_dims, &self.volume) {
            (Some(dims), Some(path)) => {
                let shape = RawShape {
                    dims,
                    spacing: self.raw_spacing,
                    value_type: self.raw_type,
                    endian: match self.raw_endian {
                        ByteOrder::Little => Endian::Little,
                        ByteOrder::Big => Endian::Big,
                    },
                    skip: self.raw_skip,
                };
                prepare(&raw::read(path, &shape).map_err(Failure::input)?, window)?
            }
            (_, path) => load(path.as_deref(), window)?,
        };
        let [nx, ny, nz] = loaded.volume.dims;
        eprintln!("{}: {nx} x {ny} x {nz} voxels; {}", loaded.volume.name, loaded.report);
        for note in &loaded.notes {
            eprintln!("note: {note}");
        }
        Ok(loaded)
    }
}

/// A closed list of names, as scenes spell them.
#[derive(Clone, Copy, ValueEnum)]
enum PrecisionArg {
    Paper,
    Compact,
    Wide,
}

#[derive(Clone, Copy, ValueEnum)]
enum TableArg {
    Sqrt8,
    Sqrt16,
}

#[derive(Clone, Copy, ValueEnum)]
enum LookupArg {
    Nearest,
    Linear,
}

#[derive(Clone, Copy, ValueEnum)]
enum BlendArg {
    FrontToBack,
    BackToFront,
    Maximum,
    Minimum,
}

/// The scene.
#[derive(clap::Args)]
pub struct SceneArgs {
    /// A scene file (TOML), or the name of a built-in scene: headsq, ct-bone, ct-fog, ct-fog8.
    #[arg(long, default_value = scene::file::DEFAULT)]
    scene: PathBuf,
    /// Number formats; without it, the scene's.
    #[arg(long)]
    precision: Option<PrecisionArg>,
    /// Opacity in the table; without it, the scene's or the precision's.
    #[arg(long)]
    table: Option<TableArg>,
    /// Table look-up; without it, the scene's or the precision's.
    #[arg(long)]
    lookup: Option<LookupArg>,
    /// How samples of a ray combine; without it, the scene's.
    #[arg(long)]
    blend: Option<BlendArg>,
    /// Sample planes per voxel, 1 to 16; without it, the scene's.
    #[arg(long, value_name = "N")]
    planes: Option<u32>,
    /// Rays per voxel along each side, 1 to 8; without it, the scene's.
    #[arg(long, value_name = "N")]
    rays: Option<u32>,
    /// Turn of the viewer about the vertical axis, degrees; without it, the scene's.
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    azimuth: Option<f64>,
    /// Height of the viewer, degrees; without it, the scene's.
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    elevation: Option<f64>,
}

impl SceneArgs {
    /// Reads the scene and applies the overrides.
    pub fn load(&self) -> Result<Scene, Failure> {
        let name = self.scene.to_str().unwrap_or("");
        let built_in = scene::file::BUILT_IN.iter().any(|(known, _)| *known == name);
        let read = if built_in && !self.scene.exists() {
            scene::file::built_in(name)
        } else {
            scene::file::read(&self.scene)
        };
        let mut scene = read.map_err(Failure::input)?;
        if let Some(precision) = self.precision {
            scene.precision = match precision {
                PrecisionArg::Paper => PrecisionName::Paper,
                PrecisionArg::Compact => PrecisionName::Compact,
                PrecisionArg::Wide => PrecisionName::Wide,
            };
        }
        if let Some(table) = self.table {
            scene.table = Some(match table {
                TableArg::Sqrt8 => AlphaCodeName::Sqrt8,
                TableArg::Sqrt16 => AlphaCodeName::Sqrt16,
            });
        }
        if let Some(lookup) = self.lookup {
            scene.lookup = Some(match lookup {
                LookupArg::Nearest => LookupName::Nearest,
                LookupArg::Linear => LookupName::Linear,
            });
        }
        if let Some(blend) = self.blend {
            scene.blend = match blend {
                BlendArg::FrontToBack => Blend::FrontToBack,
                BlendArg::BackToFront => Blend::BackToFront,
                BlendArg::Maximum => Blend::Maximum,
                BlendArg::Minimum => Blend::Minimum,
            };
        }
        if let Some(planes) = self.planes {
            scene.sampling.planes_per_voxel = planes;
        }
        if let Some(rays) = self.rays {
            scene.sampling.rays_per_voxel = rays;
        }
        if let Some(azimuth) = self.azimuth {
            scene.view.azimuth = azimuth;
        }
        if let Some(elevation) = self.elevation {
            scene.view.elevation = elevation;
        }
        scene.check().map_err(Failure::input)?;
        Ok(scene)
    }
}

/// How many threads.
#[derive(clap::Args)]
pub struct ThreadArgs {
    /// Threads; without it, one a processor. The picture does not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

impl ThreadArgs {
    /// The number asked for.
    pub fn count(&self) -> Option<usize> {
        self.threads.map(usize::from)
    }
}
