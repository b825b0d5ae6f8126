//! A volume that comes slice by slice, as from a sensor, a flash or a DMA, and its picture in letters:
//! `cargo run -p slicecast --example stream`.

use slicecast::classify::{Linear, PointTable, Sqrt16, entry};
use slicecast::composite::{FrontToBack, Unorm16, to_byte};
use slicecast::format::Direction;
use slicecast::plan::{Plan, Sampling, Spacing};
use slicecast::plane::Composite;
use slicecast::precision::Compact;
use slicecast::shade::Unlit;
use slicecast::slice::RowRange;
use slicecast::stream::{Memory, Needs, Stream};
use slicecast::table::ENTRIES;
use slicecast::view::View;

/// Only the combination that is named is compiled: the default precision, a table of points, no lights.
type Unlit16<'t> = Composite<Compact, PointTable<'t, Sqrt16, Linear>, Unlit, FrontToBack>;

/// Voxels along each side.
const SIDE: usize = 32;

/// A slice of a hollow ball: codes of 12 bits, largest on the sphere of radius 12.
fn slice(z: usize) -> Vec<u16> {
    let from_middle = |at: usize| (2 * at as i32 - SIDE as i32 + 1).pow(2) / 4;
    let mut voxels = Vec::with_capacity(SIDE * SIDE);
    for y in 0..SIDE {
        for x in 0..SIDE {
            let square = from_middle(x) + from_middle(y) + from_middle(z);
            voxels.push((4095 - 32 * (square - 144).abs()).max(0) as u16);
        }
    }
    voxels
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // White from code 2000 on; the entry holds the high byte of the root of the opacity: (0x40 / 0x100)^2 is 1/16 a step.
    let mut entries = [0; ENTRIES];
    for entry_of_code in entries.iter_mut().skip(2000) {
        *entry_of_code = entry([255; 3], 0x40);
    }
    let low = [0; ENTRIES];
    let pipeline = Unlit16::new(Compact, PointTable::new(&entries, &low), Unlit);

    // A direction a little off the z axis, from the eye into the scene, in any scale.
    let direction = [1i64, 2, 8].map(|component| Direction::from_bits(component << 55));
    let plan = Plan::new(
        View::new(direction)?,
        [SIDE as u32; 3],
        Spacing::CUBIC,
        Sampling::default(),
    )?;

    // A device sizes its arrays by these numbers.
    let needs = Needs::of::<Unlit16>(&plan);
    let [slices, ranges, scratch, image] = needs.bytes();
    println!("RAM in bytes: slices {slices}, ranges {ranges}, scratch {scratch}, image {image}");
    let memory = Memory {
        slices: &mut vec![0; needs.slices],
        ranges: &mut vec![RowRange::EMPTY; needs.ranges],
        scratch: &mut vec![0; needs.scratch],
        image: &mut vec![Unorm16::default(); needs.image],
    };

    let mut stream = Stream::new(plan, pipeline, memory)?;
    while let Some(number) = stream.wanted() {
        stream.push(&slice(number as usize))?;
    }

    // The base plane in letters, every second row, as letters are twice as high as wide.
    let [width, height] = plan.base();
    for v in (0..height).step_by(2) {
        let letter = |u: u32| {
            let grey = to_byte(stream.pixel(u.into(), v.into()).colour[0]);
            char::from(b" .:-=+*#%@"[usize::from(grey) * 10 / 256])
        };
        println!("{}", (0..width).map(letter).collect::<String>().trim_end());
    }
    Ok(())
}
