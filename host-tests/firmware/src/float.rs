//! The same pipeline in f32, for comparison: what an engineer would write for a machine with floating point. The stages,
//! their order, their row structure and what they skip are those of slicecast; only the numbers differ, and the slices
//! are read where they lie, without a ring.

use slicecast::classify::{Support, opacity_of_root};
use slicecast::locate::{Plane, cell, plane};
use slicecast::plan::{Phase, Plan};
use slicecast::slice::{RowRange, Slice};
use slicecast::stage::Stage;
use slicecast::table::ENTRIES;
use slicecast_firmware_shared::scene::{Lighting, SceneData};

/// The longest side of a slice.
const SIDE: usize = 64;
/// A row with a place before and one behind.
type Row = [f32; SIDE + 2];

/// Memory of the f32 pipeline.
#[derive(Debug)]
pub struct Buffers {
    /// Red, green, blue, opacity.
    table: [[f32; 4]; ENTRIES],
    /// Red, green, blue, transparency.
    image: [[f32; 4]; 128 * 128],
    /// The samples of a plane, one row beyond each face.
    samples: [Row; SIDE + 2],
    z: [Row; 2],
    y: Row,
    opacity: Row,
    colour: [Row; 3],
    g: [Row; 3],
    dz: [Row; 2],
    /// Of every row of voxels, and how many slices have theirs.
    ranges: [[RowRange; SIDE]; SIDE],
    measured: usize,
}

impl Buffers {
    /// Zeroed memory.
    pub const fn new() -> Self {
        Self {
            table: [[0.0; 4]; ENTRIES],
            image: [[0.0; 4]; 128 * 128],
            samples: [[0.0; SIDE + 2]; SIDE + 2],
            z: [[0.0; SIDE + 2]; 2],
            y: [0.0; SIDE + 2],
            opacity: [0.0; SIDE + 2],
            colour: [[0.0; SIDE + 2]; 3],
            g: [[0.0; SIDE + 2]; 3],
            dz: [[0.0; SIDE + 2]; 2],
            ranges: [[RowRange { low: 0, high: 0 }; SIDE]; SIDE],
            measured: 0,
        }
    }
}

impl Default for Buffers {
    fn default() -> Self {
        Self::new()
    }
}

struct Lamp {
    direction: [f32; 3],
    half: [f32; 3],
    diffuse: [f32; 3],
    specular: [f32; 3],
}

struct Lamps<'a> {
    list: &'a [Lamp],
    ambient: [f32; 3],
    viewer: [f32; 3],
    half_vector: bool,
    exponent_log2: u32,
}

