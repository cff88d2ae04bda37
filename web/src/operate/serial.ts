// A board on a serial port of this computer, by Web Serial.

import type { Listener, Port } from "./port";

/** A serial port on an RP2040, and on an RP2350. */
const BOARDS: SerialPortFilter[] = [0x000a, 0x0009].map((usbProductId) => ({ usbVendorId: 0x2e8a, usbProductId }));
/** A USB port has its own. */
const BITS_PER_S = 115_200;

/** Why this browser has no Web Serial; empty if it has. */
export function whyNoSerial(): string {
  if ("serial" in navigator) return "";
  return window.isSecureContext
    ? "This browser has no Web Serial, as Chrome, Edge and Opera have on a desktop. With any browser: isostep web --port."
    : "A browser gives serial ports only to pages of https or of this computer (http://127.0.0.1). With any page: isostep web --port.";
}

/** A board that the person chooses, or the only one that was chosen before: one that was unplugged comes back as another port. */
export async function chosenBoard(isAgain: boolean): Promise<SerialPort> {
  const known = isAgain ? (await navigator.serial.getPorts()).filter(isBoard) : [];
  const [only] = known;
  return only && known.length === 1 ? only : navigator.serial.requestPort({ filters: BOARDS });
}

function isBoard(port: SerialPort): boolean {
  const { usbVendorId, usbProductId } = port.getInfo();
  return BOARDS.some((board) => usbVendorId === board.usbVendorId && usbProductId === board.usbProductId);
}

/** The last port that was left, once it is closed. */
let closed = Promise.resolve();

export class UsbPort implements Port {
  private readonly writer: Promise<WritableStreamDefaultWriter<Uint8Array>>;
  private readonly reading: Promise<void>;
  private reader: ReadableStreamDefaultReader<Uint8Array> | undefined;
  private isLeft = false;

  constructor(
    private readonly port: SerialPort,
    listener: Listener,
  ) {
    this.writer = this.open();
    this.reading = this.read(listener);
    this.reading.then(
      () => {
        this.close();
        listener.lost({ line: null, words: "it was unplugged: plug it in, then connect again" });
      },
      (error: Error) => listener.lost({ line: null, words: `${error.message} Close other programs that use it, then connect again` }),
    );
  }

  send(bytes: Uint8Array): void {
    // Whoever reads tells when the port fails.
    this.writer.then((writer) => writer.write(bytes)).catch(() => undefined);
  }

  close(): void {
    if (this.isLeft) return;
    this.isLeft = true;
    closed = this.leave().catch(() => undefined);
  }

  private async open(): Promise<WritableStreamDefaultWriter<Uint8Array>> {
    await closed;
    await this.port.open({ baudRate: BITS_PER_S });
    await this.port.setSignals({ dataTerminalReady: true });
    if (!this.port.writable) throw new Error("It was unplugged.");
    return this.port.writable.getWriter();
  }

  /** Reads until the port is gone. After a byte that came spoilt there is a new stream. */
  private async read(listener: Listener): Promise<void> {
    await this.writer;
    while (this.port.readable && !this.isLeft) {
      this.reader = this.port.readable.getReader();
      await this.readStream(this.reader, listener).catch(() => undefined);
      this.reader.releaseLock();
    }
  }

  private async readStream(reader: ReadableStreamDefaultReader<Uint8Array>, listener: Listener): Promise<void> {
    for (;;) {
      const { value, done } = await reader.read();
      if (done) return;
      listener.bytes(value);
    }
  }

  /** What was sent goes out first. Of a board that is gone nothing can be closed but the port. */
  private async leave(): Promise<void> {
    const writer = await this.writer;
    await writer.close().catch(() => undefined);
    writer.releaseLock();
    await this.reader?.cancel().catch(() => undefined);
    await this.reading;
    await this.port.close();
  }
}
