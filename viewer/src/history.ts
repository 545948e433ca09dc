/**
 * The last minute of weights, in memory taken once: a ring of frames with weight, truth and provenance of every shape, so
 * that a shape which somebody picks shows its past at once.
 */
import type { Frame } from "./protocol";
import { SHAPE_COUNT } from "./shapes";

/** One minute at 60 Hz. */
const CAPACITY = 3600;
/** A step in time of more than this, s, or backwards, begins anew: the replay was moved, or another one began. */
const JUMP_S = 5;

/** What of one shape is drawn: as long as each other; null where there is a hole. */
export interface Stretch {
  times: number[];
  weights: (number | null)[];
  truths: (number | null)[];
  letters: string[];
}

export class History {
  private readonly times = new Float64Array(CAPACITY);
  private readonly weights = new Float32Array(CAPACITY * SHAPE_COUNT);
  private readonly truths = new Float32Array(CAPACITY * SHAPE_COUNT);
  private readonly letters: string[] = new Array<string>(CAPACITY).fill("");
  private next = 0;
  private count = 0;

  get length(): number {
    return this.count;
  }

  /** Time of the newest frame, s; 0 when there is none. */
  get latest(): number {
    return this.count > 0 ? (this.times[(this.next + CAPACITY - 1) % CAPACITY] ?? 0) : 0;
  }

  clear(): void {
    this.next = 0;
    this.count = 0;
  }

  add(frame: Frame): void {
    if (this.count > 0) {
      const step = frame.time - this.latest;
      if (step === 0) return; // A paused replay repeats itself.
      if (step < 0 || step > JUMP_S) this.clear();
    }
    const at = this.next;
    this.times[at] = frame.time;
    this.weights.set(frame.weights, at * SHAPE_COUNT);
    if (frame.truth) this.truths.set(frame.truth, at * SHAPE_COUNT);
    else this.truths.fill(NaN, at * SHAPE_COUNT, (at + 1) * SHAPE_COUNT);
    this.letters[at] = frame.provenance;
    this.next = (at + 1) % CAPACITY;
    this.count = Math.min(CAPACITY, this.count + 1);
  }

  /** The last `seconds` of some shapes; times are seconds before now (negative). */
  stretch(shape: number, seconds: number): Stretch {
    const out: Stretch = { times: [], weights: [], truths: [], letters: [] };
    const now = this.latest;
    for (let i = this.count; i > 0; --i) {
      const at = (this.next + CAPACITY - i) % CAPACITY;
      const time = (this.times[at] ?? 0) - now;
      if (time < -seconds) continue;
      const truth = this.truths[at * SHAPE_COUNT + shape] ?? NaN;
      out.times.push(time);
      out.weights.push(this.weights[at * SHAPE_COUNT + shape] ?? null);
      out.truths.push(Number.isNaN(truth) ? null : truth);
      out.letters.push(this.letters[at]?.charAt(shape) ?? "n");
    }
    return out;
  }
}
