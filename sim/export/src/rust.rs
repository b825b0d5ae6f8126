//! A scene as a Rust module: constants that the compiler checks, and the pipeline by simple calls.

use std::fmt::{Debug, Write};

use slicecast::borders::Borders;
use slicecast::format::{Intensity, Position, Step};
use slicecast_scene::{AlphaCodeName, Blend, LookupName, PrecisionName};

use crate::table::{Language, table};
use crate::{Numbers, Shading};

/// The module, and with voxels one that holds them.
pub fn files(numbers: &Numbers<'_>, name: &str, voxels: Option<&[u16]>) -> Vec<(String, String)> {
    let mut files = vec![(format!("{name}.rs"), module(numbers))];
    files.extend(voxels.map(|voxels| (format!("{name}_voxels.rs"), self::voxels(numbers, voxels))));
    files
}

/// Plain comments, so that `include!` takes the file too.
fn header(numbers: &Numbers<'_>) -> String {
    let mut out = String::from("// Written by `slicecast export`; docs/export.md says how to use it.\n//\n");
    for (name, words) in numbers.about() {
        let _ = writeln!(out, "// {name:<9} {words}");
    }
    out
}

/// Types that a scene's pipeline is made of.
struct Types {
    precision: &'static str,
    element: &'static str,
    zero: &'static str,
    code: &'static str,
    lookup: &'static str,
}

impl Types {
    fn of(numbers: &Numbers<'_>) -> Self {
        let (precision, element, zero) = match numbers.precision {
            PrecisionName::Paper => ("Paper", "u16", "0"),
            PrecisionName::Compact => ("Compact", "Unorm16", "Unorm16(0)"),
            PrecisionName::Wide => ("Wide", "u32", "0"),
            PrecisionName::Fast => unreachable!("refused before"),
        };
        let (element, zero) = if numbers.is_composited() {
            (element, zero)
        } else {
            ("i32", "0")
        };
        Self {
            precision,
            element,
            zero,
            code: match numbers.table.code {
                AlphaCodeName::Sqrt8 => "Sqrt8",
                AlphaCodeName::Sqrt16 => "Sqrt16",
                AlphaCodeName::Colour16 => "Colour16",
            },
            lookup: match numbers.table.lookup {
                LookupName::Nearest => "Nearest",
                LookupName::Linear => "Linear",
            },
        }
    }
}

fn module(numbers: &Numbers<'_>) -> String {
    let types = Types::of(numbers);
    let mut out = header(numbers);
    out.push('\n');
    uses(&mut out, numbers, &types);
    pipeline_type(&mut out, numbers, &types);
    geometry(&mut out, numbers);
    memory(&mut out, &types);
    if let Some(shading) = &numbers.shading {
        lights(&mut out, shading);
    }
    calls(&mut out, numbers, &types);
    picture(&mut out, numbers);
    out.push('\n');
    out.push_str(&table(numbers.table, "table", Language::Rust));
    out
}

/// A `use` a line, in order.
fn uses(out: &mut String, numbers: &Numbers<'_>, types: &Types) {
    let mut classify = vec![types.code, types.lookup, "PointTable"];
    classify.sort_unstable();
    let mut composite = Vec::new();
    if types.element == "Unorm16" {
        composite.push("Unorm16");
    }
    match numbers.blend {
        Blend::FrontToBack => composite.push("FrontToBack"),
        Blend::BackToFront => composite.push("BackToFront"),
        Blend::Maximum | Blend::Minimum | Blend::Average | Blend::Additive => {}
    }
    composite.sort_unstable();
    let mut lines = vec!["slicecast::Error".to_owned(), list("classify", &classify)];
    if !composite.is_empty() {
        lines.push(list("composite", &composite));
    }
    lines.push(list("format", &["Direction", "Intensity", "Step"]));
    lines.push(list("plan", &["Plan", "Sampling", "Spacing"]));
    lines.push(list(
        "plane",
        &[if numbers.is_composited() {
            "Composite"
        } else {
            "Project"
        }],
    ));
    lines.push(list("precision", &[types.precision]));
    match (numbers.blend, &numbers.shading) {
        (Blend::Maximum, _) => lines.push(list("project", &["Maximum"])),
        (Blend::Minimum, _) => lines.push(list("project", &["Minimum"])),
        (Blend::Average | Blend::Additive, _) => lines.push(list("project", &["Sum"])),
        (_, Some(_)) => lines.push(list("shade", &["Highlight", "KeptLight", "Phong"])),
        (_, None) => lines.push(list("shade", &["Unlit"])),
    }
    lines.push(list("stream", &["Needs", "Reserved", "Stream"]));
    lines.push(list("view", &["View"]));
    lines.push(list("warp", &["Warp", "in_front_of"]));
    for line in lines {
        let _ = writeln!(out, "use {line};");
    }
}

fn list(module: &str, names: &[&str]) -> String {
    match names {
        [name] => format!("slicecast::{module}::{name}"),
        names => format!("slicecast::{module}::{{{}}}", names.join(", ")),
    }
}

