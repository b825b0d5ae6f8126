//! The scenes that machines render: crops of the built-in CT, as the host's program sees them and as Rust source for
//! the image.

use std::fmt::Write as _;

use slicecast::crop::Crop;
use slicecast::format::{Direction, Position};
use slicecast_engine::camera;
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::oriented::{Turned, packed};
use slicecast_engine::pipelines::compile;
use slicecast_engine::rendering::in_memory_order;
use slicecast_engine::table::Table;
use slicecast_firmware_shared::sum::Sum;
use slicecast_scene::clip::Clip;
use slicecast_scene::crop::{self as boxes, CropUnit};
use slicecast_scene::cueing::Cueing;
use slicecast_scene::file::parse;
use slicecast_scene::{AlphaCodeName, Borders, Highlight, PrecisionName, Scene};
use slicecast_volume::Volume;
use slicecast_volume::mapping::Window;
use slicecast_volume::open::load;

use crate::colours;
use crate::shell::{Failure, fail};

/// A scene on its volume.
#[derive(Debug)]
pub struct Named {
    /// Its name.
    pub name: &'static str,
    /// The scene, lit.
    pub scene: Scene,
    /// The volume.
    pub volume: Volume,
}

/// Which pipeline of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Kind {
    /// Index into [`PrecisionName::STAGED`].
    precision: usize,
    /// With gradients and lights.
    pub lit: bool,
}

impl Kind {
    /// All kinds, in the order in which images report them.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..3).flat_map(|precision| [false, true].map(|lit| Self { precision, lit }))
    }

    /// The default precision, unlit.
    pub const COMPACT_UNLIT: Self = Self {
        precision: 1,
        lit: false,
    };

    /// The default precision, lit.
    pub const COMPACT_LIT: Self = Self {
        precision: 1,
        lit: true,
    };

    /// The precision.
    pub fn precision(self) -> PrecisionName {
        PrecisionName::STAGED[self.precision]
    }

    /// `lit` or `unlit`.
    pub const fn shading(self) -> &'static str {
        if self.lit { "lit" } else { "unlit" }
    }

    /// As images print it.
    pub fn name(self) -> String {
        format!("{} {}", self.precision().name(), self.shading())
    }
}

/// Names of the scenes whose cost is measured: one in which every sample is visible, and the built-in head.
pub const COSTED: [&str; 2] = ["dense", "large"];

/// Every table entry is a little opaque, no ray ends: every sample goes through every stage.
const DENSE: &str = r##"
[view]
azimuth = 20.0
elevation = 12.0
[sampling]
borders = "whole"
[transfer]
unit_distance = 1.0
points = [
  { value = -1024.0, colour = "#203040", opacity = 0.001 },
  { value = 300.0, colour = "#f2e8d0", opacity = 0.004 },
]
[lighting]
ambient = 0.2
diffuse = 0.7
specular = 0.2
exponent = 32
[[lighting.lights]]
direction = [-1.0, 1.0, 1.5]
"##;

/// Two coloured lights, half vectors, four phases, two planes per voxel, a view along another axis.
const SMALL: &str = r##"
[view]
azimuth = -60.0
elevation = 25.0
roll = 10.0
[image]
size = [48, 48]
[sampling]
planes_per_voxel = 2
rays_per_voxel = 2
borders = "whole"
[transfer]
unit_distance = 1.0
points = [
  { value = -750.0, colour = "#e6b08c", opacity = 0.0 },
  { value = -500.0, colour = "#e6b08c", opacity = 0.12 },
  { value = -250.0, colour = "#e6b08c", opacity = 0.0 },
  { value = 100.0, colour = "#f2e8d0", opacity = 0.0 },
  { value = 300.0, colour = "#f2e8d0", opacity = 0.6 },
]
[lighting]
ambient = 0.15
diffuse = 0.6
specular = 0.4
exponent = 64
highlight = "half-vector"
[[lighting.lights]]
direction = [-1.0, 1.0, 1.5]
colour = "#ffe0c0"
[[lighting.lights]]
direction = [1.0, 0.2, 0.8]
colour = [0.2, 0.3, 0.5]
"##;

