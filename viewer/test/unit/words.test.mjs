import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./load.mjs";

const { ago, agoToTheMinute, clock, fixed, milliseconds, percentage } = await load("format.ts");
const { countLetters, letterOf, standingOf } = await load("provenance.ts");
const { healthOf, HEALTH_STATES } = await load("health.ts");
const { sessionWord } = await load("chrome/session_word.ts");
const { linkFigures, linkSummary } = await load("panels/link_words.ts");
const { sameSubject, subjectOf } = await load("chrome/notices.ts");
const { ageSentence } = await load("panels/calibration.ts");
const { growingTake, takeFacts } = await load("panels/takes.ts");
const { standingSentence } = await load("chrome/standing_words.ts");

test("numbers read as a person says them", () => {
  assert.equal(milliseconds(4.21), "4.2 ms");
  assert.equal(milliseconds(87.4), "87 ms");
  assert.equal(milliseconds(-31_900), "-31.9 s");
  assert.equal(milliseconds(720_000), "12 min");
  assert.equal(milliseconds(null), "–");
  assert.equal(percentage(0), "0 %");
  assert.equal(percentage(0.004), "0.4 %");
  assert.equal(percentage(0.126), "13 %");
  assert.equal(clock(65.9), "1:05");
  assert.equal(clock(3723), "1:02:03");
  assert.equal(clock(-1), "0:00");
  assert.equal(ago(2), "just now");
  assert.equal(ago(185), "3 min ago");
  assert.equal(agoToTheMinute(40), "40 s ago");
  assert.equal(agoToTheMinute(3560), "59 min ago");
  assert.equal(agoToTheMinute(3575), "1 h ago");
  assert.equal(agoToTheMinute(4320), "1 h 12 min ago");
  assert.equal(fixed(null, 1), "–");
  assert.equal(fixed(Infinity, 1), "–");
});

test("a calibration says how old and how sure it is", () => {
  const sentence = (ageS, recentredS, sigmaDeg) => ageSentence({ ageS, recentredS, sigmaDeg });
  assert.equal(sentence(4320, null, 2.14), "Calibrated 1 h 12 min ago, rotations known to 2.1°.");
  assert.equal(sentence(4320, 180, 1), "Calibrated 1 h 12 min ago, re-centred 3 min ago, rotations known to 1.0°.");
  assert.equal(sentence(2, null, null), "Calibrated just now.");
  assert.equal(sentence(null, null, null), "Calibrated.");
});

test("a face is live while anything of it is", () => {
  assert.equal(standingOf("nnnnhm"), "live");
  assert.equal(standingOf("aaaa"), "live");
  assert.equal(standingOf("hhhh"), "held");
  assert.equal(standingOf("nnnn"), "neutral");
  assert.equal(standingOf("nnhh"), "resting");
  assert.equal(standingOf("xxxx"), "neutral");
  assert.equal(standingOf(""), "neutral");
});

test("a session is live once there was a frame, and not before", () => {
  const status = (fields) => ({ frames: 0, recording: { on: false }, replay: null, ...fields });
  const open = { kind: "open" };
  assert.deepEqual(sessionWord(open, status({ frames: 1 })), { text: "live", tone: "live" });
  for (const silent of [null, status({})]) assert.deepEqual(sessionWord(open, silent), { text: "waiting", tone: "idle" });
  assert.equal(sessionWord(open, status({ recording: { on: true } })).tone, "record");
  assert.equal(sessionWord(open, status({ replay: { paused: true } })).text, "replay, paused");
  assert.equal(sessionWord({ kind: "stalled" }, status({ frames: 9 })).tone, "bad");
  assert.equal(sessionWord({ kind: "lost", refused: true }, null).text, "refused");
  assert.equal(sessionWord({ kind: "connecting" }, null).tone, "idle");
});

test("a neutral face says what can be done about it, and of a take nothing about devices", () => {
  const silent = { replay: null, prompts: null, links: [{ state: "silent" }, { state: "unbound" }], calibration: { state: "none" } };
  const say = (fields) => standingSentence("neutral", { kind: "open" }, { ...silent, ...fields });
  assert.match(say({}), /Switch them on/);
  assert.match(say({ links: [{ state: "good" }] }), /not calibrated yet/);
  assert.match(say({ links: [{ state: "good" }], calibration: { state: "done" } }), /nothing is measured\.$/);
  for (const state of ["none", "watching", "running", "done"]) {
    const words = say({ replay: { paused: false }, calibration: { state } });
    assert.match(words, /take/);
    assert.doesNotMatch(words, /sensor|calibrat|Switch/);
  }
});

test("a page without its session says why", () => {
  const away = (connection, status = null) => standingSentence("away", connection, status);
  assert.match(away({ kind: "lost", refused: true }), /refuses this page/);
  assert.match(away({ kind: "lost", refused: false }), /Connection lost/);
  assert.match(away({ kind: "lost", refused: false }, { prompts: { state: "over" } }), /session has ended/);
  assert.equal(away({ kind: "connecting" }), "Connecting.");
  assert.equal(standingSentence("live", { kind: "open" }, null), "");
});

