//! Classified segments: one table of integrals on the device, seen from three views, and surfaces in its volume.

use std::fmt::Write as _;
use std::path::Path;

use slicecast::cut::Cut;
use slicecast::integral::{Colours, Length};
use slicecast::surface::Surface;
use slicecast_engine::depth::depths;
use slicecast_engine::frame::Prepared;
use slicecast_engine::integrals::Cumulative;
use slicecast_engine::oriented::{Oriented, Turned};
use slicecast_firmware_shared::scene::SURFACES;
use slicecast_firmware_shared::sum::Sum;
use slicecast_scene::file::parse;
use slicecast_scene::{Classification, PrecisionName, Scene};
use slicecast_volume::mapping::Window;
use slicecast_volume::open::load;

use crate::images::{Case, Report, Workshop, execute, first_difference, parse as parse_report};
use crate::line;
use crate::machines::Machine;
use crate::proofs::{entry, link};
use crate::reference::{Counts, Sums, reference, sums};
use crate::scenes::{Kind, LARGE, Named, constant_name, crop};
use crate::shell::{Failure, fail};

/// Codes of a bin on a device, log2: lists of 1025 nodes, 4 KiB each.
const GRAIN: u32 = 2;

/// The kind that is bounded.
const UNLIT: Kind = Kind::COMPACT_UNLIT;

/// Instructions that a dense unlit sample of that kind may take on a Cortex-M4.
const DENSE_UNLIT_MAX: f64 = 400.0;

/// What the host knows.
#[derive(Debug)]
pub struct Segments {
    turns: Vec<Named>,
    dense: Named,
    /// Of every turn and kind,
    references: Vec<(String, Sums)>,
    /// of the first turn with surfaces in it, and their depths,
    cut: Vec<(String, Sums)>,
    depths: (String, u32),
    /// and of the dense scene, by points and by segments.
    counted: Vec<(Kind, [(Sums, Counts); 2])>,
}

/// What the rows of the cost are.
pub const HEADING: &str = "## Segments\n\nThe same dense scene by points and by segments ([contract/integral.md](contract/integral.md)), \
     counted in one program (`host-tests/firmware/src/bin/segments.rs`; `host-tests/run-firmware MACHINE` prints these rows, too). A \
     table of integrals has 16400 bytes (1025 nodes; of one colour 4100) and holds for every view; one of points has 20480 \
     (`compact`) or 32768 (`wide`) and holds for one length of step. `library` and `memory` are as above.\n\n\
     | core | pipeline | library: points | segments | memory: points | segments | dense, instr. a sample: points | segments | \
     ratio |\n|---|---|---|---|---|---|---|---|---|\n";

/// The precisions that are shown.
fn kinds() -> impl Iterator<Item = Kind> {
    Kind::all().filter(|kind| kind.precision() != PrecisionName::Paper)
}

/// The integrals of a scene for a device.
fn cumulative(scene: &Scene, named: &Named) -> Cumulative {
    Cumulative::of(&scene.transfer, &named.volume, GRAIN)
}

/// A scene as a device has it: its integrals, and no surface or all.
fn prepared<'a>(scene: &'a Scene, named: &'a Named, surfaces: &[Surface]) -> Result<Prepared<'a>, Failure> {
    let words = |error: &dyn std::error::Error| Failure(format!("{}: {error}", named.name));
    let mut prepared = Prepared::new(scene, &named.volume).map_err(|e| words(&e))?;
    let integrals = cumulative(scene, named).classifier(Length::of(&prepared.setup.plan));
    let cut = Cut::new(Some(integrals), surfaces.into(), 1).map_err(|e| words(&e))?;
    prepared.segments = Some(cut);
    Ok(prepared)
}

fn of_kind(named: &Named, kind: Kind, surfaces: &[Surface]) -> Result<(Sums, Counts), Failure> {
    let words = |error: &dyn std::error::Error| Failure(format!("{}: {error}", named.name));
    let scene = Scene {
        classification: Classification::Integral,
        ..named.of_kind(kind)
    };
    let prepared = prepared(&scene, named, surfaces)?;
    sums(&prepared).map_err(|e| words(&e))
}

/// The sum of the depths of the surfaces in `Compact`.
fn depths_of(named: &Named) -> Result<u32, Failure> {
    let words = |error: &dyn std::error::Error| Failure(format!("{}: {error}", named.name));
    let scene = Scene {
        classification: Classification::Integral,
        precision: PrecisionName::Compact,
        ..named.scene.clone()
    };
    let prepared = prepared(&scene, named, &SURFACES)?;
    let mut turned = Turned::new(&named.volume, &prepared.setup.plan);
    let slices = turned.slices().map_err(|e| words(&e))?;
    let Some(found) = depths(&prepared, &Oriented::of(&slices), &|_, _| ()).map_err(|e| words(&e))? else {
        return fail("there are no surfaces");
    };
    let mut sum = Sum::new();
    found.depths.iter().for_each(|depth| sum.word(*depth));
    Ok(sum.get())
}

