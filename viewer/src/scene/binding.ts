/** Which numbers of a pose go into which morph target: by the target's name. Pure, so that it is tested without a screen. */
import type { Pose } from "../playout";
import { shapesOfName, TONGUE } from "../shapes";

/** One morph target (or expression) and what drives it. */
export interface Drive<Target> {
  target: Target;
  /** One shape, or both sides of one that the file has in one piece. */
  shapes: readonly number[];
}

/** The drives for a list of names; names of nothing that we know are left alone. */
export function bindNames<Target>(names: Iterable<readonly [string, Target]>): Drive<Target>[] {
  const drives: Drive<Target>[] = [];
  for (const [name, target] of names) {
    const shapes = shapesOfName(name);
    if (shapes.length > 0) drives.push({ target, shapes });
  }
  return drives;
}

/** The weight of a drive: that of its shape, or the mean of both sides. */
export function driven(shapes: readonly number[], pose: Pose): number {
  let sum = 0;
  for (const shape of shapes) sum += shape === TONGUE ? pose.tongue : (pose.weights[shape] ?? 0);
  return sum / shapes.length;
}
