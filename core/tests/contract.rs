//! Sentences of the contract that could be read in two ways, and a vector that tells the readings apart. Each test
//! states the reading that holds and shows that the other one gives another number.

use slicecast::classify::{Classifier, Linear, PointTable, Sqrt16, entry};
use slicecast::composite::{BackToFront, Dither, Dithered, Recurrence, Unorm16};
use slicecast::format::{Coefficient, Cosine, Direction, Intensity, Vector, Weight};
use slicecast::gradient::space;
use slicecast::locate::{Cell, inside};
use slicecast::normalise::Normal;
use slicecast::plan::{Plan, Sampling, Spacing};
use slicecast::plane::Composite;
use slicecast::precision::{Compact, Paper, Precision, Wide};
use slicecast::project::{Maximum, resolve};
use slicecast::shade::{Highlight, Light, Phong, Unlit, keep, keep_vector, reflected};
use slicecast::slice::RowRange;
use slicecast::stream::{Memory, Needs, Stream};
use slicecast::table::ENTRIES;
use slicecast::view::{Axis, View};

fn view([x, y, z]: [i64; 3]) -> View {
    View::new([x, y, z].map(|c| Direction::from_bits(c << 50))).unwrap()
}

/// Location: the base plane's size comes from the coded step. Two thirds of a voxel are rounded up to 2863311531 / 2^32,
/// so that three steps pass two whole voxels; the exact step would end on the second.
#[test]
fn the_base_plane_is_as_large_as_the_coded_step_makes_it() {
    let plan = Plan::whole(view([2, 0, 3]), [8, 8, 4], Spacing::CUBIC, Sampling::default()).unwrap();
    assert_eq!(plan.step()[0].to_bits(), 2_863_311_531);
    assert_eq!((plan.base(), plan.origin()), ([8 + 3, 8], [-3, 0]));
}

/// Location: whether a sample exists is decided by all 16 bits of its weight, in every precision: `Paper` reads 12 of them,
/// and 15 / 65536 beyond the last voxel would be that voxel.
#[test]
fn samples_exist_by_the_full_weight() {
    let beyond = |bits| Cell {
        index: 3,
        weight: Weight::from_bits(bits),
    };
    assert_eq!(Paper.formats().weight_bits, 12);
    assert_eq!(inside(beyond(0), 4, 1), 0..1);
    assert_eq!(inside(beyond(15), 4, 1), 0..0);
}

/// Shading: vectors are in (i, j, k), and the third component changes its sign where the slices are read from the far end.
#[test]
fn the_third_component_turns_with_the_slices() {
    let vector = [1, 2, 3];
    assert_eq!(view([0, 0, 1]).orient(vector), [1, 2, 3]);
    assert_eq!(view([0, 0, -1]).orient(vector), [1, 2, -3]);
    let along_y = view([0, -1, 0]);
    assert_eq!((along_y.major(), along_y.orient(vector)), (Axis::Y, [1, 3, -2]));
}

/// Shading: a coefficient (1.31, material times light) goes to the nearest of the bits that a precision keeps, a half up;
/// the half is not taken to the even neighbour, and `Wide` keeps all.
#[test]
fn coefficients_are_kept_to_nearest() {
    let kept = |bits| {
        let coefficient = Coefficient::from_bits(bits);
        (
            keep(Compact, coefficient),
            keep(Paper, coefficient),
            keep(Wide, coefficient),
        )
    };
    assert_eq!(kept((2 << 16) + (1 << 15) - 1), (2, 2, (2 << 16) + (1 << 15) - 1));
    assert_eq!(kept((2 << 16) + (1 << 15)), (3, 3, (2 << 16) + (1 << 15)));
    assert_eq!(kept(1 << 31), (1 << 15, 1 << 15, 1 << 31));
}

