//! Which pages of a file are the slices of one channel at one time point.

use super::NAME;
use crate::choice::{Choice, one_of};
use crate::error::Problem;

/// Channels, slices and time points of a file, and the page of each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Planes {
    /// How many channels, slices and time points.
    pub counts: [usize; 3],
    /// What varies from page to page, the fastest first: 0, 1, 2 for channel, slice, time point.
    pub order: [usize; 3],
    /// The page of each plane in that order, where the file does not keep to it.
    pub pages: Option<Vec<usize>>,
}

/// Planes that a file may state.
pub(super) const PLANES_MAX: usize = 1 << 20;

impl Planes {
    /// The order of ImageJ: channels, then slices, then time points.
    pub const CHANNELS_FIRST: [usize; 3] = [0, 1, 2];

    /// Planes in all.
    pub fn total(&self) -> usize {
        self.counts.iter().fold(1, |all, &count| all.saturating_mul(count))
    }

    /// Refuses counts that no file bears out, before anything is made of them.
    pub fn check(&self) -> Result<(), Problem> {
        match self.total() {
            total if total <= PLANES_MAX => Ok(()),
            total => {
                let fault = format!("the description states {total} images, expected at most {PLANES_MAX}");
                Err(Problem::format(NAME, fault))
            }
        }
    }

    /// The pages of the chosen channel and time point, slice after slice; what was chosen is noted.
    ///
    /// # Errors
    /// [`Problem::Choice`] if the file does not have the one chosen.
    pub fn slices(&self, choice: &Choice, notes: &mut Vec<String>) -> Result<Vec<usize>, Problem> {
        let [channels, slices, times] = self.counts;
        let channel = one_of("channel", choice.channel, channels)?;
        if channels > 1 {
            notes.push(format!(
                "channel {} of {channels}; `--channel N` chooses another",
                channel + 1
            ));
        }
        // A stack whose slices were mistaken for time points is as common as a film of one slice.
        if slices == 1 && times > 1 && choice.time.is_none() {
            notes.push(format!(
                "{times} time points of one slice are taken as slices; `--time N` chooses one"
            ));
            return (0..times).map(|time| self.page([channel, 0, time])).collect();
        }
        let time = one_of("time point", choice.time, times)?;
        if times > 1 {
            notes.push(format!(
                "time point {} of {times}; `--time N` chooses another",
                time + 1
            ));
        }
        (0..slices).map(|slice| self.page([channel, slice, time])).collect()
    }

    fn page(&self, at: [usize; 3]) -> Result<usize, Problem> {
        let plane = self
            .order
            .iter()
            .rev()
            .fold(0, |plane, &axis| plane * self.counts[axis] + at[axis]);
        match &self.pages {
            None => Ok(plane),
            Some(pages) => pages
                .get(plane)
                .copied()
                .ok_or_else(|| Problem::format(NAME, format!("has no page for plane {plane}"))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn choose(channel: usize, time: usize) -> Choice {
        Choice {
            channel: Some(channel),
            time: Some(time),
            ..Choice::default()
        }
    }

    #[test]
    fn pages_follow_the_stated_order() {
        let mut planes = Planes {
            counts: [2, 3, 2],
            order: Planes::CHANNELS_FIRST,
            pages: None,
        };
        let mut notes = Vec::new();
        assert_eq!(planes.slices(&Choice::default(), &mut notes).unwrap(), [0, 2, 4]);
        assert_eq!(
            notes,
            [
                "channel 1 of 2; `--channel N` chooses another",
                "time point 1 of 2; `--time N` chooses another"
            ]
        );
        assert_eq!(planes.slices(&choose(2, 2), &mut notes).unwrap(), [7, 9, 11]);
        // Slices first, then time, then channels.
        planes.order = [1, 2, 0];
        assert_eq!(planes.slices(&choose(2, 2), &mut notes).unwrap(), [9, 10, 11]);
        planes.pages = Some((0..12).rev().collect());
        assert_eq!(planes.slices(&choose(2, 2), &mut notes).unwrap(), [2, 1, 0]);
        let error = planes.slices(&choose(3, 1), &mut notes).unwrap_err().to_string();
        assert_eq!(error, "has 2 channels, expected one of them: channel 3 was asked for");
        assert!(planes.slices(&choose(0, 1), &mut notes).is_err());
        assert!(planes.slices(&choose(1, 3), &mut notes).is_err());
    }

    #[test]
    fn a_film_of_one_slice_is_a_stack_unless_a_time_is_chosen() {
        let planes = Planes {
            counts: [1, 1, 4],
            order: Planes::CHANNELS_FIRST,
            pages: None,
        };
        let mut notes = Vec::new();
        assert_eq!(planes.slices(&Choice::default(), &mut notes).unwrap(), [0, 1, 2, 3]);
        assert!(notes[0].contains("taken as slices"));
        assert_eq!(planes.slices(&choose(1, 3), &mut notes).unwrap(), [2]);
    }
}
