import { BasePeripheral } from 'rp2040js';

const [CTRL, FLUSH, STAT, CTR_HIT, CTR_ACC, STREAM_ADDR, STREAM_CTR] = [0x00, 0x04, 0x08, 0x0c, 0x10, 0x14, 0x18];
/** Enabled, and bad memory accesses raise errors. */
const CTRL_AT_RESET = 3;
/** The cache is flushed, the stream's FIFO empty. */
const STAT_IDLE = 3;

/** The cache's control registers. There is no cache, and streaming from flash in the background is not emulated: all is idle. */
export class XipControl extends BasePeripheral {
  constructor(chip, name) {
    super(chip, name);
    this.ctrl = CTRL_AT_RESET;
  }

  readUint32(offset) {
    switch (offset) {
      case CTRL:
        return this.ctrl;
      case STAT:
        return STAT_IDLE;
      case FLUSH:
      case CTR_HIT:
      case CTR_ACC:
      case STREAM_ADDR:
      case STREAM_CTR:
        return 0;
    }
    return super.readUint32(offset);
  }

  writeUint32(offset, value) {
    if (offset === CTRL) this.ctrl = value & 0xf;
    // A stream of no words is one stopped.
    else if (offset > CTR_ACC && value !== 0) super.writeUint32(offset, value);
  }
}
