//! Classification of the segment between two samples.
//!
//! Source: Engel, Kraus, Ertl, "High-Quality Pre-Integrated Volume Rendering Using Hardware-Accelerated Pixel Shading", 2001,
//! equations 5 and 6, with the self-attenuation that the paper leaves out afterwards:
//!
//! ```text
//! s(t)    = s_front + t (s_back - s_front)          t from 0 to 1: the field is linear in between
//! tau(s)  = min(16 / r, -ln(1 - opacity(s)) / unit distance)      r: the smallest spacing
//! depth   = d int tau(s(t)) dt                      d: length of the segment
//! opacity = 1 - exp(-depth)
//! colour  = int tau c dt / int tau dt               mixed, not ordered
//! ```
//!
//! The bound on the extinction belongs to the definition (docs/contract/integral.md): an opacity of 1 would be infinite.
//!
//! [`Bins`] are what a table can hold of this: the integrals up to the edges of codes, straight in between, and no segment
//! shorter than a code. What separates them from the above is the error of the table; what separates a pipeline from them is
//! that of its arithmetic.
//!
//! The transfer function is cut at its points. On a straight piece the integrand is a logarithm of a straight line, which is
//! smooth but near an opacity of 1; there it is cut once more, so that transparency changes at most twofold within a part.
//! Gauss's rule with eight points is then right to 1e-12.

use super::classify::{Classified, Classifier};

/// Extinction per smallest spacing is at most this.
const EXTINCTION_MAX: f64 = 16.0;

/// Nodes and weights of Gauss's rule on -1 to 1; each counts for both signs.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_3),
];

/// Extinction, and extinction times red, green, blue; integrals of them over values.
type Sums = [f64; 4];

impl Classifier<'_> {
    /// Colour and opacity of the segment, one step long, between two samples in code units. `reference` is the smallest
    /// spacing.
    pub fn segment(&self, ends: [f64; 2], reference: f64) -> Classified {
        let [front, back] = ends.map(|code| self.value(code));
        let (low, high) = (front.min(back), front.max(back));
        let bound = EXTINCTION_MAX * self.unit_distance() / reference;
        let sums = if high - low > 1e-9 * (1.0 + low.abs().max(high.abs())) {
            self.over([low, high], bound).map(|sum| sum / (high - low))
        } else {
            weighted(self.as_written(ends[1]), bound)
        };
        let [extinction, colours @ ..] = sums;
        if extinction == 0.0 {
            return Classified {
                colour: self.as_written(ends[1]).colour,
                opacity: 0.0,
            };
        }
        Classified {
            colour: colours.map(|sum| sum / extinction),
            opacity: -(-extinction * self.step_in_units()).exp_m1(),
        }
    }

    /// What a table of one bin per code holds of the transfer function.
    pub fn bins(&self, reference: f64) -> Bins {
        let bound = EXTINCTION_MAX * self.unit_distance() / reference;
        let last = (BINS - 1) as f64;
        let mut sums = [0.0; 4];
        let mut nodes = vec![sums];
        for bin in 0..BINS {
            let code = bin as f64;
            // Beyond the first and the last code the function is constant.
            let inside = [(code - 0.5).max(0.0), (code + 0.5).min(last)];
            let [a, b] = inside.map(|code| self.value(code));
            let (low, high) = (a.min(b), a.max(b));
            let mean = self.over([low, high], bound).map(|sum| sum / (high - low));
            let outside = weighted(self.as_written(code), bound);
            let share = inside[1] - inside[0];
            for ((sum, mean), outside) in sums.iter_mut().zip(mean).zip(outside) {
                *sum += mean * share + outside * (1.0 - share);
            }
            nodes.push(sums);
        }
        Bins {
            nodes,
            step_in_units: self.step_in_units(),
        }
    }

    /// Integrals from one data value to another.
    fn over(&self, [low, high]: [f64; 2], bound: f64) -> Sums {
        let corners = self.corners().filter(|value| low < *value && *value < high);
        let mut sums = [0.0; 4];
        let mut from = low;
        for to in corners.chain([high]) {
            if to > from {
                let inside = (from + to) / 2.0;
                let piece = |value: f64| self.on_piece_of(inside, value);
                for (sum, part) in sums.iter_mut().zip(straight([from, to], &piece, bound)) {
                    *sum += part;
                }
                from = to;
            }
        }
        sums
    }
}

/// Bins of a table.
const BINS: usize = 4096;

/// The integrals of a transfer function up to the edges of codes: bin n reaches from n - 1/2 to n + 1/2.
#[derive(Clone, Debug, PartialEq)]
pub struct Bins {
    nodes: Vec<Sums>,
    step_in_units: f64,
}

impl Bins {
    /// Colour and opacity of the segment, one step long, between two samples in code units: of at least one bin about its
    /// middle.
    pub fn segment(&self, ends: [f64; 2]) -> Classified {
        let [front, back] = ends.map(|code| code + 0.5);
        let (mut low, mut high) = (front.min(back), front.max(back));
        if high - low < 1.0 {
            low = ((low + high) / 2.0 - 0.5).clamp(0.0, (BINS - 1) as f64);
            high = low + 1.0;
        }
        let (from, to) = (self.up_to(low), self.up_to(high));
        self.classified([0, 1, 2, 3].map(|n| (to[n] - from[n]) / (high - low)))
    }