/// The scene of the program's own picture, at one plane and one ray per voxel.
pub const LARGE: &str = r##"
[view]
azimuth = 30.0
elevation = 10.0
[image]
size = [96, 96]
[sampling]
borders = "whole"
[transfer]
unit_distance = 1.0
points = [
  { value = -750.0, colour = "#e6b08c", opacity = 0.0 },
  { value = -500.0, colour = "#e6b08c", opacity = 0.12 },
  { value = -250.0, colour = "#e6b08c", opacity = 0.0 },
  { value = 100.0, colour = "#f2e8d0", opacity = 0.0 },
  { value = 300.0, colour = "#f2e8d0", opacity = 0.6 },
]
[lighting]
ambient = 0.2
diffuse = 0.7
specular = 0.3
exponent = 32
[[lighting.lights]]
direction = [-1.0, 1.0, 1.5]
[[lighting.lights]]
direction = [1.0, 0.2, 0.8]
colour = [0.25, 0.25, 0.25]
"##;

/// A scene's name as a constant's.
pub fn constant_name(name: &str) -> String {
    name.to_uppercase().replace('-', "_")
}

/// The scenes, in the order in which images render them. Their borders are whole, and programs of theirs link no others; those of
/// the exported head and of a box are exact.
///
/// # Errors
/// If the built-in volume or a scene cannot be read.
pub fn all() -> Result<Vec<Named>, Failure> {
    let head = load(None, Window::Auto)
        .map_err(|error| Failure(error.to_string()))?
        .volume;
    let named = |name, text, first, sides| -> Result<Named, Failure> {
        Ok(Named {
            name,
            scene: parse(text, name).map_err(|error| Failure(error.to_string()))?,
            volume: crop(&head, first, sides)?,
        })
    };
    Ok(vec![
        named("small", SMALL, [16, 4, 34], [32; 3])?,
        named("large", LARGE, [0, 0, 24], [64; 3])?,
        named("dense", DENSE, [0, 0, 24], [64; 3])?,
    ])
}

pub fn crop(volume: &Volume, first: [usize; 3], sides: [usize; 3]) -> Result<Volume, Failure> {
    if (0..3).any(|a| first[a] + sides[a] > volume.dims[a]) {
        return fail(format!(
            "a crop of {sides:?} at {first:?} does not fit {:?}",
            volume.dims
        ));
    }
    let [nx, ny, _] = volume.dims;
    let mut voxels = Vec::with_capacity(sides.iter().product());
    for z in first[2]..first[2] + sides[2] {
        for y in first[1]..first[1] + sides[1] {
            let start = (z * ny + y) * nx + first[0];
            voxels.extend_from_slice(&volume.voxels[start..start + sides[0]]);
        }
    }
    Ok(Volume {
        dims: sides,
        voxels,
        ..volume.clone()
    })
}

impl Named {
    /// The scene of a kind of pipeline. Each precision has a table code of its own, so that all codes are seen to work.
    pub fn of_kind(&self, kind: Kind) -> Scene {
        let mut scene = self.in_precision(kind.precision());
        if !kind.lit {
            scene.lighting = None;
        }
        scene
    }

    fn in_precision(&self, precision: PrecisionName) -> Scene {
        let code = match precision {
            PrecisionName::Paper => AlphaCodeName::Sqrt8,
            PrecisionName::Compact | PrecisionName::Fast => AlphaCodeName::Sqrt16,
            PrecisionName::Wide => AlphaCodeName::Colour16,
        };
        Scene {
            precision,
            table: Some(code),
            ..self.scene.clone()
        }
    }

