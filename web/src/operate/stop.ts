// Stop: a hold and a reset. It goes through the page, the browser and the link, so it is no emergency stop.

import { button } from "../elements";
import { HOLD, RESET } from "./dialect";
import type { Machine } from "./machine";

/** The machine brakes on its path and forgets what waits. A second one stops it at once. */
export function stop(machine: Machine): void {
  machine.forgetWaiting();
  machine.byte(HOLD);
  machine.byte(RESET);
  machine.log("stop: hold and reset", "sent");
}

/** The button, and the Escape key wherever the button is seen. */
export function offerStop(machine: Machine): void {
  button("stop").onclick = () => stop(machine);
  document.addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || event.repeat || button("stop").offsetParent === null) return;
    // In a field of the settings it is the field's own: it empties a search, for example.
    if (event.target instanceof Element && event.target.closest("#view-settings")) return;
    event.preventDefault();
    stop(machine);
  });
}
