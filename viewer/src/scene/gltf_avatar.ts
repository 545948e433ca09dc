/** A glTF head with named morph targets, with or without a skeleton. */
import { Box3, Euler, Group, Quaternion, Vector3, type Mesh, type Object3D } from "three";
import type { Pose } from "../playout";
import { disposeTree, FACE_BOX, hangOn, materialsOf, placeOver, type Avatar } from "./avatar";
import { CpuMorph } from "./cpu_morph";
import { bindNames, driven, type Drive } from "./binding";
import { dress, wearPictures } from "./materials";
import { mergePieces } from "./merge";
import { addMorphNormals } from "./morph_normals";
import { faceMesh, movingBoxIn } from "./moving_skin";
import { giveNeck } from "./neck";
import { addOpenness, findOpenness } from "./openness";
import { PlainLook } from "./plain_look";
import { picturePaths, type PicturePaths, type SkinPictures } from "./skin_pictures";

/** Heights between which the built-in face's shirt fades, m, frame H. */
const CLOTH = { top: -0.185, bottom: -0.222 };

export interface GltfAvatarOptions {
  name: string;
  /** The session's own face: in frame H already, and with materials whose names we know. */
  own: boolean;
}

export class GltfAvatar implements Avatar {
  readonly object: Group;
  readonly name: string;
  readonly face: Mesh | null;
  readonly worn: Group;
  readonly known: number;
  readonly settled: Promise<void> = Promise.resolve();
  /** Of the session's own face, once it was asked for. */
  private plain: PlainLook | null = null;

  readonly setPlain?: (plain: boolean) => void;
  readonly pictures: PicturePaths | null = null;
  readonly wearPictures?: (pictures: SkinPictures | null) => void;
  private disposed = false;
  private readonly drives: { mesh: Mesh; drives: Drive<number>[] }[] = [];
  private readonly morphs: CpuMorph[] = [];
  private readonly eyes: { node: Object3D; rest: Quaternion; first: number }[] = [];
  private head: { node: Object3D; rest: Quaternion } | null = null;

  /** Throws, with a sentence for the person, when no morph target has a name that we know. */
  constructor(scene: Group, options: GltfAvatarOptions) {
    this.name = options.name;
    mergePieces(scene);
    const face = faceMesh(scene);
    if (!face) throw new Error("No morph target in this file has an ARKit name (jawOpen, eyeBlinkLeft, …).");
    scene.traverse((node) => {
      const mesh = node as Mesh;
      if (!mesh.isMesh) return;
      addMorphNormals(mesh.geometry);
      mesh.frustumCulled = false;
      mesh.castShadow = true;
      mesh.receiveShadow = true;
      for (const material of materialsOf(mesh)) material.shadowSide = 2;
    });
    const box = movingBoxIn(scene, face);
    this.findEyes(scene);
    const bone = findNode(scene, /^(head|.*[:_. ]head)$/i, true);
    if (bone) {
      this.head = { node: bone, rest: bone.quaternion.clone() };
    } else {
      const size = box.getSize(new Vector3());
      const pivot = options.own ? new Vector3(0, -0.02, 0) : box.getCenter(new Vector3()).setZ(box.min.z);
      const top = options.own ? -0.085 : box.min.y;
      const bottom = options.own ? -0.15 : box.min.y - 0.4 * size.y;
      const neck = giveNeck(scene, pivot, top, bottom);
      this.head = { node: neck.head, rest: neck.head.quaternion.clone() };
    }
    if (options.own) {
      for (const material of materialsOf(face)) this.pictures ??= picturePaths(material);
      this.wearPictures = (pictures) => wearPictures(this.object, pictures);
      dress(scene, { cloth: CLOTH, skin: { top: -0.125, bottom: -0.186 } });
      this.object = new Group();
      this.object.add(scene);
      addOpenness(scene);
      this.setPlain = (plain) => {
        if (plain) this.plain ??= new PlainLook(this.object, this.head?.node ?? null, CLOTH);
        this.plain?.show(plain);
      };
      this.settled = findOpenness(scene, () => this.disposed).then(() => this.plain?.relight());
    } else {
      this.object = placeOver(scene, box, FACE_BOX);
    }

    scene.traverse((node) => {
      const morph = (node as Mesh).isMesh ? CpuMorph.of(node as Mesh) : null;
      if (morph) this.morphs.push(morph);
    });
    this.worn = hangOn(this.object, this.head?.node ?? null);

    const known = new Set<number>();
    scene.traverse((node) => {
      const mesh = node as Mesh;
      if (!mesh.isMesh || !mesh.morphTargetDictionary) return;
      const drives = bindNames(Object.entries(mesh.morphTargetDictionary));
      for (const drive of drives) for (const shape of drive.shapes) known.add(shape);
      if (drives.length > 0) this.drives.push({ mesh, drives });
    });
    this.known = known.size;
    // Necks replace meshes: the one with the face is looked for again.
    this.face = faceMesh(this.object);
  }

  apply(pose: Pose): void {
    for (const { mesh, drives } of this.drives) {
      const influences = mesh.morphTargetInfluences;
      if (!influences) continue;
      for (const drive of drives) influences[drive.target] = driven(drive.shapes, pose);
    }
    for (const morph of this.morphs) morph.update();
    for (const eye of this.eyes) {
      const yaw = pose.eyes[eye.first] ?? 0;
      const pitch = pose.eyes[eye.first + 1] ?? 0;
      eye.node.quaternion.copy(eye.rest).multiply(turned.setFromEuler(look.set(-pitch, yaw, 0, "YXZ")));
    }
    if (this.head) {
      const [w, x, y, z] = pose.head;
      this.head.node.quaternion.set(x, y, z, w).multiply(this.head.rest);
    }
    this.plain?.update();
  }

  dispose(): void {
    this.disposed = true;
    this.plain?.dispose();
    // They are not this head's alone.
    this.wearPictures?.(null);
    disposeTree(this.object);
  }

  /**
   * Nodes that are an eye each and turn about themselves: bones, and meshes whose origin lies inside them. Others would fly
   * off when turned; there the eyeLook shapes have to do.
   */
  private findEyes(scene: Object3D): void {
    const sides: [RegExp, number][] = [
      [/^(left[_. ]?eye(ball)?|eye(ball)?[_. ]?(l|left))$/i, 0],
      [/^(right[_. ]?eye(ball)?|eye(ball)?[_. ]?(r|right))$/i, 2],
    ];
    for (const [name, first] of sides) {
      const node = findNode(scene, name, false);
      if (!node) continue;
      const mesh = node as Mesh;
      if (mesh.isMesh) {
        const box = new Box3().setFromBufferAttribute(mesh.geometry.attributes["position"] as never);
        if (!box.containsPoint(new Vector3(0, 0, 0))) continue;
      }
      this.eyes.push({ node, rest: node.quaternion.clone(), first });
    }
  }
}

const look = new Euler();
const turned = new Quaternion();

function findNode(root: Object3D, name: RegExp, onlyBones: boolean): Object3D | null {
  let found: Object3D | null = null;
  root.traverse((node) => {
    if (found || !name.test(node.name)) return;
    if (onlyBones && (node as { isBone?: boolean }).isBone !== true) return;
    found = node;
  });
  return found;
}
