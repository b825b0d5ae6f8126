//! One sample, one ray, all rays.

use super::classify::{Classified, Classifier};
use super::clip::{ClipPlane, CuePlane, Left, left};
use super::composite::Pixel;
use super::gradient::{difference_at, normalise, spacing_factors};
use super::grid::Grid;
use super::interpolate::value_at;
use super::modulation::Weights;
use super::parts::{Crossing, Isosurface, Part, crossings, cut, pieces, surfaces};
use super::rays::{Geometry, Lattice};
use super::segment::Bins;
use super::shade::Lights;
use super::spline;
use super::warp::ModelImage;
use slicecast_scene::modulation::Modulation;
use slicecast_scene::{Blend, Borders, Classification, Interpolation, Scene};
use slicecast_volume::Volume;

/// A segment is cut into pieces if its depth is more than this (docs/contract/surfaces.md).
const PIECES_FROM: f64 = 0.25;

/// Where the model takes its samples.
pub enum Positions<'a> {
    /// At the real positions ([`Geometry::position`]); 2^-17 voxel outside a face still counts as on it.
    Exact,
    /// At given positions, for instance a pipeline's 16.16 numbers: a function of (plane, u, v), voxels in the frame
    /// (i, j, k). A sample exists if its position lies in the volume, faces included, without tolerance.
    Given(Box<dyn Fn(usize, usize, usize) -> [f64; 3] + Send + Sync + 'a>),
    /// Of segments with exact borders: where the two ends lie of what the box leaves of the one that ends at a plane.
    GivenEnds(Box<dyn Fn(usize, usize, usize) -> [[f64; 3]; 2] + Send + Sync + 'a>),
}

/// The f64 model of one scene on one volume.
pub struct Model<'a> {
    geometry: Geometry,
    lattice: Lattice,
    positions: Positions<'a>,
    grid: Grid<'a>,
    spacing_factors: [f64; 3],
    classifier: Classifier<'a>,
    lights: Option<Lights>,
    blend: Blend,
    /// Whether samples lie at voxels.
    nearest: bool,
    /// Whether they are splines.
    splines: bool,
    segments: Segmented,
    surfaces: Vec<Isosurface>,
    /// Whether the volume is drawn, and not surfaces alone.
    with_volume: bool,
    /// Pieces of a segment of several colours.
    pieces: u32,
    clips: Vec<ClipPlane>,
    cue: Option<CuePlane>,
    modulation: Option<&'a Modulation>,
    /// A gradient's unit, codes over two voxels of the finest axis, in values per unit of length.
    steepness: f64,
}

/// What the model classifies, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Segments {
    /// Samples.
    Not,
    /// The segments between samples, by what a table of one bin per code holds.
    Binned,
    /// The segments between samples, as the transfer function is written.
    Exact,
}

/// The same, with what it needs.
enum Segmented {
    Not,
    Binned(Bins),
    /// With the smallest spacing.
    Exact(f64),
}

/// What is classified on a plane of a ray, by positions in voxels along i, j, k.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The sample on the plane.
    pub position: [f64; 3],
    /// The one on the plane in front, where a segment ends at this one.
    pub front: Option<[f64; 3]>,
    /// What of the sample's own segment lies in the volume, 0 to 1.
    pub fraction: f64,
    /// What clip planes leave of that.
    pub left: Left,
    /// How far colours have turned in the middle of the segment, 0 to 1.
    pub turned: f64,
}

/// Everything about one sample, stage by stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelSample {
    /// Where it was taken, voxels along i, j, k.
    pub position: [f64; 3],
    /// Interpolated value, 12-bit code units.
    pub value: f64,
    /// Gradient in world directions along i, j, k: differences times spacing factors, code units per two voxels of
    /// the finest axis ([`Model::gradient_at`]).
    pub gradient: [f64; 3],
    /// `-G / |G|`, or zero.
    pub normal: [f64; 3],
    /// Colour by the transfer function, 0 to 1.
    pub colour: [f64; 3],
    /// Opacity over one step of the ray, 0 to 1.
    pub opacity: f64,
    /// Colour after shading, 0 to 1, not multiplied by opacity; `colour` itself if the scene is unlit.
    pub shaded: [f64; 3],
}

