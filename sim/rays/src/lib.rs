//! The pipeline's definitions, applied to one ray at a time: what every row kernel, layer and vector has to equal.
//!
//! Only core's scalar definitions are used: `position` and `middle`, `Side::part`, `fraction_of`, `trilinear`, `triquadratic`, `quadratic::gradient`, `space`, `coarsen`, `normalise`, `Phong::shade`, `Mapped::shade`, `Modulated::shade` and `opacity`,
//! `Classifier::opacity`, `colour` and those of parts of segments, `Recurrence::over` and `under`, `settle`, `Extreme::keep`, `resolve`, `Sum::add`, `share_of_length`, `Projection::shown`. Which
//! voxels they are given follows from the contract and is written here once more: no rows, no ring, no spans, no reuse.
//! Under a witness that wants everything nothing is skipped either; without one, invisible samples are not shaded and
//! finished rays end, as any renderer of rays would have it, and that is what is measured.

mod clips;
mod fast;
mod grid;
mod locate;

use rayon::prelude::*;
use slicecast::borders::{fraction_of, opacity_of_length};
use slicecast::classify::Classifier;
use slicecast::clip::{ClipPlane, Clips, CuePlane, Remainder};
use slicecast::composite::{Channel, Dither, Pixel, Recurrence, settle};
use slicecast::format::Opacity;
use slicecast::gradient::{coarsen, space};
use slicecast::interpolate::trilinear;
use slicecast::locate::Cell;
use slicecast::modulate::Modulated;
use slicecast::normalise::{Normal, normalise};
use slicecast::perspective::Spread;
use slicecast::plan::Plan;
use slicecast::plane::{ChannelOf, Depth, NO_DEPTH};
use slicecast::precision::{Formats, Precision};
use slicecast::project::{Extreme, Maximum, Minimum, Projection, Sum, pixel, resolve, share_of_length};
use slicecast::quadratic::{self, triquadratic};
use slicecast::shade::Phong;
use slicecast::shade::map::Mapped;
use slicecast_engine::error::CameraError;
use slicecast_engine::frame::Prepared;
use slicecast_engine::image::BaseImage;
use slicecast_engine::reflectance;
use slicecast_engine::segments::Segments;
use slicecast_engine::table::AnyTable;
use slicecast_engine::with_precision;
use slicecast_scene::{Blend, Interpolation, PrecisionName};

use self::grid::Grid;
use self::locate::{Located, Ray, Segment};

/// A sample of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Visit {
    /// Number of the plane in the order of folding.
    pub step: u32,
    /// Number of the phase.
    pub phase: u32,
    /// Row of the phase's image.
    pub row: u32,
    /// Column of it.
    pub column: u32,
    /// Which part of the segment, where it is cut.
    pub part: u32,
}

/// What a composited sample was on its way.
#[derive(Clone, Copy, Debug)]
pub struct Composited<C> {
    /// Its opacity.
    pub opacity: Opacity,
    /// Its colour in the table.
    pub colour: [u32; 3],
    /// Gradient after the spacing factors, normal and shaded colour; `None` in unlit scenes.
    pub lit: Option<([i32; 3], Normal, [u32; 3])>,
    /// Its opacity under modulation, if there is any.
    pub modulated: Option<Opacity>,
    /// The pixel before it.
    pub before: Pixel<C>,
    /// The pixel after it.
    pub after: Pixel<C>,
}

/// An observer of what happens along the rays.
pub trait Witness {
    /// Whether invisible samples are to be computed too.
    const EVERYTHING: bool;
    /// The position of a phase's first pixel on a plane, 16.16.
    fn location(&mut self, _step: u32, _phase: u32, _at: [i32; 3]) {}
    /// A sample, in the precision's bits, and the one in front of it where segments are classified.
    fn sample(&mut self, _at: Visit, _sample: i32, _front: Option<i32>) {}
    /// A sample that was composited.
    fn composited<C: Channel>(&mut self, _at: Visit, _seen: &Composited<C>) {}
}

