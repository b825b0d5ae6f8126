//! A lit frame on a display of 240 x 240 pixels, RGB565, in strips of 16 rows: 7680 bytes where a frame buffer takes
//! 115,200. With a path it writes what the display shows as a PNG:
//! `cargo run -p slicecast --features embedded-graphics --example display -- display.png`.

use std::fs::File;
use std::io::BufWriter;

use embedded_graphics::framebuffer::{Framebuffer, buffer_size};
use embedded_graphics::image::GetPixel as _;
use embedded_graphics::pixelcolor::raw::BigEndian;
use embedded_graphics::pixelcolor::{Rgb565, Rgb888};
use embedded_graphics::prelude::*;
use slicecast::classify::{Linear, PointTable, Sqrt16, entry};
use slicecast::composite::{FrontToBack, Unorm16};
use slicecast::display::Picture;
use slicecast::format::{Coefficient, Intensity, Step, Vector};
use slicecast::plan::{Plan, Sampling, Spacing};
use slicecast::plane::Composite;
use slicecast::precision::Compact;
use slicecast::shade::{Highlight, Light, Phong};
use slicecast::slice::RowRange;
use slicecast::stream::{Memory, Needs, Stream};
use slicecast::table::ENTRIES;
use slicecast::view::View;
use slicecast::warp::Warp;

type Lit<'t> = Composite<Compact, PointTable<'t, Sqrt16, Linear>, Phong<Compact>, FrontToBack>;
/// The display's driver would stand here: anything that takes areas of pixels.
type Display =
    Framebuffer<Rgb565, <Rgb565 as PixelColor>::Raw, BigEndian, SIDE, SIDE, { buffer_size::<Rgb565>(SIDE, SIDE) }>;

/// Pixels along a side of the display.
const SIDE: usize = 240;
/// Rows of a strip.
const ROWS: usize = 16;
/// Voxels along a side of the volume.
const VOXELS: u32 = 64;
/// Where the camera stands: radians about z, and above the horizon.
const ANGLES: [f32; 2] = [0.6, 0.45];

/// A gyroid, cut to a ball: 2048 on its surface, more inside.
fn voxel(at: [u32; 3]) -> u16 {
    let [x, y, z] = at.map(|c| c as f32 - (VOXELS - 1) as f32 / 2.0);
    let [a, b, c] = [x, y, z].map(|c| c * 0.27);
    let wall = 0.45 - (a.sin() * b.cos() + b.sin() * c.cos() + c.sin() * a.cos()).abs();
    let ball = (28.0 - (x * x + y * y + z * z).sqrt()) * 0.27;
    (2048.0 + 2800.0 * wall.min(ball)).clamp(0.0, 4095.0) as u16
}

/// Right, down and forward of the camera, in i, j, k.
fn camera(view: &View) -> [[f32; 3]; 3] {
    let [(sa, ca), (se, ce)] = ANGLES.map(f32::sin_cos);
    [[ca, sa, 0.0], [sa * se, -ca * se, -ce], [-sa * ce, ca * ce, -se]].map(|axis| view.orient(axis))
}

/// The warp of a picture with the volume's middle in its middle, `pixel` voxels (cubes) to a picture pixel.
fn warp(plan: &Plan, pixel: f32) -> Warp {
    let [right, down, _] = camera(plan.view());
    let ([si, sj], [oi, oj]) = (plan.view().shear(1).map(Step::to_num::<f32>), plan.origin());
    // Where a point meets the first slice along its ray.
    let meet = |[i, j, k]: [f32; 3]| [i - si * k, j - sj * k];
    let (right, down) = (meet(right).map(|c| c * pixel), meet(down).map(|c| c * pixel));
    let [u, v] = meet(plan.volume().map(|side| (side - 1) as f32 / 2.0));
    let middle = [u - oi as f32, v - oj as f32];
    let half = (SIDE - 1) as f32 / 2.0;
    let origin = [0, 1].map(|axis| middle[axis] - half * (right[axis] + down[axis]));
    let [origin, right, down] = [origin, right, down].map(|vector| vector.map(Step::from_num));
    Warp { origin, right, down }
}

