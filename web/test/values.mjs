// What the page makes of what a machine says, without a browser: `node --test values.mjs`. The machine here is a script.
import assert from "node:assert/strict";
import { readdir, readFile } from "node:fs/promises";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const at = (path) => fileURLToPath(new URL(path, import.meta.url));
const MODULES = ["axes", "choice-of-axes", "envelope", "long", "motion", "operate/change", "operate/dialect", "operate/flight", "operate/held", "operate/homed", "operate/machine", "operate/program", "settings/lines", "settings/send", "units", "whatif/becomes", "whatif/scale"];

/** The page's own modules, as a browser gets them. */
async function bundled() {
  const contents = MODULES.map((name) => `export * from "./${name}";`).join("\n");
  const stdin = { contents, resolveDir: at("../src"), loader: "ts" };
  const { outputFiles } = await build({ stdin, bundle: true, format: "esm", target: "es2022", write: false, logLevel: "warning" });
  return import(`data:text/javascript;base64,${Buffer.from(outputFiles[0].contents).toString("base64")}`);
}

// What they ask a browser for. No time passes unless a test says so.
const timers = [];
const ticks = [];
Object.assign(globalThis, { window: { addEventListener() {}, setTimeout: (act) => timers.push(act) }, document: { hidden: false }, setInterval: (act) => ticks.push(act), clearTimeout() {} });
const { askedTool, becomes, changes, differences, FORGOTTEN, factorAt, hasA, HeldJog, Lines, linesOf, Machine, Motion, placeOf, placesInWords, read, realTime, reason, rounded, send, setting, status, tooLong, toolWords, unitInSigns, UNKNOWN, withSettings, written } = await bundled();

const WINDOW_BYTES = 128;
const RESET = 0x18;

/** A machine of the page with a scripted one behind it, which was switched on with it unless a test says otherwise. */
function attached({ isAtPowerUp = true } = {}) {
  const machine = new Machine();
  const board = { machine, lines: [], bytes: [], reported: [] };
  let partial = "";
  const take = (bytes) => {
    for (const byte of bytes) {
      const letter = String.fromCharCode(byte);
      if (byte >= 0x80 || "?!~\x18".includes(letter)) board.bytes.push(byte);
      else if (letter === "\n") board.lines.push(partial), (partial = "");
      else partial += letter;
    }
  };
  let toPage;
  machine.watch({ alarmed: (words) => words && board.reported.push(words) });
  machine.attach((listener) => ((toPage = listener), { send: take, close() {} }), isAtPowerUp);
  board.say = (...lines) => toPage.bytes(new TextEncoder().encode(lines.map((line) => `${line}\r\n`).join("")));
  /** Sends a line, which is answered so. */
  board.answers = (line, ...answer) => {
    machine.ask(line, () => undefined);
    assert.equal(board.lines.at(-1), line);
    board.say(...answer);
  };
  /** Bytes of the lines that were sent, with their ends. */
  board.sentBytes = (from = 0) => board.lines.slice(from).reduce((sum, line) => sum + line.length + 1, 0);
  return board;
}

test("128 bytes are under way and no more, as many lines as fit", () => {
  const { machine, lines, say, sentBytes } = attached();
  const line = "G1 X12.34 F1200"; // 16 bytes with its end.
  const answered = [];
  for (let number = 0; number < 20; number++) machine.ask(line, (answer) => answered.push(answer));
  assert.equal(lines.length, 8);
  assert.equal(sentBytes(), WINDOW_BYTES);
  say("ok");
  assert.equal(lines.length, 9, "an answer makes room for one of them");
  say("error:20", "ok", "<Run|MPos:1.000,0.000,0.000|FS:1200,0>", "[MSG:words]");
  assert.equal(lines.length, 11, "an error does too, and nothing else does");
  assert.deepEqual(answered, ["ok", "error:20", "ok"]);
  assert.equal(machine.underWay, 17);
});

test("a line goes as soon as it just fits, its end counted", () => {
  const { machine, lines, say } = attached();
  const ask = (length) => machine.ask("(".repeat(length), () => undefined);
  ask(99);
  ask(27); // 100 and 28 bytes are 128.
  assert.equal(lines.length, 2);
  ask(0); // Even the end of a line is too much now.
  assert.equal(lines.length, 2);
  say("ok");
  assert.equal(lines.length, 3);
  ask(98); // 28 and 1 and 99 bytes are 128.
  assert.equal(lines.length, 4);
});