/// No observer.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unobserved;

impl Witness for Unobserved {
    const EVERYTHING: bool = false;
}

/// Renders the base plane of a frame ray by ray; in 16-bit lanes without a witness.
///
/// # Errors
/// [`CameraError`] if the material is not one that the pipeline takes.
pub fn render<W: Witness>(prepared: &Prepared<'_>, witness: &mut W) -> Result<BaseImage, CameraError> {
    if prepared.scene.precision == PrecisionName::Fast {
        return fast::render(prepared);
    }
    with_precision!(prepared.scene.precision, precision => Ok(Rays::new(precision, prepared)?.image(witness)))
}

/// Follows all rays of a frame on rayon's current threads, each row by itself, and keeps a checksum of what they saw.
///
/// # Errors
/// As [`render`].
pub fn follow(prepared: &Prepared<'_>) -> Result<u64, CameraError> {
    with_precision!(prepared.scene.precision, precision => Ok(Rays::new(precision, prepared)?.follow()))
}

/// The depths of a frame's surfaces, ray by ray ([`slicecast::plane::Depth`]); `None` if it has none.
///
/// # Errors
/// As [`render`].
pub fn depths(prepared: &Prepared<'_>) -> Result<Option<Vec<u32>>, CameraError> {
    with_precision!(prepared.scene.precision, precision => Ok(Rays::new(precision, prepared)?.depths()))
}

struct Rays<'a, P: Precision> {
    precision: P,
    plan: &'a Plan,
    spread: Option<&'a Spread>,
    clips: &'a [ClipPlane],
    cue: Option<&'a CuePlane>,
    grid: Grid<'a>,
    table: AnyTable<'a>,
    segments: Option<&'a Segments>,
    phong: Option<Phong<P>>,
    modulated: Option<Modulated<P>>,
    mapped: Option<Mapped<Vec<u32>, P>>,
    blend: Blend,
    additive: Sum,
    floor: ChannelOf<P>,
    /// Whether samples are splines.
    splines: bool,
}

/// A sample's cell along i, j, k.
type Cells = [Cell; 3];

/// The voxels around a sample: `[z][y][x]`.
type Corners = [[[i16; 2]; 2]; 2];

impl<'a, P: Precision> Rays<'a, P> {
    fn new(precision: P, prepared: &'a Prepared<'_>) -> Result<Self, CameraError> {
        let (plan, pixel) = (&prepared.setup.plan, precision.pixel());
        let blend = prepared.scene.blend;
        let asked = match (blend, prepared.scene.early_termination) {
            (Blend::FrontToBack, Some(bits)) => pixel.one().bits() >> bits,
            _ => 0,
        };
        let material = prepared.setup.material.as_ref();
        let phong = material.map(|material| material.phong(precision)).transpose()?;
        // Of samples alone.
        let modulation = prepared.modulation.clone().filter(|_| prepared.segments.is_none());
        let mapped = match (&phong, prepared.scene.reflectance) {
            (Some(phong), Some(map)) if prepared.segments.is_none() => Some(reflectance::of(phong, map)?),
            _ => None,
        };
        Ok(Self {
            mapped,
            modulated: modulation.map(|modulation| Modulated::new(precision, phong.clone(), modulation)),
            precision,
            grid: Grid::of(prepared.volume, plan),
            plan,
            spread: prepared.setup.spread.as_ref(),
            clips: prepared.setup.clips.as_ref().map_or(&[], Clips::planes),
            cue: prepared.setup.clips.as_ref().and_then(Clips::cue),
            table: prepared.table.classifier(),
            segments: prepared.segments.as_ref(),
            phong,
            blend,
            additive: prepared.setup.additive,
            floor: Channel::from_bits(pixel.floor().bits().max(asked)),
            splines: prepared.scene.interpolation == Interpolation::Quadratic,
        })
    }

    fn size(&self) -> [u32; 2] {
        let n = self.plan.sampling().rays_per_voxel;
        self.plan.base().map(|side| side * n)
    }

