//! What is exported is enough: a scene read back from its JSON, by a reader that knows nothing of scenes, has the engine's
//! bits.

use serde_json::Value;
use slicecast::borders::Borders;
use slicecast::classify::{AlphaCode, Classifier, Colour16, Linear, Lookup, Nearest, PointTable, Sqrt8, Sqrt16};
use slicecast::composite::{BackToFront, Channel as _, ChannelFormat, FrontToBack, Recurrence, Unorm16};
use slicecast::crop::Crop;
use slicecast::format::{Direction, Intensity, Position, Step};
use slicecast::plan::{Plan, Sampling, Spacing};
use slicecast::plane::{ChannelOf, Composite, Pictured, Project};
use slicecast::precision::{Compact, Paper, Precision, Wide};
use slicecast::project::{Maximum, Sum};
use slicecast::shade::{Highlight, KeptLight, Phong, Unlit};
use slicecast::slice::RowRange;
use slicecast::slice::Voxel as _;
use slicecast::stream::{Memory, Needs, Stream};
use slicecast::table::ENTRIES;
use slicecast::view::View;
use slicecast::warp::{Warp, in_front_of};
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::rendering::in_memory_order;
use slicecast_export::{ExportError, Format, files};
use slicecast_scene::{
    AlphaCodeName, Blend, Highlight as SceneHighlight, Interpolation, LookupName, PrecisionName, Scene, file,
};
use slicecast_volume::{Mapping, Volume};

/// A ball with a soft rim, 19 x 16 x 13, its voxels stretched along z.
fn ball() -> Volume {
    let dims = [19, 16, 13];
    let [nx, ny, nz] = dims;
    let mut voxels = Vec::new();
    for (z, y, x) in (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| (z, y, x)))) {
        let at = [x, y, z].map(|c| c as f64);
        let off = [0, 1, 2].map(|a| (at[a] - (dims[a] as f64 - 1.0) / 2.0) / dims[a] as f64);
        let radius = off.iter().map(|c| c * c).sum::<f64>().sqrt();
        voxels.push((2200.0 - 4000.0 * radius).clamp(0.0, 4095.0) as u16);
    }
    Volume {
        name: "a ball */ of\ntests".into(),
        dims,
        spacing: [1.0, 1.0, 1.75],
        voxels,
        mapping: Mapping {
            scale: 1.0,
            offset: -1024.0,
        },
    }
}

/// An exported object.
struct Read(Value);

impl Read {
    fn of(files: &[(String, String)], name: &str) -> Self {
        let (_, text) = files.iter().find(|(file, _)| file == name).unwrap();
        Self(serde_json::from_str(text).unwrap())
    }

    fn list(&self, name: &str) -> Vec<i64> {
        let quantity = &self.0["quantities"][name];
        let values = quantity["value"].as_array().unwrap_or_else(|| panic!("no {name}"));
        let values: Vec<i64> = values.iter().map(|v| v.as_i64().unwrap()).collect();
        let (bits, signed) = (
            quantity["bits"].as_u64().unwrap(),
            quantity["signed"].as_bool().unwrap(),
        );
        let range = if signed {
            -(1i128 << (bits - 1))..1i128 << (bits - 1)
        } else {
            0..1i128 << bits
        };
        assert!(
            values.iter().all(|v| range.contains(&i128::from(*v))),
            "{name}: {bits} bits"
        );
        let shape = quantity["shape"]
            .as_array()
            .unwrap()
            .iter()
            .map(|n| n.as_u64().unwrap());
        assert_eq!(shape.product::<u64>(), values.len() as u64, "{name}");
        values
    }

    fn has(&self, name: &str) -> bool {
        !self.0["quantities"][name].is_null()
    }

    fn array<T: TryFrom<i64, Error: std::fmt::Debug>, const N: usize>(&self, name: &str) -> [T; N] {
        let list: Vec<T> = self.list(name).into_iter().map(|v| v.try_into().unwrap()).collect();
        list.try_into().unwrap_or_else(|_| panic!("{name}: not {N} values"))
    }

    fn one(&self, name: &str) -> u32 {
        let [value] = self.array(name);
        value
    }

    fn rows<T: TryFrom<i64, Error: std::fmt::Debug> + Copy>(&self, name: &str) -> Vec<[T; 3]> {
        let list = self.list(name).into_iter().map(|v| v.try_into().unwrap());
        let list: Vec<T> = list.collect();
        list.as_chunks().0.to_vec()
    }

