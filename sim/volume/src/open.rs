//! Which reader a file or folder is for: by its first bytes, then by its name.

use std::fs::{self};
use std::io::BufRead;
use std::path::Path;

use super::choice::Choice;
use super::colours::Colours;
use super::decoded::Decoded;
use super::decoded::Orientation;
use super::error::{Problem, ReadError};
use super::file::open_regular;
use super::mapping::{Labels, Mapped, MappingError, MappingReport, Window, map};
use super::meaning::Modality;
use super::placed::Placed;
use super::statistics::Statistics;
use super::{Volume, dicom, metaimage, nifti, nrrd, raw, tiff, zarr};

/// The CT head that comes with the program, 64 x 64 x 93 voxels (see `sim/volume/data/LICENSE-headsq.txt`).
const BUILT_IN: &[u8] = include_bytes!("../data/headsq-quarter.nrrd");

/// What [`load`] and [`prepare`] can fail with.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The file cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// Its values cannot be mapped to 12 bits as asked.
    #[error("{name}: {error}")]
    Mapping {
        /// Where the volume came from.
        name: String,
        /// What is wrong.
        error: MappingError,
    },
}

/// What a user may state about a volume beside its path.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Which of several volumes, and what becomes of NaN.
    pub choice: Choice,
    /// The file is raw data of this shape, whatever it looks like.
    pub raw: Option<raw::describe::Description>,
}

/// Reads a volume of any known format: a file, a folder of slices or a store.
///
/// # Errors
/// As [`read_with`].
pub fn read(path: &Path) -> Result<Decoded, ReadError> {
    read_with(path, &Options::default())
}

/// Reads a volume of any known format. The first bytes decide before the name does. A raw file is read if the options
/// describe it, a sidecar lies beside it or its name tells its shape.
///
/// # Errors
/// [`ReadError`] if the file is a device, is of no known format, or its reader refuses it.
pub fn read_with(path: &Path, options: &Options) -> Result<Decoded, ReadError> {
    let choice = &options.choice;
    match find(path, options)? {
        Found::Placed(placed) => placed.read(choice.nan),
        Found::Folder => read_folder(path, options),
        Found::Dicom => dicom::read_with_file(path, choice),
        Found::Tiff => tiff::read(path, choice),
    }
}

/// What a path leads to.
pub(super) enum Found {
    /// A header has been read, the values have not.
    Placed(Box<Placed>),
    /// A folder of slices.
    Folder,
    /// A DICOM file.
    Dicom,
    /// A TIFF file.
    Tiff,
}

/// Finds the format of a file, and reads its header where the values lie in one piece or in files of their own.
///
/// # Errors
/// As [`read_with`].
pub(super) fn find(path: &Path, options: &Options) -> Result<Found, ReadError> {
    let choice = &options.choice;
    if options.raw.is_none() && zarr::recognise(path) {
        return Ok(Found::Placed(zarr::place(path, choice)?.into()));
    }
    if path.is_dir() {
        return Ok(Found::Folder);
    }
    let fail = |problem| ReadError::new(path, problem);
    if let Some(description) = &options.raw {
        choice.check_single().map_err(fail)?;
        return Ok(Found::Placed(raw::place(path, description)?.into()));
    }
    let (mut source, _) = open_regular(path)?;
    let start = source.fill_buf().map_err(Problem::io("read the file")).map_err(fail)?;
    let format = Format::of(start, path);
    if format != Some(Format::Tiff) {
        choice.check_single().map_err(fail)?;
    }
    let placed = match format {
        Some(Format::Nrrd) => nrrd::place(path)?,
        Some(Format::Nifti) => nifti::place(path)?,
        Some(Format::MetaImage) => metaimage::place(path)?,
        Some(Format::Dicom) => return Ok(Found::Dicom),
        Some(Format::Tiff) => return Ok(Found::Tiff),
        None => match raw::place_by_sidecar(path) {
            Some(placed) => placed?,
            None => {
                return Err(fail(Problem::UnknownFormat {
                    first_bytes: format!("\"{}\"", start[..start.len().min(8)].escape_ascii()),
                }));
            }
        },
    };
    Ok(Found::Placed(placed.into()))
}

