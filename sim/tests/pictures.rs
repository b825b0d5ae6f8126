//! Pictures as a first hour meets them: no empty one without a word, sharp at any size, one scale in a turn, and files
//! that hold what was asked for.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

/// A folder with volumes.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes an NRRD of signed 16-bit voxels given by their places.
    fn volume(&self, name: &str, dims: [usize; 3], spacing: &str, voxel: impl Fn([usize; 3]) -> i16) {
        let [nx, ny, nz] = dims;
        let head = format!(
            "NRRD0004\ntype: int16\ndimension: 3\nsizes: {nx} {ny} {nz}\nspacings: {spacing}\nendian: little\nencoding: raw\n\n"
        );
        let voxels = (0..nx * ny * nz).map(|index| voxel([index % nx, index / nx % ny, index / (nx * ny)]));
        let bytes: Vec<u8> = head.bytes().chain(voxels.flat_map(i16::to_le_bytes)).collect();
        fs::write(self.path(name), bytes).unwrap();
    }

    fn run(&self, line: &str) -> Output {
        Command::new(env!("CARGO_BIN_EXE_slicecast"))
            .args(line.split_whitespace())
            .current_dir(self.0.path())
            .output()
            .unwrap()
    }

    /// What is said on standard error by a command that succeeds.
    fn says(&self, line: &str) -> String {
        let output = self.run(line);
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{line}: {text}");
        text
    }

    fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap()
    }

    fn picture(&self, name: &str) -> Picture {
        Picture::decode(&self.read(name))
    }

    /// The names in the folder.
    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<_> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

/// A decoded PNG.
struct Picture {
    width: usize,
    height: usize,
    channels: usize,
    /// Channels, 0 to 1.
    values: Vec<f64>,
    /// Keys of text chunks.
    keys: Vec<String>,
    frames: u32,
}

impl Picture {
    fn decode(bytes: &[u8]) -> Self {
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut values = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut values).unwrap();
        let info = reader.info();
        let values = match info.bit_depth {
            png::BitDepth::Eight => values.iter().map(|v| f64::from(*v) / 255.0).collect(),
            png::BitDepth::Sixteen => {
                let wide = values.as_chunks().0.iter();
                wide.map(|v| f64::from(u16::from_be_bytes(*v)) / 65535.0).collect()
            }
            depth => panic!("{depth:?}"),
        };
        Self {
            width: info.width as usize,
            height: info.height as usize,
            channels: info.color_type.samples(),
            values,
            keys: info
                .uncompressed_latin1_text
                .iter()
                .map(|text| text.keyword.clone())
                .collect(),
            frames: info.animation_control.map_or(1, |control| control.num_frames),
        }
    }

    /// Whether each pixel is brighter than 8 of 255.
    fn lit(&self) -> impl Iterator<Item = bool> {
        let seen = |pixel: &[f64]| pixel.iter().any(|value| *value > 8.0 / 255.0);
        self.values.chunks(self.channels).map(seen)
    }

    fn share(&self) -> f64 {
        self.lit().filter(|lit| *lit).count() as f64 / (self.width * self.height) as f64
    }

    /// Rows with anything in them.
    fn rows(&self) -> usize {
        let lit: Vec<bool> = self.lit().collect();
        lit.chunks(self.width).filter(|row| row.contains(&true)).count()
    }

    /// The largest difference of two pictures of one size, in steps of 255.
    fn difference(&self, other: &[f64]) -> f64 {
        assert_eq!(self.values.len(), other.len());
        let differences = self.values.iter().zip(other).map(|(a, b)| (a - b).abs() * 255.0);
        differences.fold(0.0, f64::max)
    }
}

/// A ball of 900 in its middle and 650 at its border, in a soft shell, on 0.
fn ball([x, y, z]: [usize; 3]) -> i16 {
    // Off the grid, so that there are many values.
    let radius = (x as f64 - 9.5).hypot(y as f64 - 9.3).hypot(z as f64 - 9.1);
    ((900.0 - 3.0 * radius * radius) * (9.0 - radius).clamp(0.0, 1.0)) as i16
}

