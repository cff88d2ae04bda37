// The board of the page's server, by a WebSocket: binary messages are the board's, both ways; texts are between the page and the server.

import type { Listener, Port } from "./port";
import type { Begun } from "./sender";
import type { JobHolder, ServersJob } from "./server-sender";

const REFUSED = "the server refuses: open the address that it printed when it was started last";
const ENDED = "the server does not answer any more: start it again, and open the address that it prints";

type FromServer =
  | { is: "alive?" }
  | ({ is: "job" } & ServersJob)
  | ({ is: "program" } & Begun)
  | { is: "refused"; why: string }
  | { is: "ended"; why: string };

type ToServer = { do: "alive" } | { do: "start"; name: string; program: string; before: string[] } | { do: "program" };

export class BridgePort implements Port, JobHolder {
  /** The server holds jobs. */
  readonly jobs = this;
  job: ServersJob | undefined;
  onJob: ((job: ServersJob) => void) | undefined;
  onRefused: ((why: string) => void) | undefined;
  private readonly socket: WebSocket;
  /** What is sent before the socket is open. */
  private readonly waiting: (Uint8Array<ArrayBuffer> | string)[] = [];
  /** Who has asked for the job's program. */
  private readonly askers: ((program: Begun) => void)[] = [];
  private why = REFUSED;

  constructor(token: string, listener: Listener) {
    const address = new URL(`board?token=${token}`, location.href);
    address.protocol = location.protocol.replace("http", "ws");
    address.hash = "";
    this.socket = new WebSocket(address);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => {
      this.why = ENDED;
      for (const message of this.waiting.splice(0)) this.socket.send(message);
    };
    this.socket.onmessage = ({ data }: MessageEvent<ArrayBuffer | string>) => {
      if (typeof data === "string") this.hear(JSON.parse(data) as FromServer);
      else listener.bytes(new Uint8Array(data));
    };
    this.socket.onclose = () => listener.lost({ line: null, words: this.why });
  }

  send(bytes: Uint8Array<ArrayBuffer>): void {
    this.pass(bytes);
  }

  close(): void {
    this.socket.close();
  }

  start({ name, text, before }: Begun): void {
    this.tell({ do: "start", name, program: text, before });
  }

  /** The program of the job. */
  program(): Promise<Begun> {
    this.tell({ do: "program" });
    return new Promise((resolve) => this.askers.push(resolve));
  }

  private tell(message: ToServer): void {
    this.pass(JSON.stringify(message));
  }

  private pass(message: Uint8Array<ArrayBuffer> | string): void {
    if (this.socket.readyState === WebSocket.CONNECTING) this.waiting.push(message);
    else this.socket.send(message);
  }

  private hear(told: FromServer): void {
    switch (told.is) {
      case "alive?":
        return this.tell({ do: "alive" });
      case "job":
        this.job = told;
        return this.onJob?.(told);
      case "program":
        return this.askers.shift()?.(told);
      case "refused":
        return this.onRefused?.(told.why);
      case "ended":
        this.why = told.why;
    }
  }
}
