//! `slicecast pyramid`: what it writes is read again, what has no meaning is refused, and `docs/malformed-inputs.md` says the same.

mod support;

use std::fs;
use std::path::Path;

use support::Place;

/// An NRRD file of colours.
fn colours(place: &Place, name: &str, components: usize, kind: &str, data: &[u8]) {
    let head = format!(
        "NRRD0005\ntype: {kind}\ndimension: 4\nsizes: {components} 4 4 2\nkinds: {components}-color domain domain domain\n\
         spacings: nan 1 1 2\nendian: little\nencoding: raw\n\n"
    );
    place.write(name, [head.as_bytes(), data].concat());
}

/// Colours and opacities of 4 x 4 x 2 voxels.
fn rgba() -> Vec<u8> {
    (0..128_u32).map(|i| (i * 37 % 251) as u8).collect()
}

/// Two shares of materials a voxel.
fn shares(place: &Place, name: &str, data: Vec<u8>) {
    let head = "NRRD0005\ntype: uint8\ndimension: 4\nsizes: 2 4 4 2\nkinds: list domain domain domain\nspacings: nan 1 1 2\n\
                encoding: raw\n\n";
    place.write(name, [head.as_bytes(), &data].concat());
}

fn files() -> Place {
    let place = Place::new();
    colours(&place, "rgba.nrrd", 4, "uint8", &rgba());
    colours(&place, "rgb.nrrd", 3, "uint8", &rgba()[..96]);
    colours(&place, "signed.nrrd", 4, "int8", &rgba());
    let floats: Vec<u8> = (0..128).flat_map(|i| (i as f32 / 100.0).to_le_bytes()).collect();
    colours(&place, "floats.nrrd", 4, "float", &floats);
    colours(&place, "cut.nrrd", 4, "uint8", &rgba()[..127]);
    shares(
        &place,
        "shares.nrrd",
        (0..64).map(|i: u8| i.wrapping_mul(37) % 128).collect(),
    );
    shares(&place, "full.nrrd", [[0, 255], [200, 100]].concat().repeat(16));
    shares(
        &place,
        "labels.nrrd",
        (0..32).flat_map(|i: u8| [i % 3 * 4, 8 * i]).collect(),
    );
    let material = |label: &str, extinction: &str| {
        format!("[[material]]\nname = \"a material\"\n{label}colour = \"#ff8040\"\nextinction = {extinction}\n")
    };
    let of_two = |voxel: &str, labels: [&str; 2]| {
        let [one, other] = labels;
        format!("voxel = \"{voxel}\"\n{}{}", material(one, "3"), material(other, "1.5"))
    };
    place.write("two.toml", of_two("shares", [""; 2]));
    place.write("labels.toml", of_two("label-share", ["label = 4\n", "label = 8\n"]));
    place.write("fewer.toml", of_two("label-share", ["label = 4\n", "label = 7\n"]));
    place.write("one.toml", format!("voxel = \"shares\"\n{}", material("", "3")));
    place.write("bad.toml", format!("voxel = \"shares\"\n{}", material("", "-1")));
    place.block("scalar.nrrd");
    place.write("kept/level-1.nrrd", "my notes");
    place
}

/// Values of a level, and its header.
fn level(place: &Place, name: &str) -> (String, Vec<u16>) {
    let bytes = fs::read(place.path(name)).unwrap();
    let end = bytes.windows(2).position(|pair| pair == b"\n\n").unwrap() + 2;
    let header = String::from_utf8(bytes[..end].to_vec()).unwrap();
    let values = match header.contains("type: uint16") {
        true => bytes[end..]
            .as_chunks::<2>()
            .0
            .iter()
            .map(|pair| u16::from_le_bytes(*pair))
            .collect(),
        false => bytes[end..].iter().copied().map(u16::from).collect(),
    };
    (header, values)
}