/// A light from a direction of the camera's, (right, up, towards the eye), with its coefficients.
fn light([x, y, z]: [f32; 3], colour: [f32; 3], camera: [[f32; 3]; 3]) -> Light {
    let [right, down, forward] = camera;
    let world = |[x, y, z]: [f32; 3]| {
        let vector = [0, 1, 2].map(|axis| x * right[axis] - y * down[axis] - z * forward[axis]);
        let length = vector.iter().map(|c| c * c).sum::<f32>().sqrt();
        vector.map(|c| Vector::from_num(c / length))
    };
    Light {
        direction: world([x, y, z]),
        // The highlight is a reflection, which does not read it.
        half: [Vector::ZERO; 3],
        diffuse: colour.map(Coefficient::from_num),
        specular: colour.map(|c| Coefficient::from_num(c * 0.5)),
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // From clear to opaque around the surface; further inside the colour goes over from orange to blue.
    let mut entries = [0; ENTRIES];
    for (code, entry_of_code) in entries.iter_mut().enumerate().skip(1800) {
        let (rise, blue) = ((code - 1800).min(510) / 2, (code.saturating_sub(2100)).min(1020) / 4);
        *entry_of_code = entry([255 - blue as u8 / 2, 150, 60 + (blue / 2) as u8], rise as u8);
    }
    let low = [0; ENTRIES];

    let view = View::from_angles(ANGLES[0], ANGLES[1], [1.0; 3])?;
    let sampling = Sampling {
        planes_per_voxel: 2,
        rays_per_voxel: 1,
    };
    let plan = Plan::new(view, [VOXELS; 3], Spacing::CUBIC, sampling)?;
    let camera = camera(plan.view());
    let lights = [
        light([-0.6, 0.8, 1.0], [0.75, 0.72, 0.68], camera),
        light([1.0, -0.2, 0.6], [0.12, 0.18, 0.3], camera),
    ];
    let towards_eye = camera[2].map(|c| Vector::from_num(-c));
    let ambient = [Coefficient::from_num(0.15); 3];
    let phong = Phong::new(Compact, ambient, &lights, towards_eye, Highlight::Reflection, 5)?;
    let pipeline = Lit::new(Compact, PointTable::new(&entries, &low), phong);

    let needs = Needs::of::<Lit>(&plan);
    let memory = Memory {
        slices: &mut vec![0; needs.slices],
        ranges: &mut vec![RowRange::EMPTY; needs.ranges],
        scratch: &mut vec![0; needs.scratch],
        image: &mut vec![Unorm16::default(); needs.image],
    };
    let mut stream = Stream::new(plan, pipeline, memory)?;
    while let Some(number) = stream.wanted() {
        stream.push(&slice(&plan, number))?;
    }

    // The picture is mixed from the base plane while strips of it are sent: there is no other memory.
    let background = [0.02, 0.03, 0.05].map(Intensity::from_num);
    let picture = Picture::new(warp(&plan, 0.25), [SIDE as u32; 2], background, |u, v| {
        stream.pixel(u, v)
    });
    let mut display = Display::new();
    let mut strip = [Rgb565::BLACK; ROWS * SIDE];
    let mut first = 0;
    while first < SIDE as u32 {
        let area = picture.strip(first, &mut strip);
        display.fill_contiguous(&area, strip.iter().copied())?;
        first += area.size.height;
    }

    let bytes: usize = needs.bytes().iter().sum();
    println!("RAM: {bytes} bytes lent, {} of a strip", size_of_val(&strip));
    match std::env::args_os().nth(1) {
        None => println!("no path given, so no PNG written"),
        Some(path) => write(&display, &path)?,
    }
    Ok(())
}

/// A slice of the volume in the view's order.
fn slice(plan: &Plan, number: u32) -> Vec<u16> {
    let k = if plan.view().reversed() {
        VOXELS - 1 - number
    } else {
        number
    };
    let mut voxels = Vec::new();
    for j in 0..VOXELS {
        for i in 0..VOXELS {
            voxels.push(voxel(plan.view().restore([i, j, k])));
        }
    }
    voxels
}

/// What the display shows, as a PNG.
fn write(display: &Display, path: &std::ffi::OsStr) -> Result<(), Box<dyn std::error::Error>> {
    let points = display.bounding_box().points();
    let colours = points.filter_map(|point| display.pixel(point)).map(Rgb888::from);
    let bytes: Vec<u8> = colours
        .flat_map(|colour| [colour.r(), colour.g(), colour.b()])
        .collect();
    let mut encoder = png::Encoder::new(BufWriter::new(File::create(path)?), SIDE as u32, SIDE as u32);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&bytes)?;
    writer.finish()?;
    println!("written: {}", path.display());
    Ok(())
}
