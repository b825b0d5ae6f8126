use super::*;
use crate::crop::Crop;
use crate::format::Direction;
use crate::format::Position;
use crate::locate::cut;
use crate::plan::Plan;
use crate::plan::{PlanError, Sampling, Spacing};
use crate::sides::{Side, about_k, along_k};
use crate::view::View;
use proptest::prelude::*;

/// Opacities of all lengths, and those at powers of two.
fn opacities() -> impl Iterator<Item = u32> {
    let steps = (0..=1u64 << 31).step_by(1_048_573).map(|bits| bits as u32);
    let near = (0..=31).flat_map(|n| [-1i64, 0, 1].map(|d| (1i64 << n) + d));
    let ends = near.flat_map(|bits| [bits, (1 << 31) - bits]);
    steps.chain(ends.filter_map(|bits| u32::try_from(bits).ok().filter(|bits| *bits <= 1 << 31)))
}

fn fractions() -> impl Iterator<Item = u32> {
    (1..=WHOLE).step_by(1_021).chain([2, 3, 32_767, 32_768, 65_535, WHOLE])
}

fn reduced(opacity: u32, fraction: u32) -> u32 {
    fraction_of(Opacity::from_bits(opacity), fraction).to_bits()
}

#[test]
fn opacities_of_fractions_are_as_near_as_stated() {
    let mut worst: f64 = 0.0;
    for opacity in opacities() {
        for fraction in fractions() {
            let found = reduced(opacity, fraction);
            let left = 1.0 - f64::from(opacity) / 2147483648.0;
            let exact = -(f64::from(fraction) / 65536.0 * left.ln()).exp_m1() * 2147483648.0;
            worst = worst.max((f64::from(found) - exact).abs());
            assert!(found <= opacity, "{opacity} {fraction}: {found}");
        }
        assert_eq!(reduced(opacity, WHOLE), opacity);
    }
    assert!(worst <= ERROR, "{worst}");
    assert!(worst > 0.8 * ERROR, "stale: {worst}");
}

#[test]
fn nothing_and_everything_stay() {
    for fraction in fractions() {
        assert_eq!((reduced(0, fraction), reduced(1 << 31, fraction)), (0, 1 << 31));
    }
}

#[test]
fn opacities_never_fall() {
    for fraction in fractions() {
        let mut last = 0;
        for opacity in (0..=1u64 << 31).step_by(400_009) {
            let found = reduced(opacity as u32, fraction);
            assert!(found >= last, "{opacity} {fraction}");
            last = found;
        }
    }
    for opacity in opacities() {
        let mut last = 0;
        for fraction in fractions().take(65) {
            let found = reduced(opacity, fraction);
            assert!(found >= last, "{opacity} {fraction}");
            last = found;
        }
    }
}

#[test]
fn a_small_machine_has_the_same_bits() {
    for fraction in fractions() {
        let row: std::vec::Vec<i32> = opacities().map(|bits| bits as i32).collect();
        let (mut small, mut scalar) = (row.clone(), row);
        fraction_row::<Small>(&mut small, fraction);
        fraction_row::<i32>(&mut scalar, fraction);
        assert_eq!(small, scalar);
    }
}

/// Directions as shears: none, whole, the shortest step, or any.
fn shear() -> impl Strategy<Value = i64> {
    let one = 1i64 << 58;
    prop_oneof![
        1 => Just(0),
        1 => Just(one),
        1 => Just(-one),
        1 => (-3i64..=3).prop_map(|bits| bits << 26),
        1 => (-4i64..=4).prop_map(move |quarters| quarters * (one >> 2)),
        4 => -one..=one,
    ]
}

fn plan_of(shear: [i64; 2], dims: [u32; 3], rates: [u32; 2], borders: Borders) -> Result<Plan, PlanError> {
    let [i, j] = shear;
    let view = View::new([i, j, 1 << 58].map(Direction::from_bits)).unwrap();
    let [planes_per_voxel, rays_per_voxel] = rates;
    let sampling = Sampling {
        planes_per_voxel,
        rays_per_voxel,
    };
    Plan::with_borders(view, dims, Spacing::CUBIC, sampling, borders)
}

/// Where a ray enters and leaves the box along an axis, in segments from the first.
fn crossing(first: Side, pixel: u32) -> [f64; 2] {
    let begin = first.begin as f64 + f64::from(pixel) * 8589934592.0;
    let [a, b] = [-begin, first.side as f64 - begin].map(|distance| distance / first.length as f64);
    match first.length {
        0 if (0.0..=first.side as f64).contains(&begin) => [f64::NEG_INFINITY, f64::INFINITY],
        0 => [f64::INFINITY, f64::NEG_INFINITY],
        _ => [a.min(b), a.max(b)],
    }
}

