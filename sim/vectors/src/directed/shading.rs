//! Lights: vectors and coefficients as they are kept, cosines, reflection, powers, and the colour.

use slicecast::composite::Recurrence as _;
use slicecast::format::{Coefficient, Cosine, Vector};
use slicecast::normalise::{Normal, normalise};
use slicecast::precision::{Precision, Shading};
use slicecast::shade::{self, Highlight, Light, Phong, dot, keep, keep_vector, reflected};

use super::normalisation::{normal, normals};
use super::{Numbers, colour};
use crate::set::{Field, Set, ijk, rgb, s, u};

/// A vector as a precision keeps it.
fn kept_field<P: Precision>(p: P, name: &str) -> [Field; 3] {
    ijk(&if p.formats().shading.vector_bits() == 15 {
        s(name, 17, "2^-15")
    } else {
        s(name, 32, "2^-30")
    })
}

/// The largest whole number whose square is not above this one.
fn root(square: i64) -> i64 {
    let mut root = (square as f64).sqrt() as i64;
    while root * root > square {
        root -= 1;
    }
    while (root + 1) * (root + 1) <= square {
        root += 1;
    }
    root
}

const ONE: i64 = 1 << 30;

/// A unit vector with this first and second component, if there is one.
fn unit(x: i64, y: i64, sign: i64) -> Option<[i64; 3]> {
    let rest = (1_i64 << 60).checked_sub(x * x)?.checked_sub(y * y)?;
    (rest >= 0).then(|| [x, y, sign * root(rest)])
}

/// Unit vectors, s1.30: the axes, the diagonals, ties of the lattice rule, and some in between.
fn vectors() -> Vec<[i64; 3]> {
    let mut all = Vec::new();
    for sign in [ONE, -ONE] {
        all.extend([[sign, 0, 0], [0, sign, 0], [0, 0, sign]]);
    }
    // Half a unit of 15 bits beside an axis, where plain rounding and the lattice rule part.
    for half in [1 << 14, (1 << 14) - 1, -(1 << 14), 3 << 14, -(3 << 14)] {
        all.extend(unit(half, 0, 1));
        all.extend(unit(0, half, -1));
        all.extend(unit(half, half, 1));
    }
    // Two components alike: candidates that exchange them are as good.
    for z in (0..ONE).step_by(49_382_715) {
        let x = root(((1_i64 << 60) - z * z) / 2);
        all.extend([[x, x, z], [x, z, x], [-x, -x, -z]]);
        // As good by their length, and one of them nearer.
        all.extend([[x + 3000, x - 3000, z], [x - 5000, z, x + 5000]]);
    }
    let mut numbers = Numbers(7);
    while all.len() < 280 {
        let sign = numbers.of(&[-1, 1]);
        let (x, y) = (numbers.within(-ONE, ONE), numbers.within(-ONE, ONE));
        all.extend(if (x / 2).pow(2) + (y / 2).pow(2) < 1 << 58 {
            unit(x, y, sign)
        } else {
            None
        });
    }
    all
}

fn kept<P: Precision>(p: P, vector: [i64; 3]) -> [i64; 3] {
    keep_vector(p, vector.map(|c| Vector::from_bits(c as i32))).map(i64::from)
}

/// Vectors as a precision keeps them.
pub fn vector<P: Precision>(p: P) -> Set {
    let inputs = ijk(&s("vector", 32, "2^-30")).to_vec();
    let about = "a light, half or viewer vector with the bits that are kept";
    let mut set = Set::new(Some(P::NAME), "vector", about, inputs, kept_field(p, "kept").to_vec());
    for vector in vectors() {
        set.push(&vector, &kept(p, vector));
    }
    set
}

/// Coefficients as a precision keeps them.
pub fn coefficient<P: Precision>(p: P) -> Set {
    let bits = p.formats().shading.coefficient_bits();
    let outputs = vec![u("kept", bits + 1, if bits == 15 { "2^-15" } else { "2^-31" })];
    let about = "a coefficient, material times light, with the bits that are kept";
    let mut set = Set::new(
        Some(P::NAME),
        "coefficient",
        about,
        vec![u("coefficient", 32, "2^-31")],
        outputs,
    );
    let halves = [0_i64, 1, 2, 3, 16383, 32767].map(|k| (k << 16) + (1 << 15));
    let mut numbers = Numbers(8);
    let some = [(); 30].map(|()| numbers.within(0, 1 << 31));
    for k in [0, 1, 1 << 31, (1 << 31) - 1]
        .into_iter()
        .chain(halves)
        .chain(halves.map(|k| k - 1))
        .chain(some)
    {
        let coefficient = Coefficient::from_bits(k as u32);
        set.push(&[k], &[keep(p, coefficient).into()]);
    }
    set
}

