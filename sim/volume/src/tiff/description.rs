//! What the first page's tags and description say about the whole stack: planes, distances, calibration.

use tiff::tags::Tag;

use super::ome;
use super::patched::Decoder;
use super::planes::Planes;
use super::told::{Description, Length};
use crate::error::Problem;
use crate::text::{decode, shorten};

/// Bytes of a description that are read.
const TEXT_MAX: usize = 1 << 22;

/// Reads the first page's description and, where it states no distances, the page's resolution.
pub(super) fn read(decoder: &mut Decoder<'_>, size: [u32; 2]) -> Result<Description, Problem> {
    let (text, latin) = decode(&text(decoder));
    let mut description = if ome::recognise(&text) {
        ome::read(&text)?
    } else if text.starts_with("ImageJ=") {
        imagej(&text, latin, resolution(decoder))?
    } else {
        Description {
            planes: shaped(&text, size),
            ..Description::default()
        }
    };
    if description.spacing[..2].iter().all(Option::is_none) {
        let unit = decoder.find_tag_unsigned::<u16>(Tag::ResolutionUnit).ok().flatten();
        let name = match unit {
            Some(2) => Some("inch"),
            Some(3) => Some("cm"),
            _ => None,
        };
        let [x, y] = resolution(decoder);
        description.spacing[0] = x.map(|pixel| Length::new(pixel, name));
        description.spacing[1] = y.map(|pixel| Length::new(pixel, name));
    }
    Ok(description)
}

/// The first page's description, as its bytes stand in the file, up to the first 0.
fn text(decoder: &mut Decoder<'_>) -> Vec<u8> {
    let mut ifd = decoder.image_ifd();
    let Some(entry) = ifd.find_entry(Tag::ImageDescription) else {
        return Vec::new();
    };
    let len = usize::try_from(entry.count()).unwrap_or(TEXT_MAX).min(TEXT_MAX);
    let mut bytes = vec![0; len];
    let read = ifd.find_tag_bytes(Tag::ImageDescription, &mut bytes, 0);
    bytes.truncate(read.ok().flatten().unwrap_or(0));
    let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
    bytes.truncate(end);
    bytes
}

/// The distance between pixels along x and y in the resolution's unit.
fn resolution(decoder: &mut Decoder<'_>) -> [Option<f64>; 2] {
    [Tag::XResolution, Tag::YResolution].map(|tag| {
        let [n, d] = decoder.get_tag_u32_vec(tag).ok()?.try_into().ok()?;
        (n > 0 && d > 0).then(|| f64::from(d) / f64::from(n))
    })
}

/// ImageJ's description: lines of `key=value`. Pages count channels first, then slices, then time points.
fn imagej(text: &str, latin: bool, resolution: [Option<f64>; 2]) -> Result<Description, Problem> {
    let field = |key: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix('='));
        line.map(str::trim)
    };
    let number = |key: &str| {
        field(key)
            .and_then(|text| text.parse::<f64>().ok())
            .filter(|x| x.is_finite())
    };
    let count = |key: &str| -> Result<Option<usize>, Problem> {
        let Some(text) = field(key) else { return Ok(None) };
        match text.parse() {
            Ok(count @ 1..=0xff_ffff) => Ok(Some(count)),
            _ => Err(Problem::format(
                super::NAME,
                format!(
                    "ImageJ's description states {key} = `{}`, expected 1 or more",
                    shorten(text)
                ),
            )),
        }
    };
    let mut notes = Vec::new();
    if latin {
        notes.push("the description is not UTF-8 text: it is taken as Latin-1".into());
    }
    let (channels, times) = (count("channels")?.unwrap_or(1), count("frames")?.unwrap_or(1));
    let images = count("images")?;
    let slices = match (count("slices")?, images) {
        (Some(slices), _) => Some(slices),
        (None, Some(images)) => Some((images / channels.saturating_mul(times)).max(1)),
        (None, None) => None,
    };
    let planes = slices.map(|slices| Planes {
        counts: [channels, slices, times],
        order: Planes::CHANNELS_FIRST,
        pages: None,
    });
    planes.as_ref().map_or(Ok(()), Planes::check)?;
    let unit = field("unit");
    let length = |number: f64| Length::new(number, unit);
    let spacing = number("spacing").map(f64::abs).filter(|&step| step > 0.0);
    let calibration = match (field("cf"), number("c0"), number("c1")) {
        (Some("0"), Some(offset), Some(scale)) if scale != 0.0 => Some([scale, offset]),
        (None, ..) => None,
        (Some(function), ..) => {
            notes.push(format!(
                "the calibration function {} is not applied: the values are as stored",
                shorten(function)
            ));
            None
        }
    };
    if let Some([scale, offset]) = calibration.filter(|&calibration| calibration != [1.0, 0.0]) {
        notes.push(format!(
            "the file's calibration is applied: value = {offset} + {scale} x stored"
        ));
    }
    Ok(Description {
        planes,
        spacing: [
            resolution[0].map(length),
            resolution[1].map(length),
            spacing.map(length),
        ],
        calibration,
        notes,
    })
}

/// The shape that tifffile writes, `{"shape": [2, 16, 22, 20]}`: axes before the last three are taken as time points.
fn shaped(text: &str, [width, height]: [u32; 2]) -> Option<Planes> {
    let list = text.trim_start().strip_prefix("{\"shape\": [")?.split(']').next()?;
    let sides: Option<Vec<usize>> = list.split(',').map(|side| side.trim().parse().ok()).collect();
    let mut sides = sides?;
    while sides.len() > 3 && sides.ends_with(&[1]) {
        sides.pop();
    }
    let [before @ .., slices, rows, columns] = &sides[..] else {
        return None;
    };
    let times = before.iter().fold(1_usize, |all, &side| all.saturating_mul(side));
    let is_whole = [*rows, *columns] == [height as usize, width as usize];
    (is_whole && times > 1 && *slices > 0).then_some(Planes {
        counts: [1, *slices, times],
        order: Planes::CHANNELS_FIRST,
        pages: None,
    })
}