    /// Colour and opacity by the means over a step.
    fn classified(&self, [extinction, colours @ ..]: Sums) -> Classified {
        if extinction == 0.0 {
            return Classified::CLEAR;
        }
        Classified {
            colour: colours.map(|sum| sum / extinction),
            opacity: -(-extinction * self.step_in_units).exp_m1(),
        }
    }

    /// Colour and opacity of a part of such a segment, between two of its places, 0 at the front sample and 1 at the back one:
    /// of the integrals between its values, or a share of what is looked up as a bin.
    pub fn part(&self, ends: [f64; 2], [from, to]: [f64; 2]) -> Classified {
        let [front, back] = ends;
        let difference = (back - front).abs();
        if difference < 1.0 {
            return self.segment(ends).shared(to - from);
        }
        let up_to = |t: f64| self.up_to(front + (back - front) * t + 0.5);
        let (a, b) = (up_to(from), up_to(to));
        self.classified([0, 1, 2, 3].map(|n| (b[n] - a[n]).abs() / difference))
    }

    /// Integrals up to a place, in codes from the lower edge of the first bin.
    fn up_to(&self, place: f64) -> Sums {
        let bin = (place.floor() as usize).min(BINS - 1);
        let share = place - bin as f64;
        let (a, b) = (self.nodes[bin], self.nodes[bin + 1]);
        [0, 1, 2, 3].map(|n| a[n] + (b[n] - a[n]) * share)
    }
}

/// Extinction per unit distance, at most `bound`, alone and times each colour.
fn weighted(Classified { colour, opacity }: Classified, bound: f64) -> Sums {
    let extinction = if opacity < 1.0 {
        (-(-opacity).ln_1p()).min(bound)
    } else {
        bound
    };
    let [red, green, blue] = colour.map(|c| c * extinction);
    [extinction, red, green, blue]
}

