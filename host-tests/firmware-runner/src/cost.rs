//! The cost table: flash, RAM, stack and instructions, measured and written to docs/firmware-cost.md.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use slicecast::stage::Stage;
use slicecast_scene::PrecisionName;

use crate::References;
use crate::fast::{self, Fast};
use crate::footprint::Footprint;
use crate::images::{Case, Workshop, execute, parse};
use crate::machines::Machine;
use crate::proofs::{entry, library, link};
use crate::scenes::{COSTED, Kind};
use crate::segments::{self, Segments};
use crate::shell::{Failure, fail};

/// The boundaries up to compositing.
const FIRST: &[Stage] = Stage::ALL.split_at(7).0;

/// The scene in which every sample goes through every stage, and the scene of the built-in picture.
const DENSE: &str = COSTED[0];
const HEAD: &str = COSTED[1];

/// A part that can be bought: clock and instructions a cycle that are assumed of it.
struct Part {
    name: &'static str,
    machine: &'static str,
    megahertz: f64,
    per_cycle: f64,
}

/// Assumed, not measured: sustained instructions a cycle with code and slices in the core's own fast memory.
const PARTS: [Part; 4] = [
    Part {
        name: "STM32H743 (Cortex-M7)",
        machine: "mps2-an500",
        megahertz: 480.0,
        per_cycle: 1.2,
    },
    Part {
        name: "i.MX RT1170 (Cortex-M7)",
        machine: "mps2-an500",
        megahertz: 1000.0,
        per_cycle: 1.2,
    },
    Part {
        name: "RP2350 (Cortex-M33)",
        machine: "mps2-an505",
        megahertz: 150.0,
        per_cycle: 0.8,
    },
    Part {
        name: "ESP32-P4 (RV32)",
        machine: "virt",
        megahertz: 400.0,
        per_cycle: 0.8,
    },
];

/// What one pipeline takes on one machine.
struct Measured {
    machine: Machine,
    kind: Kind,
    fast: Taken,
    /// Optimised for size.
    small: Option<Taken>,
    /// Instructions of the stages, by scene,
    stages: BTreeMap<&'static str, Stages>,
    /// and those of the f32 pipeline.
    float: BTreeMap<&'static str, Stages>,
    bands: Option<Bands>,
}

/// The head in bands.
struct Bands {
    /// How many, of how many rows.
    number: String,
    instructions: u64,
    /// Statics and stack.
    ram: u64,
}

/// Instructions by stage.
type Stages = BTreeMap<String, u64>;

/// What a program takes.
struct Taken {
    library: u64,
    program: u64,
    memory: u64,
    stack: u64,
    /// Instructions of a frame, by scene.
    frames: BTreeMap<&'static str, u64>,
}

/// Measures and writes the table.
///
/// # Errors
/// If anything cannot be built or run, or a program's image is not the host's.
pub fn write(
    workshop: &Workshop,
    machines: &[Machine],
    references: &References,
    (segments, fast): (&Segments, &Fast),
) -> Result<(), Failure> {
    let (mut rows, mut beside, mut lanes) = (Vec::new(), segments::HEADING.to_owned(), fast::HEADING.to_owned());
    for machine in machines {
        println!("measuring {}", machine.name);
        rows.extend(measure(workshop, machine, references)?);
        let programs = workshop.images(machine, "release", &["segments", "fast"])?;
        let (tools, root) = (&workshop.toolchain, &workshop.root);
        let archive = library(tools, root, "firmware", machine.target, machine.cpu)?;
        beside.push_str(&segments.rows(workshop, machine, &programs, &archive)?);
        lanes.push_str(&fast.rows(workshop, machine, &programs, &archive)?);
    }
    let beside = format!("{lanes}\n{beside}");
    let text = table(&rows, machines, references, &workshop.toolchain.describe(), &beside);
    let path = workshop.root.join("docs/firmware-cost.md");
    fs::create_dir_all(workshop.root.join("docs")).map_err(|error| Failure(error.to_string()))?;
    fs::write(&path, &text).map_err(|error| Failure(format!("{}: {error}", path.display())))?;
    print!("{text}");
    Ok(())
}

