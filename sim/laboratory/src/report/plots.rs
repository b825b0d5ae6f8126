//! The report's plots, as SVG inside the page.
//!
//! Ink is drawn in colours that no plot uses and then replaced by the page's own, so that light, dark and print share one
//! drawing.

use plotters::prelude::*;

use crate::pareto::{Place, places};
use crate::rows::Row;
use slicecast_compare::stages::StageReport;

/// What stands for the page's text and line colours.
const INK: RGBColor = RGBColor(1, 1, 1);
const FAINT: RGBColor = RGBColor(2, 2, 2);
/// What stands for the colours of the three precisions, and of all other points.
const SERIES: [RGBColor; 4] = [
    RGBColor(3, 3, 3),
    RGBColor(4, 4, 4),
    RGBColor(5, 5, 5),
    RGBColor(6, 6, 6),
];

/// The precisions that the plot of the front names wherever they are; the last has the colour of all other points, but filled.
const NAMED: [&str; 4] = ["paper", "compact", "wide", "fast"];

/// A plot that cannot be drawn.
pub(crate) type PlotError = Box<dyn std::error::Error>;

/// Puts the page's colours in and makes the drawing as wide as its place.
fn finish(svg: &str, label: &str) -> String {
    let label = label.replace('&', "&amp;").replace('"', "&quot;").replace('<', "&lt;");
    let mut svg = svg.to_owned();
    for (mark, colour) in [
        ("#010101", "currentColor"),
        ("#020202", "var(--faint)"),
        ("#030303", "var(--series-1)"),
        ("#040404", "var(--series-2)"),
        ("#050505", "var(--series-3)"),
        ("#060606", "var(--series-4)"),
    ] {
        svg = svg.replace(mark, colour);
    }
    svg.replacen("<svg ", &format!("<svg role=\"img\" aria-label=\"{label}\" "), 1)
}

/// Places on a logarithmic axis: 1, 2 and 5 of each decade, or of many decades each 1. A range without a power of ten has
/// some as well.
pub(crate) fn decades(low: f64, high: f64) -> Vec<f64> {
    let [first, last] = [low, high].map(|end| end.log10().floor() as i32);
    let steps: &[f64] = if last - first > 4 { &[1.0] } else { &[1.0, 2.0, 5.0] };
    let places = (first..=last).flat_map(|decade| steps.iter().map(move |step| step * 10f64.powi(decade)));
    places.filter(|place| (low..=high).contains(place)).collect()
}

/// The label of a place on an axis: as many digits as tell it from its neighbours, and none of the noise of its sum.
pub(crate) fn tick(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    match rounded.abs() {
        0.0 => "0".into(),
        v if v < 0.001 => format!("{rounded:e}"),
        _ => rounded.to_string(),
    }
}

