#!/usr/bin/env node
// Drives cncjs like its web page, over HTTP and socket.io: signs in, opens the port, homes, loads programs and runs
// them, holds each of them and resumes it.
//
//     cncjs.mjs INSTALLED PORT PROGRAMS X,Y,Z
//
// INSTALLED is the folder with cncjs in its node_modules. Of the programs in the folder PROGRAMS, parking.nc is held by
// either kind of button on the page, engraving.nc with a laser ($32=1), square.nc with a spindle at S500 ($32=0).
// two_tools.nc is run twice: the page leaves M6 out and stops the program, as it does unless it is told otherwise, and
// it sends M6, which waits ($341=0). The script fails unless the machine stands still in each hold and continues from
// there. A laser must be off while held and on again afterwards; a spindle must keep turning. Every line must be
// answered with ok, and at the end of each program the machine must stand with all outputs off at X,Y,Z mm, or where
// two_tools.nc ends with the length of its last tool.

import { spawn } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:net';
import { createRequire } from 'node:module';
import { join } from 'node:path';

const PATIENCE_MS = 60_000;
const POLL_MS = 50;
/** How often a status report is requested. */
const REPORT_MS = 20;
/** Number of reports requested at rest. Every tenth report says what is on. */
const REPORTS_AT_REST = 12;
const SPINDLE_S = 500;
const TWO_TOOLS = 'two_tools.nc';
/** What cncjs does with M6, by its numbers: it leaves it out and stops the program, or sends it. */
const LEAVES_OUT_M6 = 0;
const SENDS_M6 = 1;
/** The lengths that the tools of two_tools.nc have in the table of tools, and where it ends with the last of them, mm. */
const LENGTHS_MM = new Map([[1, 10], [2, 4]]);
const TWO_TOOLS_END_MM = [20, 20, 29];

if (process.argv.length !== 6) fail('give INSTALLED PORT PROGRAMS X,Y,Z');
const [installed, port, programs, end] = process.argv.slice(2);
const wanted = end.split(',').map(Number);
const require = createRequire(join(installed, 'node_modules', 'cncjs', 'package.json'));
const said = [];
let server;
let address;
let token;

process.on('SIGTERM', () => fail('told to end'));
try {
  await main();
} catch (error) {
  fail(error.message);
}
server.kill();
process.exit(0);

async function main() {
  address = await serve();
  ({ token } = await (await fetch(`${address}/api/signin`, { method: 'POST' })).json());
  const socket = require('socket.io-client')(address, { query: `token=${token}`, transports: ['websocket'] });
  const seen = watch(socket);
  await until('connection', () => socket.connected);
  socket.emit('list');
  await until('list of ports', () => seen.ports.length > 0);
  if (!seen.ports.some((each) => each.port === port)) throw new Error(`cncjs does not offer ${port}, which its .cncrc names`);
  await new Promise((resolve, reject) => socket.emit('open', port, { controllerType: 'Grbl', baudrate: 115200 }, (error) => (error ? reject(new Error(`cncjs cannot open ${port}: ${JSON.stringify(error)}`)) : resolve())));
  await until('settings', () => seen.settings['$132'] !== undefined);
  await until('status Idle', () => seen.state === 'Idle');
  console.log(`connected; ${Object.keys(seen.settings).length} settings read, version ${seen.version}`);

  socket.emit('command', port, 'homing');
  await until('status Home', () => seen.state === 'Home');
  await until('end of homing', () => seen.state === 'Idle');
  console.log(`homed, at ${seen.place}`);

  if (refusals().length > 0) console.log(`refused while connecting: ${refusals()}`);
  await changeTools(socket, seen);
  await park(socket, seen);
  await engrave(socket, seen);
  await mill(socket, seen);
  await new Promise((resolve) => socket.emit('close', port, resolve));
}

