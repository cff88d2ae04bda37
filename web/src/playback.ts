// Time on the page: a slider, and playing at a speed.

import { placesInWords } from "./axes";
import { button, input, part, select } from "./elements";
import { Motion } from "./motion";

export class Playback {
  private readonly slider = input("time");
  private readonly play = button("play");
  private motion = new Motion();
  private time = 0;
  private last: number | undefined;

  constructor(private readonly onTime: (time: number, isMoved: boolean) => void) {
    this.slider.oninput = () => this.go(Number(this.slider.value));
    this.play.onclick = () => (this.last === undefined ? this.start() : this.stop());
  }

  show(motion: Motion): void {
    this.motion = motion;
    this.slider.max = String(motion.end);
    this.slider.step = String(Math.max(motion.end / 10_000, 1e-4));
    this.slider.disabled = this.play.disabled = motion.length === 0;
    this.go(motion.end, false);
  }

  go(time: number, isMoved = true): void {
    this.time = Math.min(Math.max(0, time), this.motion.end);
    this.slider.value = String(this.time);
    const places = this.motion.places(this.time).map((place, axis) => ({ axis, words: place.toFixed(2) }));
    const speed = this.motion.speedAt(this.time).toFixed(1);
    part("time-now").textContent = `${this.time.toFixed(3)} s`;
    part("place-now").textContent = this.motion.isHomingAt(this.time) ? "homing" : `${placesInWords(places, this.motion.isRotary, "  ")}, ${speed} mm/s`;
    this.slider.setAttribute("aria-valuetext", `${this.time.toFixed(2)} seconds`);
    this.onTime(this.time, isMoved);
  }

  stop(): void {
    this.last = undefined;
    this.play.textContent = "Play";
  }

  private start(): void {
    if (this.time >= this.motion.end) this.time = 0;
    this.play.textContent = "Pause";
    this.last = performance.now();
    requestAnimationFrame((now) => this.tick(now));
  }

  private tick(now: number): void {
    if (this.last === undefined) return;
    const passed = Math.max(0, (now - this.last) / 1000) * Number(select("rate").value);
    this.last = now;
    this.go(this.time + passed);
    if (this.time >= this.motion.end) this.stop();
    else requestAnimationFrame((next) => this.tick(next));
  }
}
