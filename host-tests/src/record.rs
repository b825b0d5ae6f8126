//! A tap that keeps every value at every stage boundary, and the first place where two runs part.

use std::collections::BTreeMap;
use std::fmt;

use slicecast::locate::Plane;
use slicecast::plan::{Phase, Plan};
use slicecast::stage::Stage;
use slicecast::tap::{Beam, Bits as Row, Tap};
use slicecast_engine::frame::Layer;
use slicecast_engine::image::BaseImage;
use slicecast_engine::rendering::tapped;

use crate::frame::Frame;

/// Where a value was seen. Ordered as the data flow: what comes first may have caused what comes later.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// Number of the plane in the order of folding.
    pub step: u32,
    /// Number of the phase.
    pub phase: u32,
    /// Which part of segments, where they are cut.
    pub part: u32,
    /// Boundary.
    pub stage: Stage,
    /// Row of the phase's image.
    pub row: u32,
    /// Column of it.
    pub column: u32,
}

/// Raw bits; a stage with fewer values leaves the rest 0.
pub type Bits = [u32; 4];

/// What was seen where.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Recording {
    /// Values by place.
    pub values: BTreeMap<Place, Bits>,
}

/// The first place where a run departs from what was expected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Divergence {
    /// Where.
    pub place: Place,
    /// What should have been there; `None`: nothing.
    pub expected: Option<Bits>,
    /// What was; `None`: nothing.
    pub found: Option<Bits>,
}

impl fmt::Display for Divergence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Place {
            step,
            phase,
            part,
            stage,
            row,
            column,
        } = self.place;
        write!(
            f,
            "first divergence at stage {}, plane {step} of the fold, phase {phase}, row {row}, column {column}, part {part}: ",
            stage.name()
        )?;
        let mut side = |name: &str, bits: Option<Bits>| match bits {
            Some(b) => write!(f, "{name} {b:08x?} {:?}", b.map(|c| c as i32)),
            None => write!(f, "{name} nothing"),
        };
        side("expected", self.expected)?;
        side(", found", self.found)
    }
}

impl Recording {
    /// Notes a value.
    pub fn note(&mut self, place: Place, bits: Bits) {
        self.values.insert(place, bits);
    }

    /// Where `other` first differs from this run of the pipeline, value for value.
    pub fn first_difference(&self, other: &Self) -> Option<Divergence> {
        let places = self.values.keys().chain(other.values.keys());
        let differing = places.filter(|p| self.values.get(p) != other.values.get(p)).min()?;
        Some(Divergence {
            place: *differing,
            expected: self.values.get(differing).copied(),
            found: other.values.get(differing).copied(),
        })
    }
}

/// The tap.
#[derive(Clone, Debug)]
pub struct Recorder {
    back_to_front: bool,
    planes: u32,
    rays: u32,
    /// What has been seen.
    pub recording: Recording,
}

impl Recorder {
    /// An empty recording of a pipeline's run.
    pub fn new(plan: &Plan, segments: bool, back_to_front: bool) -> Self {
        Self {
            back_to_front,
            planes: if segments { plan.ends() } else { plan.planes() },
            rays: plan.sampling().rays_per_voxel,
            recording: Recording::default(),
        }
    }

    fn place(&self, plane: &Plane, stage: Stage, row: u32, column: u32, part: u32) -> Place {
        let Phase { u, v } = plane.phase;
        Place {
            step: if self.back_to_front {
                self.planes - 1 - plane.index
            } else {
                plane.index
            },
            phase: u + v * self.rays,
            part,
            stage,
            row,
            column,
        }
    }
}

impl Tap for Recorder {
    fn plane(&mut self, plane: &Plane) {
        let place = self.place(plane, Stage::Location, 0, 0, 0);
        let [x, y, z] = [plane.x, plane.y, plane.z].map(|p| p.to_bits() as u32);
        self.recording.note(place, [x, y, z, 0]);
    }

    fn row(&mut self, stage: Stage, at: Beam<'_>, rows: &[&dyn Row]) {
        for offset in 0..rows.first().map_or(0, |row| row.len()) {
            let place = self.place(at.plane, stage, at.row, at.column + offset as u32, at.part);
            let bits = bits(rows, offset);
            // A row has as many parts as that segment which is cut most; where another has none, nothing is visible.
            if at.part == 0 || stage != Stage::Opacity || bits != [0; 4] {
                self.recording.note(place, bits);
            }
        }
    }
}

/// The values of up to four rows at a place.
pub fn bits(rows: &[&dyn Row], offset: usize) -> Bits {
    std::array::from_fn(|row| rows.get(row).map_or(0, |row| row.bits(offset)))
}

/// Runs a frame through a layer, recording everything.
pub fn recorded(frame: &Frame, layer: Layer) -> (BaseImage, Recording) {
    frame.with_prepared(|prepared, slices| {
        let mut rendering = prepared.begun().expect("a small image of a material that core takes");
        let (plan, back_to_front) = (&prepared.setup.plan, rendering.back_to_front());
        let recorder = || Recorder::new(plan, prepared.segments.is_some(), back_to_front);
        let recording = match layer {
            Layer::Tiles(rows) => {
                let taps = tapped(&mut *rendering, slices, rows, &|_, _| (), |_| recorder());
                let values = taps.into_iter().flat_map(|t| t.recording.values).collect();
                Recording { values }
            }
            Layer::Stream => {
                let mut tap = recorder();
                let streamed = rendering.stream(slices, &|_, _| (), Some(&mut tap));
                streamed.expect("good slices");
                tap.recording
            }
        };
        (rendering.base(), recording)
    })
}