impl<'a> Model<'a> {
    /// A model of `scene` on `volume` for the rays of `lattice` (see [`Geometry::natural_lattice`]).
    ///
    /// # Panics
    /// If the volume is empty or not as long as its dimensions say, the transfer function is empty or its unit
    /// distance is not positive, or a sampling rate is zero. Readers and scene files refuse all of these.
    pub fn new(scene: &'a Scene, volume: &'a Volume, lattice: Lattice, positions: Positions<'a>) -> Self {
        let camera = scene.view.axes();
        let geometry = Self::geometry_of(scene, volume);
        Self {
            lattice,
            positions,
            grid: Grid::new(volume, &geometry),
            spacing_factors: spacing_factors(geometry.spacing),
            classifier: Classifier::new(&scene.transfer, volume.mapping, geometry.step_length()),
            lights: scene.lighting.as_ref().map(|l| Lights::new(l, &camera, &geometry)),
            blend: scene.blend,
            nearest: scene.interpolation == Interpolation::Nearest,
            splines: scene.interpolation == Interpolation::Quadratic,
            segments: Segmented::Not,
            surfaces: surfaces(scene, &volume.mapping),
            with_volume: scene.classification != Classification::None,
            pieces: if has_one_colour(scene) { 1 } else { scene.pieces },
            clips: scene.clips.iter().map(|clip| ClipPlane::of(clip, &geometry)).collect(),
            cue: (scene.cueing.as_ref()).map(|cue| CuePlane::of(cue, camera.forward, &geometry)),
            modulation: scene.modulation.as_ref(),
            steepness: volume.mapping.scale.abs() / (2.0 * volume.spacing.into_iter().fold(f64::INFINITY, f64::min)),
            geometry,
        }
    }

    /// The same model, which classifies samples or the segments between them.
    pub fn with_segments(self, segments: Segments) -> Self {
        let reference = self.geometry.spacing.into_iter().fold(f64::INFINITY, f64::min);
        Self {
            segments: match segments {
                Segments::Not => Segmented::Not,
                Segments::Binned => Segmented::Binned(self.classifier.bins(reference)),
                Segments::Exact => Segmented::Exact(reference),
            },
            ..self
        }
    }

    /// A model with exact positions on the natural lattice of the view.
    ///
    /// # Panics
    /// As [`Model::new`].
    pub fn natural(scene: &'a Scene, volume: &'a Volume) -> Self {
        let lattice = Self::geometry_of(scene, volume).natural_lattice();
        Self::new(scene, volume, lattice, Positions::Exact)
    }

    /// The geometry of a scene's view of a volume.
    ///
    /// # Panics
    /// As [`Geometry::new`].
    pub fn geometry_of(scene: &Scene, volume: &Volume) -> Geometry {
        let geometry = Geometry::new(scene.view.axes().forward, volume.dims, volume.spacing, scene.sampling)
            .with_borders(scene.borders);
        match scene.crop {
            None => geometry,
            Some(crop) => geometry.with_crop(crop.faces(volume.spacing)),
        }
    }

    /// The same model with other lights, for instance a pipeline's rounded ones; `None` is unlit.
    pub fn with_lights(self, lights: Option<Lights>) -> Self {
        Self { lights, ..self }
    }

    /// Axes, flip, shear, planes, step length.
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// The rays.
    pub fn lattice(&self) -> Lattice {
        self.lattice
    }