fn borders() -> impl Strategy<Value = Borders> {
    prop_oneof![Just(Borders::Cells), Just(Borders::Nodes)]
}

/// Boxes that meet a volume of up to nine voxels, most of them: faces at voxels, halves and anywhere, thin, open.
fn crop() -> impl Strategy<Value = Option<Crop>> {
    let low =
        prop_oneof![2 => (-2i32..=18).prop_map(|halves| halves << 15), 2 => -70_000i32..=600_000, 1 => Just(i32::MIN)];
    let side = prop_oneof![1 => Just(1), 2 => 1i32..=70_000, 2 => 1i32..=600_000, 1 => Just(i32::MAX)];
    let axes = prop::array::uniform3((low, side));
    prop::option::weighted(0.8, axes).prop_map(|axes| {
        axes.map(|axes| Crop {
            low: axes.map(|(low, _)| Position::from_bits(low)),
            high: axes.map(|(low, side)| Position::from_bits(low.max(-(1 << 17)).saturating_add(side))),
        })
    })
}

/// The plan, cropped, or `None` where the box lies beside the volume.
fn cropped(plan: Plan, crop: Option<Crop>) -> Option<Plan> {
    match crop.map(|crop| plan.with_crop(crop)) {
        None => Some(plan),
        Some(Ok(plan)) => Some(plan),
        Some(Err(PlanError::Beside { .. })) => None,
        Some(Err(error)) => panic!("{error}"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, rng_seed: proptest::test_runner::RngSeed::Fixed(18), ..ProptestConfig::default() })]

    /// The fractions of a ray add up to its length; none of its length lies beside the base plane.
    #[test]
    fn fractions_add_up_to_the_length(
        shear in [shear(), shear()],
        dims in prop::array::uniform3(1u32..=9),
        rates in [1u32..=16, 1u32..=3],
        borders in borders(),
        crop in crop(),
    ) {
        let plan = match plan_of(shear, dims, rates, borders) {
            Err(error) => {
                prop_assert_eq!((error, dims.contains(&1), borders), (PlanError::Thin, true, Borders::Nodes));
                return Ok(());
            }
            Ok(plan) => plan,
        };
        let Some(plan) = cropped(plan, crop) else { return Ok(()) };
        let planes = plan.planes();
        prop_assert!(plan.planes_met().end <= planes && !plan.planes_met().is_empty());
        for phase in 0..plan.phases() {
            let [start_i, start_j] = plan.start(plan.phase(phase));
            let sides = |index| [Side::of(&plan, start_i, 0, index), Side::of(&plan, start_j, 1, index)];
            let [columns, rows] = plan.base();
            for (u, v) in (0..columns).flat_map(|u| (0..rows).map(move |v| (u, v))) {
                let sum: u64 = (0..planes)
                    .map(|index| {
                        let [x, y] = sides(index);
                        let part = x.part(u).and(y.part(v)).and(about_k(&plan, index));
                        assert!(part.length() == 0 || plan.planes_met().contains(&index), "plane {index} is left out");
                        u64::from(part.length())
                    })
                    .sum();
                let [x, y] = sides(0);
                let ([x_in, x_out], [y_in, y_out]) = (crossing(x, u), crossing(y, v));
                // Along k in segments from the first.
                let first = if borders == Borders::Cells { f64::from(rates[0]) / 2.0 } else { 0.0 };
                let [z_in, z_out] = plan.box_of_volume()[2].map(|face| f64::from(face.to_bits()) / 65536.0 * f64::from(rates[0]) + first);
                let length = (x_out.min(y_out).min(z_out) - x_in.max(y_in).max(z_in)).max(0.0);
                prop_assert!((sum as f64 - length * 65536.0).abs() <= 1.0 + 1e-4, "{u} {v}: {sum}, {}", length * 65536.0);
            }
            for index in 0..planes {
                for (side, pixels) in sides(index).into_iter().zip([columns, rows]) {
                    let before = Side { begin: side.begin - (1 << 33), ..side };
                    let counted = about_k(&plan, index);
                    prop_assert_eq!(before.part(0).fraction(counted), 0, "before the first pixel");
                    prop_assert_eq!(side.part(pixels).fraction(counted), 0, "behind the last pixel");
                    let part = |pixel: &u32| side.part(*pixel);
                    let touched: std::vec::Vec<u32> = (0..pixels).filter(|p| part(p).fraction(Part::WHOLE) > 0).collect();
                    prop_assert!(touched.iter().all(|pixel| side.touched(pixels).contains(pixel)));
                    let whole: std::vec::Vec<u32> = side.whole(pixels).collect();
                    prop_assert!(whole.iter().all(|pixel| side.part(*pixel) == Part::WHOLE));
                    // At most one at each end is not whole.
                    prop_assert!(side.touched(pixels).len() <= whole.len() + 2);
                }
            }
        }
    }

    /// So do those of segments between samples, which end where the next begins; the whole ray is covered.
    #[test]
    fn segments_follow_one_another_and_add_up_to_the_length(
        shear in [shear(), shear()],
        dims in prop::array::uniform3(1u32..=9),
        rates in [1u32..=16, 1u32..=3],
        borders in borders(),
        crop in crop(),
    ) {
        let Ok(plan) = plan_of(shear, dims, rates, borders) else { return Ok(()) };
        let Some(plan) = cropped(plan, crop) else { return Ok(()) };
        let (segments, [rate, _]) = (plan.ends() - 1, rates);
        for phase in (0..plan.phases()).map(|number| plan.phase(number)) {
            let [start_i, start_j] = plan.start(phase);
            let sides = |index| [Side::behind(&plan, start_i, 0, index), Side::behind(&plan, start_j, 1, index)];
            for index in 0..segments {
                // Every slice lies in a plane, so that none is straddled; and cut places lie between the segment's ends.
                let places = [0, 1, 20_000, 65_535, WHOLE].map(|part| cut(&plan, phase, index, part));
                prop_assert_eq!(places[4], cut(&plan, phase, index + 1, 0));
                let [near, far] = [places[0][2], places[4][2]].map(|z| z.to_bits());
                prop_assert!(far <= ((near >> 16) + 1) << 16);
                for axis in 0..3 {
                    let line = places.map(|place| place[axis].to_bits());
                    prop_assert!(line.is_sorted() || line.iter().rev().is_sorted());
                }
                for (side, pixels) in sides(index).into_iter().zip(plan.base()) {
                    // At most two at each end are not whole, or have an end that is held to the voxels.
                    let [low, high] = [side.begin.min(side.begin + side.length), side.begin.max(side.begin + side.length)];
                    // Beyond the outermost voxels ends are held.
                    let before = if crop.is_none() { i64::from(borders == Borders::Cells) << 32 } else { 0 };
                    let inner = |pixel: &u32| {
                        let way = i64::from(*pixel) << 33;
                        low + way >= before && high + way <= side.side - before
                    };
                    let touched = side.touched(pixels);
                    prop_assert!(touched.clone().filter(|pixel| !inner(pixel)).count() <= 4);
                }
            }
            let [columns, rows] = plan.base();
            // The box in segments from the first plane.
            let before = if borders == Borders::Cells { f64::from(rate.div_ceil(2)) } else { 0.0 };
            for (u, v) in (0..columns).flat_map(|u| (0..rows).map(move |v| (u, v))) {
                let length = |index: u32| {
                    let [x, y] = sides(index);
                    x.part(u).and(y.part(v)).and(along_k(&plan, index)).length()
                };
                for index in 0..segments {
                    let met = plan.ends_met();
                    prop_assert!(length(index) == 0 || (met.start <= index && index + 1 < met.end), "segment {} is left out", index);
                }
                let sum: u64 = (0..segments).map(|index| u64::from(length(index))).sum();
                let [x, y] = sides(0);
                let ([x_in, x_out], [y_in, y_out]) = (crossing(x, u), crossing(y, v));
                let [z_in, z_out] = plan.box_of_volume()[2].map(|face| f64::from(face.to_bits()) / 65536.0 * f64::from(rate) + before);
                let length = (x_out.min(y_out).min(z_out) - x_in.max(y_in).max(z_in)).max(0.0);
                prop_assert!((sum as f64 - length * 65536.0).abs() <= 1.0 + 1e-4, "{u} {v}: {sum}, {}", length * 65536.0);
            }
        }
    }

    /// Seen from behind, a segment has the same part inside, ties apart.
    #[test]
    fn fractions_are_the_same_from_behind(begin in -(40i64 << 33)..40 << 33, step in -(1i64 << 32)..=1 << 32, side in 1i64..=20, pixel in 0u32..40) {
        let there = Side { begin, length: 2 * step, side: side << 33, finer: 0 };
        let back = Side { begin: begin + 2 * step, length: -2 * step, side: side << 33, finer: 0 };
        let (a, b) = (there.part(pixel), back.part(pixel));
        prop_assert!(a.from.abs_diff(WHOLE - b.to) <= 1 && a.to.abs_diff(WHOLE - b.from) <= 1 || step == 0);
        prop_assert!(a.fraction(Part::WHOLE).abs_diff(b.fraction(Part::WHOLE)) <= 1);
        if step % 2 != 0 {
            prop_assert_eq!(a.fraction(Part::WHOLE), b.fraction(Part::WHOLE));
        }
    }
}