/// Cosines of normals and vectors.
pub fn cosine<P: Precision>(p: P) -> Set {
    let mut inputs = normal();
    inputs.extend(kept_field(p, "vector"));
    let about = "max(0, N . L) of a normal and a kept vector";
    let mut set = Set::new(Some(P::NAME), "cosine", about, inputs, vec![u("cosine", 32, "2^-31")]);
    let mut push = |[x, y, z, r]: [i64; 4], vector: [i64; 3]| {
        let normal = Normal {
            g: [x, y, z].map(|c| c as i32),
            r: r as u32,
        };
        let cosine = dot(p, normal, vector.map(|c| c as i32));
        set.push(&[&[x, y, z, r], &vector[..]].concat(), &[cosine.to_bits().into()]);
    };
    let (vectors, mut numbers) = (vectors(), Numbers(9));
    for normal in normals() {
        for round in 0..4 {
            let vector = if round < 2 {
                round
            } else {
                numbers.within(6, vectors.len() as i64 - 1)
            };
            let mut vector = kept(p, vectors[vector as usize]);
            // Towards the light rather than away from it, where most would be 0.
            let along: i64 = vector.iter().zip(normal).map(|(v, g)| v * g).sum();
            if along > 0 && round != 1 {
                vector = vector.map(|c| -c);
            }
            push(normal, vector);
        }
    }
    // Straight into the light: a kept vector may be longer than 1, and so may be the product.
    for vector in vectors {
        let towards = normalise(vector.map(|c| -c as i32));
        let [x, y, z] = towards.g.map(i64::from);
        push([x, y, z, towards.r.into()], kept(p, vector));
    }
    set
}

/// Cosines at their ends, and powers of two beside them.
const COSINES: [i64; 12] = [
    0,
    1,
    2,
    32767,
    32768,
    65536,
    1 << 29,
    1 << 30,
    (1 << 31) - 65536,
    (1 << 31) - 2,
    (1 << 31) - 1,
    1 << 31,
];

/// A cosine with the bits that a precision has of it.
fn had<P: Precision>(p: P, cosine: i64) -> i64 {
    if p.formats().shading == Shading::Truncated16 {
        cosine >> 15 << 15
    } else {
        cosine
    }
}

/// Reflections.
pub fn reflection<P: Precision>(p: P) -> Set {
    let mut inputs = vec![u("cosine_nv", 32, "2^-31"), u("cosine_nl", 32, "2^-31")];
    inputs.extend(kept_field(p, "viewer"));
    inputs.extend(kept_field(p, "light"));
    let about = "R . L = 2 (N.V)(N.L) - V.L, held to 0 and 1; 0 where a cosine is 0";
    let mut set = Set::new(
        Some(P::NAME),
        "reflection",
        about,
        inputs,
        vec![u("cosine", 32, "2^-31")],
    );
    let mut push = |nv: i64, nl: i64, viewer: [i64; 3], light: [i64; 3]| {
        let [nv, nl] = [had(p, nv), had(p, nl)];
        // Three unit vectors never reach 2, and the contract does not say what 2 would be.
        let along: i64 = viewer.iter().zip(light).map(|(v, l)| v * l).sum();
        let bits = p.formats().shading.vector_bits();
        let along = if bits == 15 { 2 * along } else { along >> 29 };
        if ((i128::from(nv) * i128::from(nl)) >> 30) - i128::from(along) >= (1 << 32) - 8 {
            return;
        }
        let [a, b] = [nv, nl].map(|c| Cosine::from_bits(c as u32));
        let reflection = reflected(p, a, b, viewer.map(|c| c as i32), light.map(|c| c as i32));
        let inputs = [&[nv, nl][..], &viewer, &light].concat();
        set.push(&inputs, &[reflection.to_bits().into()]);
    };
    let (vectors, mut numbers) = (vectors(), Numbers(10));
    let pick = |at: i64| kept(p, vectors[at as usize]);
    for nv in COSINES {
        for nl in COSINES {
            push(nv, nl, pick(0), pick(0));
            push(nv, nl, pick(0), pick(3));
            push(nv, nl, pick(1), pick(2));
        }
    }
    // One unit short of the axis: `Paper`'s sum exceeds 1.
    let short = if p.formats().shading.vector_bits() == 15 {
        32767
    } else {
        ONE - 1
    };
    for nv in [1 << 31, (1 << 31) - 1, (1 << 31) - (1 << 15)] {
        push(nv, 1 << 31, [0, 0, short], [0, 0, short]);
    }
    for _ in 0..400 {
        let [viewer, light] = [(); 2].map(|()| pick(numbers.within(0, vectors.len() as i64 - 1)));
        push(numbers.within(0, 1 << 31), numbers.within(0, 1 << 31), viewer, light);
        push(
            numbers.within(3 << 29, 1 << 31),
            numbers.within(3 << 29, 1 << 31),
            viewer,
            light,
        );
    }
    set
}

