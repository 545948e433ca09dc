import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./load.mjs";

const { readMessage, OWN_ORDER } = await load("protocol.ts");
const { readDataset, readDatasetList } = await load("dataset_protocol.ts");
const { isAsking, isLine, readPrompts } = await load("prompt_protocol.ts");
const { readMemory } = await load("dataset/memory.ts");
const { askedAgain, LineLog, shownWords } = await load("dataset/line_log.ts");
const { isRunning, stepOf } = await load("dataset/step.ts");
const { aboutMinutes, blocksOf, blockSentence, languageName, loudnessWords, progressWords, titled } = await load("dataset/words.ts");
const { endedSentences, recordedWell } = await load("dataset/summary_step.ts");
const { blockFacts, worstFirst } = await load("dataset/check_step.ts");
const { newsWords, scriptOf } = await load("dataset/recording.ts");
const { phonesOf, sensorsOf } = await load("dataset/roles.ts");
const { largestSize } = await load("dataset/fit.ts");
const { isHeard } = await load("dataset/what_step.ts");
const { healthOf } = await load("health.ts");

const line = (fields = {}) => readPrompts({
  state: "running", name: "calm 1", say: "Read calmly", text: "The keeper wrote.", block: "calm", emotion: "neutral", language: "en", own_pace: true, attempt: 1, poor: [], again: 0,
  target: {}, next: { name: "calm 2", text: "The gulls read.", target: {} }, number: 1, of: 3, progress: 0.5, remaining_s: 2, left_s: 20, ...fields,
});

test("a line is read: its text, labels and pace; a text alone asks for no face", () => {
  const one = line();
  assert.deepEqual([one.text, one.block, one.emotion, one.language, one.ownPace, one.attempt], ["The keeper wrote.", "calm", "neutral", "en", true, 1]);
  assert.equal(one.target, null);
  assert.deepEqual(one.next, { name: "calm 2", text: "The gulls read.", target: null });
  assert.ok(line({ target: { jawOpen: 0.5 } }).target, "a face to make beside the text");
  assert.ok(line({ text: "" }).target, "a pose at rest is a pose");
  assert.equal(line({ state: "over", text: "", target: null }).target, null);
  assert.equal(line({ state: "block" }).state, "block");
});

test("odd values of a line become harmless ones", () => {
  const odd = line({ text: 7, say: {}, block: [], emotion: null, language: "<b>", own_pace: 1, attempt: -3, poor: "all", again: NaN, next: "x", number: "1", of: 1e99, progress: 7, left_s: 1e300 });
  assert.deepEqual([odd.text, odd.say, odd.block, odd.emotion, odd.language, odd.ownPace, odd.attempt, odd.poor, odd.again, odd.next], ["", "", "", "", "", false, 1, [], 0, null]);
  assert.deepEqual([odd.number, odd.of, odd.progress, odd.leftS], [0, 10_000, 1, 360_000]);
  assert.equal(line({ text: "x".repeat(9000) }).text.length, 2000);
  assert.equal(line({ language: "zh-Hant-TW" }).language, "zh-Hant-TW");
  for (const language of ["e", "en us", "en\"onclick", `en-${"x".repeat(40)}`, 5]) assert.equal(line({ language }).language, "", String(language));
  for (const none of [null, 3, "running", [], {}, { state: "blocked" }]) assert.equal(readPrompts(none), null);
});

test("lines are the teleprompter's, poses of a plain recording are not", () => {
  assert.ok(isLine(line()));
  assert.ok(isLine(line({ block: "", state: "block" })));
  assert.ok(!isLine(line({ block: "" })), "a text of no block");
  const pose = line({ text: "", block: "", target: { jawOpen: 1 } });
  assert.ok(isAsking(pose) && !isLine(pose));
  for (const none of [null, undefined, line({ state: "over" })]) assert.ok(!isAsking(none) && !isLine(none));
});

test("a dataset's recording is read from a status", () => {
  const dataset = { name: "faces", performer: "anna", take: "anna_3.mien", lines: 42, done: 11, over: false, error: null };
  const status = readMessage(JSON.stringify({ type: "status", dataset }), OWN_ORDER);
  assert.deepEqual(status.dataset, { ...dataset, error: "" });
  assert.equal(readMessage('{"type":"status"}', OWN_ORDER).dataset, null);
  for (const none of [null, 7, "faces", [], {}, { name: 7 }]) assert.equal(readDataset(none), null);
  assert.deepEqual(readDataset({ name: "n".repeat(900), lines: -4, done: "many", over: "yes", error: 3 }), { name: "n".repeat(500), performer: "", take: "", lines: 0, done: 0, over: false, error: "" });
});

