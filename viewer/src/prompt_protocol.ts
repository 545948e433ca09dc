/** What the session says of poses and lines that a performer is asked for: a part of protocol.ts. */
import { readTarget } from "./calibration_protocol";
import { count, fieldsOf, number, share, text, texts } from "./reading";

/** What is asked for now, or comes next. */
export interface PromptStatus {
  /** block: what comes next waits until its block is begun. */
  state: "block" | "ready" | "running" | "paused" | "over";
  name: string;
  /** What to do. */
  say: string;
  /** To be read aloud; empty: nothing is read. */
  text: string;
  /** The face to make, in our order; null where a text is read in one's own way, and when all are over. */
  target: Float32Array | null;
  /** The part of a recording script that it belongs to; empty: none. */
  block: string;
  /** In which it is read or made; empty: none is given. */
  emotion: string;
  /** Of what is read, as BCP 47 has it; empty where the session names none, or none that is a language. */
  language: string;
  /** It is shown until the performer goes on: `progress` and `remainingS` are only of what it usually takes. */
  ownPace: boolean;
  /** From 1; from 2 on it is asked for again. */
  attempt: number;
  /** What was poor with the line that was over last, a sentence each; empty: it was good. */
  poor: string[];
  /** How many of those to come are asked for again. */
  again: number;
  next: { name: string; text: string; target: Float32Array | null } | null;
  /** From 1. */
  number: number;
  of: number;
  /** Of the present one, 0 to 1. */
  progress: number;
  /** Of the present one; when ready, until it begins. */
  remainingS: number;
  /** Until all are over. */
  leftS: number;
}

/** next: what is shown at the performer's own pace was performed; again: it, or the one before, from its beginning. */
export type PromptDeed = "skip" | "pause" | "resume" | "stop" | "begin" | "next" | "again";

/** More than a session asks for. */
const MOST_PROMPTS = 10_000;
/** What is read is longer than other texts: 2000 bytes. */
const LONGEST_READ = 2000;
/** Nor for longer, s. */
const LONGEST_S = 360_000;
const STATES = ["block", "ready", "running", "paused", "over"] as const;

/** A face of zeros beside a text is no face to make: the session has one for every line. */
function poseBeside(target: Float32Array | null, read: string): Float32Array | null {
  return target && (read === "" || target.some((weight) => weight > 0)) ? target : null;
}

function seconds(value: unknown): number {
  return Math.min(LONGEST_S, Math.max(0, number(value)));
}

function languageOf(value: unknown): string {
  const tag = text(value);
  return /^[A-Za-z]{2,8}(-[A-Za-z0-9]{1,8})*$/.test(tag) && tag.length <= 35 ? tag : "";
}

function readNext(value: unknown): PromptStatus["next"] {
  const fields = fieldsOf(value);
  const name = text(fields["name"]);
  const read = text(fields["text"], "", LONGEST_READ);
  const target = readTarget(fields["target"]);
  return target || read !== "" ? { name, text: read, target: poseBeside(target, read) } : null;
}

export function readPrompts(value: unknown): PromptStatus | null {
  const fields = fieldsOf(value);
  const state = STATES.find((one) => one === fields["state"]);
  if (!state) return null;
  const read = text(fields["text"], "", LONGEST_READ);
  return {
    state,
    name: text(fields["name"]),
    say: text(fields["say"]),
    text: read,
    target: poseBeside(readTarget(fields["target"]), read),
    block: text(fields["block"]),
    emotion: text(fields["emotion"]),
    language: languageOf(fields["language"]),
    ownPace: fields["own_pace"] === true,
    attempt: Math.max(1, count(fields["attempt"], MOST_PROMPTS)),
    poor: texts(fields["poor"]),
    again: count(fields["again"], MOST_PROMPTS),
    next: readNext(fields["next"]),
    number: count(fields["number"], MOST_PROMPTS),
    of: count(fields["of"], MOST_PROMPTS),
    progress: share(fields["progress"]),
    remainingS: seconds(fields["remaining_s"]),
    leftS: seconds(fields["left_s"]),
  };
}

/** Whether something is asked for, now or once the performer goes on. */
export function isAsking(prompts: PromptStatus | null | undefined): prompts is PromptStatus {
  return prompts != null && prompts.state !== "over";
}

/** Whether it is for the teleprompter: a line of a script's block, not one of the poses of a plain recording. */
export function isLine(prompts: PromptStatus | null | undefined): boolean {
  return isAsking(prompts) && (prompts.block !== "" || prompts.state === "block");
}