    /// The plan, whose derived numbers are those of the file.
    fn plan(&self) -> Plan {
        let view = View::new(self.array("direction").map(Direction::from_bits)).unwrap();
        let sampling = Sampling {
            planes_per_voxel: self.one("planes_per_voxel"),
            rays_per_voxel: self.one("rays_per_voxel"),
        };
        let spacing = Spacing(self.array("spacing_factors").map(Intensity::from_bits));
        let borders = [Borders::Whole, Borders::Cells, Borders::Nodes][self.one("borders") as usize];
        let mut plan = Plan::with_borders(view, self.array("dims"), spacing, sampling, borders).unwrap();
        let [low, high] = ["crop_low", "crop_high"].map(|name| self.array::<i32, 3>(name));
        if [low, high] != [[0; 3]; 2] {
            // Both ends 0: open.
            let open = |axis: usize| low[axis] == 0 && high[axis] == 0;
            let faces = |faces: [i32; 3], end: i32| {
                [0, 1, 2].map(|axis| Position::from_bits(if open(axis) { end } else { faces[axis] }))
            };
            let crop = Crop {
                low: faces(low, i32::MIN),
                high: faces(high, i32::MAX),
            };
            plan = plan.with_crop(crop).unwrap();
        }
        assert_eq!(plan.first(), self.array::<u32, 3>("first_voxel"));
        assert_eq!(plan.dims(), self.array::<u32, 3>("slice_dims"));
        assert_eq!(plan.step().map(Step::to_bits), self.array::<i64, 3>("step"));
        assert_eq!(plan.origin(), self.array::<i32, 2>("origin"));
        assert_eq!(plan.base(), self.array::<u32, 2>("base"));
        assert_eq!(
            [plan.planes(), plan.phases()],
            ["planes", "phases"].map(|name| self.one(name))
        );
        if self.one("nearest") == 1 {
            plan.with_nearest()
        } else {
            plan
        }
    }

    fn phong<P: Precision>(&self, p: P) -> Phong<P> {
        let [directions, halves] = ["light_directions", "light_halves"].map(|name| self.rows::<i32>(name));
        let [diffuse, specular] = ["light_diffuse", "light_specular"].map(|name| self.rows::<u32>(name));
        let light = |n: usize| KeptLight {
            direction: directions[n],
            half: halves[n],
            diffuse: diffuse[n],
            specular: specular[n],
        };
        let lights: Vec<_> = (0..directions.len()).map(light).collect();
        let highlight = match self.one("highlight") {
            0 => Highlight::Reflection,
            _ => Highlight::HalfVector,
        };
        let exponent = self.one("exponent_log2");
        Phong::of_kept(
            p,
            self.array("ambient"),
            &lights,
            self.array("viewer"),
            highlight,
            exponent,
        )
        .unwrap()
    }
}

/// Bits of the base plane and bytes of the picture.
type Image = (Vec<u32>, Vec<u8>);

fn streamed<L: Pictured<Element: Bits>>(read: &Read, voxels: &[i64], pipeline: L) -> Image {
    let plan = read.plan();
    let needs = Needs::of::<L>(&plan);
    assert_eq!(
        [needs.slices, needs.ranges, needs.scratch, needs.image].map(|n| n as i64),
        read.array::<i64, 4>("memory_elements")
    );
    assert_eq!(needs.bytes().map(|n| n as i64), read.array::<i64, 4>("memory_bytes"));
    let mut slices = vec![0; needs.slices];
    let mut ranges = vec![RowRange::EMPTY; needs.ranges];
    let mut scratch = vec![0; needs.scratch];
    let mut image = vec![L::Element::default(); needs.image];
    let memory = Memory {
        slices: &mut slices,
        ranges: &mut ranges,
        scratch: &mut scratch,
        image: &mut image,
    };
    let mut stream = Stream::new(plan, pipeline, memory).unwrap();
    let [width, height, _] = plan.dims();
    let len = (width * height) as usize;
    while let Some(number) = stream.wanted() {
        let slice: Vec<u16> = voxels[(number - plan.first()[2]) as usize * len..][..len]
            .iter()
            .map(|v| *v as u16)
            .collect();
        stream.push(L::Voxel::given(&slice)).unwrap();
    }
    let step = |name: &str| read.array::<i64, 2>(name).map(Step::from_bits);
    let warp = Warp {
        origin: step("warp_origin"),
        right: step("warp_right"),
        down: step("warp_down"),
    };
    let background = read.array("background").map(Intensity::from_bits);
    let [columns, rows]: [u32; 2] = read.array("picture");
    let pixels = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
    let picture = pixels.flat_map(|(x, y)| {
        in_front_of(
            warp.pixel::<ChannelOf<L::Precision>>(x, y, |u, v| stream.pixel(u, v)),
            background,
        )
    });
    let picture = picture.collect();
    (stream.image().iter().map(|element| element.bits()).collect(), picture)
}