async function changeTools(socket, seen) {
  await set(socket, seen, '$341', '0');
  for (const [tool, mm] of LENGTHS_MM) await answered(socket, `G10 L1 P${tool} Z${mm}`);
  await changeToolsBy(socket, seen, LEAVES_OUT_M6, async (tool) => {
    await stoppedByPage(seen, tool);
    await until('answers to what was sent', () => seen.sender.received === seen.sender.sent);
    const idle = await reported(socket, 'Idle behind them', (report) => report.startsWith('<Idle|'));
    checkTool(`at the stop for tool ${tool}`, await restReports(socket, said.indexOf(idle)), 0);
    socket.emit('command', port, 'gcode:resume');
  });
  await changeToolsBy(socket, seen, SENDS_M6, async (tool, begin) => {
    const isTold = () => said.slice(begin).some((line) => line.startsWith(`[MSG:M6: put in tool ${tool},`));
    await until(`prompt for tool ${tool}`, isTold);
    await waitsForPerson(socket, `tool ${tool}`);
    socket.emit('command', port, 'cyclestart');
  });
  // The tool is in the spindle, so this waits for nobody.
  await answered(socket, 'M6 T2');

  // The other programs begin without all that.
  for (const line of ['G10 L2 P1 X0 Y0 Z0', 'G49']) await answered(socket, line);
}

/** Runs two_tools.nc with cncjs set to one of its ways to change tools, and `change` for each tool. */
async function changeToolsBy(socket, seen, toolChangePolicy, change) {
  const headers = { 'Content-Type': 'application/json', Authorization: `Bearer ${token}` };
  const body = JSON.stringify({ toolChangePolicy });
  const set = await fetch(`${address}/api/tool`, { method: 'POST', headers, body });
  if (!set.ok) throw new Error(`cncjs does not take ${body}: ${set.status}`);
  const begin = said.length;
  const changeAll = async () => {
    for (const tool of LENGTHS_MM.keys()) await change(tool, begin);
  };
  await run(socket, seen, TWO_TOOLS, source(TWO_TOOLS), changeAll, TWO_TOOLS_END_MM);
  await checkLength(socket);
}

/** Waits until cncjs has stopped the program at M6 by itself. */
async function stoppedByPage(seen, tool) {
  const isStop = ({ data, msg }) => data === 'M6' && msg.startsWith(`T${tool} M6`);
  await until(`stop for tool ${tool}`, () => seen.workflow === 'paused' && isStop(seen.sender.holdReason ?? {}));
  console.log(`the page stopped at ${seen.sender.holdReason.msg}`);
}

/** Waits until the machine waits in M0 or M6, with everything off. */
async function waitsForPerson(socket, what) {
  const held = await reported(socket, `Hold:0 for ${what}`, (report) => report.startsWith('<Hold:0|'));
  checkTool(`in the wait for ${what}`, await restReports(socket, said.indexOf(held)), 0);
  console.log(`waits for ${what} at ${place(held)}`);
}

/** The length of the last tool must be in force. */
async function checkLength(socket) {
  const begin = said.length;
  await answered(socket, '$#');
  const inForce = said.slice(begin).find((line) => line.startsWith('[TLO:'));
  const wantedLine = `[TLO:${LENGTHS_MM.get(2).toFixed(3)}]`;
  if (inForce !== wantedLine) throw new Error(`the last tool has the length ${wantedLine}, and yet ${inForce}`);
}

async function park(socket, seen) {
  await run(socket, seen, 'parking.nc', source('parking.nc'), async () => {
    // The page's buttons for the machine, which leave the program running; then those for the program.
    const isUnderWay = (report) => place(report)[0] > 10 && place(report)[2] === 0;
    await holdAndResume(socket, ['feedhold', 'cyclestart'], isUnderWay, 0);
    const isCarrying = (report) => place(report)[0] > 175 && place(report)[1] > 50;
    await holdAndResume(socket, ['gcode:pause', 'gcode:resume'], isCarrying, 0);
  });
}

async function engrave(socket, seen) {
  await set(socket, seen, '$32', '1');
  await run(socket, seen, 'engraving.nc', source('engraving.nc'), async () => {
    const begin = await holdAndResume(socket, ['feedhold', 'cyclestart'], (report) => s(report) > 0, 0);
    await asked(socket, 'laser on again', () => {
      const reports = reportsFrom(begin);
      return reports.some(isOn) && reports.some((report) => s(report) > 0);
    });
  });
}

