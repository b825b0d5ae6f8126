//! A device's answer: its files read back, and the first place where it departs.
//!
//! Files are read as [`files`](crate::files) writes them; a simulator's own ways are taken too: comments and addresses of
//! `$writememh`, words without `_`, upper case, arrays of other integer types.

use std::fmt;

use npyz::{NpyFile, TypeChar};

use crate::files::{Format, digits};
use crate::set::{Field, Set, Side};

/// Why a file is no answer.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AnswerError {
    /// It is not text of hexadecimal words.
    #[error("line {line}: `{word}` is no hexadecimal word of {digits} digits")]
    Word {
        /// The line, from 1.
        line: usize,
        /// What stands there.
        word: String,
        /// How many digits a word has.
        digits: usize,
    },
    /// An address jumps.
    #[error("line {line}: the address @{address:x}, expected @{expected:x}: words one after the other from 0")]
    Address {
        /// The line, from 1.
        line: usize,
        /// The address.
        address: usize,
        /// The one that would have been the next.
        expected: usize,
    },
    /// It has too few or too many vectors.
    #[error("{given} vectors, expected {expected}")]
    Length {
        /// How many it has.
        given: usize,
        /// How many the set has.
        expected: usize,
    },
    /// It is no NPY array.
    #[error("no NPY array: {0}")]
    Npy(String),
    /// An array of another kind.
    #[error("an array of {given}, expected integers of shape {expected}")]
    Shape {
        /// Type and shape.
        given: String,
        /// The shape.
        expected: String,
    },
}

/// A number that came back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Value {
    /// A number.
    Number(i128),
    /// Digits that a simulator did not know (`x` or `z`).
    Unknown,
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => write!(f, "{number}"),
            Self::Unknown => f.write_str("unknown (x)"),
        }
    }
}

/// Reads a file that should hold this side.
///
/// # Errors
/// [`AnswerError`], with what was expected.
pub fn read(side: &Side, format: Format, bytes: &[u8]) -> Result<Vec<Value>, AnswerError> {
    let values = match format {
        Format::Hex => hex(&side.fields, bytes)?,
        Format::Npy => npy(side, bytes)?,
    };
    if values.len() == side.values.len() {
        Ok(values)
    } else {
        Err(AnswerError::Length {
            given: values.len() / side.fields.len(),
            expected: side.values.len() / side.fields.len(),
        })
    }
}

fn hex(fields: &[Field], bytes: &[u8]) -> Result<Vec<Value>, AnswerError> {
    let all: usize = fields.iter().map(digits).sum();
    let text = String::from_utf8_lossy(bytes);
    let (mut values, mut words, mut commented) = (Vec::new(), 0, false);
    for (number, line) in (1..).zip(text.lines()) {
        let line = without_comments(line, &mut commented);
        for word in line.split_whitespace() {
            let refused = || AnswerError::Word {
                line: number,
                word: word.chars().take(40).collect(),
                digits: all,
            };
            if let Some(address) = word.strip_prefix('@') {
                let address = usize::from_str_radix(address, 16).map_err(|_| refused())?;
                if address != words {
                    return Err(AnswerError::Address {
                        line: number,
                        address,
                        expected: words,
                    });
                }
                continue;
            }
            let word: String = word.chars().filter(|c| *c != '_').collect();
            let known = |c: char| c.is_ascii_hexdigit() || "xXzZ".contains(c);
            // Leading zeros may be left out.
            if word.is_empty() || word.len() > all || !word.chars().all(known) {
                return Err(refused());
            }
            let mut rest = &*format!("{word:0>all$}");
            for field in fields {
                let (own, behind) = rest.split_at(digits(field));
                rest = behind;
                values.push(value(field, own));
            }
            words += 1;
        }
    }
    Ok(values)
}

/// A line without what stands in `/* */` or behind `//`; `commented` says whether a `/*` is open.
fn without_comments(line: &str, commented: &mut bool) -> String {
    let (mut kept, mut rest) = (String::new(), line);
    loop {
        if *commented {
            let Some((_, behind)) = rest.split_once("*/") else {
                return kept;
            };
            (*commented, rest) = (false, behind);
            kept.push(' ');
        }
        let whole = rest.split_once("//").map_or(rest, |(code, _)| code);
        match whole.split_once("/*") {
            Some((code, _)) => {
                kept.push_str(code);
                *commented = true;
                rest = &rest[code.len() + 2..];
            }
            None => {
                kept.push_str(whole);
                return kept;
            }
        }
    }
}

