//! A scene whose voxels are splatted: bins of records, made in runs of slices, and bands of rows, on all cores.
//!
//! The image is aligned with the picture; pixels are as long as the volume's shortest voxel side divided by the rays per voxel, sheets
//! as thick as it divided by the planes per voxel. The picture is this image enlarged or reduced. In perspective the image is the
//! picture, or some times as fine.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use slicecast::classify::Support;
use slicecast::composite::{Channel as _, ChannelFormat, FrontToBack, Pixel, Recurrence};
use slicecast::format::{Direction, Intensity, Step};
use slicecast::lanes::Lanes;
use slicecast::plane::{BandMemory, Composite, FoldSheet, Pictured, fold_band};
use slicecast::precision::Precision;
use slicecast::shade::Unlit;
use slicecast::slice::RowRange;
use slicecast::splat::{BLOCK, Bands, Bins, Kernel, Layout, Needed, PIXELS, Sheets, Splatting, Voxels, measure_layer};
use slicecast::view::View;
use slicecast::warp::Warp;
use slicecast_engine::camera::{Material, PICTURE_SIDE_MAX, Picture, check_spacing, extent, fitting_pixel, size_at};
use slicecast_engine::error::{CameraError, RenderError};
use slicecast_engine::expanded::Expanded;
use slicecast_engine::frame::Prepared;
use slicecast_engine::image::{BaseImage, Frame};
use slicecast_engine::perspective::Camera;
use slicecast_engine::picture::of_base;
use slicecast_engine::pipelines::{compile, early};
use slicecast_engine::progress::Progress;
use slicecast_engine::simd::{OverLanes, Simd, with_lanes};
use slicecast_engine::table::Table;
use slicecast_engine::with_precision;
use slicecast_scene::perspective::Perspective;
use slicecast_scene::{
    Blend, CameraAxes, Classification, Frame as Frames, Interpolation, Light, Lighting, PrecisionName, Scene,
};
use slicecast_volume::Volume;

/// Rows of a band.
pub const BAND_ROWS: u32 = 16;

/// The most memory that records may take, bytes.
const RECORD_BYTES_MAX: u64 = 8 << 30;

/// The picture's own axes, as light is given in them: x to the right, y down, z away from the eye.
const AXES: CameraAxes = CameraAxes {
    right: [1.0, 0.0, 0.0],
    up: [0.0, -1.0, 0.0],
    forward: [0.0, 0.0, 1.0],
};

/// A scene on a volume, ready to be splatted.
#[derive(Clone, Debug)]
pub struct Splatted<'a> {
    scene: &'a Scene,
    volume: &'a Volume,
    /// How the volume lies in the image.
    pub splatting: Splatting,
    /// The picture.
    pub picture: Picture,
    /// The table of points.
    pub table: Table,
    material: Option<Material>,
    spacing: [Intensity; 3],
    simd: Simd,
}

/// Records in the caller's hands: of runs of slices, each with bins of its own.
#[derive(Clone, Debug)]
pub struct Records {
    runs: Vec<Run>,
    bands: Bands,
}

#[derive(Clone, Debug)]
struct Run {
    starts: Vec<u32>,
    records: Vec<u64>,
}

impl Records {
    /// How many records there are.
    pub fn count(&self) -> usize {
        self.runs.iter().map(|run| run.records.len()).sum()
    }
}

