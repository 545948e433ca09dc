import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { load } from "./load.mjs";

const { readMessage, readTakes, OWN_ORDER } = await load("protocol.ts");
const { lookWords } = await load("chrome/look_field.ts");
const { readPairing } = await load("network_protocol.ts");
const { SHAPES, SHAPE_COUNT } = await load("shapes.ts");

const read = (message, order = OWN_ORDER) => readMessage(typeof message === "string" ? message : JSON.stringify(message), order);

function frame(fields = {}) {
  return {
    type: "frame", index: 7, time: 1.5, weights: SHAPES.map((_, i) => i / 100), confidence: SHAPES.map(() => 0.5),
    provenance: "m".repeat(SHAPE_COUNT), tongue_out: 0.25, head: [1, 0, 0, 0], head_confidence: 1, head_provenance: "m",
    eyes: [0.1, 0, 0.1, 0], eyes_confidence: 0.4, eyes_provenance: "p", ...fields,
  };
}

test("a whole frame is read", () => {
  const message = read(frame({ truth: SHAPES.map(() => 0.5) }));
  assert.equal(message.type, "frame");
  assert.equal(message.index, 7);
  assert.equal(message.weights.length, SHAPE_COUNT);
  assert.ok(Math.abs(message.weights[30] - 0.3) < 1e-6);
  assert.equal(message.provenance, "m".repeat(SHAPE_COUNT));
  assert.equal(message.truth[52], 0.5);
  assert.deepEqual([...message.eyes], [0.1, 0, 0.1, 0]);
});

test("what comes of learning from a phone is read, and how far it is", () => {
  const lesson = (phone_lesson) => read({ type: "status", phone_lesson }).phoneLesson;
  assert.equal(lesson(null), null);
  assert.deepEqual(lesson({ state: "learning", sentence: "", learnt: 0.25 }), { state: "learning", sentence: "", learnt: 0.25 });
  assert.equal(lesson({ state: "recording", sentence: "" }).learnt, 0);
  assert.equal(lesson({ state: "learning", sentence: "", learnt: 7 }).learnt, 1);
  assert.equal(lesson({ state: "asleep", sentence: "" }), null);
});

test("the session's order is brought into ours by name", () => {
  const hello = read({ type: "hello", shapes: [...SHAPES].reverse() });
  const message = read(frame({ weights: [...SHAPES].map((_, i) => i / 100).reverse(), provenance: "mh".padEnd(SHAPE_COUNT, "n") }), hello.order);
  assert.ok(Math.abs(message.weights[10] - 0.1) < 1e-6);
  assert.equal(message.provenance.slice(-2), "hm");
});

test("a shape that the session does not have is zero and neutral", () => {
  const hello = read({ type: "hello", shapes: ["jawOpen"] });
  const message = read(frame({ weights: [0.8], provenance: "m" }), hello.order);
  assert.ok(Math.abs(message.weights[SHAPES.indexOf("jawOpen")] - 0.8) < 1e-6);
  assert.equal(message.weights[0], 0);
  assert.equal(message.provenance.charAt(0), "n");
});

test("a frame with odd values becomes a harmless one", () => {
  const message = read(frame({
    weights: [NaN, "x", null, 7, -3], confidence: "no", provenance: 5, head: [0, 0, 0, 0], eyes: [99, {}, -99], tongue_out: [], truth: {}, time: "late",
  }));
  assert.equal(message.weights[0], 0);
  assert.equal(message.weights[3], 1);
  assert.equal(message.weights[4], 0);
  assert.equal(message.provenance, "n".repeat(SHAPE_COUNT));
  assert.deepEqual([...message.head], [1, 0, 0, 0]);
  assert.deepEqual([...message.eyes], [1, 0, -1, 0]);
  assert.equal(message.truth, null);
  assert.equal(message.time, 0);
});

test("a frame without weights is no frame", () => {
  assert.equal(read(frame({ weights: undefined })), null);
  assert.equal(read(frame({ weights: "m" })), null);
});

test("what is no message is null, and nothing throws", () => {
  for (const nonsense of ["", "{", "null", "[]", "7", '"frame"', "{}", '{"type":"odd"}', '{"type":7}', '{"type":["frame"]}']) {
    assert.equal(read(nonsense), null, nonsense);
  }
});