/// Renders a scene; `mark` is called when a stage has done a row. False if the scene is
/// out of range.
pub fn render(scene: &SceneData, lit: bool, b: &mut Buffers, mark: &mut impl FnMut(Stage)) -> bool {
    let Ok(plan) = scene.plan() else { return false };
    for (t, (entry, low)) in b.table.iter_mut().zip(scene.entries16.iter().zip(scene.plane16)) {
        let [red, green, blue, high] = entry.to_le_bytes();
        let part = |c: u8| f32::from(c) / 255.0;
        let opacity = opacity_of_root(u16::from_be_bytes([high, *low])).to_bits() as f32 / 2_147_483_648.0;
        *t = [part(red), part(green), part(blue), opacity];
    }
    b.image.fill([0.0, 0.0, 0.0, 1.0]);
    b.measured = 0;
    let support = Support::of(b.table.iter().map(|entry| entry[3] != 0.0));
    let dark = b.table.iter().position(|entry| entry[3] != 0.0).unwrap_or(ENTRIES) as f32 - 1.0;
    let unit = |v: [i32; 3]| v.map(|c| c as f32 / 1_073_741_824.0);
    let share = |v: [u32; 3]| v.map(|c| c as f32 / 2_147_483_648.0);
    let Lighting {
        ambient,
        viewer,
        half_vector,
        exponent_log2,
        lights,
    } = &scene.lighting;
    let mut list = [const {
        Lamp {
            direction: [0.0; 3],
            half: [0.0; 3],
            diffuse: [0.0; 3],
            specular: [0.0; 3],
        }
    }; 8];
    for (lamp, (direction, half, diffuse, specular)) in list.iter_mut().zip(*lights) {
        *lamp = Lamp {
            direction: unit(*direction),
            half: unit(*half),
            diffuse: share(*diffuse),
            specular: share(*specular),
        };
    }
    let lamps = Lamps {
        list: &list[..lights.len().min(8)],
        ambient: share(*ambient),
        viewer: unit(*viewer),
        half_vector: *half_vector,
        exponent_log2: *exponent_log2,
    };
    let spacing = plan.spacing().map(|f| f32::from(f.to_bits()) / 32768.0);
    for index in 0..plan.planes() {
        let plane = plane(&plan, Phase::default(), index);
        let [width, height, depth] = plan.dims().map(|d| d as usize);
        while b.measured < depth.min(cell(plane.z).index as usize + if lit { 3 } else { 2 }) {
            let voxels = &scene.voxels[b.measured * width * height..][..width * height];
            if Slice::measure(voxels, width, height, width, &mut b.ranges[b.measured]).is_err() {
                return false;
            }
            b.measured += 1;
        }
        mark(Stage::Location);
        fold(
            scene,
            &plan,
            &plane,
            lit.then_some(&lamps),
            spacing,
            (support, dark),
            b,
            mark,
        );
    }
    true
}

/// The largest difference of a channel, 0 to 1, between the picture rendered last and a `Wide` image of the same scene.
pub fn largest_difference(plan: &Plan, b: &Buffers, wide: &[u32]) -> f32 {
    let [width, height] = plan.base().map(|d| d as usize);
    let mut largest = 0.0f32;
    for (row, pixels) in wide.chunks_exact(4 * width).zip(b.image.chunks_exact(128)).take(height) {
        for (column, pixel) in pixels.iter().take(width).enumerate() {
            for (channel, value) in pixel.iter().enumerate() {
                let exact = row[channel * width + column] as f32 / 2_147_483_648.0;
                largest = largest.max((value - exact).abs());
            }
        }
    }
    largest
}

