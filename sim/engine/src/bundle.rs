//! Rays of a base plane that another plan folds.

use slicecast::plan::{Plan, Rays};

/// Rays of the base plane that one plan folds, as pixels of its own.
#[derive(Clone, Copy, Debug)]
pub struct Bundle {
    /// The plan.
    pub plan: Plan,
    /// Which rays of the finest level's plan they are.
    pub rays: Rays,
    /// How far apart they are there.
    pub(crate) stride: usize,
}

impl Bundle {
    /// Where the runs of its rows begin in the image of the finest plan.
    fn runs(&self, finest: &Plan, channels: usize) -> impl Iterator<Item = usize> + use<> {
        let [width, height] = finest.base().map(|side| side as usize);
        let Rays { phase, first, count } = self.rays;
        let phase = (phase.v * finest.sampling().rays_per_voxel + phase.u) as usize;
        let (top, left, stride) = (phase * height + first[1] as usize, first[0] as usize, self.stride);
        let rows = (0..count[1] as usize).map(move |row| top + row * stride);
        rows.flat_map(move |row| (0..channels).map(move |channel| (row * channels + channel) * width + left))
    }

    /// Its pixels of an image.
    pub(crate) fn gathered<E: Copy>(&self, finest: &Plan, channels: usize, image: &[E]) -> Vec<E> {
        let across = self.rays.count[0] as usize;
        self.runs(finest, channels)
            .flat_map(|start| image[start..].iter().step_by(self.stride).take(across).copied())
            .collect()
    }

    /// Puts its pixels back.
    pub(crate) fn scatter<E: Copy>(&self, finest: &Plan, channels: usize, image: &mut [E], own: &[E]) {
        let runs = own.chunks_exact(self.rays.count[0] as usize);
        for (start, run) in self.runs(finest, channels).zip(runs) {
            for (to, from) in image[start..].iter_mut().step_by(self.stride).zip(run) {
                *to = *from;
            }
        }
    }
}
