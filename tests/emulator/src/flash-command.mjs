const UNIQUE_ID_COMMAND = 0x4b;
/** Bytes that the chip sends nothing in after this command. */
const DUMMIES = 4;
/** The 64 bits that every W25Q16JV has of its own; here they are the same for every board. */
export const UNIQUE_ID = [0xe6, 0x60, 0x58, 0x38, 0x83, 0x2a, 0x11, 0x25];

/**
 * A command that is sent to the flash chip byte by byte, and its answer. Only the unique identifier is known; the rest
 * of an answer is zeros.
 */
export class FlashCommand {
  constructor() {
    this.begin();
  }

  /** The chip is selected anew: the next byte is a command. */
  begin() {
    this.command = null;
    /** Bytes on the wire since the command. */
    this.bytes = 0;
  }

  send(byte) {
    if (this.command === null) this.command = byte;
    else this.bytes += 1;
  }

  receive() {
    const at = this.bytes - DUMMIES;
    this.bytes += 1;
    return (this.command === UNIQUE_ID_COMMAND ? UNIQUE_ID[at] : 0) ?? 0;
  }
}