#[expect(clippy::too_many_arguments, reason = "a comparison, kept in one place")]
fn fold(
    scene: &SceneData,
    plan: &Plan,
    plane: &Plane,
    lamps: Option<&Lamps<'_>>,
    spacing: [f32; 3],
    (support, dark): (Support, f32),
    b: &mut Buffers,
    mark: &mut impl FnMut(Stage),
) {
    let [width, height, depth] = plan.dims().map(|d| d as usize);
    let (x, y, z) = (cell(plane.x), cell(plane.y), cell(plane.z));
    let weight = |bits: u32| bits as f32 / 65536.0;
    let (wx, wy, wz) = (
        weight(x.weight.to_bits()),
        weight(y.weight.to_bits()),
        weight(z.weight.to_bits()),
    );
    let near = z.index as usize;
    let row_of = |k: usize, row: usize| -> &[u16] {
        let start = (k * height + row) * width;
        &scene.voxels[start..start + width]
    };
    let far = (near + 1).min(depth - 1);
    let [base_width, base_height] = plan.base().map(|d| d as usize);

    // Pixels whose samples lie inside the volume.
    let inside = |index: i32, w: f32, side: usize, pixels: usize| {
        let end = side as i32 - index - i32::from(w > 0.0);
        let first = (-index).clamp(0, pixels as i32) as usize;
        first..(end.clamp(0, pixels as i32) as usize).max(first)
    };
    let columns = inside(x.index, wx, width, base_width);
    let rows = inside(y.index, wy, height, base_height);
    if columns.is_empty() {
        return;
    }
    let first = (columns.start as i32 + x.index) as usize;
    let n = columns.len();

    let mut made = [false; SIDE + 2];
    let mut made_z = [usize::MAX; 2];
    for row in rows {
        let voxel_row = (row as i32 + y.index) as usize;
        let here = voxel_row + 1;
        let pixels = row * 128 + columns.start..row * 128 + columns.start + n;
        if b.image[pixels.clone()].iter().all(|p| p[3] == 0.0) {
            continue;
        }
        let range = |slice: usize, row: usize| b.ranges[slice][row.min(height - 1)];
        let rows_of = |slice| range(slice, voxel_row).union(range(slice, voxel_row + 1));
        if !support.meets(rows_of(near).union(rows_of(far))) {
            continue;
        }
        // Sample rows are made once per plane, when they are needed.
        let mut need = |row: usize, b: &mut Buffers| {
            if !made[row] {
                make_row(row, height, width, [wx, wy, wz], [near, far], &row_of, b, &mut made_z);
                made[row] = true;
            }
        };
        need(here, b);
        let places = first + 1..first + 1 + n;
        mark(Stage::Interpolation);

        for (o, s) in b.opacity.iter_mut().zip(&b.samples[here][places.clone()]) {
            if *s <= dark {
                *o = 0.0;
                continue;
            }
            let (i, f) = (*s as usize, *s - (*s as usize) as f32);
            let (p, q) = (b.table[i.min(ENTRIES - 1)][3], b.table[(i + 1).min(ENTRIES - 1)][3]);
            *o = p + (q - p) * f;
        }
        mark(Stage::Opacity);

        let mut from = 0;
        loop {
            // As integers: positive floats are 0 where their bits are.
            let visible = |(a, p): (&f32, &[f32; 4])| a.to_bits() != 0 && p[3].to_bits() != 0;
            let mut rest = b.opacity[from..n].iter().zip(&b.image[pixels.clone()][from..]);
            let Some(skipped) = rest.position(visible) else { break };
            let start = from + skipped;
            let end = rest.position(|s| !visible(s)).map_or(n, |p| start + p + 1);
            from = end;
            let len = end - start;
            let span = places.start + start..places.start + end;
            let [red, green, blue] = &mut b.colour;
            for (((r, g), bl), s) in red.iter_mut().zip(green).zip(blue).zip(&b.samples[here][span.clone()]) {
                let (i, f) = (*s as usize, *s - (*s as usize) as f32);
                let (p, q) = (&b.table[i.min(ENTRIES - 1)], &b.table[(i + 1).min(ENTRIES - 1)]);
                *r = p[0] + (q[0] - p[0]) * f;
                *g = p[1] + (q[1] - p[1]) * f;
                *bl = p[2] + (q[2] - p[2]) * f;
            }
            mark(Stage::Colour);
            if let Some(lamps) = lamps {
                need(here - 1, b);
                need(here + 1, b);
                gradients(
                    here,
                    span.clone(),
                    [near, far],
                    depth,
                    height,
                    [wx, wy, wz],
                    spacing,
                    &row_of,
                    b,
                );
                mark(Stage::Gradient);
                let [gx, gy, gz] = &mut b.g;
                for ((x, y), z) in gx[..len].iter_mut().zip(gy).zip(gz) {
                    let square = *x * *x + *y * *y + *z * *z;
                    let r = if square > 0.0 { -1.0 / root(square) } else { 0.0 };
                    (*x, *y, *z) = (*x * r, *y * r, *z * r);
                }
                mark(Stage::Normal);
                shade(lamps, len, &b.g, &mut b.colour);
                mark(Stage::Shading);
            }
            composite(
                &mut b.image[pixels.clone()][start..end],
                &b.opacity[start..end],
                &b.colour,
            );
            mark(Stage::After);
        }
    }
}

