//! Axes of one entry beyond three, such as a trailing time axis of one point: they are left out of the header.

use super::header::Header;
use super::refuse;
use crate::error::Problem;

/// Axes that a header may have.
pub(super) const MAX_AXES: usize = 16;

/// Fields with a word for each axis of the file.
const PER_AXIS: [&str; 6] = ["sizes", "spacings", "thicknesses", "kinds", "units", "space directions"];

/// Leaves out surplus axes: those without a direction of space first, then the last. An axis of more than one entry is
/// never left out.
///
/// # Errors
/// [`Problem::FieldValue`] if more than three axes are left.
pub(super) fn leave_out(header: &mut Header) -> Result<(), Problem> {
    let stated = header.get("dimension").and_then(|text| text.parse::<usize>().ok());
    let Some(axes) = stated.filter(|axes| (4..=MAX_AXES).contains(axes)) else {
        return Ok(());
    };
    let words = |header: &Header, field: &str| header.get(field).and_then(|text| words(text, axes));
    let Some(sizes) = words(header, "sizes") else {
        return Ok(());
    };
    let directions = words(header, "space directions");
    let no_direction = |axis: &usize| {
        directions
            .as_ref()
            .is_some_and(|words| words[*axis].eq_ignore_ascii_case("none"))
    };
    // An axis of colours is none to be left out beside, whatever the others have.
    let coloured = words(header, "kinds").is_some_and(|kinds| kinds.iter().any(|kind| is_colour(kind)));
    let mut kept: Vec<usize> = (0..axes).collect();
    while kept.len() > 3 {
        let single = |axis: &&usize| sizes[**axis] == "1" && !coloured;
        let directionless = kept.iter().rev().filter(single).find(|axis| no_direction(axis));
        let Some(&left_out) = directionless.or_else(|| kept.iter().rev().find(single)) else {
            let text = header.get("dimension").unwrap_or_default();
            return Err(refuse("dimension", text, "3: a volume of one value a voxel"));
        };
        kept.retain(|&axis| axis != left_out);
    }
    retain(header, axes, &kept);
    header
        .notes
        .push(format!("{} axes of one entry are left out", axes - 3));
    Ok(())
}

/// Leaves all of the file's `axes` out of the header but those kept.
pub(super) fn retain(header: &mut Header, axes: usize, kept: &[usize]) {
    for field in PER_AXIS {
        if let Some(words) = header.get(field).and_then(|text| words(text, axes)) {
            let text: Vec<&str> = kept.iter().map(|&axis| words[axis].as_str()).collect();
            header.fields.insert(field, text.join(" "));
        }
    }
    header.fields.insert("dimension", kept.len().to_string());
}

/// Whether an axis of this kind has colours.
pub(super) fn is_colour(kind: &str) -> bool {
    kind.to_ascii_lowercase().ends_with("-color")
}

/// Exactly `count` words, of which one may be a parenthesised vector or stand in quotes.
pub(super) fn words(text: &str, count: usize) -> Option<Vec<String>> {
    let mut words = Vec::new();
    let mut rest = text.trim();
    while let Some(first) = rest.chars().next() {
        let closing = match first {
            '(' => Some(')'),
            '"' => Some('"'),
            _ => None,
        };
        let len = match closing {
            Some(closing) => 1 + rest[1..].find(closing)? + 1,
            None => rest.find([' ', '\t', '(']).unwrap_or(rest.len()),
        };
        words.push(rest[..len].to_owned());
        rest = rest[len..].trim_start();
    }
    (words.len() == count).then_some(words)
}
