/** How an instruction ended: continue with the next one, continue at a new address, try again, or jump to itself. */
export const [DONE, JUMPED, STALLED, SPINNING] = [0, 1, 2, 3];
/** What a stalled machine waits for: bits, so that one waker can serve several. One that goes round waits for its next look. */
export const WAITS_FOR = { tx: 1, rx: 2, irq: 4, pin: 8, program: 16, look: 32, level: 8 | 32 };
const WORD_BITS = 32;

/**
 * Carries out one instruction (datasheet 3.4), without its side-set and delay.
 *
 * @param {import('./state-machine.mjs').StateMachine} machine
 * @param {number} op
 * @param {number} cycle
 * @returns {number} how it ended
 */
export function execute(machine, op, cycle) {
  switch (op >> 13) {
    case 0:
      return jump(machine, op, cycle);
    case 1:
      return wait(machine, op, cycle);
    case 2:
      return shiftIn(machine, op, cycle);
    case 3:
      return shiftOut(machine, op, cycle);
    case 4:
      return op & 0x80 ? pull(machine, op, cycle) : push(machine, op, cycle);
    case 5:
      return move(machine, op, cycle);
    case 6:
      return interrupt(machine, op, cycle);
    default:
      return set(machine, op);
  }
}

function jump(machine, op, cycle) {
  const target = op & 31;
  switch ((op >> 5) & 7) {
    case 0:
      break;
    case 1:
      if (machine.x !== 0) return DONE;
      break;
    case 2:
      if (machine.x !== 0 && machine.spinsAt(target)) return SPINNING;
      machine.x = (machine.x - 1) | 0;
      if (machine.x === -1) return DONE;
      break;
    case 3:
      if (machine.y !== 0) return DONE;
      break;
    case 4:
      if (machine.y !== 0 && machine.spinsAt(target)) return SPINNING;
      machine.y = (machine.y - 1) | 0;
      if (machine.y === -1) return DONE;
      break;
    case 5:
      if (machine.x === machine.y) return DONE;
      break;
    case 6:
      if (((machine.block.inputs.at(cycle) >>> machine.jumpPin) & 1) === 0) return DONE;
      break;
    default:
      if (machine.osrCount >= machine.pullThreshold) return DONE;
  }
  machine.pc = target;
  return JUMPED;
}

function wait(machine, op, cycle) {
  const high = (op & 0x80) !== 0;
  const index = op & 31;
  switch ((op >> 5) & 3) {
    case 0:
      return waitForPin(machine, index, high, cycle);
    case 1:
      return waitForPin(machine, (index + machine.inBase) & 31, high, cycle);
    case 2:
      return waitForFlag(machine, index, high, cycle);
    default:
      return DONE;
  }
}

function waitForPin(machine, pin, high, cycle) {
  const level = ((machine.block.inputs.at(cycle) >>> pin) & 1) !== 0;
  return level === high ? DONE : machine.stallOn(WAITS_FOR.pin);
}

/** Waiting for a set flag also clears it. */
function waitForFlag(machine, index, high, cycle) {
  const { block, bit } = machine.block.flag(machine, index);
  if (((block.flags & bit) !== 0) !== high) return machine.stallOn(WAITS_FOR.irq);
  if (high) machine.block.lowerIn(block, bit, cycle);
  return DONE;
}

function shiftIn(machine, op, cycle) {
  const bits = (op & 31) || WORD_BITS;
  const count = Math.min(WORD_BITS, machine.isrCount + bits);
  const pushes = machine.autopush && count >= machine.pushThreshold;
  if (pushes && machine.rx.full) return machine.stallOnFullRx();
  const value = lowBits(source(machine, (op >> 5) & 7, cycle), bits);
  machine.isr = bits === WORD_BITS ? value : machine.inRight ? (machine.isr >>> bits) | (value << (WORD_BITS - bits)) : (machine.isr << bits) | value;
  machine.isrCount = count;
  if (pushes) machine.pushIsr(cycle);
  return DONE;
}

function shiftOut(machine, op, cycle) {
  if (machine.autopull && machine.osrCount >= machine.pullThreshold) {
    if (machine.tx.empty) return machine.stallOnEmptyTx();
    machine.pullOsr(cycle);
    return STALLED;
  }
  const bits = (op & 31) || WORD_BITS;
  const { osr } = machine;
  const value = machine.outRight ? lowBits(osr, bits) : osr >>> (WORD_BITS - bits);
  machine.osr = bits === WORD_BITS ? 0 : machine.outRight ? osr >>> bits : osr << bits;
  machine.osrCount = Math.min(WORD_BITS, machine.osrCount + bits);
  return shiftOutTo(machine, (op >> 5) & 7, value | 0, bits);
}