/// What a scene needs beside its transfer function.
const WHITE: &str = "[transfer]\npoints = [\n{ value = 1.0, colour = \"#ffffff\", opacity = 0.0 },\n{ value = 800.0, colour = \"#ffffff\", opacity = 1.0 },\n]\n";

#[test]
fn empty_pictures_say_why_and_what_to_do() {
    let folder = Folder::new();
    folder.volume("ball.nrrd", [20; 3], "1 1 1", ball);
    folder.volume("dim.nrrd", [20; 3], "1 1 1", |place| ball(place) / 5);
    folder.volume("small.nrrd", [20; 3], "1e-4 1e-4 1e-4", ball);
    folder.volume("slice.nrrd", [20, 20, 1], "1 1 1", |[x, y, _]| ball([x, y, 9]));
    fs::write(folder.path("white.toml"), WHITE).unwrap();
    fs::write(
        folder.path("high.toml"),
        WHITE
            .replace("1.0, colour", "2000.0, colour")
            .replace("800.0", "3000.0"),
    )
    .unwrap();
    fs::write(
        folder.path("thin.toml"),
        WHITE.replace("opacity = 1.0", "opacity = 0.1"),
    )
    .unwrap();
    for (line, said) in [
        (
            "render ball.nrrd --scene high.toml",
            "warning: the picture shows nothing: no value between 0 and 898 is visible, the transfer function is for \
             others: of the values that have a code it shows 2001 to 4095; `--scene mr` fits the values",
        ),
        (
            "render dim.nrrd --scene ct-bone",
            "this scene is for Hounsfield units, which the file does not have",
        ),
        (
            "render small.nrrd --scene thin.toml",
            "warning: the picture shows nothing: opacities are meant for a length of 1, and the volume is 0.0034641 from \
             corner to corner; `--unit-distance 0.0001` means them for one voxel",
        ),
        (
            "turntable small.nrrd --scene thin.toml --frames 3",
            "warning: 3 of 3 pictures: the picture shows nothing: opacities are meant for",
        ),
        (
            "compare slice.nrrd --scene white.toml --borders whole --elevation 30",
            "warning: the picture shows nothing: one slice along z has no thickness",
        ),
        (
            "render ball.nrrd --scene white.toml --background white --unlit",
            "has the colour of the background, or no light falls on it; `--background`, `--light` and `--unlit` change that",
        ),
    ] {
        let text = folder.says(&format!(
            "{line} {}",
            if line.starts_with("compare") {
                "--simd scalar"
            } else {
                "--force"
            }
        ));
        assert!(text.contains(said), "{line}: {text}");
    }
    for line in [
        "render ball.nrrd --scene white.toml --force",
        "render small.nrrd --scene thin.toml --unit-distance 0.0001 --force",
        "turntable ball.nrrd --scene white.toml --frames 3 --force",
    ] {
        let text = folder.says(line);
        assert!(!text.contains("warning"), "{line}: {text}");
    }
}

#[test]
fn one_slice_shows_something_from_every_side() {
    let folder = Folder::new();
    let slices: [(&str, [usize; 3]); 3] = [("x", [1, 20, 20]), ("y", [20, 1, 20]), ("z", [20, 20, 1])];
    fs::write(folder.path("white.toml"), WHITE).unwrap();
    for (axis, dims) in slices {
        let place = |[x, y, z]: [usize; 3]| match axis {
            "x" => ball([9, y, z]),
            "y" => ball([x, 9, z]),
            _ => ball([x, y, 9]),
        };
        folder.volume("slice.nrrd", dims, "1 1 1", place);
        for angles in ["0 0", "0 10", "0 50", "90 0", "37 -20", "0 90"] {
            for borders in ["cells", "nodes", "whole"] {
                let (azimuth, elevation) = angles.split_once(' ').unwrap();
                let text = folder.says(&format!(
                    "render slice.nrrd --scene white.toml --azimuth {azimuth} --elevation {elevation} --force \
                     --borders {borders}"
                ));
                let noted = text.contains(&format!("note: one slice along {axis} has no thickness"));
                assert_eq!(noted, borders != "cells", "{borders}: {text}");
                let picture = folder.picture("image.png");
                assert!(
                    picture.share() > 0.01,
                    "{axis}, {angles}, {borders}: {}",
                    picture.share()
                );
            }
        }
    }
}