test("a line longer than the window goes when no other is under way, and none goes beside it", () => {
  const { machine, lines, say } = attached();
  for (const length of [10, 200, 3]) machine.ask("(".repeat(length), () => undefined);
  assert.deepEqual(lines.map(({ length }) => length), [10]);
  say("ok");
  assert.deepEqual(lines.map(({ length }) => length), [10, 200]);
  say("error:11");
  assert.deepEqual(lines.map(({ length }) => length), [10, 200, 3]);
});

test("real-time bytes wait for nothing and take no room", () => {
  const { machine, lines, bytes } = attached();
  machine.ask("(".repeat(126), () => undefined);
  for (const byte of [0x21, 0x7e, 0x85, 0x3f]) machine.byte(byte);
  assert.deepEqual(bytes, [0x21, 0x7e, 0x85, 0x3f]);
  machine.ask("", () => undefined);
  assert.equal(lines.length, 2, "127 bytes and 1");
});

test("a reset forgets what was under way, and the window is empty after it", () => {
  const { machine, lines, say, sentBytes } = attached();
  const answered = [];
  for (let number = 0; number < 20; number++) machine.ask("G1 X12.34 F1200", (answer) => answered.push(answer));
  machine.byte(RESET);
  say("Grbl 1.1h ['$' for help]");
  assert.deepEqual(answered, Array(20).fill(FORGOTTEN));
  assert.equal(lines[8], "$$", "the settings are read anew");
  for (let number = 0; number < 20; number++) machine.ask("G1 X12.34 F1200", () => undefined);
  assert.equal(sentBytes(8), 3 + 7 * 16, "125 bytes");
});

test("what a line prints is given to who asked, and to nobody else", () => {
  const { machine, say } = attached();
  const [said, queried] = [[], []];
  machine.watch({ logged: (line) => said.push(line) });
  machine.ask("G0 X1", () => undefined);
  machine.query("$G", (printed, answer) => queried.push(printed, answer));
  say("[MSG:of the first]", "ok", "[GC:G0 G54]", "<Idle|MPos:0.000,0.000,0.000|FS:0,0>", "ok", "[MSG:of nobody]");
  assert.deepEqual(queried, [["[GC:G0 G54]"], "ok"]);
  assert.deepEqual(said, ["[MSG:of the first]", "[MSG:of nobody]"]);
});

test("a setting that another page has changed is known", () => {
  const { machine, say } = attached();
  const known = [];
  machine.watch({ set: () => known.push(machine.settings.get(110)) });
  say("$110=2000.000", "[MSG:$111=1]");
  assert.deepEqual(known, ["2000.000"]);
});

const report = (state) => `<${state}|MPos:0.000,0.000,0.000|FS:0,0>`;

test("in a change of the tool the lines of a person are by hand, and those of the program wait", () => {
  const { machine, lines, bytes, say } = attached();
  const answered = [];
  const program = (line) => machine.askOfProgram(line, (answer) => answered.push(`${line} ${answer}`));
  const person = (line) => machine.ask(line, (answer) => answered.push(`${line} ${answer}`));
  program("M6 T2");
  program("G0 X1");
  say("[MSG:M6: put in tool 2, measure it ($TPW), then ~]", "ok", report("Tool"));
  assert.ok(machine.isChanging && machine.waitsForTool);
  program("G0 X2");
  assert.deepEqual([lines.length, bytes], [3, []], "nothing is by hand before somebody sends something");
  person("$J=G91 X1 F100");
  person("$TPW");
  program("G0 X3");
  assert.deepEqual(bytes, [0xa3], "once");
  assert.equal(lines.at(-1), "$TPW", "a line of the program would be taken for one by hand");
  assert.equal(machine.waitsForTool, false, "a resume would not be heard");
  say("ok", report("Jog"), "error:47");
  assert.ok(machine.isChanging);
  say(report("Tool"));
  assert.ok(machine.waitsForTool);
  assert.deepEqual(answered, ["M6 T2 ok", "$J=G91 X1 F100 ok", "$TPW error:47"]);
  machine.byte(0x7e);
  say(report("Run"));
  assert.equal(lines.at(-1), "G0 X3", "the program goes on");
  say("ok", "ok", "error:20");
  assert.deepEqual(answered.slice(3), ["G0 X1 ok", "G0 X2 ok", "G0 X3 error:20"]);
  person("$G");
  assert.deepEqual(bytes, [0xa3, 0x7e]);
});

test("a hold in a change of the tool is in it, and each change has a byte of its own", () => {
  const { machine, bytes, say } = attached();
  machine.ask("G0 X1", () => undefined);
  say("ok", report("Tool"));
  machine.ask("$G", () => undefined);
  say("ok", report("Door:1"), report("Hold:0"), report("Tool"));
  machine.ask("$G", () => undefined);
  say("ok", report("Idle"), report("Tool"));
  machine.ask("$G", () => undefined);
  assert.deepEqual(bytes, [0xa3, 0xa3]);
});

