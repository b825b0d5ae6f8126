//! NIfTI-1 and NIfTI-2 volumes (`.nii`, `.nii.gz`, and `.hdr` with an `.img` beside it).
//!
//! Source: nifti1.h and nifti2.h of the NIfTI data format working group. Read: integers of 8 to 64 bits, single and double
//! precision, either byte order, `scl_slope` and `scl_inter`, and colours (RGB24, RGBA32, of 8 bits); exactly one volume; what
//! follows it is left out with a note.
//! Orientation comes from the sform, else from the qform, else is unknown; both speak RAS and are brought to LPS.

mod header;
mod orientation;

use std::collections::HashMap;
use std::io::{BufRead, BufReader, Cursor, Read};
use std::path::{Path, PathBuf};

use flate2::bufread::MultiGzDecoder;

use self::header::{Header, NAME};
use self::orientation::orientation;
use super::axes::Directions;
use super::choice::Choice;
use super::colours::Colours;
use super::companion;
use super::decoded::Decoded;
use super::error::{Problem, ReadError};
use super::file::open_regular;
use super::payload::{ByteSkip, Encoding, Layout, Tail};
use super::placed::{Place, Placed};

/// Reads a NIfTI file, packed by gzip or not, or a header and the `.img` file beside it, whichever of the two is named.
///
/// # Errors
/// [`ReadError`] names the file, what was wrong and what was expected; see [`Problem`].
pub fn read(path: &Path, choice: &Choice) -> Result<Decoded, ReadError> {
    place(path)?.read(choice.nan)
}

/// What a NIfTI header says, and where its values are.
///
/// # Errors
/// As [`read`].
pub(super) fn place(path: &Path) -> Result<Placed, ReadError> {
    if let Some(header) = header_beside(path) {
        let mut placed = place(&header)?;
        placed.notes.push(format!("the header is in {}", header.display()));
        return Ok(placed);
    }
    let (header, data_path) = located(path)?;
    check_one_value(&header).map_err(|problem| ReadError::new(&data_path, problem))?;
    placed(&header, data_path, path.display().to_string())
}

/// Reads a NIfTI file of colours (RGB24, RGBA32); `None` of one with a value a voxel.
///
/// # Errors
/// As [`read`].
pub fn read_colours(path: &Path) -> Result<Option<Colours>, ReadError> {
    let beside = header_beside(path);
    let path = beside.as_deref().unwrap_or(path);
    let (header, data_path) = located(path)?;
    if header.components == 1 {
        return Ok(None);
    }
    // Slope and intercept do not concern colours.
    let placed = placed(&header, data_path, path.display().to_string())?;
    placed.read_colours(HashMap::new()).map(Some)
}

/// The header of a file, and the file that has the data.
fn located(path: &Path) -> Result<(Header, PathBuf), ReadError> {
    let fail = |problem| ReadError::new(path, problem);
    let (mut source, _) = open_regular(path)?;
    let packed = is_gzip(&mut source).map_err(fail)?;
    let header = header_of(&mut source, packed).map_err(fail)?;
    if header.attached {
        return Ok((header, path.to_owned()));
    }
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let stem = stem.strip_suffix(".hdr").unwrap_or(&stem).to_owned();
    let data_path = companion::data_file(path, &format!("{stem}.img"))?;
    if data_path.exists() {
        return Ok((header, data_path));
    }
    let packed_path = companion::data_file(path, &format!("{stem}.img.gz"))?;
    Ok((header, if packed_path.exists() { packed_path } else { data_path }))
}

/// What a header says of the values in a file.
fn placed(header: &Header, data_path: PathBuf, name: String) -> Result<Placed, ReadError> {
    let (mut source, _) = open_regular(&data_path)?;
    let packed = is_gzip(&mut source);
    let described = packed.and_then(|packed| described(header, data_path.clone(), packed, name));
    described.map_err(|problem| ReadError::new(&data_path, problem))
}

