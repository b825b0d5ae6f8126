//! `slicecast render`.

use std::ffi::OsStr;
use std::path::PathBuf;
use std::time::Duration;

use slicecast_colours::Coloured;
use slicecast_compare::colours::picture_of;
use slicecast_engine::depth::depths;
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::image::{BaseImage, Frame};
use slicecast_engine::levels::Leveled;
use slicecast_engine::levels::budget::{Limits, Losses};
use slicecast_engine::levels::tree::Tree;
use slicecast_engine::oriented::{Oriented, Turned};
use slicecast_engine::parts::{Cut, Reading};
use slicecast_engine::perspective::{InPerspective, sharp};
use slicecast_engine::progress::Progress;
use slicecast_engine::shard::Shard;
use slicecast_engine::source::Source;
use slicecast_engine::threads::on_threads;
use slicecast_engine::tile::TILE_ROWS;
use slicecast_pyramid::volume::RgbaVolume;
use slicecast_scene::Scene;
use slicecast_scene::perspective::Perspective;
use slicecast_splat::Splatted;
use slicecast_volume::Volume;
use slicecast_volume::on_disk::OnDisk;
use slicecast_volume::open::Loaded;

use super::Failure;
use super::chosen::Chosen;
use super::colours::{ColourArgs, LevelArgs};
use super::inputs::{SceneArgs, ThreadArgs, VolumeArgs};
use super::laboratory::{Texture8Arg, texture_picture, texture8};
use super::memory::{self, Budget};
use super::output::{check_free, write_file};
use super::picture::{self, PictureArgs, Target};
use super::progress::with_bar;
use super::sampled::SampledArgs;
use super::splatted::{self, SplatArg};
use super::textured;
use crate::raster::{Raster, png, rgb_png};
use crate::slab::thicken;
use crate::{legend, shards, visibility};

/// Pixels along both sides of a picture in perspective of which nothing states a size.
const IN_PERSPECTIVE: u32 = 512;

/// Render a volume to a PNG picture.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  slicecast render -o head.png
  slicecast render scan.nrrd --scene bone.toml --precision wide --size 800x600 -o bone.png
  slicecast render scan.nrrd --background none --depth 16 -o - | other-program
  slicecast render angiogram.nrrd --scene mip -o vessels.png
  slicecast render --surface 200 --surface -300,#e0a080,0.3 -o skin-over-skull.png --depth-map depth.png
  slicecast render --scene ct-bone --fov 120 --eye 32,20,34 -o within.png
  slicecast render --scene ct-bone --splat -o splatted.png
  slicecast render large.nrrd --memory 1GiB --scene bone.toml -o large.png
  slicecast render large.nrrd --budget 256MiB --scene bone.toml -o preview.png
  slicecast render colours.nrrd --alpha-distance 1 --precision wide -o colours.png
  slicecast render scan.nrrd --scene fog.toml --unlit --level 2 -o preview.png
  slicecast render voxels.raw --raw-dims 256x256x128 --raw-type uint8 --scene fog.toml -o fog.png")]
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
    picture: PictureArgs,
    #[command(flatten)]
    threads: ThreadArgs,
    /// The picture, a PNG; - is standard output. The legend of a label map is written beside it (.legend.png, .legend.json).
    #[arg(short, long, value_name = "FILE", default_value = "image.png")]
    output: PathBuf,
    /// Push the slices one by one through the stream layer, as firmware does.
    #[arg(long)]
    stream: bool,
    /// Draw what texture hardware of 8 bits computes of the scene, for comparison: classified after the filter (post; normalised: its normals
    /// are brought to their length again), before it (pre), or before it with colours times opacity (weighted); products after Blinn, or by one shift. `slicecast texture` says how far it is.
    #[arg(long, value_parser = texture8(), value_name = "PIPELINE", conflicts_with_all = ["stream", "depth_map", "shard", "memory", "budget"])]
    texture8: Option<Texture8Arg>,
    /// Splat the voxels into sheets that are parallel to the picture, in place of following rays: in samples, front to back, of the whole
    /// volume. Each voxel is kept in a record of 64 bits: fine, or as Squeeze has it (paper).
    #[arg(long, value_enum, value_name = "RECORD", num_args = 0..=1, default_missing_value = "fine", require_equals = true,
          conflicts_with_all = ["stream", "depth_map", "shard", "memory", "budget", "texture8"])]
    splat: Option<SplatArg>,
    /// The depth of the first surface, a PNG of 16-bit grey levels: 1 on the first plane to 65535 on the last, 0 where no
    /// surface is met.
    #[arg(long, value_name = "FILE", value_parser = picture::png_file)]
    depth_map: Option<PathBuf>,
    /// Render one shard of several, I from 1 to N, as on a machine of an array job; -o names its file, which ends in .shard.
    /// `slicecast merge` makes the picture of all.
    #[arg(long, value_name = "I/N", value_parser = picture::shard, conflicts_with_all = ["stream", "depth_map"])]
    shard: Option<Shard>,
    /// Leave the volume in its file and read it in parts, within so much memory, such as 512MiB or 2GiB: for raw, NRRD,
    /// MetaImage, NIfTI and Zarr files that are larger than memory. The picture is the same.
    #[arg(long, value_name = "SIZE", value_parser = memory::bytes, conflicts_with_all = ["stream", "depth_map"])]
    memory: Option<u64>,
    /// Keep the picture within so much memory, such as 128MiB, or its frame within a time, such as 200ms, or both: bricks of the
    /// volume that show least are taken from levels whose voxels are two, four or eight times as long; what fits is not made coarser.
    /// By memory, for raw, NRRD, MetaImage, NIfTI and Zarr files. Times are measured on this machine, by a few frames.
    #[arg(long, value_name = "SIZE|TIME", value_delimiter = ',', value_parser = memory::budget, conflicts_with_all = ["stream", "depth_map", "shard", "memory"])]
    budget: Vec<Budget>,
    /// Replace the output if it exists.
    #[arg(long)]
    force: bool,
}

