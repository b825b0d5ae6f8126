//! Figure 3 as an SVG: thickness and opacity along a row of rays.

use plotters::prelude::*;

use super::figures::{Profile, Through, opacity};
use crate::report::plots::PlotError;

const INK: RGBColor = RGBColor(40, 40, 40);
const FAINT: RGBColor = RGBColor(225, 225, 225);
const EXACT: RGBColor = RGBColor(0, 95, 170);
const RENDERED: RGBColor = RGBColor(200, 80, 0);
/// Pixels of a plot.
const SIZE: (u32, u32) = (360, 240);

/// What is drawn: its name, and how it comes of a thickness.
type Quantity = (&'static str, fn(f64) -> f64);

/// A row of plots for the thickness and one for the opacity, a plot for each of the borders: exact and rendered.
///
/// # Errors
/// If it cannot be drawn.
pub fn profiles(profiles: &[Profile]) -> Result<String, PlotError> {
    const QUANTITIES: [Quantity; 2] = [("thickness, steps", |steps| steps), ("opacity", opacity)];
    let mut svg = String::new();
    {
        let columns = profiles.len().max(1);
        let root = SVGBackend::with_string(&mut svg, (SIZE.0 * columns as u32, SIZE.1 * 2)).into_drawing_area();
        root.fill(&WHITE)?;
        let places = root.split_evenly((2, columns));
        for (row, quantity) in QUANTITIES.into_iter().enumerate() {
            for (place, profile) in places[row * columns..].iter().zip(profiles) {
                draw(place, profile, quantity)?;
            }
        }
        root.present()?;
    }
    Ok(svg)
}

fn draw(
    place: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
    profile: &Profile,
    (name, of): Quantity,
) -> Result<(), PlotError> {
    let rays = &profile.rays;
    let (first, last) = match (rays.first(), rays.last()) {
        (Some(first), Some(last)) => (first.place, last.place),
        _ => (0.0, 1.0),
    };
    let all = rays.iter().flat_map(|ray| [ray.length, ray.rendered]).map(of);
    let most = 1.08 * all.fold(0.1, f64::max);
    let style = |size: u32| ("sans-serif", size).into_font().color(&INK);
    let mut chart = ChartBuilder::on(place)
        .margin(10)
        .caption(format!("{}: {name}", profile.borders), style(15))
        .x_label_area_size(24)
        .y_label_area_size(34)
        .build_cartesian_2d(first..last, 0.0..most)?;
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .bold_line_style(FAINT)
        .axis_style(INK)
        .x_labels(6)
        .y_labels(5)
        .label_style(style(11))
        .draw()?;
    let line = |value: fn(&Through) -> f64| rays.iter().map(move |ray| (ray.place, of(value(ray))));
    chart.draw_series(LineSeries::new(line(|ray| ray.rendered), RENDERED.stroke_width(2)))?;
    chart.draw_series(LineSeries::new(line(|ray| ray.length), EXACT.stroke_width(1)))?;
    for (words, colour, down) in [("exact", EXACT, 0), ("rendered", RENDERED, 15)] {
        let style = ("sans-serif", 12).into_font().color(&colour);
        place.draw(&Text::new(words, (SIZE.0 as i32 - 75, 40 + down), style))?;
    }
    Ok(())
}
