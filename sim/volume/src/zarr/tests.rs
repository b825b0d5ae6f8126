//! Stores that zarr-python wrote (`host-tests/peers/zarr_stores.py`), and faults put into them.

use std::collections::BTreeMap;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use flate2::read::GzDecoder;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use tempfile::TempDir;

use crate::choice::{Choice, NanRule};
use crate::decoded::Decoded;
use crate::mapping::Window;
use crate::open::{Options, load, read, read_colours, read_with};
use crate::values::{ValueType, Values};

const STORES: &[u8] = include_bytes!("tests/stores.json.gz");

/// Voxels of most stores along x, y, z.
const DIMS: [usize; 3] = [9, 6, 5];

/// All stores, in a folder that lives as long as the test; or those whose name has `part`.
pub(crate) fn stores(part: &str) -> TempDir {
    let mut text = String::new();
    GzDecoder::new(STORES).read_to_string(&mut text).unwrap();
    let files: BTreeMap<String, String> = serde_json::from_str(&text).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for (name, hexadecimal) in files.iter().filter(|(name, _)| name.contains(part)) {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        let digits = hexadecimal.as_bytes().chunks(2);
        let bytes: Vec<u8> = digits
            .map(|two| u8::from_str_radix(str::from_utf8(two).unwrap(), 16).unwrap())
            .collect();
        fs::write(path, bytes).unwrap();
    }
    folder
}

/// The value of a voxel, as the writer's head states it.
fn expected(value_type: ValueType, [x, y, z]: [usize; 3]) -> f64 {
    let v = ((3 * x * x + 5 * y + 40 * z + x * y) % 97) as f64;
    match value_type {
        ValueType::F32 | ValueType::F64 => 1.5 * v - 20.0,
        ValueType::I8 | ValueType::I16 | ValueType::I32 | ValueType::I64 => v - 20.0,
        _ => v,
    }
}

fn numbers(values: &Values) -> Vec<f64> {
    let mut numbers = Vec::new();
    values.for_each(|value| {
        numbers.push(value);
        true
    });
    numbers
}

/// Every voxel against `value`.
fn held(decoded: &Decoded, dims: [usize; 3], value: impl Fn([usize; 3]) -> f64) {
    assert_eq!(decoded.dims(), dims, "{}", decoded.name());
    for (index, found) in numbers(decoded.values()).into_iter().enumerate() {
        let at = [index % dims[0], index / dims[0] % dims[1], index / dims[0] / dims[1]];
        assert_eq!(found, value(at), "{} at {at:?}", decoded.name());
    }
}

#[test]
fn every_type_and_codec_is_read() {
    use ValueType::{F32, F64, I8, I16, I32, I64, U8, U16, U32, U64};
    let folder = stores("");
    let stores = [
        ("u2", U16),
        ("u1-gzip", U8),
        ("i2-big-zlib", I16),
        ("i4-zstd-f", I32),
        ("f4-lz4", F32),
        ("f8-bz2", F64),
        ("i1", I8),
        ("u4-big", U32),
        ("i8", I64),
        ("u8", U64),
        ("3-u2", U16),
        ("3-i2-big-gzip", I16),
        ("3-f4-zstd", F32),
        ("3-f8-crc", F64),
        ("3-i4-crc-zstd", I32),
        ("3-u1-blosc", U8),
        ("3-v2-keys", U16),
        ("3-dots", U16),
        ("3-turned", U16),
        ("3-sharded", U16),
        ("3-sharded-start", I32),
        ("3-named", U16),
    ];
    for (name, value_type) in stores {
        let decoded = read(&folder.path().join(format!("{name}.zarr"))).unwrap();
        held(&decoded, DIMS, |at| expected(value_type, at));
        let stored = match value_type {
            // 64-bit integers become 32-bit ones where all fit.
            I64 | U64 => I32,
            other => other,
        };
        assert_eq!(decoded.values().value_type(), stored, "{name}");
        assert_eq!(decoded.notes(), ["the file states no spacing: 1 is assumed"], "{name}");
    }
    for (name, value_type) in [
        ("lz4-bytes", U16),
        ("lz4hc-bits", I32),
        ("blosclz-bytes", U16),
        ("blosclz-bits", U16),
        ("zlib-none", F32),
        ("zlib-bytes", F64),
        ("zstd-bytes", I16),
        ("zstd-bits", U8),
    ] {
        let decoded = read(&folder.path().join(format!("blosc-{name}.zarr"))).unwrap();
        held(&decoded, [10, 8, 9], |at| expected(value_type, at));
    }
    // As zarr-python, a reader of its own, has the sum of the plain bytes.
    let plain = read(&folder.path().join("blosc-plain.zarr")).unwrap();
    assert_eq!((plain.dims(), plain.values().crc32()), (DIMS, 0xfa51_6d96));
}