#[test]
fn a_turn_has_one_scale() {
    let folder = Folder::new();
    // A cube of 16 voxels off the axis, in a box that is longer than wide.
    folder.volume("cube.nrrd", [60, 24, 32], "1 1 1", |place| {
        i16::from(place.iter().all(|c| (4..20).contains(c))) * 900
    });
    fs::write(folder.path("white.toml"), WHITE).unwrap();
    for size in ["", " --size 300x260"] {
        folder.says(&format!(
            "turntable cube.nrrd --scene white.toml --unlit --numbered --frames 8 -o frames/f.png --force{size}"
        ));
        let frames: Vec<Picture> = (0..8)
            .map(|n| folder.picture(&format!("frames/f-{n:03}.png")))
            .collect();
        let rows: Vec<usize> = frames.iter().map(Picture::rows).collect();
        let (least, most) = (rows.iter().min().unwrap(), rows.iter().max().unwrap());
        // Half a pixel at each end.
        assert!(most - least <= 1, "{rows:?}");
        assert!(*least > 60, "{rows:?}");
        assert!(
            frames
                .iter()
                .all(|frame| (frame.width, frame.height) == (frames[0].width, frames[0].height))
        );
    }
    folder.says("turntable cube.nrrd --scene white.toml --frames 3 --background none -o turn.png");
    let turn = folder.picture("turn.png");
    assert_eq!((turn.frames, turn.channels, turn.width), (3, 4, 512));
}

#[test]
fn angles_turn_from_the_side_that_is_named() {
    let folder = Folder::new();
    folder.volume("ball.nrrd", [20; 3], "1 1 2", |[x, y, z]| {
        ball([x, y, z]) / (1 + (x / 8) as i16)
    });
    let render = |options: &str| {
        folder.says(&format!("render ball.nrrd --scene mr --size 90x90 --force {options}"));
        folder.read("image.png")
    };
    assert_eq!(
        render("--view left --azimuth 20 --elevation 5"),
        render("--azimuth 110 --elevation 5")
    );
    assert_eq!(
        render("--view posterior --roll 5"),
        render("--azimuth 180 --elevation 0 --roll 5")
    );
    assert_ne!(render("--view left --azimuth 20"), render("--view left"));
    for (options, said) in [
        (
            "--view superior --elevation 10",
            "--elevation 10: --view superior stands at 90 degrees already, expected a number from -90 to 0",
        ),
        (
            "--view inferior --elevation -0.5",
            "--elevation -0.5: --view inferior stands at -90 degrees already, expected a number from 0 to 90",
        ),
    ] {
        let refused = folder.run(&format!("render ball.nrrd {options} --force"));
        assert_eq!(refused.status.code(), Some(2));
        let text = String::from_utf8(refused.stderr).unwrap();
        assert!(text.contains(said), "{text}");
    }
    folder.says("render ball.nrrd --view superior --elevation -10 --size 9x9 --force");
    let refused = folder.run("turntable ball.nrrd --view left --azimuth 1000 --force");
    assert_eq!(refused.status.code(), Some(2));
}

