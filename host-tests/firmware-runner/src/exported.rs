//! The built-in head, exported: its files are all that a machine's programs in Rust and C have of scene and volume.

use std::fs;
use std::path::{Path, PathBuf};

use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::rendering::in_memory_order;
use slicecast_export::{Format, files};
use slicecast_firmware_shared::image::add_rgb;
use slicecast_firmware_shared::sum::Sum;
use slicecast_scene::file::{DEFAULT, built_in};
use slicecast_volume::mapping::Window;
use slicecast_volume::open::load;

use crate::c::build_and_run;
use crate::footprint::Footprint;
use crate::images::{Workshop, execute, parse};
use crate::machines::Machine;
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
    Ok(sums)
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