    /// The numbers that the pipeline reads.
    pub fn numbers(&self) -> Result<Numbers, Failure> {
        let words = |error: &dyn std::error::Error| Failure(format!("{}: {error}", self.name));
        let prepared = Prepared::new(&self.scene, &self.volume).map_err(|e| words(&e))?;
        let (setup, spacing) = (&prepared.setup, self.volume.spacing);
        let Some((material, lighting)) = setup.material.as_ref().zip(self.scene.lighting.as_ref()) else {
            return fail(format!("{}: the scene has no lights", self.name));
        };
        let forward = self.scene.view.axes().forward;
        let direction = [0, 1, 2].map(|a| forward[a] / spacing[a]);
        let longest = direction.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
        let one = Direction::ONE.to_bits() as f64;
        let smallest = spacing.iter().copied().fold(f64::INFINITY, f64::min);
        let mut turned = Turned::new(&self.volume, &setup.plan);
        let slices = turned.slices().map_err(|e| words(&e))?;
        let voxels = slices.iter().flat_map(packed).collect();
        let table = |precision| {
            let scene = self.in_precision(precision);
            compile(&scene, &self.volume.mapping, setup.step_length)
        };
        let bits = |v: [slicecast::format::Vector; 3]| v.map(|c| c.to_bits());
        let share = |v: [slicecast::format::Coefficient; 3]| v.map(|c| c.to_bits());
        let lights = material.lights.iter();
        let warp = setup.picture.warp;
        Ok(Numbers {
            direction: direction.map(|c| (c / longest * one).round() as i64),
            spacing: spacing.map(|s| (smallest / s * 32768.0).round() as u16),
            voxels,
            table8: table(PrecisionName::Paper),
            table16: table(PrecisionName::Compact),
            table_wide: table(PrecisionName::Wide),
            lights: lights
                .map(|l| (bits(l.direction), bits(l.half), share(l.diffuse), share(l.specular)))
                .collect(),
            ambient: share(material.ambient),
            viewer: bits(material.viewer),
            half_vector: lighting.highlight == Highlight::HalfVector,
            exponent_log2: lighting.exponent_log2,
            picture: setup.picture.size,
            warp: [warp.origin, warp.right, warp.down].map(|v| v.map(|s| s.to_bits())),
        })
    }

    /// The scene as a Rust constant.
    pub fn rust(&self) -> Result<String, Failure> {
        let n = self.numbers()?;
        let mut out = String::new();
        let upper = constant_name(self.name);
        let text = |out: &mut String, name: &str, kind: &str, len: usize, list: String| {
            // A section of its own, so that a scene's data can be told from a program's constants.
            let _ = writeln!(out, "#[unsafe(link_section = \".scene\")]");
            let _ = writeln!(out, "static {upper}_{name}: [{kind}; {len}] = {list};");
        };
        text(&mut out, "VOXELS", "u16", n.voxels.len(), format!("{:?}", n.voxels));
        text(&mut out, "ENTRIES8", "u32", 4096, format!("{:?}", n.table8.entries));
        text(&mut out, "ENTRIES16", "u32", 4096, format!("{:?}", n.table16.entries));
        text(&mut out, "PLANE16", "u8", 4096, format!("{:?}", n.table16.plane));
        let wide = &n.table_wide;
        text(&mut out, "ENTRIES_WIDE", "u32", 4096, format!("{:?}", wide.entries));
        text(&mut out, "COLOURS_WIDE", "[u8; 3]", 4096, format!("{:?}", wide.colours));
        out.push_str(&self.constant(&n, &upper));
        Ok(out)
    }

    /// The scene as a Rust constant that names the data of a scene.
    pub fn constant(&self, n: &Numbers, data: &str) -> String {
        let mut out = String::new();
        let upper = constant_name(self.name);
        let rates = &self.scene.sampling;
        let _ = writeln!(
            out,
            "/// Written by the runner.\npub static {upper}: &SceneData = &SceneData {{ name: {:?}, direction: {:?}, dims: \
             {:?}, spacing: {:?}, sampling: {:?}, voxels: &{data}_VOXELS, entries8: &{data}_ENTRIES8, entries16: \
             &{data}_ENTRIES16, plane16: &{data}_PLANE16, entries_wide: &{data}_ENTRIES_WIDE, colours_wide: \
             &{data}_COLOURS_WIDE, picture: {:?}, warp: {:?}, lighting: Lighting {{ ambient: \
             {:?}, viewer: {:?}, half_vector: {}, exponent_log2: {}, lights: &{:?} }} }};",
            self.name,
            n.direction,
            self.volume.dims,
            n.spacing,
            [rates.planes_per_voxel, rates.rays_per_voxel],
            n.picture,
            n.warp,
            n.ambient,
            n.viewer,
            n.half_vector,
            n.exponent_log2,
            n.lights,
        );
        out
    }

