//! The words of the board in the gantry's firmware, `boards/pico-gantry/src/board_words.rs`: what is wired to it, and the times that
//! moves last at least. They are written into an ELF file that is linked already, so images that differ in them alone are linked once.

use std::fs;
use std::ops::Range;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use isostep_motion::{LeastTimes, RampTimes};
use object::read::elf::ElfFile32;
use object::{Endianness, Object, ObjectSection};

use crate::variant::{Contact, Driver};

const SECTION: &str = ".board_words";
const MAGIC: &[u8] = b"ISOWORDS";
const VERSION: u32 = 2;
const WORD_BYTES: usize = size_of::<u32>();
/// The magic, and the words after it: version, contact, driver, one that is not used. Then come the least times, as doubles.
const TIMES_AT: usize = MAGIC.len() + 4 * WORD_BYTES;
const SECTION_BYTES: usize = TIMES_AT + size_of::<LeastTimes>();

/// The choices that the words hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoardWords {
    pub contact: Contact,
    pub driver: Driver,
}

impl BoardWords {
    /// Writes them into the ELF file at `path`, in place of those that it has. The file is another one afterwards, so that of
    /// which it was a link, Cargo's own, stays as the linker made it.
    ///
    /// # Errors
    /// The file has no words of this layout.
    pub fn write_to(self, path: &Path) -> Result<()> {
        let mut elf = read(path)?;
        self.patch(&mut elf).with_context(|| format!("{} cannot be detected what is wired to it", path.display()))?;
        write(&elf, path)
    }

    fn patch(self, elf: &mut [u8]) -> Result<()> {
        let [words, _] = places(elf)?;
        let values = [self.contact as u32, self.driver as u32];
        let bytes = values.into_iter().flat_map(u32::to_le_bytes).collect::<Vec<_>>();
        elf[words].copy_from_slice(&bytes);
        Ok(())
    }
}

/// The times that moves last at least by the ELF file at `path`.
///
/// # Errors
/// The file has no words of this layout.
pub fn least_times(path: &Path) -> Result<LeastTimes> {
    let elf = read(path)?;
    let [_, place] = places(&elf).with_context(|| format!("{} has no least times", path.display()))?;
    let mut doubles = elf[place].as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes));
    let mut next = || doubles.next().unwrap_or_default();
    Ok(LeastTimes {
        straight_s: next(),
        blend_s: next(),
        join_s: next(),
        together_s: next(),
        shaped_s: next(),
        box_s: next(),
        box_root_step_s: next(),
        queued_s: next(),
        curved: std::array::from_fn(|_| RampTimes { ramps_s: next(), root_step_s: next() }),
    })
}

/// Writes the ELF file at `from` to `to` with other times that moves last at least.
///
/// # Errors
/// The file has no words of this layout.
pub fn with_least_times(from: &Path, times: &LeastTimes, to: &Path) -> Result<()> {
    let mut elf = read(from)?;
    let [_, place] = places(&elf).with_context(|| format!("{} has no least times", from.display()))?;
    elf[place].copy_from_slice(&doubles(times).flat_map(f64::to_le_bytes).collect::<Vec<_>>());
    write(&elf, to)
}

/// In the order in which they are in memory.
fn doubles(times: &LeastTimes) -> impl Iterator<Item = f64> {
    let &LeastTimes { straight_s, blend_s, join_s, together_s, shaped_s, box_s, box_root_step_s, queued_s, curved } =
        times;
    let curved = curved.into_iter().flat_map(|RampTimes { ramps_s, root_step_s }| [ramps_s, root_step_s]);
    [straight_s, blend_s, join_s, together_s, shaped_s, box_s, box_root_step_s, queued_s].into_iter().chain(curved)
}

fn read(path: &Path) -> Result<Vec<u8>> {
    fs::read(path).with_context(|| format!("cannot read {}", path.display()))
}

fn write(elf: &[u8], path: &Path) -> Result<()> {
    let new = path.with_extension("new");
    fs::write(&new, elf)
        .and_then(|()| fs::rename(&new, path))
        .with_context(|| format!("cannot write {}", path.display()))
}

/// The places of contact and driver in the file, and of the least times.
fn places(elf: &[u8]) -> Result<[Range<usize>; 2]> {
    const REMEDY: &str = "take an image of `cargo xtask build` of the same sources";
    let file = ElfFile32::<Endianness>::parse(elf)?;
    let section = file.section_by_name(SECTION).with_context(|| format!("it has no section {SECTION}: {REMEDY}"))?;
    let (start, bytes) = section.file_range().with_context(|| format!("{SECTION} is not in the file: {REMEDY}"))?;
    ensure!(bytes == SECTION_BYTES as u64, "{SECTION} has {bytes} bytes, not {SECTION_BYTES}: {REMEDY}");
    let (magic, words) = section.data()?.split_at(MAGIC.len());
    ensure!(magic == MAGIC, "{SECTION} begins with {magic:?}, not {MAGIC:?}: {REMEDY}");
    let version = u32::from_le_bytes(words[..WORD_BYTES].try_into()?);
    ensure!(version == VERSION, "{SECTION} is of version {version}, not {VERSION}: {REMEDY}");
    let start = start as usize;
    let words = start + MAGIC.len() + WORD_BYTES;
    Ok([words..words + 2 * WORD_BYTES, start + TIMES_AT..start + SECTION_BYTES])
}