#[test]
fn voxels_without_a_chunk_have_the_fill_value() {
    let folder = stores("missing");
    let decoded = read(&folder.path().join("missing.zarr")).unwrap();
    held(&decoded, DIMS, |[x, y, z]| {
        if x >= 5 && z < 3 {
            7.0
        } else {
            expected(ValueType::U16, [x, y, z])
        }
    });
    assert!(!folder.path().join("missing.zarr/0.0.1").exists());
    let decoded = read(&folder.path().join("3-sharded-missing.zarr")).unwrap();
    held(&decoded, DIMS, |[x, y, z]| {
        if x < 4 && y < 3 && (2..4).contains(&z) {
            -7.5
        } else {
            expected(ValueType::F32, [x, y, z])
        }
    });
    // A whole shard.
    fs::remove_file(folder.path().join("3-sharded-missing.zarr/c/1/0/0")).unwrap();
    let decoded = read(&folder.path().join("3-sharded-missing.zarr")).unwrap();
    assert_eq!(numbers(decoded.values())[4 * 54..][..8], [-7.5; 8]);
    let metadata = folder.path().join("3-sharded-missing.zarr/zarr.json");
    let text = fs::read_to_string(&metadata).unwrap().replace("-7.5", "\"NaN\"");
    fs::write(&metadata, text).unwrap();
    let path = folder.path().join("3-sharded-missing.zarr");
    let error = read(&path).unwrap_err().to_string();
    assert!(error.contains("is NaN, expected finite numbers only"), "{error}");
    let options = Options {
        choice: Choice {
            nan: NanRule::Background,
            ..Choice::default()
        },
        raw: None,
    };
    assert!(read_with(&path, &options).is_ok());
}

fn chosen(channel: Option<usize>, time: Option<usize>) -> Options {
    Options {
        choice: Choice {
            channel,
            time,
            ..Choice::default()
        },
        raw: None,
    }
}

#[test]
fn levels_channels_and_times_are_chosen() {
    let folder = stores(".ome.zarr");
    for name in ["image4", "image5", "sharded5"] {
        let path = folder.path().join(format!("{name}.ome.zarr"));
        assert!(read_colours(&path, &Choice::default()).unwrap().is_none());
        for (channel, time, more) in [(None, None, 0.0), (Some(2), None, 100.0), (Some(1), Some(2), 1000.0)] {
            let decoded = read_with(&path, &chosen(channel, time)).unwrap();
            held(&decoded, DIMS, |at| more + expected(ValueType::U16, at));
            let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
            let [x, y, z] = decoded.spacing();
            assert!(near(x, 0.5e-3) && near(y, 0.5e-3) && near(z, 2e-3), "{x} {y} {z}");
            let window = if channel == Some(2) {
                [103.0, 190.0]
            } else {
                [3.0, 90.0]
            };
            assert_eq!(decoded.stated_window(), Some(window));
            let notes = decoded.notes().join("\n");
            assert!(
                notes.contains("level 0 of `0`, `1`; the path of another chooses it"),
                "{notes}"
            );
            assert!(
                notes.contains(&format!(
                    "channel {} of 2; `--channel N` chooses another",
                    channel.unwrap_or(1)
                )),
                "{notes}"
            );
            assert!(
                notes.contains(&format!("time point {} of 2; `--time N`", time.unwrap_or(1))),
                "{notes}"
            );
        }
        for (level, times) in [("0", 1), ("1", 2)] {
            let decoded = read_with(&path.join(level), &chosen(Some(2), Some(1))).unwrap();
            let dims = DIMS.map(|side| side.div_ceil(times));
            held(&decoded, dims, |at| {
                100.0 + expected(ValueType::U16, at.map(|i| i * times))
            });
            assert!((decoded.spacing()[2] - 2e-3 * times as f64).abs() < 1e-12);
            assert_eq!(decoded.notes().len(), 2, "{:?}", decoded.notes());
        }
        let loaded = load(Some(&path), Window::Stated).unwrap();
        assert_eq!(loaded.volume.dims, DIMS);
        let message = |path: &Path, options| read_with(path, &options).unwrap_err().to_string();
        let error = message(&path, chosen(Some(3), None));
        assert!(
            error.ends_with("has 2 channels, expected one of them: channel 3 was asked for"),
            "{error}"
        );
        let error = message(&path.join("7"), chosen(None, None));
        assert!(
            error.ends_with("ome.zarr: Zarr: has no level `7`, expected one of `0`, `1`"),
            "{error}"
        );
        let error = message(&path.join("1/none"), chosen(None, None));
        assert!(error.contains("has no level `none`, expected one of none"), "{error}");
    }
}

