//! Parts of a volume on disk against the same volume read whole.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::*;
use crate::choice::Choice;
use crate::meaning::Modality;
use crate::open::load_with;
use crate::raw::RawShape;
use crate::raw::describe::Description;
use crate::values::{Endian, ValueType};

fn open(path: &Path, window: Window, options: &Options) -> Result<(Loaded, OnDisk), LoadError> {
    OnDisk::open(path, window, options, &|_, _| {})
}

/// Parts and what is known of the volume against the same of the whole, which both have to be refused or neither.
fn held(path: &Path, window: Window, options: &Options, corner: [usize; 3]) -> Result<(), TestCaseError> {
    let (whole, (loaded, on_disk)) = match (load_with(Some(path), window, options), open(path, window, options)) {
        (Ok(whole), Ok(opened)) => (whole, opened),
        (Err(whole), Err(part)) => {
            prop_assert_eq!(whole.to_string(), part.to_string());
            return Ok(());
        }
        (whole, part) => {
            return Err(TestCaseError::fail(format!(
                "one is refused: {:?} and {:?}",
                whole.err().map(|error| error.to_string()),
                part.err().map(|error| error.to_string())
            )));
        }
    };
    prop_assert_eq!(whole.report, loaded.report);
    prop_assert_eq!(&whole.labels, &loaded.labels);
    prop_assert_eq!(&whole.statistics, &loaded.statistics);
    prop_assert_eq!(&whole.orientation, &loaded.orientation);
    prop_assert_eq!((whole.integers, whole.modality), (loaded.integers, loaded.modality));
    let said = |notes: &[String]| {
        let other = |note: &&String| !note.contains("scratch file") && !note.starts_with("the data are in");
        notes.iter().filter(other).cloned().collect::<Vec<_>>()
    };
    prop_assert_eq!(said(&whole.notes), said(&loaded.notes));
    let dims = whole.volume.dims;
    prop_assert_eq!(on_disk.dims(), dims);
    prop_assert_eq!(
        &on_disk.read([0; 3], dims, None).unwrap().0.voxels,
        &whole.volume.voxels
    );
    let first = [0, 1, 2].map(|axis| corner[axis] % dims[axis]);
    let sides = [0, 1, 2].map(|axis| 1 + corner[2 - axis] % (dims[axis] - first[axis]));
    let (part, read) = on_disk.read(first, sides, None).unwrap();
    prop_assert_eq!(read, part.voxels.len() as u64);
    // Voxels of strips that are not wanted have a code of their strip; here, where one range alone is seen.
    let seen = 1000 + corner[0] as u16;
    let wanted = on_disk.wanted(|[low, high]| low <= seen && seen <= high);
    let (few, read) = on_disk.read(first, sides, Some(&wanted)).unwrap();
    let other = few
        .voxels
        .iter()
        .zip(&part.voxels)
        .filter(|(few, all)| few != all)
        .count();
    prop_assert!(other as u64 <= part.voxels.len() as u64 - read);
    prop_assert!(
        few.voxels
            .iter()
            .zip(&part.voxels)
            .all(|(few, all)| few == all || (*all < seen) == (*few < seen))
    );
    prop_assert_eq!((part.dims, part.spacing), (sides, whole.volume.spacing));
    prop_assert_eq!(part.mapping, whole.volume.mapping);
    for (index, code) in part.voxels.iter().enumerate() {
        let at = [
            index % sides[0],
            index / sides[0] % sides[1],
            index / sides[0] / sides[1],
        ];
        let [x, y, z] = [0, 1, 2].map(|axis| first[axis] + at[axis]);
        prop_assert_eq!(*code, whole.volume.voxels[x + dims[0] * (y + dims[1] * z)]);
    }
    Ok(())
}

