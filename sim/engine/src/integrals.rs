//! Transfer functions compiled to cumulative integrals (`slicecast::integral`).
//!
//! Extinction is `-ln(1 - opacity)` per unit distance, at most 16 per reference length (the smallest spacing); a code's bin
//! reaches half a code to either side, and beyond the first and the last code the function is constant. Each bin is cut at
//! the transfer function's points and integrated by Gauss's rule on each part. Nodes are rounded as sums, not as increments,
//! under the largest exponent that holds the last.

use slicecast::integral::{Colours, EXPONENTS, EXTINCTION_MAX, GRAINS, Integral, Length, NODE_MAX, nodes};
use slicecast::table::ENTRIES;
use slicecast_scene::TransferFunction;
use slicecast_volume::{Mapping, Volume};

/// A classifier that owns its lists.
pub type Integrals = Integral<Nodes>;

/// A list of nodes that frames of the same table share.
#[derive(Clone, Debug)]
pub struct Nodes(std::sync::Arc<[u32]>);

impl AsRef<[u32]> for Nodes {
    fn as_ref(&self) -> &[u32] {
        &self.0
    }
}

impl From<Vec<u32>> for Nodes {
    fn from(list: Vec<u32>) -> Self {
        Self(list.into())
    }
}

/// A transfer function's integrals: all that a table holds, whatever the view.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cumulative {
    /// Integrals of extinction.
    pub extinction: Vec<u32>,
    /// Integrals of extinction times a colour, or the colour of all values.
    pub colours: Colours<Vec<u32>>,
    /// log2 of the codes of a bin.
    pub grain: u32,
    /// log2 of what the integrals were multiplied by.
    pub exponent: u32,
}

impl Cumulative {
    /// The integrals of a scene's transfer function on a volume, for bins of 2^`grain` codes.
    ///
    /// # Panics
    /// As [`Cumulative::compile`].
    pub fn of(transfer: &TransferFunction, volume: &Volume, grain: u32) -> Self {
        let reference = volume.spacing.iter().copied().fold(f64::INFINITY, f64::min);
        Self::compile(transfer, &volume.mapping, reference, grain)
    }

    /// Compiles a transfer function for bins of 2^`grain` codes. `reference` is the smallest spacing, in its unit.
    ///
    /// # Panics
    /// If core has no bins of that many codes.
    pub fn compile(transfer: &TransferFunction, mapping: &Mapping, reference: f64, grain: u32) -> Self {
        assert!(GRAINS.contains(&grain), "bins of 2^{grain} codes");
        let sums = sums(transfer, mapping, reference, grain);
        let total = sums.last().map_or(0.0, |sums| sums[0]);
        let fits = |exponent: &u32| total * f64::from(*exponent).exp2() <= f64::from(NODE_MAX);
        let exponent = EXPONENTS.rev().find(fits).unwrap_or(*EXPONENTS.start());
        let list = |channel: usize| -> Vec<u32> {
            let node = |sums: &[f64; 4]| (sums[channel] * f64::from(exponent).exp2()).round() as u32;
            sums.iter().map(node).collect()
        };
        let first = transfer.points.first().map_or([0.0; 3], |point| point.colour);
        Self {
            extinction: list(0),
            colours: if transfer.points.iter().all(|point| point.colour == first) {
                Colours::One(first.map(|c| (c * 2_147_483_648.0).round() as u32))
            } else {
                Colours::Each([list(1), list(2), list(3)])
            },
            grain,
            exponent,
        }
    }

    /// The classifier for segments of a length, in reference lengths.
    ///
    /// # Panics
    /// Never: [`Cumulative::compile`] and [`Length::of`] keep core's ranges.
    pub fn classifier(self, length: Length) -> Integrals {
        let colours = match self.colours {
            Colours::One(colour) => Colours::One(colour),
            Colours::Each(lists) => Colours::Each(lists.map(Nodes::from)),
        };
        Integral::new(self.extinction.into(), colours, self.grain, self.exponent, length)
            .unwrap_or_else(|error| unreachable!("{error}"))
    }

    /// Bytes of the lists.
    pub fn bytes(&self) -> usize {
        let lists = match self.colours {
            Colours::One(_) => 1,
            Colours::Each(_) => 4,
        };
        4 * lists * self.extinction.len()
    }
}

