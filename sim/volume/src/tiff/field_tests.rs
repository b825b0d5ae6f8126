//! What other programs write: channels, time points, stacks behind one directory, units, calibration, white that is 0.

use super::*;
use crate::choice::NanRule;
use crate::values::Values;

/// A file of plain pages of 3 x 2, made byte by byte.
struct Made {
    big_endian: bool,
    description: Vec<u8>,
    /// Pixels per unit, along x and y; none is stated where it is 0.
    resolution: u32,
    resolution_unit: u16,
    white_is_zero: bool,
    /// Bits and sample format.
    form: [u16; 2],
    /// The values of each page, as bytes.
    pages: Vec<Vec<u8>>,
    /// Bytes after the first page's values, before the directories.
    behind: Vec<u8>,
}

impl Made {
    /// Pages of 16-bit values 10 i to 10 i + 5.
    fn new(pages: u16, description: &[u8]) -> Self {
        Self {
            big_endian: false,
            description: description.to_vec(),
            resolution: 0,
            resolution_unit: 1,
            white_is_zero: false,
            form: [16, 1],
            pages: (0..pages)
                .map(|page| values(10 * page).map(u16::to_le_bytes).concat())
                .collect(),
            behind: Vec::new(),
        }
    }

    fn bytes(&self) -> Vec<u8> {
        let short = |v: u16| {
            if self.big_endian {
                v.to_be_bytes()
            } else {
                v.to_le_bytes()
            }
        };
        let long = |v: u32| {
            if self.big_endian {
                v.to_be_bytes()
            } else {
                v.to_le_bytes()
            }
        };
        let magic = if self.big_endian { b"MM" } else { b"II" };
        let mut out = [&magic[..], &short(42), &long(0)].concat();
        let description_at = out.len() as u32;
        out.extend(&self.description);
        out.push(0);
        let resolution_at = out.len() as u32;
        out.extend([long(self.resolution), long(1)].concat());
        let mut places = Vec::new();
        for (index, page) in self.pages.iter().enumerate() {
            places.push(out.len() as u32);
            out.extend(page);
            if index == 0 {
                out.extend(&self.behind);
            }
        }
        let mut link_at = 4;
        for (index, (&place, page)) in places.iter().zip(&self.pages).enumerate() {
            let mut entries = vec![
                (256, 3, 1, [short(3), [0; 2]].concat()),
                (257, 3, 1, [short(2), [0; 2]].concat()),
                (258, 3, 1, [short(self.form[0]), [0; 2]].concat()),
                (259, 3, 1, [short(1), [0; 2]].concat()),
                (262, 3, 1, [short(u16::from(!self.white_is_zero)), [0; 2]].concat()),
            ];
            if index == 0 && !self.description.is_empty() {
                let len = self.description.len() as u32 + 1;
                entries.push((270, 2, len, long(description_at).to_vec()));
            }
            entries.push((273, 4, 1, long(place).to_vec()));
            entries.push((278, 4, 1, long(2).to_vec()));
            entries.push((279, 4, 1, long(page.len() as u32).to_vec()));
            if self.resolution > 0 {
                entries.push((282, 5, 1, long(resolution_at).to_vec()));
                entries.push((283, 5, 1, long(resolution_at).to_vec()));
                entries.push((296, 3, 1, [short(self.resolution_unit), [0; 2]].concat()));
            }
            entries.push((339, 3, 1, [short(self.form[1]), [0; 2]].concat()));
            let at = out.len() as u32;
            out[link_at..link_at + 4].copy_from_slice(&long(at));
            out.extend(short(entries.len() as u16));
            for (tag, kind, count, value) in entries {
                out.extend([&short(tag)[..], &short(kind), &long(count), &value].concat());
            }
            link_at = out.len();
            out.extend(long(0));
        }
        out
    }

    fn read(&self, choice: &Choice) -> Result<Decoded, ReadError> {
        read_bytes(&self.bytes(), "t.tif", choice)
    }

    fn volume(&self) -> Decoded {
        self.read(&Choice::default()).unwrap()
    }

    fn message(&self) -> String {
        self.read(&Choice::default()).unwrap_err().to_string()
    }
}

fn values(first: u16) -> [u16; 6] {
    [0, 1, 2, 3, 4, 5].map(|i| first + i)
}

