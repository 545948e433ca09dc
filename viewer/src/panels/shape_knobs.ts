/** Gain and limits of the shape that was chosen last: they change what sinks get, and what is shown. */
import type { Actions } from "../actions";
import { h, setHidden, setText } from "../dom";
import { fixed } from "../format";
import type { Session } from "../session";
import { shapeLabel, shapeName } from "../shapes";
import type { ViewState } from "../view_state";

const HIGHEST_GAIN = 3;
/** While a slider is dragged, no more than one command in this time, ms. */
export const SEND_MS = 120;

export class ShapeKnobs {
  readonly element = h("details", { class: "knobs" });
  private readonly title = h("span");
  private readonly gain = slider("Gain", 0, HIGHEST_GAIN, 0.05);
  private readonly low = slider("Least", 0, 1, 0.01);
  private readonly high = slider("Most", 0, 1, 0.01);
  private shape = -1;
  private timer = 0;

  constructor(
    private readonly session: Session,
    view: ViewState,
    private readonly actions: Actions,
  ) {
    const reset = h("button", { type: "button", class: "text-button", text: "As it was", onclick: () => this.reset() });
    this.element.append(
      h("summary", {}, "Gain and limits of ", this.title),
      h("div", { class: "knob-grid" }, this.gain.element, this.low.element, this.high.element),
      reset,
    );
    for (const knob of [this.gain, this.low, this.high]) {
      knob.input.addEventListener("input", () => {
        if (knob === this.low && this.low.value > this.high.value) this.high.set(this.low.value);
        if (knob === this.high && this.high.value < this.low.value) this.low.set(this.high.value);
        knob.set(knob.value);
        this.sendSoon();
      });
    }
    view.plotted.listen((plotted) => {
      this.shape = plotted[plotted.length - 1] ?? -1;
      setHidden(this.element, this.shape < 0);
      setText(this.title, shapeLabel(this.shape));
      this.read();
    });
    session.status.listen(() => {
      if (this.timer === 0 && !this.element.contains(document.activeElement)) this.read();
    });
  }

  private read(): void {
    const shaping = this.session.status.value?.shaping;
    const name = shapeName(this.shape);
    const limits = shaping?.limits.get(name) ?? [0, 1];
    this.gain.set(shaping?.gains.get(name) ?? 1);
    this.low.set(limits[0]);
    this.high.set(limits[1]);
  }

  private reset(): void {
    this.gain.set(1);
    this.low.set(0);
    this.high.set(1);
    this.sendSoon();
  }

  private sendSoon(): void {
    if (this.timer !== 0) return;
    this.timer = window.setTimeout(() => {
      this.timer = 0;
      const name = shapeName(this.shape);
      if (name === "") return;
      void this.actions.send({
        command: "shape",
        gains: { [name]: this.gain.value },
        limits: { [name]: [this.low.value, this.high.value] },
      });
    }, SEND_MS);
  }
}

export interface Slider {
  element: HTMLElement;
  input: HTMLInputElement;
  readonly value: number;
  set(value: number): void;
}

/** A labelled slider that shows its number. */
export function slider(label: string, least: number, most: number, step: number): Slider {
  const input = h("input", { type: "range", min: least, max: most, step });
  const number = h("output", { class: "slider-value" });
  const digits = step < 0.05 ? 2 : step < 1 ? 2 : 0;
  return {
    element: h("label", { class: "slider" }, h("span", { text: label }), input, number),
    input,
    get value() {
      return Number(input.value);
    },
    set(value: number) {
      input.value = String(value);
      input.style.setProperty("--share", String((value - least) / (most - least)));
      setText(number, fixed(value, digits));
    },
  };
}
