//! MetaImage volumes (`.mhd` with a data file beside it, `.mha` with the data attached).
//!
//! Source: the MetaIO documentation of ITK. Read: three axes, beside which others may have one entry, one channel, data
//! attached, in one file or in many (`LIST` or a pattern); integers of 8 to 64 bits, float, double, either byte order,
//! plain, zlib-packed or written as text. `DistanceUnits` are brought to millimetres. `TransformMatrix` (or `Orientation`,
//! `Rotation`) is taken as LPS, as ITK does; without it `AnatomicalOrientation` counts, and without both the orientation is
//! unknown.
//! `CompressedDataSize` is not believed: real files state too little; the data end where their stream ends.

mod header;

use std::io::Cursor;
use std::path::Path;

use self::header::{Header, NAME};
use super::axes::Directions;
use super::choice::Choice;
use super::companion;
use super::decoded::Decoded;
use super::error::{Problem, ReadError};
use super::file::open_regular;
use super::files::Data;
use super::length::millimetres;
use super::meaning::Modality;
use super::payload::{ByteSkip, Encoding, Layout, Tail};
use super::placed::{Place, Placed};
use super::text::shorten;
use super::values::{Endian, ValueType};

/// Axes that a header may have.
const MAX_AXES: usize = 16;

/// The last line of a header: what follows is the data, or their file's name.
const DATA_FILE: &str = "ElementDataFile";

/// Reads a MetaImage file. A data file must lie in the header's folder or below it.
///
/// # Errors
/// [`ReadError`] names the file (header or data), what was wrong and what was expected; see [`Problem`].
pub fn read(path: &Path, choice: &Choice) -> Result<Decoded, ReadError> {
    place(path)?.read(choice.nan)
}

/// What a MetaImage header says, and where its values are.
///
/// # Errors
/// As [`read`].
pub(super) fn place(path: &Path) -> Result<Placed, ReadError> {
    let at_header = |problem| ReadError::new(path, problem);
    let (mut source, _) = open_regular(path)?;
    let header = Header::read(&mut source).map_err(at_header)?;
    let (description, data) = describe(&header, path.display().to_string()).map_err(at_header)?;
    let place = match data {
        Data::Attached => Place::File(path.to_owned(), header.len),
        Data::File(data_file) => Place::File(companion::data_file(path, &data_file)?, 0),
        Data::Files(files) => Place::Files(path.to_owned(), files),
    };
    Ok(Placed { place, ..description })
}

/// Reads a MetaImage file with attached data that is already in memory; `name` stands for its path in messages.
///
/// # Errors
/// As [`read`]; a header that names a data file is refused.
pub fn read_bytes(bytes: &[u8], name: &str, choice: &Choice) -> Result<Decoded, ReadError> {
    let fail = |problem| ReadError::new(Path::new(name), problem);
    let mut source = Cursor::new(bytes);
    let header = Header::read(&mut source).map_err(fail)?;
    let (placed, data) = describe(&header, name.to_owned()).map_err(fail)?;
    if !matches!(data, Data::Attached) {
        let found = header.get(&[DATA_FILE]).unwrap_or_default();
        return Err(fail(refuse(
            DATA_FILE,
            found,
            "`LOCAL`, since the data have to be attached here",
        )));
    }
    let left = (bytes.len() as u64).saturating_sub(header.len);
    placed.read_from(&mut source, left, choice.nan).map_err(fail)
}

/// Whether a file that begins so is a MetaImage header.
pub(super) fn recognise(start: &[u8]) -> bool {
    let first = start
        .split(|&byte| byte == b'\n')
        .find(|line| !line.trim_ascii().is_empty());
    let key = first.and_then(|line| line.split(|&byte| byte == b'=').next());
    key.is_some_and(|key| [&b"ObjectType"[..], b"NDims"].contains(&key.trim_ascii()) && key.len() < 32)
}

