/** Short texts that come and go: answers to what was asked here, and what the session reports. */
import { h } from "../dom";
import type { Session } from "../session";
import type { ViewState } from "../view_state";

const SHOWN_MS = 5000;
/** Bad news stays longer. */
const BAD_MS = 9000;
const MOST = 3;
const BAD_KINDS = /lost|fail|full|error|missing|disk|contested/;

export class Notices {
  readonly element = h("div", { class: "notices", role: "status", "aria-live": "polite" });

  constructor(session: Session, view: ViewState) {
    let seen = 0;
    session.events.listen((events) => {
      const newest = events[events.length - 1];
      if (!newest || newest.atMs <= seen) return;
      seen = newest.atMs;
      this.show(newest.text, BAD_KINDS.test(newest.kind) ? "bad" : "plain");
    });
    view.notices.listen((notice) => {
      if (notice) this.show(notice.text, notice.tone);
    });
  }

  /** Takes all away at once. */
  clear(): void {
    this.element.replaceChildren();
  }

  private show(text: string, tone: "plain" | "good" | "bad"): void {
    if (text === "") return;
    for (const child of this.element.children) if (child.textContent === text) child.remove();
    const notice = h("div", { class: "notice", "data-tone": tone, text });
    this.element.append(notice);
    while (this.element.childElementCount > MOST) this.element.firstElementChild?.remove();
    window.setTimeout(() => notice.remove(), tone === "bad" ? BAD_MS : SHOWN_MS);
  }
}
