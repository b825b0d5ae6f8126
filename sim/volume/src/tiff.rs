//! TIFF stacks: the pages of one file, or a folder of one-page files in the order of the numbers in their names.
//!
//! Read by the `tiff` crate under limits: grey pages of one size and type (8 to 32 bits, signed or not, single or double
//! precision), plain, LZW, deflate or packbits. TIFF has no field for the distance between slices: ImageJ's `spacing=` in
//! the description counts; the distance between pixels comes from the resolution where its unit is known.

use std::fs;
use std::io::{BufRead, Cursor, Read, Seek, SeekFrom};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

use super::error::{Problem, ReadError};
use super::open::open_regular;
use super::text::shorten;
use super::values::{Decoded, MAX_AXIS, MAX_BYTES, Values, voxel_count};

/// The format's name in messages.
const NAME: &str = "TIFF";

/// More than any of the read packings unpacks a byte to.
const EXPANSION_MAX: u64 = 3000;

/// Reads the pages of a TIFF file as slices.
///
/// # Errors
/// [`ReadError`] names the file, what was wrong and what was expected; see [`Problem`].
pub fn read(path: &Path) -> Result<Decoded, ReadError> {
    let fail = |problem| ReadError::new(path, problem);
    let (source, len) = open_regular(path)?;
    read_source(source, len, path.display().to_string()).map_err(fail)
}

/// Reads a TIFF file that is already in memory; `name` stands for its path in messages.
///
/// # Errors
/// As [`read`].
pub fn read_bytes(bytes: &[u8], name: &str) -> Result<Decoded, ReadError> {
    let read = read_source(Cursor::new(bytes), bytes.len() as u64, name.to_owned());
    read.map_err(|problem| ReadError::new(Path::new(name), problem))
}

/// Reads a folder of TIFF files, each one slice or more.
///
/// # Errors
/// As [`read`]; [`Problem::Format`] if there is no TIFF file in it.
pub fn read_folder(folder: &Path) -> Result<Decoded, ReadError> {
    let fail = |problem| ReadError::new(folder, problem);
    let entries = fs::read_dir(folder)
        .map_err(Problem::io("read the folder"))
        .map_err(fail)?;
    let paths = entries.flatten().take(2 * MAX_AXIS).map(|entry| entry.path());
    let mut paths: Vec<PathBuf> = paths.filter(|path| path.is_file() && has_name(path)).collect();
    paths.sort_by_cached_key(|path| natural_key(path));
    let mut pages = Pages::default();
    for path in &paths {
        let (source, len) = open_regular(path)?;
        pages
            .add_file(source, len)
            .map_err(|problem| ReadError::new(path, problem))?;
    }
    pages.notes.push(format!(
        "{} files in the order of the numbers in their names: a TIFF states no position",
        paths.len()
    ));
    pages.finish(folder.display().to_string()).map_err(fail)
}

/// Whether a file that begins so is a TIFF.
pub(super) fn recognise(start: &[u8]) -> bool {
    [&b"II*\0"[..], b"MM\0*", b"II+\0", b"MM\0+"]
        .iter()
        .any(|magic| start.starts_with(magic))
}

/// Whether a file is called a TIFF.
pub(super) fn has_name(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    extension == "tif" || extension == "tiff"
}

/// A name with its numbers as numbers, so that `s10` follows `s9`.
fn natural_key(path: &Path) -> Vec<(u8, u128, String)> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut parts: Vec<(u8, u128, String)> = Vec::new();
    for c in name.chars() {
        match (c.to_digit(10), parts.last_mut()) {
            (Some(digit), Some((0, number, _))) => *number = number.saturating_mul(10).saturating_add(digit.into()),
            (Some(digit), _) => parts.push((0, digit.into(), String::new())),
            (None, Some((1, _, text))) => text.push(c),
            (None, _) => parts.push((1, 0, c.to_string())),
        }
    }
    parts
}

fn read_source<R: Read + Seek + BufRead>(source: R, len: u64, name: String) -> Result<Decoded, Problem> {
    let mut pages = Pages::default();
    pages.add_file(source, len)?;
    pages.finish(name)
}