/// Shading: `Wide` takes its vectors as they are; the lattice rule is for 15 bits alone, and of candidates that are as good
/// the first counts, offsets of the first component slowest, each from -1 to 1.
#[test]
fn lattice_ties_go_to_the_smallest_offsets() {
    let mut ties = 0;
    for z in (0..1 << 30).step_by(9_876_543) {
        // The first two components are equal, so that two candidates which exchange them are as good.
        let rest = (1_i64 << 60) - i64::from(z) * i64::from(z);
        let x = ((rest / 2) as f64).sqrt() as i32;
        let exact = [x, x, z];
        let vector = exact.map(Vector::from_bits);
        assert_eq!(keep_vector(Wide, vector), exact);
        let [a, b, _] = keep_vector(Compact, vector);
        if a != b {
            assert!(a < b, "{exact:?}: {a}, {b}");
            ties += 1;
        }
    }
    assert!(ties > 10, "{ties}");
}

fn phong<P: Precision>(p: P, light: Light, viewer: [i32; 3]) -> Phong<P> {
    let ambient = [Coefficient::from_bits(1 << 28); 3];
    Phong::new(
        p,
        ambient,
        &[light],
        viewer.map(Vector::from_bits),
        Highlight::Reflection,
        0,
    )
    .unwrap()
}

/// Shading: without a gradient there is ambient light and nothing else. V.L = -1 here: R.L = 2 (N.V)(N.L) - V.L taken by
/// itself would be 1, a full highlight.
#[test]
fn no_gradient_has_no_highlight() {
    fn shaded<P: Precision>(p: P) -> [u32; 3] {
        let one = 1 << 30;
        let light = Light {
            direction: [0, 0, one].map(Vector::from_bits),
            half: [0, 0, one].map(Vector::from_bits),
            diffuse: [Coefficient::ONE; 3],
            specular: [Coefficient::ONE; 3],
        };
        let normal = Normal { g: [0; 3], r: 0 };
        phong(p, light, [0, 0, -one]).shade(normal, [1 << p.pixel().colour_bits(); 3])
    }
    assert_eq!(shaded(Compact), [1 << 12; 3]);
    assert_eq!(shaded(Paper), [1 << 12; 3]);
    assert_eq!(shaded(Wide), [1 << 28; 3]);
}

/// Shading: the highlight's sum may stop anywhere from 2^31 - 1 on: the colour is 1 from there. Eight lights of 1.0 that
/// all shine into the eye would wrap a sum of 32 bits.
#[test]
fn highlights_beyond_one_are_one() {
    fn shaded<P: Precision>(p: P) -> u32 {
        let towards = [0, 0, -(1 << 30)].map(Vector::from_bits);
        let light = Light {
            direction: towards,
            half: towards,
            diffuse: [Coefficient::ZERO; 3],
            specular: [Coefficient::ONE; 3],
        };
        let phong = Phong::new(
            p,
            [Coefficient::ZERO; 3],
            &[light; 8],
            towards,
            Highlight::HalfVector,
            0,
        )
        .unwrap();
        // g points away from the normal.
        let normal = slicecast::normalise::normalise([0, 0, 1000]);
        phong.shade(normal, [0; 3])[0]
    }
    // A cosine is at most 2^-19.2 below 1, in each of the eight.
    assert_eq!(shaded(Compact), 1 << 15);
    assert_eq!(shaded(Paper), 1 << 15);
    assert_eq!(shaded(Wide), 1 << 31);
}

/// Shading: the reflection of `Paper` is held to 1, as its dot products are. N, L and V of one direction give
/// 2 - 0.99994 where the vectors are one unit short, and a power would raise what exceeds 1.
#[test]
fn the_papers_reflection_is_held_to_one() {
    let short = [0, 0, 32_767];
    assert_eq!(((1_i64 << 32) >> 15) - ((32_767 * 32_767) >> 14), (1 << 16) + 4);
    let reflection = reflected(Paper, Cosine::ONE, Cosine::ONE, short, short);
    assert_eq!(reflection, Cosine::ONE);
}

/// A table with one visible entry.
fn table(code: usize, colour: [u8; 3], root: u16) -> ([u32; ENTRIES], [u8; ENTRIES]) {
    let (mut entries, mut low) = ([0; ENTRIES], [0; ENTRIES]);
    let [low_byte, high] = root.to_le_bytes();
    entries[code] = entry(colour, high);
    low[code] = low_byte;
    (entries, low)
}

