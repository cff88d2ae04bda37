const [INTERFACE, ENDPOINT] = [4, 5];
const [CLASS_COMMUNICATIONS, CLASS_CDC_DATA] = [2, 10];
const BULK = 2;

/**
 * Finds a CDC-ACM function in a configuration descriptor: its control interface, and its bulk endpoints.
 *
 * @param {ArrayLike<number>} bytes
 * @returns {{interface: number, in: number, out: number}}
 */
export function bulkEndpoints(bytes) {
  const found = { interface: null, in: null, out: null };
  let dataInterface = false;
  for (let at = 0; at + 1 < bytes.length && bytes[at] > 0; at += bytes[at]) {
    if (bytes[at + 1] === INTERFACE) {
      dataInterface = bytes[at + 5] === CLASS_CDC_DATA;
      if (bytes[at + 5] === CLASS_COMMUNICATIONS) found.interface = bytes[at + 2];
    } else if (bytes[at + 1] === ENDPOINT && dataInterface && (bytes[at + 3] & 3) === BULK) {
      found[bytes[at + 2] & 0x80 ? 'in' : 'out'] = bytes[at + 2] & 0xf;
    }
  }
  if (Object.values(found).includes(null)) throw new Error('the firmware describes no CDC-ACM serial port on USB');
  return found;
}
