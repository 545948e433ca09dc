/**
 * All weights as bars, grouped as they lie in the face: pairs as one sees the performer, their right on the left. Each bar
 * says by colour, pattern and letter how its value came about, and by the line below it how sure it is.
 */
import { h, setAttribute, setText } from "../dom";
import { countLetters, letterOf, PROVENANCES, provenanceOf, type Letter } from "../provenance";
import type { Frame, Shaping } from "../protocol";
import type { Session } from "../session";
import { REGIONS, SHAPE_COUNT, shapeLabel, shapeName, TONGUE, type ShapeRow } from "../shapes";
import type { ViewState } from "../view_state";
import { WeightPlot } from "./plot";
import { ShapeKnobs } from "./shape_knobs";
import type { Actions } from "../actions";

/** More lines than this cannot be told apart. */
export const MOST_PLOTTED = 5;
/** What screen readers are told is renewed this often, ms: sixty times a second helps nobody. */
const SPOKEN_MS = 1000;

interface Cell {
  shape: number;
  element: HTMLElement;
  /** One bar; a shape without sides has it twice, mirrored. */
  tracks: Track[];
  letter: HTMLElement;
  value: HTMLElement;
  shownLetter: Letter | "";
}

interface Track {
  element: HTMLElement;
  fill: HTMLElement;
  sure: HTMLElement;
  truth: HTMLElement;
  /** Where the shape rests on this wearer. */
  rest: HTMLElement;
}

export class WeightsPanel {
  readonly element = h("div", { class: "panel weights-panel" });
  private readonly cells: Cell[] = [];
  private readonly legend = new Map<Letter, HTMLElement>();
  private readonly plot: WeightPlot;
  private readonly knobs: ShapeKnobs;
  private spokenAt = 0;
  private drawn = false;

  constructor(
    private readonly session: Session,
    private readonly view: ViewState,
    actions: Actions,
  ) {
    this.plot = new WeightPlot(session, view);
    this.knobs = new ShapeKnobs(session, view, actions);
    this.element.append(this.plot.element, this.knobs.element, this.makeLegend(), this.makeBars());
    view.plotted.listen((plotted) => {
      for (const cell of this.cells) {
        const at = plotted.indexOf(cell.shape);
        setAttribute(cell.element, "aria-pressed", String(at >= 0));
        setAttribute(cell.element, "data-line", at >= 0 ? String(at) : null);
      }
    });
    session.status.listen((status) => {
      if (status) this.markShaping(status.shaping);
    });
  }

  /** Draws the newest frame; called at the display's rate while the panel can be seen. */
  draw(nowMs: number): void {
    this.plot.draw(nowMs);
    const frame = this.session.frame.value;
    if (!frame) return;
    const speak = nowMs - this.spokenAt > SPOKEN_MS || !this.drawn;
    if (speak) this.spokenAt = nowMs;
    this.drawn = true;
    for (const cell of this.cells) this.drawCell(cell, frame, speak);
    if (speak) {
      const counts = countLetters(frame.provenance);
      for (const [letter, element] of this.legend) setText(element, String(counts.get(letter) ?? 0));
    }
  }

  private drawCell(cell: Cell, frame: Frame, speak: boolean): void {
    const tongue = cell.shape === TONGUE;
    const weight = tongue ? frame.tongueOut : (frame.weights[cell.shape] ?? 0);
    const sure = tongue ? 0 : (frame.confidence[cell.shape] ?? 0);
    const letter: Letter = tongue ? (frame.tongueOut > 0 ? "p" : "n") : letterOf(frame.provenance, cell.shape);
    const rest = this.session.status.value?.shaping.rests.get(shapeName(cell.shape)) ?? 0;
    const truth = tongue ? undefined : frame.truth?.[cell.shape];
    for (const track of cell.tracks) {
      track.fill.style.transform = `scaleX(${weight.toFixed(3)})`;
      track.sure.style.transform = `scaleX(${sure.toFixed(2)})`;
      track.truth.style.display = truth === undefined ? "none" : "";
      if (truth !== undefined) track.truth.style.setProperty("--at", truth.toFixed(3));
    }
    const shown = String(Math.round(weight * 100));
    setText(cell.value, shown);
    if (cell.shownLetter !== letter) {
      cell.shownLetter = letter;
      cell.element.dataset["prov"] = letter;
      setText(cell.letter, letter);
    }
    if (speak) {
      const how = provenanceOf(letter).name;
      setAttribute(
        cell.element,
        "aria-label",
        `${shapeLabel(cell.shape)}: ${shown} percent, ${how}, confidence ${Math.round(sure * 100)} percent${restWords(rest)}`,
      );
    }
  }

