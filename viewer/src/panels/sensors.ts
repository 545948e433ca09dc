/** Every sensor with the numbers of its link; what to do about a bad one; and devices that nobody has bound yet. */
import type { Actions } from "../actions";
import { h, KeyedList, setAttribute, setHidden, setText } from "../dom";
import { fixed, milliseconds, sensorLabel } from "../format";
import { healthOf } from "../health";
import type { Link, Rival, UnboundDevice } from "../protocol";
import type { Session } from "../session";
import type { ViewState } from "../view_state";
import { CameraView } from "./camera_view";
import { HeadsetSection } from "./headset";
import { isHeard, linkFigures, linkSummary } from "./link_words";
import { NetworkSection } from "./network";

/** Name, the unit of what has none in its cells, and what it means. */
const COLUMNS: readonly (readonly [string, string, string])[] = [
  ["Sensor", "", ""],
  ["Level", "", "How much comes back of what it sends out"],
  ["Rate", "Hz", "Samples a second"],
  ["Age", "", "Since its last sample"],
  ["Loss", "", "Share of packets lost over the last seconds"],
  ["Offset", "", "Its clock against ours"],
  ["Drift", "ppm", "How fast its clock goes wrong, parts in a million"],
  ["Battery", "", ""],
];

export class SensorsPanel {
  readonly element = h("div", { class: "panel sensors-panel" });
  private readonly summary = h("p", { class: "summary" });
  private readonly body = h("tbody");
  private readonly table = h("table", { class: "links" });
  private readonly detail: Detail;
  private readonly network: NetworkSection;
  private readonly unboundSection = h("section", { class: "unbound" });
  private readonly rows: KeyedList<Link, SensorRow>;
  private readonly unbound: KeyedList<UnboundDevice, UnboundRow>;

  constructor(
    private readonly session: Session,
    private readonly view: ViewState,
    actions: Actions,
  ) {
    this.detail = new Detail(session, view, actions);
    this.network = new NetworkSection(actions);
    const head = h(
      "thead",
      {},
      h(
        "tr",
        {},
        ...COLUMNS.map(([name, unit, meaning]) =>
          h(
            "th",
            { scope: "col", class: `${name}-column`.toLowerCase(), title: meaning || null },
            name,
            unit !== "" && h("span", { class: "unit", text: unit }),
          ),
        ),
      ),
    );
    const list = h("ul", { class: "unbound-list" });
    this.unboundSection.append(
      h("h3", { text: "Heard, but bound to no site" }),
      list,
    );
    this.table.append(h("caption", { class: "hidden-visually", text: "Sensors and their links" }), head, this.body);
    this.element.append(
      this.summary,
      new HeadsetSection(session, view, actions).element,
      this.detail.element,
      h("div", { class: "table-scroll" }, this.table),
      this.unboundSection,
      this.network.element,
    );
    this.rows = new KeyedList(this.body, (link) => link.sensor, (link) => new SensorRow(link.sensor, view));
    this.unbound = new KeyedList(list, (one) => one.device, (one) => new UnboundRow(one, session, actions));
    session.status.listen(() => this.update());
    view.sensor.listen((sensor) => {
      this.update();
      if (sensor !== null) this.detail.element.scrollIntoView({ block: "nearest" });
    });
  }

  private update(): void {
    const status = this.session.status.value;
    if (!status) {
      setText(this.summary, "No news from the session yet.");
      return;
    }
    setText(this.summary, linkSummary(status.links));
    this.rows.update(status.links);
    // No column for what no sensor of this rig has.
    this.table.classList.toggle("without-level", status.links.every((link) => link.level === null));
    this.table.classList.toggle("without-battery", status.links.some((link) => link.level !== null) && status.links.every((link) => link.battery === null));
    for (const row of this.body.children) {
      setAttribute(row, "aria-selected", String(row instanceof HTMLElement && row.dataset["sensor"] === this.view.sensor.value));
    }
    setHidden(this.unboundSection, status.unbound.length === 0);
    this.unbound.update(status.unbound);
    this.network.update(status.network, this.session.hello.value?.listening ?? []);
    this.detail.update();
  }
}

class SensorRow {
  readonly element: HTMLTableRowElement;
  private readonly state = h("span", { class: "row-state" });
  private readonly cells = Array.from({ length: 6 }, (_, i) => h("td", { class: i === 5 ? "battery-column" : null }));
  private readonly bar = h("div", { class: "level-run" });
  private readonly level = h("td", { class: "level-column" }, h("div", { class: "level" }, this.bar));
  private readonly pip = h("span", { class: "pip" });

