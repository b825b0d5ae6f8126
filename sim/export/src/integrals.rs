//! Tables of integrals for other programs: Rust, C, and Verilog's `$readmemh`.

use std::fmt::Write;

use slicecast::integral::Colours;
use slicecast_engine::integrals::Cumulative;
use slicecast_volume::Volume;

use crate::numbers::{mapping_words, one_line, volume_words};
use crate::table::{Language, identifier, words};

/// Where a table comes from.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a> {
    /// The scene's name.
    pub scene: &'a str,
    /// The volume, whose mapping and smallest spacing are the table's.
    pub volume: &'a Volume,
}

/// The text of a table of integrals. `name` becomes the arrays' name; characters that no identifier has are replaced by `_`.
///
/// Rust and C get a list of nodes for extinction and, where colours differ, one each for red, green, blue; else the colour
/// (1.31). A line of `$readmemh` is a node: extinction (32 bits); where colours differ blue, green, red and extinction, blue in
/// the highest of 128 bits. All begin with grain, exponent, bytes and source. C behind `slicecast.h` gets a `SlicecastIntegrals`,
/// too.
pub fn integrals(table: &Cumulative, source: Source<'_>, name: &str, language: Language) -> String {
    let name = identifier(name);
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = match language {
        Language::Rust => rust(&mut out, table, &source, &name.to_ascii_uppercase()),
        Language::C => c(&mut out, table, &source, &name.to_ascii_lowercase()),
        Language::Readmemh => readmemh(&mut out, table, &source),
    };
    out
}

/// What the lists are, and whence.
fn about(table: &Cumulative, source: &Source<'_>) -> Vec<String> {
    let lists = match table.colours {
        Colours::One(_) => "extinction; the colour is one",
        Colours::Each(_) => "extinction, and extinction times red, green, blue",
    };
    let nodes = table.extinction.len();
    vec![
        format!("program   slicecast {}", env!("CARGO_PKG_VERSION")),
        format!("scene     {}", one_line(source.scene)),
        format!("volume    {}", volume_words(source.volume)),
        format!("mapping   {}", mapping_words(&source.volume.mapping)),
        format!("integrals of {lists}; docs/contract/integral.md"),
        format!(
            "lists     {nodes} nodes each, {} bytes in all, which may lie in flash",
            table.bytes()
        ),
        format!("grain     {}: a bin is {} code(s)", table.grain, 1 << table.grain),
        format!("exponent  {0}: nodes are 2^{0} times the integrals", table.exponent),
        "use       holds for every view, step and number of planes per voxel; only the segments' length changes".into(),
    ]
}

const CHANNELS: [&str; 3] = ["red", "green", "blue"];

fn rust(out: &mut String, table: &Cumulative, source: &Source<'_>, name: &str) -> std::fmt::Result {
    let len = table.extinction.len();
    for line in about(table, source) {
        writeln!(out, "// {line}")?;
    }
    let mut list = |name: &str, what: &str, nodes: &[u32]| -> std::fmt::Result {
        writeln!(
            out,
            "\n/// {what}\n#[rustfmt::skip]\npub static {name}: [u32; {len}] = ["
        )?;
        words(out, nodes)?;
        writeln!(out, "];")
    };
    list(name, "Integrals of the extinction.", &table.extinction)?;
    match &table.colours {
        Colours::One(colour) => writeln!(
            out,
            "\n/// The colour, 1.31.\npub const {name}_COLOUR: [u32; 3] = {colour:?};"
        )?,
        Colours::Each(lists) => {
            for (channel, nodes) in CHANNELS.iter().zip(lists) {
                let part = format!("{name}_{}", channel.to_ascii_uppercase());
                list(&part, &format!("Integrals of the extinction times {channel}."), nodes)?;
            }
        }
    }
    writeln!(
        out,
        "\n/// log2 of the codes of a bin.\npub const {name}_GRAIN: u32 = {};",
        table.grain
    )?;
    writeln!(
        out,
        "\n/// log2 of what the integrals were multiplied by.\npub const {name}_EXPONENT: u32 = {};",
        table.exponent
    )
}

