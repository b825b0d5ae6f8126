//! What a tap sees of a frame, as sets: the inputs and outputs of every stage boundary, in the order of folding.
//!
//! | set | a vector is | in | out |
//! |---|---|---|---|
//! | `voxels`, `table` | a word of a memory | | |
//! | `location` | a plane and phase | | position, columns and rows with samples, offsets |
//! | `interpolation` | a sample | place, 8 voxels, 3 weights | sample |
//! | `opacity` | a sample | place, sample, fraction | opacity |
//! | `colour` | a visible sample | place, sample | colour |
//! | `gradient` | the same, lit | place | gradient |
//! | `normal` | the same | place, gradient | g, r |
//! | `shading` | the same | place, g, r, colour | colour |
//! | `compositing` | a visible sample | place, pixel before, opacity, colour | pixel after |
//! | `image` | a pixel of the base plane | row, column of all phases | its channels |
//! | `picture` | a pixel of the picture | row, column | 8 bits a channel |
//!
//! A tap sees what was computed: rows that nothing could be seen of are left out, and from colours on only what is visible
//! (opacity and transparency above 0).

use std::ops::Range;

use slicecast::borders::{Borders, WHOLE};
use slicecast::composite::{Channel as _, Dither, Recurrence};
use slicecast::format::Position;
use slicecast::locate::{Cell, Plane, cell, inside, plane};
use slicecast::plan::Plan;
use slicecast::precision::Precision;
use slicecast::sides::Side;
use slicecast::slice::Slice;
use slicecast::stage::Stage;
use slicecast::tap::{Beam, Bits, Tap};
use slicecast::view::Axis;
use slicecast_engine::camera::Material;
use slicecast_engine::error::RenderError;
use slicecast_engine::frame::Prepared;
use slicecast_engine::image::background;
use slicecast_engine::oriented::Turned;
use slicecast_engine::with_precision;
use slicecast_scene::{AlphaCodeName, Blend, LookupName};

use crate::directed::{self, classification, compositing, gradient, interpolation, normalisation, shading};
use crate::files::{Format, bytes_of_vector};
use crate::set::{Field, Set, ijk, rgb, s, u};

/// The part of a frame that is wanted: planes, and rows of a phase's image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Planes, by their numbers from the eye.
    pub planes: Range<u32>,
    /// Rows.
    pub rows: Range<u32>,
}

impl Part {
    /// All of a frame.
    pub fn whole(plan: &Plan) -> Self {
        Self {
            planes: 0..plan.planes(),
            rows: 0..plan.base()[1],
        }
    }
}

/// The sets of a frame, and the numbers that all its vectors share.
#[derive(Clone, Debug)]
pub struct FrameSets {
    /// In the order of the data flow.
    pub sets: Vec<Set>,
    /// View, sizes, lights and so on, by the names that directed sets give them.
    pub constants: Vec<(Field, i64)>,
}

/// The most that a part of a frame takes: samples, and bytes of its files.
pub fn at_most(prepared: &Prepared<'_>, part: &Part, formats: &[Format]) -> [u64; 2] {
    let (plan, sets) = (&prepared.setup.plan, Sets::of(prepared));
    let samples: u64 = part
        .planes
        .clone()
        .map(|index| samples_of(plan, index, &part.rows))
        .sum();
    let line = |set: &Set| bytes_of_vector(set, formats);
    let of_sample: u64 = sets.stages().iter().map(|set| line(set)).sum();
    let planes = u64::from(plan.phases()) * part.planes.len() as u64;
    let voxels: u64 = plan.dims().into_iter().map(u64::from).product();
    let mut bytes = samples * of_sample + planes * line(&sets.location) + voxels * line(&sets.voxels);
    bytes += 4096 * line(&sets.table);
    if *part == Part::whole(plan) {
        let [width, height] = plan.base().map(u64::from);
        let [across, down] = prepared.setup.picture.size.map(u64::from);
        bytes += width * height * u64::from(plan.phases()) * line(&sets.image) + across * down * line(&sets.picture);
    }
    [samples, bytes]
}

/// Samples of a plane's rows, all phases.
fn samples_of(plan: &Plan, index: u32, rows: &Range<u32>) -> u64 {
    let of_phase = |phase| {
        let [columns, met] = extent(plan, &plane(plan, plan.phase(phase), index));
        let met = met.start.max(rows.start)..met.end.min(rows.end);
        columns.len() as u64 * met.len() as u64
    };
    (0..plan.phases()).map(of_phase).sum()
}