test("letters that nobody knows are not taken for measured", () => {
  assert.equal(letterOf("z", 0), "?");
  assert.equal(letterOf("", 5), "?");
  assert.deepEqual([...countLetters("mmhz")], [["m", 2], ["h", 1], ["?", 1]]);
});

test("troubles of few sensors are named, of many counted, the worst first", () => {
  const links = (...states) => states.map((state, i) => ({ sensor: `brow_${i}`, state }));
  assert.equal(linkSummary(links("good", "good")), "2 of 2 sensors are well.");
  assert.equal(linkSummary(links("silent", "unbound")), "0 of 2 sensors are well.");
  assert.equal(linkSummary(links("good", "lossy", "lost")), "1 of 3 well; brow 2 lost, brow 1 lossy.");
  assert.equal(linkSummary(links("late", "lost", "lost", "frozen", "good", "lost")), "1 of 6 well; 3 lost, brow 3 frozen, brow 0 late.");
  assert.equal(linkSummary(links(...new Array(12).fill("lost"))), "0 of 12 well; 12 lost.");
});

test("of a sensor that is not heard no figures are shown as if they were of now", () => {
  const link = { state: "good", rateHz: 239.6, ageMs: 2.5, loss: 0, offsetMs: 31.4, driftPpm: -17.96, battery: 99.6 };
  assert.deepEqual(linkFigures(link), ["240", "2.5 ms", "0 %", "31 ms", "-18.0", "100 %"]);
  const lost = { ...link, state: "lost", rateHz: 0, ageMs: 12_900, driftPpm: -100 };
  assert.deepEqual(linkFigures(lost), ["0", "12.9 s", "–", "–", "–", "100 %"]);
  assert.deepEqual(linkFigures({ ...lost, state: "silent", ageMs: null, battery: null }), ["0", "–", "–", "–", "–", "–"]);
  for (const state of ["lossy", "late", "frozen", "duplicate"]) assert.equal(linkFigures({ ...link, state })[2], "0 %", state);
});

test("news of one thing takes the place of what was said of it before", () => {
  assert.equal(subjectOf("frames_held", "holding frames 40 ms: packets arrive late"), subjectOf("frames_punctual", "packets arrive in time again"));
  assert.equal(subjectOf("sensor_lost", "mentalis is lost"), subjectOf("sensor_back", "mentalis is back"));
  assert.notEqual(subjectOf("sensor_lost", "mentalis is lost"), subjectOf("sensor_back", "mastoid_L is back"));
  assert.notEqual(subjectOf("sensor_lost", "a is lost"), subjectOf("line_lost", "a is lost"));
  for (const kind of ["recorded", "contested", "constructor", "__proto__", ""]) assert.equal(subjectOf(kind, "a is b"), "", kind);
});

test("news of several sensors takes the place of news of any, and is taken its place by it", () => {
  const several = subjectOf("sensor_lost", "6 sensors are lost"), one = subjectOf("sensor_back", "mentalis is back");
  assert.ok(sameSubject(several, subjectOf("sensor_back", "5 sensors are back")));
  assert.ok(sameSubject(several, one) && sameSubject(one, several));
  assert.ok(!sameSubject(one, subjectOf("sensor_lost", "mastoid_L is lost")));
  assert.ok(!sameSubject(several, subjectOf("line_lost", "/dev/ttyUSB0 is lost")));
  assert.ok(!sameSubject(several, "hold"));
});

test("of a take that is being recorded the list gives no length, and knows which one it is", () => {
  assert.equal(growingTake({ on: true, path: "/home/you/takes/live.mien" }), "live.mien");
  assert.equal(growingTake({ on: true, path: "C:\\takes\\live.mien" }), "live.mien");
  assert.equal(growingTake({ on: true, path: "live.mien" }), "live.mien");
  assert.equal(growingTake({ on: true, path: "" }), null);
  assert.equal(growingTake({ on: false, path: "takes/live.mien" }), null, "the one before");
  const take = { name: "live.mien", seconds: 44, megabytes: 4.6, error: "", recorded: "", growing: false };
  assert.equal(takeFacts(take), "0:44 · 4.6 MB");
  assert.equal(takeFacts({ ...take, growing: true }), "being recorded");
  assert.equal(takeFacts({ ...take, error: "the file is damaged", seconds: null }), "cannot be read · 4.6 MB");
});

test("every state of a link has words and a mark of its own severity", () => {
  for (const state of HEALTH_STATES) {
    const health = healthOf(state);
    assert.ok(health.sentence.endsWith("."), state);
    assert.equal(health.mark === "", state === "good", state);
  }
  for (const odd of ["", "toString", "constructor", "__proto__", "GOOD"]) assert.equal(healthOf(odd).label, "unknown", odd);
});
