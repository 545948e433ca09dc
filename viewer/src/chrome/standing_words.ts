/** What stands over a face that is not live: why it is not, and what can be done. */
import type { ConnectionState } from "../connection";
import type { Standing } from "../provenance";
import type { Status } from "../protocol";

/** `away`: nothing of the session is known right now. */
export type ShownStanding = Standing | "away";

export function standingSentence(standing: ShownStanding, connection: ConnectionState, status: Status | null): string {
  switch (standing) {
    case "away":
      return awaySentence(connection, status);
    case "held":
      return "Held: nothing new is measured, this is the last face.";
    case "neutral":
      return neutralSentence(status);
    case "resting":
      return "Nothing is measured: held and neutral values only.";
    case "live":
      return "";
  }
}

function awaySentence(connection: ConnectionState, status: Status | null): string {
  if (connection.kind === "stalled") return "Nothing is received from the session.";
  if (connection.kind !== "lost") return "Connecting.";
  if (connection.refused) return "The session refuses this page: its address lacks the right token.";
  if (status?.prompts?.state === "over") return "The recording is over, and the session has ended.";
  return "Connection lost. Trying again.";
}

function neutralSentence(status: Status | null): string {
  // Links and calibration are those of the devices, also while a take is played: they explain nothing of its face.
  if (status?.replay) return "Neutral: nothing is measured at this time of the take.";
  const calibration = status?.calibration.state;
  if (calibration === "running") return "Neutral while it calibrates.";
  if ((status?.links ?? []).every((link) => link.state === "silent" || link.state === "unbound"))
    return "Neutral: no sensor has sent anything yet. Switch them on.";
  return calibration === "none" || calibration === "watching" || calibration === "failed"
    ? "Neutral: not calibrated yet, so nothing is measured."
    : "Neutral: nothing is measured.";
}