test("a reset in a change of the tool forgets the lines by hand too, and what comes next is not by hand", () => {
  const { machine, lines, bytes, say } = attached();
  const answered = [];
  say(report("Tool"));
  machine.ask("$TPW", (answer) => answered.push(answer));
  machine.askOfProgram("G0 X1", (answer) => answered.push(answer));
  machine.byte(RESET);
  say("Grbl 1.1h ['$' for help]");
  assert.deepEqual(answered, [FORGOTTEN, FORGOTTEN]);
  machine.ask("G0 X2", () => undefined);
  assert.deepEqual([bytes, lines], [[0xa3, RESET], ["$TPW", "$$", "G0 X2"]]);
});

test("the tool that is asked for is named with the comment of the program", () => {
  assert.equal(askedTool("[MSG:M6: put in tool 12, then resume with ~]"), 12);
  assert.equal(askedTool("[MSG:M6: change the tool, then resume with ~]"), 0);
  assert.equal(askedTool("[MSG:M6: the tool was not measured ($TPW)]"), undefined);
  assert.equal(toolWords(2, "6 mm end mill"), "tool 2: 6 mm end mill");
  assert.equal(toolWords(2), "tool 2");
  assert.equal(toolWords(0), "another tool");
});

test("an error is explained in the machine's words, which are asked for once", () => {
  const { machine, lines, say } = attached();
  const reported = [];
  machine.explain("error:22", (words) => reported.push(words));
  say("[MSG:no feed: give F]", "ok");
  machine.explain("error:22", (words) => reported.push(words));
  assert.deepEqual(reported, Array(2).fill("error:22: no feed: give F"));
  assert.deepEqual(lines, ["$E22"]);
});

/** What is homed after each alarm of docs/console.md, if all axes were before it. */
const HOMED_AFTER = { 1: "no", 2: "yes", 3: "no", 4: "yes", 5: "yes", 6: "no", 7: "no", 8: "no", 9: "no", 10: "no", 14: "no", 15: "no", 17: "no", 19: "no", 20: "no", 21: "yes", 22: "no", 23: "no", 24: "no" };

test("what is homed after each alarm is what the documentation says of it", async () => {
  const page = await readFile(at("../../docs/console.md"), "utf8");
  const alarms = page.slice(page.indexOf("| alarm |"), page.indexOf("## States"));
  const rows = [...alarms.matchAll(/^\| (\d+) \|.*\| ((?:not )?trusted)[^|]*\|$/gm)];
  const documented = Object.fromEntries(rows.map(([, alarm, position]) => [alarm, position === "trusted" ? "yes" : "no"]));
  assert.deepEqual(HOMED_AFTER, documented);
  for (const [alarm, homed] of Object.entries(HOMED_AFTER)) {
    const { machine, answers, say, reported } = attached();
    answers("$H", "ok");
    assert.equal(machine.homed.words, "yes");
    say(`ALARM:${alarm}`, "[MSG:its words]");
    assert.deepEqual(reported, [`ALARM:${alarm}`, `ALARM:${alarm}: its words`]);
    assert.equal(machine.homed.words, homed, `ALARM:${alarm}`);
    assert.deepEqual(["X", "Y", "Z"].map((axis) => machine.homed.has(axis)), Array(3).fill(homed === "yes"), `ALARM:${alarm}`);
    answers("$X", "[MSG:Caution: Unlocked]", "ok");
    assert.equal(machine.homed.words, homed, "to unlock homes nothing");
    answers("$H", "ok");
    assert.equal(machine.homed.words, "yes");
  }
});

test("an axis is homed by its own line, if that was not refused", () => {
  const { machine, answers } = attached();
  answers("$HY", "ok");
  answers("$hx", "ok");
  answers("$HZ", "error:9");
  assert.equal(machine.homed.words, "X, Y only");
  answers("$HZ", "ok");
  assert.equal(machine.homed.words, "yes");
  answers("$SLP", "ok");
  assert.equal(machine.homed.words, "no", "motors that were free may have been turned");
});

test("an axis whose steps or switch are others is homed no more, whoever has set that", () => {
  const { machine, answers, say } = attached();
  const lost = "[MSG:what the position of X Z means has changed: home again with $H]";
  answers("$H", "ok");
  answers("$27=3", "ok");
  answers("$RST=#", "ok");
  assert.equal(machine.homed.words, "yes");
  machine.query("$RST=$", () => undefined);
  say(lost, "ok");
  assert.equal(machine.homed.words, "Y only");
  answers("$H", "ok");
  say(lost);
  assert.equal(machine.homed.words, "Y only");
});