/// Bytes of values of a kind: noise, labels in runs, or a few outliers on a ramp.
fn bytes(value_type: ValueType, endian: Endian, kind: usize, count: usize, seed: u64) -> Vec<u8> {
    let mut state = seed | 1;
    let mut next = || {
        state = state
            .wrapping_mul(0x5851_f42d_4c95_7f2d)
            .wrapping_add(1442695040888963407);
        (state >> 33) as i64
    };
    let value = |index: usize, noise: i64| match kind {
        0 => noise % 30_000 - 9_000,
        1 => [0, 0, 3, 90, 0, 41_000][index / 7 % 6],
        2 if index % 499 == 17 => 2_000_000,
        2 => noise % 5_000 - 1_500,
        // Labels that are told by equal neighbours alone, along the file's x.
        4 => index as i64 / 5 % 120,
        _ => noise % 200,
    };
    let mut out = Vec::new();
    for index in 0..count {
        let value = value(index, next());
        let little = match value_type {
            ValueType::I8 => (value as i8).to_le_bytes().to_vec(),
            ValueType::U8 => (value as u8).to_le_bytes().to_vec(),
            ValueType::I16 => (value as i16).to_le_bytes().to_vec(),
            ValueType::U16 => (value as u16).to_le_bytes().to_vec(),
            ValueType::I32 => (value as i32).to_le_bytes().to_vec(),
            ValueType::U32 => (value as u32).to_le_bytes().to_vec(),
            ValueType::I64 => value.to_le_bytes().to_vec(),
            ValueType::U64 => (value as u64).to_le_bytes().to_vec(),
            ValueType::F32 => (value as f32 * if kind == 0 { 0.37 } else { 1.0 })
                .to_le_bytes()
                .to_vec(),
            ValueType::F64 => (value as f64 * if kind == 0 { 0.37 } else { 1.0 })
                .to_le_bytes()
                .to_vec(),
        };
        match endian {
            Endian::Little => out.extend(little),
            Endian::Big => out.extend(little.into_iter().rev()),
        }
    }
    out
}

const TYPES: [ValueType; 10] = [
    ValueType::I8,
    ValueType::U8,
    ValueType::I16,
    ValueType::U16,
    ValueType::I32,
    ValueType::U32,
    ValueType::I64,
    ValueType::U64,
    ValueType::F32,
    ValueType::F64,
];

/// Signed axes in an order.
fn directions(order: usize, signs: usize) -> [[f64; 3]; 3] {
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    [0, 1, 2].map(|axis| {
        let mut direction = [0.0; 3];
        direction[orders[order % 6][axis]] = if signs >> axis & 1 == 1 { -1.0 } else { 1.0 };
        direction
    })
}

fn file(folder: &tempfile::TempDir, name: &str, parts: &[&[u8]]) -> PathBuf {
    let path = folder.path().join(name);
    fs::write(&path, parts.concat()).unwrap();
    path
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 250, rng_seed: RngSeed::Fixed(8192), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn parts_of_raw_files_are_those_of_the_whole(
        value_type in prop::sample::select(&TYPES[..]),
        big in any::<bool>(),
        kind in 0_usize..5,
        dims in prop::array::uniform3(1_u64..17),
        skip in 0_u64..9,
        turn in prop::option::of((0_usize..6, 0_usize..8)),
        offset in prop::sample::select(&[0.0, -1024.0, 0.5][..]),
        scale in prop::sample::select(&[1.0, 1.0, 0.25][..]),
        modality in prop::option::of(Just(Modality::Ct)),
        window in prop::sample::select(&[
            Window::Auto,
            Window::Auto,
            Window::Stated,
            Window::Range { low: -200.0, high: 3000.0 },
            Window::Range { low: 5.0, high: 5.0 },
            Window::Percentile { low: 1.0, high: 98.0 },
        ][..]),
        corner in prop::array::uniform3(0_usize..1000),
        seed in any::<u64>(),
    ) {
        let endian = if big { Endian::Big } else { Endian::Little };
        let count = dims.iter().product::<u64>() as usize;
        let folder = tempfile::tempdir().unwrap();
        let values = bytes(value_type, endian, kind, count, seed);
        let path = file(&folder, "v.raw", &[&vec![9; skip as usize], &values]);
        let description = Description {
            shape: RawShape { dims, spacing: [1.0, 2.0, 3.0], value_type, endian, skip },
            scale,
            offset,
            modality,
            directions: turn.map(|(order, signs)| directions(order, signs)),
        };
        let options = Options { choice: Choice::default(), raw: Some(description) };
        held(&path, window, &options, corner)?;
    }
}

