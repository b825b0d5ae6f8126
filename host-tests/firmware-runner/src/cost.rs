//! The cost table: flash, RAM, stack and instructions, measured and written to docs/firmware-cost.md.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;

use slicecast_firmware_shared::boundary::STAGES;

use crate::References;
use crate::footprint::Footprint;
use crate::images::{Case, Workshop, execute, parse};
use crate::machines::Machine;
use crate::proofs::{library, link};
use crate::scenes::Kind;
use crate::shell::{Failure, fail};

/// The scene in which every sample goes through every stage, and the scene of the built-in picture.
const DENSE: &str = "dense";
const HEAD: &str = "large";

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
    library_flash: u64,
    program_flash: u64,
    memory: u64,
    stack: u64,
    /// Instructions of a frame, by scene.
    frames: BTreeMap<&'static str, u64>,
    /// Instructions of the stages of the dense scene.
    stages: BTreeMap<String, u64>,
    /// Instructions of the f32 pipeline, by scene.
    float: BTreeMap<&'static str, u64>,
}

/// Measures and writes the table.
///
/// # Errors
/// If anything cannot be built or run, or a program's image is not the host's.
pub fn write(workshop: &Workshop, machines: &[Machine], references: &References) -> Result<(), Failure> {
    let mut rows = Vec::new();
    for machine in machines {
        println!("measuring {}", machine.name);
        rows.extend(measure(workshop, machine, references)?);
    }
    let text = table(&rows, machines, references, &workshop.toolchain.describe());
    let path = workshop.root.join("docs/firmware-cost.md");
    fs::create_dir_all(workshop.root.join("docs")).map_err(|error| Failure(error.to_string()))?;
    fs::write(&path, &text).map_err(|error| Failure(format!("{}: {error}", path.display())))?;
    print!("{text}");
    Ok(())
}

fn measure(workshop: &Workshop, machine: &Machine, references: &References) -> Result<Vec<Measured>, Failure> {
    let programs = workshop.images(machine)?;
    let archive = library(&workshop.toolchain, &workshop.root, machine.target, machine.cpu)?;
    let stages = parse(&execute(machine, &programs.join("stages"), true)?.out)?;
    let find = |name: &str| -> Result<&Case, Failure> {
        let found = stages.cases.iter().find(|case| case.name == name);
        found.ok_or_else(|| Failure(format!("no stages of {name}")))
    };
    let mut rows = Vec::new();
    for kind in Kind::all() {
        let program = programs.join(format!("frame-{}", kind.name().replace(' ', "-")));
        let finished = execute(machine, &program, true)?;
        let report = parse(&finished.out)?;
        let (mut frames, mut float) = (BTreeMap::new(), BTreeMap::new());
        for scene in [DENSE, HEAD] {
            let name = format!("{scene} {}", kind.name());
            let case = report.cases.iter().find(|case| case.name == name);
            let (sums, _) = &references[&(scene, kind)];
            match case {
                Some(Case {
                    sums: device,
                    instructions: Some(count),
                    ..
                }) if device.image == sums.image => frames.insert(scene, *count),
                _ => {
                    return fail(format!(
                        "{}: {name} was not rendered, or differs from the host",
                        machine.name
                    ));
                }
            };
            let case = find(&format!("{scene} f32 {}", kind.shading()))?;
            float.insert(scene, case.stages.values().sum());
        }
        rows.push(Measured {
            machine: *machine,
            kind,
            library_flash: link(workshop, machine, &archive, kind)?.flash,
            program_flash: Footprint::of(&program)?.flash,
            memory: report
                .cases
                .first()
                .and_then(|case| case.memory)
                .map_or(0, |m| m.iter().sum()),
            stack: report.stack.unwrap_or(0),
            frames,
            stages: find(&format!("{DENSE} {}", kind.name()))?.stages.clone(),
            float,
        });
    }
    Ok(rows)
}

fn table(rows: &[Measured], machines: &[Machine], references: &References, compiler: &str) -> String {
    let counts = |scene, kind| references[&(scene, kind)].1;
    let mut out = String::new();
    let _ = writeln!(
        out,
        "# What the firmware costs\n\nWritten by `host-tests/run-firmware --cost`; compiler: {compiler}.\n\n\
         Instructions are counted by QEMU (`-icount shift=0`), not estimated; they are instructions, not cycles. Two \
         scenes of 64^3 voxels of the built-in CT, one plane and one ray a voxel: *dense* makes every sample a little \
         opaque, so that every sample goes through every stage (the worst case); *head* is the built-in scene (skull \
         and skin, two lights). A *sample* is a place of a ray inside the volume, whether the pipeline skips it or not. \
         Every image measured here had the host's checksum.\n\n\
         - library: code and constants of the C library with this pipeline alone, without table\n\
         - program: the whole bare-metal program with start-up, semihosting and text output, without scene and table\n\
         - memory: what a stream of the dense scene borrows (ring of slices, scratch, image); nothing else is static\n\
         - stack: high-water mark of the program, printing included\n\
         - f32: the same pipeline written in f32 for the same machine, same scene, and the ratio f32 / fixed\n"
    );
    let _ = writeln!(
        out,
        "| core | shading | precision | library | program | memory | stack | dense, instr. a sample | f32 | ratio | head, \
         instr. a sample | f32 | ratio |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|"
    );
    for row in rows {
        let each = |scene: &str, count: u64, name| {
            let _: &str = scene;
            count as f64 / counts(name, row.kind).places as f64
        };
        let mut cells = String::new();
        for scene in [DENSE, HEAD] {
            let (fixed, float) = (
                each(scene, row.frames[scene], scene),
                each(scene, row.float[scene], scene),
            );
            let _ = write!(cells, " {fixed:.1} | {float:.1} | {:.2} |", float / fixed);
        }
        let _ = writeln!(
            out,
            "| {}{} | {} | {} | {} | {} | {} | {} |{cells}",
            row.machine.core,
            if row.machine.hard_float { "" } else { " (soft float)" },
            row.kind.shading(),
            row.kind.precision().name(),
            row.library_flash,
            row.program_flash,
            row.memory,
            row.stack,
        );
    }
    let _ = writeln!(
        out,
        "\n## Where the instructions go\n\nDense scene, instructions a sample, stage by stage: a tap reads the counter at \
         the stage boundaries. *stream* takes the slice (its check, its ranges, its copy) and loops; in lit pipelines \
         *gradient* includes the interpolation of the neighbouring row, which *interpolate* then finds done.\n"
    );
    let _ = writeln!(
        out,
        "| core | shading | precision | stream | {} |\n|---|---|---|---|{}",
        STAGES[1..].join(" | "),
        "---|".repeat(STAGES.len() - 1)
    );
    for row in rows {
        let places = counts(DENSE, row.kind).places as f64;
        let cells: String = STAGES
            .iter()
            .map(|stage| format!(" {:.1} |", row.stages.get(*stage).copied().unwrap_or(0) as f64 / places))
            .collect();
        let (core, kind) = (row.machine.core, row.kind);
        let _ = writeln!(
            out,
            "| {core} | {} | {} |{cells}",
            kind.shading(),
            kind.precision().name()
        );
    }
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
                let found = rows.iter().find(|row| {
                    row.machine.name == part.machine
                        && row.kind.lit == lit
                        && row.kind.precision() == Kind::COMPACT_LIT.precision()
                });
                let frames = found.map_or(0.0, |row| {
                    part.megahertz * 1e6 * part.per_cycle / row.frames[scene] as f64
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
    out
}
