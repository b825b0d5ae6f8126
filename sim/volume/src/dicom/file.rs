//! One DICOM file: the fields that a volume needs, and where its pixels are.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::Read;

use flate2::read::DeflateDecoder;

use super::NAME;
use super::element::{Elements, Encoding, PIXEL_DATA, Tag, Value, name, u16_of};
use crate::error::Problem;
use crate::text::{shorten, shorten_bytes};

/// Bytes that one file may have, packed or unpacked (512 MiB).
pub const MAX_FILE_LEN: u64 = 1 << 29;

/// The fields that are kept.
const KEPT: [Tag; 23] = [
    MODALITY,
    SERIES_UID,
    SERIES_NUMBER,
    DESCRIPTION,
    POSITION,
    DIRECTIONS,
    PIXEL_SPACING,
    THICKNESS,
    SAMPLES,
    PHOTOMETRIC,
    FRAMES,
    ROWS,
    COLUMNS,
    ALLOCATED,
    STORED,
    HIGH_BIT,
    SIGNED,
    INTERCEPT,
    SLOPE,
    CENTRE,
    WIDTH,
    ECHO,
    TILT,
];
const MODALITY: Tag = (0x0008, 0x0060);
const DESCRIPTION: Tag = (0x0008, 0x103e);
const THICKNESS: Tag = (0x0018, 0x0050);
const ECHO: Tag = (0x0018, 0x0086);
const TILT: Tag = (0x0018, 0x1120);
const SERIES_UID: Tag = (0x0020, 0x000e);
const SERIES_NUMBER: Tag = (0x0020, 0x0011);
const POSITION: Tag = (0x0020, 0x0032);
const DIRECTIONS: Tag = (0x0020, 0x0037);
const SAMPLES: Tag = (0x0028, 0x0002);
const PHOTOMETRIC: Tag = (0x0028, 0x0004);
const FRAMES: Tag = (0x0028, 0x0008);
const ROWS: Tag = (0x0028, 0x0010);
const COLUMNS: Tag = (0x0028, 0x0011);
const PIXEL_SPACING: Tag = (0x0028, 0x0030);
const ALLOCATED: Tag = (0x0028, 0x0100);
const STORED: Tag = (0x0028, 0x0101);
const HIGH_BIT: Tag = (0x0028, 0x0102);
const SIGNED: Tag = (0x0028, 0x0103);
const CENTRE: Tag = (0x0028, 0x1050);
const WIDTH: Tag = (0x0028, 0x1051);
const INTERCEPT: Tag = (0x0028, 0x1052);
const SLOPE: Tag = (0x0028, 0x1053);

/// How pixels are packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Packing {
    Plain,
    Rle,
}

/// The form of a stored pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PixelForm {
    /// Bytes a pixel: 1, 2 or 4.
    pub bytes: usize,
    /// Bits in use.
    pub stored: u32,
    /// Bits below them.
    pub shift: u32,
    pub signed: bool,
    pub big: bool,
}

/// One slice, without its pixels.
#[derive(Clone, Debug)]
pub(super) struct Slice {
    pub modality: String,
    pub series_uid: String,
    pub series_number: String,
    pub description: String,
    pub echo: String,
    /// Centre of the first pixel, mm, LPS.
    pub position: Option<[f64; 3]>,
    /// Unit vectors along a row and down a column.
    pub directions: Option<[[f64; 3]; 2]>,
    /// Distance between columns and between rows, mm.
    pub pixel_spacing: Option<[f64; 2]>,
    pub thickness: Option<f64>,
    pub columns: u32,
    pub rows: u32,
    pub form: PixelForm,
    pub packing: Packing,
    /// Slope and intercept.
    pub rescale: [f64; 2],
    pub window: Option<[f64; 2]>,
    /// Whether the smallest value is shown white.
    pub inverted: bool,
}

impl Slice {
    /// Reads the fields of a file and checks that its pixels can be read; `None` of a file that is no image, such as a
    /// DICOMDIR.
    pub fn parse(bytes: &[u8]) -> Result<Option<Self>, Problem> {
        let (data, encoding, packing) = data_set(bytes)?;
        let mut fields = Fields {
            values: HashMap::new(),
            big: encoding.big,
        };
        let mut elements = Elements::new(&data, encoding);
        let mut has_pixels = false;
        while let Some((tag, value)) = elements.next()? {
            if tag == PIXEL_DATA {
                has_pixels = true;
                break;
            }
            if let Value::Bytes(bytes) = value
                && KEPT.contains(&tag)
            {
                fields.values.insert(tag, bytes);
            }
        }
        match (has_pixels, fields.number(ROWS)) {
            (true, _) => fields.slice(packing).map(Some),
            (false, None) => Ok(None),
            (false, Some(_)) => Err(Problem::format(
                NAME,
                "has no pixel data (7FE0,0010), expected an image",
            )),
        }
    }