#[test]
fn attached_packed_and_many_files_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let values = bytes(ValueType::I16, Endian::Little, 0, 6 * 5 * 4, 77);
    let check = |path: &Path| held(path, Window::Auto, &Options::default(), [2, 1, 3]).unwrap();
    let nrrd = |encoding: &str, rest: &str| {
        format!(
            "NRRD0004\ntype: short\ndimension: 3\nsizes: 6 5 4\nendian: little\nencoding: {encoding}\nspace: RAS\n\
             space directions: (0,0.5,0) (1,0,0) (0,0,-2)\n{rest}\n"
        )
    };
    check(&file(&folder, "a.nrrd", &[nrrd("raw", "").as_bytes(), &values]));
    let mut gzip = GzEncoder::new(Vec::new(), Compression::fast());
    gzip.write_all(&values).unwrap();
    let packed = gzip.finish().unwrap();
    let path = file(&folder, "b.nrrd", &[nrrd("gzip", "").as_bytes(), &packed]);
    check(&path);
    let (loaded, on_disk) = open(&path, Window::Auto, &Options::default()).unwrap();
    assert!(loaded.notes.iter().any(|note| note.contains("240 bytes are unpacked")));
    drop(on_disk);
    let names: String = (0..4).map(|k| format!("s{k}.raw\n")).collect();
    for (k, slice) in values.chunks(60).enumerate() {
        file(&folder, &format!("s{k}.raw"), &[slice]);
    }
    check(&file(
        &folder,
        "c.nhdr",
        &[nrrd("raw", &format!("data file: LIST\n{names}")).as_bytes()],
    ));
    let mut zlib = ZlibEncoder::new(Vec::new(), Compression::fast());
    zlib.write_all(&values).unwrap();
    let meta = "NDims = 3\nDimSize = 6 5 4\nElementType = MET_SHORT\nElementSpacing = 1 1 2\nCompressedData = True\n\
                ElementDataFile = LOCAL\n";
    check(&file(&folder, "d.mha", &[meta.as_bytes(), &zlib.finish().unwrap()]));
    // A slice that ends early, a stream that is damaged.
    file(&folder, "s2.raw", &[&values[..59]]);
    check(&folder.path().join("c.nhdr"));
    check(&file(
        &folder,
        "e.nrrd",
        &[nrrd("gzip", "").as_bytes(), &packed[..packed.len() / 2]],
    ));
}

#[test]
fn what_is_read_whole_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |path: &Path, options: &Options| open(path, Window::Auto, options).unwrap_err().to_string();
    let plain = Options::default();
    assert!(refused(folder.path(), &plain).ends_with("expected raw, NRRD, MetaImage, NIfTI or Zarr"));
    let text = "NRRD0004\ntype: short\ndimension: 3\nsizes: 2 1 1\nencoding: ascii\n\n3 4\n";
    assert!(refused(&file(&folder, "t.nrrd", &[text.as_bytes()]), &plain).contains("the values are text"));
    let raw = |scale| Options {
        raw: Some(Description {
            shape: RawShape {
                dims: [2, 1, 1],
                spacing: [1.0; 3],
                value_type: ValueType::F32,
                endian: Endian::Little,
                skip: 0,
            },
            scale,
            offset: 0.0,
            modality: None,
            directions: None,
        }),
        ..Options::default()
    };
    let path = file(&folder, "f.raw", &[&1.5_f32.to_le_bytes(), &f32::NAN.to_le_bytes()]);
    assert!(refused(&path, &raw(-1.0)).contains("read whole"));
    assert!(refused(&path, &raw(1.0)).contains("voxel (1, 0, 0) is NaN"));
    let mut background = raw(1.0);
    background.choice.nan = NanRule::Background;
    assert!(refused(&path, &background).contains("--nan background: voxel (1, 0, 0) is NaN"));
}