/// An element of an image.
trait Bits {
    fn bits(&self) -> u32;
}

impl Bits for u16 {
    fn bits(&self) -> u32 {
        (*self).into()
    }
}

impl Bits for Unorm16 {
    fn bits(&self) -> u32 {
        self.0.into()
    }
}

impl Bits for u32 {
    fn bits(&self) -> u32 {
        *self
    }
}

impl Bits for i32 {
    fn bits(&self) -> u32 {
        *self as u32
    }
}

/// Renders what a file says, in the precision and with the table that it says.
fn rendered(read: &Read, voxels: &[i64], precision: PrecisionName) -> Image {
    let entries: Box<[u32; ENTRIES]> = Box::new(read.array("table_entries"));
    let low: Box<[u8; ENTRIES]> = match read.one("table_code") {
        0 => Box::new([0; ENTRIES]),
        _ => Box::new(read.array("table_low_roots")),
    };
    match (precision, read.one("table_code"), read.one("table_linear")) {
        (PrecisionName::Paper, 0, 0) => of_table(read, voxels, Paper, PointTable::<Sqrt8, Nearest>::new(&entries, ())),
        (PrecisionName::Paper, 1, 1) => {
            of_table(read, voxels, Paper, PointTable::<Sqrt16, Linear>::new(&entries, &low))
        }
        (PrecisionName::Compact, 1, 1) => {
            of_table(read, voxels, Compact, PointTable::<Sqrt16, Linear>::new(&entries, &low))
        }
        (PrecisionName::Wide, 2, 1) => {
            let colours: Box<[[u8; 3]; ENTRIES]> =
                read.rows("table_low_colours").into_boxed_slice().try_into().unwrap();
            of_table(
                read,
                voxels,
                Wide,
                PointTable::<Colour16, Linear>::new(&entries, (&low, &colours)),
            )
        }
        other => panic!("{other:?}"),
    }
}