/// The number of a field's digits.
fn value(field: &Field, digits: &str) -> Value {
    let Ok(bits) = u64::from_str_radix(digits, 16) else {
        return Value::Unknown;
    };
    let (bits, width) = (i128::from(bits), 4 * digits.len());
    // The sign stands in the highest digit, as it was written; of a field's own width it is taken as well.
    let negative = field.signed && (bits >> (width - 1) == 1 || bits >> (field.bits - 1) == 1);
    Value::Number(if !negative {
        bits
    } else if bits >> (width - 1) == 1 {
        bits - (1 << width)
    } else {
        bits - (1 << field.bits)
    })
}

fn npy(side: &Side, bytes: &[u8]) -> Result<Vec<Value>, AnswerError> {
    let file = NpyFile::new(bytes).map_err(|error| AnswerError::Npy(error.to_string()))?;
    let width = side.fields.len();
    let (descr, shape) = (file.dtype().descr(), file.shape().to_vec());
    let refused = || AnswerError::Shape {
        given: format!("{descr}, shape {shape:?}"),
        expected: format!("[{}, {width}]", side.values.len() / width),
    };
    // A set of one field may be a plain row.
    let fits = match shape[..] {
        [_] => width == 1,
        [_, fields] => fields == width as u64,
        _ => false,
    };
    if !fits || file.order() != npyz::Order::C {
        return Err(refused());
    }
    let npyz::DType::Plain(kind) = file.dtype() else {
        return Err(refused());
    };
    fn all<T: npyz::Deserialize + Into<i128>>(file: NpyFile<&[u8]>) -> std::io::Result<Vec<Value>> {
        let numbers: Vec<T> = file.into_vec()?;
        Ok(numbers.into_iter().map(|number| Value::Number(number.into())).collect())
    }
    let read = match (kind.type_char(), kind.size_field()) {
        (TypeChar::Int, 1) => all::<i8>(file),
        (TypeChar::Int, 2) => all::<i16>(file),
        (TypeChar::Int, 4) => all::<i32>(file),
        (TypeChar::Int, 8) => all::<i64>(file),
        (TypeChar::Uint, 1) => all::<u8>(file),
        (TypeChar::Uint, 2) => all::<u16>(file),
        (TypeChar::Uint, 4) => all::<u32>(file),
        (TypeChar::Uint, 8) => all::<u64>(file),
        _ => return Err(refused()),
    };
    read.map_err(|error| AnswerError::Npy(error.to_string()))
}

/// A place where an answer departs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Divergence {
    /// The set.
    pub set: String,
    /// The vector.
    pub vector: usize,
    /// Plane, phase, row, column, as far as the set has them.
    pub place: Vec<(String, i64)>,
    /// The field.
    pub field: String,
    /// What comes out of the pipeline.
    pub expected: i64,
    /// What came back.
    pub found: Value,
    /// How many vectors of the set depart.
    pub departing: usize,
    /// Of how many.
    pub of: usize,
}

impl fmt::Display for Divergence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "first divergence at stage {}", self.set)?;
        for (name, value) in &self.place {
            write!(f, ", {name} {value}")?;
        }
        let (expected, found) = (self.expected, self.found);
        write!(f, ", vector {}, {}: expected {expected}", self.vector, self.field)?;
        write!(f, ", found {found}; {} of {} vectors depart", self.departing, self.of)
    }
}

/// Where the values of a set's outputs first depart.
pub fn first(set: &Set, found: &[Value]) -> Option<Divergence> {
    let width = set.outputs.fields.len();
    let departs = |at: usize| Value::Number(set.outputs.values[at].into()) != found[at];
    let at = (0..found.len()).find(|at| departs(*at))?;
    let vector = at / width;
    let departing = (0..set.len())
        .filter(|row| (row * width..(row + 1) * width).any(departs))
        .count();
    let place = set.inputs.fields.iter().zip(set.inputs.row(vector)).take(set.place);
    Some(Divergence {
        set: set.name.clone(),
        vector,
        place: place.map(|(field, value)| (field.name.clone(), *value)).collect(),
        field: set.outputs.fields[at % width].name.clone(),
        expected: set.outputs.values[at],
        found: found[at],
        departing,
        of: set.len(),
    })
}