/// The first value of each slice.
fn firsts(volume: &Decoded) -> Vec<u16> {
    let Values::U16(values) = volume.values() else {
        panic!("{:?}", volume.values().value_type())
    };
    values.iter().step_by(6).copied().collect()
}

fn choose(channel: usize, time: usize) -> Choice {
    Choice {
        channel: Some(channel),
        time: Some(time),
        ..Choice::default()
    }
}

const HYPERSTACK: &[u8] =
    b"ImageJ=1.54f\nimages=12\nchannels=2\nslices=3\nframes=2\nhyperstack=true\nunit=mm\nspacing=2\n";

#[test]
fn imagej_channels_and_time_points_are_told_apart() {
    let made = Made::new(12, HYPERSTACK);
    let volume = made.volume();
    assert_eq!(firsts(&volume), [0, 20, 40]);
    assert_eq!(volume.dims(), [3, 2, 3]);
    let notes = volume.notes().join("\n");
    assert!(
        notes.contains("channel 1 of 2") && notes.contains("time point 1 of 2"),
        "{notes}"
    );
    assert_eq!(firsts(&made.read(&choose(2, 2)).unwrap()), [70, 90, 110]);
    for (choice, expected) in [
        (
            choose(3, 1),
            "t.tif: has 2 channels, expected one of them: channel 3 was asked for",
        ),
        (
            choose(1, 0),
            "t.tif: has 2 time points, expected one of them: time point 0 was asked for",
        ),
    ] {
        assert_eq!(made.read(&choice).unwrap_err().to_string(), expected);
    }
    // Slices that are not stated are what is left of the images.
    let made = Made::new(4, b"ImageJ=1.5\nimages=4\nchannels=2\n");
    assert_eq!(firsts(&made.volume()), [0, 20]);
    let plain = Made::new(2, b"ImageJ=1.5\nimages=2\nslices=2\n");
    let error = plain.read(&choose(2, 1)).unwrap_err().to_string();
    assert!(error.contains("has 1 channel, expected"), "{error}");
    let none = Made::new(2, b"").read(&choose(1, 2)).unwrap_err().to_string();
    assert!(none.contains("has 1 time point, expected"), "{none}");
}

#[test]
fn a_count_that_the_pages_do_not_bear_out_is_refused() {
    let message = Made::new(11, HYPERSTACK).message();
    assert!(message.contains("states 12 images, the file has 11 pages"), "{message}");
    let message = Made::new(1, b"ImageJ=1.5\nimages=0\n").message();
    assert!(message.contains("images = `0`, expected 1 or more"), "{message}");
    let message = Made::new(1, b"ImageJ=1.5\nimages=16777215\nchannels=16777215\nframes=16777215\n").message();
    assert!(
        message.contains("states 281474943156225 images, expected at most 1048576"),
        "{message}"
    );
}

#[test]
fn the_images_behind_one_directory_are_read() {
    for big_endian in [false, true] {
        let mut made = Made::new(
            1,
            b"ImageJ=1.54f\nimages=4\nchannels=2\nslices=2\nunit=mm\nspacing=1.4\n",
        );
        made.big_endian = big_endian;
        let order = |v: u16| if big_endian { v.to_be_bytes() } else { v.to_le_bytes() };
        made.pages = vec![values(0).map(order).concat()];
        made.behind = [10, 20, 30].map(|first| values(first).map(order).concat()).concat();
        let volume = made.volume();
        assert_eq!((firsts(&volume), volume.dims()), (vec![0, 20], [3, 2, 2]));
        assert_eq!(
            volume.values().crc32(),
            Values::U16([values(0), values(20)].concat()).crc32()
        );
        assert_eq!(volume.spacing(), [1.4; 3]);
        assert!(
            volume.notes().contains(&"4 images behind one directory".into()),
            "{:?}",
            volume.notes()
        );
        assert_eq!(firsts(&made.read(&choose(2, 1)).unwrap()), [10, 30]);
    }
    // The directory of 138 bytes stands where the images should.
    let mut short = Made::new(1, b"ImageJ=1.54f\nimages=16\nslices=16\n");
    short.behind = vec![0; 20];
    let message = short.message();
    assert!(
        message.contains("16 images are stated and 1 page is found"),
        "{message}"
    );
    assert!(message.contains("expected 192 for 16 of 3 x 2 uint16"), "{message}");
}

