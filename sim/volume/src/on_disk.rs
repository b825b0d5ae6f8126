//! A volume that stays in its file and is read part by part, for volumes larger than memory.
//!
//! Raw, NRRD, MetaImage and NIfTI files hold their values in one piece, or in files of as many each, so that any box of
//! voxels is found by its place; packed values are unpacked once into a scratch file. Zarr stores hold them in chunks, which are
//! read as wholes. How values become codes is chosen by a
//! census of all of them, as if they were in memory: a part has the codes that the whole volume would have there.

mod census;
mod pairs;
mod store;
mod strips;
#[cfg(test)]
mod tests;

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

pub use self::census::Progress;
use self::census::{Block, Histogram, Passes, background_needs_all, each_block};
use self::store::{Region, Store};
use self::strips::Strips;
pub use self::strips::Wanted;
use super::axes::Turn;
use super::choice::NanRule;
use super::decoded::Orientation;
use super::decoded::check_rescale;
use super::error::{Problem, ReadError};
use super::mapping::choice::{Chosen, Code, choose};
use super::mapping::{Tally, Window, codes};
use super::meaning::Meaning;
use super::open::{Found, LoadError, Loaded, Options, find};
use super::placed::Placed;
use super::statistics::Statistics;
use super::values::{Values, check_spacing};
use super::{Mapping, Volume};

/// Codes of values of 8 or 16 bits, by their bits.
const NARROW: usize = 1 << 16;

/// From stored values to codes.
#[derive(Debug)]
enum Coder {
    /// Of 8 or 16 bits: looked up.
    Table(Box<[u16; NARROW]>),
    /// Of more.
    Code(Code),
}

/// A volume in its file.
#[derive(Debug)]
pub struct OnDisk {
    name: String,
    dims: [usize; 3],
    spacing: [f64; 3],
    mapping: Mapping,
    turn: Turn,
    store: Store,
    coder: Coder,
    strips: Strips,
}

/// The turn to the volume's axes.
fn turn(placed: &Placed) -> Result<Turn, ReadError> {
    match placed.directions {
        None => Ok(Turn::NONE),
        Some(directions) => directions
            .turn()
            .map_err(|error| ReadError::new(placed.place.path(), error)),
    }
}

impl OnDisk {
    /// Opens a file, looks at all of its values once (8 and 16 bits) or several times (others), and chooses their codes.
    /// What is known of the volume comes beside it, without voxels.
    ///
    /// # Errors
    /// [`LoadError`] as of reading it whole; if the format is one that is read whole; or if values fall as their stored
    /// numbers rise, or NaN is to be background, which both change every value.
    pub fn open(
        path: &Path,
        window: Window,
        options: &Options,
        progress: Progress<'_>,
    ) -> Result<(Loaded, Self), LoadError> {
        let Found::Placed(placed) = find(path, options)? else {
            let problem = Problem::Unsupported {
                format: "a volume in parts",
                found: "a folder, DICOM or TIFF".into(),
                expected: "raw, NRRD, MetaImage, NIfTI or Zarr",
            };
            return Err(ReadError::new(path, problem).into());
        };
        let mut placed = *placed;
        let fault = placed.place.path().to_owned();
        let fail = |problem: Problem| ReadError::new(&fault, problem);
        check_spacing(placed.spacing).map_err(|error| fail(error.into()))?;
        let [scale, offset] = placed.rescale.unwrap_or([1.0, 0.0]);
        check_rescale(placed.format, scale, offset).map_err(fail)?;
        if scale < 0.0 {
            let fault = format!(
                "values are scaled by {scale}, expected a number above 0 where a volume is read in parts: values that fall \
                 as stored numbers rise are read whole"
            );
            return Err(fail(Problem::format(placed.format, fault)).into());
        }
        let turn = turn(&placed)?;
        let store = Store::open(&mut placed)?;
        let meaning = Meaning {
            value_type: placed.layout.value_type,
            scale,
            offset,
            modality: placed.modality,
            stated_window: placed.stated_window,
        };
        let counted = count(&placed.name, &store, &turn, &meaning, window, progress);
        let Counted {
            chosen,
            tally,
            statistics,
            coder,
            strips,
        } = match counted {
            Err(LoadError::Read(error)) if options.choice.nan == NanRule::Background => {
                return Err(background_needs_all(error).into());
            }
            counted => counted?,
        };
        let mut notes = std::mem::take(&mut placed.notes);
        let orientation = match placed.directions {
            None => Orientation::Unknown,
            Some(directions) => {
                notes.extend(turn.notes(directions.space()));
                Orientation::of(directions, &turn)
            }
        };
        notes.extend(chosen.note.clone());
        let on_disk = Self {
            name: placed.name,
            dims: turn.permuted(store.dims()),
            spacing: turn.permuted(placed.spacing),
            mapping: chosen.mapping,
            turn,
            store,
            coder,
            strips,
        };
        let loaded = Loaded {
            volume: on_disk.part(on_disk.dims, Vec::new()),
            report: chosen.report(&tally),
            notes,
            modality: placed.modality,
            orientation,
            integers: chosen.has_integers(),
            labels: chosen.labels,
            statistics,
        };
        Ok((loaded, on_disk))
    }