const KNOWN = readDatasetList({
  datasets: [{ name: "faces", performers: [{ name: "anna", takes: 2, lines: 31 }] }],
  scripts: [{ name: "dataset_en", title: "Dataset, English", language: "en", blocks: [{ name: "calm", lines: 20, seconds: 160 }, { name: "emotional", lines: 16, seconds: 100 }, { name: "calm", lines: 6, seconds: 40 }] }],
});

test("the list of datasets is read, whatever it is", () => {
  assert.equal(KNOWN.datasets[0].performers[0].lines, 31);
  assert.equal(KNOWN.scripts[0].blocks[0].seconds, 160);
  for (const none of [null, {}, { datasets: "x", scripts: 4 }]) assert.deepEqual(readDatasetList(none), { datasets: [], scripts: [] });
  const odd = readDatasetList({ datasets: [7, { name: "a", performers: [{}, { name: "b", takes: "x", lines: -1 }] }, { performers: [] }], scripts: [{ name: "s", blocks: [{ seconds: -3, lines: 2.4 }, null] }] });
  assert.deepEqual(odd.datasets, [{ name: "a", performers: [{ name: "b", takes: 0, lines: 0 }] }]);
  assert.deepEqual(odd.scripts, [{ name: "s", title: "s", language: "", blocks: [{ name: "", lines: 2, seconds: 0 }, { name: "", lines: 0, seconds: 0 }] }]);
  assert.ok(readDatasetList({ datasets: Array.from({ length: 5000 }, () => ({ name: "n" })) }).datasets.length <= 256);
});

