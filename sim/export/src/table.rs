//! Compiled tables for other programs: Rust, C, and Verilog's `$readmemh`.

use std::fmt::Write;

use slicecast_engine::table::Table;
use slicecast_scene::AlphaCodeName;

/// The languages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// `pub static` arrays.
    Rust,
    /// `const` arrays for a header.
    C,
    /// One word a line, in hexadecimal, for `$readmemh`.
    Readmemh,
}

/// The text of a table. `name` becomes the array's name; characters that no identifier has are replaced by `_`.
///
/// Rust and C get 4096 words of 32 bits, `0xAABBGGRR` as [`slicecast::classify::entry`] packs them (AA is the square
/// root of the opacity or its high byte, and so are the colours), for 16-bit roots 4096 low bytes, and for 16-bit colours
/// 4096 times three low bytes, red first. A line of `$readmemh` is such a word, for 16-bit roots followed by two digits of
/// the low byte (40 bits), for 16-bit colours by six more, blue first (64 bits).
pub fn table(table: &Table, name: &str, language: Language) -> String {
    let name = identifier(name);
    let bits = match table.code {
        AlphaCodeName::Sqrt8 => Bits { root: 8, colour: 8 },
        AlphaCodeName::Sqrt16 => Bits { root: 16, colour: 8 },
        AlphaCodeName::Colour16 => Bits { root: 16, colour: 16 },
    };
    let what = format!(
        "{} entries: opacity (square root, {} bits), and colour of 3 x {} bits.",
        table.entries.len(),
        bits.root,
        bits.colour
    );
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = match language {
        Language::Rust => rust(&mut out, table, &name.to_ascii_uppercase(), &what, bits),
        Language::C => c(&mut out, table, &name.to_ascii_lowercase(), &what, bits),
        Language::Readmemh => readmemh(&mut out, table, &what, bits),
    };
    out
}

/// How many bits an entry has for what.
#[derive(Clone, Copy)]
struct Bits {
    root: u32,
    colour: u32,
}

fn rust(out: &mut String, table: &Table, name: &str, what: &str, bits: Bits) -> std::fmt::Result {
    writeln!(
        out,
        "/// {what}\n#[rustfmt::skip]\npub static {name}: [u32; {}] = [",
        table.entries.len()
    )?;
    words(out, &table.entries[..])?;
    writeln!(out, "];")?;
    if bits.root == 16 {
        writeln!(
            out,
            "\n/// Low bytes of the square roots.\n#[rustfmt::skip]\npub static {name}_LOW: [u8; {}] = [",
            table.plane.len()
        )?;
        bytes(out, &table.plane[..])?;
        writeln!(out, "];")?;
    }
    if bits.colour == 16 {
        writeln!(
            out,
            "\n/// Low bytes of the colours.\n#[rustfmt::skip]\npub static {name}_COLOURS: [[u8; 3]; {}] = [",
            table.colours.len()
        )?;
        triples(out, &table.colours[..], ['[', ']'])?;
        writeln!(out, "];")?;
    }
    Ok(())
}

fn c(out: &mut String, table: &Table, name: &str, what: &str, bits: Bits) -> std::fmt::Result {
    writeln!(out, "/* {what} */\n#include <stdint.h>\n")?;
    writeln!(out, "static const uint32_t {name}[{}] = {{", table.entries.len())?;
    words(out, &table.entries[..])?;
    writeln!(out, "}};")?;
    if bits.root == 16 {
        writeln!(out, "\n/* Low bytes of the square roots. */")?;
        writeln!(out, "static const uint8_t {name}_low[{}] = {{", table.plane.len())?;
        bytes(out, &table.plane[..])?;
        writeln!(out, "}};")?;
    }
    if bits.colour == 16 {
        writeln!(out, "\n/* Low bytes of the colours. */")?;
        writeln!(
            out,
            "static const uint8_t {name}_colours[{}][3] = {{",
            table.colours.len()
        )?;
        triples(out, &table.colours[..], ['{', '}'])?;
        writeln!(out, "}};")?;
    }
    Ok(())
}

