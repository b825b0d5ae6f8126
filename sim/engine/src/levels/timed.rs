//! Levels by a budget of time: frames are rendered and timed until one is found that takes no more.
//!
//! How long boxes take depends on what rays find in them: how much is hidden, where rays end, how many lights there are. So nothing is
//! foretold from tables. The coarsest levels are timed first, then the finest, which is done if it keeps to the budget. Else time is taken
//! to be linear in the visible samples ([`Chosen::work`]), through the last two frames that were timed. Small boxes cost more than that, so a
//! choice counts when its own frame has kept to the budget.

use std::time::{Duration, Instant};

use super::budget::{Chosen, Limits, Losses};
use super::tree::Tree;
use super::{Leveled, LevelsError};
use crate::error::RenderError;
use crate::frame::Prepared;
use crate::image::Frame;
use crate::rendering::Progress;
use crate::source::Source;

/// Frames that are timed at most after the coarsest and the finest.
const TRIES: u32 = 5;

/// The share of a budget that a choice aims at: the next frame may take a little longer than the last.
const AIM: f64 = 0.9;

/// A frame that takes this share of the budget is fine enough.
const ENOUGH: f64 = 0.8;

/// A frame that kept to a budget of time.
pub struct Timed {
    /// The frame.
    pub frame: Frame,
    /// Its levels.
    pub chosen: Chosen,
    /// How long it took.
    pub took: Duration,
    /// Frames that were timed, this one with them.
    pub frames: u32,
}

impl Losses {
    /// The finest frame, of those that are tried, that takes no longer than `time`, and within a budget of memory if there is one. Its
    /// time is that of folding and warping, without reading. `progress` is told of each frame anew.
    ///
    /// # Errors
    /// [`LevelsError::Time`] if not even the coarsest levels are fast enough, and as of [`Losses::within`].
    pub fn within_time(
        &self,
        prepared: &Prepared<'_>,
        source: &dyn Source,
        (time, memory): (Duration, Option<u64>),
        progress: Progress<'_>,
    ) -> Result<Timed, RenderError> {
        let frame_of = |tree: &Tree| {
            let leveled = Leveled::new(prepared, tree)?;
            let bricks = leveled.bricks(source, &|_, _| ())?;
            let start = Instant::now();
            let frame = leveled.render(&bricks, progress)?;
            Ok::<_, RenderError>((frame, start.elapsed()))
        };
        let within = |work: f64| {
            let work = Some(work);
            self.within(prepared, source, Limits { memory, work })
        };
        let coarsest = within(0.0)?;
        // The first frame also brings tables and pages to where they are used.
        frame_of(&coarsest.tree)?;
        let (frame, took) = frame_of(&coarsest.tree)?;
        if took > time {
            return Err(LevelsError::Time { time, least: took }.into());
        }
        let budget = time.as_secs_f64();
        let line = Line::through([coarsest.work, took.as_secs_f64()]);
        let mut best = Timed {
            frame,
            chosen: coarsest,
            took,
            frames: 3,
        };
        let finest = within(f64::INFINITY)?;
        let (frame, took) = frame_of(&finest.tree)?;
        let mut line = line.and([finest.work, took.as_secs_f64()]);
        if took <= time {
            return Ok(Timed {
                frame,
                chosen: finest,
                took,
                ..best
            });
        }
        for _ in 0..TRIES {
            if best.took.as_secs_f64() >= ENOUGH * budget {
                break;
            }
            let chosen = within(line.work(AIM * budget))?;
            if [&best.chosen.tree, &finest.tree].contains(&&chosen.tree) {
                break;
            }
            let (frame, took) = frame_of(&chosen.tree)?;
            best.frames += 1;
            line = line.and([chosen.work, took.as_secs_f64()]);
            let finer = chosen.work > best.chosen.work;
            if took <= time && finer {
                best = Timed {
                    frame,
                    chosen,
                    took,
                    ..best
                };
            }
        }
        Ok(best)
    }
}

/// Seconds as a linear function of visible samples.
#[derive(Clone, Copy, Debug)]
struct Line {
    last: [f64; 2],
    /// Seconds per sample.
    slope: f64,
}

impl Line {
    /// Through no time at no sample and one that was measured.
    fn through(last: [f64; 2]) -> Self {
        let [work, time] = last;
        Self {
            last,
            slope: time / work.max(1.0),
        }
    }

    /// Through the last one and another; with its slope alone where both are about the same.
    fn and(self, other: [f64; 2]) -> Self {
        let [work, time] = [0, 1].map(|at| other[at] - self.last[at]);
        let slope = time / work;
        let apart = work.abs() > 0.02 * other[0].max(1.0);
        Self {
            last: other,
            slope: if apart && slope > 0.0 { slope } else { self.slope },
        }
    }

    fn work(self, time: f64) -> f64 {
        let [last, taken] = self.last;
        (last + (time - taken) / self.slope.max(f64::MIN_POSITIVE)).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::Line;

    #[test]
    fn a_line_foretells_what_is_linear() {
        let measured = |work: f64| [work, 0.5 + 3e-9 * work];
        let line = Line::through(measured(1e8));
        assert!((line.work(0.8) - 1e8).abs() < 1.0);
        let line = line.and(measured(4e8));
        assert!((line.work(3.5) - 1e9).abs() < 1.0);
        // The same work again says nothing of the slope.
        let line = line.and([4e8, 1.9]);
        assert!((line.slope - 3e-9).abs() < 1e-15 && line.work(1.9) == 4e8);
        assert_eq!(line.work(0.0), 0.0);
    }
}
