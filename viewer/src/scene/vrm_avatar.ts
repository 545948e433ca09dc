/**
 * A VRM character, 0 or 1. Shapes go to the expressions that are named after them (Perfect Sync), else to morph targets
 * that are, and where neither is, to the few expressions that every VRM has.
 */
import { VRMUtils, type VRM } from "@pixiv/three-vrm";
import { Quaternion, type Group, type Mesh, type Object3D } from "three";
import type { Pose } from "../playout";
import { shapeIndex } from "../shapes";
import { disposeTree, FACE_BOX, hangOn, placeOver, type Avatar } from "./avatar";
import { bindNames, driven, type Drive } from "./binding";
import { faceMesh, movingBoxIn, richestMesh } from "./moving_skin";

/** With at least this many shapes of its own a file speaks for itself, and the presets stay out of it. */
const ENOUGH_SHAPES = 20;

/** What the common expressions are made of where there is nothing finer. */
const PRESETS: readonly (readonly [string, readonly string[], number])[] = [
  ["blinkLeft", ["eyeBlink_L"], 1],
  ["blinkRight", ["eyeBlink_R"], 1],
  ["aa", ["jawOpen"], 1.4],
  ["ou", ["mouthPucker"], 0.9],
  ["oh", ["mouthFunnel"], 0.9],
  ["ih", ["mouthStretch_L", "mouthStretch_R"], 0.6],
  ["happy", ["mouthSmile_L", "mouthSmile_R"], 0.8],
  ["angry", ["browDown_L", "browDown_R"], 0.7],
  ["sad", ["mouthFrown_L", "mouthFrown_R"], 0.7],
  ["surprised", ["browOuterUp_L", "browOuterUp_R"], 0.6],
];

export class VrmAvatar implements Avatar {
  readonly object: Group;
  readonly name: string;
  readonly face: Mesh | null;
  readonly worn: Group;
  readonly known: number;

  private readonly expressions: Drive<string>[];
  private readonly targets: { mesh: Mesh; drives: Drive<number>[] }[] = [];
  private readonly usePresets: boolean;
  private readonly head: Object3D | null;
  private readonly rest = new Quaternion();

  constructor(private readonly vrm: VRM, name: string) {
    this.name = name;
    VRMUtils.rotateVRM0(vrm);
    vrm.scene.traverse((node) => {
      node.frustumCulled = false;
      node.castShadow = true;
    });
    const manager = vrm.expressionManager;
    this.expressions = bindNames(Object.keys(manager?.expressionMap ?? {}).map((key) => [key, key] as const));
    const known = new Set(this.expressions.flatMap((drive) => [...drive.shapes]));
    if (known.size < ENOUGH_SHAPES) {
      vrm.scene.traverse((node) => {
        const mesh = node as Mesh;
        if (!mesh.isMesh || !mesh.morphTargetDictionary) return;
        const drives = bindNames(Object.entries(mesh.morphTargetDictionary)).filter(
          (drive) => !drive.shapes.some((shape) => this.expressions.some((one) => one.shapes.includes(shape))),
        );
        for (const drive of drives) for (const shape of drive.shapes) known.add(shape);
        if (drives.length > 0) this.targets.push({ mesh, drives });
      });
    }
    this.known = known.size;
    this.usePresets = known.size < ENOUGH_SHAPES;
    this.head = vrm.humanoid.getNormalizedBoneNode("head");
    if (this.head) this.rest.copy(this.head.quaternion);
    this.face = faceMesh(vrm.scene) ?? richestMesh(vrm.scene);
    this.object = this.placed();
    this.worn = hangOn(this.object, this.head);
  }

  apply(pose: Pose): void {
    const manager = this.vrm.expressionManager;
    if (manager) {
      if (this.usePresets) {
        for (const [expression, shapes, gain] of PRESETS) {
          const weight = driven(shapes.map(shapeIndex), pose) * gain;
          manager.setValue(expression, Math.min(1, Math.max(0, weight)));
        }
      }
      for (const drive of this.expressions) manager.setValue(drive.target, driven(drive.shapes, pose));
    }
    const lookAt = this.vrm.lookAt;
    if (lookAt) {
      lookAt.autoUpdate = false;
      const [yawLeft, pitchLeft, yawRight, pitchRight] = pose.eyes;
      // VRM's eyes look the same way: the mean of ours, degrees, yaw to the character's left, pitch downwards.
      lookAt.applier.applyYawPitch(((yawLeft + yawRight) / 2) * DEGREES, -((pitchLeft + pitchRight) / 2) * DEGREES);
    }
    if (this.head) {
      const [w, x, y, z] = pose.head;
      this.head.quaternion.set(x, y, z, w).multiply(this.rest);
    }
    this.vrm.update(0);
    for (const { mesh, drives } of this.targets) {
      for (const drive of drives) {
        if (mesh.morphTargetInfluences) mesh.morphTargetInfluences[drive.target] = driven(drive.shapes, pose);
      }
    }
  }

  dispose(): void {
    disposeTree(this.object);
  }

  /** By the face's moving part where its mesh is known, else by the head's bone. */
  private placed(): Group {
    const scene = this.vrm.scene;
    scene.updateWorldMatrix(true, true);
    if (this.face) {
      const box = movingBoxIn(scene, this.face).applyMatrix4(scene.matrix);
      return placeOver(scene, box, FACE_BOX);
    }
    const box = FACE_BOX.clone();
    if (this.head) {
      const at = this.head.getWorldPosition(box.getCenter(FACE_BOX.min.clone()));
      // A head's bone is at the top of the neck: the face begins about there.
      box.min.set(at.x - 0.09, at.y, at.z - 0.02);
      box.max.set(at.x + 0.09, at.y + 0.19, at.z + 0.1);
    }
    return placeOver(scene, box, FACE_BOX);
  }
}

const DEGREES = 180 / Math.PI;
