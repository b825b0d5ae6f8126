//! The text of an NRRD header, cut into fields and `key:=value` pairs; nothing is interpreted here.
//!
//! Source: teem.sourceforge.net/nrrd/format.html. Lines end in LF or CR LF; the header ends with an empty line, or, if it
//! stands in a file of its own, with the file.

use std::collections::HashMap;
use std::io::{BufRead, Read};

use crate::error::Problem;
use crate::files::is_list;
use crate::text::{decode, shorten};

/// Bytes that a header may have.
pub(super) const MAX_LEN: u64 = 1 << 20;

/// The fields that the format defines, with the names under which they are kept.
///
/// Unknown ones are refused, as the format's own library does: `spacing:` for `spacings:` must not pass unseen.
const FIELDS: [(&str, &str); 40] = [
    ("axis maxs", "axis maxs"),
    ("axis mins", "axis mins"),
    ("axismaxs", "axis maxs"),
    ("axismins", "axis mins"),
    ("block size", "block size"),
    ("blocksize", "block size"),
    ("byte skip", "byte skip"),
    ("byteskip", "byte skip"),
    ("centerings", "centers"),
    ("centers", "centers"),
    ("content", "content"),
    ("data file", "data file"),
    ("datafile", "data file"),
    ("dimension", "dimension"),
    ("encoding", "encoding"),
    ("endian", "endian"),
    ("kinds", "kinds"),
    ("labels", "labels"),
    ("line skip", "line skip"),
    ("lineskip", "line skip"),
    ("max", "max"),
    ("measurement frame", "measurement frame"),
    ("min", "min"),
    ("number", "number"),
    ("old max", "old max"),
    ("old min", "old min"),
    ("oldmax", "old max"),
    ("oldmin", "old min"),
    ("sample units", "sample units"),
    ("sampleunits", "sample units"),
    ("sizes", "sizes"),
    ("space", "space"),
    ("space dimension", "space dimension"),
    ("space directions", "space directions"),
    ("space origin", "space origin"),
    ("space units", "space units"),
    ("spacings", "spacings"),
    ("thicknesses", "thicknesses"),
    ("type", "type"),
    ("units", "units"),
];

/// A header's lines.
#[derive(Debug, Default)]
pub(super) struct Header {
    /// Values by the field's full name.
    pub fields: HashMap<&'static str, String>,
    /// The names that follow `data file: LIST`, a line each.
    pub listed: Vec<String>,
    /// Values of `key:=value` pairs by key; of a key given twice, the last.
    pub keys: HashMap<String, String>,
    /// What the user should know.
    pub notes: Vec<String>,
    /// Bytes up to the data.
    pub len: u64,
    /// Whether an empty line ended it (data may follow) rather than the file's end.
    pub ended: bool,
}

impl Header {
    /// Reads a header and leaves `source` at the first byte of the data.
    pub fn read<R: BufRead>(source: &mut R) -> Result<Self, Problem> {
        let mut header = Self::default();
        let mut bytes = Vec::new();
        let mut first_latin = None;
        for line in 1.. {
            bytes.clear();
            // One byte over the limit tells a line that breaks it from a file that ends there.
            let room = MAX_LEN + 1 - header.len;
            let read = source.by_ref().take(room).read_until(b'\n', &mut bytes);
            header.len += read.map_err(Problem::io("read the header"))? as u64;
            let text = bytes.strip_suffix(b"\n").unwrap_or(&bytes);
            let text = text.strip_suffix(b"\r").unwrap_or(text);
            if line == 1 {
                check_magic(text)?;
                continue;
            }
            if header.len > MAX_LEN {
                return Err(Problem::HeaderTooLong { limit: MAX_LEN });
            }
            if bytes.is_empty() {
                break;
            }
            if text.is_empty() {
                header.ended = true;
                break;
            }
            let (text, latin) = decode(text);
            if latin && first_latin.is_none() {
                first_latin = Some(line);
            }
            if header.get("data file").is_some_and(is_list) {
                header.listed.push(text);
            } else {
                header.take_line(line, &text)?;
            }
        }
        if let Some(line) = first_latin {
            header
                .notes
                .push(format!("header line {line} is not UTF-8 text: it is taken as Latin-1"));
        }
        Ok(header)
    }

    /// Sorts one line in.
    fn take_line(&mut self, line: usize, text: &str) -> Result<(), Problem> {
        if text.trim_start().starts_with('#') {
            return Ok(());
        }
        let key_at = text.find(":=");
        let field_at = text.find(": ").or_else(|| text.strip_suffix(':').map(str::len));
        match (key_at, field_at) {
            (Some(key), field) if field.is_none_or(|field| key < field) => {
                self.keys.insert(text[..key].to_owned(), text[key + 2..].to_owned());
                Ok(())
            }
            (_, Some(field)) => self.take_field(line, text[..field].trim(), text[field + 1..].trim()),
            _ => Err(Problem::HeaderLine {
                line,
                text: shorten(text),
            }),
        }
    }