/// A face grazed along, a corner touched, a step of 2^-32.
#[test]
fn grazing_rays_have_the_length_inside() {
    let one = 1i64 << 33;
    let along = |begin| Side {
        begin,
        length: 0,
        side: 3 * one,
        finer: 0,
    };
    assert_eq!(
        [-1, 0, 3 * one, 3 * one + 1].map(|b| along(b).part(0)),
        [Part::NONE, Part::WHOLE, Part::WHOLE, Part::NONE]
    );
    // Enters x where it leaves y: the corner alone.
    let (x, y) = (
        Side {
            begin: -one / 2,
            length: one,
            side: one,
            finer: 0,
        },
        Side {
            begin: one / 2,
            length: one,
            side: one,
            finer: 0,
        },
    );
    assert_eq!(
        (x.part(0), y.part(0)),
        (Part { from: 32768, to: WHOLE }, Part { from: 0, to: 32768 })
    );
    assert_eq!(x.part(0).fraction(y.part(0)), 0);
    // The shortest step, half of it inside.
    let short = Side {
        begin: -1,
        length: 2,
        side: one,
        finer: 0,
    };
    assert_eq!(short.part(0), Part { from: 32768, to: WHOLE });
    assert_eq!(Side { begin: -2, ..short }.part(0).fraction(Part::WHOLE), 0);
}

