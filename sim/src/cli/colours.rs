//! Volumes of colour and extinction as several subcommands take them.

use clap::ValueEnum;
use slicecast_pyramid::filter::Filter;
use slicecast_pyramid::pyramid::{By, next};
use slicecast_pyramid::read::{Curve, OpacityRule, Read, Stated, of_colours, of_scalars};
use slicecast_pyramid::volume::RgbaVolume;
use slicecast_scene::check::LENGTHS;
use slicecast_scene::{Classification, ColourOpacity, Scene};
use slicecast_volume::colours::Colours;
use slicecast_volume::open::Loaded;

use super::Failure;
use super::inputs::{SceneArgs, VolumeArgs, number_in};
use super::materials::MaterialArgs;

/// What is stated about a volume of colours.
#[derive(clap::Args, Default)]
pub struct ColourArgs {
    /// The distance over which the opacities of a file of colours are meant, in the unit of its spacing.
    #[arg(long, value_name = "LENGTH", value_parser = number_in(LENGTHS))]
    alpha_distance: Option<f64>,
    /// The largest extinction, per unit of the spacing, to which larger ones are held; without it, the largest that there is,
    /// up to 15 over the distance of the opacities.
    #[arg(long, value_name = "TAU", value_parser = number_in(LENGTHS))]
    tau_max: Option<f64>,
    /// Opacity of colours without one: luminance, a number from 0 to 1 for all voxels, or points LUMINANCE:OPACITY of a transfer function
    /// with commas between them, as 0.1:0,0.5:0.8,1:1.
    #[arg(long, value_name = "RULE", value_parser = opacity)]
    opacity: Option<OpacityRule>,
    #[command(flatten)]
    pub materials: MaterialArgs,
}

/// A coarser level of the volume.
#[derive(clap::Args, Default)]
pub struct LevelArgs {
    /// A level of the volume's pyramid, 0 being the finest, made in memory: a preview. A volume of one value a voxel is
    /// classified voxel by voxel first.
    #[arg(long, value_name = "N")]
    level: Option<u32>,
    /// Weights along each axis for --level: see `slicecast pyramid`.
    #[arg(long, value_enum, requires = "level", default_value = "four")]
    filter: FilterArg,
}

/// Filters that halve an axis.
#[derive(Clone, Copy, Default, ValueEnum)]
pub enum FilterArg {
    Two,
    #[default]
    Four,
    Six,
    Five,
}

impl From<FilterArg> for Filter {
    fn from(filter: FilterArg) -> Self {
        match filter {
            FilterArg::Two => Self::Two,
            FilterArg::Four => Self::Four,
            FilterArg::Six => Self::Six,
            FilterArg::Five => Self::Five,
        }
    }
}

/// `luminance`, a number, or points of luminance and opacity.
fn opacity(text: &str) -> Result<OpacityRule, String> {
    if text == "luminance" {
        return Ok(OpacityRule::Luminance);
    }
    let number = text.parse().ok().filter(|number| (0.0..=1.0).contains(number));
    let rule = number
        .map(OpacityRule::Constant)
        .or_else(|| curve(text).map(OpacityRule::Curve));
    rule.ok_or_else(|| {
        let most = Curve::MOST;
        let points = format!("or 2 to {most} points LUMINANCE:OPACITY, both from 0 to 1, luminances rising");
        format!("expected `luminance`, or a number from 0 to 1, {points}")
    })
}

/// Points of luminance and opacity.
fn curve(text: &str) -> Option<Curve> {
    let point = |text: &str| {
        let (luminance, opacity) = text.split_once(':')?;
        Some([luminance.parse().ok()?, opacity.parse().ok()?])
    };
    let points: Option<Vec<[f64; 2]>> = text.split(',').map(point).collect();
    Curve::new(&points?)
}

