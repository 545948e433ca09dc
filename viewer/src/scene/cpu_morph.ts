/**
 * Moves a mesh by its morph targets before it is drawn. Graphics cards do this in each pass for every vertex and every
 * target, moved or not; a card that is software spends most of a picture on it. Here only the vertices that a shape moves
 * are touched, only by shapes in use, and only when a weight has changed.
 */
import { BufferGeometry, DynamicDrawUsage, Float32BufferAttribute, type Mesh } from "three";
import { numbersOf } from "./attributes";
import { addSparse, sparse, type Sparse } from "./sparse";

/** A mesh's surface at rest with its morph targets, whoever moves it. */
export function atRest(mesh: Mesh): BufferGeometry {
  return (mesh.userData["atRest"] as BufferGeometry | undefined) ?? mesh.geometry;
}

interface Moved {
  rest: Float32Array;
  targets: Sparse[];
  out: Float32BufferAttribute;
}

export class CpuMorph {
  private readonly moved: Moved[] = [];
  private readonly applied: Float32Array;

  /** Null for a mesh without targets, or with ones that three.js has to move: absolute ones, and colours. */
  static of(mesh: Mesh): CpuMorph | null {
    const { morphAttributes, morphTargetsRelative } = mesh.geometry;
    if (!morphAttributes.position?.length || morphAttributes.color || !morphTargetsRelative) return null;
    return mesh.morphTargetInfluences ? new CpuMorph(mesh) : null;
  }

  /** From now on the mesh draws a geometry of its own, without targets; `atRest` still has them. */
  private constructor(private readonly mesh: Mesh) {
    const rest = mesh.geometry;
    const drawn = new BufferGeometry();
    for (const [name, attribute] of Object.entries(rest.attributes)) drawn.setAttribute(name, attribute);
    drawn.setIndex(rest.index);
    for (const { start, count, materialIndex } of rest.groups) drawn.addGroup(start, count, materialIndex);
    for (const name of ["position", "normal"] as const) {
      const base = rest.attributes[name];
      const targets = rest.morphAttributes[name];
      if (!base || !targets) continue;
      const numbers = numbersOf(base);
      const out = new Float32BufferAttribute(numbers.slice(), 3);
      out.setUsage(DynamicDrawUsage);
      drawn.setAttribute(name, out);
      this.moved.push({ rest: numbers, targets: targets.map((target) => sparse(numbersOf(target))), out });
    }
    this.applied = new Float32Array(rest.morphAttributes.position?.length ?? 0);
    mesh.userData["atRest"] = rest;
    mesh.geometry = drawn;
  }

  /** Brings the surface to the mesh's present influences. */
  update(): void {
    const influences = this.mesh.morphTargetInfluences ?? [];
    let changed = false;
    for (let k = 0; k < this.applied.length; ++k) {
      const weight = Math.fround(influences[k] ?? 0);
      changed ||= weight !== this.applied[k];
      this.applied[k] = weight;
    }
    if (!changed) return;
    for (const { rest, targets, out } of this.moved) {
      const numbers = out.array as Float32Array;
      numbers.set(rest);
      targets.forEach((target, k) => addSparse(target, this.applied[k] as number, numbers));
      out.needsUpdate = true;
    }
  }
}