impl Segments {
    /// Renders all that devices will render.
    ///
    /// # Errors
    /// If a scene cannot be rendered.
    pub fn new(scenes: &[Named]) -> Result<Self, Failure> {
        let head = load(None, Window::Auto)
            .map_err(|error| Failure(error.to_string()))?
            .volume;
        let volume = crop(&head, [16, 4, 34], [32; 3])?;
        let views = [
            ("turn-0", "30.0", "10.0"),
            ("turn-1", "22.0", "-15.0"),
            ("turn-2", "40.5", "12.0"),
        ];
        let turn = |(name, azimuth, elevation): (&'static str, &str, &str)| -> Result<Named, Failure> {
            let text = LARGE
                .replacen("azimuth = 30.0", &format!("azimuth = {azimuth}"), 1)
                .replacen("elevation = 10.0", &format!("elevation = {elevation}"), 1)
                .replacen("size = [96, 96]", "size = [48, 48]", 1);
            Ok(Named {
                name,
                scene: parse(&text, name).map_err(|error| Failure(error.to_string()))?,
                volume: volume.clone(),
            })
        };
        let turns = views.into_iter().map(turn).collect::<Result<Vec<_>, _>>()?;
        let Some(dense) = scenes.iter().find(|named| named.name == "dense") else {
            return fail("there is no dense scene");
        };
        let dense = Named {
            name: dense.name,
            scene: dense.scene.clone(),
            volume: dense.volume.clone(),
        };
        let mut references = Vec::new();
        for named in &turns {
            for kind in kinds() {
                references.push((format!("{} {}", named.name, kind.name()), of_kind(named, kind, &[])?.0));
            }
        }
        let Some(first) = turns.first() else {
            return fail("there are no turns");
        };
        let mut cut = Vec::new();
        for kind in kinds() {
            cut.push((
                format!("surfaces {} {}", first.name, kind.name()),
                of_kind(first, kind, &SURFACES)?.0,
            ));
        }
        let depths = (format!("depths {}", first.name), depths_of(first)?);
        let mut counted = Vec::new();
        for kind in kinds() {
            counted.push((kind, [reference(&dense, kind)?, of_kind(&dense, kind, &[])?]));
        }
        Ok(Self {
            turns,
            dense,
            references,
            cut,
            depths,
            counted,
        })
    }

    /// Rust source of the scenes and tables.
    ///
    /// # Errors
    /// If a view meets the slices in another order than the first.
    pub fn source(&self) -> Result<String, Failure> {
        let mut out = String::new();
        let Some((first, others)) = self.turns.split_first() else {
            return fail("there are no turns");
        };
        out.push_str(&first.rust()?);
        let data = constant_name(first.name);
        let voxels = first.numbers()?.voxels;
        for other in others {
            let numbers = other.numbers()?;
            if numbers.voxels != voxels {
                return fail(format!("{} meets the slices in another order", other.name));
            }
            out.push_str(&other.constant(&numbers, &data));
        }
        for (name, named) in [("TURN", first), ("DENSE", &self.dense)] {
            out.push_str(&table(name, &cumulative(&named.scene, named)));
        }
        let names: Vec<String> = self.turns.iter().map(|named| constant_name(named.name)).collect();
        let images: Vec<u32> = self.references.iter().map(|(_, sums)| sums.image).collect();
        let images: Vec<&[u32]> = images.chunks(kinds().count()).collect();
        let _ = writeln!(
            out,
            "/// One table, several views.\npub static TURNS: [&SceneData; {}] = [{}];\n\
             /// The sums that their images must have.\npub static TURNS_EXPECTED: [[u32; {}]; {}] = {images:?};",
            names.len(),
            names.join(", "),
            kinds().count(),
            names.len(),
        );
        let cut: Vec<u32> = self.cut.iter().map(|(_, sums)| sums.image).collect();
        let (_, depths) = &self.depths;
        let _ = writeln!(
            out,
            "/// The sums of the images with surfaces.\npub static SURFACES_EXPECTED: [u32; {}] = {cut:?};\n\
             /// The sum of the surfaces' depths.\npub static DEPTHS_EXPECTED: u32 = {depths};",
            cut.len(),
        );
        Ok(out)
    }