#[test]
fn a_group_leads_to_its_only_image() {
    let folder = stores("image4");
    let outer = folder.path().join("outer.zarr");
    fs::create_dir(&outer).unwrap();
    fs::write(outer.join(".zgroup"), "{\"zarr_format\": 2}").unwrap();
    fs::rename(folder.path().join("image4.ome.zarr"), outer.join("0")).unwrap();
    let decoded = read(&outer).unwrap();
    assert_eq!(decoded.dims(), DIMS);
    assert_eq!(decoded.notes()[0], "the group's only image is `0`");
    fs::create_dir(outer.join("1")).unwrap();
    fs::write(outer.join("1/.zgroup"), "{\"zarr_format\": 2}").unwrap();
    let error = read(&outer).unwrap_err().to_string();
    assert!(
        error.contains("is a group of `0`, `1`, expected one of them: its path chooses it, like"),
        "{error}"
    );
    let error = read(&outer.join("1")).unwrap_err().to_string();
    assert!(
        error.contains("is a group without an array or `multiscales`, expected an image"),
        "{error}"
    );
}

/// A store whose metadata have one text in place of another.
fn altered(name: &str, file: &str, from: &str, to: &str) -> String {
    let folder = stores(name);
    let path = folder.path().join(name);
    let text = fs::read_to_string(path.join(file)).unwrap();
    let compact: String = text.split_whitespace().collect();
    assert!(compact.contains(from), "{compact}");
    fs::write(path.join(file), compact.replace(from, to)).unwrap();
    read(&path).unwrap_err().to_string()
}

