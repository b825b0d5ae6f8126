//! Writes a raw volume of any size, slice by slice: balls with soft rims in a lattice, grain inside of them, nothing between.
//!
//! `cargo run --release -p slicecast-volume --example large_volume -- 2048x2048x1024 large.raw` writes 8 GiB of 16-bit codes,
//! little endian, and beside them the sidecar that tells their shape.

use std::fs::File;
use std::io::{self, BufWriter, Write};

/// Voxels from one ball to the next.
const LATTICE: i64 = 256;

/// The radius of a ball.
const RADIUS: i64 = 96;

/// The code of a voxel.
fn code([x, y, z]: [i64; 3]) -> u16 {
    let from_middle = |c: i64| c % LATTICE - LATTICE / 2;
    let squares: i64 = [x, y, z].map(|c| from_middle(c).pow(2)).iter().sum();
    // The rim is 16 voxels wide.
    let inside = (RADIUS * RADIUS - squares) / 8;
    if inside <= 0 {
        return 0;
    }
    let grain = ((x * 73) ^ (y * 179) ^ (z * 283)) & 63;
    inside.min(384).wrapping_mul(9).saturating_add(grain).min(4095) as u16
}

fn write(dims: [i64; 3], path: &str) -> io::Result<()> {
    let [nx, ny, nz] = dims;
    let mut out = BufWriter::with_capacity(1 << 20, File::create_new(path)?);
    for z in 0..nz {
        for y in 0..ny {
            let row: Vec<u8> = (0..nx).flat_map(|x| code([x, y, z]).to_le_bytes()).collect();
            out.write_all(&row)?;
        }
    }
    out.flush()?;
    let sidecar = format!("size = [{nx}, {ny}, {nz}]\ntype = \"uint16\"\nendian = \"little\"\n");
    File::create_new(format!("{path}.toml"))?.write_all(sidecar.as_bytes())
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let usage = "expected a shape and a file that is not there yet: 2048x2048x1024 large.raw";
    let [shape, path] = &arguments[..] else {
        eprintln!("error: {usage}");
        std::process::exit(2);
    };
    let sides: Vec<i64> = shape.split('x').filter_map(|side| side.parse().ok()).collect();
    let dims = match sides[..] {
        [x, y, z] if sides.iter().all(|side| (1..=8192).contains(side)) => [x, y, z],
        _ => {
            eprintln!("error: {shape}: {usage}");
            std::process::exit(2);
        }
    };
    if let Err(error) = write(dims, path) {
        eprintln!("error: {path}: {error}");
        std::process::exit(1);
    }
}
