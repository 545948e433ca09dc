/** How far two expressions of one face are apart, in millimetres of skin. */
import { Vector3, type Mesh } from "three";
import { atRest } from "./cpu_morph";
import { shapesOfName, TONGUE } from "../shapes";

/** Skin that moves by less than this at full weight of every shape, m, is left out of the mean. */
const LEAST_M = 0.0005;
/** This many vertices are enough for a mean. */
const SAMPLES = 3000;

/** A shape off by less shows as 0.000: it is named as off no more than the others are. */
const LEAST_WEIGHT = 0.0005;

export interface Difference {
  meanMm: number;
  maxMm: number;
}

export class SkinDifference {
  /** For each sampled vertex its displacement by each shape, m: [vertex][shape][xyz]. */
  private readonly deltas: Float32Array;
  private readonly count: number;
  private readonly shapes: number[][] = [];

  /** `scale`: metres per unit of the mesh. */
  constructor(mesh: Mesh, scale: number) {
    const targets = atRest(mesh).morphAttributes.position ?? [];
    const used: number[] = [];
    for (const [name, target] of Object.entries(mesh.morphTargetDictionary ?? {})) {
      const shapes = shapesOfName(name).filter((shape) => shape !== TONGUE);
      if (shapes.length === 0) continue;
      this.shapes.push([...shapes]);
      used.push(target);
    }
    const total = atRest(mesh).attributes["position"]?.count ?? 0;
    const moving: number[] = [];
    const delta = new Vector3();
    for (let v = 0; v < total; ++v) {
      const moves = used.some((target) => {
        const attribute = targets[target];
        return attribute !== undefined && delta.fromBufferAttribute(attribute, v).length() * scale > LEAST_M;
      });
      if (moves) moving.push(v);
    }
    const stride = Math.max(1, Math.floor(moving.length / SAMPLES));
    const sampled = moving.filter((_, i) => i % stride === 0);
    this.count = sampled.length;
    this.deltas = new Float32Array(this.count * used.length * 3);
    let at = 0;
    for (const v of sampled) {
      for (const target of used) {
        const attribute = targets[target];
        if (attribute) delta.fromBufferAttribute(attribute, v).multiplyScalar(scale);
        else delta.set(0, 0, 0);
        this.deltas[at++] = delta.x;
        this.deltas[at++] = delta.y;
        this.deltas[at++] = delta.z;
      }
    }
  }

  /** Between two sets of 53 weights; null where the mesh does not name its shapes. */
  between(a: Float32Array, b: Float32Array): Difference | null {
    if (this.count === 0) return null;
    const apart = this.shapes.map((shapes) => {
      let sum = 0;
      for (const shape of shapes) sum += (a[shape] ?? 0) - (b[shape] ?? 0);
      return sum / shapes.length;
    });
    let sum = 0;
    let max = 0;
    let at = 0;
    for (let v = 0; v < this.count; ++v) {
      let x = 0, y = 0, z = 0;
      for (let k = 0; k < apart.length; ++k) {
        const weight = apart[k] as number;
        x += weight * (this.deltas[at++] as number);
        y += weight * (this.deltas[at++] as number);
        z += weight * (this.deltas[at++] as number);
      }
      const distance = Math.hypot(x, y, z);
      sum += distance;
      if (distance > max) max = distance;
    }
    return { meanMm: (1000 * sum) / this.count, maxMm: 1000 * max };
  }
}

/** How far two sets of weights are apart on average, and in which shape most; null where none is visibly apart. */
export function weightsApart(a: Float32Array, b: Float32Array): { mean: number; furthest: number | null } {
  let furthest: number | null = null;
  let most = LEAST_WEIGHT;
  let sum = 0;
  a.forEach((weight, shape) => {
    const off = Math.abs(weight - (b[shape] ?? 0));
    sum += off;
    if (off <= most) return;
    most = off;
    furthest = shape;
  });
  return { mean: sum / Math.max(1, a.length), furthest };
}