    /// Holds a machine to the host; returns the number of failures.
    ///
    /// # Errors
    /// If the program does not run.
    pub fn check(
        &self,
        workshop: &Workshop,
        programs: &Path,
        machine: &Machine,
        library: &Path,
    ) -> Result<u32, Failure> {
        let finished = execute(machine, &programs.join("segments"), true)?;
        let report = parse_report(&finished.out)?;
        let find = |name: &String| report.cases.iter().find(|case| case.name == *name);
        let mut failed = 0;
        for (name, host) in self.references.iter().chain(&self.cut) {
            let verdict = match find(name) {
                Some(case) => first_difference(&case.sums, host),
                None => Some("did not run".to_owned()),
            };
            failed += line(
                machine,
                &format!("segments {name}"),
                &format!("{:08x}", host.image),
                verdict,
            );
        }
        let (name, depths) = &self.depths;
        let found = find(name).map(|case| case.sums.image);
        let verdict = (found != Some(*depths)).then(|| format!("found {found:08x?}"));
        failed += line(machine, &format!("segments {name}"), &format!("{depths:08x}"), verdict);
        let rows = self.costs(&report)?;
        for (kind, [_, per_sample]) in &rows {
            let bounded = machine.core == "Cortex-M4" && *kind == UNLIT;
            let verdict = (bounded && *per_sample > DENSE_UNLIT_MAX)
                .then(|| format!("{per_sample:.1} instructions per sample, more than {DENSE_UNLIT_MAX}"));
            let what = format!("segments {} {}", self.dense.name, kind.name());
            failed += line(machine, &what, &format!("{per_sample:.1}"), verdict);
        }
        print!("{HEADING}{}", self.table(workshop, machine, &report, library)?);
        let verdict = (!finished.passed || !report.verdict).then(|| "its own verdict: fail".to_owned());
        failed += line(machine, "segments exit", "", verdict);
        Ok(failed)
    }

    /// Rows of the cost table of a machine.
    ///
    /// # Errors
    /// If the program does not run, or an image is not the host's.
    pub fn rows(
        &self,
        workshop: &Workshop,
        machine: &Machine,
        programs: &Path,
        library: &Path,
    ) -> Result<String, Failure> {
        let finished = execute(machine, &programs.join("segments"), true)?;
        self.table(workshop, machine, &parse_report(&finished.out)?, library)
    }

    /// A case of the dense scene, whose image must be the host's.
    fn case<'r>(&self, report: &'r Report, way: &str, kind: Kind, host: &Sums) -> Result<&'r Case, Failure> {
        let name = format!("{way} {} {}", self.dense.name, kind.name());
        match report.cases.iter().find(|case| case.name == name) {
            Some(case) if case.sums.image == host.image => Ok(case),
            Some(case) => fail(format!("{name}: {:08x}, host {:08x}", case.sums.image, host.image)),
            None => fail(format!("{name} did not run")),
        }
    }

    /// Instructions per sample by points and by segments.
    fn costs(&self, report: &Report) -> Result<Vec<(Kind, [f64; 2])>, Failure> {
        let each = |way, kind, (sums, counts): &(Sums, Counts)| -> Result<f64, Failure> {
            let instructions = self.case(report, way, kind, sums)?.instructions;
            Ok(instructions.unwrap_or(u64::MAX) as f64 / counts.places as f64)
        };
        let row = |(kind, [points, segments]): &(Kind, [(Sums, Counts); 2])| {
            Ok((
                *kind,
                [each("points", *kind, points)?, each("segments", *kind, segments)?],
            ))
        };
        self.counted.iter().map(row).collect()
    }

    fn table(
        &self,
        workshop: &Workshop,
        machine: &Machine,
        report: &Report,
        library: &Path,
    ) -> Result<String, Failure> {
        let mut out = String::new();
        for ((kind, [points, segments]), (_, hosts)) in self.costs(report)?.into_iter().zip(&self.counted) {
            let flash = |of_segments: bool| -> Result<u64, Failure> {
                Ok(link(workshop, machine, library, &entry(kind, of_segments))?.flash)
            };
            let memory = |way: &str, (host, _): &(Sums, Counts)| -> Result<u64, Failure> {
                Ok(self
                    .case(report, way, kind, host)?
                    .memory
                    .map_or(0, |parts| parts.iter().sum()))
            };
            let _ = writeln!(
                out,
                "| {} | {} | {} | {} | {} | {} | {points:.1} | {segments:.1} | {:.2} |",
                machine.core,
                kind.name(),
                flash(false)?,
                flash(true)?,
                memory("points", &hosts[0])?,
                memory("segments", &hosts[1])?,
                segments / points,
            );
        }
        Ok(out)
    }
}

/// A table as Rust constants.
fn table(name: &str, table: &Cumulative) -> String {
    let mut out = String::new();
    let list = |out: &mut String, part: &str, nodes: &[u32]| {
        let _ = writeln!(
            out,
            "#[unsafe(link_section = \".scene\")]\nstatic {name}_{part}: [u32; {}] = {nodes:?};",
            nodes.len()
        );
    };
    list(&mut out, "EXTINCTION", &table.extinction);
    let colours = match &table.colours {
        Colours::One(colour) => format!("Colours::One({colour:?})"),
        Colours::Each([red, green, blue]) => {
            for (part, nodes) in [("RED", red), ("GREEN", green), ("BLUE", blue)] {
                list(&mut out, part, nodes);
            }
            format!("Colours::Each([&{name}_RED, &{name}_GREEN, &{name}_BLUE])")
        }
    };
    let _ = writeln!(
        out,
        "/// Written by the runner.\npub static {name}_INTEGRALS: &IntegralData = &IntegralData {{ extinction: \
         &{name}_EXTINCTION, colours: {colours}, grain: {}, exponent: {} }};",
        table.grain, table.exponent,
    );
    out
}
