//! The vectors of a frame, computed once more by the second model: every stage from its own inputs, the samples and
//! gradients from the voxels themselves, and the image and the picture from what came before them.

use slicecast_vectors::frame::FrameSets;
use slicecast_vectors::set::Set;

use crate::found::Inputs;
use crate::second::{Numbers, Rays, Second, Width};

/// A frame's vectors by name.
struct Framed<'a> {
    frame: &'a FrameSets,
    second: Second,
    width: Width,
}

/// The numbers of a vector, and behind them those that the whole frame shares.
struct Known<'a>(Vec<(&'static str, i128)>, Inputs<'a>, &'a FrameSets);

impl Numbers for Known<'_> {
    fn find(&self, name: &str) -> Option<i128> {
        let own = self.0.iter().find(|(known, _)| *known == name).map(|(_, value)| *value);
        own.or_else(|| self.1.find(name)).or_else(|| constant(self.2, name))
    }
}

fn constant(frame: &FrameSets, name: &str) -> Option<i128> {
    let found = frame.constants.iter().find(|(field, _)| field.name == name)?;
    Some(found.1.into())
}

/// The first vector of a frame on which the second model gives other numbers, and how many vectors it gave.
///
/// # Panics
/// If the sets are not those of a frame.
pub fn first_departure(frame: &FrameSets, width: Width) -> (Option<String>, usize) {
    let framed = Framed {
        frame,
        second: Second::new(width, None),
        width,
    };
    let mut count = 0;
    for set in frame.sets.iter().filter(|set| !set.outputs.fields.is_empty()) {
        for index in 0..set.len() {
            let found = framed.outputs(set, index);
            let expected: Vec<i128> = set.outputs.row(index).iter().copied().map(i128::from).collect();
            if found != expected {
                let inputs = set.inputs.row(index);
                let text = format!(
                    "{} {index}, inputs {inputs:?}: {expected:?}, second model {found:?}",
                    set.name
                );
                return (Some(text), count);
            }
            count += 1;
        }
    }
    (None, count)
}