/// Reads a volume of colours; `None` of a file that is none, which [`read_with`] may read or refuse. Of the choice, channel and
/// time count.
///
/// # Errors
/// As [`read_with`].
pub fn read_colours(path: &Path, choice: &Choice) -> Result<Option<Colours>, ReadError> {
    if zarr::recognise(path) {
        return Ok(None);
    }
    if path.is_dir() {
        return tiff::read_colours(path, choice);
    }
    let (mut source, _) = open_regular(path)?;
    let start = source.fill_buf().map_err(Problem::io("read the file"));
    match Format::of(start.map_err(|problem| ReadError::new(path, problem))?, path) {
        Some(Format::Nrrd) => single(nrrd::read_colours(path)?, path, choice),
        Some(Format::Nifti) => single(nifti::read_colours(path)?, path, choice),
        Some(Format::Tiff) => tiff::read_colours(path, choice),
        _ => Ok(None),
    }
}

/// Reads a volume of shares of materials: an NRRD file with 1 to 8 values a voxel.
///
/// # Errors
/// As [`read_with`].
pub fn read_shares(path: &Path) -> Result<Colours, ReadError> {
    if path.is_dir() || zarr::recognise(path) {
        return Err(ReadError::new(path, Problem::NoShares));
    }
    let (mut source, _) = open_regular(path)?;
    let start = source.fill_buf().map_err(Problem::io("read the file"));
    match Format::of(start.map_err(|problem| ReadError::new(path, problem))?, path) {
        Some(Format::Nrrd) => nrrd::read_shares(path),
        _ => Err(ReadError::new(path, Problem::NoShares)),
    }
}

/// The colours of a file that holds no more than one volume.
fn single(colours: Option<Colours>, path: &Path, choice: &Choice) -> Result<Option<Colours>, ReadError> {
    if colours.is_some() {
        choice.check_single().map_err(|problem| ReadError::new(path, problem))?;
    }
    Ok(colours)
}

/// Reads a folder: a DICOM series, or TIFF slices.
fn read_folder(path: &Path, options: &Options) -> Result<Decoded, ReadError> {
    let fail = |problem| ReadError::new(path, problem);
    let entries = fs::read_dir(path)
        .map_err(Problem::io("read the folder"))
        .map_err(fail)?;
    let any_tiff = entries.flatten().any(|entry| tiff::has_name(&entry.path()));
    match dicom::read_folder(path, &options.choice) {
        // Only a folder without a single DICOM file may be something else.
        Err(ReadError {
            problem: Problem::NoImages,
            ..
        }) if any_tiff => tiff::read_folder(path, &options.choice),
        Err(ReadError {
            problem: Problem::NoImages,
            ..
        }) => {
            options.choice.check_single().map_err(fail)?;
            dicom::read_tree(path, &options.choice)
        }
        read => {
            options.choice.check_single().map_err(fail)?;
            read
        }
    }
}

/// The formats that state their own shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Nrrd,
    Nifti,
    MetaImage,
    Dicom,
    Tiff,
}

impl Format {
    /// The format that a file's first bytes tell, else the one that its name tells.
    fn of(start: &[u8], path: &Path) -> Option<Self> {
        let by_content = [
            (start.starts_with(b"NRRD"), Self::Nrrd),
            (tiff::recognise(start), Self::Tiff),
            (dicom::recognise(start), Self::Dicom),
            (nifti::recognise(start), Self::Nifti),
            (metaimage::recognise(start), Self::MetaImage),
        ];
        if let Some((_, format)) = by_content.into_iter().find(|(found, _)| *found) {
            return Some(format);
        }
        let name = path.file_name()?.to_string_lossy().to_ascii_lowercase();
        let ends = |endings: &[&str]| endings.iter().any(|ending| name.ends_with(ending));
        [
            (ends(&[".nrrd", ".nhdr"]), Self::Nrrd),
            (ends(&[".nii", ".nii.gz", ".hdr"]), Self::Nifti),
            (nifti::header_beside(path).is_some(), Self::Nifti),
            (ends(&[".mhd", ".mha"]), Self::MetaImage),
            (ends(&[".dcm"]), Self::Dicom),
            (ends(&[".tif", ".tiff"]), Self::Tiff),
        ]
        .into_iter()
        .find_map(|(named, format)| named.then_some(format))
    }
}

/// Reads the built-in CT head: stored values 0 to 3926, in Hounsfield units after its offset of -1024.
///
/// # Errors
/// None in a sound build; a test reads it.
pub fn read_built_in() -> Result<Decoded, ReadError> {
    nrrd::read_bytes(BUILT_IN, "built-in CT head", &Choice::default())
}

