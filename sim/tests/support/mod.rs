//! A folder to run the program in.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

/// A folder of its own, in which the program runs.
pub struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    pub fn new() -> Self {
        Self {
            folder: tempfile::tempdir().unwrap(),
        }
    }

    /// A file's path.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a file, and the folders that it lies in.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }

    /// Writes an NRRD file of cubic voxels.
    pub fn nrrd(&self, name: &str, kind: &str, dims: [usize; 3], data: &[u8]) {
        let [x, y, z] = dims;
        let head = format!(
            "NRRD0004\ntype: {kind}\ndimension: 3\nsizes: {x} {y} {z}\nspacings: 1 1 1\nendian: little\nencoding: raw\n\n"
        );
        self.write(name, [head.as_bytes(), data].concat());
    }

    /// Writes a block of a head's density in air, in Hounsfield units, 8 x 8 x 8.
    pub fn block(&self, name: &str) {
        let voxel = |index: i16| if index % 8 < 2 { -1000 } else { 3 * index };
        let data: Vec<u8> = (0..512).flat_map(|index| voxel(index).to_le_bytes()).collect();
        self.nrrd(name, "int16", [8; 3], &data);
    }

    /// Runs the program.
    pub fn run(&self, words: &str) -> Output {
        Command::new(env!("CARGO_BIN_EXE_slicecast"))
            .args(words.split(' '))
            .current_dir(self.folder.path())
            .output()
            .unwrap()
    }

    /// Runs the program, which has to succeed: what it says on standard output and on standard error.
    pub fn succeeds(&self, words: &str) -> [String; 2] {
        let output = self.run(words);
        let [out, err] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        assert!(output.status.success(), "{words}: {err}");
        [out, err]
    }

    /// Runs the program, which has to refuse: its words on standard error, in one line.
    pub fn refuses(&self, words: &str) -> String {
        let output = self.run(words);
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{words}: {text}");
        assert!(!text.contains("panicked"), "{words}: {text}");
        text.split_whitespace().collect::<Vec<_>>().join(" ")
    }
}
