/** What this browser remembers of recordings: what was chosen last, and what it saw of the one that runs. Never a consent. */
import { LONGEST, type Pace } from "../dataset_protocol";
import { fieldsOf, list, number, text, texts } from "../reading";

const KEY = "mien.recording";

/** A line that was poor, as the page saw it. */
export interface PoorLine {
  /** Of the prompt. */
  name: string;
  /** What was asked for, in its own words. */
  what: string;
  language: string;
  poor: string[];
}

export interface Remembered {
  dataset: string;
  script: string;
  performer: string;
  recordedBy: string;
  purpose: string;
  pace: Pace;
  /** The take that was begun here, or seen, last; its other facts below. */
  take: string;
  /** Lines that its performer had recorded well before it; null where that was not learnt in time. */
  before: number | null;
  poor: PoorLine[];
  /** Its end was read and put away. */
  dismissed: boolean;
  /** This browser's camera records its video. */
  video: boolean;
}

const NOTHING: Remembered = {
  dataset: "", script: "", performer: "", recordedBy: "", purpose: "", pace: "key", take: "", before: null, poor: [], dismissed: false, video: false,
};

/** Reads what was kept; what is missing or odd becomes nothing. */
export function readMemory(kept: string | null): Remembered {
  let parsed: unknown = null;
  try {
    parsed = JSON.parse(kept ?? "null");
  } catch {
    // Somebody else's: begin as always.
  }
  const fields = fieldsOf(parsed);
  const before = fields["before"];
  return {
    dataset: text(fields["dataset"], "", LONGEST.dataset),
    script: text(fields["script"]),
    performer: text(fields["performer"], "", LONGEST.performer),
    recordedBy: text(fields["recordedBy"], "", LONGEST.recordedBy),
    purpose: text(fields["purpose"], "", LONGEST.purpose),
    pace: fields["pace"] === "voice" ? "voice" : "key",
    take: text(fields["take"]),
    before: typeof before === "number" ? number(before) : null,
    poor: list(fields["poor"], (one) => ({ name: text(one["name"]), what: text(one["what"]), language: text(one["language"]), poor: texts(one["poor"]) })),
    dismissed: fields["dismissed"] === true,
    video: fields["video"] === true,
  };
}

export class Memory {
  private kept: Remembered;

  constructor() {
    let found: string | null = null;
    try {
      found = localStorage.getItem(KEY);
    } catch {
      // A browser that keeps nothing: this page remembers alone, while it is open.
    }
    this.kept = readMemory(found);
  }

  get value(): Readonly<Remembered> {
    return this.kept;
  }

  set(change: Partial<Remembered>): void {
    this.kept = { ...this.kept, ...change };
    try {
      localStorage.setItem(KEY, JSON.stringify(this.kept));
    } catch {
      // As above.
    }
  }

  /** Another take: what was seen of the one before is void. */
  beginTake(take: string): void {
    if (take !== this.kept.take) this.set({ take, before: NOTHING.before, poor: NOTHING.poor, dismissed: NOTHING.dismissed, video: NOTHING.video });
  }
}
