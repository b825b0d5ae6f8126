//! The fields that a volume needs, as typed values; those of a frame stand in for those of its file.

use std::collections::HashMap;

use super::NAME;
use super::element::{Elements, PIXEL_DATA, Tag, Value, name, u16_of};
use super::file::text;
use crate::error::Problem;
use crate::text::shorten_bytes;

pub(super) const IMAGE_TYPE: Tag = (0x0008, 0x0008);
pub(super) const OBJECT_UID: Tag = (0x0008, 0x0018);
pub(super) const ACQUISITION_TIME: Tag = (0x0008, 0x0032);
pub(super) const MODALITY: Tag = (0x0008, 0x0060);
pub(super) const DESCRIPTION: Tag = (0x0008, 0x103e);
pub(super) const THICKNESS: Tag = (0x0018, 0x0050);
pub(super) const ECHO_TIME: Tag = (0x0018, 0x0081);
pub(super) const ECHO: Tag = (0x0018, 0x0086);
pub(super) const TRIGGER_TIME: Tag = (0x0018, 0x1060);
pub(super) const EFFECTIVE_ECHO_TIME: Tag = (0x0018, 0x9082);
pub(super) const DIFFUSION: Tag = (0x0018, 0x9087);
pub(super) const SERIES_UID: Tag = (0x0020, 0x000e);
pub(super) const SERIES_NUMBER: Tag = (0x0020, 0x0011);
pub(super) const ACQUISITION: Tag = (0x0020, 0x0012);
pub(super) const INSTANCE: Tag = (0x0020, 0x0013);
pub(super) const POSITION: Tag = (0x0020, 0x0032);
pub(super) const DIRECTIONS: Tag = (0x0020, 0x0037);
pub(super) const TEMPORAL_POSITION: Tag = (0x0020, 0x0100);
pub(super) const STACK: Tag = (0x0020, 0x9056);
pub(super) const TEMPORAL_INDEX: Tag = (0x0020, 0x9128);
pub(super) const TRIGGER_DELAY: Tag = (0x0020, 0x9153);
pub(super) const SAMPLES: Tag = (0x0028, 0x0002);
pub(super) const PHOTOMETRIC: Tag = (0x0028, 0x0004);
pub(super) const FRAMES: Tag = (0x0028, 0x0008);
pub(super) const ROWS: Tag = (0x0028, 0x0010);
pub(super) const COLUMNS: Tag = (0x0028, 0x0011);
pub(super) const PIXEL_SPACING: Tag = (0x0028, 0x0030);
pub(super) const ALLOCATED: Tag = (0x0028, 0x0100);
pub(super) const STORED: Tag = (0x0028, 0x0101);
pub(super) const HIGH_BIT: Tag = (0x0028, 0x0102);
pub(super) const SIGNED: Tag = (0x0028, 0x0103);
pub(super) const CENTRE: Tag = (0x0028, 0x1050);
pub(super) const WIDTH: Tag = (0x0028, 0x1051);
pub(super) const INTERCEPT: Tag = (0x0028, 0x1052);
pub(super) const SLOPE: Tag = (0x0028, 0x1053);

/// The fields that are kept.
const KEPT: [Tag; 35] = [
    IMAGE_TYPE,
    OBJECT_UID,
    ACQUISITION_TIME,
    MODALITY,
    DESCRIPTION,
    THICKNESS,
    ECHO_TIME,
    ECHO,
    TRIGGER_TIME,
    EFFECTIVE_ECHO_TIME,
    DIFFUSION,
    SERIES_UID,
    SERIES_NUMBER,
    ACQUISITION,
    INSTANCE,
    POSITION,
    DIRECTIONS,
    TEMPORAL_POSITION,
    STACK,
    TEMPORAL_INDEX,
    TRIGGER_DELAY,
    SAMPLES,
    PHOTOMETRIC,
    FRAMES,
    ROWS,
    COLUMNS,
    PIXEL_SPACING,
    ALLOCATED,
    STORED,
    HIGH_BIT,
    SIGNED,
    CENTRE,
    WIDTH,
    INTERCEPT,
    SLOPE,
];

/// What all frames of a file have in common, and what each has of its own.
const SHARED_GROUPS: Tag = (0x5200, 0x9229);
const FRAME_GROUPS: Tag = (0x5200, 0x9230);

/// The functional groups whose fields are kept: echo, diffusion, cardiac phase, frame content, plane position and
/// orientation, pixel measures, window, rescale.
const GROUPS: [Tag; 9] = [
    (0x0018, 0x9114),
    (0x0018, 0x9117),
    (0x0018, 0x9118),
    (0x0020, 0x9111),
    (0x0020, 0x9113),
    (0x0020, 0x9116),
    (0x0028, 0x9110),
    (0x0028, 0x9132),
    (0x0028, 0x9145),
];

