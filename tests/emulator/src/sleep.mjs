const [ISPR, SCR] = [0x200, 0xd10];
const [SLEEP_ON_EXIT, SLEEP_DEEP, SEND_EVENT_ON_PENDING] = [1 << 1, 1 << 2, 1 << 4];
const [PENDSV, SYSTICK] = [14, 15];
const FIRST_INTERRUPT = 16;

/** How a core sleeps and wakes (ARMv6-M B1.5.17 and B1.5.18): WFI, WFE, and the System Control Register. */
export class Sleep {
  /**
   * @param {(text: string) => void} onWarning
   * @param {(heedsMask: boolean) => boolean} wakes whether a pending exception would be entered; WFI ignores whether interrupts are masked
   */
  constructor(core, onWarning, wakes = (heedsMask) => wakesCortexM0(core, heedsMask)) {
    this.core = core;
    this.wakes = wakes;
    this.onWarning = onWarning;
    this.control = 0;
    /** Whether it sleeps in WFE; otherwise in WFI. */
    this.forEvent = false;
  }

  /** Adds the register to rp2040js's private peripherals. */
  attach(ppb) {
    const { readUint32, writeUint32 } = ppb;
    ppb.readUint32 = (offset) => (offset === SCR ? this.control : readUint32.call(ppb, offset));
    ppb.writeUint32 = (offset, value) => {
      if (offset === SCR) return this.setControl(value);
      const fresh = offset === ISPR && (value & ~this.core.pendingInterrupts) !== 0;
      writeUint32.call(ppb, offset, value);
      if (fresh) this.pended();
      return undefined;
    };
  }

  /** WFI: continues at once if an exception is pending that would wake it. */
  waitForInterrupt() {
    this.forEvent = false;
    this.core.waiting = !this.wakes(false);
  }

  /** WFE: continues at once if an event has been registered, and clears the event. */
  waitForEvent() {
    const { core } = this;
    this.forEvent = true;
    core.waiting = !core.eventRegistered;
    core.eventRegistered = false;
  }

  /** An exception has become pending, enabled or not. */
  pended() {
    const { core } = this;
    if (this.control & SEND_EVENT_ON_PENDING) core.eventRegistered = true;
    if (!core.waiting) return;
    if (this.forEvent && core.eventRegistered) {
      core.eventRegistered = false;
      core.waiting = false;
    } else if (this.wakes(this.forEvent)) {
      core.waiting = false;
    }
  }

  /** An interrupt has been enabled, which may have been pending for long. */
  enabled() {
    const { core } = this;
    if (core.waiting && this.wakes(this.forEvent)) core.waiting = false;
  }

  setControl(value) {
    this.control = value & (SLEEP_DEEP | SEND_EVENT_ON_PENDING);
    if (value & SLEEP_ON_EXIT) this.onWarning('SCR: SLEEPONEXIT is not emulated');
  }
}

function wakesCortexM0(core, heedsMask) {
  if (core.pendingNMI) return true;
  if (heedsMask && core.PM) return false;
  const active = core.exceptionPriority(core.IPSR);
  if (core.pendingPendSV && core.exceptionPriority(PENDSV) < active) return true;
  if (core.pendingSystick && core.exceptionPriority(SYSTICK) < active) return true;
  for (let left = core.pendingInterrupts & core.enabledInterrupts; left !== 0; left &= left - 1) {
    if (core.exceptionPriority(FIRST_INTERRUPT + 31 - Math.clz32(left & -left)) < active) return true;
  }
  return false;
}