#[test]
fn base_planes_hold_the_box_and_no_more() {
    let (one, r) = (1i64 << 58, [1, 1]);
    let plan = |shear, dims, rates, borders| plan_of(shear, dims, rates, borders).unwrap();
    let shape = |p: Plan| (p.base(), p.origin(), p.planes());
    assert_eq!(shape(plan([0, 0], [5, 7, 3], r, Borders::Cells)), ([5, 7], [0, 0], 3));
    assert_eq!(shape(plan([0, 0], [5, 7, 3], r, Borders::Nodes)), ([5, 7], [0, 0], 2));
    // Phases reach half a voxel before the first.
    assert_eq!(
        shape(plan([0, 0], [5, 7, 3], [2, 2], Borders::Cells)),
        ([6, 8], [-1, -1], 6)
    );
    assert_eq!(
        shape(plan([one, -one], [5, 7, 3], r, Borders::Nodes)),
        ([7, 9], [-2, 0], 2)
    );
    assert_eq!(
        shape(plan([one, -one], [5, 7, 3], r, Borders::Cells)),
        ([9, 11], [-3, -1], 3)
    );
    assert_eq!(
        shape(plan([0, 0], [1, 1, 1], [16, 1], Borders::Cells)),
        ([1, 1], [0, 0], 16)
    );
    assert_eq!(
        plan_of([0, 0], [2, 2, 2049], [16, 1], Borders::Cells),
        Err(PlanError::Planes { given: 2049 * 16 - 1 })
    );
    assert_eq!(plan_of([0, 0], [2, 1, 2], [1, 1], Borders::Nodes), Err(PlanError::Thin));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20000, rng_seed: proptest::test_runner::RngSeed::Fixed(44), ..ProptestConfig::default() })]

    /// Against real numbers; a step of its own length is left alone but for the rounding of a power.
    #[test]
    fn opacities_of_lengths_are_close(root in 0u32..=1 << 16, low in 0u32..=1 << 14, length in 1u32 << 20..(8 << 20) - 1) {
        let opacity = ((root * (root >> 1)) + low).min(1 << 31);
        let found = opacity_of_length(opacity as i32, length as i32) as u32;
        let (a, l) = (f64::from(opacity) / 2147483648.0, f64::from(length) / 1048576.0);
        let exact = (1.0 - (1.0 - a).powf(l)) * 2147483648.0;
        let error = f64::from(found) - exact;
        prop_assert!(error.abs() <= 100.0 * l, "{error} of {exact}, {opacity} {length}");
        prop_assert!(found >= opacity);
        prop_assert!(found == 0 || opacity > 0);
        let (mut row, mut small) = ([opacity as i32, 0, opacity as i32], [opacity as i32, 0, opacity as i32]);
        lengths_row::<i32>(&mut row, &[length as i32; 3]);
        lengths_row::<Small>(&mut small, &[length as i32; 3]);
        prop_assert_eq!(row, [found as i32, 0, found as i32]);
        prop_assert_eq!(small, row);
    }
}

#[test]
fn what_is_opaque_stays_opaque_at_any_length() {
    for length in [1 << 20, 3 << 20, (8 << 20) - 1] {
        assert_eq!(opacity_of_length(i32::MIN, length), i32::MIN);
        assert_eq!(opacity_of_length(0, length), 0);
    }
}
