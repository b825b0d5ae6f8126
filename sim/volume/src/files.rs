//! A volume in many data files, each of which holds a slab of it.
//!
//! NRRD and MetaImage name such files in a list or by a pattern (`slice%03d.raw 1 16 1`). Every name is held to the
//! header's folder, every file to the length of its slab.

use std::io::BufRead;
use std::path::Path;

use super::companion;
use super::error::{Problem, ReadError};
use super::file::open_regular;
use super::payload::{Layout, read_values};
use super::values::{Values, voxel_count};

/// Data files that a header may name.
const MAX_FILES: usize = 65536;

/// Where a header's data are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Data {
    /// After the header.
    Attached,
    /// In a file.
    File(String),
    /// In many files.
    Files(DataFiles),
}

/// Whether the name of a data file announces a list of names.
pub(super) fn is_list(data_file: &str) -> bool {
    data_file.split_ascii_whitespace().next() == Some("LIST")
}

impl Data {
    /// The data of a name that is not the format's word for attached data: `LIST AXES`, followed by the names `listed`,
    /// `PATTERN FIRST LAST STEP AXES` or one file. The step may be missing (1), and so may the axes (2: files are slices).
    ///
    /// # Errors
    /// What was expected.
    pub fn named(text: &str, listed: &[String]) -> Result<Self, &'static str> {
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        let axes = |word: Option<&&str>| {
            let number = word.map_or(Ok(2), |word| word.trim_end_matches(['D', 'd']).parse());
            number.map_err(|_| "a number of axes, 1 to 3, at the end")
        };
        match &words[..] {
            ["LIST", more @ ..] => Ok(Self::Files(DataFiles {
                names: listed.to_vec(),
                axes: axes(more.first())?,
            })),
            [pattern, first, last, more @ ..] if pattern.contains('%') => {
                let number = |word: &str| word.parse::<i64>().map_err(|_| "PATTERN FIRST LAST STEP");
                let step = more.first().map_or(Ok(1), |word| number(word))?;
                Ok(Self::Files(DataFiles {
                    names: expand(pattern, [number(first)?, number(last)?, step])?,
                    axes: axes(more.get(1))?,
                }))
            }
            _ => Ok(Self::File(text.to_owned())),
        }
    }
}

/// The files of a volume, in its order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct DataFiles {
    /// Their names.
    pub names: Vec<String>,
    /// How many axes, from x on, a file has: 2 for slices.
    pub axes: usize,
}

/// The names that a pattern with one `%d` makes of the numbers from `first` to `last`.
///
/// # Errors
/// What was expected, if the pattern or the numbers are not usable.
fn expand(pattern: &str, [first, last, step]: [i64; 3]) -> Result<Vec<String>, &'static str> {
    let pieces = Pattern::parse(pattern).ok_or("one `%d`, `%i` or `%u` with at most a width, such as `%03d`")?;
    let towards = i128::from(last) - i128::from(first);
    let step_wide = i128::from(step);
    if step == 0 || (towards != 0 && towards.signum() != step_wide.signum()) {
        return Err("a step that leads from the first number to the last");
    }
    let count = towards / step_wide + 1;
    if count > MAX_FILES as i128 {
        return Err("at most 65536 files");
    }
    // Within first and last, so that nothing overflows.
    Ok((0..count as i64).map(|i| pieces.name(first + i * step)).collect())
}

/// A pattern cut at its number.
struct Pattern {
    before: String,
    after: String,
    zeros: bool,
    width: usize,
}

impl Pattern {
    fn parse(pattern: &str) -> Option<Self> {
        let (before, rest) = pattern.split_once('%')?;
        let end = rest.find(|c: char| !c.is_ascii_digit())?;
        let (width, rest) = rest.split_at(end);
        let after = rest.strip_prefix(['d', 'i', 'u'])?;
        let width_number = if width.is_empty() { 0 } else { width.parse().ok()? };
        (width_number <= 20 && !after.contains('%')).then(|| Self {
            before: before.to_owned(),
            after: after.to_owned(),
            zeros: width.starts_with('0'),
            width: width_number,
        })
    }

    fn name(&self, number: i64) -> String {
        let (before, after, width) = (&self.before, &self.after, self.width);
        if self.zeros {
            format!("{before}{number:0width$}{after}")
        } else {
            format!("{before}{number:width$}{after}")
        }
    }
}

