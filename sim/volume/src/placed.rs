//! A volume as its header tells it, its values still in their file.
//!
//! NRRD, MetaImage, NIfTI and raw files and Zarr stores all end here: the values are read whole ([`Placed::read`]) or stay where they are
//! ([`on_disk`](crate::on_disk)).

use std::collections::HashMap;
use std::io::{BufRead, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::axes::Directions;
use super::choice::NanRule;
use super::chunked::Chunked;
use super::colours::Colours;
use super::decoded::Decoded;
use super::error::{Problem, ReadError};
use super::file::open_regular;
use super::files::DataFiles;
use super::meaning::Modality;
use super::payload::{Encoding, Layout, read_values};
use super::values::Values;

/// Where the values are.
#[derive(Clone, Debug)]
pub(super) enum Place {
    /// In a file, behind so many bytes.
    File(PathBuf, u64),
    /// In the files that a header names.
    Files(PathBuf, DataFiles),
    /// In the chunks of an array.
    Chunks(Arc<dyn Chunked>),
}

impl Place {
    /// The file that is at fault where values are.
    pub fn path(&self) -> &Path {
        match self {
            Self::File(path, _) | Self::Files(path, _) => path,
            Self::Chunks(chunks) => chunks.folder(),
        }
    }
}

/// What a header says, interpreted.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    /// Where it came from, for messages.
    pub name: String,
    /// The format's name in messages.
    pub format: &'static str,
    pub place: Place,
    pub layout: Layout,
    /// Distance between voxels along the file's axes.
    pub spacing: [f64; 3],
    pub directions: Option<Directions>,
    /// Scale and offset from stored values to the data's unit, where the file states them.
    pub rescale: Option<[f64; 2]>,
    pub modality: Option<Modality>,
    pub stated_window: Option<[f64; 2]>,
    /// How many packed bytes the header states; files state too few.
    pub packed_len: Option<u64>,
    pub notes: Vec<String>,
}

impl Placed {
    /// Reads the values.
    ///
    /// # Errors
    /// [`ReadError`] names the file, what was wrong and what was expected.
    pub fn read(mut self, nan: NanRule) -> Result<Decoded, ReadError> {
        let (values, fault) = (self.values()?, self.place.path().to_owned());
        self.finish(values, nan)
            .map_err(|problem| ReadError::new(&fault, problem))
    }

    /// Reads the values of a volume of colours, those of a voxel side by side; `keys` are the header's.
    ///
    /// # Errors
    /// As [`Placed::read`].
    pub fn read_colours(mut self, keys: HashMap<String, String>) -> Result<Colours, ReadError> {
        let values = self.values()?;
        let fail = |problem: Problem| ReadError::new(self.place.path(), problem);
        let dims = self.layout.dims.map(|d| d as usize);
        let colours = Colours::new(self.name, dims, self.spacing, self.layout.components as usize, values);
        let colours = colours.map_err(|error| fail(error.into()))?.with(keys, self.notes);
        match self.directions {
            Some(directions) => colours.along(directions).map_err(fail),
            None => Ok(colours),
        }
    }

    fn values(&mut self) -> Result<Values, ReadError> {
        match &self.place {
            Place::File(path, start) => {
                let fail = |problem| ReadError::new(path, problem);
                let (mut source, len) = open_at(path, *start)?;
                let layout = looked_at(self.layout, self.packed_len, &mut source, len, &mut self.notes);
                read_values(&layout.map_err(fail)?, &mut source, len, &mut self.notes).map_err(fail)
            }
            Place::Files(header, files) => files.read(header, &self.layout, sniffed, &mut self.notes),
            Place::Chunks(chunks) => chunks.values(&self.layout),
        }
    }

    /// Reads the values from a source that begins with them and has `len` bytes.
    ///
    /// # Errors
    /// [`Problem`] says what was wrong.
    pub fn read_from(mut self, source: &mut dyn BufRead, len: u64, nan: NanRule) -> Result<Decoded, Problem> {
        let layout = looked_at(self.layout, self.packed_len, source, len, &mut self.notes)?;
        let values = read_values(&layout, source, len, &mut self.notes)?;
        self.finish(values, nan)
    }

    /// Joins the values with what is known of them.
    fn finish(self, values: Values, nan: NanRule) -> Result<Decoded, Problem> {
        let dims = self.layout.dims.map(|d| d as usize);
        let [scale, offset] = self.rescale.unwrap_or([1.0, 0.0]);
        let mut decoded = Decoded::with_nan(self.name, dims, self.spacing, values, (nan, scale))?
            .with_modality(self.modality)
            .with_stated_window(self.stated_window)
            .with_notes(self.notes);
        if self.rescale.is_some() {
            decoded = decoded.with_rescale(self.format, scale, offset)?;
        }
        match self.directions {
            Some(directions) => decoded.along(directions),
            None => Ok(decoded),
        }
    }
}

/// Opens a file at a byte; the bytes left come with it.
pub(super) fn open_at(path: &Path, start: u64) -> Result<(impl BufRead + use<>, u64), ReadError> {
    let (mut source, len) = open_regular(path)?;
    let sought = source
        .seek(SeekFrom::Start(start))
        .map_err(Problem::io("read the file"));
    sought.map_err(|problem| ReadError::new(path, problem))?;
    Ok((source, len.saturating_sub(start)))
}

/// The layout, with the first bytes' word for how packed data are packed; `packed_len` is the header's word for `len`.
///
/// # Errors
/// [`Problem::Io`] if they cannot be read.
pub(super) fn looked_at(
    layout: Layout,
    packed_len: Option<u64>,
    source: &mut dyn BufRead,
    len: u64,
    notes: &mut Vec<String>,
) -> Result<Layout, Problem> {
    if layout.encoding != Encoding::Zlib {
        return Ok(layout);
    }
    let start = source.fill_buf().map_err(Problem::io("read the file"))?;
    let layout = sniffed(layout, start);
    if let Some(stated) = packed_len.filter(|&stated| stated != len) {
        notes.push(format!(
            "CompressedDataSize is {stated}, the file has {len} bytes of packed data: all are read"
        ));
    }
    Ok(layout)
}

/// Packed data are zlib's or gzip's; their first bytes tell.
fn sniffed(layout: Layout, start: &[u8]) -> Layout {
    let encoding = match layout.encoding {
        Encoding::Zlib if start.starts_with(&[0x1f, 0x8b]) => Encoding::Gzip,
        other => other,
    };
    Layout { encoding, ..layout }
}
