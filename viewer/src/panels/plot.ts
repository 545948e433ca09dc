/** The chosen shapes over the last seconds, with the truth as a dashed line where it is known, and below how each came about. */
import uPlot from "uplot";
import { h } from "../dom";
import type { Stretch } from "../history";
import { ink } from "../ink";
import type { Session } from "../session";
import { shapeLabel } from "../shapes";
import type { ViewState } from "../view_state";

const SECONDS = 12;
/** Redrawn this often, ms: a plot that scrolls faster is not easier to read. */
const REDRAW_MS = 66;
const HEIGHT = 132;
/** Height of one stripe of provenance, CSS pixels. */
const STRIPE = 3;

export class WeightPlot {
  readonly element = h("div", { class: "plot" });
  private readonly host = h("div", { class: "plot-host", role: "img", "aria-label": "The chosen shapes over the last seconds" });
  private readonly keys = h("ul", { class: "plot-keys" });
  private plot: uPlot | null = null;
  private stretches: Stretch[] = [];
  private shown: readonly number[] = [];
  private drawnAt = 0;
  private drawnTime = NaN;

  constructor(
    private readonly session: Session,
    private readonly view: ViewState,
  ) {
    this.element.append(this.host, this.keys);
    view.plotted.listen((plotted) => this.rebuild(plotted));
    view.colours.listen(() => this.rebuild(this.shown));
    new ResizeObserver(() => this.fit()).observe(this.host);
  }

  draw(nowMs: number): void {
    const latest = this.session.history.latest;
    if (!this.plot || nowMs - this.drawnAt < REDRAW_MS || latest === this.drawnTime) return;
    this.drawnAt = nowMs;
    this.drawnTime = latest;
    this.stretches = this.shown.map((shape) => this.session.history.stretch(shape, SECONDS));
    const times = this.stretches[0]?.times ?? [];
    const data: (number | null)[][] = [times];
    for (const stretch of this.stretches) data.push(stretch.weights, stretch.truths);
    this.plot.setData(data as unknown as uPlot.AlignedData, false);
    this.plot.setScale("x", { min: -SECONDS, max: 0 });
  }

  private rebuild(plotted: readonly number[]): void {
    this.shown = plotted;
    this.drawnTime = NaN;
    this.plot?.destroy();
    this.plot = null;
    this.keys.replaceChildren(
      ...plotted.map((shape, i) =>
        h(
          "li",
          {},
          h(
            "button",
            {
              type: "button",
              class: "plot-key",
              "data-line": i,
              title: "Take it out of the plot",
              onclick: () => this.view.plotted.set(this.view.plotted.value.filter((one) => one !== shape)),
            },
            h("span", { class: "line-swatch" }),
            shapeLabel(shape),
          ),
        ),
      ),
    );
    if (plotted.length === 0) {
      this.host.replaceChildren(h("p", { class: "quiet plot-empty", text: "Press a bar to see it over time." }));
      return;
    }
    this.host.replaceChildren();
    const series: uPlot.Series[] = [{}];
    plotted.forEach((_, i) => {
      const stroke = ink(`--line-${i}`);
      series.push({ stroke, width: 1.75, points: { show: false }, spanGaps: false });
      series.push({ stroke, width: 1.25, dash: [4, 4], alpha: 0.75, points: { show: false }, spanGaps: false });
    });
    const axis = { stroke: ink("--quiet"), font: "11px system-ui", ticks: { show: false } };
    this.plot = new uPlot(
      {
        width: Math.max(120, this.host.clientWidth),
        height: HEIGHT,
        legend: { show: false },
        cursor: { show: false },
        padding: [6, 14, 0, 0],
        scales: { x: { time: false, range: () => [-SECONDS, 0] }, y: { range: () => [-0.03 - 0.035 * plotted.length, 1] } },
        axes: [
          {
            ...axis, size: 20, gap: 2, grid: { show: false },
            splits: () => [-10, -5, 0],
            values: (_, splits) => splits.map((value) => (value === 0 ? "now" : `${value} s`)),
          },
          { ...axis, size: 26, gap: 3, grid: { stroke: ink("--hairline"), width: 1 }, splits: () => [0, 0.5, 1], values: () => ["0", "50", "100"] },
        ],
        series,
        hooks: { draw: [(plot) => this.stripes(plot)] },
      },
      [[], ...plotted.flatMap(() => [[], []])] as unknown as uPlot.AlignedData,
      this.host,
    );
  }

  /** One thin line a shape along the foot of the plot, coloured by provenance. */
  private stripes(plot: uPlot): void {
    const ratio = devicePixelRatio || 1;
    const { left, top, width, height } = plot.bbox;
    plot.ctx.save();
    this.stretches.forEach((stretch, i) => {
      const y = top + height - ratio * (STRIPE + 1) * (this.stretches.length - i);
      let begin = 0;
      for (let k = 1; k <= stretch.letters.length; ++k) {
        if (k < stretch.letters.length && stretch.letters[k] === stretch.letters[begin]) continue;
        const from = left + ((stretch.times[begin] ?? 0) / SECONDS + 1) * width;
        const until = left + ((stretch.times[Math.min(k, stretch.times.length - 1)] ?? 0) / SECONDS + 1) * width;
        plot.ctx.fillStyle = ink(`--prov-${stretch.letters[begin] === "?" ? "n" : stretch.letters[begin]}`);
        plot.ctx.fillRect(from, y, Math.max(1, until - from), STRIPE * ratio);
        begin = k;
      }
    });
    plot.ctx.restore();
  }

  private fit(): void {
    const width = this.host.clientWidth;
    if (this.plot && width > 0 && Math.abs(this.plot.width - width) > 1) this.plot.setSize({ width, height: HEIGHT });
  }
}
