//! What clip planes leave of a ray's segment: the distances of its ends, each from its place alone.

use slicecast::borders::Part;
use slicecast::clip::{ClipPlane, Remainder};
use slicecast::format::Step;
use slicecast::plan::Plan;

/// Of the segment that begins so many half steps behind the first slice, of a ray that starts there.
pub(super) fn left(clips: &[ClipPlane], plan: &Plan, start: [Step; 2], halves: i64, part: Part) -> Remainder {
    let [si, sj, sk] = plan.step().map(|step| i128::from(step.to_bits()));
    let [start_i, start_j] = start.map(|start| 2 * i128::from(start.to_bits()));
    let mut left = Remainder::WHOLE;
    for plane in clips {
        let ends = [halves, halves + 2].map(|halves| {
            let halves = i128::from(halves);
            // 2^-33 voxel.
            let place = [start_i + halves * si, start_j + halves * sj, halves * sk];
            let term = |axis: usize| (i128::from(plane.slope[axis]) * place[axis]).div_euclid(1 << 33) as i64;
            plane.distance + term(0) + term(1) + term(2)
        });
        left = left.and(plane.cut(ends));
    }
    left.of(part)
}
