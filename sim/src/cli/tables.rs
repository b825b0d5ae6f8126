//! Error figures as text tables.

use comfy_table::{CellAlignment, ContentArrangement, Table, presets};
use slicecast_bench::Row;
use slicecast_bench::ways::WayRow;
use slicecast_compare::image::ImageFigures;
use slicecast_compare::stages::StageReport;
use slicecast_compare::statistics::Figures;
use slicecast_compare::{Comparison, Split};

/// An empty table under a header, its first column to the left, the others to the right.
pub fn header(columns: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_preset(presets::ASCII_MARKDOWN);
    table.set_header(columns);
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// Columns of a page: what is meant to be read as a whole, and fits.
pub const PAGE: u16 = 100;

/// As [`header`], of a table that breaks its words to fit the page.
pub fn page_header(columns: &[&str]) -> Table {
    let mut table = header(columns);
    table
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_width(PAGE);
    table
}

/// Text in lines that fit the page; those behind the first begin with `indent`.
pub fn paragraph(text: &str, indent: &str) -> String {
    textwrap::fill(
        text,
        textwrap::Options::new(usize::from(PAGE)).subsequent_indent(indent),
    )
}

/// How far measurements scatter, in percent.
pub fn percent(spread: Option<f64>) -> String {
    spread.map_or("-".into(), |spread| format!("{:.1}", 100.0 * spread))
}

/// A figure with three significant digits, in few characters.
pub fn short(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        v if v < 0.001 => format!("{value:.1e}"),
        v if v < 10.0 => format!("{value:.3}"),
        v if v < 1000.0 => format!("{value:.1}"),
        v if v < 1e6 => format!("{value:.0}"),
        _ => format!("{value:.2e}"),
    }
}

fn bits(figures: &Figures) -> String {
    figures.bits.map_or("exact".into(), |bits| format!("{bits:.1}"))
}

/// What a stage's figures are shown by; JSON has the number of samples and the root mean square as well.
const FIGURES: [&str; 6] = ["max ulp", "mean", "bias", "exact %", "bits", "Squeeze"];

fn figures(f: &Figures) -> [String; 5] {
    [
        short(f.max_ulp),
        short(f.mean_ulp),
        short(f.bias_ulp),
        format!("{:.2}", f.exact_percent),
        bits(f),
    ]
}

/// Errors of every stage on its own inputs, beside the bits that Squeeze requires.
pub fn local(stages: &[StageReport]) -> Table {
    let mut table = page_header(&[&["stage, local error", "format"], &FIGURES[..]].concat());
    for stage in stages {
        let mut cells = vec![stage.name.to_owned(), stage.format.clone()];
        cells.extend(figures(&stage.local));
        cells.push(match (stage.required_bits, stage.meets_required) {
            (Some(bits), Some(true)) => format!("{bits}: met"),
            (Some(bits), _) => format!("{bits}: no"),
            (None, _) => "-".into(),
        });
        table.add_row(cells);
    }
    table
}

/// Errors of every stage against the model from the beginning.
pub fn carried(stages: &[StageReport]) -> Table {
    let mut table = page_header(&[&["stage, carried error", "format"], &FIGURES[..5]].concat());
    for stage in stages {
        let mut cells = vec![stage.name.to_owned(), stage.format.clone()];
        cells.extend(figures(&stage.carried));
        table.add_row(cells);
    }
    table
}

/// Errors of pictures, a line each.
pub fn images(lines: &[(String, ImageFigures)]) -> Table {
    let mut table = page_header(&["8-bit values", "values", "equal %", "max step", "mean step", "PSNR dB"]);
    for (name, f) in lines {
        table.add_row([
            name.clone(),
            f.values.to_string(),
            format!("{:.2}", f.equal_percent),
            short(f.max_lsb8),
            short(f.mean_lsb8),
            f.psnr_db.map_or("exact".into(), |db| format!("{db:.1}")),
        ]);
    }
    table
}

/// The lines of a comparison in [`images`].
pub fn image_lines(name: &str, comparison: &Comparison) -> [(String, ImageFigures); 2] {
    [
        (format!("{name}, base plane"), comparison.image),
        (format!("{name}, picture"), comparison.picture),
    ]
}

/// The lines of a split error in [`images`].
pub fn split_lines(split: &Split) -> Vec<(String, ImageFigures)> {
    let line = |name: &str, figures| (name.to_owned(), figures);
    [line("arithmetic: pipeline, f64 at exact positions", split.arithmetic)]
        .into_iter()
        .chain(
            split
                .table
                .map(|table| line("table: f64 of its codes, f64 as written", table)),
        )
        .chain([
            line("algorithm: f64, converged integral", split.algorithm),
            line("both: pipeline, converged integral", split.both),
        ])
        .collect()
}

/// Times of pictures, by the way that they are made.
pub fn ways(rows: &[WayRow]) -> Table {
    let mut table = header(&[
        "picture",
        "threads",
        "ms a frame",
        "± %",
        "samples, records, M",
        "time to parallel rays",
    ]);
    for row in rows {
        table.add_row([
            row.way.to_owned(),
            row.threads.to_string(),
            format!("{:.2}", row.milliseconds),
            percent(row.spread),
            format!("{:.2}", row.count as f64 / 1e6),
            format!("{:.2}", row.against_rays),
        ]);
    }
    table
}

/// Times of frames.
pub fn speed(rows: &[Row]) -> Table {
    let mut table = header(&[
        "who",
        "vectors",
        "threads",
        "ms a frame",
        "M samples/s",
        "± %",
        "ns per sample",
        "to compact",
        "to f32",
    ]);
    let ratio = |ratio: Option<f64>| ratio.map_or("-".into(), |ratio| format!("{ratio:.2}"));
    for row in rows {
        table.add_row([
            row.engine.clone(),
            row.width.to_owned(),
            row.threads.to_string(),
            format!("{:.2}", row.milliseconds),
            format!("{:.1}", row.samples_per_second / 1e6),
            percent(row.spread),
            format!("{:.3}", row.nanoseconds),
            ratio(row.against_compact),
            ratio(row.against_f32),
        ]);
    }
    table
}
