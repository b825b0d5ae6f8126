//! Sets as files.
//!
//! A set NAME has `NAME.in.hex` and `NAME.out.hex`: a line a vector, one word for `$readmemh`, the fields side by side in the
//! order of the manifest, the first in the highest bits. Each field takes whole hexadecimal digits, `ceil(bits / 4)` of them
//! (negative numbers in two's complement of those), and `_` stands between fields, which Verilog skips. `NAME.in.npy` and
//! `NAME.out.npy` hold the same as 64-bit integers, shape (vectors, fields). A set without outputs is a memory's contents.

use std::fmt::Write;
use std::io;

use npyz::WriterBuilder;
use serde::Serialize;

use crate::set::{Field, Set, Side};

/// How a side is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Words for `$readmemh`.
    Hex,
    /// NumPy's array file.
    Npy,
}

impl Format {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Hex, Self::Npy];

    /// The ending of a file's name.
    pub const fn ending(self) -> &'static str {
        match self {
            Self::Hex => "hex",
            Self::Npy => "npy",
        }
    }
}

/// The manifest's file.
pub const MANIFEST: &str = "manifest.json";

/// Hexadecimal digits of a field.
pub fn digits(field: &Field) -> usize {
    field.bits.div_ceil(4) as usize
}

/// Bytes of a vector's line.
fn line(side: &Side) -> u64 {
    side.fields.iter().map(|field| digits(field) as u64 + 1).sum()
}

/// Bytes that a vector of a set takes in these formats.
pub fn bytes_of_vector(set: &Set, formats: &[Format]) -> u64 {
    let side = |side: &Side| -> u64 {
        let one = |format: &Format| match format {
            Format::Hex => line(side),
            Format::Npy => 8 * side.fields.len() as u64,
        };
        formats.iter().map(one).sum()
    };
    side(&set.inputs) + side(&set.outputs)
}

/// The name of a side's file.
pub fn name(set: &Set, side: &str, format: Format) -> String {
    format!("{}.{side}.{}", set.name, format.ending())
}

/// A side's contents.
///
/// # Errors
/// An encoder's own.
pub fn contents(side: &Side, format: Format) -> io::Result<Vec<u8>> {
    match format {
        Format::Hex => Ok(hex(side).into_bytes()),
        Format::Npy => npy(side),
    }
}

fn hex(side: &Side) -> String {
    let mut text = String::new();
    for row in side.values.chunks_exact(side.fields.len()) {
        for (at, (field, value)) in side.fields.iter().zip(row).enumerate() {
            let digits = digits(field);
            let mask = if digits == 16 {
                u64::MAX
            } else {
                (1 << (4 * digits)) - 1
            };
            let gap = if at == 0 { "" } else { "_" };
            // Writing to a string cannot fail.
            let _ = write!(text, "{gap}{:0digits$x}", *value as u64 & mask);
        }
        text.push('\n');
    }
    text
}

fn npy(side: &Side) -> io::Result<Vec<u8>> {
    let width = side.fields.len();
    let mut bytes = Vec::new();
    let mut writer = npyz::WriteOptions::new()
        .default_dtype()
        .shape(&[(side.values.len() / width) as u64, width as u64])
        .writer(&mut bytes)
        .begin_nd()?;
    writer.extend(side.values.iter().copied())?;
    writer.finish()?;
    Ok(bytes)
}

/// A field in the manifest.
#[derive(Serialize)]
struct FieldLine<'a> {
    #[serde(flatten)]
    field: &'a Field,
    digits: usize,
}

/// A set in the manifest.
#[derive(Serialize)]
struct SetLine<'a> {
    name: &'a str,
    stage: &'a str,
    precision: Option<&'a str>,
    about: &'a str,
    vectors: usize,
    place: Vec<&'a str>,
    inputs: Vec<FieldLine<'a>>,
    outputs: Vec<FieldLine<'a>>,
    files: Vec<String>,
}

/// The manifest: of all sets the names, widths, signs, units and files, in the order in which they are compared.
///
/// `about` says where the vectors come from; `constants` are numbers that all vectors of a frame share.
///
/// # Errors
/// An encoder's own.
pub fn manifest(
    sets: &[Set],
    formats: &[Format],
    about: &serde_json::Value,
    constants: &[(Field, i64)],
) -> serde_json::Result<Vec<u8>> {
    let lines: Vec<serde_json::Value> = sets
        .iter()
        .map(|set| {
            let line = |field| FieldLine {
                digits: digits(field),
                field,
            };
            let files = sides(set)
                .into_iter()
                .flat_map(|(side, _)| formats.iter().map(move |format| name(set, side, *format)));
            serde_json::to_value(SetLine {
                name: &set.name,
                stage: set.stage,
                precision: set.precision,
                about: set.about,
                vectors: set.len(),
                place: set.inputs.fields[..set.place]
                    .iter()
                    .map(|field| field.name.as_str())
                    .collect(),
                inputs: set.inputs.fields.iter().map(line).collect(),
                outputs: set.outputs.fields.iter().map(line).collect(),
                files: files.collect(),
            })
        })
        .collect::<serde_json::Result<_>>()?;
    let constants: serde_json::Map<String, serde_json::Value> = constants
        .iter()
        .map(|(field, value)| {
            let line = serde_json::json!({
                "value": value, "bits": field.bits, "signed": field.signed, "unit": field.unit,
            });
            (field.name.clone(), line)
        })
        .collect();
    serde_json::to_vec_pretty(&serde_json::json!({
        "version": env!("CARGO_PKG_VERSION"),
        "from": about,
        "hex": "a word a line: the fields in this order, the first in the highest bits, `digits` hexadecimal digits each, \
                `_` between them; negative numbers in two's complement",
        "npy": "64-bit integers, shape (vectors, fields)",
        "constants": constants,
        "sets": lines,
    }))
}

/// The sides of a set that have fields, with the words that their files' names hold.
pub fn sides(set: &Set) -> Vec<(&'static str, &Side)> {
    [("in", &set.inputs), ("out", &set.outputs)]
        .into_iter()
        .filter(|(_, side)| !side.fields.is_empty())
        .collect()
}