impl Args {
    /// Renders the picture.
    pub fn run(self) -> Result<(), Failure> {
        let target = if self.shard.is_some() {
            self.check_shard()?;
            None
        } else {
            Some(Target::checked(&self.output, vec![self.output.clone()], self.force)?)
        };
        check_free(&self.depth_map, self.force)?;
        if self.depth_map.as_ref() == Some(&self.output) {
            return Err(Failure::input(
                "--depth-map: names the picture's own file, expected another",
            ));
        }
        if let Some((scene, volume)) = self.level.volume(&self.volume, &self.colours, &self.scene)? {
            textured::check_none(self.texture8.is_some())?;
            splatted::check_none(self.splat.is_some(), "volume of colours")?;
            return self.render_colours(target, scene, &volume);
        }
        let (budget_memory, budget_time) = self.budgets()?;
        let option = if self.memory.is_some() { "--memory" } else { "--budget" };
        let (mut loaded, on_disk) = match self.memory.or(budget_memory) {
            Some(_) => {
                let (loaded, on_disk) = self.volume.load_on_disk(option)?;
                (loaded, Some(on_disk))
            }
            None => (self.volume.load()?, None),
        };
        self.colours.check_none(&loaded)?;
        self.sampled.check_none(&loaded.volume.name)?;
        let mut chosen = match &on_disk {
            Some(voxels) => self.scene.choose_from(&self.volume, &loaded, voxels)?,
            None => self.scene.choose(&self.volume, &loaded)?,
        };
        self.picture.apply(&mut chosen.scene);
        if let Some(perspective) = chosen.scene.perspective {
            if let (Some(splat), Some(target)) = (self.splat, &target) {
                // The image is as fine as the picture, or finer where pixels would be farther apart than voxels.
                let scene = &mut chosen.scene;
                scene.image.size = Some(self.picture.size().or(scene.image.size).unwrap_or([IN_PERSPECTIVE; 2]));
                if !self.scene.sampling_stated()[0] {
                    scene.sampling.rays_per_voxel = 1;
                }
                return self.render_splatted(target, scene, &loaded.volume, splat);
            }
            return self.render_in_perspective(target, chosen.scene, &perspective, &loaded.volume);
        }
        let legend = match &target {
            Some(target) => self.legend(target, &chosen, &loaded)?,
            None => Vec::new(),
        };
        if on_disk.is_none()
            && let Some(note) = thicken(&mut loaded.volume, chosen.scene.borders)
        {
            eprintln!("note: {note}");
        }
        let scenes = std::slice::from_ref(&chosen.scene);
        let framing = self.picture.frame(scenes, &loaded.volume, &self.scene)?;
        let scene = framing.scene(&chosen.scene, &loaded.volume);
        if let (Some(splat), Some(target)) = (self.splat, &target) {
            return self.render_splatted(target, &scene, &loaded.volume, splat);
        }
        let prepared = match &on_disk {
            Some(volume) => Prepared::of(&scene, &loaded.volume, volume)?,
            None => Prepared::new(&scene, &loaded.volume)?,
        };
        let prepared = prepared.with_simd(self.threads.simd());
        if let Some(note) = visibility::fineness(&prepared) {
            eprintln!("note: {note}");
        }
        if let (Some(pipeline), Some(target)) = (self.texture8, &target) {
            return self.render_texture(&prepared, pipeline, target);
        }
        let target = match (target, self.shard) {
            (Some(target), _) => target,
            (None, shard) => return self.write_shard(&prepared, on_disk.as_ref(), shard.unwrap_or(Shard::ALL)),
        };
        let frame = with_bar("rendering", |progress| {
            on_threads(self.threads.count(), || match &on_disk {
                Some(volume) if !self.budget.is_empty() => {
                    in_levels(&prepared, volume, (budget_memory, budget_time), progress)
                }
                None if !self.budget.is_empty() => in_levels(&prepared, &loaded.volume, (None, budget_time), progress),
                Some(volume) => {
                    let cut = self.cut(&prepared, volume)?;
                    let (frame, read) = prepared.render_in_parts(volume, cut, progress)?;
                    say_read(&read, volume);
                    Ok(frame)
                }
                None => prepared.render(self.layer(), progress),
            })
        })??;
        let depth_map = self.depth_map(&prepared)?;
        if let Some(warning) = visibility::warning(&prepared, &frame, &chosen.circumstances()) {
            eprintln!("warning: {warning}");
        }
        let raster = self.picture.raster(&scene, &prepared.setup.picture, frame);
        self.write(&target, &raster)?;
        for (path, contents) in legend {
            write_file(&path, self.force, &contents)?;
            println!("{}: the labels' colours", path.display());
        }
        if let (Some(path), Some((png, said))) = (&self.depth_map, depth_map) {
            write_file(path, self.force, &png)?;
            println!("{}: {said}", path.display());
        }
        Ok(())
    }

