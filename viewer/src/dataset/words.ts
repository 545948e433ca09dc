/** What is said about datasets, scripts and lines: sentences of their numbers. */
import { type DatasetList, performerOf, type Script, type ScriptBlock } from "../dataset_protocol";

/** "1 line", "12 lines". */
export function lineCount(lines: number): string {
  return `${lines} ${lines === 1 ? "line" : "lines"}`;
}

/** Of a time that is only known roughly: "under a minute", "about 3 min". */
export function aboutMinutes(seconds: number): string {
  const minutes = Math.round(seconds / 60);
  if (minutes < 1) return "under a minute";
  return minutes < 120 ? `about ${minutes} min` : `about ${Math.round(minutes / 60)} h`;
}

/** As a title: its first letter large, whatever the alphabet. */
export function titled(words: string): string {
  const [first = "", ...rest] = [...words.replaceAll("_", " ")];
  return first.toLocaleUpperCase() + rest.join("");
}

/** A language's name in English; the tag itself where there is none. */
export function languageName(tag: string): string {
  if (tag === "") return "";
  try {
    return new Intl.DisplayNames(["en"], { type: "language" }).of(tag) ?? tag;
  } catch {
    return tag;
  }
}

/** The blocks by name, each once: lines and time of those that share a name together. */
export function blocksOf(script: Script): ScriptBlock[] {
  const blocks = new Map<string, ScriptBlock>();
  for (const { name, lines, seconds } of script.blocks) {
    const before = blocks.get(name);
    blocks.set(name, { name, lines: lines + (before?.lines ?? 0), seconds: seconds + (before?.seconds ?? 0) });
  }
  return [...blocks.values()];
}

export function wholeOf(script: Script): { lines: number; seconds: number } {
  return script.blocks.reduce((sum, one) => ({ lines: sum.lines + one.lines, seconds: sum.seconds + one.seconds }), { lines: 0, seconds: 0 });
}

/** How many lines this performer has done, and how many of the script are left: as far as the list knows. */
export function progressWords(known: DatasetList, dataset: string, performer: string, script: Script | null): string {
  if (dataset === "" || performer === "" || !script) return "";
  const { lines, seconds } = wholeOf(script);
  const before = performerOf(known, dataset, performer);
  if (!before || before.lines === 0) return `Nothing of ${performer} is in “${dataset}” yet: all ${lineCount(lines)} are asked for, ${aboutMinutes(seconds)}.`;
  const done = `${performer} has ${lineCount(before.lines)} in “${dataset}” already, in ${before.takes} ${before.takes === 1 ? "take" : "takes"}.`;
  // Lines are counted over all scripts: of this one no more than so many are done.
  const left = Math.max(0, lines - before.lines);
  return left > 0
    ? `${done} What is recorded well is not asked for again: of this script's ${lines} at least ${left} ${left === 1 ? "is" : "are"} left.`
    : `${done} What is recorded well is not asked for again.`;
}

const BLOCKS: Readonly<Record<string, string>> = {
  calm: "Read each text aloud, calmly, in your own voice.",
  expressions: "Make each face, or say each line, as the word above it says.",
  emotional: "Say each line as if you meant it: the word above it names the feeling.",
};

/** What a block asks for; empty where it is none that is known. */
export function blockSentence(block: string): string {
  return (Object.hasOwn(BLOCKS, block) ? BLOCKS[block] : undefined) ?? "";
}

/** From what level on somebody speaks loud enough, and too loud: a microphone's level is 0 at -60 dB, 1 at 0 dB. */
const FAINT = 0.3;
const QUIET = 0.45;
const LOUD = 0.93;

/** How loud the loudest of the last seconds was, in words. */
export function loudnessWords(peak: number): { words: string; good: boolean } {
  if (peak < FAINT) return { words: "Nothing is heard yet: say a few words.", good: false };
  if (peak < QUIET) return { words: "You are heard, but quietly: come nearer to the microphone, or turn it up.", good: false };
  if (peak > LOUD) return { words: "Too loud: the sound is cut off. Turn the microphone down, or step back.", good: false };
  return { words: "You are heard well.", good: true };
}