impl<'a> Splatted<'a> {
    /// Prepares a scene whose voxels are kept in records of this layout.
    ///
    /// # Errors
    /// [`RenderError::Unsplattable`] for what splatting does not know, [`RenderError::Splat`] and [`RenderError::Camera`] for what is out of
    /// range.
    pub fn new(scene: &'a Scene, volume: &'a Volume, layout: Layout) -> Result<Self, RenderError> {
        check(scene)?;
        if let Some(perspective) = &scene.perspective {
            return from_eye(scene, perspective, volume, layout);
        }
        let (dims, spacing) = (volume.dims, volume.spacing);
        check_spacing(spacing)?;
        let CameraAxes { right, up, forward } = scene.view.axes();
        let finest = spacing.iter().copied().fold(f64::INFINITY, f64::min);
        let pixel = finest / f64::from(scene.sampling.rays_per_voxel);
        let sheet = finest / f64::from(scene.sampling.planes_per_voxel);
        let extent = extent(scene, dims, spacing);
        let size = scene.image.size.unwrap_or_else(|| size_at(extent, pixel));
        let [width, height] = size;
        if size.iter().any(|side| !(1..=PICTURE_SIDE_MAX).contains(side)) {
            return Err(CameraError::Picture { width, height }.into());
        }
        let steps = [0, 1, 2].map(|m| {
            [
                right[m] * spacing[m] / pixel,
                -up[m] * spacing[m] / pixel,
                forward[m] * spacing[m] / sheet,
            ]
        });
        let along = |axis: usize| (0..3).map(move |m| steps[m][axis] * (dims[m] as f64 - 1.0));
        // As odd or even as the picture, so that pixels fall on pixels where both are equally fine.
        let across = [0, 1].map(|axis| {
            let across = along(axis)
                .map(f64::abs)
                .sum::<f64>()
                .ceil()
                .min(f64::from(u32::MAX / 2)) as u32
                + 1;
            across + (across + size[axis]) % 2
        });
        let origin = [0, 1].map(|axis| (f64::from(across[axis]) - 1.0 - along(axis).sum::<f64>()) / 2.0);
        let step = |c: f64| Step::from_bits((c * 4294967296.0).round() as i64);
        let splatting = Splatting::new(
            dims.map(|side| u32::try_from(side).unwrap_or(u32::MAX)),
            origin.map(step),
            steps.map(|s| s.map(step)),
            across,
            layout,
        )?;
        let shown = fitting_pixel(extent, size) / scene.image.zoom;
        let scale = if shown > 0.0 { shown / pixel } else { 1.0 };
        let first = [0, 1].map(|axis| (f64::from(across[axis]) - 1.0 - (f64::from(size[axis]) - 1.0) * scale) / 2.0);
        let shorter = pixel.min(sheet);
        let factor = |length: f64| Intensity::from_bits((shorter / length * 32768.0).round() as u16);
        Ok(Self {
            picture: Picture {
                size,
                warp: Warp {
                    origin: first.map(step),
                    right: [step(scale), Step::ZERO],
                    down: [Step::ZERO, step(scale)],
                },
                affine: [first, [scale, 0.0], [0.0, scale]],
            },
            table: compile(scene, &volume.mapping, sheet),
            material: match &scene.lighting {
                Some(lighting) => Some(material(lighting, &scene.view.axes())?),
                None => None,
            },
            spacing: [factor(pixel), factor(pixel), factor(sheet)],
            splatting,
            scene,
            volume,
            simd: Simd::widest(),
        })
    }

    /// A prepared scene whose volume lies so in an image that is the picture, with lights in the image's frame and these spacing factors
    /// of gradients: for frames that are stated in integers.
    pub fn of(prepared: &Prepared<'a>, splatting: Splatting, spacing: [Intensity; 3]) -> Self {
        Self {
            scene: prepared.scene,
            volume: prepared.volume,
            picture: Picture {
                size: splatting.size(),
                warp: Warp::IDENTITY,
                affine: [[0.0; 2], [1.0, 0.0], [0.0, 1.0]],
            },
            table: prepared.table.clone(),
            material: prepared.setup.material.clone(),
            spacing,
            splatting,
            simd: prepared.simd,
        }
    }

    /// The same, with these vectors.
    #[must_use]
    pub fn with_simd(self, simd: Simd) -> Self {
        Self { simd, ..self }
    }

    /// Renders the frame. `progress` is told how many bands of how many are done.
    ///
    /// # Errors
    /// As [`Splatted::records`].
    pub fn render(&self, progress: Progress<'_>) -> Result<Frame, RenderError> {
        let base = self.image(&self.records(true, BAND_ROWS)?, progress)?;
        Ok(self.frame(base))
    }

    /// The frame of an image.
    pub fn frame(&self, base: BaseImage) -> Frame {
        let Scene { precision, image, .. } = self.scene;
        let picture = of_base(&base, *precision, &self.picture, image.background, self.simd);
        Frame { base, picture }
    }

