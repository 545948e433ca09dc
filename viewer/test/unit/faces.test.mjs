// Faces of other people's making, without a screen: what the page makes of their names, sizes and bones.
import assert from "node:assert/strict";
import { test } from "node:test";
import { sphereHead } from "../sphere_head.mjs";
import { load } from "./load.mjs";

// The loaders look for these two of a browser's; no test face has pictures.
globalThis.self ??= globalThis;
globalThis.navigator ??= { userAgent: "node" };

const { loadAvatar, refusal, MOST_BYTES } = await load("scene/load_avatar.ts");
const { FACE_BOX } = await load("scene/avatar.ts");
const { movingBoxIn } = await load("scene/moving_skin.ts");
const { nearestVertices, vertexAt } = await load("scene/skin_points.ts");
const { SkinDifference, weightsApart } = await load("scene/difference.ts");
const { restingPose } = await load("playout.ts");
const { shapeIndex } = await load("shapes.ts");
const { Quaternion, Vector3 } = await load("../node_modules/three/build/three.module.js");

const bytes = (buffer) => buffer.buffer.slice(buffer.byteOffset, buffer.byteOffset + buffer.byteLength);
const open = (how = {}, name = "egg.glb", own = false) => loadAvatar(bytes(sphereHead(how)), name, own);

function poseWith(weights, head = [1, 0, 0, 0]) {
  const pose = restingPose();
  for (const [name, weight] of Object.entries(weights)) pose.weights[shapeIndex(name)] = weight;
  pose.head = head;
  return pose;
}

test("all spellings of the names drive the same target", async () => {
  for (const names of ["ict", "arkit", "pascal"]) {
    const avatar = await open({ names });
    assert.equal(avatar.known, 53, names);
    avatar.apply(poseWith({ jawOpen: 0.7, mouthSmile_L: 0.3 }));
    const { morphTargetDictionary: places, morphTargetInfluences: weights } = avatar.face;
    const weightOf = (shape) => weights[Object.entries(places).find(([name]) => name.toLowerCase() === shape.toLowerCase())[1]];
    assert.ok(Math.abs(weightOf(names === "pascal" ? "JawOpen" : "jawOpen") - 0.7) < 1e-6);
    assert.ok(Math.abs(weightOf(names === "ict" ? "mouthSmile_L" : "mouthSmileLeft") - 0.3) < 1e-6);
  }
});

test("a VRM is driven through its Perfect Sync expressions", async () => {
  const avatar = await open({ names: "pascal", vrm: true }, "egg.vrm");
  assert.equal(avatar.known, 53);
  avatar.apply(poseWith({ jawOpen: 0.7 }));
  assert.ok(Math.abs(avatar.face.morphTargetInfluences[shapeIndex("jawOpen")] - 0.7) < 1e-5);
  // Its targets have no names of ours, so nothing can be said in millimetres.
  assert.equal(new SkinDifference(avatar.face, 1).between(poseWith({ jawOpen: 1 }).weights, poseWith({}).weights), null);
});

test("a face in centimetres is brought over the built-in one", async () => {
  for (const scale of [1, 100, 0.01]) {
    const avatar = await open({ scale });
    const box = movingBoxIn(avatar.object, avatar.face);
    assert.ok(Math.abs(box.max.y - FACE_BOX.max.y) < 2e-3, `${scale}: ${box.max.y}`);
    assert.ok(Math.abs(box.max.z - FACE_BOX.max.z) < 2e-3, `${scale}: ${box.max.z}`);
  }
});

test("the head turns and the collar stays", async () => {
  const avatar = await open({});
  const mesh = avatar.face;
  const [crown, collar] = nearestVertices(mesh, [new Vector3(0, 0.2, 0.02), new Vector3(0, -0.25, 0.02)]);
  const rest = [vertexAt(mesh, crown, new Vector3(), true), vertexAt(mesh, collar, new Vector3(), true)];
  const turn = new Quaternion().setFromAxisAngle(new Vector3(1, 0, 0), 0.5);
  avatar.apply(poseWith({}, [turn.w, turn.x, turn.y, turn.z]));
  avatar.object.updateMatrixWorld(true);
  assert.ok(vertexAt(mesh, crown, new Vector3(), true).distanceTo(rest[0]) > 0.02);
  assert.ok(vertexAt(mesh, collar, new Vector3(), true).distanceTo(rest[1]) < vertexAt(mesh, crown, new Vector3(), true).distanceTo(rest[0]));
});

