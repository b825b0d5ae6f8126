//! What the laboratory's commands say to files and options that are not what they need: one line, the right exit code,
//! nothing written; and `docs/malformed-inputs.md` says the same.

#![cfg(feature = "laboratory")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// A folder with a volume, the rows of a sweep and files that are something else.
struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let bench = Self { folder };
        bench.volume("a.nrrd", 0);
        bench.volume("b.nrrd", 1);
        bench.file("notes.txt", "my notes\n");
        bench.file("other.json", "{\"rows\": []}\n");
        bench.file("empty.jsonl", "");
        bench.file("old.jsonl", "{\"slicecast\":\"sweep rows\",\"version\":1}\n");
        let sweep = [
            "sweep", "a.nrrd", "--scene", "ct-fog", "--rounds", "1", "--rows", "a.jsonl",
        ];
        bench.succeeds(&[&sweep[..], &["--only", "compact,paper"]].concat());
        let rows = bench.read("a.jsonl");
        bench.file("cut.jsonl", &rows[..rows.len() - 9]);
        bench.file(
            "damaged.jsonl",
            &rows.replacen("\"pixel_bytes\":8", "\"pixel_bytes\":-8", 1),
        );
        let sweep = [
            "sweep", "b.nrrd", "--scene", "ct-fog", "--rounds", "1", "--rows", "b.jsonl",
        ];
        bench.succeeds(&[&sweep[..], &["--only", "wide"]].concat());
        let sweep = [
            "sweep",
            "a.nrrd",
            "--scene",
            "ct-fog",
            "--rounds",
            "1",
            "--rows",
            "turned.jsonl",
        ];
        bench.succeeds(&[&sweep[..], &["--only", "wide", "--azimuth", "7"]].concat());
        bench
    }

    fn file(&self, name: &str, text: &str) {
        fs::write(self.folder.path().join(name), text).unwrap();
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.folder.path().join(name)).unwrap()
    }

    /// A block of a head's density in air, in Hounsfield units.
    fn volume(&self, name: &str, seed: i16) {
        let head =
            "NRRD0004\ntype: int16\ndimension: 3\nsizes: 8 8 8\nspacings: 1 1 1\nendian: little\nencoding: raw\n\n";
        let voxel = |index: i16| if index % 8 < 2 { -1000 } else { 3 * index + seed };
        let voxels = (0..512).flat_map(|index| voxel(index).to_le_bytes());
        let bytes: Vec<u8> = head.bytes().chain(voxels).collect();
        fs::write(self.folder.path().join(name), bytes).unwrap();
    }

    fn run(&self, args: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_slicecast"))
            .args(args)
            .current_dir(self.folder.path())
            .output()
            .unwrap()
    }

    fn succeeds(&self, args: &[&str]) -> String {
        let output = self.run(args);
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{args:?}: {text}");
        text
    }

    /// The names in the folder.
    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<_> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

