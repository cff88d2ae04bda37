// The RP2350's double-precision coprocessor, coprocessor 4 of a core, as far as `boards/rp2350-floats` uses it: for doubles,
// not for sums of floats, for fused multiplications or for roots.
//
// From pico-sdk (hardware_dcp, pico_double) and the comments in rp235x-hal:
// - the encodings and in which order instructions come; which of them leave `engaged` set follows from where they stand;
// - RXMS and RYMS return a mantissa with 62 - s bits after the point; WXMS sets bit 0 of X if anything is set in what it
//   writes, WXMO writes X, ORs into bit 0, adds exponents and XORs signs; its product has 60 bits after the point;
// - REFD returns X's exponent and flags in the first word, Y's in the second; bits 28 to 30 say zero, infinity and NaN;
// - the status has N for engaged, Z for equal, C for greater or equal, V for unordered; unordered leaves Z and C at 0;
// - 32-bit integers are truncated towards 0 and saturate.
//
// Derived from the sequences, which give right results with nothing else: RYMR returns about 1 / Y and Y with 31 bits after
// the point each, WXDD writes a quotient with 57.
//
// Assumed: denormals are zeros, as arguments and, judged after rounding, as results, with their signs. A NaN is
// 0x7ff80000_00000000, as a float 0x7fc00000, and an infinity as an integer. What RYMR estimates goes by Y's first 8 bits
// after the point. All other bits of the state are our own arrangement; who saves it gives it back as it was.
//
// Stricter than the chip: an instruction that does not belong to those before it is an error.

/** What a number is, unless it has a mantissa, as in bits 28 to 30 of the flags. */
const [ZERO, INFINITE, NAN] = [1, 2, 4];
/** What the instructions so far have made of X. */
const [UNPACKED, COMPARED, SUM, DIFFERENCE, PRODUCT, QUOTIENT, CONVERTED, STICKY] = [0, 1, 2, 3, 4, 5, 6, 7];
/** The status' bits, but for `engaged`. */
const [EQUAL, GREATER_OR_EQUAL, UNORDERED] = [4, 2, 1];
const ENGAGED = 8;
/** The exponent of a zero: less than any. */
const LEAST = -4096;
const WORD = 2 ** 32;
/** 1.0 as the upper word of a mantissa. */
const ONE = 0x40000000;
/** How many bits of a mantissa are behind those of a double and a float. */
const [BEHIND_DOUBLE, BEHIND_SINGLE] = [10, 39];

/** About 1 / y with 31 bits after the point, right for the middle of those y that begin with these 8 bits. */
const RECIPROCALS = Int32Array.from({ length: 256 }, (_, bits) => Math.round(2 ** 31 / (1 + (bits + 0.5) / 256)));

/** The coprocessor. A mantissa is a pair of words: 1.0 is 2^62. */
export class Dcp {
  /** Between the first operand and the result. */
  engaged = false;
  #xLow = 0;
  #xHigh = 0;
  #yLow = 0;
  #yHigh = 0;
  #xExponent = LEAST;
  #yExponent = LEAST;
  #xSign = 0;
  #ySign = 0;
  #xClass = ZERO;
  #yClass = ZERO;
  #status = 0;
  #made = UNPACKED;

  cdp(opc1, crd, crn, crm, opc2) {
    if (crd === 0 && crn === 0) {
      switch ((opc1 << 8) | (crm << 4) | opc2) {
        case 0x010: return this.#compare();
        case 0x110: return this.#add(SUM);
        case 0x111: return this.#add(DIFFERENCE);
        case 0x801: return this.#round(BEHIND_DOUBLE);
        case 0x821: return this.#round(BEHIND_SINGLE);
        case 0x802: return this.#truncate();
      }
    }
    throw unknown(`cdp #${opc1}, c${crd}, c${crn}, c${crm}, #${opc2}`);
  }

