/** Where the face goes, how it is shaped on its way, how fast it is, and what the session has said. */
import type { Actions } from "../actions";
import { h, KeyedList, setHidden, setText } from "../dom";
import { fixed } from "../format";
import { ink } from "../ink";
import type { BrowserMicrophone } from "../microphone";
import type { SinkStatus, Status } from "../protocol";
import type { Session } from "../session";
import { shapeIndex, shapeLabel } from "../shapes";
import type { ViewState } from "../view_state";
import { SEND_MS, slider } from "./shape_knobs";
import { VoiceBlock } from "./voice";
import { isLimited } from "./weights";

const SINK_KINDS: readonly (readonly [string, string])[] = [
  ["livelink://127.0.0.1:11111", "Unreal, Live Link Face"],
  ["vmc://127.0.0.1:39539", "VMC: VSeeFace, Warudo, VNyan"],
  ["vrchat://127.0.0.1:9000", "VRChat"],
  ["ifacialmocap://127.0.0.1:49983", "iFacialMocap receivers"],
  ["ws://127.0.0.1:8741", "Other web pages"],
  ["csv:face.csv", "A file, Live Link Face CSV"],
];

/** Sliders of shaping: key of the command, label, most, step. */
const SLIDERS = [
  ["smoothing", "Smoothing", 1, 0.01],
  ["blinks_per_min", "Blinks a minute", 60, 1],
] as const;

/** Steps of shaping that are switched here: key of the command, label, what it does. */
const SWITCHES = [
  ["resting", "Learn the face at rest", "What it mostly is, of the last 30 s, becomes neutral."],
  ["constraints", "Obey the constraints", "What a face cannot do at once is not shown."],
  ["lids_follow_eyes", "Lids follow the eyes", "Where a tracker gave eye directions and saw no lids."],
] as const;

export class OutputPanel {
  readonly element = h("div", { class: "panel output-panel" });
  private readonly sliders = SLIDERS.map(([key, label, most, step]) => ({ key, slider: slider(label, 0, most, step), timer: 0 }));
  private readonly switches = SWITCHES.map(([key, label]) => ({
    key,
    element: h("button", {
      type: "button", class: "switch", role: "switch", "aria-label": label,
      onclick: () => void this.actions.send({ command: "shape", [key]: !this.session.status.value?.shaping[key] }),
    }),
  }));
  private readonly shaped = h("ul", { class: "shaped-list" });
  private readonly shapedEmpty = h("p", { class: "quiet", text: "No gains or limits. Press a bar in Weights, then open its gain." });
  private readonly about = h("dl", { class: "facts" });
  private readonly latency = h("canvas", { class: "latency-plot", role: "img", "aria-label": "Latency over the last two minutes" });
  private readonly latencyText = h("p", { class: "summary" });

  constructor(
    private readonly session: Session,
    view: ViewState,
    private readonly actions: Actions,
    microphone: BrowserMicrophone,
  ) {
    const sinkList = h("ul", { class: "sinks" });
    const sinks = new KeyedList<SinkStatus, SinkRow>(sinkList, (sink) => String(sink.id), (sink) => new SinkRow(sink, actions));
    const log = h("ol", { class: "log" });
    this.element.append(
      h("h3", { text: "Receivers" }),
      sinkList,
      this.makeAdd(),
      h("h3", { text: "Shaping" }),
      ...this.sliders.map(({ slider }) => slider.element),
      h("p", { class: "quiet", text: "Only lids that no sensor observes are made to blink." }),
      ...SWITCHES.map(([, label, words], at) =>
        h("div", { class: "switch-row" }, this.switches[at]!.element, h("span", {}, `${label} `, h("span", { class: "quiet", text: words }))),
      ),
      this.shaped,
      this.shapedEmpty,
      new VoiceBlock(session, actions, microphone).element,
      h("h3", { text: "Latency" }),
      this.latencyText,
      this.latency,
      h("h3", { text: "Session" }),
      this.about,
      h("h3", { text: "What happened" }),
      log,
    );
    for (const one of this.sliders)
      one.slider.input.addEventListener("input", () => {
        one.slider.set(one.slider.value);
        if (one.timer !== 0) return;
        one.timer = window.setTimeout(() => {
          one.timer = 0;
          void this.actions.send({ command: "shape", [one.key]: one.slider.value });
        }, SEND_MS);
      });
    session.status.listen((status) => {
      if (!status) return;
      sinks.update(status.sinks);
      for (const { key, slider, timer } of this.sliders)
        if (timer === 0 && document.activeElement !== slider.input) slider.set(status.shaping[key]);
      for (const { key, element } of this.switches) element.setAttribute("aria-checked", String(status.shaping[key]));
      this.drawShaped(status);
      this.drawAbout(status);
      this.drawLatency();
    });
    session.events.listen((events) => {
      log.replaceChildren(
        ...(events.length === 0 ? [h("li", { class: "quiet", text: "Nothing yet." })] : []),
        ...[...events].reverse().map((event) =>
          h("li", {}, h("time", { class: "quiet", text: timeOfDay(event.atMs) }), ` ${event.text}`),
        ),
      );
    });
    view.colours.listen(() => this.drawLatency());
  }