/// The kept fields of a file, or of one frame of it.
#[derive(Clone)]
pub(super) struct Fields<'a> {
    values: HashMap<Tag, &'a [u8]>,
    shared: Option<Value<'a>>,
    frames: Option<Value<'a>>,
    /// Whether the file has pixels.
    pub has_pixels: bool,
    big: bool,
}

impl<'a> Fields<'a> {
    /// No fields yet.
    pub fn new(big: bool) -> Self {
        Self {
            values: HashMap::new(),
            shared: None,
            frames: None,
            has_pixels: false,
            big,
        }
    }

    /// Takes the fields of a file, up to its pixels; those before a damage are kept.
    pub fn read(&mut self, mut elements: Elements<'a>) -> Result<(), Problem> {
        while let Some((tag, value)) = elements.next()? {
            match tag {
                PIXEL_DATA => {
                    self.has_pixels = true;
                    break;
                }
                SHARED_GROUPS => self.shared = Some(value),
                FRAME_GROUPS => self.frames = Some(value),
                _ => self.keep(tag, value),
            }
        }
        Ok(())
    }

    fn keep(&mut self, tag: Tag, value: Value<'a>) {
        if let Value::Bytes(bytes, _) = value
            && KEPT.contains(&tag)
        {
            self.values.insert(tag, bytes);
        }
    }

    /// The fields of every frame of the file; `None` if the file says nothing about single frames.
    pub fn of_frames(&self) -> Result<Option<Vec<Self>>, Problem> {
        let Some(frames) = self.frames else {
            return Ok(None);
        };
        let mut common = self.clone();
        if let Some(shared) = self.shared {
            let mut items = shared.items();
            while let Some(groups) = items.next()? {
                common.read_groups(groups)?;
            }
        }
        let mut all = Vec::new();
        let mut items = frames.items();
        while let Some(groups) = items.next()? {
            let mut frame = common.clone();
            frame.read_groups(groups)?;
            all.push(frame);
        }
        Ok(Some(all))
    }

    /// Takes the fields of functional groups.
    fn read_groups(&mut self, mut groups: Elements<'a>) -> Result<(), Problem> {
        while let Some((tag, value)) = groups.next()? {
            let mut items = value.items();
            while GROUPS.contains(&tag)
                && let Some(mut fields) = items.next()?
            {
                while let Some((tag, value)) = fields.next()? {
                    self.keep(tag, value);
                }
            }
        }
        Ok(())
    }

    /// Whether numbers are stored with their highest byte first.
    pub const fn big(&self) -> bool {
        self.big
    }

    /// Whether the field is there and not empty.
    pub fn has(&self, tag: Tag) -> bool {
        self.values.get(&tag).is_some_and(|bytes| !bytes.is_empty())
    }

    /// A field of two bytes that has to be there.
    pub fn need(&self, tag: Tag) -> Result<u16, Problem> {
        let missing = || Problem::format(NAME, format!("has no element {}, expected a number", name(tag)));
        self.number(tag).ok_or_else(missing)
    }

    /// A field of two bytes.
    pub fn number(&self, tag: Tag) -> Option<u16> {
        let bytes = self.values.get(&tag)?;
        (bytes.len() == 2).then(|| u16_of(bytes, self.big))
    }

    /// A text field; empty if it is not there.
    pub fn text(&self, tag: Tag) -> String {
        let bytes = self.values.get(&tag).copied().unwrap_or(&[]);
        text(bytes.get(..256).unwrap_or(bytes))
    }

    /// A number stored in 4 or 8 bytes as text.
    pub fn binary(&self, tag: Tag) -> String {
        let bytes = self.values.get(&tag).copied().unwrap_or(&[]);
        let ordered = |mut bytes: Vec<u8>| {
            if self.big {
                bytes.reverse();
            }
            bytes
        };
        match *ordered(bytes.to_vec()).as_slice() {
            [a, b, c, d] => u32::from_le_bytes([a, b, c, d]).to_string(),
            [a, b, c, d, e, f, g, h] => f64::from_le_bytes([a, b, c, d, e, f, g, h]).to_string(),
            _ => String::new(),
        }
    }

    /// Exactly `N` decimal numbers, or none if the field is absent or empty.
    pub fn numbers<const N: usize>(&self, tag: Tag) -> Result<Option<[f64; N]>, Problem> {
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

    /// One decimal number.
    pub fn one(&self, tag: Tag) -> Result<Option<f64>, Problem> {
        Ok(self.numbers::<1>(tag)?.map(|[number]| number))
    }

    /// The first of several numbers; one that is no number is left out.
    pub fn first(&self, tag: Tag) -> Option<f64> {
        let text = self.text(tag);
        text.split('\\').next().and_then(|word| word.trim().parse().ok())
    }
}
