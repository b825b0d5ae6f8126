//! The chunks of a volume: what one holds, and all of them as values.

use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use super::NAME;
use super::array::Array;
use super::codecs;
use super::shard::Places;
use super::unpacked::damage;
use crate::chunked::Chunked;
use crate::error::{Problem, ReadError};
use crate::limits::MAX_BYTES;
use crate::payload::{Layout, decode};
use crate::values::{Values, voxel_count};

/// Chunks that a volume may have.
const CHUNKS_MAX: u64 = 1 << 24;

/// Indices of shards that are kept: more than threads read at a time.
const KEPT_MAX: usize = 16;

/// The index of a shard, and its file.
type Kept = (PathBuf, Arc<Places>);

/// A volume in the chunks of an array.
#[derive(Clone, Debug)]
pub(crate) struct Chunks {
    array: Array,
    /// The array's axis of x, y and z; `None`: one voxel.
    space: [Option<usize>; 3],
    /// Where the volume lies along every other axis.
    at: Vec<u64>,
    /// Indices of the shards that were read last.
    indices: Arc<Mutex<Vec<Kept>>>,
}

impl Chunks {
    /// A volume of an array, which has a chunk at least.
    ///
    /// # Errors
    /// [`Problem`] if there are too many chunks, or none.
    pub(super) fn new(array: Array, space: [Option<usize>; 3], at: Vec<u64>) -> Result<Self, Problem> {
        let chunks = Self {
            array,
            space,
            at,
            indices: Arc::default(),
        };
        let counts = chunks.counts();
        let all = counts.iter().try_fold(1_u64, |all, &count| all.checked_mul(count));
        let Some(all) = all.filter(|&all| all <= CHUNKS_MAX) else {
            let fault = format!("has {counts:?} chunks, expected at most {CHUNKS_MAX} in all");
            return Err(Problem::format(NAME, fault));
        };
        let entries = chunks.array.folder.read_dir().into_iter().flatten().flatten();
        let metadata = |name: &str| name.starts_with('.') || name == "zarr.json";
        if entries
            .map(|entry| entry.file_name())
            .all(|name| metadata(&name.to_string_lossy()))
        {
            let first = chunks.path([0; 3]);
            let fault = format!(
                "has none of its {all} chunks, expected some, the first in {}",
                first.strip_prefix(&chunks.array.folder).unwrap_or(&first).display()
            );
            return Err(Problem::format(NAME, fault));
        }
        Ok(chunks)
    }

    /// Voxels along x, y and z.
    pub fn dims(&self) -> [u64; 3] {
        self.space.map(|axis| axis.map_or(1, |axis| self.array.shape[axis]))
    }

    /// The chunk's number along each axis of the array.
    fn index(&self, chunk: [u64; 3]) -> Vec<u64> {
        let mut index: Vec<u64> = self
            .at
            .iter()
            .zip(&self.array.chunk)
            .map(|(at, len)| at / len)
            .collect();
        for (axis, number) in self.space.into_iter().zip(chunk) {
            if let Some(axis) = axis {
                index[axis] = number;
            }
        }
        index
    }

    /// The file that a chunk is in.
    fn path(&self, chunk: [u64; 3]) -> PathBuf {
        let per_file = self
            .array
            .file
            .iter()
            .zip(&self.array.chunk)
            .map(|(file, chunk)| file / chunk);
        let index: Vec<u64> = self.index(chunk).iter().zip(per_file).map(|(i, n)| i / n).collect();
        self.array.path(&index)
    }

    /// All values of a chunk, as many as the metadata state; `None` of one that is not there.
    fn unpacked(&self, chunk: [u64; 3]) -> Result<Option<Vec<u8>>, ReadError> {
        let path = self.path(chunk);
        let fail = |problem| ReadError::new(&path, problem);
        let packed = self.packed(&path, chunk).map_err(|error| match error.kind() {
            io::ErrorKind::InvalidData | io::ErrorKind::UnexpectedEof => fail(Problem::format(NAME, error.to_string())),
            _ => fail(Problem::io("read the chunk")(error)),
        })?;
        let Some(packed) = packed else {
            return Ok(None);
        };
        let expected = self.array.chunk_bytes().and_then(|bytes| usize::try_from(bytes).ok());
        let unpacked = codecs::unpacked(&self.array.codecs, packed, expected.unwrap_or(usize::MAX));
        unpacked.map(Some).map_err(|fault| fail(Problem::format(NAME, fault)))
    }

