//! What clip planes leave of a ray's segment: the distances of its ends, each from its place alone.

use slicecast::borders::Part;
use slicecast::clip::{ClipPlane, Remainder};
use slicecast::format::Step;
use slicecast::plan::Plan;

/// The distances, or depths, of the ends of the segment that begins so many half steps behind the first slice, of a ray that starts
/// there, from a plane of these slopes.
pub(super) fn ends(slope: [i64; 3], first: i64, plan: &Plan, start: [Step; 2], halves: i64) -> [i64; 2] {
    let [si, sj, sk] = plan.step().map(|step| i128::from(step.to_bits()));
    let [start_i, start_j] = start.map(|start| 2 * i128::from(start.to_bits()));
    [halves, halves + 2].map(|halves| {
        let halves = i128::from(halves);
        // 2^-33 voxel.
        let place = [start_i + halves * si, start_j + halves * sj, halves * sk];
        let term = |axis: usize| (i128::from(slope[axis]) * place[axis]).div_euclid(1 << 33) as i64;
        first + term(0) + term(1) + term(2)
    })
}

/// Of the segment that begins so many half steps behind the first slice, of a ray that starts there.
pub(super) fn left(clips: &[ClipPlane], plan: &Plan, start: [Step; 2], halves: i64, part: Part) -> Remainder {
    let cut = |plane: &ClipPlane| plane.cut(ends(plane.slope, plane.distance, plan, start, halves));
    clips.iter().map(cut).fold(Remainder::WHOLE, Remainder::and).of(part)
}
