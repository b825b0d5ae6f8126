//! Piecewise linear curves with VTK's midpoints and sharpness, and how two become one function.

use super::super::Point;

/// One point of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Node<const N: usize> {
    pub x: f64,
    pub y: [f64; N],
    /// Where between this point and the next the curve is half way, 0 to 1.
    pub midpoint: f64,
    /// 0 linear, 1 a step.
    pub sharpness: f64,
}

/// A curve as a file states it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Curve<const N: usize> {
    pub nodes: Vec<Node<N>>,
}

/// A curve of straight pieces, ascending; two points of one x are a step.
pub(super) type Straight<const N: usize> = Vec<(f64, [f64; N])>;

impl<const N: usize> Curve<N> {
    /// The curve in straight pieces; what it cannot follow is told.
    pub fn straight(&self, notes: &mut Vec<String>) -> Straight<N> {
        let mut nodes = self.nodes.clone();
        // VTK sorts as well; the order of equal points is kept.
        nodes.sort_by(|a, b| a.x.total_cmp(&b.x));
        let mut out: Straight<N> = Vec::new();
        for (i, node) in nodes.iter().enumerate() {
            push(&mut out, node.x, node.y);
            let Some(next) = nodes.get(i + 1).filter(|next| next.x > node.x) else {
                continue;
            };
            let middle = node.x + node.midpoint.clamp(0.0, 1.0) * (next.x - node.x);
            if node.sharpness > 0.99 {
                push(&mut out, middle, node.y);
                push(&mut out, middle, next.y);
            } else if node.midpoint != 0.5 || node.sharpness > 0.01 {
                let half = std::array::from_fn(|k| f64::midpoint(node.y[k], next.y[k]));
                push(&mut out, middle, half);
                if node.sharpness > 0.01 {
                    notes.push("a curve is bent (sharpness between 0 and 1): it is taken as straight pieces".into());
                }
            }
        }
        out
    }
}

/// Adds a point; of three at one x the middle one would never be seen.
fn push<const N: usize>(out: &mut Straight<N>, x: f64, y: [f64; N]) {
    if let [.., (a, _), (b, _)] = out[..]
        && a == x
        && b == x
    {
        out.pop();
    }
    out.push((x, y));
}

/// The values just below and at `x`.
fn around<const N: usize>(curve: &Straight<N>, x: f64) -> [[f64; N]; 2] {
    let below = curve.partition_point(|point| point.0 < x);
    let at = curve.partition_point(|point| point.0 <= x);
    let between = |i: usize| match (i.checked_sub(1).and_then(|i| curve.get(i)), curve.get(i)) {
        (Some(a), Some(b)) => {
            let t = (x - a.0) / (b.0 - a.0);
            std::array::from_fn(|k| a.1[k] + (b.1[k] - a.1[k]) * t)
        }
        (Some(only), None) | (None, Some(only)) => only.1,
        (None, None) => [0.0; N],
    };
    if below == at {
        return [between(below); 2];
    }
    // Before its first point a curve is constant.
    [curve[below].1, curve[at - 1].1]
}

/// One function that has the colour of one curve and the opacity of the other everywhere.
pub(super) fn join(colour: &Straight<3>, opacity: &Straight<1>) -> Vec<Point> {
    let mut places: Vec<f64> = colour.iter().map(|p| p.0).chain(opacity.iter().map(|p| p.0)).collect();
    places.sort_by(f64::total_cmp);
    places.dedup();
    let mut points = Vec::new();
    for value in places {
        let [c_below, c_at] = around(colour, value);
        let [[a_below], [a_at]] = around(opacity, value);
        let at = Point {
            value,
            colour: c_at,
            opacity: a_at,
        };
        if (c_below, a_below) != (c_at, a_at) {
            points.push(Point {
                value,
                colour: c_below,
                opacity: a_below,
            });
        }
        points.push(at);
    }
    points
}
