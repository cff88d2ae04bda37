/**
 * Where the registers of a chip's DMA are, and the bits of its channels' control words.
 *
 * @typedef {typeof RP2040} DmaLayout
 */

/** RP2040 datasheet 2.5.7. */
export const RP2040 = {
  channels: 12,
  interrupts: [11, 12],
  registers: { timer0: 0x420, multiChanTrigger: 0x430, sniffCtrl: 0x434, sniffData: 0x438, fifoLevels: 0x440, chanAbort: 0x444, nChannels: 0x448 },
  bits: { increasesWrite: 1 << 5, ringsWrite: 1 << 10, quiet: 1 << 21, swaps: 1 << 22, busy: 1 << 24, unknown: 0 },
  shifts: { ring: 6, chainTo: 11, request: 15 },
  writable: 0xffffff,
  pioRequests: 16,
};

/** RP2350 datasheet 12.6.10. Addresses that fall are not emulated. */
export const RP2350 = {
  channels: 16,
  interrupts: [11, 12],
  registers: { timer0: 0x440, multiChanTrigger: 0x450, sniffCtrl: 0x454, sniffData: 0x458, fifoLevels: 0x460, chanAbort: 0x464, nChannels: 0x468 },
  bits: { increasesWrite: 1 << 6, ringsWrite: 1 << 12, quiet: 1 << 23, swaps: 1 << 24, busy: 1 << 26, unknown: (1 << 5) | (1 << 7) },
  shifts: { ring: 8, chainTo: 13, request: 17 },
  writable: 0x3ffffff,
  pioRequests: 24,
};