    /// Voxels along x, y and z.
    pub const fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// Whether the codes of a part are first read in another order, which takes as much memory again.
    pub fn is_turned(&self) -> bool {
        !self.turn.is_none()
    }

    /// Bytes that reading takes beside the codes: a slice of the file, or a chunk, for each thread, as bytes and as values.
    pub fn reading_bytes(&self, threads: usize) -> u64 {
        threads as u64 * self.store.reading_bytes()
    }

    /// Chunks that were read so far, those read again counted again, and how many the volume has; `None` of other files.
    pub fn chunks_read(&self) -> Option<[u64; 2]> {
        self.store.chunks_read()
    }

    /// The parts of the file that can be seen, where `meets` tells whether anything from a code to another is visible.
    pub fn wanted(&self, meets: impl Fn([u16; 2]) -> bool) -> Wanted {
        self.strips.wanted(meets)
    }

    /// A box of the volume: `dims` voxels from `first` on, along its own axes; and how many of them were read. What is not
    /// `wanted`, if anything is said of that, has one of its own codes everywhere, and is not read. Files are read in parallel,
    /// slice by slice of theirs or chunk by chunk.
    ///
    /// # Errors
    /// [`ReadError`] if a file cannot be read any more.
    pub fn read(
        &self,
        first: [usize; 3],
        dims: [usize; 3],
        wanted: Option<&Wanted>,
    ) -> Result<(Volume, u64), ReadError> {
        let region = Region { first, dims }.turned(&self.turn, self.store.dims());
        let [nx, ny, nz] = region.dims;
        let read = AtomicU64::new(0);
        let mut voxels = vec![0; nx * ny * nz];
        let parts = self.store.blocks().cut(region);
        let rows = rows_of(&parts, &mut voxels);
        let of_part = |(part, mut rows): (Region, Vec<&mut [u16]>)| {
            let mut rows = rows.iter_mut();
            for (strip, piece) in self.runs(part, wanted) {
                let count = piece.dims.iter().product::<usize>();
                let mut codes = vec![strip.map_or(0, |strip| self.strips.least(strip)); count];
                if strip.is_none() {
                    self.coder.code(&self.store.read(piece)?, &mut codes);
                    read.fetch_add(count as u64, Ordering::Relaxed);
                }
                // The codes first: what is zipped to them loses no row where they end.
                for (codes, row) in codes.chunks(piece.dims[0]).zip(&mut rows) {
                    row.copy_from_slice(codes);
                }
            }
            Ok::<(), ReadError>(())
        };
        parts.into_par_iter().zip(rows).try_for_each(of_part)?;
        let turned = self.turn.values(Values::U16(voxels), 1, region.dims);
        match turned.map_err(|problem| ReadError::new(self.store.path(), problem))? {
            Values::U16(voxels) => Ok((self.part(dims, voxels), read.into_inner())),
            _ => unreachable!("a turn keeps the type of values"),
        }
    }

    /// What a thread reads of a part of a block, in pieces of whole rows: strips side by side are read together, and with each
    /// that is left out its number comes.
    fn runs(&self, part: Region, wanted: Option<&Wanted>) -> Vec<(Option<usize>, Region)> {
        let cut = self.strips.cut();
        let mut runs: Vec<(Option<usize>, Region)> = Vec::new();
        for piece in cut.cut(part) {
            let strip = cut.number([0, 1, 2].map(|axis| piece.first[axis] / cut.side[axis]));
            let left_out = Some(strip).filter(|&strip| wanted.is_some_and(|wanted| !wanted.has(strip)));
            match runs.last_mut() {
                // Strips of a block follow one another along y.
                Some((None, run)) if left_out.is_none() => run.dims[1] += piece.dims[1],
                _ => runs.push((left_out, piece)),
            }
        }
        runs
    }

    fn part(&self, dims: [usize; 3], voxels: Vec<u16>) -> Volume {
        Volume {
            name: self.name.clone(),
            dims,
            spacing: self.spacing,
            voxels,
            mapping: self.mapping,
        }
    }
}

/// The rows of each part of a box, in the part's order, in the box's voxels. Parts are blocks' and come x first, then y, then z.
fn rows_of<'v>(parts: &[Region], mut voxels: &'v mut [u16]) -> Vec<Vec<&'v mut [u16]>> {
    let mut rows: Vec<Vec<&mut [u16]>> = parts.iter().map(|_| Vec::new()).collect();
    let mut layer = 0;
    while let Some(first) = parts.get(layer) {
        let within = |part: &&Region| part.first[2] == first.first[2];
        let of_layer = parts[layer..].iter().take_while(within).count();
        for _ in 0..first.dims[2] {
            let mut band = layer;
            while band < layer + of_layer {
                let start = parts[band].first[1];
                let of_band = parts[band..layer + of_layer]
                    .iter()
                    .take_while(|part| part.first[1] == start)
                    .count();
                for _ in 0..parts[band].dims[1] {
                    for number in band..band + of_band {
                        let (row, rest) = std::mem::take(&mut voxels).split_at_mut(parts[number].dims[0]);
                        rows[number].push(row);
                        voxels = rest;
                    }
                }
                band += of_band;
            }
        }
        layer += of_layer;
    }
    rows
}

