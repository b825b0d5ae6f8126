//! Squeeze's figure 1 and its teaser, and the pipelines of 8 bits side by side, as pictures and as tables.

use serde::Serialize;
use slicecast::classify::{Sqrt8, Sqrt16};
use slicecast::precision::{Compact, Precision};
use slicecast_compare::image::{ImageFigures, heat_map, model_figures, model_picture};
use slicecast_compare::{ModelPositions, model};
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::image::Rgb;
use slicecast_engine::progress::Progress;
use slicecast_engine::tile::TILE_ROWS;
use slicecast_model::{Affine, ModelImage};
use slicecast_scene::file::built_in;
use slicecast_scene::{Borders, Image, LookupName, Point, PrecisionName, Sampling, Scene, TransferFunction};
use slicecast_volume::Volume;

use super::arithmetic::Product;
use super::{Line, Order, Texture8, compare, shares};
use crate::channels::Scale;
use crate::codes::{Plain8, Plain16};
use crate::formats::Study;
use crate::measure::{Kind, Runner};
use crate::pixels::{Arithmetic, StudyPixel};

/// Pictures side by side, each with what it shows.
pub type Row = Vec<(String, Rgb)>;

/// What is drawn of a CT: its name, and the built-in scene that it is made of.
const SCENES: [(&str, &str, bool); 6] = [
    ("bone", "ct-bone", false),
    ("bone, highlights", "ct-bone", true),
    ("soft tissue", "ct-soft-tissue", false),
    ("skin over bone", "headsq", false),
    ("fog", "ct-fog", false),
    ("fog, 8 planes", "ct-fog8", false),
];

/// A built-in scene, perhaps without highlights, which hardware without them is measured by.
fn scene(name: &str, highlights: bool) -> Scene {
    let mut scene = built_in(name).expect("a built-in scene");
    if let (Some(lighting), false) = (&mut scene.lighting, highlights) {
        lighting.specular = 0.0;
    }
    scene
}

/// The figures of a scene.
#[derive(Clone, Debug, Serialize)]
pub struct Compared {
    /// Which one.
    pub scene: &'static str,
    /// Each pipeline's.
    pub lines: Vec<Line>,
}

/// Every scene by every pipeline.
///
/// # Errors
/// [`RenderError`] if a scene cannot be rendered.
pub fn tables(volume: &Volume, progress: Progress<'_>) -> Result<Vec<Compared>, RenderError> {
    let mut all = Vec::new();
    for (done, (name, built_in, highlights)) in SCENES.into_iter().enumerate() {
        progress(done, SCENES.len());
        let scene = scene(built_in, highlights);
        let prepared = Prepared::new(&scene, volume)?;
        let lines = compare(&prepared, &Texture8::ALL, &|_, _| ())?;
        all.push(Compared { scene: name, lines });
    }
    progress(SCENES.len(), SCENES.len());
    Ok(all)
}

/// The scene with pictures of this size.
fn sized(scene: Scene, size: [u32; 2]) -> Scene {
    Scene {
        image: Image {
            size: Some(size),
            ..scene.image
        },
        ..scene
    }
}

/// A base plane as the scene's picture shows it.
fn shown(prepared: &Prepared<'_>, base: &ModelImage) -> Rgb {
    let [origin, right, down] = prepared.setup.picture.affine;
    let map = Affine {
        u: [origin[0], right[0], down[0]],
        v: [origin[1], right[1], down[1]],
    };
    let size = prepared.setup.picture.size.map(|side| side as usize);
    model_picture(&base.warp(size, map), prepared.scene.image.background)
}

/// The picture of a scene by the pipelines of 8 bits.
///
/// # Errors
/// As [`Texture8::render`].
pub fn picture(prepared: &Prepared<'_>, pipeline: Texture8) -> Result<Rgb, RenderError> {
    Ok(shown(prepared, &pipeline.render(prepared)?))
}

