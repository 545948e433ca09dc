/**
 * When a display refreshes at its own rate, what is shown lies between the last two frames: never beyond the last one.
 * The face is thus one frame late (17 ms at 60 Hz), and never guesses.
 */
import type { Frame } from "./protocol";
import { SHAPE_COUNT } from "./shapes";

/** What a face is told to do. */
export interface Pose {
  weights: Float32Array;
  tongue: number;
  head: [number, number, number, number];
  eyes: [number, number, number, number];
}

export function restingPose(): Pose {
  return { weights: new Float32Array(SHAPE_COUNT), tongue: 0, head: [1, 0, 0, 0], eyes: [0, 0, 0, 0] };
}

/** Frames further apart than this, s, are not joined: the newer one is shown at once. */
const LONGEST_STEP_S = 0.25;

export class Playout {
  private before: Frame | null = null;
  private last: Frame | null = null;
  private arrivedMs = 0;
  private stepMs = 0;

  /** `nowMs`: when it arrived, on the clock that `pose` is asked with. */
  add(frame: Frame, nowMs: number): void {
    const step = this.last ? frame.time - this.last.time : 0;
    const joined = step > 0 && step <= LONGEST_STEP_S;
    this.before = joined ? this.last : null;
    this.stepMs = joined ? step * 1000 : 0;
    this.last = frame;
    this.arrivedMs = nowMs;
  }

  clear(): void {
    this.before = null;
    this.last = null;
  }

  /** The newest frame whose truth is drawn beside it. */
  get newest(): Frame | null {
    return this.last;
  }

  /** Writes what to show at `nowMs` into `pose` and, when it is known, `truth`. True while it has not come to rest. */
  pose(nowMs: number, pose: Pose, truth: Pose | null): boolean {
    const { last, before } = this;
    if (!last) return false;
    const share = before ? Math.min(1, Math.max(0, (nowMs - this.arrivedMs) / this.stepMs)) : 1;
    const from = before ?? last;
    mix(from.weights, last.weights, share, pose.weights);
    pose.tongue = from.tongueOut + (last.tongueOut - from.tongueOut) * share;
    mix(from.eyes, last.eyes, share, pose.eyes);
    turn(from.head, last.head, share, pose.head);
    if (truth && last.truth) {
      mix(from.truth ?? last.truth, last.truth, share, truth.weights);
      truth.tongue = pose.tongue;
      for (let i = 0; i < 4; ++i) {
        truth.head[i] = pose.head[i] ?? 0;
        truth.eyes[i] = pose.eyes[i] ?? 0;
      }
    }
    return share < 1;
  }
}

function mix(from: ArrayLike<number>, to: ArrayLike<number>, share: number, out: Float32Array | number[]): void {
  for (let i = 0; i < out.length; ++i) {
    const a = from[i] ?? 0;
    out[i] = a + ((to[i] ?? 0) - a) * share;
  }
}

/** Along the shorter way; steps are small, so the straight line made unit again will do. */
function turn(from: readonly number[], to: readonly number[], share: number, out: number[]): void {
  let dot = 0;
  for (let i = 0; i < 4; ++i) dot += (from[i] ?? 0) * (to[i] ?? 0);
  const sign = dot < 0 ? -1 : 1;
  let size = 0;
  for (let i = 0; i < 4; ++i) {
    const value = (from[i] ?? 0) * (1 - share) + sign * (to[i] ?? 0) * share;
    out[i] = value;
    size += value * value;
  }
  size = Math.sqrt(size);
  for (let i = 0; i < 4; ++i) out[i] = size > 1e-6 ? (out[i] ?? 0) / size : i === 0 ? 1 : 0;
}