/// The program of one pipeline.
fn program_name(kind: Kind) -> String {
    format!("frame-{}", kind.name().replace(' ', "-"))
}

/// Whether a kind is measured for size, too: those of the default precision.
fn in_small(kind: Kind) -> bool {
    kind.precision() == Kind::COMPACT_LIT.precision()
}

fn measure(workshop: &Workshop, machine: &Machine, references: &References) -> Result<Vec<Measured>, Failure> {
    let build = |profile: &str, library_profile: &str, kinds: &[Kind], others: &[&str]| {
        let names: Vec<String> = kinds.iter().map(|kind| program_name(*kind)).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).chain(others.iter().copied()).collect();
        let programs = workshop.images(machine, profile, &names)?;
        let archive = library(
            &workshop.toolchain,
            &workshop.root,
            library_profile,
            machine.target,
            machine.cpu,
        )?;
        Ok::<_, Failure>((programs, archive))
    };
    let kinds: Vec<Kind> = Kind::all().collect();
    let small_kinds: Vec<Kind> = Kind::all().filter(|kind| in_small(*kind)).collect();
    let fast = build("release", "firmware", &kinds, &["stages", "bands"])?;
    let small = build("small", "firmware-small", &small_kinds, &[])?;
    let finished = execute(machine, &fast.0.join("stages"), true)?;
    let stages = parse(&finished.out)?;
    if !finished.passed {
        return fail(format!("{}: the f32 pipeline renders another picture", machine.name));
    }
    let find = |name: &str| -> Result<&Case, Failure> {
        let found = stages.cases.iter().find(|case| case.name == name);
        found.ok_or_else(|| Failure(format!("no stages of {name}")))
    };
    let mut rows = Vec::new();
    for kind in kinds {
        let (mut stages, mut float) = (BTreeMap::new(), BTreeMap::new());
        for scene in [DENSE, HEAD] {
            stages.insert(scene, find(&format!("{scene} {}", kind.name()))?.stages.clone());
            float.insert(scene, find(&format!("{scene} f32 {}", kind.shading()))?.stages.clone());
        }
        rows.push(Measured {
            machine: *machine,
            kind,
            fast: take(workshop, machine, kind, &fast, references)?,
            small: if in_small(kind) {
                Some(take(workshop, machine, kind, &small, references)?)
            } else {
                None
            },
            stages,
            float,
            bands: if kind == Kind::COMPACT_LIT {
                Some(bands(machine, &fast.0.join("bands"), references)?)
            } else {
                None
            },
        });
    }
    Ok(rows)
}

/// The head, compact and lit, in bands.
fn bands(machine: &Machine, program: &Path, references: &References) -> Result<Bands, Failure> {
    let report = parse(&execute(machine, program, true)?.out)?;
    let (sums, _) = &references[&(HEAD, Kind::COMPACT_LIT)];
    match report.cases.first() {
        Some(case) if case.sums.image == sums.image => Ok(Bands {
            number: case.notes.first().cloned().unwrap_or_default(),
            instructions: case.instructions.unwrap_or(0),
            ram: Footprint::of(program)?.ram + report.stack.unwrap_or(0),
        }),
        _ => fail(format!("{}: the bands differ from the host", machine.name)),
    }
}