    /// The bytes of a file's pixels, still packed if its syntax packs them.
    pub fn pixels(bytes: &[u8]) -> Result<Vec<u8>, Problem> {
        let (data, encoding, _) = data_set(bytes)?;
        let mut elements = Elements::new(&data, encoding);
        while let Some((tag, value)) = elements.next()? {
            if let (PIXEL_DATA, Value::Bytes(pixels) | Value::Open(pixels)) = (tag, value) {
                return Ok(pixels.to_vec());
            }
        }
        Err(Problem::format(
            NAME,
            "has no pixel data (7FE0,0010), expected an image",
        ))
    }

    /// What slices of one series have in common.
    pub fn series_key(&self) -> SeriesKey<'_> {
        SeriesKey {
            texts: [&self.series_uid, &self.series_number, &self.echo],
            size: [self.columns, self.rows],
            // Directions agree to a thousandth.
            directions: self
                .directions
                .map(|two| two.map(|v| v.map(|c| (c * 1000.0).round() as i64))),
        }
    }
}

/// What slices of one series have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SeriesKey<'a> {
    texts: [&'a str; 3],
    size: [u32; 2],
    directions: Option<[[i64; 3]; 2]>,
}

/// The data set after the file's meta information, unpacked if it is deflated.
fn data_set(bytes: &[u8]) -> Result<(Cow<'_, [u8]>, Encoding, Packing), Problem> {
    let meta = match bytes.get(128..132) {
        Some(b"DICM") => &bytes[132..],
        _ => return Err(Problem::format(NAME, "has no `DICM` after a preamble of 128 bytes")),
    };
    let mut elements = Elements::new(meta, Encoding::EXPLICIT);
    let mut syntax = None;
    while elements.peek().is_some_and(|(group, _)| group == 2) {
        if let Some(((0x0002, 0x0010), Value::Bytes(uid))) = elements.next()? {
            syntax = Some(text(uid));
        }
    }
    let rest = meta.get(elements.position()..).unwrap_or(&[]);
    let syntax = syntax.ok_or_else(|| Problem::format(NAME, "states no transfer syntax (0002,0010)"))?;
    let form = |explicit, big| Encoding { explicit, big };
    match syntax.as_str() {
        "1.2.840.10008.1.2" => Ok((rest.into(), form(false, false), Packing::Plain)),
        "1.2.840.10008.1.2.1" => Ok((rest.into(), form(true, false), Packing::Plain)),
        "1.2.840.10008.1.2.2" => Ok((rest.into(), form(true, true), Packing::Plain)),
        "1.2.840.10008.1.2.5" => Ok((rest.into(), form(true, false), Packing::Rle)),
        "1.2.840.10008.1.2.1.99" => Ok((inflate(rest)?.into(), form(true, false), Packing::Plain)),
        other => Err(Problem::Unsupported {
            format: NAME,
            found: format!("transfer syntax {} ({})", shorten(other), syntax_name(other)),
            expected: "uncompressed, deflated or RLE (dcmdjpeg and gdcmconv --raw convert the others)",
        }),
    }
}

/// What the common packed syntaxes are called.
fn syntax_name(uid: &str) -> &'static str {
    match uid {
        "1.2.840.10008.1.2.4.50" | "1.2.840.10008.1.2.4.51" => "JPEG, with loss",
        "1.2.840.10008.1.2.4.57" | "1.2.840.10008.1.2.4.70" => "JPEG lossless",
        "1.2.840.10008.1.2.4.80" | "1.2.840.10008.1.2.4.81" => "JPEG-LS",
        "1.2.840.10008.1.2.4.90" | "1.2.840.10008.1.2.4.91" => "JPEG 2000",
        uid if uid.starts_with("1.2.840.10008.1.2.4.") => "JPEG or video",
        _ => "unknown",
    }
}

/// Unpacks a deflated data set, up to the limit of a file.
fn inflate(packed: &[u8]) -> Result<Vec<u8>, Problem> {
    let mut out = Vec::new();
    let read = DeflateDecoder::new(packed).take(MAX_FILE_LEN + 1).read_to_end(&mut out);
    read.map_err(|error| Problem::format(NAME, format!("deflated data are damaged: {error}")))?;
    if out.len() as u64 > MAX_FILE_LEN {
        return Err(Problem::TooLarge {
            bytes: out.len() as u64,
            what: "one file, unpacked",
            limit: MAX_FILE_LEN,
        });
    }
    Ok(out)
}

/// A value as text, without padding.
fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes)
        .trim_matches([' ', '\0', '\n', '\r', '\t'])
        .to_owned()
}

/// The kept fields of a file.
struct Fields<'a> {
    values: HashMap<Tag, &'a [u8]>,
    big: bool,
}