    /// The voxels in the frame (i, j, k).
    pub fn grid(&self) -> &Grid<'a> {
        &self.grid
    }

    /// Lights and material in the frame (i, j, k); `None` if unlit.
    pub fn lights(&self) -> Option<&Lights> {
        self.lights.as_ref()
    }

    /// Where the ray of pixel (u, v) is sampled on a plane, voxels along i, j, k; `None` outside the volume. With exact
    /// borders: where a part of its segment is inside, and held to the voxels.
    pub fn position(&self, plane: usize, u: usize, v: usize) -> Option<[f64; 3]> {
        // Halves up; what is at a voxel stays there.
        let settled = |position: [f64; 3]| {
            if self.nearest {
                position.map(|c| (c + 0.5).floor())
            } else {
                position
            }
        };
        if self.geometry.borders != Borders::Whole {
            let exact = self.geometry.position(self.lattice, plane, u, v);
            let at = match &self.positions {
                Positions::Exact => exact,
                Positions::Given(position) => position(plane, u, v),
                Positions::GivenEnds(ends) => ends(plane, u, v)[1],
            };
            return (self.geometry.fraction(exact) > 0.0).then(|| self.geometry.held(settled(at)));
        }
        match &self.positions {
            Positions::Exact => {
                self.geometry
                    .inside_tolerant(settled(self.geometry.position(self.lattice, plane, u, v)))
            }
            Positions::Given(position) => self.geometry.inside(settled(position(plane, u, v))),
            Positions::GivenEnds(ends) => self.geometry.inside(settled(ends(plane, u, v)[1])),
        }
    }

    /// What is classified on a plane for pixel (u, v); `None` outside the volume, and on a ray's first plane if segments are
    /// classified.
    pub fn place(&self, plane: usize, u: usize, v: usize) -> Option<Place> {
        if self.cuts_segments() {
            let index = plane.checked_sub(1)?;
            let [from, to] = self.geometry.cut(self.lattice, index, u, v)?;
            let ends = match &self.positions {
                Positions::GivenEnds(ends) => ends(plane, u, v),
                _ => [from, to].map(|part| self.geometry.place(self.lattice, index as f64 + part, u, v)),
            };
            let [front, position] = ends.map(|end| self.geometry.held(end));
            let begin = self.geometry.place(self.lattice, index as f64, u, v);
            return Some(Place {
                position,
                front: Some(front),
                fraction: to - from,
                left: left(&self.clips, begin, self.geometry.way(), [from, to]),
                turned: self.turned_behind(begin),
            });
        }
        let position = self.position(plane, u, v)?;
        let front = match self.segments {
            Segmented::Not => None,
            _ => Some(self.position(plane.checked_sub(1)?, u, v)?),
        };
        let middle = self.geometry.position(self.lattice, plane, u, v);
        // Segments with whole borders end at the sample.
        let begin = match front {
            None => self.geometry.front(middle),
            Some(_) => self.geometry.position(self.lattice, plane - 1, u, v),
        };
        Some(Place {
            position,
            front,
            fraction: self.geometry.fraction(middle),
            left: left(&self.clips, begin, self.geometry.way(), self.geometry.part(middle)),
            turned: self.turned_behind(begin),
        })
    }

    /// How far colours have turned in the middle of the segment that begins at a place.
    fn turned_behind(&self, begin: [f64; 3]) -> f64 {
        let way = self.geometry.way();
        let middle = [0, 1, 2].map(|axis| begin[axis] + way[axis] / 2.0);
        self.cue.as_ref().map_or(0.0, |cue| cue.turned(middle))
    }

    /// A shaded colour as depth cueing turns it so far.
    pub fn cued(&self, colour: [f64; 3], turned: f64) -> [f64; 3] {
        self.cue.as_ref().map_or(colour, |cue| cue.colour(colour, turned))
    }

    /// Depth cueing.
    pub(super) fn cue(&self) -> Option<&CuePlane> {
        self.cue.as_ref()
    }

    /// Whether segments are classified that the borders cut.
    fn cuts_segments(&self) -> bool {
        !matches!(self.segments, Segmented::Not) && self.geometry.borders != Borders::Whole
    }

    /// Planes of samples, or those at which segments end.
    pub fn planes(&self) -> usize {
        if self.cuts_segments() {
            self.geometry.ends()
        } else {
            self.geometry.planes()
        }
    }

    /// Where the ray of pixel (u, v) meets one of them, unrounded and whether inside the volume or not.
    pub fn location(&self, plane: usize, u: usize, v: usize) -> [f64; 3] {
        if self.cuts_segments() {
            self.geometry.place(self.lattice, plane as f64, u, v)
        } else {
            self.geometry.position(self.lattice, plane, u, v)
        }
    }

    /// The value at a position inside the volume, code units.
    pub fn value_at(&self, position: [f64; 3]) -> f64 {
        if self.splines {
            return spline::value_at(&self.grid, position);
        }
        value_at(&self.grid, position)
    }

    /// The value of a sample, code units; `None` outside the volume.
    pub fn sample_value(&self, plane: usize, u: usize, v: usize) -> Option<f64> {
        self.position(plane, u, v).map(|p| self.value_at(p))
    }

    /// The interpolated central differences at a position inside the volume, or twice the slopes of the spline there, without spacing
    /// factors: code units per two voxels, along i, j, k.
    pub fn difference_at(&self, position: [f64; 3]) -> [f64; 3] {
        if self.splines {
            return spline::difference_at(&self.grid, position);
        }
        difference_at(&self.grid, position)
    }

    /// The gradient at a position inside the volume: [`Model::difference_at`] times
    /// [`spacing_factors`](super::gradient::spacing_factors), code units per two voxels of the finest axis.
    pub fn gradient_at(&self, position: [f64; 3]) -> [f64; 3] {
        let difference = self.difference_at(position);
        [0, 1, 2].map(|a| difference[a] * self.spacing_factors[a])
    }

    /// Colour and opacity of a code, the opacity over one step of the ray.
    pub fn classify(&self, code: f64) -> Classified {
        self.classifier.classify(code)
    }

    /// Colour and opacity of a sample, or of the segment between it and the one in front of it, over one step of the ray.
    pub fn classify_behind(&self, front: Option<f64>, code: f64) -> Classified {
        match (&self.segments, front) {
            (Segmented::Binned(bins), Some(front)) => bins.segment([front, code]),
            (Segmented::Exact(reference), Some(front)) => self.classifier.segment([front, code], *reference),
            _ => self.classify(code),
        }
    }

    /// What is composited of a sample, or of the segment between it and the one in front of it, of which a fraction lies in the
    /// volume and clip planes leave something: its parts in the order along the ray. A surface is met whole or not at all, but
    /// fades.
    pub fn parts(&self, front: Option<f64>, code: f64, fraction: f64, left: Left) -> Vec<Part> {
        if left.weight() == 0.0 {
            return Vec::new();
        }
        let fraction = fraction * left.weight();
        let whole = |classified| Part {
            number: 0,
            classified,
            crossing: None,
        };
        let front = match (&self.segments, front) {
            (Segmented::Not, _) | (_, None) => return vec![whole(self.classify(code).of_fraction(fraction))],
            (_, Some(front)) => front,
        };
        let ends = left.ends([front, code]);
        let [front, code] = ends;
        let value = |t: f64| front + (code - front) * t;
        let volume = |[from, to]: [f64; 2]| {
            let part = match &self.segments {
                _ if !self.with_volume => Classified::CLEAR,
                Segmented::Not => Classified::CLEAR,
                Segmented::Binned(bins) => bins.part(ends, [from, to]),
                Segmented::Exact(reference) => {
                    let part = self.classifier.segment([value(from), value(to)], *reference);
                    part.shared(to - from)
                }
            };
            part.of_fraction(fraction)
        };
        let crossings = crossings(&self.surfaces, ends);
        if !crossings.is_empty() {
            let mut parts = cut(&crossings, &volume);
            for part in &mut parts {
                if let Some(crossing) = &mut part.crossing {
                    crossing.t = left.from + (left.to - left.from) * crossing.t;
                    part.classified = part.classified.of_fraction(left.fade);
                }
            }
            return parts;
        }
        let all = if self.with_volume {
            self.classify_behind(Some(front), code).of_fraction(fraction)
        } else {
            Classified::CLEAR
        };
        let far = (code - front).abs() >= f64::from(self.pieces);
        if self.pieces > 1 && far && -(-all.opacity).ln_1p() > PIECES_FROM {
            return pieces(self.pieces, &volume);
        }
        vec![whole(all)]
    }

    /// The gradient of what is classified: of a segment the sum of those at its ends, whose length does not count; of a
    /// crossing the one between both, turned around for a surface that is seen from within.
    pub fn gradient_of(&self, place: Place, crossing: Option<Crossing>) -> [f64; 3] {
        let gradient = self.gradient_at(place.position);
        match place.front {
            None => gradient,
            Some(front) => between(self.gradient_at(front), gradient, crossing),
        }
    }

    /// Colour and opacity of a code as the transfer function states them, the opacity over one unit distance.
    pub fn classify_as_written(&self, code: f64) -> Classified {
        self.classifier.as_written(code)
    }

    /// [`Model::classify_as_written`], and the straight piece of the transfer function that the code lies on.
    pub(super) fn as_written_on_piece(&self, code: f64) -> (Classified, usize) {
        (self.classifier.as_written(code), self.classifier.piece(code))
    }

    /// The surfaces, ascending.
    pub(super) fn surfaces(&self) -> &[Isosurface] {
        &self.surfaces
    }

    /// Whether the volume is drawn, and not surfaces alone.
    pub(super) fn has_volume(&self) -> bool {
        self.with_volume
    }

    /// Clip planes.
    pub(super) fn clips(&self) -> &[ClipPlane] {
        &self.clips
    }

    /// The transfer function.
    pub(super) fn classifier(&self) -> &Classifier<'a> {
        &self.classifier
    }

    /// The shaded colour of a surface; `colour` itself if the scene is unlit.
    pub fn shade(&self, normal: [f64; 3], colour: [f64; 3]) -> [f64; 3] {
        self.lights
            .as_ref()
            .map_or(colour, |lights| lights.shade(normal, colour))
    }

    /// The same with weights of diffuse and specular light.
    pub fn shade_weighed(&self, normal: [f64; 3], colour: [f64; 3], weights: Weights) -> [f64; 3] {
        self.lights
            .as_ref()
            .map_or(colour, |lights| lights.shade_weighed(normal, colour, weights))
    }

    /// Whether gradients weigh opacities or light.
    pub const fn modulates(&self) -> bool {
        self.modulation.is_some()
    }

    /// The factors of a sample with this gradient ([`Model::gradient_at`]).
    pub fn weights(&self, gradient: [f64; 3]) -> Weights {
        self.modulation.map_or(Weights::ONE, |modulation| {
            let length = gradient.iter().map(|c| c * c).sum::<f64>().sqrt();
            Weights::of(modulation, length * self.steepness)
        })
    }

    /// Every stage of one sample, visible or not; `None` outside the volume. Of samples, even where segments are classified.
    pub fn sample(&self, plane: usize, u: usize, v: usize) -> Option<ModelSample> {
        let position = self.position(plane, u, v)?;
        let value = self.value_at(position);
        let middle = self.geometry.position(self.lattice, plane, u, v);
        let left = left(
            &self.clips,
            self.geometry.front(middle),
            self.geometry.way(),
            self.geometry.part(middle),
        );
        let fraction = self.geometry.fraction(middle) * left.weight();
        let Classified { colour, opacity } = self.classify(value).of_fraction(fraction);
        let gradient = self.gradient_at(position);
        let (normal, weights) = (normalise(gradient), self.weights(gradient));
        Some(ModelSample {
            position,
            value,
            gradient,
            normal,
            colour,
            opacity: opacity * weights.opacity,
            shaded: self.cued(
                self.shade_weighed(normal, colour, weights),
                self.turned_behind(self.geometry.front(middle)),
            ),
        })
    }

    /// The pixel of one ray, composited as the scene asks. A ray that misses the volume is transparent.
    pub fn ray(&self, u: usize, v: usize) -> Pixel {
        match self.blend {
            Blend::FrontToBack => self.front_to_back(u, v),
            Blend::BackToFront => self.back_to_front(u, v),
            Blend::Maximum => self.extreme(u, v, f64::max),
            Blend::Minimum => self.extreme(u, v, f64::min),
            Blend::Average => self.summed(u, v, |sum, length| sum / length),
            Blend::Additive => {
                let steps = self.geometry.diagonal() / self.geometry.step_length();
                self.summed(u, v, |sum, _| (sum / steps).min(4095.0))
            }
        }
    }

    /// The whole base plane, rows in parallel.
    pub fn render(&self) -> ModelImage {
        ModelImage::from_fn(self.lattice.size, |u, v| self.ray(u, v))
    }

    /// Shaded colour and opacity of what can be seen on a plane, in the order along the ray.
    fn visible(&self, plane: usize, u: usize, v: usize) -> Vec<([f64; 3], f64)> {
        match self.place(plane, u, v) {
            Some(place) => self.seen(place),
            None => Vec::new(),
        }
    }

    /// The same of a place.
    pub(super) fn seen(&self, place: Place) -> Vec<([f64; 3], f64)> {
        let front = place.front.map(|at| self.value_at(at));
        let parts = self.parts(front, self.value_at(place.position), place.fraction, place.left);
        parts
            .into_iter()
            .filter(|part| part.classified.opacity > 0.0)
            .map(|part| {
                let Classified { colour, opacity } = part.classified;
                if self.lights.is_none() && self.modulation.is_none() {
                    return (self.cued(colour, place.turned), opacity);
                }
                let gradient = self.gradient_of(place, part.crossing);
                let weights = self.weights(gradient);
                let shaded = self.shade_weighed(normalise(gradient), colour, weights);
                (self.cued(shaded, place.turned), opacity * weights.opacity)
            })
            .collect()
    }

    fn front_to_back(&self, u: usize, v: usize) -> Pixel {
        let mut pixel = Pixel::TRANSPARENT;
        for plane in 0..self.planes() {
            // Behind an exactly opaque pixel every weight is exactly zero.
            if pixel.transparency == 0.0 {
                break;
            }
            for (colour, opacity) in self.visible(plane, u, v) {
                pixel = pixel.front_to_back(colour, opacity);
            }
        }
        pixel
    }

    fn back_to_front(&self, u: usize, v: usize) -> Pixel {
        (0..self.planes())
            .rev()
            .flat_map(|plane| self.visible(plane, u, v).into_iter().rev())
            .fold(Pixel::TRANSPARENT, |pixel, (colour, opacity)| {
                pixel.back_to_front(colour, opacity)
            })
    }

    /// Maximum or minimum of the ray's values, classified once: opacity as written, colour unlit.
    fn extreme(&self, u: usize, v: usize, choose: fn(f64, f64) -> f64) -> Pixel {
        (0..self.geometry.planes())
            .filter(|plane| self.place(*plane, u, v).is_some_and(|place| place.left.weight() > 0.0))
            .filter_map(|plane| self.sample_value(plane, u, v))
            .reduce(choose)
            .map_or(Pixel::TRANSPARENT, |value| {
                let Classified { colour, opacity } = self.classify_as_written(value);
                Pixel::of_sample(colour, opacity)
            })
    }
}