    /// The scene as a C header.
    ///
    /// # Errors
    /// If it does not fit the pipeline.
    pub fn c(&self, image_sum: impl Fn(Kind) -> u32) -> Result<String, Failure> {
        let n = self.numbers()?;
        let list = |v: &dyn std::fmt::Debug| format!("{v:?}").replace(['[', '('], "{").replace([']', ')'], "}");
        let mut out = String::from("/* Written by the runner. */\n");
        let _ = writeln!(out, "static const uint16_t voxels[] = {};", list(&n.voxels));
        let _ = writeln!(out, "static const uint32_t entries[] = {};", list(&n.table16.entries));
        let _ = writeln!(out, "static const uint8_t low_roots[] = {};", list(&n.table16.plane));
        let wide = &n.table_wide;
        let _ = writeln!(out, "static const uint32_t entries_wide[] = {};", list(&wide.entries));
        let low: &[u8] = wide.colours.as_flattened();
        let _ = writeln!(out, "static const uint8_t low_colours[] = {};", list(&low));
        let _ = writeln!(out, "static const SlicecastLight lights[] = {};", list(&n.lights));
        let _ = writeln!(
            out,
            "static const SlicecastLighting lighting = {{{}, {}, {}, {}, {}, lights}};",
            list(&n.ambient),
            list(&n.viewer),
            u32::from(n.half_vector),
            n.exponent_log2,
            n.lights.len(),
        );
        let rates = &self.scene.sampling;
        let cropped = self.cropped();
        let faces = camera::crop(&cropped, self.volume.spacing).unwrap_or(Crop::NONE);
        let [low, high] = [faces.low, faces.high].map(|faces| list(&faces.map(Position::to_bits)));
        let uncropped = "0, {0, 0, 0}, {0, 0, 0}";
        out.push_str(&colours::c(self)?);
        // Roots are the same in both.
        for (scene, entries, borders, medium) in [
            ("scene", "entries", uncropped.to_owned(), "{0, 0}"),
            ("scene_wide", "entries_wide", uncropped.to_owned(), "{0, 0}"),
            ("scene_cropped", "entries", format!("1, {low}, {high}"), "{0, 0}"),
            ("scene_colours", "0", uncropped.to_owned(), "COLOUR_MEDIUM"),
        ] {
            let _ = writeln!(
                out,
                "static const SlicecastScene {scene} = {{SLICECAST_VERSION, {}, {}, {}, {}, {}, 0, {borders}, {entries}, low_roots, \
                 low_colours, &lighting, 0, 0, 0, {medium}, 0}};",
                list(&self.volume.dims),
                list(&n.direction),
                list(&n.spacing),
                rates.planes_per_voxel,
                rates.rays_per_voxel,
            );
        }
        for kind in Kind::all() {
            let name = kind.name().to_uppercase().replace(' ', "_");
            let _ = writeln!(out, "#define {name} {}u", image_sum(kind));
        }
        let clipped = self.clipped();
        let units = |lengths: f64| (lengths * f64::from(1 << 30)) as i64;
        let planes = clipped.clips.iter().map(|clip| {
            let plane = clip.in_voxels(self.volume.spacing);
            format!(
                "{{{}, {}, {}, {}, {}}}",
                list(&plane.slope.map(units)),
                u32::from(clip.outside),
                units(plane.distance),
                plane.thickness.map_or(0, units),
                units(plane.falloff),
            )
        });
        let planes: Vec<_> = planes.collect();
        let _ = writeln!(out, "static const SlicecastClip clips[] = {{{}}};", planes.join(", "));
        let forward = clipped.view.axes().forward;
        if let Some(cue) = clipped.cueing {
            let plane = cue.in_voxels(forward, self.volume.dims, self.volume.spacing);
            let _ = writeln!(
                out,
                "static const SlicecastCue cue = {{{}, {}, {}, {}, {}}};",
                list(&plane.slope.map(units)),
                (plane.strength * 65536.0) as u32,
                units(plane.distance),
                units(plane.depth),
                list(&cue.colour.map(|c| (c * 32768.0).round() as u16)),
            );
        }
        for (name, scene) in [("CROPPED", &cropped), ("CLIPPED", &clipped)] {
            let words = |error: &dyn std::error::Error| Failure(format!("{}, {name}: {error}", self.name));
            let prepared = Prepared::new(scene, &self.volume).map_err(|e| words(&e))?;
            let frame = prepared.render(Layer::Tiles(32), &|_, _| ()).map_err(|e| words(&e))?;
            let mut sum = Sum::new();
            in_memory_order(&frame.base, rates.rays_per_voxel as usize).for_each(|bits| sum.word(bits));
            let _ = writeln!(out, "#define {name} {}u", sum.get());
        }
        Ok(out)
    }