/// The scenes by f64, by their own precision, and by pipelines of 8 bits: a row each.
///
/// # Errors
/// [`RenderError`] if a scene cannot be rendered.
pub fn sheet(volume: &Volume, size: [u32; 2]) -> Result<Vec<Row>, RenderError> {
    let pipelines = [
        Texture8::of(Order::Normalised, Product::Blinn),
        Texture8::of(Order::After, Product::Blinn),
        Texture8::of(Order::After, Product::Shift),
        Texture8::of(Order::Before, Product::Blinn),
        Texture8::of(Order::Weighted, Product::Blinn),
    ];
    let row = |(name, built_in, highlights)| {
        let scene = sized(scene(built_in, highlights), size);
        let prepared = Prepared::new(&scene, volume)?;
        let own = prepared.render(Layer::Tiles(TILE_ROWS), &|_, _| ())?.picture;
        let mut row = vec![(format!("{name}: {}", scene.precision.name()), own)];
        for pipeline in pipelines {
            row.push((pipeline.name().to_owned(), picture(&prepared, pipeline)?));
        }
        Ok(row)
    };
    SCENES.into_iter().map(row).collect()
}

/// How far a code of opacities is from f64.
#[derive(Clone, Debug, Serialize)]
pub struct OfCode {
    /// The code.
    pub code: &'static str,
    /// Its error.
    pub image: ImageFigures,
}

/// Steps of 1/255 that are white in a picture of errors.
const WHITE: f64 = 16.0;

/// Thin soft tissue over bone, unlit: opacities of a few thousandths a millimetre.
fn thin_tissue() -> Scene {
    let point = |value, [r, g, b]: [u8; 3], opacity| Point {
        value,
        colour: [r, g, b].map(|c| f64::from(c) / 255.0),
        opacity,
    };
    Scene {
        transfer: TransferFunction {
            unit_distance: 1.0,
            points: vec![
                point(-400.0, [224, 168, 140], 0.0),
                point(-100.0, [224, 168, 140], 0.0015),
                point(40.0, [206, 92, 80], 0.004),
                point(100.0, [206, 92, 80], 0.007),
                point(250.0, [250, 240, 220], 0.02),
                point(1000.0, [250, 240, 220], 0.06),
            ],
        },
        sampling: Sampling {
            planes_per_voxel: 8,
            rays_per_voxel: 1,
        },
        borders: Borders::Whole,
        ..scene("ct-fog", false)
    }
}

/// Figure 1: thin soft tissue by codes of a table's opacities, and below each its error against f64, white from 16 steps on.
///
/// # Errors
/// [`RenderError`] if the scene cannot be rendered.
pub fn figure_1(volume: &Volume, size: [u32; 2]) -> Result<(Vec<Row>, Vec<OfCode>), RenderError> {
    let scene = sized(thin_tissue(), size);
    let prepared = Prepared::new(&scene, volume)?;
    let exact = model(&prepared, ModelPositions::Pipeline).render();
    let compact = Kind::Named(PrecisionName::Compact);
    let codes = [
        ("alpha 0.8", Runner::of::<Plain8>(compact, LookupName::Linear)),
        ("root 0.8", Runner::of::<Sqrt8>(compact, LookupName::Linear)),
        ("alpha 0.16", Runner::of::<Plain16>(compact, LookupName::Linear)),
        ("root 0.16", Runner::of::<Sqrt16>(compact, LookupName::Linear)),
    ];
    let (mut pictures, mut errors, mut figures) = (Row::new(), Row::new(), Vec::new());
    for (code, runner) in codes {
        let base = runner.render(&prepared)?;
        let found = shares(&base);
        let image = model_figures(&found, &exact);
        pictures.push((code.to_owned(), shown(&prepared, &found)));
        errors.push((format!("mean {:.2}, max {:.1}", image.mean_lsb8, image.max_lsb8), {
            let heat = heat_map(&base, &exact, WHITE);
            shown(&prepared, &of_bytes(&heat))
        }));
        figures.push(OfCode { code, image });
    }
    pictures.push(("f64".to_owned(), shown(&prepared, &exact)));
    Ok((vec![pictures, errors], figures))
}

/// A picture as a base plane of opaque pixels.
fn of_bytes(picture: &Rgb) -> ModelImage {
    let channel = |c| {
        let bytes = picture.bytes.iter().skip(c).step_by(3);
        bytes.map(|byte| f64::from(*byte) / 255.0).collect::<Vec<_>>()
    };
    ModelImage {
        size: picture.size.map(|side| side as usize),
        rgb: [channel(0), channel(1), channel(2)],
        t: vec![0.0; picture.bytes.len() / 3],
    }
}

/// A frame buffer of so many bits, in fog that is as thin as they allow.
#[derive(Clone, Debug, Serialize)]
pub struct OfBits {
    /// Fraction bits.
    pub bits: u32,
    /// Error of the truncated frame buffer, against f64 of the same opacities.
    pub truncated: ImageFigures,
    /// The same of `compact`.
    pub compact: ImageFigures,
    /// The largest opacity of a pixel's fog, percent: f64, and the truncated frame buffer's of the same pixel.
    pub fog: [f64; 2],
}