/// Makes sense of a header's fields; where the data are comes beside, and the place is the name's until it is known.
fn describe(header: &Header, name: String) -> Result<(Placed, Data), Problem> {
    let stated = header.require("NDims", "3")?;
    let axes = stated
        .parse::<usize>()
        .ok()
        .filter(|axes| (3..=MAX_AXES).contains(axes));
    let axes = axes.ok_or_else(|| refuse("NDims", stated, "3: a volume of one value a voxel"))?;
    let channels = header.get(&["ElementNumberOfChannels"]).unwrap_or("1");
    if channels != "1" {
        return Err(refuse("ElementNumberOfChannels", channels, "1"));
    }
    let sizes = header.require("DimSize", "three whole numbers")?;
    let all_sides =
        numbers::<u64>(sizes, axes).ok_or_else(|| refuse("DimSize", sizes, "a whole number for each axis"))?;
    if all_sides[3..].iter().any(|&side| side != 1) {
        return Err(refuse("DimSize", sizes, "1 for every axis after the third"));
    }
    let dims = [all_sides[0], all_sides[1], all_sides[2]];
    let encoding = encoding(header)?;
    let mut notes = header.notes.clone();
    if axes > 3 {
        notes.push(format!("{} axes of one entry are left out", axes - 3));
    }
    let spacing = match header.get(&["ElementSpacing", "ElementSize"]) {
        Some(text) => {
            let lengths = numbers::<f64>(text, axes);
            let lengths = lengths.ok_or_else(|| refuse("ElementSpacing", text, "a number above 0 for each axis"))?;
            let unit = unit(header, &mut notes);
            [lengths[0] * unit, lengths[1] * unit, lengths[2] * unit]
        }
        None => {
            notes.push("the file states no spacing: 1 is assumed".into());
            [1.0; 3]
        }
    };
    let layout = Layout {
        dims,
        components: 1,
        value_type: value_type(header)?,
        endian: endian(header)?,
        encoding,
        line_skip: 0,
        byte_skip: byte_skip(header, encoding)?,
        tail: Tail::Refused,
    };
    let rescale = [
        number(header, "ElementToIntensityFunctionSlope", 1.0)?,
        number(header, "ElementToIntensityFunctionOffset", 0.0)?,
    ];
    let placed = Placed {
        place: Place::File((&name).into(), 0),
        name,
        format: NAME,
        layout,
        spacing,
        directions: directions(header, axes, &mut notes)?.map(Directions::Patient),
        rescale: (rescale != [1.0, 0.0]).then_some(rescale),
        modality: header
            .get(&["Modality"])
            .and_then(|text| Modality::from_code(text.trim_start_matches("MET_MOD_"))),
        stated_window: None,
        packed_len: header.get(&["CompressedDataSize"]).and_then(|text| text.parse().ok()),
        notes,
    };
    Ok((placed, data(header)?))
}

/// Where the data are.
fn data(header: &Header) -> Result<Data, Problem> {
    match header.require(DATA_FILE, "`LOCAL` or a file's name")? {
        "LOCAL" => Ok(Data::Attached),
        text => Data::named(text, &header.listed).map_err(|expected| refuse(DATA_FILE, text, expected)),
    }
}

/// Millimetres per unit of the spacing.
fn unit(header: &Header, notes: &mut Vec<String>) -> f64 {
    let Some(name) = header.get(&["DistanceUnits"]) else {
        return 1.0;
    };
    let known = millimetres(name);
    match known {
        Some(1.0) => {}
        Some(_) => notes.push(format!("DistanceUnits {} are brought to millimetres", shorten(name))),
        None => notes.push(format!(
            "DistanceUnits {} is no unit of length: mm are assumed",
            shorten(name)
        )),
    }
    known.unwrap_or(1.0)
}

fn encoding(header: &Header) -> Result<Encoding, Problem> {
    let packed = header.truth(&["CompressedData"])?.unwrap_or(false);
    let binary = header.truth(&["BinaryData"])?.unwrap_or(true);
    match (packed, binary) {
        (true, false) => Err(refuse("BinaryData", "False", "True where CompressedData is True")),
        (true, true) => Ok(Encoding::Zlib),
        (false, true) => Ok(Encoding::Raw),
        (false, false) => Ok(Encoding::Text),
    }
}

fn endian(header: &Header) -> Result<Endian, Problem> {
    let big = header.truth(&["BinaryDataByteOrderMSB", "ElementByteOrderMSB"])?;
    Ok(if big.unwrap_or(false) {
        Endian::Big
    } else {
        Endian::Little
    })
}

