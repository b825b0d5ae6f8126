//! Modulation, sums, reflectance maps and splatting on random inputs against f64 of the same inputs.

use std::collections::BTreeMap;

use slicecast::format::{Coefficient, Intensity, Opacity, Step, Vector};
use slicecast::modulate::{Factors, Modulated, Modulation, modulated};
use slicecast::precision::{Compact, Wide};
use slicecast::project::{Projection, Sum};
use slicecast::shade::map::{Filter, Mapped, entries, fill};
use slicecast::shade::{Highlight, Light, Phong};
use slicecast::splat::{Kernel, Layout, Splatting, product, sample, tilted, weight};
use slicecast_host_tests::beside::LINES;
use slicecast_host_tests::random::Random;
use slicecast_host_tests::tolerance::STALE;

const TRIES: usize = 200_000;

/// The largest of what is found in many tries.
fn worst(seed: u64, mut of: impl FnMut(&mut Random) -> f64) -> f64 {
    let mut random = Random::new(seed);
    (0..TRIES).fold(0.0, |most: f64, _| most.max(of(&mut random)))
}

/// From -1 to 1.
fn unit(random: &mut Random) -> f64 {
    f64::from(random.below(1 << 30)) / f64::from(1 << 29) - 1.0
}

/// A gradient of any length.
fn gradient(random: &mut Random) -> [i32; 3] {
    let scale = 0.5f64.powf(f64::from(random.below(1400)) / 100.0) * 8190.0 * 4096.0;
    [(); 3].map(|()| (unit(random) * scale) as i32)
}

fn modulation(found: &mut BTreeMap<&'static str, f64>) {
    // 65 nodes, 512 units from one to the next.
    let ramp = std::array::from_fn(|node| Intensity::from_bits(512 * node as u16));
    let opacity = Some(Factors::new(&ramp).expect("factors of at most 1"));
    let modulation = Modulation {
        opacity,
        ..Modulation::default()
    };
    let shader = Modulated::new(Compact, None, modulation);
    let factor = worst(1, |random| {
        let gradient = gradient(random);
        let q: f64 = gradient.iter().map(|g| (f64::from(*g) / 4096.0).powi(2)).sum();
        let octave = q.log2().floor();
        let within = q / octave.exp2() - 1.0;
        let node = (2.0 * (octave + 4.0) + 2.0 * within).max(0.0);
        let made = shader.opacity(gradient, Opacity::from_bits(1 << 31)).to_bits();
        (f64::from(made) / 65536.0 - 512.0 * node).abs()
    });
    found.insert("modulation: factor, 1.15", factor);
    let product = worst(2, |random| {
        let (opacity, factor) = (random.below(1 << 31), random.below((1 << 15) + 1));
        let exact = u64::from(opacity) * u64::from(factor);
        let made = u64::from(modulated(opacity as i32, factor as i32) as u32);
        (made as f64 - exact as f64 / 32768.0).abs()
    });
    found.insert("modulation: opacity, 1.31", product);
}

fn sums(found: &mut BTreeMap<&'static str, f64>) {
    let mut both = [0.0f64; 2];
    let mut random = Random::new(3);
    for _ in 0..TRIES / 50 {
        let (mut words, mut sum, mut length) = ([0; 3], 0u64, 0u64);
        for _ in 0..1 + random.below(100) {
            let (sample, share) = (random.below(4095 << 12), random.below((1 << 16) + 1));
            words = Sum::add(words, sample as i32, share);
            sum += u64::from(sample) * u64::from(share);
            length += u64::from(share);
        }
        if length > 0 {
            let shown = Sum::Average.shown(Compact, words).expect("a sample");
            both[0] = both[0].max((f64::from(shown) - sum as f64 / length as f64).abs());
            let step = (1 << 25) + random.below(1 << 24);
            let exact = sum as f64 * f64::from(step) / 48f64.exp2();
            if exact < 4095.0 * 4096.0 {
                let shown = Sum::Additive { step, shift: 0 }
                    .shown(Compact, words)
                    .expect("a sample");
                both[1] = both[1].max((f64::from(shown) - exact).abs());
            }
        }
    }
    found.insert("average, 12.12", both[0]);
    found.insert("additive, 12.12", both[1]);
}

