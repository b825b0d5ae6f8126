//! The images: built, run, and what they print taken apart.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use slicecast::stage::Stage;

use crate::exported;
use crate::machines::Machine;
use crate::reference::Sums;
use crate::shell::{Failure, Finished, fail, run};
use crate::toolchain::{Toolchain, build};

/// How long a program may run.
const LIMIT: Duration = Duration::from_secs(300);

/// Two frames of one program, and the places of samples in each.
#[derive(Debug)]
pub struct Pair<'a> {
    cases: [&'a Case; 2],
    places: [u64; 2],
}

impl<'a> Pair<'a> {
    /// The cases of these names.
    ///
    /// # Errors
    /// If the program reported another.
    pub fn of(report: &'a Report, names: [String; 2], places: [u64; 2]) -> Result<Self, Failure> {
        let [first, second] = names.map(|name| report.cases.iter().find(|case| case.name == name));
        match (first, second) {
            (Some(first), Some(second)) => Ok(Self {
                cases: [first, second],
                places,
            }),
            _ => fail("the program did not report its cases"),
        }
    }

    /// The sum of the second's image.
    pub const fn image(&self) -> u32 {
        self.cases[1].sums.image
    }

    /// Instructions of both.
    pub fn instructions(&self) -> [u64; 2] {
        self.cases.map(|case| case.instructions.unwrap_or(u64::MAX))
    }

    /// Instructions of a sample.
    pub fn each(&self) -> [f64; 2] {
        let [first, second] = self.instructions();
        let [of_first, of_second] = self.places;
        [first as f64 / of_first as f64, second as f64 / of_second as f64]
    }

    /// Bytes of memory lent to both.
    pub fn memory(&self) -> [u64; 2] {
        self.cases
            .map(|case| case.memory.map_or(0, |parts| parts.iter().sum::<u64>()))
    }

    /// Instructions of a sample and memory of both, by these words.
    pub fn cost(&self, [first, second]: [&str; 2]) -> String {
        let ([each, other], [memory, lent]) = (self.each(), self.memory());
        format!(
            "    instructions a sample: {first} {each:.1}, {second} {other:.1}, {:.2} times; memory {memory} and {lent}",
            other / each
        )
    }
}

/// What is needed to build and run images.
#[derive(Debug)]
pub struct Workshop {
    /// The compiler.
    pub toolchain: Toolchain,
    /// The repository.
    pub root: PathBuf,
    /// The generated scenes.
    pub scenes: PathBuf,
}

impl Workshop {
    /// Where generated files go.
    pub fn directory(&self) -> PathBuf {
        self.root.join("target/firmware")
    }

    /// Builds some of the programs for a machine in a profile and returns the directory that they are in.
    ///
    /// # Errors
    /// With what the compiler said.
    pub fn images(&self, machine: &Machine, profile: &str, programs: &[&str]) -> Result<PathBuf, Failure> {
        let (mut command, directory) = self.toolchain.cargo("build", profile, machine.target, machine.cpu);
        for program in programs {
            command.args(["--bin", program]);
        }
        build(self.of_firmware(&mut command, machine))?;
        Ok(directory)
    }

    /// Lints all the programs for a machine.
    ///
    /// # Errors
    /// With what there is to say.
    pub fn lint(&self, machine: &Machine) -> Result<(), Failure> {
        let mut command = self.toolchain.clippy(machine);
        self.of_firmware(&mut command, machine);
        self.toolchain.deny_warnings(&mut command);
        build(&mut command)
    }

    /// A `cargo` command for the programs of a machine.
    fn of_firmware<'c>(&self, command: &'c mut Command, machine: &Machine) -> &'c mut Command {
        command
            .current_dir(self.root.join("host-tests/firmware"))
            .arg("--locked")
            .env("SLICECAST_MACHINE", machine.name)
            .env("SLICECAST_SCENES", &self.scenes)
            .env("SLICECAST_EXPORTED", exported::directory(self))
    }
}

/// Runs a program on a machine.
///
/// # Errors
/// If QEMU cannot be started or the program does not end.
pub fn execute(machine: &Machine, program: &Path, counted: bool) -> Result<Finished, Failure> {
    let mut command: Command = machine.command(program, counted);
    run(&mut command, LIMIT)
}

/// What one case of a program printed.
#[derive(Clone, Debug, Default)]
pub struct Case {
    /// Scene, precision, shading.
    pub name: String,
    /// Sums, where they were printed.
    pub sums: Sums,
    /// Instructions of the whole case.
    pub instructions: Option<u64>,
    /// Instructions of each stage.
    pub stages: BTreeMap<String, u64>,
    /// Bytes of slices, ranges, scratch and image.
    pub memory: Option<[u64; 4]>,
    /// Other lines.
    pub notes: Vec<String>,
}

/// What a program printed.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Its cases.
    pub cases: Vec<Case>,
    /// Stack used, bytes.
    pub stack: Option<u64>,
    /// Sum of the views from angles.
    pub angles: Option<u32>,
    /// Its own verdict.
    pub verdict: bool,
}

