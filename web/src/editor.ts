// The program as text, with the numbers of its lines and marks at those that something is to be said of.

import { area, made, part } from "./elements";

export class Editor {
  private readonly text = area("program");
  private readonly gutter = part("gutter");
  private marked = new Set<number>();

  constructor() {
    this.text.addEventListener("input", () => this.number());
    this.text.addEventListener("scroll", () => this.follow());
    new ResizeObserver(() => this.number()).observe(this.text);
  }

  get value(): string {
    return this.text.value;
  }

  load(text: string): void {
    this.text.value = text;
    this.text.scrollTop = 0;
    this.mark([]);
  }

  /** Marks these lines, from 1. */
  mark(lines: number[]): void {
    this.marked = new Set(lines);
    this.number();
  }

  /** Selects a line, from 1, and brings it into view. */
  go(line: number): void {
    const lines = this.text.value.split("\n");
    const start = lines.slice(0, line - 1).reduce((sum, text) => sum + text.length + 1, 0);
    this.text.focus();
    this.text.setSelectionRange(start, start + (lines[line - 1]?.length ?? 0));
    this.text.scrollTop = (line - 1) * this.lineHeight() - this.text.clientHeight / 2;
    this.follow();
  }

  private lineHeight(): number {
    return parseFloat(getComputedStyle(this.text).lineHeight);
  }

  /** Numbers those lines that are in view, because there may be 200,000. */
  private number(): void {
    const height = this.lineHeight();
    const count = this.text.value.split("\n").length;
    const first = Math.max(0, Math.floor(this.text.scrollTop / height) - 2);
    const shown = Math.min(count - first, Math.ceil(this.text.clientHeight / height) + 6);
    const numbers = Array.from({ length: Math.max(0, shown) }, (_, index) => {
      const line = first + index + 1;
      return made("div", String(line), this.marked.has(line) ? "marked" : "");
    });
    this.gutter.replaceChildren(...numbers);
    this.gutter.style.setProperty("--shift", `${first * height - this.text.scrollTop}px`);
  }

  private follow(): void {
    this.number();
  }
}