#[test]
fn distances_keep_their_unit_or_their_ratio() {
    let micro = [1e-3 * 0.5, 1e-3 * 0.5, 1e-3 * 2.0];
    for (unit, spacing) in [
        (&b"unit=mm\n"[..], [0.5, 0.5, 2.0]),
        (b"unit=cm\n", [5.0, 5.0, 20.0]),
        (b"unit=nm\n", [0.5e-6, 0.5e-6, 2e-6]),
        (b"unit=inch\n", [12.7, 12.7, 50.8]),
        (b"unit=\xb5m\n", micro),
        (b"unit=\xc2\xb5m\n", micro),
        (b"unit=\xce\xbcm\n", micro),
        (b"unit=\\u00B5m\n", micro),
        (b"unit=micron\n", micro),
        (b"unit=pixel\n", [0.5, 0.5, 2.0]),
        (b"", [0.5, 0.5, 2.0]),
    ] {
        let mut made = Made::new(2, &[b"ImageJ=1.54f\nimages=2\nslices=2\nspacing=-2\n", unit].concat());
        made.resolution = 2;
        let volume = made.volume();
        let unit = String::from_utf8_lossy(unit);
        let close = |i: usize| (volume.spacing()[i] / spacing[i] - 1.0).abs() < 1e-12;
        assert!((0..3).all(close), "{unit}: {:?}", volume.spacing());
        let notes = volume.notes().join("\n");
        assert!(!notes.contains("states no spacing"), "{unit}: {notes}");
        let is_ratio = unit.is_empty() || unit.contains("pixel");
        assert_eq!(
            notes.contains("only the ratio 0.5 : 0.5 : 2 is"),
            is_ratio,
            "{unit}: {notes}"
        );
    }
}

#[test]
fn the_resolution_counts_without_a_description() {
    for (unit, resolution, spacing, note) in [
        (3, 20, [0.5; 3], "no distance between slices"),
        (2, 254, [0.1; 3], "no distance between slices"),
        (1, 4, [0.25; 3], "only the ratio"),
        (1, 1, [1.0; 3], "states no spacing"),
        (1, 0, [1.0; 3], "states no spacing"),
    ] {
        let mut made = Made::new(2, b"");
        (made.resolution, made.resolution_unit) = (resolution, unit);
        let volume = made.volume();
        let close = |i: usize| (volume.spacing()[i] - spacing[i]).abs() < 1e-12;
        assert!((0..3).all(close), "{unit}: {:?}", volume.spacing());
        assert!(volume.notes().join("\n").contains(note), "{unit}: {:?}", volume.notes());
    }
}

#[test]
fn a_linear_calibration_is_applied_and_another_is_told() {
    let text = |more: &str| format!("ImageJ=1.54f\nimages=2\nslices=2\n{more}").into_bytes();
    let volume = Made::new(2, &text("cf=0\nc0=-32768.0\nc1=1.0\nvunit=gray value\n")).volume();
    assert_eq!((volume.value_scale(), volume.value_offset()), (1.0, -32768.0));
    assert!(
        volume.notes()[0].contains("value = -32768 + 1 x stored"),
        "{:?}",
        volume.notes()
    );
    let volume = Made::new(2, &text("cf=0\nc0=2\nc1=-0.5\n")).volume();
    assert_eq!(
        volume.values(),
        &Values::F32((0..6).chain(10..16).map(|v| 2.0 - 0.5 * v as f32).collect())
    );
    for other in [
        "cf=1\nc0=0\nc1=1\nc2=2\n",
        "cf=21\n",
        "cf=0\nc0=1\nc1=0\n",
        "cf=0\nc0=x\nc1=1\n",
    ] {
        let volume = Made::new(2, &text(other)).volume();
        assert_eq!((volume.value_scale(), volume.value_offset()), (1.0, 0.0));
        assert!(
            volume.notes()[0].contains("is not applied"),
            "{other}: {:?}",
            volume.notes()
        );
    }
}