/// Columns and rows of a phase's image that have a sample in a plane.
fn extent(plan: &Plan, plane: &Plane) -> [Range<u32>; 2] {
    let ([width, height, _], [base_width, base_height]) = (plan.dims(), plan.base());
    if plan.borders() == Borders::Whole {
        return [
            inside(cell(plane.x), width, base_width),
            inside(cell(plane.y), height, base_height),
        ];
    }
    let [columns, rows] = sides(plan, plane);
    [between(columns, base_width), between(rows, base_height)]
}

/// A plane's segments along i and j.
fn sides(plan: &Plan, plane: &Plane) -> [Side; 2] {
    let [start_i, start_j] = plan.start(plane.phase);
    [
        Side::of(plan, start_i, 0, plane.index),
        Side::of(plan, start_j, 1, plane.index),
    ]
}

/// Pixels of whose segments something lies between the faces.
fn between(side: Side, pixels: u32) -> Range<u32> {
    let counts = |pixel: &u32| side.part(*pixel).length() > 0;
    let first = (0..pixels).find(counts).unwrap_or(pixels);
    first..(first..pixels).rfind(counts).map_or(first, |last| last + 1)
}

/// What of a pixel's segment a sample counts for, 0.16.
fn fraction(plan: &Plan, plane: &Plane, [column, row]: [u32; 2]) -> u32 {
    if plan.borders() == Borders::Whole {
        return WHOLE;
    }
    let [columns, rows] = sides(plan, plane);
    columns.part(column).fraction(rows.part(row))
}

/// The cells of a pixel's sample, held to the voxels.
fn cells(plan: &Plan, plane: &Plane, [column, row]: [u32; 2]) -> [Cell; 3] {
    let own = [(plane.x, column), (plane.y, row), (plane.z, 0)];
    let mut sides = plan.dims().into_iter();
    own.map(|(position, pixel)| {
        let last = i64::from(sides.next().unwrap_or(1)) - 1;
        let position = i64::from(position.to_bits()) + (i64::from(pixel) << 16);
        cell(Position::from_bits(position.clamp(0, last << 16) as i32))
    })
}

/// Renders a part of a frame under a tap.
///
/// # Errors
/// [`RenderError`] as for any frame, and if segments are classified, samples are summed up or the volume is cropped: the sets have
/// one sample an opacity, of a whole volume.
pub fn sets(prepared: &Prepared<'_>, part: &Part) -> Result<FrameSets, RenderError> {
    prepared.check_points()?;
    prepared.check_staged()?;
    prepared.check_uncropped()?;
    if matches!(prepared.scene.blend, Blend::Average | Blend::Additive) {
        return Err(RenderError::Summed);
    }
    let plan = &prepared.setup.plan;
    let mut turned = Turned::new(prepared.volume, plan);
    let slices = turned.slices()?;
    let mut rendering = prepared.begun()?;
    let mut sets = Sets::of(prepared);
    for slice in &slices {
        let rows = (0..slice.height()).flat_map(|row| slice.row(row).iter());
        rows.for_each(|voxel| sets.voxels.push(&[i64::from(*voxel)], &[]));
    }
    let table = &prepared.table;
    for ((word, root), [r, g, b]) in table.entries.iter().zip(table.plane.iter()).zip(table.colours.iter()) {
        let row = [i64::from(*word), (*root).into(), (*r).into(), (*g).into(), (*b).into()];
        sets.table.push(&row, &[]);
    }
    let mut recorder = Recorder {
        plan,
        slices: &slices,
        part,
        sets,
        row: Row::default(),
        span: Span::default(),
    };
    rendering.stream(&slices, &|_, _| (), Some(&mut recorder))?;
    let mut sets = recorder.sets;
    if *part == Part::whole(plan) {
        let base = rendering.base();
        let [width, height] = base.size;
        for at in 0..width * height {
            let channels = [0, 1, 2, 3].map(|channel| i64::from(base.planes[channel][at]));
            sets.image.push(&[(at / width) as i64, (at % width) as i64], &channels);
        }
        let picture = rendering.picture(&prepared.shown());
        let width = picture.size[0] as usize;
        for (at, pixel) in picture.bytes.chunks_exact(3).enumerate() {
            let bytes = [0, 1, 2].map(|channel| i64::from(pixel[channel]));
            sets.picture.push(&[(at / width) as i64, (at % width) as i64], &bytes);
        }
    }
    Ok(FrameSets {
        sets: sets.in_order(),
        constants: with_precision!(prepared.scene.precision, precision => constants(precision, prepared)),
    })
}

