/** The guided calibration over the face: what to do now, a ring that runs down, and afterwards how well it went. */
import type { Actions } from "../actions";
import { seesAnEye } from "../camera_words";
import { h, setAttribute, setHidden, setText } from "../dom";
import type { Session } from "../session";
import type { Status } from "../protocol";
import { scoreItems } from "../panels/calibration";
import { findVoice, speak } from "../spoken";
import { LookField } from "./look_field";
import { CountdownRing } from "./ring";

const TITLES: Readonly<Record<string, string>> = { neutral: "Hold still", nod: "Nod", shake: "Shake your head", anchor: "Make this face", gaze: "Look there" };

export class CalibrationGuide {
  readonly element = h("section", { class: "guide", "aria-label": "Calibration", hidden: true });
  private readonly title = h("h2");
  private readonly prompt = h("p", { "aria-live": "assertive" });
  private readonly ring = new CountdownRing();
  private readonly look = new LookField();
  private readonly steps = h("ol", { class: "steps", "aria-hidden": "true" });
  private readonly running = h("div", { class: "guide-running" });
  private readonly done = h("div", { class: "guide-done", hidden: true });
  /** The calibration that this page has seen running: only its end is news. */
  private wasRunning = false;
  /** The versions that there were when it began: a cancelled one brings no other. */
  private before: ReadonlySet<string | number> = new Set();
  private step = "";
  /** Who wears a headset, or is to look elsewhere, cannot read. */
  private spoken = false;

  constructor(
    session: Session,
    private readonly actions: Actions,
  ) {
    this.running.append(
      h("div", { class: "guide-signs" }, this.ring.element, this.look.element),
      h("div", { class: "guide-words" }, this.title, this.prompt, this.steps),
      h("button", { type: "button", class: "button", text: "Cancel", onclick: () => void actions.cancelCalibration() }),
    );
    this.element.append(this.running, this.done);
    session.hello.listen((hello) => {
      this.spoken = seesAnEye(hello?.sensors ?? []);
      if (this.spoken) findVoice();
    });
    session.status.listen((status) => {
      if (status) this.update(status);
    });
  }

  get open(): boolean {
    return !this.element.hidden;
  }

  /** Escape: cancels what runs, closes what has ended. */
  close(): void {
    if (this.wasRunning) void this.actions.cancelCalibration();
    else setHidden(this.element, true);
  }

  /** Moves the ring between two messages of the session; called at the display's rate while it is open. */
  draw(nowMs: number): void {
    if (this.wasRunning) this.ring.draw(nowMs);
  }

  private update(status: Status): void {
    const { calibration } = status;
    if (calibration.state === "running") {
      if (!this.wasRunning) {
        this.wasRunning = true;
        this.before = new Set(calibration.versions.map((one) => one.id));
        setHidden(this.element, false);
        setHidden(this.running, false);
        setHidden(this.done, true);
      }
      const step = `${calibration.step} ${calibration.prompt}`;
      if (step !== this.step) {
        this.step = step;
        this.prompt.classList.remove("fresh");
        void this.prompt.offsetWidth;
        this.prompt.classList.add("fresh");
        if (this.spoken) speak(calibration.prompt);
      }
      setText(this.title, TITLES[calibration.step] ?? "Calibrating");
      setText(this.prompt, calibration.prompt);
      this.look.show(calibration.look);
      this.ring.set(calibration.progress, calibration.remainingS ?? 0);
      this.drawSteps(calibration.stepNumber, calibration.steps);
      return;
    }
    if (!this.wasRunning) return;
    this.wasRunning = false;
    this.step = "";
    const version = calibration.versions.find((one) => one.inForce);
    if (calibration.state === "failed" || !version || this.before.has(version.id)) {
      setHidden(this.element, calibration.state !== "failed");
      if (calibration.state === "failed") this.finish("It did not work", calibration.prompt || "Try again, more slowly.", []);
      return;
    }
    const failed = version.scores.filter((score) => !score.pass).length;
    this.finish(
      failed === 0 ? "Calibrated" : "Calibrated, with a doubt",
      failed === 0 ? "Everything looks right." : "It is in force. What is marked below can be made better by another try.",
      scoreItems(version.scores),
    );
  }

  private drawSteps(at: number, of: number): void {
    setHidden(this.steps, of < 2);
    if (this.steps.childElementCount !== of) this.steps.replaceChildren(...Array.from({ length: of }, () => h("li")));
    Array.from(this.steps.children).forEach((dot, i) => {
      setAttribute(dot, "data-step", i + 1 < at ? "done" : i + 1 === at ? "now" : "later");
    });
  }

  private finish(title: string, sentence: string, scores: HTMLElement[]): void {
    const close = h("button", { type: "button", class: "button primary", text: "Done", onclick: () => setHidden(this.element, true) });
    const again = h("button", { type: "button", class: "button", text: "Again", onclick: () => void this.actions.calibrate("short") });
    this.done.replaceChildren(
      h("h2", { text: title }),
      h("p", { text: sentence }),
      h("ul", { class: "scores" }, ...scores),
      h("div", { class: "button-row" }, close, again),
    );
    setHidden(this.running, true);
    setHidden(this.done, false);
    setHidden(this.element, false);
    if (document.activeElement === document.body) close.focus({ preventScroll: true });
  }
}
