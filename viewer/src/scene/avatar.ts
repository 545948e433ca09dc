/** A head that can be told what to do: the session's own face, or a file that somebody dropped. */
import { Box3, Group, Vector3, type Material, type Mesh, type Object3D, type SkinnedMesh, type Texture } from "three";
import type { Pose } from "../playout";
import type { PicturePaths, SkinPictures } from "./skin_pictures";

export interface Avatar {
  /** Scaled and moved so that its face is where the built-in one's is: metres, +Y up, +Z out of the face. */
  readonly object: Group;
  readonly name: string;
  /** The mesh on which sensors are placed; null where no mesh has morph targets. */
  readonly face: Mesh | null;
  /** What hangs here follows the head; placed as on the built-in face, metres, frame H. */
  readonly worn: Group;
  /** How many of the 53 shapes it can show. */
  readonly known: number;
  /** When its light is found; until then it is drawn without shade in its folds. */
  readonly settled?: Promise<void>;
  /** Draws it lit a vertex at a time; missing where only the fine look is known. */
  readonly setPlain?: (plain: boolean) => void;
  /** Where pictures of its skin lie; null where it has none. */
  readonly pictures?: PicturePaths | null;
  /** Shows them in the fine look; null: no longer. */
  readonly wearPictures?: (pictures: SkinPictures | null) => void;
  apply(pose: Pose): void;
  dispose(): void;
}

/** `movingBoxIn` of the built-in face, frame H, m: every other face is laid over it. */
export const FACE_BOX = new Box3(new Vector3(-0.0733, -0.1263, 0.0122), new Vector3(0.0733, 0.0845, 0.1177));

/** Puts `content`, whose moving face is `box`, where the built-in one's face is. */
export function placeOver(content: Object3D, box: Box3, reference: Box3): Group {
  const size = box.getSize(new Vector3());
  const wanted = reference.getSize(new Vector3());
  const scale = size.y > 1e-9 ? wanted.y / size.y : 1;
  const group = new Group();
  group.scale.setScalar(scale);
  const centre = box.getCenter(new Vector3());
  const target = reference.getCenter(new Vector3());
  // By the front, not by the middle: how deep a face's moving part goes differs most between files.
  group.position.set(
    target.x - centre.x * scale,
    target.y - centre.y * scale,
    reference.max.z - box.max.z * scale,
  );
  group.add(content);
  const outer = new Group();
  outer.add(group);
  return outer;
}

/** A group for what a head wears. `head` turns, and is at rest now; without one, all of `object` is worn on. */
export function hangOn(object: Group, head: Object3D | null): Group {
  object.updateWorldMatrix(true, true);
  const node = head ?? object;
  const worn = new Group();
  worn.applyMatrix4(node.matrixWorld.clone().invert());
  node.add(worn);
  return worn;
}

/** Gives back what the graphics card holds of a tree. */
export function disposeTree(root: Object3D): void {
  root.traverse((node) => {
    const mesh = node as Mesh;
    if (!mesh.isMesh) return;
    mesh.geometry.dispose();
    (mesh as Partial<SkinnedMesh>).skeleton?.dispose();
    for (const material of materialsOf(mesh)) {
      for (const value of Object.values(material)) {
        if ((value as Partial<Texture> | null)?.isTexture) (value as Texture).dispose();
      }
      material.dispose();
    }
  });
}

export function materialsOf(mesh: Mesh): Material[] {
  return Array.isArray(mesh.material) ? mesh.material : [mesh.material];
}