/// Of the first departures of several sets, by their numbers, the one that may have caused the others: the earliest plane
/// and phase in the order of folding, and there the first stage.
pub fn earliest(sets: &[Set], departures: &[(usize, Divergence)]) -> Option<Divergence> {
    let located = sets.iter().find(|set| set.stage == "location" && set.place == 2);
    let moment = |divergence: &Divergence| match &divergence.place[..] {
        [] => 0,
        [(name, plane), (_, phase), ..] if name == "plane" => {
            let planes = located.map_or(&[][..], |set| &set.inputs.values);
            planes
                .chunks_exact(2)
                .position(|at| at == [*plane, *phase])
                .unwrap_or(0)
        }
        // What belongs to no plane, the image and the picture, comes when all are folded.
        _ => usize::MAX,
    };
    let first = departures
        .iter()
        .min_by_key(|(number, divergence)| (moment(divergence), *number));
    first.map(|(_, divergence)| divergence.clone())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::contents;
    use crate::set::{s, u};

    fn set() -> Set {
        let mut set = Set::new(
            None,
            "stage",
            "about",
            vec![u("a", 5, "1")],
            vec![s("b", 9, "1"), u("c", 4, "1")],
        );
        for (a, b, c) in [(1, -256, 15), (2, 255, 0), (31, -1, 7)] {
            set.push(&[a], &[b, c]);
        }
        set
    }

    fn hex_of(text: &str) -> Result<Vec<Value>, AnswerError> {
        read(&set().outputs, Format::Hex, text.as_bytes())
    }

    #[test]
    fn what_is_written_is_read() {
        let set = set();
        assert_eq!(contents(&set.outputs, Format::Hex).unwrap(), b"f00_f\n0ff_0\nfff_7\n");
        for format in Format::ALL {
            let bytes = contents(&set.outputs, format).unwrap();
            assert_eq!(first(&set, &read(&set.outputs, format, &bytes).unwrap()), None);
        }
    }

    #[test]
    fn the_ways_of_simulators_are_read() {
        let expected = hex_of("f00_f\n0ff_0\nfff_7").unwrap();
        for text in [
            "// a memory\n@0\nF00F 0FF0 /* two\nlines */ FFF7\n",
            "@00000000 f00f\nff0\n@2\nfff7 // the last",
            // Signs in the field's own nine bits.
            "100f 0ff0 1ff7",
        ] {
            assert_eq!(hex_of(text).unwrap(), expected, "{text}");
        }
        let unknown = hex_of("f00_f\n0xx_0\nfff_7").unwrap();
        let divergence = first(&set(), &unknown).unwrap();
        assert_eq!(
            (divergence.vector, divergence.found, divergence.departing),
            (1, Value::Unknown, 1)
        );
    }

    #[test]
    fn what_is_no_answer_is_named() {
        let word = |line, word: &str| AnswerError::Word {
            line,
            word: word.into(),
            digits: 4,
        };
        assert_eq!(hex_of("f00f\nhello"), Err(word(2, "hello")));
        assert_eq!(hex_of("f00f 00ff0"), Err(word(1, "00ff0")));
        let short = AnswerError::Length { given: 2, expected: 3 };
        assert_eq!(hex_of("f00f 0ff0"), Err(short.clone()));
        let jump = AnswerError::Address {
            line: 1,
            address: 2,
            expected: 1,
        };
        assert_eq!(hex_of("f00f @2 0ff0 fff7"), Err(jump));
        let npy = contents(&set().outputs, Format::Npy).unwrap();
        assert!(matches!(
            read(&set().outputs, Format::Npy, &npy[..npy.len() - 1]),
            Err(AnswerError::Npy(_))
        ));
        assert!(matches!(
            read(&set().outputs, Format::Npy, b"no"),
            Err(AnswerError::Npy(_))
        ));
        let inputs = contents(&set().inputs, Format::Npy).unwrap();
        assert!(matches!(
            read(&set().outputs, Format::Npy, &inputs),
            Err(AnswerError::Shape { .. })
        ));
    }

    #[test]
    fn the_first_departure_is_named_with_both_values() {
        let set = set();
        let mut found = read(&set.outputs, Format::Hex, b"f00_f 0ff_0 fff_7").unwrap();
        found[3] = Value::Number(9);
        found[4] = Value::Number(0);
        let text = first(&set, &found).unwrap().to_string();
        assert_eq!(
            text,
            "first divergence at stage all/stage, vector 1, c: expected 0, found 9; 2 of 3 vectors depart"
        );
    }
}