fn readmemh(out: &mut String, table: &Table, what: &str, bits: Bits) -> std::fmt::Result {
    writeln!(out, "// {what}")?;
    for ((entry, low), [r, g, b]) in table.entries.iter().zip(table.plane.iter()).zip(table.colours.iter()) {
        write!(out, "{entry:08x}")?;
        if bits.root == 16 {
            write!(out, "{low:02x}")?;
        }
        if bits.colour == 16 {
            write!(out, "{b:02x}{g:02x}{r:02x}")?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// Eight words a line.
pub(crate) fn words(out: &mut String, words: &[u32]) -> std::fmt::Result {
    for line in words.chunks(8) {
        let text: Vec<String> = line.iter().map(|word| format!("0x{word:08x},")).collect();
        writeln!(out, "    {}", text.join(" "))?;
    }
    Ok(())
}

fn bytes(out: &mut String, bytes: &[u8]) -> std::fmt::Result {
    for line in bytes.chunks(16) {
        let text: Vec<String> = line.iter().map(|byte| format!("0x{byte:02x},")).collect();
        writeln!(out, "    {}", text.join(" "))?;
    }
    Ok(())
}

fn triples(out: &mut String, triples: &[[u8; 3]], [open, close]: [char; 2]) -> std::fmt::Result {
    for line in triples.chunks(5) {
        let one = |[r, g, b]: &[u8; 3]| format!("{open}0x{r:02x}, 0x{g:02x}, 0x{b:02x}{close},");
        let text: Vec<String> = line.iter().map(one).collect();
        writeln!(out, "    {}", text.join(" "))?;
    }
    Ok(())
}

/// Letters, digits and `_`, not beginning with a digit.
pub(crate) fn identifier(name: &str) -> String {
    let keep = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let kept: String = name.chars().map(keep).collect();
    match kept.chars().next() {
        None => "table".into(),
        Some(first) if first.is_ascii_digit() => format!("t{kept}"),
        Some(_) => kept,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slicecast_engine::table::Correction;
    use slicecast_scene::{LookupName, Point, TransferFunction};
    use slicecast_volume::Mapping;

    const MAPPING: Mapping = Mapping {
        scale: 1.0,
        offset: -1024.0,
    };

    fn fog(opacity: f64) -> TransferFunction {
        let point = |value, opacity| Point {
            value,
            colour: [1.0, 0.5, 0.0],
            opacity,
        };
        TransferFunction {
            unit_distance: 1.0,
            points: vec![point(0.0, 0.0), point(0.0, opacity)],
        }
    }

    fn compiled(opacity: f64, code: AlphaCodeName) -> Table {
        Table::compile(&fog(opacity), &MAPPING, Correction::None, code, LookupName::Nearest)
    }

    #[test]
    fn exports_hold_the_tables_own_numbers() {
        let eight = compiled(0.25, AlphaCodeName::Sqrt8);
        let sixteen = compiled(0.25, AlphaCodeName::Sqrt16);
        let lines: Vec<String> = table(&eight, "x", Language::Readmemh)
            .lines()
            .map(str::to_owned)
            .collect();
        assert_eq!(lines.len(), 4097);
        for (line, entry) in lines[1..].iter().zip(eight.entries.iter()) {
            assert_eq!(u32::from_str_radix(line, 16).unwrap(), *entry);
        }
        // Root, blue, green, red: the fog is orange.
        assert_eq!(&lines[4096][2..], "0080ff");
        let text = table(&sixteen, "x", Language::Readmemh);
        let last = text.lines().last().unwrap();
        let expected = u64::from(sixteen.entries[4095]) << 8 | u64::from(sixteen.plane[4095]);
        assert_eq!(u64::from_str_radix(last, 16).unwrap(), expected);
        for (language, head) in [
            (Language::Rust, "pub static BONE_1: [u32; 4096]"),
            (Language::C, "uint32_t bone_1[4096]"),
        ] {
            let text = table(&sixteen, "bone-1", language);
            assert!(text.contains(head), "{}", &text[..200]);
            let numbers = text.matches("0x").count();
            assert_eq!(numbers, 2 * 4096);
        }
        let fine = compiled(0.25, AlphaCodeName::Colour16);
        let text = table(&fine, "x", Language::Readmemh);
        let last = u64::from_str_radix(text.lines().last().unwrap(), 16).unwrap();
        let [r, g, b] = fine.colour(4095);
        assert_eq!([r, g, b], [65535, 32768, 0]);
        let word = |high: u32, low: u32| ((last >> high) & 0xff) << 8 | ((last >> low) & 0xff);
        assert_eq!([word(32, 0), word(40, 8), word(48, 16)], [r, g, b].map(u64::from));
        assert_eq!((last >> 24) & 0xff, u64::from(fine.plane[4095]));
        for (language, head) in [
            (Language::Rust, "pub static X_COLOURS: [[u8; 3]; 4096]"),
            (Language::C, "uint8_t x_colours[4096][3]"),
        ] {
            let text = table(&fine, "x", language);
            assert!(text.contains(head));
            assert_eq!(text.matches("0x").count(), 5 * 4096);
        }
        assert_eq!(["", "1", "a b"].map(identifier), ["table", "t1", "a_b"]);
    }
}
