/** Calibrations: beginning one, the versions so far, two of them compared, and an earlier one put back in force. */
import type { Actions } from "../actions";
import type { CalibrationStatus, CalibrationVersion, Score } from "../calibration_protocol";
import { seesAnEye } from "../camera_words";
import { h, KeyedList, setHidden, setText } from "../dom";
import { ago, agoToTheMinute, fixed } from "../format";
import type { Status } from "../protocol";
import type { Session } from "../session";
import { PhoneLessonSection } from "./phone_lesson";

const ORIGINS: Readonly<Record<string, string>> = {
  self: "By itself, from how you moved",
  guided: "Guided",
  recentre: "Re-centred",
  restored: "From an earlier session",
  phone: "Learnt from the phone",
};

export class CalibrationPanel {
  readonly element = h("div", { class: "panel calibration-panel" });
  private readonly sentence = h("p", { class: "summary" });
  private readonly advice = h("p", { class: "advice", hidden: true, text: "Your sensors have drifted. Relax your face and press Space." });
  private readonly list = h("ul", { class: "versions" });
  private readonly empty = h("p", { class: "quiet", text: "None yet." });
  private readonly comparison = h("section", { class: "comparison", hidden: true });
  private readonly compared = new Set<string>();
  private readonly versions: KeyedList<CalibrationVersion, VersionRow>;
  private readonly begin: HTMLButtonElement[];
  private shownComparison = "";

  constructor(
    private readonly session: Session,
    actions: Actions,
  ) {
    const short = h("button", { type: "button", class: "button primary", onclick: () => void actions.calibrate("short") }, "Calibrate");
    const full = h("button", { type: "button", class: "button", onclick: () => void actions.calibrate("full") }, "With expressions");
    const wearer = h("button", { type: "button", class: "button", onclick: () => void actions.calibrate("wearer") }, "Learn my skin");
    const gaze = h("button", { type: "button", class: "button", hidden: true, onclick: () => void actions.calibrate("gaze") }, "Where I look");
    const recentre = h("button", { type: "button", class: "button", onclick: () => void actions.recentre() }, "Re-centre");
    this.begin = [short, full, wearer, gaze];
    this.element.append(
      this.sentence,
      this.advice,
      h("div", { class: "button-row" }, short, full, wearer, gaze, recentre),
      h("p", {
        class: "quiet",
        text: "Calibrate: hold still, nod, shake your head. With expressions: then also a few faces to make, and each is told how well it was seen. Learn my skin: then a minute of other faces, and sensors on the skin are read as yours from then on. Where I look, with a headset: five points to look at, said aloud. Re-centre: relax and look ahead for three seconds and a half; what your sensors drifted by, or your headset slipped by, is corrected, and the face you have now is neutral again.",
      }),
      new PhoneLessonSection(session, actions).element,
      h("h3", { text: "Versions" }),
      this.list,
      this.empty,
      this.comparison,
    );
    this.versions = new KeyedList(this.list, (one) => String(one.id), (one) => new VersionRow(one, actions, (on) => this.compare(one, on)));
    session.status.listen((status) => this.update(status));
    session.hello.listen((hello) => setHidden(gaze, !seesAnEye(hello?.sensors ?? [])));
  }

  private update(status: Status | null): void {
    if (!status) return;
    const { calibration } = status;
    const sentences: Record<typeof calibration.state, string> = {
      none: "Not calibrated: the face stays neutral until it is.",
      watching: calibration.prompt || "Not calibrated yet. Hold still, nod and shake your head: the session is watching for them.",
      running: calibration.prompt,
      done: ageSentence(calibration),
      failed: calibration.prompt || "The calibration failed. Try again, more slowly.",
    };
    setText(this.sentence, sentences[calibration.state]);
    setHidden(this.advice, calibration.state !== "done" || !calibration.advisesRecentring);
    for (const button of this.begin) button.disabled = calibration.state === "running";
    const newestFirst = [...calibration.versions].reverse();
    this.versions.update(newestFirst);
    for (const row of this.versionsRows()) row.tick(status);
    setHidden(this.empty, newestFirst.length > 0);
    this.drawComparison(calibration.versions);
  }

  private versionsRows(): VersionRow[] {
    return Array.from(this.list.children).flatMap((element) => rowOf.get(element) ?? []);
  }

  private compare(version: CalibrationVersion, on: boolean): void {
    const key = String(version.id);
    this.compared.delete(key);
    if (on) this.compared.add(key);
    while (this.compared.size > 2) {
      const oldest = this.compared.values().next().value;
      if (oldest === undefined) break;
      this.compared.delete(oldest);
      for (const row of this.versionsRows()) row.uncheck(oldest);
    }
    this.drawComparison(this.session.status.value?.calibration.versions ?? []);
  }