    /// The records of the voxels that are needed, or of all, for bands of so many rows.
    ///
    /// # Errors
    /// [`RenderError::Splat`] if a voxel has more than 12 bits, [`RenderError::Records`] before too much is allocated.
    pub fn records(&self, needed: bool, band_rows: u32) -> Result<Records, RenderError> {
        let (splatting, voxels) = (&self.splatting, &self.volume.voxels);
        let ([width, height, depth], bands) = (splatting.dims(), Bands::new(band_rows, self.scene.lighting.is_some()));
        let slice = width as usize * height as usize;
        let of_slices = |slices: Range<u32>| {
            let (first, end) = (slices.start as usize * slice, slices.end as usize * slice);
            Voxels::new(splatting, slices, &voxels[first..end])
        };
        let mut blocks = vec![0; if needed { Needed::len(splatting) } else { 0 }];
        let needed = if needed {
            Some(self.needed(&of_slices, &mut blocks)?)
        } else {
            None
        };
        // A few runs for each thread: slices differ in what is needed of them.
        let runs = 4 * rayon::current_num_threads() as u32;
        let len = depth.div_ceil(runs).next_multiple_of(BLOCK);
        let firsts: Vec<u32> = (0..depth).step_by(len as usize).collect();
        let counted: Vec<_> = (firsts.into_par_iter())
            .map(|first| {
                let slices = first..(first + len).min(depth);
                let mut starts = vec![0; Bins::len(splatting, bands)];
                let count = Bins::count(
                    splatting,
                    bands,
                    &of_slices(slices.clone())?,
                    needed.as_ref(),
                    &mut starts,
                )?;
                Ok((slices, starts, count))
            })
            .collect::<Result<_, RenderError>>()?;
        let bytes = counted.iter().map(|(_, _, count)| 8 * *count as u64).sum();
        if bytes > RECORD_BYTES_MAX {
            let limit = RECORD_BYTES_MAX;
            return Err(RenderError::Records { bytes, limit });
        }
        let runs = (counted.into_par_iter())
            .map(|(slices, mut starts, count)| {
                let mut records = vec![0; count];
                let voxels = of_slices(slices)?;
                Bins::fill(splatting, bands, &voxels, needed.as_ref(), &mut starts, &mut records)?;
                Ok(Run { starts, records })
            })
            .collect::<Result<_, RenderError>>()?;
        Ok(Records { runs, bands })
    }