#[test]
fn white_that_is_0_inverts_unsigned_integers_only() {
    for big_endian in [false, true] {
        let mut made = Made::new(0, b"");
        (made.big_endian, made.white_is_zero) = (big_endian, true);
        let floats = [24.0_f32, 1e-8, -3.0, 2424.0, 0.1, 7.0];
        made.form = [32, 3];
        let order = |v: f32| if big_endian { v.to_be_bytes() } else { v.to_le_bytes() };
        made.pages = vec![floats.map(order).concat(); 2];
        let volume = made.volume();
        assert_eq!(volume.values(), &Values::F32([floats, floats].concat()));
        assert!(
            volume.notes().join("\n").contains("taken as stored"),
            "{:?}",
            volume.notes()
        );
        made.form = [16, 2];
        let signed = [-3_i16, 5, 0, 1, 2, 3];
        let order = |v: i16| if big_endian { v.to_be_bytes() } else { v.to_le_bytes() };
        made.pages = vec![signed.map(order).concat()];
        assert_eq!(made.volume().values(), &Values::I16(signed.to_vec()));
        made.form = [8, 1];
        made.pages = vec![vec![0, 1, 2, 3, 254, 255]];
        let volume = made.volume();
        assert_eq!(volume.values(), &Values::U8(vec![255, 254, 253, 252, 1, 0]));
        assert!(
            volume.notes().join("\n").contains("are inverted"),
            "{:?}",
            volume.notes()
        );
    }
}

#[test]
fn nan_is_background_on_demand() {
    let mut made = Made::new(0, b"");
    made.form = [32, 3];
    made.pages = vec![[f32::NAN, 2.0, 3.0, f32::NAN, 1.0, 5.0].map(f32::to_le_bytes).concat()];
    assert!(made.message().contains("`--nan background`"));
    let choice = Choice {
        nan: NanRule::Background,
        ..Choice::default()
    };
    let volume = made.read(&choice).unwrap();
    assert_eq!(volume.values(), &Values::F32(vec![1.0, 2.0, 3.0, 1.0, 1.0, 5.0]));
    assert!(
        volume.notes().join("\n").contains("2 of 6 voxels are NaN"),
        "{:?}",
        volume.notes()
    );
    // A calibration that falls turns the greatest stored value into the least.
    made.description = b"ImageJ=1.5\nimages=1\ncf=0\nc0=0\nc1=-1\n".to_vec();
    let volume = made.read(&choice).unwrap();
    assert_eq!(volume.values(), &Values::F64(vec![-5.0, -2.0, -3.0, -5.0, -1.0, -5.0]));
}

fn ome(pixels: &str, inside: &str) -> Vec<u8> {
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?><OME xmlns=\"http://www.openmicroscopy.org/Schemas/OME/2016-06\">\
         <Image ID=\"Image:0\"><Pixels ID=\"Pixels:0\" Type=\"uint16\" SizeX=\"3\" SizeY=\"2\" {pixels}>{inside}</Pixels></Image></OME>"
    )
    .into_bytes()
}

#[test]
fn ome_states_order_and_sizes() {
    let sizes = "DimensionOrder=\"XYCZT\" SizeC=\"1\" SizeZ=\"2\" SizeT=\"1\" PhysicalSizeX=\"0.5\" PhysicalSizeXUnit=\"\u{b5}m\" \
                 PhysicalSizeY=\"0.25\" PhysicalSizeZ=\"2.0\" PhysicalSizeZUnit=\"mm\"";
    let volume = Made::new(2, &ome(sizes, "<TiffData IFD=\"0\" PlaneCount=\"2\"/>")).volume();
    assert_eq!((volume.spacing(), volume.notes().len()), ([0.0005, 0.00025, 2.0], 0));
    let order = |order: &str| format!("DimensionOrder=\"{order}\" SizeC=\"2\" SizeZ=\"3\" SizeT=\"1\"");
    for (text, second) in [
        ("XYCZT", [10, 30, 50]),
        ("XYZCT", [30, 40, 50]),
        ("XYTZC", [30, 40, 50]),
    ] {
        for inside in ["", "<TiffData/>"] {
            let made = Made::new(6, &ome(&order(text), inside));
            assert_eq!(firsts(&made.read(&choose(2, 1)).unwrap()), second, "{text}");
        }
    }
    // Planes in an order of their own.
    let blocks: String = (0..6)
        .map(|i| {
            format!(
                "<TiffData IFD=\"{i}\" FirstC=\"{}\" FirstZ=\"{}\"/>",
                1 - i / 3,
                2 - i % 3
            )
        })
        .collect();
    let made = Made::new(6, &ome(&order("XYCZT"), &blocks));
    assert_eq!(firsts(&made.volume()), [50, 40, 30]);
    let pixel = "SizeZ=\"2\" PhysicalSizeX=\"1\" PhysicalSizeXUnit=\"pixel\" PhysicalSizeY=\"1\" PhysicalSizeYUnit=\"pixel\" \
                 PhysicalSizeZ=\"3\" PhysicalSizeZUnit=\"pixel\"";
    let volume = Made::new(2, &ome(pixel, "")).volume();
    assert_eq!(volume.spacing(), [1.0, 1.0, 3.0]);
    assert!(
        volume.notes()[0].contains("only the ratio 1 : 1 : 3 is"),
        "{:?}",
        volume.notes()
    );
}

