import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./load.mjs";

const { Playout, restingPose } = await load("playout.ts");

function frame(time, weight, fields = {}) {
  return {
    type: "frame", index: 0, time, weights: new Float32Array(53).fill(weight), confidence: new Float32Array(53), provenance: "", tongueOut: weight,
    head: [1, 0, 0, 0], eyes: [weight, 0, weight, 0], truth: null, ...fields,
  };
}

test("what is shown lies between the last two frames and never beyond", () => {
  const playout = new Playout();
  const pose = restingPose();
  assert.equal(playout.pose(0, pose, null), false);
  playout.add(frame(1, 0), 1000);
  playout.add(frame(1.02, 1), 1020);
  const at = (now) => {
    playout.pose(now, pose, null);
    return pose.weights[5];
  };
  assert.equal(at(1020), 0);
  assert.ok(Math.abs(at(1030) - 0.5) < 1e-6);
  assert.equal(at(1040.1), 1);
  assert.equal(at(9000), 1);
  assert.equal(at(900), 0);
});

test("it asks to be drawn again until it rests", () => {
  const playout = new Playout();
  const pose = restingPose();
  playout.add(frame(1, 0), 0);
  playout.add(frame(1.02, 1), 20);
  assert.equal(playout.pose(25, pose, null), true);
  assert.equal(playout.pose(40.1, pose, null), false);
});

test("a jump in time, either way, is shown at once", () => {
  for (const time of [0.2, 1, 7]) {
    const playout = new Playout();
    const pose = restingPose();
    playout.add(frame(1, 0), 0);
    playout.add(frame(time, 1), 20);
    playout.pose(20, pose, null);
    assert.equal(pose.weights[0], 1, `to ${time}`);
  }
});

test("the head turns the shorter way and stays a rotation", () => {
  const playout = new Playout();
  const pose = restingPose();
  playout.add(frame(1, 0, { head: [1, 0, 0, 0] }), 0);
  playout.add(frame(1.02, 0, { head: [-Math.SQRT1_2, 0, -Math.SQRT1_2, 0] }), 20);
  playout.pose(30, pose, null);
  assert.ok(Math.abs(Math.hypot(...pose.head) - 1) < 1e-6);
  assert.ok(Math.abs(Math.abs(pose.head[0]) - Math.cos(Math.PI / 8)) < 1e-3);
});

test("the truth is joined like the rest, from its first frame on", () => {
  const playout = new Playout();
  const pose = restingPose();
  const truth = restingPose();
  playout.add(frame(1, 0), 0);
  playout.add(frame(1.02, 1, { truth: new Float32Array(53).fill(0.4) }), 20);
  playout.pose(30, pose, truth);
  assert.ok(Math.abs(truth.weights[3] - 0.4) < 1e-6);
  playout.add(frame(1.04, 1, { truth: new Float32Array(53).fill(0.8) }), 40);
  playout.pose(50, pose, truth);
  assert.ok(Math.abs(truth.weights[3] - 0.6) < 1e-6);
});
