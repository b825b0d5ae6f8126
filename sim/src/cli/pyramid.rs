//! `slicecast pyramid`.

use std::path::PathBuf;

use clap::ValueEnum;
use slicecast_model::pyramid::{Halving, Voxel};
use slicecast_pyramid::filter::Filter;
use slicecast_pyramid::pyramid::{By, next};
use slicecast_pyramid::read::Read;
use slicecast_pyramid::reduce::axes;
use slicecast_pyramid::volume::RgbaVolume;
use slicecast_pyramid::write::Level;

use super::Failure;
use super::colours::{ColourArgs, FilterArg};
use super::inputs::{SceneArgs, VolumeArgs};
use super::named_scene::{NamedScene, Transfer};
use super::output::Folder;
use super::tables::header;

/// Write a volume of colour and extinction, and coarser levels that keep the extinction, as NRRD.
///
/// A volume of colours (NRRD of 3 or 4 values a voxel, RGB or RGBA TIFF) is taken as it is; a volume of one value a voxel is
/// classified voxel by voxel first, by the scene's transfer function. Extinctions are filtered in integers, and the remainder of
/// the division is carried along the row, so that sums are kept. Pictures of levels are denser where matter does not fill its voxels.
/// Each voxel is red, green, blue and the root of extinction in 8 bits. Levels are read again as volumes of colours.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  slicecast pyramid scan.nrrd --scene bone.toml -o levels/
  slicecast pyramid colours.nrrd --alpha-distance 1 --filter six -o levels/
  slicecast pyramid photographs/ --opacity luminance --alpha-distance 0.5 --levels 3 -o levels/
  slicecast pyramid levels/level-1.nrrd --exact -o more/")]
pub struct Args {
    #[command(flatten)]
    volume: VolumeArgs,
    /// A scene file (TOML), or a name as `render` has them, whose transfer function classifies a volume of one value a voxel;
    /// without it, the one that fits the volume.
    #[arg(long, value_parser = NamedScene::parser())]
    scene: Option<NamedScene>,
    /// The transfer function of another program in place of the scene's: 3D Slicer (.vp, .vp.json), ParaView (.json).
    #[arg(long, value_name = "FILE", value_parser = Transfer::parser())]
    transfer: Option<Transfer>,
    #[command(flatten)]
    colours: ColourArgs,
    /// Weights along each axis: two (1,1)/2, four (1,1,1,1)/4, six (3,2,3,3,2,3)/16, of which voxels are cells; five
    /// (1,2,2,2,1)/8, of which they are nodes and outer ones stay where they are.
    #[arg(long, value_enum, default_value = "four")]
    filter: FilterArg,
    /// What is filtered; opacity, over --alpha-distance or the transfer function's unit distance, is there for comparison: it
    /// loses matter.
    #[arg(long, value_enum, default_value = "extinction")]
    by: ByArg,
    /// Levels to make below the finest; without it, as many as there are.
    #[arg(long, value_name = "N")]
    levels: Option<usize>,
    /// Write what was computed with, four codes of 15 bits a voxel in 8 bytes, in place of the voxel in 4.
    #[arg(long)]
    exact: bool,
    /// Compare every level with the same filter in f64; of volumes up to 2^24 voxels, by extinction.
    #[arg(long)]
    compare: bool,
    /// Folder of the levels, level-0.nrrd being the finest.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Replace files that this program has not written.
    #[arg(long)]
    force: bool,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum ByArg {
    Extinction,
    Opacity,
}

/// The levels in f64, beside those that are written.
struct Beside {
    weights: Vec<f64>,
    on_nodes: bool,
    dims: [usize; 3],
    voxels: Vec<Voxel>,
}

/// Voxels that are compared with f64, at 32 bytes each.
const COMPARED: usize = 1 << 24;

impl Beside {
    fn new(volume: &RgbaVolume, filter: Filter) -> Self {
        let voxels = 0..volume.voxels.len();
        Self {
            weights: filter.weights().iter().copied().map(f64::from).collect(),
            on_nodes: filter.on_nodes(),
            dims: volume.dims,
            voxels: voxels.map(|index| volume.voxels.codes(index).map(f64::from)).collect(),
        }
    }

    /// Goes one level down.
    fn next(&mut self) {
        let halving = Halving {
            weights: &self.weights,
            on_nodes: self.on_nodes,
        };
        (self.dims, self.voxels) = halving.volume(self.dims, &self.voxels);
    }

