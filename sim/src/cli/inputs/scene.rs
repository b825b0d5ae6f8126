//! A scene on the command line, and what overrides its fields.

use clap::ValueEnum;
use slicecast_engine::source::Source;
use slicecast_scene::View;
use slicecast_scene::check;
use slicecast_scene::clip::Clip;
use slicecast_scene::colour::hexadecimal;
use slicecast_scene::crop::Crop;
use slicecast_scene::cueing::Cueing;
use slicecast_scene::import::Shading;
use slicecast_scene::modulation::Modulated;
use slicecast_scene::perspective::{Eye, FOV, Perspective};
use slicecast_scene::reflectance::Reflectance;
use slicecast_scene::{
    AlphaCodeName, Blend, Borders, Classification, Face, Interpolation, LookupName, PrecisionName, Scene, Surface,
};
use slicecast_volume::decoded::Orientation;
use slicecast_volume::open::Loaded;
use slicecast_volume::statistics::Statistics;

use super::{VolumeArgs, number_in, whole_in};
use crate::cli::Failure;
use crate::cli::chosen::Chosen;
use crate::cli::look::LookArgs;
use crate::cli::named_scene::{NamedScene, Transfer, is_fitted};
use crate::presets::{self, PresetError};
use crate::projection;

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

/// A closed list of names, as scenes spell them.
#[derive(Clone, Copy, ValueEnum)]
enum PrecisionArg {
    Paper,
    Compact,
    Wide,
    Fast,
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
    Quadratic,
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
    Average,
    Additive,
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
    /// The part of the volume that is drawn, along x, y and z, in voxels (0 is the centre of the first) or, with mm behind it, in
    /// the unit of the spacing: 10:40.5,:32,20: or 5:60,:,:mm; without it, the scene's. It needs borders cells or nodes.
    #[arg(long, value_name = "X0:X1,Y0:Y1,Z0:Z1", value_parser = Crop::parse, allow_hyphen_values = true)]
    crop: Option<Crop>,
    /// A clip plane, up to six times: a point in voxels (0 is the centre of the first) and a normal, on whose side the volume is
    /// drawn; with thickness=T only a slab there, with falloff=F a soft face, with outside what is left of it otherwise, with
    /// mm in the unit of the spacing: 32,32,40:0,1,0 or 0,0,12.5:0,0,1:thickness=4:falloff=2:mm; without it, the scene's.
    #[arg(long = "clip", value_name = "X,Y,Z:NX,NY,NZ[:...]", value_parser = Clip::parse, allow_hyphen_values = true)]
    clips: Vec<Clip>,
    /// Depth cueing: how far colours turn black with depth, 0 to 1, and where that begins and ends, as shares of the way through
    /// the volume, 0,1 if they are left out; without it, the scene's.
    #[arg(long, value_name = "STRENGTH[,FROM,TO]", value_parser = Cueing::parse)]
    depth_cueing: Option<Cueing>,
    /// Factors of opacity, of diffuse or of specular light by the magnitude of the gradient, as points of magnitude (a difference of
    /// values per unit of length) and factor, 0 to 1: opacity=0:0,200:1, up to once for each; without it, the scene's.
    #[arg(long, value_name = "WHAT=M:F,M:F,...", value_parser = Modulated::parse)]
    modulation: Vec<Modulated>,
    /// Look light up in a reflectance map, a cube of so many nodes along an edge (2 to 256), read bilinear or, with `,nearest`, at
    /// the nearest node: 32 or 64,nearest; without it, the scene's.
    #[arg(long, value_name = "SIDE[,FILTER]", value_parser = Reflectance::parse)]
    reflectance: Option<Reflectance>,
    /// How samples of a ray combine; without it, the scene's. A projection (maximum, minimum, average, additive) of a named scene
    /// gets a grey ramp over the values that rays keep or sum up.
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
    /// Rays from an eye, and the field of view from the top of the picture to its bottom, degrees, 5 to 120: a view in perspective, of
    /// samples, with whole borders; without it and --eye, the scene's, which is parallel if it says nothing else.
    #[arg(long, value_name = "DEGREES", value_parser = number_in(check::FOV))]
    fov: Option<f64>,
    /// Where the eye is, in voxels (0 is the centre of the first) or, with :mm behind it, in the unit of the spacing: 64,-200,30 or
    /// 12.5,40,60:mm, outside the volume or in it; without it, the scene's, or outside, where the whole volume is seen.
    #[arg(long, value_name = "X,Y,Z", value_parser = Eye::parse, allow_hyphen_values = true)]
    eye: Option<Eye>,
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
        self.choose_from(volume, loaded, &loaded.volume)
    }

    /// The same, of a volume whose voxels come from a source.
    pub fn choose_from(&self, volume: &VolumeArgs, loaded: &Loaded, source: &dyn Source) -> Result<Chosen, Failure> {
        self.choose_or(slicecast_scene::file::DEFAULT, volume, (loaded, source))
    }

    /// As [`SceneArgs::load_for`], with another scene for the built-in volume and for what looks like it.
    pub fn load_or(&self, default: &'static str, volume: &VolumeArgs, loaded: &Loaded) -> Result<Scene, Failure> {
        Ok(self.choose_or(default, volume, (loaded, &loaded.volume))?.scene)
    }

    fn choose_or(
        &self,
        default: &'static str,
        volume: &VolumeArgs,
        (loaded, source): (&Loaded, &dyn Source),
    ) -> Result<Chosen, Failure> {
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
        let mut scene = self.finish(self.read(default, Some((loaded, &statistics, source)))?)?;
        let projection = !scene.blend.is_composited();
        // Labels are names: they keep their colours.
        if projection && stock.as_ref().is_some_and(|name| name != "labels") && self.transfer.is_none() {
            scene.transfer = projection::ramp(&loaded.volume, source, scene.blend)?;
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
    fn read(&self, default: &str, fitted: Option<(&Loaded, &Statistics, &dyn Source)>) -> Result<Scene, Failure> {
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
            Some((loaded, statistics, source)) if self.scene.is_none() || is_fitted(name) => {
                presets::scene(name, loaded, statistics, source)
            }
            _ => slicecast_scene::file::built_in(name).map_err(PresetError::from),
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
                PrecisionArg::Fast => PrecisionName::Fast,
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
                InterpolationArg::Quadratic => Interpolation::Quadratic,
            };
        }
        if let Some(borders) = self.borders {
            scene.borders = match borders {
                BordersArg::Whole => Borders::Whole,
                BordersArg::Cells => Borders::Cells,
                BordersArg::Nodes => Borders::Nodes,
            };
        }
        if self.fov.is_some() || self.eye.is_some() {
            let own = scene.perspective;
            scene.perspective = Some(Perspective {
                fov: self.fov.or(own.map(|own| own.fov)).unwrap_or(FOV),
                eye: self.eye.or(own.and_then(|own| own.eye)),
            });
            // Exact ones that are asked for are refused.
            if self.borders.is_none() {
                scene.borders = Borders::Whole;
            }
        }
        if self.crop.is_some() {
            scene.crop = self.crop;
        }
        if !self.clips.is_empty() {
            scene.clips.clone_from(&self.clips);
        }
        if self.depth_cueing.is_some() {
            scene.cueing = self.depth_cueing;
        }
        for modulated in &self.modulation {
            scene.modulation.get_or_insert_default().set(modulated.clone());
        }
        if self.reflectance.is_some() {
            scene.reflectance = self.reflectance;
        }
        if let Some(blend) = self.blend {
            scene.blend = match blend {
                BlendArg::FrontToBack => Blend::FrontToBack,
                BlendArg::BackToFront => Blend::BackToFront,
                BlendArg::Maximum => Blend::Maximum,
                BlendArg::Minimum => Blend::Minimum,
                BlendArg::Average => Blend::Average,
                BlendArg::Additive => Blend::Additive,
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
