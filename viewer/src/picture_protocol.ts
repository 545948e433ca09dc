/** What the session sends of its cameras, to a page that asked for it: a part of protocol.ts. */
import { fieldsOf, number } from "./reading";

/** Of a session with cameras. */
export interface PicturesStatus {
  /** Cameras whose pictures can be looked at. */
  cameras: number;
  /** Pages that are shown them now. */
  watchers: number;
}

/** What a camera sees, as the network has it. */
export interface CameraPicture {
  type: "picture";
  /** Its number among the sensors of `hello`. */
  sensor: number;
  width: number;
  height: number;
  /** Grey levels, row by row from the top. */
  pixels: Uint8Array;
}

export function readPictures(value: unknown): PicturesStatus | null {
  if (typeof value !== "object" || value === null || Array.isArray(value)) return null;
  const fields = fieldsOf(value);
  return { cameras: Math.max(0, number(fields["cameras"])), watchers: Math.max(0, number(fields["watchers"])) };
}

const MAGIC = "MPIC";
const VERSION = 1;
const HEAD_BYTES = 12;
/** A session's views have 96 pixels either way. */
const MOST_PIXELS = 512;

/** Reads a binary message of the session. Null: not for us. */
export function readPicture(message: ArrayBuffer): CameraPicture | null {
  if (message.byteLength < HEAD_BYTES) return null;
  const view = new DataView(message);
  for (let i = 0; i < MAGIC.length; ++i) if (view.getUint8(i) !== MAGIC.charCodeAt(i)) return null;
  if (view.getUint8(4) !== VERSION) return null;
  const [sensor, width, height] = [view.getUint16(6, true), view.getUint16(8, true), view.getUint16(10, true)];
  if (width === 0 || height === 0 || width > MOST_PIXELS || height > MOST_PIXELS) return null;
  if (message.byteLength !== HEAD_BYTES + width * height) return null;
  return { type: "picture", sensor, width, height, pixels: new Uint8Array(message, HEAD_BYTES) };
}
