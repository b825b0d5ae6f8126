//! What the metadata of an array say, in either version.
//!
//! Source: the specifications of Zarr 2 and Zarr 3.1 (core, codecs `bytes`, `transpose`, `sharding_indexed`, `crc32c`).

use std::path::PathBuf;

use serde_json::Value;

use super::codecs::{self, Codec};
use super::node::Node;
use super::shard::Index;
use super::{NAME, fill};
use crate::error::{Problem, ReadError};
use crate::limits::MAX_BYTES;
use crate::text::shorten;
use crate::values::{Endian, ValueType};

/// Axes that an array may have.
const AXES_MAX: usize = 16;

/// An array, as far as its chunks are concerned.
#[derive(Clone, Debug)]
pub(super) struct Array {
    pub folder: PathBuf,
    /// Entries along each axis.
    pub shape: Vec<u64>,
    /// Those of a file.
    pub file: Vec<u64>,
    /// Those that are unpacked at once: a file's, or of a shard a part's.
    pub chunk: Vec<u64>,
    pub value_type: ValueType,
    pub endian: Endian,
    /// The axes as they follow one another in a chunk, the slowest first.
    pub order: Vec<usize>,
    /// What packed a chunk, in that order.
    pub codecs: Vec<Codec>,
    pub shard: Option<Index>,
    /// The bytes of a value that no chunk holds.
    pub fill: Vec<u8>,
    keys: Keys,
    /// Names of the axes, where the array itself tells them.
    pub names: Option<Vec<String>>,
}

/// How the names of files are made.
#[derive(Clone, Debug)]
struct Keys {
    /// `c` of the keys that Zarr 3 has by default.
    prefix: Option<&'static str>,
    separator: char,
}

impl Array {
    /// Reads the metadata of an array.
    ///
    /// # Errors
    /// [`ReadError`] names the field, what was wrong and what was expected.
    pub fn of(node: &Node) -> Result<Self, ReadError> {
        let array = match node.version {
            2 => second(node)?,
            _ => third(node)?,
        };
        let axes = array.shape.len();
        let divides = |whole: &[u64], part: &[u64]| whole.iter().zip(part).all(|(w, p)| w.is_multiple_of(*p));
        if axes > AXES_MAX || [array.file.len(), array.chunk.len(), array.order.len()] != [axes; 3] {
            return Err(node.fault(format!(
                "{axes} axes have chunks of {} and {}, expected as many, at most {AXES_MAX}",
                array.file.len(),
                array.chunk.len()
            )));
        }
        if !divides(&array.file, &array.chunk) {
            return Err(node.fault("the chunks of a shard do not divide it, expected shards of whole chunks"));
        }
        let bytes = array.chunk_bytes();
        if bytes.is_none_or(|bytes| bytes > MAX_BYTES) {
            return Err(node.fault(format!(
                "a chunk of {:?} values would take more than {MAX_BYTES} bytes",
                array.chunk
            )));
        }
        Ok(array)
    }

    /// Bytes of a chunk's values; `None` of more than can be counted.
    pub fn chunk_bytes(&self) -> Option<u64> {
        let lens = self.chunk.iter();
        lens.copied().try_fold(self.value_type.byte_len(), u64::checked_mul)
    }

    /// The file of a chunk, by its number along each axis.
    pub fn path(&self, index: &[u64]) -> PathBuf {
        let numbers = index.iter().map(u64::to_string);
        let parts: Vec<String> = self.keys.prefix.map(String::from).into_iter().chain(numbers).collect();
        let name = if parts.is_empty() {
            "0".into()
        } else {
            parts.join(&self.keys.separator.to_string())
        };
        self.folder.join(name)
    }
}

/// A list of whole numbers above 0.
fn lengths(node: &Node, field: &str, value: Option<&Value>) -> Result<Vec<u64>, ReadError> {
    let numbers = value.and_then(Value::as_array);
    let numbers: Option<Vec<u64>> =
        numbers.and_then(|numbers| numbers.iter().map(|n| n.as_u64().filter(|&n| n > 0)).collect());
    numbers.ok_or_else(|| node.fault(format!("`{field}` is not a list of whole numbers above 0")))
}

fn unsupported(node: &Node, found: String, expected: &'static str) -> ReadError {
    let problem = Problem::Unsupported {
        format: NAME,
        found,
        expected,
    };
    ReadError::new(&node.file, problem)
}

fn codec(node: &Node, value: &Value) -> Result<Codec, ReadError> {
    Codec::named(value).map_err(|name| unsupported(node, format!("the codec `{name}`"), codecs::READ))
}

