//! NRRD volumes (`.nrrd`, and `.nhdr` with a data file beside it).
//!
//! Read: versions 1 to 5; integers of 8 to 64 bits, `float`, `double`; either byte order; encodings `raw`, `gzip`,
//! `bzip2` and `ascii`; three axes, beside which others may have one entry; data attached, in one file or in many
//! (`LIST` or a pattern). Spacing comes from `spacings`, or from the lengths of `space directions`, or is 1; `units` and
//! `space units` bring it to millimetres. With `space directions` the voxels are reordered and reversed so that they run
//! along the axes of the space: the patient's (LPS) if `space` is one of the three patient spaces. Two keys of our own:
//! `hounsfield_offset:=N` makes the data's unit the stored value plus N, `modality:=CT` tells what made the values.

mod colours;
mod header;
mod orientation;
mod surplus;
pub mod write;

use std::io::{BufRead, Cursor};
use std::path::Path;

use self::header::Header;
use super::axes::Directions;
use super::choice::Choice;
use super::colours::Colours;
use super::companion;
use super::decoded::Decoded;
use super::error::{Problem, ReadError};
use super::file::open_regular;
use super::files::Data;
use super::meaning::Modality;
use super::payload::{ByteSkip, Encoding, Layout, Tail};
use super::placed::{Place, Placed};
use super::text::shorten;
use super::values::{Endian, ValueType, check_spacing};

/// What a header says about its volume, interpreted.
#[derive(Debug)]
struct Description {
    layout: Layout,
    spacing: [f64; 3],
    directions: Option<Directions>,
    value_offset: i32,
    modality: Option<Modality>,
    data: Data,
    notes: Vec<String>,
}

/// Reads an NRRD file. A detached header's data file must lie in the header's folder or below it.
///
/// # Errors
/// [`ReadError`] names the file (header or data), what was wrong and what was expected; see [`Problem`].
pub fn read(path: &Path, choice: &Choice) -> Result<Decoded, ReadError> {
    place(path)?.read(choice.nan)
}

/// What an NRRD file's header says, and where its values are.
///
/// # Errors
/// As [`read`].
pub(super) fn place(path: &Path) -> Result<Placed, ReadError> {
    let at_header = |problem| ReadError::new(path, problem);
    let (mut source, _) = open_regular(path)?;
    let (header, description) = describe(&mut source).map_err(at_header)?;
    let place = place_of(path, &header, &description)?;
    Ok(description.placed(path.display().to_string(), place))
}

/// Reads an NRRD file of colours: its first axis has three or four entries, which no field says to be anything else.
/// `None` of a file that has no such axis.
///
/// # Errors
/// As [`read`].
pub fn read_colours(path: &Path) -> Result<Option<Colours>, ReadError> {
    let at_header = |problem| ReadError::new(path, problem);
    let (mut source, _) = open_regular(path)?;
    let mut header = Header::read(&mut source).map_err(at_header)?;
    let Some(components) = colours::take(&mut header).map_err(at_header)? else {
        return Ok(None);
    };
    of_components(path, header, components).map(Some)
}

/// Reads an NRRD file whose first axis holds 1 to 8 shares of materials.
///
/// # Errors
/// As [`read`].
pub fn read_shares(path: &Path) -> Result<Colours, ReadError> {
    let at_header = |problem| ReadError::new(path, problem);
    let (mut source, _) = open_regular(path)?;
    let mut header = Header::read(&mut source).map_err(at_header)?;
    let components = colours::take_shares(&mut header).map_err(at_header)?;
    of_components(path, header, components)
}

/// Reads the values of a file whose first axis has been taken off its header.
fn of_components(path: &Path, mut header: Header, components: usize) -> Result<Colours, ReadError> {
    let at_header = |problem| ReadError::new(path, problem);
    surplus::leave_out(&mut header).map_err(at_header)?;
    let mut description = interpret(&header).map_err(at_header)?;
    description.layout.components = components as u64;
    let place = place_of(path, &header, &description)?;
    let placed = description.placed(path.display().to_string(), place);
    placed.read_colours(header.keys)
}

/// Where the values are.
fn place_of(path: &Path, header: &Header, description: &Description) -> Result<Place, ReadError> {
    Ok(match &description.data {
        Data::Attached if !header.ended => return Err(ReadError::new(path, Problem::NoData)),
        Data::Attached => Place::File(path.to_owned(), header.len),
        Data::File(data_file) => Place::File(companion::data_file(path, data_file)?, 0),
        Data::Files(files) => Place::Files(path.to_owned(), files.clone()),
    })
}

/// Reads an NRRD file with attached data that is already in memory; `name` stands for its path in messages.
///
/// # Errors
/// As [`read`]; a header that names a data file is refused.
pub fn read_bytes(bytes: &[u8], name: &str, choice: &Choice) -> Result<Decoded, ReadError> {
    let fail = |problem| ReadError::new(Path::new(name), problem);
    let mut source = Cursor::new(bytes);
    let (header, description) = describe(&mut source).map_err(fail)?;
    if !matches!(description.data, Data::Attached) {
        return Err(fail(Problem::FieldValue {
            field: "data file",
            value: shorten(header.get("data file").unwrap_or_default()),
            expected: "no such field, since the data have to be attached here",
        }));
    }
    if !header.ended {
        return Err(fail(Problem::NoData));
    }
    let left = (bytes.len() as u64).saturating_sub(header.len);
    let placed = description.placed(name.to_owned(), Place::File(name.into(), header.len));
    placed.read_from(&mut source, left, choice.nan).map_err(fail)
}

