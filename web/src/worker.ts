// The machine, apart from the page, so that the page never waits for it.

import init, { check, Job, speedProfiles, lastPanic, Live, panicOnPurpose, plainLines, Quick, report, settingRows, settingsListed, settingsRefusal, swings, tools } from "../machine/machine.js";
import type { FromWorker, Kept, LineTimes, Load, Summary, ToWorker, Trouble } from "./messages";
import { buffers, lastPieces, pieces } from "./pieces";

/** Machine time in one go, us. */
const SLICE_US = 100_000;
/** Time between two messages about a program, ms. */
const TELL_EVERY_MS = 60;
/** Time between two looks at a machine that is operated, ms. */
const TICK_MS = 16;
/** A machine that is further behind than this no longer tries to catch up, ms. */
const BEHIND_MAX_MS = 250;

/** A test of the page asks for a defect by the address of this worker. */
const BREAKS = self.location.search === "?defect";

let live: Live | undefined;
let speed = 1;

function tell(message: FromWorker, transfer: Transferable[] = []): void {
  self.postMessage(message, { transfer });
}

/** What was thrown, as words and a line: the machine throws JSON; a panic is a defect, and says where. */
function trouble(error: unknown): Trouble {
  if (typeof error === "string") {
    try {
      return JSON.parse(error) as Trouble;
    } catch {
      return { line: null, words: error };
    }
  }
  const panic = error instanceof WebAssembly.RuntimeError ? lastPanic() : undefined;
  return { line: null, words: panic ? `this is a defect of Isostep: ${panic}` : String(error) };
}

function tellProgress(job: Job): void {
  const [motion, rows] = [pieces(job), job.takeRows()];
  const { answered, lines } = job;
  const lineTimes = lineTimesOf(job);
  tell({ is: "progress", answered, lines, seconds: job.nowUs * 1e-6, motion, rows, lineTimes }, [...buffers(motion), rows.buffer, lineTimes.times.buffer, lineTimes.lines.buffer]);
}

/** Since they were taken last. */
function lineTimesOf(job: Job): LineTimes {
  return { times: job.takeLineTimes(), lines: job.takeLines() };
}

function run(program: Uint8Array, settings: string, kept: Kept): void {
  const began = performance.now();
  const job = new Job(program, settings, kept);
  let [until, reportedAt, hasEnded] = [0, began, false];
  while (!hasEnded) {
    until += SLICE_US;
    hasEnded = job.advance(until);
    if (performance.now() - reportedAt > TELL_EVERY_MS) {
      reportedAt = performance.now();
      tellProgress(job);
    }
  }
  // What is left of before the end is taken first.
  tellProgress(job);
  const summary = JSON.parse(job.end());
  const [motion, rows] = [lastPieces(job), job.takeRows()];
  const lineTimes = lineTimesOf(job);
  const wallSeconds = (performance.now() - began) * 1e-3;
  tell({ is: "ended", summary, wallSeconds, motion, rows, lineTimes }, [...buffers(motion), rows.buffer, lineTimes.times.buffer, lineTimes.lines.buffer]);
}

/** What the machine would do: how it moves, when each line is answered, to a slice of time, and how long all takes. `before` makes it so as
 * a real machine is, and its time does not count. */
function plan(program: Uint8Array, before: Uint8Array, settings: string): void {
  const whole = new Uint8Array(before.length + program.length);
  whole.set(before);
  whole.set(program, before.length);
  const job = new Job(whole, settings, "plan");
  const answeredAtS = new Float64Array(job.lines);
  const motion = [];
  let [answered, hasEnded] = [0, false];
  while (!hasEnded) {
    hasEnded = job.advance(job.nowUs + SLICE_US);
    motion.push(...pieces(job));
    answeredAtS.fill(job.nowUs * 1e-6, answered, job.answered);
    answered = job.answered;
  }
  const { duration_s: totalS, alarm, refusals, position_mm: placeMm, said_last: said } = JSON.parse(job.end()) as Summary;
  motion.push(...lastPieces(job));
  const lines = lineTimesOf(job);
  const [refusal] = refusals;
  if (refusal) return tell({ is: "trouble", trouble: { line: refusal.line, words: `\`${refusal.text.trim()}\`: error:${refusal.code} ${refusal.words}` } });
  if (alarm !== null) return tell({ is: "trouble", trouble: { line: null, words: `the program ends in ALARM:${alarm}` } });
  tell({ is: "planned", motion, lines, answeredAtS, beganS: beganAt(lines, before), totalS, placeMm, said }, [...buffers(motion), lines.times.buffer, lines.lines.buffer, answeredAtS.buffer]);
}

