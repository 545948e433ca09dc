/** What one morph target moves, and nothing of the rest. */
export interface Sparse {
  /** Vertices that move. */
  vertices: Uint32Array;
  /** By how much: three numbers each. */
  deltas: Float32Array;
}

/** Of three numbers a vertex, those that are not all zero. */
export function sparse(dense: Float32Array): Sparse {
  const moving: number[] = [];
  for (let v = 0; 3 * v < dense.length; ++v) {
    if (dense[3 * v] !== 0 || dense[3 * v + 1] !== 0 || dense[3 * v + 2] !== 0) moving.push(v);
  }
  const deltas = new Float32Array(3 * moving.length);
  moving.forEach((v, i) => deltas.set(dense.subarray(3 * v, 3 * v + 3), 3 * i));
  return { vertices: Uint32Array.from(moving), deltas };
}

/** Adds `weight` times a target to three numbers a vertex. */
export function addSparse({ vertices, deltas }: Sparse, weight: number, to: Float32Array): void {
  if (weight === 0) return;
  for (let i = 0; i < vertices.length; ++i) {
    const at = 3 * (vertices[i] as number);
    to[at] = (to[at] as number) + weight * (deltas[3 * i] as number);
    to[at + 1] = (to[at + 1] as number) + weight * (deltas[3 * i + 1] as number);
    to[at + 2] = (to[at + 2] as number) + weight * (deltas[3 * i + 2] as number);
  }
}