test("eyes turn about themselves", async () => {
  const avatar = await open({});
  const eye = avatar.object.getObjectByName("eye_L");
  const before = eye.getWorldPosition(new Vector3());
  const pose = restingPose();
  pose.eyes = [0.4, 0, 0.4, 0];
  avatar.apply(pose);
  avatar.object.updateMatrixWorld(true);
  assert.ok(eye.getWorldPosition(new Vector3()).distanceTo(before) < 1e-6);
  // Yaw is to the performer's left, which is +X.
  const look = new Vector3(0, 0, 1).applyQuaternion(eye.getWorldQuaternion(new Quaternion()));
  assert.ok(look.x > 0.3 && Math.abs(look.y) < 1e-6);
});

test("sensors stick to the skin as it moves", async () => {
  const avatar = await open({});
  const [chin] = nearestVertices(avatar.face, [new Vector3(0, -0.1, 0.1)]);
  const rest = vertexAt(avatar.face, chin, new Vector3(), true);
  avatar.apply(poseWith({ jawOpen: 1 }));
  const moved = vertexAt(avatar.face, chin, new Vector3(), true);
  assert.ok(moved.y < rest.y - 0.005, `${rest.y} to ${moved.y}`);
});

test("the difference of two faces is in millimetres of skin", async () => {
  const avatar = await open({});
  const difference = new SkinDifference(avatar.face, 1);
  const open1 = poseWith({ jawOpen: 1 }).weights;
  const rest = poseWith({}).weights;
  assert.deepEqual(difference.between(rest, rest), { meanMm: 0, maxMm: 0 });
  const full = difference.between(open1, rest);
  assert.ok(full.maxMm > 25 && full.maxMm < 32, String(full.maxMm));
  const half = difference.between(poseWith({ jawOpen: 0.5 }).weights, rest);
  assert.ok(Math.abs(half.meanMm - full.meanMm / 2) < 1e-3);
});

test("what cannot be shown is refused with a sentence", async () => {
  assert.match(refusal("head.fbx", 1000), /\.glb or \.vrm/);
  assert.match(refusal("head.glb", MOST_BYTES + 1), /at most 256 MB/);
  assert.match(refusal("head.glb", 0), /empty/);
  assert.equal(refusal("head.VRM", 1000), null);
  await assert.rejects(loadAvatar(new ArrayBuffer(100), "x.glb", false), /not a glTF binary/);
  await assert.rejects(loadAvatar(new ArrayBuffer(3), "x.vrm", false), /not a glTF binary/);
  const cut = bytes(sphereHead()).slice(0, 5000);
  await assert.rejects(loadAvatar(cut, "x.glb", false), /could not be read/);
  await assert.rejects(open({ without: ["all"], names: "ict" }).then(async () => {
    const { SHAPES } = await load("shapes.ts");
    return open({ without: [...SHAPES] });
  }), /ARKit name/);
});

test("of weights the furthest off is named, and none where all agree", () => {
  const truth = new Float32Array(53).fill(0.25);
  assert.deepEqual(weightsApart(truth, truth), { mean: 0, furthest: null });
  const near = truth.map((weight) => weight + 0.0003);
  assert.equal(weightsApart(near, truth).furthest, null, "what shows as 0.000 is not blamed on a shape");
  const off = Float32Array.from(truth);
  off[7] = 0.5;
  off[9] = 0;
  off[20] = 0.78;
  const apart = weightsApart(off, truth);
  assert.equal(apart.furthest, 20);
  assert.ok(Math.abs(apart.mean - 1.03 / 53) < 1e-6);
});
