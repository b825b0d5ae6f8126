//! Error figures as text tables.

use comfy_table::{CellAlignment, Table, presets};
use slicecast_bench::Row;
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

/// Errors of every stage on its own inputs, beside what Squeeze requires.
pub fn local(stages: &[StageReport]) -> Table {
    let mut table = header(&[
        "stage, local error",
        "format",
        "samples",
        "max ulp",
        "mean",
        "rms",
        "bias",
        "exact %",
        "bits",
        "Squeeze",
        "met",
    ]);
    for stage in stages {
        let f = &stage.local;
        table.add_row([
            stage.name.to_owned(),
            stage.format.clone(),
            f.samples.to_string(),
            short(f.max_ulp),
            short(f.mean_ulp),
            short(f.rms_ulp),
            short(f.bias_ulp),
            format!("{:.2}", f.exact_percent),
            bits(f),
            stage.required_bits.map_or("-".into(), |bits| bits.to_string()),
            match stage.meets_required {
                Some(true) => "yes",
                Some(false) => "no",
                None => "-",
            }
            .to_owned(),
        ]);
    }
    table
}

/// Errors of every stage against the model from the beginning.
pub fn carried(stages: &[StageReport]) -> Table {
    let mut table = header(&[
        "stage, carried error",
        "format",
        "samples",
        "max ulp",
        "mean",
        "rms",
        "bias",
        "exact %",
        "bits",
    ]);
    for stage in stages {
        let f = &stage.carried;
        table.add_row([
            stage.name.to_owned(),
            stage.format.clone(),
            f.samples.to_string(),
            short(f.max_ulp),
            short(f.mean_ulp),
            short(f.rms_ulp),
            short(f.bias_ulp),
            format!("{:.2}", f.exact_percent),
            bits(f),
        ]);
    }
    table
}

/// Errors of pictures, a line each.
pub fn images(lines: &[(String, ImageFigures)]) -> Table {
    let mut table = header(&["8-bit values", "values", "equal %", "max step", "mean step", "PSNR dB"]);
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
pub fn split_lines(split: &Split) -> [(String, ImageFigures); 3] {
    [
        ("arithmetic: pipeline, f64 at exact positions".into(), split.arithmetic),
        ("algorithm: f64, converged integral".into(), split.algorithm),
        ("both: pipeline, converged integral".into(), split.both),
    ]
}

/// Times of frames.
pub fn speed(rows: &[Row]) -> Table {
    let mut table = header(&[
        "who",
        "vectors",
        "threads",
        "ms a frame",
        "M samples/s",
        "ns a sample",
        "against compact",
    ]);
    for row in rows {
        table.add_row([
            row.engine.clone(),
            row.width.to_owned(),
            row.threads.to_string(),
            format!("{:.2}", row.milliseconds),
            format!("{:.1}", row.samples_per_second / 1e6),
            format!("{:.3}", row.nanoseconds),
            row.against_compact.map_or("-".into(), |ratio| format!("{ratio:.2}")),
        ]);
    }
    table
}
