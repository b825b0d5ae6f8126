//! The model beside the pipeline, plane by plane, for the rows of one tile.

use std::sync::Arc;

use slicecast::classify::opacity_of_root;
use slicecast::composite::{Channel, Recurrence};
use slicecast::format::{Coefficient, Opacity, Position, Vector};
use slicecast::locate::{Plane, cut};
use slicecast::plan::{Phase, Plan};
use slicecast::precision::{Fast, NormalForm, Precision};
use slicecast::shade::{formed, formed_nearest, keep, keep_vector};
use slicecast::sides::Side;
use slicecast::sides::along_k;
use slicecast::tap::{Beam, Bits, Tap};

use super::stages::{Stage, StageErrors};
use slicecast_engine::camera::{Material, Setup};
use slicecast_engine::tile::Tile;
use slicecast_model::gradient::normalise;
use slicecast_model::shade::{Lights, ResolvedLight};
use slicecast_model::{Classified, Left, Model, Part, Pixel, Weights, between};
use slicecast_scene::{Blend, Borders};

/// What the model knows of a sample of the current plane.
#[derive(Clone, Debug)]
struct Sample {
    value: f64,
    /// What of its segment lies in the volume.
    fraction: f64,
    /// What clip planes leave of that.
    left: Left,
    /// How far depth cueing has turned its colour.
    turned: f64,
    /// The sample, or the parts of the segment that ends at it.
    parts: Vec<Known>,
}

/// What the model knows of a part.
#[derive(Clone, Copy, Debug)]
struct Known {
    number: u32,
    opacity: f64,
    visible: Option<Visible>,
    /// The pixel behind it.
    after: Pixel,
}

#[derive(Clone, Copy, Debug)]
struct Visible {
    colour: [f64; 3],
    gradient: [f64; 3],
    normal: [f64; 3],
    shaded: [f64; 3],
    /// As it is composited.
    opacity: f64,
}

/// The lights as the pipeline has them, dequantised, for errors of shading alone.
#[derive(Clone, Debug)]
struct PipelineLights {
    lights: Lights,
    ambient: [f64; 3],
    /// Diffuse and specular coefficients of each light, a channel each.
    coefficients: Vec<([f64; 3], [f64; 3])>,
}

/// A vector as a precision keeps it.
fn vector_value<P: Precision>(p: P, v: [Vector; 3]) -> [f64; 3] {
    keep_vector(p, v).map(|c| f64::from(c) * 2f64.powi(-(p.formats().shading.vector_bits() as i32)))
}

/// Coefficients as a precision keeps them.
fn coefficient_value<P: Precision>(p: P, v: [Coefficient; 3]) -> [f64; 3] {
    v.map(|c| f64::from(keep(p, c)) * 2f64.powi(-(p.formats().shading.coefficient_bits() as i32)))
}

/// How a precision's vectors and coefficients are valued.
struct Valued<'v> {
    vector: &'v dyn Fn([Vector; 3]) -> [f64; 3],
    coefficients: &'v dyn Fn([Coefficient; 3]) -> [f64; 3],
}

impl PipelineLights {
    fn new<P: Precision>(p: P, material: &Material, model: &Lights) -> Self {
        let valued = Valued {
            vector: &|v| vector_value(p, v),
            coefficients: &|v| coefficient_value(p, v),
        };
        Self::valued(&valued, material, model)
    }

    /// As they are before 16-bit lanes keep them: what that loses is shading's.
    fn of_fast(material: &Material, model: &Lights) -> Self {
        let valued = Valued {
            vector: &|v| v.map(|c| f64::from(c.to_bits()) / 2f64.powi(30)),
            coefficients: &|v| v.map(|c| f64::from(c.to_bits()) / 2f64.powi(31)),
        };
        Self::valued(&valued, material, model)
    }

    fn valued(valued: &Valued<'_>, material: &Material, model: &Lights) -> Self {
        let (vector_value, coefficient_value) = (valued.vector, valued.coefficients);
        let viewer = vector_value(material.viewer);
        let resolve = |light: &slicecast::shade::Light| {
            let direction = vector_value(light.direction);
            ResolvedLight {
                direction,
                half: vector_value(light.half),
                viewer_dot: viewer.iter().zip(direction).map(|(v, l)| v * l).sum(),
                colour: [1.0; 3],
            }
        };
        Self {
            lights: Lights {
                viewer,
                lights: material.lights.iter().map(resolve).collect(),
                ..model.clone()
            },
            ambient: coefficient_value(material.ambient),
            coefficients: material
                .lights
                .iter()
                .map(|l| (coefficient_value(l.diffuse), coefficient_value(l.specular)))
                .collect(),
        }
    }

