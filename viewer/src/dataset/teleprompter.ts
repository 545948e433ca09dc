/** The lines of a recording, one at a time, to be read from afar: what now, how, what next, and how far all of it is. */
import type { Actions } from "../actions";
import { CountdownRing } from "../chrome/ring";
import { h, setAttribute, setHidden, setText } from "../dom";
import { clock } from "../format";
import { pauseIcon, playIcon } from "../icons";
import type { PromptStatus } from "../prompt_protocol";
import { fitText } from "./fit";
import { askedAgain, shownWords } from "./line_log";
import { titled } from "./words";

/** A remote that bounces must not go on by two lines, ms. */
const BOUNCE_MS = 350;
/** What was poor is read in passing, ms. */
const NEWS_MS = 7000;

export class Teleprompter {
  readonly element = h("section", { class: "tele", "aria-label": "Lines to perform", tabindex: -1 });
  /** Through which the faces are seen, where one is to be made. */
  readonly window = h("div", { class: "tele-window", hidden: true });
  private readonly emotion = h("span", { class: "tele-emotion", dir: "auto" });
  private readonly standing = h("span", { class: "tele-standing" });
  private readonly attempt = h("span", { class: "tele-attempt", text: "once more", hidden: true });
  private readonly say = h("p", { class: "tele-say", dir: "auto" });
  private readonly ring = new CountdownRing();
  private readonly text = h("p", { class: "tele-text", dir: "auto" });
  private readonly box = h("div", { class: "tele-box" }, this.text);
  private readonly next = h("p", { class: "tele-next", dir: "auto" });
  private readonly live = h("p", { class: "hidden-visually", "aria-live": "assertive" });
  private readonly news = h("p", { class: "tele-news", role: "status", hidden: true });
  private readonly bar = h("div", { class: "prompt-bar-run" });
  private readonly count = h("span");
  private readonly again = h("span", { class: "tele-again" });
  private readonly left = h("span");
  private readonly pauseText = h("span");
  private readonly pause: HTMLButtonElement;
  private readonly onward: HTMLButtonElement;
  private prompts: PromptStatus | null = null;
  private paused: boolean | null = null;
  private lastOnwardMs = -Infinity;
  private newsTimer = 0;

  constructor(
    private readonly actions: Actions,
    private readonly byVoice: () => boolean,
    private readonly skipped: (number: number) => void,
  ) {
    const back = h("button", { type: "button", class: "tele-button", onclick: () => this.repeat() }, h("span", { text: "Again" }), h("kbd", { text: "←" }));
    const skip = h("button", { type: "button", class: "tele-button", onclick: () => this.skip() }, h("span", { text: "Skip" }), h("kbd", { text: "S" }));
    this.pause = h("button", { type: "button", class: "tele-button", onclick: () => void actions.togglePrompts() });
    this.onward = h("button", { type: "button", class: "tele-button primary", onclick: () => this.goOn() }, h("span", { text: "Next" }), h("kbd", { text: "Enter" }));
    this.element.append(
      h("div", { class: "tele-top" }, this.ring.element, h("div", { class: "tele-how" }, h("div", { class: "tele-signs" }, this.standing, this.emotion, this.attempt), this.say)),
      this.box,
      this.window,
      h("div", { class: "tele-below" }, this.next, this.news),
      this.live,
      h(
        "footer",
        { class: "tele-foot" },
        h("div", { class: "prompt-bar", "aria-hidden": "true" }, this.bar),
        h("div", { class: "tele-figures" }, this.count, this.again, this.left),
        h("div", { class: "tele-buttons" }, back, this.pause, skip, this.onward),
      ),
    );
    new ResizeObserver(() => fitText(this.text, this.box)).observe(this.box);
  }

  focus(): void {
    this.element.focus({ preventScroll: true });
  }

  /** What was poor with the line before, for a moment; "": no more. */
  tell(news: string): void {
    window.clearTimeout(this.newsTimer);
    setText(this.news, news);
    setHidden(this.news, news === "");
    if (news !== "") this.newsTimer = window.setTimeout(() => setHidden(this.news, true), NEWS_MS);
  }

