//! Stored values in their files, or in the chunks of a store: where each of them lies, and how a box of them is read.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use tempfile::NamedTempFile;

use crate::axes::Turn;
use crate::chunked::Chunked;
use crate::companion;
use crate::error::{Problem, ReadError};
use crate::payload::{Encoding, Layout, decode, plain_start, unpack_into};
use crate::placed::{Place, Placed, looked_at, open_at};
use crate::values::{Values, side_product};

/// Rows of a strip: 64 KiB of 16-bit values in a row of 2048, which a disk reads at once.
pub(super) const ROWS: usize = 16;

/// Values of a block of plain values, if a slice has more: several strips.
const BLOCK: usize = 1 << 20;

/// A file that holds some of the values, plain.
#[derive(Debug)]
struct Piece {
    path: PathBuf,
    /// Bytes before its values.
    start: u64,
}

/// The values of a volume.
#[derive(Debug)]
pub(super) struct Store {
    layout: Layout,
    /// The first file or the folder, for messages.
    path: PathBuf,
    kind: Kind,
}

#[derive(Debug)]
enum Kind {
    Plain(Plain),
    /// Chunks that are read as wholes, and how many were.
    Chunks(Arc<dyn Chunked>, AtomicU64),
}

/// Values, plain, in files that hold as many each.
#[derive(Debug)]
struct Plain {
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

/// A volume cut into blocks, x fastest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Blocks {
    pub dims: [usize; 3],
    /// Voxels of a block; those at the far ends have fewer.
    pub side: [usize; 3],
}

impl Blocks {
    /// Blocks along each axis.
    pub fn counts(&self) -> [usize; 3] {
        [0, 1, 2].map(|axis| self.dims[axis].div_ceil(self.side[axis].max(1)))
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.counts().iter().product()
    }

    /// The number of a block.
    pub fn number(&self, [x, y, z]: [usize; 3]) -> usize {
        let [nx, ny, _] = self.counts();
        (z * ny + y) * nx + x
    }

    /// The place of a block, by its number.
    pub fn place(&self, number: usize) -> [usize; 3] {
        let [nx, ny, _] = self.counts();
        [number % nx, number / nx % ny, number / nx / ny]
    }

    /// The voxels of a block.
    pub fn region(&self, place: [usize; 3]) -> Region {
        let first = [0, 1, 2].map(|axis| place[axis] * self.side[axis]);
        Region {
            first,
            dims: [0, 1, 2].map(|axis| self.side[axis].min(self.dims[axis] - first[axis])),
        }
    }

    /// What a box has of each block that it meets.
    pub fn cut(&self, region: Region) -> Vec<Region> {
        let ends = |axis: usize| {
            let (first, side) = (region.first[axis], self.side[axis].max(1));
            let end = first + region.dims[axis];
            (first / side..end.div_ceil(side)).map(move |number| {
                let start = first.max(number * side);
                (start, end.min((number + 1) * side) - start)
            })
        };
        let mut parts = Vec::new();
        for (z, depth) in ends(2) {
            for (y, height) in ends(1) {
                for (x, width) in ends(0) {
                    parts.push(Region {
                        first: [x, y, z],
                        dims: [width, height, depth],
                    });
                }
            }
        }
        parts
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
            Place::Chunks(chunks) => {
                return Ok(Self {
                    layout: placed.layout,
                    path: chunks.folder().to_owned(),
                    kind: Kind::Chunks(chunks.clone(), AtomicU64::new(0)),
                });
            }
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
            layout,
            path: pieces.first().map_or(PathBuf::new(), |piece| piece.path.clone()),
            kind: Kind::Plain(Plain {
                pieces,
                per_piece,
                layout,
                _scratch: scratch,
            }),
        })
    }

    /// Voxels along the file's axes.
    pub fn dims(&self) -> [usize; 3] {
        self.layout.dims.map(|side| side as usize)
    }

    /// The file or the folder, for messages.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The volume in blocks.
    pub fn blocks(&self) -> Blocks {
        Blocks {
            dims: self.dims(),
            side: self.block(),
        }
    }

    /// The sides of a block, of which a thread reads one at a time: rows of a slice of plain values, or a chunk.
    pub fn block(&self) -> [usize; 3] {
        match &self.kind {
            Kind::Plain(_) => {
                let [nx, ny, _] = self.dims();
                let strips = (BLOCK / (ROWS * nx.max(1))).max(1);
                [nx, ny.min(strips * ROWS), 1]
            }
            Kind::Chunks(chunks, _) => chunks.side().map(|side| side as usize),
        }
    }

    /// Whether a block can be read in pieces, rather than as a whole.
    pub const fn is_plain(&self) -> bool {
        matches!(self.kind, Kind::Plain(_))
    }

    /// Bytes that a thread takes to read a block, and to make codes of it.
    pub fn reading_bytes(&self) -> u64 {
        let values = self.block().iter().product::<usize>() as u64;
        let value_len = self.layout.value_type.byte_len();
        values * (2 * value_len + 2)
            + match &self.kind {
                Kind::Plain(_) => 0,
                Kind::Chunks(chunks, _) => chunks.reading_bytes(),
            }
    }

    /// Chunks that were read so far, those read again counted again, of how many; `None` of plain values.
    pub fn chunks_read(&self) -> Option<[u64; 2]> {
        match &self.kind {
            Kind::Plain(_) => None,
            Kind::Chunks(chunks, read) => Some([read.load(Ordering::Relaxed), chunks.counts().iter().product()]),
        }
    }

    /// The values of a box, which lies in one block: its bytes are held beside.
    ///
    /// # Errors
    /// [`ReadError`] if a file cannot be read, or not any more.
    pub fn read(&self, region: Region) -> Result<Values, ReadError> {
        let bytes = match &self.kind {
            Kind::Plain(plain) => plain.read(region)?,
            Kind::Chunks(chunks, read) => {
                read.fetch_add(1, Ordering::Relaxed);
                let side = chunks.side();
                let [first, dims] = [region.first, region.dims].map(|three| three.map(|side| side as u64));
                let chunk = [0, 1, 2].map(|axis| first[axis] / side[axis]);
                chunks.read(chunk, [0, 1, 2].map(|axis| first[axis] % side[axis]), dims)?
            }
        };
        let count = region.dims.iter().product::<usize>() as u64;
        let fail = |problem| ReadError::new(self.path(), problem);
        let (values, end) = decode(&self.layout, &mut &bytes[..], count, count).map_err(fail)?;
        end.map_err(Problem::io("read the file")).map_err(fail)?;
        Ok(values)
    }
}

impl Plain {
    /// The bytes of a box.
    fn read(&self, region: Region) -> Result<Vec<u8>, ReadError> {
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
        Ok(bytes)
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
