//! A frame stated in integers, and its way through the pipeline.

use std::sync::Arc;

use slicecast::borders::Borders;
use slicecast::classify::{colour_of_word, entry};
use slicecast::clip::{Clip, Clips, Cue};
use slicecast::crop::Crop;
use slicecast::cut::Cut;
use slicecast::format::{Direction, Intensity, Step};
use slicecast::integral::{Colours, Length};
use slicecast::modulate::Modulation;
use slicecast::perspective::{Eye, Spread};
use slicecast::plan::{Plan, Sampling, Spacing};
use slicecast::project::Sum;
use slicecast::slice::Slice;
use slicecast::surface::Surface;
use slicecast::table::ENTRIES;
use slicecast::view::View;
use slicecast::warp::Warp;
use slicecast_engine::camera::{Material, Picture, Setup};
use slicecast_engine::error::CameraError;
use slicecast_engine::frame::Prepared;
use slicecast_engine::integrals::{Cumulative, Integrals};
use slicecast_engine::oriented::Turned;
use slicecast_engine::segments::Segments;
use slicecast_engine::simd::Simd;
use slicecast_engine::table::Table;
use slicecast_scene::reflectance::Reflectance;
use slicecast_scene::{AlphaCodeName, Blend, LookupName, PrecisionName, Scene};
use slicecast_volume::Volume;

/// What an additive projection of a frame makes of sums, whatever its view: forty steps show the mean, many more saturate.
pub const ADDITIVE: Sum = Sum::Additive {
    step: 0xcccc_cccd,
    shift: 5,
};

/// Everything that decides a frame's bits.
#[derive(Clone, Debug)]
pub struct Frame {
    /// The voxels.
    pub volume: Arc<Volume>,
    /// Viewing direction in voxel units, any scale; each component within +-2^30.
    pub direction: [i64; 3],
    /// The eye of a frame in perspective, along the direction's major axis; `None` is a parallel one.
    pub eye: Option<Eye>,
    /// Spacing factors along x, y, z, 1.15.
    pub factors: [u16; 3],
    /// Planes a voxel.
    pub planes_per_voxel: u32,
    /// Rays a voxel along a side.
    pub rays_per_voxel: u32,
    /// Colour (65535 is 1; the high byte counts where the table's colours have 8 bits) and square root of the opacity (0.16)
    /// of each code.
    pub table: Arc<[([u16; 3], u16); ENTRIES]>,
    /// Lights in the slice frame; `None` is unlit.
    pub material: Option<Material>,
    /// How samples combine.
    pub blend: Blend,
    /// Number formats.
    pub precision: PrecisionName,
    /// Whether samples lie at voxels.
    pub nearest: bool,
    /// Whether samples are splines.
    pub splines: bool,
    /// Where the volume ends.
    pub borders: Borders,
    /// The box that the volume is cropped to.
    pub crop: Option<Crop>,
    /// Clip planes.
    pub clips: Vec<Clip>,
    /// Depth cueing.
    pub cue: Option<Cue>,
    /// Factors by the magnitude of the gradient, of composited samples.
    pub modulation: Option<Modulation>,
    /// A map that light is looked up in, of composited samples.
    pub reflectance: Option<Reflectance>,
    /// Table coding; `None` takes the precision's own.
    pub code: Option<AlphaCodeName>,
    /// Table look-up; `None` takes the precision's own.
    pub lookup: Option<LookupName>,
    /// Threshold of early termination.
    pub early_termination: Option<u32>,
    /// Segments, if they are classified.
    pub segments: Option<Stated>,
}

/// What segments are classified by.
#[derive(Clone, Debug)]
pub struct Stated {
    /// log2(e) times their length in reference lengths, 27 fraction bits.
    pub scaled: u32,
    /// Whether surfaces are drawn without the volume.
    pub alone: bool,
    /// Surfaces, ascending.
    pub surfaces: Vec<Surface>,
    /// Pieces of a segment.
    pub pieces: u32,
}

impl Stated {
    /// Segments of a length that nothing cuts.
    pub const fn whole(scaled: u32) -> Self {
        Self {
            scaled,
            alone: false,
            surfaces: Vec::new(),
            pieces: 1,
        }
    }
}

impl Frame {
    /// An unlit frame of this volume, straight along +z, one sample a voxel.
    pub fn new(volume: Arc<Volume>, table: Arc<[([u16; 3], u16); ENTRIES]>) -> Self {
        Self {
            volume,
            direction: [0, 0, 1],
            eye: None,
            factors: [32768; 3],
            planes_per_voxel: 1,
            rays_per_voxel: 1,
            table,
            material: None,
            blend: Blend::FrontToBack,
            precision: PrecisionName::Compact,
            nearest: false,
            splines: false,
            borders: Borders::Whole,
            crop: None,
            clips: Vec::new(),
            cue: None,
            modulation: None,
            reflectance: None,
            code: None,
            lookup: None,
            early_termination: None,
            segments: None,
        }
    }