  private makeAdd(): HTMLElement {
    const address = h("input", {
      type: "text", class: "field", list: "sink-kinds", placeholder: "Add: livelink://HOST:PORT", "aria-label": "Address of a new receiver", spellcheck: "false", autocomplete: "off",
    });
    return h(
      "form",
      {
        class: "button-row",
        onsubmit: (event: Event) => {
          event.preventDefault();
          const add = address.value.trim();
          if (add === "") {
            address.focus();
            return;
          }
          void this.actions.send({ command: "sink", add }).then((reply) => {
            if (reply.ok) address.value = "";
          });
        },
      },
      address,
      h("button", { type: "submit", class: "button", text: "Add" }),
      h("datalist", { id: "sink-kinds" }, ...SINK_KINDS.map(([value, label]) => h("option", { value, label }))),
    );
  }

  private drawShaped(status: Status): void {
    const { gains, limits } = status.shaping;
    const names = [...new Set([...gains.keys(), ...limits.keys()])].filter((name) => (gains.get(name) ?? 1) !== 1 || isLimited(limits.get(name)));
    setHidden(this.shapedEmpty, names.length > 0);
    const key = names.map((name) => `${name} ${gains.get(name)} ${limits.get(name)}`).join("\n");
    if (this.shaped.dataset["key"] === key) return;
    this.shaped.dataset["key"] = key;
    this.shaped.replaceChildren(
      ...names.map((name) => {
        const limit = limits.get(name) ?? [0, 1];
        const parts = [(gains.get(name) ?? 1) !== 1 ? `× ${fixed(gains.get(name) ?? 1, 2)}` : "", isLimited(limit) ? `${fixed(limit[0], 2)} to ${fixed(limit[1], 2)}` : ""];
        return h(
          "li",
          {},
          h("span", { text: shapeIndex(name) < 0 ? name : shapeLabel(shapeIndex(name)) }),
          h("span", { class: "quiet", text: parts.filter((part) => part !== "").join(", ") }),
          h("button", {
            type: "button", class: "text-button", text: "Undo", "aria-label": `Undo the shaping of ${name}`,
            onclick: () => void this.actions.send({ command: "shape", gains: { [name]: 1 }, limits: { [name]: [0, 1] } }),
          }),
        );
      }),
    );
  }

  private drawAbout(status: Status): void {
    const hello = this.session.hello.value;
    const facts: [string, string][] = [
      ["Program", hello?.software || "–"],
      ["Model", hello?.model || "–"],
      ["Rig", hello?.rigName || "–"],
      ["Listens on", hello?.listening.join(", ") || "–"],
      ["Frames", `${status.frames}, ${status.missed} missed`],
      ["Unreadable messages", String(this.session.malformed)],
    ];
    if (this.about.childElementCount !== facts.length) {
      this.about.replaceChildren(...facts.map(([name]) => h("div", {}, h("dt", { text: name }), h("dd"))));
    }
    facts.forEach(([, value], i) => {
      const place = this.about.children[i]?.lastElementChild;
      if (place) setText(place, value);
    });
  }

