//! Local error of every stage: its output against `slicecast_sim`'s f64 model on the same, already rounded inputs.

use slicecast::composite::{Channel, PixelRow, Recurrence};
use slicecast::format::Unit;
use slicecast::locate::Plane;
use slicecast::plan::Plan;
use slicecast::plane::Pipeline;
use slicecast::precision::Precision;
use slicecast::shade::Phong;
use slicecast::slice::Slice;
use slicecast::tap::{Beam, Tap};
use slicecast_sim::engine::{Prepared, fold_tiles, new_image};
use slicecast_sim::model::gradient::{difference_at, normalise};
use slicecast_sim::model::grid::Grid;
use slicecast_sim::model::interpolate::value_at;
use slicecast_sim::model::shade::{Lights, ResolvedLight};
use slicecast_sim::model::{Lattice, Model, Positions};
use slicecast_sim::oriented::with_slices;
use slicecast_sim::pipelines::Job;
use slicecast_sim::scene::{Highlight, PrecisionName, Scene};
use slicecast_sim::volume::Volume;

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Position of a plane, against the exact sum.
    Location,
    /// Sample, against the value at the stored position.
    Interpolation,
    /// Opacity, against the transfer function at the stored sample, corrected for the step.
    Opacity,
    /// Colour, against the transfer function at the stored sample.
    Colour,
    /// Gradient, against the interpolated differences of the voxels at the stored position.
    Gradient,
    /// Direction, against the stored gradient's.
    Normal,
    /// Shaded colour, against Phong on the stored normal and colour.
    Shading,
    /// Transparency, against `T (1 - a)`.
    Transparency,
    /// Pixel colour, against `C + c (T before - T after)`, for `Paper` against `C + c a T`.
    PixelColour,
}

impl Quantity {
    /// All of them, in order.
    pub const ALL: [Self; 9] = [
        Self::Location,
        Self::Interpolation,
        Self::Opacity,
        Self::Colour,
        Self::Gradient,
        Self::Normal,
        Self::Shading,
        Self::Transparency,
        Self::PixelColour,
    ];
}

/// The largest error of each quantity, in units of the last place of its own format.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Worst {
    max: [f64; Quantity::ALL.len()],
    count: [u64; Quantity::ALL.len()],
}

impl Worst {
    /// The largest error, or `None` if nothing was measured.
    pub fn of(&self, quantity: Quantity) -> Option<f64> {
        let index = quantity as usize;
        (self.count[index] > 0).then_some(self.max[index])
    }

    /// The larger errors of both.
    #[must_use]
    pub fn and(mut self, other: &Self) -> Self {
        for index in 0..self.max.len() {
            self.max[index] = self.max[index].max(other.max[index]);
            self.count[index] += other.count[index];
        }
        self
    }

    fn note(&mut self, quantity: Quantity, found: f64, exact: f64) {
        let error = (found - exact).abs();
        let max = &mut self.max[quantity as usize];
        // NaN counts as the worst.
        if error > *max || error.is_nan() {
            *max = error;
        }
        self.count[quantity as usize] += 1;
    }
}

/// The rounded lights of a pipeline as the model has them; its coefficients stay beside them, a channel each.
struct RoundedLights {
    model: Lights,
    phong: Phong,
}

fn value(v: [Unit; 3]) -> [f64; 3] {
    v.map(|c| f64::from(c.to_bits()) / 32768.0)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl RoundedLights {
    fn new(phong: &Phong, exponent_log2: u32, highlight: Highlight) -> Self {
        let viewer = value(phong.viewer());
        let resolve = |light: &slicecast::shade::Light| ResolvedLight {
            direction: value(light.direction),
            half: value(light.half),
            viewer_dot: dot(viewer, value(light.direction)),
            colour: [1.0; 3],
        };
        Self {
            model: Lights {
                ambient: 0.0,
                diffuse: 0.0,
                specular: 0.0,
                exponent_log2,
                highlight,
                viewer,
                lights: phong.lights().iter().map(resolve).collect(),
            },
            phong: phong.clone(),
        }
    }

    fn shade(&self, normal: [f64; 3], colour: [f64; 3]) -> [f64; 3] {
        let terms: Vec<_> = self.model.lights.iter().map(|l| self.model.terms(l, normal)).collect();
        [0, 1, 2].map(|c| {
            let k = |k: slicecast::format::Intensity| f64::from(k.to_bits()) / 32768.0;
            let (mut coloured, mut highlight) = (k(self.phong.ambient()[c]), 0.0);
            for (light, terms) in self.phong.lights().iter().zip(&terms) {
                coloured += k(light.diffuse[c]) * terms.diffuse;
                highlight += k(light.specular[c]) * terms.specular;
            }
            (colour[c] * coloured.min(1.0) + highlight).min(1.0)
        })
    }
}

/// What all tiles share.
struct Judge<'a> {
    model: &'a Model<'a>,
    grid: &'a Grid<'a>,
    lattice: Lattice,
    plan: &'a Plan,
    lights: Option<RoundedLights>,
    sample_bits: u32,
    floor: f64,
    telescoping: bool,
}

