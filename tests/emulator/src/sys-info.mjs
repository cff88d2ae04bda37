const CHIP_ID = 0x00;
/** Raspberry Pi's JEDEC number 0x927 and part 2, in revision 2: an RP2040-B2, as the stand-in ROM's version says too. B0 and B1 are revision 1. */
const B2 = 0x20002927;

/** Makes rp2040js's SYSINFO, which is that of an RP2040-B1, say which chip this is. */
export function identifyAsB2(sysInfo) {
  const { readUint32 } = sysInfo;
  sysInfo.readUint32 = (offset) => (offset === CHIP_ID ? B2 : readUint32.call(sysInfo, offset));
}