#[test]
fn pictures_are_large_and_sharp_unless_told_otherwise() {
    let folder = Folder::new();
    folder.volume("ball.nrrd", [20; 3], "1 1 1", ball);
    let size = |options: &str| {
        let text = folder.says(&format!("render ball.nrrd --scene mr --force {options}"));
        let picture = folder.picture("image.png");
        (text, [picture.width, picture.height])
    };
    let (text, sides) = size("");
    assert_eq!(sides.iter().max(), Some(&512));
    assert!(
        text.contains("sampling: --rays 8 and --planes 4 per voxel, for a sharp picture of 512 x"),
        "{text}"
    );
    let (text, sides) = size("--size 100x80");
    assert_eq!(sides, [100, 80]);
    assert!(text.contains("sampling: --rays 4 and --planes 4 per voxel"), "{text}");
    let (text, _) = size("--size 100x80 --zoom 0.25");
    assert!(!text.contains("sampling"), "{text}");
    let (text, _) = size("--size 900x900 --rays 1 --planes 1");
    assert!(!text.contains("sampling"), "{text}");
}

#[test]
fn pictures_without_background_and_of_sixteen_bits() {
    let folder = Folder::new();
    folder.volume("ball.nrrd", [20; 3], "1 1 1", ball);
    let render = |options: &str| {
        folder.says(&format!("render ball.nrrd --scene mr --size 120x120 --force {options}"));
        folder.picture("image.png")
    };
    let black = render("");
    let white = render("--background white");
    for depth in ["8", "16"] {
        let clear = render(&format!("--background none --depth {depth}"));
        assert_eq!((clear.channels, &clear.keys[..]), (4, &["Alpha".to_owned()][..]));
        let over = |behind: f64| -> Vec<f64> {
            let pixel = |pixel: &[f64]| [0, 1, 2].map(|c| pixel[c] * pixel[3] + behind * (1.0 - pixel[3]));
            clear.values.chunks(4).flat_map(pixel).collect()
        };
        assert!(black.difference(&over(0.0)) <= 1.5, "{}", black.difference(&over(0.0)));
        assert!(white.difference(&over(1.0)) <= 1.5, "{}", white.difference(&over(1.0)));
        let alpha: Vec<f64> = clear.values.chunks(4).map(|pixel| pixel[3]).collect();
        assert!(
            alpha.contains(&0.0) && alpha.iter().any(|a| (0.1..0.9).contains(a)) && alpha.iter().any(|a| *a > 0.95)
        );
    }
    let deep = render("--depth 16 --background 1,1,1");
    assert_eq!((deep.channels, deep.keys.len()), (3, 0));
    assert!(
        white.difference(&deep.values) <= 0.51,
        "{}",
        white.difference(&deep.values)
    );
    let between = deep
        .values
        .iter()
        .filter(|value| (*value * 255.0).fract() > 0.1)
        .count();
    assert!(between > 100, "{between}");
}

#[test]
fn outputs_are_checked_before_the_work() {
    let folder = Folder::new();
    folder.volume("ball.nrrd", [20; 3], "1 1 1", ball);
    fs::write(folder.path("notes.png"), "my notes").unwrap();
    let before = folder.names();
    for (line, code, said) in [
        (
            "render none.nrrd -o a.jpg",
            2,
            "a.jpg: pictures are written as PNG, expected a name that ends in .png",
        ),
        (
            "turntable none.nrrd -o a.gif",
            2,
            "a.gif: pictures are written as PNG, expected a name that ends in .png",
        ),
        (
            "turntable none.nrrd --numbered -o -",
            2,
            "-o -: one animation goes to standard output",
        ),
        (
            "render none.nrrd -o notes.png",
            2,
            "notes.png exists; --force replaces it",
        ),
        (
            "render none.nrrd -o notes.png/a.png",
            1,
            "notes.png/a.png: cannot be written: ",
        ),
        (
            "render none.nrrd --background greenish",
            2,
            "expected none, black, white, six hexadecimal digits",
        ),
        (
            "render none.nrrd --size 0x9",
            2,
            "expected 1 to 16384 pixels along each side",
        ),
        (
            "render none.nrrd --depth 12",
            2,
            "invalid value '12' for '--depth <DEPTH>'",
        ),
    ] {
        let output = folder.run(line);
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{line}: {text}");
        assert!(text.contains(said), "{line}: {text}");
    }
    assert_eq!(folder.names(), before);

    folder.says("render ball.nrrd --scene mr --size 40x40 -o new/folder/a.png");
    let streamed = folder.run("render ball.nrrd --scene mr --size 40x40 -o -");
    assert!(streamed.status.success());
    assert_eq!(streamed.stdout, folder.read("new/folder/a.png"));
    let turned = folder.run("turntable ball.nrrd --scene mr --size 40x40 --frames 2 -o -");
    assert_eq!(Picture::decode(&turned.stdout).frames, 2);
}

