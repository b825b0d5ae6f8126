//! The built-in head, exported: its files are all that a machine's programs in Rust and C have of scene and volume.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use slicecast::integral::Length;
use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::integrals::Cumulative;
use slicecast_engine::rendering::in_memory_order;
use slicecast_engine::segments::cut;
use slicecast_export::integrals::{Source, integrals};
use slicecast_export::table::Language;
use slicecast_export::{Format, files};
use slicecast_firmware_shared::image::add_rgb;
use slicecast_firmware_shared::sum::Sum;
use slicecast_scene::file::{DEFAULT, built_in};
use slicecast_scene::{Classification, Scene};
use slicecast_volume::Volume;
use slicecast_volume::mapping::Window;
use slicecast_volume::open::load;

use crate::c::build_and_run;
use crate::footprint::Footprint;
use crate::images::{Workshop, execute, parse};
use crate::machines::Machine;
use crate::scenes::Kind;
use crate::shell::{Failure, Finished};
use crate::{line, write_if_changed};

/// The machine that renders it: it says nothing of bits that one machine would not show.
pub const MACHINE: &str = "mps2-an386";

/// Where the files are.
pub fn directory(workshop: &Workshop) -> PathBuf {
    workshop.directory().join("exported")
}

/// Sums of the host's image and picture.
#[derive(Clone, Copy, Debug)]
pub struct Sums {
    image: u32,
    picture: u32,
}

/// Writes the files of `slicecast export --scene headsq --rays 1 --planes 1 --name head --voxels` in both languages, and the host's
/// sums.
///
/// # Errors
/// If the scene cannot be rendered or a file not written.
pub fn write(workshop: &Workshop) -> Result<Sums, Failure> {
    let words = |error: &dyn std::error::Error| Failure(format!("the exported head: {error}"));
    let volume = load(None, Window::Auto).map_err(|e| words(&e))?.volume;
    let mut scene = built_in(DEFAULT).map_err(|e| words(&e))?;
    scene.sampling = slicecast_scene::Sampling::default();
    let prepared = Prepared::new(&scene, &volume).map_err(|e| words(&e))?;
    let directory = directory(workshop);
    fs::create_dir_all(&directory).map_err(|e| words(&e))?;
    for format in [Format::Rust, Format::C] {
        for (name, text) in files(&prepared, format, "head", true).map_err(|e| words(&e))? {
            write_if_changed(&directory.join(name), &text)?;
        }
    }
    let frame = prepared.render(Layer::Stream, &|_, _| ()).map_err(|e| words(&e))?;
    let (mut image, mut picture) = (Sum::new(), Sum::new());
    in_memory_order(&frame.base, 1).for_each(|bits| image.word(bits));
    for pixel in frame.picture.bytes.as_chunks().0 {
        add_rgb(&mut picture, *pixel);
    }
    let sums = Sums {
        image: image.get(),
        picture: picture.get(),
    };
    let Sums { image, picture } = sums;
    let rust = format!(
        "/// Sum of the host's image.\npub const IMAGE: u32 = {image};\n/// Sum of its picture.\npub const PICTURE: u32 = {picture};\n"
    );
    write_if_changed(&directory.join("sums.rs"), &rust)?;
    let c = format!("#define IMAGE_SUM {image}u\n#define PICTURE_SUM {picture}u\n");
    write_if_changed(&directory.join("sums.h"), &c)?;
    segments(&scene, &volume, &directory)?;
    Ok(sums)
}

/// Codes of a bin on a device, log2.
const GRAIN: u32 = 2;

