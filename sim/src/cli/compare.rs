//! `slicecast compare`.

use std::path::PathBuf;

use serde::Serialize;
use slicecast_colours::Coloured;
use slicecast_compare::colours::{CONVERGED, compare_colours, compare_sampling};
use slicecast_compare::exchange;
use slicecast_compare::image::ImageFigures;
use slicecast_compare::perspective::compare as in_perspective;
use slicecast_compare::splat::compare as compare_splatted;
use slicecast_compare::stages::StageReport;
use slicecast_compare::statistics::Figures;
use slicecast_compare::{Comparison, ModelPositions, Split, compare, split};
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::Prepared;
use slicecast_engine::perspective::InPerspective;
use slicecast_engine::threads::on_threads;
use slicecast_pyramid::volume::RgbaVolume;
use slicecast_scene::perspective::Perspective;
use slicecast_scene::{AlphaCodeName, Interpolation, LookupName, Scene};
use slicecast_splat::Splatted;

use slicecast_volume::Volume;

use super::Failure;
use super::colours::{ColourArgs, LevelArgs};
use super::inputs::{SceneArgs, ThreadArgs, VolumeArgs};
use super::laboratory::{Texture8Arg, compare_textures, texture8};
use super::output::{Folder, check_free, write_file};
use super::progress::with_bar;
use super::sampled::SampledArgs;
use super::splatted::{self, SplatArg};
use super::tables;
use super::textured;
use crate::visibility;

/// Compare every stage, and the picture, with the f64 model.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  slicecast compare
  slicecast compare --converged                 error of the arithmetic, of the algorithm, and both together
  slicecast compare scan.nrrd --scene bone.toml --precision wide --exact-positions --json errors.json
  slicecast compare scan.nrrd --scene bone.toml --specular 0 --texture8 post,pre
  slicecast compare scan.nrrd --scene bone.toml --npy planes/")]
pub struct Args {
    #[command(flatten)]
    volume: VolumeArgs,
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    colours: ColourArgs,
    #[command(flatten)]
    level: LevelArgs,
    #[command(flatten)]
    sampled: SampledArgs,
    #[command(flatten)]
    threads: ThreadArgs,
    /// Let the model sample at the real positions instead of the pipeline's 16.16 ones.
    #[arg(long)]
    exact_positions: bool,
    /// Also compare with the converged integral: the error of the arithmetic (against f64 of the same algorithm), of the
    /// algorithm (that f64 against the integral: planes, steps, borders), and both together, which is what a viewer sees.
    /// Takes several times as long; `slicecast report` always shows it.
    #[arg(long)]
    converged: bool,
    /// Compare pipelines of texture hardware of 8 bits instead, beside the scene's precision: with f64 of the same samples, and with the
    /// converged integral. They have no specular light, and count a sample at a border as a whole step or not at all.
    #[arg(long, value_parser = texture8(), value_name = "PIPELINE", value_delimiter = ',', conflicts_with_all = ["npy", "exact_positions", "converged"])]
    texture8: Vec<Texture8Arg>,
    /// Compare the scene with its voxels splatted into sheets instead, with f64 of the same sheets at exact places. Each voxel is kept in
    /// a record of 64 bits: fine, or as Squeeze has it (paper).
    #[arg(long, value_enum, value_name = "RECORD", num_args = 0..=1, default_missing_value = "fine", require_equals = true,
          conflicts_with_all = ["npy", "exact_positions", "converged", "texture8"])]
    splat: Option<SplatArg>,
    /// Write the figures as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write the base-plane images of pipeline and model, the geometry and the decoded table for other tools.
    #[arg(long, value_name = "DIR")]
    npy: Option<PathBuf>,
    /// Replace files that exist.
    #[arg(long)]
    force: bool,
}

/// One line of `stages` in the JSON.
#[derive(Serialize)]
struct StageLine<'a> {
    name: &'a str,
    format: &'a str,
    /// `local` or `carried`.
    error: &'static str,
    required_bits: Option<u32>,
    #[serde(flatten)]
    figures: Figures,
}

/// The figures as JSON.
#[derive(Serialize)]
pub struct Figured<'a> {
    volume: &'a str,
    precision: &'static str,
    table: AlphaCodeName,
    lookup: LookupName,
    positions: &'static str,
    image: ImageFigures,
    picture: ImageFigures,
    #[serde(skip_serializing_if = "Option::is_none")]
    split: Option<Split>,
    stages: Vec<StageLine<'a>>,
}

