//! What of a row is worth its work: spans of visible samples on rays that are not finished.

use core::ops::Range;

use super::meeting::Meeting;
use crate::composite::{Channel, Order};
use crate::lanes::Lanes;
use crate::rows::part;

/// Whether any of the `V::COUNT` samples at `at` is visible.
#[inline(always)]
fn any_visible<O: Order, C: Channel, V: Lanes>(opacities: &[i32], transparencies: &[C], at: usize) -> bool {
    let opacity = V::load(opacities, at);
    let visible = if O::BACK_TO_FRONT {
        opacity
    } else {
        V::load_as(transparencies, at, C::bits).nonzero_then(opacity)
    };
    !visible.all_zero()
}

/// The next span of visible samples at or after `from`, in whole lanes: an invisible sample among them changes nothing.
#[inline(always)]
pub(super) fn visible_span<O: Order, C: Channel, V: Lanes>(
    opacities: &[i32],
    transparencies: &[C],
    from: usize,
) -> Option<Range<usize>> {
    let transparencies = transparencies.get(..opacities.len())?;
    let mut start = from;
    while start < opacities.len() && !any_visible::<O, C, V>(opacities, transparencies, start) {
        start += V::COUNT;
    }
    let mut end = start;
    while end < opacities.len() && any_visible::<O, C, V>(opacities, transparencies, end) {
        end += V::COUNT;
    }
    (start < end).then_some(start..end.min(opacities.len()))
}

/// Whether all rays of a row are finished.
#[inline(always)]
fn all_finished<C: Channel, V: Lanes>(transparencies: &[C]) -> bool {
    for at in (0..transparencies.len()).step_by(V::COUNT) {
        if !V::load_as(transparencies, at, C::bits).all_zero() {
            return false;
        }
    }
    true
}

/// Those of some blocks in which a ray is not finished.
#[inline(always)]
pub(super) fn unfinished<C: Channel, V: Lanes>(meeting: &Meeting, blocks: u64, transparencies: &[C]) -> u64 {
    let (mut left, mut kept) = (blocks, 0);
    while left != 0 {
        let block = left.trailing_zeros();
        let bit = left & left.wrapping_neg();
        left ^= bit;
        if !all_finished::<C, V>(part(transparencies, meeting.samples(block..block + 1))) {
            kept |= bit;
        }
    }
    kept
}
