// How a person goes about in the plane: the wheel or two fingers go nearer, dragging shifts, a double click shows all again.

import type { Plane, Window } from "./plane";

/** How far one goes, against the least and the most, px for a millimetre. */
const SCALES = [0.02, 4_000] as const;
/** What a notch of the wheel does. */
const NOTCH = 1.0016;

interface Owner {
  plane(): Plane | undefined;
  /** Looks elsewhere; at all there is without a window. */
  look(window: Window | undefined): void;
}

export class Handling {
  /** Pointers that are down, with where they were seen last. */
  private readonly down = new Map<number, [number, number]>();

  constructor(
    private readonly place: HTMLElement,
    private readonly owner: Owner,
  ) {
    place.addEventListener("wheel", (event) => this.turned(event), { passive: false });
    place.addEventListener("pointerdown", (event) => this.pressed(event));
    place.addEventListener("pointermove", (event) => this.moved(event));
    for (const end of ["pointerup", "pointercancel"] as const) place.addEventListener(end, (event) => void this.down.delete(event.pointerId));
    place.addEventListener("dblclick", () => this.owner.look(undefined));
  }

  private turned(event: WheelEvent): void {
    if (!this.owner.plane()) return;
    event.preventDefault();
    this.scale(NOTCH ** -event.deltaY, this.at(event));
  }

  private pressed(event: PointerEvent): void {
    if (!this.owner.plane() || event.button !== 0 || event.target instanceof HTMLButtonElement) return;
    this.place.setPointerCapture(event.pointerId);
    this.down.set(event.pointerId, this.at(event));
  }

  private moved(event: PointerEvent): void {
    const before = this.down.get(event.pointerId);
    const plane = this.owner.plane();
    if (!before || !plane) return;
    const now = this.at(event);
    const [other] = [...this.down].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
    this.down.set(event.pointerId, now);
    if (other) return this.scale(Math.hypot(now[0] - other[0], now[1] - other[1]) / Math.max(1, Math.hypot(before[0] - other[0], before[1] - other[1])), other);
    const [from, to] = [plane.placeAt(...before), plane.placeAt(...now)];
    const { middle, scale } = plane.window;
    this.owner.look({ middle: [middle[0] + from[0] - to[0], middle[1] + from[1] - to[1]], scale });
  }

  /** What is at a place of the canvas stays there. */
  private scale(by: number, at: [number, number]): void {
    const plane = this.owner.plane();
    if (!plane) return;
    const { middle, scale } = plane.window;
    const next = Math.min(SCALES[1], Math.max(SCALES[0], scale * by));
    const place = plane.placeAt(...at);
    const share = scale / next;
    this.owner.look({ middle: [place[0] + (middle[0] - place[0]) * share, place[1] + (middle[1] - place[1]) * share], scale: next });
  }

  private at(event: MouseEvent): [number, number] {
    const { left, top } = this.place.getBoundingClientRect();
    return [event.clientX - left, event.clientY - top];
  }
}
