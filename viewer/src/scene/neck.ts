/**
 * A head that turns as one stiff piece tears its shoulders about. A mesh without a skeleton is given two bones: the head's,
 * and the body's that stays; between chin and collar the skin goes over from one to the other.
 */
import {
  Bone, Float32BufferAttribute, Matrix4, Skeleton, SkinnedMesh, Uint8BufferAttribute, Vector3, type Mesh, type Object3D,
} from "three";

export interface Neck {
  /** Turn this to turn the head. */
  head: Object3D;
}

/**
 * Replaces every plain mesh below `root` by one that follows the bones. `pivot`, `top` and `bottom` in `root`'s own
 * coordinates: the point about which the head turns, the height above which all of it does, and that below which nothing.
 */
export function giveNeck(root: Object3D, pivot: Vector3, top: number, bottom: number): Neck {
  root.updateWorldMatrix(true, true);
  const body = new Bone();
  body.name = "mien_body";
  const head = new Bone();
  head.name = "mien_head";
  head.position.copy(pivot);
  body.add(head);
  root.add(body);
  root.updateWorldMatrix(true, true);

  const meshes: Mesh[] = [];
  root.traverse((node) => {
    if ((node as Mesh).isMesh) meshes.push(node as Mesh);
  });
  for (const mesh of meshes) {
    const toRoot = new Matrix4().copy(root.matrixWorld).invert().multiply(mesh.matrixWorld);
    const reaches = lowest(mesh, toRoot) < top;
    if (!reaches) {
      head.attach(mesh);
      continue;
    }
    const skinned = new SkinnedMesh(mesh.geometry, mesh.material);
    skinned.name = mesh.name;
    skinned.castShadow = mesh.castShadow;
    skinned.receiveShadow = mesh.receiveShadow;
    if (mesh.morphTargetDictionary) skinned.morphTargetDictionary = mesh.morphTargetDictionary;
    if (mesh.morphTargetInfluences) skinned.morphTargetInfluences = mesh.morphTargetInfluences;
    skinned.position.copy(mesh.position);
    skinned.quaternion.copy(mesh.quaternion);
    skinned.scale.copy(mesh.scale);
    skinned.frustumCulled = false;
    weigh(skinned, toRoot, top, bottom);
    for (const child of [...mesh.children]) skinned.add(child);
    mesh.parent?.add(skinned);
    mesh.removeFromParent();
    skinned.updateWorldMatrix(true, false);
    skinned.bind(new Skeleton([body, head]));
  }
  return { head };
}

function lowest(mesh: Mesh, toRoot: Matrix4): number {
  const positions = mesh.geometry.attributes["position"];
  const point = new Vector3();
  let low = Infinity;
  for (let v = 0; positions && v < positions.count; ++v) {
    low = Math.min(low, point.fromBufferAttribute(positions, v).applyMatrix4(toRoot).y);
  }
  return low;
}

function weigh(mesh: SkinnedMesh, toRoot: Matrix4, top: number, bottom: number): void {
  const positions = mesh.geometry.attributes["position"];
  if (!positions) return;
  const indices = new Uint8Array(positions.count * 4);
  const weights = new Float32Array(positions.count * 4);
  const point = new Vector3();
  for (let v = 0; v < positions.count; ++v) {
    const height = point.fromBufferAttribute(positions, v).applyMatrix4(toRoot).y;
    const share = Math.min(1, Math.max(0, (height - bottom) / (top - bottom)));
    const head = share * share * (3 - 2 * share);
    indices[4 * v + 1] = 1;
    weights[4 * v] = 1 - head;
    weights[4 * v + 1] = head;
  }
  mesh.geometry.setAttribute("skinIndex", new Uint8BufferAttribute(indices, 4));
  mesh.geometry.setAttribute("skinWeight", new Float32BufferAttribute(weights, 4));
}