  constructor(sensor: string, view: ViewState) {
    const name = h(
      "button",
      {
        type: "button",
        class: "row-name",
        onclick: () => view.sensor.set(view.sensor.value === sensor ? null : sensor),
      },
      this.pip,
      h("span", {}, h("span", { text: sensorLabel(sensor) }), this.state),
    );
    this.element = h("tr", { "data-sensor": sensor }, h("th", { scope: "row" }, name), this.level, ...this.cells);
  }

  update(link: Link): void {
    const health = healthOf(link.state);
    this.element.dataset["severity"] = health.severity;
    setText(this.pip, health.mark);
    setText(this.state, link.estimated ? `${health.label}, time estimated` : health.label);
    linkFigures(link).forEach((text, i) => {
      const cell = this.cells[i];
      if (cell) setText(cell, text);
    });
    this.bar.style.transform = `scaleX(${link.level ?? 0})`;
    setAttribute(this.level, "aria-label", link.level === null ? null : `${Math.round(100 * link.level)} %`);
    const battery = this.cells[5];
    if (!battery) return;
    const old = link.battery !== null && !isHeard(link);
    battery.classList.toggle("low", link.battery !== null && link.battery < 15);
    battery.classList.toggle("quiet", old);
    setAttribute(battery, "title", old ? "As it last said" : null);
  }
}

/** The chosen sensor: what is wrong, what can be done, and the numbers that the table has no room for. */
class Detail {
  readonly element = h("section", { class: "detail", hidden: true, "aria-live": "polite" });
  private readonly title = h("h3");
  private readonly sentence = h("p");
  private readonly facts = h("dl", { class: "facts" });
  private readonly tap = h("button", { type: "button", class: "button" });
  private readonly device = h("select", { "aria-label": "Device at this site" });
  private readonly senders: Senders;
  private readonly cameraView: CameraView;

  constructor(
    private readonly session: Session,
    private readonly view: ViewState,
    private readonly actions: Actions,
  ) {
    this.senders = new Senders(actions);
    this.cameraView = new CameraView(actions);
    this.tap.addEventListener("click", () => {
      const sensor = view.sensor.value;
      if (!sensor) return;
      // What looks from afar cannot be tapped.
      const link = session.status.value?.links.find((one) => one.sensor === sensor);
      void (link?.view ? actions.cover(sensor) : actions.tap(sensor));
    });
    this.device.addEventListener("change", () => {
      const sensor = view.sensor.value;
      if (sensor && this.device.value) void this.actions.bind(sensor, this.device.value);
    });
    this.element.append(
      h("div", { class: "detail-head" }, this.title, h("button", { type: "button", class: "text-button", text: "Close", onclick: () => view.sensor.set(null) })),
      this.sentence,
      this.senders.element,
      h("div", { class: "button-row" }, this.tap, this.device),
      this.cameraView.element,
      this.facts,
    );
  }

  update(): void {
    const status = this.session.status.value;
    const link = status?.links.find((one) => one.sensor === this.view.sensor.value);
    setHidden(this.element, !link);
    if (!link || !status) return;
    const health = healthOf(link.state);
    this.element.dataset["severity"] = health.severity;
    setText(this.title, sensorLabel(link.sensor));
    const camera = link.view !== null;
    const waiting = camera ? status.cover.sensor === link.sensor : status.tap === link.sensor;
    const asked = camera ? "Waiting: hold a finger on the lens of the camera that looks from here, for a second." : "Waiting: tap the real sensor that sits here, two or three times.";
    const trouble = camera && status.cover.trouble ? ` No camera was bound: ${status.cover.trouble}.` : "";
    setText(this.sentence, waiting ? asked : `${capital(health.label)}. ${health.sentence}${trouble}`);
    setText(this.tap, waiting ? "Stop waiting" : camera ? "Cover it to bind it" : "Tap it to bind it");
    this.senders.update(link);
    this.cameraView.update(link);
    this.fillDevices(link, status.unbound);
    const facts: [string, string][] = [
      ["Device", link.device || "none"],
      ["Heard from", link.source || "–"],
      ["Clock known to", link.uncertaintyMs === null ? "–" : `±${milliseconds(link.uncertaintyMs)}`],
      ...headingFact(link, camera),
      ["Lost", String(link.lost)],
      ["Late", String(link.late)],
      ["Doubled", String(link.doubled)],
      ["Reordered", String(link.reordered)],
      ["Malformed", String(link.malformed)],
    ];
    if (this.facts.childElementCount !== facts.length) {
      this.facts.replaceChildren(...facts.map(([name]) => h("div", {}, h("dt", { text: name }), h("dd"))));
    }
    facts.forEach(([, value], i) => {
      const place = this.facts.children[i]?.lastElementChild;
      if (place) setText(place, value);
    });
  }

