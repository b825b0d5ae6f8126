//! Error against time of every scene, as an SVG by itself.

use plotters::prelude::*;

use super::curves::{Curve, Frame};
use crate::report::plots::{PlotError, decades, tick};

const INK: RGBColor = RGBColor(40, 40, 40);
const FAINT: RGBColor = RGBColor(215, 215, 215);
const SAMPLES: RGBColor = RGBColor(0, 95, 170);
const SEGMENTS: RGBColor = RGBColor(200, 80, 0);
const COLUMNS: usize = 3;
/// Pixels of a scene's plot.
const SIZE: [u32; 2] = [320, 250];
/// Errors below this are drawn as this.
const LEAST: f64 = 1e-4;

/// A small plot per scene. Time is relative to that of one plane of samples; both axes are logarithmic. Numbers beside points are
/// planes per voxel.
///
/// # Errors
/// If it cannot be drawn.
pub fn curves(curves: &[Curve]) -> Result<String, PlotError> {
    // The last place explains.
    let rows = (curves.len() + 1).div_ceil(COLUMNS);
    let mut svg = String::new();
    {
        let size = (SIZE[0] * COLUMNS as u32, SIZE[1] * rows as u32);
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        root.fill(&WHITE)?;
        let places = root.split_evenly((rows, COLUMNS));
        for (place, curve) in places.iter().zip(curves) {
            draw(place, curve)?;
        }
        if let Some(place) = places.get(curves.len()) {
            for (line, (words, colour)) in [
                ("samples", SAMPLES),
                ("segments", SEGMENTS),
                ("numbers: planes per voxel", INK),
                ("across: time, one plane of samples = 1", INK),
                ("up: mean error, steps of 1/255", INK),
            ]
            .into_iter()
            .enumerate()
            {
                let style = ("sans-serif", 14).into_font().color(&colour);
                place.draw(&Text::new(words, (30, 60 + 24 * line as i32), style))?;
            }
        }
        root.present()?;
    }
    Ok(svg)
}

fn draw(place: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>, curve: &Curve) -> Result<(), PlotError> {
    let unit = curve.samples.first().map_or(1.0, |frame| frame.milliseconds);
    let at = |frame: &Frame| (frame.milliseconds / unit, frame.mean.max(LEAST));
    let all: Vec<(f64, f64)> = curve.samples.iter().chain(&curve.segments).map(at).collect();
    let range = |values: Vec<f64>| {
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        [least / 1.5, values.iter().copied().fold(0.0, f64::max) * 1.7]
    };
    let [left, right] = range(all.iter().map(|place| place.0).collect());
    let [low, high] = range(all.iter().map(|place| place.1).collect());
    let across = (left..right).log_scale().with_key_points(decades(left, right));
    let up = (low..high).log_scale().with_key_points(decades(low, high));
    let mut chart = ChartBuilder::on(place)
        .margin(8)
        .caption(curve.case, ("sans-serif", 14).into_font().color(&INK))
        .x_label_area_size(24)
        .y_label_area_size(48)
        .build_cartesian_2d(across, up)?;
    chart
        .configure_mesh()
        .x_label_formatter(&|x| tick(*x))
        .y_label_formatter(&|y| tick(*y))
        .label_style(("sans-serif", 11).into_font().color(&INK))
        .axis_style(INK)
        .bold_line_style(FAINT)
        .light_line_style(TRANSPARENT)
        .draw()?;
    for (frames, colour) in [(&curve.samples, SAMPLES), (&curve.segments, SEGMENTS)] {
        chart.draw_series(LineSeries::new(frames.iter().map(at), colour.stroke_width(2)))?;
        chart.draw_series(frames.iter().map(|frame| Circle::new(at(frame), 3, colour.filled())))?;
        let style = ("sans-serif", 11).into_font().color(&colour);
        let number =
            |frame: &Frame| EmptyElement::at(at(frame)) + Text::new(frame.planes.to_string(), (5, -13), style.clone());
        chart.draw_series(frames.iter().map(number))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_is_drawn_with_its_planes() {
        let frame = |planes: u32, mean: f64| Frame {
            planes,
            mean,
            most: mean,
            whole: mean,
            milliseconds: f64::from(planes),
        };
        let curve = |case| Curve {
            case,
            samples: vec![frame(1, 3.0), frame(16, 0.0)],
            segments: vec![frame(2, 0.5)],
            worth: Vec::new(),
        };
        let svg = curves(&[curve("first"), curve("second")]).unwrap();
        for words in ["first", "second", "segments", "16"] {
            assert!(svg.contains(&format!(">\n{words}\n<")), "{words}: {svg}");
        }
        assert_eq!(svg.matches("<circle").count(), 6);
    }
}
