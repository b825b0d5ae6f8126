//! `slicecast plan`.

use serde::Serialize;
use slicecast::integral::Length;
use slicecast::project::Sum;
use slicecast::view::Axis;
use slicecast_engine::camera::{Material, clips, plan};
use slicecast_engine::fast;
use slicecast_engine::geometry::Geometry;
use slicecast_engine::integrals::Cumulative;
use slicecast_engine::modulation;
use slicecast_engine::parameters::Parameters;
use slicecast_engine::pipelines::{compile, rendering, rendering_of_segments};
use slicecast_engine::segments;
use slicecast_scene::{Classification, PrecisionName};
use slicecast_volume::Mapping;

use super::Failure;
use super::inputs::{SceneArgs, dims, spacing};

/// Say what a scene needs in memory, before there is a volume.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  slicecast plan --dims 64x64x64 --scene bone.toml --precision compact
  slicecast plan --dims 512x512x300 --spacing 0.5,0.5,1 --json")]
pub struct Args {
    /// Sides of the volume, voxels.
    #[arg(long, value_name = "WxHxD", value_parser = dims)]
    dims: [u64; 3],
    /// Distance between voxels.
    #[arg(long, value_name = "X,Y,Z", value_parser = spacing, default_value = "1,1,1")]
    spacing: [f64; 3],
    #[command(flatten)]
    scene: SceneArgs,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
}

/// What a scene needs, as JSON shows it. `docs/formats.md` lists the keys, and a test holds the two together.
#[derive(Serialize)]
struct Facts {
    precision: &'static str,
    shading: &'static str,
    axis: &'static str,
    reversed: bool,
    slice: [u32; 2],
    slices: u32,
    base_plane: [u32; 2],
    phases: u32,
    planes: u32,
    ring_slices: usize,
    slices_bytes: usize,
    ranges_bytes: usize,
    scratch_bytes: usize,
    image_bytes: usize,
    ram_bytes: usize,
    table_bytes: usize,
}

impl Args {
    /// Prints what the scene needs.
    pub fn run(self) -> Result<(), Failure> {
        let scene = self.scene.load()?;
        let dims = self.dims.map(|side| usize::try_from(side).unwrap_or(usize::MAX));
        let plan = plan(&scene, dims, self.spacing).map_err(Failure::input)?;
        let lights = match &scene.lighting {
            Some(lighting) => Some(Material::new(lighting, &scene.view.axes(), plan.view()).map_err(Failure::input)?),
            None => None,
        };
        let codes = Mapping {
            scale: 1.0,
            offset: 0.0,
        };
        let table = compile(&scene, &codes, 1.0);
        let mut table_bytes = match scene.precision {
            PrecisionName::Fast => fast::table(&table).bytes(),
            PrecisionName::Paper | PrecisionName::Compact | PrecisionName::Wide => table.bytes(),
        };
        let clips = clips(&scene, &plan, self.spacing).map_err(Failure::input)?;
        let geometry = Geometry {
            plan: &plan,
            clips: clips.as_ref(),
        };
        let modulation = modulation::of(&scene, &codes, self.spacing);
        let parameters = Parameters {
            material: lights.as_ref(),
            modulation: modulation.as_ref(),
            additive: Sum::Average,
            spread: None,
        };
        let with_volume = scene.classification != Classification::None;
        let rendering = if with_volume && scene.classification != Classification::Integral {
            rendering(&scene, &table, parameters, geometry)
        } else {
            let integrals = with_volume.then(|| Cumulative::compile(&scene.transfer, &codes, 1.0, 0));
            table_bytes = integrals.as_ref().map_or(0, Cumulative::bytes);
            let integrals = integrals.map(|integrals| integrals.classifier(Length::of(&plan)));
            let segments = segments::cut(integrals, &scene, &codes);
            rendering_of_segments(&scene, &segments, parameters, geometry)
        };
        let rendering = rendering.map_err(Failure::input)?;
        let needs = rendering.needs();
        let [slices, ranges, scratch, image] = needs.bytes();
        let [width, height, depth] = plan.dims();
        let view = plan.view();
        let facts = Facts {
            precision: scene.precision.name(),
            shading: match (scene.blend.is_composited(), &lights) {
                (false, _) => "projection",
                (true, Some(_)) => "lit",
                (true, None) => "unlit",
            },
            axis: match view.major() {
                Axis::X => "x",
                Axis::Y => "y",
                Axis::Z => "z",
            },
            reversed: view.reversed(),
            slice: [width, height],
            slices: depth,
            base_plane: plan.base(),
            phases: plan.phases(),
            planes: plan.planes_met().len() as u32,
            ring_slices: slices / (width as usize * height as usize * 2),
            slices_bytes: slices,
            ranges_bytes: ranges,
            scratch_bytes: scratch,
            image_bytes: image,
            ram_bytes: slices + ranges + scratch + image,
            table_bytes,
        };
        if self.json {
            let text = serde_json::to_string_pretty(&facts).map_err(Failure::machine)?;
            println!("{text}");
        } else {
            facts.print();
        }
        Ok(())
    }
}

impl Facts {
    fn print(&self) {
        let ([width, height], [base_width, base_height]) = (self.slice, self.base_plane);
        println!("precision          {}, {}", self.precision, self.shading);
        println!(
            "slices             {} of {width} x {height} voxels along {}{}",
            self.slices,
            self.axis,
            if self.reversed { ", from its far end" } else { "" }
        );
        println!(
            "base plane         {base_width} x {base_height} pixels, {} phase(s), {} plane(s)",
            self.phases, self.planes
        );
        println!();
        for (name, bytes) in [
            (
                format!("slices ({} in the ring)", self.ring_slices).as_str(),
                self.slices_bytes,
            ),
            ("row ranges", self.ranges_bytes),
            ("rows under way", self.scratch_bytes),
            ("base-plane image", self.image_bytes),
            ("RAM in all", self.ram_bytes),
        ] {
            println!("{name:<24}{bytes:>12} bytes");
        }
        println!("{:<24}{:>12} bytes (may lie in flash)", "table", self.table_bytes);
    }
}