/// Every exponent of the ends, and of cosines near 1.
pub fn power<P: Precision>(p: P) -> Set {
    let inputs = vec![u("cosine", 32, "2^-31"), u("exponent_log2", 4, "squarings")];
    let about = "a cosine squared again and again";
    let mut set = Set::new(Some(P::NAME), "power", about, inputs, vec![u("power", 32, "2^-31")]);
    let mut numbers = Numbers(11);
    let some = [(); 30].map(|()| numbers.within(0, 1 << 31));
    let near = [(); 30].map(|()| numbers.within((1 << 31) - (1 << 26), 1 << 31));
    // x * x = 2^30 + m 2^31 exactly: a half of the rounding.
    let halves = [1 << 15, 3 << 15, 5 << 15, 32767 << 15];
    for x in COSINES.into_iter().chain(halves).chain(some).chain(near) {
        let x = had(p, x);
        for n in 0..=8 {
            let power = shade::power(p, Cosine::from_bits(x as u32), n as u32);
            set.push(&[x, n], &[power.to_bits().into()]);
        }
    }
    set
}

/// Most lights of a scene.
const LIGHTS: usize = 8;

/// A light: direction, half vector, diffuse and specular coefficients.
type Lamp = [[i64; 3]; 4];

/// What a scene hands over.
struct Scene {
    ambient: [i64; 3],
    viewer: [i64; 3],
    half_vector: bool,
    exponent_log2: i64,
    lamps: Vec<Lamp>,
}

/// The constants of a scene as fields: what [`shading`] reads beside normal and colour.
pub fn scene_fields() -> Vec<Field> {
    let mut fields = rgb(&u("ambient", 32, "2^-31")).to_vec();
    fields.extend(ijk(&s("viewer", 32, "2^-30")));
    fields.push(u("highlight", 1, "0 reflection, 1 half vector"));
    fields.push(u("exponent_log2", 4, "squarings"));
    fields.push(u("lights", 4, "lights; the rest is 0"));
    for light in 0..LIGHTS {
        fields.extend(ijk(&s(format!("light{light}_direction"), 32, "2^-30")));
        fields.extend(ijk(&s(format!("light{light}_half"), 32, "2^-30")));
        fields.extend(rgb(&u(format!("light{light}_diffuse"), 32, "2^-31")));
        fields.extend(rgb(&u(format!("light{light}_specular"), 32, "2^-31")));
    }
    fields
}

/// The numbers of [`scene_fields`].
pub fn scene_values(
    ambient: [i64; 3],
    viewer: [i64; 3],
    [half_vector, exponent_log2]: [i64; 2],
    lamps: &[Lamp],
) -> Vec<i64> {
    let mut values = [&ambient[..], &viewer, &[half_vector, exponent_log2, lamps.len() as i64]].concat();
    values.extend(lamps.iter().flatten().flatten());
    values.resize(scene_fields().len(), 0);
    values
}

impl Scene {
    fn phong<P: Precision>(&self, p: P) -> Phong<P> {
        let vector = |v: [i64; 3]| v.map(|c| Vector::from_bits(c as i32));
        let coefficient = |k: [i64; 3]| k.map(|c| Coefficient::from_bits(c as u32));
        let light = |[direction, half, diffuse, specular]: &Lamp| Light {
            direction: vector(*direction),
            half: vector(*half),
            diffuse: coefficient(*diffuse),
            specular: coefficient(*specular),
        };
        let lights: Vec<Light> = self.lamps.iter().map(light).collect();
        let highlight = if self.half_vector {
            Highlight::HalfVector
        } else {
            Highlight::Reflection
        };
        let (ambient, viewer) = (coefficient(self.ambient), vector(self.viewer));
        Phong::new(p, ambient, &lights, viewer, highlight, self.exponent_log2 as u32)
            .expect("lights within their ranges")
    }

    fn values(&self) -> Vec<i64> {
        let form = [self.half_vector.into(), self.exponent_log2];
        scene_values(self.ambient, self.viewer, form, &self.lamps)
    }
}