    fn image<W: Witness>(&self, witness: &mut W) -> BaseImage {
        let [width, height] = self.size();
        let mut planes = [(); 4].map(|()| Vec::new());
        for (u, v) in (0..height).flat_map(|v| (0..width).map(move |u| (u, v))) {
            let pixel = self.pixel([u, v], witness);
            let [red, green, blue] = pixel.colour.map(Channel::bits);
            for (plane, bits) in planes.iter_mut().zip([red, green, blue, pixel.transparency.bits()]) {
                plane.push(bits);
            }
        }
        BaseImage {
            size: [width as usize, height as usize],
            format: self.precision.pixel().format(),
            one: self.precision.pixel().one().bits(),
            planes,
        }
    }

    fn follow(&self) -> u64 {
        let [width, height] = self.size();
        let row = |v: u32| -> u64 {
            let bits = |u| u64::from(self.pixel([u, v], &mut Unobserved).transparency.bits());
            (0..width).map(bits).sum()
        };
        (0..height).into_par_iter().map(row).sum()
    }

    fn depths(&self) -> Option<Vec<u32>> {
        let surfaces = self.segments?.surfaces();
        let pipeline = Depth::new(self.precision, surfaces, self.plan)
            .ok()
            .filter(|_| !surfaces.is_empty())?;
        let depth = |pixel| {
            let ray = &self.ray(pixel);
            let met = |index: u32| {
                let Segment { ends, part, left } = self.segment(ray, index)?;
                let left = left?;
                let position = pipeline.first(left.ends(ends.map(|cells| self.sample::<false>(cells))))?;
                let way = (u64::from(part.length()) * u64::from(left.place(position))) >> 16;
                Some((index << 16) + part.from + way as u32)
            };
            (0..self.plan.ends() - 1).find_map(met).unwrap_or(NO_DEPTH)
        };
        let [width, height] = self.size();
        let pixels = (0..height).flat_map(|v| (0..width).map(move |u| [u, v]));
        Some(pixels.map(depth).collect())
    }

    fn pixel<W: Witness>(&self, pixel: [u32; 2], witness: &mut W) -> Pixel<ChannelOf<P>> {
        let ray = &self.ray(pixel);
        match self.blend {
            Blend::FrontToBack => self.composited::<W, false>(ray, witness),
            Blend::BackToFront => self.composited::<W, true>(ray, witness),
            Blend::Maximum => self.projected::<Maximum, W>(ray, witness),
            Blend::Minimum => self.projected::<Minimum, W>(ray, witness),
            Blend::Average => self.summed(ray, Sum::Average, witness),
            Blend::Additive => self.summed(ray, self.additive, witness),
        }
    }