/// A volume ready for the pipeline, and what the user should know about it.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The volume in 12-bit codes.
    pub volume: Volume,
    /// What the mapping to codes did to the values.
    pub report: MappingReport,
    /// What was assumed or left aside in reading the file, a sentence each.
    pub notes: Vec<String>,
    /// What made the values, if the file says so.
    pub modality: Option<Modality>,
    /// How the volume lies in the patient.
    pub orientation: Orientation,
    /// Whether the stored values are integers, in whatever type.
    pub integers: bool,
    /// The labels, if the volume is a label map.
    pub labels: Option<Labels>,
    /// How often each code occurs.
    pub statistics: Statistics,
}

impl Loaded {
    /// What a code stands for in the file: a value in the data's unit, or the label where codes count labels.
    pub fn value(&self, code: u16) -> f64 {
        let label = self.labels.as_ref().and_then(|labels| labels.of(code));
        label.unwrap_or_else(|| self.volume.mapping.value(f64::from(code)))
    }
}

/// Reads a volume file, or the built-in CT head if there is no path, and maps it to 12 bits.
///
/// # Errors
/// [`LoadError`] if the file cannot be read or its values cannot be mapped as asked.
pub fn load(path: Option<&Path>, window: Window) -> Result<Loaded, LoadError> {
    load_with(path, window, &Options::default())
}

/// As [`load`], with what the user states about the file.
///
/// # Errors
/// As [`load`].
pub fn load_with(path: Option<&Path>, window: Window, options: &Options) -> Result<Loaded, LoadError> {
    let decoded = match path {
        Some(path) => read_with(path, options)?,
        None => read_built_in()?,
    };
    prepare(&decoded, window)
}

/// Maps a volume that has been read (as raw files have to be, by [`super::raw::read`]) to 12 bits.
///
/// # Errors
/// [`LoadError::Mapping`] if its values cannot be mapped as asked.
pub fn prepare(decoded: &Decoded, window: Window) -> Result<Loaded, LoadError> {
    match map(decoded, window) {
        Ok(Mapped {
            volume,
            report,
            labels,
            note,
        }) => Ok(Loaded {
            statistics: Statistics::of(&volume),
            volume,
            report,
            labels,
            notes: decoded.notes().iter().cloned().chain(note).collect(),
            modality: decoded.modality(),
            orientation: decoded.orientation().clone(),
            integers: decoded.values().are_whole(),
        }),
        Err(error) => Err(LoadError::Mapping {
            name: decoded.name().to_owned(),
            error,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::values::Values;

    #[test]
    fn the_built_in_volume_is_the_documented_one() {
        let Loaded {
            volume, report, notes, ..
        } = load(None, Window::Auto).unwrap();
        assert!(notes.is_empty());
        assert_eq!(volume.dims, [64, 64, 93]);
        assert_eq!(volume.spacing, [3.2, 3.2, 1.5]);
        assert_eq!(volume.voxels.iter().max(), Some(&3926));
        assert_eq!(volume.voxels.iter().min(), Some(&0));
        assert_eq!((volume.mapping.scale, volume.mapping.offset), (1.0, -1024.0));
        assert!(report.lossless);
    }

    #[test]
    fn content_decides_before_the_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("head.raw");
        fs::write(&path, BUILT_IN).unwrap();
        assert_eq!(read(&path).unwrap().dims(), [64, 64, 93]);
        let path = folder.path().join("head.NRRD");
        fs::write(&path, b"P5 1 1 255\n").unwrap();
        assert!(matches!(read(&path).unwrap_err().problem, Problem::Magic { .. }));
        let path = folder.path().join("head.xyz");
        fs::write(&path, b"\x1f\x8b\x08\0abcdefgh").unwrap();
        let message = read(&path).unwrap_err().to_string();
        assert!(
            message.contains("begins with \"\\x1f\\x8b\\x08\\x00abcd\", expected NRRD, NIfTI"),
            "{message}"
        );
    }

    #[test]
    fn codes_stand_for_values_or_for_labels() {
        let of = |values| {
            let decoded = Decoded::new("t".into(), [4, 1, 1], [1.0; 3], Values::U16(values)).unwrap();
            let loaded = prepare(&decoded, Window::Auto).unwrap();
            [0, 1, 2].map(|code| loaded.value(code))
        };
        assert_eq!(of(vec![0, 0, 7, 900]), [0.0, 1.0, 2.0]);
        assert_eq!(of(vec![0, 0, 7, 9000]), [0.0, 7.0, 9000.0]);
    }

    #[cfg(unix)]
    #[test]
    fn devices_are_refused() {
        let error = read(Path::new("/dev/zero")).unwrap_err().to_string();
        assert_eq!(error, "/dev/zero: is a device, pipe or socket, expected a regular file");
    }
}