fn c(out: &mut String, table: &Cumulative, source: &Source<'_>, name: &str) -> std::fmt::Result {
    let len = table.extinction.len();
    for line in about(table, source) {
        writeln!(out, "/* {line} */")?;
    }
    writeln!(out, "#include <stdint.h>")?;
    let mut list = |name: &str, what: &str, nodes: &[u32]| -> std::fmt::Result {
        writeln!(out, "\n/* {what} */\nstatic const uint32_t {name}[{len}] = {{")?;
        words(out, nodes)?;
        writeln!(out, "}};")
    };
    list(name, "Integrals of the extinction.", &table.extinction)?;
    match &table.colours {
        Colours::One([red, green, blue]) => writeln!(
            out,
            "\n/* The colour, 1.31. */\nstatic const uint32_t {name}_colour[3] = {{{red}u, {green}u, {blue}u}};"
        )?,
        Colours::Each(lists) => {
            for (channel, nodes) in CHANNELS.iter().zip(lists) {
                let what = format!("Integrals of the extinction times {channel}.");
                list(&format!("{name}_{channel}"), &what, nodes)?;
            }
        }
    }
    writeln!(
        out,
        "\n/* log2 of the codes of a bin. */\nstatic const uint32_t {name}_grain = {};",
        table.grain
    )?;
    writeln!(
        out,
        "\n/* log2 of what the integrals were multiplied by. */\nstatic const uint32_t {name}_exponent = {};",
        table.exponent
    )?;
    let (lists, colour, colours) = match &table.colours {
        Colours::One([red, green, blue]) => (1, format!("{red}u, {green}u, {blue}u"), "0, 0, 0".into()),
        Colours::Each(_) => (
            4,
            "0, 0, 0".into(),
            CHANNELS.map(|channel| format!("{name}_{channel}")).join(", "),
        ),
    };
    let (grain, exponent) = (table.grain, table.exponent);
    writeln!(
        out,
        "\n#ifdef SLICECAST_H\n/* The same for slicecast.h: nodes, lists, grain, exponent, the colour, the lists. */\n\
         static const SlicecastIntegrals {name}_integrals = {{\n    {len}, {lists}, {grain}, {exponent}, {{{colour}}}, {name}, \
         {{{colours}}},\n}};\n#endif"
    )
}

