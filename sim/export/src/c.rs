//! A scene as a C header, for `slicecast.h`.

use std::fmt::{Display, Write};

use slicecast::borders::Borders;
use slicecast::format::{Coefficient, Intensity, Step, Vector};
use slicecast_scene::{AlphaCodeName, Blend};

use crate::quantity::of_scene;
use crate::table::{Language, table};
use crate::{ExportError, Numbers, Shading};

/// What the C interface has.
const ACCEPTED: &str = "front to back without early termination; paper with sqrt8 and nearest, compact and wide with sqrt16 or \
                        colour16 and linear";

/// The header, and with voxels one that holds them.
///
/// # Errors
/// [`ExportError::NoPipeline`] if the C interface has none for the scene.
pub fn files(numbers: &Numbers<'_>, name: &str, voxels: Option<&[u16]>) -> Result<Vec<(String, String)>, ExportError> {
    let pipeline = pipeline(numbers)?;
    let mut files = vec![(format!("{name}.h"), scene(numbers, name, &pipeline))];
    files.extend(voxels.map(|voxels| (format!("{name}_voxels.h"), self::voxels(numbers, name, voxels))));
    Ok(files)
}

/// The function that describes the scene's pipeline.
fn pipeline(numbers: &Numbers<'_>) -> Result<String, ExportError> {
    let (code, lookup) = (numbers.table.code, numbers.table.lookup);
    let own = numbers.precision.table();
    let fine = own == AlphaCodeName::Sqrt16 && code == AlphaCodeName::Colour16;
    let known = numbers.blend == Blend::FrontToBack
        && numbers.early_termination.is_none()
        && lookup == numbers.precision.lookup()
        && (code == own || fine);
    if !known {
        let [code, lookup] = numbers.layout();
        let early = numbers
            .early_termination
            .map_or(String::new(), |bits| format!(", early termination at 2^-{bits}"));
        let order = numbers.order();
        return Err(ExportError::NoPipeline {
            given: format!(
                "of {} with {code} and {lookup}, {order}{early}",
                numbers.precision.name()
            ),
            accepted: ACCEPTED,
        });
    }
    let suffix = if fine { "_colour16" } else { "" };
    Ok(format!(
        "slicecast_{}_{}{suffix}",
        numbers.precision.name(),
        numbers.shading_name()
    ))
}

fn header(numbers: &Numbers<'_>) -> String {
    let mut out = String::from("/* Written by `slicecast export`; docs/export.md says how to use it.\n *\n");
    for (name, words) in numbers.about() {
        let _ = writeln!(out, " * {name:<9} {words}");
    }
    out.push_str(" */\n");
    out
}

/// Numbers in braces.
fn braces<T: Display>(values: impl IntoIterator<Item = T>) -> String {
    let list: Vec<String> = values.into_iter().map(|value| value.to_string()).collect();
    format!("{{{}}}", list.join(", "))
}

fn scene(numbers: &Numbers<'_>, name: &str, pipeline: &str) -> String {
    let (upper, lower) = (name.to_ascii_uppercase(), name.to_ascii_lowercase());
    let (plan, picture) = (&numbers.plan, &numbers.picture);
    let mut out = header(numbers);
    let _ = write!(
        out,
        "#ifndef {upper}_H\n#define {upper}_H\n\n#include \"slicecast.h\"\n\n{}",
        table(numbers.table, &format!("{lower}_table"), Language::C)
    );
    let lighting = match &numbers.shading {
        Some(shading) => {
            lights(&mut out, shading, &lower);
            format!("&{lower}_lighting")
        }
        None => "0".into(),
    };
    let low = match numbers.table.code {
        AlphaCodeName::Sqrt8 => "0, 0".into(),
        AlphaCodeName::Sqrt16 => format!("{lower}_table_low, 0"),
        AlphaCodeName::Colour16 => format!("{lower}_table_low, &{lower}_table_colours[0][0]"),
    };
    let sampling = plan.sampling();
    let _ = write!(
        out,
        "
/* The scene: version, dims, direction, spacing factors, planes and rays per voxel, interpolation, borders, crop box, table, lights;
   no integrals: segments have a table of their own, which `slicecast table` writes; no surfaces, no scale of extinctions. */
static const SlicecastScene {lower} = {{
    SLICECAST_VERSION,
    {dims},
    {direction},
    {spacing},
    {planes},
    {rays},
    {nearest},
    {borders},
    {low_faces},
    {high_faces},
    {lower}_table,
    {low},
    {lighting},
    0,
    0,
    0,
    {{0, 0}},
    0,
}};

/* Its pipeline: a call that gives the description. */
#define {upper}_PIPELINE {pipeline}

/* Bytes of a block for a whole frame, known to the compiler; slicecast_needs tells the exact number, which is less. */
#define {upper}_BYTES (SLICECAST_STATE_BYTES + {parts})

/* Voxels of a slice, and slices, nearest first; the number of the first slice. */
#define {upper}_SLICE_VOXELS {slice}
#define {upper}_SLICES {slices}
#define {upper}_FIRST_SLICE {first}

/* The picture: columns, rows, where its pixels look at the base plane, what is behind it. */
#define {upper}_COLUMNS {columns}
#define {upper}_ROWS {rows}
static const SlicecastWarp {lower}_warp = {{
    {origin},
    {right},
    {down},
}};
static const uint16_t {lower}_background[3] = {background};
",
        dims = braces(plan.view().restore(plan.volume())),
        direction = braces(plan.view().direction().map(|c| c.to_bits())),
        spacing = braces(plan.view().restore(plan.spacing()).map(Intensity::to_bits)),
        planes = sampling.planes_per_voxel,
        rays = sampling.rays_per_voxel,
        nearest = u8::from(plan.is_nearest()),
        borders = match plan.borders() {
            Borders::Whole => 0,
            Borders::Cells => 1,
            Borders::Nodes => 2,
        },
        low_faces = braces(numbers.crop_bits()[0]),
        high_faces = braces(numbers.crop_bits()[1]),
        parts = numbers
            .needs
            .bytes()
            .map(|bytes| bytes.next_multiple_of(8).to_string())
            .join(" + "),
        slice = plan.dims()[0] * plan.dims()[1],
        slices = plan.dims()[2],
        first = plan.first()[2],
        columns = picture.size[0],
        rows = picture.size[1],
        origin = braces(picture.warp.origin.map(Step::to_bits)),
        right = braces(picture.warp.right.map(Step::to_bits)),
        down = braces(picture.warp.down.map(Step::to_bits)),
        background = braces(numbers.background.map(Intensity::to_bits)),
    );
    derived(&mut out, numbers);
    let _ = write!(out, "\n#endif /* {upper}_H */\n");
    out
}