/// Integrals of extinction and of extinction times red, green, blue up to each node, over codes.
fn sums(transfer: &TransferFunction, mapping: &Mapping, reference: f64, grain: u32) -> Vec<[f64; 4]> {
    let per_reference = reference / transfer.unit_distance;
    let at = |code: f64| {
        let (colour, opacity) = transfer.evaluate(mapping.value(code.clamp(0.0, (ENTRIES - 1) as f64)));
        let tau = (-(-opacity).ln_1p() * per_reference).min(f64::from(EXTINCTION_MAX));
        [tau, tau * colour[0], tau * colour[1], tau * colour[2]]
    };
    let mut corners: Vec<f64> = (transfer.points.iter())
        .map(|point| (point.value - mapping.offset) / mapping.scale)
        .collect();
    corners.sort_by(f64::total_cmp);
    let mut sum = [0.0; 4];
    let mut sums = Vec::with_capacity(nodes(grain));
    sums.push(sum);
    let width = f64::from(1u32 << grain);
    for bin in 0..ENTRIES >> grain {
        let low = bin as f64 * width - 0.5;
        let high = low + width;
        let (first, end) = (
            corners.partition_point(|corner| *corner <= low),
            corners.partition_point(|corner| *corner < high),
        );
        let mut from = low;
        for to in corners[first..end.max(first)].iter().copied().chain([high]) {
            // Where extinction is steep or cut, a single part would not do.
            for part in 0..PARTS {
                let place = |part: usize| from + (to - from) * part as f64 / PARTS as f64;
                for (sum, part) in sum.iter_mut().zip(gauss(place(part), place(part + 1), &at)) {
                    *sum += part;
                }
            }
            from = to;
        }
        sums.push(sum);
    }
    sums
}

/// Parts that a straight piece of the transfer function is cut into within a bin.
const PARTS: usize = 4;

