//! Levels by a budget of time: frames are rendered and timed until one is found that takes no more.
//!
//! How long boxes take depends on what rays find in them: how much is hidden, where rays end, how many lights there are. So nothing is
//! foretold from tables. The coarsest levels are timed first, then the finest, which is done if it keeps to the budget. Else time is taken
//! to be linear in the visible samples ([`Chosen::work`]), through the last two frames that were timed. Small boxes cost more than that, so a
//! choice counts when its own frame has kept to the budget.

use std::time::{Duration, Instant};

use super::Leveled;
use super::budget::{Chosen, Limits, Losses};
use super::tree::Tree;
use crate::error::LevelsError;
use crate::error::RenderError;
use crate::frame::Prepared;
use crate::image::Frame;
use crate::progress::Progress;
use crate::source::Source;

/// Frames that are timed at most after the coarsest and the finest.
const TRIES: u32 = 5;

/// The share of a budget that a choice aims at: the next frame may take a little longer than the last.
const AIM: f64 = 0.9;

/// A frame that takes this share of the budget is fine enough.
const ENOUGH: f64 = 0.8;

/// A frame that kept to a budget of time.
pub struct Timed<F = Frame> {
    /// The frame.
    pub frame: F,
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
    /// [`LevelsError::Time`] if not even the coarsest levels are fast enough, and as of [`Ordered::within`](super::budget::Ordered::within).
    pub fn within_time(
        &self,
        prepared: &Prepared<'_>,
        source: &dyn Source,
        (time, memory): (Duration, Option<u64>),
        progress: Progress<'_>,
    ) -> Result<Timed, RenderError> {
        let ordered = self.ordered(prepared, source, true)?;
        let within = |work: f64| {
            let work = Some(work);
            ordered.within(Limits { memory, work })
        };
        search(time, &within, &mut |tree| {
            let leveled = Leveled::new(prepared, tree)?;
            let bricks = leveled.bricks(source, &|_, _| ())?;
            let start = Instant::now();
            let frame = leveled.render(&bricks, progress)?;
            Ok((frame, start.elapsed()))
        })
    }
}

/// A frame, and how long it took.
type Taken<F> = Result<(F, Duration), RenderError>;

/// The search, given the finest levels of so much work at most, and how frames are made and timed.
fn search<F>(
    time: Duration,
    within: &dyn Fn(f64) -> Result<Chosen, LevelsError>,
    frame_of: &mut dyn FnMut(&Tree) -> Taken<F>,
) -> Result<Timed<F>, RenderError> {
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
    use super::*;

    /// Levels of 0 to 100 hundredths of the finest work, each with a tree of its own.
    fn levels(work: f64) -> Result<Chosen, LevelsError> {
        let level = (work / 1e7).clamp(0.0, 100.0) as u32;
        Ok(Chosen {
            tree: Tree::Leaf(level),
            bricks: [0; 4],
            boxes: 1,
            bytes: 0,
            all: 0,
            work: 1e7 * f64::from(level.max(12)),
            loss: 0.0,
        })
    }

    /// Searches on a machine whose frames take so many milliseconds by their level; how many frames it made.
    fn searched(budget: u64, time: impl Fn(f64) -> f64) -> (Result<Timed<u32>, RenderError>, u32) {
        let mut made = 0;
        let found = search(Duration::from_millis(budget), &levels, &mut |tree| {
            made += 1;
            let Tree::Leaf(level) = tree else { unreachable!() };
            let took = Duration::from_secs_f64(time(f64::from(*level)) / 1000.0);
            Ok((*level, took))
        });
        (found, made)
    }

    #[test]
    fn what_is_found_has_kept_to_the_budget() {
        // Linear; with a price of mixtures; and one that grows faster than the samples.
        let machines: [fn(f64) -> f64; 3] = [
            |level| 20.0 + 2.0 * level,
            |level| 20.0 + 2.0 * level + if (1.0..100.0).contains(&level) { 40.0 } else { 0.0 },
            |level| 20.0 + level * level / 50.0,
        ];
        for (number, machine) in machines.into_iter().enumerate() {
            for budget in [25, 60, 100, 150, 200, 219, 220, 1000] {
                let (found, made) = searched(budget, machine);
                let found = found.unwrap();
                let level = f64::from(found.frame);
                assert!(
                    found.took.as_secs_f64() * 1000.0 <= budget as f64 + 1e-6,
                    "{number} {budget}"
                );
                assert!((found.took.as_secs_f64() * 1000.0 - machine(level)).abs() < 1e-6);
                assert_eq!((found.frames, found.frames <= 3 + TRIES), (made, true));
                if machine(100.0) <= budget as f64 {
                    assert_eq!((level, made), (100.0, 3), "{number} {budget}");
                } else if number == 0 && budget > 60 {
                    // Where time is linear, all but what the aim leaves is used.
                    assert!(machine(level) > ENOUGH * budget as f64, "{budget}: {level}");
                }
            }
            let (refused, made) = searched(19, machine);
            let Err(RenderError::Levels(LevelsError::Time { least, .. })) = refused else {
                panic!("19 ms are enough");
            };
            assert_eq!((least, made), (Duration::from_millis(20), 2));
        }
    }

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