#[test]
fn volumes_beyond_memory_are_opened() {
    let folder = tempfile::tempdir().unwrap();
    // A file with a hole: 4 GiB and a slice of zeros, of which the disk has none.
    let path = folder.path().join("hole.raw");
    let dims = [2048, 1025, 2048];
    let file = fs::File::create(&path).unwrap();
    file.set_len(dims.iter().product()).unwrap();
    let whole = load_with(Some(&path), Window::Auto, &hole(dims));
    assert!(whole.unwrap_err().to_string().contains("--memory"));
    let short = open(&path, Window::Auto, &hole([2048, 1025, 2049]));
    assert!(
        short
            .unwrap_err()
            .to_string()
            .contains("expected 4301260800 for 2048 x 1025 x 2049 uint8")
    );
}

/// A raw file of bytes.
fn hole(dims: [u64; 3]) -> Options {
    Options {
        raw: Some(Description {
            shape: RawShape {
                dims,
                spacing: [1.0; 3],
                value_type: ValueType::U8,
                endian: Endian::Little,
                skip: 0,
            },
            scale: 1.0,
            offset: 0.0,
            modality: None,
            directions: None,
        }),
        ..Options::default()
    }
}

/// Values as a store of Zarr 2 in plain chunks.
fn chunked(folder: &Path, dims: [usize; 3], side: [usize; 3], dtype: &str, values: &[Vec<u8>]) {
    let list = |[x, y, z]: [usize; 3]| format!("[{z},{y},{x}]");
    let (shape, chunks) = (list(dims), list(side));
    let metadata = format!(
        "{{\"zarr_format\":2,\"shape\":{shape},\"chunks\":{chunks},\"dtype\":\"{dtype}\",\"compressor\":null,\"fill_value\":0,\
         \"order\":\"C\",\"filters\":null}}"
    );
    fs::write(folder.join(".zarray"), metadata).unwrap();
    let cut = store::Blocks { dims, side };
    for number in 0..cut.len() {
        let place = cut.place(number);
        let mut chunk = Vec::new();
        for (z, y, x) in (0..side[2]).flat_map(|z| (0..side[1]).flat_map(move |y| (0..side[0]).map(move |x| (z, y, x))))
        {
            let at = [x, y, z];
            let [x, y, z] = [0, 1, 2].map(|axis| place[axis] * side[axis] + at[axis]);
            let inside = x < dims[0] && y < dims[1] && z < dims[2];
            let value = if inside {
                &values[(z * dims[1] + y) * dims[0] + x]
            } else {
                &values[0]
            };
            chunk.extend_from_slice(value);
        }
        let [x, y, z] = place;
        fs::write(folder.join(format!("{z}.{y}.{x}")), chunk).unwrap();
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, rng_seed: RngSeed::Fixed(19), ..ProptestConfig::default() })]

    /// Chunks of any size against the whole: noise, and labels whose runs cross the chunks' faces.
    #[test]
    fn chunks_are_the_whole(
        dims in prop::array::uniform3(1_usize..14), side in prop::array::uniform3(1_usize..9), corner in prop::array::uniform3(0_usize..100),
        kind in 0_usize..4, run in 1_usize..9, seed in any::<u32>(),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let count = dims.iter().product::<usize>();
        let mix = |index: usize| (index as u32 ^ seed).wrapping_mul(0x9e37_79b9) >> 7;
        let label = |index: usize| if mix(index / run) % 3 == 0 { 0 } else { mix(index / run) % 900 };
        let (dtype, values): (_, Vec<Vec<u8>>) = match kind {
            0 => ("<u2", (0..count).map(|i| (mix(i) as u16 % 3000).to_le_bytes().to_vec()).collect()),
            1 => (">i2", (0..count).map(|i| (label(i) as i16).to_be_bytes().to_vec()).collect()),
            2 => ("<f4", (0..count).map(|i| (mix(i) as f32 / 1000.0).to_le_bytes().to_vec()).collect()),
            _ => ("<i8", (0..count).map(|i| i64::from(label(i)).to_le_bytes().to_vec()).collect()),
        };
        chunked(folder.path(), dims, side, dtype, &values);
        held(folder.path(), Window::Auto, &Options::default(), corner)?;
        let (_, on_disk) = open(folder.path(), Window::Auto, &Options::default()).unwrap();
        let [read, all] = on_disk.chunks_read().unwrap();
        if kind < 2 {
            prop_assert_eq!(read, all);
        }
        on_disk.read([0; 3], dims, None).unwrap();
        prop_assert_eq!(on_disk.chunks_read().unwrap()[0], read + all);
    }
}