fn pipeline_type(out: &mut String, numbers: &Numbers<'_>, types: &Types) {
    let Types {
        precision,
        code,
        lookup,
        element,
        ..
    } = types;
    let shader = match &numbers.shading {
        Some(_) => format!("Phong<{precision}>"),
        None => "Unlit".into(),
    };
    let pipeline = match numbers.blend {
        Blend::FrontToBack => format!("Composite<{precision}, Table, {shader}, FrontToBack>"),
        Blend::BackToFront => format!("Composite<{precision}, Table, {shader}, BackToFront>"),
        Blend::Maximum => format!("Project<{precision}, Table, Maximum>"),
        Blend::Minimum => format!("Project<{precision}, Table, Minimum>"),
        Blend::Average | Blend::Additive => format!("Project<{precision}, Table, Sum>"),
    };
    let _ = write!(
        out,
        "
/// The table's layout.
pub type Table = PointTable<'static, {code}, {lookup}>;

/// The scene's pipeline.
pub type Pipeline = {pipeline};

/// An element of its image.
pub type Element = {element};
"
    );
}

/// A list of `Type::from_bits(…)`.
fn from_bits<T: Debug>(kind: &str, bits: impl IntoIterator<Item = T>) -> String {
    let list: Vec<String> = bits.into_iter().map(|b| format!("{kind}::from_bits({b:?})")).collect();
    format!("[{}]", list.join(", "))
}

