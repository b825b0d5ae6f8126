//! Files for Verilog's `$readmemh`: a word a line, and a manifest of names, widths and units.

use std::fmt::Write;

use crate::Numbers;
use crate::json::{Filed, object};
use crate::quantity::{Quantity, of_scene, of_voxels};
use crate::table::{Language, table};
use slicecast_scene::AlphaCodeName;

/// A file per quantity, the table in one of its own, and `manifest.json`.
pub fn files(numbers: &Numbers<'_>, voxels: Option<&[u16]>) -> Vec<(String, String)> {
    let mut quantities = of_scene(numbers);
    quantities.extend(voxels.map(|voxels| of_voxels(numbers, voxels)));
    let mut files: Vec<(String, String)> = quantities.iter().map(|q| (file(q.name), words(q))).collect();
    files.push((file("table"), table(numbers.table, "table", Language::Readmemh)));

    let mut filed: Vec<Filed> = quantities
        .iter()
        .map(|q| Filed {
            file: file(q.name),
            words: q.values.as_ref().map_or(0, Vec::len),
            quantity: q.without_values(),
        })
        .collect();
    filed.push(Filed {
        file: file("table"),
        words: numbers.table.entries.len(),
        quantity: packed_table(numbers),
    });
    let manifest = object(numbers, filed.iter().map(|filed| (filed.quantity.name, filed)));
    files.push(("manifest.json".into(), manifest));
    files
}

fn file(name: &str) -> String {
    format!("{name}.hex")
}

/// The words of a quantity, two's complement, as many digits as its width takes.
fn words(quantity: &Quantity) -> String {
    let Quantity {
        name,
        format,
        bits,
        unit,
        order,
        ..
    } = quantity;
    let mut out = format!("// {name}: {format}, {bits} bits; {unit}; {order}\n");
    let (digits, mask) = (bits.div_ceil(4) as usize, (1i128 << bits) - 1);
    for value in quantity.values.iter().flatten() {
        let _ = writeln!(out, "{:0digits$x}", value & mask);
    }
    out
}

/// The table as `table.hex` has it, in one word a code.
fn packed_table(numbers: &Numbers<'_>) -> Quantity {
    let (bits, unit) = match numbers.table.code {
        AlphaCodeName::Sqrt8 => (32, "from the top: root 8, blue 8, green 8, red 8"),
        AlphaCodeName::Sqrt16 => (
            40,
            "from the top: root's high byte, blue 8, green 8, red 8, root's low byte",
        ),
        AlphaCodeName::Colour16 => (
            64,
            "from the top: high bytes of root, blue, green, red; low bytes of root, blue, green, red",
        ),
    };
    Quantity {
        name: "table",
        format: "bytes",
        bits,
        signed: false,
        unit,
        order: "code",
        shape: vec![numbers.table.entries.len()],
        values: None,
    }
}