/// Classification: an entry is red in bits 0 to 7, green, blue, and the root's high byte in bits 24 to 31.
#[test]
fn entries_begin_with_red() {
    assert_eq!(entry([0x11, 0x22, 0x33], 0x44), 0x4433_2211);
}

/// Classification: opacities are decoded before they are mixed. Half way between 0 and the root 1 the opacity is a half;
/// the square of half the root would be a quarter.
#[test]
fn opacities_are_mixed_and_roots_are_not() {
    let (entries, low) = table(101, [255; 3], 0xffff);
    let table = PointTable::<Sqrt16, Linear>::new(&entries, &low);
    let opacity = Classifier::opacity(&table, Compact, (100 << 12) + (1 << 11));
    assert_eq!(opacity.to_bits(), 1_073_709_057);
}

/// Compositing: back to front, a plane keeps its own number and with it its dither; planes are not counted from behind.
#[test]
fn planes_keep_their_dither_back_to_front() {
    type Pipe<'t> = Composite<Compact, PointTable<'t, Sqrt16, Linear>, Unlit, BackToFront>;
    // Opacity 0.21, so that both offsets of three planes decide a rounding.
    let (entries, low) = table(1000, [200, 120, 40], 30_011);
    let table = PointTable::<Sqrt16, Linear>::new(&entries, &low);
    let pipeline = Pipe::new(Compact, table, Unlit);
    let plan = Plan::whole(view([0, 0, 1]), [1, 1, 3], Spacing::CUBIC, Sampling::default()).unwrap();
    let needs = Needs::of::<Pipe>(&plan);
    let (mut slices, mut ranges) = (vec![0; needs.slices], vec![RowRange::EMPTY; needs.ranges]);
    let (mut scratch, mut image) = (vec![0; needs.scratch], vec![Unorm16::default(); needs.image]);
    let memory = Memory {
        slices: &mut slices,
        ranges: &mut ranges,
        scratch: &mut scratch,
        image: &mut image,
    };
    let mut stream = Stream::new(plan, pipeline, memory).unwrap();
    let mut order = Vec::new();
    while let Some(number) = stream.wanted() {
        order.push(number);
        stream.push(&[1000]).unwrap();
    }
    assert_eq!(order, [2, 1, 0]);
    let sample = 1000 << 12;
    let opacity = Classifier::opacity(&table, Compact, sample);
    let colour = Classifier::colour(&table, Compact, sample);
    let folded = |numbers: [u32; 3]| {
        let under = |pixel, k| Dithered.under(pixel, colour, opacity, Dither::of_plane(k));
        numbers.into_iter().fold(Dithered.clear(), under)
    };
    assert_eq!(stream.pixel(0, 0), folded([2, 1, 0]));
    assert_ne!(folded([2, 1, 0]), folded([0, 1, 2]));
}

/// Projection: a dither of 0 keeps the half unit, `(2 * 0 + 1) 2^15`. The opacity 2^-16 takes 0.49999 of a unit and a half.
#[test]
fn a_dither_of_zero_keeps_the_half_unit() {
    let (entries, low) = table(7, [255; 3], 256);
    let table = PointTable::<Sqrt16, Linear>::new(&entries, &low);
    let opacity = Classifier::opacity(&table, Compact, 7 << 12);
    assert_eq!(opacity.to_bits(), 1 << 15);
    assert_eq!((65_535_u64 * (1 << 15)) >> 31, 0);
    let pixel = resolve::<_, Maximum>(Compact, 7 << 12, &table);
    // (c w + 0) >> 15 with c = 1.0 gives all of what was taken.
    assert_eq!((pixel.transparency.0, pixel.colour[0].0), (65_534, 1));
}

/// Gradient: the difference comes first and its product with the spacing factor is rounded once.
#[test]
fn differences_are_taken_before_the_spacing_factor() {
    let half = Intensity::from_bits(1 << 14);
    assert_eq!(space(3 - 2, half), 1);
    assert_eq!(space(3, half) - space(2, half), 1);
    assert_eq!(space(4 - 1, half), 2);
    assert_eq!(space(4, half) - space(1, half), 1);
}