fn readmemh(out: &mut String, table: &Cumulative, source: &Source<'_>) -> std::fmt::Result {
    for line in about(table, source) {
        writeln!(out, "// {line}")?;
    }
    match table.colours {
        Colours::One([red, green, blue]) => {
            writeln!(out, "// colour    {red:08x} {green:08x} {blue:08x}, red first, 1.31")?
        }
        Colours::Each(_) => writeln!(
            out,
            "// word      blue, green, red, extinction; blue is the highest 32 of 128 bits"
        )?,
    }
    for (index, node) in table.extinction.iter().enumerate() {
        if let Colours::Each([red, green, blue]) = &table.colours {
            write!(out, "{:08x}{:08x}{:08x}", blue[index], green[index], red[index])?;
        }
        writeln!(out, "{node:08x}")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::Command;

    use slicecast_scene::{Point, TransferFunction};
    use slicecast_volume::mapping::Window;
    use slicecast_volume::open::load;

    fn volume() -> Volume {
        load(None, Window::Auto).expect("the built-in volume").volume
    }

    fn table(volume: &Volume, last: [f64; 3]) -> Cumulative {
        let point = |value, colour, opacity| Point { value, colour, opacity };
        let transfer = TransferFunction {
            unit_distance: 1.0,
            points: vec![point(0.0, [1.0, 0.5, 0.25], 0.0), point(4000.0, last, 0.5)],
        };
        Cumulative::of(&transfer, volume, 4)
    }

    fn written(table: &Cumulative, volume: &Volume, name: &str, language: Language) -> String {
        let scene = "two /* colours */";
        integrals(table, Source { scene, volume }, name, language)
    }

    /// The words of a list that begins with `head`, up to the end of its initialiser.
    fn list(text: &str, head: &str) -> Vec<u32> {
        let (_, rest) = text.split_once(head).unwrap_or_else(|| panic!("no {head} in {text}"));
        let (body, _) = rest.split_once([']', '}']).expect("an end");
        (body.split(','))
            .map(str::trim)
            .filter(|word| !word.is_empty())
            .map(|word| u32::from_str_radix(word.trim_start_matches("0x"), 16).expect("a word"))
            .collect()
    }

    /// What is written is what was compiled, node by node.
    #[test]
    fn every_list_holds_the_compiled_nodes() {
        let volume = volume();
        let table = table(&volume, [0.0, 1.0, 1.0]);
        let Colours::Each([red, green, blue]) = &table.colours else {
            panic!("one colour");
        };
        let hex = written(&table, &volume, "bone", Language::Readmemh);
        let lines: Vec<u128> = (hex.lines())
            .filter(|line| !line.starts_with("//"))
            .map(|line| u128::from_str_radix(line, 16).expect("a word"))
            .collect();
        assert_eq!(lines.len(), 257);
        for (n, line) in lines.iter().enumerate() {
            let word = [blue[n], green[n], red[n], table.extinction[n]];
            let word = word.iter().fold(0, |word, part| word << 32 | u128::from(*part));
            assert_eq!(*line, word);
        }
        let rust = written(&table, &volume, "a-b", Language::Rust);
        let c = written(&table, &volume, "a-b", Language::C);
        for (nodes, part) in [
            (&table.extinction, ""),
            (red, "_red"),
            (green, "_green"),
            (blue, "_blue"),
        ] {
            let upper = part.to_ascii_uppercase();
            assert_eq!(list(&rust, &format!("pub static A_B{upper}: [u32; 257] = [")), *nodes);
            assert_eq!(list(&c, &format!("static const uint32_t a_b{part}[257] = {{")), *nodes);
        }
        for text in [&rust, &c, &hex] {
            for said in [
                "scene     two / * colours * /",
                "mapping   value = code * ",
                "257 nodes each, 4112 bytes in all",
                "grain     4: a bin is 16 code(s)",
                &format!("exponent  {}: ", table.exponent),
                "every view, step and number of planes per voxel",
            ] {
                assert!(text.contains(said), "{said}: {text}");
            }
        }
        assert!(rust.contains("pub const A_B_GRAIN: u32 = 4;"));
        assert!(c.contains(&format!("static const uint32_t a_b_exponent = {};", table.exponent)));
    }

    #[test]
    fn one_colour_is_stated_once() {
        let volume = volume();
        let table = table(&volume, [1.0, 0.5, 0.25]);
        let text = written(&table, &volume, "bone", Language::Rust);
        assert!(
            text.contains("pub const BONE_COLOUR: [u32; 3] = [2147483648, 1073741824, 536870912];"),
            "{text}"
        );
        assert_eq!(text.matches("0x").count(), 257);
        let text = written(&table, &volume, "bone", Language::Readmemh);
        assert!(text.contains("80000000 40000000 20000000, red first"), "{text}");
    }

    /// The compiler that Rust links with has no complaints; the program adds the nodes up.
    #[test]
    fn c_compiles_without_a_warning() {
        let volume = volume();
        let folder = std::env::temp_dir().join(format!("slicecast-integrals-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        for (last, parts) in [
            ([0.0, 1.0, 1.0], &["_red", "_green", "_blue"][..]),
            ([1.0, 0.5, 0.25], &["_colour"]),
        ] {
            let table = table(&volume, last);
            let header = written(&table, &volume, "bone", Language::C);
            let uses: String = parts.iter().map(|part| format!(" + bone{part}[0]")).collect();
            let source = format!(
                "{header}#include <stdio.h>\nint main(void) {{\n    uint32_t sum = 0;\n    for (int n = 0; n < 257; n++)\n        \
                 sum += bone[n];\n    sum += (0{uses}) * 0;\n    printf(\"%u %u %u\", (unsigned)sum, (unsigned)bone_grain, \
                 (unsigned)bone_exponent);\n    return 0;\n}}\n"
            );
            let (c, program) = (folder.join("a.c"), folder.join("a.out"));
            std::fs::write(&c, source).expect("a file");
            let made = Command::new("cc")
                .args(["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-o"])
                .args([&program, &c])
                .output()
                .expect("cc");
            assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
            let ran = Command::new(&program).output().expect("the program");
            let sum = table.extinction.iter().fold(0u32, |sum, node| sum.wrapping_add(*node));
            assert_eq!(
                String::from_utf8_lossy(&ran.stdout),
                format!("{sum} {} {}", table.grain, table.exponent)
            );
        }
        std::fs::remove_dir_all(&folder).expect("the folder");
    }
}