fn maps(found: &mut BTreeMap<&'static str, f64>) {
    const SIDE: u32 = 32;
    let one = |c: f64| Vector::from_bits((c * 1073741824.0).round() as i32);
    let share = |k: f64| Coefficient::from_bits((k * 2147483648.0).round() as u32);
    let light = Light {
        direction: [one(0.36), one(-0.48), one(-0.8)],
        half: [one(0.0), one(0.0), one(-1.0)],
        diffuse: [share(0.7); 3],
        specular: [share(0.0); 3],
    };
    let viewer = [one(0.0), one(0.0), one(-1.0)];
    let phong = Phong::new(Wide, [share(0.1); 3], &[light], viewer, Highlight::HalfVector, 4).expect("a light");
    let mut map = vec![0; entries(&phong, SIDE)];
    fill(&phong, SIDE, &mut map).expect("memory of its length");
    let diffuse: Vec<f64> = map.iter().map(|entry| f64::from(entry & 0xffff)).collect();
    let mapped = Mapped::new(&phong, SIDE, Filter::Bilinear, map).expect("a map of its size");
    // White of the precision, 31 bits.
    let white = [1u32 << 31; 3];
    let most = worst(4, |random| {
        let g = [(); 3].map(|()| (unit(random) * 32767.0) as i32);
        let largest = g.iter().map(|c| c.abs()).max().unwrap_or(0);
        // Of 15 bits already.
        if largest < 16384 {
            return 0.0;
        }
        let axis = g.iter().position(|c| c.abs() == largest).unwrap_or(0);
        let face = 2 * axis + usize::from(g[axis] < 0);
        let beside: Vec<f64> = (0..3)
            .filter(|c| *c != axis)
            .map(|c| (f64::from(g[c]) / f64::from(largest) + 1.0) / 2.0 * f64::from(SIDE - 1))
            .collect();
        let node = beside
            .iter()
            .map(|p| p.floor().min(f64::from(SIDE - 2)))
            .collect::<Vec<_>>();
        let at = |a: f64, b: f64| diffuse[1 + (face * SIDE as usize + b as usize) * SIDE as usize + a as usize];
        let (wa, wb) = (beside[0] - node[0], beside[1] - node[1]);
        let row = |b: f64| at(node[0], b) * (1.0 - wa) + at(node[0] + 1.0, b) * wa;
        let exact = row(node[1]) * (1.0 - wb) + row(node[1] + 1.0) * wb;
        let [made, ..] = mapped.shade(g, white);
        (f64::from(made) / 65536.0 - exact).abs()
    });
    found.insert("reflectance map, bilinear, 32 nodes, 1.15", most);
}

fn step(c: f64) -> Step {
    Step::from_bits((c * 4294967296.0).round() as i64)
}

fn spline(t: f64) -> f64 {
    match t.abs() {
        t if t < 0.5 => 0.75 - t * t,
        t if t < 1.5 => (1.5 - t).powi(2) / 2.0,
        _ => 0.0,
    }
}

fn integral(t: f64) -> f64 {
    let half = match t.abs() {
        t if t < 0.5 => 0.75 * t - t.powi(3) / 3.0,
        t if t < 1.5 => 0.5 - (1.5 - t).powi(3) / 6.0,
        _ => 0.5,
    };
    half.copysign(t)
}