test("a reset of the page, by its byte or a line, keeps what is homed, and a welcome that nobody has asked for leaves it unknown", () => {
  const welcome = "Grbl 1.1h ['$' for help]";
  const { machine, answers, say } = attached();
  answers("$H", "ok");
  machine.byte(RESET);
  say(welcome, "ok");
  assert.equal(machine.homed.words, "yes");
  answers("$RST=#", "[MSG:Restoring defaults]", "ok", welcome, "ok");
  assert.equal(machine.homed.words, "yes");
  answers("$C", "[MSG:Enabled]", "ok", "<Check|MPos:0.000,0.000,0.000|FS:0,0>");
  answers("$C", "[MSG:Disabled]", "ok", welcome, "ok");
  assert.equal(machine.homed.words, "yes");
  say(welcome, "ok");
  assert.equal(machine.homed.words, "unknown");
  assert.equal(attached({ isAtPowerUp: false }).machine.homed.words, "unknown");
  assert.equal(attached().machine.homed.words, "no");
});

test("a report adds to what the last one reported", () => {
  const first = status("<Run|WPos:7.000,0.000,-1.500|FS:600,500|WCO:3.000,0.000,1.000|Ov:90,50,110|A:SF|Pn:XP|Bf:12,100|Ln:7>", UNKNOWN);
  assert.deepEqual(first, {
    state: "Run", machinePosition: [10, 0, -0.5], workPosition: [7, 0, -1.5], offset: [3, 0, 1], feed: 600, spindle: 500,
    pins: "XP", overrides: [90, 50, 110], accessories: "SF", room: [12, 100], line: 7, homedMask: undefined,
  });
  const second = status("<Hold:1|MPos:11.000,2.000,0.000|FS:0,0>", first);
  assert.deepEqual(second, { ...first, state: "Hold:1", machinePosition: [11, 2, 0], workPosition: [8, 2, -1], feed: 0, spindle: 0, pins: "", room: undefined, line: undefined });
  assert.equal(status("<Idle|MPos:0.000,0.000,0.000|Ov:100,100,100>", second).accessories, "", "it comes with the overrides, if anything is on");
  assert.equal(status("<Idle|MPos:0.000", second), undefined);
});

test("lines come in any pieces", () => {
  const lines = new Lines();
  const heard = ["o", "k\r", "\n<Idle|MPos:1.0", "00,0.000,0.000>\r\nerror:2", "\n"].flatMap((piece) => lines.push(new TextEncoder().encode(piece)));
  assert.deepEqual(heard, ["ok", "<Idle|MPos:1.000,0.000,0.000>", "error:2"]);
});

test("a program's lines go without comments, with their numbers where there is room and none of its own", () => {
  const sent = (program) => linesOf(program).map(({ sent }) => sent);
  assert.deepEqual(sent("G21 ; mm\r\n(all)\n%\nG1 X1 (fast) F600\n$H\n"), ["N1 G21", "%", "N4 G1 X1  F600", "$H"]);
  assert.deepEqual(sent("N10 G0 X1\nG0 X2"), ["N10 G0 X1", "G0 X2"]);
  const long = `G1 ${"X1".repeat(38)}`; // 78 characters, which N1 makes 80.
  assert.deepEqual(sent(long), [long]);
  assert.equal(realTime(linesOf("G0 X1\nG0 X2 !\n")).number, 2);
});

test("settings are read from whatever stands about them, and those that are in force are left out", () => {
  const wanted = read("$100=250.000 ; x\n$$\nok\n$110=500\n$100 = 80\n<Idle>\n");
  assert.deepEqual([...wanted], [[100, "80"], [110, "500"]]);
  assert.deepEqual(changes(new Map([[100, "80.000"], [110, "600.000"]]), wanted), [[110, "500"]]);
  assert.deepEqual(setting("$13=1"), [13, "1"]);
  assert.equal(setting("$N0=G54"), undefined);
  assert.deepEqual(differences([{ number: 1, default: "25" }, { number: 2, default: "0" }], new Map([[1, "25.000"], [2, "4"]])), [[2, "4"]]);
});

