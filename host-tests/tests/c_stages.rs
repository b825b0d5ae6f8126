//! The stages of the C interface give what the directed vectors say, each stage and each precision.

use std::ptr::{null, null_mut};

use slicecast_ffi::*;
use slicecast_host_tests::found::Inputs;
use slicecast_host_tests::second::Numbers;
use slicecast_vectors::directed;
use slicecast_vectors::set::Set;

/// Numbers of a vector as C takes them.
fn numbers<T: TryFrom<i128>, const N: usize>(inputs: &Inputs<'_>, names: [String; N]) -> [T; N] {
    names.map(|name| T::try_from(inputs.get(&name)).unwrap_or_else(|_| panic!("{name} does not fit")))
}

fn endings<const N: usize>(name: &str, endings: [&str; N]) -> [String; N] {
    endings.map(|ending| format!("{name}_{ending}"))
}

fn ijk<T: TryFrom<i128>>(inputs: &Inputs<'_>, name: &str) -> [T; 3] {
    numbers(inputs, endings(name, ["i", "j", "k"]))
}

fn rgb<T: TryFrom<i128>>(inputs: &Inputs<'_>, name: &str) -> [T; 3] {
    numbers(inputs, endings(name, ["red", "green", "blue"]))
}

fn one<T: TryFrom<i128>>(inputs: &Inputs<'_>, name: &str) -> T {
    let [value] = numbers(inputs, [name.to_owned()]);
    value
}

fn wide<T: Into<i64>, const N: usize>(values: [T; N]) -> Vec<i64> {
    values.into_iter().map(Into::into).collect()
}

/// A table's memories, kept from one vector to the next: of 4096 entries two are written.
struct Tables {
    entries: Vec<u32>,
    roots: Vec<u8>,
    colours: Vec<[u8; 3]>,
}

impl Tables {
    fn write(&mut self, at: usize, inputs: &Inputs<'_>, name: &str) {
        self.entries[at] = one(inputs, name);
        self.roots[at] = one(inputs, &format!("{name}_low_root"));
        self.colours[at] = rgb(inputs, &format!("{name}_low"));
    }
}