/// The sum of the host's image of segments by a device's table, and the direction of the view.
fn of_segments(scene: &Scene, volume: &Volume) -> Result<(u32, [i64; 3]), Failure> {
    let words = |error: &dyn std::error::Error| Failure(format!("the exported head: {error}"));
    let scene = Scene {
        classification: Classification::Integral,
        ..scene.clone()
    };
    let mut prepared = Prepared::new(&scene, volume).map_err(|e| words(&e))?;
    let length = Length::of(&prepared.setup.plan);
    let integrals = Cumulative::of(&scene.transfer, volume, GRAIN).classifier(length);
    prepared.segments = Some(cut(Some(integrals), &scene, &volume.mapping));
    let frame = prepared.render(Layer::Stream, &|_, _| ()).map_err(|e| words(&e))?;
    let mut sum = Sum::new();
    in_memory_order(&frame.base, 1).for_each(|bits| sum.word(bits));
    Ok((sum.get(), prepared.setup.plan.view().direction().map(|c| c.to_bits())))
}

/// Writes what `c/segments.c` reads beside the exported head: the table of `slicecast table --classification integral --format c
/// --name bone`, and the host's sums.
fn segments(scene: &Scene, volume: &Volume, directory: &Path) -> Result<(), Failure> {
    let table = Cumulative::of(&scene.transfer, volume, GRAIN);
    let source = Source { scene: DEFAULT, volume };
    write_if_changed(
        &directory.join("bone.h"),
        &integrals(&table, source, "bone", Language::C),
    )?;
    let mut out = String::new();
    for kind in Kind::all() {
        let (sum, _) = of_segments(
            &Scene {
                precision: kind.precision(),
                lighting: scene.lighting.clone().filter(|_| kind.lit),
                ..scene.clone()
            },
            volume,
        )?;
        let _ = writeln!(out, "#define {} {sum}u", kind.name().to_uppercase().replace(' ', "_"));
    }
    let mut turned = Scene {
        lighting: None,
        ..scene.clone()
    };
    turned.view.azimuth = 22.0;
    turned.view.elevation = -15.0;
    let (sum, [x, y, z]) = of_segments(&turned, volume)?;
    let _ = writeln!(out, "#define TURNED {sum}u\n#define TURNED_DIRECTION {{{x}, {y}, {z}}}");
    write_if_changed(&directory.join("expected.h"), &out)
}

/// Renders it from Rust and from C; returns the number of failures.
///
/// # Errors
/// If a program cannot be built or run.
pub fn on_machine(
    workshop: &Workshop,
    machine: &Machine,
    programs: &Path,
    library: &Path,
    sums: Sums,
) -> Result<u32, Failure> {
    let program = programs.join("exported");
    let in_rust = execute(machine, &program, false)?;
    let in_c = build_and_run(workshop, machine, library, "exported.c")?;
    let mut failed = 0;
    for (what, finished) in [("exported head, Rust", in_rust), ("exported head, C", in_c)] {
        let found = verdict(&finished, sums)?;
        failed += line(machine, what, &format!("{:08x}", sums.image), found);
    }
    println!("    RAM {} static (Rust)", Footprint::of(&program)?.ram);
    let finished = build_and_run(workshop, machine, library, "segments.c")?;
    let report = parse(&format!("{}{}", finished.out, finished.err))?;
    let good = finished.passed && report.verdict && report.cases.len() == 7;
    let found = (!good).then(|| {
        format!(
            "{:?}",
            report.cases.iter().map(|case| case.sums.image).collect::<Vec<_>>()
        )
    });
    failed += line(machine, "segments of the head, C", "", found);
    Ok(failed)
}

/// What is wrong, if anything.
fn verdict(finished: &Finished, sums: Sums) -> Result<Option<String>, Failure> {
    // QEMU writes what a program says by SYS_WRITE0 to its standard error.
    let report = parse(&format!("{}{}", finished.out, finished.err))?;
    let [case] = &report.cases[..] else {
        return Ok(Some("did not run".into()));
    };
    let got = (case.sums.image, case.sums.picture);
    let good = got == (sums.image, sums.picture) && finished.passed && report.verdict;
    Ok((!good).then(|| {
        format!(
            "image {:08x}, picture {:08x}, host {:08x} and {:08x}",
            got.0, got.1, sums.image, sums.picture
        )
    }))
}
