//! Error against time: whole frames, rendered by samples and by segments of several planes per voxel, beside the converged
//! integral in f64.

use std::time::Duration;

use serde::Serialize;
use slicecast::plan::Plan;
use slicecast_compare::image::base_figures;
use slicecast_compare::{ModelPositions, model};
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::Prepared;
use slicecast_engine::oriented::{Oriented, Turned};
use slicecast_scene::file::built_in;
use slicecast_scene::{Classification, Point, PrecisionName, Sampling, Scene, TransferFunction, View};
use slicecast_volume::mapping::Window;
use slicecast_volume::open::load;
use slicecast_volume::{Mapping, Volume};

use crate::clock::{one_thread, worked};

use super::cases::{Case, Random, cases, smooth};

/// Planes per voxel of frames by samples, and by segments.
pub const SAMPLES: [u32; 5] = [1, 2, 4, 8, 16];
/// See [`SAMPLES`].
pub const SEGMENTS: [u32; 3] = [1, 2, 4];
/// Rows of a tile.
const TILE: usize = 32;

/// A frame: its error, and what it took.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Frame {
    /// Planes per voxel.
    pub planes: u32,
    /// Mean difference in steps of 1/255, over red, green and blue of the pixels that anything contributes to.
    pub mean: f64,
    /// The largest.
    pub most: f64,
    /// The mean over those pixels alone whose rays run from the first slice to the last. A ray that enters or leaves by a side
    /// loses the part of a segment that lies between the side and a plane.
    pub whole: f64,
    /// Milliseconds of a processor: the base plane alone, on one thread, the quickest of all rounds.
    pub milliseconds: f64,
}

/// A number, or that it lies beyond what was rendered.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Bounded {
    /// Between the frames by samples.
    Is(f64),
    /// Less than this.
    Below(f64),
    /// More than this.
    Above(f64),
}

impl std::fmt::Display for Bounded {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Is(number) => write!(f, "{number:.1}"),
            Self::Below(number) => write!(f, "< {number:.1}"),
            Self::Above(number) => write!(f, "> {number:.1}"),
        }
    }
}

/// Samples with the mean error of a frame of segments.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Equal {
    /// Planes of samples per voxel.
    pub samples: Bounded,
    /// Their time divided by that of the segments: above 1, segments are quicker at the same error.
    pub gain: Bounded,
}

/// What a frame of segments is worth.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Worth {
    /// Planes of segments per voxel.
    pub planes: u32,
    /// By the error of all pixels.
    pub all: Equal,
    /// By that of whole rays.
    pub whole: Equal,
}

/// The frames of a scene.
#[derive(Clone, Debug, Serialize)]
pub struct Curve {
    /// Which scene.
    pub case: &'static str,
    /// By samples, of ascending planes.
    pub samples: Vec<Frame>,
    /// By segments, of ascending planes.
    pub segments: Vec<Frame>,
    /// A line for each of them.
    pub worth: Vec<Worth>,
}

/// A scene on its volume.
pub(super) struct Setting {
    name: &'static str,
    pub(super) volume: Volume,
    pub(super) scene: Scene,
}

/// An unlit scene; both ways of classification in 1.31, so that the arithmetic does not count.
fn scene(transfer: TransferFunction) -> Scene {
    Scene {
        view: View {
            azimuth: 17.0,
            elevation: 12.0,
            roll: 0.0,
        },
        image: slicecast_scene::Image::default(),
        sampling: Sampling::default(),
        transfer,
        lighting: None,
        blend: slicecast_scene::Blend::FrontToBack,
        precision: PrecisionName::Wide,
        table: None,
        lookup: None,
        interpolation: slicecast_scene::Interpolation::Linear,
        borders: slicecast_scene::Borders::Whole,
        early_termination: None,
        classification: Classification::Point,
        pieces: 1,
        colours: None,
        crop: None,
        clips: Vec::new(),
        cueing: None,
        perspective: None,
        modulation: None,
        reflectance: None,
        surfaces: Vec::new(),
    }
}

