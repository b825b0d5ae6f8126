//! ParaView's colour maps: JSON with `RGBPoints` (value, red, green, blue …) and `Points` (value, opacity, midpoint,
//! sharpness …).

use serde::Deserialize;

use super::Parts;
use super::curve::{Curve, Node};
use crate::file::SceneFault;

#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
struct Map {
    color_space: Option<String>,
    name: Option<String>,
    #[serde(rename = "RGBPoints")]
    rgb_points: Option<Vec<f64>>,
    points: Option<Vec<f64>>,
}

/// A file is a list of maps, or one map.
#[derive(Deserialize)]
#[serde(untagged)]
enum File {
    Many(Vec<Map>),
    One(Box<Map>),
}

fn fault(text: impl Into<String>) -> SceneFault {
    SceneFault::Import(text.into())
}

/// Reads the first map.
pub(super) fn parse(text: &str) -> Result<Parts, SceneFault> {
    let file: File = serde_json::from_str(text).map_err(|error| fault(error.to_string()))?;
    let (map, others) = match file {
        File::One(map) => (*map, 0),
        File::Many(maps) => {
            let others = maps.len().saturating_sub(1);
            let first = maps.into_iter().next();
            (
                first.ok_or_else(|| fault("is an empty list, expected a colour map"))?,
                others,
            )
        }
    };
    let mut notes = vec!["opacities are taken as over 1 unit of length: the file does not say".to_owned()];
    if others > 0 {
        let name = map
            .name
            .as_deref()
            .unwrap_or("without a name")
            .escape_debug()
            .to_string();
        notes.push(format!(
            "the first colour map (`{name}`) is taken, {others} others are left out"
        ));
    }
    if let Some(space) = map
        .color_space
        .as_deref()
        .filter(|space| *space != "RGB" && *space != "Step")
    {
        let space = space.escape_debug();
        notes.push(format!("colours between points are mixed in RGB, not in `{space}`"));
    }
    let rgb = map.rgb_points.unwrap_or_default();
    if rgb.is_empty() || !rgb.len().is_multiple_of(4) {
        let found = rgb.len();
        return Err(fault(format!("`RGBPoints` has {found} numbers, expected four a point")));
    }
    let step = map.color_space.as_deref() == Some("Step");
    let colour = Curve {
        nodes: rgb
            .chunks_exact(4)
            .map(|p| Node {
                x: p[0],
                y: [p[1], p[2], p[3]],
                // A stepped map holds a colour up to the next point.
                midpoint: if step { 1.0 } else { 0.5 },
                sharpness: if step { 1.0 } else { 0.0 },
            })
            .collect(),
    };
    let opacity = match map.points {
        Some(points) if !points.is_empty() && points.len().is_multiple_of(4) => Curve {
            nodes: points
                .chunks_exact(4)
                .map(|p| Node {
                    x: p[0],
                    y: [p[1]],
                    midpoint: p[2],
                    sharpness: p[3],
                })
                .collect(),
        },
        Some(points) if !points.is_empty() => {
            let found = points.len();
            return Err(fault(format!("`Points` has {found} numbers, expected four a point")));
        }
        _ => {
            notes.push("the file states no opacity: it rises from 0 to 1 over the colours".into());
            ramp(&colour)
        }
    };
    Ok(Parts {
        colour,
        opacity,
        unit_distance: 1.0,
        shading: None,
        notes,
    })
}

/// From 0 at the first colour to 1 at the last.
fn ramp(colour: &Curve<3>) -> Curve<1> {
    let xs = colour.nodes.iter().map(|node| node.x);
    let low = xs.clone().fold(f64::INFINITY, f64::min);
    let high = xs.fold(f64::NEG_INFINITY, f64::max);
    let node = |x, y| Node {
        x,
        y: [y],
        midpoint: 0.5,
        sharpness: 0.0,
    };
    Curve {
        nodes: vec![node(low, 0.0), node(high, 1.0)],
    }
}
