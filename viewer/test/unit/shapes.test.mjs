import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./load.mjs";

const { REGIONS, SHAPES, SHAPE_COUNT, TONGUE, shapeIndex, shapeLabel, shapesOfName } = await load("shapes.ts");

test("every shape and the tongue stand in the regions once", () => {
  const seen = new Map();
  for (const row of REGIONS.flatMap((region) => region.rows)) {
    for (const shape of new Set([row.left, row.right])) seen.set(shape, (seen.get(shape) ?? 0) + 1);
  }
  assert.deepEqual([...seen.keys()].sort((a, b) => a - b), Array.from({ length: SHAPE_COUNT + 1 }, (_, i) => i));
  assert.ok([...seen.values()].every((count) => count === 1));
});

test("labels are told apart", () => {
  const labels = SHAPES.map((_, i) => shapeLabel(i));
  assert.equal(new Set(labels).size, SHAPE_COUNT);
  assert.equal(shapeLabel(shapeIndex("mouthLowerDown_L")), "Lower lip down, left");
  assert.equal(shapeLabel(shapeIndex("jawLeft")), "Jaw sideways, left");
});

test("names of other people's files are understood", () => {
  const left = [shapeIndex("eyeBlink_L")];
  for (const name of ["eyeBlink_L", "eyeBlinkLeft", "EyeBlinkLeft", "EyeBlink_L", "eye_blink_left", "Face.eyeBlink_L", "blendShape1.eyeBlinkLeft", "EYEBLINKLEFT"]) {
    assert.deepEqual([...shapesOfName(name)], left, name);
  }
  assert.deepEqual([...shapesOfName("JawOpen")], [shapeIndex("jawOpen")]);
  assert.deepEqual([...shapesOfName("jawLeft")], [shapeIndex("jawLeft")]);
  assert.deepEqual([...shapesOfName("mouthLeft")], [shapeIndex("mouthLeft")]);
  assert.deepEqual([...shapesOfName("browInnerUp")], [shapeIndex("browInnerUp_L"), shapeIndex("browInnerUp_R")]);
  assert.deepEqual([...shapesOfName("CheekPuff")], [shapeIndex("cheekPuff_L"), shapeIndex("cheekPuff_R")]);
  assert.deepEqual([...shapesOfName("tongueOut")], [TONGUE]);
});

test("names of nothing are nothing", () => {
  for (const name of ["", ".", "smile", "Fcl_ALL_Joy", "eyeBlink", "toString", "__proto__", "jawOpen2"]) assert.deepEqual([...shapesOfName(name)], [], name);
});
