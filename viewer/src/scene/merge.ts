/**
 * glTF splits a mesh by material, and three.js then keeps every morph target once for each piece. Pieces that share
 * their vertices are joined again, with one material a group: a head of eight materials takes an eighth of the memory.
 */
import { BufferGeometry, Mesh, Uint32BufferAttribute, type Material, type Object3D } from "three";

/** Joins what can be joined among the children of every node below `root`. */
export function mergePieces(root: Object3D): void {
  const parents: Object3D[] = [];
  root.traverse((node) => parents.push(node));
  for (const parent of parents) {
    const byVertices = new Map<unknown, Mesh[]>();
    for (const child of parent.children) {
      if (!isPlainMesh(child)) continue;
      const vertices = child.geometry.attributes["position"];
      byVertices.set(vertices, [...(byVertices.get(vertices) ?? []), child]);
    }
    for (const pieces of byVertices.values()) {
      if (pieces.length > 1) parent.add(joined(pieces));
    }
  }
}

function isPlainMesh(node: Object3D): node is Mesh<BufferGeometry, Material> {
  const mesh = node as Partial<Mesh>;
  return (
    mesh.isMesh === true &&
    !Array.isArray(mesh.material) &&
    (node as { isSkinnedMesh?: boolean }).isSkinnedMesh !== true &&
    mesh.geometry?.index != null &&
    node.children.length === 0
  );
}

function joined(pieces: Mesh[]): Mesh {
  const first = pieces[0] as Mesh;
  const geometry = new BufferGeometry();
  // Pieces may have attributes that others lack: colours where no picture shows them.
  for (const piece of pieces) {
    for (const [name, attribute] of Object.entries(piece.geometry.attributes)) {
      if (!geometry.hasAttribute(name)) geometry.setAttribute(name, attribute);
    }
  }
  Object.assign(geometry.morphAttributes, first.geometry.morphAttributes);
  geometry.morphTargetsRelative = first.geometry.morphTargetsRelative;
  const indices: number[] = [];
  const materials: Material[] = [];
  pieces.forEach((piece, number) => {
    const index = piece.geometry.index;
    if (!index) return;
    geometry.addGroup(indices.length, index.count, number);
    for (let i = 0; i < index.count; ++i) indices.push(index.getX(i));
    materials.push(piece.material as Material);
    piece.removeFromParent();
  });
  geometry.setIndex(new Uint32BufferAttribute(indices, 1));
  const mesh = new Mesh(geometry, materials);
  mesh.name = first.parent?.name ?? first.name;
  mesh.position.copy(first.position);
  mesh.quaternion.copy(first.quaternion);
  mesh.scale.copy(first.scale);
  if (first.morphTargetDictionary) mesh.morphTargetDictionary = { ...first.morphTargetDictionary };
  mesh.morphTargetInfluences = (first.morphTargetInfluences ?? []).slice();
  return mesh;
}
