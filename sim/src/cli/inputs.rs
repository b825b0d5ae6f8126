//! What several subcommands take: a volume, a scene and what overrides its fields.

use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::str::FromStr;

use crate::presets;
use clap::ValueEnum;
use slicecast_engine::simd::Simd;
use slicecast_scene::View;
use slicecast_scene::check;
use slicecast_scene::colour::hexadecimal;
use slicecast_scene::import::Shading;
use slicecast_scene::{
    AlphaCodeName, Blend, Borders, Classification, Face, Interpolation, LookupName, PrecisionName, Scene, Surface,
};
use slicecast_volume::choice::{Choice, NanRule, Series};
use slicecast_volume::colours::Colours;
use slicecast_volume::mapping::Window;
use slicecast_volume::on_disk::OnDisk;
use slicecast_volume::open::{self, Loaded, Options, prepare};
use slicecast_volume::raw::RawShape;
use slicecast_volume::raw::describe::{self, Description};
use slicecast_volume::statistics::Statistics;
use slicecast_volume::values::{Decoded, Endian, Orientation, ValueType};

use super::Failure;
use super::chosen::Chosen;
use super::look::LookArgs;
use super::named_scene::{NamedScene, Transfer, is_fitted};
use super::progress::with_bar;
use crate::projection;

/// The parser of a number that a scene's field may have.
pub fn number_in(range: RangeInclusive<f64>) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| {
        let number = text.parse().ok().filter(|number| range.contains(number));
        let [low, high] = [range.start(), range.end()].map(|end| check::shown(*end));
        number.ok_or_else(|| format!("expected a number from {low} to {high}"))
    }
}

/// As [`number_in`], of a whole number.
pub fn whole_in(range: RangeInclusive<i64>) -> impl Fn(&str) -> Result<u32, String> + Clone {
    move |text| {
        let number = text.parse::<i64>().ok().filter(|number| range.contains(number));
        let number = number.and_then(|number| u32::try_from(number).ok());
        number.ok_or_else(|| format!("expected a whole number from {} to {}", range.start(), range.end()))
    }
}

/// Numbers separated by `x` or commas.
pub fn numbers<T: FromStr, const N: usize>(text: &str, separator: char, example: &str) -> Result<[T; N], String> {
    let parts: Option<Vec<T>> = text.split(separator).map(|part| part.trim().parse().ok()).collect();
    parts
        .and_then(|parts| parts.try_into().ok())
        .ok_or_else(|| format!("expected {N} numbers like {example}"))
}