    /// The blocks that are needed.
    fn needed<'b>(
        &self,
        of_slices: &(dyn Fn(Range<u32>) -> Result<Voxels<'a>, slicecast::splat::SplatError> + Sync),
        blocks: &'b mut [u8],
    ) -> Result<Needed<'b>, RenderError> {
        let splatting = &self.splatting;
        let ([across, down, _], [_, _, depth]) = (Needed::sides(splatting), splatting.dims());
        let mut ranges = vec![RowRange::EMPTY; blocks.len()];
        ranges
            .par_chunks_mut((across * down) as usize)
            .enumerate()
            .try_for_each(|(layer, ranges)| {
                let first = layer as u32 * BLOCK;
                let voxels = of_slices(first..(first + BLOCK).min(depth))?;
                measure_layer(splatting, &voxels, ranges)
            })?;
        Ok(Needed::find(splatting, &ranges, self.support(), blocks)?)
    }

    fn support(&self) -> Support {
        use slicecast::classify::Classifier;
        Classifier::<slicecast::precision::Compact>::support(&self.table.expanded())
    }

    /// The image of records.
    ///
    /// # Errors
    /// [`RenderError::Splat`] if they are another splatting's, [`RenderError::Camera`] if the material has been changed.
    pub fn image(&self, records: &Records, progress: Progress<'_>) -> Result<BaseImage, RenderError> {
        with_precision!(self.scene.precision, p => self.image_in(p, records, progress))
    }

    fn image_in<P: Precision<Pixel: Recurrence<Channel: ChannelFormat>>>(
        &self,
        p: P,
        records: &Records,
        progress: Progress<'_>,
    ) -> Result<BaseImage, RenderError> {
        let (table, bits): (Expanded, _) = (self.table.expanded(), self.scene.early_termination);
        match &self.material {
            Some(material) => {
                let phong = material.phong(p).map_err(CameraError::from)?;
                let pipeline = Composite::<_, _, _, FrontToBack>::new(p, table, phong);
                self.folded(&early(pipeline, bits), records, progress)
            }
            None => {
                let pipeline = Composite::<_, _, _, FrontToBack>::new(p, table, Unlit);
                self.folded(&early(pipeline, bits), records, progress)
            }
        }
    }

    fn folded<L: Pictured + FoldSheet>(
        &self,
        pipeline: &L,
        records: &Records,
        progress: Progress<'_>,
    ) -> Result<BaseImage, RenderError> {
        let (splatting, bands) = (&self.splatting, records.bands);
        let size = splatting.size().map(|side| side as usize);
        let row_len = 4 * size[0];
        let mut image = vec![L::Element::default(); row_len * size[1]];
        for (number, run) in image.chunks_mut(size[0]).enumerate() {
            run.fill(pipeline.empty(number % 4));
        }
        let mut tables = vec![0; Kernel::len(splatting)];
        Kernel::fill(splatting, &mut tables)?;
        let kernel = Kernel::of(splatting, &tables)?;
        let bins: Vec<Bins<'_>> = records
            .runs
            .iter()
            .map(|run| Bins::of(splatting, &run.starts, &run.records))
            .collect();
        let [sums, samples] = Sheets::len(splatting, bands.most(), L::LIT);
        let (done, total) = (AtomicUsize::new(0), bands.count(splatting) as usize);
        let (_, rows) = bands.rows(splatting, 0);
        image
            .par_chunks_mut(row_len * rows as usize)
            .enumerate()
            .with_max_len(1)
            .try_for_each_init(
                || {
                    (
                        vec![0; sums],
                        vec![0; samples],
                        vec![0; L::SCRATCH.len(splatting.size()[0]) + 1024],
                        vec![0; bands.rays_len(splatting)],
                    )
                },
                |(sums, samples, scratch, rays), (band, data)| {
                    let fold = FoldBand {
                        pipeline,
                        frame: (splatting, kernel, self.spacing),
                        bins: &bins,
                        band: (bands, band as u32),
                        data,
                        memory: BandMemory {
                            sums,
                            samples,
                            scratch,
                            rays,
                        },
                    };
                    with_lanes(self.simd, fold)?;
                    progress(done.fetch_add(1, Ordering::Relaxed) + 1, total);
                    Ok::<_, RenderError>(())
                },
            )?;
        let pixel = pipeline.precision().pixel();
        let mut planes = [(); 4].map(|()| Vec::with_capacity(size[0] * size[1]));
        for row in image.chunks(row_len) {
            for column in 0..size[0] {
                let Pixel {
                    colour: [r, g, b],
                    transparency,
                } = pipeline.pixel(row, column);
                for (plane, channel) in planes.iter_mut().zip([r, g, b, transparency]) {
                    plane.push(channel.bits());
                }
            }
        }
        Ok(BaseImage {
            size,
            format: pixel.format(),
            one: pixel.one().bits(),
            planes,
        })
    }
}

/// A band, with vectors to be chosen.
struct FoldBand<'f, L: FoldSheet> {
    pipeline: &'f L,
    frame: (&'f Splatting, Kernel<'f>, [Intensity; 3]),
    bins: &'f [Bins<'f>],
    band: (Bands, u32),
    data: &'f mut [L::Element],
    memory: BandMemory<'f>,
}

impl<L: FoldSheet> OverLanes for FoldBand<'_, L> {
    type Output = Result<(), slicecast::splat::SplatError>;

    fn run<V: Lanes>(self) -> Self::Output {
        fold_band::<L, V>(self.pipeline, self.frame, self.bins, self.band, self.data, self.memory)
    }
}

/// What a pixel in the farthest sheet may be longer than a voxel divided by the rays per voxel, before the image is made finer.
const COARSER: f64 = 0.05;