    /// Keeps a field under its full name.
    fn take_field(&mut self, line: usize, name: &str, value: &str) -> Result<(), Problem> {
        let refuse = |fault| Problem::HeaderField {
            line,
            field: shorten(name),
            fault,
        };
        let lower = name.to_ascii_lowercase();
        let known = FIELDS.iter().find(|(spelling, _)| *spelling == lower);
        let (_, full) = known.ok_or_else(|| refuse("unknown, expected one that the NRRD format defines"))?;
        match self.fields.insert(full, value.to_owned()) {
            None => Ok(()),
            Some(_) => Err(refuse("given twice, expected once")),
        }
    }

    /// A field that need not be there.
    pub fn get(&self, field: &str) -> Option<&str> {
        self.fields.get(field).map(String::as_str)
    }

    /// A field that has to be there.
    pub fn require(&self, field: &'static str, expected: &'static str) -> Result<&str, Problem> {
        self.get(field).ok_or(Problem::MissingField { field, expected })
    }
}

/// Refuses everything but the five versions of the format.
fn check_magic(line: &[u8]) -> Result<(), Problem> {
    match line {
        [b'N', b'R', b'R', b'D', b'0', b'0', b'0', b'1'..=b'5'] => Ok(()),
        other => Err(Problem::Magic {
            found: shorten(&other.escape_ascii().to_string()),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &[u8]) -> Result<Header, Problem> {
        Header::read(&mut &*text)
    }

    #[test]
    fn lines_are_sorted() {
        let header = read(b"NRRD0004\r\n# c: d\nSizes: 1 2 3 \r\ncontent: a:=b\nkey: x:=y\nk:=v: w\n\ndata");
        assert!(matches!(header, Err(Problem::HeaderField { line: 5, .. })));
        let header = read(b"NRRD0004\r\n# c: d\nSizes: 1 2 3 \r\ncontent: a:=b\nk:=v: w\r\nempty:=\n\r\ndata").unwrap();
        assert_eq!(header.get("sizes"), Some("1 2 3"));
        assert_eq!(header.get("content"), Some("a:=b"));
        assert_eq!(header.keys["k"], "v: w");
        assert_eq!(header.keys["empty"], "");
        assert!(header.ended);
        assert_eq!(header.len, 65);
    }

    #[test]
    fn a_file_may_end_the_header() {
        let header = read(b"NRRD0001\ndatafile: x.raw").unwrap();
        assert_eq!((header.get("data file"), header.ended), (Some("x.raw"), false));
    }

    #[test]
    fn other_beginnings_are_refused() {
        for bad in [&b""[..], b"NRRD0006\n", b"NRRD\n", b"\x89PNG\r\n", b"NRRD00051\n"] {
            assert!(matches!(read(bad), Err(Problem::Magic { .. })), "{bad:?}");
        }
    }

    #[test]
    fn bad_lines_are_refused_with_their_number() {
        let error = read(b"NRRD0005\nnot a field\n").unwrap_err().to_string();
        assert_eq!(
            error,
            "header line 2 is `not a field`, expected `# comment`, `field: value` or `key:=value`"
        );
        let error = read(b"NRRD0005\ntype: short\nspacing: 1 1 2\n")
            .unwrap_err()
            .to_string();
        assert!(
            error.starts_with("header line 3: field `spacing` is unknown"),
            "{error}"
        );
        let error = read(b"NRRD0005\nline skip: 1\nlineskip: 1\n").unwrap_err().to_string();
        assert_eq!(error, "header line 3: field `lineskip` is given twice, expected once");
    }

    #[test]
    fn comments_may_be_in_latin_1() {
        let header = read(b"NRRD0005\n# Universit\xe4t\n  # indented\ncontent: \xb5CT\n\n").unwrap();
        assert_eq!(header.get("content"), Some("\u{b5}CT"));
        assert_eq!(
            header.notes,
            ["header line 2 is not UTF-8 text: it is taken as Latin-1"]
        );
    }

    #[test]
    fn a_list_of_files_ends_the_header() {
        let header = read(b"NRRD0004\ndata file: LIST 2\na: b.raw\nNRRD: c\n").unwrap();
        assert_eq!(header.listed, ["a: b.raw", "NRRD: c"]);
        assert_eq!(read(b"NRRD0004\ndata file: LIST\na\n\nb").unwrap().listed, ["a"]);
    }

    #[test]
    fn the_length_limit_is_exact() {
        let mut text = b"NRRD0005\n#".to_vec();
        text.resize(MAX_LEN as usize - 2, b'x');
        text.extend(b"\n\n");
        assert_eq!(read(&text).unwrap().len, MAX_LEN);
        text.insert(20, b'x');
        assert!(matches!(read(&text), Err(Problem::HeaderTooLong { limit: MAX_LEN })));
        text.truncate(9);
        text.resize(3 * MAX_LEN as usize, b'#');
        assert!(matches!(read(&text), Err(Problem::HeaderTooLong { .. })));
    }
}
