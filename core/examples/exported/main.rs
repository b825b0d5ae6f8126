//! A scene that `slicecast export` has written, rendered as a device would: memory sized by the compiler, one slice at a time.
//! `cargo run -p slicecast --example exported` shows a ball under the lights and the table of the built-in head.

use std::sync::Mutex;

use slicecast::Error;

// slicecast export --scene headsq --rays 1 --planes 1 --format rust --name head -o src/
mod head;

// RAM of a frame, as the compiler counts it; the table (20,480 bytes) stays in flash.
const _: () = assert!(size_of::<head::Memory>() == 151_096);

/// Renders a frame: `read` gives slices as the scanner has them, `show` takes the picture's pixels.
fn frame(
    memory: &mut head::Memory,
    read: impl Fn(u32) -> &'static [u16],
    mut show: impl FnMut(u32, u32, [u8; 3]),
) -> Result<(), Error> {
    let mut stream = head::stream(memory)?;
    while let Some(number) = stream.wanted() {
        stream.push(read(number))?;
    }
    let [columns, rows] = head::PICTURE;
    for y in 0..rows {
        for x in 0..columns {
            show(x, y, head::pixel(&stream, x, y));
        }
    }
    Ok(())
}

static MEMORY: Mutex<head::Memory> = Mutex::new(head::memory());

fn main() -> Result<(), Error> {
    let slices: Vec<&'static [u16]> = ball().chunks_exact(slice_len()).collect();
    let mut memory = MEMORY.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    // A character for 3 x 5 pixels.
    frame(
        &mut memory,
        |number| slices[number as usize],
        |x, y, [red, _, _]| {
            if x % 3 == 1 && y % 5 == 2 {
                let shade = usize::from(red) * 9 / 255;
                print!("{}", &" .:-=+*#%@"[shade..=shade]);
            }
            if x + 1 == head::PICTURE[0] && y % 5 == 2 {
                println!();
            }
        },
    )
}

fn slice_len() -> usize {
    let [width, height, _] = head::PLAN.dims();
    (width * height) as usize
}

/// A ball of bone in air, slice after slice, its rim two voxels thick.
fn ball() -> &'static [u16] {
    let dims = head::PLAN.dims().map(i64::from);
    let [width, height, depth] = dims;
    let code = |at: [i64; 3]| {
        // In 1/1000 of the volume's sides, from its middle.
        let off = [0, 1, 2].map(|a| (2000 * at[a] + 1000) / dims[a] - 1000);
        let inside = 850 * 850 - off.iter().map(|c| c * c).sum::<i64>();
        (inside / 60).clamp(24, 1700) as u16
    };
    let voxels = (0..depth).flat_map(|k| (0..height).flat_map(move |j| (0..width).map(move |i| [i, j, k])));
    voxels.map(code).collect::<Vec<u16>>().leak()
}
