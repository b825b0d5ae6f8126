//! What a linked program takes of flash and RAM, and which symbols it holds.

use std::collections::BTreeSet;
use std::path::Path;

use object::{Object, ObjectSection, ObjectSymbol, SectionFlags, SectionKind, elf};

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
        let mut footprint = Self::default();
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

/// Whether a section is not the program's own: the scene's data, or the room that a linker script leaves for the stack
/// and the heap.
fn reserved<E>(section: Result<&str, E>) -> bool {
    matches!(section, Ok(".scene" | ".stack" | ".heap"))
}