/// Integrals over a straight piece of the transfer function.
fn straight([from, to]: [f64; 2], piece: &dyn Fn(f64) -> Classified, bound: f64) -> Sums {
    let (mut low, mut high) = (from, to);
    let mut sums = [0.0; 4];
    let mut add = |a: f64, b: f64| {
        let (middle, half) = ((a + b) / 2.0, (b - a) / 2.0);
        for (node, weight) in GAUSS {
            for place in [middle - half * node, middle + half * node] {
                for (sum, part) in sums.iter_mut().zip(weighted(piece(place), bound)) {
                    *sum += weight * half * part;
                }
            }
        }
    };
    let left = |value: f64| 1.0 - piece(value).opacity;
    let least = (-bound).exp();
    // Halves the transparency towards the end that has less of it.
    loop {
        let (at_low, at_high) = (left(low), left(high));
        let (less, more) = (at_low.min(at_high), at_low.max(at_high));
        if less >= more / 2.0 || more <= least {
            add(low, high);
            return sums;
        }
        let cut = low + (high - low) * (more / 2.0 - at_low) / (at_high - at_low);
        if cut <= low || cut >= high {
            add(low, high);
            return sums;
        }
        if at_low > at_high {
            add(low, cut);
            low = cut;
        } else {
            add(cut, high);
            high = cut;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slicecast_scene::{Point, TransferFunction};
    use slicecast_volume::Mapping;

    const CODES: Mapping = Mapping {
        scale: 1.0,
        offset: 0.0,
    };

    fn transfer(points: &[(f64, [f64; 3], f64)]) -> TransferFunction {
        let point = |&(value, colour, opacity): &(f64, [f64; 3], f64)| Point { value, colour, opacity };
        TransferFunction {
            unit_distance: 2.0,
            points: points.iter().map(point).collect(),
        }
    }

    const WHITE: [f64; 3] = [1.0; 3];
    const RED: [f64; 3] = [1.0, 0.0, 0.0];
    const BLUE: [f64; 3] = [0.0, 0.0, 1.0];

    /// Where nothing changes, a segment is a point.
    #[test]
    fn equal_samples_are_a_point() {
        let ramp = transfer(&[(0.0, RED, 0.0), (4000.0, BLUE, 0.9)]);
        let classifier = Classifier::new(&ramp, CODES, 0.7);
        for code in [0.0, 1.0, 1234.5, 4000.0, 4095.0] {
            let (segment, point) = (classifier.segment([code; 2], 1.0), classifier.classify(code));
            assert!((segment.opacity - point.opacity).abs() < 1e-15, "{code}");
            // And nothing jumps where a segment begins to have a length.
            let near = classifier.segment([code, code + 1e-6], 1.0);
            assert!((near.opacity - point.opacity).abs() < 1e-9, "{code}");
        }
    }

    /// A rising opacity a: int -ln(1 - x) dx from 0 to a is (1 - a) ln(1 - a) + a, up to 1, where it is 1.
    #[test]
    fn a_ramp_is_its_closed_form() {
        for a in [1e-9, 0.1, 0.5, 0.9, 0.999_999, 1.0] {
            let ramp = transfer(&[(1000.0, WHITE, 0.0), (2000.0, WHITE, a)]);
            let rest: f64 = 1.0 - a;
            let exact = if a < 1e-6 {
                a / 2.0
            } else if rest > 0.0 {
                (rest * rest.ln() + a) / a
            } else {
                1.0
            };
            for ends in [[1000.0, 2000.0], [2000.0, 1000.0]] {
                let got = Classifier::new(&ramp, CODES, 2.0).segment(ends, 0.01);
                let depth = -(-got.opacity).ln_1p();
                assert!((depth / exact - 1.0).abs() < 1e-7, "{a}: {depth} {exact}");
                assert_eq!(got.colour, WHITE);
            }
        }
    }

    /// Depths of the parts of a segment add up to that of the whole, in proportion to their lengths.
    #[test]
    fn parts_add_up() {
        let comb = transfer(&[
            (10.0, RED, 0.0),
            (11.0, RED, 1.0),
            (11.0, BLUE, 0.2),
            (40.0, WHITE, 0.7),
            (41.0, WHITE, 0.0),
        ]);
        let sums = |a: f64, b: f64| {
            let classifier = Classifier::new(&comb, CODES, 1.0);
            let Classified { colour, opacity } = classifier.segment([a, b], 1.0);
            let depth = -(-opacity).ln_1p() * (b - a);
            [depth, depth * colour[0], depth * colour[1], depth * colour[2]]
        };
        let whole = sums(3.0, 90.0);
        let mut parts = [0.0; 4];
        for [a, b] in [[3.0, 10.5], [10.5, 11.0], [11.0, 25.0], [25.0, 40.25], [40.25, 90.0]] {
            parts.iter_mut().zip(sums(a, b)).for_each(|(sum, part)| *sum += part);
        }
        for (whole, parts) in whole.iter().zip(parts) {
            assert!((whole - parts).abs() < 1e-9 * whole, "{whole} {parts}");
        }
    }

    /// Where edges lie half-way between codes and segments end there, bins hold all; equal samples read the mean of a code, and
    /// segments of less than a code are widened to one.
    #[test]
    fn bins_are_means_over_codes() {
        let edges = transfer(&[
            (9.5, RED, 0.0),
            (9.5, RED, 0.6),
            (12.5, RED, 0.6),
            (12.5, BLUE, 0.3),
            (20.5, BLUE, 0.3),
            (20.5, BLUE, 0.0),
        ]);
        let classifier = Classifier::new(&edges, CODES, 0.7);
        let bins = classifier.bins(1.0);
        let depth = |opacity: f64| -(-opacity).ln_1p();
        for ends in [[0.5, 9.5], [8.5, 30.5], [9.5, 10.5], [20.5, 10.5], [11.5, 4000.5]] {
            let (held, exact) = (bins.segment(ends), classifier.segment(ends, 1.0));
            assert!((held.opacity - exact.opacity).abs() < 1e-12, "{ends:?}");
            if exact.opacity > 0.0 {
                for (a, b) in held.colour.iter().zip(exact.colour) {
                    assert!((a - b).abs() < 1e-12, "{ends:?}");
                }
            }
        }
        // Half of the red of code 10 beside an edge at its middle; all of it at the code.
        let (at, beside) = (bins.segment([10.0; 2]), bins.segment([9.5; 2]));
        assert!((depth(beside.opacity) / depth(at.opacity) - 0.5).abs() < 1e-12);
        let near = bins.segment([9.4, 9.6]);
        assert!((near.opacity - beside.opacity).abs() < 1e-12);
        assert_eq!(bins.segment([8.0, 8.9]).opacity, 0.0);
        // Both ends of the table, where the function is constant.
        let fog = transfer(&[(0.0, RED, 0.2), (1.0, RED, 0.4)]);
        let classifier = Classifier::new(&fog, CODES, 2.0);
        let bins = classifier.bins(1.0);
        assert!((depth(bins.segment([4095.0; 2]).opacity) - depth(0.4)).abs() < 1e-12);
        let first = (depth(0.2) + depth(classifier.segment([0.0, 0.5], 1.0).opacity)) / 2.0;
        assert!((depth(bins.segment([0.0; 2]).opacity) - first).abs() < 1e-9);
    }

    /// Opaque material is 16 per smallest spacing, half a segment of it 8.
    #[test]
    fn opaque_material_is_bounded() {
        let step = transfer(&[(500.0, RED, 0.0), (500.0, BLUE, 1.0)]);
        let classifier = Classifier::new(&step, CODES, 0.5);
        for (ends, share) in [([600.0, 700.0], 1.0), ([450.0, 550.0], 0.5), ([400.0, 450.0], 0.0)] {
            let got = classifier.segment(ends, 0.5);
            let exact = -f64::exp_m1(-16.0 * share);
            assert!((got.opacity - exact).abs() < 1e-12, "{ends:?} {}", got.opacity);
            if share > 0.0 {
                assert_eq!(got.colour, BLUE);
            }
        }
    }
}