#[cfg(test)]
mod tests {
    use super::*;

    include!("stand_in_elf.rs");

    /// The words read back, as the firmware does: from the address at which the section is loaded.
    fn words(elf: &[u8]) -> [u32; 2] {
        let [words, _] = places(elf).unwrap();
        let bytes = &elf[words];
        [0, WORD_BYTES].map(|at| u32::from_le_bytes(bytes[at..at + WORD_BYTES].try_into().unwrap()))
    }

    #[test]
    fn words_are_read_back_and_nothing_else_is_changed() {
        let linked = elf(b"code", WORDS);
        for (contact, driver, expected) in [
            (Contact::No, Driver::Drv8825, [0, 0]),
            (Contact::Nc, Driver::Drv8825, [1, 0]),
            (Contact::No, Driver::Tmc2209, [0, 1]),
            (Contact::Nc, Driver::Tmc2209, [1, 1]),
        ] {
            let mut patched = linked.clone();
            BoardWords { contact: Contact::Nc, driver: Driver::Tmc2209 }.patch(&mut patched).unwrap();
            BoardWords { contact, driver }.patch(&mut patched).unwrap();
            assert_eq!(words(&patched), expected);
            patched[places(&linked).unwrap()[0].clone()].fill(0);
            assert!(patched == linked);
        }
    }

    #[test]
    fn an_image_without_these_words_is_refused_with_the_remedy() {
        let refusal = |words: Option<&[u8]>| {
            let mut elf = words.map_or_else(|| elf_named(b"code", WORDS, b".other_words"), |words| elf(b"code", words));
            let before = elf.clone();
            let error = BoardWords { contact: Contact::Nc, driver: Driver::Tmc2209 }.patch(&mut elf).unwrap_err();
            assert!(elf == before);
            error.to_string()
        };
        let remedy = "take an image of `cargo xtask build` of the same sources";
        assert_eq!(refusal(None), format!("it has no section .board_words: {remedy}"));
        assert_eq!(refusal(Some(&WORDS[..16])), format!(".board_words has 16 bytes, not 184: {remedy}"));
        let of_version_1 = [&WORDS[..8], &[1], &WORDS[9..]].concat();
        assert_eq!(refusal(Some(&of_version_1)), format!(".board_words is of version 1, not 2: {remedy}"));
        let other = [b"ISOSWORD", &WORDS[8..]].concat();
        assert!(
            refusal(Some(&other)).starts_with(".board_words begins with [73, 83, 79, 83, "),
            "{}",
            refusal(Some(&other))
        );
    }

    #[test]
    fn a_file_is_replaced_and_what_it_was_a_link_of_stays() {
        let folder = std::env::temp_dir().join(format!("isostep-board-words-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let [linked, shown] = ["linked", "shown"].map(|name| folder.join(name));
        fs::write(&linked, elf(b"code", WORDS)).unwrap();
        fs::hard_link(&linked, &shown).unwrap();
        BoardWords { contact: Contact::Nc, driver: Driver::Drv8825 }.write_to(&shown).unwrap();
        let [linked, shown] = [linked, shown].map(|path| words(&fs::read(path).unwrap()));
        fs::remove_dir_all(&folder).unwrap();
        assert_eq!((linked, shown), ([0, 0], [1, 0]));
    }

    #[test]
    fn least_times_are_read_back_and_the_linked_file_stays() {
        let folder = std::env::temp_dir().join(format!("isostep-least-times-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let [linked, trial] = ["linked", "trial"].map(|name| folder.join(name));
        let elf = elf(b"code", WORDS);
        fs::write(&linked, &elf).unwrap();
        let mut times = LeastTimes { straight_s: 0.4e-3, box_s: 7e-3, ..isostep_controller::least_times::RP2040 };
        times.curved[5].root_step_s = 8e-3;
        with_least_times(&linked, &times, &trial).unwrap();
        let (found, mut patched) = (least_times(&trial).unwrap(), fs::read(&trial).unwrap());
        let is_same = fs::read(&linked).unwrap() == elf;
        fs::remove_dir_all(&folder).unwrap();
        assert!(is_same && found == times, "{found:?}");
        let [words, place] = places(&elf).unwrap();
        assert_eq!(words.end + WORD_BYTES, place.start);
        assert_eq!(patched[place.start..place.start + 8], 0.4e-3_f64.to_le_bytes());
        patched[place.clone()].copy_from_slice(&elf[place]);
        assert!(patched == elf);
    }
}