#[test]
fn stores_of_every_kind_are_read_in_parts() {
    let folder = crate::zarr::tests::stores("");
    for entry in fs::read_dir(folder.path()).unwrap().flatten() {
        for corner in [[0; 3], [3, 1, 2], [8, 5, 4]] {
            held(&entry.path(), Window::Auto, &Options::default(), corner).unwrap();
        }
    }
}

/// Strips that are read beside strips that are left out, in slices of several.
#[test]
fn strips_are_read_where_they_lie() {
    let folder = tempfile::tempdir().unwrap();
    let dims = [5, 75, 12];
    let values: Vec<Vec<u8>> = (0..dims.iter().product::<usize>())
        .map(|index| {
            let (y, z) = (index / 5 % 75, index / 375);
            let code = if z == 6 && y / 16 == 2 {
                3000
            } else {
                10 + (index % 97) as u16
            };
            code.to_le_bytes().to_vec()
        })
        .collect();
    let raw = folder.path().join("v_5x75x12_uint16.raw");
    fs::write(&raw, values.concat()).unwrap();
    let store = folder.path().join("v.zarr");
    fs::create_dir(&store).unwrap();
    chunked(&store, dims, [2, 20, 2], "<u2", &values);
    for path in [raw, store] {
        let (loaded, on_disk) = open(&path, Window::Auto, &Options::default()).unwrap();
        assert_eq!(loaded.volume.dims, dims);
        let whole = load_with(Some(&path), Window::Auto, &Options::default())
            .unwrap()
            .volume;
        let wanted = on_disk.wanted(|[_, high]| high >= 3000);
        let cut = *on_disk.strips.cut();
        for (first, sides) in [([0; 3], dims), ([1, 9, 2], [3, 60, 9]), ([0, 30, 6], [5, 7, 1])] {
            let (part, read) = on_disk.read(first, sides, Some(&wanted)).unwrap();
            let (mut expected, mut seen) = (Vec::new(), 0);
            for (z, y, x) in
                (0..sides[2]).flat_map(|z| (0..sides[1]).flat_map(move |y| (0..sides[0]).map(move |x| (z, y, x))))
            {
                let at = [first[0] + x, first[1] + y, first[2] + z];
                let strip = cut.number([0, 1, 2].map(|axis| at[axis] / cut.side[axis]));
                seen += u64::from(wanted.has(strip));
                expected.push(if wanted.has(strip) {
                    whole.voxels[(at[2] * dims[1] + at[1]) * dims[0] + at[0]]
                } else {
                    on_disk.strips.least(strip)
                });
            }
            assert!(part.voxels == expected, "{}, {first:?}", path.display());
            assert_eq!(read, seen);
        }
        assert!((0..cut.len()).any(|strip| wanted.has(strip)) && !(0..cut.len()).all(|strip| wanted.has(strip)));
    }
}