pub(super) fn of_case(case: Case) -> Setting {
    let voxels = case.codes().map(|code| code as u16).collect();
    Setting {
        name: case.name,
        volume: Volume {
            name: case.name.into(),
            dims: [case.side(); 3],
            spacing: [1.0; 3],
            voxels,
            mapping: Mapping {
                scale: 1.0,
                offset: 0.0,
            },
        },
        scene: scene(case.transfer),
    }
}

/// Seven coloured spikes, 8 to 40 codes wide.
fn spikes(mapping: &Mapping) -> TransferFunction {
    let mut random = Random::new(7);
    let spike = |n: usize| {
        let (middle, half) = (500.0 + 350.0 * n as f64, 4.0 + 16.0 * n as f64 / 6.0);
        let colour = [(); 3].map(|()| random.number());
        [(-half, 0.0), (0.0, 0.6), (half, 0.0)].map(|(away, opacity)| Point {
            value: mapping.value(middle + away),
            colour,
            opacity,
        })
    };
    TransferFunction {
        unit_distance: 1.0,
        points: (0..7).flat_map(spike).collect(),
    }
}

/// All scenes; `reduced` those of small volumes alone.
fn settings(reduced: bool) -> Result<Vec<Setting>, RenderError> {
    let mut all: Vec<Setting> = cases(reduced).into_iter().map(of_case).collect();
    all.push(of_case(smooth(reduced)));
    if reduced {
        return Ok(all);
    }
    let lit = head();
    let unlit = Scene {
        lighting: None,
        ..lit.scene.clone()
    };
    let spiky = scene(spikes(&lit.volume.mapping));
    for (name, scene) in [("head, bone", unlit), ("head, seven spikes", spiky)] {
        all.push(Setting {
            name,
            volume: lit.volume.clone(),
            scene,
        });
    }
    all.insert(all.len() - 1, lit);
    Ok(all)
}

/// The built-in head as lit bone.
pub(super) fn head() -> Setting {
    // Both are part of the program.
    let (Ok(loaded), Ok(bone)) = (load(None, Window::Auto), built_in("ct-bone")) else {
        unreachable!("the built-in head and its scene")
    };
    Setting {
        name: "head, bone, lit",
        volume: loaded.volume,
        scene: Scene {
            lighting: bone.lighting,
            ..scene(bone.transfer)
        },
    }
}

/// The head's skin and skull as layers that are finer than what neighbouring samples differ by, lit.
pub(super) fn thin_layers() -> Setting {
    let point = |(value, colour, opacity)| Point { value, colour, opacity };
    let (skin, skull) = ([0.9, 0.69, 0.55], [0.95, 0.91, 0.82]);
    let points = [
        (-510.0, skin, 0.0),
        (-500.0, skin, 0.97),
        (-490.0, skin, 0.0),
        (190.0, skull, 0.0),
        (190.0, skull, 0.999_999_9),
        (220.0, skull, 0.999_999_9),
        (220.0, skull, 0.0),
    ];
    let head = head();
    Setting {
        name: "head, thin layers",
        scene: Scene {
            transfer: TransferFunction {
                unit_distance: 1.0,
                points: points.into_iter().map(point).collect(),
            },
            ..head.scene
        },
        ..head
    }
}

/// A way of a frame, prepared.
fn prepared_scene(setting: &Setting, classification: Classification, planes: u32) -> Scene {
    Scene {
        classification,
        sampling: Sampling {
            planes_per_voxel: planes,
            ..setting.scene.sampling
        },
        ..setting.scene.clone()
    }
}