/// Fraction bits of the teaser's frame buffers.
const BITS: [u32; 6] = [8, 10, 12, 14, 15, 16];

/// Samples of a ray of the teaser: 512 voxels, two each.
const SAMPLES: u32 = 1024;

/// Bone in fog of 2^-b a sample, everywhere, as many samples deep as the paper's, or as 16 a voxel make of the volume. Most light is
/// ambient: fog has hardly a gradient.
fn least_fog(bits: u32, volume: &Volume) -> Result<Scene, RenderError> {
    let fog = f64::from(bits).exp2().recip();
    let point = |value, grey: [f64; 3], opacity| Point {
        value,
        colour: grey,
        opacity,
    };
    let (white, bone) = ([0.75, 0.8, 0.85], [0.95, 0.91, 0.82]);
    let mut scene = Scene {
        transfer: TransferFunction {
            unit_distance: 1.0,
            points: vec![
                point(200.0, white, fog),
                point(201.0, bone, fog),
                point(400.0, bone, 0.5),
            ],
        },
        borders: Borders::Whole,
        ..scene("ct-bone", false)
    };
    if let Some(lighting) = &mut scene.lighting {
        (lighting.ambient, lighting.diffuse) = (0.6, 0.4);
    }
    let [.., deep] = Prepared::new(&scene, volume)?.setup.plan.dims();
    scene.sampling = Sampling {
        planes_per_voxel: (SAMPLES / deep.max(1)).clamp(1, 16),
        rays_per_voxel: 1,
    };
    // Opacities are those of a step.
    scene.transfer.unit_distance = Prepared::new(&scene, volume)?.setup.step_length;
    Ok(scene)
}

/// The teaser: bone in fog of the least opacity that a frame buffer of so many bits takes, by that frame buffer (1.b, products
/// truncated), by `compact`, and in f64.
///
/// # Errors
/// [`RenderError`] if a scene cannot be rendered.
pub fn teaser(volume: &Volume, size: [u32; 2]) -> Result<(Vec<Row>, Vec<OfBits>), RenderError> {
    let (mut rows, mut figures) = ([Row::new(), Row::new(), Row::new()], Vec::new());
    for bits in BITS {
        let scene = sized(least_fog(bits, volume)?, size);
        let prepared = Prepared::new(&scene, volume)?;
        let exact = model(&prepared, ModelPositions::Pipeline).render();
        let by = |kind| Runner::of::<Plain16>(kind, LookupName::Nearest).render(&prepared);
        let pixel = StudyPixel::new(Arithmetic::Product { rounded: false }, Scale::Binary(bits));
        let study = pixel.map(|pixel| Study {
            formats: Compact.formats(),
            pixel,
        });
        // Every width of the list is one.
        let truncated = match study {
            Some(study) => shares(&by(Kind::Study(study))?),
            None => exact.clone(),
        };
        let compact = shares(&by(Kind::Named(PrecisionName::Compact))?);
        let images = [&truncated, &compact, &exact];
        let names = [format!("b = {bits}, truncated"), "compact".into(), "f64".into()];
        for ((row, name), image) in rows.iter_mut().zip(names).zip(images) {
            row.push((name, shown(&prepared, image)));
        }
        figures.push(OfBits {
            bits,
            truncated: model_figures(&truncated, &exact),
            compact: model_figures(&compact, &exact),
            fog: thickest_fog(&exact, &truncated, &prepared),
        });
    }
    Ok((rows.into(), figures))
}

/// The largest opacity among rays through fog alone, of which a ray cannot have more than all its samples; percent.
fn thickest_fog(exact: &ModelImage, found: &ModelImage, prepared: &Prepared<'_>) -> [f64; 2] {
    let model = model(prepared, ModelPositions::Pipeline);
    let fog = prepared
        .scene
        .transfer
        .points
        .first()
        .map_or(0.0, |point| point.opacity);
    let most = (1.0 - fog).powi(model.planes() as i32);
    let rays = (0..exact.t.len()).filter(|index| exact.t[*index] >= most - 1e-9);
    let thickest = rays.min_by(|a, b| exact.t[*a].total_cmp(&exact.t[*b]));
    thickest.map_or([0.0; 2], |index| {
        [exact, found].map(|image| 100.0 * (1.0 - image.t[index]))
    })
}
