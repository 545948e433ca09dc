/** What the state of a link means: one word, one sentence, and how bad it is. Colours stand in theme.css. */

export type Severity = "good" | "warn" | "bad" | "idle";

export interface Health {
  label: string;
  severity: Severity;
  /** Drawn inside the dot, so that colour is never alone in saying it. */
  mark: string;
  sentence: string;
}

const HEALTH: Readonly<Record<string, Health>> = {
  good: { label: "good", severity: "good", mark: "", sentence: "Heard in full and in time." },
  lossy: { label: "lossy", severity: "warn", mark: "!", sentence: "Packets go missing. Move the access point nearer, or change its channel." },
  late: { label: "late", severity: "warn", mark: "!", sentence: "Its packets come too late for their frame." },
  lost: { label: "lost", severity: "bad", mark: "×", sentence: "Nothing is received any more. Check its battery or cable, and the network." },
  frozen: { label: "frozen", severity: "bad", mark: "‖", sentence: "It still sends, but always the same reading. Switch it off and on." },
  saturated: { label: "saturated", severity: "warn", mark: "▲", sentence: "It moved faster than it can measure." },
  unchanged: { label: "unchanged", severity: "warn", mark: "=", sentence: "The board answers, but has nothing new to say." },
  restarted: { label: "restarted", severity: "warn", mark: "↻", sentence: "It has just restarted; its clock is being learnt again." },
  duplicate: { label: "duplicate", severity: "bad", mark: "2", sentence: "Two devices use this id. Choose which is heard, and give the other another." },
  no_face: { label: "sees no face", severity: "bad", mark: "∅", sentence: "It is there, but sees no face. Hold it before the face, and see to the light." },
  silent: { label: "silent", severity: "idle", mark: "…", sentence: "Bound to a device that has sent nothing yet." },
  unbound: { label: "unbound", severity: "idle", mark: "+", sentence: "No device is bound to this site." },
};

/** On the face while a take is played: what the devices do meanwhile is nothing of that face. */
export const REPLAYED: Health = { label: "replayed", severity: "idle", mark: "", sentence: "A take is played; the devices have no part in it." };

const UNKNOWN: Health = { label: "unknown", severity: "idle", mark: "?", sentence: "The session names a state that this page does not know." };

export const HEALTH_STATES: readonly string[] = Object.keys(HEALTH);

export function healthOf(state: string): Health {
  return (Object.hasOwn(HEALTH, state) ? HEALTH[state] : undefined) ?? UNKNOWN;
}
