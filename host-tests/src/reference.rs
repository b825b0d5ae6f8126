//! The pipeline's definitions, applied to one ray at a time.
//!
//! Only core's scalar definitions are used: `position`, `trilinear`, `space`, `coarsen`, `normalise`, `Phong::shade`,
//! `Classifier::opacity` and `colour`, `Recurrence::over` and `under`, `settle`, `Extreme::keep`, `resolve`. Which
//! voxels they are given follows from the contract (design.md, section 2) and is written here once more: no rows, no ring, no
//! spans, no row reuse, and nothing is ever skipped. Whatever the layers leave out must therefore be without effect.

use slicecast::classify::Classifier;
use slicecast::composite::{Channel, Dither, Pixel, Recurrence, settle};
use slicecast::format::{Step, Weight};
use slicecast::gradient::{coarsen, space};
use slicecast::interpolate::trilinear;
use slicecast::locate::{Cell, cell, position};
use slicecast::normalise::normalise;
use slicecast::plan::Plan;
use slicecast::precision::{Compact, Paper, Precision, Wide};
use slicecast::project::{Extreme, Maximum, Minimum, resolve};
use slicecast::shade::Phong;
use slicecast::view::Axis;
use slicecast_sim::engine::BaseImage;
use slicecast_sim::scene::{Blend, PrecisionName};
use slicecast_sim::table::AnyTable;

use crate::frame::Frame;
use crate::record::{Bits, Divergence, Place, Recording, Stage};

/// What the definitions say about a frame.
#[derive(Clone, Debug)]
pub struct Expected {
    /// The base-plane image.
    pub image: BaseImage,
    /// Every value on the way.
    pub recording: Recording,
    /// Places that a run must have passed: visible samples.
    pub required: Vec<Place>,
}

impl Expected {
    /// Where a run of the pipeline first departs: it may leave out what is invisible, but whatever it computed must be
    /// right, and nothing visible may be missing.
    pub fn first_divergence(&self, run: &Recording) -> Option<Divergence> {
        let wrong = run
            .values
            .iter()
            .filter(|(place, bits)| self.recording.values.get(place) != Some(bits))
            .map(|(place, _)| place);
        let missing = self.required.iter().filter(|place| !run.values.contains_key(place));
        let place = *wrong.chain(missing).min()?;
        Some(Divergence {
            place,
            expected: self.recording.values.get(&place).copied(),
            found: run.values.get(&place).copied(),
        })
    }
}

/// Renders a frame by the definitions.
///
/// # Panics
/// If core refuses the frame.
pub fn render(frame: &Frame) -> Expected {
    match frame.precision {
        PrecisionName::Paper => Rays::<Paper>::render(frame),
        PrecisionName::Compact => Rays::<Compact>::render(frame),
        PrecisionName::Wide => Rays::<Wide>::render(frame),
    }
}

struct Rays<'a, P: Precision> {
    frame: &'a Frame,
    plan: &'a Plan,
    table: AnyTable<'a>,
    phong: Option<Phong<P>>,
    floor: <P::Pixel as Recurrence>::Channel,
}

/// A sample's cell along i, j, k.
type Cells = [Cell; 3];

