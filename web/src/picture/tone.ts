// What the path is coloured by.

import { label } from "../drawing";
import { Kind, type Motion, type Phase } from "../motion";

/** Parts of a phase along which the speed changes, or which is bent. */
const PARTS = 6;
/** An acceleration that is above its limit by less is within it, as rounded numbers go. */
const WITHIN = 1.01;

/** The parts of a phase, each of which has one colour. They are made for one phase after the other, as phases are read. */
export class Parts {
  count = 0;
  /** When each begins and ends after the beginning of the phase, s. */
  readonly from: number[] = [];
  readonly to: number[] = [];
  readonly ranks: number[] = [];

  add(from: number, to: number, rank: number): void {
    this.from[this.count] = from;
    this.to[this.count] = to;
    this.ranks[this.count++] = rank;
  }

  /** Adds equal parts of a phase, or all of it. */
  addEqual({ span }: Phase, isDivided: boolean, rank = 0): void {
    const count = isDivided ? PARTS : 1;
    for (let index = 0; index < count; index++) this.add((span * index) / count, (span * (index + 1)) / count, rank);
  }

  middle(index: number): number {
    return ((this.from[index] ?? 0) + (this.to[index] ?? 0)) / 2;
  }
}

export interface Tone {
  /** Names of colours of the style sheet, by ranks: higher ones are drawn over lower ones. */
  colours: string[];
  /** Ranks that are drawn wider. */
  loud: number;
  /** Divides a phase into parts. */
  divide(motion: Motion, phase: Phase, parts: Parts): void;
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

/** By speed. Slow places are drawn over fast ones. */
const speed: Tone = {
  colours: FAST_FIRST,
  scale: SLOW_FIRST,
  loud: Infinity,
  divide(motion, phase, parts) {
    parts.addEqual(phase, phase.kind !== Kind.Cruise);
    for (let index = 0; index < parts.count; index++) parts.ranks[index] = COUNT - 1 - classOf(phase.speedAlong(parts.middle(index)) / motion.topSpeed);
  },
  key: (motion) => ({ name: "Speed", low: "0", high: `${label(motion.topSpeed, 0.1)} mm/s` }),
};

/** By the acceleration over its limit, of the axis where that is most. A jump of speed is a dot. */
const load: Tone = {
  colours: [...FAST_FIRST, "over"],
  scale: FAST_FIRST,
  loud: COUNT,
  divide(_, phase, parts) {
    if (phase.jump > WITHIN) parts.add(0, 0, COUNT);
    parts.addEqual(phase, phase.kind === Kind.Blend, phase.load > WITHIN ? COUNT : classOf(phase.load));
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
  divide(_, phase, parts) {
    parts.addEqual(phase, phase.kind !== Kind.Cruise);
    for (let index = 0; index < parts.count; index++) parts.ranks[index] = classOf(phase.lost(parts.middle(index)));
  },
  key: () => ({ name: "Time lost against the feed asked for", low: "none", high: "nearly all" }),
};

/** By what the tool is given. */
const power: Tone = {
  colours: ["bound", ...FAST_FIRST],
  scale: FAST_FIRST,
  loud: Infinity,
  divide(motion, phase, parts) {
    const count = phase.kind === Kind.Blend ? PARTS : 1;
    for (let index = 0; index < count; index++) {
      const last = (phase.span * (index + 1)) / count;
      for (let from = (phase.span * index) / count; from < last; ) {
        const { share, until } = motion.power(phase.from + from);
        const to = Math.max(Math.min(last, until - phase.from), from + 1e-9);
        parts.add(from, to, share > 0 ? 1 + classOf(share) : 0);
        from = to;
      }
    }
  },
  key: () => ({ name: "Tool", low: "off is grey, 0", high: "100 % of its power" }),
};

export const TONES: Record<string, Tone> = { speed, lost, load, power };