test("settings go one by one, a refusal is reported in the machine's words, and so is what the last one left", async () => {
  const { machine, lines, say } = attached();
  const answers = { "$20=1": ["[MSG:Soft limits need homing: locked until $22=1]", "ok"], "$30=0": ["[MSG:$30 is 1 to 100000]", "error:3"], "$5=9": ["error:2"], "$E2": ["[MSG:not a number]", "ok"], "$22=1": ["[MSG:Settings work together again]", "ok"] };
  const sent = send(machine, [[20, "1"], [30, "0"], [5, "9"], [22, "1"]]);
  for (const expected of Object.keys(answers)) {
    assert.equal(lines.at(-1), expected, "each waits for the answer to the one before");
    say(...answers[expected]);
    await new Promise(setImmediate);
  }
  assert.deepEqual(await sent, {
    taken: [20, 22],
    refused: new Map([[30, "$30 is 1 to 100000"], [5, "error:2: not a number"]]),
    remark: "Settings work together again",
  });
  assert.deepEqual(lines, Object.keys(answers));
  assert.equal(machine.settings.get(20), "1");
});

test("the page's modules exist, and so does what its worker asks the machine for", async () => {
  const entryPoints = ["main", "worker"].map((name) => at(`../src/${name}.ts`));
  const options = { bundle: true, splitting: true, outdir: at("out"), format: "esm", write: false, external: ["*/machine/machine.js"], logLevel: "warning" };
  const { outputFiles } = await build({ entryPoints, ...options });
  const imports = /import\s+(?:\w+,\s*)?\{([^}]*)\}\s+from\s+"[^"]*machine\.js"/g;
  const asked = outputFiles.flatMap(({ text }) => [...text.matchAll(imports)]).flatMap(([, names]) => names.split(",").map((name) => name.trim().split(" ")[0]));
  const folder = at("../../crates/web/src");
  const sources = await Promise.all((await readdir(folder)).map((name) => readFile(`${folder}/${name}`, "utf8")));
  const exported = /#\[wasm_bindgen(?:\(js_name = (\w+)\))?\]\n(?:pub )?(?:fn|struct) (\w+)/g;
  const given = sources.flatMap((text) => [...text.matchAll(exported)]).map(([, renamed, name]) => renamed ?? name);
  assert.ok(asked.length > 8, asked.join());
  assert.deepEqual(asked.filter((name) => !given.includes(name)), []);
});

/** Phases of a whole piece: see `piece` in crates/web. */
const PHASES = 4_096;

/** A motion of so many axes in phases of random lengths, with a pause now and then, from a number. */
function randomMotion(axes, phases, seed) {
  let state = seed;
  const random = () => ((state = (state * 1_103_515_245 + 12_345) % 2_147_483_648) / 2_147_483_648);
  const rows = [];
  let [time, pause, values] = [0, 0, Array.from({ length: axes }, () => ({ place: 0, speed: 0, accel: 0 }))];
  for (let phase = 0; phase < phases; phase++) {
    const span = random() < 0.1 ? 5 * random() + 0.01 : 0.02 * random() + 1e-4;
    const ends = values.map(() => (phase % 7 === 6 ? 0 : 400 * random() - 200));
    rows.push({ time, pause, end: time + span, kind: 1 + (phase % 3), values, changes: values.map(({ accel }, axis) => ends[axis] - accel) });
    values = values.map((value, axis) => after(value, ends[axis], span));
    time += span;
    pause = random() < 0.05 ? random() : 0;
    time += pause;
    if (pause) values = values.map(({ place }) => ({ place, speed: 0, accel: 0 }));
  }
  const motion = new Motion();
  for (let from = 0; from < phases; from += PHASES) motion.add(pieceOf(rows.slice(from, from + PHASES), axes));
  return motion;
}

/** Where an axis is at the end of a phase, in which its acceleration becomes another. */
function after({ place, speed, accel }, end, span) {
  const change = end - accel;
  return { place: place + span * (speed + span * (accel / 2 + change / 6)), speed: speed + span * (accel + change / 2), accel: end };
}

/** Phases as the machine gives them: what is the same throughout is one number. */
function pieceOf(rows, axes) {
  const column = (kind, of) => kind.from(rows.every((row) => of(row) === of(rows[0])) ? [of(rows[0])] : rows.map(of));
  const ofAxis = (axis) => {
    const [places, speeds, accels] = ["place", "speed", "accel"].map((name) => column(Float32Array, ({ values }) => values[axis][name]));
    return { places, speeds, accels, changes: column(Float32Array, ({ changes }) => changes[axis]) };
  };
  return {
    phases: rows.length, end: rows.at(-1).end, begins: column(Float64Array, ({ time }) => time), pauses: column(Float64Array, ({ pause }) => pause), kinds: column(Uint8Array, ({ kind }) => kind),
    ofAxes: Array.from({ length: axes }, (_, axis) => ofAxis(axis)), loads: Uint16Array.of(0), jumps: Uint16Array.of(0), asked: Float32Array.of(0), powerTimes: new Float64Array(), powers: new Float32Array(),
  };
}