/// What a pipeline takes of a built program and library.
fn take(
    workshop: &Workshop,
    machine: &Machine,
    kind: Kind,
    (programs, archive): &(PathBuf, PathBuf),
    references: &References,
) -> Result<Taken, Failure> {
    let program = programs.join(program_name(kind));
    let report = parse(&execute(machine, &program, true)?.out)?;
    let mut frames = BTreeMap::new();
    for scene in [DENSE, HEAD] {
        let name = format!("{scene} {}", kind.name());
        let case = report.cases.iter().find(|case| case.name == name);
        let (sums, _) = &references[&(scene, kind)];
        match case.and_then(|case| case.instructions.filter(|_| case.sums.image == sums.image)) {
            Some(count) => frames.insert(scene, count),
            None => {
                return fail(format!(
                    "{}: {name} was not rendered, or differs from the host",
                    machine.name
                ));
            }
        };
    }
    let memory = report.cases.first().and_then(|case| case.memory);
    Ok(Taken {
        library: link(workshop, machine, archive, &entry(kind, false))?.flash,
        program: Footprint::of(&program)?.flash,
        memory: memory.map_or(0, |m| m.iter().sum()),
        stack: report.stack.unwrap_or(0),
        frames,
    })
}

fn table(rows: &[Measured], machines: &[Machine], references: &References, compiler: &str, segments: &str) -> String {
    let counts = |scene, kind| references[&(scene, kind)].1;
    let mut out = String::new();
    let _ = writeln!(
        out,
        "# What the firmware costs\n\nWritten by `host-tests/run-firmware --cost`; compiler: {compiler}.\n\n\
         Instructions are counted by QEMU (`-icount shift=0`), not estimated; they are instructions, not cycles. Two \
         scenes of 64^3 voxels of the built-in CT, one plane and one ray per voxel: *dense* makes every sample a little \
         opaque, so that every sample goes through every stage (the worst case); *head* is the built-in scene (skull \
         and skin, two lights). A *sample* is a place of a ray inside the volume, whether the pipeline skips it or not. \
         Every image measured here had the host's checksum.\n\n\
         - library: code and constants of the C library with this pipeline alone, without table\n\
         - program: the whole bare-metal program with start-up, semihosting and text output, without scene and table\n\
         - memory: what a stream of the dense scene borrows (ring of slices, scratch, image); nothing else is static\n\
         - stack: high-water mark of the program, printing included\n\
         - f32: the same pipeline written in f32 for the same machine (`host-tests/firmware/src/float.rs`), same scene, same \
         skips, the picture that of `wide` within an 8-bit step, which is checked; and the ratio f32 / fixed. It reads the volume \
         in place (no ring) and needs a table of 64 KiB and 16 bytes per pixel. A square root or a division of a floating-point \
         unit counts as one instruction here and takes about 14 cycles\n"
    );
    let _ = writeln!(
        out,
        "| core | pipeline | library | program | memory | stack | dense, instr. a sample | f32 | ratio | head, instr. a \
         sample | f32 | ratio |\n|---|---|---|---|---|---|---|---|---|---|---|---|"
    );
    for row in rows {
        let places = |scene| counts(scene, row.kind).places as f64;
        let mut cells = String::new();
        for scene in [DENSE, HEAD] {
            let fixed = row.fast.frames[scene] as f64 / places(scene);
            let float = row.float[scene].values().sum::<u64>() as f64 / places(scene);
            let _ = write!(cells, " {fixed:.1} | {float:.1} | {:.2} |", float / fixed);
        }
        let _ = writeln!(
            out,
            "| {} | {} | {} | {} | {} | {} |{cells}",
            row.name(),
            row.kind.name(),
            row.fast.library,
            row.fast.program,
            row.fast.memory,
            row.fast.stack,
        );
    }
    let _ = writeln!(
        out,
        "\n## For size\n\nThe same with `opt-level = \"s\"` (profiles `firmware-small` and `small`), the default precision.\n\n\
         | core | pipeline | library | program | stack | dense, instr. a sample | head, instr. a sample |\n\
         |---|---|---|---|---|---|---|"
    );
    for row in rows {
        let Some(small) = &row.small else { continue };
        let each = |scene| small.frames[scene] as f64 / counts(scene, row.kind).places as f64;
        let _ = writeln!(
            out,
            "| {} | {} | {} | {} | {} | {:.1} | {:.1} |",
            row.machine.core,
            row.kind.name(),
            small.library,
            small.program,
            small.stack,
            each(DENSE),
            each(HEAD),
        );
    }
    let _ = write!(out, "\n{segments}");
    for (scene, heading) in [
        (DENSE, "Where the instructions go, dense"),
        (HEAD, "Where the instructions go, head"),
    ] {
        let _ = writeln!(
            out,
            "\n## {heading}\n\nInstructions a sample, stage by stage: a tap reads the counter at the stage boundaries. \
             *stream* takes the slice (its check, its ranges, its copy) and loops; *colour* includes the search for \
             visible spans; in lit pipelines *gradient* includes the interpolation of the neighbouring row, which \
             *interpolate* then finds done.\n\n| core | pipeline | stream | {} |\n|---|---|---|{}",
            FIRST[1..]
                .iter()
                .map(|stage| stage.name())
                .collect::<Vec<_>>()
                .join(" | ")
                + " | composite",
            "---|".repeat(FIRST.len())
        );
        for row in rows {
            let places = counts(scene, row.kind).places as f64;
            let mut line = |name: &str, stages: &Stages| {
                let each = |stage: Stage| stages.get(stage.name()).copied().unwrap_or(0) as f64 / places;
                let mut cells: String = FIRST.iter().map(|stage| format!(" {:.1} |", each(*stage))).collect();
                let composite = each(Stage::Before) + each(Stage::After);
                let _ = write!(cells, " {composite:.1} |");
                let _ = writeln!(out, "| {} | {name} |{cells}", row.machine.core);
            };
            line(&row.kind.name(), &row.stages[scene]);
            // Once a shading, behind the last precision.
            if row.kind.precision() == PrecisionName::Wide {
                line(&format!("f32 {}", row.kind.shading()), &row.float[scene]);
            }
        }
    }
    let _ = writeln!(
        out,
        "\n## Bands\n\nHead, compact, lit, in at most 65,536 bytes of RAM for statics and stack together, printing included: \
         the image in bands, the slices read again for each, against the image in one piece.\n\n\
         | core | bands | RAM | instructions per frame | in one piece | ratio |\n|---|---|---|---|---|---|"
    );
    for row in rows {
        let Some(bands) = &row.bands else { continue };
        let (count, whole) = (bands.instructions, row.fast.frames[HEAD]);
        let _ = writeln!(
            out,
            "| {} | {} | {} | {count} | {whole} | {:.2} |",
            row.machine.core,
            bands.number.trim_start_matches("bands "),
            bands.ram,
            count as f64 / whole as f64,
        );
    }
    frames_a_second(&mut out, rows, machines);
    out
}

