/** What is heard: the switch, the level, and this browser's microphone where the session hears one. */
import type { Actions } from "../actions";
import { h, setAttribute, setHidden, setText } from "../dom";
import { fixed } from "../format";
import type { Hearing } from "../hearing_protocol";
import type { BrowserMicrophone, MicrophoneState } from "../microphone";
import type { Hello, Status } from "../protocol";
import type { Session } from "../session";

/** A rig's sensors of this kind are microphones. */
export const MICROPHONE = "speech";

/** The name of the first microphone; null where the rig has none. */
export function microphoneOf(hello: Hello | null): string | null {
  return hello?.sensors.find(({ kind }) => kind === MICROPHONE)?.name ?? null;
}

/** Its loudness, 0 to 1; null while nothing is heard. */
export function microphoneLevel(hello: Hello | null, status: Status): number | null {
  const microphone = microphoneOf(hello);
  return status.hearing?.on ? (status.links.find((link) => link.sensor === microphone)?.level ?? null) : null;
}

/** How hearing stands, in a sentence or two. */
export function hearingWords(hearing: Hearing): string {
  if (hearing.shut) return "The session was started with every microphone shut (--no-audio); nothing switches one on.";
  if (!hearing.on) return "Sound is off; no shape is from it, and a microphone is closed.";
  const late = Math.abs(hearing.laterMs) >= 1 ? ` Sound ${hearing.laterMs > 0 ? "lags behind" : "comes before"} the face by ${fixed(Math.abs(hearing.laterMs), 0)} ms.` : "";
  return `${hearing.speaks ? "Somebody speaks." : "Nobody speaks."} ${fixed(100 * hearing.share, 0)} % of all frames have shapes from it.${late}`;
}

/** How this browser's microphone stands beside the session, in a sentence; "": there is nothing to say. */
export function microphoneWords(microphone: MicrophoneState, hearing: Hearing): string {
  if (!hearing.browser) return "";
  const refused = hearing.browser.refused > 0 ? ` ${hearing.browser.refused} pieces were refused.` : "";
  switch (microphone.kind) {
    case "asking":
      return "Allow it where the browser asks.";
    case "on":
      return `This browser is heard; ${fixed(hearing.blocks / 50, 0)} s of sound were heard so far.${refused}`;
    case "refused":
      return microphone.why;
    case "off":
      if (!hearing.on) return "";
      return hearing.browser.heard ? "Another browser is heard; this one would take its place." : "No browser is heard yet.";
  }
}

export class VoiceBlock {
  readonly element: HTMLElement;
  private readonly hear: HTMLButtonElement;
  private readonly words = h("span", { class: "quiet" });
  private readonly run = h("div", { class: "level-run" });
  private readonly level = h("div", { class: "level", role: "meter", "aria-label": "Level", "aria-valuemin": 0, "aria-valuemax": 100 }, this.run);
  private readonly trouble = h("p", { class: "voice-trouble", role: "status" });
  private readonly use: HTMLButtonElement;
  private readonly used = h("span", { class: "quiet", role: "status" });
  private readonly row: HTMLElement;

  constructor(
    private readonly session: Session,
    actions: Actions,
    private readonly microphone: BrowserMicrophone,
  ) {
    this.hear = h("button", {
      type: "button", class: "switch", role: "switch", "aria-label": "Hear the voice",
      onclick: () => void actions.send({ command: "shape", merge: { audio: !session.status.value?.hearing?.on } }),
    });
    this.use = h("button", { type: "button", class: "button small", onclick: () => this.microphone.toggle() });
    this.row = h("div", { class: "voice-browser" }, this.use, this.used);
    this.element = h(
      "section", { class: "voice", hidden: true },
      h("h3", { text: "Voice" }),
      h("div", { class: "switch-row" }, this.hear, h("span", {}, "Hear the voice ", this.words)),
      this.level,
      this.trouble,
      this.row,
    );
    session.status.listen((status) => this.draw(status));
    this.microphone.state.listen(() => this.draw(session.status.value));
  }

  private draw(status: Status | null): void {
    const hearing = status?.hearing ?? null;
    setHidden(this.element, hearing === null);
    if (!status || !hearing) return;
    const microphone = this.microphone.state.value;
    setHidden(this.hear, hearing.shut);
    this.hear.setAttribute("aria-checked", String(hearing.on));
    setText(this.words, hearingWords(hearing));
    const level = microphoneLevel(this.session.hello.value, status);
    setHidden(this.level, level === null);
    this.run.style.transform = `scaleX(${level ?? 0})`;
    setAttribute(this.level, "aria-valuenow", String(Math.round(100 * (level ?? 0))));
    setHidden(this.trouble, !hearing.on || hearing.trouble === "");
    setText(this.trouble, hearing.trouble);
    setHidden(this.row, hearing.browser === null);
    const running = microphone.kind === "on" || microphone.kind === "asking";
    setText(this.use, running ? "Stop" : "Use this browser's microphone");
    this.use.disabled = !hearing.on && !running;
    setText(this.used, microphoneWords(microphone, hearing));
    this.used.classList.toggle("bad", microphone.kind === "refused");
  }
}
