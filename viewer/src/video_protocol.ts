/** What the session says of the video beside a recording, and what a browser's camera sends it: a part of protocol.ts. */
import { count, fieldsOf, number, text } from "./reading";

export interface VideoStatus {
  /** A recording runs whose performer agreed to it. */
  agreed: boolean;
  /** Video is being written. */
  on: boolean;
  /** The newest file's name; empty before the first. */
  file: string;
  files: number;
  megabytes: number;
  /** Why none is written, or what is wrong with it; empty: nothing. */
  trouble: string;
}

export function readVideo(value: unknown): VideoStatus | null {
  if (typeof value !== "object" || value === null || Array.isArray(value)) return null;
  const fields = fieldsOf(value);
  return {
    agreed: fields["agreed"] === true,
    on: fields["on"] === true,
    file: text(fields["file"]),
    files: count(fields["files"], 1000),
    megabytes: Math.max(0, number(fields["megabytes"])),
    trouble: text(fields["trouble"]),
  };
}

/** The camera of this browser, which was recorded, is recorded no more. */
export interface VideoOver {
  type: "video";
  /** Empty: the recording is over. */
  why: string;
  /** It is to begin anew, with another file. */
  again: boolean;
}

/** What a MediaRecorder wraps its video in. */
export type Container = "webm" | "mp4";

const CONTAINERS: Readonly<Record<Container, number>> = { webm: 1, mp4: 2 };
const MAGIC = "MVID";
const VERSION = 1;
const HEAD_BYTES = 16;

/** A chunk of video as the session takes it. `sequence`: from 0, with which a file begins; `ageMs`: since the first frame. */
export function videoMessage(container: Container, sequence: number, ageMs: number, data: ArrayBuffer): ArrayBuffer {
  const message = new Uint8Array(HEAD_BYTES + data.byteLength);
  const view = new DataView(message.buffer);
  for (let i = 0; i < MAGIC.length; ++i) view.setUint8(i, MAGIC.charCodeAt(i));
  view.setUint8(4, VERSION);
  view.setUint8(5, CONTAINERS[container]);
  view.setUint32(8, sequence, true);
  view.setUint32(12, Math.max(0, Math.round(ageMs)), true);
  message.set(new Uint8Array(data), HEAD_BYTES);
  return message.buffer;
}
