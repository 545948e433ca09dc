// The look for graphics cards that are none: which hair it draws, and its tone curve.
import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./load.mjs";

const { outermost } = await load("scene/plain_look.ts");
const { toned } = await load("scene/studio.ts");

test("ribbons stay whole, the outermost come first, and the share is theirs", () => {
  // Two ribbons of two triangles: vertices 0 to 3 near the middle, 4 to 7 far from it.
  const places = Float32Array.of(1, 0, 0, 1, 1, 0, -1, 0, 0, -1, 1, 0, 9, 0, 0, 9, 1, 0, -9, 0, 0, -9, 1, 0);
  const inner = [0, 1, 2, 2, 1, 3], outer = [4, 5, 6, 6, 5, 7];
  assert.deepEqual(outermost([...inner, ...outer], places, 1), [...outer, ...inner]);
  assert.deepEqual(outermost([...inner, ...outer], places, 0.5), outer);
  assert.deepEqual(outermost([], places, 0.5), []);
});

test("the tone curve is sRGB's below its knee, grows, and ends at white", () => {
  const byte = (light) => {
    const out = new Uint8Array(4);
    toned(light, light, light, out, 0);
    return out[0];
  };
  assert.equal(byte(0), 0);
  assert.equal(byte(-1), 0);
  assert.equal(byte(0.2158605), 128);
  assert.equal(byte(1e9), 255);
  for (let light = 0; light < 4; light += 0.1) assert.ok(byte(light + 0.1) >= byte(light));
});