/// The outputs of a vector by C: `None` where C has no such function.
fn called(set: &Set, index: usize, tables: &mut Tables) -> Option<Vec<i64>> {
    let inputs = &Inputs::of(set, index);
    let precision = match set.precision {
        Some("paper") => SLICECAST_PAPER,
        Some("wide") => SLICECAST_WIDE,
        _ => SLICECAST_COMPACT,
    };
    let get = |name: &str| -> u32 { one(inputs, name) };
    // SAFETY: every pointer is to a value of its type, and every array as long as the header says.
    let (code, outputs) = unsafe {
        match set.stage {
            "location" if get("nearest") == 0 => {
                let mut position = 0;
                let (start, step) = (one(inputs, "start"), one(inputs, "step"));
                let code = slicecast_stage_locate(start, step, get("plane"), &mut position, null_mut());
                let (cell, weight) = (position >> 16, position & 0xffff);
                // Which pixels have a sample is not the function's.
                let rest = set.outputs.row(index)[3..].to_vec();
                (code, [wide([position, cell, weight]), rest].concat())
            }
            "interpolation" => {
                let names: [String; 8] =
                    std::array::from_fn(|at| format!("voxel_{}{}{}", at >> 2, at >> 1 & 1, at & 1));
                let (voxels, weights) = (numbers::<i16, 8>(inputs, names), ijk::<u16>(inputs, "weight"));
                let mut sample = 0;
                let code =
                    slicecast_stage_interpolate(precision, voxels.as_ptr(), weights.as_ptr(), &mut sample, null_mut());
                (code, wide([sample]))
            }
            "classification" => {
                let sample: i32 = one(inputs, "sample");
                let at = (sample >> if precision == SLICECAST_WIDE { 15 } else { 12 }) as usize;
                tables.write((at + 1) % 4096, inputs, "next");
                tables.write(at, inputs, "entry");
                let (mut opacity, mut colour) = (0, [0_u32; 3]);
                let code = slicecast_stage_classify(
                    precision,
                    get("code"),
                    get("lookup"),
                    sample,
                    tables.entries.as_ptr(),
                    tables.roots.as_ptr(),
                    tables.colours.as_ptr().cast(),
                    &mut opacity,
                    colour.as_mut_ptr(),
                    null_mut(),
                );
                (code, [wide([opacity]), wide(colour)].concat())
            }
            "gradient" => {
                let samples = ["next_i", "previous_i", "next_j", "previous_j", "along_k"].map(|name| one(inputs, name));
                let (factors, mut gradient) = (ijk::<u16>(inputs, "factor"), [0; 3]);
                let (samples, factors): (*const i32, _) = (samples.as_ptr(), factors.as_ptr());
                let code = slicecast_stage_gradient(samples, factors, gradient.as_mut_ptr(), null_mut());
                (code, wide(gradient))
            }
            "normalisation" => {
                let (gradient, mut g, mut r) = (ijk::<i32>(inputs, "gradient"), [0; 3], 0);
                let code = slicecast_stage_normalise(gradient.as_ptr(), g.as_mut_ptr(), &mut r, null_mut());
                (code, [wide(g), wide([r])].concat())
            }
            "shading" => {
                let light = |light: u32| SlicecastLight {
                    direction: ijk(inputs, &format!("light{light}_direction")),
                    half: ijk(inputs, &format!("light{light}_half")),
                    diffuse: rgb(inputs, &format!("light{light}_diffuse")),
                    specular: rgb(inputs, &format!("light{light}_specular")),
                };
                let lights: Vec<_> = (0..get("lights")).map(light).collect();
                let lighting = SlicecastLighting {
                    ambient: rgb(inputs, "ambient"),
                    viewer: ijk(inputs, "viewer"),
                    highlight: get("highlight"),
                    exponent_log2: get("exponent_log2"),
                    count: lights.len(),
                    lights: if lights.is_empty() { null() } else { lights.as_ptr() },
                };
                let (g, colour) = (ijk::<i32>(inputs, "g"), rgb::<u32>(inputs, "colour"));
                let mut shaded = [0_u32; 3];
                let code = slicecast_stage_shade(
                    precision,
                    &lighting,
                    g.as_ptr(),
                    get("r"),
                    colour.as_ptr(),
                    shaded.as_mut_ptr(),
                    null_mut(),
                );
                (code, wide(shaded))
            }
            "compositing" | "compositing-back" => {
                let mut pixel: [u32; 4] = numbers(inputs, endings("before", ["red", "green", "blue", "t"]));
                let back = set.stage == "compositing-back";
                let code = slicecast_stage_composite(
                    precision,
                    back.into(),
                    get("plane"),
                    if back { 0 } else { get("floor") },
                    get("opacity"),
                    rgb::<u32>(inputs, "colour").as_ptr(),
                    pixel.as_mut_ptr(),
                    null_mut(),
                );
                (code, wide(pixel))
            }
            "projection" => {
                let mut kept = one(inputs, "kept");
                let code = slicecast_stage_project(get("extreme"), one(inputs, "sample"), &mut kept, null_mut());
                (code, wide([kept]))
            }
            "resolution" => {
                tables.write(7, inputs, "entry");
                let (mut opacity, mut colour, mut pixel) = (0, [0_u32; 3], [0_u32; 4]);
                let sample = 7 << if precision == SLICECAST_WIDE { 15 } else { 12 };
                let (entries, roots) = (tables.entries.as_ptr(), tables.roots.as_ptr());
                let (colours, out) = (tables.colours.as_ptr().cast(), colour.as_mut_ptr());
                let code = slicecast_stage_classify(
                    precision,
                    get("code"),
                    1,
                    sample,
                    entries,
                    roots,
                    colours,
                    &mut opacity,
                    out,
                    null_mut(),
                );
                assert_eq!(code, SLICECAST_OK);
                let (extreme, kept) = (get("extreme"), one(inputs, "kept"));
                let (colour, out) = (colour.as_ptr(), pixel.as_mut_ptr());
                let code = slicecast_stage_resolve(precision, extreme, kept, opacity, colour, out, null_mut());
                (code, wide(pixel))
            }
            "coordinate" => {
                let along = |name| [one::<i64>(inputs, name); 2];
                let warp = SlicecastWarp {
                    origin: along("origin"),
                    right: along("right"),
                    down: along("down"),
                };
                let (mut pixel, mut weight) = ([0; 2], [0; 2]);
                let (at, weights) = (pixel.as_mut_ptr(), weight.as_mut_ptr());
                let code = slicecast_stage_point(&warp, get("x"), get("y"), at, weights, null_mut());
                assert_eq!((pixel[0], weight[0]), (pixel[1], weight[1]));
                (code, vec![i64::from(pixel[0]), i64::from(weight[0])])
            }
            "mixture" => {
                // The channel in the place of each of the four.
                let corners = ["p00", "p01", "p10", "p11"].map(|name| [get(name); 4]);
                let weights: [u16; 2] = numbers(inputs, endings("weight", ["u", "v"]));
                let (mut mixed, mut bytes, black) = ([0_u32; 4], [0_u8; 3], [0_u16; 3]);
                let code = slicecast_stage_warp(
                    precision,
                    corners.as_ptr().cast(),
                    weights.as_ptr(),
                    black.as_ptr(),
                    mixed.as_mut_ptr(),
                    bytes.as_mut_ptr(),
                    null_mut(),
                );
                assert_eq!(mixed, [mixed[0]; 4]);
                (code, wide([mixed[0]]))
            }
            "background" => {
                let (c, t, k) = (get("colour"), get("t"), one::<u16>(inputs, "background"));
                let corners = [[c, c, c, t]; 4];
                let (mut mixed, mut bytes) = ([0_u32; 4], [0_u8; 3]);
                let code = slicecast_stage_warp(
                    precision,
                    corners.as_ptr().cast(),
                    [0_u16; 2].as_ptr(),
                    [k; 3].as_ptr(),
                    mixed.as_mut_ptr(),
                    bytes.as_mut_ptr(),
                    null_mut(),
                );
                assert_eq!(bytes, [bytes[0]; 3]);
                (code, wide([bytes[0]]))
            }
            _ => return None,
        }
    };
    assert_eq!(code, SLICECAST_OK, "{} {index}", set.name);
    Some(outputs)
}

#[test]
fn c_gives_the_directed_vectors() {
    let mut tables = Tables {
        entries: vec![0; 4096],
        roots: vec![0; 4096],
        colours: vec![[0; 3]; 4096],
    };
    let (mut stages, mut count) = (Vec::new(), 0);
    for set in directed::sets() {
        for index in 0..set.len() {
            let Some(found) = called(&set, index, &mut tables) else {
                continue;
            };
            assert_eq!(found, set.outputs.row(index), "{} {index}", set.name);
            count += 1;
            if stages.last() != Some(&set.name) {
                stages.push(set.name.clone());
            }
        }
    }
    // Three for all precisions, ten for each.
    assert_eq!(stages.len(), 3 + 3 * 10, "{stages:?}");
    assert!(count > 30_000, "{count}");
}