test("every message survives every field being of a wrong kind", () => {
  const samples = [
    { type: "hello", shapes: SHAPES, rig: { name: "r", sensors: [{ name: "a", position_m: [0, 0, 0] }] }, listening: ["udp://"] },
    frame(),
    {
      type: "status", time: 1, latency_ms: { p50: 1, p99: 2, max: 3 }, hold_ms: 1, links: [{ sensor: "a", state: "good" }], unbound: [{ device: "d" }],
      calibration: { state: "running", target: { jawOpen: 1 }, versions: [{ id: 1, scores: [{ name: "s" }] }] }, sinks: [{ id: 1 }],
      prompts: { state: "running", name: "a", target: { jawOpen: 1 }, next: { name: "b", target: { jawOpen: 1 } }, number: 1, of: 2 },
      recording: { on: true }, shaping: { gains: { jawOpen: 1.5 }, limits: { jawOpen: [0, 0.5] } }, replay: { take: "t" }, tap: { sensor: "a" },
      network: { open: ["udp://0.0.0.0:5005"], interfaces: [{ name: "lo", address: "127.0.0.1", loopback: true }], only: "lo", elsewhere: 1, sealed: true, refused: 2 },
    },
    { type: "reply", id: 1, ok: true, result: {} },
    { type: "event", kind: "k", text: "t" },
  ];
  const odd = [undefined, null, 0, -1, 1e300, "", "x", true, [], [null], [[]], {}, { a: { b: [] } }, "toString", ["__proto__"]];
  const spoil = (value, path) => {
    if (typeof value !== "object" || value === null) return;
    for (const key of Object.keys(value)) {
      if (path.length === 0 && key === "type") continue;
      const before = value[key];
      for (const other of odd) {
        value[key] = other;
        assert.doesNotThrow(() => read(root), `${path.concat(key).join(".")} = ${JSON.stringify(other)}`);
      }
      value[key] = before;
      spoil(before, path.concat(key));
    }
  };
  let root;
  for (root of samples) spoil(root, []);
});

test("who sends as a sensor is read, and nobody without an address", () => {
  const status = read({ type: "status", links: [{ sensor: "a", source: "udp://h:1", rivals: [{ source: "udp://h:2", age_ms: 3, implausible: true }, { source: 7 }, null] }, { sensor: "b", rivals: "x" }] });
  assert.equal(status.links[0].source, "udp://h:1");
  assert.deepEqual(status.links[0].rivals, [{ source: "udp://h:2", ageMs: 3, implausible: true }]);
  assert.deepEqual(status.links[1].rivals, []);
});

test("a status is read", () => {
  const message = read({
    type: "status", time: 3, frames: 180, missed: 1, latency_ms: { p50: 7, p99: 12, max: 20 }, hold_ms: 45,
    links: [{ sensor: "mentalis", device: "d", state: "lossy", age_ms: 3, rate_hz: 239.8, loss: 0.1, battery: null, heading_sigma_deg: 2, rotation_sigma_deg: 3.5, left_out: true }],
    calibration: { state: "running", age_s: 4320, recentred_s: null, sigma_deg: 5.5, advises_recentring: true, step: "anchor", prompt: "Smile.", target: { mouthSmile_L: 1 }, progress: 0.5, remaining_s: 1.5, step_number: 4, steps: 8, versions: [] },
    sinks: [{ id: 2, address: "vmc://h:1", on: true, rate_hz: 60, receivers: null }], shaping: { smoothing: 0.4, gains: { jawOpen: 1.2, nonsense: 3 }, limits: {} },
    replay: null, tap: { sensor: "mentalis" },
  });
  assert.equal(message.holdMs, 45);
  assert.equal(message.links[0].loss, 0.1);
  assert.equal(message.links[0].battery, null);
  assert.deepEqual(message.links[0].rivals, []);
  assert.equal(message.calibration.target[SHAPES.indexOf("mouthSmile_L")], 1);
  assert.equal(message.calibration.steps, 8);
  const { ageS, recentredS, sigmaDeg, advisesRecentring } = message.calibration;
  assert.deepEqual([ageS, recentredS, sigmaDeg, advisesRecentring], [4320, null, 5.5, true]);
  assert.deepEqual([message.links[0].rotationSigmaDeg, message.links[0].leftOut], [3.5, true]);
  assert.equal(read({ type: "status" }).calibration.advisesRecentring, false);
  assert.equal(message.sinks[0].id, 2);
  assert.deepEqual([...message.shaping.gains], [["jawOpen", 1.2]]);
  assert.equal(message.tap, "mentalis");
  assert.equal(message.replay, null);
});