/// `WxHxD`.
pub fn dims(text: &str) -> Result<[u64; 3], String> {
    numbers(text, 'x', "256x256x108")
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

/// `VALUE[,COLOUR[,OPACITY]]`.
fn surface(text: &str) -> Result<Surface, String> {
    let mut parts = text.split(',').map(str::trim);
    let value =
        number_in(check::VALUE)(parts.next().unwrap_or_default()).map_err(|expected| format!("value: {expected}"))?;
    let mut face = Face::default();
    if let Some(colour) = parts.next() {
        let parsed = colour.strip_prefix('#').and_then(hexadecimal);
        face.colour = parsed.ok_or_else(|| format!("colour {colour:?}: expected #rrggbb"))?;
    }
    if let Some(opacity) = parts.next() {
        face.opacity = number_in(check::FRACTION)(opacity).map_err(|expected| format!("opacity: {expected}"))?;
    }
    match parts.next() {
        None => Ok(Surface::of(value, face)),
        Some(more) => Err(format!(
            "{more:?} is too much: expected a value, a colour and an opacity"
        )),
    }
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
    /// The volume: NIfTI, NRRD, MetaImage, TIFF, a DICOM file or folder, or raw; without one, the built-in CT head.
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
    /// Channel wanted, from 1, of a TIFF file that has several; without it, the first.
    #[arg(long, value_name = "N", requires = "volume", value_parser = clap::value_parser!(u16).range(1..))]
    channel: Option<u16>,
    /// Time point wanted, from 1, of a TIFF file that has several; without it, the first.
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

    /// As [`VolumeArgs::load`], and leaves the voxels in the file.
    pub fn load_on_disk(&self) -> Result<(Loaded, OnDisk), Failure> {
        let Some(path) = &self.volume else {
            return Err(Failure::input(
                "--memory: the built-in CT head is in memory, expected a volume file",
            ));
        };
        let window = self.window.unwrap_or(Window::Auto);
        let opened = with_bar("counting values", |progress| {
            OnDisk::open(path, window, &self.options(), progress)
        })?;
        let [nx, ny, nz] = opened.1.dims();
        if nx.min(ny).min(nz) == 1 {
            return Err(Failure::input(format!(
                "{}: is one slice thick ({nx} x {ny} x {nz} voxels); expected no --memory: it is drawn twice, in memory",
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
    Colour16,
}

#[derive(Clone, Copy, ValueEnum)]
enum LookupArg {
    Nearest,
    Linear,
}

#[derive(Clone, Copy, ValueEnum)]
enum ClassificationArg {
    Point,
    Integral,
    Auto,
    None,
}

#[derive(Clone, Copy, ValueEnum)]
enum InterpolationArg {
    Linear,
    Nearest,
}

#[derive(Clone, Copy, ValueEnum)]
enum BordersArg {
    Whole,
    Cells,
    Nodes,
}

#[derive(Clone, Copy, ValueEnum)]
enum BlendArg {
    FrontToBack,
    BackToFront,
    Maximum,
    Minimum,
}

/// The scene of a volume of colours where none is named: the view of the other scenes.
const OF_COLOURS: &str = "[view]\nazimuth = 30.0\nelevation = 10.0\n[colours]\n";

/// The scene.
#[derive(clap::Args, Default)]
pub struct SceneArgs {
    /// A scene file (TOML), or a name: headsq, ct-bone, ct-soft-tissue, ct-vessels, ct-fog, ct-fog8, or, fitted to the
    /// volume's histogram, mr, labels, fog, mip. Without it, the one that fits the volume.
    #[arg(long, value_parser = NamedScene::parser())]
    scene: Option<NamedScene>,
    /// The transfer function of another program in place of the scene's: 3D Slicer (.vp, .vp.json), ParaView (.json).
    #[arg(long, value_name = "FILE", value_parser = Transfer::parser())]
    transfer: Option<Transfer>,
    /// The side of the patient on which the viewer stands, from which --azimuth and --elevation turn; without it, the
    /// scene's view.
    #[arg(long, value_name = "SIDE", value_parser = ["anterior", "posterior", "left", "right", "superior", "inferior"])]
    view: Option<String>,
    /// Number formats; without it, the scene's.
    #[arg(long)]
    precision: Option<PrecisionArg>,
    /// Opacity and colours in the table; without it, the scene's or what precision and colours ask for.
    #[arg(long)]
    table: Option<TableArg>,
    /// Table look-up; without it, the scene's or the precision's.
    #[arg(long)]
    lookup: Option<LookupArg>,
    /// What is classified along a ray: samples (point), segments between samples (integral), or segments where the transfer
    /// function is finer than what neighbouring samples differ by or a surface cuts them (auto), or nothing, for surfaces
    /// alone (none); without it, the scene's.
    #[arg(long)]
    classification: Option<ClassificationArg>,
    /// An isosurface: the value, its colour (#rrggbb) and its opacity from 0 to 1; as often as wanted. Added to the scene's;
    /// without --scene, --transfer and --classification, surfaces alone are drawn.
    #[arg(long, value_name = "VALUE[,COLOUR[,OPACITY]]", value_parser = surface, allow_hyphen_values = true)]
    surface: Vec<Surface>,
    /// Pieces, 1, 2 or 4, that segments of strong colours are cut into; without it, the scene's.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4))]
    pieces: Option<u32>,
    /// The value between voxels; without it, the scene's. Labels are names, and are sampled nearest.
    #[arg(long)]
    interpolation: Option<InterpolationArg>,
    /// Where the volume ends: at its outermost voxels, where each sample counts as a whole step (whole), or exactly, where
    /// it counts by the part of its step inside: half a voxel beyond them (cells) or at them (nodes); without it, the
    /// scene's.
    #[arg(long)]
    borders: Option<BordersArg>,
    /// How samples of a ray combine; without it, the scene's. A projection (maximum, minimum) of a named scene gets a grey
    /// ramp over the values that rays keep.
    #[arg(long)]
    blend: Option<BlendArg>,
    /// Sample planes per voxel, 1 to 16; without it, the scene's.
    #[arg(long, value_name = "N", value_parser = whole_in(check::PLANES_PER_VOXEL))]
    planes: Option<u32>,
    /// Rays per voxel along each side, 1 to 8; without it, the scene's.
    #[arg(long, value_name = "N", value_parser = whole_in(check::RAYS_PER_VOXEL))]
    rays: Option<u32>,
    /// Turn of the viewer about the vertical axis, degrees, from --view if it is given; without it, the scene's.
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true, value_parser = number_in(check::TURN))]
    azimuth: Option<f64>,
    /// Height of the viewer, degrees, from --view if it is given; without it, the scene's.
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true, value_parser = number_in(check::ELEVATION))]
    elevation: Option<f64>,
    #[command(flatten)]
    look: LookArgs,
}

impl SceneArgs {
    /// A scene of which nothing but the transfer function counts.
    pub fn classifying(scene: Option<NamedScene>, transfer: Option<Transfer>) -> Self {
        Self {
            scene,
            transfer,
            ..Self::default()
        }
    }

    /// The scene as it was asked for, for headings.
    pub fn name(&self) -> String {
        let asked = self.scene.as_ref().map(NamedScene::name);
        asked.unwrap_or_else(|| "the fitting scene".into())
    }

    /// Whether the command line states the rays and the planes per voxel.
    pub fn sampling_stated(&self) -> [bool; 2] {
        [self.rays.is_some(), self.planes.is_some()]
    }

    /// Reads the scene and applies the overrides, without a volume.
    pub fn load(&self) -> Result<Scene, Failure> {
        if let Some(NamedScene::Known(name)) = &self.scene
            && is_fitted(name)
        {
            return Err(Failure::input(format!(
                "--scene {name}: is fitted to the values of a volume, and there is none here; accepted: a TOML file, or one of {}",
                slicecast_scene::file::BUILT_IN.map(|(known, _)| known).join(", ")
            )));
        }
        self.finish(self.read(slicecast_scene::file::DEFAULT, None)?)
    }

    /// As [`SceneArgs::load`]; without a scene named, the one that fits the volume, which is told.
    pub fn load_for(&self, volume: &VolumeArgs, loaded: &Loaded) -> Result<Scene, Failure> {
        Ok(self.choose(volume, loaded)?.scene)
    }

    /// As [`SceneArgs::load_for`], and where the scene came from.
    pub fn choose(&self, volume: &VolumeArgs, loaded: &Loaded) -> Result<Chosen, Failure> {
        self.choose_or(slicecast_scene::file::DEFAULT, volume, loaded)
    }

    /// As [`SceneArgs::load_for`], with another scene for the built-in volume and for what looks like it.
    pub fn load_or(&self, default: &'static str, volume: &VolumeArgs, loaded: &Loaded) -> Result<Scene, Failure> {
        Ok(self.choose_or(default, volume, loaded)?.scene)
    }

    fn choose_or(&self, default: &'static str, volume: &VolumeArgs, loaded: &Loaded) -> Result<Chosen, Failure> {
        let statistics = loaded.statistics.clone();
        let (fitting, reason) = presets::suggest(loaded);
        let default = if volume.is_named() && fitting != slicecast_scene::file::DEFAULT {
            fitting
        } else {
            default
        };
        if self.scene.is_none() && volume.is_named() {
            eprintln!("scene: {default}, since {reason}");
        }
        if self.view.is_some() && !matches!(loaded.orientation, Orientation::Patient { .. }) {
            eprintln!("note: the file does not say how the patient lies: --view follows the file's axes");
        }
        let stock = self.stock(default);
        // Colours of labels depend on which of them touch, and a projection's greys on what rays keep.
        if let Some(name) = stock.as_deref().filter(|name| ["labels", "mip"].contains(name))
            && loaded.volume.voxels.is_empty()
        {
            return Err(Failure::input(format!(
                "--memory: the scene `{name}` is fitted by a look at all voxels, and the volume is read in parts; expected \
                 --scene with another or with a file"
            )));
        }
        let mut scene = self.finish(self.read(default, Some((loaded, &statistics)))?)?;
        let projection = matches!(scene.blend, Blend::Maximum | Blend::Minimum);
        // Labels are names: they keep their colours.
        if projection && stock.as_ref().is_some_and(|name| name != "labels") && self.transfer.is_none() {
            if loaded.volume.voxels.is_empty() {
                return Err(Failure::input(
                    "--memory: a projection of a named scene is grey by what rays keep, and the volume is read in parts; \
                     expected --scene FILE or --transfer FILE",
                ));
            }
            scene.transfer = projection::ramp(&loaded.volume, scene.blend);
            scene.check().map_err(Failure::input)?;
            eprintln!("projection: {}", projection::described(&scene.transfer));
        }
        Ok(Chosen {
            scene,
            stock,
            fitting,
            statistics,
        })
    }

    /// The scene of a volume of colours: a file with `[colours]`, or one that says nothing of them, with the overrides.
    pub fn colours(&self) -> Result<Scene, Failure> {
        let classifying = [
            ("--transfer", self.transfer.is_some()),
            ("--table", self.table.is_some()),
            ("--lookup", self.lookup.is_some()),
            ("--classification", self.classification.is_some()),
            ("--surface", !self.surface.is_empty()),
            ("--pieces", self.pieces.is_some()),
        ];
        if let Some((option, _)) = classifying.into_iter().find(|(_, stated)| *stated) {
            return Err(Failure::input(format!(
                "{option}: classifies values, and a volume of colours has none"
            )));
        }
        let scene = match &self.scene {
            None => slicecast_scene::file::parse(OF_COLOURS, "the scene of colours").map_err(Failure::input)?,
            Some(NamedScene::File(_, scene)) if scene.colours.is_some() => Scene::clone(scene),
            Some(named) => {
                return Err(Failure::input(format!(
                    "--scene {}: classifies values, and a volume of colours has none; expected a file with [colours] in place \
                     of [transfer]",
                    named.name()
                )));
            }
        };
        self.finish(scene)
    }

    /// The name of the scene, if it is one of the program's.
    fn stock(&self, default: &str) -> Option<String> {
        match &self.scene {
            None => Some(default.to_owned()),
            Some(NamedScene::Known(name)) => Some(name.clone()),
            Some(NamedScene::File(..)) => None,
        }
    }

    /// The scene as named, before overrides.
    fn read(&self, default: &str, fitted: Option<(&Loaded, &Statistics)>) -> Result<Scene, Failure> {
        let name = match &self.scene {
            Some(NamedScene::File(path, scene)) if scene.colours.is_some() => {
                return Err(Failure::input(format!(
                    "--scene {}: is of a volume of colours ([colours]), and this volume has one value a voxel; expected [transfer]",
                    path.display()
                )));
            }
            Some(NamedScene::File(_, scene)) => return Ok(Scene::clone(scene)),
            Some(NamedScene::Known(name)) => name,
            None => default,
        };
        let read = match fitted {
            Some((loaded, statistics)) if self.scene.is_none() || is_fitted(name) => {
                presets::scene(name, loaded, statistics)
            }
            _ => slicecast_scene::file::built_in(name),
        };
        read.map_err(Failure::input)
    }

    /// Applies the overrides.
    fn finish(&self, mut scene: Scene) -> Result<Scene, Failure> {
        if let Some(Transfer { path, imported }) = &self.transfer {
            imported
                .notes
                .iter()
                .for_each(|note| eprintln!("note: {}: {note}", path.display()));
            scene.transfer = imported.transfer.clone();
            match &imported.shading {
                Some(Shading::On(lighting)) => scene.lighting = Some(lighting.clone()),
                Some(Shading::Off) => scene.lighting = None,
                None => {}
            }
        }
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
                TableArg::Colour16 => AlphaCodeName::Colour16,
            });
        }
        if let Some(lookup) = self.lookup {
            scene.lookup = Some(match lookup {
                LookupArg::Nearest => LookupName::Nearest,
                LookupArg::Linear => LookupName::Linear,
            });
        }
        if let Some(classification) = self.classification {
            scene.classification = match classification {
                ClassificationArg::Point => Classification::Point,
                ClassificationArg::Integral => Classification::Integral,
                ClassificationArg::Auto => Classification::Auto,
                ClassificationArg::None => Classification::None,
            };
        } else if !self.surface.is_empty() {
            // No volume was asked for.
            let alone = self.scene.is_none() && self.transfer.is_none();
            scene.classification = match scene.classification {
                _ if alone => Classification::None,
                Classification::Point => Classification::Integral,
                stated => stated,
            };
        }
        scene.surfaces.extend(&self.surface);
        if let Some(pieces) = self.pieces {
            scene.pieces = pieces;
        }
        if let Some(interpolation) = self.interpolation {
            scene.interpolation = match interpolation {
                InterpolationArg::Linear => Interpolation::Linear,
                InterpolationArg::Nearest => Interpolation::Nearest,
            };
        }
        if let Some(borders) = self.borders {
            scene.borders = match borders {
                BordersArg::Whole => Borders::Whole,
                BordersArg::Cells => Borders::Cells,
                BordersArg::Nodes => Borders::Nodes,
            };
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
        let side = self.view.as_deref().and_then(View::named);
        if side.is_some() {
            // Angles are first checked by themselves, then added to the side's.
            scene.view = View::default();
        }
        if let Some(azimuth) = self.azimuth {
            scene.view.azimuth = azimuth;
        }
        if let Some(elevation) = self.elevation {
            scene.view.elevation = elevation;
        }
        self.look.apply(&mut scene)?;
        scene.check().map_err(Failure::input)?;
        if let Some(side) = side {
            let View {
                azimuth,
                elevation,
                roll,
            } = scene.view;
            let height = side.elevation + elevation;
            if !check::ELEVATION.contains(&height) {
                let [low, high] = if side.elevation > 0.0 { [-90, 0] } else { [0, 90] };
                return Err(Failure::input(format!(
                    "--elevation {elevation}: --view {} stands at {} degrees already, expected a number from {low} to {high}",
                    self.view.as_deref().unwrap_or_default(),
                    side.elevation
                )));
            }
            scene.view = View {
                elevation: height,
                roll,
                ..side.turned(azimuth)
            };
        }
        Ok(scene)
    }
}

/// How many threads.
#[derive(clap::Args)]
pub struct ThreadArgs {
    /// Threads; without it, one a processor. The picture does not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Vectors to compute with; without it, the widest that the processor has. The picture does not depend on them.
    #[arg(long, value_name = "WIDTH", value_parser = simd)]
    simd: Option<Simd>,
}

/// A vector width by its name, if this processor has it.
fn simd(name: &str) -> Result<Simd, String> {
    if !Simd::NAMES.contains(&name) {
        return Err(format!("accepted: {}", Simd::NAMES.join(", ")));
    }
    let found = Simd::available().find(|simd| simd.name() == name);
    found.ok_or_else(|| format!("this processor has no {name}"))
}

impl ThreadArgs {
    /// The number asked for.
    pub fn count(&self) -> Option<usize> {
        self.threads.map(usize::from)
    }

    /// The vectors asked for.
    pub fn simd(&self) -> Simd {
        self.simd.unwrap_or_else(Simd::widest)
    }
}