    /// The frame in another precision.
    pub fn in_precision(&self, precision: PrecisionName) -> Self {
        Self {
            precision,
            ..self.clone()
        }
    }

    /// The frame's scene: of it the engine reads blend, precision and early termination; the rest is decided already.
    pub fn scene(&self) -> Scene {
        Scene {
            view: slicecast_scene::View::default(),
            image: slicecast_scene::Image::default(),
            sampling: slicecast_scene::Sampling::default(),
            interpolation: if self.splines {
                slicecast_scene::Interpolation::Quadratic
            } else {
                slicecast_scene::Interpolation::Linear
            },
            borders: slicecast_scene::Borders::Whole,
            transfer: slicecast_scene::TransferFunction {
                unit_distance: 1.0,
                points: Vec::new(),
            },
            lighting: None,
            blend: self.blend,
            precision: self.precision,
            table: self.code,
            lookup: self.lookup,
            early_termination: self.early_termination,
            classification: slicecast_scene::Classification::Point,
            pieces: 1,
            colours: None,
            crop: None,
            clips: Vec::new(),
            cueing: None,
            perspective: None,
            modulation: None,
            reflectance: self.reflectance,
            surfaces: Vec::new(),
        }
    }

    /// The frame's plan.
    ///
    /// # Errors
    /// [`CameraError`] if core refuses the view or the sampling.
    pub fn plan(&self) -> Result<Plan, CameraError> {
        Ok(self.rays()?.0)
    }

    /// The plan and, in perspective, its rays.
    fn rays(&self) -> Result<(Plan, Option<Spread>), CameraError> {
        let view = View::new(self.direction.map(|c| Direction::from_bits(c << 28)))?;
        let dims = self.volume.dims.map(|side| side as u32);
        let spacing = Spacing(self.factors.map(Intensity::from_bits));
        let sampling = Sampling {
            planes_per_voxel: self.planes_per_voxel,
            rays_per_voxel: self.rays_per_voxel,
        };
        if let Some(eye) = self.eye {
            let (plan, spread) = Plan::perspective(view, dims, spacing, sampling, eye)?;
            return Ok((plan, Some(spread)));
        }
        let plan = Plan::with_borders(view, dims, spacing, sampling, self.borders)?;
        let plan = match self.crop {
            None => plan,
            Some(crop) => plan.with_crop(crop)?,
        };
        Ok((if self.nearest { plan.with_nearest() } else { plan }, None))
    }

    /// The table as the engine has it.
    pub fn compiled(&self) -> Table {
        let code = self.code.unwrap_or(self.precision.table());
        let mut table = Table {
            entries: Box::new([0; ENTRIES]),
            plane: Box::new([0; ENTRIES]),
            colours: Box::new([[0; 3]; ENTRIES]),
            code,
            lookup: self.lookup.unwrap_or(self.precision.lookup()),
            underflows: 0,
        };
        let slots = table.entries.iter_mut().zip(table.plane.iter_mut());
        for ((slot, low), (_, root)) in slots.zip(self.table.iter()) {
            let [low_byte, high] = root.to_le_bytes();
            *slot = entry([0; 3], high);
            if code != AlphaCodeName::Sqrt8 {
                *low = low_byte;
            }
        }
        for (index, (colour, _)) in self.table.iter().enumerate() {
            let of_byte = |word: u16| 257 * (word >> 8);
            let fine = code == AlphaCodeName::Colour16;
            table.set_colour(index, if fine { *colour } else { colour.map(of_byte) });
        }
        table
    }

    /// The classifier of segments as the engine has it, its surfaces' list as stated.
    ///
    /// # Panics
    /// If core refuses the surfaces.
    pub fn classified(&self) -> Option<Segments> {
        let composited = self.blend.is_composited();
        let stated = self.segments.as_ref().filter(|_| composited)?;
        let integrals = (!stated.alone).then(|| self.integrals(stated.scaled));
        Some(Cut::new(integrals, stated.surfaces.clone().into(), stated.pieces).expect("surfaces that can be drawn"))
    }

