// What the path is coloured by.

import { label } from "../drawing";
import { Kind, type Motion } from "../motion";

/** Parts of a phase along which the speed changes, or which is bent. */
const PARTS = 6;
/** An acceleration that is above its limit by less is within it, as rounded numbers go. */
const WITHIN = 1.01;

/** A part of a phase that has one colour, with its times after the beginning of the phase, s. */
export type Part = (from: number, to: number, rank: number) => void;

export interface Tone {
  /** Names of colours of the style sheet, by ranks: higher ones are drawn over lower ones. */
  colours: string[];
  /** Ranks that are drawn wider. */
  loud: number;
  /** Divides a phase into parts. */
  parts(motion: Motion, row: number, part: Part): void;
  /** What the lowest and the highest colour of the scale mean, and what the loud one does. */
  key(motion: Motion): { name: string; low: string; high: string; loud?: string };
  /** Colours of the scale, from low to high. */
  scale: string[];
}

const SLOW_FIRST = Array.from({ length: 8 }, (_, index) => `speed-${index + 1}`);
const LOST = Array.from({ length: 8 }, (_, index) => `lost-${index + 1}`);
const FAST_FIRST = [...SLOW_FIRST].reverse();
const COUNT = SLOW_FIRST.length;

/** The class of a share from 0 to 1. */
const classOf = (share: number): number => Math.min(COUNT - 1, Math.max(0, Math.floor(COUNT * share)));

/** Divides a phase into equal parts, or not at all. */
function equal(motion: Motion, row: number, isDivided: boolean, part: (from: number, to: number) => void): void {
  const [span, count] = [motion.to(row) - motion.from(row), isDivided ? PARTS : 1];
  for (let index = 0; index < count; index++) part((span * index) / count, (span * (index + 1)) / count);
}

/** By speed. Slow places are drawn over fast ones. */
const speed: Tone = {
  colours: FAST_FIRST,
  scale: SLOW_FIRST,
  loud: Infinity,
  parts(motion, row, part) {
    equal(motion, row, motion.kind(row) !== Kind.Cruise, (from, to) => {
      const share = motion.speedIn(row, (from + to) / 2) / motion.topSpeed;
      part(from, to, COUNT - 1 - classOf(share));
    });
  },
  key: (motion) => ({ name: "Speed", low: "0", high: `${label(motion.topSpeed, 0.1)} mm/s` }),
};

/** By the acceleration over its limit, of the axis where that is most. A jump of speed is a dot. */
const load: Tone = {
  colours: [...FAST_FIRST, "over"],
  scale: FAST_FIRST,
  loud: COUNT,
  parts(motion, row, part) {
    if (motion.jump(row) > WITHIN) part(0, 0, COUNT);
    const share = motion.load(row);
    const rank = share > WITHIN ? COUNT : classOf(share);
    equal(motion, row, motion.kind(row) === Kind.Blend, (from, to) => part(from, to, rank));
  },
  key(motion) {
    const most = motion.topLoad;
    const loud = most > WITHIN ? `above it, at most ${(100 * most).toFixed(0)} %` : undefined;
    return { name: "Acceleration of the worst axis", low: "0", high: "100 % of its limit", ...(loud && { loud }) };
  },
};

/** By the time that is lost: the part of the time in a place that the feed asked for would not take. */
const lost: Tone = {
  colours: LOST,
  scale: LOST,
  loud: Infinity,
  parts(motion, row, part) {
    equal(motion, row, motion.kind(row) !== Kind.Cruise, (from, to) => {
      part(from, to, classOf(motion.lostIn(row, (from + to) / 2)));
    });
  },
  key: () => ({ name: "Time lost against the feed asked for", low: "none", high: "nearly all" }),
};

/** By what the tool is given. */
const power: Tone = {
  colours: ["bound", ...FAST_FIRST],
  scale: FAST_FIRST,
  loud: Infinity,
  parts(motion, row, part) {
    const begin = motion.from(row);
    equal(motion, row, motion.kind(row) === Kind.Blend, (first, last) => {
      for (let from = first; from < last; ) {
        const { share, until } = motion.power(begin + from);
        const to = Math.max(Math.min(last, until - begin), from + 1e-9);
        part(from, to, share > 0 ? 1 + classOf(share) : 0);
        from = to;
      }
    });
  },
  key: () => ({ name: "Tool", low: "off is grey, 0", high: "100 % of its power" }),
};

export const TONES: Record<string, Tone> = { speed, lost, load, power };
