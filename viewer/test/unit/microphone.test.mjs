import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./load.mjs";

const { readHearing, soundMessage } = await load("hearing_protocol.ts");
const { hearingWords, microphoneWords } = await load("panels/voice.ts");
const { BrowserMicrophone, refusalWords } = await load("microphone.ts");
const { Signal } = await load("signal.ts");

const hex = (buffer) => Buffer.from(buffer).toString("hex");

test("a piece of sound has its rate, its place and its samples", () => {
  // The vector of docs/reference/page_protocol.md.
  assert.equal(hex(soundMessage(48_000, 960, Int16Array.of(1, -2, 32767))), "4d534e440100000080bb0000c0030000000000000100feffff7f");
  assert.equal(soundMessage(16_000, 2 ** 40, new Int16Array(320)).byteLength, 660);
});

test("what is said of hearing is read with care", () => {
  const all = { on: true, speaks: true, share: 0.4, later_ms: -20, shut: false, blocks: 7, trouble: "no sound", browser: { heard: true, refused: 3 } };
  assert.deepEqual(readHearing(all), { on: true, speaks: true, share: 0.4, laterMs: -20, shut: false, blocks: 7, trouble: "no sound", browser: { heard: true, refused: 3 } });
  const none = { on: false, speaks: false, share: 0, laterMs: 0, shut: false, blocks: 0, trouble: "", browser: null };
  assert.deepEqual(readHearing({ blocks: "many", trouble: 3, browser: "yes", shut: 1 }), none);
  assert.deepEqual(readHearing({ browser: { heard: 1, refused: NaN } }).browser, { heard: false, refused: 0 });
});

test("who is refused a microphone reads what to do", () => {
  const words = (name) => refusalWords({ name, message: "odd" });
  assert.match(refusalWords(null), /only to pages of its own machine \(127\.0\.0\.1\) or over HTTPS.*--audio default/);
  assert.match(words("NotAllowedError"), /Allow it for this page.*--audio default/);
  assert.match(words("NotFoundError"), /finds no microphone.*--audio default/);
  assert.match(words("NotReadableError"), /another program may hold it.*press again, or load the page anew; or .*--audio default/);
  assert.match(words("TypeError"), /cannot be used: odd\. .*press again, or load the page anew; or .*--audio default/);
  assert.match(refusalWords({ name: "AbortError", message: "" }), /AbortError/);
});

test("the block of the voice says how it stands", () => {
  const hearing = readHearing({ on: true, speaks: false, share: 0.5, later_ms: 0, blocks: 500, browser: { heard: false, refused: 0 } });
  assert.match(hearingWords({ ...hearing, shut: true, on: false }), /--no-audio/);
  assert.match(hearingWords({ ...hearing, on: false }), /Sound is off/);
  assert.match(hearingWords({ ...hearing, laterMs: -12 }), /Nobody speaks\. 50 % .* comes before the face by 12 ms/);
  assert.equal(microphoneWords({ kind: "on" }, { ...hearing, browser: null }), "");
  assert.equal(microphoneWords({ kind: "off" }, hearing), "No browser is heard yet.");
  assert.equal(microphoneWords({ kind: "off" }, { ...hearing, on: false }), "");
  assert.match(microphoneWords({ kind: "off" }, { ...hearing, browser: { heard: true, refused: 0 } }), /Another browser is heard/);
  assert.equal(microphoneWords({ kind: "on" }, { ...hearing, browser: { heard: true, refused: 0 } }), "This browser is heard; 10 s of sound were heard so far.");
  assert.match(microphoneWords({ kind: "on" }, { ...hearing, browser: { heard: true, refused: 2 } }), /2 pieces were refused/);
  assert.equal(microphoneWords({ kind: "refused", why: "No." }, hearing), "No.");
});

/** A browser with a microphone whose user answers when told to, and a session that says `answer`. */
function world({ answer = { ok: true, error: "" }, devices = true } = {}) {
  const track = { stopped: 0, stop: () => ++track.stopped, onended: null };
  const asked = [];
  const node = { port: { onmessage: null }, connect: (next) => next };
  const context = { sampleRate: 48_000, closed: 0, audioWorklet: { addModule: async () => {} }, createMediaStreamSource: () => node, resume: async () => {}, close: async () => ++context.closed };
  const session = { connection: new Signal({ kind: "open" }), microphoneOver: new Signal(null), sent: [], sound: [], send: async (command) => (session.sent.push(command), answer), sendSound: (bytes) => session.sound.push(bytes) };
  const mediaDevices = devices ? { getUserMedia: () => new Promise((give, refuse) => asked.push({ give: () => give({ getTracks: () => [track] }), refuse })) } : undefined;
  Object.defineProperty(globalThis, "navigator", { configurable: true, value: { mediaDevices } });
  globalThis.window = { location: { href: "http://127.0.0.1:8740/?token=x" } };
  globalThis.AudioContext = function () { return context; };
  globalThis.AudioWorkletNode = function () { return node; };
  return { track, asked, node, context, session, microphone: new BrowserMicrophone(session) };
}