    /// The integrals as the engine has them: of extinctions that are the squares of the roots, over 2^13, in whole numbers.
    ///
    /// # Panics
    /// Never: sums of 4096 squares of 16 bits, over 2^13, fit.
    fn integrals(&self, scaled: u32) -> Integrals {
        let mut sums = [0u32; 4];
        let mut lists = [(); 4].map(|()| vec![0]);
        for (colour, root) in self.table.iter() {
            let extinction = (u32::from(*root) * u32::from(*root)) >> 13;
            let [red, green, blue] = colour.map(|c| (u64::from(extinction) * u64::from(c) / 65535) as u32);
            for ((sum, list), part) in sums.iter_mut().zip(&mut lists).zip([extinction, red, green, blue]) {
                *sum += part;
                list.push(*sum);
            }
        }
        let [extinction, colours @ ..] = lists;
        let (first, _) = self.table[0];
        let colours = if self.table.iter().all(|(colour, _)| *colour == first) {
            Colours::One(first.map(|c| colour_of_word(c, 31)))
        } else {
            Colours::Each(colours)
        };
        let cumulative = Cumulative {
            extinction,
            colours,
            grain: 0,
            exponent: 18,
        };
        cumulative.classifier(Length { scaled, bits: 27 })
    }

    /// Gives the prepared frame and its slices to `run`.
    ///
    /// # Panics
    /// If core refuses the frame: tests state frames that it takes.
    pub fn with_prepared<R>(&self, run: impl FnOnce(&Prepared<'_>, &[Slice<'_>]) -> R) -> R {
        let (plan, spread) = self.rays().expect("a frame that has a plan");
        let scene = self.scene();
        let prepared = Prepared {
            scene: &scene,
            volume: &self.volume,
            setup: Setup {
                picture: picture(&plan),
                material: self.material.clone(),
                step_length: 1.0,
                additive: ADDITIVE,
                spread,
                clips: clips(&plan, &self.clips, self.cue.as_ref()),
                plan,
            },
            table: self.compiled(),
            segments: self.classified(),
            modulation: self.modulation.clone(),
            finest: None,
            simd: Simd::widest(),
        };
        let mut turned = Turned::new(&self.volume, &plan);
        run(&prepared, &turned.slices().expect("12-bit voxels"))
    }
}

/// Clip planes of a plan, and its depth cueing; `None` where there is neither.
pub(crate) fn clips(plan: &Plan, clips: &[Clip], cue: Option<&Cue>) -> Option<Clips> {
    let made = || {
        let clips = Clips::new(plan, clips)?;
        cue.map_or(Ok(clips.clone()), |cue| clips.with_cue(plan, cue))
    };
    (!clips.is_empty() || cue.is_some()).then(|| made().expect("good clip planes"))
}

/// A picture of 48 x 40 pixels that turns and shrinks the base plane a little, so that the warp has work to do.
pub(crate) fn picture(plan: &Plan) -> Picture {
    let rays = i64::from(plan.sampling().rays_per_voxel);
    let [w, h] = plan.base().map(|side| (i64::from(side) * rays) << 32);
    let step = Step::from_bits;
    Picture {
        size: [48, 40],
        warp: Warp {
            origin: [step(-w / 16), step(h / 23)],
            right: [step(w / 47), step(-h / 390)],
            down: [step(w / 410), step(h / 39)],
        },
        affine: [[0.0; 2]; 3],
    }
}

/// A table from points `(code, colour, root)`, linear in integers between them, constant outside; colours of 8 bits.
///
/// # Panics
/// Without a point.
pub fn table_of(points: &[(u16, [u8; 3], u16)]) -> Arc<[([u16; 3], u16); ENTRIES]> {
    between(points, i64::from, |byte| 257 * byte as u16)
}

/// [`table_of`] with colours of 16 bits.
///
/// # Panics
/// Without a point.
pub fn fine_table_of(points: &[(u16, [u16; 3], u16)]) -> Arc<[([u16; 3], u16); ENTRIES]> {
    between(points, i64::from, |word| word as u16)
}

fn between<C: Copy>(
    points: &[(u16, [C; 3], u16)],
    number: impl Fn(C) -> i64,
    colour: impl Fn(i64) -> u16,
) -> Arc<[([u16; 3], u16); ENTRIES]> {
    let mut table = [([0; 3], 0); ENTRIES];
    for (code, slot) in table.iter_mut().enumerate() {
        let passed = points.iter().take_while(|p| usize::from(p.0) <= code).count();
        let a = points[passed.saturating_sub(1)];
        let b = points[passed.min(points.len() - 1)];
        let (from, span) = (i64::from(a.0), i64::from(b.0) - i64::from(a.0));
        let mix = |a: i64, b: i64| {
            if span == 0 {
                a
            } else {
                a + (b - a) * (code as i64 - from) / span
            }
        };
        let channel = |c: usize| colour(mix(number(a.1[c]), number(b.1[c])));
        *slot = ([0, 1, 2].map(channel), mix(i64::from(a.2), i64::from(b.2)) as u16);
    }
    Arc::new(table)
}