/// An angiogram: noise, a bright vessel, one voxel that is far brighter.
fn angiogram([x, y, z]: [usize; 3]) -> i16 {
    match [x, y, z] {
        [0, 0, 0] => 30_000,
        [_, 9..12, 11..14] => 700,
        _ => 20 + ((7 * x + 5 * y + 3 * z) % 31) as i16,
    }
}

#[test]
fn projections_show_what_rays_keep() {
    let folder = Folder::new();
    folder.volume("mra.nrrd", [24; 3], "1 1 1", angiogram);
    let render = |options: &str| {
        let text = folder.says(&format!(
            "render mra.nrrd --azimuth 0 --elevation 0 --size 240x240 --window 0,4095 --force {options}"
        ));
        (text, folder.picture("image.png"))
    };
    let (text, picture) = render("--blend maximum");
    assert!(
        text.contains("projection: grey from ") && text.contains("(dark) to 700 (bright)"),
        "{text}"
    );
    let grey = |x: usize, y: usize| picture.values[3 * (y * picture.width + x)];
    let vessel = (100..140).map(|y| grey(120, y)).fold(0.0, f64::max);
    assert!(vessel > 0.9, "{vessel}");
    assert!(grey(120, 40) < 0.2, "{}", grey(120, 40));
    let (_, stock) = render("--scene mip");
    assert_eq!(stock.values, picture.values);
    let (text, least) = render("--blend minimum");
    assert!(text.contains("projection: grey from 20 (dark) to "), "{text}");
    assert!(least.share() > 0.2, "{}", least.share());
    // A scene of one's own keeps its transfer function.
    fs::write(folder.path("white.toml"), WHITE).unwrap();
    let (text, _) = render("--scene white.toml --blend maximum");
    assert!(!text.contains("projection"), "{text}");
}

#[test]
fn every_label_of_many_has_its_colour_and_a_legend() {
    let folder = Folder::new();
    // 512 labels in blocks of 2 voxels, on background.
    folder.volume("labels.nrrd", [20; 3], "1 1 1", |place| {
        if place.iter().all(|c| (2..18).contains(c)) {
            let [x, y, z] = place.map(|c| (c as i16 - 2) / 2);
            1 + 3 * (x + 8 * y + 64 * z)
        } else {
            0
        }
    });
    let text = folder.says("render labels.nrrd --scene labels --unlit --background white -o out/l.png");
    assert!(!text.contains("warning"), "{text}");
    let legend: serde_json::Value = serde_json::from_slice(&folder.read("out/l.legend.json")).unwrap();
    let labels = legend["labels"].as_array().unwrap();
    assert_eq!(labels.len(), 512);
    assert_eq!(
        (&labels[511]["label"], &labels[511]["voxels"]),
        (&1534.0.into(), &8.into())
    );
    let colours: std::collections::HashSet<&str> = labels.iter().map(|l| l["colour"].as_str().unwrap()).collect();
    assert_eq!(colours.len(), 512);
    let picture = folder.picture("out/l.legend.png");
    for colour in colours {
        let value = |place: usize| f64::from(u8::from_str_radix(&colour[place..place + 2], 16).unwrap()) / 255.0;
        let wanted = [value(1), value(3), value(5)];
        assert!(picture.values.chunks(3).any(|pixel| pixel == wanted), "{colour}");
    }
    // The legend is checked before the work as the picture is.
    let again = folder.run("render labels.nrrd --scene labels -o out/l.PNG");
    let text = String::from_utf8(again.stderr).unwrap();
    assert_eq!(again.status.code(), Some(2), "{text}");
    assert!(text.contains("out/l.legend.json exists; --force replaces it"), "{text}");
}

