//! A volume on the command line.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use slicecast_volume::choice::{Choice, NanRule, Series};
use slicecast_volume::colours::Colours;
use slicecast_volume::decoded::Decoded;
use slicecast_volume::mapping::Window;
use slicecast_volume::on_disk::OnDisk;
use slicecast_volume::open::{self, Loaded, Options, prepare};
use slicecast_volume::raw::RawShape;
use slicecast_volume::raw::describe::{self, Description};
use slicecast_volume::values::{Endian, ValueType};

use super::{dims, numbers, spacing};
use crate::cli::Failure;
use crate::cli::progress::with_bar;

fn window(text: &str) -> Result<Window, String> {
    match text {
        "auto" => return Ok(Window::Auto),
        "file" => return Ok(Window::Stated),
        _ => {}
    }
    if let Some(percent) = text.strip_suffix('%') {
        let [low, high] = numbers(percent, ',', "0.5,99.5%")?;
        return Ok(Window::Percentile { low, high });
    }
    let [low, high] = numbers(text, ',', "-1000,2000")?;
    Ok(Window::Range { low, high })
}

fn raw_words(text: &str) -> Result<Description, String> {
    describe::from_words(text).map_err(|problem| problem.to_string())
}

fn value_type(text: &str) -> Result<ValueType, String> {
    ValueType::from_name(text).ok_or_else(|| format!("expected {}", ValueType::NAMES))
}

#[derive(Clone, Copy, ValueEnum)]
enum ByteOrder {
    Little,
    Big,
}

#[derive(Clone, Copy, ValueEnum)]
enum NanArg {
    Background,
}

/// The volume.
#[derive(clap::Args)]
pub struct VolumeArgs {
    /// The volume: NIfTI, NRRD, MetaImage, TIFF, a DICOM file or folder, Zarr (scan.ome.zarr, or scan.ome.zarr/1 for another level),
    /// or raw; without one, the built-in CT head.
    volume: Option<PathBuf>,
    /// Values mapped to codes 0 to 4095: LOW,HIGH, or LOW,HIGH% of the voxels, or `file` for the file's own window;
    /// without it, the data's whole range, without loss where 12 bits hold it.
    #[arg(long, value_name = "WINDOW", value_parser = window, allow_hyphen_values = true)]
    window: Option<Window>,
    /// Number or UID of the DICOM series wanted; without it, the one with the most slices.
    #[arg(long, value_name = "SERIES", requires = "volume")]
    series: Option<String>,
    /// Phase wanted, from 1, of a DICOM series that holds its slices several times over: times, echoes, acquisitions.
    #[arg(long, value_name = "N", requires = "volume", value_parser = clap::value_parser!(u16).range(1..))]
    phase: Option<u16>,
    /// Channel wanted, from 1, of a TIFF file or Zarr array that has several; without it, the first.
    #[arg(long, value_name = "N", requires = "volume", value_parser = clap::value_parser!(u16).range(1..))]
    channel: Option<u16>,
    /// Time point wanted, from 1, of a TIFF file or Zarr array that has several; without it, the first.
    #[arg(long, value_name = "N", requires = "volume", value_parser = clap::value_parser!(u16).range(1..))]
    time: Option<u16>,
    /// What becomes of NaN: background, which takes the least value and is counted; without it, NaN is refused.
    #[arg(long, value_enum, value_name = "RULE", requires = "volume")]
    nan: Option<NanArg>,
    /// The file is raw voxels, in one line: 256x256x128,uint16,big,spacing=1x1x2,skip=16,offset=-1024,axes=LPS.
    #[arg(long, value_name = "SHAPE", value_parser = raw_words, requires = "volume", conflicts_with = "raw_dims")]
    raw: Option<Description>,
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
    /// Whether a volume was named.
    pub fn is_named(&self) -> bool {
        self.volume.is_some()
    }

