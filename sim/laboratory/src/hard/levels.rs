//! Levels: lengths of rays through boxes of several resolutions, and what is seen where they meet (LaMar, figure 12).

use slicecast_engine::error::RenderError;
use slicecast_engine::levels::tree::Tree;
use slicecast_scene::Borders;

use super::borders::{homogeneous, views};
use super::scenes::{scene, volume};
use super::{Case, Size};
use crate::borders::rays::seen;
use crate::borders::seams::rays;

fn cut(axis: usize, at: usize, parts: [Tree; 2]) -> Tree {
    Tree::Cut {
        axis,
        at,
        parts: Box::new(parts),
    }
}

/// Cuts of a cube of eight voxels into boxes of three levels and more: quarters, slabs, a slab of one voxel between coarse ones, a box of one
/// voxel in a corner, one voxel of level 3.
fn trees() -> Vec<Tree> {
    use Tree::Leaf;
    let quarters = |axes: [usize; 2]| cut(axes[0], 4, [Leaf(2), cut(axes[1], 4, [Leaf(1), Leaf(0)])]);
    let thin = |axis: usize| {
        cut(
            axis,
            4,
            [Leaf(2), cut(axis, 5, [Leaf(0), cut(axis, 6, [Leaf(0), Leaf(1)])])],
        )
    };
    let corner = cut(
        0,
        4,
        [
            Leaf(2),
            cut(
                1,
                6,
                [
                    Leaf(1),
                    cut(2, 7, [Leaf(0), cut(0, 7, [Leaf(0), cut(1, 7, [Leaf(0), Leaf(0)])])]),
                ],
            ),
        ],
    );
    vec![
        quarters([0, 1]),
        thin(0),
        quarters([2, 0]),
        thin(1),
        quarters([1, 2]),
        thin(2),
        corner,
        Leaf(3),
    ]
}

/// A homogeneous cube from all sides: what is missing from, or too much of, each ray, in steps of the finest level.
fn cube(size: Size) -> Result<Case, RenderError> {
    let count = match size {
        Size::Full => 104,
        Size::Reduced => 16,
    };
    let mut case = Case::new(
        "levels",
        format!(
            "homogeneous cube of 8 voxels, opacity 0.1 a voxel, in boxes of levels 0 to 3, cut in 8 ways, {count} views, every ray"
        ),
        "largest error of a ray's length, steps of level 0",
        0.0,
        "what is left is exp(-tau times the ray's length in the cube)",
    );
    let (cube, kinds) = homogeneous();
    let trees = trees();
    for (kind, scene) in kinds {
        let mut worst: f64 = 0.0;
        for (n, view) in views(count).enumerate() {
            let rate = [1, 2, 3, 5][n % 4];
            let scene = seen(&scene, view, rate, Borders::Cells);
            // The three special views with every cut, the others with one.
            let chosen = if n < 3 {
                0..trees.len()
            } else {
                n % trees.len()..n % trees.len() + 1
            };
            for tree in &trees[chosen] {
                let errors = rays(&scene, &cube, tree, |ray, step, left| {
                    let tau = -(-0.1f64).ln_1p() * step / f64::from(rate);
                    (-left.ln() / tau - ray.length() * f64::from(rate)).abs()
                })?;
                worst = errors.values.into_iter().fold(worst, f64::max);
            }
        }
        case.outcome(format!("wide, {kind}"), worst, Some(0.01));
    }
    case.note = Some("limit: that of whole volumes (group borders); a third of the rays lie at multiples of 1/3 voxel, and of straight views along faces".into());
    Ok(case)
}

