//! What OME-XML in the description of the first page says: planes and physical sizes.
//!
//! Source: the OME-TIFF specification and the schema of 2016-06. Of several images the first counts.

use roxmltree::{Document, Node, ParsingOptions};

use super::NAME;
use super::planes::{PLANES_MAX, Planes};
use super::told::{Description, Length};
use crate::error::Problem;
use crate::text::shorten;

/// Elements and attributes that a description may have.
const NODES_MAX: u32 = 1 << 20;

/// Whether a description is OME-XML.
pub(super) fn recognise(text: &str) -> bool {
    let start = text.trim_start_matches('\u{feff}').trim_start();
    start.starts_with('<') && text.contains("<OME")
}

/// Reads OME-XML.
pub(super) fn read(text: &str) -> Result<Description, Problem> {
    let fault = |what: String| Problem::format(NAME, format!("OME-XML {what}"));
    let options = ParsingOptions {
        nodes_limit: NODES_MAX,
        ..ParsingOptions::default()
    };
    let text = text.trim_start_matches('\u{feff}').trim();
    let document = Document::parse_with_options(text, options)
        .map_err(|error| fault(format!("is damaged: {}", shorten(&error.to_string()))))?;
    let images: Vec<Node<'_, '_>> = document
        .descendants()
        .filter(|node| node.has_tag_name_any("Pixels"))
        .collect();
    let pixels = images.first().ok_or_else(|| fault("states no `Pixels`".into()))?;
    let mut notes = Vec::new();
    if images.len() > 1 {
        notes.push(format!("{} images in the file: shown is the first", images.len()));
    }
    let count = |name: &str| {
        let text = pixels.attribute(name).unwrap_or("1");
        let count = text
            .trim()
            .parse::<usize>()
            .ok()
            .filter(|&count| (1..=PLANES_MAX).contains(&count));
        count.ok_or_else(|| {
            fault(format!(
                "states {name} = `{}`, expected 1 to {PLANES_MAX}",
                shorten(text)
            ))
        })
    };
    let counts = [count("SizeC")?, count("SizeZ")?, count("SizeT")?];
    let order = order(pixels.attribute("DimensionOrder").unwrap_or("XYCZT"))
        .ok_or_else(|| fault("states a DimensionOrder that is none, expected such as XYCZT".into()))?;
    let mut planes = Planes {
        counts,
        order,
        pages: None,
    };
    planes.check()?;
    planes.pages = pages(pixels, &planes).map_err(fault)?;
    let size = |axis: char| {
        let length = pixels
            .attribute(format!("PhysicalSize{axis}").as_str())?
            .trim()
            .parse::<f64>()
            .ok()?;
        let unit = pixels
            .attribute(format!("PhysicalSize{axis}Unit").as_str())
            .unwrap_or("um");
        (length.is_finite() && length > 0.0).then(|| Length::new(length, Some(unit)))
    };
    Ok(Description {
        planes: Some(planes),
        spacing: ['X', 'Y', 'Z'].map(size),
        calibration: None,
        notes,
    })
}

/// From `XYCZT` to the axes behind X and Y.
fn order(text: &str) -> Option<[usize; 3]> {
    let letters = text.trim().strip_prefix("XY")?;
    let axes: Option<Vec<usize>> = letters.chars().map(|letter| "CZT".find(letter)).collect();
    let axes: [usize; 3] = axes?.try_into().ok()?;
    [0, 1, 2].iter().all(|axis| axes.contains(axis)).then_some(axes)
}

/// The page of each plane, from the `TiffData` elements; `None` if pages and planes are in the same order.
fn pages(pixels: &Node<'_, '_>, planes: &Planes) -> Result<Option<Vec<usize>>, String> {
    let blocks: Vec<Node<'_, '_>> = pixels
        .children()
        .filter(|node| node.has_tag_name_any("TiffData"))
        .collect();
    if blocks.is_empty() {
        return Ok(None);
    }
    let mut files: Vec<&str> = blocks
        .iter()
        .flat_map(|block| block.children().filter(|node| node.has_tag_name_any("UUID")))
        .filter_map(|node| node.attribute("FileName"))
        .collect();
    files.sort_unstable();
    files.dedup();
    if files.len() > 1 {
        let count = files.len();
        return Err(format!("keeps the planes in {count} files, expected all in this one"));
    }
    let total = planes.total();
    let mut pages = vec![None; total];
    for block in &blocks {
        let number = |name: &str, default: usize| match block.attribute(name) {
            None => Ok(default),
            Some(text) => text
                .trim()
                .parse::<usize>()
                .map_err(|_| format!("states {name} = `{}`, expected a whole number", shorten(text))),
        };
        let first = [number("FirstC", 0)?, number("FirstZ", 0)?, number("FirstT", 0)?];
        let start = planes.order.iter().rev().try_fold(0_usize, |plane, &axis| {
            let inside = first[axis] < planes.counts[axis];
            inside.then(|| plane * planes.counts[axis] + first[axis])
        });
        let start = start.ok_or("places a plane outside its own sizes")?;
        let default = if block.has_attribute("IFD") { 1 } else { total - start };
        let (page, count) = (number("IFD", 0)?, number("PlaneCount", default)?);
        for (i, place) in pages.iter_mut().skip(start).take(count).enumerate() {
            *place = Some(page.saturating_add(i));
        }
    }
    let found: Option<Vec<usize>> = pages.iter().copied().collect();
    found.map(Some).ok_or_else(|| {
        let missing = pages.iter().filter(|page| page.is_none()).count();
        format!("names no page for {missing} of {total} planes")
    })
}

/// Names without regard to the namespace, whose address changes with the schema's version.
trait AnyNamespace {
    fn has_tag_name_any(&self, name: &str) -> bool;
}

impl AnyNamespace for Node<'_, '_> {
    fn has_tag_name_any(&self, name: &str) -> bool {
        self.is_element() && self.tag_name().name() == name
    }
}
