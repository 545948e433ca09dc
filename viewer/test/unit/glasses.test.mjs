import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { Vector3 } from "three";
import { load } from "./load.mjs";

const { glassesShape } = await load("scene/glasses_shape.ts");

const rig = readFileSync(new URL("../../../rigs/eyewear.toml", import.meta.url), "utf8");
const PLACES = [...rig.matchAll(/^position_m = (\[.*\])/gm)].map(([, numbers]) => new Vector3(...JSON.parse(numbers)));

const nearest = (line, place) => Math.min(...line.map((point) => point.distanceTo(place)));
const finite = (line) => line.every((point) => [point.x, point.y, point.z].every(Number.isFinite));

test("the rims pass by every sensor before the eyes, a side each", () => {
  const { rims } = glassesShape(PLACES);
  assert.equal(rims.length, 2);
  const front = PLACES.filter((place) => place.z > 0.07);
  assert.equal(front.length, 16);
  for (const place of front) assert.ok(Math.min(...rims.map((rim) => nearest(rim, place))) < 0.005, `${place.toArray()}`);
  assert.ok(rims[0].every((point) => point.x > 0.005));
  assert.ok(rims[1].every((point) => point.x < -0.005));
});

test("left and right mirror each other", () => {
  const { rims } = glassesShape(PLACES);
  const mirrored = rims[1].map((point) => new Vector3(-point.x, point.y, point.z));
  for (const point of rims[0]) assert.ok(nearest(mirrored, point) < 0.0015);
});

test("hooks reach the sensors at the jaw, and temples go behind the ears", () => {
  const { arms } = glassesShape(PLACES);
  assert.equal(arms.length, 5);
  for (const place of PLACES.filter((one) => one.z < 0.07)) assert.ok(Math.min(...arms.map((arm) => nearest(arm, place))) < 0.001);
  assert.equal(arms.filter((arm) => arm.some((point) => point.z < -0.01)).length, 2);
});

test("any rig gives a frame: one sensor, all on one side, all in one place", () => {
  const one = new Vector3(0.02, 0.05, 0.11);
  for (const places of [[one], [one, one, one, one, one, one], PLACES.filter((place) => place.x > 0), PLACES.slice(0, 3), [new Vector3()]]) {
    const { rims, arms } = glassesShape(places);
    assert.equal(rims.length, 2);
    assert.ok([...rims, ...arms].every(finite));
  }
});