#[test]
fn surfaces_are_drawn_alone_or_in_the_volume_with_their_depth() {
    let folder = Folder::new();
    folder.volume("ball.nrrd", [20; 3], "1 1 1", ball);
    let render = |options: &str| {
        folder.says(&format!(
            "render ball.nrrd --size 61x61 --azimuth 0 --elevation 0 --unlit --rays 2 --planes 1 --force {options}"
        ));
        folder.picture("image.png")
    };
    let red = render("--surface 500,#ff0000 --depth-map depth.png");
    let share = red.share();
    assert!((0.3..0.7).contains(&share), "{share}");
    let pure = |pixel: &[f64]| pixel[1] == 0.0 && pixel[2] == 0.0;
    assert!(red.values.chunks(3).all(pure));
    let depth = folder.picture("depth.png");
    assert_eq!((depth.channels, depth.width, depth.height), (1, 61, 61));
    let met = depth.values.iter().filter(|level| **level > 0.0).count() as f64 / (61.0 * 61.0);
    assert!((met - share).abs() < 0.05, "{met} {share}");
    // The ball is nearest in its middle, in front of the middle of the volume.
    let middle = |depth: &Picture| {
        let centre = depth.values[30 * 61 + 30];
        let met = depth.values.iter().copied().filter(|level| *level > 0.0);
        let nearest = met.fold(1.0, f64::min);
        assert!(centre - nearest < 0.01, "{centre} {nearest}");
        centre
    };
    let cells = middle(&depth);
    render("--surface 500,#ff0000 --depth-map depth.png --borders whole");
    let whole = middle(&folder.picture("depth.png"));
    assert!(whole < 0.1, "{whole}");
    // Segments of cells begin a whole plane before the first slice, and end as far behind the last.
    assert!((21.0 * cells - 19.0 * whole - 1.0).abs() < 0.001, "{cells} {whole}");

    let faint = render("--surface 500,#ff0000,0.25");
    assert!(red.difference(&faint.values) > 60.0);
    let both = render("--scene mr --surface 500,#ff0000,0.25");
    let pieces = render("--scene mr --surface 500,#ff0000,0.25 --pieces 4");
    assert!(both.difference(&faint.values) > 30.0 && both.difference(&pieces.values) < 30.0);
    let alone = render("--scene mr --classification none --surface 500,#ff0000,0.25");
    assert_eq!(alone.difference(&faint.values), 0.0);

    let empty = folder.says("render ball.nrrd --surface 5000 --force");
    let told = "no ray crosses a surface of value 5000: all values lie between 0 and";
    assert!(
        empty.contains("the picture shows nothing") && empty.contains(told),
        "{empty}"
    );
    let clear = folder.says("render ball.nrrd --surface 500,#ff0000,0 --force");
    assert!(
        clear.contains("every surface has an opacity of 0 on both sides"),
        "{clear}"
    );
    for (options, said) in [
        ("--surface 500,red", "colour \"red\": expected #rrggbb"),
        ("--surface 500,#ff0000,2", "opacity: expected a number from 0 to 1"),
        ("--surface 500,#ff0000,1,7", "\"7\" is too much"),
        ("--surface x", "value: expected a number"),
        ("--surface 500 --blend maximum", "no [[surface]] under a projection"),
        (
            "--surface 500 --classification point",
            "expected \"integral\" beside surfaces",
        ),
        ("--classification none", "expected a [[surface]]"),
        ("--depth-map d.png", "--depth-map: the scene has no visible surface"),
        ("--surface 500 --depth-map d.txt", "expected a name that ends in .png"),
        (
            "--surface 500 --depth-map image.png",
            "--depth-map: names the picture's own file",
        ),
        ("--pieces 3", "`render.pieces` is 3, expected 1, 2 or 4"),
    ] {
        let output = folder.run(&format!("render ball.nrrd --size 61x61 --force {options}"));
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{options}: {text}");
        assert!(text.contains(said), "{options}: {text}");
    }
    let table = folder.run("table ball.nrrd --surface 500 -o t.txt");
    assert!(
        String::from_utf8(table.stderr)
            .unwrap()
            .contains("surfaces alone, which have no table")
    );
}

