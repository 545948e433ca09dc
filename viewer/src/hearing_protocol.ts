/** What the session says of what it hears: a part of protocol.ts. */
import { fieldsOf, number, share } from "./reading";

export interface Hearing {
  /** Sound may answer; false: a microphone is closed. */
  on: boolean;
  speaks: boolean;
  /** Of the frames so far, those of which a shape is from sound. */
  share: number;
  /** By how much sound lags behind the face. */
  laterMs: number;
}

export function readHearing(value: unknown): Hearing | null {
  if (typeof value !== "object" || value === null || Array.isArray(value)) return null;
  const fields = fieldsOf(value);
  return { on: fields["on"] === true, speaks: fields["speaks"] === true, share: share(fields["share"]), laterMs: number(fields["later_ms"]) };
}
