//! Compositing: white fog and its relatives, without the floor and with it.

use slicecast::composite::{
    Channel as _, Dither, Dithered, Pixel, Recurrence, Telescoping31, Truncating15, Unorm16, settle,
};
use slicecast::format::Opacity;
use slicecast_host_tests::random::Random;
use slicecast_laboratory::channels::Scale;
use slicecast_laboratory::pixels::{Arithmetic, StudyPixel};

/// A ray: colour (1.15, all channels alike) and opacity (1.31) of plane k.
type Ray = (&'static str, u32, fn(u32) -> (u32, u32));

/// C, T and the 8-bit value.
type Result3 = (u32, u32, u8);

const WHITE: u32 = 32768;

/// Ray; wide; 64 bits with dither in 1.15; paper; and the same dither on the scale of 65535, which `Compact` has. C and
/// T are raw bits. The last column is not the study's: `w = (T a + (2 dT + 1) 2^15) >> 31`, `T -= w`,
/// `C += (c w + dC) >> 15` from T = 65535, in Python's integers.
const RAYS: [(Ray, [Result3; 4]); 14] = [
    (
        ("fog 2^-8 x 1024", 1024, |_| (WHITE, 1 << 23)),
        [
            (2_108_457_882, 39_025_766, 250),
            (32_171, 597, 250),
            (31_279, 474, 243),
            (64344, 1191, 250),
        ],
    ),
    (
        ("fog 2^-10 x 1024", 1024, |_| (WHITE, 1 << 21)),
        [
            (1_357_854_147, 789_629_501, 161),
            (20_724, 12_044, 161),
            (20_013, 11_734, 156),
            (41440, 24095, 161),
        ],
    ),
    (
        ("fog 2^-12 x 1024", 1024, |_| (WHITE, 1 << 19)),
        [
            (475_072_282, 1_672_411_366, 56),
            (7_251, 25_517, 56),
            (6_658, 25_088, 52),
            (14498, 51037, 56),
        ],
    ),
    (
        ("fog 2^-14 x 1024", 1024, |_| (WHITE, 1 << 17)),
        [
            (130_112_822, 2_017_370_826, 15),
            (1_988, 30_780, 15),
            (1_025, 30_720, 8),
            (3972, 61563, 15),
        ],
    ),
    (
        ("fog 2^-15 x 1024", 1024, |_| (WHITE, 1 << 16)),
        [
            (66_071_651, 2_081_411_997, 8),
            (1_013, 31_755, 8),
            (1, 31_744, 0),
            (2016, 63519, 8),
        ],
    ),
    (
        ("fog 2^-16 x 1024", 1024, |_| (WHITE, 1 << 15)),
        [
            (33_293_427, 2_114_190_221, 4),
            (509, 32_259, 4),
            (0, 31_744, 0),
            (1017, 64518, 4),
        ],
    ),
    (
        ("fog 2^-16 x 4096", 4096, |_| (WHITE, 1 << 15)),
        [
            (130_108_472, 2_017_375_176, 15),
            (1_986, 30_782, 15),
            (0, 28_672, 0),
            (3970, 61565, 15),
        ],
    ),
    (
        ("fog 2^-12 x 4096", 4096, |_| (WHITE, 1 << 19)),
        [
            (1_357_563_723, 789_919_925, 161),
            (20_716, 12_052, 161),
            (17_806, 10_868, 139),
            (41428, 24107, 161),
        ],
    ),
    (
        ("almost black, 2^-8 x 512", 512, |_| (1, 1 << 23)),
        [(56_453, 289_494_405, 0), (1, 4_417, 0), (0, 4_308, 0), (1, 8834, 0)],
    ),
    (
        ("opaque first, then white", 2, |k| {
            if k == 0 { (20_000, 1 << 31) } else { (WHITE, 1 << 31) }
        }),
        [
            (1_310_720_000, 0, 156),
            (20_000, 0, 156),
            (20_000, 0, 156),
            (39999, 0, 156),
        ],
    ),
    (
        ("the table's most opaque black, then white", 2, |k| {
            if k == 0 { (0, 2_147_418_113) } else { (WHITE, 1 << 31) }
        }),
        [(65_535, 0, 0), (1, 0, 0), (1, 0, 0), (2, 0, 0)],
    ),
    (
        ("transparent x 4096, then opaque", 4097, |k| {
            if k < 4096 { (WHITE, 0) } else { (12_345, 1 << 31) }
        }),
        [(809_041_920, 0, 96), (12_345, 0, 96), (12_345, 0, 96), (24690, 0, 96)],
    ),
    (
        ("2^-15 on odd planes of 4096", 4096, |k| {
            (WHITE, if k % 2 == 1 { 1 << 16 } else { 0 })
        }),
        [
            (130_110_422, 2_017_373_226, 15),
            (1_983, 30_785, 15),
            (1, 30_720, 0),
            (3971, 61564, 15),
        ],
    ),
    (
        ("half x 31", 31, |_| (WHITE, 1 << 30)),
        [
            (2_147_483_647, 1, 255),
            (32_768, 0, 255),
            (32_767, 0, 255),
            (65535, 0, 255),
        ],
    ),
];

fn cast<R: Recurrence>(
    r: R,
    ray: Ray,
    fold: impl Fn(Pixel<R::Channel>, [u32; 3], Opacity, Dither) -> Pixel<R::Channel>,
) -> Result3 {
    let (name, planes, sample) = ray;
    let mut pixel = r.clear();
    for k in 0..planes {
        let (colour, opacity) = sample(k);
        let colour = [colour << (r.colour_bits() - 15); 3];
        pixel = fold(pixel, colour, Opacity::from_bits(opacity), Dither::of_plane(k));
    }
    let [red, green, blue] = pixel.colour;
    assert!(red == green && green == blue, "{name}: channels differ");
    // To the nearest byte.
    let (bits, one) = (u64::from(red.bits()), u64::from(r.one().bits()));
    (
        red.bits(),
        pixel.transparency.bits(),
        ((bits * 510 + one) / (2 * one)) as u8,
    )
}

fn without_floor<R: Recurrence>(r: R, ray: Ray) -> Result3 {
    cast(r, ray, |p, c, a, d| r.over(p, c, a, d))
}

fn with_floor<R: Recurrence>(r: R, ray: Ray) -> Result3 {
    cast(r, ray, |p, c, a, d| {
        let mut out = r.over(p, c, a, d);
        out.transparency = settle(out.transparency, r.floor());
        out
    })
}

/// 1.15 with the dither.
fn dithered15() -> StudyPixel {
    StudyPixel::new(Arithmetic::Dithered, Scale::Binary(15)).unwrap()
}

#[test]
fn rays_without_the_floor() {
    for (ray, [wide, dithered, paper, compact]) in RAYS {
        assert_eq!(without_floor(Telescoping31, ray), wide, "{}, 1.31", ray.0);
        let found = without_floor(dithered15(), ray);
        assert_eq!(found, dithered, "{}, 1.15 with dither", ray.0);
        assert_eq!(without_floor(Truncating15, ray), paper, "{}, paper", ray.0);
        assert_eq!(without_floor(Dithered, ray), compact, "{}, 65535 with dither", ray.0);
    }
}

/// The floors: 1 unit in 16 bits, where they can never matter, and 2^-20 in 1.31. There only the last ray comes below: its
/// light is halved to 2^11 by sample 20 and to 2^10 by sample 21, which is below the floor and becomes 0; 2^10 of the
/// light is lost and C stands at 2^31 - 2^10.
#[test]
fn rays_with_the_floor() {
    for (ray, [wide, dithered, paper, compact]) in RAYS {
        let wide = if ray.0 == "half x 31" {
            ((1 << 31) - (1 << 10), 0, 255)
        } else {
            wide
        };
        assert_eq!(with_floor(Telescoping31, ray), wide, "{}, 1.31", ray.0);
        let found = with_floor(dithered15(), ray);
        assert_eq!(found, dithered, "{}, 1.15 with dither", ray.0);
        assert_eq!(with_floor(Truncating15, ray), paper, "{}, paper", ray.0);
        assert_eq!(with_floor(Dithered, ray), compact, "{}, 65535 with dither", ray.0);
    }
}

#[test]
fn the_floor_itself() {
    let floors = (Telescoping31.floor(), Dithered.floor(), Truncating15.floor());
    assert_eq!(floors, (1 << 11, Unorm16(1), 1));
    for (t, settled) in [
        (0, 0),
        (1, 0),
        (2047, 0),
        (2048, 2048),
        (2049, 2049),
        (1 << 31, 1 << 31),
    ] {
        assert_eq!(settle(t, Telescoping31.floor()), settled);
    }
    assert_eq!([0u16, 1, 2, 32768].map(|t| settle(t, 1)), [0, 1, 2, 32768]);
    // Without a floor 1.31 sticks at 1 unit whatever half-transparent samples follow.
    let stuck = Pixel {
        colour: [0; 3],
        transparency: 1u32,
    };
    let after = Telescoping31.over(stuck, [1 << 31; 3], Opacity::from_bits(1 << 30), Dither::of_plane(0));
    assert_eq!(after, stuck);
}

/// White keeps C + T = 1 whatever the opacities, and transparent samples leave a pixel alone.
#[test]
fn white_keeps_all_light() {
    fn run<R: Recurrence>(r: R, seed: u64) {
        let mut random = Random::new(seed);
        let (mut pixel, one) = (r.clear(), r.one().bits());
        let white = [1 << r.colour_bits(); 3];
        for k in 0..20_000 {
            let dither = Dither::of_plane(k);
            let opacity = Opacity::from_bits((random.next_bits() as u32 >> 1) >> random.below(28));
            pixel = r.over(pixel, white, opacity, dither);
            assert_eq!(pixel.colour[0].bits() + pixel.transparency.bits(), one, "plane {k}");
            assert_eq!(r.over(pixel, white, Opacity::ZERO, dither), pixel);
            if pixel.transparency.bits() < one >> 8 {
                pixel = r.clear();
            }
        }
    }
    for seed in 0..8 {
        run(Telescoping31, seed);
        run(Dithered, seed);
    }
}
