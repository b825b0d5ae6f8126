//! 3D Slicer's volume properties.
//!
//! Source: Slicer's developer guide ("Format of Volume Property file") and volume-property-schema-v1.0.0.json.

use serde::Deserialize;

use super::curve::{Curve, Node};
use super::{Parts, Shading, material};
use crate::file::SceneFault;

fn fault(text: impl Into<String>) -> SceneFault {
    SceneFault::Import(text.into())
}

/// The older format: a line each for interpolation, shade, diffuse, ambient, specular, power, scalar opacity, gradient
/// opacity, colour. A curve's line begins with the count of its numbers.
pub(super) fn parse_text(text: &str) -> Result<Parts, SceneFault> {
    let lines: Vec<&str> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    let line = |i: usize, what: &str| {
        let missing = || fault(format!("ends before line {}, expected {what}", i + 1));
        lines.get(i).copied().ok_or_else(missing)
    };
    let number = |i: usize, what: &str| {
        let found = line(i, what)?;
        let parsed = found.parse::<f64>().ok().filter(|n| n.is_finite());
        parsed.ok_or_else(|| fault(format!("line {} is no number, expected {what}", i + 1)))
    };
    let _interpolation = number(0, "the interpolation")?;
    let shade = number(1, "whether to shade (0 or 1)")? != 0.0;
    let (diffuse, ambient) = (
        number(2, "the diffuse reflection")?,
        number(3, "the ambient reflection")?,
    );
    let (specular, power) = (number(4, "the specular reflection")?, number(5, "the specular power")?);
    let opacity = curve::<1>(line(6, "the scalar opacity")?, 7)?;
    let gradient = curve::<1>(line(7, "the gradient opacity")?, 8)?;
    let colour = curve::<3>(line(8, "the colours")?, 9)?;
    let mut notes = vec!["opacities are taken as over 1 unit of length: the file does not say".to_owned()];
    note_gradient(&gradient, &mut notes);
    Ok(Parts {
        colour,
        opacity,
        unit_distance: 1.0,
        shading: Some(if shade {
            material([ambient, diffuse, specular, power])?
        } else {
            Shading::Off
        }),
        notes,
    })
}

/// A curve of `count` numbers: x and `N` values a point.
fn curve<const N: usize>(text: &str, line: usize) -> Result<Curve<N>, SceneFault> {
    let bad = |what: &str| fault(format!("line {line} {what}"));
    let mut words = text.split_ascii_whitespace();
    let count = words.next().and_then(|word| word.parse::<usize>().ok());
    let count = count.ok_or_else(|| bad("does not begin with the count of its numbers"))?;
    let numbers: Option<Vec<f64>> = words
        .map(|word| word.parse().ok().filter(|n: &f64| n.is_finite()))
        .collect();
    let numbers = numbers.ok_or_else(|| bad("has a word that is no finite number"))?;
    if numbers.len() != count || !count.is_multiple_of(N + 1) || count == 0 {
        let found = numbers.len();
        return Err(bad(&format!(
            "has {found} numbers, expected {count} as it says, {} a point",
            N + 1
        )));
    }
    let node = |part: &[f64]| Node {
        x: part[0],
        y: std::array::from_fn(|k| part[k + 1]),
        midpoint: 0.5,
        sharpness: 0.0,
    };
    Ok(Curve {
        nodes: numbers.chunks_exact(N + 1).map(node).collect(),
    })
}

fn note_gradient(gradient: &Curve<1>, notes: &mut Vec<String>) {
    if gradient.nodes.iter().any(|node| node.y != [1.0]) {
        notes.push("opacity by gradient is left out".into());
    }
}

/// The format's root; further fields are allowed by its schema.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct File {
    volume_properties: Vec<Property>,
}

#[derive(Deserialize)]
struct Property {
    #[serde(default)]
    components: Vec<Component>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Component {
    #[serde(default)]
    shade: bool,
    lighting: Option<Material>,
    #[serde(default)]
    disable_gradient_opacity: bool,
    scalar_opacity_unit_distance: Option<f64>,
    scalar_opacity: Option<Function<OpacityPoint>>,
    gradient_opacity: Option<Function<OpacityPoint>>,
    rgb_transfer_function: Option<Function<ColourPoint>>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Material {
    ambient: f64,
    diffuse: f64,
    specular: f64,
    specular_power: f64,
}

#[derive(Deserialize)]
struct Function<P> {
    points: Vec<P>,
}

#[derive(Deserialize)]
struct OpacityPoint {
    x: f64,
    y: f64,
    midpoint: Option<f64>,
    sharpness: Option<f64>,
}

#[derive(Deserialize)]
struct ColourPoint {
    x: f64,
    color: [f64; 3],
    midpoint: Option<f64>,
    sharpness: Option<f64>,
}

impl From<&OpacityPoint> for Node<1> {
    fn from(point: &OpacityPoint) -> Self {
        Self {
            x: point.x,
            y: [point.y],
            midpoint: point.midpoint.unwrap_or(0.5),
            sharpness: point.sharpness.unwrap_or(0.0),
        }
    }
}

impl From<&ColourPoint> for Node<3> {
    fn from(point: &ColourPoint) -> Self {
        Self {
            x: point.x,
            y: point.color,
            midpoint: point.midpoint.unwrap_or(0.5),
            sharpness: point.sharpness.unwrap_or(0.0),
        }
    }
}

/// A curve of a function's points.
fn nodes<'a, P, const N: usize>(function: &'a Function<P>) -> Curve<N>
where
    Node<N>: From<&'a P>,
{
    Curve {
        nodes: function.points.iter().map(Node::from).collect(),
    }
}

/// The newer format.
pub(super) fn parse_json(text: &str) -> Result<Parts, SceneFault> {
    let file: File = serde_json::from_str(text).map_err(|error| fault(error.to_string()))?;
    let mut notes = Vec::new();
    let property = file
        .volume_properties
        .first()
        .ok_or_else(|| fault("`volumeProperties` is empty"))?;
    let component = property
        .components
        .first()
        .ok_or_else(|| fault("`components` is empty"))?;
    if file.volume_properties.len() > 1 || property.components.len() > 1 {
        notes.push("the first property's first component is taken, the others are left out".into());
    }
    let missing = |field: &str| fault(format!("component has no points in `{field}`"));
    let opacity: Curve<1> = component.scalar_opacity.as_ref().map(nodes).unwrap_or_default();
    let colour: Curve<3> = component.rgb_transfer_function.as_ref().map(nodes).unwrap_or_default();
    if opacity.nodes.is_empty() {
        return Err(missing("scalarOpacity"));
    }
    if colour.nodes.is_empty() {
        return Err(missing("rgbTransferFunction"));
    }
    if let Some(gradient) = component
        .gradient_opacity
        .as_ref()
        .filter(|_| !component.disable_gradient_opacity)
    {
        note_gradient(&nodes(gradient), &mut notes);
    }
    let shading = match (component.shade, &component.lighting) {
        (false, _) => Shading::Off,
        (true, Some(m)) => material([m.ambient, m.diffuse, m.specular, m.specular_power])?,
        (true, None) => material([0.1, 0.7, 0.2, 10.0])?,
    };
    Ok(Parts {
        colour,
        opacity,
        unit_distance: component.scalar_opacity_unit_distance.unwrap_or(1.0),
        shading: Some(shading),
        notes,
    })
}