    /// What `--budget` says of memory and of time, one of each at most.
    fn budgets(&self) -> Result<(Option<u64>, Option<Duration>), Failure> {
        let (mut memory, mut time) = (None, None);
        for budget in &self.budget {
            let twice = match *budget {
                Budget::Memory(bytes) => memory.replace(bytes).is_some(),
                Budget::Time(limit) => time.replace(limit).is_some(),
            };
            if twice {
                return Err(Failure::input(
                    "--budget: two of a kind, expected one size, one time, or both (128MiB,200ms)",
                ));
            }
        }
        Ok((memory, time))
    }

    /// How slices reach the pipeline.
    fn layer(&self) -> Layer {
        if self.stream {
            Layer::Stream
        } else {
            Layer::Tiles(TILE_ROWS)
        }
    }

    /// Writes the picture.
    fn write(&self, target: &Target, raster: &Raster) -> Result<(), Failure> {
        let [width, height] = raster.size();
        let picture = png(raster).map_err(Failure::machine)?;
        target.write(self.force, &[picture], &format!("{width} x {height} pixels"))
    }

    /// Draws the scene as a pipeline of 8 bits has it.
    fn render_texture(&self, prepared: &Prepared<'_>, pipeline: Texture8Arg, target: &Target) -> Result<(), Failure> {
        if !self.picture.is_plain() {
            return Err(Failure::input(
                "--texture8: is drawn in 8 bits in front of a background, expected no --depth 16 and no --background none",
            ));
        }
        let picture = texture_picture(prepared, pipeline, &self.threads)?;
        self.write(target, &picture.into())
    }

    /// Renders a volume of colour and extinction.
    fn render_colours(&self, target: Option<Target>, mut scene: Scene, volume: &RgbaVolume) -> Result<(), Failure> {
        let target = match (target, &self.depth_map) {
            (Some(target), None) => target,
            (None, _) => return Err(Failure::input("--shard: shards are of volumes of one value a voxel")),
            (_, Some(_)) => {
                let message = "--depth-map: a volume of colour and extinction has no surfaces";
                return Err(Failure::input(message));
            }
        };
        self.picture.apply(&mut scene);
        let framing = self.picture.frame(std::slice::from_ref(&scene), volume, &self.scene)?;
        let scene = framing.scene(&scene, volume);
        let prepared = Coloured::new(&scene, volume)?.with_simd(self.threads.simd());
        if let Some(interpolated) = self.sampled.interpolated(volume)? {
            if self.stream || !self.picture.is_plain() {
                return Err(Failure::input(
                    "--sampling: by opacity is drawn in f64, in 8 bits in front of a background, expected no --stream, --depth 16 \
                     and --background none",
                ));
            }
            let picture = on_threads(self.threads.count(), || picture_of(&prepared, interpolated))?;
            return self.write(&target, &picture.into());
        }
        let frame = with_bar("rendering", |progress| {
            on_threads(self.threads.count(), || prepared.render(self.layer(), progress))
        })??;
        let BaseImage {
            planes: [.., transparency],
            one,
            ..
        } = &frame.base;
        if transparency.iter().all(|left| left == one) {
            eprintln!("warning: the picture shows nothing: no ray meets a voxel with an opacity");
        }
        self.write(&target, &self.picture.raster(&scene, &prepared.setup.picture, frame))
    }