    /// Squeeze, equation 10, with these lights.
    fn shade(
        &self,
        normal: [f64; 3],
        colour: [f64; 3],
        Weights {
            diffuse: wd,
            specular: ws,
            ..
        }: Weights,
    ) -> [f64; 3] {
        let mut diffuse = self.ambient;
        let mut specular = [0.0; 3];
        for (light, (kd, ks)) in self.lights.lights.iter().zip(&self.coefficients) {
            let terms = self.lights.terms(light, normal);
            for c in 0..3 {
                diffuse[c] += wd * kd[c] * terms.diffuse;
                specular[c] += ws * ks[c] * terms.specular;
            }
        }
        [0, 1, 2].map(|c| (colour[c] * diffuse[c].min(1.0) + specular[c]).min(1.0))
    }
}

/// What the model has to know of a precision. Values, so that the tap is compiled once and not once per precision.
#[derive(Clone)]
pub struct Scales {
    /// Ulp in 1.0, stage by stage.
    pub per_unit: [f64; Stage::ALL.len()],
    /// 1.0 of a sample.
    pub sample_one: f64,
    /// 1.0 of a colour.
    pub colour_one: f64,
    /// 1.0 of a pixel's channel.
    channel_one: f64,
    /// `None`: no normal is made, light is of the gradient.
    normal: Option<NormalForm>,
    /// The opacity that is read of the bits of one.
    read: Arc<dyn Fn(i32) -> Opacity + Send + Sync>,
    /// Transparency below this is 0, and whether that is more than the least one.
    floor: f64,
    has_floor: bool,
    telescopes: bool,
}

impl Scales {
    /// Those of a precision.
    pub fn of<P: Precision>(p: P) -> Self {
        let pixel = p.pixel();
        let (floor, one) = (pixel.floor(), pixel.one());
        Self {
            per_unit: Stage::ALL.map(|stage| stage.per_unit(p)),
            sample_one: f64::from(p.formats().sample_bits).exp2(),
            colour_one: f64::from(pixel.colour_bits()).exp2(),
            channel_one: f64::from(one.bits()),
            normal: Some(p.formats().normal),
            read: Arc::new(move |bits| pixel.read(Opacity::from_bits(bits as u32))),
            floor: f64::from(floor.bits()) / f64::from(one.bits()),
            has_floor: floor.bits() > 1,
            telescopes: pixel.telescoping(),
        }
    }

    /// Those of 16-bit lanes, whose rows hold roots of opacities.
    pub fn of_fast() -> Self {
        let staged = Self::of(Fast);
        Self {
            colour_one: 65535.0,
            normal: None,
            read: Arc::new(|bits| opacity_of_root(bits as u16)),
            ..staged
        }
    }

    /// The opacity that a pixel reads.
    pub fn opacity(&self, bits: i32) -> f64 {
        f64::from((self.read)(bits).to_bits()) / 2147483648.0
    }

    /// A colour of the pipeline.
    pub fn colour(&self, bits: [i32; 3]) -> [f64; 3] {
        bits.map(|c| f64::from(c as u32) / self.colour_one)
    }

    /// The pixels of four rows of channels.
    pub fn pixels(&self, rows: &[&dyn Bits]) -> Vec<Pixel> {
        let value = |bits: i32| f64::from(bits as u32) / self.channel_one;
        values(rows)
            .map(|(_, [r, g, b, t])| Pixel {
                colour: [r, g, b].map(value),
                transparency: value(t),
            })
            .collect()
    }

    /// The normal that shading works with, if one is made.
    pub fn normal(&self, g: [i32; 3], r: i32) -> Option<[f64; 3]> {
        let scaled = |n: [i32; 3], bits: u32| n.map(|n| f64::from(n) * 2f64.powi(-(bits as i32)));
        Some(match self.normal? {
            NormalForm::Deferred => g.map(|g| -f64::from(g) * f64::from(r) * 2f64.powi(-35)),
            NormalForm::Formed(bits) => scaled(formed(g, r, bits), bits),
            NormalForm::Nearest(bits) => scaled(formed_nearest(g, r, bits), bits),
        })
    }
}

/// What lights a frame, if anything does.
fn material<'m>(model: &'m Model<'_>, setup: &'m Setup) -> Option<(&'m Material, &'m Lights)> {
    setup.material.as_ref().zip(model.lights())
}