fn of_table<P, A: AlphaCode, L: Lookup>(read: &Read, voxels: &[i64], p: P, table: PointTable<'_, A, L>) -> Image
where
    P: Precision<Pixel: Recurrence<Channel: ChannelFormat + Bits>>,
    for<'a> PointTable<'a, A, L>: Classifier<P>,
{
    match (read.one("order"), read.has("ambient")) {
        (0, true) => streamed(
            read,
            voxels,
            floored(read, Composite::<_, _, _, FrontToBack>::new(p, table, read.phong(p))),
        ),
        (0, false) => streamed(
            read,
            voxels,
            floored(read, Composite::<_, _, _, FrontToBack>::new(p, table, Unlit)),
        ),
        (1, true) => streamed(
            read,
            voxels,
            Composite::<_, _, _, BackToFront>::new(p, table, read.phong(p)),
        ),
        _ => panic!("not among the cases"),
    }
}

/// With early termination at the floor that the file says.
fn floored<P: Precision, C: Classifier<P>, S: slicecast::shade::Shader<P>>(
    read: &Read,
    pipeline: Composite<P, C, S, FrontToBack>,
) -> Composite<P, C, S, FrontToBack> {
    use slicecast::plane::Pipeline as _;
    let pixel = pipeline.precision().pixel();
    let (one, floor) = (pixel.one().bits(), read.one("floor"));
    if floor == pixel.floor().bits() {
        return pipeline;
    }
    let bits = (1..32).find(|bits| one >> bits == floor).unwrap();
    pipeline.with_early_termination(bits)
}

fn expected(prepared: &Prepared<'_>) -> Image {
    let frame = prepared.render(Layer::Stream, &|_, _| ()).unwrap();
    let rays = prepared.setup.plan.sampling().rays_per_voxel as usize;
    (in_memory_order(&frame.base, rays).collect(), frame.picture.bytes)
}

fn scene() -> Scene {
    let mut scene = file::built_in("headsq").unwrap();
    scene.image.size = Some([31, 23]);
    scene.image.background = [0.1, 0.2, 0.9];
    scene
}

#[test]
fn scenes_read_back_from_json_have_the_engines_bits() {
    let volume = ball();
    let turned = |azimuth, elevation, change: fn(&mut Scene)| {
        let mut scene = scene();
        (scene.view.azimuth, scene.view.elevation) = (azimuth, elevation);
        change(&mut scene);
        scene
    };
    let cases = [
        turned(30.0, 10.0, |_| ()),
        turned(-110.0, 35.0, |s| s.precision = PrecisionName::Paper),
        turned(80.0, -75.0, |s| {
            s.precision = PrecisionName::Wide;
            s.table = Some(AlphaCodeName::Colour16);
            s.lighting.as_mut().unwrap().highlight = SceneHighlight::HalfVector;
        }),
        turned(200.0, 5.0, |s| {
            s.precision = PrecisionName::Paper;
            (s.table, s.lookup) = (Some(AlphaCodeName::Sqrt16), Some(LookupName::Linear));
            s.blend = Blend::BackToFront;
        }),
        turned(45.0, 0.0, |s| {
            s.lighting = None;
            s.early_termination = Some(4);
            s.sampling.rays_per_voxel = 3;
        }),
        turned(10.0, 0.0, |s| s.interpolation = Interpolation::Nearest),
        turned(20.0, 15.0, |s| s.borders = slicecast_scene::Borders::Cells),
        turned(-20.0, 15.0, |s| s.borders = slicecast_scene::Borders::Nodes),
        turned(160.0, 15.0, |s| {
            s.borders = slicecast_scene::Borders::Cells;
            s.crop = Some(slicecast_scene::crop::Crop::parse("2.25:8.5,:7,:").unwrap());
        }),
    ];
    for (number, scene) in cases.iter().enumerate() {
        let prepared = Prepared::new(scene, &volume).unwrap();
        let files = files(&prepared, Format::Json, "ball", true).unwrap();
        let voxels = Read::of(&files, "ball_voxels.json").list("voxels");
        let got = rendered(&Read::of(&files, "ball.json"), &voxels, scene.precision);
        let (base, picture) = expected(&prepared);
        assert!(base.iter().any(|bits| *bits != base[0]), "case {number} shows nothing");
        assert!(got.0 == base && got.1 == picture, "case {number}");
    }
}

#[test]
fn a_projection_has_no_lights_and_no_step() {
    let volume = ball();
    let mut scene = scene();
    scene.blend = Blend::Maximum;
    let prepared = Prepared::new(&scene, &volume).unwrap();
    let files = files(&prepared, Format::Json, "ball", true).unwrap();
    let read = Read::of(&files, "ball.json");
    assert_eq!(read.one("order"), 2);
    assert!(!read.has("ambient") && !read.has("floor"));
    assert!(read.0["about"]["step"].as_str().unwrap().contains("whatever the step"));
    let voxels = Read::of(&files, "ball_voxels.json").list("voxels");
    let (entries, low): (Box<_>, Box<_>) = (
        Box::new(read.array("table_entries")),
        Box::new(read.array("table_low_roots")),
    );
    let table = PointTable::<Sqrt16, Linear>::new(&entries, &low);
    let (_, picture) = streamed(&read, &voxels, Project::<_, _, Maximum>::new(Compact, table));
    assert!(picture == expected(&prepared).1);
    assert!(!read.has("additive_step"));
}

#[test]
fn sums_take_what_the_file_says() {
    let volume = ball();
    for (blend, order) in [(Blend::Average, 4), (Blend::Additive, 5)] {
        let mut scene = scene();
        scene.blend = blend;
        let prepared = Prepared::new(&scene, &volume).unwrap();
        let files = files(&prepared, Format::Json, "ball", true).unwrap();
        let read = Read::of(&files, "ball.json");
        assert_eq!(read.one("order"), order);
        assert_eq!(read.has("additive_step"), blend == Blend::Additive);
        let voxels = Read::of(&files, "ball_voxels.json").list("voxels");
        let (entries, low): (Box<_>, Box<_>) = (
            Box::new(read.array("table_entries")),
            Box::new(read.array("table_low_roots")),
        );
        let table = PointTable::<Sqrt16, Linear>::new(&entries, &low);
        let sum = if blend == Blend::Average {
            Sum::Average
        } else {
            Sum::Additive {
                step: read.one("additive_step") as u32,
                shift: read.one("additive_shift") as u32,
            }
        };
        let (base, picture) = streamed(&read, &voxels, Project::of(Compact, table, sum));
        assert!(base.iter().any(|bits| *bits != base[0]), "{blend:?} shows nothing");
        assert!(picture == expected(&prepared).1, "{blend:?}");
        let [module, ..] = &slicecast_export::files(&prepared, Format::Rust, "ball", false).unwrap()[..] else {
            panic!("no module");
        };
        let made = match sum {
            Sum::Average => "Project::of(Compact, table, Sum::Average)".to_owned(),
            Sum::Additive { step, shift } => {
                format!("Project::of(Compact, table, Sum::Additive {{ step: {step}, shift: {shift} }})")
            }
        };
        let text = format!("{module:?}");
        assert!(text.contains(&made), "{text}");
    }
}

/// A word a line, as wide as the manifest says, and the numbers of the JSON.
#[test]
fn hexadecimal_files_hold_the_same_numbers() {
    let volume = ball();
    let mut scene = scene();
    (scene.view.azimuth, scene.precision) = (-100.0, PrecisionName::Wide);
    let prepared = Prepared::new(&scene, &volume).unwrap();
    let written = files(&prepared, Format::Hex, "ball", true).unwrap();
    let json = files(&prepared, Format::Json, "ball", true).unwrap();
    let [scene, voxels] = ["ball.json", "ball_voxels.json"].map(|name| Read::of(&json, name));
    let manifest = Read::of(&written, "manifest.json");
    let listed = manifest.0["quantities"].as_object().unwrap();
    assert_eq!(listed.len() + 1, written.len());
    for (name, quantity) in listed {
        let file = quantity["file"].as_str().unwrap();
        let (_, text) = written.iter().find(|(written, _)| written == file).unwrap();
        let words: Vec<&str> = text.lines().filter(|line| !line.starts_with("//")).collect();
        assert_eq!(words.len() as u64, quantity["words"].as_u64().unwrap(), "{name}");
        let bits = quantity["bits"].as_u64().unwrap();
        assert!(words.iter().all(|word| word.len() as u64 == bits.div_ceil(4)), "{name}");
        let read: Vec<u64> = words
            .iter()
            .map(|word| u64::from_str_radix(word, 16).unwrap())
            .collect();
        let mask = u64::MAX >> (64 - bits);
        let expected = match name.as_str() {
            "table" => {
                let low = scene.list("table_low_roots");
                scene
                    .list("table_entries")
                    .iter()
                    .zip(low)
                    .map(|(entry, low)| entry << 8 | low)
                    .collect()
            }
            "voxels" => voxels.list("voxels"),
            name => scene.list(name),
        };
        let expected: Vec<u64> = expected.iter().map(|value| *value as u64 & mask).collect();
        assert_eq!(read, expected, "{name}");
    }
}

#[test]
fn what_c_has_no_pipeline_for_is_named() {
    let volume = ball();
    let refused = |change: fn(&mut Scene), name: &str| {
        let mut scene = scene();
        change(&mut scene);
        let prepared = Prepared::new(&scene, &volume).unwrap();
        files(&prepared, Format::C, name, false).unwrap_err()
    };
    for (change, given) in [
        (
            (|s| s.blend = Blend::BackToFront) as fn(&mut Scene),
            "of compact with sqrt16 and linear, back-to-front; accepted: front to back",
        ),
        (|s| s.blend = Blend::Minimum, "linear, minimum;"),
        (
            |s| s.lookup = Some(LookupName::Nearest),
            "of compact with sqrt16 and nearest, front-to-back;",
        ),
        (
            |s| s.table = Some(AlphaCodeName::Sqrt8),
            "of compact with sqrt8 and linear",
        ),
        (
            |s| s.early_termination = Some(9),
            "front-to-back, early termination at 2^-9;",
        ),
    ] {
        let error = refused(change, "ball");
        assert!(matches!(error, ExportError::NoPipeline { .. }), "{error}");
        let text = error.to_string();
        assert!(
            text.starts_with("--format c: the C interface has no pipeline ") && text.contains(given),
            "{text}"
        );
    }
    for name in ["", "1", "a b", "slicecast", "Slicecast", "a/b", "é"] {
        let error = refused(|_| (), name);
        assert!(matches!(error, ExportError::Name { .. }), "{error}");
    }
}

/// Names of volumes come from files: they end neither a line nor a comment.
#[test]
fn names_of_volumes_stay_in_their_comment() {
    let volume = ball();
    let scene = scene();
    let prepared = Prepared::new(&scene, &volume).unwrap();
    for format in [Format::Rust, Format::C] {
        let files = files(&prepared, format, "ball", false).unwrap();
        assert!(
            files[0]
                .1
                .contains("a ball * / of tests, 19 x 16 x 13 voxels 1 x 1 x 1.75 apart")
        );
    }
}
