// What the page needs of a machine: bytes both ways. A simulated one has them (here), a serial port (serial.ts), and the board of
// the page's server (bridge.ts).

import { worker } from "../job";
import type { FromWorker, ToWorker, Trouble } from "../messages";
import type { JobHolder } from "./server-sender";

export interface Port {
  send(bytes: Uint8Array): void;
  close(): void;
  /** If its other end holds jobs: it also sees to a page that goes. */
  readonly jobs?: JobHolder;
}

export interface Listener {
  bytes(bytes: Uint8Array): void;
  lost(trouble: Trouble): void;
}

/** The machine in virtual time, paced to the wall clock. */
export class SimulatedPort implements Port {
  private readonly worker = worker();

  constructor(settings: string, listener: Listener) {
    this.worker.onmessage = ({ data }: MessageEvent<FromWorker>) => {
      if (data.is === "output") {
        if (data.bytes.length) listener.bytes(data.bytes);
      } else if (data.is === "trouble") {
        this.close();
        listener.lost(data.trouble);
      }
    };
    this.worker.onerror = (event) => listener.lost({ line: null, words: event.message || "the machine did not start" });
    this.tell({ do: "operate", settings, speed: 1 });
  }

  send(bytes: Uint8Array): void {
    this.tell({ do: "send", bytes });
  }

  setSpeed(speed: number): void {
    this.tell({ do: "speed", speed });
  }

  setStopButton(pressed: boolean): void {
    this.tell({ do: "stop-button", pressed });
  }

  setPlate(placeMm: number | undefined): void {
    this.tell({ do: "plate", placeMm });
  }

  close(): void {
    this.worker.terminate();
  }

  private tell(message: ToWorker): void {
    this.worker.postMessage(message);
  }
}