/// Gauss's rule with three points.
fn gauss(from: f64, to: f64, at: &impl Fn(f64) -> [f64; 4]) -> [f64; 4] {
    let (middle, half) = ((from + to) / 2.0, (to - from) / 2.0);
    let away = half * 0.6_f64.sqrt();
    let [a, b, c] = [middle - away, middle, middle + away].map(at);
    [0, 1, 2, 3].map(|n| (5.0 * (a[n] + c[n]) + 8.0 * b[n]) * half / 9.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;
    use slicecast::classify::{Classifier, Slab};
    use slicecast::integral::LENGTH_BITS;
    use slicecast::lanes::{Kernel, Lanes};
    use slicecast::precision::{Compact, Precision, Wide};
    use slicecast_scene::Point;

    use crate::simd::{OverLanes, Simd, with_lanes};

    const CODES: Mapping = Mapping {
        scale: 1.0,
        offset: 0.0,
    };

    fn transfer(points: &[(f64, [f64; 3], f64)]) -> TransferFunction {
        let point = |&(value, colour, opacity)| Point { value, colour, opacity };
        TransferFunction {
            unit_distance: 2.0,
            points: points.iter().map(point).collect(),
        }
    }

    /// A ramp to opaque: int -ln(1 - x) dx from 0 to a is (1 - a) ln(1 - a) + a, here over 1000 codes, half of it per reference
    /// length.
    #[test]
    fn a_ramp_is_its_closed_form() {
        let white = [1.0; 3];
        let made = Cumulative::compile(
            &transfer(&[(1000.0, white, 0.0), (2000.0, white, 0.9), (2000.0, white, 0.0)]),
            &CODES,
            1.0,
            0,
        );
        let exact = 500.0 / 0.9 * (0.1 * 0.1f64.ln() + 0.9);
        let found = f64::from(made.extinction[4096]) / f64::from(made.exponent).exp2();
        assert!((found - exact).abs() < 2e-6 * exact, "{found} {exact}");
        assert_eq!(made.colours, Colours::One([1 << 31; 3]));
        assert_eq!((made.extinction[1000], made.bytes()), (0, 4 * 4097));
        assert_eq!(made.extinction[2001], made.extinction[4096]);
    }

    #[test]
    fn opaque_is_cut_and_the_exponent_is_the_largest() {
        let opaque = Cumulative::compile(&transfer(&[(0.0, [1.0; 3], 1.0)]), &CODES, 1.0, 2);
        assert_eq!((opaque.exponent, opaque.extinction[1024]), (15, 1 << 31));
        let clear = Cumulative::compile(&transfer(&[(0.0, [1.0; 3], 0.0)]), &CODES, 1.0, 0);
        assert_eq!((clear.exponent, clear.extinction[4096]), (28, 0));
        let two = transfer(&[(0.0, [1.0; 3], 0.5), (9.0, [0.0, 1.0, 0.0], 0.5)]);
        let Colours::Each([red, green, _]) = Cumulative::compile(&two, &CODES, 1.0, 0).colours else {
            panic!("one colour of two");
        };
        assert_eq!(red[4096], red[10]);
        assert!(green[4096] > red[4096]);
    }

    fn length(reference_lengths: f64) -> Length {
        let scaled = |bits: u32| (reference_lengths * std::f64::consts::LOG2_E * f64::from(bits).exp2()).round();
        let fits = |bits: &u32| scaled(*bits) <= f64::from(u32::MAX);
        let bits = LENGTH_BITS.rev().find(fits).expect("a length that has bits");
        Length {
            scaled: scaled(bits) as u32,
            bits,
        }
    }

    struct Rows<'a, P>(P, &'a Integrals, &'a [i32], &'a [i32]);

    impl<P: Precision> OverLanes for Rows<'_, P> {
        type Output = [Vec<i32>; 4];
        fn run<V: Lanes>(self) -> Self::Output {
            V::enter(OfLanes(self, std::marker::PhantomData::<V>))
        }
    }

    struct OfLanes<'a, P, V>(Rows<'a, P>, std::marker::PhantomData<V>);

    impl<P: Precision, V: Lanes> Kernel for OfLanes<'_, P, V> {
        type Output = [Vec<i32>; 4];
        #[inline(always)]
        fn run(self) -> Self::Output {
            let Self(Rows(p, table, front, back), _) = self;
            let mut rows = [(); 4].map(|()| vec![0; front.len()]);
            let [a, r, g, b] = &mut rows;
            table.opacity_row::<V>(p, Slab::between(front, back), a);
            table.colour_row::<V>(p, Slab::between(front, back), [r, g, b]);
            rows
        }
    }

    /// Rows of every width against the definition, segment by segment.
    fn held<P: Precision>(p: P, table: &Integrals, front: &[i32], back: &[i32]) -> Result<(), TestCaseError> {
        for simd in Simd::available() {
            let rows = with_lanes(simd, Rows(p, table, front, back));
            for n in 0..front.len() {
                let ends = [front[n], back[n]];
                let [r, g, b] = table.segment_colour(p, ends).map(|c| c as i32);
                let expected = [table.segment_opacity(p, ends).to_bits() as i32, r, g, b];
                prop_assert_eq!(
                    rows.each_ref().map(|row| row[n]),
                    expected,
                    "{} {:?}",
                    simd.name(),
                    ends
                );
            }
        }
        Ok(())
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 60, rng_seed: RngSeed::Fixed(4097), failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn rows_are_the_definition(
            points in prop::collection::vec((0.0..4095.0f64, prop::array::uniform3(0.0..=1.0f64), prop_oneof![Just(0.0), 0.0..=1.0f64, Just(1.0)]), 1..9),
            one_colour in any::<bool>(),
            l in prop_oneof![0.05..3.0f64, 3.0..2000.0],
            grain in prop_oneof![Just(0u32), Just(0), Just(2)],
            ends in prop::collection::vec((0i32..=4095 << 15, -18.0..27.0f64, any::<bool>()), 1..300),
        ) {
            let mut points = points;
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            if one_colour {
                let colour = points[0].1;
                points.iter_mut().for_each(|point| point.1 = colour);
            }
            let table = Cumulative::compile(&transfer(&points), &CODES, 1.5, grain).classifier(length(l));
            let front: Vec<i32> = ends.iter().map(|end| end.0).collect();
            let back: Vec<i32> = (ends.iter())
                .map(|(front, away, up)| {
                    let away = away.exp2() as i32;
                    (if *up { front + away } else { front - away }).clamp(0, 4095 << 15)
                })
                .collect();
            held(Wide, &table, &front, &back)?;
            let [front, back] = [front, back].map(|row| row.iter().map(|s| s >> 3).collect::<Vec<_>>());
            held(Compact, &table, &front, &back)?;
        }
    }
}