    /// The scene behind a hard plane and a soft slab that is cut away, with depth cueing, lit, in `Compact`.
    fn clipped(&self) -> Scene {
        let slab = Clip {
            thickness: Some(3.5),
            falloff: 4.0,
            outside: true,
            ..Clip::new([0.0, 0.0, 9.0], [0.1, -0.2, 1.0])
        };
        Scene {
            cueing: Some(Cueing {
                from: 0.125,
                colour: [0.0, 0.125, 0.25],
                ..Cueing::default()
            }),
            clips: vec![Clip::new([12.0, 14.5, 13.0], [1.0, 0.4, -0.3]), slab],
            ..self.in_precision(PrecisionName::Compact)
        }
    }

    /// The scene of a box of the volume, lit, in `Compact`.
    fn cropped(&self) -> Scene {
        Scene {
            borders: Borders::Cells,
            crop: Some(boxes::Crop {
                ranges: [[7.25, 18.5], [f64::NEG_INFINITY, 14.0], [9.5, 21.75]],
                unit: CropUnit::Voxels,
            }),
            ..self.in_precision(PrecisionName::Compact)
        }
    }
}

/// A light: direction, half vector, diffuse, specular.
type LightBits = ([i32; 3], [i32; 3], [u32; 3], [u32; 3]);

/// A scene in the pipeline's formats.
pub struct Numbers {
    direction: [i64; 3],
    spacing: [u16; 3],
    /// Voxels in the order in which the view meets the slices.
    pub voxels: Vec<u16>,
    table8: Table,
    table16: Table,
    table_wide: Table,
    lights: Vec<LightBits>,
    ambient: [u32; 3],
    viewer: [i32; 3],
    half_vector: bool,
    exponent_log2: u32,
    picture: [u32; 2],
    warp: [[i64; 2]; 3],
}

/// Rust source of all scenes, with the sums that their images must have.
///
/// # Errors
/// If a scene does not fit the pipeline.
pub fn source(scenes: &[Named], image_sum: impl Fn(&Named, Kind) -> u32) -> Result<String, Failure> {
    let mut out = String::new();
    for named in scenes {
        out.push_str(&named.rust()?);
        let sums: Vec<u32> = Kind::all().map(|kind| image_sum(named, kind)).collect();
        let upper = named.name.to_uppercase();
        let _ = writeln!(
            out,
            "/// Sums of the host's images.\npub static {upper}_EXPECTED: [u32; 6] = {sums:?};"
        );
        let _ = writeln!(
            out,
            "/// Sum of the host's image.\npub const {upper}_COMPACT_LIT: u32 = {};",
            sums[3]
        );
    }
    out.push_str(
        "/// The scenes whose bits are compared.\npub static SCENES: [&SceneData; 3] = [SMALL, LARGE, DENSE];\n\
         /// The sums that their images must have.\npub static EXPECTED: [[u32; 6]; 3] = [SMALL_EXPECTED, LARGE_EXPECTED, DENSE_EXPECTED];\n\
         /// The scenes whose cost is measured.\npub static COSTED: [&SceneData; 2] = [DENSE, LARGE];\n",
    );
    Ok(out)
}