/** When the first line behind `before` moves the machine, or would if it did, s. */
function beganAt({ times, lines }: LineTimes, before: Uint8Array): number {
  const count = before.filter((byte) => byte === 10).length;
  const first = lines.findIndex((line) => line > count);
  return first < 0 ? 0 : (times[first] ?? 0);
}

/** How long a program takes, and, if a load is given, how that swings. */
function quick(program: Uint8Array, settings: string, load: Load | undefined): void {
  const job = new Quick(program, settings);
  let [until, reportedAt, hasEnded] = [0, performance.now(), false];
  while (!hasEnded) {
    until += SLICE_US;
    hasEnded = job.advance(until);
    if (performance.now() - reportedAt < TELL_EVERY_MS) continue;
    reportedAt = performance.now();
    tell({ is: "quickly", answered: job.answered, lines: job.lines });
  }
  tell({ is: "found", found: JSON.parse(job.end()) });
  if (!load) return;
  try {
    tell({ is: "swung", swings: JSON.parse(swings(program, settings, load.hz, load.damping)), words: "" });
  } catch (error) {
    tell({ is: "swung", swings: null, words: trouble(error).words });
  }
}

function operate(machine: Live): void {
  let last = performance.now();
  const tick = (): void => {
    const now = performance.now();
    const passedMs = Math.min(now - last, BEHIND_MAX_MS);
    last = now;
    try {
      machine.advance(machine.nowUs + passedMs * 1e3 * speed);
      machine.forgetMotion();
      const bytes = machine.takeOutput();
      tell({ is: "output", bytes, seconds: machine.nowUs * 1e-6 });
      setTimeout(tick, TICK_MS);
    } catch (error) {
      tell({ is: "trouble", trouble: trouble(error) });
    }
  };
  tick();
}

async function obey(message: ToWorker): Promise<void> {
  await ready;
  if (BREAKS) panicOnPurpose();
  switch (message.do) {
    case "run":
      run(message.program, message.settings, message.kept);
      break;
    case "check":
      tell({ is: "checked", rows: JSON.parse(check(message.program, message.settings)) });
      break;
    case "report":
      tell({ is: "reported", report: report(message.name, message.program, message.settings) });
      break;
    case "profiles":
      tell({ is: "profiles", profiles: JSON.parse(speedProfiles(new Float64Array(message.asked))) });
      break;
    case "operate":
      speed = message.speed;
      live = new Live(message.settings);
      operate(live);
      break;
    case "send":
      live?.send(message.bytes);
      break;
    case "speed":
      speed = message.speed;
      break;
    case "stop-button":
      live?.setEmergencyStop(message.pressed);
      break;
    case "plate":
      live?.setPlate(message.placeMm);
      break;
    case "plan":
      tell({ is: "tools", tools: JSON.parse(tools(message.program)) });
      tell({ is: "plain", lines: JSON.parse(plainLines(message.program)) });
      plan(message.program, message.before, message.settings);
      break;
    case "setting-rows":
      tell({ is: "setting-rows", rows: JSON.parse(settingRows()) });
      break;
    case "check-settings":
      tell({ is: "settings-checked", refusal: JSON.parse(settingsRefusal(message.lines)) });
      break;
    case "list-settings":
      tell({ is: "settings-listed", listed: JSON.parse(settingsListed(message.text)) });
      break;
    case "quick":
      quick(message.program, message.settings, message.load);
  }
}

/** Its name says how many axes its machine has. That with A is another module with the same functions. */
const MODULE = self.name === "4 axes" ? "machine4_bg.wasm" : "machine_bg.wasm";
const ready = init({ module_or_path: new URL(MODULE, self.location.href) });

self.onmessage = ({ data }: MessageEvent<ToWorker>) => {
  obey(data).catch((error: unknown) => tell({ is: "trouble", trouble: trouble(error) }));
};