/// Bits that every value of a stage has right on its own inputs, by precision, and what Squeeze requires.
pub fn stages(reports: &[(&str, &[StageReport])], label: &str) -> Result<String, PlotError> {
    let mut names: Vec<(&str, Option<u32>)> = Vec::new();
    for report in reports.iter().flat_map(|(_, stages)| stages.iter()) {
        if !names.iter().any(|(name, _)| *name == report.name) {
            names.push((report.name, report.required_bits));
        }
    }
    let count = names.len() as f64;
    let size = (860, 60 + 52 * names.len() as u32);
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        let mut chart = ChartBuilder::on(&root)
            .margin(10)
            .margin_right(24)
            .x_label_area_size(36)
            .y_label_area_size(200)
            .build_cartesian_2d(0.0..33.0, 0.0..count)?;
        chart
            .configure_mesh()
            .disable_y_mesh()
            .y_labels(0)
            .x_labels(9)
            .x_desc("fraction bits that every value has right")
            .x_label_formatter(&|x| tick(*x))
            .label_style(("sans-serif", 13).into_font().color(&INK))
            .axis_style(INK)
            .bold_line_style(FAINT)
            .light_line_style(TRANSPARENT)
            .draw()?;
        let each = 0.8 / reports.len().max(1) as f64;
        for (row, (name, required)) in names.iter().enumerate() {
            let top = count - row as f64 - 0.1;
            let (_, y) = chart.backend_coord(&(0.0, top - 0.4));
            let style = ("sans-serif", 13)
                .into_font()
                .color(&INK)
                .pos(plotters::style::text_anchor::Pos::new(
                    plotters::style::text_anchor::HPos::Right,
                    plotters::style::text_anchor::VPos::Center,
                ));
            root.draw(&Text::new((*name).to_owned(), (202, y), style))?;
            for (place, (_, stages)) in reports.iter().enumerate() {
                let Some(stage) = stages.iter().find(|stage| stage.name == *name) else {
                    continue;
                };
                // A stage without an error has all bits.
                let bits = stage.local.bits.unwrap_or(32.0).clamp(0.0, 32.0);
                let (high, low) = (top - place as f64 * each, top - (place as f64 + 0.85) * each);
                let colour = SERIES[place.min(2)];
                chart.draw_series([Rectangle::new([(0.0, low), (bits, high)], colour.filled())])?;
            }
            if let Some(required) = required {
                let x = f64::from(*required);
                chart.draw_series([PathElement::new(vec![(x, top), (x, top - 0.8)], INK.stroke_width(2))])?;
            }
        }
        root.present()?;
    }
    Ok(finish(&svg, label))
}