    /// Renders a scene whose voxels are splatted.
    fn render_splatted(&self, target: &Target, scene: &Scene, volume: &Volume, splat: SplatArg) -> Result<(), Failure> {
        let splatted = Splatted::new(scene, volume, splat.into())?.with_simd(self.threads.simd());
        let frame = with_bar("splatting", |progress| {
            on_threads(self.threads.count(), || splatted.render(progress))
        })??;
        let BaseImage {
            planes: [.., transparency],
            one,
            ..
        } = &frame.base;
        if transparency.iter().all(|left| left == one) {
            eprintln!("warning: the picture shows nothing: no sheet has a sample with an opacity");
        }
        self.write(target, &self.picture.raster(scene, &splatted.picture, frame))
    }

    /// Renders a view in perspective.
    fn render_in_perspective(
        &self,
        target: Option<Target>,
        mut scene: Scene,
        perspective: &Perspective,
        volume: &Volume,
    ) -> Result<(), Failure> {
        let refused = [
            ("--memory", self.memory.is_some()),
            ("--budget", !self.budget.is_empty()),
            ("--depth-map", self.depth_map.is_some()),
        ];
        let refused = refused.into_iter().find(|(_, given)| *given).map(|(option, _)| option);
        let target = match (target, refused) {
            (Some(target), None) => target,
            (_, option) => {
                let option = option.unwrap_or("--shard");
                return Err(Failure::input(format!(
                    "{option}: is of parallel views, and the scene is in perspective"
                )));
            }
        };
        let [rays, _] = self.scene.sampling_stated();
        scene.image.size = Some(self.picture.size().or(scene.image.size).unwrap_or([IN_PERSPECTIVE; 2]));
        if !rays {
            scene.sampling.rays_per_voxel = sharp(&scene, perspective, volume).map_err(RenderError::from)?;
            if scene.sampling.rays_per_voxel > 1 {
                let rays = scene.sampling.rays_per_voxel;
                eprintln!("sampling: --rays {rays} per voxel of the farthest slice, for a sharp picture");
            }
        }
        let prepared = InPerspective::new(&scene, perspective, volume).map_err(RenderError::from)?;
        let prepared = prepared.with_simd(self.threads.simd());
        let frame = with_bar("rendering", |progress| {
            on_threads(self.threads.count(), || prepared.render(self.layer(), progress))
        })??;
        let BaseImage {
            planes: [.., transparency],
            one,
            ..
        } = &frame.base;
        if transparency.iter().all(|left| left == one) {
            eprintln!("warning: the picture shows nothing: no ray from the eye meets a sample with an opacity");
        }
        self.write(&target, &self.picture.raster(&scene, &prepared.picture(), frame))
    }

    /// The file of a shard, found fit to be written before there is anything to write.
    fn check_shard(&self) -> Result<(), Failure> {
        if self.output.extension().and_then(OsStr::to_str) != Some("shard") {
            return Err(Failure::input(format!(
                "{}: with --shard a shard is written, expected a name that ends in .shard",
                self.output.display()
            )));
        }
        check_free([&self.output], self.force)
    }

    /// How the volume is cut for what --memory leaves room for.
    fn cut(&self, prepared: &Prepared<'_>, volume: &OnDisk) -> Result<Cut, RenderError> {
        prepared.cut_within(volume, self.memory.unwrap_or(u64::MAX))
    }

    /// Renders a shard into its file.
    fn write_shard(&self, prepared: &Prepared<'_>, on_disk: Option<&OnDisk>, shard: Shard) -> Result<(), Failure> {
        let (number, count) = (shard.number(), shard.count());
        let most = Shard::most(&prepared.setup.plan);
        if count > most {
            return Err(Failure::input(format!(
                "--shard {number}/{count}: the frame has {most} strips of rows, expected at most as many shards"
            )));
        }
        let base = with_bar("rendering", |progress| {
            on_threads(self.threads.count(), || match on_disk {
                Some(volume) => {
                    let cut = self.cut(prepared, volume)?;
                    let (base, read) = prepared.render_shard_in_parts(volume, cut, shard, progress)?;
                    say_read(&read, volume);
                    Ok(base)
                }
                None => prepared.render_shard(shard, progress),
            })
        })??;
        let file = shards::file(prepared, &base, shard).map_err(Failure::machine)?;
        write_file(&self.output, self.force, &file)?;
        println!("{}: shard {number} of {count}", self.output.display());
        Ok(())
    }

