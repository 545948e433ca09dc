/** Where to look, as seen by who looks: a field with straight ahead in its middle, and a point in it. */
import type { Look } from "../calibration_protocol";
import { h, setAttribute, setHidden, setText, svg } from "../dom";

/** Of the field, either way from its middle. */
const WIDTH_DEG = 24;
const HEIGHT_DEG = 18;

/** The direction in words: "15° left". */
export function lookWords(look: Look): string {
  const parts = [
    look.upDeg !== 0 ? `${Math.round(Math.abs(look.upDeg))}° ${look.upDeg > 0 ? "up" : "down"}` : "",
    look.leftDeg !== 0 ? `${Math.round(Math.abs(look.leftDeg))}° ${look.leftDeg > 0 ? "left" : "right"}` : "",
  ].filter((part) => part !== "");
  return parts.length > 0 ? parts.join(", ") : "ahead";
}

export class LookField {
  private readonly way = svg("line", { x1: 0, y1: 0, x2: 0, y2: 0, class: "look-way" });
  private readonly point = svg("circle", { cx: 0, cy: 0, r: 2.4, class: "look-point" });
  private readonly words = h("span", { class: "look-words" });
  readonly element = h(
    "div",
    { class: "look", hidden: true },
    svg(
      "svg",
      { viewBox: `${-WIDTH_DEG} ${-HEIGHT_DEG} ${2 * WIDTH_DEG} ${2 * HEIGHT_DEG}`, "aria-hidden": "true" },
      svg("path", { d: "M-3 0H3M0 -3V3", class: "look-ahead" }),
      this.way,
      this.point,
    ),
    this.words,
  );

  /** Null: nowhere in particular. */
  show(look: Look | null): void {
    setHidden(this.element, look === null);
    if (!look) return;
    const x = String(-Math.max(-WIDTH_DEG, Math.min(WIDTH_DEG, look.leftDeg)));
    const y = String(-Math.max(-HEIGHT_DEG, Math.min(HEIGHT_DEG, look.upDeg)));
    setAttribute(this.point, "cx", x);
    setAttribute(this.point, "cy", y);
    setAttribute(this.way, "x2", x);
    setAttribute(this.way, "y2", y);
    setText(this.words, lookWords(look));
  }
}