/// Gathers the figures of a comparison for JSON.
pub fn figured<'a>(prepared: &'a Prepared<'_>, comparison: &'a Comparison, positions: ModelPositions) -> Figured<'a> {
    let line = |stage: &'a StageReport, error, figures| StageLine {
        name: stage.name,
        format: &stage.format,
        error,
        required_bits: stage.required_bits,
        figures,
    };
    Figured {
        volume: &prepared.volume.name,
        precision: prepared.scene.precision.name(),
        table: prepared.table.code,
        lookup: prepared.table.lookup,
        positions: match positions {
            ModelPositions::Pipeline => "pipeline",
            ModelPositions::Exact => "exact",
        },
        image: comparison.image,
        picture: comparison.picture,
        split: None,
        stages: comparison
            .stages
            .iter()
            .flat_map(|stage| [line(stage, "local", stage.local), line(stage, "carried", stage.carried)])
            .collect(),
    }
}

/// The figures of a picture as JSON: of a volume of colour and extinction, or in perspective.
#[derive(Serialize)]
struct PictureFigures<'a> {
    volume: &'a str,
    precision: &'static str,
    image: ImageFigures,
    picture: ImageFigures,
}

impl Args {
    /// Which positions the model takes its samples at.
    fn positions(&self) -> ModelPositions {
        if self.exact_positions {
            ModelPositions::Exact
        } else {
            ModelPositions::Pipeline
        }
    }

    /// Compares the picture of a volume of colour and extinction.
    fn compare_colours(&self, scene: &Scene, volume: &RgbaVolume) -> Result<(), Failure> {
        if self.converged || self.npy.is_some() {
            let message = "--converged, --npy: are of volumes of one value a voxel";
            return Err(Failure::input(message));
        }
        let prepared = Coloured::new(scene, volume)?.with_simd(self.threads.simd());
        if let Some(interpolated) = self.sampled.interpolated(volume)? {
            let found = on_threads(self.threads.count(), || compare_sampling(&prepared, interpolated))?;
            let reference = format!("extinctions, {CONVERGED} planes");
            println!(
                "{}",
                tables::images(&[
                    ("opacities to extinctions".to_owned(), found.apart),
                    (format!("extinctions to {reference}"), found.extinctions),
                    (format!("opacities to {reference}"), found.opacities),
                ])
            );
            if let Some(path) = &self.json {
                let text = serde_json::to_string_pretty(&found).map_err(Failure::machine)?;
                write_file(path, self.force, text.as_bytes())?;
            }
            return Ok(());
        }
        let comparison = with_bar("comparing", |progress| {
            on_threads(self.threads.count(), || {
                compare_colours(&prepared, self.positions(), progress)
            })
        })??;
        self.say(scene, &volume.name, [comparison.image, comparison.picture])
    }

    /// Compares a view in perspective with the model, at exact positions.
    fn compare_in_perspective(&self, scene: &Scene, perspective: &Perspective, volume: &Volume) -> Result<(), Failure> {
        if self.converged || self.npy.is_some() {
            let message = "--converged, --npy: are of parallel views, and the scene is in perspective";
            return Err(Failure::input(message));
        }
        let prepared = InPerspective::new(scene, perspective, volume).map_err(RenderError::from)?;
        let prepared = prepared.with_simd(self.threads.simd());
        let comparison = with_bar("comparing", |progress| {
            on_threads(self.threads.count(), || {
                in_perspective(scene, volume, &prepared, progress)
            })
        })??;
        self.say(scene, &volume.name, [comparison.image, comparison.picture])
    }

    /// Compares a scene whose voxels are splatted with the model, at exact places.
    fn compare_splatted(&self, scene: &Scene, volume: &Volume, splat: SplatArg) -> Result<(), Failure> {
        let splatted = Splatted::new(scene, volume, splat.into())?.with_simd(self.threads.simd());
        let comparison = with_bar("comparing", |progress| {
            on_threads(self.threads.count(), || {
                compare_splatted(scene, volume, &splatted, progress)
            })
        })??;
        self.say(scene, &volume.name, [comparison.image, comparison.picture])
    }

