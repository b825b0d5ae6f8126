//! The pipeline's definitions, applied to one ray at a time: what every row kernel, layer and vector has to equal.
//!
//! Only core's scalar definitions are used: `position` and `middle`, `Side::part`, `fraction_of`, `trilinear`, `triquadratic`, `quadratic::gradient`, `space`, `coarsen`, `normalise`, `Phong::shade`, `Mapped::shade`, `Modulated::shade` and `opacity`,
//! `Classifier::opacity`, `colour` and those of parts of segments, `Recurrence::over` and `under`, `settle`, `Extreme::keep`, `resolve`, `Sum::add`, `Projection::shown`. Which
//! voxels they are given follows from the contract and is written here once more: no rows, no ring, no spans, no reuse.
//! Under a witness that wants everything nothing is skipped either; without one, invisible samples are not shaded and
//! finished rays end, as any renderer of rays would have it, and that is what is measured.

mod clips;
mod grid;

use rayon::prelude::*;
use slicecast::borders::{Borders, Part, Side, WHOLE, about_k, along_k, fraction_of, opacity_of_length};
use slicecast::classify::Classifier;
use slicecast::clip::{ClipPlane, Clips, CuePlane, Remainder, halves};
use slicecast::composite::{Channel, Dither, Pixel, Recurrence, settle};
use slicecast::format::{Opacity, Position, Step, Weight};
use slicecast::gradient::{coarsen, space};
use slicecast::interpolate::trilinear;
use slicecast::locate::{Cell, cell, middle, position, settled};
use slicecast::modulate::Modulated;
use slicecast::normalise::{Normal, normalise};
use slicecast::perspective::{ALONG_K, Spread, Way, square};
use slicecast::plan::Plan;
use slicecast::plane::{ChannelOf, Depth, NO_DEPTH};
use slicecast::precision::{Formats, Precision};
use slicecast::project::{Extreme, Maximum, Minimum, Projection, Sum, pixel, resolve};
use slicecast::quadratic::{self, triquadratic};
use slicecast::shade::Phong;
use slicecast::shade::map::Mapped;

use self::grid::Grid;
use crate::camera::CameraError;
use crate::frame::Prepared;
use crate::image::BaseImage;
use crate::reflectance;
use crate::segments::Segments;
use crate::table::AnyTable;
use slicecast_scene::{Blend, Interpolation};

use crate::with_precision;

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