  mcrr(opc1, crm, low, high) {
    this.engaged = true;
    switch ((opc1 << 4) | crm) {
      case 0x00: return this.#setX(low, high); // WXMD
      case 0x01: return this.#setY(low, high); // WYMD
      case 0x02: return this.#restoreFlags(low, high); // WEFD
      case 0x10: return this.#unpackX(low, high); // WXUP
      case 0x11: return this.#unpackY(low, high); // WYUP
      case 0x12: return this.#unpackSingles(low, high); // WXYU
      case 0x20: return this.#setSticky(low, high); // WXMS
      case 0x30: return this.#setProduct(low, high); // WXMO
      case 0x40: return this.#setQuotient(low, high); // WXDD
      case 0x60: return this.#fromInteger(low >>> 0); // WXUC
      case 0x70: return this.#fromInteger(low | 0); // WXIC
      case 0x80: // WXDC
        this.#unpackX(low, high);
        return this.#unpackY(0, 0);
    }
    throw unknown(`mcrr #${opc1}, c${crm}`);
  }

  /** @returns {number[]} the low word and the high one */
  mrrc(opc1, crm, keeps) {
    if (crm === 4) return shiftedRight(this.#xLow, this.#xHigh, opc1); // RXMS
    if (crm === 5) return shiftedRight(this.#yLow, this.#yHigh, opc1); // RYMS
    switch ((opc1 << 4) | crm) {
      case 0x08: return this.#read(keeps, [this.#xLow, this.#xHigh]); // RXMD
      case 0x09: return this.#read(keeps, [this.#yLow, this.#yHigh]); // RYMD
      case 0x0a: return this.#read(keeps, this.#flags()); // REFD
      case 0x11: return [this.#xHigh, this.#yHigh]; // RXYH
      case 0x21: return this.#reciprocal(); // RYMR
      case 0x10: return this.#read(keeps, this.#double(SUM)); // RDDA
      case 0x30: return this.#read(keeps, this.#double(DIFFERENCE)); // RDDS
      case 0x50: return this.#read(keeps, this.#double(PRODUCT)); // RDDM
      case 0x70: return this.#read(keeps, this.#double(QUOTIENT)); // RDDD
      case 0xb0: return this.#read(keeps, this.#double(UNPACKED)); // RDDG
    }
    throw unknown(`mrrc${keeps ? '2' : ''} #${opc1}, c${crm}`);
  }

  mrc(opc1, crn, crm, opc2, keeps) {
    if (opc1 === 0 && crn === 0) {
      switch ((crm << 4) | opc2) {
        case 0x01: return this.#read(keeps, ((this.engaged ? ENGAGED : 0) | this.#status) << 28); // RCMP
        case 0x25: return this.#read(keeps, this.#single(UNPACKED)); // RDFG
        case 0x30: return this.#read(keeps, this.#integer(-(2 ** 31), 2 ** 31 - 1)); // RDIC
        case 0x31: return this.#read(keeps, this.#integer(0, WORD - 1)); // RDUC
      }
    }
    throw unknown(`mrc${keeps ? '2' : ''} #${opc1}, c${crn}, c${crm}, #${opc2}`);
  }

  #read(keeps, value) {
    if (!keeps) this.engaged = false;
    return value;
  }

  #expect(made) {
    if (this.#made !== made) throw new Error('the coprocessor is asked for what the instructions before have not made');
  }

  #setX(low, high) {
    this.#xLow = low | 0;
    this.#xHigh = high | 0;
  }

  #setY(low, high) {
    this.#yLow = low | 0;
    this.#yHigh = high | 0;
  }

