// The elements of the page by their names.

export function element<T extends HTMLElement>(id: string, type: new () => T): T {
  const found = document.getElementById(id);
  if (!(found instanceof type)) throw new Error(`no ${type.name} is called ${id}`);
  return found;
}

export const button = (id: string): HTMLButtonElement => element(id, HTMLButtonElement);
export const input = (id: string): HTMLInputElement => element(id, HTMLInputElement);
export const select = (id: string): HTMLSelectElement => element(id, HTMLSelectElement);
export const area = (id: string): HTMLTextAreaElement => element(id, HTMLTextAreaElement);
export const canvas = (id: string): HTMLCanvasElement => element(id, HTMLCanvasElement);
export const part = (id: string): HTMLElement => element(id, HTMLElement);

/** A new element with a text and a class. */
export function made(tag: string, text: string, name = ""): HTMLElement {
  const created = document.createElement(tag);
  created.textContent = text;
  if (name) created.className = name;
  return created;
}

/** Seconds as a person reads them. */
export function duration(seconds: number, digits = 3): string {
  if (seconds < 60) return `${seconds.toFixed(digits)} s`;
  const whole = Math.round(seconds);
  const [hours, minutes] = [Math.floor(whole / 3600), Math.floor((whole % 3600) / 60)];
  return `${hours ? `${hours} h ` : ""}${minutes} min ${whole % 60} s`;
}

export function save(name: string, content: Blob): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