impl ColourArgs {
    /// A volume of colours as it is stated here, and by a scene where it is not.
    pub fn read(&self, colours: &Colours, scene: Option<&Scene>) -> Result<Read, Failure> {
        let of_scene = scene.and_then(|scene| scene.colours).unwrap_or_default();
        let rule = |opacity: ColourOpacity| match opacity {
            ColourOpacity::Luminance => OpacityRule::Luminance,
            ColourOpacity::Constant(opacity) => OpacityRule::Constant(opacity),
        };
        let stated = Stated {
            alpha_distance: self.alpha_distance.or(of_scene.alpha_distance),
            tau_max: self.tau_max.or(of_scene.tau_max),
            opacity: self.opacity.or(of_scene.opacity.map(rule)),
        };
        let [x, y, z] = colours.dims();
        eprintln!(
            "{}: {x} x {y} x {z} voxels of {} values",
            colours.name(),
            colours.components()
        );
        colours.notes().iter().for_each(|note| eprintln!("note: {note}"));
        let read = of_colours(colours, &stated);
        read.map_err(|error| Failure::input(format!("{}: {error}", colours.name())))
    }

    /// A volume of one value a voxel, classified voxel by voxel by a scene's transfer function.
    pub fn classified(&self, loaded: &Loaded, scene: &Scene) -> Result<Read, Failure> {
        self.refuse(&loaded.volume.name)?;
        let transfer = &scene.transfer;
        let value = |code: u16| loaded.volume.mapping.value(f64::from(code));
        let table: Vec<([f64; 3], f64)> = (0..4096).map(|code| transfer.evaluate(value(code))).collect();
        let distance = transfer.unit_distance;
        let (volume, orientation) = (&loaded.volume, &loaded.orientation);
        Ok(of_scalars(volume, orientation, &table, distance, self.tau_max))
    }

    /// Refuses what says nothing about a volume of one value a voxel.
    fn refuse(&self, name: &str) -> Result<(), Failure> {
        if self.alpha_distance.is_some() || self.opacity.is_some() {
            return Err(Failure::input(format!(
                "{name}: has one value a voxel, whose opacity and distance are the transfer function's, expected neither \
                 --alpha-distance nor --opacity"
            )));
        }
        Ok(())
    }

    /// For a volume of one value a voxel that is classified sample by sample.
    pub fn check_none(&self, loaded: &Loaded) -> Result<(), Failure> {
        let name = &loaded.volume.name;
        self.refuse(name)?;
        match self.tau_max {
            None => Ok(()),
            Some(_) => Err(Failure::input(format!(
                "{name}: has one value a voxel and is classified sample by sample, expected no --tau-max without --level"
            ))),
        }
    }
}

impl LevelArgs {
    /// The volume of colour and extinction that is to be rendered, and its scene: of a file of colours, or of one value a voxel
    /// where a level is asked for.
    pub fn volume(
        &self,
        volume: &VolumeArgs,
        colours: &ColourArgs,
        scene: &SceneArgs,
    ) -> Result<Option<(Scene, RgbaVolume)>, Failure> {
        let (scene, read) = if let Some(read) = colours.materials.read(volume)? {
            let scene = scene.colours()?;
            if scene.colours != Some(Default::default()) {
                return Err(Failure::input(
                    "--materials: the table states extinctions, expected a scene whose [colours] are empty",
                ));
            }
            (scene, read)
        } else if let Some(file) = volume.colours()? {
            let scene = scene.colours()?;
            let read = colours.read(&file, Some(&scene))?;
            (scene, read)
        } else if self.level.is_some() {
            let loaded = volume.load()?;
            let scene = scene.load_for(volume, &loaded)?;
            if scene.classification != Classification::Point {
                return Err(Failure::input(
                    "--level: levels are classified voxel by voxel, expected --classification point and no surfaces",
                ));
            }
            let read = colours.classified(&loaded, &scene)?;
            (scene, read)
        } else {
            return Ok(None);
        };
        read.notes().iter().for_each(|note| eprintln!("note: {note}"));
        let mut volume = read.volume;
        for made in 0..self.level.unwrap_or(0) {
            volume = next(&volume, self.filter.into(), By::Extinction).ok_or_else(|| {
                let level = self.level.unwrap_or(0);
                Failure::input(format!(
                    "--level {level}: {} has {made} levels below the finest, expected at most that",
                    volume.name
                ))
            })?;
        }
        Ok(Some((scene, volume)))
    }
}
