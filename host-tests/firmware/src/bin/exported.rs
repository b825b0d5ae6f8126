//! The built-in head from files that `slicecast export` writes, and nothing else: scene, table, voxels. Prints the sums of
//! the image and of the viewer's picture.
#![no_std]
#![no_main]

use semihosting::println;
use slicecast::Error;
use slicecast_firmware::{machine, stack};
use slicecast_firmware_shared::image::{add_rgb, add_rows};
use slicecast_firmware_shared::sum::Sum;
use static_cell::ConstStaticCell;

#[cfg(target_arch = "arm")]
use cortex_m_rt::entry;
#[cfg(target_arch = "riscv32")]
use riscv_rt::entry;

/// The scene.
mod head {
    include!(concat!(env!("SLICECAST_EXPORTED"), "/head.rs"));
}

/// Its volume.
mod head_voxels {
    include!(concat!(env!("SLICECAST_EXPORTED"), "/head_voxels.rs"));
}

/// What the host has.
mod sums {
    include!(concat!(env!("SLICECAST_EXPORTED"), "/sums.rs"));
}

static MEMORY: ConstStaticCell<head::Memory> = ConstStaticCell::new(head::memory());

/// Sums of the image and of the picture.
fn render(memory: &mut head::Memory) -> Result<[u32; 2], Error> {
    let mut stream = head::stream(memory)?;
    let [width, height, _] = head::PLAN.dims();
    let len = (width * height) as usize;
    while let Some(number) = stream.wanted() {
        let voxels = head_voxels::VOXELS.get(number as usize * len..).unwrap_or(&[]);
        stream.push(voxels.get(..len).unwrap_or(&[]))?;
    }
    let (mut image, mut picture) = (Sum::new(), Sum::new());
    add_rows(&mut image, stream.image());
    let [columns, rows] = head::PICTURE;
    for y in 0..rows {
        for x in 0..columns {
            add_rgb(&mut picture, head::pixel(&stream, x, y));
        }
    }
    Ok([image.get(), picture.get()])
}

#[entry]
fn main() -> ! {
    stack::paint();
    println!("case exported head");
    let mut passed = false;
    match render(MEMORY.take()) {
        Ok([image, picture]) => {
            println!("image {:08x}", image);
            println!("picture {:08x}", picture);
            passed = image == sums::IMAGE && picture == sums::PICTURE;
        }
        Err(error) => println!("error {}", error),
    }
    println!("stack {}", stack::high_water());
    machine::finish(passed)
}