/// The sets of a frame by name.
struct Sets {
    voxels: Set,
    table: Set,
    location: Set,
    interpolation: Set,
    opacity: Set,
    colour: Set,
    gradient: Set,
    normal: Set,
    shading: Set,
    compositing: Set,
    image: Set,
    picture: Set,
}

/// A sample's place.
fn place() -> Vec<Field> {
    vec![
        u("plane", 16, "number from the eye"),
        u("phase", 6, "number, v rays_per_voxel + u"),
        u("row", 15, "of the phase"),
        u("column", 15, "of the phase"),
    ]
}

/// A set of a frame: its name is its stage's.
fn set(stage: &'static str, about: &'static str, place: Vec<Field>, inputs: Vec<Field>, outputs: Vec<Field>) -> Set {
    let places = place.len();
    let mut set = Set::new(None, stage, about, [place, inputs].concat(), outputs);
    set.name = stage.into();
    set.place = places;
    set
}

impl Sets {
    fn of(prepared: &Prepared<'_>) -> Self {
        with_precision!(prepared.scene.precision, precision => Self::in_precision(precision))
    }

    fn in_precision<P: Precision>(p: P) -> Self {
        let bits = p.formats().sample_bits;
        let sample = || vec![u("sample", 12 + bits, directed::sample_unit(p))];
        let opacity = || vec![u("opacity", 32, "2^-31")];
        let colour = |name| rgb(&directed::colour(p, name)).to_vec();
        let of_plane = || place()[..2].to_vec();
        let mut location = ["x", "y", "z"].map(|axis| s(axis, 30, "2^-16 voxel")).to_vec();
        let ends = ["first_column", "end_column", "first_row", "end_row"];
        location.extend(ends.map(|name| u(name, 15, "pixels of the phase")));
        location.extend(["dither_t", "dither_c"].map(|name| u(name, 15, "2^-15")));
        let full = |name| u(name, 17, "pixels of all phases");
        let of_picture = |name| u(name, 15, "picture pixels");
        let set_of_sample = |stage, about, inputs, outputs| set(stage, about, place(), inputs, outputs);
        Self {
            voxels: set(
                "voxels",
                "slices along k, each row after row: i fastest",
                Vec::new(),
                vec![u("voxel", 12, "code")],
                Vec::new(),
            ),
            table: set(
                "table",
                "the table's memories, by code",
                Vec::new(),
                classification::entry("entry"),
                Vec::new(),
            ),
            location: set(
                "location",
                "where a plane's samples lie",
                of_plane(),
                Vec::new(),
                location,
            ),
            interpolation: set_of_sample(
                "interpolation",
                "a sample from the voxels around it, voxel_kji",
                interpolation::fields(),
                sample(),
            ),
            opacity: set_of_sample(
                "opacity",
                "opacity of a sample, of its fraction of a step",
                [sample(), vec![directed::borders::fraction()]].concat(),
                opacity(),
            ),
            colour: set_of_sample("colour", "colour of a visible sample", sample(), colour("colour")),
            gradient: set_of_sample(
                "gradient",
                "gradient of a visible sample, spacing factors included, from the voxels around its place",
                Vec::new(),
                gradient::outputs(p),
            ),
            normal: set_of_sample(
                "normal",
                "direction of a gradient",
                gradient::outputs(p),
                normalisation::normal(),
            ),
            shading: set_of_sample(
                "shading",
                "colour under the frame's lights",
                [normalisation::normal(), colour("colour")].concat(),
                colour("shaded"),
            ),
            compositing: set_of_sample(
                "compositing",
                "a pixel before and after a sample",
                [compositing::pixel(p, "before"), opacity(), colour("colour")].concat(),
                compositing::pixel(p, "after"),
            ),
            image: set(
                "image",
                "the base plane when all planes are folded",
                vec![full("row"), full("column")],
                Vec::new(),
                compositing::pixel(p, "pixel"),
            ),
            picture: set(
                "picture",
                "the base plane warped, in front of the background",
                vec![of_picture("row"), of_picture("column")],
                Vec::new(),
                rgb(&u("byte", 8, "1/255")).to_vec(),
            ),
        }
    }