/// Speed against error, a point a configuration; the front joined up and named.
pub fn front(rows: &[Row], label: &str) -> Result<String, PlotError> {
    let error = |row: &Row| row.image.mean_lsb8.max(1e-6);
    let speeds = rows.iter().map(|row| row.relative_speed);
    let (slowest, fastest) = speeds.fold((f64::INFINITY, 0.0f64), |(l, h), s| (l.min(s), h.max(s)));
    let (least, most) = rows
        .iter()
        .map(error)
        .fold((f64::INFINITY, 0.0f64), |(l, h), e| (l.min(e), h.max(e)));
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (860, 520)).into_drawing_area();
        let x_range = slowest * 0.95..fastest * 1.12;
        let (low, high) = (least / 2.0, most * 2.0);
        let y_range = (low..high).log_scale().with_key_points(decades(low, high));
        let mut chart = ChartBuilder::on(&root)
            .margin(10)
            .x_label_area_size(40)
            .y_label_area_size(76)
            .build_cartesian_2d(x_range, y_range)?;
        chart
            .configure_mesh()
            .x_desc("speed, compact = 1 (faster to the right)")
            .y_desc("mean error, steps of 1/255 (better below)")
            .x_label_formatter(&|x| tick(*x))
            .y_label_formatter(&|y| tick(*y))
            .label_style(("sans-serif", 13).into_font().color(&INK))
            .axis_style(INK)
            .bold_line_style(FAINT)
            .light_line_style(TRANSPARENT)
            .draw()?;
        let marked: Vec<bool> = places(rows).into_iter().map(|place| place == Place::Front).collect();
        let mut front: Vec<&Row> = rows
            .iter()
            .zip(&marked)
            .filter(|(_, on)| **on)
            .map(|(row, _)| row)
            .collect();
        front.sort_by(|a, b| a.relative_speed.total_cmp(&b.relative_speed));
        let line: Vec<_> = front.iter().map(|row| (row.relative_speed, error(row))).collect();
        chart.draw_series(LineSeries::new(line, INK.stroke_width(1)))?;
        for (row, on) in rows.iter().zip(&marked) {
            let place = NAMED.iter().position(|name| *name == row.name);
            let colour = SERIES[place.unwrap_or(3)];
            let style = if *on || place.is_some() {
                colour.filled()
            } else {
                colour.stroke_width(1)
            };
            let at = (row.relative_speed, error(row));
            chart.draw_series([Circle::new(at, if *on { 6 } else { 4 }, style)])?;
        }
        // Names, each as near to its point as those before it leave room.
        let mut taken: Vec<(i32, i32, i32)> = Vec::new();
        let named = rows
            .iter()
            .zip(&marked)
            .filter(|(row, on)| **on || NAMED.contains(&row.name.as_str()));
        for (row, _) in named {
            let (x, y) = chart.backend_coord(&(row.relative_speed, error(row)));
            let width = 7 * row.name.chars().count() as i32;
            let x = (x + 9).min(850 - width);
            let free = |y: i32, taken: &[(i32, i32, i32)]| {
                taken
                    .iter()
                    .all(|(from, to, line)| x > *to || x + width < *from || (y - line).abs() >= 14)
            };
            let tries = [-7, 7, -21, 21, -35, 35, -49, 49];
            let y = tries.iter().map(|d| y + d).find(|y| free(*y, &taken)).unwrap_or(y);
            taken.push((x, x + width, y));
            let style = ("sans-serif", 12).into_font().color(&INK);
            root.draw(&Text::new(row.name.clone(), (x, y - 6), style))?;
        }
        root.present()?;
    }
    Ok(finish(&svg, label))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::tests::row;

    /// The numbers on the axes of a drawing, each line of them by itself.
    fn ticks(svg: &str) -> Vec<Vec<String>> {
        let mut lines: std::collections::BTreeMap<String, Vec<String>> = Default::default();
        for text in svg.split("<text ").skip(1) {
            let attribute = |name: &str| text.split(name).nth(1).and_then(|rest| rest.split('"').nth(1));
            let words = text
                .split('>')
                .nth(1)
                .and_then(|rest| rest.split('<').next())
                .unwrap_or("")
                .trim();
            if words.parse::<f64>().is_ok() {
                // Labels of the axis below share their height, those of the one beside it their end.
                let place = match attribute("text-anchor=") {
                    Some("end") => format!("x {}", attribute(" x=").or(attribute("x=")).unwrap()),
                    _ => format!("y {}", attribute(" y=").unwrap()),
                };
                lines.entry(place).or_default().push(words.to_owned());
            }
        }
        lines.into_values().collect()
    }

    #[test]
    fn no_two_ticks_of_an_axis_have_one_label() {
        for (speeds, errors) in [
            ([0.98, 1.01], [0.0021, 0.0024]),
            ([0.2, 3.0], [1e-5, 12.0]),
            ([1.0, 1.0], [1.3e-4, 1.9e-4]),
            ([0.999, 1.0], [0.0, 0.0]),
            ([10.0, 250.0], [0.5, 0.5]),
        ] {
            let rows = [row("a", 0, errors[0], speeds[0]), row("b", 1, errors[1], speeds[1])];
            let axes = ticks(&front(&rows, "").unwrap());
            assert!(axes.len() >= 2, "{axes:?}");
            for labels in axes {
                let mut distinct = labels.clone();
                distinct.sort();
                distinct.dedup();
                assert_eq!(distinct.len(), labels.len(), "{speeds:?} {errors:?}: {labels:?}");
            }
        }
    }

    #[test]
    fn ticks_have_no_noise() {
        let labels = [0.1 + 0.2, 1.0, 0.05, 2e-4, 1.5e-5, 0.0, 120.0].map(tick);
        assert_eq!(labels, ["0.3", "1", "0.05", "2e-4", "1.5e-5", "0", "120"]);
    }

    #[test]
    fn the_front_names_what_is_on_it_and_has_no_ink_of_its_own() {
        let rows = [
            row("compact", 0, 0.005, 1.0),
            row("fast", 1, 0.5, 1.6),
            row("bad", 2, 3.0, 0.7),
            row("exact", 3, 0.0, 0.6),
        ];
        let svg = front(&rows, "speed & \"error\"").unwrap();
        assert!(svg.contains("aria-label=\"speed &amp; &quot;error&quot;\""));
        for name in ["fast", "compact", "exact"] {
            assert!(svg.contains(name), "{name}");
        }
        assert!(!svg.contains(">\nbad\n") && !svg.contains(">bad<"));
        assert!(svg.contains("currentColor") && svg.contains("var(--series-2)"));
        for mark in ["#010101", "#020202", "#030303", "#040404", "#060606"] {
            assert!(!svg.contains(mark), "{mark}");
        }
    }
}