/// Samples without a gradient, lights that add up to more than 1, dull and sharp highlights.
pub fn shading<P: Precision>(p: P) -> Set {
    let mut inputs = normal();
    inputs.extend(rgb(&colour(p, "colour")));
    inputs.extend(scene_fields());
    let about = "the colour of a sample under lights; vectors and coefficients as the caller gives them";
    let mut set = Set::new(
        Some(P::NAME),
        "shading",
        about,
        inputs,
        rgb(&colour(p, "shaded")).to_vec(),
    );
    let full = 1_i64 << p.pixel().colour_bits();
    let mut push = |scene: &Scene, gradient: [i64; 3], colour: [i64; 3]| {
        let normal = normalise(gradient.map(|c| c as i32));
        let shaded = scene.phong(p).shade(normal, colour.map(|c| c as u32));
        let [x, y, z] = normal.g.map(i64::from);
        let inputs = [&[x, y, z, normal.r.into()], &colour[..], &scene.values()].concat();
        set.push(&inputs, &shaded.map(i64::from));
    };
    let (one, zero) = (1_i64 << 31, 0);
    let to_eye = [0, 0, -ONE];
    let colours = [[0; 3], [full; 3], [1, full / 2, full - 1]];
    for half_vector in [false, true] {
        for exponent_log2 in [0, 5, 8] {
            let scene = |viewer, lamps: Vec<Lamp>, ambient| Scene {
                ambient: [ambient; 3],
                viewer,
                half_vector,
                exponent_log2,
                lamps,
            };
            let lamp = |direction, diffuse, specular| [direction, direction, [diffuse; 3], [specular; 3]];
            for colour in colours {
                // No gradient, with V.L = -1 and 1; no light; ambient light of 1.
                push(
                    &scene([0, 0, ONE], vec![lamp(to_eye, one, one)], one / 8),
                    [0; 3],
                    colour,
                );
                push(&scene(to_eye, vec![lamp(to_eye, one, one)], one / 8), [0; 3], colour);
                push(&scene(to_eye, Vec::new(), one), [0, 0, 9], colour);
                // Eight lights of 1 into the eye, each sum by itself and both.
                for (diffuse, specular) in [(one, zero), (zero, one), (one, one)] {
                    let lamps = vec![lamp(to_eye, diffuse, specular); LIGHTS];
                    push(&scene(to_eye, lamps, one), [0, 0, 1000], colour);
                }
                // From behind, and along the surface.
                push(&scene(to_eye, vec![lamp(to_eye, one, one)], 0), [0, 0, -1000], colour);
                push(
                    &scene(to_eye, vec![lamp([ONE, 0, 0], one, one)], 0),
                    [0, 0, 1000],
                    colour,
                );
                push(
                    &scene([ONE, 0, 0], vec![lamp(to_eye, one, one)], 0),
                    [0, 0, 1000],
                    colour,
                );
                // One light of 1, and of the least coefficients.
                push(&scene(to_eye, vec![lamp(to_eye, one, 0)], 0), [0, 0, 16385], colour);
                push(
                    &scene(to_eye, vec![lamp(to_eye, 1 << 15, 1 << 15)], 1 << 15),
                    [0, 0, 16385],
                    colour,
                );
            }
        }
    }
    let (vectors, mut numbers) = (vectors(), Numbers(12));
    for round in 0..300 {
        let mut pick = || vectors[numbers.within(0, vectors.len() as i64 - 1) as usize];
        let (viewer, first) = (pick(), pick());
        let count = [1, 1, 2, 3, 8][round % 5];
        let mut lamps = Vec::new();
        for light in 0..count {
            let direction = if light == 0 {
                first
            } else {
                vectors[numbers.within(0, vectors.len() as i64 - 1) as usize]
            };
            let half = vectors[numbers.within(0, vectors.len() as i64 - 1) as usize];
            let mut coefficients = || {
                let grey = numbers.of(&[one, one / 2, 1 << 16, numbers_end(round)]);
                if round % 3 == 0 {
                    [grey; 3]
                } else {
                    [(); 3].map(|()| numbers.within(0, grey))
                }
            };
            lamps.push([direction, half, coefficients(), coefficients()]);
        }
        let [direction, half, _, _] = lamps[0];
        let scene = Scene {
            ambient: [(); 3].map(|()| numbers.within(0, one / 4)),
            viewer,
            half_vector: round % 2 == 0,
            exponent_log2: numbers.within(0, 8),
            lamps,
        };
        let colour = |numbers: &mut Numbers| [(); 3].map(|()| numbers.within(0, full));
        // Normals towards the light, between light and eye, and along the half vector: where highlights are.
        let towards = |v: [i64; 3], numbers: &mut Numbers| v.map(|c| -(c >> 15) + numbers.within(-200, 200));
        let between = [0, 1, 2].map(|a| (direction[a] + viewer[a]) / 2);
        for aim in [direction, between, half] {
            let gradient = towards(aim, &mut numbers);
            let colour = colour(&mut numbers);
            push(&scene, gradient, colour);
        }
        let gradient = [(); 3].map(|()| numbers.within(-(1 << 20), 1 << 20));
        let colour = colour(&mut numbers);
        push(&scene, gradient, colour);
    }
    set
}

/// A coefficient that is no power of 2.
fn numbers_end(round: usize) -> i64 {
    1_431_655_765 + 977 * round as i64
}
