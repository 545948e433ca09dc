/**
 * Which lines were poor, found out from one status after the other: the session says it of the line that was over last, and
 * the page adds which that was.
 */
import type { PromptStatus } from "../prompt_protocol";
import type { PoorLine } from "./memory";

/** What was poor with the line that is just over. */
export interface PoorNews {
  sentences: string[];
  /** It will be asked for again in this recording. */
  again: boolean;
}

/** What is asked for, in the words that are shown large. */
export function shownWords(prompts: Pick<PromptStatus, "name" | "say" | "text">): string {
  return prompts.text || prompts.say || prompts.name;
}

/** How many lines are still asked for once more, the present one among them. */
export function askedAgain(prompts: Pick<PromptStatus, "again" | "attempt" | "state">): number {
  return prompts.again + (prompts.attempt > 1 && prompts.state !== "over" ? 1 : 0);
}

export class LineLog {
  private before: PromptStatus | null = null;
  private skipped = -1;
  private readonly lines: Map<string, PoorLine>;

  constructor(known: readonly PoorLine[] = []) {
    this.lines = new Map(known.map((line) => [line.name, line]));
  }

  /** Lines whose last attempt was poor. */
  get poor(): PoorLine[] {
    return [...this.lines.values()];
  }

  /** Whether it knows otherwise than this. */
  changed(known: readonly PoorLine[]): boolean {
    return known.length !== this.lines.size || known.some((line) => !same(line.poor, this.lines.get(line.name)?.poor ?? []));
  }

  /** The line of this number is being skipped: it is neither poor nor good. */
  skip(number: number): void {
    this.skipped = number;
  }

  /** The session's next word. Gives news where a line was over, and poor. */
  see(now: PromptStatus): PoorNews | null {
    const before = this.before;
    this.before = now;
    if (!before) {
      // The page came in the middle. Before a block, what was poor may be of a recording long ago.
      return now.state === "block" || now.state === "over" || now.poor.length === 0 ? null : { sentences: now.poor, again: askedAgain(now) > 0 };
    }
    // Of a recording that was ended early nothing is known of the line that was cut off.
    const over = now.state === "over" ? before.number === before.of : now.number === before.number + 1;
    if (!over || before.state !== "running" || before.number === this.skipped) return null;
    if (now.poor.length === 0) {
      this.lines.delete(before.name);
      return null;
    }
    const gained = askedAgain(now) - askedAgain(before);
    const again = now.state !== "over" && gained >= (before.attempt > 1 ? 0 : 1);
    // Skipped by somebody else: what was poor is still that of a line before.
    if (!again && now.state !== "over" && same(before.poor, now.poor)) return null;
    this.lines.set(before.name, { name: before.name, what: shownWords(before), language: before.language, poor: now.poor });
    return { sentences: now.poor, again };
  }
}

function same(a: readonly string[], b: readonly string[]): boolean {
  return a.length === b.length && a.every((one, i) => one === b[i]);
}
