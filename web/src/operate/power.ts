// Which machine is operated: the simulated one, with its power, its time and its emergency stop, or a board.

import { button, input, made, part, select } from "../elements";
import { BridgePort } from "./bridge";
import type { Machine } from "./machine";
import { SimulatedPort } from "./port";
import { chosenBoard, UsbPort, whyNoSerial } from "./serial";
import { serversToken, serverHasBoard } from "./server";

/** Where the plate for the probe lies, from the switch of Z. */
const PLATE_MM = 10;
const NO_TOKEN = "The board is for those who know the server's token: open the address that isostep web has printed.";

/** What Web Serial cannot promise. */
const BY_PAGE = "This page sends the program itself: if it is closed, the machine is held; if the computer sleeps or the browser crashes, it stops with what it has.";

/** What each machine is called, in the header and below its buttons. */
const WHAT: Record<string, [string, string]> = {
  simulated: ["The firmware's own tasks, on a simulated machine, in this browser", "This is a simulated machine."],
  usb: ["A board by USB; programs on a simulated machine", `This is a real machine. ${BY_PAGE}`],
  server: ["The board of this server; programs on a simulated machine", "This is a real machine. Its server sends the program, and goes on without this page."],
};

export class Power {
  private simulated: SimulatedPort | undefined;
  /** Whether the board that is chosen was attached before. */
  private hasConnected = false;
  private readonly hasServerBoard = serverHasBoard();

  constructor(
    private readonly machine: Machine,
    private readonly settings: () => string,
  ) {
    button("power").onclick = () => this.simulate();
    button("connect").onclick = () => (machine.isAttached ? machine.detach() : this.connect());
    select("which").onchange = () => this.choose();
    const stop = input("stop-button");
    stop.onchange = () => this.simulated?.setStopButton(stop.checked);
    const plate = input("plate");
    plate.onchange = () => this.simulated?.setPlate(plate.checked ? PLATE_MM : undefined);
    select("live-rate").onchange = () => this.setSpeed();
    machine.watch({ attached: () => this.show() });
    // Taken out of the address before anybody else reads it.
    serversToken();
    window.addEventListener("hashchange", () => serversToken());
    void this.hasServerBoard.then((hasBoard) => hasBoard && this.offerServerBoard());
  }

  /** Takes a machine when its page is looked at; a board only the first time, and one by USB needs a click. */
  look(): void {
    void this.hasServerBoard.then(() => {
      if (this.machine.isAttached || this.hasConnected || this.which === "usb") return;
      this.connect();
    });
  }

  private get which(): string {
    return select("which").value;
  }

  private offerServerBoard(): void {
    const option = made("option", "The board of this server");
    option.setAttribute("value", "server");
    select("which").append(option);
    if (serversToken()) select("which").value = "server";
    this.show();
  }

  /** A board waits for a click: nothing moves because somebody has looked at a list. */
  private choose(): void {
    this.machine.detach();
    this.simulated = undefined;
    this.hasConnected = false;
    if (this.which === "simulated") this.simulate();
    this.show();
  }

  private connect(): void {
    if (this.which === "simulated") this.simulate();
    else if (this.which === "server") this.attachServerBoard(serversToken());
    else this.attachUsbBoard().catch((error: Error) => this.tell(`No board was chosen: ${error.message}`));
  }

  private attachServerBoard(token: string | null): void {
    if (!token) return this.tell(NO_TOKEN);
    this.hasConnected = true;
    this.machine.attach((listener) => new BridgePort(token, listener), false);
  }

  private async attachUsbBoard(): Promise<void> {
    const board = await chosenBoard(this.hasConnected);
    // The person may have chosen something else meanwhile.
    if (this.which !== "usb") return;
    this.hasConnected = true;
    this.machine.attach((listener) => new UsbPort(board, listener), false);
  }

  /** A machine at power-up, with the settings of the page. */
  private simulate(): void {
    input("stop-button").checked = input("plate").checked = false;
    this.machine.log("power-up", "note");
    this.simulated = this.machine.attach((listener) => new SimulatedPort(this.settings(), listener), true);
    this.setSpeed();
  }

  private setSpeed(): void {
    this.simulated?.setSpeed(Number(select("live-rate").value));
  }

  private show(): void {
    const [what, now] = WHAT[this.which] ?? [];
    part("what").textContent = what ?? "";
    part("what-now").textContent = now ?? "";
    part("simulated").hidden = this.which !== "simulated";
    const connect = button("connect");
    connect.hidden = this.which === "simulated";
    connect.disabled = this.which === "usb" && whyNoSerial() !== "";
    connect.textContent = this.machine.isAttached ? "Disconnect" : this.hasConnected ? "Connect again" : "Connect";
    this.tell(this.which === "usb" ? whyNoSerial() : "");
  }

  private tell(words: string): void {
    part("which-trouble").textContent = words;
    part("which-trouble").hidden = !words;
  }
}
