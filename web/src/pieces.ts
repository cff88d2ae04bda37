// The motion of a run in pieces, as its machine makes them.

import type { Job, Motion } from "../machine/machine.js";
import type { Columns, OfAxis } from "./messages";

/** The whole pieces that have been made since. */
export function pieces(job: Job): Columns[] {
  const made: Columns[] = [];
  for (let piece = job.takePiece(); piece; piece = job.takePiece()) made.push(columns(piece));
  return made;
}

/** All that is left of it after its end. */
export function lastPieces(job: Job): Columns[] {
  return [...pieces(job), columns(job.takeRest())];
}

/** The memory of pieces, which goes to the page with them. */
export function buffers(pieces: Columns[]): Transferable[] {
  const parts = pieces.flatMap(({ ofAxes, ...others }) => [others, ...ofAxes]);
  return parts.flatMap((part) => Object.values(part)).flatMap((column) => (typeof column === "number" ? [] : [column.buffer]));
}

function columns(motion: Motion): Columns {
  const taken = {
    phases: motion.phases,
    end: motion.end,
    begins: motion.begins(),
    pauses: motion.pauses(),
    kinds: motion.kinds(),
    ofAxes: Array.from({ length: motion.axes }, (_, axis) => ofAxis(motion, axis)),
    loads: motion.loads(0),
    jumps: motion.loads(1),
    asked: motion.asked(),
    powerTimes: motion.powerTimes(),
    powers: motion.powers(),
  };
  motion.free();
  return taken;
}

function ofAxis(motion: Motion, axis: number): OfAxis {
  return { places: motion.ofAxis(axis, 0), speeds: motion.ofAxis(axis, 1), accels: motion.ofAxis(axis, 2), changes: motion.changesOf(axis) };
}
