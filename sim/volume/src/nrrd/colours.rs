//! The axis of colours: the first one, of three or four entries, is taken off the header.

use super::header::Header;
use super::refuse;
use super::surplus::{MAX_AXES, is_colour, retain, words};
use crate::error::Problem;

/// Kinds of an axis that do not say what its entries mean.
const UNSTATED: [&str; 5] = ["???", "none", "list", "vector", "point"];

/// Takes the axis of colours off and returns its entries; `None` of a header that has no such axis.
///
/// # Errors
/// [`Problem::FieldValue`] if colours are stated that are not red, green, blue (and a fourth), or not side by side.
pub(super) fn take(header: &mut Header) -> Result<Option<usize>, Problem> {
    let stated = header.get("dimension").and_then(|text| text.parse::<usize>().ok());
    let Some(axes) = stated.filter(|axes| (4..=MAX_AXES).contains(axes)) else {
        return Ok(None);
    };
    let kinds = header.get("kinds").and_then(|text| words(text, axes));
    let kinds = kinds.map(|kinds| kinds.iter().map(|kind| kind.to_ascii_lowercase()).collect::<Vec<_>>());
    if let Some(kinds) = &kinds
        && kinds.iter().skip(1).any(|kind| is_colour(kind))
    {
        let text = header.get("kinds").unwrap_or_default();
        return Err(refuse(
            "kinds",
            text,
            "the axis of colours first: the colours of a voxel side by side",
        ));
    }
    let sizes = header.get("sizes").and_then(|text| words(text, axes));
    let count = match sizes.as_ref().and_then(|sizes| sizes.first()).map(String::as_str) {
        Some("3") => 3,
        Some("4") => 4,
        _ => return Ok(None),
    };
    match kinds.as_ref().and_then(|kinds| kinds.first()).map(String::as_str) {
        Some("rgb-color" | "3-color") if count == 3 => {}
        Some("rgba-color" | "4-color") if count == 4 => {}
        Some(kind) if is_colour(kind) => {
            let text = header.get("kinds").unwrap_or_default();
            let expected = if count == 3 {
                "`RGB-color` or `3-color` for the first axis, which has 3 entries"
            } else {
                "`RGBA-color` or `4-color` for the first axis, which has 4 entries"
            };
            return Err(refuse("kinds", text, expected));
        }
        // A direction in space, a tensor, or something else that is no colour.
        Some(kind) if !UNSTATED.contains(&kind) => return Ok(None),
        // Three axes and others of one entry are a volume of one value a voxel.
        _ if sizes.iter().flatten().filter(|size| *size != "1").count() <= 3 => return Ok(None),
        _ => header.notes.push(unstated(count)),
    }
    let kept: Vec<usize> = (1..axes).collect();
    retain(header, axes, &kept);
    Ok(Some(count))
}

/// Materials whose shares a voxel can have.
const SHARES: std::ops::RangeInclusive<usize> = 1..=8;

/// Takes the first axis off, whose entries are shares of materials, and returns how many there are.
///
/// # Errors
/// [`Problem::FieldValue`] if the header has no such axis.
pub(super) fn take_shares(header: &mut Header) -> Result<usize, Problem> {
    let given = header.get("dimension").unwrap_or_default().to_owned();
    let axes = given.parse::<usize>().ok().filter(|axes| (4..=MAX_AXES).contains(axes));
    let axes = axes.ok_or_else(|| refuse("dimension", &given, "4: the shares of materials first, then three axes"))?;
    let first = |field| header.get(field).and_then(|text| words(text, axes)?.into_iter().next());
    if let Some(kind) = first("kinds")
        && !UNSTATED.contains(&kind.to_ascii_lowercase().as_str())
    {
        let expected = "`list` or `???` for the first axis, which is of shares of materials";
        return Err(refuse("kinds", header.get("kinds").unwrap_or_default(), expected));
    }
    let count = first("sizes")
        .and_then(|size| size.parse().ok())
        .filter(|count| SHARES.contains(count));
    let Some(count) = count else {
        let expected = "1 to 8 shares of materials first, then the voxels along three axes";
        return Err(refuse("sizes", header.get("sizes").unwrap_or_default(), expected));
    };
    let kept: Vec<usize> = (1..axes).collect();
    retain(header, axes, &kept);
    Ok(count)
}

/// What is assumed of entries that have no stated meaning.
fn unstated(count: usize) -> String {
    let meaning = if count == 3 {
        "red, green, blue"
    } else {
        "red, green, blue and opacity"
    };
    format!("the file does not say what the {count} values of a voxel are: they are taken for {meaning}")
}
