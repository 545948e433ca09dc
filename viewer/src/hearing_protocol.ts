/** What the session says of what it hears, and what a browser's microphone sends it: a part of protocol.ts. */
import { fieldsOf, number, share, text } from "./reading";

export interface Hearing {
  /** Sound may answer; false: a microphone is closed. */
  on: boolean;
  speaks: boolean;
  /** Of the frames so far, those of which a shape is from sound. */
  share: number;
  /** By how much sound lags behind the face. */
  laterMs: number;
  /** The session was started with every microphone shut. */
  shut: boolean;
  /** Blocks of 20 ms that were heard so far. */
  blocks: number;
  /** What stands against hearing now; empty: nothing. */
  trouble: string;
  /** Null: the session hears no browser's microphone. */
  browser: { heard: boolean; refused: number } | null;
}

export function readHearing(value: unknown): Hearing | null {
  if (typeof value !== "object" || value === null || Array.isArray(value)) return null;
  const fields = fieldsOf(value);
  const browser = fields["browser"];
  return {
    on: fields["on"] === true,
    speaks: fields["speaks"] === true,
    share: share(fields["share"]),
    laterMs: number(fields["later_ms"]),
    shut: fields["shut"] === true,
    blocks: number(fields["blocks"]),
    trouble: text(fields["trouble"]),
    browser: typeof browser === "object" && browser !== null
      ? { heard: fieldsOf(browser)["heard"] === true, refused: number(fieldsOf(browser)["refused"]) }
      : null,
  };
}

/** The microphone of this browser, which was heard, is heard no more. */
export interface MicrophoneOver {
  type: "microphone";
  /** Empty: the voice was switched off. */
  why: string;
}

const MAGIC = "MSND";
const VERSION = 1;
const HEAD_BYTES = 20;

/**
 * A piece of sound as the session takes it, 16 bits a sample. `count`: samples before these since the sound began. A
 * tenth of a second at most.
 */
export function soundMessage(rateHz: number, count: number, samples: Int16Array): ArrayBuffer {
  const message = new ArrayBuffer(HEAD_BYTES + 2 * samples.length);
  const view = new DataView(message);
  for (let i = 0; i < MAGIC.length; ++i) view.setUint8(i, MAGIC.charCodeAt(i));
  view.setUint8(4, VERSION);
  view.setUint32(8, rateHz, true);
  view.setBigUint64(12, BigInt(count), true);
  samples.forEach((sample, i) => view.setInt16(HEAD_BYTES + 2 * i, sample, true));
  return message;
}