/// All curves; `reduced` for tests: small volumes, one round.
///
/// # Errors
/// [`RenderError`] if a scene cannot be rendered.
pub fn run(reduced: bool, progress: &(dyn Fn(usize, usize) + Sync)) -> Result<Vec<Curve>, RenderError> {
    let settings = settings(reduced)?;
    let total = settings.len();
    let curve = |(n, setting): (usize, &Setting)| {
        progress(n, total);
        of_setting(setting, if reduced { 1 } else { ROUNDS })
    };
    settings.iter().enumerate().map(curve).collect()
}

/// Times that every frame is rendered, each time after all others.
const ROUNDS: usize = 7;

fn of_setting(setting: &Setting, rounds: usize) -> Result<Curve, RenderError> {
    let ways = (SAMPLES.iter().map(|planes| (Classification::Point, *planes)))
        .chain(SEGMENTS.iter().map(|planes| (Classification::Integral, *planes)));
    let scenes: Vec<Scene> = ways.map(|(way, planes)| prepared_scene(setting, way, planes)).collect();
    let frames = (scenes.iter())
        .map(|scene| Prepared::new(scene, &setting.volume))
        .collect::<Result<Vec<_>, _>>()?;
    let mut turned = Turned::new(&setting.volume, &frames[0].setup.plan);
    let slices = turned.slices()?;
    let volume = Oriented::of(&slices);
    let converged = model(&frames[0], ModelPositions::Exact).render_integral();
    let others: Vec<usize> = not_whole(&frames[0].setup.plan).collect();
    let converged_whole = {
        let mut image = converged.clone();
        others.iter().for_each(|&pixel| image.t[pixel] = 1.0);
        image
    };
    let mut found = vec![([0.0; 3], Duration::MAX); frames.len()];
    for round in 0..rounds {
        for (prepared, (error, least)) in frames.iter().zip(&mut found) {
            let mut rendering = prepared.begun()?;
            let took = one_thread(|| {
                let begin = worked();
                rendering.fold(&volume, TILE, prepared.simd, &|_, _| ());
                worked().saturating_sub(begin)
            });
            *least = took.min(*least);
            if round == 0 {
                let mut base = rendering.base();
                let all = base_figures(&base, &converged);
                // Pixels that are transparent in both are left out.
                others.iter().for_each(|&pixel| base.planes[3][pixel] = base.one);
                let whole = base_figures(&base, &converged_whole);
                *error = [all.mean_lsb8, all.max_lsb8, whole.mean_lsb8];
            }
        }
    }
    let frame = |(scene, ([mean, most, whole], least)): (&Scene, &([f64; 3], Duration))| Frame {
        planes: scene.sampling.planes_per_voxel,
        mean: *mean,
        most: *most,
        whole: *whole,
        milliseconds: least.as_secs_f64() * 1e3,
    };
    let mut samples: Vec<Frame> = scenes.iter().zip(&found).map(frame).collect();
    let segments = samples.split_off(SAMPLES.len());
    let worth = |frame: &Frame| Worth {
        planes: frame.planes,
        all: equal(&samples, frame, |frame| frame.mean),
        whole: equal(&samples, frame, |frame| frame.whole),
    };
    let worth = segments.iter().map(worth).collect();
    Ok(Curve {
        case: setting.name,
        samples,
        segments,
        worth,
    })
}

/// The pixels whose rays enter or leave by a side, of a plan of one ray per voxel.
fn not_whole(plan: &Plan) -> impl Iterator<Item = usize> {
    let [columns, _] = plan.base();
    let ([width, height, slices], [i, j, k]) = (plan.dims(), plan.step().map(|step| step.to_bits() as f64));
    let start = plan.start(plan.phase(0)).map(|start| start.to_num::<f64>());
    let through = f64::from(slices - 1);
    let inside = move |start: f64, step: f64, side: u32| {
        let last = f64::from(side - 1);
        (0.0..=last).contains(&start) && (0.0..=last).contains(&(start + step / k * through))
    };
    let pixels = columns * plan.base()[1];
    (0..pixels).filter_map(move |pixel| {
        let [u, v] = [pixel % columns, pixel / columns].map(f64::from);
        let whole = inside(start[0] + u, i, width) && inside(start[1] + v, j, height);
        (!whole).then_some(pixel as usize)
    })
}