    /// The bytes of a chunk in its file.
    fn packed(&self, path: &Path, chunk: [u64; 3]) -> io::Result<Option<Vec<u8>>> {
        let kind = match fs::metadata(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            kind => kind?,
        };
        if !kind.is_file() {
            return Err(damage("is no regular file, expected a chunk".into()));
        }
        if kind.len() > 2 * MAX_BYTES && self.array.shard.is_none() {
            return Err(damage(format!("has {} bytes, more than any chunk", kind.len())));
        }
        let mut file = File::open(path)?;
        let mut packed = Vec::new();
        let Some(index) = &self.array.shard else {
            file.read_to_end(&mut packed)?;
            return Ok(Some(packed));
        };
        let places = self.kept(path);
        let places = match places {
            Some(places) => places,
            None => {
                let places = Arc::new(index.read(&mut file, kind.len())?);
                let mut kept = self.indices.lock().unwrap_or_else(PoisonError::into_inner);
                kept.truncate(KEPT_MAX - 1);
                kept.insert(0, (path.to_owned(), places.clone()));
                places
            }
        };
        let within = self.index(chunk).into_iter().zip(&index.counts);
        let number = within.fold(0, |number, (i, count)| number * count + i % count);
        let Some([start, len]) = places.get(number as usize).copied().flatten() else {
            return Ok(None);
        };
        file.seek(SeekFrom::Start(start))?;
        file.take(len).read_to_end(&mut packed)?;
        Ok(Some(packed))
    }

    /// The index of a shard that was read before.
    fn kept(&self, path: &Path) -> Option<Arc<Places>> {
        let kept = self.indices.lock().unwrap_or_else(PoisonError::into_inner);
        let found = kept.iter().find(|(of, _)| of == path);
        found.map(|(_, places)| places.clone())
    }

    /// The bytes of a layer of chunks.
    fn layer(&self, z: u64) -> Result<Vec<u8>, ReadError> {
        let (dims, side, counts) = (self.dims(), self.side(), self.counts());
        let value_len = self.array.value_type.byte_len() as usize;
        let box_of = |chunk: [u64; 3]| {
            let first = [0, 1, 2].map(|to| chunk[to] * side[to]);
            (first, [0, 1, 2].map(|to| side[to].min(dims[to] - first[to])))
        };
        let (_, [_, _, slices]) = box_of([0, 0, z]);
        let mut layer = vec![0; (dims[0] * dims[1] * slices) as usize * value_len];
        let places: Vec<[u64; 3]> = (0..counts[1])
            .flat_map(|y| (0..counts[0]).map(move |x| [x, y, z]))
            .collect();
        for places in places.chunks(4 * rayon::current_num_threads()) {
            let read = |&chunk: &[u64; 3]| self.read(chunk, [0; 3], box_of(chunk).1);
            // All of them, so that of several faults the first chunk's is told, whichever thread meets one first.
            let read: Vec<Result<Vec<u8>, ReadError>> = places.par_iter().map(read).collect();
            for (&chunk, bytes) in places.iter().zip(read) {
                let bytes = bytes?;
                let ([x, y, _], sides) = box_of(chunk);
                let [nx, ny, _] = sides.map(|side| side as usize);
                for (number, row) in bytes.chunks_exact(nx * value_len).enumerate() {
                    let (k, j) = (number / ny, number % ny + y as usize);
                    let start = ((k * dims[1] as usize + j) * dims[0] as usize + x as usize) * value_len;
                    layer[start..start + row.len()].copy_from_slice(row);
                }
            }
        }
        Ok(layer)
    }
}

