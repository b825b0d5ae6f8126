//! Stored values in their files: where each of them lies, and how a box of them is read.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::axes::Turn;
use crate::companion;
use crate::error::{Problem, ReadError};
use crate::payload::{Encoding, Layout, decode, plain_start, unpack_into};
use crate::placed::{Place, Placed, looked_at, open_at};
use crate::values::{Values, side_product};

/// A file that holds some of the values, plain.
#[derive(Debug)]
struct Piece {
    path: PathBuf,
    /// Bytes before its values.
    start: u64,
}

/// The values of a volume, plain, in files that hold as many each.
#[derive(Debug)]
pub(super) struct Store {
    pieces: Vec<Piece>,
    /// Values of a piece.
    per_piece: u64,
    layout: Layout,
    /// Where packed values were unpacked to; deleted with the store.
    _scratch: Option<NamedTempFile>,
}

/// A box of voxels along the file's axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Region {
    pub first: [usize; 3],
    pub dims: [usize; 3],
}

impl Region {
    /// The box of the file that a box of the volume comes from; `whole` are the file's sides.
    pub fn turned(self, turn: &Turn, whole: [usize; 3]) -> Self {
        let mut region = Self {
            first: [0; 3],
            dims: whole,
        };
        for (axis, from) in turn.source.into_iter().enumerate() {
            let (first, side) = (self.first[axis], self.dims[axis]);
            region.dims[from] = side;
            region.first[from] = if turn.reversed[axis] {
                whole[from] - first - side
            } else {
                first
            };
        }
        region
    }
}

impl Store {
    /// Finds the values that a header tells of, and unpacks them into a scratch file if they are packed. What there is to
    /// say of it is added to the header's notes.
    ///
    /// # Errors
    /// [`ReadError`] names the file, what was wrong and what was expected.
    pub fn open(placed: &mut Placed) -> Result<Self, ReadError> {
        let header = placed.place.path();
        let at_header = |problem: Problem| ReadError::new(header, problem);
        side_product(placed.layout.dims).map_err(|error| at_header(error.into()))?;
        let (sources, dims) = match &placed.place {
            Place::File(path, start) => (vec![(path.clone(), *start)], placed.layout.dims),
            Place::Files(header, files) => {
                let path = |name: &String| Ok((companion::data_file(header, name)?, 0));
                let sources: Result<Vec<_>, ReadError> = files.names.iter().map(path).collect();
                (sources?, files.slab(placed.layout.dims).map_err(at_header)?)
            }
        };
        let part = Layout { dims, ..placed.layout };
        let per_piece: u64 = dims.iter().product();
        let expected = per_piece * part.value_type.byte_len();
        let (mut pieces, mut scratch, mut notes) = (Vec::new(), None, Vec::new());
        for (path, start) in sources {
            let fail = |problem| ReadError::new(&path, problem);
            let (mut source, len) = open_at(&path, start)?;
            let layout = looked_at(part, placed.packed_len, &mut source, len, &mut notes).map_err(fail)?;
            match layout.encoding {
                Encoding::Text => {
                    let fault = "the values are text, expected plain or packed ones in a volume that is read in parts";
                    return Err(fail(Problem::format(placed.format, fault)));
                }
                Encoding::Raw => {
                    let passed = plain_start(&layout, &mut source, len, expected, &mut notes).map_err(fail)?;
                    let start = start + passed;
                    pieces.push(Piece { path, start });
                }
                Encoding::Gzip | Encoding::Zlib | Encoding::Bzip2 => {
                    let new = NamedTempFile::new().map_err(Problem::io("make a scratch file"));
                    let out = match &mut scratch {
                        Some(out) => out,
                        none => none.insert(new.map_err(fail)?),
                    };
                    unpack_into(&layout, &mut source, expected, &mut notes, out).map_err(fail)?;
                    pieces.push(Piece {
                        path: out.path().to_owned(),
                        start: expected * pieces.len() as u64,
                    });
                }
            }
        }
        if let Some(out) = &mut scratch {
            let written = out.flush().map_err(Problem::io("write a scratch file"));
            written.map_err(at_header)?;
            notes.push(format!(
                "the values are packed: {} bytes are unpacked into a scratch file in {}, which is deleted at the end",
                expected * pieces.len() as u64,
                out.path().parent().unwrap_or(Path::new(".")).display()
            ));
        }
        // One file's note stands for all of its kind.
        notes.dedup();
        let layout = placed.layout;
        placed.notes.append(&mut notes);
        Ok(Self {
            pieces,
            per_piece,
            layout,
            _scratch: scratch,
        })
    }