async function mill(socket, seen) {
  await set(socket, seen, '$32', '0');
  await run(socket, seen, 'square.nc', `M3 S${SPINDLE_S}\n${source('square.nc')}\nM5\n`, async () => {
    const turns = (report) => s(report) === SPINDLE_S;
    const begin = await holdAndResume(socket, ['gcode:pause', 'gcode:resume'], turns, SPINDLE_S);
    checkTool('when resumed', reportsFrom(begin), SPINDLE_S);
  });
}

/** Types a setting into the page's console, and reads it back. */
async function set(socket, seen, name, value) {
  for (const line of [`${name}=${value}`, '$$']) await answered(socket, line);
  await until(`${name} read as ${value}`, () => seen.settings[name] === value);
}

/** Types a line into the page's console, and waits for its answer. */
async function answered(socket, line) {
  const answers = () => said.filter((each) => each === 'ok').length;
  const before = answers();
  socket.emit('writeln', port, line);
  await until(`ok to ${line}`, () => answers() > before);
}

/** Loads a program, runs it and meanwhile does what `meanwhile` does. Every line must be answered with ok, and the
 * machine rest where it is to, all off. */
async function run(socket, seen, name, gcode, meanwhile, endsAt = wanted) {
  const refusedBefore = refusals().length;
  socket.emit('command', port, 'gcode:load', name, gcode, {});
  await until(`${name} loaded`, () => seen.sender.name === name);
  socket.emit('command', port, 'gcode:start');
  // It may have stopped at the first tool already.
  await until('program running', () => seen.workflow !== 'idle');
  await meanwhile();
  // cncjs resets its counts at the end.
  const { total } = seen.sender;
  await until('answer to every line', () => seen.sender.received === total);
  await until('end of the program', () => seen.workflow === 'idle');
  const isThere = () => seen.place.every((mm, axis) => mm === endsAt[axis]);
  await until(`Idle at ${endsAt}`, () => seen.state === 'Idle' && isThere());
  checkTool(`after ${name}`, await restReports(socket, said.length), 0);
  const refused = refusals().length - refusedBefore;
  if (refused > 0) throw new Error(`${refused} of ${total} lines refused`);
  console.log(`${total} lines of ${name} answered with ok; Idle at ${seen.place}`);
}

/** Holds the machine once it runs and reports what `isThere` looks for; it must stand still, its spindle or laser at
 * `heldS`, and go on when it is resumed. @returns {Promise<number>} how much was said before that */
async function holdAndResume(socket, [hold, resume], isThere, heldS) {
  await reported(socket, `Run on the way to ${hold}`, (report) => report.startsWith('<Run|') && isThere(report));
  socket.emit('command', port, hold);
  const held = await reported(socket, `Hold:0 after ${hold}`, (report) => report.startsWith('<Hold:0|'));
  const all = await restReports(socket, said.indexOf(held));
  const moved = all.find((report) => !report.startsWith('<Hold:0|') || String(place(report)) !== String(place(held)));
  if (moved) throw new Error(`held: ${held}, and yet ${moved}`);
  checkTool(`after ${hold}`, all, heldS);
  console.log(`held by ${hold} at ${place(held)}, S${heldS}`);
  const begin = said.length;
  socket.emit('command', port, resume);
  const isOnTheWay = (report) => report.startsWith('<Run|') && String(place(report)) !== String(place(held));
  await reported(socket, `Run after ${resume}`, isOnTheWay);
  return begin;
}

/** Asks for so many reports that one tells what is on. @returns {Promise<string[]>} all from line `begin` on */
async function restReports(socket, begin) {
  await asked(socket, 'reports at rest', () => {
    const reports = reportsFrom(begin);
    return reports.length >= REPORTS_AT_REST && reports.some((report) => isOn(report) !== undefined);
  });
  return reportsFrom(begin);
}

/** Requests status reports, like the page's terminal, until the condition holds. */
async function asked(socket, what, condition) {
  const ask = () => {
    if (condition()) return true;
    socket.emit('write', port, '?');
    return false;
  };
  await until(what, ask, REPORT_MS);
}