    /// Those with a vector a sample, at most.
    fn stages(&self) -> [&Set; 7] {
        [
            &self.interpolation,
            &self.opacity,
            &self.colour,
            &self.gradient,
            &self.normal,
            &self.shading,
            &self.compositing,
        ]
    }

    fn in_order(self) -> Vec<Set> {
        let all = [
            self.voxels,
            self.table,
            self.location,
            self.interpolation,
            self.opacity,
            self.colour,
            self.gradient,
            self.normal,
            self.shading,
            self.compositing,
            self.image,
            self.picture,
        ];
        all.into_iter().filter(|set| !set.is_empty()).collect()
    }
}

/// The row under way: its first column, samples and opacities.
#[derive(Default)]
struct Row {
    first: u32,
    samples: Vec<i64>,
    opacities: Vec<i64>,
}

impl Row {
    /// Sample and opacity of a column.
    fn at(&self, column: u32) -> [i64; 2] {
        let at = (column - self.first) as usize;
        [self.samples[at], self.opacities[at]]
    }
}

/// The span under way: the colour that is composited, gradient, normal, the pixels before, a row each.
#[derive(Default)]
struct Span {
    colour: Vec<[i64; 3]>,
    gradient: Vec<[i64; 3]>,
    before: Vec<[i64; 4]>,
    normal: Vec<[i64; 4]>,
}

/// The tap.
struct Recorder<'a> {
    plan: &'a Plan,
    slices: &'a [Slice<'a>],
    part: &'a Part,
    sets: Sets,
    row: Row,
    span: Span,
}

/// Numbers without a sign, column after column.
fn unsigned<const N: usize>(rows: &[&dyn Bits]) -> Vec<[i64; N]> {
    let len = rows.first().map_or(0, |row| row.len());
    (0..len)
        .map(|at| std::array::from_fn(|row| rows.get(row).map_or(0, |row| i64::from(row.bits(at)))))
        .collect()
}

/// Numbers with one.
fn signed<const N: usize>(rows: &[&dyn Bits]) -> Vec<[i64; N]> {
    let mut all = unsigned(rows);
    all.iter_mut()
        .flatten()
        .for_each(|value| *value = i64::from(*value as u32 as i32));
    all
}

