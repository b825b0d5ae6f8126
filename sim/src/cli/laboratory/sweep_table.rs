//! The table of a sweep: as text, CSV and JSON.

use comfy_table::Table;
use serde::Serialize;
use slicecast_laboratory::catalogue::{BASE, Configuration};
use slicecast_laboratory::ensemble::{Difference, spread};
use slicecast_laboratory::parameters::Name;
use slicecast_laboratory::pareto::{Place, places};
use slicecast_laboratory::rows::Row;

use crate::cli::Failure;
use crate::cli::tables::{header, percent, short};

/// What the columns mean.
const LEGEND: &str = "\
Errors: steps of 1/255 on the base plane against the f64 model at the positions of the full step. `worst stage`: the
stage with the fewest right bits on its own inputs. Speeds: fastest frame of several, rendered by the host with these
lanes and taken in turns with `compact`; `speed` is the median of the rounds' ratios, and `± %` half the distance between
their quartiles. Widths of studies are values: such a row stands beside `compact` with its widths as values, and its
speed is that of the arithmetic, not of the memory. Tables have colours of 8 bits, those of `compact` and `wide` too, as
with `--table sqrt16`: where a scene's colours change with the value, other commands give these two colours of 16 bits.
Front: no configuration is at least as fast and at least as exact in the mean, and clearly better in one of the two;
speeds that differ by no more than they scatter (at least 1 %) are one speed. `~` would be on the front if they were
exact.";

/// What the columns of several views mean.
const ENSEMBLE: &str = "\
Views: errors are of all together; `spread` is the standard deviation of a view's mean step. `less compact`: mean step less
that of `compact` in the same view, its mean over the views and the standard error of that; below 0 is more exact, and
clearly so beyond 2.2 standard errors. `better in`: views in which it is below 0.";

/// What the columns of a table mean.
pub fn legend(rows: &[Row]) -> String {
    if ensemble(rows) {
        format!("{LEGEND}\n{ENSEMBLE}")
    } else {
        LEGEND.into()
    }
}

/// Whether rows were measured in several views.
fn ensemble(rows: &[Row]) -> bool {
    rows.iter().any(|row| row.views.len() > 1)
}

/// A row beside the base, view by view; `None` without the base's row.
fn beside(row: &Row, rows: &[Row]) -> Option<Difference> {
    let base = rows.iter().find(|row| row.name == BASE)?;
    Some(Difference::between(&row.errors(), &base.errors()))
}

/// The table as text.
pub fn table(rows: &[Row]) -> Table {
    let ensemble = ensemble(rows);
    let mut columns = vec![
        "configuration",
        "front",
        "pixel",
        "table",
        "equal %",
        "max step",
        "mean step",
    ];
    if ensemble {
        columns.extend(["spread", "less compact", "better in"]);
    }
    columns.extend(["PSNR dB", "worst stage", "bits", "lanes", "Msamples/s", "speed", "± %"]);
    let mut table = header(&columns);
    for (row, place) in rows.iter().zip(places(rows)) {
        let worst = row
            .stages
            .iter()
            .filter_map(|stage| stage.local_bits.map(|bits| (bits, stage.name.as_str())))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let mut cells = vec![
            row.name.clone(),
            place.sign().into(),
            row.pixel_bytes.to_string(),
            row.table_bytes.to_string(),
            format!("{:.2}", row.image.equal_percent),
            short(row.image.max_lsb8),
            short(row.image.mean_lsb8),
        ];
        if ensemble {
            let beside = beside(row, rows);
            let error = beside.and_then(|d| d.standard_error);
            cells.extend([
                spread(&row.errors()).map_or("-".into(), short),
                beside.map_or("-".into(), |d| {
                    format!("{:+.1e} ± {:.1e}", d.mean, error.unwrap_or(0.0))
                }),
                beside.map_or("-".into(), |d| format!("{} of {}", d.better, d.views)),
            ]);
        }
        cells.extend([
            row.image.psnr_db.map_or("exact".into(), |db| format!("{db:.1}")),
            worst.map_or("-".into(), |(_, name)| name.to_owned()),
            worst.map_or("-".into(), |(bits, _)| format!("{bits:.1}")),
            row.lanes.clone(),
            format!("{:.1}", row.samples_per_second / 1e6),
            format!("{:.2}", row.relative_speed),
            percent(row.speed_spread),
        ]);
        table.add_row(cells);
    }
    table
}