test("a browser's microphone is heard until it is stopped, by whomever", async () => {
  const ways = {
    off: ({ microphone }) => microphone.stop(),
    switched: ({ session }) => session.microphoneOver.set({ type: "microphone", why: "" }),
    taken: ({ session }) => session.microphoneOver.set({ type: "microphone", why: "Another is heard." }),
    lost: ({ session }) => session.connection.set({ kind: "lost", retryAtMs: 0, attempts: 1, refused: false }),
    unplugged: ({ track }) => track.onended(),
  };
  const whys = { off: undefined, switched: undefined, taken: "Another is heard.", lost: "The connection to the session broke. When it is back, press again, or load the page anew.", unplugged: "The microphone was unplugged, or the browser took it back. Plug it in and press again, or load the page anew." };
  for (const [way, end] of Object.entries(ways)) {
    const it = world();
    const started = it.microphone.start();
    assert.equal(it.microphone.state.value.kind, "asking");
    it.asked[0].give();
    await started;
    assert.equal(it.microphone.state.value.kind, "on", way);
    assert.deepEqual(it.session.sent, [{ command: "microphone", on: true }]);
    it.node.port.onmessage({ data: { count: 5, samples: Int16Array.of(3) } });
    assert.deepEqual(it.session.sound.map(hex), [hex(soundMessage(48_000, 5, Int16Array.of(3)))]);
    end(it);
    assert.equal(it.microphone.state.value.why, whys[way], way);
    assert.equal(it.track.stopped, 1, `${way}: the browser's sign goes off`);
    assert.equal(it.context.closed, 1, way);
    it.node.port.onmessage({ data: { count: 6, samples: Int16Array.of(3) } });
    assert.equal(it.session.sound.length, 1, `${way}: nothing is sent any more`);
    const told = it.session.sent.slice(1);
    assert.deepEqual(told, way === "off" || way === "unplugged" ? [{ command: "microphone", on: false }] : [], way);
  }
});

test("a connection that is lost while a microphone is asked for ends it", async () => {
  const asks = {
    module: (it, wait) => (it.context.audioWorklet.addModule = () => wait),
    session: (it, wait) => (it.session.send = () => wait.then(() => ({ ok: true, error: "" }))),
  };
  for (const [where, hold] of Object.entries(asks)) {
    const it = world();
    let goOn;
    hold(it, new Promise((resolve) => (goOn = resolve)));
    const started = it.microphone.start();
    it.asked[0].give();
    await new Promise(setImmediate);
    it.session.connection.set({ kind: "lost", retryAtMs: 0, attempts: 1, refused: false });
    assert.equal(it.microphone.state.value.kind, "refused", where);
    goOn();
    await started;
    assert.match(it.microphone.state.value.why, /connection to the session broke/, `${where}: it stays so`);
    assert.equal(it.track.stopped, 1, where);
    assert.equal(it.context.closed, 1, where);
    assert.deepEqual(it.session.sent, [], where);
    assert.equal(it.node.port.onmessage, null, where);
  }
});

test("a microphone that is refused says why, and is let go", async () => {
  const insecure = world({ devices: false });
  await insecure.microphone.start();
  assert.match(insecure.microphone.state.value.why, /HTTPS/);
  const denied = world();
  const started = denied.microphone.start();
  denied.asked[0].refuse(new DOMException("Permission denied", "NotAllowedError"));
  await started;
  assert.match(denied.microphone.state.value.why, /Allow it/);
  assert.deepEqual(denied.session.sent, []);
  const unwanted = world({ answer: { ok: false, error: "the voice is switched off" } });
  const asking = unwanted.microphone.start();
  unwanted.asked[0].give();
  await asking;
  assert.equal(unwanted.microphone.state.value.why, "the voice is switched off");
  assert.equal(unwanted.track.stopped, 1);
  // Stopped while the browser still asks: what it gives then is let go.
  const late = world();
  const waiting = late.microphone.start();
  late.microphone.stop();
  late.asked[0].give();
  await waiting;
  assert.equal(late.track.stopped, 1);
  assert.equal(late.microphone.state.value.kind, "off");
  assert.deepEqual(late.session.sent, []);
});

test("the thread of sound packs 20 ms, and a gap shows in the count", async () => {
  let Made;
  const told = [];
  Object.assign(globalThis, {
    sampleRate: 16_000, currentFrame: 1000, registerProcessor: (_, made) => (Made = made),
    AudioWorkletProcessor: class { port = { postMessage: (piece) => told.push(piece) }; },
  });
  await import("../../public/microphone_worklet.js");
  const made = new Made();
  const hear = (value, quanta) => {
    for (let i = 0; i < quanta; ++i, globalThis.currentFrame += 128) made.process([value === null ? [] : [new Float32Array(128).fill(value)]]);
  };
  hear(0.5, 5);
  assert.deepEqual(told.map(({ count }) => count), [0, 320]);
  assert.deepEqual([...told[1].samples], Array(320).fill(16_384));
  hear(2, 1);
  hear(null, 10); // What was begun is left out: it would not fill up in time.
  hear(-2, 3);
  assert.deepEqual(told.map(({ count }) => count), [0, 320, 2048]);
  assert.ok(told[2].samples.every((sample) => sample === -32_768), "clipped");
});