/// A tap that runs the f64 model in step with the pipeline and gathers the errors of every stage.
pub struct Lockstep<'a> {
    model: &'a Model<'a>,
    plan: Plan,
    lights: Option<PipelineLights>,
    /// Spacing factors as the pipeline has them.
    spacing: [f64; 3],
    blend: Blend,
    tile: Tile,
    width: usize,
    /// Rays per voxel.
    rays: usize,
    errors: StageErrors,
    scales: Scales,
    /// The model's samples of the current plane, and its pixels so far, for the rows of the tile.
    samples: Vec<Option<Sample>>,
    pixels: Vec<Pixel>,
    /// The row under way, dequantised: index of its first pixel, sample values, opacities.
    row: usize,
    values: Vec<f64>,
    /// The samples of the plane in front, where segments are classified.
    fronts: Vec<f64>,
    opacities: Vec<f64>,
    /// The span under way: gradients, normals, colours (shaded ones after shading), pixels before it.
    gradients: Vec<[f64; 3]>,
    normals: Vec<[f64; 3]>,
    colours: Vec<[f64; 3]>,
    before: Vec<Pixel>,
    after: Vec<Pixel>,
}

impl<'a> Lockstep<'a> {
    /// A tap for a tile.
    pub fn new<P: Precision>(p: P, model: &'a Model<'a>, setup: &Setup, blend: Blend, tile: Tile) -> Self {
        let lights = material(model, setup).map(|(material, lights)| PipelineLights::new(p, material, lights));
        Self::with(Scales::of(p), lights, model, (setup, blend), tile)
    }

    /// A tap for a tile, of rows as `FastLockstep` hands them on.
    pub(crate) fn of_fast(model: &'a Model<'a>, setup: &Setup, blend: Blend, tile: Tile) -> Self {
        let lights = material(model, setup).map(|(material, lights)| PipelineLights::of_fast(material, lights));
        Self::with(Scales::of_fast(), lights, model, (setup, blend), tile)
    }

    fn with(
        scales: Scales,
        lights: Option<PipelineLights>,
        model: &'a Model<'a>,
        (setup, blend): (&Setup, Blend),
        tile: Tile,
    ) -> Self {
        let [width, _] = setup.plan.base();
        let width = width as usize;
        let count = width * tile.rows as usize;
        Self {
            model,
            plan: setup.plan,
            lights,
            spacing: setup.plan.spacing().map(|f| f64::from(f.to_bits()) / 32768.0),
            blend,
            tile,
            width,
            rays: setup.plan.sampling().rays_per_voxel as usize,
            errors: StageErrors::default(),
            scales,
            samples: vec![None; count],
            pixels: vec![Pixel::TRANSPARENT; count],
            row: 0,
            values: Vec::new(),
            fronts: Vec::new(),
            opacities: Vec::new(),
            gradients: Vec::new(),
            normals: Vec::new(),
            colours: Vec::new(),
            before: Vec::new(),
            after: Vec::new(),
        }
    }

    /// The tile, what was gathered in it, and the model's pixels, row after row.
    pub fn finish(self) -> (Tile, StageErrors, Vec<Pixel>) {
        (self.tile, self.errors, self.pixels)
    }

    /// Full-resolution coordinates of a pixel of this phase.
    fn full(&self, plane: &Plane, column: usize, row: usize) -> (usize, usize) {
        (
            column * self.rays + plane.phase.u as usize,
            row * self.rays + plane.phase.v as usize,
        )
    }

    fn index(&self, at: Beam<'_>) -> usize {
        (at.row - self.tile.first) as usize * self.width + at.column as usize
    }

    fn add(&mut self, stage: Stage, local: f64, carried: Option<f64>) {
        let ulp = self.scales.per_unit[stage as usize];
        self.errors.local[stage as usize].add(local * ulp);
        if let Some(carried) = carried {
            self.errors.carried[stage as usize].add(carried * ulp);
        }
    }

    fn add3(&mut self, stage: Stage, fixed: [f64; 3], exact: [f64; 3], carried: Option<[f64; 3]>) {
        for c in 0..3 {
            self.add(stage, fixed[c] - exact[c], carried.map(|e| fixed[c] - e[c]));
        }
    }

    /// What the model knows of a part; `None` where it has no such part.
    fn known(&self, index: usize, part: u32) -> Option<&Known> {
        let sample = self.samples.get(index)?.as_ref()?;
        sample.parts.iter().find(|known| known.number == part)
    }