/// Pages read so far.
#[derive(Default)]
struct Pages {
    size: Option<[u32; 2]>,
    count: u64,
    values: Option<Values>,
    spacing: [Option<f64>; 3],
    notes: Vec<String>,
}

impl Pages {
    /// Adds all pages of a file of `len` bytes. A panic of the library, of which none is known, becomes an error.
    fn add_file<R: Read + Seek>(&mut self, source: R, len: u64) -> Result<(), Problem> {
        let read = catch_unwind(AssertUnwindSafe(|| self.add_pages(source, len)));
        read.unwrap_or_else(|_| {
            Err(Problem::format(
                NAME,
                "is damaged in a way that its library does not expect",
            ))
        })
    }

    fn add_pages<R: Read + Seek>(&mut self, mut source: R, len: u64) -> Result<(), Problem> {
        source.seek(SeekFrom::Start(0)).map_err(Problem::io("read the file"))?;
        let mut limits = Limits::default();
        let page_max = len.saturating_mul(EXPANSION_MAX).min(MAX_BYTES);
        limits.decoding_buffer_size = usize::try_from(page_max).unwrap_or(usize::MAX);
        limits.intermediate_buffer_size = limits.decoding_buffer_size.min(1 << 28);
        limits.ifd_value_size = 1 << 22;
        let mut decoder = Decoder::new(source).map_err(damaged)?.with_limits(limits);
        loop {
            self.add_page(&mut decoder, page_max)?;
            if !decoder.more_images() {
                return Ok(());
            }
            decoder.next_image().map_err(damaged)?;
        }
    }

    fn add_page<R: Read + Seek>(&mut self, decoder: &mut Decoder<R>, file_max: u64) -> Result<(), Problem> {
        let (width, height) = decoder.dimensions().map_err(damaged)?;
        let bits = match decoder.colortype().map_err(damaged)? {
            ColorType::Gray(bits @ (8 | 16 | 32 | 64)) => u64::from(bits),
            other => {
                return Err(Problem::Unsupported {
                    format: NAME,
                    found: format!("a page of colour type {other:?}"),
                    expected: "grey of 8, 16 or 32 bits",
                });
            }
        };
        self.count += 1;
        let voxels = voxel_count([width.into(), height.into(), self.count])?;
        let bytes = voxels * bits / 8;
        // A folder's files add up, so that a single one's expansion is no bound below this.
        let limit = file_max.clamp(MAX_BYTES / 64, MAX_BYTES);
        if bytes > limit {
            let what = "the pages so far";
            return Err(Problem::TooLarge { bytes, what, limit });
        }
        let size = *self.size.get_or_insert([width, height]);
        if size != [width, height] {
            let fault = format!(
                "page {} is {width} x {height}, expected {} x {}",
                self.count, size[0], size[1]
            );
            return Err(Problem::format(NAME, fault));
        }
        if self.count == 1 {
            self.read_spacing(decoder);
        }
        let page = match decoder.read_image().map_err(damaged)? {
            DecodingResult::U8(v) => Values::U8(v),
            DecodingResult::I8(v) => Values::I8(v),
            DecodingResult::U16(v) => Values::U16(v),
            DecodingResult::I16(v) => Values::I16(v),
            DecodingResult::U32(v) => Values::U32(v),
            DecodingResult::I32(v) => Values::I32(v),
            DecodingResult::F32(v) => Values::F32(v),
            DecodingResult::F64(v) => Values::F64(v),
            _ => {
                return Err(Problem::Unsupported {
                    format: NAME,
                    found: "a page of 64-bit integers or half precision".into(),
                    expected: "integers of 8 to 32 bits, float or double",
                });
            }
        };
        let pixels = u64::from(width) * u64::from(height);
        if page.len() as u64 != pixels {
            let fault = format!("page {} has {} values, expected {pixels}", self.count, page.len());
            return Err(Problem::format(NAME, fault));
        }
        match &mut self.values {
            None => self.values = Some(page),
            Some(values) => append(values, page, self.count)?,
        }
        Ok(())
    }