  private fillDevices(link: Link, unbound: readonly UnboundDevice[]): void {
    const devices = unbound.map((one) => one.device);
    const key = [link.sensor, link.device, ...devices].join("\n");
    if (this.device.dataset["key"] === key) return;
    this.device.dataset["key"] = key;
    this.device.replaceChildren(
      h("option", { value: "", text: devices.length > 0 ? "Bind a device by name…" : "No unbound device is sending" }),
      ...unbound.map((one) => h("option", { value: one.device, text: one.announces ? `${one.device} (says ${one.announces})` : one.device })),
    );
    this.device.disabled = devices.length === 0;
  }
}

/** Who sends as one sensor's device, a row each, where more than one does: who is heard, and a button for the others. */
class Senders {
  readonly element = h("div", { class: "senders", hidden: true });
  private readonly heard = h("strong", { class: "mono" });
  private readonly rivals: KeyedList<Rival, RivalRow>;
  private sensor = "";

  constructor(actions: Actions) {
    const list = h("ul", { class: "sender-list" });
    const rows = h("ul", { class: "sender-list" }, h("li", { class: "sender" }, h("div", {}, this.heard, h("span", { class: "quiet", text: "heard" }))));
    this.element.append(rows, list);
    this.rivals = new KeyedList(list, (one) => one.source, (one) => new RivalRow(one.source, () => void actions.hear(this.sensor, one.source)));
  }

  update(link: Link): void {
    this.sensor = link.sensor;
    setHidden(this.element, link.rivals.length === 0);
    setText(this.heard, link.source);
    this.rivals.update(link.rivals);
  }
}

class RivalRow {
  readonly element: HTMLLIElement;
  private readonly about = h("span", { class: "quiet" });

  constructor(source: string, hear: () => void) {
    this.element = h(
      "li",
      { class: "sender" },
      h("div", {}, h("strong", { class: "mono", text: source }), this.about),
      h("button", { type: "button", class: "button small", text: "Hear this one", onclick: hear }),
    );
  }

  update(rival: Rival): void {
    setText(this.about, `not heard, sent ${milliseconds(rival.ageMs)} ago${rival.implausible ? ", behaves as no sensor" : ""}`);
  }
}

class UnboundRow {
  readonly element = h("li", { class: "unbound-row" });
  private readonly about = h("span", { class: "quiet" });
  private readonly sensor = h("select", { "aria-label": "Site" });

  constructor(one: UnboundDevice, session: Session, actions: Actions) {
    const bind = h("button", {
      type: "button",
      class: "button small",
      text: "Bind",
      onclick: () => {
        if (this.sensor.value) void actions.bind(this.sensor.value, one.device);
      },
    });
    const names = (session.status.value?.links ?? []).map((link) => link.sensor);
    this.sensor.append(
      h("option", { value: "", text: "Which site?" }),
      ...names.map((name) => h("option", { value: name, text: sensorLabel(name), selected: name === one.announces })),
    );
    this.element.append(
      h("div", {}, h("strong", { class: "mono", text: one.device }), this.about),
      h("div", { class: "button-row" }, this.sensor, bind),
    );
  }

  update(one: UnboundDevice): void {
    const says = one.announces ? `, says it is ${sensorLabel(one.announces)}` : "";
    setText(this.about, `${one.protocol || "unknown protocol"}, heard ${milliseconds(one.ageMs)} ago${says}`);
  }
}

/** A camera's heading is the headset's own. */
function headingFact(link: Link, camera: boolean): [string, string][] {
  if (camera) return [];
  const known = (degrees: number | null) => (degrees === null ? "–" : `±${fixed(degrees, 1)}°`);
  return [
    ["Heading known to", known(link.headingSigmaDeg)],
    ["Rotation known to", known(link.rotationSigmaDeg) + (link.leftOut ? ", left out" : "")],
  ];
}

function capital(text: string): string {
  return text.charAt(0).toUpperCase() + text.slice(1);
}