  /** p99 as a line over p50 as an area, scaled to the worst of the last two minutes. */
  private drawLatency(): void {
    const status = this.session.status.value;
    setText(
      this.latencyText,
      status?.latency ? `Half of all frames leave within ${fixed(status.latency.p50, 1)} ms of their last sample, 99 % within ${fixed(status.latency.p99, 1)} ms; the slowest took ${fixed(status.latency.max, 1)} ms.${status.holdMs > 0 ? ` Besides, holding frames ${fixed(status.holdMs, 0)} ms: packets arrive late.` : ""}` : status && status.frames > 0 ? "No frames in the last ten seconds." : "No frames yet.",
    );
    const canvas = this.latency;
    if (canvas.clientWidth === 0) return;
    const ratio = devicePixelRatio || 1;
    const width = Math.round(canvas.clientWidth * ratio);
    const height = Math.round(48 * ratio);
    if (canvas.width !== width) canvas.width = width;
    if (canvas.height !== height) canvas.height = height;
    const context = canvas.getContext("2d");
    if (!context) return;
    context.clearRect(0, 0, width, height);
    const points = this.session.latencies.value;
    const top = Math.max(10, ...points.map((point) => point.p99)) * 1.15;
    const trace = (pick: (point: { p50: number; p99: number }) => number) => {
      context.beginPath();
      points.forEach((point, i) => {
        const x = width - ((points.length - 1 - i) * width) / 480;
        const y = height - (pick(point) / top) * height;
        if (i === 0) context.moveTo(x, y);
        else context.lineTo(x, y);
      });
    };
    context.lineWidth = 1.5 * ratio;
    for (const [pick, colour] of [[(point: { p50: number }) => point.p50, "--quiet"], [(point: { p99: number }) => point.p99, "--ink"]] as const) {
      context.strokeStyle = ink(colour);
      trace(pick);
      context.stroke();
    }
    const last = points[points.length - 1];
    if (!last) return;
    context.font = `${11 * ratio}px system-ui`;
    context.fillStyle = ink("--quiet");
    context.textBaseline = "bottom";
    context.fillText("p99", 0, height - (last.p99 / top) * height - 3 * ratio);
    context.fillText("p50", 0, height - (last.p50 / top) * height - 3 * ratio);
  }
}

class SinkRow {
  readonly element = h("li", { class: "sink" });
  private readonly about = h("span", { class: "quiet" });
  private readonly toggle: HTMLButtonElement;
  private on = false;

  constructor(sink: SinkStatus, actions: Actions) {
    this.toggle = h("button", {
      type: "button", class: "switch", role: "switch", "aria-label": `Send to ${sink.address}`,
      onclick: () => void actions.send({ command: "sink", sink: sink.id, on: !this.on }),
    });
    this.element.append(
      this.toggle,
      h("div", {}, h("strong", { class: "mono", text: sink.address }), this.about),
      h("button", {
        type: "button", class: "text-button", text: "Remove", "aria-label": `Remove ${sink.address}`,
        onclick: () => void actions.send({ command: "sink", sink: sink.id, remove: true }),
      }),
    );
  }

  update(sink: SinkStatus): void {
    this.on = sink.on;
    this.toggle.setAttribute("aria-checked", String(sink.on));
    const parts = [
      sink.on ? `${fixed(sink.rateHz, 0)} a second` : "off",
      sink.failed > 0 ? `${sink.failed} failed` : "",
      sink.receivers !== null ? `${sink.receivers} listening` : "",
      sink.note,
    ];
    setText(this.about, parts.filter((part) => part !== "").join(" · "));
    this.element.classList.toggle("failing", sink.on && sink.failed > 0);
  }
}

function timeOfDay(atMs: number): string {
  return new Date(performance.timeOrigin + atMs).toLocaleTimeString(undefined, { hour: "2-digit", minute: "2-digit", second: "2-digit" });
}