/// The configurations and what they are made of.
pub fn list<'a>(configurations: impl Iterator<Item = &'a Configuration>) -> Table {
    let mut columns = vec!["configuration", "pixel", "table"];
    columns.extend(Name::ALL.iter().map(|name| name.text()));
    let mut table = header(&columns);
    for c in configurations {
        let mut cells = vec![c.name.clone(), c.pixel_bytes.to_string(), c.table_bytes.to_string()];
        cells.extend(Name::ALL.iter().map(|name| c.parameter(*name).to_owned()));
        table.add_row(cells);
    }
    table
}

/// The stages that any row has, in the order of the pipeline.
fn stages(rows: &[Row]) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for stage in rows.iter().flat_map(|row| &row.stages) {
        if !names.contains(&stage.name.as_str()) {
            names.push(&stage.name);
        }
    }
    names
}

/// The table as CSV: a line a configuration, with its parameters and the errors of every stage.
pub fn csv(rows: &[Row]) -> Result<Vec<u8>, Failure> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let stages = stages(rows);
    let mut head: Vec<String> = ["configuration", "front", "within_spread"].map(str::to_owned).into();
    head.extend(Name::ALL.iter().map(|name| name.text().to_owned()));
    head.extend(
        [
            "pixel_bytes",
            "table_bytes",
            "values",
            "equal_percent",
            "max_lsb8",
            "mean_lsb8",
            "psnr_db",
            "views",
            "spread_lsb8",
            "less_compact_lsb8",
            "less_compact_standard_error",
            "views_better",
        ]
        .map(str::to_owned),
    );
    for stage in &stages {
        for figure in [
            "local max ulp",
            "local mean ulp",
            "local bits",
            "carried max ulp",
            "carried mean ulp",
        ] {
            head.push(format!("{stage}: {figure}"));
        }
    }
    head.extend(
        [
            "samples_per_second",
            "relative_speed",
            "speed_spread",
            "rounds",
            "threads",
            "lanes",
            "inputs",
        ]
        .map(str::to_owned),
    );
    writer.write_record(&head).map_err(Failure::machine)?;
    let optional = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
    for (row, place) in rows.iter().zip(places(rows)) {
        let mut line = vec![row.name.clone()];
        line.extend([Place::Front, Place::WithinSpread].map(|asked| u8::from(place == asked).to_string()));
        for name in Name::ALL {
            let value = row.parameters.iter().find(|(n, _)| *n == name);
            line.push(value.map_or(String::new(), |(_, value)| value.clone()));
        }
        let image = &row.image;
        line.extend([
            row.pixel_bytes.to_string(),
            row.table_bytes.to_string(),
            image.values.to_string(),
        ]);
        line.extend([image.equal_percent, image.max_lsb8, image.mean_lsb8].map(|value| value.to_string()));
        line.push(optional(image.psnr_db));
        let beside = beside(row, rows);
        line.extend([
            row.views.len().to_string(),
            optional(spread(&row.errors())),
            optional(beside.map(|d| d.mean)),
            optional(beside.and_then(|d| d.standard_error)),
            beside.map_or(String::new(), |d| d.better.to_string()),
        ]);
        for name in &stages {
            match row.stages.iter().find(|stage| stage.name == *name) {
                Some(stage) => {
                    line.extend([stage.local_max_ulp, stage.local_mean_ulp].map(|value| value.to_string()));
                    line.push(optional(stage.local_bits));
                    line.extend([stage.carried_max_ulp, stage.carried_mean_ulp].map(|value| value.to_string()));
                }
                None => line.extend(std::iter::repeat_n(String::new(), 5)),
            }
        }
        line.extend([row.samples_per_second, row.relative_speed].map(|value| value.to_string()));
        line.push(optional(row.speed_spread));
        line.extend([
            row.rounds.to_string(),
            row.threads.to_string(),
            row.lanes.clone(),
            row.key.clone(),
        ]);
        writer.write_record(&line).map_err(Failure::machine)?;
    }
    writer.into_inner().map_err(Failure::machine)
}

/// A row and whether it is on the front, or would be if speeds were exact.
#[derive(Serialize)]
struct Marked<'a> {
    front: bool,
    within_spread: bool,
    #[serde(flatten)]
    row: &'a Row,
}

/// The table as JSON.
pub fn json(rows: &[Row]) -> Result<Vec<u8>, Failure> {
    let marked: Vec<_> = rows
        .iter()
        .zip(places(rows))
        .map(|(row, place)| Marked {
            front: place == Place::Front,
            within_spread: place == Place::WithinSpread,
            row,
        })
        .collect();
    serde_json::to_vec_pretty(&marked).map_err(Failure::machine)
}
