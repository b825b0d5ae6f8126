//! Pages of one file or of many, joined to a volume.

use std::collections::HashMap;
use std::io::{BufReader, Seek as _, SeekFrom};
use std::panic::{AssertUnwindSafe, catch_unwind};

use tiff::decoder::{DecodingResult, Limits};
use tiff::tags::{ByteOrder, CompressionMethod, PhotometricInterpretation, Tag};

use super::NAME;
use super::damage::damaged;
use super::description;
use super::patched::{Decoder, Patched, Source};
use super::pixels::{Pixel, Wanted};
use super::told::Description;
use crate::choice::Choice;
use crate::colours::Colours;
use crate::decoded::Decoded;
use crate::error::Problem;
use crate::limits::MAX_BYTES;
use crate::payload::{ByteSkip, Encoding, Layout, Tail, read_values};
use crate::values::{Endian, Values, voxel_count};

/// More than any of the read packings unpacks a byte to.
const EXPANSION_MAX: u64 = 3000;

/// Pages read so far.
pub(super) struct Stack {
    choice: Choice,
    wanted: Wanted,
    /// Values of a pixel, of the first page.
    components: Option<u64>,
    size: Option<[u32; 2]>,
    count: u64,
    values: Option<Values>,
    /// Of the first file.
    description: Option<Description>,
    white_is_zero: bool,
    notes: Vec<String>,
}

impl Stack {
    /// No page yet.
    pub fn new(choice: Choice, wanted: Wanted) -> Self {
        Self {
            choice,
            wanted,
            components: None,
            size: None,
            count: 0,
            values: None,
            description: None,
            white_is_zero: false,
            notes: Vec::new(),
        }
    }

    /// Adds something that the user should know.
    pub fn note(&mut self, note: String) {
        self.notes.push(note);
    }

    /// Adds the slices of a file of `len` bytes. A panic of the library, of which none is known, becomes an error.
    pub fn add_file(&mut self, source: &mut dyn Source, len: u64) -> Result<(), Problem> {
        let read = catch_unwind(AssertUnwindSafe(|| self.add_slices(source, len)));
        read.unwrap_or_else(|_| {
            Err(Problem::format(
                NAME,
                "is damaged in a way that its library does not expect",
            ))
        })
    }

    fn add_slices(&mut self, source: &mut dyn Source, len: u64) -> Result<(), Problem> {
        source.seek(SeekFrom::Start(0)).map_err(Problem::io("read the file"))?;
        let mut limits = Limits::default();
        let page_max = len.saturating_mul(EXPANSION_MAX).min(MAX_BYTES);
        limits.decoding_buffer_size = usize::try_from(page_max).unwrap_or(usize::MAX);
        limits.intermediate_buffer_size = limits.decoding_buffer_size.min(1 << 28);
        limits.ifd_value_size = 1 << 22;
        let mut decoder = Decoder::new(Patched::new(source)).map_err(damaged)?.with_limits(limits);
        Pixel::of(&mut decoder, self.wanted)?;
        let (width, height) = decoder.dimensions().map_err(damaged)?;
        let mut description = description::read(&mut decoder, [width, height])?;
        let mut pages = 1;
        while decoder.more_images() {
            decoder.next_image().map_err(damaged)?;
            pages += 1;
        }
        let mut notes = std::mem::take(&mut description.notes);
        let planes = description.planes.take();
        let wanted = match &planes {
            None => (0..pages).collect(),
            Some(planes) => planes.slices(&self.choice, &mut notes)?,
        };
        if planes.is_none() {
            self.choice.check_single()?;
        }
        let stated = planes.as_ref().map(|planes| (planes.total(), planes.pages.is_some()));
        if self.description.is_none() {
            self.description = Some(description);
            self.notes.append(&mut notes);
        }
        match stated {
            Some((images, false)) if images > 1 && pages == 1 => {
                self.add_contiguous(&mut decoder, len, images, &wanted)?;
                self.note(format!("{images} images behind one directory"));
                return Ok(());
            }
            Some((images, false)) if images != pages => {
                let fault = format!("the description states {images} images, the file has {pages} pages");
                return Err(Problem::format(NAME, format!("{fault}, expected as many")));
            }
            _ => {}
        }
        for index in wanted {
            if index >= pages {
                let fault = format!("the description names page {}, the file has {pages}", index + 1);
                return Err(Problem::format(NAME, fault));
            }
            decoder.seek_to_image(index).map_err(damaged)?;
            self.set_black_is_zero(&mut decoder, index)?;
            self.add_page(&mut decoder, page_max)?;
        }
        Ok(())
    }