#[test]
fn faults_are_named() {
    let v2 = "u2.zarr";
    for (from, to, message) in [
        (
            "\"<u2\"",
            "\"<f2\"",
            "the dtype `<f2` is not read, expected the dtype <i1",
        ),
        ("\"<u2\"", "\"|u2\"", "the dtype `|u2` is not read"),
        ("\"<u2\"", "[[\"r\",\"|u1\"]]", "the dtype `a structure` is not read"),
        (
            "\"compressor\":null",
            "\"compressor\":{\"id\":\"lzma\"}",
            "the codec `lzma` is not read, expected gzip, zlib",
        ),
        (
            "\"filters\":null",
            "\"filters\":[{\"id\":\"delta\"}]",
            "the filter `delta` is not read, expected no filters",
        ),
        ("[5,6,9]", "[5,6,-9]", "`shape` is not a list of whole numbers above 0"),
        ("[5,6,9]", "[5,6,99999]", "has 99999 voxels along x, expected 1 to 8192"),
        (
            "[5,6,9]",
            "[8192,8192,8000]",
            "has [1600, 1366, 2731] chunks, expected at most 16777216 in all",
        ),
        (
            "[5,6,9]",
            "[5,6,9,2]",
            "4 axes have chunks of 3 and 3, expected as many",
        ),
        ("[3,6,5]", "[3,6,0]", "`chunks` is not a list of whole numbers above 0"),
        ("[3,6,5]", "[3,6,900000000000]", "would take more than 4294967296 bytes"),
        (
            "[3,6,5]",
            "[3,6,4]",
            "0.0.0: Zarr: has more than 144 bytes of values, expected 144",
        ),
        (
            "[3,6,5]",
            "[3,6,6]",
            "0.0.0: Zarr: has 180 bytes of values, expected 216",
        ),
        (
            "\"fill_value\":0",
            "\"fill_value\":70000",
            "`fill_value` is 70000, expected a value of type uint16",
        ),
        ("\"order\":\"C\"", "\"order\":\"Q\"", "`order` is neither `C` nor `F`"),
        (
            "\"zarr_format\":2",
            "\"zarr_format\":4",
            "states 4 `zarr_format`, expected 2",
        ),
        ("\"zarr_format\":2", "\"zarr_format\":", "metadata are no JSON object"),
    ] {
        let error = altered(v2, ".zarray", from, to);
        assert!(error.contains(message), "{error}");
    }
    let sharded = "3-sharded.zarr";
    for (from, to, message) in [
        (
            "\"uint16\"",
            "\"bfloat16\"",
            "the data type `bfloat16` is not read, expected int8",
        ),
        (
            "\"regular\"",
            "\"rectangular\"",
            "the chunk grid `rectangular` is not read",
        ),
        (
            "\"name\":\"zstd\"",
            "\"name\":\"pcodec\"",
            "the codec `pcodec` is not read",
        ),
        (
            "\"name\":\"bytes\",\"configuration\":{\"endian\":\"little\"}},{\"name\":\"zstd\"",
            "\"name\":\"sharding_indexed\",\"configuration\":{}},{\"name\":\"zstd\"",
            "a shard of shards",
        ),
        ("[2,3,4]", "[3,3,4]", "the chunks of a shard do not divide it"),
        (
            "[2,3,4]",
            "[2,6,4]",
            "c/0/0/0: Zarr: the shard's index has not the sum that is stated behind it",
        ),
        ("[4,6,8]", "[4000,6000,8000]", "a shard has more than 1048576 chunks"),
        (
            "\"node_type\":\"array\"",
            "\"node_type\":\"thing\"",
            "`node_type` is thing, expected `array` or `group`",
        ),
    ] {
        let error = altered(sharded, "zarr.json", from, to);
        assert!(error.contains(message), "{error}");
    }
    for (from, to, message) in [
        (
            "\"path\":\"0\"",
            "\"path\":\"../0\"",
            "names the data file `../0`, expected a file in its own folder",
        ),
        (
            "\"path\":\"0\"",
            "\"path\":\"9\"",
            "9: Zarr: has none of zarr.json, .zarray and .zgroup",
        ),
        (
            "[1,1,2.0,0.5,0.25]",
            "[1,1,2.0,0.5]",
            "`scale` is not a list of 5 numbers, one for each axis",
        ),
        (
            "[1,1,2.0,0.5,0.25]",
            "[1,1,2.0,0.5,-0.25]",
            "has spacing -0.0005 along x, expected a length",
        ),
        (
            "\"type\":\"scale\"",
            "\"type\":\"affine\"",
            "the coordinate transformation `affine` is not read",
        ),
        (
            "{\"name\":\"t\",\"type\":\"time\",\"unit\":\"second\"}",
            "{\"name\":\"q\"}",
            "has the axes q 2, c 2, z 5, y 6, x 9, expected z, y and x",
        ),
        (
            "{\"name\":\"c\",\"type\":\"channel\"},",
            "",
            ".zattrs: Zarr: `scale` is not a list of 4 numbers, one for each axis",
        ),
        (
            "{\"name\":\"c\",\"type\":\"channel\"}",
            "{\"name\":\"z\"}",
            "names two axes `z`, expected one",
        ),
    ] {
        let error = altered("image4.ome.zarr", ".zattrs", from, to);
        assert!(error.contains(message), "{error}");
    }
}

