import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./load.mjs";

const { History } = await load("history.ts");

function frame(time, weight, truth = null) {
  return { time, weights: new Float32Array(53).fill(weight), truth: truth === null ? null : new Float32Array(53).fill(truth), provenance: "mh".padEnd(53, "n") };
}

test("the last seconds come out in order, with truth where it is known", () => {
  const history = new History();
  for (let i = 0; i < 600; ++i) history.add(frame(i / 60, (i % 10) / 10, i < 590 ? null : 0.5));
  const stretch = history.stretch(1, 2);
  assert.ok(stretch.times.length >= 120 && stretch.times.length <= 121);
  assert.equal(stretch.times.at(-1), 0);
  assert.ok(stretch.times.every((time, i) => i === 0 || time > stretch.times[i - 1]));
  assert.equal(stretch.letters.at(-1), "h");
  assert.equal(stretch.truths[0], null);
  assert.equal(stretch.truths.at(-1), 0.5);
});

test("it keeps a minute and no more", () => {
  const history = new History();
  for (let i = 0; i < 20_000; ++i) history.add(frame(i / 60, 0));
  assert.equal(history.length, 3600);
  assert.ok(Math.abs(history.stretch(0, 1e9).times[0] + 3599 / 60) < 1e-6);
});

test("a replay that is moved begins anew; one that stands still does not fill it", () => {
  const history = new History();
  for (let i = 0; i < 100; ++i) history.add(frame(10 + i / 60, 0));
  for (let i = 0; i < 100; ++i) history.add(frame(10 + 99 / 60, 0));
  assert.equal(history.length, 100);
  history.add(frame(3, 0));
  assert.equal(history.length, 1);
  history.add(frame(30, 0));
  assert.equal(history.length, 1);
});