function shiftOutTo(machine, destination, value, bits) {
  switch (destination) {
    case 4:
      machine.outDirections(value);
      return DONE;
    case 6:
      machine.isr = value;
      machine.isrCount = bits;
      return DONE;
    case 7:
      machine.injected = value & 0xffff;
      return DONE;
    default:
      return writeTo(machine, destination, value);
  }
}

/** The destinations that OUT and MOV share. */
function writeTo(machine, destination, value) {
  switch (destination) {
    case 0:
      machine.outPins(value);
      return DONE;
    case 1:
      machine.x = value;
      return DONE;
    case 2:
      machine.y = value;
      return DONE;
    case 5:
      machine.pc = value & 31;
      return JUMPED;
    default:
      return DONE;
  }
}

function push(machine, op, cycle) {
  const onlyIfFull = (op & 0x40) !== 0;
  const blocks = (op & 0x20) !== 0;
  if (onlyIfFull && machine.isrCount < machine.pushThreshold) return DONE;
  if (!machine.rx.full) {
    machine.pushIsr(cycle);
    return DONE;
  }
  if (blocks) return machine.stallOnFullRx();
  machine.dropIsr();
  return DONE;
}

function pull(machine, op, cycle) {
  const onlyIfEmpty = (op & 0x40) !== 0;
  const blocks = (op & 0x20) !== 0;
  if ((onlyIfEmpty || machine.autopull) && machine.osrCount < machine.pullThreshold) return DONE;
  if (!machine.tx.empty) {
    machine.pullOsr(cycle);
    return DONE;
  }
  if (blocks) return machine.stallOnEmptyTx();
  machine.osr = machine.x;
  machine.osrCount = 0;
  return DONE;
}

function move(machine, op, cycle) {
  const value = changed(source(machine, op & 7, cycle), (op >> 3) & 3);
  const destination = (op >> 5) & 7;
  switch (destination) {
    case 4:
      machine.injected = value & 0xffff;
      return DONE;
    case 6:
      machine.isr = value;
      machine.isrCount = 0;
      return DONE;
    case 7:
      machine.osr = value;
      machine.osrCount = 0;
      return DONE;
    default:
      return writeTo(machine, destination, value);
  }
}

function changed(value, operation) {
  return operation === 1 ? ~value : operation === 2 ? reversed(value) : value;
}

function reversed(value) {
  let result = 0;
  for (let bit = 0; bit < WORD_BITS; bit++) result = (result << 1) | ((value >>> bit) & 1);
  return result;
}

/** The sources of IN and MOV. */
function source(machine, number, cycle) {
  switch (number) {
    case 0:
      return rotateRight(machine.block.inputs.at(cycle), machine.inBase);
    case 1:
      return machine.x;
    case 2:
      return machine.y;
    case 5:
      return machine.status;
    case 6:
      return machine.isr;
    case 7:
      return machine.osr;
    default:
      return 0;
  }
}

/** IRQ: clears a flag, or sets it and optionally waits until it has been cleared. */
function interrupt(machine, op, cycle) {
  const { block, bit } = machine.block.flag(machine, op & 31);
  if (op & 0x40) {
    machine.block.lowerIn(block, bit, cycle);
    return DONE;
  }
  const waits = (op & 0x20) !== 0;
  if (!waits) {
    machine.block.raiseIn(block, bit, cycle);
    return DONE;
  }
  return raiseAndWait(machine, block, bit, cycle);
}

function raiseAndWait(machine, block, bit, cycle) {
  if (!machine.flagRaised) {
    machine.block.raiseIn(block, bit, cycle);
    machine.flagRaised = true;
    return STALLED;
  }
  if (block.flags & bit) return machine.stallOn(WAITS_FOR.irq);
  machine.flagRaised = false;
  return DONE;
}

function set(machine, op) {
  const value = op & 31;
  switch ((op >> 5) & 7) {
    case 0:
      machine.setPins(value);
      break;
    case 1:
      machine.x = value;
      break;
    case 2:
      machine.y = value;
      break;
    case 4:
      machine.setDirections(value);
      break;
  }
  return DONE;
}

function lowBits(value, bits) {
  return bits === WORD_BITS ? value : value & ((1 << bits) - 1);
}

export function rotateRight(value, by) {
  return (value >>> by) | (value << (WORD_BITS - by));
}

export function rotateLeft(value, by) {
  return (value << by) | (value >>> (WORD_BITS - by));
}
