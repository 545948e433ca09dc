/** The line above the face: what this is, whether it is live, how fast, and how honest the face is right now. */
import { h, setAttribute, setHidden, setText } from "../dom";
import { fixed } from "../format";
import { standingOf } from "../provenance";
import { autoIcon, helpIcon, moonIcon, sunIcon } from "../icons";
import { sessionWord } from "./session_word";
import { type ShownStanding, standingSentence } from "./standing_words";
import type { Session } from "../session";
import type { ThemeChoice, ViewState } from "../view_state";

const NEXT_THEME: Readonly<Record<ThemeChoice, ThemeChoice>> = { system: "light", light: "dark", dark: "system" };
const THEME_NAMES: Readonly<Record<ThemeChoice, string>> = { system: "as the system has it", light: "light", dark: "dark" };

export class Topbar {
  readonly element = h("header", { class: "topbar" });
  /** Over the face, so that nobody takes a kept or resting face for a live one. */
  readonly badge = h("div", { class: "standing", role: "status", hidden: true });

  private readonly state = h("span", { class: "chip", "data-tone": "idle" });
  private readonly latency = h("span", { class: "latency", title: "From the arrival of a frame's last sample to the packet sent, over ten seconds" });
  private readonly p50 = h("b", { text: "–" });
  private readonly p99 = h("b", { text: "–" });
  private readonly held = h("b", { class: "gap", hidden: true, title: "Packets arrive late, so every frame waits for them by so much: it adds to the latency" });
  private standing = "";
  private standingSince = 0;

  constructor(
    private readonly session: Session,
    view: ViewState,
  ) {
    const theme = h("button", { type: "button", class: "icon-button", onclick: () => view.theme.set(NEXT_THEME[view.theme.value]) });
    view.theme.listen((choice) => {
      theme.replaceChildren(choice === "system" ? autoIcon() : choice === "light" ? sunIcon() : moonIcon());
      theme.setAttribute("aria-label", `Colours: ${THEME_NAMES[choice]}`);
      theme.title = `Colours: ${THEME_NAMES[choice]}`;
    });
    this.latency.append(
      h("span", { class: "quiet", text: "p50 " }), this.p50, h("span", { class: "quiet", text: " ms" }),
      h("span", { class: "quiet gap", text: "p99 " }), this.p99, h("span", { class: "quiet", text: " ms" }),
      this.held,
    );
    this.element.append(
      h("span", { class: "wordmark", text: "mien" }),
      this.state,
      h("span", { class: "spring" }),
      this.latency,
      theme,
      h("button", { type: "button", class: "icon-button", "aria-label": "Keys and help", title: "Keys and help (?)", onclick: () => view.helpOpen.set(true) }, helpIcon()),
    );
    session.connection.listen(() => this.update());
    session.status.listen(() => this.update());
    session.frame.listen(() => this.judge());
  }

  private update(): void {
    const status = this.session.status.value;
    const { text, tone } = sessionWord(this.session.connection.value, status);
    setText(this.state, text);
    setAttribute(this.state, "data-tone", tone);
    const latency = this.session.connected ? status?.latency : null;
    setText(this.p50, fixed(latency?.p50 ?? null, 1));
    setText(this.p99, fixed(latency?.p99 ?? null, 1));
    const holdMs = this.session.connected ? (status?.holdMs ?? 0) : 0;
    setText(this.held, `+ ${fixed(holdMs, 0)} ms held`);
    setHidden(this.held, holdMs === 0);
    this.judge();
  }

  /** A standing is shown once it has lasted a moment: a single late frame is no news. */
  private judge(): void {
    const connection = this.session.connection.value;
    const frame = this.session.frame.value;
    let standing: ShownStanding = frame ? standingOf(frame.provenance) : "neutral";
    if (connection.kind !== "open") standing = "away";
    const now = performance.now();
    if (standing !== this.standing) {
      this.standing = standing;
      this.standingSince = now;
    }
    if (standing !== "live" && standing !== "away" && now - this.standingSince < 300) return;
    const app = document.documentElement;
    if (app.dataset["standing"] !== standing) app.dataset["standing"] = standing;
    setText(this.badge, standingSentence(standing, connection, this.session.status.value));
    setHidden(this.badge, standing === "live");
  }
}