/// Renders the base plane of a frame ray by ray.
///
/// # Errors
/// [`CameraError`] if the material is not one that the pipeline takes.
pub fn render<W: Witness>(prepared: &Prepared<'_>, witness: &mut W) -> Result<BaseImage, CameraError> {
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

/// A sample, or a segment that ends at it.
struct Located {
    cells: Cells,
    /// The sample in front, of a segment.
    front: Option<Cells>,
    visit: Visit,
    /// What of the segment lies in the volume, 0.16.
    fraction: u32,
    /// What clip planes leave of that; `None` is nothing.
    left: Option<Remainder>,
    /// In perspective.
    way: Option<Direction>,
}

/// The direction of a ray from an eye.
#[derive(Clone, Copy)]
struct Direction {
    /// The length of its steps.
    length: i32,
    /// Towards the eye.
    towards: [i32; 3],
}

impl Direction {
    fn of(spread: &Spread, ray: &Ray) -> Self {
        let [i, j] = [(0, ray.column), (1, ray.row)].map(|(axis, pixel)| spread.slope(axis, pixel));
        let way = Way::of([square(i), square(j)]);
        Self {
            length: way.length(),
            towards: [i, j, ALONG_K].map(|slope| way.towards(slope)),
        }
    }
}

/// What counts of a segment: its ends, and which part of it that is.
struct Segment {
    ends: [Cells; 2],
    part: Part,
    left: Option<Remainder>,
}

/// A ray of the base plane.
struct Ray {
    /// Where its phase starts.
    start: [Step; 2],
    phase: u32,
    column: u32,
    row: u32,
}

impl Ray {
    /// Its own place on the first slice.
    fn first(&self) -> [Step; 2] {
        let [i, j] = self.start;
        let pixel = |pixel: u32| Step::from_bits(i64::from(pixel) << 32);
        [i + pixel(self.column), j + pixel(self.row)]
    }
}

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

    /// The ray of pixel (u, v).
    fn ray(&self, [u, v]: [u32; 2]) -> Ray {
        let n = self.plan.sampling().rays_per_voxel;
        let [oi, oj] = self.plan.origin();
        // The phase's offset to the nearest 2^-32, halves up.
        let start = |origin: i32, phase: u32| {
            let offset = ((u64::from(phase) << 33) + u64::from(n)) / (2 * u64::from(n));
            Step::from_bits((i64::from(origin) << 32) + offset as i64)
        };
        Ray {
            start: [start(oi, u % n), start(oj, v % n)],
            phase: u % n + v % n * n,
            column: u / n,
            row: v / n,
        }
    }

    /// Cells of a ray's sample on a plane, those of the sample in front of it where segments are classified, and the fraction
    /// of its segment in the volume, or `None` outside.
    #[inline(always)]
    fn locate<W: Witness>(&self, ray: &Ray, step: u32, witness: &mut W) -> Option<Located> {
        let index = self.index(step);
        if let Some(spread) = self.spread {
            return self.locate_in_perspective(spread, ray, step, witness);
        }
        let positions = match self.segments {
            None => self.positions(ray, index),
            Some(_) => self.cut(ray, index, 0),
        };
        let visit = Visit {
            step,
            phase: ray.phase,
            row: ray.row,
            column: ray.column,
            part: 0,
        };
        witness.location(step, visit.phase, self.in_held(positions));
        if self.segments.is_some() {
            // No segment ends at the first plane.
            let Segment {
                ends: [front, cells],
                part,
                left,
            } = self.segment(ray, index.checked_sub(1)?)?;
            return Some(Located {
                cells,
                front: Some(front),
                visit,
                fraction: part.length(),
                left,
                way: None,
            });
        }
        if self.plan.borders() == Borders::Whole {
            let cells = self.cells(ray, positions)?;
            let left = self.left(ray, index, false, Part::WHOLE);
            return Some(Located {
                cells,
                front: None,
                visit,
                fraction: WHOLE,
                left,
                way: None,
            });
        }
        let part = |axis: usize, pixel| Side::of(self.plan, ray.start[axis], axis, index).part(pixel);
        let part = part(0, ray.column).and(part(1, ray.row)).and(about_k(self.plan, index));
        let fraction = part.length();
        (fraction > 0).then(|| Located {
            cells: self.held(ray, positions),
            front: None,
            visit,
            fraction,
            left: self.left(ray, index, false, part),
            way: None,
        })
    }

    /// [`Rays::locate`] of a ray from an eye.
    fn locate_in_perspective<W: Witness>(
        &self,
        spread: &Spread,
        ray: &Ray,
        step: u32,
        witness: &mut W,
    ) -> Option<Located> {
        let index = self.index(step);
        let [_, _, sk] = self.plan.step();
        let z = position(Step::ZERO, sk, index);
        let lines = spread.lines(index);
        let at = [lines[0].exact(ray.column), lines[1].exact(ray.row)];
        let visit = Visit {
            step,
            phase: 0,
            row: ray.row,
            column: ray.column,
            part: 0,
        };
        // A plane has no place of its own along i and j.
        witness.location(step, 0, [0, 0, z.to_bits()]);
        if index < spread.first_plane() {
            return None;
        }
        let sides = at.iter().zip(self.grid.last);
        let inside = sides
            .into_iter()
            .all(|(at, last)| (0..=i64::from(last) << 16).contains(at));
        inside.then(|| Located {
            cells: [at[0], at[1], z.to_bits().into()].map(|at| cell(Position::from_bits(at as i32))),
            front: None,
            visit,
            fraction: WHOLE,
            left: Some(Remainder::WHOLE),
            way: Some(Direction::of(spread, ray)),
        })
    }

    /// What counts of a ray's segment behind a plane at which segments end: what lies in the volume, from sample to sample.
    #[inline(always)]
    fn segment(&self, ray: &Ray, index: u32) -> Option<Segment> {
        if self.plan.borders() == Borders::Whole {
            let ends = [index, index + 1].map(|index| self.cells(ray, self.cut(ray, index, 0)));
            let [Some(front), Some(back)] = ends else { return None };
            return Some(Segment {
                ends: [front, back],
                part: Part::WHOLE,
                left: self.left(ray, index + 1, true, Part::WHOLE),
            });
        }
        let along = |axis: usize, pixel| Side::behind(self.plan, ray.start[axis], axis, index).part(pixel);
        let part = along(0, ray.column)
            .and(along(1, ray.row))
            .and(along_k(self.plan, index));
        let ends = [part.from, part.to].map(|place| self.held(ray, self.cut(ray, index, place)));
        (part.length() > 0).then(|| Segment {
            ends,
            part,
            left: self.left(ray, index + 1, true, part),
        })
    }

    /// What clip planes leave of a part of a ray's segment: of that about a plane's sample, or of that which ends at a plane.
    /// `None` is nothing.
    #[inline(always)]
    fn left(&self, ray: &Ray, index: u32, segments: bool, part: Part) -> Option<Remainder> {
        if self.clips.is_empty() {
            return Some(Remainder::WHOLE);
        }
        let left = clips::left(
            self.clips,
            self.plan,
            ray.first(),
            halves(self.plan, index, segments),
            part,
        );
        (left.weight() > 0).then_some(left)
    }

    /// A colour as depth cueing turns it.
    fn turned(&self, ray: &Ray, index: u32, colour: [u32; 3]) -> [u32; 3] {
        let Some(cue) = self.cue else { return colour };
        let halves = halves(self.plan, index, self.segments.is_some());
        let ends = clips::ends(cue.slope, cue.distance, self.plan, ray.first(), halves);
        cue.turned(colour, self.precision.pixel().colour_bits(), cue.share(ends))
    }

    /// Where the first pixel of a ray's phase lies at a place of the segment behind a plane at which segments end.
    #[inline(always)]
    fn cut(&self, ray: &Ray, index: u32, place: u32) -> [Position; 3] {
        let [si, sj, sk] = self.plan.step();
        let [start_i, start_j] = ray.start;
        let before = match self.plan.borders() {
            Borders::Cells => self.plan.sampling().planes_per_voxel.div_ceil(2),
            Borders::Whole | Borders::Nodes => 0,
        };
        let [oi, oj] = self.plan.offset();
        let [x, y, z] = [(start_i, oi, si), (start_j, oj, sj), (Step::ZERO, 0, sk)].map(|(start, offset, step)| {
            // The place to the nearest 2^-32 voxel, halves up; then the sum to the nearest 2^-16.
            let part = (i64::from(place) * step.to_bits() + 0x8000) >> 16;
            let steps = i64::from(index) - i64::from(before);
            let exact = 16 * (start.to_bits() + steps * step.to_bits() + part) + offset;
            settled(self.plan, Position::from_bits(((exact + 0x80000) >> 20) as i32))
        });
        [x, y, self.in_slices(z)]
    }

    /// A position in the volume, counted from the first voxel that the plan holds. Rays look at the whole volume: what a plan holds
    /// must do as well.
    fn in_held(&self, position: [Position; 3]) -> [i32; 3] {
        let first = self.plan.first();
        [0, 1, 2].map(|axis| position[axis].to_bits() - ((first[axis] as i32) << 16))
    }

    /// A position along k held to the slices.
    fn in_slices(&self, z: Position) -> Position {
        Position::from_bits(z.to_bits().clamp(0, self.grid.last[2] << 16))
    }

    /// Where the first pixel of a ray's phase lies on a plane.
    #[inline(always)]
    fn positions(&self, ray: &Ray, index: u32) -> [Position; 3] {
        let [si, sj, sk] = self.plan.step();
        let [start_i, start_j] = ray.start;
        let halves = 2 * i64::from(index) + 1;
        let rate = i64::from(self.plan.sampling().planes_per_voxel);
        let [oi, oj] = self.plan.offset();
        let [x, y, z] = [(start_i, oi, si), (start_j, oj, sj), (Step::ZERO, 0, sk)].map(|(start, offset, step)| {
            let at = match self.plan.borders() {
                Borders::Whole => position(start, step, index),
                Borders::Nodes => middle(start, offset, step, halves),
                Borders::Cells => middle(start, offset, step, halves - rate),
            };
            settled(self.plan, at)
        });
        [x, y, self.in_slices(z)]
    }

    /// The cells of a ray's sample, held to the voxels.
    fn held(&self, ray: &Ray, positions: [Position; 3]) -> Cells {
        let [x, y, z] = positions.map(|position| i64::from(position.to_bits()));
        let own = [x + (i64::from(ray.column) << 16), y + (i64::from(ray.row) << 16), z];
        [0, 1, 2].map(|axis| {
            let last = i64::from(self.grid.last[axis]) << 16;
            cell(Position::from_bits(own[axis].clamp(0, last) as i32))
        })
    }

    /// The cells of a ray's sample, or `None` outside the volume.
    #[inline(always)]
    fn cells(&self, ray: &Ray, positions: [Position; 3]) -> Option<Cells> {
        let mut cells = positions.map(cell);
        cells[0].index += ray.column as i32;
        cells[1].index += ray.row as i32;
        for (cell, last) in cells.iter().zip(&self.grid.last) {
            let inside = 0 <= cell.index && (cell.index < *last || cell.index == *last && cell.weight == Weight::ZERO);
            if !inside {
                return None;
            }
        }
        Some(cells)
    }

    /// Planes of samples, or those at which segments end.
    fn planes(&self) -> u32 {
        match self.segments {
            None => self.plan.planes(),
            Some(_) => self.plan.ends(),
        }
    }

    fn index(&self, step: u32) -> u32 {
        if self.blend == Blend::BackToFront {
            self.planes() - 1 - step
        } else {
            step
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
                    words = Sum::add(words, sample, share(located.fraction, left.weight()));
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