#[test]
fn levels_are_written_and_read_again() {
    let place = files();
    let [out, _] = place.succeeds("pyramid rgba.nrrd --alpha-distance 2 --filter two --exact -o a");
    assert!(out.contains("a: 3 levels by (1,1)/2"), "{out}");
    let [(_, fine), (header, coarse)] = ["a/level-0.nrrd", "a/level-1.nrrd"].map(|name| level(&place, name));
    for line in [
        "sizes: 4 2 2 1",
        "spacings: nan 2 2 4",
        "slicecast_voxel:=extinction15",
        "slicecast_level:=1",
        "slicecast_alpha_distance:=2",
        "slicecast_filter:=(1,1)/2",
        "centers: none cell cell cell",
    ] {
        assert!(header.lines().any(|found| found == line), "{line}: {header}");
    }
    // Every row of the coarse level has the sum of the eight voxels behind each of its own, to within half a code.
    for row in 0..2 {
        let place = |x: usize, y: usize, z: usize| 4 * (x + 4 * (y + 4 * z)) + 3;
        let behind = (0..16).map(|i| i64::from(fine[place(i % 4, 2 * row + i / 4 % 2, i / 8)]));
        let found: i64 = (0..2).map(|x| 8 * i64::from(coarse[4 * (x + 2 * row) + 3])).sum();
        let difference = found - behind.sum::<i64>();
        assert!((-3..=4).contains(&difference), "row {row}: {difference}");
    }
    // The finest level, as it was written, gives the same pyramid.
    place.succeeds("pyramid a/level-0.nrrd --filter two --exact -o b");
    assert_eq!(level(&place, "b/level-1.nrrd").1, coarse);
    place.succeeds("pyramid b/level-0.nrrd --filter two --exact --levels 1 --by opacity -o c");
    assert_ne!(level(&place, "c/level-1.nrrd").1, coarse);
    assert!(!place.path("c/level-2.nrrd").exists());
}

#[test]
fn scalars_are_classified_first() {
    let place = files();
    let [_, err] = place.succeeds("pyramid scalar.nrrd --scene ct-fog --compare -o a");
    assert!(!err.contains("twice"), "{err}");
    let (header, values) = level(&place, "a/level-0.nrrd");
    assert!(
        header.contains("slicecast_voxel:=root8\n") && header.contains("slicecast_alpha_distance:=1\n"),
        "{header}"
    );
    // Air is clear; everything else of the block is as dense as the scene has it, and white.
    let expected = |i: usize| if i % 8 < 2 { 0 } else { 255 };
    assert!(values.chunks(4).enumerate().all(|(i, voxel)| voxel[3] == expected(i)));
    assert!(values.chunks(4).all(|voxel| voxel[..3] == [255; 3]));
    let again = place.succeeds("pyramid scalar.nrrd --scene ct-fog -o a")[0].clone();
    assert!(again.contains("a: 4 levels by (1,1,1,1)/4"), "{again}");
}

#[test]
fn odd_axes_and_missing_levels_are_told() {
    let place = files();
    let [_, err] = place.succeeds("pyramid rgba.nrrd --alpha-distance 1 --filter five --levels 9 -o a");
    assert!(err.contains("note: 2 levels below the finest, not 9"), "{err}");
    assert!(
        err.contains("note: an axis that does not halve has its last voxel twice"),
        "{err}"
    );
}

/// Colours without opacity take what is asked for; opaque voxels are counted.
#[test]
fn rules_for_opacity_are_applied_and_told() {
    let place = files();
    place.succeeds("pyramid rgb.nrrd --opacity luminance --alpha-distance 1 -o a");
    place.succeeds("pyramid rgb.nrrd --opacity 0.1:0,0.5:0.8,1:1 --alpha-distance 1 -o c");
    let [_, err] = place.succeeds("pyramid rgb.nrrd --opacity 1 --alpha-distance 0.5 -o b");
    assert!(
        err.contains("note: 32 of 32 voxels block more than tau_max = 30.000000 can"),
        "{err}"
    );
}

