import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./load.mjs";

const { Pace } = await load("scene/pace.ts");

function draw(pace, count, intervalMs, fromMs = 0) {
  let now = fromMs;
  let changes = 0;
  for (let i = 0; i < count; ++i) if (pace.drew((now += intervalMs))) ++changes;
  return changes;
}

test("a quick display keeps the best picture", () => {
  const pace = new Pace();
  assert.equal(draw(pace, 1000, 16.7), 0);
  assert.deepEqual(pace.quality, { sharpness: 1, shadows: true, plain: false });
});

test("a slow one gets coarser pictures, and in time even where each takes seconds", () => {
  for (const intervalMs of [50, 400, 2500]) {
    const pace = new Pace();
    draw(pace, 100, intervalMs);
    assert.deepEqual(pace.quality, { sharpness: 0.55, shadows: false, plain: true }, String(intervalMs));
  }
});

test("pauses and single hitches are not taken for slowness", () => {
  const pace = new Pace();
  for (let i = 0; i < 200; ++i) pace.drew(i * 60_000);
  for (let i = 0; i < 400; ++i) pace.drew(2e7 + i * 16 + (i % 10 === 0 ? 8 : 0));
  assert.equal(pace.quality.sharpness, 1);
});

test("one that begins coarse stays so", () => {
  const pace = new Pace("coarsest");
  assert.equal(draw(pace, 500, 16), 0);
  assert.equal(pace.quality.shadows, false);
});
