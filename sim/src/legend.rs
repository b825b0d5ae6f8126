//! The legend of a label map: which label has which colour, as text, JSON and a picture.

use std::fmt::Write;

use serde::Serialize;
use slicecast_engine::image::Rgb;

use crate::labels::Label;
use crate::lettering::{LETTER, LINE, Sheet};

/// Lines of a legend in text.
const LINES: usize = 32;

/// Rows of a legend in a picture, at least; more where it would be wider than high.
const ROWS: usize = 24;

/// `#rrggbb`.
fn hexadecimal([red, green, blue]: [u8; 3]) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// A legend in lines of text, shortened where it is long.
pub fn text(labels: &[Label]) -> String {
    let mut text = String::from("       label  colour        voxels");
    for label in labels.iter().take(LINES) {
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "\n{:>12}  {}  {:>10}",
            label.label,
            hexadecimal(label.colour),
            label.voxels
        );
    }
    if let Some(more) = labels.len().checked_sub(LINES).filter(|more| *more > 0) {
        let _ = write!(text, "\n{more} more; `render` writes all of them beside the picture");
    }
    text
}

/// A line of the legend in JSON.
#[derive(Serialize)]
pub struct Line {
    /// The code of the label's voxels.
    code: u16,
    /// The label as the file has it.
    label: f64,
    /// `#rrggbb`.
    colour: String,
    /// How many voxels have it.
    voxels: u64,
}

/// The legend in JSON.
#[derive(Serialize)]
struct Lines<'a> {
    volume: &'a str,
    labels: Vec<Line>,
}

/// The lines of a legend in JSON.
pub fn lines(labels: &[Label]) -> Vec<Line> {
    let line = |label: &Label| Line {
        code: label.code,
        label: label.label,
        colour: hexadecimal(label.colour),
        voxels: label.voxels,
    };
    labels.iter().map(line).collect()
}

/// The legend of a volume as JSON.
pub fn json(volume: &str, labels: &[Label]) -> serde_json::Result<Vec<u8>> {
    serde_json::to_vec_pretty(&Lines {
        volume,
        labels: lines(labels),
    })
}

/// The legend as a picture: columns of colours, each with its label beside it.
pub fn picture(labels: &[Label]) -> Rgb {
    let names: Vec<String> = labels.iter().map(|label| label.label.to_string()).collect();
    let longest = names.iter().map(String::len).max().unwrap_or(0) as u32;
    let column = LINE + LETTER * (longest + 2);
    let square = (labels.len() as f64 * f64::from(column) / f64::from(LINE))
        .sqrt()
        .ceil() as usize;
    let rows = square.max(ROWS).min(labels.len().max(1));
    let columns = labels.len().div_ceil(rows).max(1);
    let mut sheet = Sheet::black([columns as u32 * column, rows as u32 * LINE]);
    for (place, (label, name)) in labels.iter().zip(&names).enumerate() {
        let [x, y] = [(place / rows) as u32 * column, (place % rows) as u32 * LINE];
        sheet.fill([x + 1, y + 1], [LINE - 2, LINE - 2], label.colour);
        sheet.write(name, [x + LINE + LETTER, y + 1]);
    }
    sheet.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(count: u16) -> Vec<Label> {
        let label = |code| Label {
            code,
            label: f64::from(code) * 5.0,
            colour: [200, 100, code.to_le_bytes()[0]],
            voxels: 7,
        };
        (1..=count).map(label).collect()
    }

    #[test]
    fn texts_are_short() {
        let text = text(&labels(98));
        assert_eq!(text.lines().count(), LINES + 2);
        assert!(text.contains("\n          10  #c86402           7\n"), "{text}");
        assert!(
            text.ends_with("\n66 more; `render` writes all of them beside the picture"),
            "{text}"
        );
        assert_eq!(super::text(&labels(32)).lines().count(), 33);
    }

    #[test]
    fn json_has_every_label() {
        let bytes = json("a.nii", &labels(98)).unwrap();
        let read: serde_json::Value = serde_json::from_slice(&bytes).unwrap();
        assert_eq!(read["labels"].as_array().map(Vec::len), Some(98));
        assert_eq!(read["labels"][97]["label"], 490.0);
        assert_eq!(read["labels"][97]["colour"], "#c86462");
    }

    #[test]
    fn pictures_show_every_colour_once() {
        for count in [0, 1, 23, 98, 4095] {
            let picture = picture(&labels(count));
            let [width, height] = picture.size;
            assert!(width.max(height) <= 4096, "{:?}", picture.size);
            let swatches = picture.bytes.chunks(3).filter(|p| p[..2] == [200, 100]).count();
            assert_eq!(swatches, usize::from(count) * 14 * 14, "{count}");
        }
    }
}
