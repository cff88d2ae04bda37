#!/usr/bin/env node
// Drives cncjs as its web page does, over HTTP and socket.io: sign in, open the port, home, load a program, run it, hold it on
// the way by either of the page's buttons and resume it.
//
//     cncjs.mjs INSTALLED PORT PROGRAM X,Y,Z
//
// INSTALLED is the folder with cncjs in its node_modules. It fails unless the machine stands still in each hold, goes on from
// there, every line of the program is answered with ok and the machine stands at X,Y,Z mm at the end.

import { spawn } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:net';
import { createRequire } from 'node:module';
import { join } from 'node:path';

const PATIENCE_MS = 60_000;
const POLL_MS = 50;
/** How long a held machine is watched: with its speed, seconds of the machine's. */
const HELD_MS = 500;

if (process.argv.length !== 6) fail('give INSTALLED PORT PROGRAM X,Y,Z');
const [installed, port, program, place] = process.argv.slice(2);
const wanted = place.split(',').map(Number);
const require = createRequire(join(installed, 'node_modules', 'cncjs', 'package.json'));
const said = [];
let server;

process.on('SIGTERM', () => fail('told to end'));
try {
  await main();
} catch (error) {
  fail(error.message);
}
server.kill();
process.exit(0);

async function main() {
  const url = await serve();
  const { token } = await (await fetch(`${url}/api/signin`, { method: 'POST' })).json();
  const socket = require('socket.io-client')(url, { query: `token=${token}`, transports: ['websocket'] });
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

  const refusedBefore = said.filter((line) => line.startsWith('error:'));
  if (refusedBefore.length > 0) console.log(`refused while connecting: ${refusedBefore}`);
  socket.emit('command', port, 'gcode:load', 'program', readFileSync(program, 'utf8'), {});
  await until('program loaded', () => seen.sender.total > 0);
  socket.emit('command', port, 'gcode:start');
  await until('program running', () => seen.workflow === 'running');
  // Its buttons for the machine, which leave the program running, then those for the program.
  await holdAndResume(socket, 'feedhold', 'cyclestart', ([x, y, z]) => x > 10 && z === 0);
  await holdAndResume(socket, 'gcode:pause', 'gcode:resume', ([x, y]) => x > 175 && y > 50);
  await until('end of the program', () => seen.workflow === 'idle');
  await until(`Idle at ${wanted}`, () => seen.state === 'Idle' && seen.place.every((mm, axis) => mm === wanted[axis]));
  const refused = said.filter((line) => line.startsWith('error:')).length - refusedBefore.length;
  const { total, received } = seen.sender;
  if (refused > 0 || received !== total) throw new Error(`${received} of ${total} lines answered, ${refused} refused`);
  console.log(`${total} lines answered with ok; Idle at ${seen.place}`);
  await new Promise((resolve) => socket.emit('close', port, resolve));
}

/** Holds the machine once it runs and has come as far as `isThere` says; it must stand still, and go on when it is resumed. */
async function holdAndResume(socket, hold, resume, isThere) {
  const place = (report) => /MPos:([^|>]+)/.exec(report)[1];
  await reported(socket, `Run on the way to ${hold}`, (report) => report.startsWith('<Run|') && isThere(place(report).split(',').map(Number)));
  socket.emit('command', port, hold);
  const held = await reported(socket, `Hold:0 after ${hold}`, (report) => report.startsWith('<Hold:0|'));
  await new Promise((resolve) => setTimeout(resolve, HELD_MS));
  const later = await reported(socket, 'report in the hold', () => true);
  if (!later.startsWith('<Hold:0|') || place(later) !== place(held)) throw new Error(`held: ${held}, and yet ${later}`);
  console.log(`held by ${hold} at ${place(held)}`);
  socket.emit('command', port, resume);
  await reported(socket, `Run after ${resume}`, (report) => report.startsWith('<Run|') && place(report) !== place(held));
}

/** Asks for status reports, as the page's terminal does, until one is as wanted. @returns {Promise<string>} that one */
async function reported(socket, what, isWanted) {
  let next = said.length;
  let found;
  await until(what, () => {
    const reports = said.slice(next).filter((line) => line.startsWith('<'));
    next = said.length;
    found = reports.find(isWanted);
    if (!found) socket.emit('write', port, '?');
    return found !== undefined;
  });
  return found;
}

/** Starts the server, with the port among those that its page offers. @returns {Promise<string>} its address */
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

/** What cncjs tells its page. */
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

async function until(what, condition) {
  const end = Date.now() + PATIENCE_MS;
  while (!(await condition())) {
    const alarm = said.find((line) => line.startsWith('ALARM'));
    if (alarm) throw new Error(`${alarm}, waiting for ${what}`);
    if (Date.now() > end) throw new Error(`no ${what} within ${PATIENCE_MS / 1000} s`);
    await new Promise((resolve) => setTimeout(resolve, POLL_MS));
  }
}

function fail(why) {
  server?.kill();
  console.error(`error: ${why}`);
  for (const line of said.slice(-20)) console.error(`  ${String(line).trimEnd()}`);
  process.exit(1);
}