/** Speeds of an axis at the ends of its phases within a part of time. */
function speedsAtEnds(motion, axis, from, to) {
  const speeds = [];
  for (let row = Math.max(0, motion.rowAt(from)); row < motion.length && motion.from(row) < to; row++) {
    const ends = [Math.max(from, motion.from(row)), Math.min(to, motion.to(row))].filter((time) => time >= motion.from(row));
    speeds.push(...ends.map((time) => motion.read(row).speed(axis, time - motion.from(row))));
  }
  return speeds;
}

/** What an axis does at a time: speed, acceleration and jerk; at rest 0. */
function axisAt(motion, axis, time) {
  const row = motion.rowAt(time);
  if (row < 0 || time > motion.to(row)) return [0, 0, 0];
  const phase = motion.read(row);
  const after = time - phase.from;
  return [phase.speed(axis, after), phase.accel(axis, after), phase.jerk(axis)];
}

test("curves of a long run are those of its motion, at every zoom", () => {
  for (const [axes, seed] of [[3, 1], [3, 2], [4, 3], [4, 4]]) {
    const motion = randomMotion(axes, 5_000, seed);
    assert.equal(motion.axes, axes);
    for (const [from, to] of [[0, motion.end], [motion.end * 0.4, motion.end * 0.5], [motion.end * 0.7, motion.end * 0.701]]) {
      const bins = motion.envelope.bins(from, to, 1_000);
      let [values, flat] = [0, 0];
      for (let bin = 0; bin < bins.count; bin++) {
        for (let axis = 0; axis < axes; axis++) {
          const within = Array.from({ length: 9 }, (_, part) => axisAt(motion, axis, from + (bin + (part + 0.5) / 9) * bins.width));
          for (const quantity of [0, 1, 2]) {
            const [low, high] = [false, true].map((isHigh) => bins.value(bin, axis, quantity, isHigh));
            const room = 1e-3 * (1 + Math.abs(low) + Math.abs(high));
            for (const at of within) assert.ok(at[quantity] >= low - room && at[quantity] <= high + room, `seed ${seed}, bin ${bin}: ${at[quantity]} is not in ${low}..${high}`);
            values += Math.max(Math.abs(low), Math.abs(high));
            flat += high === low ? 1 : 0;
            // Nothing is shown that is not there: the extremes of speed are those of its instants, but for what changes between two, and short rests.
            if (quantity > 0 || high === 0) continue;
            const begins = from + bin * bins.width;
            const speeds = [...within.map(([speed]) => speed), ...speedsAtEnds(motion, axis, begins, begins + bins.width)];
            assert.ok(high - Math.max(...speeds) <= (200 * bins.width) / 9 + room, `seed ${seed}, bin ${bin}: ${high} is never reached`);
          }
        }
      }
      assert.ok(values > 1_000 && flat < 9_000, "the curves are not flat");
    }
  }
});

test("places of a rotary axis are degrees, and not mm", () => {
  const places = ["1.00", "-2.00", "0.00", "90.00"].map((words, axis) => ({ axis, words }));
  assert.equal(placesInWords(places, true), "X 1.00, Y -2.00, Z 0.00 mm, A 90.00 degrees");
  assert.equal(placesInWords(places, false), "X 1.00, Y -2.00, Z 0.00, A 90.00 mm");
  assert.equal(placesInWords(places.slice(0, 3), true), "X 1.00, Y -2.00, Z 0.00 mm");
  assert.equal(placesInWords([], true), "");
});

test("a machine with A is wanted for words of A, and for no comment, name or function", () => {
  for (const line of ["G1 X1 A90", "g0a-4.5", "G1 A [#1 + 2]", "A#<angle>", "N7 G91 A.5"]) assert.ok(hasA(line), line);
  for (const line of ["G1 X1 (A90)", "X1 ; A90", "$A1", "X[ABS[-2]]", "X[ATAN[1]/[2]]", "X#<a1>", "G42 X1"]) assert.ok(!hasA(line), line);
});

test("with inches a rotary axis is in degrees all the same", () => {
  const { machine, say } = attached();
  say("Grbl 1.1h ['$' for help]", "$13=1", "$103=50.000", "ok", "<Idle|MPos:1.0000,0.0000,0.0000,10.000|FS:0.0,0>");
  assert.deepEqual(machine.inMm(machine.report.machinePosition), [25.4, 0, 0, 10]);
  say("$376=0");
  assert.deepEqual(machine.inMm(machine.report.machinePosition), [25.4, 0, 0, 254]);
});

