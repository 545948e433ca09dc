/** Whether a microphone is heard, and how loud, before a block: a level that lives, and a word on it. */
import { h, setAttribute, setHidden, setText } from "../dom";
import type { BrowserMicrophone } from "../microphone";
import { microphoneLevel, microphoneOf, microphoneWords } from "../panels/voice";
import type { Status } from "../protocol";
import type { Session } from "../session";
import { loudnessWords } from "./words";

/** Speech has pauses: the loudest of so long counts, ms. */
const PEAK_MS = 4000;

export class MicrophoneCheck {
  readonly element: HTMLElement;
  private readonly run = h("div", { class: "meter-run" });
  private readonly top = h("div", { class: "meter-top" });
  private readonly meter = h("div", { class: "meter", role: "meter", "aria-label": "Level of the microphone", "aria-valuemin": 0, "aria-valuemax": 100 }, this.run, this.top);
  private readonly words = h("p");
  private readonly use: HTMLButtonElement;
  private readonly used = h("p", { class: "quiet" });
  private levels: { atMs: number; level: number }[] = [];

  constructor(
    private readonly session: Session,
    private readonly microphone: BrowserMicrophone,
  ) {
    this.use = h("button", { type: "button", class: "button", onclick: () => microphone.toggle() });
    this.element = h("section", { class: "check-part" }, h("h3", { text: "Microphone" }), this.meter, this.words, this.use, this.used);
  }

  update(status: Status): void {
    const { hearing } = status;
    const level = microphoneLevel(this.session.hello.value, status);
    const now = performance.now();
    this.levels = this.levels.filter(({ atMs }) => now - atMs < PEAK_MS);
    if (level !== null) this.levels.push({ atMs: now, level });
    const peak = Math.max(0, ...this.levels.map((one) => one.level));
    setHidden(this.meter, level === null);
    this.run.style.transform = `scaleX(${(level ?? 0).toFixed(3)})`;
    this.top.style.left = `${(100 * peak).toFixed(1)}%`;
    setAttribute(this.meter, "aria-valuenow", String(Math.round(100 * (level ?? 0))));

    const { words, severity } = this.judge(status, level === null ? null : peak);
    setText(this.words, words);
    setAttribute(this.element, "data-severity", severity);
    const { kind } = this.microphone.state.value;
    const running = kind === "on" || kind === "asking";
    setHidden(this.use, !hearing?.browser || (!hearing.on && !running));
    setText(this.use, running ? "Stop this browser's microphone" : "Use this browser's microphone");
    const used = hearing ? microphoneWords(this.microphone.state.value, hearing) : "";
    setText(this.used, used);
    setHidden(this.used, used === "");
  }

  private judge({ hearing }: Status, peak: number | null): { words: string; severity: string } {
    if (!hearing || microphoneOf(this.session.hello.value) === null) return { words: "This session hears no microphone: the recording will be without sound.", severity: "idle" };
    if (hearing.shut || !hearing.on) return { words: "The microphone is switched off: the recording will be without sound.", severity: "idle" };
    if (hearing.trouble !== "") return { words: hearing.trouble, severity: "bad" };
    const loudness = loudnessWords(peak ?? 0);
    return { words: loudness.words, severity: loudness.good ? "good" : "warn" };
  }
}
