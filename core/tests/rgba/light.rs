//! Light on volumes of colours, and depth cueing, by the formulas of `docs/contract/extinction.md` in 128 bits.

use super::Volume;
use proptest::prelude::*;
use slicecast::clip::{Clips, Cue, halves};
use slicecast::extinction::Eighths;
use slicecast::format::{Coefficient, Distance, Intensity, Step, Vector, Weight};
use slicecast::gradient::space;
use slicecast::interpolate::trilinear_words;
use slicecast::normalise::{Normal, normalise};
use slicecast::plan::Plan;
use slicecast::precision::{Precision, Shading};
use slicecast::shade::{Highlight, KeptLight, Light, Phong, dot, keep, keep_vector, power, reflected};

/// Lights and material, before a precision takes what it keeps of them.
#[derive(Clone, Debug)]
pub struct Material {
    pub ambient: [Coefficient; 3],
    pub lights: Vec<Light>,
    pub viewer: [Vector; 3],
    pub highlight: Highlight,
    pub exponent_log2: u32,
}

impl Material {
    /// Ambient light of 1, and no other.
    pub fn white() -> Self {
        Self {
            ambient: [Coefficient::ONE; 3],
            lights: Vec::new(),
            viewer: [Vector::ZERO, Vector::ZERO, Vector::from_bits(-1 << 30)],
            highlight: Highlight::Reflection,
            exponent_log2: 4,
        }
    }

    pub fn phong<P: Precision>(&self, p: P) -> Phong<P> {
        Phong::new(
            p,
            self.ambient,
            &self.lights,
            self.viewer,
            self.highlight,
            self.exponent_log2,
        )
        .unwrap()
    }

    /// D and E of a channel under these lights, 1.31.
    fn sums<P: Precision>(&self, p: P, normal: Normal, channel: usize) -> [i128; 2] {
        let viewer = keep_vector(p, self.viewer);
        let compact = p.formats().shading == Shading::Rounded16;
        let (mut diffuse, mut specular) = (i128::from(keep(p, self.ambient[channel])), 0);
        if compact {
            diffuse <<= 16;
        }
        let add = |sum: &mut i128, k: u32, x: i128| {
            *sum += if compact {
                i128::from(k) * ((x + (1 << 14)) >> 15)
            } else {
                (i128::from(k) * x) >> 31
            };
        };
        for light in self.lights.iter().map(|light| KeptLight::of(p, light)) {
            let facing = dot(p, normal, light.direction);
            let base = match self.highlight {
                Highlight::Reflection => reflected(p, dot(p, normal, viewer), facing, viewer, light.direction),
                Highlight::HalfVector if facing.to_bits() > 0 => dot(p, normal, light.half),
                Highlight::HalfVector => Default::default(),
            };
            let bright = power(p, base, self.exponent_log2);
            add(&mut diffuse, light.diffuse[channel], i128::from(facing.to_bits()));
            add(&mut specular, light.specular[channel], i128::from(bright.to_bits()));
        }
        if compact {
            let m = ((diffuse + (1 << 14)) >> 15).min(1 << 16);
            [m << 15, specular.min((1 << 31) - 1)]
        } else {
            [diffuse.min(1 << 31), specular.min(1 << 31)]
        }
    }

    /// Colours times extinction under these lights.
    pub fn lit<P: Precision>(&self, p: P, normal: Normal, [t, colours @ ..]: [i64; 4]) -> [i64; 4] {
        let lit = |channel: usize| {
            let [d, e] = self.sums(p, normal, channel);
            let sum = i128::from(colours[channel]) * d + i128::from(t) * e + (1 << 30);
            ((sum >> 31) as i64).min(t)
        };
        [t, lit(0), lit(1), lit(2)]
    }
}

/// A voxel's extinction, the volume continued linearly by one voxel beyond each face.
fn continued(volume: &Volume, at: [i32; 3]) -> i32 {
    for axis in 0..3 {
        let last = volume.dims[axis] as i32 - 1;
        let beyond = |edge: i32, inner: i32| {
            let of = |c: i32| {
                let mut at = at;
                at[axis] = c;
                continued(volume, at)
            };
            2 * of(edge) - of(inner.clamp(0, last))
        };
        if at[axis] < 0 {
            return beyond(0, 1);
        }
        if at[axis] > last {
            return beyond(last, last - 1);
        }
    }
    i32::from(volume.codes(at.map(|c| c as usize))[0])
}