/// Samples with the error of a frame, on straight lines between the logarithms of planes, errors and times; where an error is met
/// more than once, the fewest planes count.
fn equal(samples: &[Frame], frame: &Frame, error: fn(&Frame) -> f64) -> Equal {
    let [first, last] = [&samples[0], &samples[samples.len() - 1]];
    let told = |samples: Bounded, gain: Bounded| Equal { samples, gain };
    let times = |of: &Frame| of.milliseconds / frame.milliseconds;
    if error(frame) > error(first) {
        return told(Bounded::Below(f64::from(first.planes)), Bounded::Below(times(first)));
    }
    let between = samples.windows(2).find(|pair| error(&pair[1]) <= error(frame));
    let Some([a, b]) = between else {
        return told(Bounded::Above(f64::from(last.planes)), Bounded::Above(times(last)));
    };
    let [from, to] = [error(a), error(b)];
    let t = if from > to && to > 0.0 {
        ((from / error(frame)).ln() / (from / to).ln()).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let mix = |a: f64, b: f64| a * (b / a).powf(t);
    told(
        Bounded::Is(mix(a.planes.into(), b.planes.into())),
        Bounded::Is(mix(times(a), times(b))),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(planes: u32, mean: f64, milliseconds: f64) -> Frame {
        Frame {
            planes,
            mean,
            most: mean,
            whole: 2.0 * mean,
            milliseconds,
        }
    }

    #[test]
    fn worth_is_read_between_frames_and_bounded_beyond_them() {
        let samples = [frame(1, 16.0, 10.0), frame(2, 8.0, 20.0), frame(4, 4.0, 40.0)];
        let of = |mean, milliseconds| {
            let [all, whole] = [|frame: &Frame| frame.mean, |frame: &Frame| frame.whole]
                .map(|error| equal(&samples, &frame(1, mean, milliseconds), error));
            assert_eq!(all, whole);
            (all.samples, all.gain)
        };
        assert_eq!(of(17.0, 20.0), (Bounded::Below(1.0), Bounded::Below(0.5)));
        assert_eq!(of(3.0, 20.0), (Bounded::Above(4.0), Bounded::Above(2.0)));
        let (Bounded::Is(planes), Bounded::Is(gain)) = of(32f64.sqrt(), 20.0) else {
            panic!("beyond")
        };
        assert!((planes - 8f64.sqrt()).abs() < 1e-12 && (gain - 2f64.sqrt()).abs() < 1e-12);
        assert_eq!(of(16.0, 10.0), (Bounded::Is(1.0), Bounded::Is(1.0)));
    }

    /// A shell finer than what neighbours differ by is what segments are for; in fog there is nothing to gain.
    #[test]
    fn thin_shells_gain_and_fog_does_not() {
        let curves = run(true, &|_, _| ()).unwrap();
        let of = |name: &str| {
            let curve = curves.iter().find(|curve| curve.case == name).expect(name);
            assert_eq!((curve.samples.len(), curve.segments.len()), (5, 3), "{name}");
            for frame in curve.samples.iter().chain(&curve.segments) {
                assert!(frame.mean.is_finite() && frame.mean <= frame.most && frame.milliseconds > 0.0);
            }
            curve
        };
        let shells = of("sphere, shells of 3 codes");
        assert_eq!(shells.worth[0].all.samples, Bounded::Above(16.0));
        assert!(shells.segments[0].whole < shells.segments[0].mean);
        assert!(shells.segments[0].mean < shells.samples[4].mean);
        let fog = of("sphere, thin fog");
        assert!(fog.segments[0].mean < 1.0 && fog.samples[0].mean < 1.0);
        assert!(of("harmonic, 64 random").segments[2].mean < of("harmonic, 64 random").segments[0].mean);
        assert_eq!(curves.len(), 7);
    }
}