  #flags() {
    const ofX = (this.#xSign << 31) | (this.#xClass << 28) | (this.#status << 25) | (this.#made << 22) | (this.#xExponent & 0x3fff);
    return [ofX, (this.#ySign << 31) | (this.#yClass << 28) | (this.#yExponent & 0x3fff)];
  }

  #restoreFlags(ofX, ofY) {
    this.#xSign = ofX >>> 31;
    this.#xClass = (ofX >>> 28) & 7;
    this.#status = (ofX >>> 25) & 7;
    this.#made = (ofX >>> 22) & 7;
    this.#xExponent = (ofX << 18) >> 18;
    this.#ySign = ofY >>> 31;
    this.#yClass = (ofY >>> 28) & 7;
    this.#yExponent = (ofY << 18) >> 18;
  }

  #unpackX(low, high) {
    this.#made = UNPACKED;
    this.#xSign = high >>> 31;
    this.#xClass = classOf(low, high);
    this.#xExponent = exponentOf(high);
    if (this.#xClass === 0) this.#setX(low << 10, mantissaHighOf(low, high));
    else this.#setX(0, this.#xClass === ZERO ? 0 : ONE);
  }

  #unpackY(low, high) {
    this.#made = UNPACKED;
    this.#ySign = high >>> 31;
    this.#yClass = classOf(low, high);
    this.#yExponent = exponentOf(high);
    if (this.#yClass === 0) this.#setY(low << 10, mantissaHighOf(low, high));
    else this.#setY(0, this.#yClass === ZERO ? 0 : ONE);
  }

  /** Each float is unpacked as the double that it is equal to. */
  #unpackSingles(x, y) {
    this.#unpackX(...doubleOfSingle(x));
    this.#unpackY(...doubleOfSingle(y));
  }

