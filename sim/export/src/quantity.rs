//! The numbers as a list: name, format, width, unit, order, values.

use serde::Serialize;
use slicecast::borders::Borders;
use slicecast::format::{Intensity, Step};
use slicecast::view::Axis;
use slicecast_engine::table::Table;
use slicecast_scene::{AlphaCodeName, Blend, LookupName, PrecisionName};

use crate::Numbers;

/// Numbers of one format.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Quantity {
    /// Its name.
    #[serde(skip)]
    pub name: &'static str,
    /// As the contract writes it: `sI.F` has a sign, I integer and F fraction bits.
    pub format: &'static str,
    /// Bits of a word; two's complement where it is signed.
    pub bits: u32,
    /// Whether words have a sign.
    pub signed: bool,
    /// What 1.0 is, or what the codes mean.
    pub unit: &'static str,
    /// What the values are, in their order; the last changes fastest.
    pub order: &'static str,
    /// Values along each of these.
    pub shape: Vec<usize>,
    /// The values, as integers.
    #[serde(rename = "value", skip_serializing_if = "Option::is_none")]
    pub values: Option<Vec<i128>>,
}

/// A format and its width.
type Kind = (&'static str, u32);

const COUNT: Kind = ("32.0", 32);
const FLAG: Kind = ("1.0", 1);
const SHARE: Kind = ("1.15", 16);
const STEP: Kind = ("s31.32", 64);

fn quantity<T: Into<i128>>(
    name: &'static str,
    (format, bits): Kind,
    unit: &'static str,
    order: &'static str,
    values: impl IntoIterator<Item = T>,
) -> Quantity {
    let values: Vec<i128> = values.into_iter().map(Into::into).collect();
    Quantity {
        name,
        format,
        bits,
        signed: format.starts_with('s'),
        unit,
        order,
        shape: vec![values.len()],
        values: Some(values),
    }
}

impl Quantity {
    /// The same values as so many rows.
    fn rows(mut self, rows: usize) -> Self {
        let len = self.values.as_ref().map_or(0, Vec::len);
        self.shape = vec![rows, len.checked_div(rows).unwrap_or(0)];
        self
    }

    /// The same quantity, its values elsewhere.
    #[must_use]
    pub fn without_values(&self) -> Self {
        Self {
            values: None,
            ..self.clone()
        }
    }
}

/// All quantities of a scene but the table and the voxels.
pub fn of_scene(numbers: &Numbers<'_>) -> Vec<Quantity> {
    let Numbers { plan, picture, .. } = numbers;
    let view = plan.view();
    let sampling = plan.sampling();
    let bits = |v: [Intensity; 3]| v.map(Intensity::to_bits);
    let steps = |v: [Step; 2]| v.map(Step::to_bits);
    let axis = match view.major() {
        Axis::X => 0,
        Axis::Y => 1,
        Axis::Z => 2,
    };
    let order: u8 = match numbers.blend {
        Blend::FrontToBack => 0,
        Blend::BackToFront => 1,
        Blend::Maximum => 2,
        Blend::Minimum => 3,
        Blend::Average => 4,
        Blend::Additive => 5,
    };
    let channel = match numbers.precision {
        PrecisionName::Paper => ("1.15", 16),
        PrecisionName::Compact => ("16 bits, 65535 is 1", 16),
        PrecisionName::Wide => ("1.31", 32),
        PrecisionName::Fast => unreachable!("refused before"),
    };
    let needs = &numbers.needs;
    let elements = [needs.slices, needs.ranges, needs.scratch, needs.image];
    let long = |v: usize| v as u64;
    let mut list = vec![
        quantity(
            "direction",
            ("s5.58", 64),
            "voxels, of any scale",
            "x, y, z",
            view.direction().map(|c| c.to_bits()),
        ),
        quantity("dims", COUNT, "voxels", "x, y, z", plan.view().restore(plan.volume())),
        quantity(
            "spacing_factors",
            SHARE,
            "smallest spacing / spacing",
            "x, y, z",
            bits(plan.view().restore(plan.spacing())),
        ),
        quantity(
            "planes_per_voxel",
            COUNT,
            "sample planes",
            "",
            [sampling.planes_per_voxel],
        ),
        quantity(
            "rays_per_voxel",
            COUNT,
            "rays along each side",
            "",
            [sampling.rays_per_voxel],
        ),
        quantity(
            "nearest",
            FLAG,
            "1: samples lie at voxels",
            "",
            [u8::from(plan.is_nearest())],
        ),
        quantity(
            "borders",
            ("2.0", 2),
            "0 whole, 1 cells, 2 nodes",
            "",
            [match plan.borders() {
                Borders::Whole => 0u8,
                Borders::Cells => 1,
                Borders::Nodes => 2,
            }],
        ),
        quantity(
            "crop_low",
            ("s15.16", 32),
            "voxels; both faces 0: not cropped",
            "x, y, z",
            numbers.crop_bits()[0],
        ),
        quantity(
            "crop_high",
            ("s15.16", 32),
            "voxels; both faces 0: not cropped",
            "x, y, z",
            numbers.crop_bits()[1],
        ),
        quantity(
            "major_axis",
            ("2.0", 2),
            "0 x, 1 y, 2 z: the axis that is k",
            "",
            [axis],
        ),
        quantity(
            "reversed",
            FLAG,
            "1: k from the far end of the axis",
            "",
            [u8::from(view.reversed())],
        ),
        quantity("slice_dims", COUNT, "voxels that are held", "i, j, k", plan.dims()),
        quantity("first_voxel", COUNT, "the first of them", "i, j, k", plan.first()),
        quantity(
            "slice_spacing_factors",
            SHARE,
            "smallest spacing / spacing",
            "i, j, k",
            bits(plan.spacing()),
        ),
        quantity(
            "step",
            STEP,
            "voxels per plane",
            "i, j, k",
            plan.step().map(Step::to_bits),
        ),
        quantity("origin", ("s31.0", 32), "voxels", "i, j", plan.origin()),
        quantity("base", COUNT, "pixels of a phase", "columns, rows", plan.base()),
        quantity("planes", COUNT, "sample planes", "", [plan.planes()]),
        quantity("phases", COUNT, "phases", "", [plan.phases()]),
        quantity(
            "order",
            ("3.0", 3),
            "0 front to back, 1 back to front, 2 maximum, 3 minimum, 4 average, 5 additive",
            "",
            [order],
        ),
    ];
    if let Some([step, shift]) = numbers.additive {
        let unit = "shares of the additive length per step, over 2^(32 + shift)";
        list.push(quantity("additive_step", COUNT, unit, "", [step]));
        list.push(quantity("additive_shift", COUNT, "bits", "", [shift]));
    }
    if numbers.is_composited() {
        list.push(quantity(
            "floor",
            channel,
            "transparency below it becomes 0",
            "",
            [numbers.floor],
        ));
    }
    if let Some(shading) = &numbers.shading {
        let vector = if shading.vector_bits == 15 {
            ("s1.15", 17)
        } else {
            ("s1.30", 32)
        };
        let coefficient = if shading.coefficient_bits == 15 {
            ("1.15", 16)
        } else {
            ("1.31", 32)
        };
        let lights = shading.lights.iter();
        let count = shading.lights.len();
        let material = shading.material;
        list.extend([
            quantity(
                "highlight",
                FLAG,
                "0 reflection, 1 half vector",
                "",
                [u8::from(shading.is_half_vector())],
            ),
            quantity(
                "exponent_log2",
                ("4.0", 4),
                "log2 of the exponent",
                "",
                [material.exponent_log2],
            ),
            quantity(
                "ambient",
                coefficient,
                "1.0 is all light",
                "red, green, blue",
                shading.ambient,
            ),
            quantity(
                "viewer",
                vector,
                "unit vector towards the eye",
                "i, j, k",
                shading.viewer,
            ),
            quantity(
                "light_directions",
                vector,
                "unit vector towards the light",
                "light; i, j, k",
                lights.clone().flat_map(|l| l.direction),
            )
            .rows(count),
            quantity(
                "light_halves",
                vector,
                "unit vector between light and eye",
                "light; i, j, k",
                lights.clone().flat_map(|l| l.half),
            )
            .rows(count),
            quantity(
                "light_diffuse",
                coefficient,
                "1.0 is all light",
                "light; red, green, blue",
                lights.clone().flat_map(|l| l.diffuse),
            )
            .rows(count),
            quantity(
                "light_specular",
                coefficient,
                "1.0 is all light",
                "light; red, green, blue",
                lights.flat_map(|l| l.specular),
            )
            .rows(count),
        ]);
    }
    list.extend([
        quantity(
            "table_code",
            ("2.0", 2),
            "0 sqrt8, 1 sqrt16, 2 colour16",
            "",
            [code(numbers.table)],
        ),
        quantity(
            "table_linear",
            FLAG,
            "0 nearest entry, 1 linear",
            "",
            [u8::from(numbers.table.lookup == LookupName::Linear)],
        ),
        quantity("picture", COUNT, "pixels", "columns, rows", picture.size),
        quantity(
            "warp_origin",
            STEP,
            "base-plane pixels of all phases",
            "u, v",
            steps(picture.warp.origin),
        ),
        quantity(
            "warp_right",
            STEP,
            "base-plane pixels per picture pixel",
            "u, v",
            steps(picture.warp.right),
        ),
        quantity(
            "warp_down",
            STEP,
            "base-plane pixels per picture pixel",
            "u, v",
            steps(picture.warp.down),
        ),
        quantity(
            "background",
            SHARE,
            "1.0 is full",
            "red, green, blue",
            bits(numbers.background),
        ),
        quantity(
            "memory_elements",
            ("64.0", 64),
            "elements",
            "slices, row ranges, scratch, image",
            elements.map(long),
        ),
        quantity(
            "memory_bytes",
            ("64.0", 64),
            "bytes",
            "slices, row ranges, scratch, image",
            needs.bytes().map(long),
        ),
    ]);
    list
}

fn code(table: &Table) -> u8 {
    match table.code {
        AlphaCodeName::Sqrt8 => 0,
        AlphaCodeName::Sqrt16 => 1,
        AlphaCodeName::Colour16 => 2,
    }
}

/// The table: entries, and the planes of low bytes that its code has.
pub fn of_table(table: &Table) -> Vec<Quantity> {
    let entry = "red, green, blue, square root of the opacity (or their high bytes), from the lowest byte";
    let mut list = vec![quantity(
        "table_entries",
        ("4 x 8 bits", 32),
        entry,
        "code",
        *table.entries,
    )];
    if table.code != AlphaCodeName::Sqrt8 {
        let unit = "low byte of the square root of the opacity";
        list.push(quantity("table_low_roots", ("8 bits", 8), unit, "code", *table.plane));
    }
    if table.code == AlphaCodeName::Colour16 {
        let colours = table.colours.iter().copied().flatten();
        let unit = "low byte of the colour";
        let plane = quantity(
            "table_low_colours",
            ("8 bits", 8),
            unit,
            "code; red, green, blue",
            colours,
        );
        list.push(plane.rows(table.entries.len()));
    }
    list
}

/// The voxels, nearest slice first.
pub fn of_voxels(numbers: &Numbers<'_>, voxels: &[u16]) -> Quantity {
    let [width, height, depth] = numbers.plan.dims().map(|side| side as usize);
    Quantity {
        shape: vec![depth, height, width],
        ..quantity("voxels", ("12.0", 12), "code", "k, j, i", voxels.iter().copied())
    }
}
