/** Short texts that come and go: answers to what was asked here, and what the session reports. */
import { h } from "../dom";
import type { Session } from "../session";
import type { ViewState } from "../view_state";

const SHOWN_MS = 5000;
/** Bad news stays longer. */
const BAD_MS = 9000;
const MOST = 3;
const BAD_KINDS = /lost|fail|full|error|missing|disk|contested/;

/** Kinds of events that tell of one thing, each by turns: the newest of them is what holds. */
const SUBJECTS: Readonly<Record<string, string>> = {
  frames_held: "hold", frames_punctual: "hold",
  sensor_lost: "sensor", sensor_back: "sensor",
  line_lost: "line", line_back: "line",
  packets_lost: "sender", packets_taken: "sender",
};

/**
 * What an event is about, where a later one takes its place on the page: it would contradict it otherwise. "": nothing
 * of the kind. Sensors and lines are each for itself, named by the text's first word.
 */
export function subjectOf(kind: string, text: string): string {
  const subject = Object.hasOwn(SUBJECTS, kind) ? (SUBJECTS[kind] ?? "") : "";
  if (subject === "" || subject === "hold") return subject;
  const first = text.split(" ", 1)[0] ?? "";
  // News of several at once, "6 sensors are lost", is about no one of them.
  return /^\d+$/.test(first) ? `${subject}s` : `${subject} ${first}`;
}

/** Whether news of `newer` takes the place of news of `older`: of the same, or of several among which it may be. */
export function sameSubject(older: string, newer: string): boolean {
  if (older === newer) return true;
  const several = (subject: string) => subject.endsWith("s") && !subject.includes(" ");
  const kind = (subject: string) => (several(subject) ? subject.slice(0, -1) : subject.split(" ", 1)[0]);
  return (several(older) || several(newer)) && kind(older) === kind(newer);
}

export class Notices {
  readonly element = h("div", { class: "notices", role: "status", "aria-live": "polite" });

  constructor(session: Session, view: ViewState) {
    let seen = 0;
    session.events.listen((events) => {
      const newest = events[events.length - 1];
      if (!newest || newest.atMs <= seen) return;
      seen = newest.atMs;
      this.show(newest.text, BAD_KINDS.test(newest.kind) ? "bad" : "plain", subjectOf(newest.kind, newest.text));
    });
    view.notices.listen((notice) => {
      if (notice) this.show(notice.text, notice.tone);
    });
  }

  /** Takes all away at once. */
  clear(): void {
    this.element.replaceChildren();
  }

  private show(text: string, tone: "plain" | "good" | "bad", subject = ""): void {
    if (text === "") return;
    for (const child of [...this.element.querySelectorAll<HTMLElement>(".notice")]) {
      const overtaken = subject !== "" && sameSubject(child.dataset["subject"] ?? "", subject);
      if (overtaken || child.textContent === text) child.remove();
    }
    const notice = h("div", { class: "notice", "data-tone": tone, "data-subject": subject || null, text });
    this.element.append(notice);
    while (this.element.childElementCount > MOST) this.element.firstElementChild?.remove();
    window.setTimeout(() => notice.remove(), tone === "bad" ? BAD_MS : SHOWN_MS);
  }
}