/// A scene in perspective. The image is the picture, or so many times finer that in the farthest sheet pixels are no longer than a voxel's
/// shortest side divided by the rays per voxel.
fn from_eye<'a>(
    scene: &'a Scene,
    perspective: &Perspective,
    volume: &'a Volume,
    layout: Layout,
) -> Result<Splatted<'a>, RenderError> {
    let Camera {
        eye,
        axes: CameraAxes { right, up, forward },
        size,
        pixel,
        spacing,
    } = Camera::of(scene, perspective, volume)?;
    let finest = spacing.iter().copied().fold(f64::INFINITY, f64::min);
    let sheet = finest / f64::from(scene.sampling.planes_per_voxel);
    let frame = [right, up.map(|c| -c), forward];
    let steps = [0, 1, 2].map(|m| frame.map(|axis| axis[m] * spacing[m] / sheet));
    let first = [0, 1, 2].map(|axis| -(0..3).map(|m| eye[m] * steps[m][axis]).sum::<f64>());
    let deepest: f64 = (0..3)
        .map(|m| (steps[m][2] * (volume.dims[m] as f64 - 1.0)).max(0.0))
        .sum();
    let coarsest = pixel * (first[2] + deepest) * sheet * f64::from(scene.sampling.rays_per_voxel) / finest;
    let finer = (coarsest - COARSER).ceil().clamp(1.0, f64::from(PIXELS)) as u32;
    let distance = (f64::from(finer) / pixel * 65536.0)
        .round()
        .clamp(0.0, f64::from(u32::MAX)) as u32;
    let step = |c: f64| Step::from_bits((c * 4294967296.0).round() as i64);
    let splatting = Splatting::from_eye(
        volume.dims.map(|side| u32::try_from(side).unwrap_or(u32::MAX)),
        first.map(step),
        steps.map(|s| s.map(step)),
        (distance, size.map(|side| side.saturating_mul(finer))),
        layout,
    )?;
    let (scale, middle) = (f64::from(finer), (f64::from(finer) - 1.0) / 2.0);
    Ok(Splatted {
        picture: Picture {
            size,
            warp: Warp {
                origin: [step(middle); 2],
                right: [step(scale), Step::ZERO],
                down: [Step::ZERO, step(scale)],
            },
            affine: [[middle; 2], [scale, 0.0], [0.0, scale]],
        },
        table: compile(scene, &volume.mapping, sheet),
        material: match &scene.lighting {
            Some(lighting) => Some(material(lighting, &scene.view.axes())?),
            None => None,
        },
        // Sheets have their own.
        spacing: [Intensity::ONE; 3],
        splatting,
        scene,
        volume,
        simd: Simd::widest(),
    })
}

/// The lights of a scene in the frame of its picture.
fn material(lighting: &Lighting, CameraAxes { right, up, forward }: &CameraAxes) -> Result<Material, CameraError> {
    let along = |axis: &[f64; 3], v: [f64; 3]| (0..3).map(|m| axis[m] * v[m]).sum::<f64>();
    let seen = |light: &Light| match light.frame {
        Frames::Camera => *light,
        Frames::Volume => Light {
            direction: [
                along(right, light.direction),
                along(up, light.direction),
                -along(forward, light.direction),
            ],
            frame: Frames::Camera,
            ..*light
        },
    };
    let lighting = Lighting {
        lights: lighting.lights.iter().map(seen).collect(),
        ..lighting.clone()
    };
    let view = View::new([Direction::ZERO, Direction::ZERO, Direction::ONE])?;
    Material::new(&lighting, &AXES, &view)
}

/// Refuses what splatting does not know.
fn check(scene: &Scene) -> Result<(), RenderError> {
    let samples = matches!(scene.classification, Classification::Point | Classification::Auto);
    for (field, known, expected) in [
        (
            "sampling.interpolation",
            scene.interpolation == Interpolation::Linear,
            "\"linear\"",
        ),
        ("crop", scene.crop.is_none(), "no crop box"),
        ("clip", scene.clips.is_empty(), "no clip planes"),
        ("cueing", scene.cueing.is_none(), "no depth cueing"),
        ("modulation", scene.modulation.is_none(), "no modulation"),
        ("reflectance", scene.reflectance.is_none(), "no reflectance map"),
        (
            "render.classification",
            samples,
            "\"point\" or \"auto\", which is then \"point\"",
        ),
        ("surfaces", scene.surfaces.is_empty(), "no surfaces"),
        (
            "render.precision",
            scene.precision != PrecisionName::Fast,
            "\"paper\", \"compact\" or \"wide\"",
        ),
        ("render.blend", scene.blend == Blend::FrontToBack, "\"front-to-back\""),
    ] {
        if !known {
            return Err(RenderError::Unsplattable { field, expected });
        }
    }
    Ok(())
}
