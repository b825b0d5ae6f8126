//! The paper's figures 7 to 10, remade: what is compared there, side by side.
//!
//! Samples, segments and isosurfaces are rendered by the engine. Two things that it does not do are rendered in f64 along the
//! same rays: voxels classified before interpolation, and isosurfaces whose segments take in both ends.

use slicecast_compare::image::model_picture;
use slicecast_compare::{ModelPositions, model};
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::image::Rgb;
use slicecast_model::gradient::normalise;
use slicecast_model::interpolate::{Cell, trilinear};
use slicecast_model::{Affine, Model, ModelImage, Pixel};
use slicecast_scene::{Classification, Face, Image, Sampling, Scene, Surface, TransferFunction};
use slicecast_volume::Volume;

use super::cases::Case;
use super::curves::{Setting, head, of_case, thin_layers};
use super::function::Function;
use super::table::{PIECE, ordered};

/// A figure of the paper.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Its number there.
    pub number: u32,
    /// Pictures with what they show.
    pub parts: Vec<(&'static str, Rgb)>,
}

/// Numbers of the figures.
pub const NUMBERS: [u32; 4] = [7, 8, 9, 10];

/// Rows of a tile.
const TILE: usize = 32;
/// Rays per voxel of the harmonic of 16³.
const FINE: u32 = 8;
/// Rays per voxel of the head.
const COARSE: u32 = 2;

/// All four, each picture so many pixels wide and high.
///
/// # Errors
/// [`RenderError`] if a scene cannot be rendered.
pub fn figures(size: u32) -> Result<Vec<Figure>, RenderError> {
    let harmonic = of_case(Case::harmonic());
    Ok(vec![
        twice_met(&harmonic, size)?,
        surfaces(&harmonic, size)?,
        ways(9, &thin_layers(), COARSE, 16, size, None)?,
        {
            let table = dependent(&harmonic.scene.transfer, size);
            ways(10, &harmonic, FINE, 16, size, Some(("table of segments", table)))?
        },
    ])
}

/// A scene as it is rendered for a picture.
fn pictured(setting: &Setting, classification: Classification, rays: u32, planes: u32, size: u32) -> Scene {
    Scene {
        classification,
        sampling: Sampling {
            planes_per_voxel: planes,
            rays_per_voxel: rays,
        },
        image: Image {
            size: Some([size; 2]),
            ..setting.scene.image
        },
        ..setting.scene.clone()
    }
}

fn rendered(scene: &Scene, volume: &Volume) -> Result<Rgb, RenderError> {
    let frame = Prepared::new(scene, volume)?.render(Layer::Tiles(TILE), &|_, _| ())?;
    Ok(frame.picture)
}