impl Fields<'_> {
    fn slice(&self, packing: Packing) -> Result<Slice, Problem> {
        self.check_kind()?;
        let [slope, intercept] = [self.one(SLOPE)?.unwrap_or(1.0), self.one(INTERCEPT)?.unwrap_or(0.0)];
        let window = match (self.first(CENTRE)?, self.first(WIDTH)?) {
            (Some(centre), Some(width)) => Some([centre - width / 2.0, centre + width / 2.0]),
            _ => None,
        };
        let directions = self
            .numbers::<6>(DIRECTIONS)?
            .map(|[a, b, c, d, e, f]| [[a, b, c], [d, e, f]]);
        Ok(Slice {
            modality: self.text(MODALITY),
            series_uid: self.text(SERIES_UID),
            series_number: self.text(SERIES_NUMBER),
            description: self.text(DESCRIPTION),
            echo: self.text(ECHO),
            position: self.numbers(POSITION)?,
            directions,
            // The file gives the distance between rows first.
            pixel_spacing: self
                .numbers::<2>(PIXEL_SPACING)?
                .map(|[between_rows, between_columns]| [between_columns, between_rows]),
            thickness: self.one(THICKNESS)?,
            columns: u32::from(self.need(COLUMNS)?),
            rows: u32::from(self.need(ROWS)?),
            form: self.form()?,
            packing,
            rescale: [slope, intercept],
            window,
            inverted: self.text(PHOTOMETRIC) == "MONOCHROME1",
        })
    }

    /// Refuses colour and multi-frame files.
    fn check_kind(&self) -> Result<(), Problem> {
        let refuse = |found, expected| {
            Err(Problem::Unsupported {
                format: NAME,
                found,
                expected,
            })
        };
        let samples = self.number(SAMPLES).unwrap_or(1);
        if samples != 1 {
            return refuse(format!("{samples} samples a pixel"), "one");
        }
        let photometric = self.text(PHOTOMETRIC);
        if !["", "MONOCHROME1", "MONOCHROME2"].contains(&photometric.as_str()) {
            return refuse(
                format!("photometric interpretation {}", shorten(&photometric)),
                "MONOCHROME2 or MONOCHROME1",
            );
        }
        let frames = self.text(FRAMES);
        if !["", "1"].contains(&frames.as_str()) {
            return refuse(format!("a file of {} frames", shorten(&frames)), "one slice a file");
        }
        Ok(())
    }

    fn form(&self) -> Result<PixelForm, Problem> {
        let allocated = self.need(ALLOCATED)?;
        let stored = self.number(STORED).unwrap_or(allocated);
        let high = self.number(HIGH_BIT).unwrap_or(stored.wrapping_sub(1));
        let sound = [8, 16, 32].contains(&allocated) && (1..=allocated).contains(&stored);
        if !sound || high >= allocated || high + 1 < stored {
            let fault = format!(
                "bits allocated {allocated}, stored {stored}, high bit {high}, expected 8, 16 or 32 bits that hold those stored"
            );
            return Err(Problem::format(NAME, fault));
        }
        Ok(PixelForm {
            bytes: usize::from(allocated / 8),
            stored: u32::from(stored),
            shift: u32::from(high + 1 - stored),
            signed: self.number(SIGNED).unwrap_or(0) == 1,
            big: self.big,
        })
    }

    /// A field of two bytes that has to be there.
    fn need(&self, tag: Tag) -> Result<u16, Problem> {
        let missing = || Problem::format(NAME, format!("has no element {}, expected a number", name(tag)));
        self.number(tag).ok_or_else(missing)
    }

    fn number(&self, tag: Tag) -> Option<u16> {
        let bytes = self.values.get(&tag)?;
        (bytes.len() == 2).then(|| u16_of(bytes, self.big))
    }

    fn text(&self, tag: Tag) -> String {
        let bytes = self.values.get(&tag).copied().unwrap_or(&[]);
        text(bytes.get(..256).unwrap_or(bytes))
    }

    /// Exactly `N` decimal numbers, or none if the field is absent or empty.
    fn numbers<const N: usize>(&self, tag: Tag) -> Result<Option<[f64; N]>, Problem> {
        let text = self.text(tag);
        if text.is_empty() {
            return Ok(None);
        }
        let words: Vec<Option<f64>> = text.split('\\').map(|word| word.trim().parse().ok()).collect();
        let numbers = words
            .into_iter()
            .collect::<Option<Vec<f64>>>()
            .and_then(|v| <[f64; N]>::try_from(v).ok());
        match numbers.filter(|all| all.iter().all(|c| c.is_finite())) {
            Some(numbers) => Ok(Some(numbers)),
            None => {
                let found = shorten_bytes(text.as_bytes());
                let fault = format!("element {} is `{found}`, expected {N} finite numbers", name(tag));
                Err(Problem::format(NAME, fault))
            }
        }
    }

    fn one(&self, tag: Tag) -> Result<Option<f64>, Problem> {
        Ok(self.numbers::<1>(tag)?.map(|[number]| number))
    }

    /// The first of several numbers; a window that is no number is left out.
    fn first(&self, tag: Tag) -> Result<Option<f64>, Problem> {
        let text = self.text(tag);
        Ok(text.split('\\').next().and_then(|word| word.trim().parse().ok()))
    }
}
