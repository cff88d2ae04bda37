// A gamepad: its left stick or cross jogs X and Y, its right stick Z, as long as it is held; one button holds, another stops.

import { part } from "../elements";
import { HOLD } from "./dialect";
import type { Machine } from "./machine";
import type { Jog } from "./jog";
import { stop } from "./stop";

/** A stick that is nearer to its middle is at rest. */
const REST = 0.5;
/** Axes of a standard gamepad: which one jogs what, and whether up is less. */
const STICKS: [stick: number, axis: number, sign: number][] = [[0, 0, 1], [1, 1, -1], [3, 2, -1]];
/** Buttons of its cross. */
const CROSS: [button: number, axis: number, direction: number][] = [[15, 0, 1], [14, 0, -1], [12, 1, 1], [13, 1, -1]];
/** The right one of the four holds; the lower one, and none else, stops. */
const [STOPS, HOLDS] = [0, 1];
const LOOK_EVERY_MS = 40;

export class Gamepads {
  private held = "";
  private pressed = new Set<number>();
  private timer: number | undefined;

  constructor(
    private readonly machine: Machine,
    private readonly jog: Jog,
  ) {
    window.addEventListener("gamepadconnected", ({ gamepad }) => {
      part("gamepad").textContent = `${gamepad.id}: left stick or cross jogs X and Y, right stick Z; button ${HOLDS + 1} holds, button ${STOPS + 1} stops.`;
      this.timer ??= window.setInterval(() => this.look(), LOOK_EVERY_MS);
    });
    window.addEventListener("gamepaddisconnected", () => this.letGo());
  }

  private look(): void {
    const pad = navigator.getGamepads().find((each) => each?.mapping === "standard");
    if (!pad || document.hidden) return this.letGo();
    this.readButtons(pad);
    const wanted = this.wanted(pad);
    const name = wanted ? `gamepad ${wanted.join(" ")}` : "";
    if (name === this.held) return;
    this.letGo();
    if (!wanted) return;
    this.held = name;
    this.jog.start(...wanted, name);
  }

  private wanted(pad: Gamepad): [number, number] | undefined {
    for (const [stick, axis, sign] of STICKS) {
      const value = (pad.axes[stick] ?? 0) * sign;
      if (Math.abs(value) > REST) return [axis, Math.sign(value)];
    }
    const found = CROSS.find(([button]) => pad.buttons[button]?.pressed);
    return found && [found[1], found[2]];
  }

  private readButtons(pad: Gamepad): void {
    const pressed = new Set([STOPS, HOLDS].filter((button) => pad.buttons[button]?.pressed));
    if (pressed.has(STOPS) && !this.pressed.has(STOPS)) stop(this.machine);
    if (pressed.has(HOLDS) && !this.pressed.has(HOLDS)) this.machine.byte(HOLD);
    this.pressed = pressed;
  }

  private letGo(): void {
    if (this.held) this.jog.letGo(this.held);
    this.held = "";
  }
}
