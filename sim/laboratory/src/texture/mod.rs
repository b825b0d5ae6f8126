//! What texture hardware of Squeeze's time computes (its sections 3, 4.1.2, 4.4 and 4.5): everything in 8 bits. A comparator: none
//! of it is in the library, and nothing of the pipeline's arithmetic is here.
//!
//! | value | bits | made |
//! |---|---|---|
//! | voxel | 8 | `round(255 (v - low) / (high - low))` of the volume's codes, low and high its smallest and largest |
//! | normal | 3 x 8, signed about 128 | before the frame, of each voxel's own central differences; `-G / abs(G)` times 127 to nearest; between voxels shorter than 1, or brought to 127 again by a cube map |
//! | table | 256 x (3 x 8 colour, 8 opacity) | before the frame: the transfer function at a voxel's value, corrected for the step (equation 7) |
//! | light, coefficients | 8 | before the frame; ambient and diffuse, no specular |
//! | place of a sample | 8 fraction bits | the pipeline's own place, to nearest |
//! | filtered texel | 4 x 8 | exact sum of eight, rounded once |
//! | colour times light, opacity, transparency | 8 | a [`Product`] each |
//! | frame buffer | 4 x 8 | equations 4 and 6, saturating |
//!
//! What is made before the frame is made in f64 and rounded, as programs of that time did; what hardware does for each sample is in
//! integers. Rays and planes are those of the pipeline, so that pictures align. A sample counts as a whole step or not at all: where
//! half of its step, or more, is in the volume.
//!
//! | classification | texels | behind the filter |
//! |---|---|---|
//! | after | value and normal | table, light, colour times opacity |
//! | after, normalised | value and normal | the same, light by the normal's direction |
//! | before | red, green, blue and opacity of voxels, lit | colour times opacity |
//! | before, weighted | the same, colour times opacity (opacity-weighted colours, Wittenbrink et al.) | nothing |
//!
//! Both kinds of pre-classification are there because they fail in different ways: without weights the colours of clear voxels bleed
//! into their neighbours; with them, the products of thin voxels have few bits before they are ever summed.

pub mod arithmetic;
pub mod figures;
mod rays;

use arithmetic::Product;
use rayon::prelude::*;
use serde::Serialize;
use slicecast_compare::image::{ImageFigures, model_figures};
use slicecast_compare::{ModelPositions, model};
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::image::BaseImage;
use slicecast_engine::progress::Progress;
use slicecast_engine::tile::TILE_ROWS;
use slicecast_model::ModelImage;

/// Where voxels become colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Behind the filter.
    After,
    /// Behind the filter, whose normals a cube map brings to their length again.
    Normalised,
    /// Before it.
    Before,
    /// Before it, with colours times opacity.
    Weighted,
}

/// A pipeline of 8 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Texture8 {
    /// Where voxels become colours.
    pub order: Order,
    /// How two bytes are multiplied.
    pub product: Product,
}

impl Texture8 {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::of(Order::Normalised, Product::Blinn),
        Self::of(Order::Normalised, Product::Shift),
        Self::of(Order::After, Product::Blinn),
        Self::of(Order::After, Product::Shift),
        Self::of(Order::Before, Product::Blinn),
        Self::of(Order::Before, Product::Shift),
        Self::of(Order::Weighted, Product::Blinn),
        Self::of(Order::Weighted, Product::Shift),
    ];

    /// One of them.
    pub const fn of(order: Order, product: Product) -> Self {
        Self { order, product }
    }

    /// What tables and sheets call it.
    pub const fn name(self) -> &'static str {
        match (self.order, self.product) {
            (Order::Normalised, Product::Blinn) => "8 bits, post, normalised",
            (Order::Normalised, Product::Shift) => "8 bits, post, normalised, shift",
            (Order::After, Product::Blinn) => "8 bits, post",
            (Order::After, Product::Shift) => "8 bits, post, shift",
            (Order::Before, Product::Blinn) => "8 bits, pre",
            (Order::Before, Product::Shift) => "8 bits, pre, shift",
            (Order::Weighted, Product::Blinn) => "8 bits, pre, weighted",
            (Order::Weighted, Product::Shift) => "8 bits, pre, weighted, shift",
        }
    }

    /// The base plane of a scene, its bytes as shares of 255.
    ///
    /// # Errors
    /// [`RenderError`] if the scene is no composited one of samples, or has a crop box, clip planes, depth cueing or a modulation.
    pub fn render(self, prepared: &Prepared<'_>) -> Result<ModelImage, RenderError> {
        if !prepared.scene.blend.is_composited() {
            return Err(RenderError::Projection);
        }
        prepared.check_points()?;
        prepared.check_uncropped()?;
        let model = model(prepared, ModelPositions::Pipeline);
        Ok(rays::Frame::new(self, prepared, &model).render())
    }
}

