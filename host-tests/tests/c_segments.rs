//! The C that `slicecast table` writes for segments, compiled and linked with the header and the static library by the system's
//! compiler: its frames have the engine's bits.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use slicecast_engine::frame::{Layer, Prepared};
use slicecast_engine::integrals::Cumulative;
use slicecast_engine::rendering::in_memory_order;
use slicecast_export::integrals::{Source, integrals};
use slicecast_export::table::Language;
use slicecast_export::{Format, files};
use slicecast_firmware_shared::sum::Sum;
use slicecast_scene::file::built_in;
use slicecast_scene::{Classification, PrecisionName, Sampling, Scene};
use slicecast_volume::Volume;
use slicecast_volume::mapping::Window;
use slicecast_volume::open::load;

/// The static library that cargo has made beside this program, where it makes every crate type of a dependency; the newest,
/// because those of other features may be there, too.
fn library() -> PathBuf {
    let program = env::current_exe().unwrap();
    let folder = program.parent().unwrap();
    let made = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let archives = made.filter(|path| {
        let name = path.file_name().unwrap().to_string_lossy();
        name.starts_with("libslicecast_ffi") && name.ends_with(".a")
    });
    let newest = archives.max_by_key(|path| path.metadata().unwrap().modified().unwrap());
    newest.unwrap_or_else(|| panic!("no libslicecast_ffi.a in {}", folder.display()))
}

/// The sum of the engine's image, and the view's direction.
fn expected(scene: &Scene, volume: &Volume) -> (u32, [i64; 3]) {
    let scene = Scene {
        classification: Classification::Integral,
        ..scene.clone()
    };
    let prepared = Prepared::new(&scene, volume).unwrap();
    let frame = prepared.render(Layer::Tiles(32), &|_, _| ()).unwrap();
    let mut sum = Sum::new();
    in_memory_order(&frame.base, 1).for_each(|bits| sum.word(bits));
    (sum.get(), prepared.setup.plan.view().direction().map(|c| c.to_bits()))
}

/// The sums that `segments.c` asks for, and the direction to which it turns.
fn sums(scene: &Scene, volume: &Volume) -> String {
    let mut out = String::new();
    for precision in PrecisionName::STAGED {
        for (shading, lighting) in [("UNLIT", None), ("LIT", scene.lighting.clone())] {
            let (base, name) = (scene.clone(), precision.name().to_uppercase());
            let (sum, _) = expected(
                &Scene {
                    precision,
                    lighting,
                    ..base
                },
                volume,
            );
            let _ = writeln!(out, "#define {name}_{shading} {sum}u");
        }
    }
    let mut turned = Scene {
        lighting: None,
        ..scene.clone()
    };
    turned.view.azimuth = 22.0;
    turned.view.elevation = -15.0;
    let (sum, [x, y, z]) = expected(&turned, volume);
    let _ = writeln!(out, "#define TURNED {sum}u\n#define TURNED_DIRECTION {{{x}, {y}, {z}}}");
    out
}

/// The scene of `slicecast export`, the table of `slicecast table`, and a program.
fn renders(scene: &Scene, name: &str) {
    let volume = load(None, Window::Auto).unwrap().volume;
    let (root, folder) = (
        Path::new(env!("CARGO_MANIFEST_DIR")),
        env::temp_dir().join(format!("slicecast-c-segments-{name}-{}", std::process::id())),
    );
    fs::create_dir_all(&folder).unwrap();
    let write = |name: &str, text: &str| fs::write(folder.join(name), text).unwrap();
    let prepared = Prepared::new(scene, &volume).unwrap();
    for (name, text) in files(&prepared, Format::C, "head", true).unwrap() {
        write(&name, &text);
    }
    // All bins, as `render` has them.
    let table = Cumulative::of(&scene.transfer, &volume, 0);
    let source = Source {
        scene: "headsq",
        volume: &volume,
    };
    write("bone.h", &integrals(&table, source, "bone", Language::C));
    write("expected.h", &sums(scene, &volume));

    let program = folder.join("segments");
    let made = Command::new("cc")
        .args(["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1"])
        .arg("-I")
        .arg(root.join("../core/ffi/include"))
        .arg("-I")
        .arg(&folder)
        .args(["segments.c", "host.c"].map(|file| root.join("firmware/c").join(file)))
        .arg(library())
        .args(["-lpthread", "-ldl", "-lm", "-o"])
        .arg(&program)
        .output()
        .unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let ran = Command::new(&program).output().unwrap();
    let said = String::from_utf8_lossy(&ran.stdout);
    assert!(ran.status.success(), "{said}");
    let images: BTreeSet<&str> = said.lines().filter(|line| line.starts_with("image ")).collect();
    assert_eq!(images.len(), 7, "an image twice proves nothing: {said}");
    fs::remove_dir_all(&folder).unwrap();
}

/// The built-in head: two colours, so that all four lists are read.
fn head() -> Scene {
    Scene {
        sampling: Sampling::default(),
        ..built_in("headsq").unwrap()
    }
}

#[test]
fn lists_of_colours_render_the_engines_bits() {
    renders(&head(), "each");
}

#[test]
fn one_colour_renders_the_engines_bits() {
    let mut scene = head();
    scene
        .transfer
        .points
        .iter_mut()
        .for_each(|p| p.colour = [1.0, 0.5, 0.2]);
    renders(&scene, "one");
}