/// A picture whose rays are made in f64.
fn by_rays(
    scene: &Scene,
    volume: &Volume,
    ray: &(dyn Fn(&Model<'_>, usize, usize) -> Pixel + Sync),
) -> Result<Rgb, RenderError> {
    let prepared = Prepared::new(scene, volume)?;
    let model = model(&prepared, ModelPositions::Exact);
    let base = ModelImage::from_fn(model.lattice().size, |u, v| ray(&model, u, v));
    let [origin, right, down] = prepared.setup.picture.affine;
    let map = Affine {
        u: [origin[0], right[0], down[0]],
        v: [origin[1], right[1], down[1]],
    };
    let size = prepared.setup.picture.size.map(|side| side as usize);
    Ok(model_picture(&base.warp(size, map), scene.image.background))
}

/// Voxels before segments: classified voxels, samples, samples of more planes, segments.
fn ways(
    number: u32,
    setting: &Setting,
    rays: u32,
    planes: u32,
    size: u32,
    more: Option<(&'static str, Rgb)>,
) -> Result<Figure, RenderError> {
    let scene = |classification, planes| pictured(setting, classification, rays, planes, size);
    let mut parts = vec![
        (
            "a) voxels classified",
            by_rays(&scene(Classification::Point, 1), &setting.volume, &of_classified_voxels)?,
        ),
        (
            "b) samples",
            rendered(&scene(Classification::Point, 1), &setting.volume)?,
        ),
        (
            "c) samples, 16 planes",
            rendered(&scene(Classification::Point, planes), &setting.volume)?,
        ),
        (
            "d) segments",
            rendered(&scene(Classification::Integral, 1), &setting.volume)?,
        ),
    ];
    parts.extend(more);
    Ok(Figure { number, parts })
}

/// A ray through interpolated colours and opacities of classified voxels: pre-classification.
fn of_classified_voxels(model: &Model<'_>, u: usize, v: usize) -> Pixel {
    let grid = model.grid();
    let mut pixel = Pixel::TRANSPARENT;
    for plane in 0..model.geometry().planes() {
        let Some(position) = model.position(plane, u, v) else {
            continue;
        };
        let cell = Cell::at(position, grid.dims());
        let corners = cell.corners(|at| model.classify(grid.voxel(at)));
        let opacity = trilinear(corners.map(|corner| corner.opacity), cell.weight);
        let colour = [0, 1, 2].map(|c| trilinear(corners.map(|corner| corner.colour[c]), cell.weight));
        let normal = normalise(model.gradient_at(position));
        pixel = pixel.front_to_back(model.shade(normal, colour), opacity);
    }
    pixel
}

/// The paper's table: front sample across, back sample down, colour times opacity of a segment one voxel long.
fn dependent(transfer: &TransferFunction, size: u32) -> Rgb {
    let function = Function::new(transfer);
    texture(size, |ends| {
        let [r, g, b, _] = ordered(&function, ends, 1.0, PIECE);
        [r, g, b]
    })
}

/// A square of segments, codes 0 to 4095 across (front) and down (back).
fn texture(size: u32, colour: impl Fn([f64; 2]) -> [f64; 3]) -> Rgb {
    let code = |n: u32| f64::from(n) * 4095.0 / f64::from(size.saturating_sub(1).max(1));
    let mut bytes = Vec::with_capacity(3 * (size * size) as usize);
    for back in 0..size {
        for front in 0..size {
            let eight = |c: f64| (c * 255.0).round().clamp(0.0, 255.0) as u8;
            bytes.extend(colour([code(front), code(back)]).map(eight));
        }
    }
    Rgb { size: [size; 2], bytes }
}

/// The value of figure 7, in steps of 8 bits, and its face.
const VALUE: f64 = 150.0;
const GLASS: Face = Face {
    colour: [0.4, 0.7, 1.0],
    opacity: 0.5,
};

/// A translucent surface over samples of 8 bits, as the paper's hardware has them: with segments that take in both ends, with
/// half-open ones, and as it is rendered here.
fn twice_met(harmonic: &Setting, size: u32) -> Result<Figure, RenderError> {
    let mut scene = pictured(harmonic, Classification::None, FINE, 1, size);
    scene.lighting = head().scene.lighting;
    scene.surfaces = vec![Surface::of(VALUE * 4095.0 / 255.0, GLASS)];
    let by = |closed| {
        by_rays(&scene, &harmonic.volume, &move |model, u, v| {
            of_eight_bits(model, closed, u, v)
        })
    };
    Ok(Figure {
        number: 7,
        parts: vec![
            ("a) both ends, 8 bits", by(true)?),
            ("b) half-open, 8 bits", by(false)?),
            ("c) here, 12 bits", rendered(&scene, &harmonic.volume)?),
        ],
    })
}

/// A ray that crosses a surface between samples of 8 bits. `closed`: a segment that begins or ends on it crosses it too.
fn of_eight_bits(model: &Model<'_>, closed: bool, u: usize, v: usize) -> Pixel {
    let mut pixel = Pixel::TRANSPARENT;
    let mut front: Option<([f64; 3], f64)> = None;
    for plane in 0..model.geometry().planes() {
        let back = model.position(plane, u, v).map(|position| {
            let code = model.value_at(position);
            (position, (code * 255.0 / 4095.0).round())
        });
        if let (Some((from, a)), Some((to, b))) = (front, back) {
            let met = if closed {
                a.min(b) <= VALUE && VALUE <= a.max(b)
            } else {
                (a < VALUE) != (b < VALUE)
            };
            if met {
                let share = if a == b { 0.0 } else { (VALUE - a) / (b - a) };
                let at = [0, 1, 2].map(|axis| from[axis] + (to[axis] - from[axis]) * share);
                let side = if b < a { -1.0 } else { 1.0 };
                let normal = normalise(model.gradient_at(at)).map(|n| side * n);
                pixel = pixel.front_to_back(model.shade(normal, GLASS.colour), GLASS.opacity);
            }
        }
        front = back;
    }
    pixel
}

/// Values, as shares of the codes, and colours of four surfaces.
const FOUR: [(f64, [f64; 3]); 4] = [
    (0.35, [0.2, 0.4, 1.0]),
    (0.5, [0.2, 0.9, 0.3]),
    (0.65, [1.0, 0.8, 0.2]),
    (0.8, [1.0, 0.25, 0.2]),
];
const SKIN: Face = Face {
    colour: [0.9, 0.69, 0.55],
    opacity: 1.0,
};
const SKULL: Face = Face {
    colour: [0.95, 0.91, 0.82],
    opacity: 1.0,
};

/// Several surfaces of a field with their table, and skin and skull of the head.
fn surfaces(harmonic: &Setting, size: u32) -> Result<Figure, RenderError> {
    let head = head();
    let list = FOUR.map(|(share, colour)| Surface::of(share * 4095.0, Face { colour, opacity: 0.6 }));
    let mut several = pictured(harmonic, Classification::None, FINE, 1, size);
    several.lighting = head.scene.lighting.clone();
    several.surfaces = list.to_vec();
    let table = texture(size, |ends| of_crossings(&list, ends));
    let of_head = |surfaces: Vec<Surface>| {
        let scene = Scene {
            surfaces,
            ..pictured(&head, Classification::None, COARSE, 1, size)
        };
        rendered(&scene, &head.volume)
    };
    let (skin, skull) = (Surface::of(-300.0, SKIN), Surface::of(200.0, SKULL));
    let glass = Surface::of(-300.0, Face { opacity: 0.3, ..SKIN });
    Ok(Figure {
        number: 8,
        parts: vec![
            ("a) four surfaces", rendered(&several, &harmonic.volume)?),
            ("b) their table", table),
            ("c) skin", of_head(vec![skin])?),
            ("d) skull", of_head(vec![skull])?),
            ("e) skin over skull", of_head(vec![skull, glass])?),
        ],
    })
}

/// Colour times opacity of the surfaces that a segment crosses, in their order.
fn of_crossings(surfaces: &[Surface], [front, back]: [f64; 2]) -> [f64; 3] {
    let mut met: Vec<_> = (surfaces.iter())
        .filter(|surface| (front < surface.value) != (back < surface.value))
        .collect();
    if back < front {
        met.reverse();
    }
    let fold = |pixel: Pixel, surface: &&Surface| pixel.front_to_back(surface.front.colour, surface.front.opacity);
    met.iter().fold(Pixel::TRANSPARENT, fold).colour
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean difference of two pictures in steps of 1/255.
    fn apart(a: &Rgb, b: &Rgb) -> f64 {
        assert_eq!(a.size, b.size);
        let sum: u32 = (a.bytes.iter().zip(&b.bytes))
            .map(|(a, b)| u32::from(a.abs_diff(*b)))
            .sum();
        f64::from(sum) / a.bytes.len() as f64
    }

    #[test]
    fn figures_show_what_the_paper_compares() {
        let figures = figures(48).unwrap();
        assert_eq!(figures.iter().map(|figure| figure.number).collect::<Vec<_>>(), NUMBERS);
        for Figure { number, parts } in &figures {
            for (name, picture) in parts {
                assert_eq!(picture.size, [48; 2], "figure {number}: {name}");
                assert!(
                    picture.bytes.iter().any(|c| *c > 50),
                    "figure {number}: {name} is empty"
                );
            }
        }
        // Surfaces that are met twice are brighter; half-open ones of 8 bits are nearly those of 12.
        let [twice, once, here] = [0, 1, 2].map(|n| &figures[0].parts[n].1);
        assert!(apart(twice, once) > 0.2, "{}", apart(twice, once));
        assert!(apart(once, here) < apart(twice, here));
        // Thin layers and random functions: 16 planes come nearer to segments than 1 does.
        for figure in &figures[2..] {
            let [before, one, sixteen, segments] = [0, 1, 2, 3].map(|n| &figure.parts[n].1);
            assert!(apart(one, segments) > apart(sixteen, segments));
            assert!(apart(before, segments) > apart(sixteen, segments));
        }
    }

    #[test]
    fn a_table_of_crossings_is_composited_in_order() {
        let list = FOUR.map(|(share, colour)| Surface::of(share * 4095.0, Face { colour, opacity: 1.0 }));
        assert_eq!(of_crossings(&list, [0.0, 4095.0]), FOUR[0].1);
        assert_eq!(of_crossings(&list, [4095.0, 0.0]), FOUR[3].1);
        assert_eq!(of_crossings(&list, [100.0, 100.0]), [0.0; 3]);
    }
}