test("a letter beyond ASCII is refused as what acts at once, unless a comment has it", () => {
  const refused = (program) => realTime(linesOf(program))?.number;
  assert.equal(refused("G0 X1\nG0 X2 Ä\n"), 2, "its second byte is that of the safety door");
  assert.equal(refused("G0 X1 (Länge)\nG0 X2 ; Größe\n"), undefined);
  assert.equal(refused("G0 X1\nG0?\n"), 2);
});

test("a link that is lost or silent is told as that, and nothing of before is shown as if it were so", (context) => {
  const { machine, say } = attached();
  const links = [];
  machine.watch({ linked: (link, words) => links.push([link, words]) });
  say("Grbl 1.1h ['$' for help]", "<Run|MPos:1.000,2.000,3.000|FS:600,0>");
  assert.deepEqual([machine.link, machine.mayMove, machine.report.machinePosition], ["connected", true, [1, 2, 3]]);
  const clock = { ms: performance.now() };
  context.mock.method(performance, "now", () => clock.ms);
  const passes = (ms) => ((clock.ms += ms), ticks.at(-1)());
  passes(60_000);
  assert.equal(machine.link, "connected", "a page that has slept has not asked");
  // Nothing comes for 3 s.
  for (let tick = 0; tick < 15; tick++) passes(200);
  assert.equal(machine.link, "silent");
  assert.match(links.at(-1)[1], /has not answered for 3 s/);
  say("<Run|MPos:1.500,2.000,3.000|FS:600,0>");
  assert.deepEqual([machine.link, links.at(-1)], ["connected", ["connected", ""]]);
  const logged = [];
  let alarms = 0;
  machine.watch({ logged: (line, kind) => logged.push([line, kind]), alarmed: (words) => (alarms += words ? 1 : 0) });
  machine.detach();
  machine.command("G0 X1");
  assert.deepEqual([machine.link, machine.state, machine.report.machinePosition, alarms], ["none", "Off", [], 0]);
  assert.deepEqual(logged.at(-1), ["not sent, because there is no machine: G0 X1", "wrong"]);
});

test("a machine whose link is lost may still move, and one that never answered is not there", () => {
  const words = [];
  const lost = (heard) => {
    const machine = new Machine();
    let port;
    machine.watch({ linked: (link, why) => words.push(`${link}: ${why}`) });
    machine.attach((listener) => ((port = listener), { send() {}, close() {} }), false);
    if (heard) port.bytes(new TextEncoder().encode("<Run|MPos:0.000,0.000,0.000|FS:600,0>\r\n"));
    port.lost({ line: null, words: "it was unplugged" });
    return machine;
  };
  assert.deepEqual([lost(true).mayMove, lost(false).mayMove], [true, false]);
  const [told, ofNone] = words.filter((why) => !why.endsWith(": "));
  assert.match(told, /^lost: The link to the machine is lost: it was unplugged\. What the machine was told before it may still do/);
  assert.match(ofNone, /^none: There is no link to the machine: it was unplugged/);
});

/** What a held jog asks for on a machine that goes at its feed at once, when the page renews it at these instants, ms. */
function jogged(renewedAtMs, { feed = 1_200, mostMm = 1_000, isHeard = () => true } = {}) {
  const clock = { ms: 0 };
  const now = performance.now;
  performance.now = () => clock.ms;
  try {
    const asked = [];
    const [speedMmPerMs, sum] = [feed / 60_000, () => asked.reduce((mm, line) => mm + Number(/X([-\d.]+)/.exec(line)[1]), 0)];
    let movedMm = 0;
    const report = () => ({ ...UNKNOWN, state: "Jog", machinePosition: [movedMm, 0, 0], feed: movedMm < sum() ? feed : 0 });
    const held = new HeldJog(0, 1, feed, mostMm, report(), false, (line) => asked.push(line));
    const path = [];
    for (let ms = 1; ms <= 12_000; ms++) {
      clock.ms = ms;
      movedMm = Math.min(sum(), movedMm + speedMmPerMs);
      if (!renewedAtMs(ms)) continue;
      if (ms % 200 === 0 && isHeard(ms)) held.report(report());
      if (ms % 40 === 0) held.renew();
      path.push(movedMm);
    }
    return { movedMm, asked, path };
  } finally {
    performance.now = now;
  }
}