#[test]
fn shards_of_several_machines_are_one_picture() {
    let folder = Folder::new();
    folder.volume("a.nrrd", [48, 40, 70], "1 1 1", |[x, y, z]| {
        let away = |c: usize, middle: i16| (c as i16 - middle).abs();
        1500 - 40 * (away(x, 24) + away(y, 20) + away(z, 35))
    });
    let scene = "a.nrrd --scene ct-bone --rays 2 --planes 1 --size 200x160";
    folder.says(&format!("render {scene} -o whole.png"));
    for number in 1..=3 {
        folder.says(&format!("render {scene} --shard {number}/3 -o {number}.shard"));
    }
    let before = fs::read(folder.path("2.shard")).unwrap();
    folder.says("merge 3.shard 1.shard 2.shard -o merged.png");
    assert_eq!(folder.read("merged.png"), folder.read("whole.png"));
    folder.says(&format!("render {scene} --depth 16 --background none -o deep.png"));
    folder.says("merge 1.shard 2.shard 3.shard --depth 16 --background none -o deep-merged.png");
    assert_eq!(folder.read("deep-merged.png"), folder.read("deep.png"));

    let refuses = |line: &str, words: &str| {
        let output = folder.run(line);
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{line}: {text}");
        assert!(text.contains(words), "{line}: {text}");
    };
    refuses("merge 1.shard 3.shard -o x.png", "2 of 3 shards; missing: 2");
    refuses(
        "merge 1.shard 1.shard -o x.png",
        "1.shard: shard 1/3 again; 1.shard is the same one",
    );
    refuses("merge whole.png -o x.png", "whole.png: not a shard");
    refuses("merge none.shard -o x.png", "none.shard: No such file");
    refuses("merge 1.shard 2.shard 3.shard -o whole.png", "--force replaces it");
    refuses(
        &format!("render {scene} --shard 1/3 -o 1.png"),
        "expected a name that ends in .shard",
    );
    refuses(&format!("render {scene} --shard 1/3 -o 1.shard"), "--force replaces it");
    refuses(
        &format!("render {scene} --shard 1/999 -o x.shard"),
        "expected at most as many shards",
    );
    folder.says(&format!("render {scene} --azimuth 7 --shard 2/3 -o other.shard"));
    refuses(
        "merge 1.shard other.shard -o x.png",
        "other.shard: of another frame than 1.shard",
    );
    assert!(!folder.names().iter().any(|name| name.starts_with("x.")));
    assert_eq!(fs::read(folder.path("2.shard")).unwrap(), before);
}

#[test]
fn shards_of_a_turn_are_its_pictures() {
    let folder = Folder::new();
    folder.volume("a.nrrd", [20, 20, 20], "1 1 1", |[x, y, z]| (x * y + 30 * z) as i16);
    let turn = "turntable a.nrrd --frames 5 --numbered --size 64x64";
    folder.says(&format!("{turn} -o whole/a.png"));
    for number in 1..=2 {
        folder.says(&format!("{turn} --shard {number}/2 -o part-{number}/a.png"));
    }
    for frame in 0..5 {
        let (own, other) = (1 + frame % 2, 2 - frame % 2);
        let name = format!("a-00{frame}.png");
        assert_eq!(
            folder.read(&format!("part-{own}/{name}")),
            folder.read(&format!("whole/{name}"))
        );
        assert!(!folder.path(&format!("part-{other}/{name}")).exists());
    }
}

