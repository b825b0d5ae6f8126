//! What a linked program takes of flash and RAM, and which symbols it holds.

use std::collections::BTreeSet;
use std::path::Path;

use object::{Object, ObjectSection, ObjectSymbol, SectionFlags, SectionKind, SymbolKind, elf};

use crate::shell::Failure;

/// A linked program.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Footprint {
    /// Bytes of code and constants, without the scene's data.
    pub flash: u64,
    /// Bytes of initialised and zeroed variables.
    pub ram: u64,
    /// Names of its symbols.
    pub symbols: BTreeSet<String>,
    /// A function that holds an instruction of an Arm floating-point unit.
    pub float_in: Option<String>,
}

impl Footprint {
    /// Reads a program.
    ///
    /// # Errors
    /// If the file is none.
    pub fn of(path: &Path) -> Result<Self, Failure> {
        let words = |error: String| Failure(format!("{}: {error}", path.display()));
        let bytes = std::fs::read(path).map_err(|e| words(e.to_string()))?;
        let file = object::File::parse(&*bytes).map_err(|e| words(e.to_string()))?;
        let mut footprint = Self {
            float_in: float_in(&file),
            ..Self::default()
        };
        for section in file.sections() {
            let SectionFlags::Elf { sh_flags, .. } = section.flags() else {
                continue;
            };
            let has = |flag: elf::SectionFlags| sh_flags & flag == flag;
            if !has(elf::SHF_ALLOC) || reserved(section.name()) {
                continue;
            }
            let (written, loaded) = (has(elf::SHF_WRITE), section.kind() != SectionKind::UninitializedData);
            footprint.ram += if written { section.size() } else { 0 };
            footprint.flash += if loaded { section.size() } else { 0 };
        }
        for symbol in file.symbols() {
            if let Ok(name) = symbol.name() {
                footprint.symbols.insert(name.to_owned());
            }
        }
        Ok(footprint)
    }
}

/// The function with the first instruction of an Arm floating-point unit, if there is one.
///
/// Compilers mark where code (`$t`) and data (`$d`) begin. An instruction of 32 bits begins with 11101, 11110 or 11111;
/// those of the coprocessors have 11 behind that, and floating point is number 10 and 11.
fn float_in(file: &object::File<'_>) -> Option<String> {
    if file.architecture() != object::Architecture::Arm {
        return None;
    }
    for section in file.sections().filter(|s| s.kind() == SectionKind::Text) {
        let bytes = section.data().ok()?;
        let inside = |symbol: &object::Symbol<'_, '_>| symbol.section_index() == Some(section.index());
        let mut marks: Vec<(u64, bool)> = Vec::new();
        for symbol in file.symbols().filter(inside) {
            let name = symbol.name().unwrap_or("");
            if name.starts_with("$t") || name.starts_with("$d") {
                marks.push((symbol.address(), name.starts_with("$t")));
            }
        }
        marks.sort_unstable();
        let end = section.address() + section.size();
        for (index, &(start, _)) in marks.iter().enumerate().filter(|(_, (_, code))| *code) {
            let stop = marks.get(index + 1).map_or(end, |next| next.0);
            let part = bytes.get((start - section.address()) as usize..(stop - section.address()) as usize)?;
            if let Some(place) = first_float(part) {
                let at = start + place as u64;
                let functions = file
                    .symbols()
                    .filter(|s| s.kind() == SymbolKind::Text && (s.address() & !1) <= at);
                let function = functions.max_by_key(|s| s.address());
                return Some(
                    function
                        .and_then(|s| s.name().ok().map(str::to_owned))
                        .unwrap_or_default(),
                );
            }
        }
    }
    None
}

/// Offset of the first floating-point instruction in Thumb code.
fn first_float(code: &[u8]) -> Option<usize> {
    let half = |at: usize| Some(u16::from_le_bytes([*code.get(at)?, *code.get(at + 1)?]));
    let mut at = 0;
    while let Some(first) = half(at) {
        let long = first >> 11 >= 0b11101;
        if long && first & 0xec00 == 0xec00 && matches!(half(at + 2)? >> 8 & 15, 10 | 11) {
            return Some(at);
        }
        at += if long { 4 } else { 2 };
    }
    None
}

/// Whether a section is not the program's own: the scene's data, or the room that a linker script leaves for the stack
/// and the heap.
fn reserved<E>(section: Result<&str, E>) -> bool {
    matches!(section, Ok(".scene" | ".stack" | ".heap"))
}

#[cfg(test)]
mod tests {
    use super::first_float;

    #[test]
    fn floating_point_is_told_from_other_instructions() {
        let bytes = |halves: &[u16]| halves.iter().flat_map(|h| h.to_le_bytes()).collect::<Vec<u8>>();
        // movs r0, #1; vadd.f32 s0, s0, s1
        assert_eq!(first_float(&bytes(&[0x2001, 0xee30, 0x0a20])), Some(2));
        // vldr s0, [r0]; vcvt.f64.f32 d0, s0
        assert_eq!(first_float(&bytes(&[0xed90, 0x0a00])), Some(0));
        assert_eq!(first_float(&bytes(&[0xeeb7, 0x0ac0])), Some(0));
        // smmlar r3, r5, r2, r3; umull r0, r5, r8, r0; ldrd r1, r0, [r8, #64]; mcr p15
        assert_eq!(
            first_float(&bytes(&[0xfb55, 0x3312, 0xfba8, 0x0500, 0xe9d8, 0x1010])),
            None
        );
        assert_eq!(first_float(&bytes(&[0xee07, 0x0f95])), None);
        // The second half of a long instruction is not the first half of one.
        assert_eq!(first_float(&bytes(&[0xf44f, 0xee30, 0x2a20])), None);
    }
}
