// What the pictures show, against the steps of the same run: `node --test pictures.mjs`, once `cargo xtask web` has built the machine. With
// ISOSTEP_CORPUS=FOLDER programs of others are looked at too.
import assert from "node:assert/strict";
import { readdir, readFile } from "node:fs/promises";
import { join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const at = (path) => fileURLToPath(new URL(path, import.meta.url));
const MODULES = ["motion", "pieces", "samples", "picture/segments", "picture/tone", "operate/progress", "operate/rest"];
/** Instants at which a picture is held against the steps. */
const INSTANTS = 1_000;
const SLICE_US = 100_000;
const STEPS_PER_MM = 50;
const LETTERS = "XYZA";

/** The page's own modules and the machine, as a browser gets them; under another head as modules of their own. */
async function bundled(head = "") {
  const contents = [...MODULES.map((name) => `export * from "./${name}";`), 'export { default as init, Job } from "../machine/machine.js";'].join("\n");
  const stdin = { contents, resolveDir: at("../src"), loader: "ts" };
  const { outputFiles } = await build({ stdin, bundle: true, format: "esm", target: "es2022", write: false, logLevel: "error", banner: { js: head } });
  return import(`data:text/javascript;base64,${Buffer.from(outputFiles[0].contents).toString("base64")}`);
}

globalThis.performance ??= { now: () => 0 };
Object.assign(globalThis, { document: { createElement: () => ({}) }, matchMedia: () => ({ addEventListener() {} }) });
const { CHARTS, init, Job, lastPieces, madeAt, Motion, Parts, pieces, restFrom, samples, segments, TONES, whyNotAfter, whyNotFrom } = await bundled();
await init({ module_or_path: await readFile(at("../machine/machine_bg.wasm")) });
/** The machine with A, beside the other. */
const { init: initWithA, Job: JobWithA } = await bundled("// The machine with A.");
await initWithA({ module_or_path: await readFile(at("../machine4/machine_bg.wasm")) });

/** A run, what the page keeps of it, and its steps if they are wanted. */
function made(program, { settings = "", kept = "lines", machine = Job } = {}) {
  const job = new machine(new TextEncoder().encode(program), settings, kept);
  const motion = new Motion();
  const rows = [];
  const take = (pieces) => {
    pieces.forEach((piece) => motion.add(piece));
    rows.push(job.takeRows());
  };
  for (let hasEnded = false, until = SLICE_US; !hasEnded; until += SLICE_US) {
    hasEnded = job.advance(until);
    take(pieces(job));
  }
  const summary = JSON.parse(job.end());
  take(lastPieces(job));
  motion.addLines({ times: job.takeLineTimes(), lines: job.takeLines() });
  return { motion, summary, trace: Buffer.concat(rows).toString() };
}

/** Where each axis is after each of its steps: times in s, places in mm, from the trace. */
function stepsOf(trace) {
  const [head, ...rows] = trace.trim().split("\n").map((row) => row.split(","));
  const column = (name) => head.indexOf(name);
  const axes = [...LETTERS].map(() => ({ times: [], places: [] }));
  for (const row of rows) {
    const axis = axes[LETTERS.indexOf(row[column("axis")].toUpperCase())];
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

const OURS = ["parking.nc", "arcs.nc", "engraving.nc", "two_tools.nc"];
const theirs = process.env.ISOSTEP_CORPUS ? (await readdir(join(process.env.ISOSTEP_CORPUS, "original"))).map((name) => join(process.env.ISOSTEP_CORPUS, "original", name)) : [];
const paths = [...OURS.map((name) => at(`../../programs/${name}`)), ...theirs];
/** Beyond the travel, which an alarm ends within a corner. */
const ENDED = "G21 G90\n$21=1\nG1 X-20 F900\nG2 X-20 Y0 I-9 J0\nG1 X0\n";
const programs = await Promise.all(paths.map(async (path) => [path.split("/").at(-1), accepted(await readFile(path, "utf8"))]));

/** A program without the lines that end its run, as another machine takes them. */
function accepted(program) {
  for (;;) {
    const [refused] = made(program, { kept: "plan" }).summary.refusals.filter(({ code }) => code !== 9);
    if (!refused) return program;
    program = program.split("\n").map((line, index) => (index + 1 === refused.line ? "" : line)).join("\n");
  }
}

/** Asserts that the tool is where the steps have it, at random instants. Returns how far each axis was from its zero, added up. */
function follows(motion, trace) {
  const steps = stepsOf(trace).slice(0, motion.axes);
  const random = numbers(1);
  // Homing counts from wherever the machine stood, and ends at 0.
  let homedS = 0;
  for (let row = 0; row < motion.length && motion.read(row).isHoming; row++) homedS = motion.to(row);
  const moved = steps.map(() => 0);
  for (let instant = 0; instant < INSTANTS; instant++) {
    const time = random() * motion.end;
    const places = motion.places(time);
    assert.equal(places.length, steps.length);
    if (motion.isHomingAt(time)) continue;
    steps.forEach(({ times, places: stepped }, axis) => {
      const last = lastBefore(times, time);
      const place = last < 0 || times[last] <= homedS ? 0 : stepped[last];
      moved[axis] += Math.abs(place);
      // A step stands for the place halfway to it.
      assert.ok(Math.abs(places[axis] - place) <= 1.05 / STEPS_PER_MM, `${time} s, axis ${axis}: the picture has ${places[axis]}, the steps ${place} mm`);
    });
  }
  return moved;
}

test(`with A: where the page has all four axes, the steps have them, at ${INSTANTS} instants`, () => {
  const program = "G21 G90\n$H\nG1 X20 Y10 Z5 A90 F2000\nG0 A-45\nG91 G2 X10 I5 A30 F900\nG1 A12.34\nX1 A-1\nX1 Y1\nG90 G0 X0 Y0 Z0 A0\n";
  const { motion, summary, trace } = made(program, { kept: "trace", machine: JobWithA });
  assert.deepEqual(summary.refusals, []);
  assert.equal(motion.axes, 4);
  for (const moved of follows(motion, trace)) assert.ok(moved > INSTANTS, `${moved}: it stands still`);
  assert.ok(Math.abs(motion.places(motion.end)[3]) < 1e-3);
  assert.match(made(program).summary.refusals[0].text, /A90/, "the other machine has no A");
});

/** A speed profile whose acceleration changes all the time. */
const CURVED = "$940=1\nG21 G91\nG1 X60 Y17 F2400\nY-32 F1500\nX-25 Y15 Z4\nG0 X-35 Z-4\n";

/** Full acceleration up to a pause and behind it. */
const PAUSE = "G21 G91 G61\nG1 X10 F1200\nG4 P0.5\nX-10\nG4 P1\nY5 Z3\n";

/** A smooth surface in rows, as CAM writes it. */
function relief(lines, inRow = 100) {
  const line = (_, index) => {
    const [row, column] = [Math.floor(index / inRow), index % inRow];
    const [x, y] = [0.2 * (row % 2 ? inRow - 1 - column : column), 0.4 * row];
    return `X${x.toFixed(3)} Y${y.toFixed(3)} Z${(2 * Math.sin(x / 6) * Math.cos(y / 8)).toFixed(3)}`;
  };
  return `G21 G90 G1 F2400\n${Array.from({ length: lines }, line).join("\n")}\n`;
}

/** How far a place is from the nearest line that is drawn, mm. */
function besideMm({ places, count }, [x, y, z]) {
  let nearest = Infinity;
  for (let at = 0; at < 6 * count; at += 6) {
    const [dx, dy, dz] = [places[at + 3] - places[at], places[at + 4] - places[at + 1], places[at + 5] - places[at + 2]];
    const [px, py, pz] = [x - places[at], y - places[at + 1], z - places[at + 2]];
    const long = dx * dx + dy * dy + dz * dz;
    const share = long ? Math.min(1, Math.max(0, (px * dx + py * dy + pz * dz) / long)) : 0;
    nearest = Math.min(nearest, Math.hypot(px - share * dx, py - share * dy, pz - share * dz));
  }
  return nearest;
}

/** Speed, acceleration and jerk of an axis at a time. */
function ofAxis(motion, row, axis, time) {
  const phase = motion.read(row);
  const after = time - phase.from;
  return [phase.speed(axis, after), phase.accel(axis, after), phase.jerk(axis)];
}

/** The parts into which a tone divides a phase: from, to and rank of each. */
function partsOf(tone, motion, row) {
  const parts = new Parts();
  tone.divide(motion, motion.read(row), parts);
  return Array.from({ length: parts.count }, (_, index) => [parts.from[index], parts.to[index], parts.ranks[index]]);
}

/** The value of a curve at a time, on the straight line between two points of it. */
function between(times, values, time) {
  const last = Math.min(lastBefore(times, time), times.length - 2);
  const [from, to] = [times[last], times[last + 1]];
  return values[last] + ((values[last + 1] - values[last]) * (time - from)) / (to - from || 1);
}

for (const [name, program] of [...programs, ["a relief of 2,000 lines", relief(2_000)], ["an S-curve", CURVED], ["a pause", PAUSE], ["an alarm in a corner", ENDED]]) {

  test(`${name}: where the picture has the tool, the steps have it, at ${INSTANTS} instants`, () => {
    const { motion, trace } = made(program, { kept: "trace" });
    const moved = follows(motion, trace).reduce((sum, each) => sum + each);
    assert.ok(moved > INSTANTS, "it stands still");
  });

  test(`${name}: a place of the path has the colour of its speed, and of the time lost there`, async () => {
    const { motion } = made(program);
    for (const [name, share] of [["speed", (speed) => speed / motion.topSpeed], ["lost", (speed, asked) => Math.max(0, 1 - speed / asked)]]) {
      const tone = TONES[name];
      const wide = 1 / tone.scale.length;
      let parts = 0;
      for (let row = 0; row < motion.length; row++) {
        const phase = motion.read(row);
        if (phase.isHoming) continue;
        for (const [from, to, rank] of partsOf(tone, motion, row)) {
          // The speed by where the axes are, just before and behind the middle of the part.
          const [middle, half] = [(from + to) / 2, Math.min(1e-3, (to - from) / 4)];
          const [before, behind] = [middle - half, middle + half].map((after) => [0, 1, 2].map((axis) => phase.place(axis, after)));
          const speed = Math.hypot(...before.map((mm, axis) => behind[axis] - mm)) / (2 * half);
          const class_ = tone.scale.indexOf(tone.colours[rank]);
          const { asked } = phase;
          const wanted = share(speed, asked);
          // Places are kept as 32-bit numbers, so of a short part the speed is not known so well.
          const room = 6e-5 / half / Math.min(asked, motion.topSpeed) + 1e-3;
          if (!Number.isFinite(wanted) || room > wide / 4) continue;
          assert.ok(wanted >= class_ * wide - room && (wanted <= (class_ + 1) * wide + room || class_ === tone.scale.length - 1), `row ${row}: ${wanted} is drawn as class ${class_}`);
          // Along the part it changes by no more than a colour or so.
          for (const end of [from + 0.1 * (to - from), to - 0.1 * (to - from)]) {
            const there = share(phase.speedAlong(end), asked);
            assert.ok(Math.abs(there - (class_ + 0.5) * wide) < 2 * wide || there > 1, `row ${row}: ${there} at an end is drawn as class ${class_}`);
          }
          parts++;
        }
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
    // And wherever the tool is there is a line, finer than on a screen also for those who come nearer.
    const size = Math.max(...motion.low.map((mm, axis) => motion.high[axis] - mm));
    assert.ok(drawn.fine < size / 5_000, `${drawn.fine} of ${size} mm`);
    const random = numbers(3);
    for (let instant = 0; instant < INSTANTS / 5; instant++) {
      const time = random() * motion.end;
      if (motion.isHomingAt(time)) continue;
      const beside = besideMm(drawn, motion.places(time));
      assert.ok(beside < 2.5 * drawn.fine + 0.25 / STEPS_PER_MM, `${time} s: the tool is ${beside} mm beside the path`);
    }
  });

  test(`${name}: the scale of speeds ends at the highest, and loads are shares of the limits`, () => {
    const { motion } = made(program);
    let [highest, compared] = [0, 0];
    for (let row = 0; row < motion.length; row++) {
      const phase = motion.read(row);
      if (phase.isHoming) continue;
      highest = Math.max(highest, phase.speedAlong(phase.span / 2));
      // What limits a machine by default, and none of these programs sets: 50 mm/s2 on each axis.
      const [begins, ends] = [0.001, 0.999].map((share) => Math.max(...[0, 1, 2].map((axis) => Math.abs(phase.accel(axis, share * phase.span)))) / 50);
      assert.ok(Math.abs(phase.load - Math.max(begins, ends)) < 0.01, `row ${row}: ${phase.load}, and ${begins} to ${ends}`);
      compared++;
    }
    assert.ok(Math.abs(motion.topSpeed / highest - 1) < 0.02, `${motion.topSpeed} and ${highest} mm/s`);
    assert.ok(TONES.speed.key(motion).high.startsWith(String(Math.round(10 * motion.topSpeed) / 10)));
    assert.ok(compared > 0);
  });

  test(`${name}: the curves go through what the axes do, at ${INSTANTS} instants`, () => {
    const { motion } = made(program);
    const random = numbers(5);
    const highest = [0, 1, 2].map((quantity) => {
      const values = Array.from({ length: motion.length }, (_, row) => Math.max(...[0, 1, 2].map((axis) => Math.abs(ofAxis(motion, row, axis, motion.from(row) + 1e-9)[quantity]))));
      return values.reduce((most, value) => Math.max(most, value), 1);
    });
    let compared = 0;
    for (let look = 0; look < 20; look++) {
      const first = Math.floor(random() * motion.length);
      const last = Math.min(first + 200, motion.length - 1);
      const [from, to] = [motion.from(first), motion.to(last)];
      const charts = samples(motion, from, to);
      for (let instant = 0; instant < INSTANTS / 20; instant++) {
        const time = from + random() * (to - from);
        const row = motion.rowAt(time);
        // Where accelerations jump a curve is upright.
        const isEdge = time - motion.from(row) < 1e-5 || Math.abs(motion.to(row) - time) < 1e-5;
        if (isEdge || motion.read(row).isHoming) continue;
        CHARTS.forEach(({ quantity, axes }, chart) => {
          if (axes.some((axis) => axis >= motion.axes)) return;
          axes.forEach((axis, line) => {
            const is = time < motion.to(row) ? ofAxis(motion, row, axis, time)[quantity] : 0;
            const shown = between(charts[chart][0], charts[chart][line + 1], time);
            assert.ok(Math.abs(shown - is) < 0.005 * highest[quantity], `${time} s, axis ${axis}, quantity ${quantity}: ${is} is drawn as ${shown}`);
            compared++;
          });
        });
      }
    }
    assert.ok(compared > INSTANTS, `${compared}`);
  });

  test(`${name}: the curves of equal parts of the time have the lowest and highest values of the motion there, at any zoom`, () => {
    const { motion } = made(program);
    const [begin, end] = [Array.from({ length: motion.length }, (_, row) => row).find((row) => !motion.read(row).isHoming), motion.end];
    const quantities = ["speed", "accel", "jerk"];
    const most = [0, 0, 0].map(() => [0, 0, 0]);
    for (const [from, count] of [[motion.from(begin), 20], [motion.from(begin), 1_200], [(motion.from(begin) + end) / 2, 100]]) {
      const bins = motion.envelope.bins(from, end, count);
      const found = Array.from({ length: count }, () => quantities.map(() => [0, 1, 2].map(() => [Infinity, -Infinity])));
      const see = (time, row) => {
        const bin = bins.at(time);
        if (bin < 0 || bin >= count) return;
        for (let axis = 0; axis < 3; axis++) {
          const at = ofAxis(motion, row, axis, time);
          quantities.forEach((_, quantity) => {
            const range = found[bin][quantity][axis];
            [range[0], range[1]] = [Math.min(range[0], at[quantity]), Math.max(range[1], at[quantity])];
            most[quantity][axis] = Math.max(most[quantity][axis], Math.abs(at[quantity]));
          });
        }
      };
      for (let row = begin; row < motion.length; row++) {
        const spanS = motion.to(row) - motion.from(row);
        const points = Math.ceil(INSTANTS / 20 + (spanS / bins.width) * 20);
        for (let point = 0; point <= points; point++) see(motion.from(row) + (spanS * point) / points, row);
      }
      let seen = 0;
      for (let bin = 0; bin < count; bin++) {
        quantities.forEach((name, quantity) => {
          for (let axis = 0; axis < 3; axis++) {
            const [low, high] = found[bin][quantity][axis];
            if (low > high) continue;
            const room = 0.02 * most[quantity][axis] + 1e-3;
            const [drawnLow, drawnHigh] = [false, true].map((isHigh) => bins.value(bin, axis, quantity, isHigh));
            const words = `${name} of axis ${axis} in part ${bin} of ${count}: ${low} to ${high} is drawn from ${drawnLow} to ${drawnHigh}`;
            assert.ok(drawnLow <= low + 1e-3 * (1 + Math.abs(low)) && drawnHigh >= high - 1e-3 * (1 + Math.abs(high)), words);
            // What is drawn is reached, but for rests, which are no phases, and for parts of which instants see too little.
            assert.ok(drawnLow >= Math.min(low, 0) - room && drawnHigh <= Math.max(high, 0) + room, words);
            seen++;
          }
        });
      }
      assert.ok(seen > 60, `${seen} ranges`);
    }
    assert.ok(most.every((axes) => Math.max(...axes) > 1 || axes === most[2]), `${most}`);
  });

  test(`${name}: a machine that reports its line and place is found where it is on its path`, () => {
    const { motion } = made(program, { kept: "plan" });
    const plan = { motion, beginsS: (line) => motion.timeOf(line), endsS: (line) => motion.timeBehind(line) ?? motion.end };
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
  for (let row = 0; row < motion.length; row++) if (!motion.read(row).isHoming) highestMm = Math.max(highestMm, motion.read(row).place(2, 0));
  return { modes: said("GC").split(" "), length: Number(said("TLO")), placeMm: summary.position_mm, highestMm, isInches: false };
}

for (const name of ["parking.nc", "arcs.nc", "engraving.nc"]) {
  test(`${name}: the rest from a line on goes where the whole goes`, async () => {
    const lines = (await readFile(at(`../../programs/${name}`), "utf8")).split("\n");
    const settings = "$341=0\n";
    const whole = made(lines.join("\n"), { settings, kept: "plan" });
    let begun = 0;
    for (let line = 7; line < lines.length; line += 3) {
      const left = leftBefore(lines, line);
      if (whyNotFrom(lines, line) || whyNotAfter(lines, line, left)) continue;
      const { text } = restFrom(lines, line, left);
      assert.deepEqual(text.split("\n").slice(line - 1), lines.slice(line - 1), "lines keep their numbers");
      const rest = made(text, { settings, kept: "plan" });
      assert.deepEqual(rest.summary.refusals, [], `from line ${line}: ${text}`);
      let moved = 0;
      for (let each = line; each <= lines.length; each++) {
        const [one, other] = [whole, rest].map(({ motion }) => motion.timeOf(each));
        if (one === undefined || other === undefined) continue;
        // The first one begins at rest, where the whole goes round a corner.
        if (++moved <= 2) continue;
        const [there, here] = [whole.motion.places(one), rest.motion.places(other)];
        there.forEach((mm, axis) => assert.ok(Math.abs(mm - here[axis]) < 0.05, `from line ${line}, line ${each}: ${there} and ${here}`));
      }
      rest.summary.position_mm.forEach((mm, axis) => assert.ok(Math.abs(mm - whole.summary.position_mm[axis]) < 0.021, `from line ${line}: ends at ${rest.summary.position_mm}`));
      begun++;
    }
    assert.ok(begun > 4, `${begun} lines`);
  });
}

test("a program does not go on with an arc, a cycle or an inverse time of a line before, wherever the line that does stands", () => {
  const lines = ["G21 G90 F600", ...Array.from({ length: 8 }, () => "G1 X1"), "G81 X2 Z-1 R1", "(here)", "F700", "X3", "G80", "G1 X4"];
  const left = (motion) => ({ modes: [motion, "G21", "G90", "G94", "F600"], length: 0, placeMm: [0, 0, 0], highestMm: 0, isInches: false });
  assert.match(whyNotAfter(lines, 11, left("G81")), /^Line 13 goes on with G81/);
  assert.match(whyNotAfter(lines, 13, left("G2")), /^Line 13 goes on with G2/);
  assert.equal(whyNotAfter(lines, 11, left("G1")), "");
  assert.equal(whyNotAfter(lines, 14, left("G81")), "");
  assert.match(whyNotAfter(lines, 9, { ...left("G1"), modes: ["G1", "G93"] }), /inverse time \(G93\)/);
});

test("the tool's power is drawn as what it is given: grey where it is off, and in eighths of the scale", () => {
  const { motion } = made("G21 G91 G61\nM3 S700\nG1 X10 F600\nS130\nX10\nM5\nX10\n", { settings: "$30=1000\n" });
  const names = [0, 10, 20].map((fromMm) => {
    const found = new Set();
    for (let row = 0; row < motion.length; row++) {
      const phase = motion.read(row);
      const middleMm = (phase.place(0, 0) + phase.place(0, phase.span)) / 2;
      if (phase.isHoming || middleMm < fromMm || middleMm > fromMm + 10) continue;
      for (const [from, to, rank] of partsOf(TONES.power, motion, row)) if (to - from > 1e-3) found.add(TONES.power.colours[rank]);
    }
    return [...found];
  });
  // Of the scale of eight, from low to high: 0.7 is in the sixth part, 0.13 in the second.
  assert.deepEqual(names, [[TONES.power.scale[5]], [TONES.power.scale[1]], ["bound"]]);
});
