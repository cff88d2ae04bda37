import { CLOCK_HZ, nanosOf } from './clock.mjs';

const SHOWN = 5;

/** All results of a run, for `--json`. They contain machine time only, so the same run gives the same bytes. */
export function summary(board, console, error) {
  const { clock, gantry } = board;
  const { moving } = gantry.statistics;
  return {
    ok: error === null,
    error,
    machine_time_ns: board.nanos,
    final_status: console.lastStatus,
    alarm: console.alarm,
    axes: Object.fromEntries(gantry.axes.map((axis) => [axis, axisSummary(gantry, axis)])),
    belts: gantry.belts !== null,
    second: secondSummary(gantry),
    drivers: gantry.drivers?.summary() ?? null,
    vfd: gantry.vfdWire?.summary() ?? null,
    driver_timing: { driver: gantry.timing.limits.name, violations: gantry.timing.total, by_rule: gantry.timing.counts, first: gantry.timing.first },
    core: coreSummary(clock),
    flash_cache: cacheSummary(board),
    ...board.watch.summary(),
    late_alarms: board.lateAlarms.summary(clock.cycles),
    moving: {
      time_ns: nanosOf(moving.cycles),
      edges: moving.edges,
      last_edge_ns: Number.isFinite(gantry.statistics.lastCycle) ? nanosOf(gantry.statistics.lastCycle) : null,
      load: ratio(moving.awakeCycles, moving.cycles),
      awake_cycles_per_edge: ratio(moving.awakeCycles, moving.edges),
      interrupt_cycles_per_edge: ratio(moving.handlerCycles, moving.edges),
    },
    stops: gantry.stops.summary(),
    tool: { ...gantry.tool.summary(), stops: gantry.toolStops.summary() },
    probe: gantry.probe.summary(),
    hard_faults: board.faults,
    watchdog_resets: board.resets,
    power_cycles: board.powerCycles,
    bootsel: board.bootsel,
    floating_input_pins: gantry.floatingInputs(),
    unimplemented: [...board.warnings],
    replies: console.sent.map(replySummary),
  };
}

function coreSummary(clock) {
  const { cycles, awakeCycles, handlerCycles } = clock;
  return {
    clock_hz: CLOCK_HZ,
    cycles,
    awake_cycles: awakeCycles,
    interrupt_cycles: handlerCycles,
    thread_cycles: awakeCycles - handlerCycles,
    load: ratio(awakeCycles, cycles),
  };
}

function cacheSummary({ flashCounts: { accesses, hits, misses, stallCycles }, cache }) {
  return { accesses, hits, misses, stall_cycles: stallCycles, miss_cycles: cache.missCycles };
}

function axisSummary(gantry, axis) {
  const carriage = gantry.carriages[axis];
  return {
    edges: gantry.statistics.axes[axis].edges,
    highest_rate_steps_per_s: gantry.statistics.highestRate(axis),
    position_steps: carriage.positionSteps,
    place_mm: carriage.placeMm,
    lowest_place_mm: carriage.lowestMm,
    highest_place_mm: carriage.highestMm,
    lost_steps: carriage.lostSteps,
    switch_closures: carriage.limitSwitch.closures,
    switch_closed: carriage.limitSwitch.closed,
  };
}

/** Of the second motor, if there is one. */
function secondSummary({ second }) {
  if (second === null) return null;
  const { axis, carriage, fartherSteps, together, alone } = second;
  return { axis, place_mm: carriage.placeMm, farther_steps: fartherSteps, steps_together: together, steps_alone: alone };
}

function replySummary({ text, reply, sentNanos, arrivedNanos, repliedNanos }, index) {
  return { line: index + 1, text, reply, sent_ns: sentNanos, arrived_ns: arrivedNanos, replied_ns: repliedNanos };
}

const ratio = (part, whole) => (whole > 0 ? Number((part / whole).toFixed(6)) : 0);