  private drawComparison(versions: readonly CalibrationVersion[]): void {
    const [first, second] = [...this.compared].map((key) => versions.find((one) => String(one.id) === key));
    setHidden(this.comparison, !first || !second);
    if (!first || !second) {
      this.shownComparison = "";
      return;
    }
    const key = `${first.id} ${second.id}`;
    if (key === this.shownComparison) return;
    this.shownComparison = key;
    const names = [...new Set([...first.scores, ...second.scores].map((score) => score.name))];
    const cell = (score: Score | undefined) =>
      h("td", { "data-pass": score ? String(score.pass) : null, text: score ? `${fixed(score.value, 1)} ${score.unit}` : "–" });
    this.comparison.replaceChildren(
      h("h3", { text: "Compared" }),
      h(
        "table",
        { class: "compare" },
        h("thead", {}, h("tr", {}, h("th", { scope: "col", text: "Score" }), h("th", { scope: "col", text: `Version ${first.id}` }), h("th", { scope: "col", text: `Version ${second.id}` }))),
        h(
          "tbody",
          {},
          ...names.map((name) =>
            h(
              "tr",
              {},
              h("th", { scope: "row", text: name }),
              cell(first.scores.find((score) => score.name === name)),
              cell(second.scores.find((score) => score.name === name)),
            ),
          ),
        ),
      ),
    );
  }
}

const rowOf = new WeakMap<Element, VersionRow>();

class VersionRow {
  readonly element = h("li", { class: "version" });
  private readonly title = h("strong");
  private readonly time = h("span", { class: "quiet" });
  private readonly badge = h("span", { class: "badge", text: "in force" });
  private readonly use: HTMLButtonElement;
  private readonly check = h("input", { type: "checkbox" });
  private readonly scores = h("ul", { class: "scores" });
  private version: CalibrationVersion;

  constructor(version: CalibrationVersion, actions: Actions, compare: (on: boolean) => void) {
    this.version = version;
    this.use = h("button", {
      type: "button",
      class: "button small",
      text: "Use this",
      onclick: () => void actions.send({ command: "use_calibration", version: version.id }),
    });
    this.check.addEventListener("change", () => compare(this.check.checked));
    const details = h("details", {}, h("summary", { text: "Scores" }), this.scores);
    this.element.append(
      h("div", { class: "version-head" }, h("div", {}, this.title, this.time), this.badge, this.use),
      h("div", { class: "version-foot" }, details, h("label", { class: "check" }, this.check, "Compare")),
    );
    rowOf.set(this.element, this);
  }

  uncheck(id: string): void {
    if (String(this.version.id) === id) this.check.checked = false;
  }

  update(version: CalibrationVersion): void {
    const changed = this.scores.childElementCount === 0 || version.scores.length !== this.version.scores.length;
    this.version = version;
    setText(this.title, `${version.id}. ${ORIGINS[version.origin] ?? (version.origin || "Calibration")}`);
    setHidden(this.badge, !version.inForce);
    setHidden(this.use, version.inForce);
    this.element.classList.toggle("in-force", version.inForce);
    if (changed) this.scores.replaceChildren(...scoreItems(version.scores));
  }

  tick(status: Status): void {
    setText(this.time, when(this.version, status));
  }
}

/** Each score as a sentence with a tick or a cross. */
export function scoreItems(scores: readonly Score[]): HTMLElement[] {
  return scores.map((score) =>
    h(
      "li",
      { "data-pass": String(score.pass) },
      h("span", { class: "verdict", text: score.pass ? "✓" : "✗", "aria-label": score.pass ? "passed" : "failed" }),
      h("span", {}, score.sentence || score.name, score.value === null ? "" : h("span", { class: "quiet", text: ` ${fixed(score.value, 1)} ${score.unit}` })),
    ),
  );
}

/** "Calibrated 1 h 12 min ago, re-centred 3 min ago, rotations known to 2.1°." */
export function ageSentence(calibration: CalibrationStatus): string {
  const parts = ["Calibrated"];
  if (calibration.ageS !== null) parts[0] += ` ${agoToTheMinute(calibration.ageS)}`;
  if (calibration.recentredS !== null) parts.push(`re-centred ${agoToTheMinute(calibration.recentredS)}`);
  if (calibration.sigmaDeg !== null) parts.push(`rotations known to ${fixed(calibration.sigmaDeg, 1)}°`);
  return `${parts.join(", ")}.`;
}

function when(version: CalibrationVersion, status: Status): string {
  return version.time === null || status.time === null ? "" : ago(status.time - version.time);
}