  private makeLegend(): HTMLElement {
    const legend = h("ul", { class: "legend", "aria-label": "How the values came about" });
    for (const one of PROVENANCES) {
      const count = h("span", { class: "legend-count", text: "0" });
      this.legend.set(one.letter, count);
      legend.append(
        h(
          "li",
          { title: one.meaning, "data-prov": one.letter },
          h("span", { class: "swatch" }),
          h("span", { class: "letter", text: one.letter }),
          h("span", { text: one.name }),
          count,
        ),
      );
    }
    return legend;
  }

  private makeBars(): HTMLElement {
    const bars = h("div", { class: "bars" });
    for (const region of REGIONS) {
      const rows = h("div", { class: "region", role: "group", "aria-label": region.name });
      rows.append(h("h3", { text: region.name }));
      for (const row of region.rows) rows.append(this.makeRow(row));
      bars.append(rows);
    }
    const head = h(
      "div",
      { class: "bars-head quiet", "aria-hidden": "true" },
      h("span", { text: "their right" }),
      h("span", { text: "their left" }),
    );
    return h("div", {}, head, bars);
  }

  private makeRow(row: ShapeRow): HTMLElement {
    const label = h("span", { class: "row-label", text: row.label });
    if (row.left === row.right) return h("div", { class: "row" }, this.makeCell(row.left, "both", label));
    return h("div", { class: "row" }, this.makeCell(row.right, "right"), label, this.makeCell(row.left, "left"));
  }

  private makeCell(shape: number, side: "left" | "right" | "both", label: HTMLElement | null = null): HTMLElement {
    const tracks = side === "both" ? [makeTrack("right"), makeTrack("left")] : [makeTrack(side)];
    const letter = h("span", { class: "letter" });
    const value = h("span", { class: "value" });
    const plottable = shape < SHAPE_COUNT;
    const element = h(
      plottable ? "button" : "div",
      {
        class: `cell ${side}`,
        type: plottable ? "button" : null,
        title: shapeName(shape),
        "aria-label": shapeLabel(shape),
        onclick: plottable ? () => this.toggle(shape) : null,
      },
      letter,
      value,
      label,
      ...tracks.map((track) => track.element),
    );
    this.cells.push({ shape, element, tracks, letter, value, shownLetter: "" });
    return element;
  }

  private toggle(shape: number): void {
    const plotted = this.view.plotted.value;
    if (plotted.includes(shape)) this.view.plotted.set(plotted.filter((one) => one !== shape));
    else this.view.plotted.set([...plotted, shape].slice(-MOST_PLOTTED));
  }

  /** A small mark where a gain or a limit changes what sinks get, and one on the bar where a shape was found to rest. */
  private markShaping(shaping: Shaping): void {
    for (const cell of this.cells) {
      const name = shapeName(cell.shape);
      const shaped = (shaping.gains.get(name) ?? 1) !== 1 || isLimited(shaping.limits.get(name));
      cell.element.classList.toggle("shaped", shaped);
      const rest = shaping.rests.get(name) ?? 0;
      for (const track of cell.tracks) {
        track.rest.style.display = Math.round(rest * 100) > 0 ? "" : "none";
        track.rest.style.setProperty("--at", rest.toFixed(3));
      }
    }
  }
}

function makeTrack(side: "left" | "right"): Track {
  const fill = h("span", { class: "fill" });
  const sure = h("span", { class: "sure" });
  const truth = h("span", { class: "truth-mark" });
  const rest = h("span", { class: "rest-mark" });
  return { element: h("span", { class: `track ${side}` }, fill, rest, truth, sure), fill, sure, truth, rest };
}

/** For who does not see the mark. */
export function restWords(rest: number): string {
  const percent = Math.round(rest * 100);
  return percent > 0 ? `, rests at ${percent} percent` : "";
}

export function isLimited(limit: readonly [number, number] | undefined): boolean {
  return limit !== undefined && (limit[0] > 0 || limit[1] < 1);
}