fn geometry(out: &mut String, numbers: &Numbers<'_>) {
    let plan = &numbers.plan;
    let direction = from_bits("Direction", plan.view().direction().map(|c| c.to_bits()));
    let spacing = from_bits("Intensity", plan.view().restore(plan.spacing()).map(Intensity::to_bits));
    let (dims, sampling) = (plan.view().restore(plan.volume()), plan.sampling());
    let nearest = if plan.is_nearest() { ".with_nearest()" } else { "" };
    let made = match plan.borders() {
        Borders::Whole => ("whole", ""),
        Borders::Cells => ("new", ""),
        Borders::Nodes => ("with_borders", ", slicecast::borders::Borders::Nodes"),
    };
    let (new, borders) = made;
    let nearest = match numbers.crop {
        None => format!("plan{nearest}"),
        Some(crop) => format!(
            "match plan.with_crop(slicecast::crop::Crop {{\n        low: {},\n        high: {},\n    }}) {{\n        Ok(plan) => plan{nearest},\n        \
             Err(_) => panic!(\"the crop box holds nothing\"),\n    }}",
            from_bits("slicecast::format::Position", crop.low.map(Position::to_bits)),
            from_bits("slicecast::format::Position", crop.high.map(Position::to_bits)),
        ),
    };
    let step = plan.step().map(Step::to_bits);
    let ([columns, rows], [oi, oj]) = (plan.base(), plan.origin());
    let _ = write!(
        out,
        "
/// The viewing direction.
#[rustfmt::skip]
pub const VIEW: View = match View::new({direction}) {{
    Ok(view) => view,
    Err(_) => panic!(\"the direction is none\"),
}};

/// Rates of sampling.
pub const SAMPLING: Sampling = Sampling {{
    planes_per_voxel: {planes},
    rays_per_voxel: {rays},
}};

/// The geometry.
#[rustfmt::skip]
pub const PLAN: Plan = match Plan::{new}(VIEW, {dims:?}, Spacing({spacing}), SAMPLING{borders}) {{
    Ok(plan) => {nearest},
    Err(_) => panic!(\"sizes, spacing or rates are out of range\"),
}};

/// What the host had: steps from plane to plane along i, j, k (s31.32), origin, columns and rows of the base plane.
const _: () = {{
    let ([i, j, k], [oi, oj], [columns, rows]) = (PLAN.step(), PLAN.origin(), PLAN.base());
    assert!(i.to_bits() == {si} && j.to_bits() == {sj} && k.to_bits() == {sk});
    assert!(oi == {oi} && oj == {oj} && columns == {columns} && rows == {rows});
}};
",
        planes = sampling.planes_per_voxel,
        rays = sampling.rays_per_voxel,
        si = step[0],
        sj = step[1],
        sk = step[2],
    );
}

fn memory(out: &mut String, types: &Types) {
    let _ = write!(
        out,
        "
/// What a frame takes, in elements.
pub const NEEDS: Needs = Needs::of::<Pipeline>(&PLAN);

/// Memory for a frame, as large as the compiler has counted.
pub type Memory = Reserved<Element, {{ NEEDS.slices }}, {{ NEEDS.ranges }}, {{ NEEDS.scratch }}, {{ NEEDS.image }}>;

/// Memory of zeroes, for a `static`.
pub const fn memory() -> Memory {{
    Reserved::new({})
}}
",
        types.zero
    );
}

fn lights(out: &mut String, shading: &Shading<'_>) {
    let (vector, coefficient) = (shading.vector_bits, shading.coefficient_bits);
    let _ = write!(
        out,
        "
/// Ambient coefficient of red, green, blue, {coefficient} fraction bits.
pub const AMBIENT: [u32; 3] = {:?};

/// Unit vector towards the eye, slice frame, {vector} fraction bits.
pub const VIEWER: [i32; 3] = {:?};

/// The lights: unit vectors in the slice frame ({vector} fraction bits), coefficients times colours ({coefficient}).
pub const LIGHTS: [KeptLight; {}] = [
",
        shading.ambient,
        shading.viewer,
        shading.lights.len()
    );
    for light in &shading.lights {
        let _ = writeln!(
            out,
            "    KeptLight {{\n        direction: {:?},\n        half: {:?},\n        diffuse: {:?},\n        specular: {:?},\n    }},",
            light.direction, light.half, light.diffuse, light.specular
        );
    }
    let highlight = if shading.is_half_vector() {
        "HalfVector"
    } else {
        "Reflection"
    };
    let _ = write!(
        out,
        "];

/// The form of the highlight.
pub const HIGHLIGHT: Highlight = Highlight::{highlight};

/// log2 of its exponent.
pub const EXPONENT_LOG2: u32 = {};
",
        shading.material.exponent_log2
    );
}

fn calls(out: &mut String, numbers: &Numbers<'_>, types: &Types) {
    let precision = types.precision;
    let planes = match numbers.table.code {
        AlphaCodeName::Sqrt8 => "()",
        AlphaCodeName::Sqrt16 => "&TABLE_LOW",
        AlphaCodeName::Colour16 => "(&TABLE_LOW, &TABLE_COLOURS)",
    };
    let mut body = format!("    let table = PointTable::new(&TABLE, {planes});\n");
    let made = match (&numbers.shading, numbers.is_composited()) {
        (Some(_), _) => {
            let _ = writeln!(
                body,
                "    let phong = Phong::of_kept({precision}, AMBIENT, &LIGHTS, VIEWER, HIGHLIGHT, EXPONENT_LOG2)?;"
            );
            format!("Composite::new({precision}, table, phong)")
        }
        (None, true) => format!("Composite::new({precision}, table, Unlit)"),
        (None, false) => match (numbers.blend, numbers.additive) {
            (_, Some([step, shift])) => {
                format!("Project::of({precision}, table, Sum::Additive {{ step: {step}, shift: {shift} }})")
            }
            (Blend::Average, _) => format!("Project::of({precision}, table, Sum::Average)"),
            _ => format!("Project::new({precision}, table)"),
        },
    };
    let early = numbers
        .early_termination
        .map_or(String::new(), |bits| format!(".with_early_termination({bits})"));
    let _ = write!(
        out,
        "
/// The pipeline.
///
/// # Errors
/// None: the numbers are in range.
pub fn pipeline() -> Result<Pipeline, Error> {{
{body}    Ok({made}{early})
}}

/// Begins a frame: push slices as `wanted` numbers them, 0 being the nearest.
///
/// # Errors
/// None: the memory is as large as it has to be.
pub fn stream(memory: &mut Memory) -> Result<Stream<'_, Pipeline>, Error> {{
    Ok(Stream::new(PLAN, pipeline()?, memory.lend())?)
}}
"
    );
}

fn picture(out: &mut String, numbers: &Numbers<'_>) {
    let picture = &numbers.picture;
    let step = |v: [Step; 2]| from_bits("Step", v.map(Step::to_bits));
    let warp = picture.warp;
    let _ = write!(
        out,
        "
/// Columns and rows of the picture.
pub const PICTURE: [u32; 2] = {:?};

/// Where its pixels look at the base plane.
#[rustfmt::skip]
pub const WARP: Warp = Warp {{
    origin: {},
    right: {},
    down: {},
}};

/// What is behind it.
#[rustfmt::skip]
pub const BACKGROUND: [Intensity; 3] = {};

/// A pixel of the picture, red, green, blue.
pub fn pixel(stream: &Stream<'_, Pipeline>, x: u32, y: u32) -> [u8; 3] {{
    in_front_of(WARP.pixel(x, y, |u, v| stream.pixel(u, v)), BACKGROUND)
}}
",
        picture.size,
        step(warp.origin),
        step(warp.right),
        step(warp.down),
        from_bits("Intensity", numbers.background.map(Intensity::to_bits)),
    );
}

fn voxels(numbers: &Numbers<'_>, voxels: &[u16]) -> String {
    let mut out = header(numbers);
    let [width, height, depth] = numbers.plan.dims();
    let _ = writeln!(
        out,
        "\n/// {depth} slices of {width} x {height} voxels, nearest first, rows one after the other.\n#[rustfmt::skip]\npub static VOXELS: [u16; {}] = [",
        voxels.len()
    );
    for line in voxels.chunks(20) {
        let text: Vec<String> = line.iter().map(|voxel| format!("{voxel},")).collect();
        let _ = writeln!(out, "    {}", text.join(" "));
    }
    out.push_str("];\n");
    out
}