/// `.zarray`.
fn second(node: &Node) -> Result<Array, ReadError> {
    let field = |name: &str| node.metadata.get(name).filter(|value| !value.is_null());
    let shape = lengths(node, "shape", field("shape"))?;
    let chunk = lengths(node, "chunks", field("chunks"))?;
    let name = field("dtype").and_then(Value::as_str).unwrap_or("a structure");
    let types = "the dtype <i1, <u1, <i2, <u2, <i4, <u4, <i8, <u8, <f4, <f8, or the same with > or |";
    let found = || unsupported(node, format!("the dtype `{}`", shorten(name)), types);
    let kind = name.get(1..).ok_or_else(found)?;
    let value_type = TYPES.iter().find(|(short, _, _)| *short == kind);
    let (_, _, value_type) = *value_type.ok_or_else(found)?;
    let endian = match name.as_bytes().first() {
        Some(b'>') => Endian::Big,
        Some(b'<') => Endian::Little,
        Some(b'|') if value_type.byte_len() == 1 => Endian::Little,
        _ => return Err(found()),
    };
    if let Some(filters) = field("filters").and_then(Value::as_array)
        && let Some(first) = filters.first()
    {
        let name = first.get("id").and_then(Value::as_str).unwrap_or_default();
        let name = shorten(name);
        return Err(unsupported(node, format!("the filter `{name}`"), "no filters"));
    }
    let axes = 0..shape.len();
    let order = match field("order").and_then(Value::as_str) {
        Some("C") => axes.collect(),
        Some("F") => axes.rev().collect(),
        _ => return Err(node.fault("`order` is neither `C` nor `F`")),
    };
    let separator = match field("dimension_separator").and_then(Value::as_str) {
        None | Some(".") => '.',
        Some("/") => '/',
        Some(_) => return Err(node.fault("`dimension_separator` is neither `.` nor `/`")),
    };
    let codecs = field("compressor").map(|value| codec(node, value)).transpose()?;
    let names = node.attributes.get("_ARRAY_DIMENSIONS");
    Ok(Array {
        folder: node.folder.clone(),
        file: chunk.clone(),
        chunk,
        value_type,
        endian,
        order,
        codecs: codecs.into_iter().collect(),
        shard: None,
        fill: fill::bytes(field("fill_value"), value_type, endian).map_err(|fault| node.fault(fault))?,
        keys: Keys {
            prefix: None,
            separator,
        },
        names: texts(names, shape.len()),
        shape,
    })
}

/// Names of types: of Zarr 2 without the order of bytes, of Zarr 3, and what they are.
const TYPES: [(&str, &str, ValueType); 10] = [
    ("i1", "int8", ValueType::I8),
    ("u1", "uint8", ValueType::U8),
    ("i2", "int16", ValueType::I16),
    ("u2", "uint16", ValueType::U16),
    ("i4", "int32", ValueType::I32),
    ("u4", "uint32", ValueType::U32),
    ("i8", "int64", ValueType::I64),
    ("u8", "uint64", ValueType::U64),
    ("f4", "float32", ValueType::F32),
    ("f8", "float64", ValueType::F64),
];

/// As many texts as there are axes.
fn texts(value: Option<&Value>, axes: usize) -> Option<Vec<String>> {
    let list = value?.as_array()?.iter();
    let texts: Option<Vec<String>> = list.map(|name| name.as_str().map(String::from)).collect();
    texts.filter(|texts| texts.len() == axes)
}

/// The name and configuration of an extension of Zarr 3, which may be a name alone.
fn extension(value: &Value) -> (&str, Option<&Value>) {
    let name = value.get("name").unwrap_or(value);
    (name.as_str().unwrap_or_default(), value.get("configuration"))
}