/// How far a picture is from others.
#[derive(Clone, Debug, Serialize)]
pub struct Line {
    /// Which one.
    pub who: String,
    /// From f64 along the same rays and planes.
    pub samples: ImageFigures,
    /// From the converged integral.
    pub converged: ImageFigures,
    /// Values within 8 steps of the converged integral, which Squeeze takes for enough (3 %, section 4.1.2.1), percent.
    pub within: f64,
}

/// A scene rendered by the pipeline and by pipelines of 8 bits, against f64 of its samples and against the converged integral. The
/// scene's own precision comes first, then f64 of its samples, then the others.
///
/// # Errors
/// As [`Texture8::render`].
pub fn compare(
    prepared: &Prepared<'_>,
    pipelines: &[Texture8],
    progress: Progress<'_>,
) -> Result<Vec<Line>, RenderError> {
    let steps = pipelines.len() + 3;
    let textures: Vec<_> = (pipelines.iter().enumerate())
        .map(|(number, pipeline)| {
            progress(number, steps);
            pipeline
                .render(prepared)
                .map(|image| (pipeline.name().to_owned(), image))
        })
        .collect::<Result<_, _>>()?;
    progress(pipelines.len(), steps);
    let frame = prepared.render(Layer::Tiles(TILE_ROWS), &|_, _| ())?;
    let own = (prepared.scene.precision.name().to_owned(), shares(&frame.base));
    let exact = model(prepared, ModelPositions::Exact);
    progress(pipelines.len() + 1, steps);
    let samples = exact.render();
    progress(pipelines.len() + 2, steps);
    let converged = ModelImage::from_fn(exact.lattice().size, |u, v| exact.integral(u, v));
    progress(steps, steps);
    let f64_samples = ("f64 of samples".to_owned(), samples.clone());
    let images: Vec<_> = [own, f64_samples].into_iter().chain(textures).collect();
    let line = |(who, image): (String, ModelImage)| {
        let image = coloured(image);
        Line {
            samples: model_figures(&image, &samples),
            converged: model_figures(&image, &converged),
            within: within(&image, &converged),
            who,
        }
    };
    Ok(images.into_par_iter().map(line).collect())
}

/// An image whose pixels without any light count as clear: by one shift clear samples darken what is behind them, and pixels that
/// show nothing would be counted as equal.
fn coloured(mut image: ModelImage) -> ModelImage {
    let [red, green, blue] = &image.rgb;
    for (((t, r), g), b) in image.t.iter_mut().zip(red).zip(green).zip(blue) {
        if *r + *g + *b == 0.0 {
            *t = 1.0;
        }
    }
    image
}

/// A base plane as shares of 1.
pub fn shares(base: &BaseImage) -> ModelImage {
    let share = |plane: &Vec<u32>| {
        plane
            .iter()
            .map(|bits| f64::from(*bits) / f64::from(base.one))
            .collect()
    };
    let [red, green, blue, transparency] = base.planes.each_ref().map(share);
    ModelImage {
        size: base.size,
        rgb: [red, green, blue],
        t: transparency,
    }
}