/// Vectors and coefficients of full width: the library takes what the precision keeps, which [`derived`] tells.
fn lights(out: &mut String, shading: &Shading<'_>, lower: &str) {
    let vector = |v: [Vector; 3]| braces(v.map(Vector::to_bits));
    let coefficient = |v: [Coefficient; 3]| braces(v.map(|c| format!("{}u", c.to_bits())));
    let material = shading.material;
    let _ = write!(
        out,
        "\n/* Lights: direction, half vector (s1.30, slice frame), diffuse, specular (1.31). */\nstatic const SlicecastLight {lower}_lights[{}] = {{\n",
        material.lights.len()
    );
    for light in &material.lights {
        let _ = writeln!(
            out,
            "    {{{}, {}, {}, {}}},",
            vector(light.direction),
            vector(light.half),
            coefficient(light.diffuse),
            coefficient(light.specular)
        );
    }
    let _ = write!(
        out,
        "}};

/* Ambient (1.31), viewer (s1.30), form of the highlight, log2 of its exponent, lights. */
static const SlicecastLighting {lower}_lighting = {{
    {}, {}, {}, {}, {}, {lower}_lights,
}};
",
        coefficient(material.ambient),
        vector(material.viewer),
        u8::from(shading.is_half_vector()),
        material.exponent_log2,
        material.lights.len()
    );
}

/// What the pipeline derives from the scene, for comparison.
fn derived(out: &mut String, numbers: &Numbers<'_>) {
    out.push_str("\n/* What the library computes with, as it derives it:\n");
    for quantity in of_scene(numbers) {
        let values: Vec<String> = quantity.values.iter().flatten().map(i128::to_string).collect();
        let order = if quantity.order.is_empty() {
            String::new()
        } else {
            format!(" ({})", quantity.order)
        };
        let _ = writeln!(
            out,
            " * {}{order}, {}: {}",
            quantity.name,
            quantity.format,
            values.join(" ")
        );
    }
    out.push_str(" */\n");
}

fn voxels(numbers: &Numbers<'_>, name: &str, voxels: &[u16]) -> String {
    let (upper, lower) = (name.to_ascii_uppercase(), name.to_ascii_lowercase());
    let [width, height, depth] = numbers.plan.dims();
    let mut out = header(numbers);
    let _ = write!(
        out,
        "#ifndef {upper}_VOXELS_H\n#define {upper}_VOXELS_H\n\n#include <stdint.h>\n\n/* {depth} slices of {width} x {height} voxels, \
         nearest first, rows one after the other. */\nstatic const uint16_t {lower}_voxels[{}] = {{\n",
        voxels.len()
    );
    for line in voxels.chunks(20) {
        let text: Vec<String> = line.iter().map(|voxel| format!("{voxel},")).collect();
        let _ = writeln!(out, "    {}", text.join(" "));
    }
    let _ = write!(out, "}};\n\n#endif /* {upper}_VOXELS_H */\n");
    out
}
