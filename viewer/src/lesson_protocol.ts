/** What page and session say of learning the wearer from a phone: a part of protocol.ts. */
import { fieldsOf, share, text } from "./reading";

export interface PhoneLesson {
  /** recording: the performer is asked for expressions and texts; learning: from what was recorded then. */
  state: "recording" | "learning" | "done" | "failed";
  /** What came of it; empty until then. */
  sentence: string;
  /** While learning: how much of that is done, 0 to 1. */
  learnt: number;
}

export type LessonCommand = { command: "learn_phone"; do: "begin" | "cancel" };

/** Null: there was none in this session. */
export function readLesson(value: unknown): PhoneLesson | null {
  if (typeof value !== "object" || value === null) return null;
  const fields = fieldsOf(value);
  const state = fields["state"];
  if (state !== "recording" && state !== "learning" && state !== "done" && state !== "failed") return null;
  return { state, sentence: text(fields["sentence"]), learnt: share(fields["learnt"]) };
}