/// Folds a span into its pixels. Not inlined: with registers of its own it takes fewer instructions.
#[inline(never)]
fn composite(pixels: &mut [[f32; 4]], opacity: &[f32], [red, green, blue]: &[Row; 3]) {
    let colours = red.iter().zip(green).zip(blue);
    for ((p, a), ((r, g), b)) in pixels.iter_mut().zip(opacity).zip(colours) {
        let w = p[3] * a;
        let t = p[3] - w;
        p[3] = if t < 1.0 / 1_048_576.0 { 0.0 } else { t };
        p[0] += r * w;
        p[1] += g * w;
        p[2] += b * w;
    }
}

/// Samples of the rows between voxel rows `made - 1` and `made` (row -1 and row `height` lie beyond the faces).
#[expect(clippy::too_many_arguments, reason = "a comparison, kept in one place")]
fn make_row<'v>(
    made: usize,
    height: usize,
    width: usize,
    [wx, wy, wz]: [f32; 3],
    [near, far]: [usize; 2],
    row_of: &impl Fn(usize, usize) -> &'v [u16],
    b: &mut Buffers,
    made_z: &mut [usize; 2],
) {
    for voxel_row in [made, made + 1] {
        let slot = voxel_row & 1;
        if made_z[slot] == voxel_row {
            continue;
        }
        made_z[slot] = voxel_row;
        let edge = voxel_row.clamp(1, height) - 1;
        let lerp = |row: usize, out: &mut [f32]| {
            if wz == 0.0 {
                for (o, n) in out.iter_mut().zip(row_of(near, row)) {
                    *o = f32::from(*n);
                }
                return;
            }
            for ((o, n), f) in out.iter_mut().zip(row_of(near, row)).zip(row_of(far, row)) {
                let (n, f) = (f32::from(*n), f32::from(*f));
                *o = n + (f - n) * wz;
            }
        };
        lerp(edge, &mut b.z[slot][1..=width]);
        if voxel_row != edge + 1 {
            let inner = if voxel_row == 0 {
                1.min(height - 1)
            } else {
                height.max(2) - 2
            };
            lerp(inner, &mut b.y[1..=width]);
            for (o, i) in b.z[slot][1..=width].iter_mut().zip(&b.y[1..=width]) {
                *o = 2.0 * *o - i;
            }
        }
        let z = &mut b.z[slot];
        z[0] = 2.0 * z[1] - z[2];
        z[width + 1] = 2.0 * z[width] - z[width - 1];
    }
    let (this, next) = (&b.z[made & 1], &b.z[(made + 1) & 1]);
    for ((o, a), c) in b.y[..width + 2].iter_mut().zip(this).zip(next) {
        *o = a + (c - a) * wy;
    }
    for (o, pair) in b.samples[made].iter_mut().zip(b.y[..width + 2].windows(2)) {
        *o = pair[0] + (pair[1] - pair[0]) * wx;
    }
}