    /// Spacing from the first page: pixels from its resolution, slices from ImageJ's description.
    fn read_spacing<R: Read + Seek>(&mut self, decoder: &mut Decoder<R>) {
        let text = decoder.get_tag_ascii_string(Tag::ImageDescription).unwrap_or_default();
        let field = |key: &str| {
            let line = text.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix('='));
            line.map(|value| value.trim().to_owned())
        };
        let unit_tag = decoder
            .find_tag(Tag::ResolutionUnit)
            .ok()
            .flatten()
            .and_then(|v| v.into_u32().ok());
        let unit = match (field("unit").as_deref(), unit_tag) {
            (Some("mm"), _) => Some(1.0),
            (Some("cm"), _) => Some(10.0),
            (Some("um" | "micron" | "µm" | "\\u00B5m"), _) => Some(0.001),
            (Some(_), _) => None,
            (None, Some(3)) => Some(10.0),
            _ => None,
        };
        let mut resolution = |tag| {
            let [n, d] = decoder.get_tag_u32_vec(tag).ok()?.try_into().ok()?;
            (n > 0 && d > 0).then(|| f64::from(d) / f64::from(n))
        };
        if let Some(unit) = unit {
            self.spacing = [
                resolution(Tag::XResolution).map(|pixel| pixel * unit),
                resolution(Tag::YResolution).map(|pixel| pixel * unit),
                field("spacing")
                    .and_then(|text| text.parse::<f64>().ok())
                    .map(|step| step.abs() * unit),
            ];
        } else if let Some(unit) = field("unit") {
            self.notes
                .push(format!("the file's unit of length `{}` is not known", shorten(&unit)));
        }
    }

    fn finish(mut self, name: String) -> Result<Decoded, Problem> {
        let (Some([width, height]), Some(values)) = (self.size, self.values.take()) else {
            return Err(Problem::format(NAME, "has no page, expected slices"));
        };
        let spacing = match self.spacing {
            [Some(x), Some(y), Some(z)] => [x, y, z],
            [Some(x), Some(y), None] => {
                self.notes
                    .push("the file states no distance between slices: that of pixels is assumed".into());
                [x, y, x]
            }
            _ => {
                self.notes.push("the file states no spacing: 1 is assumed".into());
                [1.0; 3]
            }
        };
        let dims = [width as usize, height as usize, self.count as usize];
        Ok(Decoded::new(name, dims, spacing, values)?.with_notes(self.notes))
    }
}

/// Adds a page of the same type.
fn append(values: &mut Values, page: Values, number: u64) -> Result<(), Problem> {
    fn extend<T: Copy>(values: &mut Vec<T>, page: &[T]) -> Result<(), Problem> {
        values.try_reserve(page.len()).map_err(|_| Problem::Memory {
            bytes: ((values.len() + page.len()) * size_of::<T>()) as u64,
        })?;
        values.extend_from_slice(page);
        Ok(())
    }
    match (values, page) {
        (Values::U8(v), Values::U8(p)) => extend(v, &p),
        (Values::I8(v), Values::I8(p)) => extend(v, &p),
        (Values::U16(v), Values::U16(p)) => extend(v, &p),
        (Values::I16(v), Values::I16(p)) => extend(v, &p),
        (Values::U32(v), Values::U32(p)) => extend(v, &p),
        (Values::I32(v), Values::I32(p)) => extend(v, &p),
        (Values::F32(v), Values::F32(p)) => extend(v, &p),
        (Values::F64(v), Values::F64(p)) => extend(v, &p),
        (values, page) => {
            let (found, expected) = (page.value_type().name(), values.value_type().name());
            Err(Problem::format(
                NAME,
                format!("page {number} is of type {found}, expected {expected}"),
            ))
        }
    }
}

/// The library's message as a fault.
fn damaged(error: tiff::TiffError) -> Problem {
    Problem::format(NAME, shorten_line(&error.to_string()))
}

/// One line.
fn shorten_line(text: &str) -> String {
    text.lines().next().unwrap_or_default().chars().take(200).collect()
}

#[cfg(test)]
mod tests;