impl Coder {
    /// A table of all values that a type of 8 or 16 bits has.
    fn table(meaning: &Meaning, code: &Code) -> Self {
        use super::values::ValueType::{I8, I16, U8};
        let mut table = Box::new([0; NARROW]);
        let mut unused = Tally::default();
        for (bits, entry) in (0..=u16::MAX).zip(table.iter_mut()) {
            let value = match meaning.value_type {
                I8 => f64::from(bits as i8),
                U8 => f64::from(bits as u8),
                I16 => f64::from(bits as i16),
                _ => f64::from(bits),
            };
            *entry = codes(code, &[value], &mut unused)[0];
        }
        Self::Table(table)
    }

    /// The codes of values.
    fn code(&self, values: &Values, out: &mut [u16]) {
        fn looked_up<T: Copy>(table: &[u16; NARROW], values: &[T], out: &mut [u16], bits: impl Fn(T) -> u16) {
            for (out, &value) in out.iter_mut().zip(values) {
                *out = table[usize::from(bits(value))];
            }
        }
        match (self, values) {
            (Self::Table(table), Values::I8(v)) => looked_up(table, v, out, |v| u16::from(v as u8)),
            (Self::Table(table), Values::U8(v)) => looked_up(table, v, out, u16::from),
            (Self::Table(table), Values::I16(v)) => looked_up(table, v, out, |v| v as u16),
            (Self::Table(table), Values::U16(v)) => looked_up(table, v, out, |v| v),
            (Self::Table(_), _) => unreachable!("a table is of narrow values"),
            (Self::Code(code), values) => out.copy_from_slice(&of_wide(code, values, &mut Tally::default())),
        }
    }
}

/// The codes of values of more than 16 bits.
fn of_wide(code: &Code, values: &Values, tally: &mut Tally) -> Vec<u16> {
    match values {
        Values::I8(v) => codes(code, v, tally),
        Values::U8(v) => codes(code, v, tally),
        Values::I16(v) => codes(code, v, tally),
        Values::U16(v) => codes(code, v, tally),
        Values::I32(v) => codes(code, v, tally),
        Values::U32(v) => codes(code, v, tally),
        Values::F32(v) => codes(code, v, tally),
        Values::F64(v) => codes(code, v, tally),
    }
}

/// What a census leads to.
struct Counted {
    chosen: Chosen,
    tally: Tally,
    statistics: Statistics,
    coder: Coder,
    strips: Strips,
}

/// Counts all values, chooses their codes and counts those.
fn count(
    name: &str,
    store: &Store,
    turn: &Turn,
    meaning: &Meaning,
    window: Window,
    progress: Progress<'_>,
) -> Result<Counted, LoadError> {
    let mapping = |error| LoadError::Mapping {
        name: name.to_owned(),
        error,
    };
    let axis = turn.source[0];
    let mut counts = vec![0; Statistics::CODES];
    let mut tally = Tally::default();
    if meaning.value_type.byte_len() <= 2
        && let Some(histogram) = Histogram::of(store, axis, -meaning.offset, progress)?
    {
        let chosen = choose(meaning, &histogram, window).map_err(mapping)?;
        for (value, voxels) in histogram.entries() {
            let code = match &chosen.code {
                Code::Linear(coding) => tally.code(coding, value, voxels),
                labels => codes(labels, &[value], &mut tally)[0],
            };
            counts[usize::from(code)] += voxels;
        }
        return Ok(Counted {
            strips: Strips::coded(strips::cut(store), histogram.strips, &chosen.code),
            tally,
            statistics: Statistics::from_counts(counts),
            coder: Coder::table(meaning, &chosen.code),
            chosen,
        });
    }
    let passes = Passes::new(store, axis, progress)?;
    let chosen = choose(meaning, &passes, window);
    let measured = passes.end()?;
    let chosen = chosen.map_err(mapping)?;
    let none = || (vec![0; Statistics::CODES], Tally::default());
    let take = |(mut counts, mut tally): (Vec<u64>, Tally), block: Block| {
        for code in of_wide(&chosen.code, &block.values, &mut tally) {
            counts[usize::from(code)] += 1;
        }
        Ok((counts, tally))
    };
    let join = |(mut counts, tally): (Vec<u64>, Tally), (others, other): (Vec<u64>, Tally)| {
        counts.iter_mut().zip(others).for_each(|(count, other)| *count += other);
        (counts, tally.with(other))
    };
    let (counts, tally) = each_block(store, None, progress, none, take, join)?;
    Ok(Counted {
        strips: Strips::coded(strips::cut(store), measured, &chosen.code),
        tally,
        statistics: Statistics::from_counts(counts),
        coder: Coder::Code(chosen.code.clone()),
        chosen,
    })
}