#[test]
fn a_volume_read_in_parts_is_one_picture() {
    let folder = Folder::new();
    folder.volume("a.nrrd", [48, 40, 70], "1 1 1.5", |[x, y, z]| {
        let away = |c: usize, middle: i16| (c as i16 - middle).abs();
        1500 - 40 * (away(x, 24) + away(y, 20) + away(z, 35))
    });
    let scene = "a.nrrd --scene headsq --rays 2 --planes 2 --size 200x160";
    folder.says(&format!("render {scene} -o whole.png"));
    let said = folder.run(&format!("render {scene} --memory 1GiB -o parts.png"));
    let said = String::from_utf8(said.stderr).unwrap();
    assert!(said.contains("read in 1 part of at most 40 slices"), "{said}");
    assert_eq!(folder.read("parts.png"), folder.read("whole.png"));
    for number in 1..=2 {
        folder.says(&format!(
            "render {scene} --memory 1GiB --shard {number}/2 -o {number}.shard"
        ));
    }
    folder.says("merge 1.shard 2.shard -o merged.png");
    assert_eq!(folder.read("merged.png"), folder.read("whole.png"));

    let said = folder.run(&format!("render {scene} --borders cells --budget 100s -o finest.png"));
    let said = String::from_utf8(said.stderr).unwrap();
    assert!(
        said.contains("12 bricks of 32 voxels at level 0") && said.contains("of 100000.0 ms"),
        "{said}"
    );
    folder.says(&format!("render {scene} --borders cells -o cells.png"));
    assert_eq!(folder.read("finest.png"), folder.read("cells.png"));

    let refuses = |line: &str, words: &str| {
        let output = folder.run(line);
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{line}: {text}");
        assert!(text.contains(words), "{line}: {text}");
    };
    refuses(
        &format!("render {scene} --memory 9MiB -o x.png"),
        "expected at least as much",
    );
    refuses(
        &format!("render {scene} --memory 2 -o x.png"),
        "like 512MiB, 2GiB or 1.5GB",
    );
    refuses("render --memory 1GiB -o x.png", "the built-in CT head is in memory");
    let levels = format!("render {scene} --borders cells");
    refuses(
        &format!("{levels} --budget 1us -o x.png"),
        "like 128MiB, 2GiB, 200ms or 1.5s",
    );
    refuses(
        &format!("{levels} --budget 0.001ms -o x.png"),
        "expected at least as long",
    );
    refuses(&format!("{levels} --budget 1s,2s -o x.png"), "two of a kind");
    refuses(
        "render --borders cells --budget 1GiB -o x.png",
        "the built-in CT head is in memory",
    );
    // What is fitted by a look at all voxels looks at them in the file.
    folder.volume("labels.nrrd", [40, 30, 20], "1 1 1", |[x, y, z]| {
        ((x / 8 + y / 6 + z / 5) % 7) as i16
    });
    for fitted in [
        "a.nrrd --scene mip",
        "a.nrrd --scene ct-bone --blend minimum",
        "a.nrrd --scene ct-bone --classification auto",
        "labels.nrrd --scene labels",
    ] {
        folder.says(&format!("render {fitted} --size 120x100 --force -o fitted.png"));
        folder.says(&format!(
            "render {fitted} --size 120x100 --memory 1GiB --force -o in-parts.png"
        ));
        assert_eq!(folder.read("in-parts.png"), folder.read("fitted.png"), "{fitted}");
    }
    folder.volume("flat.nrrd", [8, 8, 1], "1 1 1", |[x, y, _]| (x * y) as i16);
    refuses("render flat.nrrd --memory 1GiB -o x.png", "is one slice thick");
    assert!(!folder.names().iter().any(|name| name.starts_with("x.")));
}