/// The normal at a sample with this cell.
pub fn normal<P: Precision>(p: P, plan: &Plan, volume: &Volume, index: [i32; 3], weights: [Weight; 3]) -> Normal {
    let last = volume.dims.map(|side| side as i32 - 1);
    // Behind the last voxel there is none; its weight is 0.
    let corner =
        |d: [i32; 3], at: [usize; 3]| [0, 1, 2].map(|a| (index[a] + at[a] as i32).min(last[a].max(index[a])) + d[a]);
    let sample = |value: &dyn Fn([usize; 3]) -> i32| {
        let corners = [0, 1].map(|z| [0, 1].map(|y| [0, 1].map(|x| value([x, y, z]))));
        trilinear_words(Eighths(p), corners, weights)
    };
    let beside = |axis: usize, to: i32| {
        let mut d = [0; 3];
        d[axis] = to;
        sample(&|at| continued(volume, corner(d, at)))
    };
    let along_k = sample(&|at| continued(volume, corner([0, 0, 1], at)) - continued(volume, corner([0, 0, -1], at)));
    let g = [beside(0, 1) - beside(0, -1), beside(1, 1) - beside(1, -1), along_k];
    let factors = plan.spacing();
    normalise([0, 1, 2].map(|a| space(g[a], factors[a])))
}

/// Colours times extinction as depth cueing turns them: those of a plane's sample on the ray that starts so, along i and j.
pub fn cued(
    clips: &Clips,
    colour: [Intensity; 3],
    plan: &Plan,
    start: [i64; 2],
    index: u32,
    sample: [i64; 4],
) -> [i64; 4] {
    let cue = clips.cue().unwrap();
    let depth = |h: i64| {
        let [si, sj, sk] = plan.step().map(Step::to_bits);
        let place = [2 * start[0] + h * si, 2 * start[1] + h * sj, h * sk];
        let along = |a: usize| (i128::from(cue.slope[a]) * i128::from(place[a])) >> 33;
        cue.distance + (along(0) + along(1) + along(2)) as i64
    };
    let first = halves(plan, index, false);
    let share = i64::from(cue.share([depth(first), depth(first + 2)]));
    let [t, colours @ ..] = sample;
    let turned = |k: usize| {
        let other = (t * i64::from(colour[k].to_bits()) + (1 << 14)) >> 15;
        colours[k] + (((other - colours[k]) * share + (1 << 15)) >> 16)
    };
    [t, turned(0), turned(1), turned(2)]
}

fn unit(v: [f64; 3]) -> [Vector; 3] {
    let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    v.map(|c| Vector::from_bits((c / length * 1_073_741_824.0).round() as i32))
}

/// Up to three lights of any colour, bright ones too.
pub fn materials() -> impl Strategy<Value = Material> {
    let direction =
        || prop::array::uniform3(-1.0f64..1.0).prop_filter("a direction", |v| v.iter().any(|c| c.abs() > 0.1));
    let coefficients = || {
        let coefficient = prop_oneof![Just(0u32), Just(1 << 31), 0u32..=1 << 31];
        prop_oneof![
            prop::array::uniform3(coefficient.clone()),
            coefficient.prop_map(|c| [c; 3]),
        ]
        .prop_map(|c| c.map(Coefficient::from_bits))
    };
    let light =
        (direction(), direction(), coefficients(), coefficients()).prop_map(|(l, h, diffuse, specular)| Light {
            direction: unit(l),
            half: unit(h),
            diffuse,
            specular,
        });
    let highlight = prop_oneof![Just(Highlight::Reflection), Just(Highlight::HalfVector)];
    let lights = prop::collection::vec(light, 0..=3);
    (coefficients(), lights, direction(), highlight, 0u32..=8).prop_map(
        |(ambient, lights, viewer, highlight, exponent_log2)| Material {
            ambient,
            lights,
            viewer: unit(viewer),
            highlight,
            exponent_log2,
        },
    )
}

/// Depth cueing of any slope, over depths of a fraction of a voxel to many.
pub fn cues() -> impl Strategy<Value = Cue> {
    let bits = -(1i32 << 30)..=1 << 30;
    let colour = prop::array::uniform3(0u16..=32768).prop_map(|c| c.map(Intensity::from_bits));
    (
        prop::array::uniform3(bits),
        -(3i64 << 30)..3 << 30,
        1i64 << 26..9 << 30,
        0u32..=65536,
        colour,
    )
        .prop_map(|(slope, distance, depth, most, colour)| Cue {
            slope: slope.map(Vector::from_bits),
            distance: Distance::from_bits(distance),
            depth: Distance::from_bits(depth),
            most,
            colour,
        })
}