/// The tap: errors so far, and the stages' outputs that the next stages take in.
struct Measure<'a> {
    judge: &'a Judge<'a>,
    worst: Worst,
    row_column: u32,
    opacities: Vec<i32>,
    samples: Vec<i32>,
    colours: Vec<[i32; 3]>,
    gradients: Vec<[i32; 3]>,
    normals: Vec<[f64; 3]>,
    pixels: Vec<[f64; 4]>,
}

fn columns(rows: [&[i32]; 3]) -> impl Iterator<Item = [i32; 3]> {
    let [a, b, c] = rows;
    a.iter().zip(b).zip(c).map(|((a, b), c)| [*a, *b, *c])
}

impl Measure<'_> {
    /// The stored position of the sample in a column.
    fn position(&self, at: Beam<'_>, offset: usize) -> [f64; 3] {
        let Plane { x, y, z, .. } = at.plane;
        let [x, y, z] = [x, y, z].map(|p| f64::from(p.to_bits()) / 65536.0);
        [x + f64::from(at.column) + offset as f64, y + f64::from(at.row), z]
    }
}

impl Tap for Measure<'_> {
    fn plane(&mut self, plane: &Plane) {
        let Judge { model, lattice, .. } = self.judge;
        let [u, v] = [plane.phase.u, plane.phase.v].map(|p| p as usize);
        let exact = model.geometry().position(*lattice, plane.index as usize, u, v);
        for (found, exact) in [plane.x, plane.y, plane.z].into_iter().zip(exact) {
            self.worst
                .note(Quantity::Location, f64::from(found.to_bits()), exact * 65536.0);
        }
    }

    fn samples(&mut self, at: Beam<'_>, samples: &[i32]) {
        let unit = f64::from(1u32 << self.judge.sample_bits);
        for (n, s) in samples.iter().enumerate() {
            let exact = value_at(self.judge.grid, self.position(at, n));
            self.worst.note(Quantity::Interpolation, f64::from(*s), exact * unit);
        }
        self.row_column = at.column;
        self.samples = samples.to_vec();
    }

    fn opacities(&mut self, _: Beam<'_>, opacities: &[i32]) {
        let unit = f64::from(1u32 << self.judge.sample_bits);
        for (a, s) in opacities.iter().zip(&self.samples) {
            let exact = self.judge.model.classify(f64::from(*s) / unit).opacity;
            self.worst
                .note(Quantity::Opacity, f64::from(*a as u32), exact * 2f64.powi(31));
        }
        self.opacities = opacities.to_vec();
    }

    fn colours(&mut self, at: Beam<'_>, colours: [&[i32]; 3]) {
        self.colours = columns(colours).collect();
        let unit = f64::from(1u32 << self.judge.sample_bits);
        let start = (at.column - self.row_column) as usize;
        for (found, s) in self.colours.iter().zip(&self.samples[start..]) {
            let exact = self.judge.model.classify(f64::from(*s) / unit).colour;
            for (c, e) in found.iter().zip(exact) {
                self.worst.note(Quantity::Colour, f64::from(*c), e * 32768.0);
            }
        }
    }

    fn gradients(&mut self, at: Beam<'_>, gradients: [&[i32]; 3]) {
        self.gradients = columns(gradients).collect();
        let unit = f64::from(1u32 << self.judge.sample_bits);
        let factors = self.judge.plan.spacing().map(|f| f64::from(f.to_bits()) / 32768.0);
        for (n, g) in self.gradients.iter().enumerate() {
            let exact = difference_at(self.judge.grid, self.position(at, n));
            for a in 0..3 {
                let exact = exact[a] * factors[a] * unit;
                self.worst.note(Quantity::Gradient, f64::from(g[a]), exact);
            }
        }
    }

    fn normals(&mut self, _: Beam<'_>, g: [&[i32]; 3], r: &[i32]) {
        let found = |(g, r): ([i32; 3], &i32)| g.map(|c| -f64::from(c) * f64::from(*r) / 2f64.powi(35));
        self.normals = columns(g).zip(r).map(found).collect();
        for (n, gradient) in self.normals.iter().zip(&self.gradients) {
            for (n, e) in n.iter().zip(normalise(gradient.map(f64::from))) {
                self.worst.note(Quantity::Normal, n * 32768.0, e * 32768.0);
            }
        }
    }

    fn shaded(&mut self, _: Beam<'_>, colours: [&[i32]; 3]) {
        let Some(lights) = &self.judge.lights else { return };
        let shaded: Vec<_> = columns(colours).collect();
        for ((found, normal), colour) in shaded.iter().zip(&self.normals).zip(&self.colours) {
            let exact = lights.shade(*normal, colour.map(|c| f64::from(c) / 32768.0));
            for (f, e) in found.iter().zip(exact) {
                self.worst.note(Quantity::Shading, f64::from(*f), e * 32768.0);
            }
        }
        self.colours = shaded;
    }

    fn before<C: Channel>(&mut self, _: Beam<'_>, pixels: &PixelRow<'_, C>) {
        self.pixels = pixel_columns(pixels);
    }

    fn after<C: Channel>(&mut self, at: Beam<'_>, pixels: &PixelRow<'_, C>) {
        let start = (at.column - self.row_column) as usize;
        for (n, after) in pixel_columns(pixels).into_iter().enumerate() {
            let a = f64::from(self.opacities[start + n] as u32) / 2f64.powi(31);
            let [cr, cg, cb, t] = self.pixels[n];
            let exact = t * (1.0 - a);
            // Below a floor of more than one unit, 0 is right as well, and the light taken is then not what is missing.
            let settled = self.judge.floor > 1.0 && exact < self.judge.floor && after[3] == 0.0;
            let exact_or_settled = if settled { 0.0 } else { exact };
            self.worst.note(Quantity::Transparency, after[3], exact_or_settled);
            let taken = if self.judge.telescoping && !settled {
                t - after[3]
            } else {
                t * a
            };
            for (c, before) in [cr, cg, cb].into_iter().enumerate() {
                let colour = f64::from(self.colours[n][c]) / 32768.0;
                self.worst
                    .note(Quantity::PixelColour, after[c], before + colour * taken);
            }
        }
    }
}