/// Takes a program's output apart.
///
/// # Errors
/// If the program reported an error, panicked or printed something unknown.
pub fn parse(output: &str) -> Result<Report, Failure> {
    let mut report = Report::default();
    for line in output.lines() {
        let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
        let case = report.cases.last_mut();
        let understood = match (word, case) {
            ("case", _) => {
                report.cases.push(Case {
                    name: rest.to_owned(),
                    ..Case::default()
                });
                true
            }
            ("plane", Some(case)) => plane(rest)
                .map(|(key, sums)| case.sums.planes.insert(key, sums))
                .is_some(),
            ("image", Some(case)) => hex(rest).map(|sum| case.sums.image = sum).is_some(),
            ("picture", Some(case)) => hex(rest).map(|sum| case.sums.picture = sum).is_some(),
            ("instructions", Some(case)) => rest.parse().map(|n| case.instructions = Some(n)).is_ok(),
            ("memory", Some(case)) => numbers(rest).map(|n| case.memory = Some(n)).is_some(),
            ("stage", Some(case)) => match rest.split_once(' ').and_then(|(n, name)| Some((n.parse().ok()?, name))) {
                Some((count, name)) => {
                    case.stages.insert(name.to_owned(), count);
                    true
                }
                None => false,
            },
            ("bands" | "queue" | "f32", Some(case)) => {
                case.notes.push(line.to_owned());
                true
            }
            ("angles", _) => hex(rest).map(|sum| report.angles = Some(sum)).is_some(),
            ("stack", _) => rest.parse().map(|n| report.stack = Some(n)).is_ok(),
            ("verdict", _) => {
                report.verdict = rest == "pass";
                true
            }
            _ => false,
        };
        if !understood {
            return fail(format!("the program said: {line}"));
        }
    }
    Ok(report)
}

fn hex(text: &str) -> Option<u32> {
    u32::from_str_radix(text, 16).ok()
}

fn numbers<const N: usize>(text: &str) -> Option<[u64; N]> {
    let list: Option<Vec<u64>> = text.split(' ').map(|n| n.parse().ok()).collect();
    list?.try_into().ok()
}

fn plane(text: &str) -> Option<((u32, u32, u32), [u32; Stage::ALL.len()])> {
    let words: Vec<&str> = text.split(' ').collect();
    let (key, sums) = words.split_at_checked(3)?;
    let sums: Option<Vec<u32>> = sums.iter().map(|s| hex(s)).collect();
    let key = (key[0].parse().ok()?, key[1].parse().ok()?, key[2].parse().ok()?);
    Some((key, sums?.try_into().ok()?))
}

/// Where two sets of sums differ first, in words; `None` if they are equal.
pub fn first_difference(device: &Sums, host: &Sums) -> Option<String> {
    for (key, expected) in &host.planes {
        let (index, u, v) = key;
        let Some(got) = device.planes.get(key) else {
            return Some(format!("plane {index} of phase ({u}, {v}) is missing"));
        };
        for (stage, (got, expected)) in Stage::ALL.iter().zip(got.iter().zip(expected)) {
            if got != expected {
                return Some(format!(
                    "first at stage \"{}\", plane {index}, phase ({u}, {v}): {got:08x}, host {expected:08x}",
                    stage.name()
                ));
            }
        }
    }
    if device.planes.len() != host.planes.len() {
        return Some(format!("{} planes, host {}", device.planes.len(), host.planes.len()));
    }
    if device.image != host.image {
        return Some(format!("only the image: {:08x}, host {:08x}", device.image, host.image));
    }
    if device.picture != host.picture {
        return Some(format!(
            "only the warp: picture {:08x}, host {:08x}",
            device.picture, host.picture
        ));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::{first_difference, parse};

    const OUTPUT: &str = "case small paper lit\nplane 0 0 0 1 2 3 4 5 6 7 8 9\nplane 1 0 0 1 2 3 4 5 6 7 8 9\nimage a\npicture b\n\
                          stack 512\nverdict pass\n";

    #[test]
    fn the_first_differing_stage_and_plane_are_named() {
        let host = parse(OUTPUT).unwrap().cases.remove(0).sums;
        let device = parse(&OUTPUT.replace("plane 1 0 0 1 2 3 4 5 6", "plane 1 0 0 1 2 3 4 5 f"));
        let text = first_difference(&device.unwrap().cases[0].sums, &host).unwrap();
        assert!(text.contains("\"normal\", plane 1"), "{text}");
        assert_eq!(first_difference(&host, &host), None);
    }

    #[test]
    fn nothing_a_program_says_is_overlooked() {
        assert!(parse(OUTPUT).unwrap().verdict);
        assert!(parse("panic at the disco\n").is_err());
        assert!(parse("case a\nplane 0 0 0 1 2\n").is_err());
        let missing = parse(&OUTPUT.replace("plane 1 0 0 1 2 3 4 5 6 7 8 9\n", "")).unwrap();
        let host = parse(OUTPUT).unwrap();
        assert!(first_difference(&missing.cases[0].sums, &host.cases[0].sums).is_some());
    }
}