/// Arguments, exit code, and what is said.
const REFUSED: &[(&str, i32, &str)] = &[
    (
        "sweep a.nrrd --scene ct-fog --rows notes.txt",
        2,
        "notes.txt: is no file of sweep rows, expected one that `slicecast sweep --rows` has written",
    ),
    (
        "sweep a.nrrd --scene ct-fog --rows other.json",
        2,
        "other.json: is no file of sweep rows, expected one that `slicecast sweep --rows` has written",
    ),
    (
        "sweep a.nrrd --scene ct-fog --rows old.jsonl",
        2,
        "old.jsonl: holds sweep rows of version 1, expected version 3: run the sweep again",
    ),
    (
        "sweep a.nrrd --scene ct-fog --rows damaged.jsonl",
        2,
        "damaged.jsonl: line 2: invalid value: integer `-8`, expected usize at line 1 column",
    ),
    (
        "sweep a.nrrd --scene ct-fog --rows no/rows.jsonl",
        1,
        "no/rows.jsonl: No such file or directory (os error 2)",
    ),
    (
        "sweep a.nrrd --scene ct-fog --rows .",
        1,
        ".: Is a directory (os error 21)",
    ),
    (
        "sweep a.nrrd --scene ct-fog --rows a.jsonl --views 3 --timing-threads 2 --simd scalar",
        2,
        "was measured in 1 views and timed with",
    ),
    (
        "sweep a.nrrd --rows r.jsonl --shard 3/2",
        2,
        "invalid value '3/2' for '--shard <I/N>': expected I/N with I from 1 to N, like 2/8",
    ),
    (
        "sweep a.nrrd --shard 1/2",
        2,
        "the following required arguments were not provided: --rows <FILE>",
    ),
    (
        "sweep a.nrrd --vary weight",
        2,
        "--vary weight: expected STAGE.WIDTH=VALUE,VALUE; accepted: position.bits, weight.bits,",
    ),
    (
        "sweep a.nrrd --vary width.bits=6",
        2,
        "--vary width.bits=6: no parameter `width.bits`; accepted: position.bits, weight.bits,",
    ),
    (
        "sweep a.nrrd --vary weight.bits=17",
        2,
        "--vary weight.bits=17: weight.bits has no value `17`; accepted: 1 to 16",
    ),
    (
        "sweep a.nrrd --vary weight.bits=9..6",
        2,
        "--vary weight.bits=9..6: weight.bits has no value `9..6`; accepted: ranges from low to high",
    ),
    (
        "sweep a.nrrd --only compcat",
        2,
        "--only: no configuration `compcat`; `slicecast sweep --list` names them",
    ),
    (
        "sweep a.nrrd --scene ct-fog --blend maximum",
        2,
        "a sweep composites front to back; the scene's blend is another one",
    ),
    (
        "sweep a.nrrd --scene ct-fog --csv notes.txt",
        2,
        "notes.txt exists; --force replaces it",
    ),
    (
        "sweep a.nrrd --scene ct-fog --csv notes.txt/a.csv",
        1,
        "notes.txt/a.csv: cannot be written: Not a directory (os error 20)",
    ),
    (
        "sweep-merge none.jsonl",
        2,
        "none.jsonl: has no rows, expected those that `slicecast sweep --rows none.jsonl` writes",
    ),
    (
        "sweep-merge empty.jsonl",
        2,
        "empty.jsonl: has no rows, expected those that `slicecast sweep --rows empty.jsonl` writes",
    ),
    (
        "sweep-merge a.jsonl b.jsonl",
        2,
        "b.jsonl: `wide` is of another volume than `paper`, expected rows of one sweep",
    ),
    (
        "sweep-merge a.jsonl turned.jsonl",
        2,
        "turned.jsonl: `wide` is of another scene, window or version of the program than `paper`, expected rows of one sweep",
    ),
    (
        "report a.nrrd --scene ct-fog --rows b.jsonl -o r.html",
        2,
        "b.jsonl: has rows of another volume only, expected some of this volume and scene",
    ),
    (
        "report a.nrrd --scene ct-fog --rows other.json -o r.html",
        2,
        "other.json: is no file of sweep rows, expected one that `slicecast sweep --rows` has written",
    ),
    (
        "report a.nrrd --scene ct-fog -o notes.txt",
        2,
        "notes.txt exists; --force replaces it",
    ),
    (
        "report a.nrrd --scene ct-fog -o notes.txt/r.html",
        1,
        "notes.txt/r.html: cannot be written: Not a directory (os error 20)",
    ),
    (
        "report a.nrrd --scene ct-fog --blend maximum -o r.html",
        2,
        "a report is of a scene composited front to back; the scene's blend is another one",
    ),
    ("hard --json notes.txt", 2, "notes.txt exists; --force replaces it"),
    (
        "hard --force --json .",
        2,
        ".: is a folder, expected the name of a file",
    ),
    (
        "explain a.nrrd --scene ct-fog --pixel 4",
        2,
        "invalid value '4' for '--pixel <X,Y>': expected two numbers like 120,64",
    ),
    (
        "explain a.nrrd --scene ct-fog --pixel 4,999",
        2,
        "pixels; there is none at 4,999",
    ),
    (
        "explain a.nrrd --scene ct-fog --ray 999,0",
        2,
        "rays; there is none at 999,0",
    ),
    (
        "explain a.nrrd --scene ct-fog --blend maximum --ray 4,4",
        2,
        "rays are explained front to back; the scene's blend is another one",
    ),
    (
        "explain a.nrrd --scene ct-fog --ray 4,4 --csv notes.txt",
        2,
        "notes.txt exists; --force replaces it",
    ),
];

#[test]
fn what_is_not_as_expected_is_refused_by_name() {
    let bench = Bench::new();
    let before = (bench.names(), bench.read("a.jsonl"), bench.read("notes.txt"));
    let table = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/malformed-inputs.md")).unwrap();
    for (args, code, said) in REFUSED {
        let output = bench.run(&args.split(' ').collect::<Vec<_>>());
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(*code), "{args}: {text}");
        // The parser of the command line wraps its lines.
        let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.contains(said), "{args}: {text}");
        assert!(!text.contains("panicked"), "{args}: {text}");
        let line = format!("| `{args}` | `{}` |", said.replace('|', "\\|"));
        assert!(table.contains(&line), "not in docs/malformed-inputs.md: {line}");
    }
    let after = (bench.names(), bench.read("a.jsonl"), bench.read("notes.txt"));
    assert_eq!(before, after);
}

/// A row that was cut off is measured again; who merges it is told.
#[test]
fn a_row_that_was_cut_off_is_not_lost_in_silence() {
    let bench = Bench::new();
    let note = bench.succeeds(&["sweep-merge", "cut.jsonl"]);
    assert!(
        note.contains("cut.jsonl: the last row was cut off and is left out; running its sweep again completes it"),
        "{note}"
    );
    let sweep = [
        "sweep",
        "a.nrrd",
        "--scene",
        "ct-fog",
        "--rounds",
        "1",
        "--rows",
        "cut.jsonl",
    ];
    let note = bench.succeeds(&[&sweep[..], &["--only", "compact,paper"]].concat());
    assert!(note.contains("1 of 2 configurations are finished"), "{note}");
    assert_eq!(bench.read("cut.jsonl").lines().count(), 3);
    assert!(!bench.succeeds(&["sweep-merge", "cut.jsonl"]).contains("cut off"));
}