impl Recorder<'_> {
    /// The number of a plane's phase.
    fn phase(&self, plane: &Plane) -> i64 {
        (plane.phase.u + plane.phase.v * self.plan.sampling().rays_per_voxel).into()
    }

    /// The place of a column of a row, `offset` columns behind its first.
    fn place(&self, at: Beam<'_>, offset: usize) -> [i64; 4] {
        let column = i64::from(at.column) + offset as i64;
        [at.plane.index.into(), self.phase(at.plane), at.row.into(), column]
    }

    /// The eight voxels around a sample and its weights.
    fn around(&self, at: Beam<'_>, offset: usize) -> [i64; 11] {
        let cells = cells(self.plan, at.plane, [at.column + offset as u32, at.row]);
        let [width, height, depth] = self.plan.dims();
        let index = cells.map(|cell| cell.index);
        // Behind the last voxel there is none; its weight is 0.
        let held = |index: i32, side: u32| index.clamp(0, side as i32 - 1) as usize;
        let mut values = [0; 11];
        for (corner, value) in values.iter_mut().take(8).enumerate() {
            let beside = |axis: usize| index[axis] + (corner >> axis & 1) as i32;
            let row = self.slices[held(beside(2), depth)].row(held(beside(1), height));
            *value = row[held(beside(0), width)].into();
        }
        for (value, cell) in values[8..].iter_mut().zip(cells) {
            *value = cell.weight.to_bits().into();
        }
        values
    }

    fn see_row(&mut self, at: Beam<'_>, rows: &[&dyn Bits]) {
        self.row.first = at.column;
        self.row.samples = signed::<1>(rows).into_iter().flatten().collect();
        for (offset, sample) in self.row.samples.iter().enumerate() {
            let inputs = [&self.place(at, offset)[..], &self.around(at, offset)].concat();
            self.sets.interpolation.push(&inputs, &[*sample]);
        }
    }

    fn see_opacities(&mut self, at: Beam<'_>, rows: &[&dyn Bits]) {
        self.row.opacities = unsigned::<1>(rows).into_iter().flatten().collect();
        for offset in 0..self.row.opacities.len() {
            let column = at.column + offset as u32;
            let [sample, opacity] = self.row.at(column);
            let fraction = fraction(self.plan, at.plane, [column, at.row]);
            let inputs = [&self.place(at, offset)[..], &[sample, fraction.into()]].concat();
            self.sets.opacity.push(&inputs, &[opacity]);
        }
    }

    fn see_colours(&mut self, at: Beam<'_>, rows: &[&dyn Bits]) {
        self.span.colour = unsigned(rows);
        for (offset, colour) in self.span.colour.iter().enumerate() {
            let [sample, _] = self.row.at(at.column + offset as u32);
            let inputs = [&self.place(at, offset)[..], &[sample]].concat();
            self.sets.colour.push(&inputs, colour);
        }
    }

    fn see_gradients(&mut self, at: Beam<'_>, rows: &[&dyn Bits]) {
        self.span.gradient = signed(rows);
        for (offset, gradient) in self.span.gradient.iter().enumerate() {
            let place = self.place(at, offset);
            self.sets.gradient.push(&place, gradient);
        }
    }

    fn see_normals(&mut self, at: Beam<'_>, rows: &[&dyn Bits]) {
        self.span.normal = signed(rows);
        for (offset, normal) in self.span.normal.iter().enumerate() {
            let inputs = [&self.place(at, offset)[..], &self.span.gradient[offset]].concat();
            self.sets.normal.push(&inputs, normal);
        }
    }

    fn see_shaded(&mut self, at: Beam<'_>, rows: &[&dyn Bits]) {
        let shaded = unsigned(rows);
        for (offset, colour) in shaded.iter().enumerate() {
            let normal = &self.span.normal[offset];
            let inputs = [&self.place(at, offset)[..], normal, &self.span.colour[offset]].concat();
            self.sets.shading.push(&inputs, colour);
        }
        self.span.colour = shaded;
    }

    fn see_after(&mut self, at: Beam<'_>, rows: &[&dyn Bits]) {
        for (offset, after) in unsigned::<4>(rows).iter().enumerate() {
            let [_, opacity] = self.row.at(at.column + offset as u32);
            let (before, colour) = (&self.span.before[offset], &self.span.colour[offset]);
            let inputs = [&self.place(at, offset)[..], before, &[opacity], colour].concat();
            self.sets.compositing.push(&inputs, after);
        }
    }
}

impl Tap for Recorder<'_> {
    fn plane(&mut self, plane: &Plane) {
        if !self.part.planes.contains(&plane.index) {
            return;
        }
        let [columns, rows] = extent(self.plan, plane);
        let dither = Dither::of_plane(plane.index);
        let [x, y, z] = [plane.x, plane.y, plane.z].map(|position| i64::from(position.to_bits()));
        let ends = [columns.start, columns.end, rows.start, rows.end].map(i64::from);
        let offsets = [dither.transparency, dither.colour].map(i64::from);
        let outputs = [&[x, y, z][..], &ends, &offsets].concat();
        let inputs = [plane.index.into(), self.phase(plane)];
        self.sets.location.push(&inputs, &outputs);
    }

    fn row(&mut self, stage: Stage, at: Beam<'_>, rows: &[&dyn Bits]) {
        if !self.part.planes.contains(&at.plane.index) || !self.part.rows.contains(&at.row) {
            return;
        }
        match stage {
            Stage::Location => {}
            Stage::Interpolation => self.see_row(at, rows),
            Stage::Opacity => self.see_opacities(at, rows),
            Stage::Colour => self.see_colours(at, rows),
            Stage::Gradient => self.see_gradients(at, rows),
            Stage::Normal => self.see_normals(at, rows),
            Stage::Shading => self.see_shaded(at, rows),
            Stage::Before => self.span.before = unsigned(rows),
            Stage::After => self.see_after(at, rows),
        }
    }
}