test("what is heard, where there is a microphone", () => {
  assert.equal(read({ type: "status" }).hearing, null);
  const { on, share, laterMs } = read({ type: "status", hearing: { on: true, speaks: true, share: 7, later_ms: -20 } }).hearing;
  assert.deepEqual({ on, share, laterMs }, { on: true, share: 1, laterMs: -20 });
  assert.deepEqual(read({ type: "microphone", on: false, why: "gone" }), { type: "microphone", why: "gone" });
});

test("of the face at rest the rests are read that are in force", () => {
  const shaping = { smoothing: 0, resting: true, resting_face: { rest: { eyeBlink_L: 0.3, browDown_R: 0, nonsense: 0.4, mouthSmile_L: 7 }, full: { eyeBlink_L: 0.8 } } };
  const { shaping: shown } = read({ type: "status", shaping });
  assert.equal(shown.resting, true);
  assert.deepEqual([shown.constraints, shown.lids_follow_eyes], [false, true]);
  const other = read({ type: "status", shaping: { constraints: true, lids_follow_eyes: false, blinks_per_min: 20 } }).shaping;
  assert.deepEqual([shown.blinks_per_min, other.blinks_per_min], [0, 20]);
  assert.deepEqual([other.constraints, other.lids_follow_eyes], [true, false]);
  assert.deepEqual([...shown.rests], [["eyeBlink_L", 0.3], ["mouthSmile_L", 1]]);
  for (const odd of [null, [], 3, { rest: [] }, { rest: { eyeBlink_L: "much" } }]) {
    const { shaping: none } = read({ type: "status", shaping: { resting: "yes", resting_face: odd } });
    assert.equal(none.resting, false);
    assert.equal(none.rests.size, 0);
  }
});

test("prompts are read, and none where there are none", () => {
  const prompts = {
    state: "running", name: "smile", say: "Smile", target: { mouthSmile_L: 0.6, nothing: 1 }, next: { name: "open", target: { jawOpen: 1 } },
    number: 2, of: 9, progress: 0.25, remaining_s: 1.5, left_s: 21,
  };
  const { prompts: shown } = read({ type: "status", prompts });
  assert.equal(shown.name, "smile");
  assert.ok(Math.abs(shown.target[SHAPES.indexOf("mouthSmile_L")] - 0.6) < 1e-6);
  assert.equal(shown.next.name, "open");
  assert.equal(shown.next.target[SHAPES.indexOf("jawOpen")], 1);
  assert.deepEqual([shown.number, shown.of, shown.remainingS, shown.leftS], [2, 9, 1.5, 21]);
  assert.equal(read({ type: "status", prompts: { ...prompts, next: null } }).prompts.next, null);
  const over = read({ type: "status", prompts: { ...prompts, state: "over", target: null } }).prompts;
  assert.equal(over.target, null);
  for (const odd of [null, undefined, 3, "running", [], { state: "dancing" }]) assert.equal(read({ type: "status", prompts: odd }).prompts, null);
});

test("a sensor's aim is made unit, a level a share, and both may be missing", () => {
  const hello = read({
    type: "hello",
    rig: { name: "glasses", sensors: [{ name: "a", kind: "eyewear", aim: [0, 0, -2] }, { name: "b", aim: [0, 0, 0] }, { name: "c", aim: [1, "x", 0] }, { name: "d" }] },
  });
  assert.deepEqual(hello.sensors.map((one) => one.aim), [[0, 0, -1], null, null, null]);
  const status = read({ type: "status", links: [{ sensor: "a", level: 0.4 }, { sensor: "b", level: 7 }, { sensor: "c" }, { sensor: "d", level: "much" }] });
  assert.deepEqual(status.links.map((one) => one.level), [0.4, 1, null, null]);
  assert.equal(read({ type: "status", recording: { on: true, ends_s: 60 } }).recording.endsS, 60);
  assert.equal(status.recording.endsS, null);
});