    /// One ray, alpha compositing.
    fn composited<W: Witness, const BACK_TO_FRONT: bool>(&self, ray: &Ray, witness: &mut W) -> Pixel<ChannelOf<P>> {
        let (p, recurrence) = (self.precision, self.precision.pixel());
        let mut pixel = recurrence.clear();
        for step in 0..self.planes() {
            let Some(located) = self.locate(ray, step, witness) else {
                continue;
            };
            let Located {
                cells,
                front,
                visit: at,
                fraction,
                left,
                way,
            } = located;
            if !W::EVERYTHING && left.is_none() {
                continue;
            }
            // What is not left is as it would be, but clear.
            let (clear, left) = (left.is_none(), left.unwrap_or(Remainder::WHOLE));
            let inner = self.grid.is_inner(cells);
            let sample = if inner {
                self.sample::<true>(cells)
            } else {
                self.sample::<false>(cells)
            };
            let front_sample = front.map(|cells| self.sample::<false>(cells));
            witness.sample(at, sample, front_sample);
            let segment = match (self.segments, front_sample) {
                (Some(segments), Some(front)) => Some((segments, left.ends([front, sample]))),
                _ => None,
            };
            let parts = segment.map_or(1, |(segments, ends)| segments.parts_of(p, ends));
            for turn in 0..parts {
                let part = if BACK_TO_FRONT { parts - 1 - turn } else { turn };
                let opacity = match segment {
                    _ if clear => Opacity::ZERO,
                    Some((segments, ends)) => {
                        let opacity = segments.part_opacity(p, ends, share(fraction, left.weight()), part);
                        // The opacity of a surface has no length.
                        if part & 1 == 1 {
                            fraction_of(opacity, left.fade)
                        } else {
                            opacity
                        }
                    }
                    None => fraction_of(fraction_of(self.table.opacity(p, sample), fraction), left.weight()),
                };
                let opacity = way.map_or(opacity, |way| {
                    let bits = opacity_of_length(opacity.to_bits() as i32, way.length);
                    Opacity::from_bits(bits as u32)
                });
                if !W::EVERYTHING && opacity.to_bits() == 0 {
                    continue;
                }
                let before = pixel;
                let colour = match segment {
                    Some((segments, ends)) => segments.part_colour(p, ends, share(fraction, left.weight()), part),
                    None => self.table.colour(p, sample),
                };
                // What is not lit turns as it is classified.
                let shades = self.phong.is_some() || self.modulated.is_some();
                let colour = if shades {
                    colour
                } else {
                    self.turned(ray, self.index(step), colour)
                };
                let lit = shades.then(|| {
                    let mut gradient = if inner {
                        self.gradient::<true>(cells)
                    } else {
                        self.gradient::<false>(cells)
                    };
                    if let (Some(front), Some((segments, ends))) = (front, segment) {
                        let front = self.gradient::<false>(front);
                        let crossing = (part & 1 == 1).then(|| left.turn(segments.turn(p, ends, part)));
                        gradient = [0, 1, 2].map(|axis| match crossing {
                            None => front[axis] + gradient[axis],
                            Some(turn) => turn.gradient(front[axis], gradient[axis]),
                        });
                    }
                    let normal = normalise(gradient);
                    let shaded = match (&self.modulated, &self.mapped, &self.phong) {
                        (Some(modulated), ..) => modulated.shade(gradient, normal, colour),
                        (None, Some(mapped), _) => mapped.shade(gradient, colour),
                        (None, None, Some(phong)) => match way {
                            Some(way) => phong.shade_towards(normal, way.towards, colour),
                            None => phong.shade(normal, colour),
                        },
                        (None, None, None) => colour,
                    };
                    (gradient, normal, self.turned(ray, self.index(step), shaded))
                });
                let shaded = lit.map_or(colour, |(_, _, shaded)| shaded);
                let modulated = match (&self.modulated, lit) {
                    (Some(modulated), Some((gradient, ..))) => Some(modulated.opacity(gradient, opacity)),
                    _ => None,
                };
                let folded = modulated.unwrap_or(opacity);
                let dither = Dither::of_part(self.index(step), part);
                if BACK_TO_FRONT {
                    pixel = recurrence.under(pixel, shaded, folded, dither);
                } else {
                    pixel = recurrence.over(pixel, shaded, folded, dither);
                    pixel.transparency = settle(pixel.transparency, self.floor);
                }
                let seen = Composited {
                    opacity,
                    colour,
                    lit,
                    modulated,
                    before,
                    after: pixel,
                };
                witness.composited(Visit { part, ..at }, &seen);
            }
            if !W::EVERYTHING && !BACK_TO_FRONT && pixel.transparency.bits() == 0 {
                break;
            }
        }
        pixel
    }

    /// One ray, the extreme of its samples.
    fn projected<X: Extreme, W: Witness>(&self, ray: &Ray, witness: &mut W) -> Pixel<ChannelOf<P>> {
        let mut kept = X::EMPTY;
        for step in 0..self.plan.planes() {
            if let Some(Located {
                cells, visit: at, left, ..
            }) = self.locate(ray, step, witness)
            {
                let sample = self.sample::<false>(cells);
                if left.is_some() {
                    kept = X::keep(kept, sample);
                }
                witness.sample(at, sample, None);
            }
        }
        resolve::<_, X>(self.precision, kept, &self.table)
    }

