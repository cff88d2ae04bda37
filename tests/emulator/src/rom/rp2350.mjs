import { addEndTrap, addFlash, addLookup } from './rom.mjs';
import { codeOf, RomImage } from './image.mjs';

/** 'M', 'u', 2 and the version number of the RP2350-A2's ROM. */
const MAGIC = [0x754d, 0x0202];
const LOOKUP_AT = 0x16;
const NO_FUNCTION = 0xff;
/** The flags of `reboot`: to BOOTSEL. */
const [REBOOT_TYPES, BOOTSEL] = [0xf, 2];

const image = build();

/** Writes the ROM to its place in the chip: a stand-in of our own, with the functions that the firmware calls. */
export function loadRp2350Rom(chip) {
  new Uint16Array(chip.bootrom.buffer).set(image.halfwords);
}

function build() {
  const rom = new RomImage(NO_FUNCTION);
  rom.halfwords.set(MAGIC, 0x10 / 2);
  const functions = new Map(addFlash(rom).map(([code, address]) => [codeOf(code), address]));
  functions.set(codeOf('RB'), rom.addEnd(addEndTrap((r, bus) => {
    if ((r[0] & REBOOT_TYPES) === BOOTSEL) bus.chip.onBootsel(r[2], r[3]);
  })));
  rom.halfwords[LOOKUP_AT / 2] = addLookup(rom, (code) => functions.get(code) ?? 0);
  return rom;
}