    /// The depth map, if it is asked for, and what its levels mean.
    fn depth_map(&self, prepared: &Prepared<'_>) -> Result<Option<(Vec<u8>, String)>, Failure> {
        if self.depth_map.is_none() {
            return Ok(None);
        }
        let plan = &prepared.setup.plan;
        let mut turned = Turned::new(prepared.volume, plan);
        let slices = turned.slices().map_err(Failure::input)?;
        let volume = Oriented::of(&slices);
        let found = with_bar("depths", |progress| {
            on_threads(self.threads.count(), || depths(prepared, &volume, progress))
        })??;
        let Some(found) = found else {
            return Err(Failure::input(
                "--depth-map: the scene has no visible surface; --surface adds one",
            ));
        };
        let picture = &prepared.setup.picture;
        let levels = found.warped(picture).levels(plan.ends());
        let png = png(&Raster::grey16(picture.size, &levels)).map_err(Failure::machine)?;
        let deep = f64::from(plan.ends() - 1) * prepared.setup.step_length;
        let said = format!(
            "depths of the first surface, 1 to 65535 for {} along a ray, 0 where there is none",
            visibility::rounded(deep, 6)
        );
        Ok(Some((png, said)))
    }

    /// The legend of a label map, as files beside the picture; found fit to be written.
    fn legend(&self, target: &Target, chosen: &Chosen, loaded: &Loaded) -> Result<Vec<(PathBuf, Vec<u8>)>, Failure> {
        let Some(labels) = chosen.labels(loaded) else {
            return Ok(Vec::new());
        };
        if let Target::Standard = target {
            eprintln!("note: the labels' colours are written only beside a file; `slicecast inspect` lists them");
            return Ok(Vec::new());
        }
        let json = legend::json(&loaded.volume.name, &labels).map_err(Failure::machine)?;
        let picture = rgb_png(legend::picture(&labels)).map_err(Failure::machine)?;
        let files = [("legend.json", json), ("legend.png", picture)];
        let files = files.map(|(ending, contents)| (self.output.with_extension(ending), contents));
        check_free(files.each_ref().map(|(path, _)| path), self.force)?;
        Ok(files.into())
    }
}

/// Renders a volume in the levels that a budget of memory, or of time, leaves room for, and says on standard error which these are.
fn in_levels(
    prepared: &Prepared<'_>,
    volume: &dyn Source,
    (memory, time): (Option<u64>, Option<Duration>),
    progress: Progress<'_>,
) -> Result<Frame, RenderError> {
    // Losses, voxels and the picture, in thousandths of a third each.
    let third = |number: usize| move |done: usize, all: usize| progress(1000 * number + 1000 * done / all.max(1), 3000);
    // Refused before anything is read.
    Leveled::new(prepared, &Tree::Leaf(0))?;
    let losses = Losses::of(prepared, volume, &third(0))?;
    if let Some(time) = time {
        let timed = losses.within_time(prepared, volume, (time, memory), &third(2))?;
        let milliseconds = |time: Duration| time.as_secs_f64() * 1000.0;
        eprintln!(
            "{}; the frame took {:.1} of {:.1} ms, found by {} frames",
            timed.chosen,
            milliseconds(timed.took),
            milliseconds(time),
            timed.frames,
        );
        say_opaque(&Leveled::new(prepared, &timed.chosen.tree)?);
        return Ok(timed.frame);
    }
    let limits = Limits { memory, work: None };
    let chosen = losses.ordered(prepared, volume, false)?.within(limits)?;
    eprintln!("{chosen}");
    let leveled = Leveled::new(prepared, &chosen.tree)?;
    say_opaque(&leveled);
    let bricks = leveled.bricks(volume, &third(1))?;
    leveled.render(&bricks, &third(2))
}

/// Says on standard error that steps are too opaque for what faces cut of them.
fn say_opaque(leveled: &Leveled<'_>) {
    if let Some(steps) = leveled.opaque_steps() {
        eprintln!("note: {steps}");
    }
}

/// Says on standard error what was read of a volume in parts.
fn say_read(read: &Reading, volume: &OnDisk) {
    eprintln!("{read}");
    if let Some([read, all]) = volume.chunks_read() {
        eprintln!("chunks were read {read} times, the census' passes with them; the volume has {all}");
    }
}