fn pixel_columns<C: Channel>(pixels: &PixelRow<'_, C>) -> Vec<[f64; 4]> {
    let [r, g, b] = &pixels.colour;
    let t = &pixels.transparency;
    (0..t.len())
        .map(|n| [r[n], g[n], b[n], t[n]].map(|c| f64::from(c.bits())))
        .collect()
}

/// The worst local errors of a scene on a volume.
///
/// # Panics
/// If the engine refuses the scene.
pub fn worst(scene: &Scene, volume: &Volume) -> Worst {
    struct Run<'a>(&'a Prepared<'a>, &'a Model<'a>, &'a [Slice<'a>]);
    impl Job for Run<'_> {
        type Output = Worst;

        fn run<L: Pipeline>(self, pipeline: &L) -> Worst {
            let Self(prepared, model, slices) = self;
            let plan = &prepared.setup.plan;
            let lighting = prepared.scene.lighting.as_ref().zip(prepared.setup.phong.as_ref());
            let judge = Judge {
                model,
                grid: model.grid(),
                lattice: model.lattice(),
                plan,
                lights: lighting.map(|(l, phong)| RoundedLights::new(phong, l.exponent_log2, l.highlight)),
                sample_bits: L::Precision::SAMPLE_BITS,
                floor: f64::from(<<L::Precision as Precision>::Pixel as Recurrence>::FLOOR.bits()),
                telescoping: prepared.scene.precision != PrecisionName::Paper,
            };
            let mut image = new_image::<L>(plan).expect("a small image");
            let taps = fold_tiles(plan, pipeline, slices, &mut image, 16, &|_, _| (), |_| Measure {
                judge: &judge,
                worst: Worst::default(),
                row_column: 0,
                opacities: Vec::new(),
                samples: Vec::new(),
                colours: Vec::new(),
                gradients: Vec::new(),
                normals: Vec::new(),
                pixels: Vec::new(),
            });
            taps.iter().fold(Worst::default(), |all, tap| all.and(&tap.worst))
        }
    }
    let prepared = Prepared::new(scene, volume).expect("a scene that the pipeline takes");
    let plan = &prepared.setup.plan;
    let lattice = Lattice {
        origin: plan.origin().map(i64::from),
        size: plan.base().map(|side| (side * plan.sampling().rays_per_voxel) as usize),
    };
    let model = Model::new(scene, volume, lattice, Positions::Exact);
    with_slices(volume, plan.view(), |slices| {
        prepared.dispatch(Run(&prepared, &model, slices))
    })
    .expect("12 bits")
}
