/** What the page calls the session, in a word, and the colour of that word's dot. */
import type { ConnectionState } from "../connection";
import type { Status } from "../protocol";

export type Tone = "idle" | "live" | "replay" | "record" | "bad";

/** It is `live` once there was a frame: a session that heard nothing waits. */
export function sessionWord(connection: ConnectionState, status: Pick<Status, "frames" | "recording" | "replay"> | null): { text: string; tone: Tone } {
  switch (connection.kind) {
    case "open":
      if (status?.recording.on) return { text: "recording", tone: "record" };
      if (status?.replay) return { text: status.replay.paused ? "replay, paused" : "replay", tone: "replay" };
      return status && status.frames > 0 ? { text: "live", tone: "live" } : { text: "waiting", tone: "idle" };
    case "stalled":
      return { text: "no news", tone: "bad" };
    case "lost":
      return { text: connection.refused ? "refused" : "connection lost", tone: "bad" };
    default:
      return { text: "connecting", tone: "idle" };
  }
}