/// Shares of materials become codes by the formula of the contract, and are rendered, lit and by opacities too.
#[test]
fn materials_are_mixed_by_their_shares() {
    let place = files();
    place.succeeds("pyramid shares.nrrd --materials two.toml --exact --levels 0 -o a");
    let (header, codes) = level(&place, "a/level-0.nrrd");
    assert!(header.contains("slicecast_tau_max:=3\n"), "{header}");
    let weighted = |t: u32, colour: u32| (257 * colour * t + (1 << 15)) >> 16;
    let of = |t: u32| [weighted(t, 255), weighted(t, 128), weighted(t, 64), t];
    let table = [of(32767), of(16384)];
    for (i, voxel) in codes.chunks(4).enumerate() {
        let share = |n: usize| u32::from((2 * i as u8 + n as u8).wrapping_mul(37) % 128);
        let expected =
            [0, 1, 2, 3].map(|k| (257 * (share(0) * table[0][k] + share(1) * table[1][k]) + (1 << 15)) >> 16);
        assert_eq!(
            voxel.iter().map(|c| u32::from(*c)).collect::<Vec<_>>(),
            expected,
            "voxel {i}"
        );
    }
    let [_, err] = place.succeeds("render labels.nrrd --materials labels.toml --light 0,0,1 --size 40x40 -o l.png");
    assert!(
        err.contains("labels.nrrd: 4 x 4 x 2 voxels of 2 values, 2 materials"),
        "{err}"
    );
    let [out, _] = place.succeeds("compare shares.nrrd --materials two.toml --precision wide");
    assert!(out.contains("wide, base plane"), "{out}");
    place.succeeds("render rgba.nrrd --alpha-distance 1 --sampling opacity8 --size 40x40 -o o.png");
    let [out, _] = place.succeeds("compare rgba.nrrd --alpha-distance 1 --sampling opacity16 --json o.json");
    assert!(out.contains("opacities to extinctions, 16 planes"), "{out}");
    assert!(
        fs::read_to_string(place.path("o.json"))
            .unwrap()
            .contains("\"opacities\"")
    );
}

/// The rows of the page: a command, and what it is told.
fn page() -> Vec<(String, String)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/malformed-inputs.md");
    let page = fs::read_to_string(path).unwrap();
    let section = page.split("\n## Volumes of colours\n").nth(1).unwrap();
    let section = section.split("\n## ").next().unwrap();
    let rows = section.lines().filter(|line| line.starts_with("| `"));
    let cells = rows.map(|row| {
        let (command, message) = row.trim_matches(['|', ' ']).split_once(" | ").unwrap();
        let bare = |cell: &str| {
            cell.trim()
                .strip_prefix('`')
                .unwrap()
                .strip_suffix('`')
                .unwrap()
                .to_owned()
        };
        (bare(command), bare(message))
    });
    cells.collect()
}

#[test]
fn refusals_are_those_of_the_page() {
    let place = files();
    place.succeeds("pyramid rgba.nrrd --alpha-distance 1 -o own");
    let bytes = fs::read(place.path("own/level-0.nrrd")).unwrap();
    let without = String::from_utf8_lossy(&bytes).find("slicecast_alpha").unwrap();
    let end = without + bytes[without..].iter().position(|byte| *byte == b'\n').unwrap() + 1;
    place.write("undistanced.nrrd", [&bytes[..without], &bytes[end..]].concat());
    let rows = page();
    assert!(rows.len() >= 40, "{}", rows.len());
    for (command, message) in rows {
        let text = place.refuses(&command);
        assert!(text.contains(&message), "{command}\n{text}\n{message}");
    }
    assert_eq!(fs::read(place.path("kept/level-1.nrrd")).unwrap(), b"my notes");
    assert!(!place.path("no").exists());
}