impl DataFiles {
    /// The shape of one file's slab.
    ///
    /// # Errors
    /// [`Problem::Format`] says how many files were expected.
    pub fn slab(&self, dims: [u64; 3]) -> Result<[u64; 3], Problem> {
        self.divided(dims).map_err(|expected| {
            let found = self.names.len();
            Problem::format(
                "data in many files",
                format!("{found} files are named, expected {expected}"),
            )
        })
    }

    /// The shape of one file's slab; `Err` says how many files were expected.
    fn divided(&self, [x, y, z]: [u64; 3]) -> Result<[u64; 3], String> {
        let count = self.names.len() as u64;
        match self.axes {
            1 if count == y * z => Ok([x, 1, 1]),
            1 => Err(format!("{} rows", y * z)),
            2 if count == z => Ok([x, y, 1]),
            2 => Err(format!("{z} slices")),
            3 if count > 0 && z.is_multiple_of(count) => Ok([x, y, z / count]),
            3 => Err(format!("a divisor of {z} slices")),
            _ => Err("files of 1 to 3 axes".into()),
        }
    }

    /// Reads the files as parts of the volume that `whole` describes; `layout_of` may adapt it to a file's first bytes.
    ///
    /// # Errors
    /// [`ReadError`] names the header, or the file at fault.
    pub fn read(
        &self,
        header: &Path,
        whole: &Layout,
        layout_of: impl Fn(Layout, &[u8]) -> Layout,
        notes: &mut Vec<String>,
    ) -> Result<Values, ReadError> {
        let at_header = |problem| ReadError::new(header, problem);
        voxel_count(whole.dims).map_err(|error| ReadError::new(header, error))?;
        whole.check_memory().map_err(at_header)?;
        let dims = self.slab(whole.dims).map_err(at_header)?;
        let mut all: Option<Values> = None;
        let mut file_notes = Vec::new();
        for name in &self.names {
            let path = companion::data_file(header, name)?;
            let fail = |problem| ReadError::new(&path, problem);
            let (mut source, len) = open_regular(&path)?;
            let start = source.fill_buf().map_err(Problem::io("read the file")).map_err(fail)?;
            let layout = layout_of(Layout { dims, ..*whole }, start);
            let part = read_values(&layout, &mut source, len, &mut file_notes).map_err(fail)?;
            all = Some(match all {
                None => part,
                Some(values) => joined(values, &part).map_err(fail)?,
            });
        }
        // One file's note stands for all of its kind.
        file_notes.dedup();
        notes.append(&mut file_notes);
        notes.push(format!("the data are in {} files", self.names.len()));
        all.ok_or_else(|| at_header(Problem::NoData))
    }
}

/// Both parts in one type: 64-bit integers may have been narrowed differently.
fn joined(mut values: Values, part: &Values) -> Result<Values, Problem> {
    if !values.append(part)? {
        values = values.rescaled(1.0, 0.0)?;
        values.append(&part.rescaled(1.0, 0.0)?)?;
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_make_names() {
        assert_eq!(
            expand("s%03d.raw", [9, 11, 1]).unwrap(),
            ["s009.raw", "s010.raw", "s011.raw"]
        );
        assert_eq!(expand("%d", [4, 0, -2]).unwrap(), ["4", "2", "0"]);
        assert_eq!(expand("a%2i", [7, 7, 1]).unwrap(), ["a 7"]);
        for (pattern, numbers) in [
            ("s.raw", [0, 1, 1]),
            ("%s", [0, 1, 1]),
            ("%d%d", [0, 1, 1]),
            ("%021d", [0, 1, 1]),
            ("%99999999999999999999d", [0, 1, 1]),
            ("%", [0, 1, 1]),
            ("%d", [0, 1, 0]),
            ("%d", [0, 1, -1]),
            ("%d", [0, 65536, 1]),
            ("%d", [i64::MIN, i64::MAX, 1]),
        ] {
            assert!(expand(pattern, numbers).is_err(), "{pattern} {numbers:?}");
        }
    }

    #[test]
    fn files_have_to_make_up_the_volume() {
        let files = |count: usize, axes| DataFiles {
            names: vec!["n".into(); count],
            axes,
        };
        assert_eq!(files(4, 2).divided([2, 3, 4]), Ok([2, 3, 1]));
        assert_eq!(files(2, 3).divided([2, 3, 4]), Ok([2, 3, 2]));
        assert_eq!(files(12, 1).divided([2, 3, 4]), Ok([2, 1, 1]));
        assert_eq!(files(3, 2).divided([2, 3, 4]), Err("4 slices".into()));
        assert_eq!(files(3, 3).divided([2, 3, 4]), Err("a divisor of 4 slices".into()));
        assert!(files(0, 3).divided([2, 3, 4]).is_err());
    }
}
