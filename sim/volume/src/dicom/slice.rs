//! What a file holds: slices, each without its pixels, or the reason why it is passed over.

use super::NAME;
use super::element::{Elements, Tag};
use super::fields::{self as tags, Fields};
use super::file::{File, Packing};
use crate::error::Problem;
use crate::text::shorten;

/// How directions of one stack may differ: the largest distance of two unit vectors (0.1 degrees).
const SAME_DIRECTION: f64 = 1.75e-3;

/// The form of a stored pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PixelForm {
    /// Bytes per pixel: 1, 2 or 4.
    pub bytes: usize,
    /// Bits in use.
    pub stored: u32,
    /// Bits below them.
    pub shift: u32,
    pub signed: bool,
    pub big: bool,
}

/// The fields that tell the phases of a series apart, in the order in which they are tried; the flag marks binary ones.
pub(super) const PHASE_FIELDS: [(&str, Tag, bool); 10] = [
    ("temporal position", tags::TEMPORAL_POSITION, false),
    ("temporal position index", tags::TEMPORAL_INDEX, true),
    ("acquisition number", tags::ACQUISITION, false),
    ("trigger time", tags::TRIGGER_TIME, false),
    ("trigger delay", tags::TRIGGER_DELAY, true),
    ("echo time", tags::ECHO_TIME, false),
    ("effective echo time", tags::EFFECTIVE_ECHO_TIME, true),
    ("diffusion b-value", tags::DIFFUSION, true),
    ("image type", tags::IMAGE_TYPE, false),
    ("acquisition time", tags::ACQUISITION_TIME, false),
];

/// One slice, without its pixels.
#[derive(Clone, Debug)]
pub(super) struct Slice {
    /// Which frame of its file, from 0.
    pub frame: usize,
    /// Frames of its file.
    pub frames: usize,
    pub object_uid: String,
    pub modality: String,
    pub series_uid: String,
    pub series_number: String,
    pub description: String,
    pub echo: String,
    /// The stack of a file that holds several.
    pub stack: String,
    pub instance: Option<f64>,
    /// The values of [`PHASE_FIELDS`].
    pub phase: [String; PHASE_FIELDS.len()],
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
    /// Slope and intercept.
    pub rescale: [f64; 2],
    pub window: Option<[f64; 2]>,
    /// Whether the smallest value is shown white.
    pub inverted: bool,
}

/// What a file is.
pub(super) enum Object {
    /// An image of one or more slices.
    Slices(Vec<Slice>),
    /// A DICOMDIR.
    Directory,
    /// A report, a plan, anything without pixels.
    NoImage,
}

/// Why a file is not read.
#[derive(Debug)]
pub(super) struct Refusal {
    pub problem: Problem,
    /// The file's series, as far as it is known.
    pub series_uid: String,
    /// Whether it states where it lies in space, or is too damaged to tell: then it may be a slice of its series.
    pub may_be_slice: bool,
}

impl Object {
    /// Reads the fields of a file and checks that its pixels can be read.
    pub fn parse(bytes: &[u8]) -> Result<Self, Refusal> {
        let damaged = |problem| Refusal {
            problem,
            series_uid: String::new(),
            may_be_slice: true,
        };
        let file = File::open(bytes).map_err(damaged)?;
        if file.is_directory {
            return Ok(Self::Directory);
        }
        let mut fields = Fields::new(file.encoding.big);
        let read = fields.read(Elements::new(&file.data, file.encoding));
        let refuse = |problem, may_be_slice| Refusal {
            problem,
            series_uid: fields.text(tags::SERIES_UID),
            may_be_slice,
        };
        read.map_err(|problem| refuse(problem, true))?;
        if !fields.has_pixels && !fields.has(tags::ROWS) {
            return Ok(Self::NoImage);
        }
        slices(&fields, &file.packing)
            .map(Self::Slices)
            .map_err(|problem| refuse(problem, fields.has(tags::POSITION)))
    }
}

/// The slices of an image file.
fn slices(fields: &Fields<'_>, packing: &Packing) -> Result<Vec<Slice>, Problem> {
    if !fields.has_pixels {
        return Err(Problem::format(
            NAME,
            "has no pixel data (7FE0,0010), expected an image",
        ));
    }
    check_kind(fields)?;
    packing.check()?;
    let stated = fields.text(tags::FRAMES);
    let count = match stated.as_str() {
        "" => 1,
        text => text.parse().ok().filter(|count| *count > 0).ok_or_else(|| {
            Problem::format(
                NAME,
                format!("states `{}` frames, expected a whole number from 1", shorten(text)),
            )
        })?,
    };
    match fields.of_frames()? {
        Some(frames) if frames.len() == count => {
            let slices = frames.iter().enumerate();
            slices.map(|(frame, fields)| Slice::of(fields, frame, count)).collect()
        }
        Some(frames) => {
            let fault = format!("states {count} frames and describes {}, expected as many", frames.len());
            Err(Problem::format(NAME, fault))
        }
        None if count == 1 => Ok(vec![Slice::of(fields, 0, 1)?]),
        None => Err(Problem::Unsupported {
            format: NAME,
            found: format!("a file of {count} frames that does not say where each lies"),
            expected: "per-frame functional groups (5200,9230), or one slice per file",
        }),
    }
}