test("what is left of the session's log may be unknown", () => {
  assert.deepEqual(read({ type: "status" }).log, { megabytes: 0, limitMegabytes: 0, hoursLeft: null, error: "" });
  const { log } = read({ type: "status", log: { megabytes: 1500, limit_megabytes: 4000, hours_left: 1.5, error: null } });
  assert.deepEqual(log, { megabytes: 1500, limitMegabytes: 4000, hoursLeft: 1.5, error: "" });
});

test("endless lists and texts are cut", () => {
  const message = read({ type: "status", links: Array.from({ length: 5000 }, (_, i) => ({ sensor: `s${i}`, state: "x".repeat(1000) })) });
  assert.ok(message.links.length <= 256);
  assert.ok(message.links[0].state.length <= 500);
});

test("takes are read", () => {
  assert.deepEqual(readTakes(null), []);
  assert.deepEqual(readTakes({ takes: [{ name: "a.mien", seconds: 3, error: null, megabytes: 0.5, recorded: "2026" }, {}, 7] }), [
    { name: "a.mien", seconds: 3, error: "", megabytes: 0.5, recorded: "2026" },
  ]);
  assert.deepEqual(readTakes({ takes: [{ name: "b.mien", seconds: null, error: "b.mien: not a take", megabytes: 1, recorded: "2026" }] }), [
    { name: "b.mien", seconds: null, error: "b.mien: not a take", megabytes: 1, recorded: "2026" },
  ]);
});

test("the shapes are those of the program", () => {
  const header = readFileSync(new URL("../../../mien/face/profile.h", import.meta.url), "utf8");
  const list = /kShapeNames = \{([^}]*)\}/.exec(header)[1];
  assert.deepEqual([...list.matchAll(/"(\w+)"/g)].map((match) => match[1]), [...SHAPES]);
});

test("takes that the session sends unasked are read as its answer is", () => {
  const message = read({ type: "takes", takes: [{ name: "one.mien", seconds: 2.5, megabytes: 1, recorded: "2026-01-02T03:04:05Z" }, { seconds: 1 }] });
  assert.equal(message.type, "takes");
  assert.deepEqual(message.takes, [{ name: "one.mien", seconds: 2.5, error: "", megabytes: 1, recorded: "2026-01-02T03:04:05Z" }]);
});

test("who can send is read, and a session that does not say has none", () => {
  const network = read({
    type: "status", network: { open: ["udp://0.0.0.0:5005", 7], interfaces: [{ name: "lo", address: "127.0.0.1", loopback: true }, {}], only: "lo", elsewhere: -3, sealed: 1 },
  }).network;
  assert.deepEqual(network, { open: ["udp://0.0.0.0:5005"], interfaces: [{ name: "lo", address: "127.0.0.1", loopback: true }], only: "lo", elsewhere: 0, sealed: false, refused: 0 });
  assert.equal(read({ type: "status" }).network, null);
  assert.equal(readPairing(null), null);
  assert.equal(readPairing({ firmware: 7 }), null);
  assert.deepEqual(readPairing({ file: "f", firmware: "line", command: "c", in_force: true }), { file: "f", firmware: "line", command: "c", inForce: true });
});

test("where to look is read, and an odd direction becomes one that an eye can turn to", () => {
  const look = (value) => read({ type: "status", calibration: { state: "running", step: "gaze", look: value } }).calibration.look;
  assert.deepEqual(look({ yaw_deg: 15, pitch_deg: -10 }), { leftDeg: 15, upDeg: -10 });
  assert.deepEqual(look({ yaw_deg: 1e9, pitch_deg: "up" }), { leftDeg: 45, upDeg: 0 });
  for (const none of [null, undefined, 5, [], "left"]) assert.equal(look(none), null);
  assert.equal(lookWords({ leftDeg: 15, upDeg: 0 }), "15° left");
  assert.equal(lookWords({ leftDeg: -15, upDeg: 10 }), "10° up, 15° right");
  assert.equal(lookWords({ leftDeg: 0, upDeg: 0 }), "ahead");
});