    /// Mean deviation and largest error of extinctions, and largest error of colours times extinction, in codes.
    fn errors(&self, volume: &RgbaVolume) -> [f64; 3] {
        let mut errors = [0.0, 0.0, 0.0f64];
        for (index, model) in self.voxels.iter().enumerate() {
            let codes = volume.voxels.codes(index);
            let away = [0, 1, 2, 3].map(|k| f64::from(codes[k]) - model[k]);
            errors[0] += away[3] / self.voxels.len() as f64;
            errors[1] = errors[1].max(away[3].abs());
            errors[2] = away[..3].iter().fold(errors[2], |most, away| most.max(away.abs()));
        }
        errors
    }
}

impl Args {
    /// Writes the levels.
    pub fn run(self) -> Result<(), Failure> {
        if self.compare && self.by == ByArg::Opacity {
            return Err(Failure::input(
                "--compare: is of levels by extinction, expected no --by opacity",
            ));
        }
        let read = self.read()?;
        read.notes().iter().for_each(|note| eprintln!("note: {note}"));
        let mut volume = read.volume;
        let filter = Filter::from(self.filter);
        if self.compare && volume.voxels.len() > COMPARED {
            return Err(Failure::input(format!(
                "{}: has {} voxels, expected at most {COMPARED} for --compare",
                volume.name,
                volume.voxels.len()
            )));
        }
        let mut beside = self.compare.then(|| Beside::new(&volume, filter));
        let shapes = self.shapes(filter, volume.dims);
        if shapes.windows(2).any(|pair| repeats(filter, pair)) {
            eprintln!("note: an axis that does not halve has its last voxel twice, so that levels below hold more");
        }
        if let Some(asked) = self.levels.filter(|asked| *asked >= shapes.len()) {
            let there = shapes.len() - 1;
            eprintln!("note: {there} levels below the finest, not {asked}: no axis can become shorter");
        }
        let by = match (self.by, volume.alpha_distance) {
            (ByArg::Extinction, _) => By::Extinction,
            (ByArg::Opacity, Some(distance)) => By::Opacity { distance },
            (ByArg::Opacity, None) => {
                return Err(Failure::input(format!(
                    "{}: states extinctions, and no distance over which opacities are meant, expected no --by opacity",
                    volume.name
                )));
            }
        };
        let names: Vec<String> = (0..shapes.len()).map(name).collect();
        let mut folder = Folder::open(&self.output, self.force)?;
        folder.check(&names)?;
        let content = volume.content(filter.on_nodes());
        let mut heads = vec![
            "level",
            "voxels",
            "spacing",
            "extinction kept",
            "opacity along z",
            "bytes",
        ];
        if self.compare {
            heads.push("f64: bias, extinction, colour");
        }
        let mut table = header(&heads);
        for (number, name) in names.iter().enumerate() {
            if number > 0
                && let Some(coarse) = next(&volume, filter, by)
            {
                volume = coarse;
                if let Some(beside) = &mut beside {
                    beside.next();
                }
            }
            let level = Level {
                volume: &volume,
                on_nodes: filter.on_nodes(),
                number,
                filter: filter.name(),
                exact: self.exact,
            };
            let file = level.file();
            folder.write(name, &file)?;
            let kept = volume.content(filter.on_nodes()) / content;
            let mut cells = vec![
                number.to_string(),
                volume.dims.map(|len| len.to_string()).join(" x "),
                volume.spacing.map(|length| format!("{length:.4}")).join(", "),
                if content > 0.0 {
                    format!("{kept:.6}")
                } else {
                    "-".into()
                },
                format!("{:.6}", volume.opacity_along_z()),
                file.len().to_string(),
            ];
            if let Some(beside) = &beside {
                let [bias, extinction, colour] = beside.errors(&volume);
                cells.push(format!("{bias:+.4}, {extinction:.2}, {colour:.2}"));
            }
            table.add_row(cells);
        }
        let shown = self.output.display();
        println!(
            "{shown}: {} levels by {}, tau_max {}",
            names.len(),
            filter.name(),
            volume.tau_max
        );
        println!("{table}");
        Ok(())
    }

    /// The volume of colour and extinction.
    fn read(&self) -> Result<Read, Failure> {
        if self.colours.materials.given() && (self.scene.is_some() || self.transfer.is_some()) {
            return Err(Failure::input(
                "--materials: of a volume of shares, which --scene and --transfer do not classify",
            ));
        }
        if let Some(read) = self.colours.materials.read(&self.volume)? {
            return Ok(read);
        }
        if let Some(colours) = self.volume.colours()? {
            if self.scene.is_some() || self.transfer.is_some() {
                return Err(Failure::input(format!(
                    "{}: is a volume of colours, which --scene and --transfer do not classify",
                    colours.name()
                )));
            }
            return self.colours.read(&colours, None);
        }
        let loaded = self.volume.load()?;
        let scene = SceneArgs::classifying(self.scene.clone(), self.transfer.clone());
        let scene = scene.load_for(&self.volume, &loaded)?;
        self.colours.classified(&loaded, &scene)
    }

    /// The shapes of all levels.
    fn shapes(&self, filter: Filter, dims: [usize; 3]) -> Vec<[usize; 3]> {
        let coarser = |dims: &[usize; 3]| {
            let coarse = axes(filter, *dims).map(|axis| axis.coarse);
            (coarse != *dims).then_some(coarse)
        };
        let all = std::iter::successors(Some(dims), coarser);
        all.take(self.levels.unwrap_or(usize::MAX).saturating_add(1)).collect()
    }
}

/// Whether an axis of the first shape has its last voxel twice in the second.
fn repeats(filter: Filter, pair: &[[usize; 3]]) -> bool {
    let odd = usize::from(!filter.on_nodes());
    (0..3).any(|axis| pair[0][axis] != pair[1][axis] && pair[0][axis] % 2 == odd)
}

/// A level's file.
fn name(number: usize) -> String {
    format!("level-{number}.nrrd")
}