test("how much is done and left is said as far as it is known", () => {
  const [script] = KNOWN.scripts;
  assert.match(progressWords(KNOWN, "faces", "anna", script), /anna has 31 lines in “faces” already, in 2 takes\. .* of this script's 42 at least 11 are left\./);
  assert.match(progressWords(KNOWN, "faces", "ben", script), /Nothing of ben is in “faces” yet: all 42 lines are asked for, about 5 min\./);
  assert.equal(progressWords(KNOWN, "faces", "", script), "");
  assert.equal(progressWords(KNOWN, "faces", "anna", null), "");
  const more = structuredClone(KNOWN);
  more.datasets[0].performers[0].lines = 99;
  assert.doesNotMatch(progressWords(more, "faces", "anna", script), /left/);
  assert.deepEqual(blocksOf(script), [{ name: "calm", lines: 26, seconds: 200 }, { name: "emotional", lines: 16, seconds: 100 }]);
  assert.deepEqual([aboutMinutes(10), aboutMinutes(160), aboutMinutes(1e5)], ["under a minute", "about 3 min", "about 28 h"]);
  assert.deepEqual([titled("calm"), titled("élan_vital"), titled("")], ["Calm", "Élan vital", ""]);
  assert.deepEqual([languageName("de"), languageName("not a tag"), languageName("")], ["German", "not a tag", ""]);
  for (const odd of ["toString", "__proto__", "", "mine"]) assert.equal(blockSentence(odd), "", odd);
  assert.match(blockSentence("calm"), /calmly/);
});

test("before a block its lines are counted: of one that is known, of what is left, and of what is asked for again", () => {
  const [script] = KNOWN.scripts;
  assert.equal(blockFacts(line({ of: 42 }), script), "26 lines, about 3 min; 42 lines in all from here, under a minute");
  assert.equal(blockFacts(line({ of: 20, left_s: 300 }), script), "20 lines, about 5 min");
  assert.equal(blockFacts(line({ block: "mine", number: 3, of: 20, left_s: 300 }), script), "18 lines in all from here, about 5 min");
  assert.equal(blockFacts(line({ attempt: 2, again: 2, number: 43, of: 45, left_s: 100 }), script), "3 lines, about 2 min");
  assert.equal(scriptOf(KNOWN, "", line()), script);
  assert.equal(scriptOf(KNOWN, "dataset_en", line({ language: "de" })), null);
  assert.equal(scriptOf({ ...KNOWN, scripts: [script, { ...script, name: "other" }] }, "", line()), null, "either could be meant");
  assert.equal(scriptOf({ ...KNOWN, scripts: [script, { ...script, name: "other" }] }, "other", line()).name, "other");
});

test("the session alone says which step of a recording that runs is shown", () => {
  const dataset = readDataset({ name: "faces", take: "a.mien", over: false });
  const over = { ...dataset, over: true };
  assert.equal(stepOf(null, null, null), null);
  assert.equal(stepOf({ prompts: null, dataset: null }, "consent", null), "consent");
  assert.equal(stepOf({ prompts: line({ state: "block" }), dataset }, "consent", null), "check");
  for (const state of ["ready", "running", "paused"]) assert.equal(stepOf({ prompts: line({ state }), dataset }, "what", null), "lines");
  assert.equal(stepOf({ prompts: null, dataset }, null, null), "check", "nothing is asked for yet");
  assert.equal(stepOf({ prompts: line({ state: "over" }), dataset: over }, null, null), "summary");
  assert.equal(stepOf({ prompts: line(), dataset: { ...over, error: "the disk is full" } }, null, null), "summary", "its prompts go a moment later");
  assert.equal(stepOf({ prompts: null, dataset: over }, null, "a.mien"), null, "it was put away");
  assert.equal(stepOf({ prompts: null, dataset: over }, "what", null), "what");
  assert.equal(stepOf({ prompts: line(), dataset: null }, null, null), "lines", "lines of a recording that a command began");
  assert.equal(stepOf({ prompts: line({ block: "", text: "" }), dataset: null }, null, null), null, "plain poses");
  assert.deepEqual(["what", "consent", "check", "lines", "summary", null].map(isRunning), [false, false, true, true, false, false]);
});

test("which line was poor is known from one status to the next", () => {
  const log = new LineLog();
  const third = { name: "calm 3", text: "Tea, please.", number: 3, of: 4, again: 1, poor: ["mentalis was lost"] };
  assert.equal(log.see(line()), null);
  assert.equal(log.see(line({ name: "calm 2", text: "The gulls read.", number: 2 })), null, "it was good");
  assert.deepEqual(log.see(line(third)), { sentences: ["mentalis was lost"], again: true });
  assert.equal(log.see(line({ ...third, progress: 0.9 })), null, "news once");
  assert.deepEqual(log.poor, [{ name: "calm 2", what: "The gulls read.", language: "en", poor: ["mentalis was lost"] }]);
  // Again, and good: it is poor no more.
  const again = { name: "calm 2", text: "The gulls read.", number: 4, of: 4, again: 0, attempt: 2 };
  assert.equal(log.see(line({ ...again, poor: [] })), null);
  assert.equal(log.see(line({ state: "over", number: 4, of: 4, poor: [], name: "", text: "" })), null);
  assert.deepEqual(log.poor, []);
});

test("what was skipped is not taken for poor, whoever skipped it", () => {
  const poor = ["nothing moved"];
  const second = { name: "calm 2", number: 2, of: 9, again: 1, poor };
  const own = new LineLog();
  own.see(line({ of: 8 }));
  assert.ok(own.see(line(second)));
  own.skip(2);
  assert.equal(own.see(line({ name: "calm 3", number: 3, of: 9, again: 1, poor })), null);
  assert.deepEqual(own.poor.map((one) => one.name), ["calm 1"]);
  const other = new LineLog();
  other.see(line({ of: 8 }));
  other.see(line(second));
  assert.equal(other.see(line({ name: "calm 3", number: 3, of: 9, again: 1, poor })), null);
  assert.ok(other.see(line({ name: "calm 4", number: 4, of: 10, again: 2, poor })), "poor in the same way");
  assert.deepEqual(other.poor.map((one) => one.name), ["calm 1", "calm 3"]);
});

test("news of lines: asked for again, not any more, cut off, gone back, and after a page that was closed", () => {
  const last = { name: "calm 9", number: 9, of: 9, attempt: 3, poor: [] };
  const log = new LineLog([{ name: "calm 9", what: "x", language: "", poor: ["old"] }]);
  log.see(line(last));
  assert.deepEqual(log.see(line({ state: "over", number: 9, of: 9, poor: ["it was over at once"] })), { sentences: ["it was over at once"], again: false });
  const cut = new LineLog();
  cut.see(line({ number: 2, of: 9, poor: ["old"], again: 1 }));
  assert.equal(cut.see(line({ state: "over", number: 9, of: 9, poor: ["old"] })), null, "ended in its middle");
  const back = new LineLog();
  back.see(line({ number: 3 }));
  assert.equal(back.see(line({ number: 2, poor: ["old"] })), null);
  assert.deepEqual(new LineLog().see(line({ poor: ["old"], again: 1 })), { sentences: ["old"], again: true });
  assert.equal(new LineLog().see(line({ state: "block", poor: ["of another day"] })), null);
  assert.ok(back.changed([{ name: "a", what: "", language: "", poor: [] }]) && !back.changed([]));
  assert.equal(askedAgain(line({ again: 2, attempt: 2 })), 3);
  assert.equal(newsWords({ sentences: ["a was lost", "b was lost", "c was lost", "d was lost"], again: true }), "The last line: a was lost, b was lost, c was lost and 1 more. It is asked for again at the end.");
  assert.match(newsWords({ sentences: ["nothing moved"], again: false }), /nothing moved\. It is asked for again the next time\.$/);
  assert.deepEqual([shownWords(line()), shownWords(line({ text: "" })), shownWords(line({ text: "", say: "" }))], ["The keeper wrote.", "Read calmly", "calm 1"]);
});

test("the end says how much was recorded, as far as that is known", () => {
  const dataset = readDataset({ name: "faces", performer: "anna", take: "a.mien", lines: 11, over: true });
  const ended = { dataset, known: KNOWN, before: 22, poor: [] };
  assert.equal(recordedWell(ended), 9);
  assert.deepEqual(endedSentences(ended), ["9 of 11 lines are recorded well.", "2 lines are left, and asked for the next time.", "anna has 31 lines in “faces” now, in 2 takes."]);
  assert.deepEqual(endedSentences({ ...ended, before: 20 })[1], "Nothing of this script is left.");
  assert.deepEqual(endedSentences({ ...ended, before: null }), ["anna has 31 lines in “faces” now, in 2 takes."]);
  assert.deepEqual(endedSentences({ ...ended, known: null }), []);
});

test("what this browser remembers is read with care, and holds no consent", () => {
  const nothing = readMemory(null);
  for (const odd of ["", "{", "7", "[]", '{"dataset":7,"before":"x","poor":"y","pace":"fast","dismissed":1}']) assert.deepEqual(readMemory(odd), nothing, odd);
  const kept = { ...nothing, dataset: "faces", pace: "voice", take: "a.mien", before: 3, poor: [{ name: "n", what: "w", language: "en", poor: ["p"] }] };
  assert.deepEqual(readMemory(JSON.stringify(kept)), kept);
  assert.ok(!Object.keys(nothing).some((key) => /agree|consent|sound/.test(key)));
});

test("phones, microphones and sensors are told from each other, and the worst stands first", () => {
  const hello = { sensors: [{ name: "phone", role: "truth", kind: "weights" }, { name: "microphone", role: "face", kind: "speech" }, { name: "a", role: "face", kind: "imu" }, { name: "b", role: "head", kind: "imu" }] };
  const links = [["phone", "no_face"], ["microphone", "good"], ["a", "good"], ["b", "lost"], ["unknown", "lossy"]].map(([sensor, state]) => ({ sensor, state }));
  assert.deepEqual(phonesOf(hello, { links }).map((one) => one.sensor), ["phone"]);
  assert.deepEqual(worstFirst(sensorsOf(hello, { links })).map((one) => one.sensor), ["b", "unknown", "a"]);
  assert.deepEqual(phonesOf(null, null), []);
  assert.equal(healthOf("no_face").label, "sees no face");
});

test("a microphone's loudness is said in words, and a voice is followed only where one is heard", () => {
  assert.deepEqual([0, 0.4, 0.62, 0.99].map((peak) => loudnessWords(peak).good), [false, false, true, false]);
  const hearing = { on: true, shut: false, trouble: "", blocks: 9, browser: null };
  assert.ok(isHeard(hearing) && isHeard({ ...hearing, blocks: 0, browser: { heard: true } }));
  assert.ok(isHeard({ ...hearing, blocks: 0 }), "a network's microphone counts no blocks");
  for (const not of [null, { ...hearing, on: false }, { ...hearing, shut: true }, { ...hearing, trouble: "silent for 5 s" }, { ...hearing, blocks: 0, browser: { heard: false } }]) assert.ok(!isHeard(not));
});

test("type is as large as fits", () => {
  assert.equal(largestSize((px) => px <= 57), 57);
  assert.equal(largestSize(() => true), 128);
  assert.equal(largestSize(() => false), 20);
});
