/** Where a head's face is and how large: told by the vertices that its shapes move. */
import { Box3, Matrix4, Vector3, type Mesh, type Object3D } from "three";
import { shapesOfName } from "../shapes";
import { atRest } from "./cpu_morph";

/** The mesh that has most of our shapes; null where none has any. */
export function faceMesh(root: Object3D): Mesh | null {
  let best: Mesh | null = null;
  let most = 0;
  root.traverse((node) => {
    const mesh = node as Mesh;
    if (!mesh.isMesh || !mesh.morphTargetDictionary) return;
    const known = Object.keys(mesh.morphTargetDictionary).filter((name) => shapesOfName(name).length > 0).length;
    const score = known * 1e6 + (atRest(mesh).attributes["position"]?.count ?? 0);
    if (known > 0 && score > most) {
      most = score;
      best = mesh;
    }
  });
  return best;
}

/** The mesh with the most morph targets, whatever they are called: the face of a file that names its shapes elsewhere. */
export function richestMesh(root: Object3D): Mesh | null {
  let best: Mesh | null = null;
  let most = 0;
  root.traverse((node) => {
    const mesh = node as Mesh;
    const targets = mesh.isMesh ? (atRest(mesh).morphAttributes.position?.length ?? 0) : 0;
    if (targets > most) {
      most = targets;
      best = mesh;
    }
  });
  return best;
}

/** The box of all that moves by more than a hundredth of the mesh's size, in the mesh's own coordinates. */
export function movingBox(mesh: Mesh): Box3 {
  const positions = atRest(mesh).attributes["position"];
  const targets = atRest(mesh).morphAttributes.position ?? [];
  const box = new Box3();
  if (!positions) return box;
  const whole = new Box3();
  const point = new Vector3();
  for (let v = 0; v < positions.count; ++v) whole.expandByPoint(point.fromBufferAttribute(positions, v));
  const least = whole.getSize(point).length() * 0.005;
  const delta = new Vector3();
  const at = new Vector3();
  for (let v = 0; v < positions.count; ++v) {
    for (const target of targets) {
      at.fromBufferAttribute(positions, v);
      delta.fromBufferAttribute(target, v);
      if (!atRest(mesh).morphTargetsRelative) delta.sub(at);
      if (delta.length() <= least) continue;
      box.expandByPoint(at);
      break;
    }
  }
  return box.isEmpty() ? whole : box;
}

/** The same in the coordinates of `root`, at rest. */
export function movingBoxIn(root: Object3D, mesh: Mesh): Box3 {
  root.updateWorldMatrix(true, true);
  const into = new Matrix4().copy(root.matrixWorld).invert().multiply(mesh.matrixWorld);
  return movingBox(mesh).applyMatrix4(into);
}
