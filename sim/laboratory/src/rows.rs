//! The file of finished rows: a sweep that is stopped goes on where it was, and the rows of several machines make one
//! table.
//!
//! JSON lines: a head that says what the file is, then one row a line, each with the key of its inputs. A last line
//! that was cut off while it was written counts as not there.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::parameters::Parameter;
use slicecast_compare::image::ImageFigures;

/// Errors of a stage, as a sweep keeps them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageRow {
    /// The stage.
    pub name: String,
    /// Its format.
    pub format: String,
    /// Largest error on the stage's own inputs, ulp; then the mean.
    pub local_max_ulp: f64,
    /// See [`StageRow::local_max_ulp`].
    pub local_mean_ulp: f64,
    /// Bits that every value has right; `None` if there is no error.
    pub local_bits: Option<f64>,
    /// Largest error against the model from the beginning, ulp; then the mean.
    pub carried_max_ulp: f64,
    /// See [`StageRow::carried_max_ulp`].
    pub carried_mean_ulp: f64,
}

/// What a sweep found about one configuration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// What was rendered: volume, scene and version of the program, as a checksum.
    pub key: String,
    /// Place in the catalogue.
    pub index: usize,
    /// The configuration.
    pub name: String,
    /// What it is made of.
    pub parameters: Vec<Parameter>,
    /// Bytes of a pixel.
    pub pixel_bytes: usize,
    /// Bytes of the table.
    pub table_bytes: usize,
    /// Errors of the base-plane images of all views together.
    pub image: ImageFigures,
    /// The same of each view; the first is the scene's own.
    pub views: Vec<ImageFigures>,
    /// Errors of every stage, all views together.
    pub stages: Vec<StageRow>,
    /// Samples a second.
    pub samples_per_second: f64,
    /// Speed over that of the base configuration, measured in turns with it: the median of the rounds' ratios.
    pub relative_speed: f64,
    /// How far that ratio scatters over the rounds: half the distance between its quartiles, as a share of the median;
    /// `None` of fewer than four rounds.
    pub speed_spread: Option<f64>,
    /// Frames of which the fastest counts.
    pub rounds: u32,
    /// Threads that rendered them.
    pub threads: usize,
    /// Vectors that rendered them: `scalar` is one lane, `avx2` eight, `avx512` sixteen.
    pub lanes: String,
}

impl Row {
    /// Mean error of each view, steps of 1/255.
    pub fn errors(&self) -> Vec<f64> {
        self.views.iter().map(|view| view.mean_lsb8).collect()
    }
}

/// Why rows cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum RowsError {
    /// The file cannot be read or written.
    #[error("{path}: {error}")]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        error: io::Error,
    },
    /// Something else is in the file.
    #[error("{path}: is no file of sweep rows, expected one that `slicecast sweep --rows` has written")]
    Foreign {
        /// The file.
        path: PathBuf,
    },
    /// The file is another version's.
    #[error("{path}: holds sweep rows of version {found}, expected version {VERSION}: run the sweep again")]
    Version {
        /// The file.
        path: PathBuf,
        /// The version of its rows.
        found: u32,
    },
    /// A row that cannot be read.
    #[error("{path}: line {line}: {problem}")]
    Row {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong.
        problem: String,
    },
}

/// The version of rows that this program writes.
const VERSION: u32 = 3;

/// The first line.
#[derive(Serialize, Deserialize)]
struct Head {
    slicecast: String,
    version: u32,
}

impl Head {
    fn own() -> Self {
        Self {
            slicecast: "sweep rows".into(),
            version: VERSION,
        }
    }
}

/// What a file of rows holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// The rows, all inputs.
    pub rows: Vec<Row>,
    /// Bytes behind the last whole line: a row that was cut off.
    pub cut_off: u64,
    /// Bytes up to there.
    whole: u64,
}

/// The rows of a file; `None` if it does not exist or is empty.
///
/// # Errors
/// [`RowsError`].
pub fn read(path: &Path) -> Result<Option<Found>, RowsError> {
    let text = match fs::read(path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => {
            return Err(RowsError::File {
                path: path.into(),
                error,
            });
        }
    };
    if text.is_empty() {
        return Ok(None);
    }
    let whole = text.iter().rposition(|b| *b == b'\n').map_or(0, |at| at + 1);
    let mut lines = text[..whole].split(|b| *b == b'\n');
    let path = || path.to_owned();
    match lines.next().and_then(|line| serde_json::from_slice::<Head>(line).ok()) {
        Some(head) if head.slicecast != Head::own().slicecast => return Err(RowsError::Foreign { path: path() }),
        None => return Err(RowsError::Foreign { path: path() }),
        Some(Head { version: found, .. }) if found != VERSION => {
            return Err(RowsError::Version { path: path(), found });
        }
        Some(_) => {}
    }
    let mut rows = Vec::new();
    for (number, line) in (2..).zip(lines).filter(|(_, line)| !line.is_empty()) {
        rows.push(serde_json::from_slice(line).map_err(|error| RowsError::Row {
            path: path(),
            line: number,
            problem: error.to_string(),
        })?);
    }
    Ok(Some(Found {
        rows,
        cut_off: (text.len() - whole) as u64,
        whole: whole as u64,
    }))
}

