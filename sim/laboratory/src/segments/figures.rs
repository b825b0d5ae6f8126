//! Errors of each way of classification along the same rays, and times of filling tables.
//!
//! Two references, both integrated front to back in fine pieces: the piecewise-linear field between planes one voxel apart
//! (what a table of segments can be blamed for), and the trilinear field (the truth).

use std::time::Instant;

use rayon::prelude::*;
use serde::Serialize;
use slicecast::classify::Classifier as _;
use slicecast::composite::Recurrence as _;
use slicecast::integral::{LENGTH_BITS, Length};
use slicecast::precision::{Precision as _, Wide};
use slicecast_engine::integrals::{Cumulative, Integrals};
use slicecast_volume::Mapping;

use super::cases::{Case, Random, cases};
use super::function::Function;
use super::table::{Entry, Filling, Reading, Table, ordered, over, segment};

/// Step from plane to plane in voxels, along the third axis.
const STEP: [f64; 3] = [0.31, -0.22, 1.0];
/// Pieces per voxel of the trilinear reference.
const PIECES: usize = 64;
/// Codes of a piece of the piecewise-linear reference.
const FINE: f64 = 1.0;
/// Planes per voxel of post-classification.
pub const PLANES: [usize; 5] = [1, 2, 4, 8, 16];

/// Error of a way on a case, in steps of 1/255, over red, green, blue and opacity of all rays.
#[derive(Clone, Debug, Serialize)]
pub struct Error {
    /// Which way.
    pub way: String,
    /// Planes per voxel.
    pub planes: usize,
    /// Mean and maximum against the piecewise-linear field; one plane per voxel only, and not of samples.
    pub linear: Option<[f64; 2]>,
    /// Mean and maximum against the trilinear field.
    pub trilinear: [f64; 2],
    /// Planes of post-classification with the same mean error against the trilinear field, where 1 to 16 reach it.
    pub worth: Option<f64>,
}

/// Milliseconds of filling a table.
#[derive(Clone, Debug, Serialize)]
pub struct Time {
    /// Entries along a side.
    pub side: usize,
    /// In order.
    pub ordered: f64,
    /// By integral functions, attenuated.
    pub integrals: f64,
    /// By integral functions, unattenuated: the paper's quick way.
    pub unattenuated: f64,
    /// A local update in order, of the two codes in the middle: the worst that a change of so few codes can ask.
    pub local: f64,
    /// Share of the entries that the local update fills.
    pub share: f64,
}

/// The errors and times of a case.
#[derive(Clone, Debug, Serialize)]
pub struct Figures {
    /// Its name.
    pub case: &'static str,
    /// Errors.
    pub errors: Vec<Error>,
    /// Times.
    pub times: Vec<Time>,
}