impl Chunked for Chunks {
    fn folder(&self) -> &Path {
        &self.array.folder
    }

    fn side(&self) -> [u64; 3] {
        let dims = self.dims();
        let side = |to: usize| self.space[to].map_or(1, |axis| self.array.chunk[axis]).min(dims[to]);
        [0, 1, 2].map(side)
    }

    fn counts(&self) -> [u64; 3] {
        let (dims, side) = (self.dims(), self.side());
        [0, 1, 2].map(|to| dims[to].div_ceil(side[to]))
    }

    fn reading_bytes(&self) -> u64 {
        4 * self.array.chunk_bytes().unwrap_or(u64::MAX / 8)
    }

    fn read(&self, chunk: [u64; 3], first: [u64; 3], dims: [u64; 3]) -> Result<Vec<u8>, ReadError> {
        let array = &self.array;
        let value_len = array.value_type.byte_len() as usize;
        let count = dims.iter().product::<u64>() as usize;
        let Some(bytes) = self.unpacked(chunk)? else {
            return Ok(array.fill.repeat(count));
        };
        // How far apart neighbours are in the chunk, along each axis of the array.
        let mut strides = vec![0; array.chunk.len()];
        let mut stride = value_len;
        for &axis in array.order.iter().rev() {
            strides[axis] = stride;
            stride *= array.chunk[axis] as usize;
        }
        let steps = self.space.map(|axis| axis.map_or(0, |axis| strides[axis]));
        let others = self.at.iter().zip(&array.chunk).zip(&strides);
        let base: usize = others.map(|((at, len), stride)| (at % len) as usize * stride).sum();
        let base = base
            + first
                .iter()
                .zip(steps)
                .map(|(first, step)| *first as usize * step)
                .sum::<usize>();
        let mut out = Vec::with_capacity(count * value_len);
        let [nx, ny, nz] = dims.map(|side| side as usize);
        for (z, y) in (0..nz).flat_map(|z| (0..ny).map(move |y| (z, y))) {
            let row = base + z * steps[2] + y * steps[1];
            if steps[0] == value_len || nx == 1 {
                out.extend_from_slice(&bytes[row..row + nx * value_len]);
            } else {
                for x in 0..nx {
                    let value = row + x * steps[0];
                    out.extend_from_slice(&bytes[value..value + value_len]);
                }
            }
        }
        Ok(out)
    }

    fn values(&self, layout: &Layout) -> Result<Values, ReadError> {
        let fail = |problem: Problem| ReadError::new(self.folder(), problem);
        let count = voxel_count(layout.dims).map_err(|error| fail(error.into()))?;
        let bytes = count * layout.value_type.byte_len();
        if bytes > MAX_BYTES {
            return Err(fail(Problem::TooLarge {
                bytes,
                what: "the unpacked values",
                limit: MAX_BYTES,
            }));
        }
        let mut layers = Layers {
            chunks: self,
            next: 0,
            bytes: Vec::new(),
            taken: 0,
            failed: None,
        };
        let decoded = decode(layout, &mut layers, count, count);
        if let Some(error) = layers.failed {
            return Err(error);
        }
        let (values, end) = decoded.map_err(fail)?;
        end.map_err(Problem::io("read the chunks")).map_err(fail)?;
        Ok(values)
    }
}

/// The values of a volume as a stream of bytes, a layer of chunks after the other.
struct Layers<'c> {
    chunks: &'c Chunks,
    next: u64,
    bytes: Vec<u8>,
    taken: usize,
    failed: Option<ReadError>,
}

impl Read for Layers<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.taken == self.bytes.len() && self.next < self.chunks.counts()[2] {
            self.bytes = self.chunks.layer(self.next).map_err(|error| {
                self.failed = Some(error);
                io::Error::other("a chunk cannot be read")
            })?;
            (self.next, self.taken) = (self.next + 1, 0);
        }
        let len = out.len().min(self.bytes.len() - self.taken);
        out[..len].copy_from_slice(&self.bytes[self.taken..self.taken + len]);
        self.taken += len;
        Ok(len)
    }
}
