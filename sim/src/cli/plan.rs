//! `slicecast plan`.

use slicecast::plan::Plan;
use slicecast::plane::Pipeline;
use slicecast::stream::Needs;
use slicecast_engine::camera::{Material, plan};
use slicecast_engine::pipelines::{Job, compile, dispatch};
use slicecast_scene::Blend;
use slicecast_volume::Mapping;

use super::Failure;
use super::inputs::{SceneArgs, dims, spacing};

/// Say what a scene needs in memory, before there is a volume.
#[derive(clap::Args)]
#[command(after_help = "Example:
  slicecast plan --dims 64x64x64 --scene bone.toml --precision compact")]
pub struct Args {
    /// Sides of the volume, voxels.
    #[arg(long, value_name = "WxHxD", value_parser = dims)]
    dims: [u64; 3],
    /// Distance between voxels.
    #[arg(long, value_name = "X,Y,Z", value_parser = spacing, default_value = "1,1,1")]
    spacing: [f64; 3],
    #[command(flatten)]
    scene: SceneArgs,
}

struct Count<'a>(&'a Plan);

impl Job for Count<'_> {
    type Output = Needs;

    fn run<L: Pipeline>(self, _: &L) -> Needs {
        Needs::of::<L>(self.0)
    }
}

impl Args {
    /// Does it.
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
        let needs = dispatch(&scene, &table, lights.as_ref(), Count(&plan)).map_err(Failure::input)?;
        let [slices, ranges, scratch, image] = needs.bytes();
        let [width, height, depth] = plan.dims();
        let [base_width, base_height] = plan.base();
        let lit = match (scene.blend, &lights) {
            (Blend::Maximum | Blend::Minimum, _) => "projection",
            (_, Some(_)) => "lit",
            (_, None) => "unlit",
        };
        println!("precision          {}, {lit}", scene.precision.name());
        println!(
            "slices             {depth} of {width} x {height} voxels along {:?}",
            plan.view().major()
        );
        println!(
            "base plane         {base_width} x {base_height} pixels, {} phase(s), {} plane(s)",
            plan.phases(),
            plan.planes()
        );
        println!();
        let ring = slices / (width as usize * height as usize * 2);
        for (name, bytes) in [
            (format!("slices ({ring} in the ring)"), slices),
            ("row ranges".to_owned(), ranges),
            ("rows under way".to_owned(), scratch),
            ("base-plane image".to_owned(), image),
        ] {
            println!("{name:<24}{bytes:>12} bytes");
        }
        let ram = slices + ranges + scratch + image;
        println!("{:<24}{ram:>12} bytes", "RAM in all");
        println!("{:<24}{:>12} bytes (may lie in flash)", "table", table.bytes());
        Ok(())
    }
}