    /// Voxels along the file's axes.
    pub fn dims(&self) -> [usize; 3] {
        self.layout.dims.map(|side| side as usize)
    }

    /// Bytes of a value.
    pub const fn value_len(&self) -> u64 {
        self.layout.value_type.byte_len()
    }

    /// The first file, for messages.
    pub fn path(&self) -> &Path {
        self.pieces.first().map_or(Path::new(""), |piece| &piece.path)
    }

    /// The values of a box, of which at most one slice should be asked for at a time: its bytes are held beside.
    ///
    /// # Errors
    /// [`ReadError`] if a file cannot be read any more.
    pub fn read(&self, region: Region) -> Result<Values, ReadError> {
        let [nx, ny, _] = self.layout.dims;
        let [x, y, z] = region.first.map(|first| first as u64);
        let [columns, rows, slices] = region.dims.map(|side| side as u64);
        let byte_len = self.layout.value_type.byte_len();
        let count = columns * rows * slices;
        let mut bytes = vec![0; (count * byte_len) as usize];
        // Rows that lie side by side are read as one.
        let (run, rows) = if columns == nx {
            (columns * rows, 1)
        } else {
            (columns, rows)
        };
        let (run, slices) = if columns == nx && region.dims[1] as u64 == ny {
            (run * slices, 1)
        } else {
            (run, slices)
        };
        let mut open = None;
        let starts = (0..slices).flat_map(|k| (0..rows).map(move |j| ((z + k) * ny + y + j) * nx + x));
        for (start, out) in starts.zip(bytes.chunks_mut((run * byte_len) as usize)) {
            self.read_run(start, out, &mut open)?;
        }
        let (values, end) = decode(&self.layout, &mut &bytes[..], count, count)
            .map_err(|problem| ReadError::new(self.path(), problem))?;
        end.map_err(Problem::io("read the file"))
            .map_err(|problem| ReadError::new(self.path(), problem))?;
        Ok(values)
    }

    /// The bytes of values from `start` on; the file that was open last comes along.
    fn read_run(&self, start: u64, mut out: &mut [u8], open: &mut Option<(usize, File)>) -> Result<(), ReadError> {
        let byte_len = self.layout.value_type.byte_len();
        let mut start = start;
        while !out.is_empty() {
            let (number, within) = ((start / self.per_piece) as usize, start % self.per_piece);
            let Some(piece) = self.pieces.get(number) else {
                return Ok(());
            };
            let fail = |problem| ReadError::new(&piece.path, problem);
            let left = ((self.per_piece - within) * byte_len).min(out.len() as u64) as usize;
            let (part, rest) = out.split_at_mut(left);
            if open.as_ref().is_none_or(|(opened, _)| *opened != number) {
                let file = File::open(&piece.path).map_err(Problem::io("open the file"));
                *open = Some((number, file.map_err(fail)?));
            }
            if let Some((_, file)) = open {
                let place = SeekFrom::Start(piece.start + within * byte_len);
                let read = file.seek(place).and_then(|_| file.read_exact(part));
                read.map_err(Problem::io("read the file")).map_err(fail)?;
            }
            start += left as u64 / byte_len;
            out = rest;
        }
        Ok(())
    }
}