    /// What the command line says about the file.
    fn options(&self) -> Options {
        let described = self.raw_dims.map(|dims| Description {
            shape: RawShape {
                dims,
                spacing: self.raw_spacing,
                value_type: self.raw_type,
                endian: match self.raw_endian {
                    ByteOrder::Little => Endian::Little,
                    ByteOrder::Big => Endian::Big,
                },
                skip: self.raw_skip,
            },
            scale: 1.0,
            offset: 0.0,
            modality: None,
            directions: None,
        });
        Options {
            choice: Choice {
                series: self.series.clone().map_or(Series::Largest, Series::Named),
                phase: self.phase.map(usize::from),
                channel: self.channel.map(usize::from),
                time: self.time.map(usize::from),
                nan: match self.nan {
                    None => NanRule::Refuse,
                    Some(NanArg::Background) => NanRule::Background,
                },
            },
            raw: self.raw.or(described),
        }
    }

    /// The file's colours, if it is a volume of colours.
    pub fn colours(&self) -> Result<Option<Colours>, Failure> {
        let Options { choice, raw } = self.options();
        let Some(path) = self.volume.as_ref().filter(|_| raw.is_none()) else {
            return Ok(None);
        };
        let colours = open::read_colours(path, &choice).map_err(Failure::input)?;
        let other = self.window.is_some() || self.series.is_some() || self.phase.is_some() || self.nan.is_some();
        if colours.is_some() && other {
            return Err(Failure::input(format!(
                "{}: is a volume of colours, expected none of --window, --series, --phase and --nan",
                path.display()
            )));
        }
        Ok(colours)
    }

    /// The file of an option beside which no other says anything of the volume.
    pub fn alone(&self, option: &str) -> Result<&Path, Failure> {
        let Some(path) = &self.volume else {
            return Err(Failure::input(format!(
                "{option}: the built-in CT head is no such volume, expected a volume file"
            )));
        };
        let others = [
            self.series.is_some(),
            self.phase.is_some(),
            self.channel.is_some(),
            self.time.is_some(),
        ];
        let mapped = self.window.is_some() || self.nan.is_some() || self.raw.is_some() || self.raw_dims.is_some();
        if mapped || others.contains(&true) {
            return Err(Failure::input(format!(
                "{option}: expected none of --window, --series, --phase, --channel, --time, --nan and --raw"
            )));
        }
        Ok(path)
    }

    /// Reads the file without mapping its values.
    pub fn decode(&self) -> Result<Decoded, Failure> {
        match &self.volume {
            Some(path) => open::read_with(path, &self.options()).map_err(Failure::input),
            None => open::read_built_in().map_err(Failure::input),
        }
    }

    /// Maps values as asked.
    pub fn map(&self, decoded: &Decoded) -> Result<Loaded, Failure> {
        Ok(prepare(decoded, self.window.unwrap_or(Window::Auto))?)
    }

    /// Loads it, and says on standard error how its values were mapped.
    pub fn load(&self) -> Result<Loaded, Failure> {
        let loaded = self.map(&self.decode()?)?;
        say(&loaded);
        Ok(loaded)
    }

    /// As [`VolumeArgs::load`], and leaves the voxels in the file, as an option asks.
    pub fn load_on_disk(&self, option: &str) -> Result<(Loaded, OnDisk), Failure> {
        let Some(path) = &self.volume else {
            return Err(Failure::input(format!(
                "{option}: the built-in CT head is in memory, expected a volume file"
            )));
        };
        let window = self.window.unwrap_or(Window::Auto);
        let opened = with_bar("counting values", |progress| {
            OnDisk::open(path, window, &self.options(), progress)
        })?;
        let [nx, ny, nz] = opened.1.dims();
        if nx.min(ny).min(nz) == 1 {
            return Err(Failure::input(format!(
                "{}: is one slice thick ({nx} x {ny} x {nz} voxels); expected no {option}: it is drawn twice, in memory",
                path.display()
            )));
        }
        say(&opened.0);
        Ok(opened)
    }
}

/// Says on standard error how a volume's values were mapped.
fn say(loaded: &Loaded) {
    let [nx, ny, nz] = loaded.volume.dims;
    eprintln!("{}: {nx} x {ny} x {nz} voxels; {}", loaded.volume.name, loaded.report);
    for note in &loaded.notes {
        eprintln!("note: {note}");
    }
}