test("a held jog goes on while the page lives and hears the machine, and ends by itself otherwise", () => {
  const alive = jogged(() => true);
  assert.ok(Math.abs(alive.movedMm - 240) < 1, `20 mm/s for 12 s is ${alive.movedMm} mm`);
  assert.ok(alive.asked.every((line) => /^\$J=G21 G91 X2\.000 F1200$/.test(line)));
  // The page hangs from 2 s on, for 10 s.
  const hung = jogged((ms) => ms <= 2_000);
  const behind = hung.movedMm - hung.path.at(-1);
  assert.ok(behind > 0 && behind <= 20 * 0.3 + 1e-9, `${behind} mm behind the hang`);
  // The machine is not heard from 2 s on.
  const silent = jogged(() => true, { isHeard: (ms) => ms <= 2_000 });
  assert.ok(silent.movedMm > 40 && silent.movedMm <= 20 * (2 + 0.5 + 0.3) + 1e-9, `${silent.movedMm} mm`);
  const ended = jogged(() => true, { mostMm: 7.5 });
  assert.deepEqual([ended.movedMm, ended.asked.at(-1)], [7.5, "$J=G21 G91 X1.500 F1200"]);
});

test("which axes are homed is what a report says, whoever has homed them", () => {
  const { machine, say } = attached({ isAtPowerUp: false });
  say("<Idle|MPos:0.000,0.000,0.000|FS:0,0>");
  assert.notEqual(machine.homed.words, "yes");
  say("<Idle|MPos:0.000,0.000,0.000|FS:0,0|H:0,5>");
  assert.deepEqual(["X", "Y", "Z"].map((axis) => machine.homed.has(axis)), [true, false, true]);
  say("<Idle|MPos:0.000,0.000,0.000|FS:0,0>", "<Idle|MPos:0.000,0.000,0.000|FS:0,0|H:1,7>");
  assert.equal(machine.homed.words, "yes");
  say("<Alarm|MPos:0.000,0.000,0.000|FS:0,0|H:0,0>");
  assert.equal(machine.homed.words, "no");
});

test("a time that becomes another is told as a clock shows it, and what is shown adds up", () => {
  assert.equal(becomes(519, 372), "8:39 becomes 6:12, 2:27 less (28 %)");
  assert.equal(becomes(518.6, 372.4), "8:39 becomes 6:12, 2:27 less (28 %)");
  assert.equal(becomes(3_599, 7_325), "59:59 becomes 2:02:05, 1:02:06 more (104 %)");
  assert.equal(becomes(61, 59.25), "1:01 becomes 59.250 s, 1.750 s less (3 %)");
  assert.equal(becomes(20, 19.9), "20.000 s becomes 19.900 s, 0.100 s less (0.5 %)");
  assert.equal(becomes(20.0001, 20.0002), "20.000 s, as before");
});

test("settings are put in place of their own lines, and behind all others", () => {
  const text = "; mine\r\n$120=80 (X)\n$110=3000\n$120=90\n\n";
  assert.equal(withSettings(text, [[120, "160"], [904, "0.02"]]), "; mine\n$120=160\n$110=3000\n$904=0.02\n");
  assert.equal(withSettings("", [[11, "0"]]), "$11=0\n");
  assert.equal(withSettings("$1=2", []), "$1=2\n");
  assert.equal(reason("settings:2: `$110=-5`: $110=-5 is negative"), "$110=-5 is negative");
});

test("a slider means a tenth to ten times, in values that the machine reads", () => {
  assert.deepEqual([-1, 0, 1].map((place) => rounded(50 * factorAt(place))), [5, 50, 500]);
  assert.deepEqual([placeOf(1), placeOf(10), placeOf(1e6), placeOf(1e-6)], [0, 1, 1, -1]);
  assert.equal(rounded(50 * factorAt(0.301)), 100);
  assert.deepEqual([100, 0.001, 9e7, 0.0000001].map(written), ["100", "0.001", "90000000", "0"]);
});

test("a line that is too long is named, and one that is as long as may be is not", () => {
  assert.equal(tooLong(`G0\n${"x".repeat(65_536)}\n`), undefined);
  assert.match(tooLong(`G0\n${"x".repeat(65_537)}\n`), /^line 2 has 65,537 characters, and a line has 65,536 at most/);
  assert.match(tooLong("x".repeat(5_000_000)), /^line 1 has 5,000,000/);
  assert.equal(tooLong(""), undefined);
});

test("units are written as people write them", () => {
  const found = ["mm/s2", "degrees/s3", "us", "mm/min", "steps/mm", "mm", ""].map(unitInSigns);
  assert.deepEqual(found, ["mm/s²", "degrees/s³", "µs", "mm/min", "steps/mm", "mm", ""]);
});