/// Waves in boxes of levels against the integral of each level's own field over exactly its boxes.
fn waves(size: Size) -> Result<[Case; 2], RenderError> {
    let count = match size {
        Size::Full => 24,
        Size::Reduced => 6,
    };
    let mut case = Case::new(
        "levels",
        format!("waves of 16 x 16 x 16 voxels, opacity 0.1, in boxes of levels 0 to 2, {count} views, every ray"),
        "largest error, steps of 1/255",
        0.0,
        "the integral of each level's extinction over the ray's part of its boxes",
    );
    let waves = volume([16; 3], [1.0; 3], |[x, y, z]| {
        2000.0 + 1500.0 * (0.35 * x as f64 + 0.3 * y as f64 - 0.25 * z as f64).sin()
    });
    let scene = scene(&[(0.0, 0.0), (4095.0, 0.1)]);
    let octants = |levels: [u32; 4]| {
        let [a, b, c, d] = levels.map(Tree::Leaf);
        cut(2, 8, [cut(0, 4, [a, b]), cut(1, 12, [c, d])])
    };
    let trees = [[0, 1, 2, 0], [2, 1, 0, 1], [1, 0, 1, 2]].map(octants);
    let mut order = Case::new(
        "levels",
        format!("the same waves, {count} views, every ray"),
        "largest error at twice the planes, over the one before",
        0.25,
        "midpoints are of the second order, and a seam or a rim that is missed would be of the first: 0.5",
    );
    let mut last: Option<f64> = None;
    for rate in [1, 2, 4, 8] {
        let mut worst: f64 = 0.0;
        for (n, view) in views(count).enumerate() {
            let scene = seen(&scene, view, rate, Borders::Cells);
            let errors = rays(&scene, &waves, &trees[n % 3], |ray, step, left| {
                255.0 * (left - ray.left(0.1, step)).abs()
            })?;
            worst = errors.values.into_iter().fold(worst, f64::max);
        }
        case.outcome(format!("wide, {rate} planes"), worst, None);
        if let Some(last) = last.filter(|_| rate > 2) {
            order.outcome(format!("wide, {rate} planes"), worst / last, Some(0.05));
        }
        last = Some(worst);
    }
    case.note = Some("what is left is the sampling's, and falls with the number of planes".into());
    Ok([case, order])
}

/// The paper's cylinder at twice the resolution on one side.
fn cylinder() -> Result<Case, RenderError> {
    let mut case = Case::new(
        "levels",
        "cylinder of 64 x 64 x 64 voxels, opacity 0.1 at its axis, half of it in voxels twice as long (figure 12)",
        "largest error, steps of 1/255",
        0.0,
        "the integral of each half's extinction over the ray's part of it",
    );
    for seam in crate::borders::seams::errors()? {
        let [whole, levels] = [seam.whole[0], seam.levels[0]];
        let allowed = (seam.planes == 2).then_some(0.15);
        case.outcome(format!("wide, {}, {} planes", seam.name, seam.planes), levels, allowed);
        case.outcome(
            format!("f64, bricks of whole steps, {}, {} planes", seam.name, seam.planes),
            whole,
            None,
        );
    }
    case.study = Some("0.27, 0.60 and 0.37 at one plane; whole steps 50, 37 and 9.6".into());
    case.note = Some(
        "limit: a quarter of the study's largest, 0.60, at twice its planes; at one plane the second view has 0.65"
            .into(),
    );
    Ok(case)
}

/// All of them.
///
/// # Errors
/// [`RenderError`] if a scene cannot be rendered.
pub fn cases(size: Size) -> Result<Vec<Case>, RenderError> {
    let mut cases = vec![cube(size)?];
    cases.extend(waves(size)?);
    if size == Size::Full {
        cases.push(cylinder()?);
    }
    Ok(cases)
}

#[cfg(test)]
mod tests {
    use slicecast_scene::View;

    use super::*;

    /// The measure itself: rays along faces are in one box.
    #[test]
    fn a_volume_that_is_not_cut_has_the_same_lengths() {
        let (cube, [(_, scene), _]) = homogeneous();
        let scene = seen(&scene, View::default(), 2, Borders::Cells);
        let [cut, whole] = [trees().swap_remove(0), Tree::Leaf(0)].map(|tree| {
            rays(&scene, &cube, &tree, |ray, _, _| (ray.length() * 1e6).round() as i64)
                .unwrap()
                .values
        });
        assert_eq!(cut, whole);
        assert!(cut.contains(&8_000_000));
    }
}
