/** What a script or an option does to a driver. `on` and `off` switch its supply, `well` ends all else. */
export const DRIVER_STATES = ['on', 'off', 'late', 'garbled', 'hot', 'overheated', 'shorted', 'open', 'well'];
const [WELL_CELSIUS, HOT_CELSIUS, OVERHEATED_CELSIUS] = [40, 130, 160];
/** By OTTRIM (data sheet 5.1). */
const WARNING_CELSIUS = [120, 120, 143, 143];
const LIMIT_CELSIUS = [143, 150, 150, 157];
/** Of DRV_STATUS. */
const BIT = { otpw: 1 << 0, ot: 1 << 1, s2ga: 1 << 2, ola: 1 << 6, olb: 1 << 7 };
const COMPARATORS = [[120, 1 << 8], [143, 1 << 9], [150, 1 << 10], [157, 1 << 11]];

/** What is wrong with a driver and its motor, and what the driver has noticed of it. */
export class DriverFaults {
  late = false;
  garbled = false;
  /** No current flows: the motor's cable is off. */
  open = false;
  shorted = false;
  #celsius = WELL_CELSIUS;
  #shortSeen = false;
  #tooHot = false;

  /** @param {string} state one of DRIVER_STATES other than on and off */
  set(state) {
    if (state === 'well') Object.assign(this, { late: false, garbled: false, open: false, shorted: false });
    else if (state !== 'hot' && state !== 'overheated') this[state] = true;
    if (state === 'well') this.#celsius = WELL_CELSIUS;
    if (state === 'hot') this.#celsius = HOT_CELSIUS;
    if (state === 'overheated') this.#celsius = OVERHEATED_CELSIUS;
  }

  /** The driver looks: it is switched on or not, and its temperature limits are these (OTTRIM). */
  look(switchedOn, trim) {
    this.#shortSeen = switchedOn && (this.#shortSeen || this.shorted);
    this.#tooHot = this.#celsius >= (this.#tooHot ? WARNING_CELSIUS : LIMIT_CELSIUS)[trim];
  }

  /** Whether the driver has switched itself off. */
  get tripped() {
    return this.#shortSeen || this.#tooHot;
  }

  /** The flags of DRV_STATUS. */
  flags(trim) {
    const flags = COMPARATORS.filter(([celsius]) => this.#celsius >= celsius).map(([, bit]) => bit);
    if (this.#celsius >= WARNING_CELSIUS[trim]) flags.push(BIT.otpw);
    if (this.#tooHot) flags.push(BIT.ot);
    if (this.#shortSeen) flags.push(BIT.s2ga);
    if (this.open) flags.push(BIT.ola, BIT.olb);
    return flags.reduce((all, bit) => all | bit, 0);
  }
}
