//! The text of a MetaImage header: lines of `Key = Value` up to `ElementDataFile`; nothing is interpreted here.

use std::collections::HashMap;
use std::io::{BufRead, Read};

use super::{DATA_FILE, refuse};
use crate::error::Problem;
use crate::files::is_list;
use crate::text::{decode, shorten};

/// The format's name in messages.
pub(super) const NAME: &str = "MetaImage";

/// Bytes that a header may have.
const MAX_LEN: u64 = 1 << 20;

/// A header's lines.
#[derive(Debug, Default)]
pub(super) struct Header {
    fields: HashMap<String, String>,
    /// The names that follow `ElementDataFile = LIST`, a line each.
    pub listed: Vec<String>,
    /// What the user should know.
    pub notes: Vec<String>,
    /// Bytes up to the data.
    pub len: u64,
}

impl Header {
    /// Reads a header and leaves `source` after the line of `ElementDataFile`.
    pub fn read(source: &mut impl BufRead) -> Result<Self, Problem> {
        let mut header = Self::default();
        let mut bytes = Vec::new();
        let mut listing = false;
        for line in 1.. {
            bytes.clear();
            let room = MAX_LEN + 1 - header.len;
            let read = source.by_ref().take(room).read_until(b'\n', &mut bytes);
            header.len += read.map_err(Problem::io("read the header"))? as u64;
            if header.len > MAX_LEN {
                return Err(Problem::HeaderTooLong { limit: MAX_LEN });
            }
            if bytes.is_empty() && listing {
                break;
            }
            if bytes.is_empty() {
                return Err(Problem::MissingField {
                    field: DATA_FILE,
                    expected: "`LOCAL` or a file's name at the header's end",
                });
            }
            let (text, latin) = decode(&bytes);
            let text = text.trim();
            if latin {
                let note = format!("header line {line} is not UTF-8 text: it is taken as Latin-1");
                header.notes.push(note);
            }
            if listing {
                if !text.is_empty() {
                    header.listed.push(text.to_owned());
                }
                continue;
            }
            if text.is_empty() || text.starts_with('#') {
                continue;
            }
            let Some((key, value)) = text.split_once('=') else {
                let fault = format!("header line {line} is `{}`, expected `Key = Value`", shorten(text));
                return Err(Problem::format(NAME, fault));
            };
            let (key, value) = (key.trim(), value.trim());
            let given_before = header.fields.insert(key.to_owned(), value.to_owned()).is_some();
            // Comments may follow one another; any other field is stated once.
            if given_before && key != "Comment" {
                return Err(Problem::HeaderField {
                    line,
                    field: shorten(key),
                    fault: "given twice, expected once",
                });
            }
            if key == DATA_FILE {
                listing = is_list(value);
                if !listing {
                    break;
                }
            }
        }
        Ok(header)
    }

    /// A field of one of these names, the first that is there.
    pub fn get(&self, names: &[&str]) -> Option<&str> {
        names.iter().find_map(|name| self.fields.get(*name)).map(String::as_str)
    }

    /// A field that has to be there.
    pub fn require(&self, field: &'static str, expected: &'static str) -> Result<&str, Problem> {
        self.get(&[field]).ok_or(Problem::MissingField { field, expected })
    }

    /// A field that is `True` or `False`.
    pub fn truth(&self, names: &[&'static str]) -> Result<Option<bool>, Problem> {
        let Some(text) = self.get(names) else {
            return Ok(None);
        };
        match text.to_ascii_lowercase().as_str() {
            "true" | "1" => Ok(Some(true)),
            "false" | "0" => Ok(Some(false)),
            _ => Err(refuse(names[0], text, "True or False")),
        }
    }
}