/// Values of one within 8 of 255 steps of another's, of pixels that anything contributes to; percent.
fn within(first: &ModelImage, second: &ModelImage) -> f64 {
    let (mut near, mut all) = (0u64, 0u64);
    for index in (0..second.t.len()).filter(|index| first.t[*index] < 1.0 || second.t[*index] < 1.0) {
        for c in 0..3 {
            all += 1;
            near += u64::from((first.rgb[c][index] - second.rgb[c][index]).abs() * 255.0 <= 8.0);
        }
    }
    100.0 * near as f64 / all.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::arithmetic::{Bytes, over, under};
    use super::*;
    use slicecast_scene::file::built_in;
    use slicecast_scene::{Blend, Borders, Scene, View};
    use slicecast_volume::mapping::Window;
    use slicecast_volume::open::load;
    use slicecast_volume::{Mapping, Volume};

    /// Seven deep along y, the same everywhere, in Hounsfield units.
    fn block(value: u16) -> Volume {
        Volume {
            name: "block".into(),
            dims: [3, 7, 4],
            spacing: [1.0; 3],
            voxels: vec![value; 3 * 7 * 4],
            mapping: Mapping {
                scale: 1.0,
                offset: -1000.0,
            },
        }
    }

    fn scene(blend: Blend, borders: Borders) -> Scene {
        let mut scene = built_in("ct-fog").unwrap();
        scene.view = View::default();
        scene.blend = blend;
        scene.borders = borders;
        // 26 of 255, and a rounding away from the half.
        scene.transfer.points[1].opacity = 0.102;
        scene.transfer.points[1].colour = [1.0, 0.5, 0.25];
        scene
    }

    /// A ray through a block is a fold of one sample, seven times.
    #[test]
    fn rays_through_a_block_are_one_sample_again_and_again() {
        let volume = block(2000);
        for (blend, borders) in [
            (Blend::FrontToBack, Borders::Whole),
            (Blend::FrontToBack, Borders::Cells),
            (Blend::BackToFront, Borders::Cells),
        ] {
            let scene = scene(blend, borders);
            let prepared = Prepared::new(&scene, &volume).unwrap();
            for pipeline in Texture8::ALL {
                let product = pipeline.product;
                let alpha = 26;
                let [red, green, blue] = [255, 128, 64].map(|c| product.of(c, alpha));
                let fold = if blend == Blend::BackToFront { under } else { over };
                let mut expected: Bytes = [0, 0, 0, 255];
                for _ in 0..7 {
                    expected = fold(product, expected, [red, green, blue, alpha]);
                }
                let image = pipeline.render(&prepared).unwrap();
                let seen: Vec<Bytes> = (0..image.t.len())
                    .filter(|index| image.t[*index] < 1.0)
                    .map(|at| {
                        [image.rgb[0][at], image.rgb[1][at], image.rgb[2][at], image.t[at]]
                            .map(|share| (255.0 * share).round() as u8)
                    })
                    .collect();
                assert_eq!(seen.len(), 3 * 4, "{pipeline:?} {borders:?}");
                assert!(seen.iter().all(|pixel| *pixel == expected), "{pipeline:?} {seen:?}");
            }
        }
    }

    fn error(name: &str, change: fn(&mut Scene), pipeline: Texture8) -> (f64, f64) {
        let head = load(None, Window::Auto).unwrap().volume;
        let mut scene = built_in(name).unwrap();
        change(&mut scene);
        let prepared = Prepared::new(&scene, &head).unwrap();
        let samples = model(&prepared, ModelPositions::Exact).render();
        let image = coloured(pipeline.render(&prepared).unwrap());
        (model_figures(&image, &samples).mean_lsb8, within(&image, &samples))
    }

    /// Squeeze, sections 3 and 4.1.2: opaque surfaces need 8 bits, and fog does not find them enough.
    #[test]
    fn surfaces_are_near_and_fog_is_gone() {
        let post = Texture8::of(Order::After, Product::Blinn);
        let (mean, near) = error("ct-bone", |scene| scene.lighting = None, post);
        assert!(mean < 1.0 && near > 97.0, "{mean} {near}");
        let (shifted, _) = error(
            "ct-bone",
            |scene| scene.lighting = None,
            Texture8::of(Order::After, Product::Shift),
        );
        assert!(shifted > 5.0 * mean, "{shifted} {mean}");
        // Its opacity is less than half of 1/255 a step.
        let (mean, near) = error("ct-fog8", |_| (), post);
        assert!(mean > 60.0 && near < 10.0, "{mean} {near}");
    }

    /// Normals between voxels are shorter, and darken what they light.
    #[test]
    fn a_map_of_normals_mends_diffuse_light() {
        let of = |order| {
            error(
                "ct-bone",
                |scene| scene.lighting.as_mut().unwrap().specular = 0.0,
                Texture8::of(order, Product::Blinn),
            )
        };
        let ((filtered, _), (normalised, _)) = (of(Order::After), of(Order::Normalised));
        // Measured: 5.9 steps of 11.4.
        assert!(normalised < 0.6 * filtered, "{normalised} {filtered}");
    }

    #[test]
    fn what_hardware_does_not_do_is_refused() {
        let volume = block(2000);
        let refused = |change: fn(&mut Scene)| {
            let mut scene = scene(Blend::FrontToBack, Borders::Cells);
            change(&mut scene);
            let prepared = Prepared::new(&scene, &volume).unwrap();
            let error = Texture8::ALL[0].render(&prepared).unwrap_err().to_string();
            assert!(
                error.contains("expected") || error.contains("projection") || error.contains("--classification"),
                "{error}"
            );
        };
        refused(|scene| scene.blend = Blend::Maximum);
        refused(|scene| scene.classification = slicecast_scene::Classification::Integral);
        refused(|scene| scene.clips = vec![slicecast_scene::clip::Clip::parse("1,1,1:0,1,0").unwrap()]);
    }
}
