//! Which volume is wanted of a file or folder that holds several.

/// What the user chooses among several volumes; the default takes no part of a volume away.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Choice {
    /// Which of several DICOM series.
    pub series: Series,
    /// Which phase, from 1, of a DICOM series that holds its slices several times over. Without it, such a series is
    /// refused.
    pub phase: Option<usize>,
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
