//! The report: one HTML page that needs nothing else, no network and no other file.
//!
//! | file | what it holds |
//! |---|---|
//! | `page` | the page's parts, in order |
//! | `plots` | SVG: bits of every stage, speed against error |
//! | `picture` | pictures as data inside the page |
//! | `machine` | what it was run on |
//! | `page.css`, `page.js` | light, dark and print; the slider that compares two pictures |

pub mod machine;
pub mod page;
mod picture;
pub(crate) mod plots;

use crate::hard::Case;
use crate::rows::Row;
use slicecast_compare::{Comparison, Split};
use slicecast_engine::frame::Prepared;

/// What a report shows.
pub struct Contents<'a> {
    /// Volume and scene.
    pub prepared: &'a Prepared<'a>,
    /// Name of the scene, as it was asked for.
    pub scene_name: &'a str,
    /// How values became codes.
    pub mapping: String,
    /// The named precisions beside the model, by name.
    pub comparisons: Vec<(&'static str, Comparison)>,
    /// Which of them the pictures are of.
    pub shown: usize,
    /// Its error, split.
    pub split: Option<Split>,
    /// The configurations of a sweep; may be empty.
    pub rows: Vec<Row>,
    /// The hard cases; may be empty.
    pub cases: Vec<Case>,
}