/// Refuses colour.
fn check_kind(fields: &Fields<'_>) -> Result<(), Problem> {
    let refuse = |found, expected| {
        Err(Problem::Unsupported {
            format: NAME,
            found,
            expected,
        })
    };
    let samples = fields.number(tags::SAMPLES).unwrap_or(1);
    if samples != 1 {
        return refuse(format!("a picture of {samples} samples per pixel"), "one");
    }
    let photometric = fields.text(tags::PHOTOMETRIC);
    if !["", "MONOCHROME1", "MONOCHROME2"].contains(&photometric.as_str()) {
        return refuse(
            format!("photometric interpretation {}", shorten(&photometric)),
            "MONOCHROME2 or MONOCHROME1",
        );
    }
    Ok(())
}

impl PixelForm {
    fn of(fields: &Fields<'_>) -> Result<Self, Problem> {
        let allocated = fields.need(tags::ALLOCATED)?;
        let stored = fields.number(tags::STORED).unwrap_or(allocated);
        let high = fields.number(tags::HIGH_BIT).unwrap_or(stored.wrapping_sub(1));
        let sound = [8, 16, 32].contains(&allocated) && (1..=allocated).contains(&stored);
        if !sound || high >= allocated || high + 1 < stored {
            let fault = format!(
                "bits allocated {allocated}, stored {stored}, high bit {high}, expected 8, 16 or 32 bits that hold those stored"
            );
            return Err(Problem::format(NAME, fault));
        }
        Ok(Self {
            bytes: usize::from(allocated / 8),
            stored: u32::from(stored),
            shift: u32::from(high + 1 - stored),
            signed: fields.number(tags::SIGNED).unwrap_or(0) == 1,
            big: fields.big(),
        })
    }
}

impl Slice {
    fn of(fields: &Fields<'_>, frame: usize, frames: usize) -> Result<Self, Problem> {
        let slope = fields.one(tags::SLOPE)?.unwrap_or(1.0);
        let intercept = fields.one(tags::INTERCEPT)?.unwrap_or(0.0);
        let window = match (fields.first(tags::CENTRE), fields.first(tags::WIDTH)) {
            (Some(centre), Some(width)) => Some([centre - width / 2.0, centre + width / 2.0]),
            _ => None,
        };
        let directions = fields
            .numbers::<6>(tags::DIRECTIONS)?
            .map(|[a, b, c, d, e, f]| [[a, b, c], [d, e, f]]);
        Ok(Self {
            frame,
            frames,
            object_uid: fields.text(tags::OBJECT_UID),
            modality: fields.text(tags::MODALITY),
            series_uid: fields.text(tags::SERIES_UID),
            series_number: fields.text(tags::SERIES_NUMBER),
            description: fields.text(tags::DESCRIPTION),
            echo: fields.text(tags::ECHO),
            stack: fields.text(tags::STACK),
            instance: fields.first(tags::INSTANCE),
            phase: PHASE_FIELDS.map(|(_, tag, is_binary)| {
                if is_binary {
                    fields.binary(tag)
                } else {
                    fields.text(tag)
                }
            }),
            position: fields.numbers(tags::POSITION)?,
            directions,
            // The file gives the distance between rows first.
            pixel_spacing: fields
                .numbers::<2>(tags::PIXEL_SPACING)?
                .map(|[between_rows, between_columns]| [between_columns, between_rows]),
            thickness: fields.one(tags::THICKNESS)?,
            columns: u32::from(fields.need(tags::COLUMNS)?),
            rows: u32::from(fields.need(tags::ROWS)?),
            form: PixelForm::of(fields)?,
            rescale: [slope, intercept],
            window,
            inverted: fields.text(tags::PHOTOMETRIC) == "MONOCHROME1",
        })
    }

    /// Whether two slices may belong to one stack. Directions are compared with a tolerance, since files round them.
    pub fn is_kin(&self, other: &Self) -> bool {
        let same_texts = self.series_uid == other.series_uid
            && self.series_number == other.series_number
            && self.echo == other.echo
            && self.stack == other.stack;
        let near = |a: [f64; 3], b: [f64; 3]| {
            let square: f64 = (0..3).map(|i| (a[i] - b[i]).powi(2)).sum();
            square.sqrt() <= SAME_DIRECTION
        };
        let aligned = match (self.directions, other.directions) {
            (Some(a), Some(b)) => near(a[0], b[0]) && near(a[1], b[1]),
            (None, None) => true,
            _ => false,
        };
        same_texts && (self.columns, self.rows) == (other.columns, other.rows) && aligned
    }

    /// Whether one is a copy of the other: the same object at the same place.
    pub fn is_copy(&self, other: &Self) -> bool {
        let identity = |slice: &Self| (slice.frame, slice.instance, slice.position);
        !self.object_uid.is_empty()
            && self.object_uid == other.object_uid
            && identity(self) == identity(other)
            && self.phase == other.phase
    }
}