    /// One ray, what is made of the sum of its samples.
    fn summed<W: Witness>(&self, ray: &Ray, sum: Sum, witness: &mut W) -> Pixel<ChannelOf<P>> {
        let mut words = [Sum::EMPTY; 3];
        for step in 0..self.plan.planes() {
            if let Some(located) = self.locate(ray, step, witness) {
                let sample = self.sample::<false>(located.cells);
                if let Some(left) = located.left {
                    let share = match located.way {
                        Some(way) => share_of_length(way.length),
                        None => share(located.fraction, left.weight()),
                    };
                    words = Sum::add(words, sample, share);
                }
                witness.sample(located.visit, sample, None);
            }
        }
        pixel(self.precision, sum.shown(self.precision, words), &self.table)
    }

    /// Gradient of a sample, spaced. `INNER`: all voxels that are looked at exist.
    fn gradient<const INNER: bool>(&self, cells: Cells) -> [i32; 3] {
        let weights = cells.map(|c| c.weight);
        let at = |corners: Corners| trilinear(self.precision, corners, weights);
        let grid = &self.grid;
        let [dx, dy, dz] = if self.splines {
            quadratic::gradient(self.precision, grid.about(cells), weights)
        } else if INNER {
            let ([i, j, k], here) = (grid.stride, grid.place(cells));
            [
                at(grid.corners(here + i)) - at(grid.corners(here - i)),
                at(grid.corners(here + j)) - at(grid.corners(here - j)),
                at(difference(grid.corners(here + k), grid.corners(here - k))),
            ]
        } else {
            let beside = |di, dj| at(corners_of(cells, [di, dj], |place| grid.continued(place)));
            [
                beside(1, 0) - beside(-1, 0),
                beside(0, 1) - beside(0, -1),
                at(corners_of(cells, [0; 2], |place| grid.derivative(place))),
            ]
        };
        let [fx, fy, fz] = self.plan.spacing();
        let mut gradient = [space(dx, fx), space(dy, fy), space(dz, fz)];
        let Formats { gradient_bits, .. } = self.precision.formats();
        if gradient_bits < 15 {
            gradient = coarsen(gradient, gradient_bits);
        }
        gradient
    }

    /// The sample that is classified: voxels of the volume only; behind the last there is none and none is needed.
    #[inline(always)]
    fn sample<const INNER: bool>(&self, cells: Cells) -> i32 {
        if self.splines {
            return triquadratic(self.precision, self.grid.about(cells), cells.map(|c| c.weight));
        }
        let corners = if INNER {
            self.grid.corners(self.grid.place(cells))
        } else {
            corners_of(cells, [0; 2], |at| self.grid.voxel(at))
        };
        trilinear(self.precision, corners, cells.map(|c| c.weight))
    }
}

/// The product of two shares, 0.16, to nearest.
fn share(a: u32, b: u32) -> u32 {
    ((u64::from(a) * u64::from(b) + 0x8000) >> 16) as u32
}

/// The voxels that `value` gives around a sample's neighbour.
fn corners_of(cells: Cells, [di, dj]: [i32; 2], value: impl Fn([i32; 3]) -> i32) -> Corners {
    let [i, j, k] = cells.map(|c| c.index);
    // Derivatives and continued voxels are within -4095 to 8190.
    [0, 1].map(|z| [0, 1].map(|y| [0, 1].map(|x| value([i + di + x, j + dj + y, k + z]) as i16)))
}

/// Corner by corner.
#[inline(always)]
fn difference([a, b]: Corners, [c, d]: Corners) -> Corners {
    let row = |[a, b]: [i16; 2], [c, d]: [i16; 2]| [a - c, b - d];
    let face = |[a, b]: [[i16; 2]; 2], [c, d]: [[i16; 2]; 2]| [row(a, c), row(b, d)];
    [face(a, c), face(b, d)]
}
