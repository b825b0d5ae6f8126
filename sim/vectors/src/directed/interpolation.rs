//! Samples between eight voxels.

use slicecast::format::Weight;
use slicecast::interpolate::trilinear;
use slicecast::precision::Precision;

use super::{Numbers, sample_unit};
use crate::set::{Field, Set, s, u};

/// The eight voxels around a sample, `voxel_kji`, and its three weights.
pub fn fields() -> Vec<Field> {
    let corner = |at: usize| format!("voxel_{}{}{}", at >> 2, at >> 1 & 1, at & 1);
    let mut fields: Vec<Field> = (0..8).map(|at| s(corner(at), 14, "code")).collect();
    fields.extend(["i", "j", "k"].map(|axis| u(format!("weight_{axis}"), 16, "2^-16")));
    fields
}

/// A sample. Beyond a face, and of derivatives in place of voxels, it has a sign.
pub fn sample<P: Precision>(p: P) -> Field {
    s("sample", 14 + p.formats().sample_bits, sample_unit(p))
}

/// Voxels from 0 to 4095, continued beyond a face, and derivatives in their place; every end of a weight.
pub fn interpolation<P: Precision>(p: P) -> Set {
    let about = "the value between eight voxels; voxel_kji, ghosts and derivatives included";
    let mut set = Set::new(Some(P::NAME), "interpolation", about, fields(), vec![sample(p)]);
    let mut push = |v: [i64; 8], w: [i64; 3]| {
        let [n00, n01, n10, n11, f00, f01, f10, f11] = v.map(|c| c as i16);
        let voxels = [[[n00, n01], [n10, n11]], [[f00, f01], [f10, f11]]];
        let sample = trilinear(p, voxels, w.map(|w| Weight::from_bits(w as u32)));
        set.push(&[&v[..], &w].concat(), &[sample.into()]);
    };
    let weights = [0, 1, 8, 15, 16, 0x7fff, 0x8000, 0x8001, 0xfff0, 0xffff];
    let mut numbers = Numbers(3);
    for [low, high] in [[0, 4095], [-4095, 8190], [-8190, 8190]] {
        // Every corner at either end, with every weight along one axis.
        for pattern in [0x00, 0x0f, 0x33, 0x55, 0xaa, 0xcc, 0xf0, 0xff, 0x96, 0x69] {
            let v = std::array::from_fn(|at| if pattern >> at & 1 == 1 { high } else { low });
            for w in weights {
                push(v, [w, 0, 0]);
                push(v, [0, w, 0]);
                push(v, [0, 0, w]);
                push(v, [w; 3]);
            }
        }
        for _ in 0..200 {
            let v = [(); 8].map(|()| numbers.within(low, high));
            push(v, [(); 3].map(|()| numbers.of(&weights)));
            push(v, [(); 3].map(|()| numbers.within(0, 65535)));
        }
    }
    // Halves of the y step: half a code along k, times an odd weight; along x nothing is lost.
    for (a, b) in [(7, 8), (8, 7)] {
        for wy in [1, 3, 0x7fff, 0xffff] {
            push([a, a, a, a, a, a, b, b], [0, wy, 0x8000]);
            push([-a, -a, -a, -a, -a, -a, -b, -b], [0, wy, 0x8000]);
        }
    }
    // Halves of the x step, of 12 and of 15 bits, above and below zero.
    for wx in [1, 3, 8, 24, 40, 0x8008, 0x8018, 0x8001] {
        push([7, 8, 7, 8, 7, 8, 7, 8], [wx, 0, 0]);
        push([-7, -8, -7, -8, -7, -8, -7, -8], [wx, 0, 0]);
        push([8, 7, 8, 7, 8, 7, 8, 7], [wx, 0, 0]);
    }
    set
}