/// Gradients of a span: neighbours along i and j, interpolated differences along k.
#[expect(clippy::too_many_arguments, reason = "a comparison, kept in one place")]
fn gradients<'v>(
    here: usize,
    span: core::ops::Range<usize>,
    [near, far]: [usize; 2],
    depth: usize,
    height: usize,
    [wx, wy, wz]: [f32; 3],
    [fx, fy, fz]: [f32; 3],
    row_of: &impl Fn(usize, usize) -> &'v [u16],
    b: &mut Buffers,
) {
    let len = span.len();
    let [gx, gy, gz] = &mut b.g;
    let row = &b.samples[here];
    for ((o, n), p) in gx
        .iter_mut()
        .zip(&row[span.start + 1..=span.end])
        .zip(&row[span.start - 1..])
    {
        *o = (n - p) * fx;
    }
    let (next, previous) = (&b.samples[here + 1][span.clone()], &b.samples[here - 1][span.clone()]);
    for ((o, n), p) in gy.iter_mut().zip(next).zip(previous) {
        *o = (n - p) * fy;
    }
    // Difference of the slices around `k`, doubled where it is one-sided.
    let sides = |k: usize| {
        let (low, high) = (k.saturating_sub(1), (k + 1).min(depth - 1));
        (low, high, if high - low == 2 { 1.0 } else { 2.0 })
    };
    let (n0, n1, ns) = sides(near);
    let (f0, f1, fs) = sides(far);
    let columns = span.start - 1..span.end;
    for (out, row) in b.dz.iter_mut().zip([here - 1, here.min(height - 1)]) {
        let part = |k: usize| -> &'v [u16] {
            let row = row_of(k, row);
            &row[columns.start..columns.end.min(row.len())]
        };
        let near_rows = part(n1).iter().zip(part(n0));
        if wz == 0.0 {
            for (o, (a, c)) in out.iter_mut().zip(near_rows) {
                *o = (f32::from(*a) - f32::from(*c)) * ns;
            }
            continue;
        }
        let far_rows = part(f1).iter().zip(part(f0));
        for ((o, (a, c)), (d, e)) in out.iter_mut().zip(near_rows).zip(far_rows) {
            let w0 = (f32::from(*a) - f32::from(*c)) * ns;
            let w1 = (f32::from(*d) - f32::from(*e)) * fs;
            *o = w0 + (w1 - w0) * wz;
        }
    }
    let [this, next] = &b.dz;
    for ((o, a), c) in b.y[..=len].iter_mut().zip(this).zip(next) {
        *o = a + (c - a) * wy;
    }
    for (o, pair) in gz.iter_mut().zip(b.y[..=len].windows(2)) {
        *o = (pair[0] + (pair[1] - pair[0]) * wx) * fz;
    }
}

/// Phong's equation along a row.
fn shade(lamps: &Lamps<'_>, len: usize, [gx, gy, gz]: &[Row; 3], [red, green, blue]: &mut [Row; 3]) {
    let colours = red[..len].iter_mut().zip(green).zip(blue);
    for (((r, g), bl), ((x, y), z)) in colours.zip(gx.iter().zip(gy).zip(gz)) {
        let normal = [*x, *y, *z];
        let mut diffuse = lamps.ambient;
        let mut specular = [0.0f32; 3];
        for lamp in lamps.list {
            let nl = dot(normal, lamp.direction);
            if nl <= 0.0 {
                continue;
            }
            let base = if lamps.half_vector {
                dot(normal, lamp.half)
            } else {
                let nv = dot(normal, lamps.viewer);
                if nv > 0.0 {
                    2.0 * nv * nl - dot(lamps.viewer, lamp.direction)
                } else {
                    0.0
                }
            };
            let mut power = if base > 0.0 { base } else { 0.0 };
            for _ in 0..lamps.exponent_log2 {
                power *= power;
            }
            for c in 0..3 {
                diffuse[c] += lamp.diffuse[c] * nl;
                specular[c] += lamp.specular[c] * power;
            }
        }
        for ((c, d), s) in [r, g, bl].into_iter().zip(diffuse).zip(specular) {
            let sum = *c * if d < 1.0 { d } else { 1.0 } + s;
            *c = if sum < 1.0 { sum } else { 1.0 };
        }
    }
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The square root: the machine's own where it has one.
#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
#[inline(always)]
fn root(x: f32) -> f32 {
    unsafe extern "C" {
        fn slicecast_firmware_sqrt(x: f32) -> f32;
    }
    // SAFETY: the function below, of this signature.
    unsafe { slicecast_firmware_sqrt(x) }
}

#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
core::arch::global_asm!(
    ".fpu fpv4-sp-d16",
    ".thumb_func",
    ".global slicecast_firmware_sqrt",
    "slicecast_firmware_sqrt:",
    "vsqrt.f32 s0, s0",
    "bx lr"
);

/// The square root, of a library.
#[cfg(not(all(target_arch = "arm", target_abi = "eabihf")))]
fn root(x: f32) -> f32 {
    libm::sqrtf(x)
}