/// Reads and interprets a header.
fn describe(source: &mut impl BufRead) -> Result<(Header, Description), Problem> {
    let mut header = Header::read(source)?;
    surplus::leave_out(&mut header)?;
    let description = interpret(&header)?;
    Ok((header, description))
}

impl Description {
    /// With where the values are.
    fn placed(self, name: String, place: Place) -> Placed {
        Placed {
            name,
            format: "NRRD",
            place,
            layout: self.layout,
            spacing: self.spacing,
            directions: self.directions,
            rescale: Some([1.0, f64::from(self.value_offset)]),
            modality: self.modality,
            stated_window: None,
            packed_len: None,
            notes: self.notes,
        }
    }
}

/// Makes sense of a header's fields.
fn interpret(header: &Header) -> Result<Description, Problem> {
    let dimension = header.require("dimension", "3")?;
    if dimension != "3" {
        return Err(refuse("dimension", dimension, "3: a volume of one value a voxel"));
    }
    let types = ValueType::NAMES;
    let name = header.require("type", types)?;
    let value_type = ValueType::from_name(name).ok_or_else(|| refuse("type", name, types))?;
    let sizes = header.require("sizes", "three whole numbers")?;
    let dims = three(sizes, |word| word.parse::<u64>().ok());
    let dims = dims.ok_or_else(|| refuse("sizes", sizes, "three whole numbers"))?;
    check_kinds(header)?;
    let (spacing, directions, orientation_notes) = orientation::read(header)?;
    let notes = [header.notes.clone(), orientation_notes].concat();
    check_spacing(spacing)?;
    let encoding = encoding(header)?;
    let layout = Layout {
        dims,
        components: 1,
        value_type,
        endian: endian(header, value_type, encoding)?,
        encoding,
        line_skip: line_skip(header)?,
        byte_skip: byte_skip(header, encoding)?,
        tail: Tail::Refused,
    };
    let value_offset = value_offset(header)?;
    Ok(Description {
        layout,
        spacing,
        directions,
        value_offset,
        modality: header.keys.get("modality").and_then(|code| Modality::from_code(code)),
        data: data(header)?,
        notes,
    })
}

/// Refuses axes that are no directions of space, such as the three colours of a picture.
fn check_kinds(header: &Header) -> Result<(), Problem> {
    let Some(kinds) = header.get("kinds") else {
        return Ok(());
    };
    let spatial = |word: &str| ["domain", "space", "none", "???"].contains(&word.to_ascii_lowercase().as_str());
    match three(kinds, |word| spatial(word).then_some(())) {
        Some(_) => Ok(()),
        None => Err(refuse("kinds", kinds, "`domain` or `space` for each of three axes")),
    }
}

fn encoding(header: &Header) -> Result<Encoding, Problem> {
    let expected = "`raw`, `gzip`, `bzip2` or `ascii`";
    let name = header.require("encoding", expected)?;
    match name.to_ascii_lowercase().as_str() {
        "raw" => Ok(Encoding::Raw),
        "gzip" | "gz" => Ok(Encoding::Gzip),
        "bzip2" | "bz2" => Ok(Encoding::Bzip2),
        "ascii" | "text" | "txt" => Ok(Encoding::Text),
        _ => Err(refuse("encoding", name, expected)),
    }
}

fn endian(header: &Header, value_type: ValueType, encoding: Encoding) -> Result<Endian, Problem> {
    let expected = "`little` or `big`";
    match header.get("endian") {
        // Single bytes and written numbers have no order.
        None if value_type.byte_len() == 1 || encoding == Encoding::Text => Ok(Endian::Little),
        None => Err(Problem::MissingField {
            field: "endian",
            expected,
        }),
        Some(name) => match name.to_ascii_lowercase().as_str() {
            "little" => Ok(Endian::Little),
            "big" => Ok(Endian::Big),
            _ => Err(refuse("endian", name, expected)),
        },
    }
}

fn line_skip(header: &Header) -> Result<u64, Problem> {
    let text = header.get("line skip").unwrap_or("0");
    text.parse()
        .map_err(|_| refuse("line skip", text, "a whole number, 0 or more"))
}

fn byte_skip(header: &Header, encoding: Encoding) -> Result<ByteSkip, Problem> {
    let text = header.get("byte skip").unwrap_or("0");
    match (text, encoding) {
        ("-1", Encoding::Raw) => Ok(ByteSkip::FromEnd),
        ("-1", _) => Err(refuse("byte skip", text, "0 or more, since -1 needs encoding `raw`")),
        _ => match text.parse() {
            Ok(bytes) => Ok(ByteSkip::Bytes(bytes)),
            Err(_) => Err(refuse("byte skip", text, "a whole number, 0 or more, or -1")),
        },
    }
}

/// Our own key: what to add to a stored value to get Hounsfield units.
fn value_offset(header: &Header) -> Result<i32, Problem> {
    let Some(text) = header.keys.get("hounsfield_offset") else {
        return Ok(0);
    };
    text.trim()
        .parse()
        .map_err(|_| refuse("hounsfield_offset", text, "a whole number of at most 32 bits"))
}

/// Where the data are.
fn data(header: &Header) -> Result<Data, Problem> {
    match header.get("data file") {
        None => Ok(Data::Attached),
        Some(text) => Data::named(text, &header.listed).map_err(|expected| refuse("data file", text, expected)),
    }
}

/// Exactly three words, each read by `parse`.
fn three<T>(text: &str, parse: impl Fn(&str) -> Option<T>) -> Option<[T; 3]> {
    let words: Vec<&str> = text.split_ascii_whitespace().collect();
    let [x, y, z] = words[..] else { return None };
    Some([parse(x)?, parse(y)?, parse(z)?])
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

#[cfg(test)]
mod colour_tests;
