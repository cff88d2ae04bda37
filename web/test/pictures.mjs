// What the pictures show, against the steps of the same run: `node --test pictures.mjs`, once `cargo xtask web` has built the machine. With
// ISOSTEP_CORPUS=FOLDER programs of others are looked at too.
import assert from "node:assert/strict";
import { readdir, readFile } from "node:fs/promises";
import { join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const at = (path) => fileURLToPath(new URL(path, import.meta.url));
const MODULES = ["motion", "picture/segments", "picture/tone", "operate/progress", "operate/rest"];
/** Instants at which a picture is held against the steps. */
const INSTANTS = 1_000;
const SLICE_US = 100_000;
const STEPS_PER_MM = 50;

/** The page's own modules and the machine, as a browser gets them. */
async function bundled() {
  const contents = [...MODULES.map((name) => `export * from "./${name}";`), 'export { default as init, Job } from "../machine/machine.js";'].join("\n");
  const stdin = { contents, resolveDir: at("../src"), loader: "ts" };
  const { outputFiles } = await build({ stdin, bundle: true, format: "esm", target: "es2022", write: false, logLevel: "error" });
  return import(`data:text/javascript;base64,${Buffer.from(outputFiles[0].contents).toString("base64")}`);
}

globalThis.performance ??= { now: () => 0 };
Object.assign(globalThis, { document: { createElement: () => ({}) }, matchMedia: () => ({ addEventListener() {} }) });
const { init, Job, madeAt, Motion, restFrom, segments, TONES, whyNotAfter, whyNotFrom } = await bundled();
await init({ module_or_path: await readFile(at("../machine/machine_bg.wasm")) });

/** A run, what the page keeps of it, and its steps if they are wanted. */
function made(program, { settings = "", kept = "lines" } = {}) {
  const job = new Job(new TextEncoder().encode(program), settings, kept);
  const motion = new Motion();
  const rows = [];
  const take = () => {
    const piece = job.takeMotion();
    motion.add({
      times: piece.takeTimes(), kinds: piece.takeKinds(), values: piece.takeValues(), loads: piece.takeLoads(), asked: piece.takeAsked(),
      powerTimes: piece.takePowerTimes(), powers: piece.takePowers(),
    });
    piece.free();
    rows.push(job.takeRows());
  };
  for (let hasEnded = false, until = SLICE_US; !hasEnded; until += SLICE_US) {
    hasEnded = job.advance(until);
    take();
  }
  const summary = JSON.parse(job.end());
  take();
  motion.lines = { times: job.takeLineTimes(), lines: job.takeLines() };
  return { motion, summary, trace: Buffer.concat(rows).toString() };
}

/** Where each axis is after each of its steps: times in s, places in mm, from the trace. */
function stepsOf(trace) {
  const [head, ...rows] = trace.trim().split("\n").map((row) => row.split(","));
  const column = (name) => head.indexOf(name);
  const axes = ["X", "Y", "Z"].map(() => ({ times: [], places: [] }));
  for (const row of rows) {
    const axis = axes["XYZ".indexOf(row[column("axis")].toUpperCase())];
    axis.times.push(Number(row[column("t_ns")]) * 1e-9);
    axis.places.push(Number(row[column("position_steps")]) / STEPS_PER_MM);
  }
  return axes;
}

function lastBefore(times, time) {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/** Random numbers from 0 to 1 that are the same in every run. */
function numbers(seed) {
  let state = seed;
  return () => ((state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32);
}

const OURS = ["parking.nc", "arcs.nc", "engraving.nc"];
const theirs = process.env.ISOSTEP_CORPUS ? (await readdir(join(process.env.ISOSTEP_CORPUS, "original"))).map((name) => join(process.env.ISOSTEP_CORPUS, "original", name)) : [];
const programs = [...OURS.map((name) => at(`../../programs/${name}`)), ...theirs];

for (const path of programs) {
  const name = path.split("/").at(-1);
  const program = await readFile(path, "utf8");

  test(`${name}: where the picture has the tool, the steps have it, at ${INSTANTS} instants`, () => {
    const { motion, trace } = made(program, { kept: "trace" });
    const steps = stepsOf(trace);
    const random = numbers(1);
    // Homing counts from wherever the machine stood, and ends at 0.
    let homedS = 0;
    for (let row = 0; row < motion.length && motion.isHoming(row); row++) homedS = motion.to(row);
    let moved = 0;
    for (let instant = 0; instant < INSTANTS; instant++) {
      const time = random() * motion.end;
      const places = motion.places(time);
      if (motion.isHomingAt(time)) continue;
      steps.forEach(({ times, places: stepped }, axis) => {
        const last = lastBefore(times, time);
        const place = last < 0 || times[last] <= homedS ? 0 : stepped[last];
        moved += Math.abs(place);
        // A step stands for the place halfway to it.
        assert.ok(Math.abs(places[axis] - place) <= 1.05 / STEPS_PER_MM, `${time} s, axis ${axis}: the picture has ${places[axis]}, the steps ${place} mm`);
      });
    }
    assert.ok(moved > INSTANTS, "it stands still");
  });

  test(`${name}: a place of the path has the colour of its speed, and of the time lost there`, async () => {
    const { motion } = made(program);
    for (const [name, share] of [["speed", (speed) => speed / motion.topSpeed], ["lost", (speed, asked) => Math.max(0, 1 - speed / asked)]]) {
      const tone = TONES[name];
      const wide = 1 / tone.scale.length;
      let parts = 0;
      for (let row = 0; row < motion.length; row++) {
        if (motion.isHoming(row)) continue;
        tone.parts(motion, row, (from, to, rank) => {
          // The speed by where the axes are, in the middle of the part.
          const [middle, half] = [(from + to) / 2, Math.min(1e-4, (to - from) / 4)];
          const [before, behind] = [motion.placesIn(row, middle - half), motion.placesIn(row, middle + half)];
          const speed = Math.hypot(...before.map((mm, axis) => behind[axis] - mm)) / (2 * half);
          const class_ = tone.scale.indexOf(tone.colours[rank]);
          const wanted = share(speed, motion.askedIn(row));
          // Places are kept as 32-bit numbers.
          const room = 2e-4 * 0.2 / half + 1e-3;
          if (!Number.isFinite(wanted)) return;
          assert.ok(wanted >= class_ * wide - room && (wanted <= (class_ + 1) * wide + room || class_ === tone.scale.length - 1), `row ${row}: ${wanted} is drawn as class ${class_}`);
          parts++;
        });
      }
      assert.ok(parts > 5, `${parts} parts`);
    }
    const drawn = await segments(motion, TONES.speed, () => true);
    assert.ok(drawn.count > 0 && drawn.count <= 60_000);
    // Each line of the picture ends where the tool is then, to the quarter of a step by which phases may be apart where they meet.
    for (let index = 0; index < drawn.count; index += Math.ceil(drawn.count / INSTANTS)) {
      const [place, shown] = [motion.places(drawn.ends[index]), drawn.places.slice(6 * index + 3, 6 * index + 6)];
      place.forEach((mm, axis) => assert.ok(Math.abs(mm - shown[axis]) < 0.25 / STEPS_PER_MM, `line ${index}: ${mm} is drawn at ${shown[axis]}`));
    }
  });

  test(`${name}: a machine that reports its line and place is found where it is on its path`, () => {
    const { motion } = made(program, { kept: "plan" });
    const { times, lines } = motion.lines;
    const plan = { motion, beginsS: (line) => motion.timeOf(line), endsS: (line) => times[lines.findIndex((each) => each > line)] ?? motion.end };
    const random = numbers(7);
    const instants = Array.from({ length: INSTANTS / 5 }, () => random() * motion.end).sort((one, other) => one - other);
    let from = 0;
    for (const time of instants) {
      if (motion.isHomingAt(time) || motion.speedAt(time) === 0) continue;
      const place = motion.places(time).map((mm) => Number(mm.toFixed(3)));
      const line = motion.lineAt(time);
      from = madeAt(plan, { from: line, to: line }, place, from);
      const found = motion.places(from);
      assert.ok(Math.hypot(...place.map((mm, axis) => mm - found[axis])) < 0.05, `${time} s: ${place} is found at ${found}`);
    }
  });
}

/** What the lines before one leave, by the machine's own words. */
function leftBefore(lines, line) {
  const { motion, summary } = made(`${lines.slice(0, line - 1).join("\n")}\n$G\n$#\n`, { kept: "plan" });
  const said = (name) => summary.said_last.filter((text) => text.startsWith(`[${name}:`)).at(-1)?.slice(name.length + 2, -1) ?? "";
  let highestMm = 0;
  for (let row = 0; row < motion.length; row++) if (!motion.isHoming(row)) highestMm = Math.max(highestMm, motion.place(row, 2, 0));
  return { modes: said("GC").split(" "), length: Number(said("TLO")), placeMm: summary.position_mm, highestMm, isInches: false };
}

for (const name of ["two_tools.nc", "arcs.nc", "engraving.nc"]) {
  test(`${name}: the rest from a line on goes where the whole goes`, async () => {
    const lines = (await readFile(at(`../../programs/${name}`), "utf8")).split("\n");
    const settings = "$341=0\n";
    const whole = made(lines.join("\n"), { settings, kept: "plan" });
    let begun = 0;
    for (let line = 7; line < lines.length; line += 3) {
      const left = leftBefore(lines, line);
      if (whyNotFrom(lines, line) || whyNotAfter(lines[line - 1], line, left)) continue;
      const { text } = restFrom(lines, line, left);
      assert.deepEqual(text.split("\n").slice(line - 1), lines.slice(line - 1), "lines keep their numbers");
      const rest = made(text, { settings, kept: "plan" });
      assert.deepEqual(rest.summary.refusals, [], `from line ${line}: ${text}`);
      for (let each = line; each <= lines.length; each++) {
        const [one, other] = [whole, rest].map(({ motion }) => motion.timeOf(each));
        // What follows from a place where the whole goes round a corner begins at rest here.
        if (one === undefined || other === undefined || each < line + 2) continue;
        const [there, here] = [whole.motion.places(one), rest.motion.places(other)];
        there.forEach((mm, axis) => assert.ok(Math.abs(mm - here[axis]) < 0.05, `from line ${line}, line ${each}: ${there} and ${here}`));
      }
      rest.summary.position_mm.forEach((mm, axis) => assert.ok(Math.abs(mm - whole.summary.position_mm[axis]) < 0.021, `from line ${line}: ends at ${rest.summary.position_mm}`));
      begun++;
    }
    assert.ok(begun > 4, `${begun} lines`);
  });
}