  /** Moves the ring between two messages of the session; called at the display's rate while it is shown. */
  draw(nowMs: number): void {
    this.ring.draw(nowMs);
  }

  goOn(): void {
    const now = performance.now();
    if (now - this.lastOnwardMs < BOUNCE_MS) return;
    const state = this.prompts?.state;
    if (state === "paused") void this.actions.togglePrompts();
    else if (state === "running" && this.prompts?.ownPace) void this.actions.steerPrompts("next");
    else return;
    this.lastOnwardMs = now;
  }

  repeat(): void {
    void this.actions.steerPrompts("again");
  }

  skip(): void {
    if (this.prompts) this.skipped(this.prompts.number);
    void this.actions.steerPrompts("skip");
  }

  update(prompts: PromptStatus): void {
    this.prompts = prompts;
    const { state } = prompts;
    const words = shownWords(prompts);
    const paused = state === "paused";
    const ready = state === "ready";
    setAttribute(this.element, "data-state", state);
    setAttribute(this.element, "data-pose", String(prompts.target !== null));
    setText(this.standing, paused ? "Paused" : ready ? "Get ready" : "");
    setHidden(this.standing, !paused && !ready);
    setText(this.emotion, titled(prompts.emotion));
    setHidden(this.emotion, paused || prompts.emotion === "");
    setHidden(this.attempt, prompts.attempt < 2);
    setText(this.say, this.sentence(prompts, words));
    const language = prompts.language || null;
    setAttribute(this.text, "lang", language);
    setAttribute(this.say, "lang", paused ? null : language);
    if (this.text.textContent !== words || this.window.hidden !== (prompts.target === null)) {
      setText(this.text, words);
      setHidden(this.window, prompts.target === null);
      fitText(this.text, this.box);
    }
    setAttribute(this.live, "lang", paused ? null : language);
    setText(this.live, paused ? "Paused." : ready ? "" : [titled(prompts.emotion), prompts.text === "" ? "" : prompts.say, words].filter((one) => one !== "").join(". "));
    const next = prompts.next ? prompts.next.text || titled(prompts.next.name) : "";
    setText(this.next, next === "" ? "The last line" : next);
    this.next.dataset["label"] = next === "" ? "" : "Next";
    setAttribute(this.next, "lang", prompts.next?.text ? language : null);

    const counted = ready || (state === "running" && !prompts.ownPace);
    setHidden(this.ring.element, !counted);
    this.ring.set(ready ? 0 : prompts.progress, counted ? prompts.remainingS : 0, counted);
    const within = ready || paused ? 0 : prompts.progress;
    this.bar.style.transform = `scaleX(${(prompts.of > 0 ? Math.min(1, (prompts.number - 1 + within) / prompts.of) : 0).toFixed(4)})`;
    setText(this.count, `${prompts.number} of ${prompts.of}`);
    const again = askedAgain(prompts);
    setText(this.again, again === 0 ? "" : `${again} to be asked for again`);
    setText(this.left, `${clock(Math.ceil(prompts.leftS))} left`);
    this.drawButtons(prompts, paused);
  }

  private sentence(prompts: PromptStatus, words: string): string {
    if (prompts.state === "paused") return "The recording goes on; nothing is asked for.";
    if (prompts.say !== "" && prompts.say !== words) return prompts.say;
    return prompts.text !== "" && this.byVoice() ? "Read it aloud: the next line comes when you are silent." : "";
  }

  private drawButtons(prompts: PromptStatus, paused: boolean): void {
    if (paused !== this.paused) {
      this.paused = paused;
      setText(this.pauseText, paused ? "Go on" : "Pause");
      this.pause.replaceChildren(paused ? playIcon() : pauseIcon(), this.pauseText, h("kbd", { text: "Space" }));
    }
    // What has a time of its own goes on by itself.
    this.onward.disabled = prompts.state !== "running" || !prompts.ownPace;
  }
}