    /// The model's own sample of a visible span; `None` where the model sees nothing.
    fn visible(&self, at: Beam<'_>, offset: usize) -> Option<Visible> {
        self.known(self.index(at) + offset, at.part)?.visible
    }

    /// One plane of the model: samples, then pixels.
    fn advance(&mut self, plane: &Plane) {
        let lit = self.model.lights().is_some() || self.model.modulates();
        let composited = self.blend.is_composited();
        for index in 0..self.samples.len() {
            let (column, row) = (index % self.width, index / self.width + self.tile.first as usize);
            let (u, v) = self.full(plane, column, row);
            let Some(place) = self.model.place(plane.index as usize, u, v) else {
                self.samples[index] = None;
                continue;
            };
            let value = self.model.value_at(place.position);
            let front = place.front.map(|at| self.model.value_at(at));
            let mut pixel = self.pixels[index];
            let mut known = |part: &Part| {
                let Classified { colour, opacity } = part.classified;
                let visible = (composited && opacity > 0.0).then(|| {
                    let (gradient, normal) = if lit {
                        let gradient = self.model.gradient_of(place, part.crossing);
                        (gradient, normalise(gradient))
                    } else {
                        ([0.0; 3], [0.0; 3])
                    };
                    let weights = self.model.weights(gradient);
                    let shaded = self.model.shade_weighed(normal, colour, weights);
                    Visible {
                        colour,
                        gradient,
                        normal,
                        shaded: self.model.cued(shaded, place.turned),
                        opacity: opacity * weights.opacity,
                    }
                });
                if let Some(visible) = visible {
                    let opacity = visible.opacity;
                    pixel = match self.blend {
                        Blend::BackToFront => pixel.back_to_front(visible.shaded, opacity),
                        _ => pixel.front_to_back(visible.shaded, opacity),
                    };
                }
                Known {
                    number: part.number,
                    opacity,
                    visible,
                    after: pixel,
                }
            };
            let (fraction, left) = (place.fraction, place.left);
            let parts = self.model.parts(front, value, fraction, left);
            let parts = if self.blend == Blend::BackToFront {
                parts.iter().rev().map(&mut known).collect()
            } else {
                parts.iter().map(&mut known).collect()
            };
            self.samples[index] = Some(Sample {
                value,
                fraction,
                left,
                turned: place.turned,
                parts,
            });
            self.pixels[index] = pixel;
        }
    }

    /// The errors of the pixels of a span.
    fn composited(&mut self, at: Beam<'_>) {
        for offset in 0..self.after.len() {
            let index = self.index(at) + offset;
            let (before, after) = (self.before[offset], self.after[offset]);
            let (opacity, colour) = (self.opacities[index - self.row], self.colours[offset]);
            let exact = match self.blend {
                Blend::BackToFront => before.back_to_front(colour, opacity),
                _ => before.front_to_back(colour, opacity),
            };
            // Transparency below the pixel's floor is 0 by definition. What the sample itself took is then unknown, and
            // the light that it gives is measured against the product.
            let settled = self.scales.has_floor
                && self.blend != Blend::BackToFront
                && after.transparency == 0.0
                && exact.transparency < self.scales.floor;
            let left = if settled { 0.0 } else { exact.transparency };
            let given = if self.scales.telescopes && self.blend != Blend::BackToFront && !settled {
                // The light that the sample has really taken, rounding included.
                let taken = before.transparency - after.transparency;
                [0, 1, 2].map(|c| before.colour[c] + colour[c] * taken)
            } else {
                exact.colour
            };
            let model = self
                .known(index, at.part)
                .map_or(self.pixels[index], |known| known.after);
            let carried = after.transparency - model.transparency;
            self.add(Stage::Transparency, after.transparency - left, Some(carried));
            self.add3(Stage::Compositing, after.colour, given, Some(model.colour));
        }
    }
}