  /** X is an integer, not normalised, and Y is 0. */
  #fromInteger(value) {
    const magnitude = Math.abs(value);
    this.#made = UNPACKED;
    this.#xSign = value < 0 ? 1 : 0;
    this.#xClass = value === 0 ? ZERO : 0;
    this.#xExponent = value === 0 ? LEAST : 32;
    this.#setX(magnitude << 30, magnitude >>> 2);
    this.#unpackY(0, 0);
  }

  #setSticky(low, high) {
    this.#expect(UNPACKED);
    this.#made = STICKY;
    this.#setX((low | high) === 0 ? 0 : 1, 0);
  }

  #setProduct(low, high) {
    this.#expect(STICKY);
    this.#setX(low | (this.#xLow & 1), high);
    const either = this.#xClass | this.#yClass;
    const invalid = (either & (ZERO | INFINITE)) === (ZERO | INFINITE);
    this.#finish(PRODUCT, this.#xExponent + this.#yExponent + 2, either & NAN || invalid ? NAN : either);
  }

  #setQuotient(low, high) {
    this.#expect(UNPACKED);
    this.#setX(low << 5, (high << 5) | (low >>> 27));
    const [ofX, ofY] = [this.#xClass, this.#yClass];
    const invalid = (ofX | ofY) & NAN || (ofX !== 0 && ofX === ofY);
    const outcome = ofX & ZERO || ofY & INFINITE ? ZERO : INFINITE;
    this.#finish(QUOTIENT, this.#xExponent - this.#yExponent, invalid ? NAN : (ofX | ofY) === 0 ? 0 : outcome);
  }

  #finish(made, exponent, outcome) {
    this.#made = made;
    this.#xSign ^= this.#ySign;
    this.#xExponent = outcome === 0 ? exponent : LEAST;
    this.#xClass = outcome;
  }

  /** ADD0. */
  #compare() {
    this.#expect(UNPACKED);
    this.#made = COMPARED;
    this.#status = this.#comparison();
  }

  #comparison() {
    const both = this.#xClass & this.#yClass;
    if ((this.#xClass | this.#yClass) & NAN) return UNORDERED;
    if (both & ZERO) return EQUAL | GREATER_OR_EQUAL;
    if (this.#xSign !== this.#ySign) return this.#xSign === 1 ? 0 : GREATER_OR_EQUAL;
    const magnitude =
      this.#xExponent - this.#yExponent ||
      (this.#xHigh >>> 0) - (this.#yHigh >>> 0) ||
      (this.#xLow >>> 0) - (this.#yLow >>> 0);
    if (magnitude === 0) return EQUAL | GREATER_OR_EQUAL;
    return magnitude > 0 === (this.#xSign === 0) ? GREATER_OR_EQUAL : 0;
  }

  /** ADD1 and SUB1: X becomes the sum or the difference. */
  #add(made) {
    this.#expect(COMPARED);
    this.#made = made;
    const ySign = made === SUM ? this.#ySign : this.#ySign ^ 1;
    if ((this.#xClass | this.#yClass) & (INFINITE | NAN)) return this.#addInfinite(ySign);
    if (this.#xClass & this.#yClass & ZERO) {
      this.#xSign &= ySign;
      return;
    }
    this.#xClass = 0;
    const places = this.#xExponent - this.#yExponent;
    let [low, high, sign] = [this.#xLow, this.#xHigh, this.#xSign];
    let [otherLow, otherHigh, otherSign] = [this.#yLow, this.#yHigh, ySign];
    if (places < 0) {
      [low, high, sign, otherLow, otherHigh, otherSign] = [otherLow, otherHigh, otherSign, low, high, sign];
      this.#xExponent = this.#yExponent;
    }
    if (places !== 0) [otherLow, otherHigh] = shiftedSticky(otherLow, otherHigh, Math.abs(places));
    this.#xSign = sign;
    if (sign === otherSign) {
      const sum = (low >>> 0) + (otherLow >>> 0);
      this.#setX(sum, high + otherHigh + (sum >= WORD ? 1 : 0));
      return;
    }
    let difference = (low >>> 0) - (otherLow >>> 0);
    let upper = (high >>> 0) - (otherHigh >>> 0) - (difference < 0 ? 1 : 0);
    if (upper < 0) {
      difference = (otherLow >>> 0) - (low >>> 0);
      upper = (otherHigh >>> 0) - (high >>> 0) - (difference < 0 ? 1 : 0);
      this.#xSign = otherSign;
    }
    this.#setX(difference, upper);
    if ((this.#xLow | this.#xHigh) === 0) {
      this.#xClass = ZERO;
      this.#xSign = 0;
    }
  }

  #addInfinite(ySign) {
    const either = this.#xClass | this.#yClass;
    const opposed = this.#xClass & this.#yClass & INFINITE && this.#xSign !== ySign;
    if (!(this.#xClass & INFINITE)) this.#xSign = ySign;
    this.#xClass = either & NAN || opposed ? NAN : INFINITE;
  }

  /** NRDD and NRDF: X is normalised, and rounded to the nearest, ties to even, with so many bits behind it. */
  #round(behind) {
    if (this.#xClass !== 0) return;
    let [low, high] = [this.#xLow, this.#xHigh];
    if (high < 0) {
      [low, high] = shiftedSticky(low, high, 1);
      this.#xExponent += 1;
    } else if (high < ONE) {
      const places = (high === 0 ? 32 + Math.clz32(low) : Math.clz32(high)) - 1;
      [low, high] = shiftedLeft(low, high, places);
      this.#xExponent -= places;
    }
    if (behind < 32) {
      const half = 1 << (behind - 1);
      const odd = (low >>> behind) & 1;
      const sum = (low >>> 0) + half - 1 + odd;
      low = sum & -(half * 2);
      if (sum >= WORD) high = (high + 1) | 0;
    } else {
      const half = 1 << (behind - 33);
      const odd = (high >>> (behind - 32)) & 1;
      const rest = high & (half * 2 - 1);
      const up = rest > half || (rest === half && (low !== 0 || odd === 1));
      high = (high - rest + (up ? half * 2 : 0)) | 0;
      low = 0;
    }
    if (high < 0) {
      high = ONE;
      this.#xExponent += 1;
    }
    this.#setX(low, high);
  }

  /** NTDC: X is an integer with a sign; what no integer has is as large as can be. */
  #truncate() {
    this.#expect(SUM);
    this.#made = CONVERTED;
    const large = this.#xExponent > 40;
    if (this.#xClass & NAN) this.#xSign = 0;
    if (this.#xClass & (INFINITE | NAN) || (this.#xClass === 0 && large)) this.#setX(-1, 0x7fffffff);
    else if (this.#xClass & ZERO || this.#xExponent < 0) this.#setX(0, 0);
    else this.#setX(...shiftedRight(this.#xLow, this.#xHigh, 62 - this.#xExponent));
  }

  #integer(least, greatest) {
    this.#expect(CONVERTED);
    const magnitude = this.#xHigh * WORD + (this.#xLow >>> 0);
    return Math.min(Math.max(this.#xSign === 1 ? -magnitude : magnitude, least), greatest) | 0;
  }

  #reciprocal() {
    return [RECIPROCALS[(this.#yHigh >>> 22) & 0xff], (this.#yHigh << 1) | (this.#yLow >>> 31)];
  }

  #double(made) {
    this.#expect(made);
    const sign = this.#xSign << 31;
    if (this.#xClass & NAN) return [0, 0x7ff80000];
    if (this.#xClass & ZERO || (this.#xClass === 0 && this.#xExponent < -1022)) return [0, sign];
    if (this.#xClass & INFINITE || this.#xExponent > 1023) return [0, sign | 0x7ff00000];
    const high = sign | ((this.#xExponent + 1023) << 20) | ((this.#xHigh >>> 10) & 0xfffff);
    return [(this.#xHigh << 22) | (this.#xLow >>> 10), high];
  }

  #single(made) {
    this.#expect(made);
    const sign = this.#xSign << 31;
    if (this.#xClass & NAN) return 0x7fc00000;
    if (this.#xClass & ZERO || (this.#xClass === 0 && this.#xExponent < -126)) return sign;
    if (this.#xClass & INFINITE || this.#xExponent > 127) return sign | 0x7f800000;
    return sign | ((this.#xExponent + 127) << 23) | ((this.#xHigh >>> 7) & 0x7fffff);
  }
}

function unknown(instruction) {
  return new Error(`the emulated coprocessor does not know ${instruction}`);
}

function classOf(low, high) {
  const exponent = high & 0x7ff00000;
  if (exponent === 0) return ZERO;
  if (exponent !== 0x7ff00000) return 0;
  return ((high & 0xfffff) | low) === 0 ? INFINITE : NAN;
}

function exponentOf(high) {
  const exponent = (high >>> 20) & 0x7ff;
  return exponent === 0 ? LEAST : exponent - 1023;
}

/** The upper word of the mantissa of a double that has one; the lower is the lower word, shifted left by 10. */
function mantissaHighOf(low, high) {
  return ONE | ((high & 0xfffff) << 10) | (low >>> 22);
}

function doubleOfSingle(bits) {
  const exponent = (bits >>> 23) & 0xff;
  const sign = bits & 0x80000000;
  if (exponent === 0) return [0, sign];
  return [bits << 29, sign | ((exponent === 0xff ? 0x7ff : exponent + 896) << 20) | ((bits >>> 3) & 0xfffff)];
}

function shiftedRight(low, high, places) {
  if (places === 0) return [low, high];
  if (places < 32) return [(low >>> places) | (high << (32 - places)), high >>> places | 0];
  return [places < 64 ? (high >>> (places - 32)) | 0 : 0, 0];
}

/** Shifted right, with bit 0 set if a bit that is set is lost. */
function shiftedSticky(low, high, places) {
  if (places > 63) return [(low | high) === 0 ? 0 : 1, 0];
  const shifted = shiftedRight(low, high, places);
  const lost = places < 32 ? low << (32 - places) : low | (places === 32 ? 0 : high << (64 - places));
  if (lost !== 0) shifted[0] |= 1;
  return shifted;
}

/** Shifted left, by 1 to 62 places. */
function shiftedLeft(low, high, places) {
  if (places < 32) return [low << places, (high << places) | (low >>> (32 - places))];
  return [0, low << (places - 32)];
}
