import { readFileSync, writeFileSync } from 'node:fs';
import { Board } from './board.mjs';
import { nanosOf } from './clock.mjs';
import { Console } from './console.mjs';
import { EdgeFile } from './edge-file.mjs';
import { loadSegments } from './elf.mjs';
import { readFlashFile, writeFlashFile } from './flash-file.mjs';
import { programLines } from './lines.mjs';
import { Live, serve } from './live.mjs';
import { HELP, parseOptions } from './options.mjs';
import { OutputTrace } from './output-trace.mjs';
import { namedInputs, namedOutputs } from './pins.mjs';
import { ProgramRun } from './program.mjs';
import { Profile } from './profile.mjs';
import { Progress } from './progress.mjs';
import { readable, summary } from './report.mjs';
import { print, requests } from './requests.mjs';
import { parseScript, ScriptRun } from './script.mjs';
import { StepTrace } from './step-trace.mjs';
import { Transcript } from './transcript.mjs';
import { Waveform } from './waveform.mjs';

/** No line of a run begins so. */
const END_OF_RUN = '\x04';

/**
 * The whole run, from the command line to the files.
 *
 * @param {string[]} args
 * @returns {number} the exit code: 0 all well, 1 the run failed, 2 it could not begin
 */
export function main(args) {
  try {
    const options = parseOptions(args);
    if (options.serve) return serveRuns();
    if (options.live) return live(options);
    if (!options.help) return emulate(options);
    console.log(HELP);
    return 0;
  } catch (error) {
    if (error.name !== 'Error' && error.code?.startsWith('ERR_PARSE_ARGS') !== true) throw error;
    console.error(`error: ${error.message}`);
    return 2;
  }
}

/** Runs that another program asks for, one after the other: the engine has compiled the emulator for the first of them. */
function serveRuns() {
  console.log = console.error = print;
  // A line is a command line as JSON. Behind what a run has printed comes its exit code.
  for (const request of requests()) print(`${END_OF_RUN}${main(JSON.parse(Buffer.from(request, 'latin1').toString()))}`);
  return 0;
}

function emulate(options) {
  const job = options.program ? programLines(read(options.program, 'program')) : parseScript(read(options.script, 'script').toString());
  const board = powered(options);
  const transcript = new Transcript(options.script ? (line) => console.log(line) : undefined);
  const sender = new Console(board, transcript);
  const run = options.program ? new ProgramRun(sender, [...settings(options), ...job], options) : new ScriptRun(sender, job, options);
  const recorders = record(board, options);
  const progress = new Progress(board, options.progress || process.stderr.isTTY, () => run.describe());
  const error = attempt(() => run.run()) ?? run.verdict() ?? verdict(board);
  const result = summary(board, sender, error);
  finish(options, board, transcript, recorders, result);
  console.log(readable(result));
  console.error(progress.speed());
  return error === null ? 0 : 1;
}

function powered(options) {
  return new Board(firmware(options.elf), options, options.flash ? readFlashFile(options.flash) : null);
}

/** Another program sets the pace. The last line on stdout is the summary. */
function live(options) {
  const board = powered(options);
  const transcript = options.transcript ? new Transcript() : undefined;
  const console = new Live(board, transcript);
  const recorders = record(board, options);
  const error = attempt(() => serve(console)) ?? verdict(board);
  const result = summary(board, console, error);
  finish(options, board, transcript, recorders, result);
  print(JSON.stringify(result));
  return error === null ? 0 : 1;
}

/** Writes the files that the options ask for. */
function finish(options, board, transcript, recorders, result) {
  write(options.transcript, transcript);
  recorders.trace?.close();
  recorders.edges?.close();
  recorders.outputs?.close();
  write(options.vcd, recorders.waveform);
  write(options.profile, recorders.profile);
  if (options.flash) writeFlashFile(options.flash, board.flash.bytes, firmware(options.elf));
  write(options.json, JSON.stringify(result, null, 2) + '\n');
}

function settings(options) {
  return options.settings.map((line) => new TextEncoder().encode(line));
}

function firmware(path) {
  const file = read(path, 'firmware', 'build it with: cargo xtask build');
  try {
    return loadSegments(file);
  } catch (error) {
    throw new Error(`${path}: ${error.message}`);
  }
}

function read(path, what, remedy = 'check the path') {
  try {
    return readFileSync(path);
  } catch (error) {
    throw new Error(`cannot read the ${what} ${path} (${error.code}): ${remedy}`);
  }
}

function write(path, content) {
  if (path !== undefined) writeFileSync(path, content.toString());
}

/** Attaches the recorders that the options request. */
function record(board, options) {
  const recorders = {};
  if (options.profile) recorders.profile = board.clock.profile = new Profile(board.gantry.statistics);
  if (options.trace) {
    recorders.trace = opened(options.trace, StepTrace);
    board.gantry.stepWatchers.add((cycle, axis, direction, position) => recorders.trace.step(nanosOf(cycle), axis, direction, position));
  }
  if (options.edges) {
    recorders.edges = opened(options.edges, EdgeFile);
    board.gantry.stepWatchers.add((cycle, axis, direction) => recorders.edges.step(cycle, axis, direction));
  }
  if (options.outputs) {
    recorders.outputs = opened(options.outputs, OutputTrace);
    board.gantry.tool.watchers.add((cycle, output, value) => recorders.outputs.change(nanosOf(cycle), output, value));
  }
  if (options.vcd) {
    recorders.waveform = new Waveform(namedOutputs(board.gantry.board, board.gantry.axes), namedInputs(board.gantry.board));
    board.watchChips((chip) => {
      chip.pwm.showEdges(board.gantry.board.tool.pwm);
      recorders.waveform.attach(chip, () => board.nanos);
    });
    board.gantry.watchInputs((pin, high) => recorders.waveform.input(board.nanos, pin, high));
  }
  return recorders;
}

function opened(path, Recorder) {
  try {
    return new Recorder(path);
  } catch (error) {
    throw new Error(`cannot write ${path} (${error.code}): check the path`);
  }
}

function attempt(action) {
  try {
    action();
    return null;
  } catch (error) {
    // A mistake of the machine or the firmware is a plain Error; any other error is a bug of the emulator.
    if (error.name !== 'Error') throw error;
    return error.message;
  }
}

/** What was wrong in a run that reached its end. */
function verdict(board) {
  const { timing } = board.gantry;
  const [fault] = board.faults.slice(board.crashes);
  if (fault !== undefined) return `the firmware took a hard fault at pc ${fault.pc}: ${fault.what}`;
  return timing.total > 0 ? `${timing.total} violations of the driver's timing` : null;
}
