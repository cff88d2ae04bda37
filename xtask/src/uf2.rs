//! UF2, the format of boot drives: blocks of 512 bytes. Each contains a 256-byte page of flash and its
//! address, so the blocks may arrive in any order. <https://github.com/microsoft/uf2>

use std::collections::BTreeMap;

use isostep::chip::Chip;

use crate::firmware::Load;

const PAGE_BYTES: usize = 256;
const MAGIC_START: [u32; 2] = [0x0A32_4655, 0x9E5D_5157];
const MAGIC_END: u32 = 0x0AB1_6F30;
const FLAG_FAMILY_ID: u32 = 0x2000;

/// The UF2 file that stores `loads` on a chip. Bytes of a page that no load covers are 0.
pub fn from_loads(loads: &[Load], chip: Chip) -> Vec<u8> {
    let pages = pages(loads);
    let page_count = pages.len() as u32;
    let numbered = pages.into_iter().zip(0..);
    numbered.flat_map(|((address, page), number)| block(address, &page, [number, page_count], chip)).collect()
}

/// The pages of flash that `loads` touch, by address.
fn pages(loads: &[Load]) -> BTreeMap<u32, [u8; PAGE_BYTES]> {
    let mut pages = BTreeMap::new();
    for load in loads {
        for (address, &byte) in (load.address..).zip(&load.bytes) {
            let offset = address as usize % PAGE_BYTES;
            pages.entry(address - offset as u32).or_insert([0; PAGE_BYTES])[offset] = byte;
        }
    }
    pages
}

fn block(address: u32, page: &[u8; PAGE_BYTES], [number, count]: [u32; 2], chip: Chip) -> Vec<u8> {
    let [magic_0, magic_1] = MAGIC_START;
    let head = [magic_0, magic_1, FLAG_FAMILY_ID, address, PAGE_BYTES as u32, number, count, chip.uf2_family()];
    let mut block: Vec<u8> = head.into_iter().flat_map(u32::to_le_bytes).collect();
    block.extend(page);
    block.resize(512 - size_of_val(&MAGIC_END), 0);
    block.extend(MAGIC_END.to_le_bytes());
    block
}

#[cfg(test)]
mod tests {
    use super::*;

    fn word(block: &[u8], index: usize) -> u32 {
        u32::from_le_bytes(block[4 * index..][..4].try_into().unwrap())
    }

    #[test]
    fn a_block_is_laid_out_as_the_specification_says() {
        let loads = [Load { address: 0x1000_0000, bytes: vec![0xAB; 256] }];
        let uf2 = from_loads(&loads, Chip::Rp2040);
        assert_eq!(uf2.len(), 512);
        let head: Vec<u32> = (0..8).map(|index| word(&uf2, index)).collect();
        assert_eq!(head, [0x0A32_4655, 0x9E5D_5157, 0x2000, 0x1000_0000, 256, 0, 1, 0xE48B_FF56]);
        assert_eq!(uf2[32..288], [0xAB; 256]);
        assert!(uf2[288..508].iter().all(|&byte| byte == 0));
        assert_eq!(word(&uf2, 127), 0x0AB1_6F30);
        assert_eq!(word(&from_loads(&loads, Chip::Rp2350), 7), 0xE48B_FF59, "an RP2350 takes it for Arm, secure");
    }

    #[test]
    fn neighbouring_loads_share_a_page_and_gaps_are_left_out() {
        let loads = [
            Load { address: 0x1000_0100, bytes: vec![1; 100] },
            Load { address: 0x1000_0164, bytes: vec![2; 200] },
            Load { address: 0x1000_0800, bytes: vec![3] },
        ];
        let uf2 = from_loads(&loads, Chip::Rp2040);
        let addresses: Vec<u32> = uf2.chunks(512).map(|block| word(block, 3)).collect();
        assert_eq!(addresses, [0x1000_0100, 0x1000_0200, 0x1000_0800]);
        assert!(
            uf2.chunks(512).enumerate().all(|(index, block)| word(block, 5) == index as u32 && word(block, 6) == 3)
        );
        assert_eq!((uf2[32 + 99], uf2[32 + 100]), (1, 2), "the second load follows the first within the page");
        assert_eq!(uf2[512 + 32 + 44], 0, "the rest of a page is 0");
    }
}
