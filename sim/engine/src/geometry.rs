//! The geometry of a frame.

use slicecast::clip::Clips;
use slicecast::plan::Plan;

/// The geometry of a frame, and what clip planes leave of it.
#[derive(Clone, Copy, Debug)]
pub struct Geometry<'a> {
    /// The plan.
    pub plan: &'a Plan,
    /// Clip planes, made for the plan's view and volume.
    pub clips: Option<&'a Clips>,
}
