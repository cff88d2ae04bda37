// An ELF file such as the linker makes, for unit tests and for `stand_ins`, which include it.

/// The words of the board as they are linked.
const WORDS: &[u8] = &{
    let mut words = [0; 184];
    let (begin, _) = words.split_at_mut(9);
    begin.copy_from_slice(b"ISOWORDS\x02");
    words
};

/// An ELF file for a 32-bit Arm with this code, which is loaded to the beginning of flash, and these words of the board
/// behind it.
fn elf(code: &[u8], words: &[u8]) -> Vec<u8> {
    elf_named(code, words, b".board_words")
}

/// The same with another name for the words' section.
fn elf_named(code: &[u8], words: &[u8], name: &[u8]) -> Vec<u8> {
    const FLASH: u32 = 0x1000_0000;
    let (header_bytes, segment_bytes, section_bytes) = (52, 32, 40);
    let names = [b"\0", name, b"\0"].concat();
    let code_at = header_bytes + segment_bytes;
    let words_at = code_at + code.len() as u32;
    let names_at = words_at + words.len() as u32;
    let loaded = names_at - code_at;
    let mut elf = b"\x7fELF\x01\x01\x01\0\0\0\0\0\0\0\0\0".to_vec();
    let half = |values: &[u32]| values.iter().flat_map(|&value| (value as u16).to_le_bytes()).collect::<Vec<_>>();
    let word = |values: &[u32]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<_>>();
    // An executable of version 1, whose table of segments comes next, and that of sections at the end.
    elf.extend(half(&[2, 40]));
    elf.extend(word(&[1, 0, header_bytes, names_at + names.len() as u32, 0]));
    elf.extend(half(&[header_bytes, segment_bytes, 1, section_bytes, 3, 2]));
    elf.extend(word(&[1, code_at, FLASH, FLASH, loaded, loaded, 5, 4]));
    elf.extend([code, words, &names].concat());
    elf.extend(word(&[0; 10]));
    elf.extend(word(&[1, 1, 2, FLASH + words_at - code_at, words_at, words.len() as u32, 0, 0, 4, 0]));
    elf.extend(word(&[0, 3, 0, 0, names_at, names.len() as u32, 0, 0, 1, 0]));
    elf
}