/// Reads a NIfTI file that is already in memory; `name` stands for its path in messages.
///
/// # Errors
/// As [`read`]; a header without its data is refused.
pub fn read_bytes(bytes: &[u8], name: &str, choice: &Choice) -> Result<Decoded, ReadError> {
    let fail = |problem| ReadError::new(Path::new(name), problem);
    let mut source = Cursor::new(bytes);
    let packed = is_gzip(&mut source).map_err(fail)?;
    let header = header_of(&mut source, packed).map_err(fail)?;
    if !header.attached {
        let fault = "is a header without data (magic `ni1` or `ni2`), expected both in one file here";
        return Err(fail(Problem::format(NAME, fault)));
    }
    check_one_value(&header).map_err(fail)?;
    let mut source = Cursor::new(bytes);
    let placed = described(&header, name.into(), packed, name.to_owned()).map_err(fail)?;
    placed
        .read_from(&mut source, bytes.len() as u64, choice.nan)
        .map_err(fail)
}

/// Whether a file that begins so is a NIfTI header; `start` may be packed.
pub(super) fn recognise(start: &[u8]) -> bool {
    if start.starts_with(&[0x1f, 0x8b]) {
        let mut unpacked = [0; 348];
        return MultiGzDecoder::new(start).read_exact(&mut unpacked).is_ok() && header::has_magic(&unpacked);
    }
    header::has_magic(start)
}

/// The header that belongs to a data file `NAME.img` or `NAME.img.gz`: `NAME.hdr` or `NAME.hdr.gz` beside it.
pub(super) fn header_beside(path: &Path) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let lower = name.to_ascii_lowercase();
    let stem_len = lower.strip_suffix(".gz").unwrap_or(&lower).strip_suffix(".img")?.len();
    let candidates = ["hdr", "HDR", "hdr.gz"].map(|end| path.with_file_name(format!("{}.{end}", &name[..stem_len])));
    candidates.into_iter().find(|header| header.is_file())
}

/// Whether the source begins with a gzip member.
fn is_gzip(source: &mut impl BufRead) -> Result<bool, Problem> {
    let start = source.fill_buf().map_err(Problem::io("read the file"))?;
    Ok(start.starts_with(&[0x1f, 0x8b]))
}

/// The header at the source's beginning.
fn header_of(source: &mut impl BufRead, packed: bool) -> Result<Header, Problem> {
    if packed {
        Header::read(&mut BufReader::new(MultiGzDecoder::new(source)))
    } else {
        Header::read(source)
    }
}

/// Refuses colours.
fn check_one_value(header: &Header) -> Result<(), Problem> {
    if header.components == 1 {
        return Ok(());
    }
    Err(Problem::Unsupported {
        format: NAME,
        found: format!("a volume of {} colours a voxel", header.components),
        expected: "one value a voxel; `render`, `compare` and `pyramid` take colours",
    })
}

/// A header's word, of values in a file that begins with as many other bytes as it says.
fn described(header: &Header, path: PathBuf, packed: bool, name: String) -> Result<Placed, Problem> {
    let orientation = orientation(header)?;
    Ok(Placed {
        name,
        format: NAME,
        // The bytes before the values are counted in the unpacked file.
        place: Place::File(path, 0),
        layout: Layout {
            dims: header.dims,
            components: header.components,
            value_type: header.value_type,
            endian: header.endian,
            encoding: if packed { Encoding::Gzip } else { Encoding::Raw },
            line_skip: 0,
            byte_skip: ByteSkip::Bytes(header.data_offset),
            tail: Tail::LeftOut,
        },
        spacing: orientation.spacing,
        directions: orientation.directions.map(Directions::Patient),
        rescale: (header.slope != 0.0).then_some([header.slope, header.intercept]),
        modality: None,
        stated_window: Some(header.display_range),
        packed_len: None,
        notes: [header.notes.clone(), orientation.notes].concat(),
    })
}

#[cfg(test)]
mod tests;