impl Measured {
    fn name(&self) -> String {
        let soft = if self.machine.hard_float { "" } else { " (soft float)" };
        format!("{}{soft}", self.machine.core)
    }
}

fn frames_a_second(out: &mut String, rows: &[Measured], machines: &[Machine]) {
    let _ = writeln!(
        out,
        "\n## Frames a second\n\nThe 64^3 scenes on parts that can be bought, compact: clock times the instructions a cycle \
         that are *assumed* (code and slices in the core's fastest memory; flash wait states come on top), divided by the \
         instructions counted above. The warp to the viewer's picture is not included.\n\n\
         | part | MHz | assumed instr. a cycle | dense unlit | dense lit | head unlit | head lit |\n|---|---|---|---|---|---|---|"
    );
    for part in PARTS
        .iter()
        .filter(|part| machines.iter().any(|m| m.name == part.machine))
    {
        let mut cells = String::new();
        for scene in [DENSE, HEAD] {
            for lit in [false, true] {
                let found = rows
                    .iter()
                    .find(|row| row.machine.name == part.machine && row.kind.lit == lit && in_small(row.kind));
                let frames = found.map_or(0.0, |row| {
                    part.megahertz * 1e6 * part.per_cycle / row.fast.frames[scene] as f64
                });
                let _ = write!(cells, " {frames:.1} |");
            }
        }
        let _ = writeln!(
            out,
            "| {} | {} | {} |{cells}",
            part.name, part.megahertz, part.per_cycle
        );
    }
}