/// A file that rows are added to.
pub struct Writer {
    path: PathBuf,
    file: File,
}

impl Writer {
    /// Opens a file of rows, or makes one, and says what is in it. A file of something else is left alone.
    ///
    /// # Errors
    /// [`RowsError`].
    pub fn open(path: &Path) -> Result<(Self, Vec<Row>), RowsError> {
        let failed = |error| RowsError::File {
            path: path.to_owned(),
            error,
        };
        let found = read(path)?;
        let mut file = OpenOptions::new()
            .create(true)
            .append(true)
            .open(path)
            .map_err(failed)?;
        let rows = match found {
            Some(Found { rows, whole, .. }) => {
                // What was cut off in the middle of a line.
                file.set_len(whole).map_err(failed)?;
                rows
            }
            None => {
                let head = serde_json::to_string(&Head::own()).map_err(|error| failed(error.into()))?;
                writeln!(file, "{head}").map_err(failed)?;
                Vec::new()
            }
        };
        let path = path.to_owned();
        Ok((Self { path, file }, rows))
    }

    /// Adds rows.
    ///
    /// # Errors
    /// [`RowsError::File`].
    pub fn add(&mut self, rows: &[Row]) -> Result<(), RowsError> {
        let mut text = Vec::new();
        let filled = rows.iter().try_for_each(|row| {
            serde_json::to_writer(&mut text, row)?;
            writeln!(text)
        });
        filled
            .and_then(|()| self.file.write_all(&text))
            .and_then(|()| self.file.sync_data())
            .map_err(|error| RowsError::File {
                path: self.path.clone(),
                error,
            })
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::super::parameters::Name;
    use super::*;

    pub fn row(name: &str, index: usize, error: f64, speed: f64) -> Row {
        let image = ImageFigures {
            values: 3,
            max_lsb8: 2.0 * error,
            mean_lsb8: error,
            equal_percent: 99.0,
            psnr_db: None,
        };
        Row {
            key: "k".into(),
            index,
            name: name.into(),
            parameters: vec![(Name::WeightBits, "12".into())],
            pixel_bytes: 8,
            table_bytes: 16384,
            image,
            views: vec![image],
            stages: Vec::new(),
            samples_per_second: 1e8 * speed,
            relative_speed: speed,
            speed_spread: None,
            rounds: 3,
            threads: 1,
            lanes: "scalar".into(),
        }
    }

    #[test]
    fn rows_come_back_and_a_cut_line_does_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows.jsonl");
        assert!(read(&path).unwrap().is_none());
        let (mut writer, found) = Writer::open(&path).unwrap();
        assert!(found.is_empty());
        // A figure that has no short decimal form comes back to the last bit.
        let rows = [row("a", 0, 0.1 + 0.2, 1.0), row("b", 1, 1.0 / 3.0, 0.7)];
        writer.add(&rows).unwrap();
        drop(writer);
        assert_eq!(read(&path).unwrap().unwrap().rows, rows);
        let bytes = fs::read(&path).unwrap();
        fs::write(&path, &bytes[..bytes.len() - 5]).unwrap();
        assert!(read(&path).unwrap().unwrap().cut_off > 100);
        let (mut writer, found) = Writer::open(&path).unwrap();
        assert_eq!(found, rows[..1]);
        writer.add(&rows[1..]).unwrap();
        assert_eq!(fs::read(&path).unwrap(), bytes);
    }

    #[test]
    fn files_of_others_are_refused_and_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mine.txt");
        for text in [
            "my notes",
            "my notes\n",
            "{\"slicecast\":\"sweep rows\",\"version\":",
            "{\"slicecast\":\"something else\",\"version\":2}\n",
        ] {
            fs::write(&path, text).unwrap();
            assert!(matches!(Writer::open(&path), Err(RowsError::Foreign { .. })), "{text}");
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
        }
        fs::write(&path, "{\"slicecast\":\"sweep rows\",\"version\":1}\n{}\n").unwrap();
        assert!(matches!(read(&path), Err(RowsError::Version { found: 1, .. })));
        fs::write(&path, "{\"slicecast\":\"sweep rows\",\"version\":3}\n{}\n").unwrap();
        assert!(matches!(read(&path), Err(RowsError::Row { line: 2, .. })));
    }
}