impl Tap for Lockstep<'_> {
    fn plane(&mut self, plane: &Plane) {
        let (u, v) = self.full(plane, 0, 0);
        let geometry = self.model.geometry();
        let mut exact = self.model.location(plane.index as usize, u, v);
        // The pixel's own place is held to the voxels when it is sampled, the plane's already.
        exact[2] = geometry.held(exact)[2];
        let fixed = position(&self.plan, [plane.x, plane.y, plane.z], [0; 2]);
        for (fixed, exact) in fixed.into_iter().zip(exact) {
            let error = fixed - exact;
            // The tiles of a phase share their planes: count each once.
            if self.tile.first == 0 {
                self.add(Stage::Location, error, Some(error));
            }
        }
        self.advance(plane);
    }

    fn row(&mut self, stage: slicecast::stage::Stage, at: Beam<'_>, rows: &[&dyn Bits]) {
        use slicecast::stage::Stage as Boundary;
        match stage {
            Boundary::Location => {}
            Boundary::Interpolation => self.samples(at, rows),
            Boundary::Opacity => self.opacities(at, rows),
            Boundary::Colour => self.colours(at, rows),
            Boundary::Gradient => self.gradients(at, rows),
            Boundary::Normal => self.normals(at, rows),
            Boundary::Shading => self.shaded(at, rows),
            Boundary::Before => self.before = self.scales.pixels(rows),
            Boundary::After => {
                self.after = self.scales.pixels(rows);
                self.composited(at);
            }
        }
    }
}

impl Lockstep<'_> {
    /// The model's part of the row's own samples, if it has one of that number.
    fn part(&self, offset: usize, number: u32) -> Option<Part> {
        let (fraction, left) = match (&self.samples[self.row + offset], self.model.geometry().borders) {
            (Some(sample), _) => (sample.fraction, sample.left),
            (None, Borders::Whole) => (1.0, Left::WHOLE),
            // The model's ray misses the box.
            (None, _) => (0.0, Left::WHOLE),
        };
        let parts = self
            .model
            .parts(self.fronts.get(offset).copied(), self.values[offset], fraction, left);
        parts.into_iter().find(|part| part.number == number)
    }

    /// The pipeline's own positions of a sample and of the one in front, where segments are classified; held to the voxels.
    fn positions(&self, at: Beam<'_>, offset: usize) -> ([f64; 3], Option<[f64; 3]>) {
        let Plane { index, phase, x, y, z } = *at.plane;
        let pixel = [at.column + offset as u32, at.row];
        let geometry = self.model.geometry();
        match (
            geometry.borders,
            index.checked_sub(1).filter(|_| !self.fronts.is_empty()),
        ) {
            (borders, None) => {
                let position = position(&self.plan, [x, y, z], pixel);
                let exact = borders != Borders::Whole;
                (if exact { geometry.held(position) } else { position }, None)
            }
            (Borders::Whole, Some(index)) => {
                let front = position(&self.plan, cut(&self.plan, phase, index, 0), pixel);
                (position(&self.plan, [x, y, z], pixel), Some(front))
            }
            (_, Some(_)) => {
                let [front, back] = segment_ends(&self.plan, phase, index, pixel).map(|end| geometry.held(end));
                (back, Some(front))
            }
        }
    }

    fn samples(&mut self, at: Beam<'_>, rows: &[&dyn Bits]) {
        self.row = self.index(at);
        self.values.clear();
        self.fronts.clear();
        if let [_, front] = rows {
            let value = |bits: u32| f64::from(bits as i32) / self.scales.sample_one;
            self.fronts.extend((0..front.len()).map(|at| value(front.bits(at))));
        }
        for (offset, [bits]) in values(rows) {
            let fixed = f64::from(bits) / self.scales.sample_one;
            self.values.push(fixed);
            let local = fixed - self.model.value_at(self.positions(at, offset).0);
            let carried = self.samples[self.row + offset].as_ref().map(|s| fixed - s.value);
            self.add(Stage::Interpolation, local, carried);
        }
    }

    fn opacities(&mut self, at: Beam<'_>, rows: &[&dyn Bits]) {
        self.opacities.clear();
        for (offset, [bits]) in values(rows) {
            // As compositing will read it.
            let fixed = self.scales.opacity(bits);
            self.opacities.push(fixed);
            let part = self.part(offset, at.part);
            // A row has as many parts as the segment of it that is cut most.
            if at.part > 0 && part.is_none() && bits == 0 {
                continue;
            }
            let local = fixed - part.map_or(0.0, |part| part.classified.opacity);
            let carried = self
                .known(self.row + offset, at.part)
                .map(|known| fixed - known.opacity);
            self.add(Stage::Opacity, local, carried);
        }
    }

    fn colours(&mut self, at: Beam<'_>, rows: &[&dyn Bits]) {
        self.colours.clear();
        for (offset, colour) in values(rows) {
            let index = self.index(at) + offset;
            let fixed = self.scales.colour(colour);
            self.colours.push(fixed);
            if let Some(exact) = self.part(index - self.row, at.part) {
                let unlit = self.lights.is_none() && !self.model.modulates();
                let carried = self
                    .visible(at, offset)
                    .map(|v| if unlit { v.shaded } else { v.colour });
                // What is not lit turns as it is classified.
                let colour = exact.classified.colour;
                let exact = if unlit { self.cued(index, colour) } else { colour };
                self.add3(Stage::Colour, fixed, exact, carried);
            }
        }
    }

    fn gradients(&mut self, at: Beam<'_>, rows: &[&dyn Bits]) {
        self.gradients.clear();
        for (offset, gradient) in values::<3>(rows) {
            let fixed = gradient.map(|g| f64::from(g) / self.scales.sample_one);
            self.gradients.push(fixed);
            let (position, front) = self.positions(at, offset);
            let mut difference = self.model.difference_at(position);
            if let Some(front) = front {
                let part = self.part(self.index(at) + offset - self.row, at.part);
                let crossing = part.and_then(|part| part.crossing);
                difference = between(self.model.difference_at(front), difference, crossing);
            }
            let exact = [0, 1, 2].map(|a| difference[a] * self.spacing[a]);
            let carried = self.visible(at, offset).map(|v| v.gradient);
            self.add3(Stage::Gradient, fixed, exact, carried);
        }
    }

    /// A colour of the model as depth cueing turns it about a sample.
    fn cued(&self, index: usize, colour: [f64; 3]) -> [f64; 3] {
        let turned = self.samples[index].as_ref().map_or(0.0, |sample| sample.turned);
        self.model.cued(colour, turned)
    }

    fn normals(&mut self, at: Beam<'_>, rows: &[&dyn Bits]) {
        self.normals.clear();
        for (offset, [x, y, z, r]) in values(rows) {
            let exact = normalise(self.gradients[offset]);
            let Some(fixed) = self.scales.normal([x, y, z], r) else {
                self.normals.push(exact);
                continue;
            };
            self.normals.push(fixed);
            let carried = self.visible(at, offset).map(|v| v.normal);
            self.add3(Stage::Normal, fixed, exact, carried);
        }
    }

    fn shaded(&mut self, at: Beam<'_>, rows: &[&dyn Bits]) {
        if let [_, _, _, opacities] = rows {
            let first = self.index(at) - self.row;
            for offset in 0..opacities.len() {
                self.opacities[first + offset] = self.scales.opacity(opacities.bits(offset) as i32);
            }
        }
        for (offset, colour) in values(rows) {
            let fixed = self.scales.colour(colour);
            if let Some(lights) = &self.lights {
                let weights = self.model.weights(self.gradients[offset]);
                let exact = lights.shade(self.normals[offset], self.colours[offset], weights);
                let exact = self.cued(self.index(at) + offset, exact);
                let carried = self.visible(at, offset).map(|v| v.shaded);
                self.add3(Stage::Shading, fixed, exact, carried);
            }
            self.colours[offset] = fixed;
        }
    }
}

