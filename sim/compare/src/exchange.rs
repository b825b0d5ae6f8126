//! Files for other people's tools: raw planes as NPY, geometry as JSON.

use std::io;

use npyz::WriterBuilder;
use serde_json::{Value, json};

use crate::Comparison;
use slicecast_engine::frame::Prepared;

/// The files that [`files`] makes.
pub const NAMES: [&str; 4] = ["core.npy", "model.npy", "table.npy", "geometry.json"];

/// The files of a comparison, name and contents:
///
/// - `core.npy`: the pipeline's base-plane image, raw bits, u32, shape (4, height, width): R, G, B, T;
/// - `model.npy`: the model's, f64, same shape;
/// - `table.npy`: the decoded table, u32, shape (4096, 4): R, G, B in 1.15, opacity of a step in 1.31;
/// - `geometry.json`: how rays, planes and pixels lie, in f64 and as the pipeline's integers.
///
/// # Errors
/// An encoder's own.
pub fn files(prepared: &Prepared<'_>, comparison: &Comparison) -> io::Result<[(&'static str, Vec<u8>); 4]> {
    let [core, model, table, geometry] = NAMES;
    let base = &comparison.frame.base;
    let shape = [4, base.size[1] as u64, base.size[0] as u64];
    let [r, g, b] = &comparison.model.rgb;
    let planes = [r, g, b, &comparison.model.t];
    Ok([
        (core, npy(&shape, base.planes.iter().flatten().copied())?),
        (model, npy(&shape, planes.into_iter().flatten().copied())?),
        (table, npy(&[4096, 4], decoded_table(prepared))?),
        (
            geometry,
            serde_json::to_vec_pretty(&self::geometry(prepared, comparison))?,
        ),
    ])
}

fn npy<T: npyz::AutoSerialize>(shape: &[u64], values: impl Iterator<Item = T>) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut writer = npyz::WriteOptions::new()
        .default_dtype()
        .shape(shape)
        .writer(&mut bytes)
        .begin_nd()?;
    writer.extend(values)?;
    writer.finish()?;
    Ok(bytes)
}

/// The table as the pipeline decodes it: R, G, B (1.15) and opacity (1.31) of every entry.
fn decoded_table(prepared: &Prepared<'_>) -> impl Iterator<Item = u32> {
    let table = &prepared.table;
    (0..table.entries.len()).flat_map(|index| {
        let [r, g, b] = table.colour(index).map(|c| slicecast::classify::colour_of_word(c, 15));
        [r, g, b, table.opacity(index).to_bits()]
    })
}

/// The geometry of a frame.
pub fn geometry(prepared: &Prepared<'_>, comparison: &Comparison) -> Value {
    let plan = &prepared.setup.plan;
    let view = plan.view();
    let forward = prepared.scene.view.axes().forward;
    let spacing = prepared.volume.spacing;
    let [i, j, k] = view.orient([0, 1, 2].map(|a| forward[a] / spacing[a]));
    let sampling = plan.sampling();
    let rate = f64::from(sampling.planes_per_voxel);
    json!({
        "volume": {
            "dims_xyz": prepared.volume.dims,
            "spacing_xyz": spacing,
            "value_of_code": { "scale": prepared.volume.mapping.scale, "offset": prepared.volume.mapping.offset },
        },
        "precision": prepared.scene.precision.name(),
        "channel_format": comparison.frame.base.format,
        "channel_one": comparison.frame.base.one,
        "major_axis": format!("{:?}", view.major()).to_lowercase(),
        "axes_ijk": view.arrange(["x", "y", "z"]),
        "reversed": view.reversed(),
        "dims_ijk": plan.volume(),
        "shear_per_voxel": [i / k, j / k],
        "step_per_plane": [i / k / rate, j / k / rate, 1.0 / rate],
        "step_per_plane_bits_32_32": plan.step().map(|s| s.to_bits()),
        "origin_voxels": plan.origin(),
        "base_size": comparison.frame.base.size,
        "rays_per_voxel": sampling.rays_per_voxel,
        "planes_per_voxel": sampling.planes_per_voxel,
        "planes": plan.planes(),
        "step_length": prepared.setup.step_length,
        "spacing_factors_bits_1_15": plan.spacing().map(|f| f.to_bits()),
        "position": "pixel (u, v) on plane p: i = origin_i + u / rays_per_voxel + p * step_i, j alike, k = p * step_k; \
                     slice k counts from the far end of the major axis if reversed",
    })
}