#[test]
fn ome_that_does_not_fit_the_pages_is_refused() {
    let three = "SizeC=\"1\" SizeZ=\"3\" SizeT=\"1\"";
    for (text, expected) in [
        (ome(three, ""), "states 3 images, the file has 2 pages"),
        (
            ome(three, "<TiffData IFD=\"0\" PlaneCount=\"3\"/>"),
            "names page 3, the file has 2",
        ),
        (ome(three, "<TiffData IFD=\"0\"/>"), "names no page for 2 of 3 planes"),
        (
            ome(three, "<TiffData IFD=\"0\" FirstZ=\"3\"/>"),
            "places a plane outside its own sizes",
        ),
        (
            ome(three, "<TiffData IFD=\"x\"/>"),
            "IFD = `x`, expected a whole number",
        ),
        (
            ome(
                three,
                "<TiffData><UUID FileName=\"a\"/></TiffData><TiffData><UUID FileName=\"b\"/></TiffData>",
            ),
            "in 2 files, expected all in this one",
        ),
        (ome("SizeZ=\"0\"", ""), "states SizeZ = `0`"),
        (
            ome("SizeZ=\"99999\" SizeC=\"99999\"", ""),
            "images, expected at most 1048576",
        ),
        (ome("DimensionOrder=\"XYZZT\"", ""), "DimensionOrder that is none"),
        (b"<?xml version=\"1.0\"?><OME><Image>".to_vec(), "OME-XML is damaged"),
        (b"<OME></OME>".to_vec(), "states no `Pixels`"),
        (
            b"<!DOCTYPE a [<!ENTITY b \"c\">]><OME>&b;</OME>".to_vec(),
            "OME-XML is damaged",
        ),
    ] {
        let message = Made::new(2, &text).message();
        assert!(
            message.starts_with("t.tif: TIFF: ") && message.contains(expected),
            "{expected}: {message}"
        );
        assert!(!message.contains('\n'));
    }
}

#[test]
fn a_shape_of_four_axes_is_several_volumes() {
    let made = Made::new(6, b"{\"shape\": [2, 3, 2, 3]}");
    assert_eq!(firsts(&made.volume()), [0, 10, 20]);
    assert_eq!(firsts(&made.read(&choose(1, 2)).unwrap()), [30, 40, 50]);
    for other in [
        "{\"shape\": [6, 2, 3]}",
        "{\"shape\": [6, 2, 3, 1]}",
        "{\"shape\": [2, 3, 9, 9]}",
        "{\"shape\": [x]}",
    ] {
        assert_eq!(Made::new(6, other.as_bytes()).volume().dims(), [3, 2, 6], "{other}");
    }
}

#[test]
fn other_systems_files_in_a_folder_are_passed_over() {
    let folder = tempfile::tempdir().unwrap();
    for (index, name) in ["s0.tif", "s1.tif"].iter().enumerate() {
        let mut made = Made::new(1, b"ImageJ=1.5\nunit=mm\nspacing=2\n");
        made.resolution = 1;
        made.pages = vec![values(10 * index as u16).map(u16::to_le_bytes).concat()];
        // Bytes behind the values are padding.
        made.behind = vec![0xee; 7];
        std::fs::write(folder.path().join(name), made.bytes()).unwrap();
        std::fs::write(folder.path().join(format!("._{name}")), b"\0\x05\x16\x07 AppleDouble").unwrap();
    }
    std::fs::write(folder.path().join(".DS_Store"), b"\0\0\0\x01Bud1").unwrap();
    std::fs::write(folder.path().join("Thumbs.db"), b"\xd0\xcf\x11\xe0").unwrap();
    let volume = crate::open::read(folder.path()).unwrap();
    assert_eq!((firsts(&volume), volume.spacing()), (vec![0, 10], [1.0, 1.0, 2.0]));
    let notes = volume.notes().join("\n");
    assert!(
        notes.contains("2 files whose names begin with a dot are passed over"),
        "{notes}"
    );
}
