/** A ring that runs down, with the seconds that are left in it. */
import { h, setText, svg } from "../dom";

const RADIUS = 34;
const AROUND = 2 * Math.PI * RADIUS;

export class CountdownRing {
  private readonly run = svg("circle", { cx: 40, cy: 40, r: RADIUS, class: "ring-run", "stroke-dasharray": AROUND, "stroke-dashoffset": 0 });
  private readonly seconds = h("span", { class: "ring-seconds" });
  readonly element = h(
    "div",
    { class: "ring" },
    svg("svg", { viewBox: "0 0 80 80", "aria-hidden": "true" }, svg("circle", { cx: 40, cy: 40, r: RADIUS, class: "ring-back" }), this.run),
    this.seconds,
  );
  private progress = 0;
  private remaining = 0;
  private duration = 0;
  private heardAtMs = 0;

  /** What the session says: how far it is, 0 to 1, and what is left, s. `runs`: whether time goes on until it says more. */
  set(progress: number, remainingS: number, runs = true): void {
    this.progress = progress;
    this.remaining = remainingS;
    // What is left takes the time that is left: the ring needs the whole.
    this.duration = runs && progress < 1 ? remainingS / (1 - progress) : 0;
    this.heardAtMs = performance.now();
  }

  /** Moves it between two messages of the session; called at the display's rate. */
  draw(nowMs: number): void {
    const passed = this.duration > 0 ? (nowMs - this.heardAtMs) / 1000 : 0;
    const progress = this.duration > 0 ? Math.min(1, this.progress + passed / this.duration) : this.progress;
    this.run.setAttribute("stroke-dashoffset", (AROUND * progress).toFixed(1));
    setText(this.seconds, this.remaining > 0 ? String(Math.max(0, Math.ceil(this.remaining - passed))) : "");
  }
}
