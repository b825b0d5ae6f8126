//! Volumes of materials as several subcommands take them: shares, and the table of what they are shares of.

use std::path::PathBuf;

use slicecast_pyramid::materials::{Material, Shared, of_shares};
use slicecast_pyramid::read::Read;
use slicecast_scene::materials::{self, MaterialTable, VoxelOfMaterials};
use slicecast_volume::open;

use super::Failure;
use super::inputs::VolumeArgs;

/// The table of a volume of materials.
#[derive(clap::Args, Default)]
pub struct MaterialArgs {
    /// The volume has shares of materials, in 255ths of a voxel, side by side in an NRRD file: a share of each of up to 8 materials
    /// of this table (TOML), or a label and its share.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["alpha_distance", "tau_max", "opacity"])]
    materials: Option<PathBuf>,
}

impl MaterialArgs {
    /// Whether there is a table.
    pub fn given(&self) -> bool {
        self.materials.is_some()
    }

    /// The volume of a table, if there is one.
    pub fn read(&self, volume: &VolumeArgs) -> Result<Option<Read>, Failure> {
        let Some(path) = &self.materials else { return Ok(None) };
        let table = materials::read(path).map_err(Failure::input)?;
        let shares = open::read_shares(volume.alone("--materials")?).map_err(Failure::input)?;
        let [x, y, z] = shares.dims();
        eprintln!(
            "{}: {x} x {y} x {z} voxels of {} values, {} materials",
            shares.name(),
            shares.components(),
            table.materials.len()
        );
        shares.notes().iter().for_each(|note| eprintln!("note: {note}"));
        let made = of_shares(&shares, &shared(&table));
        let volume = made.map_err(|error| Failure::input(format!("{}: {error}", shares.name())))?;
        Ok(Some(Read {
            volume,
            capped: 0,
            lost: 0,
        }))
    }
}

/// The table as it is mixed: colours in 8 bits.
fn shared(table: &MaterialTable) -> Shared {
    let material = |material: &materials::Material| Material {
        colour: material.colour.map(|c| (255.0 * c).round() as u8),
        extinction: material.extinction,
    };
    match table.voxel {
        VoxelOfMaterials::Shares => Shared::Each(table.materials.iter().map(material).collect()),
        VoxelOfMaterials::LabelShare => {
            let labelled = table.materials.iter().map(|of| (of.label, material(of)));
            Shared::Labelled(labelled.collect())
        }
    }
}
