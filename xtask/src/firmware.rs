//! Reads the firmware's ELF file: the bytes that go to flash, and the memory that it uses.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use object::read::elf::{ElfFile32, ProgramHeader};
use object::{Endianness, Object, ObjectSection, SectionFlags, elf};

const RAM_START_ADDRESS: u64 = 0x2000_0000;

/// Bytes to be stored at `address` and after it.
pub struct Load {
    pub address: u32,
    pub bytes: Vec<u8>,
}

/// The part of an ELF file that is relevant to a chip.
pub struct Firmware {
    /// In ascending order of address.
    pub loads: Vec<Load>,
    /// Code and its tables that are copied to RAM and used there.
    pub ram_code_bytes: u64,
    /// Size of `.data`, `.bss` and `.uninit`.
    pub static_ram_bytes: u64,
}

impl Firmware {
    /// Reads the ELF file at `path`.
    pub fn read(path: &Path) -> Result<Self> {
        let data = fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
        Self::parse(&data).with_context(|| format!("{} is no firmware", path.display()))
    }

    fn parse(data: &[u8]) -> Result<Self> {
        let elf = ElfFile32::<Endianness>::parse(data)?;
        let mut loads = Vec::new();
        for header in elf.elf_program_headers().iter().filter(|header| is_loaded(header)) {
            let bytes = header.data(Endianness::Little, data).ok().context("a segment lies outside the file")?.to_vec();
            // The physical address is used, where the bytes are stored. Initialised data has another address in RAM at
            // run time.
            loads.push(Load { address: header.p_paddr(Endianness::Little), bytes });
        }
        ensure!(!loads.is_empty(), "it has nothing to load");
        loads.sort_by_key(|load| load.address);
        let in_ram =
            elf.sections().filter(|section| is_allocated(section.flags()) && section.address() >= RAM_START_ADDRESS);
        let (code, statics): (Vec<_>, Vec<_>) = in_ram.partition(|section| is_code(section.flags()));
        let bytes = |sections: Vec<_>| sections.iter().map(ObjectSection::size).sum();
        Ok(Self { loads, ram_code_bytes: bytes(code), static_ram_bytes: bytes(statics) })
    }

    /// Bytes stored in flash, including the second-stage boot loader and everything that is copied to RAM.
    pub fn flash_bytes(&self) -> u64 {
        self.loads.iter().map(|load| load.bytes.len() as u64).sum()
    }
}

fn is_loaded(header: &elf::ProgramHeader32<Endianness>) -> bool {
    header.p_type(Endianness::Little) == elf::PT_LOAD && header.p_filesz(Endianness::Little) > 0
}

fn is_code(flags: SectionFlags) -> bool {
    matches!(flags, SectionFlags::Elf { sh_flags, .. } if sh_flags.contains(elf::SHF_EXECINSTR))
}

fn is_allocated(flags: SectionFlags) -> bool {
    matches!(flags, SectionFlags::Elf { sh_flags, .. } if sh_flags.contains(elf::SHF_ALLOC))
}
