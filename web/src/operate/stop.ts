// Stop: a hold and a reset. It goes through the page, the browser and the link, so it is no emergency stop.

import { button } from "../elements";
import { HOLD, RESET, RESUME } from "./dialect";
import type { Machine } from "./machine";

/** The machine brakes on its path and forgets what waits. A second one stops it at once. */
export function stop(machine: Machine): void {
  machine.forgetWaiting();
  machine.byte(HOLD);
  machine.byte(RESET);
  machine.log("stop: hold and reset", "sent");
}

/** Grbl's own letters, wherever the buttons are seen and nobody types. */
const KEYS: Record<string, number> = { "!": HOLD, "~": RESUME };

/** The button, and the Escape key wherever the button is seen. */
export function offerStop(machine: Machine): void {
  button("stop").onclick = () => stop(machine);
  document.addEventListener("keydown", (event) => {
    if (event.repeat || button("stop").offsetParent === null) return;
    const byte = KEYS[event.key];
    if (byte !== undefined && !isTyping(event)) return machine.byte(byte);
    if (event.key !== "Escape") return;
    // In a field of the settings it is the field's own: it empties a search, for example.
    if (event.target instanceof Element && event.target.closest("#view-settings")) return;
    event.preventDefault();
    stop(machine);
  });
}

function isTyping({ target }: KeyboardEvent): boolean {
  return target instanceof Element && target.closest("input, textarea, select, #program") !== null;
}
