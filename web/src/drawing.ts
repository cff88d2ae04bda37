// A canvas in the pixels of the screen and the colours of the page.

export interface Pen {
  context: CanvasRenderingContext2D;
  width: number;
  height: number;
}

/** A canvas that is smaller, or on a hidden part of the page, is not drawn on. */
const LEAST_PX = 120;

/** Clears a canvas, fits it to its place on the page, and returns what draws on it in CSS pixels; nothing if there is no room. */
export function pen(canvas: HTMLCanvasElement): Pen | undefined {
  const { clientWidth: width, clientHeight: height } = canvas;
  if (width < LEAST_PX || height < LEAST_PX) return undefined;
  const scale = window.devicePixelRatio || 1;
  const context = canvas.getContext("2d");
  if (!context) throw new Error("this browser has no canvas");
  const pixels = [width, height].map((px) => Math.round(px * scale)) as [number, number];
  // A canvas that gets a size anew is made anew, which is too slow for each picture of a tool that moves.
  if (canvas.width !== pixels[0] || canvas.height !== pixels[1]) {
    [canvas.width, canvas.height] = pixels;
    context.setTransform(scale, 0, 0, scale, 0, 0);
    context.font = `12px ${getComputedStyle(document.body).fontFamily}`;
  }
  context.clearRect(0, 0, width, height);
  return { context, width, height };
}

const probe = document.createElement("span");
const dark = matchMedia("(prefers-color-scheme: dark)");
const known = new Map<string, string>();
dark.addEventListener("change", () => known.clear());

/** A colour of the style sheet, as it is in the present light. */
export function colour(name: string): string {
  const found = known.get(name);
  if (found) return found;
  if (!probe.isConnected) {
    probe.hidden = true;
    document.body.append(probe);
  }
  probe.style.color = `var(--${name})`;
  const { color } = getComputedStyle(probe);
  if (!getComputedStyle(document.documentElement).getPropertyValue(`--${name}`)) console.error(`the style sheet has no colour --${name}`);
  known.set(name, color);
  return color;
}

/** A round step that divides a span into at most so many. */
export function roundStep(span: number, most: number): number {
  const raw = Math.max(span / most, 1e-12);
  const power = 10 ** Math.floor(Math.log10(raw));
  return ([1, 2, 5, 10].find((digit) => digit * power >= raw) ?? 10) * power;
}

/** A number of such a step, without digits that say nothing. */
export function label(value: number, step: number): string {
  return (Math.abs(value) < step / 1e6 ? 0 : value).toFixed(Math.max(0, -Math.floor(Math.log10(step) + 1e-9)));
}

/** Draws anew whenever the size of a place or the light changes. */
export function onChange(place: HTMLElement, draw: () => void): void {
  new ResizeObserver(draw).observe(place);
  dark.addEventListener("change", draw);
}
