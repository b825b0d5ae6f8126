//! A file's meta information, and the data set after it: PS3.10, and the transfer syntaxes of PS3.5.

use std::borrow::Cow;
use std::io::Read;

use flate2::read::DeflateDecoder;

use super::NAME;
use super::element::{Elements, Encoding, Value};
use crate::error::Problem;
use crate::text::shorten;

/// Bytes that one file may have (2 GiB: 4000 frames of 512 x 512 pixels of 16 bits).
pub const MAX_FILE_LEN: u64 = 1 << 31;

/// Bytes that a deflated file may unpack to (512 MiB).
const MAX_INFLATED_LEN: u64 = 1 << 29;

/// What a DICOMDIR says that it is.
const DIRECTORY: &str = "1.2.840.10008.1.3.10";

/// How pixels are packed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Packing {
    Plain,
    Rle,
    /// JPEG of one process: sequential with loss, or lossless.
    Jpeg,
    JpegLs,
    Jpeg2000,
    /// A transfer syntax that is not read.
    Unread(String),
}

impl Packing {
    /// Refuses syntaxes that are not read.
    pub fn check(&self) -> Result<(), Problem> {
        let unread = |found, expected| {
            Err(Problem::Unsupported {
                format: NAME,
                found,
                expected,
            })
        };
        match self {
            Self::Unread(uid) => unread(
                format!("transfer syntax {} ({})", shorten(uid), syntax_name(uid)),
                "uncompressed, deflated, RLE, JPEG, JPEG-LS or JPEG 2000 (gdcmconv --raw converts others)",
            ),
            Self::Jpeg | Self::JpegLs | Self::Jpeg2000 if cfg!(not(feature = "jpeg")) => unread(
                "a file packed by JPEG, JPEG-LS or JPEG 2000".into(),
                "a build with the feature `jpeg`",
            ),
            _ => Ok(()),
        }
    }
}

/// A file whose meta information has been read.
pub(super) struct File<'a> {
    /// The data set, inflated if the file deflates it.
    pub data: Cow<'a, [u8]>,
    pub encoding: Encoding,
    pub packing: Packing,
    /// Whether the file is a DICOMDIR, which lists those of a medium.
    pub is_directory: bool,
}

impl<'a> File<'a> {
    /// Reads the meta information.
    pub fn open(bytes: &'a [u8]) -> Result<Self, Problem> {
        let meta = match bytes.get(128..132) {
            Some(b"DICM") => &bytes[132..],
            _ => return Err(Problem::format(NAME, "has no `DICM` after a preamble of 128 bytes")),
        };
        let mut elements = Elements::new(meta, Encoding::EXPLICIT);
        let (mut syntax, mut is_directory) = (None, false);
        while elements.peek().is_some_and(|(group, _)| group == 2) {
            match elements.next()? {
                Some(((0x0002, 0x0010), Value::Bytes(uid, _))) => syntax = Some(text(uid)),
                Some(((0x0002, 0x0002), Value::Bytes(uid, _))) => is_directory = text(uid) == DIRECTORY,
                _ => {}
            }
        }
        let rest = meta.get(elements.position()..).unwrap_or(&[]);
        let syntax = syntax.ok_or_else(|| Problem::format(NAME, "states no transfer syntax (0002,0010)"))?;
        let mut data = Cow::Borrowed(rest);
        let mut encoding = Encoding::EXPLICIT;
        let packing = match syntax.as_str() {
            "1.2.840.10008.1.2" => {
                encoding = Encoding::IMPLICIT;
                Packing::Plain
            }
            "1.2.840.10008.1.2.1" => Packing::Plain,
            "1.2.840.10008.1.2.2" => {
                encoding = Encoding::EXPLICIT_BIG;
                Packing::Plain
            }
            "1.2.840.10008.1.2.1.99" => {
                data = inflate(rest)?.into();
                Packing::Plain
            }
            "1.2.840.10008.1.2.5" => Packing::Rle,
            "1.2.840.10008.1.2.4.50"
            | "1.2.840.10008.1.2.4.51"
            | "1.2.840.10008.1.2.4.57"
            | "1.2.840.10008.1.2.4.70" => Packing::Jpeg,
            "1.2.840.10008.1.2.4.80" | "1.2.840.10008.1.2.4.81" => Packing::JpegLs,
            "1.2.840.10008.1.2.4.90" | "1.2.840.10008.1.2.4.91" => Packing::Jpeg2000,
            _ => Packing::Unread(syntax),
        };
        Ok(Self {
            data,
            encoding,
            packing,
            is_directory,
        })
    }
}

/// What the syntaxes that are not read are called.
fn syntax_name(uid: &str) -> &'static str {
    let jpeg = uid.strip_prefix("1.2.840.10008.1.2.4.").unwrap_or("");
    match jpeg.parse() {
        Ok(92 | 93) => "JPEG 2000 of several components",
        Ok(94 | 95) => "JPIP: the pixels lie elsewhere",
        Ok(100..=108) => "video",
        Ok(110..=112) => "JPEG XL",
        Ok(201..=203) => "high-throughput JPEG 2000",
        Ok(_) => "a retired or rare kind of JPEG",
        Err(_) => "unknown",
    }
}

/// Unpacks a deflated data set, up to its limit.
fn inflate(packed: &[u8]) -> Result<Vec<u8>, Problem> {
    let mut out = Vec::new();
    let read = DeflateDecoder::new(packed)
        .take(MAX_INFLATED_LEN + 1)
        .read_to_end(&mut out);
    read.map_err(|error| Problem::format(NAME, format!("deflated data are damaged: {error}")))?;
    if out.len() as u64 > MAX_INFLATED_LEN {
        return Err(Problem::TooLarge {
            bytes: out.len() as u64,
            what: "one file, unpacked",
            limit: MAX_INFLATED_LEN,
        });
    }
    Ok(out)
}

/// A value as text, without padding.
pub(super) fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes)
        .trim_matches([' ', '\0', '\n', '\r', '\t'])
        .to_owned()
}
