import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./load.mjs";

const { readVideo, videoMessage } = await load("video_protocol.ts");
const { cameraRefusal } = await load("browser_camera.ts");
const { videoWords } = await load("dataset/video_check.ts");
const { OWN_ORDER, readMessage } = await load("protocol.ts");
const { readMemory } = await load("dataset/memory.ts");

const hex = (buffer) => Buffer.from(buffer).toString("hex");

test("a chunk of video has its container, its place and its age", () => {
  // The vector of docs/reference/page_protocol.md.
  const data = Uint8Array.of(0x1a, 0x45, 0xdf, 0xa3, 0x9f, 0x42, 0x86, 0x81).buffer;
  assert.equal(hex(videoMessage("webm", 0, 1004.4, data)), "4d564944" + "01010000" + "00000000" + "ec030000" + "1a45dfa39f428681");
  assert.equal(hex(videoMessage("mp4", 258, -3, new ArrayBuffer(1))), "4d564944" + "01020000" + "02010000" + "00000000" + "00");
});

test("what is said of video is read with care", () => {
  const all = { agreed: true, on: true, file: "anna.webm", files: 1, megabytes: 2.5, trouble: null, refused: 3 };
  assert.deepEqual(readVideo(all), { agreed: true, on: true, file: "anna.webm", files: 1, megabytes: 2.5, trouble: "" });
  for (const none of [null, undefined, 7, "yes", []]) assert.equal(readVideo(none), null);
  assert.deepEqual(readVideo({ agreed: 1, on: "yes", files: -2, megabytes: "x", trouble: 5 }), { agreed: false, on: false, file: "", files: 0, megabytes: 0, trouble: "" });
  assert.deepEqual(readMessage('{"type":"video","on":false,"why":"no","again":true}', OWN_ORDER), { type: "video", why: "no", again: true });
  assert.deepEqual(readMessage('{"type":"video","why":7,"again":"x"}', OWN_ORDER), { type: "video", why: "", again: false });
  assert.equal(readMemory('{"video":"yes"}').video, false);
});

test("who is refused a camera reads what to do, and that the recording goes on", () => {
  for (const [name, words] of [["NotAllowedError", /Allow it for this page/], ["NotFoundError", /Plug one in/], ["NotReadableError", /another program/], ["TypeError", /odd\. Press again/]]) {
    assert.match(cameraRefusal({ name, message: "odd" }), words);
    assert.match(cameraRefusal({ name, message: "odd" }), /The recording goes on without video\.$/);
  }
});

test("before a block it is said how it stands with the video", () => {
  const video = readVideo({ agreed: true, on: true, file: "anna.webm", files: 1, megabytes: 2.5 });
  assert.match(videoWords(video, { kind: "on" }).words, /Your face is recorded: anna\.webm, 2\.5 MB/);
  assert.match(videoWords(video, { kind: "off" }).words, /Another browser's camera/);
  assert.deepEqual(videoWords({ ...video, on: false }, { kind: "off" }), { words: "No camera is recorded.", severity: "warn" });
  assert.deepEqual(videoWords(video, { kind: "refused", why: "No." }), { words: "No.", severity: "bad" });
  assert.equal(videoWords({ ...video, trouble: "the disk is full" }, { kind: "off" }).words, "The disk is full.");
});