impl Framed<'_> {
    fn get(&self, name: &str) -> i128 {
        constant(self.frame, name).unwrap_or_else(|| panic!("no constant {name}"))
    }

    fn set(&self, stage: &str) -> Option<&Set> {
        self.frame.sets.iter().find(|set| set.stage == stage)
    }

    fn outputs(&self, set: &Set, index: usize) -> Vec<i128> {
        let inputs = Inputs::of(set, index);
        let place = |name| inputs.get(name);
        match set.stage {
            "location" => self.location(place("plane"), place("phase")),
            "interpolation" => self.second.outputs("interpolation", &inputs),
            "opacity" => {
                let opacity = self.classified(inputs.get("sample"))[0];
                let at = [place("column"), place("row")];
                let fraction = self.fraction(place("plane"), place("phase"), at);
                assert_eq!(fraction, inputs.get("fraction"), "the fraction at {at:?}");
                vec![self.second.of_fraction(opacity, fraction)]
            }
            "colour" => self.classified(inputs.get("sample"))[1..].to_vec(),
            "gradient" => {
                let at = [place("column"), place("row")];
                self.gradient(self.positions(place("plane"), place("phase")), at)
            }
            "normal" => self.second.outputs("normalisation", &inputs),
            "shading" => self.second.outputs("shading", &Known(Vec::new(), inputs, self.frame)),
            "compositing" => {
                let stage = if self.get("blend") == 1 {
                    "compositing-back"
                } else {
                    "compositing"
                };
                self.second.outputs(stage, &Known(Vec::new(), inputs, self.frame))
            }
            "image" => self.pixel([place("column"), place("row")]).to_vec(),
            "picture" => self.picture([place("column"), place("row")]).to_vec(),
            _ => panic!("no stage {}", set.stage),
        }
    }

    /// x, y, z of a plane and phase.
    fn positions(&self, plane: i128, phase: i128) -> [i128; 3] {
        let nearest = self.get("nearest") == 1;
        let [start_i, start_j] = self.starts(phase);
        let along = |start: i128, step: &str| match self.get("borders") {
            0 => self.second.position(start, self.get(step), plane, nearest),
            _ => self.second.middle(self.rays(start, step, plane), nearest),
        };
        let [x, y, z] = [along(start_i, "step_i"), along(start_j, "step_j"), along(0, "step_k")];
        if self.get("borders") == 0 {
            return [x, y, z];
        }
        // Held along k as a plane, along i and j pixel by pixel.
        [x, y, z.clamp(0, (self.get("side_k") - 1) << 16)]
    }

    /// Where the rays of a phase begin.
    fn starts(&self, phase: i128) -> [i128; 2] {
        let rays = self.get("rays_per_voxel");
        let start = |origin: &str, part: i128| (self.get(origin) << 32) + (2 * (part << 32) + rays) / (2 * rays);
        [start("origin_i", phase % rays), start("origin_j", phase / rays)]
    }

    /// The parts of a pixel's segment along i and j, of exact borders.
    fn part(&self, plane: i128, phase: i128, axis: usize, pixel: i128) -> [i128; 2] {
        let (step, side) = [("step_i", "side_i"), ("step_j", "side_j")][axis];
        let rays = self.rays(self.starts(phase)[axis], step, plane);
        self.second.part(rays, pixel, self.get(side))
    }

    /// Rays at a plane, along the axis of a step.
    fn rays(&self, start: i128, step: &str, plane: i128) -> Rays {
        Rays {
            start,
            step: self.get(step),
            plane,
            rate: self.get("planes_per_voxel"),
            cells: self.get("borders") == 1,
        }
    }

    /// What of a pixel's segment its sample counts for.
    fn fraction(&self, plane: i128, phase: i128, pixel: [i128; 2]) -> i128 {
        if self.get("borders") == 0 {
            return 65536;
        }
        let [i, j] = [0, 1].map(|axis| self.part(plane, phase, axis, pixel[axis]));
        (i[1].min(j[1]) - i[0].max(j[0])).max(0)
    }

    /// The pixels along an axis that have something of their segments between the faces.
    fn between(&self, plane: i128, phase: i128, axis: usize) -> [i128; 2] {
        let pixels = self.get(["columns", "rows"][axis]);
        let counts = |pixel: &i128| {
            let [from, to] = self.part(plane, phase, axis, *pixel);
            to > from
        };
        let all: Vec<i128> = (0..pixels).filter(counts).collect();
        match (all.first(), all.last()) {
            (Some(first), Some(last)) => [*first, last + 1],
            _ => [pixels, pixels],
        }
    }

    fn location(&self, plane: i128, phase: i128) -> Vec<i128> {
        let [x, y, z] = self.positions(plane, phase);
        let [columns, rows] = if self.get("borders") == 0 {
            [
                self.second.extent(x, self.get("side_i"), self.get("columns")),
                self.second.extent(y, self.get("side_j"), self.get("rows")),
            ]
        } else {
            [0, 1].map(|axis| self.between(plane, phase, axis))
        };
        [&[x, y, z][..], &columns, &rows, &self.second.dither(plane)].concat()
    }

    /// Opacity and colour of a sample.
    fn classified(&self, sample: i128) -> Vec<i128> {
        let table = self.set("table").expect("a table");
        let code = (sample >> self.width.sample_bits()) as usize;
        let entry = |prefix: &'static str, code: usize| {
            let row = Inputs::of(table, code.min(4095));
            let get = |name: &str| row.get(name);
            let names = match prefix {
                "entry" => [
                    "entry",
                    "entry_low_root",
                    "entry_low_red",
                    "entry_low_green",
                    "entry_low_blue",
                ],
                _ => [
                    "next",
                    "next_low_root",
                    "next_low_red",
                    "next_low_green",
                    "next_low_blue",
                ],
            };
            let values = [
                "entry",
                "entry_low_root",
                "entry_low_red",
                "entry_low_green",
                "entry_low_blue",
            ]
            .map(get);
            names.into_iter().zip(values)
        };
        let mut numbers: Vec<_> = entry("entry", code).chain(entry("next", code + 1)).collect();
        numbers.push(("sample", sample));
        self.second
            .outputs("classification", &Known(numbers, Inputs::of(table, code), self.frame))
    }

    /// The voxel at i, j, k, continued by one voxel beyond the faces along i and j.
    fn continued(&self, [i, j, k]: [i128; 3]) -> i128 {
        let [ni, nj, nk] = ["side_i", "side_j", "side_k"].map(|name| self.get(name));
        let voxels = self.set("voxels").expect("voxels");
        // Further away only weights of 0 reach.
        let voxel = |i: i128, j: i128| {
            let k = k.clamp(0, nk - 1);
            i128::from(voxels.inputs.values[((k * nj + j) * ni + i) as usize])
        };
        beyond(i, ni, &|i| beyond(j, nj, &|j| voxel(i, j)))
    }

    /// W at i, j, k.
    fn derivative(&self, [i, j, k]: [i128; 3]) -> i128 {
        let [ni, nj, nk] = ["side_i", "side_j", "side_k"].map(|name| self.get(name));
        let (i, j, k) = (i.clamp(0, ni - 1), j.clamp(0, nj - 1), k.clamp(0, nk - 1));
        let voxel = |k: i128| self.continued([i, j, k]);
        if nk == 1 {
            0
        } else if k == 0 {
            2 * (voxel(1) - voxel(0))
        } else if k == nk - 1 {
            2 * (voxel(k) - voxel(k - 1))
        } else {
            voxel(k + 1) - voxel(k - 1)
        }
    }

    fn gradient(&self, positions: [i128; 3], [column, row]: [i128; 2]) -> Vec<i128> {
        let mut own = [0, 1, 2].map(|axis| positions[axis] + ([column, row, 0][axis] << 16));
        if self.get("borders") != 0 {
            for (position, side) in own.iter_mut().zip(["side_i", "side_j", "side_k"]) {
                *position = (*position).clamp(0, (self.get(side) - 1) << 16);
            }
        }
        let cells = own.map(|position| position >> 16);
        let weights = own.map(|position| position & 0xffff);
        let sample = |di: i128, dj: i128, value: &dyn Fn([i128; 3]) -> i128| {
            let at = |k: usize, j: usize, i: usize| {
                value([
                    cells[0] + di + i as i128,
                    cells[1] + dj + j as i128,
                    cells[2] + k as i128,
                ])
            };
            self.second.sample(&at, weights)
        };
        let voxel = |at| self.continued(at);
        let differences = [
            sample(1, 0, &voxel) - sample(-1, 0, &voxel),
            sample(0, 1, &voxel) - sample(0, -1, &voxel),
            sample(0, 0, &|at| self.derivative(at)),
        ];
        let factors = ["factor_i", "factor_j", "factor_k"].map(|name| self.get(name));
        [0, 1, 2]
            .map(|axis| self.second.spaced(differences[axis], factors[axis]))
            .to_vec()
    }

    /// The base-plane pixel at u, v of all phases: what the last of its samples left.
    fn pixel(&self, [u, v]: [i128; 2]) -> [i128; 4] {
        let rays = self.get("rays_per_voxel");
        let (phase, at) = (v % rays * rays + u % rays, [v / rays, u / rays]);
        let here = |inputs: &[i64]| [1, 2, 3].map(|field| i128::from(inputs[field])) == [phase, at[0], at[1]];
        let blend = self.get("blend");
        let clear = [0, 0, 0, self.width.one()];
        if blend < 2 {
            let Some(set) = self.set("compositing") else {
                return clear;
            };
            let last = (0..set.len()).rev().find(|index| here(set.inputs.row(*index)));
            return last.map_or(clear, |index| {
                let row = set.outputs.row(index);
                [0, 1, 2, 3].map(|channel| row[channel].into())
            });
        }
        let Some(set) = self.set("interpolation") else {
            return clear;
        };
        let samples = (0..set.len()).filter(|index| here(set.inputs.row(*index)));
        let samples = samples.map(|index| i128::from(set.outputs.row(index)[0]));
        let kept = if blend == 2 { samples.max() } else { samples.min() };
        kept.map_or(clear, |sample| {
            let seen = self.classified(sample);
            self.second.resolved(seen[0], [seen[1], seen[2], seen[3]])
        })
    }

    fn picture(&self, [x, y]: [i128; 2]) -> [i128; 3] {
        let image = self.set("image").expect("an image");
        let rays = self.get("rays_per_voxel");
        let size = [self.get("columns") * rays, self.get("rows") * rays];
        let along = |axis: &str| {
            let map = ["warp_origin", "warp_right", "warp_down"].map(|name| self.get(&format!("{name}_{axis}")));
            let place = [
                ("origin", map[0]),
                ("right", map[1]),
                ("down", map[2]),
                ("x", x),
                ("y", y),
            ];
            let inputs = Known(place.to_vec(), Inputs::of(image, 0), self.frame);
            let found = self.second.outputs("coordinate", &inputs);
            [found[0], found[1]]
        };
        let ([u, wu], [v, wv]) = (along("u"), along("v"));
        let channel = |channel: usize, u: i128, v: i128| {
            if (0..size[0]).contains(&u) && (0..size[1]).contains(&v) {
                i128::from(image.outputs.row((v * size[0] + u) as usize)[channel])
            } else {
                [0, 0, 0, self.width.one()][channel]
            }
        };
        let mixed = [0, 1, 2, 3].map(|c| {
            let corners = [
                channel(c, u, v),
                channel(c, u + 1, v),
                channel(c, u, v + 1),
                channel(c, u + 1, v + 1),
            ];
            self.second.mixed(corners, [wu, wv])
        });
        let behind = ["background_red", "background_green", "background_blue"].map(|name| self.get(name));
        [0, 1, 2].map(|c| self.second.in_front(mixed[c], mixed[3], behind[c]))
    }
}

/// A line of `n` voxels continued by one at each end, linearly; one voxel as a constant.
fn beyond(at: i128, n: i128, line: &dyn Fn(i128) -> i128) -> i128 {
    if n == 1 {
        line(0)
    } else if at < 0 {
        2 * line(0) - line(1)
    } else if at >= n {
        2 * line(n - 1) - line(n - 2)
    } else {
        line(at)
    }
}
