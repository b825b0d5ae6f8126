//! The pipeline's definitions, applied to one ray at a time, with every value on the way kept.
//!
//! The rays are those of `slicecast_rays`: core's scalar definitions and nothing else, and here nothing is ever
//! skipped. Whatever the layers leave out must therefore be without effect.

use slicecast::composite::{Channel, Pixel};
use slicecast::stage::Stage;
use slicecast_engine::image::BaseImage;
use slicecast_rays::{Composited, Visit, Witness};
use slicecast_scene::Blend;

use crate::frame::Frame;
use crate::record::{Bits, Divergence, Place, Recording};

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
    let mut keeper = Keeper {
        back_to_front: frame.blend == Blend::BackToFront,
        recording: Recording::default(),
        required: Vec::new(),
    };
    let image = frame.with_prepared(|prepared, _| {
        slicecast_rays::render(prepared, &mut keeper).expect("a material that core takes")
    });
    Expected {
        image,
        recording: keeper.recording,
        required: keeper.required,
    }
}

/// Keeps everything.
struct Keeper {
    back_to_front: bool,
    recording: Recording,
    required: Vec<Place>,
}

fn place(at: Visit, stage: Stage) -> Place {
    Place {
        step: at.step,
        phase: at.phase,
        stage,
        row: at.row,
        column: at.column,
        part: at.part,
    }
}

impl Witness for Keeper {
    const EVERYTHING: bool = true;

    fn location(&mut self, step: u32, phase: u32, [x, y, z]: [i32; 3]) {
        let plane = Visit {
            step,
            phase,
            row: 0,
            column: 0,
            part: 0,
        };
        let bits = [x as u32, y as u32, z as u32, 0];
        self.recording.note(place(plane, Stage::Location), bits);
    }

    fn sample(&mut self, at: Visit, sample: i32, front: Option<i32>) {
        let bits = [sample as u32, front.unwrap_or(0) as u32, 0, 0];
        self.recording.note(place(at, Stage::Interpolation), bits);
    }

    fn composited<C: Channel>(&mut self, at: Visit, seen: &Composited<C>) {
        let mut values = vec![
            (Stage::Opacity, [seen.opacity.to_bits(), 0, 0, 0]),
            (Stage::Colour, colour_bits(seen.colour)),
            (Stage::Before, bits_of(&seen.before)),
            (Stage::After, bits_of(&seen.after)),
        ];
        if let Some(([x, y, z], normal, shaded)) = seen.lit {
            let [nx, ny, nz] = normal.g.map(|c| c as u32);
            values.push((Stage::Gradient, [x as u32, y as u32, z as u32, 0]));
            values.push((Stage::Normal, [nx, ny, nz, normal.r]));
            let [red, green, blue, _] = colour_bits(shaded);
            let modulated = seen.modulated.map_or(0, |opacity| opacity.to_bits());
            values.push((Stage::Shading, [red, green, blue, modulated]));
        }
        let visible = seen.opacity.to_bits() != 0 && (self.back_to_front || seen.before.transparency.bits() != 0);
        if visible {
            self.required.push(place(Visit { part: 0, ..at }, Stage::Interpolation));
        }
        for (stage, bits) in values {
            self.recording.note(place(at, stage), bits);
            if visible {
                self.required.push(place(at, stage));
            }
        }
    }
}

fn bits_of<C: Channel>(pixel: &Pixel<C>) -> Bits {
    let [r, g, b] = pixel.colour.map(Channel::bits);
    [r, g, b, pixel.transparency.bits()]
}

fn colour_bits([r, g, b]: [u32; 3]) -> Bits {
    [r, g, b, 0]
}