impl<P: Precision> Rays<'_, P> {
    fn render(frame: &Frame) -> Expected {
        let plan = frame.plan().expect("a frame that has a plan");
        let compiled = frame.compiled();
        let one = <<P::Pixel as Recurrence>::Channel as Channel>::ONE.bits();
        let asked = match (frame.blend, frame.early_termination) {
            (Blend::FrontToBack, Some(bits)) => one >> bits,
            _ => 0,
        };
        let rays = Rays::<P> {
            frame,
            plan: &plan,
            table: compiled.classifier(),
            phong: frame
                .material
                .as_ref()
                .map(|m| m.phong().expect("a material that core takes")),
            floor: Channel::from_bits(P::Pixel::FLOOR.bits().max(asked)),
        };
        let n = plan.sampling().rays_per_voxel;
        let size = plan.base().map(|side| (side * n) as usize);
        let mut expected = Expected {
            image: BaseImage {
                size,
                format: <<P::Pixel as Recurrence>::Channel as Channel>::NAME,
                one,
                planes: [(); 4].map(|()| Vec::new()),
            },
            recording: Recording::default(),
            required: Vec::new(),
        };
        for v in 0..size[1] as u32 {
            for u in 0..size[0] as u32 {
                let pixel = match frame.blend {
                    Blend::FrontToBack | Blend::BackToFront => rays.composited([u, v], &mut expected),
                    Blend::Maximum => rays.projected::<Maximum>([u, v], &mut expected),
                    Blend::Minimum => rays.projected::<Minimum>([u, v], &mut expected),
                };
                for (plane, bits) in expected.image.planes.iter_mut().zip(bits_of(&pixel)) {
                    plane.push(bits);
                }
            }
        }
        expected
    }

    /// Cells of the sample of pixel (u, v) on a plane, or `None` outside the volume; the plane's positions are noted.
    fn locate(&self, [u, v]: [u32; 2], step: u32, expected: &mut Expected) -> Option<(Cells, Place)> {
        let index = if self.frame.blend == Blend::BackToFront {
            self.plan.planes() - 1 - step
        } else {
            step
        };
        let n = self.plan.sampling().rays_per_voxel;
        let [si, sj, sk] = self.plan.step();
        let [oi, oj] = self.plan.origin();
        // The phase's offset to the nearest 2^-32, halves up.
        let start = |origin: i32, phase: u32| {
            let offset = ((u64::from(phase) << 33) + u64::from(n)) / (2 * u64::from(n));
            Step::from_bits((i64::from(origin) << 32) + offset as i64)
        };
        let x = position(start(oi, u % n), si, index);
        let y = position(start(oj, v % n), sj, index);
        let z = position(Step::ZERO, sk, index);
        let mut place = Place {
            step,
            phase: u % n + v % n * n,
            stage: Stage::Location,
            row: 0,
            column: 0,
        };
        expected
            .recording
            .note(place, [x.to_bits() as u32, y.to_bits() as u32, z.to_bits() as u32, 0]);
        (place.row, place.column) = (v / n, u / n);
        let mut cells = [cell(x), cell(y), cell(z)];
        cells[0].index += (u / n) as i32;
        cells[1].index += (v / n) as i32;
        for (cell, side) in cells.iter().zip(self.plan.dims()) {
            let last = side as i32 - 1;
            let inside = 0 <= cell.index && (cell.index < last || cell.index == last && cell.weight == Weight::ZERO);
            if !inside {
                return None;
            }
        }
        Some((cells, place))
    }

    /// One ray, all its samples, alpha compositing.
    fn composited(&self, ray: [u32; 2], expected: &mut Expected) -> Pixel<<P::Pixel as Recurrence>::Channel> {
        let back_to_front = self.frame.blend == Blend::BackToFront;
        let mut pixel = Pixel::clear();
        for step in 0..self.plan.planes() {
            let Some((cells, place)) = self.locate(ray, step, expected) else {
                continue;
            };
            let before = pixel;
            let sample = self.sample(cells);
            let opacity = Classifier::<P>::opacity(&self.table, sample);
            let colour = Classifier::<P>::colour(&self.table, sample);
            let mut seen: Vec<(Stage, Bits)> = vec![
                (Stage::Interpolation, [bits_of_sample::<P>(sample) as u32, 0, 0, 0]),
                (Stage::Opacity, [opacity.to_bits(), 0, 0, 0]),
                (Stage::Colour, colour_bits(colour)),
            ];
            let shaded = match &self.phong {
                Some(phong) => self.shaded(phong, cells, colour, &mut seen),
                None => colour,
            };
            let index = if back_to_front {
                self.plan.planes() - 1 - step
            } else {
                step
            };
            let dither = Dither::of_plane(index);
            if back_to_front {
                pixel = P::Pixel::under(pixel, shaded, opacity, dither);
            } else {
                pixel = P::Pixel::over(pixel, shaded, opacity, dither);
                pixel.transparency = settle(pixel.transparency, self.floor);
            }
            seen.push((Stage::Before, bits_of(&before)));
            seen.push((Stage::After, bits_of(&pixel)));
            let visible = opacity.to_bits() != 0 && (back_to_front || before.transparency.bits() != 0);
            for (stage, bits) in seen {
                let place = Place { stage, ..place };
                expected.recording.note(place, bits);
                if visible {
                    expected.required.push(place);
                }
            }
        }
        pixel
    }

    /// One ray, the extreme of its samples.
    fn projected<X: Extreme>(
        &self,
        ray: [u32; 2],
        expected: &mut Expected,
    ) -> Pixel<<P::Pixel as Recurrence>::Channel> {
        let mut kept = X::EMPTY;
        for step in 0..self.plan.planes() {
            if let Some((cells, place)) = self.locate(ray, step, expected) {
                let sample = bits_of_sample::<P>(self.sample(cells));
                kept = X::keep(kept, sample);
                let place = Place {
                    stage: Stage::Interpolation,
                    ..place
                };
                expected.recording.note(place, [sample as u32, 0, 0, 0]);
            }
        }
        resolve::<P, X>(kept, &self.table)
    }

    /// Gradient, normal and shaded colour of a sample.
    fn shaded(&self, phong: &Phong<P>, cells: Cells, colour: [u32; 3], seen: &mut Vec<(Stage, Bits)>) -> [u32; 3] {
        let [dx, dy] = [[1, 0], [0, 1]].map(|[di, dj]| {
            let at = |sign: i32| bits_of_sample::<P>(self.sample_beyond(cells, [sign * di, sign * dj]));
            at(1) - at(-1)
        });
        let [fx, fy, fz] = self.plan.spacing();
        let mut gradient = [space(dx, fx), space(dy, fy), space(self.derivative(cells), fz)];
        if P::GRADIENT_BITS < 15 {
            gradient = coarsen(gradient, P::GRADIENT_BITS);
        }
        let normal = normalise(gradient);
        let shaded = phong.shade(normal, colour);
        let [x, y, z] = gradient.map(|c| c as u32);
        seen.push((Stage::Gradient, [x, y, z, 0]));
        let [x, y, z] = normal.g.map(|c| c as u32);
        seen.push((Stage::Normal, [x, y, z, normal.r]));
        seen.push((Stage::Shading, colour_bits(shaded)));
        shaded
    }

    /// The sample that is classified: voxels of the volume only; behind the last there is none and none is needed.
    fn sample(&self, cells: Cells) -> P::Sample {
        self.interpolated(cells, [0; 2], |[i, j, k]| self.voxel([i, j, k]))
    }

    /// A neighbouring sample of the same plane: the volume continued linearly by one voxel along i and j.
    fn sample_beyond(&self, cells: Cells, shift: [i32; 2]) -> P::Sample {
        self.interpolated(cells, shift, |at| self.continued(at))
    }

    /// Derivative along k: `V[k+1] - V[k-1]` in place of voxels, the volume continued along k.
    fn derivative(&self, cells: Cells) -> i32 {
        let [ni, nj, nk] = self.plan.dims().map(|side| side as i32);
        bits_of_sample::<P>(self.interpolated(cells, [0; 2], |[i, j, k]| {
            let (i, j) = (i.min(ni - 1), j.min(nj - 1));
            let along_k = |k: i32| beyond(k, nk, |k| self.voxel([i, j, k]));
            let k = k.min(nk - 1);
            along_k(k + 1) - along_k(k - 1)
        }))
    }

    fn interpolated(&self, cells: Cells, [di, dj]: [i32; 2], value: impl Fn([i32; 3]) -> i32) -> P::Sample {
        let [i, j, k] = cells.map(|c| c.index);
        let corners = [0, 1].map(|z| {
            [0, 1].map(|y| [0, 1].map(|x| i16::try_from(value([i + di + x, j + dj + y, k + z])).expect("16 bits")))
        });
        trilinear::<P>(corners, cells.map(|c| c.weight))
    }

    /// The volume continued by one voxel along i and j. Further out only weights of 0 reach.
    fn continued(&self, [i, j, k]: [i32; 3]) -> i32 {
        let [ni, nj, _] = self.plan.dims().map(|side| side as i32);
        beyond(i.min(ni), ni, |i| beyond(j.min(nj), nj, |j| self.voxel([i, j, k])))
    }

    /// A voxel in the slice frame; the last one stands for those behind it.
    fn voxel(&self, ijk: [i32; 3]) -> i32 {
        let dims = self.plan.dims().map(|side| side as usize);
        let [i, j, mut k] = [0, 1, 2].map(|a| (ijk[a] as usize).min(dims[a] - 1));
        if self.plan.view().reversed() {
            k = dims[2] - 1 - k;
        }
        let [x, y, z] = match self.plan.view().major() {
            Axis::X => [k, i, j],
            Axis::Y => [i, k, j],
            Axis::Z => [i, j, k],
        };
        let [nx, ny, _] = self.frame.volume.dims;
        i32::from(self.frame.volume.voxels[x + nx * (y + ny * z)])
    }
}

/// A line of `n` voxels continued linearly by one at each end; a single voxel is continued with itself.
fn beyond(place: i32, n: i32, line: impl Fn(i32) -> i32) -> i32 {
    match place {
        _ if n == 1 => line(0),
        -1 => 2 * line(0) - line(1),
        p if p == n => 2 * line(n - 1) - line(n - 2),
        p => line(p),
    }
}

fn bits_of<C: Channel>(pixel: &Pixel<C>) -> Bits {
    let [r, g, b] = pixel.colour.map(Channel::bits);
    [r, g, b, pixel.transparency.bits()]
}

fn colour_bits([r, g, b]: [u32; 3]) -> Bits {
    [r, g, b, 0]
}

fn bits_of_sample<P: Precision>(sample: P::Sample) -> i32 {
    fixed::traits::Fixed::to_bits(sample)
}