/** The results as text for people. */
export function readable(result) {
  const refused = result.replies.filter(({ reply }) => reply !== 'ok');
  const { core, moving, driver_timing: timing } = result;
  return [
    result.ok ? 'All went through.' : `FAILED: ${result.error}`,
    ...(result.ok ? [] : refused.slice(0, SHOWN)).map(({ line, text, reply }) => `  line ${line} (${text.slice(0, 60)}): ${reply ?? 'no reply'}`),
    ...(result.replies.length === 0 ? [] : [`Lines        ${result.replies.length} sent, ${result.replies.length - refused.length} answered ok`]),
    `Status       ${result.final_status ?? 'none seen'}`,
    ...(result.belts ? ['Belts        crossed: steps and rates are those of the motors, places those of the axes'] : []),
    ...Object.entries(result.axes).map(axisLine),
    ...Object.entries(result.axes).filter(([, { lost_steps: lost }]) => lost > 0).map(lostLine),
    ...Object.entries(result.drivers ?? {}).map(driverLine),
    `Driver       ${timing.violations === 0 ? `every edge within the timing of the ${timing.driver}` : `${timing.violations} violations ${JSON.stringify(timing.by_rule)}`}`,
    ...timing.first.map((each) => `  ${each.axis} ${each.rule} at ${each.t_ns} ns: ${each.value_ns} ns, at least ${each.limit_ns}`),
    `Core         ${(core.load * 100).toFixed(1)} % awake; while moving ${(moving.load * 100).toFixed(1)} %`,
    cacheLine(result.flash_cache, core),
    ...urgentLines(result),
    ...lateAlarmLines(result.late_alarms),
    `Cycles       ${Math.round(moving.interrupt_cycles_per_edge)} a step in interrupts, ${Math.round(moving.awake_cycles_per_edge)} with planning and console`,
    ...result.stops.slice(0, SHOWN).map(stopLine),
    ...(result.stops.length > SHOWN ? [slowestStopLine(result.stops)] : []),
    ...toolLines(result.tool),
    ...result.hard_faults.map(({ t_ns, pc, what }) => `Hard fault   at ${(t_ns / 1e9).toFixed(6)} s, pc ${pc}: ${what}. The line: addr2line -f -i -e ELF ${pc}`),
    ...result.watchdog_resets.map(({ t_ns, reason }) => `Watchdog     reset at ${(t_ns / 1e9).toFixed(6)} s (${reason})`),
    ...result.power_cycles.map(({ t_ns }) => `Power        off and on at ${(t_ns / 1e9).toFixed(6)} s`),
    ...(result.bootsel === null ? [] : [`BOOTSEL      from ${(result.bootsel.t_ns / 1e9).toFixed(6)} s on`]),
    ...result.floating_input_pins.map((pin) => `Input        GP${pin} has no pull-up: it floats while its switch is open`),
    `Machine time ${(result.machine_time_ns / 1e9).toFixed(6)} s`,
  ].join('\n');
}

function cacheLine({ accesses, misses, stall_cycles: stalled, miss_cycles: cost }, core) {
  if (accesses === 0) return 'Flash        reads like RAM';
  const part = (count, whole) => `${(ratio(count, whole) * 100).toFixed(1)} %`;
  return `Flash        ${accesses} words read, ${part(misses, accesses)} not in the cache at ${cost} cycles each; the core waited ${part(stalled, core.awake_cycles)} of its time awake`;
}

/** Accesses of urgent code to flash, and the longest time with interrupts masked. */
function urgentLines(result) {
  const { longest_masked_cycles: longest, longest_masked_pc: pc } = result;
  return [
    urgentLine('Handlers  ', result.flash_in_handlers, result.flash_in_handlers_data),
    urgentLine('Masked    ', result.flash_in_critical_sections, result.flash_in_critical_sections_data),
    ...(pc === null ? [] : [`             for ${longest} cycles at most, from pc ${pc}`]),
  ];
}

function lateAlarmLines({ count, longest_us: longest, first_t_ns: first }) {
  if (count === 0) return [];
  return [`Timer        ${count} alarms set when their time had passed, the first at ${(first / 1e9).toFixed(6)} s; tasks slept ${longest.toFixed(1)} us too long`];
}

function urgentLine(name, code, data) {
  const [pc] = code.pcs;
  return `${name}   ${code.count} instructions from flash${pc === undefined ? '' : ` (most at ${pc})`}, ${data.count} reads of it`;
}

function stopLine({ input, t_ns: reportedNanos, latency_ns: latencyNanos, edges_after: edges }) {
  return `Stop         ${input} at ${(reportedNanos / 1e9).toFixed(6)} s: ${edges} more steps, the last ${(latencyNanos / 1000).toFixed(2)} us later`;
}

function slowestStopLine(stops) {
  const slowest = stops.reduce((worst, stop) => (stop.latency_ns > worst.latency_ns ? stop : worst));
  return `             of ${stops.length} stops the slowest: ${slowest.input}, ${(slowest.latency_ns / 1000).toFixed(2)} us`;
}

/** Empty for a tool that was not used. */
function toolLines({ changes, on_s: on, on_at_standstill_s: still, stops }) {
  if (changes === 0) return [];
  return [
    `Tool         on for ${on.toFixed(6)} s, ${still.toFixed(6)} s of it at standstill; ${changes} changes of its outputs`,
    ...stops.slice(0, SHOWN).map(toolStopLine),
  ];
}

function toolStopLine({ input, t_ns: reportedNanos, outputs_off_ns: offNanos }) {
  const off = offNanos === null ? 'not off until the end' : `off ${(offNanos / 1000).toFixed(2)} us later`;
  return `             ${input} at ${(reportedNanos / 1e9).toFixed(6)} s: ${off}`;
}

function axisLine([axis, { edges, place_mm: place, position_steps: position, highest_rate_steps_per_s: rate }]) {
  return `Axis ${axis}       ${edges} steps, at ${position} steps, ${place.toFixed(2)} mm above its switch, ${rate} steps/s at most`;
}

function lostLine([axis, { lost_steps: lost }]) {
  return `             ${axis} lost ${lost} of its steps`;
}

function driverLine([axis, { microsteps, irun, ihold, chopper, reads, writes, refused }]) {
  return `Driver ${axis}     ${microsteps} microsteps, IRUN ${irun}, IHOLD ${ihold}, ${chopper}; ${reads} reads, ${writes} writes, ${refused} refused`;
}
