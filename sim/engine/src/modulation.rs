//! From a scene's functions of the gradient's magnitude to the pipeline's tables.

use slicecast::format::Intensity;
use slicecast::modulate::{Factors, Modulation, NODES};
use slicecast_scene::Scene;
use slicecast_volume::Mapping;

/// The tables of a scene on a volume with this spacing; `None` if it modulates nothing.
pub fn of(scene: &Scene, mapping: &Mapping, spacing: [f64; 3]) -> Option<Modulation> {
    let stated = scene.modulation.as_ref()?;
    let finest = spacing.into_iter().fold(f64::INFINITY, f64::min);
    // Gradients are codes over two voxels of the finest spacing.
    let unit = mapping.scale.abs() / (2.0 * finest);
    let table = |points: &[[f64; 2]]| (!points.is_empty()).then(|| factors(points, unit));
    Some(Modulation {
        opacity: table(&stated.opacity),
        diffuse: table(&stated.diffuse),
        specular: table(&stated.specular),
    })
}

/// The square of the gradient, codes over two voxels, at a node.
fn square(node: usize) -> f64 {
    let half = if node.is_multiple_of(2) { 1.0 } else { 1.5 };
    half * ((node / 2) as f64 - 4.0).exp2()
}

/// Factors at the nodes, each to nearest. The first stands for all that is flatter, and is what is stated of 0.
fn factors(points: &[[f64; 2]], unit: f64) -> Factors {
    let bits = |node: usize| {
        let gradient = if node == 0 { 0.0 } else { square(node).sqrt() };
        (factor(points, gradient * unit) * 32768.0).round() as u16
    };
    let nodes: [Intensity; NODES] = std::array::from_fn(|node| Intensity::from_bits(bits(node)));
    // A scene that has been checked has no factor above 1.
    Factors::new(&nodes).unwrap_or_default()
}

/// A function through points, linear between them and constant outside.
fn factor(points: &[[f64; 2]], magnitude: f64) -> f64 {
    let after = points.partition_point(|[at, _]| *at <= magnitude);
    match (points.get(after.wrapping_sub(1)), points.get(after)) {
        (Some([m0, f0]), Some([m1, f1])) => f0 + (f1 - f0) * (magnitude - m0) / (m1 - m0),
        (Some([_, factor]), None) | (None, Some([_, factor])) => *factor,
        (None, None) => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_go_through_their_points() {
        let points = [[1.0, 0.25], [3.0, 0.75], [4.0, 0.0]];
        for (magnitude, expected) in [
            (0.0, 0.25),
            (1.0, 0.25),
            (2.0, 0.5),
            (3.0, 0.75),
            (3.5, 0.375),
            (4.0, 0.0),
            (9.0, 0.0),
        ] {
            assert_eq!(factor(&points, magnitude), expected, "{magnitude}");
        }
    }

    /// The table's own error: of a ramp from 0 it is that of a chord of a square root between two nodes.
    #[test]
    fn tables_are_close_to_their_functions() {
        use slicecast::format::Opacity;
        use slicecast::modulate::Modulated;
        use slicecast::precision::Compact;
        let worst = |points: &[[f64; 2]]| {
            let modulation = Modulation {
                opacity: Some(factors(points, 0.5)),
                ..Modulation::default()
            };
            let shader = Modulated::new(Compact, None, modulation);
            let error = |at: u32| {
                let gradient = [(at * 997) as i32, 0, 0];
                let found = f64::from(shader.opacity(gradient, Opacity::from_bits(1 << 31)).to_bits()) / 2f64.powi(31);
                (found - factor(points, f64::from(gradient[0]) / 8192.0)).abs()
            };
            (0..30_000).map(error).fold(0.0, f64::max)
        };
        // A ramp over all magnitudes: 0.57 % of the factor at the node before, which reaches 0.71 here.
        let ramp = worst(&[[0.0, 0.0], [4096.0, 1.0]]);
        assert!((0.0039..0.0042).contains(&ramp), "{ramp}");
        // A step between two nodes is as wide as they are apart.
        let step = worst(&[[0.0, 0.0], [200.0, 0.0], [220.0, 1.0]]);
        assert!((0.43..0.45).contains(&step), "{step}");
    }
}
