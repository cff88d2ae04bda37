// The board of the page's server, by a WebSocket: bytes both ways. A text says why it ends.

import type { Listener, Port } from "./port";

const REFUSED = "the server refuses: open the address that it printed when it was started last";
const ENDED = "the server does not answer any more: start it again, and open the address that it prints";

export class BridgePort implements Port {
  private readonly socket: WebSocket;
  /** What is sent before the socket is open. */
  private readonly waiting: Uint8Array<ArrayBuffer>[] = [];
  private why = REFUSED;

  constructor(token: string, listener: Listener) {
    const address = new URL(`board?token=${token}`, location.href);
    address.protocol = location.protocol.replace("http", "ws");
    address.hash = "";
    this.socket = new WebSocket(address);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => {
      this.why = ENDED;
      for (const bytes of this.waiting.splice(0)) this.socket.send(bytes);
    };
    this.socket.onmessage = ({ data }: MessageEvent<ArrayBuffer | string>) => {
      if (typeof data === "string") this.why = data;
      else listener.bytes(new Uint8Array(data));
    };
    this.socket.onclose = () => listener.lost({ line: null, words: this.why });
  }

  send(bytes: Uint8Array<ArrayBuffer>): void {
    if (this.socket.readyState === WebSocket.CONNECTING) this.waiting.push(bytes);
    else this.socket.send(bytes);
  }

  close(): void {
    this.socket.close();
  }
}