/** All reports must contain this S, and spindle or laser must be on exactly if S is above 0. */
function checkTool(when, reports, wantedS) {
  const wrong = reports.find((report) => s(report) !== wantedS || (isOn(report) ?? wantedS > 0) !== wantedS > 0);
  if (wrong) throw new Error(`S${wantedS} ${when}, and yet ${wrong}`);
}

function source(name) {
  return readFileSync(join(programs, name), 'utf8');
}

function refusals() {
  return said.filter((line) => line.startsWith('error:'));
}

/** The status reports among the lines received since line `begin`. */
function reportsFrom(begin) {
  return said.slice(begin).filter((line) => line.startsWith('<'));
}

function place(report) {
  return /MPos:([^|>]+)/.exec(report)[1].split(',').map(Number);
}

function s(report) {
  return Number(/\|FS:[^,]+,(\d+)/.exec(report)[1]);
}

/** Whether spindle or laser is on: S is M3's letter, C is M4's. @returns {boolean | undefined} undefined if not reported */
function isOn(report) {
  const reported = /\|Ov:[^|>]+(\|A:[SCFM]+)?/.exec(report);
  return reported ? /[SC]/.test(reported[1] ?? '') : undefined;
}

/** Requests status reports until one is as wanted. @returns {Promise<string>} that report */
async function reported(socket, what, isWanted) {
  const begin = said.length;
  await asked(socket, what, () => reportsFrom(begin).some(isWanted));
  return reportsFrom(begin).find(isWanted);
}

/** Starts the server, with the port in the list that its page offers. @returns {Promise<string>} its address */
async function serve() {
  const config = join(installed, 'cncrc.json');
  writeFileSync(config, JSON.stringify({ ports: [{ path: port, manufacturer: 'Isostep' }], state: { checkForUpdates: false } }));
  const number = await freePort();
  const command = [join(installed, 'node_modules', 'cncjs', 'bin', 'cncjs'), '--host', '127.0.0.1', '--port', number, '--config', config];
  server = spawn(process.execPath, command, { stdio: ['ignore', 'pipe', 'pipe'] });
  for (const stream of [server.stdout, server.stderr]) stream.on('data', (text) => said.push(`cncjs: ${text}`));
  const url = `http://127.0.0.1:${number}`;
  await until('cncjs server', async () => (await fetch(url).catch(() => null)) !== null);
  return url;
}

function freePort() {
  return new Promise((resolve) => {
    const probe = createServer().listen(0, '127.0.0.1', () => {
      const { port: number } = probe.address();
      probe.close(() => resolve(String(number)));
    });
  });
}

/** Collects what cncjs sends to its page. */
function watch(socket) {
  const seen = { ports: [], settings: {}, version: '', state: '', place: [], workflow: '', sender: {} };
  socket.on('serialport:list', (ports) => Object.assign(seen, { ports }));
  socket.on('serialport:read', (line) => said.push(line));
  socket.on('workflow:state', (workflow) => Object.assign(seen, { workflow }));
  socket.on('sender:status', (sender) => Object.assign(seen, { sender }));
  socket.on('controller:settings', (_type, { settings, version }) => Object.assign(seen, { settings, version }));
  socket.on('controller:state', (_type, { status }) => {
    const { x, y, z } = status.mpos;
    Object.assign(seen, { state: status.activeState, place: [x, y, z].map(Number) });
  });
  return seen;
}

async function until(what, condition, pollMs = POLL_MS) {
  const end = Date.now() + PATIENCE_MS;
  while (!(await condition())) {
    const alarm = said.find((line) => line.startsWith('ALARM'));
    if (alarm) throw new Error(`${alarm}, waiting for ${what}`);
    if (Date.now() > end) throw new Error(`no ${what} within ${PATIENCE_MS / 1000} s`);
    await new Promise((resolve) => setTimeout(resolve, pollMs));
  }
}

function fail(why) {
  server?.kill();
  console.error(`error: ${why}`);
  for (const line of said.slice(-20)) console.error(`  ${String(line).trimEnd()}`);
  process.exit(1);
}