/// A way of classifying segments.
enum Way<'a> {
    Exact(&'a Function),
    Formula(&'a Function, Filling),
    Table(&'a Table, Reading),
    Core(&'a Integrals),
}

impl Way<'_> {
    fn segment(&self, ends: [f64; 2], length: f64) -> Entry {
        match self {
            Way::Exact(function) => ordered(function, ends, length, FINE),
            Way::Formula(function, filling) => segment(function, *filling, ends, length),
            Way::Table(table, reading) => table.read(*reading, ends),
            Way::Core(lists) => {
                let samples = ends.map(|code| (code * f64::from(1u32 << Wide.formats().sample_bits)).round() as i32);
                let opacity = f64::from(lists.segment_opacity(Wide, samples).to_bits()) / f64::from(1u32 << 31);
                let one = f64::from(1u32 << Wide.pixel().colour_bits());
                let [r, g, b] = lists
                    .segment_colour(Wide, samples)
                    .map(|c| f64::from(c) / one * opacity);
                [r, g, b, opacity]
            }
        }
    }
}

/// The length of a segment as core takes it, in reference lengths of a voxel.
fn core_length(voxels: f64) -> Length {
    let scaled = |bits: u32| (voxels * std::f64::consts::LOG2_E * f64::from(bits).exp2()).round();
    let fits = |bits: &u32| scaled(*bits) <= f64::from(u32::MAX);
    let bits = LENGTH_BITS.rev().find(fits).unwrap_or(*LENGTH_BITS.start());
    Length {
        scaled: scaled(bits) as u32,
        bits,
    }
}

/// Codes along a ray, `parts` per voxel of depth.
fn along(case: &Case, start: [f64; 2], parts: usize) -> Vec<f64> {
    let at = |n: usize| {
        let t = n as f64 / parts as f64;
        case.at([start[0] + STEP[0] * t, start[1] + STEP[1] * t, STEP[2] * t])
    };
    (0..=(case.side() - 1) * parts).map(at).collect()
}

fn by_segments(codes: &[f64], way: &Way<'_>, length: f64) -> Entry {
    let mut sum = [0.0; 4];
    codes
        .windows(2)
        .for_each(|pair| over(&mut sum, way.segment([pair[0], pair[1]], length)));
    sum
}

/// Samples, each for half a step to either side; the ends count half.
fn by_samples(codes: &[f64], function: &Function, length: f64) -> Entry {
    let mut sum = [0.0; 4];
    for (n, code) in codes.iter().enumerate() {
        let share = if n == 0 || n + 1 == codes.len() { 0.5 } else { 1.0 };
        over(
            &mut sum,
            segment(function, Filling::Attenuated, [*code; 2], length * share),
        );
    }
    sum
}

/// Mean and maximum difference in steps of 1/255.
fn difference(found: &[Entry], expected: &[Entry]) -> [f64; 2] {
    let pairs = found.iter().flatten().zip(expected.iter().flatten());
    let [sum, most] = pairs.fold([0.0, 0.0f64], |[sum, most], (a, b)| {
        let away = 255.0 * (a - b).abs();
        [sum + away, most.max(away)]
    });
    [sum / (4 * found.len()) as f64, most]
}

/// Planes at which samples have a mean error, on a straight line between logarithms of planes and of errors.
fn worth(samples: &[(usize, f64)], mean: f64) -> Option<f64> {
    samples.windows(2).find_map(|pair| {
        let [(p, a), (q, b)] = [pair[0], pair[1]];
        if !(b..=a).contains(&mean) || b <= 0.0 || a == b {
            return None;
        }
        let t = (a / mean).ln() / (a / b).ln();
        Some(p as f64 * (q as f64 / p as f64).powf(t))
    })
}

/// All cases; `reduced` for tests: 40 rays and tables up to 128².
pub fn run(reduced: bool, progress: &(dyn Fn(usize, usize) + Sync)) -> Vec<Figures> {
    let cases = cases(reduced);
    let total = cases.len();
    let figures = cases.iter().enumerate().map(|(n, case)| {
        progress(n, total);
        of_case(case, reduced)
    });
    figures.collect()
}

/// The errors and times of one case.
pub fn of_case(case: &Case, reduced: bool) -> Figures {
    let function = Function::new(&case.transfer);
    let voxel = STEP.iter().map(|c| c * c).sum::<f64>().sqrt();
    let sides: &[usize] = if reduced {
        &[64, 128]
    } else {
        &[64, 128, 256, 512, 1024]
    };
    let mut random = Random::new(2001);
    let span = (case.side() - 1) as f64;
    let mut start = || {
        let inside = |step: f64, number: f64| {
            let travel = step * span;
            -travel.min(0.0) + number * (span - travel.abs())
        };
        [inside(STEP[0], random.number()), inside(STEP[1], random.number())]
    };
    let starts: Vec<[f64; 2]> = (0..if reduced { 40 } else { 200 }).map(|_| start()).collect();
    let rays = |parts: usize| -> Vec<Vec<f64>> { starts.par_iter().map(|start| along(case, *start, parts)).collect() };
    let all = |rays: &[Vec<f64>], way: &Way<'_>, length: f64| -> Vec<Entry> {
        rays.par_iter().map(|codes| by_segments(codes, way, length)).collect()
    };

    let single = rays(1);
    let double = rays(2);
    let linear = all(&single, &Way::Exact(&function), voxel);
    let truth = all(&rays(PIECES), &Way::Exact(&function), voxel / PIECES as f64);

    let mut errors = Vec::new();
    let mut samples = Vec::new();
    for planes in PLANES {
        let found: Vec<Entry> = (rays(planes).par_iter())
            .map(|codes| by_samples(codes, &function, voxel / planes as f64))
            .collect();
        let trilinear = difference(&found, &truth);
        samples.push((planes, trilinear[0]));
        errors.push(Error {
            way: "samples".into(),
            planes,
            linear: None,
            trilinear,
            worth: None,
        });
    }
    let mut add = |name: String, planes: usize, way: &Way<'_>| {
        let codes = if planes == 1 { &single } else { &double };
        let found = all(codes, way, voxel / planes as f64);
        let trilinear = difference(&found, &truth);
        errors.push(Error {
            way: name,
            planes,
            linear: (planes == 1).then(|| difference(&found, &linear)),
            trilinear,
            worth: worth(&samples, trilinear[0]),
        });
    };
    for planes in [1, 2] {
        add("exact segments".into(), planes, &Way::Exact(&function));
        add(
            "integrals, attenuated".into(),
            planes,
            &Way::Formula(&function, Filling::Attenuated),
        );
        add(
            "integrals, unattenuated".into(),
            planes,
            &Way::Formula(&function, Filling::Unattenuated),
        );
        for grain in [0, 2] {
            let mapping = Mapping {
                scale: 1.0,
                offset: 0.0,
            };
            let lists = Cumulative::compile(&case.transfer, &mapping, 1.0, grain);
            let lists = lists.classifier(core_length(voxel / planes as f64));
            add(
                format!("core, {} nodes", slicecast::integral::nodes(grain)),
                planes,
                &Way::Core(&lists),
            );
        }
    }
    let mut times = Vec::new();
    for &side in sides {
        let timed = |filling: Filling| {
            let begin = Instant::now();
            let table = Table::new(&function, filling, side, voxel);
            (table, begin.elapsed().as_secs_f64() * 1e3)
        };
        let [(exact, ordered), (quick, integrals)] = [Filling::Ordered, Filling::Attenuated].map(timed);
        let (paper, unattenuated) = timed(Filling::Unattenuated);
        for (reading, name) in [(Reading::Nearest, "nearest"), (Reading::Bilinear, "bilinear")] {
            add(format!("2D {side}² {name}, ordered"), 1, &Way::Table(&exact, reading));
            add(format!("2D {side}² {name}, integrals"), 1, &Way::Table(&quick, reading));
            add(
                format!("2D {side}² {name}, unattenuated"),
                1,
                &Way::Table(&paper, reading),
            );
        }
        let mut changed = exact.clone();
        let begin = Instant::now();
        let filled = changed.update(&function, 2047.0..=2048.0);
        let local = begin.elapsed().as_secs_f64() * 1e3;
        times.push(Time {
            side,
            ordered,
            integrals,
            unattenuated,
            local,
            share: filled as f64 / (side * side) as f64,
        });
    }
    Figures {
        case: case.name,
        errors,
        times,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn worth_is_read_between_planes() {
        let samples = [(1, 16.0), (2, 8.0), (4, 4.0)];
        assert_eq!(worth(&samples, 17.0), None);
        assert_eq!(worth(&samples, 3.0), None);
        assert!((worth(&samples, 16.0).unwrap_or(0.0) - 1.0).abs() < 1e-12);
        assert!((worth(&samples, 32f64.sqrt()).unwrap_or(0.0) - 8f64.sqrt()).abs() < 1e-12);
    }

    /// More planes and larger tables are nearer; attenuation counts where it is dense, and not in fog; core keeps the
    /// formula's error.
    #[test]
    fn the_ways_are_ordered() {
        let figures = run(true, &|_, _| ());
        for figures in &figures {
            let of = |way: &str, planes: usize| {
                let found = figures.errors.iter().find(|e| e.way == way && e.planes == planes);
                found.unwrap_or_else(|| panic!("no {way}"))
            };
            let linear = |way: &str| of(way, 1).linear.map_or(f64::NAN, |[mean, _]| mean);
            let name = figures.case;
            assert_eq!(linear("exact segments"), 0.0, "{name}");
            assert!(of("samples", 16).trilinear[0] < of("samples", 1).trilinear[0], "{name}");
            let [formula, core] = ["integrals, attenuated", "core, 4097 nodes"].map(linear);
            assert!((formula - core).abs() < 0.1, "{name}: {formula} {core}");
            let paper = linear("integrals, unattenuated");
            assert!(paper > formula, "{name}: {paper} {formula}");
            assert!(
                linear("2D 128² bilinear, ordered") <= linear("2D 64² nearest, ordered"),
                "{name}"
            );
        }
    }
}