#[test]
fn chunks_that_are_damaged_or_no_files_are_named() {
    for (store, chunk, message) in [
        ("u2.zarr", "0.0.1", "0.0.1: Zarr: has 90 bytes of values, expected 180"),
        ("u1-gzip.zarr", "0/0/1", "0/0/1: Zarr: gzip data are damaged"),
        ("i2-big-zlib.zarr", "1.0.0", "zlib data are damaged"),
        ("i4-zstd-f.zarr", "0.0.0", "zstd data are damaged"),
        ("f4-lz4.zarr", "0.0.0", "lz4 data are damaged"),
        ("f8-bz2.zarr", "0.0.0", "bz2 data are damaged"),
        (
            "blosc-zstd-bits.zarr",
            "0.0.0",
            "blosc data are damaged: they end early",
        ),
        ("3-f8-crc.zarr", "c/0/0/0", "crc32c data are damaged: has the sum"),
        ("3-sharded.zarr", "c/0/0/0", "c/0/0/0: Zarr: "),
    ] {
        let folder = stores(store);
        let path = folder.path().join(store);
        let bytes = fs::read(path.join(chunk)).unwrap();
        fs::write(path.join(chunk), &bytes[..bytes.len() / 2]).unwrap();
        let error = read(&path).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
        fs::remove_file(path.join(chunk)).unwrap();
        fs::create_dir(path.join(chunk)).unwrap();
        let error = read(&path).unwrap_err().to_string();
        assert!(error.ends_with("is no regular file, expected a chunk"), "{error}");
    }
    let folder = stores("u2.zarr");
    let path = folder.path().join("u2.zarr");
    for entry in fs::read_dir(&path).unwrap().flatten() {
        if entry.file_name() != ".zarray" {
            fs::remove_file(entry.path()).unwrap();
        }
    }
    let error = read(&path).unwrap_err().to_string();
    assert!(
        error.contains("has none of its 4 chunks, expected some, the first in 0.0.0"),
        "{error}"
    );
    fs::remove_file(path.join(".zarray")).unwrap();
    let error = read(&path).unwrap_err().to_string();
    assert!(
        error.contains("has none of zarr.json, .zarray and .zgroup, expected one of them"),
        "{error}"
    );
}

/// All files below a folder, in order.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().flatten();
    let mut files: Vec<PathBuf> = entries
        .flat_map(|entry| match entry.path() {
            path if path.is_dir() => files(&path),
            path => vec![path],
        })
        .collect();
    files.sort();
    files
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, rng_seed: RngSeed::Fixed(18), ..ProptestConfig::default() })]

    /// Whatever becomes of a file of a store, reading ends with a volume of the stated shape or with one line.
    #[test]
    fn damaged_stores_are_refused_or_read(which in any::<prop::sample::Index>(), places in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4), cut in any::<bool>()) {
        thread_local! {
            static STORES_HERE: (TempDir, Vec<PathBuf>) = {
                let folder = stores("");
                let files = files(folder.path());
                (folder, files)
            };
        }
        STORES_HERE.with(|(folder, files)| {
            let path = &files[which.index(files.len())];
            let sound = fs::read(path).unwrap();
            let mut bytes = sound.clone();
            for (place, byte) in places {
                let at = place.index(bytes.len());
                bytes[at] = byte;
                if cut { bytes.truncate(at.max(1)); }
            }
            fs::write(path, &bytes).unwrap();
            let store = path.ancestors().find(|up| up.parent() == Some(folder.path())).unwrap();
            let result = read(store);
            fs::write(path, &sound).unwrap();
            match result {
                Ok(decoded) => {
                    let [x, y, z] = decoded.dims();
                    prop_assert_eq!(decoded.values().len(), x * y * z);
                }
                Err(error) => prop_assert_eq!(error.to_string().lines().count(), 1),
            }
            Ok(())
        })?;
    }
}
