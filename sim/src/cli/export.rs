//! `slicecast export`.

use std::path::PathBuf;

use clap::ValueEnum;
use slicecast_engine::frame::Prepared;
use slicecast_export::{ExportError, Format, Numbers, files};

use super::Failure;
use super::inputs::{SceneArgs, VolumeArgs};
use super::output::Folder;
use super::picture::size;
use crate::slab::thicken;

/// Write a scene as integers: all that a device or a test bench needs to render it to the same bits.
///
/// View and derived steps, spacing factors, lights as the pipeline uses them, table, warp and needs of memory. Opacities in
/// the table are those of this view's step: another view has another table.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  slicecast export --scene headsq --rays 1 --planes 1 --format rust --name head -o src/
  slicecast export scan.nrrd --scene bone.toml --format c --name bone -o include/
  slicecast export scan.nrrd --scene bone.toml --format json -o exchange/
  slicecast export scan.nrrd --scene bone.toml --format hex --voxels -o bench/")]
pub struct Args {
    #[command(flatten)]
    volume: VolumeArgs,
    #[command(flatten)]
    scene: SceneArgs,
    /// What to write: a Rust module without std, a C header, JSON, or $readmemh files with a manifest.
    #[arg(long, value_enum)]
    format: FormatArg,
    /// Size of the picture that the warp makes; without it, the scene's, or one that shows every ray.
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
    /// Name of the scene: the files' and, in C, the variables'.
    #[arg(long, default_value = "scene")]
    name: String,
    /// Write the voxels too, slice after slice, nearest first.
    #[arg(long)]
    voxels: bool,
    /// Folder of the files.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Replace files that this program has not written.
    #[arg(long)]
    force: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum FormatArg {
    Rust,
    C,
    Json,
    Hex,
}

impl From<FormatArg> for Format {
    fn from(format: FormatArg) -> Self {
        match format {
            FormatArg::Rust => Self::Rust,
            FormatArg::C => Self::C,
            FormatArg::Json => Self::Json,
            FormatArg::Hex => Self::Hex,
        }
    }
}

impl From<ExportError> for Failure {
    fn from(error: ExportError) -> Self {
        match error {
            ExportError::Render(error) => error.into(),
            _ => Self::input(error),
        }
    }
}

impl Args {
    /// Writes the files.
    pub fn run(self) -> Result<(), Failure> {
        let mut loaded = self.volume.load()?;
        let mut scene = self.scene.load_for(&self.volume, &loaded)?;
        scene.image.size = self.size.or(scene.image.size);
        if let Some(note) = thicken(&mut loaded.volume, scene.borders) {
            eprintln!("note: {note}");
        }
        let prepared = Prepared::new(&scene, &loaded.volume)?;
        let files = files(&prepared, self.format.into(), &self.name, self.voxels)?;
        let names: Vec<String> = files.iter().map(|(name, _)| name.clone()).collect();
        let mut folder = Folder::open(&self.output, self.force)?;
        folder.check(&names)?;
        for (name, text) in &files {
            let path = folder.write(name, text.as_bytes())?;
            println!("{}: {} bytes", path.display(), text.len());
        }
        for (name, words) in Numbers::of(&prepared)?.about() {
            println!("{name:<9} {words}");
        }
        Ok(())
    }
}
