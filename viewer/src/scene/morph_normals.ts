/**
 * A smile that does not change the light on the cheek looks painted on. Files of morph targets mostly come without the
 * normals' own targets; these are made here, once, from the moved surfaces.
 */
import { Float32BufferAttribute, type BufferGeometry } from "three";
import { numbersOf } from "./attributes";

/** Vertices times targets beyond which the wait would be felt. */
const MOST_WORK = 6_000_000;

/** Adds normal targets where there are position targets and none of normals. */
export function addMorphNormals(geometry: BufferGeometry): void {
  const targets = geometry.morphAttributes.position;
  const base = geometry.attributes["position"];
  const normal = geometry.attributes["normal"];
  const index = geometry.index;
  if (!targets?.length || geometry.morphAttributes.normal || !base || !normal || !index) return;
  if (!geometry.morphTargetsRelative || base.count * targets.length > MOST_WORK) return;

  const positions = numbersOf(base);
  const triangles = index.array;
  const resting = normalsOf(positions, triangles);
  const moved = new Float32Array(positions.length);
  geometry.morphAttributes.normal = targets.map((target) => {
    const deltas = numbersOf(target);
    for (let i = 0; i < moved.length; ++i) moved[i] = (positions[i] ?? 0) + (deltas[i] ?? 0);
    const normals = normalsOf(moved, triangles);
    for (let i = 0; i < normals.length; ++i) normals[i] = (normals[i] ?? 0) - (resting[i] ?? 0);
    return new Float32BufferAttribute(normals, 3);
  });
}

/** Unit normals, weighted by the triangles' areas. */
function normalsOf(p: Float32Array, triangles: ArrayLike<number>): Float32Array {
  const out = new Float32Array(p.length);
  const at = (i: number) => p[i] as number;
  for (let t = 0; t + 2 < triangles.length; t += 3) {
    const a = 3 * (triangles[t] as number);
    const b = 3 * (triangles[t + 1] as number);
    const c = 3 * (triangles[t + 2] as number);
    const ux = at(b) - at(a), uy = at(b + 1) - at(a + 1), uz = at(b + 2) - at(a + 2);
    const vx = at(c) - at(a), vy = at(c + 1) - at(a + 1), vz = at(c + 2) - at(a + 2);
    const nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    for (const corner of [a, b, c]) {
      out[corner] = (out[corner] as number) + nx;
      out[corner + 1] = (out[corner + 1] as number) + ny;
      out[corner + 2] = (out[corner + 2] as number) + nz;
    }
  }
  for (let i = 0; i < out.length; i += 3) {
    const size = Math.hypot(out[i] as number, out[i + 1] as number, out[i + 2] as number) || 1;
    out[i] = (out[i] as number) / size;
    out[i + 1] = (out[i + 1] as number) / size;
    out[i + 2] = (out[i + 2] as number) / size;
  }
  return out;
}