impl Model<'_> {
    /// What is made of the sum of the ray's values and of its length in steps, of which each counts by what of it is in the box and is
    /// left; classified once.
    fn summed(&self, u: usize, v: usize, value: impl Fn(f64, f64) -> f64) -> Pixel {
        let (mut sum, mut length) = (0.0, 0.0);
        for plane in 0..self.geometry.planes() {
            if let Some(place) = self.place(plane, u, v) {
                let share = place.fraction * place.left.weight();
                sum += share * self.value_at(place.position);
                length += share;
            }
        }
        if length == 0.0 {
            return Pixel::TRANSPARENT;
        }
        let Classified { colour, opacity } = self.classify_as_written(value(sum, length));
        Pixel::of_sample(colour, opacity)
    }
}

/// The gradient of a segment's part from those at its ends.
pub fn between(front: [f64; 3], back: [f64; 3], crossing: Option<Crossing>) -> [f64; 3] {
    [0, 1, 2].map(|a| match crossing {
        None => front[a] + back[a],
        Some(Crossing { t, falling, .. }) => {
            let gradient = front[a] + (back[a] - front[a]) * t;
            if falling { -gradient } else { gradient }
        }
    })
}

/// Whether all values of a scene's transfer function have one colour.
fn has_one_colour(scene: &Scene) -> bool {
    let first = scene.transfer.points.first().map(|point| point.colour);
    scene.transfer.points.iter().all(|point| Some(point.colour) == first)
}
