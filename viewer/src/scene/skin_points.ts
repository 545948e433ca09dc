/** Points that stick to a face's skin while it moves: where a sensor sits. */
import { Matrix4, Vector3, type BufferAttribute, type InterleavedBufferAttribute, type Mesh, type SkinnedMesh } from "three";
import { atRest } from "./cpu_morph";

/** The vertex nearest to each wanted place (coordinates of the world at rest). */
export function nearestVertices(mesh: Mesh, places: readonly Vector3[]): number[] {
  const positions = atRest(mesh).attributes["position"];
  const nearest = places.map(() => -1);
  if (!positions) return nearest;
  mesh.updateWorldMatrix(true, false);
  const best = places.map(() => Infinity);
  const point = new Vector3();
  for (let v = 0; v < positions.count; ++v) {
    vertexAt(mesh, v, point, false);
    places.forEach((place, i) => {
      const distance = place.distanceToSquared(point);
      if (distance < (best[i] ?? 0)) {
        best[i] = distance;
        nearest[i] = v;
      }
    });
  }
  return nearest;
}

const inverse = new Matrix4();

/** Where vertex `v` of a mesh is in the world; `moved`: with its morph targets. */
export function vertexAt(mesh: Mesh, v: number, out: Vector3, moved: boolean): Vector3 {
  const positions = atRest(mesh).attributes["position"];
  if (!positions) return out.set(0, 0, 0);
  out.fromBufferAttribute(positions, v);
  if (moved) addTargets(mesh, atRest(mesh).morphAttributes.position, v, out);
  const skinned = mesh as SkinnedMesh;
  if (skinned.isSkinnedMesh) skinned.applyBoneTransform(v, out);
  return out.applyMatrix4(mesh.matrixWorld);
}

/** The direction out of the skin at vertex `v` at present, in the world. */
export function normalAt(mesh: Mesh, v: number, out: Vector3): Vector3 {
  const normals = atRest(mesh).attributes["normal"];
  if (!normals) return out.set(0, 0, 1);
  out.fromBufferAttribute(normals, v);
  addTargets(mesh, atRest(mesh).morphAttributes.normal, v, out);
  const skinned = mesh as SkinnedMesh;
  if (skinned.isSkinnedMesh) {
    // Turned like the point: the difference of two points of the same vertex.
    const tip = out.clone().normalize().multiplyScalar(1e-3);
    const foot = new Vector3().fromBufferAttribute(atRest(mesh).attributes["position"] as BufferAttribute, v);
    tip.add(foot);
    skinned.applyBoneTransform(v, tip);
    skinned.applyBoneTransform(v, foot);
    out.copy(tip).sub(foot);
  }
  inverse.extractRotation(mesh.matrixWorld);
  return out.applyMatrix4(inverse).normalize();
}

const delta = new Vector3();

function addTargets(
  mesh: Mesh,
  targets: readonly (BufferAttribute | InterleavedBufferAttribute)[] | undefined,
  v: number,
  out: Vector3,
): void {
  const influences = mesh.morphTargetInfluences;
  if (!targets || !influences || !atRest(mesh).morphTargetsRelative) return;
  for (let k = 0; k < targets.length; ++k) {
    const influence = influences[k] ?? 0;
    const target = targets[k];
    if (influence !== 0 && target) out.addScaledVector(delta.fromBufferAttribute(target, v), influence);
  }
}
