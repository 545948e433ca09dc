/** What the session says of who can send to it, and of pairing: a part of protocol.ts. */
import { type Fields, fieldsOf, list, number, text, texts } from "./reading";

/** Who can send to the session. */
export interface NetworkStatus {
  /** Ports that listen on every interface. */
  open: string[];
  /** By which these are reached. */
  interfaces: { name: string; address: string; loopback: boolean }[];
  /** What they are narrowed to; empty: nothing. */
  only: string;
  /** Packets refused because they came in elsewhere. */
  elsewhere: number;
  /** Only who has the key is received. */
  sealed: boolean;
  refused: number;
}

/** How a board gets the session's key. */
export interface Pairing {
  file: string;
  firmware: string;
  command: string;
  inForce: boolean;
}

export function readNetwork(value: unknown): NetworkStatus | null {
  if (typeof value !== "object" || value === null || Array.isArray(value)) return null;
  const fields = fieldsOf(value);
  return {
    open: texts(fields["open"]),
    interfaces: list(fields["interfaces"], (one) => ({
      name: text(one["name"]),
      address: text(one["address"]),
      loopback: one["loopback"] === true,
    })).filter((one) => one.name !== ""),
    only: text(fields["only"]),
    elsewhere: Math.max(0, number(fields["elsewhere"])),
    sealed: fields["sealed"] === true,
    refused: Math.max(0, number(fields["refused"])),
  };
}

/** The answer to the command `pair`; null where it is none. */
export function readPairing(result: Fields | null): Pairing | null {
  const fields = fieldsOf(result);
  const pairing = { file: text(fields["file"]), firmware: text(fields["firmware"]), command: text(fields["command"]), inForce: fields["in_force"] === true };
  return pairing.firmware === "" ? null : pairing;
}