fn byte_skip(header: &Header, encoding: Encoding) -> Result<ByteSkip, Problem> {
    let text = header.get(&["HeaderSize"]).unwrap_or("0");
    match (text, encoding) {
        ("-1", Encoding::Raw) => Ok(ByteSkip::FromEnd),
        ("0", _) => Ok(ByteSkip::Bytes(0)),
        (text, Encoding::Raw) => match text.parse() {
            Ok(bytes) => Ok(ByteSkip::Bytes(bytes)),
            Err(_) => Err(refuse("HeaderSize", text, "a whole number, 0 or more, or -1")),
        },
        _ => Err(refuse("HeaderSize", text, "0 for data that are packed or text")),
    }
}

fn value_type(header: &Header) -> Result<ValueType, Problem> {
    let expected = "MET_CHAR, MET_UCHAR, MET_SHORT, MET_USHORT, MET_INT, MET_UINT, MET_LONG, MET_ULONG, MET_LONG_LONG, \
                    MET_ULONG_LONG, MET_FLOAT or MET_DOUBLE";
    let name = header.require("ElementType", expected)?;
    Ok(match name {
        "MET_CHAR" => ValueType::I8,
        "MET_UCHAR" => ValueType::U8,
        "MET_SHORT" => ValueType::I16,
        "MET_USHORT" => ValueType::U16,
        // MetaIO's long has four bytes on every machine.
        "MET_INT" | "MET_LONG" => ValueType::I32,
        "MET_UINT" | "MET_ULONG" => ValueType::U32,
        "MET_LONG_LONG" => ValueType::I64,
        "MET_ULONG_LONG" => ValueType::U64,
        "MET_FLOAT" => ValueType::F32,
        "MET_DOUBLE" => ValueType::F64,
        _ => return Err(refuse("ElementType", name, expected)),
    })
}

/// The directions of the file's axes in LPS, if it states any.
fn directions(header: &Header, axes: usize, notes: &mut Vec<String>) -> Result<Option<[[f64; 3]; 3]>, Problem> {
    if let Some(text) = header.get(&["TransformMatrix", "Orientation", "Rotation"]) {
        let expected = "nine numbers: the directions of x, y and z";
        let entries = numbers::<f64>(text, axes * axes).ok_or_else(|| refuse("TransformMatrix", text, expected))?;
        return Ok(Some(
            [0, 1, 2].map(|row| [0, 1, 2].map(|column| entries[row * axes + column])),
        ));
    }
    let Some(letters) = header.get(&["AnatomicalOrientation"]) else {
        return Ok(None);
    };
    // The letters say where each axis comes from: `RAI` runs to the left, the back and the head.
    let mut directions = [[0.0; 3]; 3];
    for (axis, letter) in letters.chars().enumerate() {
        let (to, sign) = match letter {
            'R' => (0, 1.0),
            'L' => (0, -1.0),
            'A' => (1, 1.0),
            'P' => (1, -1.0),
            'I' => (2, 1.0),
            'S' => (2, -1.0),
            _ => return Ok(None),
        };
        match directions.get_mut(axis) {
            Some(direction) => direction[to] = sign,
            None => return Ok(None),
        }
    }
    notes.push(format!(
        "the orientation comes from AnatomicalOrientation = {}",
        shorten(letters)
    ));
    Ok(Some(directions))
}

fn number(header: &Header, field: &'static str, default: f64) -> Result<f64, Problem> {
    match header.get(&[field]) {
        None => Ok(default),
        Some(text) => text.parse().map_err(|_| refuse(field, text, "a number")),
    }
}

/// Exactly `count` numbers.
fn numbers<T: std::str::FromStr>(text: &str, count: usize) -> Option<Vec<T>> {
    let words: Result<Vec<T>, _> = text.split_ascii_whitespace().map(str::parse).collect();
    words.ok().filter(|words| words.len() == count)
}

/// A field whose value is not usable.
fn refuse(field: &'static str, value: &str, expected: &'static str) -> Problem {
    Problem::FieldValue {
        field,
        value: shorten(value),
        expected,
    }
}

#[cfg(test)]
mod tests;