/// `zarr.json`.
fn third(node: &Node) -> Result<Array, ReadError> {
    let field = |name: &str| node.metadata.get(name).filter(|value| !value.is_null());
    let shape = lengths(node, "shape", field("shape"))?;
    let (name, _) = field("data_type").map_or(("", None), extension);
    let value_type = TYPES.iter().find(|(_, long, _)| *long == name);
    let (_, _, value_type) = *value_type.ok_or_else(|| {
        let expected = "int8 to int64, uint8 to uint64, float32 or float64";
        unsupported(node, format!("the data type `{}`", shorten(name)), expected)
    })?;
    let (name, grid) = field("chunk_grid").map_or(("", None), extension);
    if name != "regular" {
        return Err(unsupported(
            node,
            format!("the chunk grid `{}`", shorten(name)),
            "a regular one",
        ));
    }
    let file = lengths(node, "chunk_shape", grid.and_then(|grid| grid.get("chunk_shape")))?;
    let (name, keys) = field("chunk_key_encoding").map_or(("default", None), extension);
    let (prefix, usual) = match name {
        "default" => (Some("c"), '/'),
        "v2" => (None, '.'),
        _ => {
            return Err(unsupported(
                node,
                format!("the chunk key encoding `{}`", shorten(name)),
                "`default` or `v2`",
            ));
        }
    };
    let separator = match keys.and_then(|keys| keys.get("separator")).map(Value::as_str) {
        None => usual,
        Some(Some(".")) => '.',
        Some(Some("/")) => '/',
        Some(_) => return Err(node.fault("`separator` is neither `.` nor `/`")),
    };
    if field("storage_transformers").is_some_and(|list| list.as_array().is_none_or(|list| !list.is_empty())) {
        return Err(unsupported(node, "a storage transformer".into(), "none"));
    }
    let mut chain = chain(node, field("codecs"), value_type, shape.len())?;
    let mut chunk = file.clone();
    let mut shard = None;
    if let Some(inner) = chain.shard.take() {
        chunk = lengths(node, "chunk_shape", inner.get("chunk_shape"))?;
        if !chain.codecs.is_empty() || chain.is_turned {
            return Err(unsupported(
                node,
                "a shard that is packed or transposed as a whole".into(),
                "packed chunks inside",
            ));
        }
        chain = self::chain(node, inner.get("codecs"), value_type, shape.len())?;
        if chain.shard.is_some() {
            return Err(unsupported(node, "a shard of shards".into(), "shards of chunks"));
        }
        let counts = file.iter().zip(&chunk).map(|(whole, part)| whole / part);
        shard = Some(Index::of(inner, counts.collect()).map_err(|fault| node.fault(fault))?);
    }
    Ok(Array {
        folder: node.folder.clone(),
        file,
        chunk,
        value_type,
        endian: chain.endian,
        order: chain.order,
        codecs: chain.codecs,
        shard,
        fill: fill::bytes(field("fill_value"), value_type, chain.endian).map_err(|fault| node.fault(fault))?,
        keys: Keys { prefix, separator },
        names: texts(field("dimension_names"), shape.len()),
        shape,
    })
}

/// The codecs of Zarr 3: of arrays, to bytes, and of bytes.
struct Chain<'v> {
    order: Vec<usize>,
    is_turned: bool,
    endian: Endian,
    shard: Option<&'v Value>,
    codecs: Vec<Codec>,
}

fn chain<'v>(node: &Node, list: Option<&'v Value>, value_type: ValueType, axes: usize) -> Result<Chain<'v>, ReadError> {
    let list = list.and_then(Value::as_array);
    let list = list.ok_or_else(|| node.fault("`codecs` is not a list"))?;
    let mut chain = Chain {
        order: (0..axes).collect(),
        is_turned: false,
        endian: Endian::Little,
        shard: None,
        codecs: Vec::new(),
    };
    let mut is_bytes = false;
    for value in list {
        let (name, configuration) = extension(value);
        match name {
            "transpose" if !is_bytes && !chain.is_turned => {
                let order = configuration.and_then(|c| c.get("order")).and_then(Value::as_array);
                let order: Option<Vec<usize>> = order.and_then(|order| {
                    let axes = order.iter().map(|axis| axis.as_u64().map(|axis| axis as usize));
                    axes.collect()
                });
                let order = order.filter(|order| order.len() == axes && (0..axes).all(|axis| order.contains(&axis)));
                chain.order = order.ok_or_else(|| node.fault("`order` of `transpose` names not every axis once"))?;
                chain.is_turned = true;
            }
            "bytes" if !is_bytes => {
                is_bytes = true;
                chain.endian = match configuration.and_then(|c| c.get("endian")).map(Value::as_str) {
                    Some(Some("little")) => Endian::Little,
                    Some(Some("big")) => Endian::Big,
                    None if value_type.byte_len() == 1 => Endian::Little,
                    _ => return Err(node.fault("`endian` of `bytes` is neither `little` nor `big`")),
                };
            }
            "sharding_indexed" if !is_bytes => {
                is_bytes = true;
                let missing = || node.fault("`sharding_indexed` has no `configuration`");
                chain.shard = Some(configuration.ok_or_else(missing)?);
            }
            _ if is_bytes => chain.codecs.push(codec(node, value)?),
            _ => {
                let expected = "transpose, bytes or sharding_indexed first";
                return Err(unsupported(node, format!("the codec `{}`", shorten(name)), expected));
            }
        }
    }
    if is_bytes {
        Ok(chain)
    } else {
        Err(node.fault("`codecs` has none that makes bytes, expected `bytes` or `sharding_indexed`"))
    }
}
