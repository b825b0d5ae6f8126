//! What a user chooses where a file holds more than one volume, or values that are no numbers.

use super::error::Problem;

/// The part of a file that becomes the volume. Everything counts from 1.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Choice {
    /// Which of several DICOM series.
    pub series: Series,
    /// Which phase of a DICOM series that holds its slices several times over; without it such a series is refused.
    pub phase: Option<usize>,
    /// Which of several channels; without it the first, with a note.
    pub channel: Option<usize>,
    /// Which of several time points; without it the first, with a note.
    pub time: Option<usize>,
    /// What becomes of NaN.
    pub nan: NanRule,
}

/// Which of several DICOM series is wanted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Series {
    /// The one with the most slices.
    #[default]
    Largest,
    /// The one whose number or UID this is.
    Named(String),
}

/// What becomes of voxels that are NaN.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NanRule {
    /// The volume is refused.
    #[default]
    Refuse,
    /// They take the least value of the volume, and are counted.
    Background,
}

impl Choice {
    /// Refuses a channel or time point beyond the first of a file that has one of each.
    pub(super) fn check_single(&self) -> Result<(), Problem> {
        one_of("channel", self.channel, 1)?;
        one_of("time point", self.time, 1)?;
        Ok(())
    }
}

/// The index, from 0, of the chosen one of `count`; the first without a choice.
pub(super) fn one_of(what: &'static str, asked: Option<usize>, count: usize) -> Result<usize, Problem> {
    match asked.unwrap_or(1) {
        asked if (1..=count).contains(&asked) => Ok(asked - 1),
        asked => Err(Problem::Choice { what, asked, count }),
    }
}
