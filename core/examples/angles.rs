//! A volume seen from angles, once round it, in one memory that is large enough for every view:
//! `cargo run -p slicecast --example angles`.
//!
//! `View::from_angles` turns angles into a view on the device; the base plane, and with it the memory, grows with the slant.

use slicecast::classify::{Linear, PointTable, Sqrt16, entry};
use slicecast::composite::{FrontToBack, Unorm16};
use slicecast::plan::{Plan, Sampling, Spacing};
use slicecast::plane::Composite;
use slicecast::precision::Compact;
use slicecast::shade::Unlit;
use slicecast::slice::RowRange;
use slicecast::stream::{Memory, Needs, Stream};
use slicecast::table::ENTRIES;
use slicecast::view::View;

type Unlit16<'t> = Composite<Compact, PointTable<'t, Sqrt16, Linear>, Unlit, FrontToBack>;

/// Voxels along x, y, z.
const DIMS: [u32; 3] = [32, 32, 16];
/// Their lengths along x, y, z, millimetres.
const SPACING: [f32; 3] = [1.0, 1.0, 2.0];

/// A box that takes up a corner of the volume.
fn voxel([x, y, z]: [u32; 3]) -> u16 {
    if x < 16 && y < 12 && z < 8 { 3000 } else { 0 }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut entries = [0; ENTRIES];
    for entry_of_code in entries.iter_mut().skip(1000) {
        *entry_of_code = entry([255, 200, 120], 0x80);
    }
    let low = [0; ENTRIES];
    let pipeline = Unlit16::new(Compact, PointTable::new(&entries, &low), Unlit);

    let mut plans = Vec::new();
    for turn in 0..8 {
        let azimuth = turn as f32 * core::f32::consts::FRAC_PI_4;
        let view = View::from_angles(azimuth, 0.4, SPACING)?;
        plans.push(Plan::new(view, DIMS, Spacing::CUBIC, Sampling::default())?);
    }
    // The largest of each part over all views: what a device reserves.
    let largest = |part: fn(&Needs) -> usize| {
        let needs = plans.iter().map(Needs::of::<Unlit16>);
        needs.map(|needs| part(&needs)).max().unwrap_or(0)
    };
    let mut slices = vec![0; largest(|needs| needs.slices)];
    let mut ranges = vec![RowRange::EMPTY; largest(|needs| needs.ranges)];
    let mut scratch = vec![0; largest(|needs| needs.scratch)];
    let mut image = vec![Unorm16::default(); largest(|needs| needs.image)];

    println!("azimuth  slices across  far end first  base plane  image bytes  opaque rays");
    for (turn, plan) in plans.into_iter().enumerate() {
        let memory = Memory {
            slices: &mut slices,
            ranges: &mut ranges,
            scratch: &mut scratch,
            image: &mut image,
        };
        let mut stream = Stream::new(plan, &pipeline, memory)?;
        let [columns, rows, depth] = plan.dims();
        while let Some(number) = stream.wanted() {
            // `number` counts away from the eye. The place of a voxel (i, j, k) of the slice in x, y, z:
            let k = if plan.view().reversed() {
                depth - 1 - number
            } else {
                number
            };
            let mut slice = Vec::new();
            for j in 0..rows {
                for i in 0..columns {
                    slice.push(voxel(plan.view().restore([i, j, k])));
                }
            }
            stream.push(&slice)?;
        }
        let [width, height] = plan.base();
        let opaque = (0..height).flat_map(|v| (0..width).map(move |u| (u, v)));
        let opaque = opaque.filter(|&(u, v)| stream.pixel(u.into(), v.into()).transparency.0 < 6554);
        println!(
            "{:>4} deg  {:>13}  {:>14}  {:>5} x {:<3} {:>11}  {:>11}",
            45 * turn,
            format!("{:?}", plan.view().major()),
            plan.view().reversed(),
            width,
            height,
            Needs::of::<Unlit16>(&plan).bytes()[3],
            opaque.count(),
        );
    }
    Ok(())
}
