import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./load.mjs";

const { readPicture, readPictures } = await load("picture_protocol.ts");
const { brightnessOf, confidenceOf, isCamera, opennessOf, originOf, seesAnEye, shapesSeen } = await load("camera_words.ts");
const { SHAPES, shapeIndex } = await load("shapes.ts");
const { gazeDirection } = await load("scene/headset.ts");
const { anchorOf, keepWithin } = await load("scene/camera_views.ts");

const bytes = (hex) => Uint8Array.from(hex.replaceAll(" ", "").match(/../g), (two) => parseInt(two, 16)).buffer;

/** The vector of docs/reference/page_protocol.md. */
const VECTOR = "4d504943 01 00 0200 0300 0200 000a141e2832";

const EYE_L = { name: "eye_L", kind: "camera", site: "eye", side: "L", role: "face", position: [0.05, 0.02, 0.1245], aim: null };
const MOUTH_R = { ...EYE_L, name: "mouth_R", site: "mouth", side: "R" };

test("a headset covers the eyes where a camera sees one", () => {
  assert.equal(seesAnEye([MOUTH_R]), false);
  assert.equal(seesAnEye([MOUTH_R, EYE_L]), true);
  assert.equal(seesAnEye([{ ...EYE_L, kind: "imu" }]), false);
});

test("a picture is read as the session writes it", () => {
  const picture = readPicture(bytes(VECTOR));
  assert.equal(picture.sensor, 2);
  assert.deepEqual([picture.width, picture.height], [3, 2]);
  assert.deepEqual([...picture.pixels], [0, 10, 20, 30, 40, 50]);
});

test("what is no picture is refused", () => {
  const whole = VECTOR.replaceAll(" ", "");
  for (let length = 0; length < whole.length; length += 2) {
    if (length === 0) assert.equal(readPicture(new ArrayBuffer(0)), null);
    else assert.equal(readPicture(bytes(whole.slice(0, length))), null, `${length / 2} bytes`);
  }
  assert.equal(readPicture(bytes(`${VECTOR} 00`)), null, "a byte too many");
  assert.equal(readPicture(bytes(VECTOR.replace("4d50", "4d51"))), null, "another magic");
  assert.equal(readPicture(bytes(VECTOR.replace("4943 01", "4943 02"))), null, "another version");
  assert.equal(readPicture(bytes("4d504943 01 00 0200 0000 0200")), null, "no width");
  assert.equal(readPicture(bytes("4d504943 01 00 0200 ffff ffff 00")), null, "larger than any");
});

test("a status without pictures has none, and a broken one is harmless", () => {
  assert.equal(readPictures(null), null);
  assert.equal(readPictures(undefined), null);
  assert.equal(readPictures([4]), null);
  assert.deepEqual(readPictures({ cameras: 4, watchers: 1 }), { cameras: 4, watchers: 1 });
  assert.deepEqual(readPictures({ cameras: "4", watchers: -1 }), { cameras: 0, watchers: 0 });
});

test("cameras are those that look at the face and have a place", () => {
  assert.ok(isCamera(EYE_L));
  assert.ok(!isCamera({ ...EYE_L, position: null }));
  assert.ok(!isCamera({ ...EYE_L, kind: "imu" }));
});

test("a camera sees its half of the face, and of that its side", () => {
  const names = (sensor) => shapesSeen(sensor).map((index) => SHAPES[index]);
  const eye = names(EYE_L);
  assert.ok(eye.includes("eyeBlink_L") && eye.includes("browDown_L"));
  assert.ok(eye.every((name) => /^(eye|brow).*_L$/.test(name)));
  const mouth = names(MOUTH_R);
  assert.ok(mouth.includes("mouthSmile_R") && mouth.includes("noseSneer_R"));
  assert.ok(mouth.every((name) => /_R$/.test(name) && !/^eye|^brow/.test(name)));
  const middle = names({ ...MOUTH_R, name: "mouth", side: "M" });
  assert.ok(middle.includes("jawOpen") && middle.includes("mouthSmile_L") && middle.includes("mouthSmile_R"));
  assert.ok(!middle.some((name) => /^eye|^brow/.test(name)));
});

test("each half is called what most of its shapes are", () => {
  const letters = (upper, lower) => SHAPES.map((name) => (/^(brow|eye)/.test(name) ? upper : lower)).join("");
  assert.equal(originOf(letters("m", "a"), "upper").word, "measured");
  assert.equal(originOf(letters("m", "a"), "lower").word, "from sound");
  assert.equal(originOf(letters("h", "m"), "upper").word, "held");
  assert.equal(originOf(letters("n", "n"), "lower").word, "neutral");
  // The eight that follow the eyes are predicted: the rest decides.
  const measured = SHAPES.map((name) => (/^eyeLook/.test(name) ? "p" : "m")).join("");
  assert.equal(originOf(measured, "upper").word, "measured");
  assert.equal(originOf("", "upper").word, "neutral");
});

test("what is little known is dim, and never gone", () => {
  const frame = { confidence: new Float32Array(SHAPES.length).fill(0.9) };
  const seen = shapesSeen(EYE_L);
  assert.equal(brightnessOf(confidenceOf(seen, frame)), 1);
  for (const index of seen) frame.confidence[index] = 0.2;
  const dim = brightnessOf(confidenceOf(seen, frame));
  assert.ok(dim > 0.3 && dim < 0.6, `${dim}`);
  assert.ok(brightnessOf(confidenceOf(shapesSeen(MOUTH_R), frame)) === 1, "the others are as they were");
  assert.equal(brightnessOf(0), 0.3);
  assert.equal(brightnessOf(confidenceOf([], frame)), 0.3);
});

test("an eye is as open as the face shows it", () => {
  const weights = new Float32Array(SHAPES.length);
  weights[shapeIndex("eyeBlink_L")] = 0.75;
  assert.deepEqual(opennessOf({ weights }), [0.25, 1]);
});

test("rays go where the eyes look: yaw to the performer's left, pitch up", () => {
  const ahead = gazeDirection(0, 0);
  assert.deepEqual(ahead.toArray(), [0, 0, 1]);
  assert.ok(gazeDirection(0.3, 0).x > 0.29);
  assert.ok(gazeDirection(0, 0.3).y > 0.29);
  assert.ok(Math.abs(gazeDirection(0.4, -0.5).length() - 1) < 1e-9);
});

test("pictures hang beside what they are of, and stay on the stage", () => {
  assert.ok(anchorOf(EYE_L).x > 0.1 && anchorOf(MOUTH_R).x < -0.1);
  assert.ok(anchorOf(EYE_L).y > anchorOf(MOUTH_R).y);
  const rect = { left: 10, top: 20, width: 300, height: 200 };
  assert.deepEqual(keepWithin(rect, 160, 120, 80, 100), { left: 120, top: 70 });
  assert.deepEqual(keepWithin(rect, -50, 500, 80, 100), { left: 10, top: 120 });
  assert.deepEqual(keepWithin(rect, 1e6, -1e6, 80, 100), { left: 230, top: 20 });
});
