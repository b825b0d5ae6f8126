//! The table of a sweep: as text, CSV and JSON.

use comfy_table::Table;
use serde::Serialize;
use slicecast_sim::study::catalogue::Configuration;
use slicecast_sim::study::parameters::Name;
use slicecast_sim::study::rows::Row;
use slicecast_sim::study::sweep::on_front;

use super::Failure;
use super::tables::{header, short};

/// What the columns mean.
pub const LEGEND: &str = "\
Errors: steps of 1/255 on the base plane against the f64 model at the positions of the full step. `worst stage`: the
stage with the fewest right bits on its own inputs. Speeds: fastest frame of several, taken in turns with `compact`;
`speed` is the ratio. Front: no configuration is at least as fast (to 1 %) and at least as exact in the mean, and
better in one of the two.";

/// The table as text.
pub fn table(rows: &[Row]) -> Table {
    let mut table = header(&[
        "configuration",
        "front",
        "pixel",
        "table",
        "equal %",
        "max step",
        "mean step",
        "PSNR dB",
        "worst stage",
        "bits",
        "Msamples/s",
        "speed",
    ]);
    for (row, front) in rows.iter().zip(on_front(rows)) {
        let worst = row
            .stages
            .iter()
            .filter_map(|stage| stage.local_bits.map(|bits| (bits, stage.name.as_str())))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        table.add_row([
            row.name.clone(),
            if front { "*".into() } else { String::new() },
            row.pixel_bytes.to_string(),
            row.table_bytes.to_string(),
            format!("{:.2}", row.image.equal_percent),
            short(row.image.max_lsb8),
            short(row.image.mean_lsb8),
            row.image.psnr_db.map_or("exact".into(), |db| format!("{db:.1}")),
            worst.map_or("-".into(), |(_, name)| name.to_owned()),
            worst.map_or("-".into(), |(bits, _)| format!("{bits:.1}")),
            format!("{:.1}", row.samples_per_second / 1e6),
            format!("{:.2}", row.relative_speed),
        ]);
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
    let mut head: Vec<String> = ["configuration", "front"].map(str::to_owned).into();
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
    head.extend(["samples_per_second", "relative_speed", "rounds", "threads", "inputs"].map(str::to_owned));
    writer.write_record(&head).map_err(Failure::machine)?;
    let optional = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
    for (row, front) in rows.iter().zip(on_front(rows)) {
        let mut line = vec![row.name.clone(), u8::from(front).to_string()];
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
        line.extend([row.rounds.to_string(), row.threads.to_string(), row.key.clone()]);
        writer.write_record(&line).map_err(Failure::machine)?;
    }
    writer.into_inner().map_err(Failure::machine)
}

/// A row and whether it is on the front.
#[derive(Serialize)]
struct Marked<'a> {
    front: bool,
    #[serde(flatten)]
    row: &'a Row,
}

/// The table as JSON.
pub fn json(rows: &[Row]) -> Result<Vec<u8>, Failure> {
    let marked: Vec<_> = rows
        .iter()
        .zip(on_front(rows))
        .map(|(row, front)| Marked { front, row })
        .collect();
    serde_json::to_vec_pretty(&marked).map_err(Failure::machine)
}
