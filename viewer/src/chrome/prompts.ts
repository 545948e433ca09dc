/** The poses of a recording over the face: which one now, a ring that runs down, what comes next, and how far all of it is. */
import type { Actions } from "../actions";
import { h, setAttribute, setHidden, setText } from "../dom";
import { clock } from "../format";
import { isAsking, isLine, type PromptStatus } from "../prompt_protocol";
import type { Session } from "../session";
import { CountdownRing } from "./ring";

export class PromptGuide {
  readonly element = h("section", { class: "guide prompts", "aria-label": "Poses of this recording", hidden: true });
  private readonly ring = new CountdownRing();
  private readonly title = h("h2", { "aria-live": "assertive", dir: "auto" });
  private readonly say = h("p");
  private readonly next = h("p", { class: "prompt-next quiet" });
  private readonly bar = h("div", { class: "prompt-bar-run" });
  private readonly count = h("span");
  private readonly left = h("span");
  private readonly pause = h("button", { type: "button", class: "button", onclick: () => void this.actions.togglePrompts() });
  private shown = "";

  constructor(
    session: Session,
    private readonly actions: Actions,
  ) {
    const skip = h("button", { type: "button", class: "button", text: "Skip", title: "Go on to the next pose", onclick: () => void actions.skipPrompt() });
    this.element.append(
      h(
        "div",
        { class: "guide-running" },
        this.ring.element,
        h("div", { class: "guide-words" }, this.title, this.say, this.next),
        h("div", { class: "prompt-buttons" }, this.pause, skip),
      ),
      h("div", { class: "prompt-bar", "aria-hidden": "true" }, this.bar),
      h("div", { class: "prompt-figures quiet" }, this.count, this.left),
    );
    session.status.listen((status) => this.update(status?.prompts ?? null));
  }

  get open(): boolean {
    return !this.element.hidden;
  }

  /** Moves the ring between two messages of the session; called at the display's rate while it is open. */
  draw(nowMs: number): void {
    this.ring.draw(nowMs);
  }

  private update(prompts: PromptStatus | null): void {
    // Lines of a script are the teleprompter's.
    const asking = isAsking(prompts) && !isLine(prompts);
    setHidden(this.element, !asking);
    if (!asking) return;
    const ready = prompts.state === "ready";
    const paused = prompts.state === "paused";
    const title = paused ? "Paused" : ready ? "Get ready" : prompts.text || prompts.name;
    if (title !== this.shown) {
      this.shown = title;
      this.title.classList.remove("fresh");
      void this.title.offsetWidth;
      this.title.classList.add("fresh");
    }
    setText(this.title, title);
    setAttribute(this.title, "lang", title === prompts.text ? prompts.language || null : null);
    setText(this.say, paused ? "The recording goes on; no pose is asked for." : ready ? `First: ${prompts.name}` : prompts.say);
    setText(this.next, ready || paused ? prompts.say : prompts.next ? `Next: ${prompts.next.name}` : "The last one");
    this.element.dataset["state"] = prompts.state;
    this.ring.set(ready ? 0 : prompts.progress, paused ? 0 : prompts.remainingS, !paused);
    const done = prompts.of > 0 ? (prompts.number - 1 + (ready || paused ? 0 : prompts.progress)) / prompts.of : 0;
    this.bar.style.transform = `scaleX(${done.toFixed(4)})`;
    setText(this.count, `${prompts.number} of ${prompts.of}`);
    setText(this.left, `${clock(Math.ceil(prompts.leftS))} left`);
    setText(this.pause, paused ? "Go on" : "Pause");
  }
}