/// The values of `N` rows, side by side, each with its place.
pub fn values<'a, const N: usize>(rows: &'a [&dyn Bits]) -> impl Iterator<Item = (usize, [i32; N])> + use<'a, N> {
    let len = rows.first().map_or(0, |row| row.len());
    (0..len).map(move |at| (at, std::array::from_fn(|row| rows[row].bits(at) as i32)))
}

/// The position of a pixel, given where pixel (0, 0) of its phase lies; voxels of the whole volume.
pub fn position(plan: &Plan, at: [Position; 3], [column, row]: [u32; 2]) -> [f64; 3] {
    let (pixel, first) = ([column, row, 0], plan.first());
    [0, 1, 2].map(|axis| f64::from(at[axis].to_bits()) / 65536.0 + f64::from(pixel[axis] + first[axis]))
}

/// Where the pipeline has the ends of what exact borders leave of a pixel's segment that ends at a plane; voxels.
pub fn segment_ends(plan: &Plan, phase: Phase, plane: u32, pixel: [u32; 2]) -> [[f64; 3]; 2] {
    let index = plane.saturating_sub(1);
    let [start_i, start_j] = plan.start(phase);
    let [column, row] = pixel;
    let part = Side::behind(plan, start_i, 0, index)
        .part(column)
        .and(Side::behind(plan, start_j, 1, index).part(row))
        .and(along_k(plan, index));
    [part.from, part.to].map(|place| position(plan, cut(plan, phase, index, place), pixel))
}
