/**
 * Keeps the face moving on a weak graphics card: where pictures come too slowly, they get coarser, then plain, which is
 * without shadows. Never finer again by itself, or it would swing between the two; a new page begins with the best.
 */

export interface Quality {
  /** Share of the display's resolution. */
  sharpness: number;
  shadows: boolean;
  /** Lit a vertex at a time, without what only a graphics card is quick at. */
  plain: boolean;
}

const STEPS: readonly Quality[] = [
  { sharpness: 1, shadows: true, plain: false },
  { sharpness: 0.75, shadows: true, plain: false },
  { sharpness: 1, shadows: false, plain: true },
  { sharpness: 0.7, shadows: false, plain: true },
  { sharpness: 0.55, shadows: false, plain: true },
];
const FIRST_PLAIN = STEPS.findIndex((step) => step.plain);
/** Pictures between two judgements, or fewer where they take this long together, ms. */
const JUDGED = 24;
const FEWEST = 4;
const LONG_ENOUGH_MS = 3000;
/** Slower than this on the median, ms a picture, is too slow. */
const TOO_SLOW_MS = 36;
/** At the last step the card rests at least this long, ms: 15 pictures a second are enough for what it is. */
const LEAST_REST_MS = 50;
const LONGEST_REST_MS = 1000;
/** Slower than this, ms a picture, and buttons begin to lag: a browser draws everything with the same card. */
const CRAWL_MS = 120;
/** A pause longer than this, ms, was no drawing at all: nothing moved, or the page was hidden. */
const PAUSE_MS = 8000;

export class Pace {
  private step: number;
  private last = -Infinity;
  private sum = 0;
  /** Median time of a picture without the rest before it, ms. */
  private cost = 0;
  private readonly intervals: number[] = [];

  /** `from`: where it begins; `coarsest` stays there, `plain` is for a graphics card that is software. */
  constructor(from: "finest" | "plain" | "coarsest" = "finest") {
    this.step = from === "coarsest" ? STEPS.length - 1 : from === "plain" ? FIRST_PLAIN : 0;
  }

  get quality(): Quality {
    return STEPS[this.step] as Quality;
  }

  /** How long to leave the card alone between two pictures, ms, so that the rest of the page stays quick. */
  get rest(): number {
    if (this.cost > CRAWL_MS) return Math.min(LONGEST_REST_MS, this.cost);
    return this.step === STEPS.length - 1 ? LEAST_REST_MS : 0;
  }

  /** Notes a picture drawn at `nowMs`. True when the quality has changed by it. */
  drew(nowMs: number): boolean {
    const interval = nowMs - this.last;
    this.last = nowMs;
    const rest = this.rest;
    if (!(interval > 0 && interval <= PAUSE_MS)) return false;
    this.intervals.push(interval);
    this.sum += interval;
    const count = this.intervals.length;
    if (count < FEWEST || (count < JUDGED && this.sum < LONG_ENOUGH_MS)) return false;
    this.cost = Math.max(0, (this.intervals.sort((a, b) => a - b)[Math.floor(count / 2)] ?? 0) - rest);
    this.intervals.length = 0;
    this.sum = 0;
    if (this.cost <= TOO_SLOW_MS || this.step >= STEPS.length - 1) return false;
    ++this.step;
    return true;
  }
}