/// The numbers that all vectors of a frame share.
fn constants<P: Precision>(p: P, prepared: &Prepared<'_>) -> Vec<(Field, i64)> {
    let (plan, scene) = (&prepared.setup.plan, prepared.scene);
    let mut all: Vec<(Field, i64)> = Vec::new();
    let three = |all: &mut Vec<(Field, i64)>, fields: [Field; 3], values: [i64; 3]| {
        all.extend(fields.into_iter().zip(values));
    };
    let major = match plan.view().major() {
        Axis::X => 0,
        Axis::Y => 1,
        Axis::Z => 2,
    };
    all.push((u("major", 2, "0 x, 1 y, 2 z"), major));
    all.push((
        u("reversed", 1, "1: slices are read from the far end"),
        plan.view().reversed().into(),
    ));
    three(&mut all, ijk(&u("side", 14, "voxels")), plan.dims().map(i64::from));
    three(
        &mut all,
        ijk(&s("step", 34, "2^-32 voxel")),
        plan.step().map(|step| step.to_bits()),
    );
    three(
        &mut all,
        ijk(&u("factor", 16, "2^-15")),
        plan.spacing().map(|factor| factor.to_bits().into()),
    );
    let ([columns, rows], [origin_i, origin_j]) = (plan.base().map(i64::from), plan.origin().map(i64::from));
    all.push((u("columns", 15, "pixels of a phase"), columns));
    all.push((u("rows", 15, "pixels of a phase"), rows));
    all.push((s("origin_i", 14, "voxels"), origin_i));
    all.push((s("origin_j", 14, "voxels"), origin_j));
    all.push((u("planes", 16, "planes"), plan.planes().into()));
    all.push((
        u("planes_per_voxel", 5, "planes"),
        plan.sampling().planes_per_voxel.into(),
    ));
    all.push((u("rays_per_voxel", 4, "rays"), plan.sampling().rays_per_voxel.into()));
    all.push((u("nearest", 1, "1: samples lie at voxels"), plan.is_nearest().into()));
    let borders = directed::borders::number(plan.borders());
    all.push((directed::borders::field(), borders));
    let code = match prepared.table.code {
        AlphaCodeName::Sqrt8 => 0,
        AlphaCodeName::Sqrt16 => 1,
        AlphaCodeName::Colour16 => 2,
    };
    all.push((u("code", 2, "0 sqrt8, 1 sqrt16, 2 colour16"), code));
    let linear = prepared.table.lookup == LookupName::Linear;
    all.push((u("lookup", 1, "0 nearest, 1 linear"), linear.into()));
    let order = match scene.blend {
        Blend::FrontToBack => 0,
        Blend::BackToFront => 1,
        Blend::Maximum => 2,
        Blend::Minimum => 3,
        // Refused before.
        Blend::Average | Blend::Additive => unreachable!("sums have no vectors"),
    };
    all.push((
        u("blend", 2, "0 front to back, 1 back to front, 2 maximum, 3 minimum"),
        order,
    ));
    let (own, one) = (p.pixel().floor().bits(), p.pixel().one().bits());
    let floor = scene.early_termination.map_or(own, |bits| own.max(one >> bits));
    // Back to front there is none.
    let floor = if scene.blend == Blend::BackToFront { 0 } else { floor };
    all.push((directed::channel(p, "floor"), floor.into()));
    if let Some(material) = &prepared.setup.material {
        all.extend(shading::scene_fields().into_iter().zip(lights(material)));
    }
    let warp = prepared.setup.picture.warp;
    for (name, steps) in [
        ("warp_origin", warp.origin),
        ("warp_right", warp.right),
        ("warp_down", warp.down),
    ] {
        for (axis, step) in ["u", "v"].into_iter().zip(steps) {
            all.push((
                s(format!("{name}_{axis}"), 64, "2^-32 base-plane pixel"),
                step.to_bits(),
            ));
        }
    }
    let behind = background(scene.image.background).map(|channel| i64::from(channel.to_bits()));
    three(&mut all, rgb(&u("background", 16, "2^-15")), behind);
    all
}

/// Lights and material as the shading set's fields.
fn lights(material: &Material) -> Vec<i64> {
    use slicecast::format::{Coefficient, Vector};
    use slicecast::shade::Highlight;
    let vector = |v: [Vector; 3]| v.map(|c| i64::from(c.to_bits()));
    let coefficient = |k: [Coefficient; 3]| k.map(|c| i64::from(c.to_bits()));
    let lamps: Vec<_> = material
        .lights
        .iter()
        .map(|light| {
            let (diffuse, specular) = (coefficient(light.diffuse), coefficient(light.specular));
            [vector(light.direction), vector(light.half), diffuse, specular]
        })
        .collect();
    let half_vector = material.highlight == Highlight::HalfVector;
    let form = [half_vector.into(), material.exponent_log2.into()];
    shading::scene_values(coefficient(material.ambient), vector(material.viewer), form, &lamps)
}
