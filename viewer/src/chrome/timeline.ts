/** The time line of a replay: play, pause, seek, leave. */
import type { Actions } from "../actions";
import { h, setHidden, setText } from "../dom";
import { clock } from "../format";
import { pauseIcon, playIcon } from "../icons";
import type { Session } from "../session";

/** While it is dragged, no more than one seek in this time, ms. */
const SEEK_MS = 100;
/** A seek needs this long, ms, until the session's time is the new one. */
const SETTLE_MS = 600;

export class Timeline {
  readonly element = h("section", { class: "timeline", "aria-label": "Replay", hidden: true });
  private readonly play = h("button", { type: "button", class: "icon-button" });
  private readonly line = h("input", { type: "range", min: 0, max: 1, step: 0.01, value: 0, "aria-label": "Time in the take" });
  private readonly now = h("span", { class: "mono" });
  private readonly whole = h("span", { class: "mono quiet" });
  private readonly name = h("span", { class: "take-name" });
  private timer = 0;
  private touchedAtMs = -Infinity;
  private paused: boolean | null = null;

  constructor(session: Session, actions: Actions) {
    this.play.addEventListener("click", () => void actions.togglePause());
    this.line.addEventListener("input", () => {
      this.touchedAtMs = performance.now();
      this.show(Number(this.line.value), Number(this.line.max));
      if (this.timer !== 0) return;
      this.timer = window.setTimeout(() => {
        this.timer = 0;
        void actions.seek(Number(this.line.value));
      }, SEEK_MS);
    });
    this.element.append(
      this.play,
      this.now,
      this.line,
      this.whole,
      this.name,
      h("button", { type: "button", class: "button small", text: "Leave replay", onclick: () => void actions.send({ command: "replay", stop: true }) }),
    );
    session.status.listen((status) => {
      const replay = status?.replay ?? null;
      setHidden(this.element, replay === null);
      if (!replay) return;
      if (replay.paused !== this.paused) {
        this.paused = replay.paused;
        this.play.replaceChildren(replay.paused ? playIcon() : pauseIcon());
        this.play.setAttribute("aria-label", replay.paused ? "Play" : "Pause");
      }
      setText(this.name, replay.take.replace(/\.mien$/, ""));
      this.line.max = String(Math.max(0.01, replay.duration));
      if (performance.now() - this.touchedAtMs > SETTLE_MS) {
        this.line.value = String(replay.time);
        this.show(replay.time, replay.duration);
      }
    });
  }

  private show(time: number, duration: number): void {
    setText(this.now, clock(time));
    setText(this.whole, clock(duration));
    this.line.style.setProperty("--share", String(duration > 0 ? time / duration : 0));
    this.line.setAttribute("aria-valuetext", `${clock(time)} of ${clock(duration)}`);
  }
}