fn splats(found: &mut BTreeMap<&'static str, f64>) {
    let steps = [[0.8, 0.6, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.0, 1.0]].map(|s| s.map(step));
    let splatting = Splatting::new([9; 3], [step(4.0); 2], steps, [16; 2], Layout::FINE).expect("a lattice");
    let mut memory = vec![0; Kernel::len(&splatting)];
    Kernel::fill(&splatting, &mut memory).expect("memory of its length");
    let kernel = Kernel::of(&splatting, &memory).expect("memory of its length");
    let [wx, wy, wz] = splatting.widths().map(|w| f64::from(w) / 65536.0);
    let rho = 1.5 * wz + 0.5;
    let weighed = worst(5, |random| {
        let [x, y] = [(); 2].map(|()| random.below(3 << 12));
        let u = random.below(256);
        let slabs = kernel.slabs(u);
        let j = random.below(slabs.len() as u32);
        let d = f64::from(j + 1) - f64::from(u) / 256.0 - rho;
        let slab = wz * (integral((d + 0.5) / wz) - integral((d - 0.5) / wz));
        let exact = slab * spline(f64::from(x) / 8192.0 / wx) * spline(f64::from(y) / 8192.0 / wy);
        let made = product(slabs[j as usize], kernel.weight(1, y), kernel.weight(0, x));
        (f64::from(made) - exact * 262144.0).abs()
    });
    found.insert("splatting: weight, 1.18", weighed);
    let quotient = worst(6, |random| {
        let weights = 1 + u64::from(random.below(1 << 22));
        let values = random.next_bits() % (4095 * weights + 1);
        let made = sample((weights << 38) | values, 1, 15);
        (f64::from(made) - values as f64 * 32768.0 / weights as f64).abs()
    });
    found.insert("splatting: sample, 12.15", quotient);
    let first = [step(-40.0), step(-30.0), step(90.0)];
    let image = (2000 << 16, [1024, 900]);
    let layout = Layout::new(13, 8, 8).expect("64 bits");
    let splatting = Splatting::from_eye([80; 3], first, steps, image, layout).expect("a lattice");
    let eye = splatting.eye().expect("an eye");
    let place = worst(7, |random| {
        let z = ((100.0 + 60.0 * unit(random)) * 4294967296.0) as i64;
        let [x, y] = [(); 2].map(|()| (unit(random) * 0.25 * z as f64) as i64);
        let Some(made) = eye.project([x, y, z], 13) else {
            return 0.0;
        };
        let of = |made: u32, c: i64, side: f64, margin: u32| {
            let exact = 2000.0 * (c as f64 / z as f64) + (side - 1.0) / 2.0 + f64::from(margin);
            (f64::from(made) - 8192.0 * exact).abs()
        };
        let [mx, my] = eye.margin();
        of(made[0], x, 1024.0, mx).max(of(made[1], y, 900.0, my))
    });
    found.insert("splatting in perspective: x and y, 13 fraction bits", place);
    let looked = worst(9, |random| {
        let t = (unit(random) * 1.5).abs();
        (f64::from(weight((t * 1048576.0).round() as u64)) - 65536.0 * spline(t)).abs()
    });
    found.insert("splatting in perspective: weight along an axis, 1.16", looked);
    let along = worst(8, |random| {
        let g = [(); 3].map(|()| (unit(random) * f64::from(1 << 28)) as i32);
        let slopes = [(); 2].map(|()| (unit(random) * 3.4 * f64::from(1 << 27)) as i32);
        let along = (unit(random) * f64::from(1 << 27)) as i32;
        let across = i128::from(g[0]) * i128::from(slopes[0]) + i128::from(g[1]) * i128::from(slopes[1]);
        let exact = i128::from(g[2]) * i128::from(along) - across;
        let made = i128::from(tilted(g, along, slopes)) << 27;
        ((made - exact) as f64 / 27f64.exp2()).abs()
    });
    found.insert("splatting in perspective: gradient along z, 12.15", along);
}

#[test]
fn every_quantity_keeps_to_its_line_and_no_line_is_stale() {
    let mut found = BTreeMap::new();
    modulation(&mut found);
    sums(&mut found);
    maps(&mut found);
    splats(&mut found);
    assert_eq!(found.len(), LINES.len());
    let mut faults = Vec::new();
    for line in LINES {
        let measured = found.get(line.quantity).copied().unwrap_or(f64::NAN);
        println!("{:56} {measured:9.4} of {:9.4} ulp", line.quantity, line.ulp);
        assert!(!line.reason.is_empty());
        // A millionth for the rounding of f64.
        if !(STALE * line.ulp..=line.ulp + 1e-6).contains(&measured) {
            faults.push((line.quantity, measured, line.ulp));
        }
    }
    assert_eq!(faults, []);
}