    /// Has a page's values arrive as they are stored, even where white is 0.
    fn set_black_is_zero(&mut self, decoder: &mut Decoder<'_>, index: usize) -> Result<(), Problem> {
        let white = PhotometricInterpretation::WhiteIsZero.to_u16();
        if decoder
            .find_tag_unsigned::<u16>(Tag::PhotometricInterpretation)
            .map_err(damaged)?
            != Some(white)
        {
            return Ok(());
        }
        self.white_is_zero = true;
        let directory = decoder.ifd_pointer().map_or(0, |pointer| pointer.0);
        let found = decoder.inner().set_black_is_zero(directory);
        if found.map_err(Problem::io("read the file"))? {
            decoder.seek_to_image(index).map_err(damaged)?;
        }
        Ok(())
    }

    /// Adds the current page.
    fn add_page(&mut self, decoder: &mut Decoder<'_>, file_max: u64) -> Result<(), Problem> {
        let pixel = Pixel::of(decoder, self.wanted)?;
        let [width, height] = self.take_size(decoder, 1)?;
        self.take_components(pixel)?;
        let voxels = voxel_count([width.into(), height.into(), self.count])?;
        let bytes = voxels * pixel.components * pixel.bits / 8;
        // A folder's files add up, so that a single one's expansion is no bound below this.
        let limit = file_max.clamp(MAX_BYTES / 64, MAX_BYTES);
        if bytes > limit {
            let what = "the pages so far";
            return Err(Problem::TooLarge { bytes, what, limit });
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
        let values = u64::from(width) * u64::from(height) * pixel.components;
        if page.len() as u64 != values {
            let fault = format!("page {} has {} values, expected {values}", self.count, page.len());
            return Err(Problem::format(NAME, fault));
        }
        self.append(page)
    }

    /// Adds the wanted ones of the `images` that follow one another behind the only directory, as ImageJ writes them
    /// above 4 GB.
    fn add_contiguous(
        &mut self,
        decoder: &mut Decoder<'_>,
        file_len: u64,
        images: usize,
        wanted: &[usize],
    ) -> Result<(), Problem> {
        let fault =
            |why: String| Problem::format(NAME, format!("{images} images are stated and 1 page is found, {why}"));
        let plain = [None, Some(CompressionMethod::None.to_u16())];
        if !plain.contains(&decoder.find_tag_unsigned(Tag::Compression).map_err(damaged)?) {
            return Err(fault("which is packed: the others cannot be found".into()));
        }
        self.white_is_zero |= decoder
            .find_tag_unsigned::<u16>(Tag::PhotometricInterpretation)
            .map_err(damaged)?
            == Some(0);
        let pixel = Pixel::of(decoder, self.wanted)?;
        let value_type = pixel.value_type(decoder)?;
        let offsets = decoder
            .find_tag_unsigned_vec::<u64>(Tag::StripOffsets)
            .map_err(damaged)?;
        let start = offsets.and_then(|offsets| offsets.first().copied());
        let start = start.ok_or_else(|| fault("without strips".into()))?;
        let endian = match decoder.byte_order() {
            ByteOrder::LittleEndian => Endian::Little,
            ByteOrder::BigEndian => Endian::Big,
        };
        let [width, height] = self.take_size(decoder, wanted.len() as u64)?;
        self.take_components(pixel)?;
        voxel_count([width.into(), height.into(), self.count])?;
        let image_len = u64::from(width) * u64::from(height) * pixel.components * value_type.byte_len();
        let needed = image_len.saturating_mul(images as u64);
        let found = file_len.saturating_sub(start);
        if needed > found {
            return Err(fault(format!(
                "behind which {found} bytes follow, expected {needed} for {images} of {width} x {height} {}",
                value_type.name()
            )));
        }
        let layout = Layout {
            dims: [width.into(), height.into(), 1],
            components: pixel.components,
            value_type,
            endian,
            encoding: Encoding::Raw,
            line_skip: 0,
            byte_skip: ByteSkip::Bytes(0),
            tail: Tail::LeftOut,
        };
        for &index in wanted {
            let at = start + index as u64 * image_len;
            let source = decoder.inner();
            source.seek(SeekFrom::Start(at)).map_err(Problem::io("read the file"))?;
            // What follows an image is the next one.
            let page = read_values(&layout, &mut BufReader::new(source), file_len - at, &mut Vec::new())?;
            self.append(page)?;
        }
        Ok(())
    }

    /// Counts `more` pages of the decoder's size, which has to be that of the pages before.
    fn take_size(&mut self, decoder: &mut Decoder<'_>, more: u64) -> Result<[u32; 2], Problem> {
        let (width, height) = decoder.dimensions().map_err(damaged)?;
        self.count += more;
        let size = *self.size.get_or_insert([width, height]);
        if size != [width, height] {
            let fault = format!(
                "page {} is {width} x {height}, expected {} x {}",
                self.count, size[0], size[1]
            );
            return Err(Problem::format(NAME, fault));
        }
        Ok(size)
    }

    /// Holds a page to as many values a pixel as the pages before.
    fn take_components(&mut self, pixel: Pixel) -> Result<(), Problem> {
        let expected = *self.components.get_or_insert(pixel.components);
        if expected == pixel.components {
            return Ok(());
        }
        let (page, found) = (self.count, pixel.components);
        let fault = format!("page {page} has {found} colours a pixel, expected {expected}");
        Err(Problem::format(NAME, fault))
    }

    fn append(&mut self, page: Values) -> Result<(), Problem> {
        let Some(values) = &mut self.values else {
            self.values = Some(page);
            return Ok(());
        };
        if values.append(&page)? {
            return Ok(());
        }
        let (found, expected, number) = (page.value_type().name(), values.value_type().name(), self.count);
        Err(Problem::format(
            NAME,
            format!("page {number} is of type {found}, expected {expected}"),
        ))
    }

    /// The volume of colours.
    pub fn finish_colours(mut self, name: String) -> Result<Colours, Problem> {
        let (Some([width, height]), Some(values)) = (self.size, self.values.take()) else {
            return Err(Problem::format(NAME, "has no page, expected slices"));
        };
        let (spacing, mut notes) = self.description.unwrap_or_default().spacing();
        self.notes.append(&mut notes);
        let dims = [width as usize, height as usize, self.count as usize];
        let colours = Colours::new(name, dims, spacing, self.components.unwrap_or(3) as usize, values)?;
        Ok(colours.with(HashMap::new(), self.notes))
    }

    /// The volume.
    pub fn finish(mut self, name: String) -> Result<Decoded, Problem> {
        let (Some([width, height]), Some(mut values)) = (self.size, self.values.take()) else {
            return Err(Problem::format(NAME, "has no page, expected slices"));
        };
        if self.white_is_zero {
            self.notes.push(
                match values.invert() {
                    true => "white is 0 in the file: values are inverted, so that more is brighter",
                    false => "white is 0 in the file: values with a sign or a fraction are taken as stored",
                }
                .into(),
            );
        }
        let description = self.description.unwrap_or_default();
        let (spacing, mut notes) = description.spacing();
        self.notes.append(&mut notes);
        let dims = [width as usize, height as usize, self.count as usize];
        let [scale, offset] = description.calibration.unwrap_or([1.0, 0.0]);
        let decoded = Decoded::with_nan(name, dims, spacing, values, (self.choice.nan, scale))?.with_notes(self.notes);
        match description.calibration {
            Some(_) => decoded.with_rescale(NAME, scale, offset),
            None => Ok(decoded),
        }
    }
}