    /// Says how far base plane and picture are from the model's.
    fn say(&self, scene: &Scene, volume: &str, [image, picture]: [ImageFigures; 2]) -> Result<(), Failure> {
        let precision = scene.precision.name();
        println!(
            "{}",
            tables::images(&[
                (format!("{precision}, base plane"), image),
                (format!("{precision}, picture"), picture),
            ])
        );
        if let Some(path) = &self.json {
            let figures = PictureFigures {
                volume,
                precision,
                image,
                picture,
            };
            let text = serde_json::to_string_pretty(&figures).map_err(Failure::machine)?;
            write_file(path, self.force, text.as_bytes())?;
        }
        Ok(())
    }

    /// Compares pipelines of 8 bits.
    fn compare_textures(&self, prepared: &Prepared<'_>) -> Result<(), Failure> {
        let [table, json] = compare_textures(prepared, &self.texture8, &self.threads)?;
        println!("{table}");
        if let Some(path) = &self.json {
            write_file(path, self.force, json.as_bytes())?;
        }
        Ok(())
    }

    /// Compares the scene with the model.
    pub fn run(self) -> Result<(), Failure> {
        check_free(&self.json, self.force)?;
        if let Some((scene, volume)) = self.level.volume(&self.volume, &self.colours, &self.scene)? {
            textured::check_none(!self.texture8.is_empty())?;
            splatted::check_none(self.splat.is_some(), "volume of colours")?;
            return self.compare_colours(&scene, &volume);
        }
        let loaded = self.volume.load()?;
        self.colours.check_none(&loaded)?;
        self.sampled.check_none(&loaded.volume.name)?;
        let chosen = self.scene.choose(&self.volume, &loaded)?;
        let scene = &chosen.scene;
        if let Some(perspective) = &scene.perspective {
            if let Some(splat) = self.splat {
                return self.compare_splatted(scene, &loaded.volume, splat);
            }
            return self.compare_in_perspective(scene, perspective, &loaded.volume);
        }
        if let Some(splat) = self.splat {
            return self.compare_splatted(scene, &loaded.volume, splat);
        }
        let prepared = Prepared::new(scene, &loaded.volume)?.with_simd(self.threads.simd());
        if !self.texture8.is_empty() {
            return self.compare_textures(&prepared);
        }
        let mut folder = match &self.npy {
            Some(path) => {
                let folder = Folder::open(path, self.force)?;
                folder.check(&exchange::NAMES.map(str::to_owned))?;
                Some(folder)
            }
            None => None,
        };
        let positions = self.positions();
        let comparison = with_bar("comparing", |progress| {
            on_threads(self.threads.count(), || compare(&prepared, positions, progress))
        })??;
        if let Some(warning) = visibility::warning(&prepared, &comparison.frame, &chosen.circumstances()) {
            eprintln!("warning: {warning}");
        }
        println!("{}", tables::local(&comparison.stages));
        println!();
        println!("{}", tables::carried(&comparison.stages));
        println!();
        let mut lines = tables::image_lines(scene.precision.name(), &comparison).to_vec();
        if self.converged && scene.interpolation == Interpolation::Nearest {
            return Err(Failure::input(
                "--converged: the integral is of values interpolated between voxels, and the scene samples the nearest one",
            ));
        }
        if self.converged {
            prepared.check_linear()?;
        }
        let split = if self.converged {
            let split = with_bar("converging", |progress| {
                on_threads(self.threads.count(), || split(&prepared, &comparison, progress))
            })??;
            lines.extend(tables::split_lines(&split));
            Some(split)
        } else {
            None
        };
        println!("{}", tables::images(&lines));
        if !self.converged {
            println!(
                "\nThis is the error of the arithmetic. --converged adds that of the algorithm, and both together."
            );
        }
        if prepared.segments.is_none() && prepared.table.underflows > 0 {
            let note = format!(
                "note: {} table entries are visible in the transfer function and fall to 0 in the table",
                prepared.table.underflows
            );
            println!("\n{}", tables::paragraph(&note, "  "));
        }
        if let Some(path) = &self.json {
            let figures = Figured {
                split,
                ..figured(&prepared, &comparison, positions)
            };
            let json = serde_json::to_vec_pretty(&figures).map_err(Failure::machine)?;
            write_file(path, self.force, &json)?;
        }
        if let Some(folder) = &mut folder {
            for (name, contents) in exchange::files(&prepared, &comparison).map_err(Failure::machine)? {
                folder.write(name, &contents)?;
            }
        }
        Ok(())
    }
}
