/** The first step of a recording: for which dataset, what of which script, by whom, and who sets the pace. */
import { type DatasetList, LONGEST, type Pace, type Script } from "../dataset_protocol";
import { h, setHidden, setText } from "../dom";
import type { Hearing } from "../hearing_protocol";
import type { Memory } from "./memory";
import { NameField } from "./name_field";
import { aboutMinutes, blocksOf, languageName, lineCount, progressWords, titled, wholeOf } from "./words";

/** What was chosen. */
export interface Choice {
  dataset: string;
  script: Script;
  performer: string;
  pace: Pace;
}

/** Whether somebody's voice could be followed. Of a browser's microphone it is known whether it is heard; a session that has another one listens to it. */
export function isHeard(hearing: Hearing | null): boolean {
  return hearing !== null && hearing.on && !hearing.shut && hearing.trouble === "" && (hearing.browser === null || hearing.browser.heard || hearing.blocks > 0);
}

/** Names of datasets are those of folders, as the session takes them. */
const FOLDER_NAME = /^[A-Za-z0-9_-]+$/;

export class WhatStep {
  readonly element = h("form", { class: "recorder-step", "aria-labelledby": "recorder-what", novalidate: true });
  private readonly title = h("h2", { id: "recorder-what", tabindex: -1, text: "What is recorded" });
  private readonly dataset = new NameField("Dataset", "A new dataset…", "Name of the new dataset", LONGEST.dataset);
  private readonly performer = new NameField("Performer", "Somebody new…", "Name or code of the performer", LONGEST.performer);
  private readonly scripts = h("div", { class: "script-cards" });
  private readonly noScripts = h("p", { class: "recorder-problem", hidden: true });
  private readonly done = h("p", { class: "recorder-note", role: "status" });
  private readonly byVoice = h("input", { type: "radio", name: "recorder-pace", value: "voice" });
  private readonly byKey = h("input", { type: "radio", name: "recorder-pace", value: "key" });
  private readonly voiceWords = h("span", { class: "quiet" });
  private readonly problem = h("p", { class: "recorder-problem", role: "alert", hidden: true });
  private known: DatasetList | null = null;
  private shownScripts = "";

  constructor(
    private readonly memory: Memory,
    private readonly onward: (choice: Choice) => void,
    close: () => void,
  ) {
    this.element.append(
      this.title,
      h("p", { class: "recorder-lead", text: "A performer reads lines and makes faces while the sensors record. What is left today is asked for the next time." }),
      h("div", { class: "recorder-fields" }, this.dataset.element, this.performer.element),
      h("fieldset", { class: "recorder-group" }, h("legend", { text: "Script" }), this.scripts, this.noScripts),
      h(
        "fieldset",
        { class: "recorder-group" },
        h("legend", { text: "Pace" }),
        h("label", { class: "recorder-option" }, this.byKey, h("span", {}, "By key ", h("span", { class: "quiet", text: "A key, a button or a presenter's remote goes on to the next line." }))),
        h("label", { class: "recorder-option" }, this.byVoice, h("span", {}, "By voice ", this.voiceWords)),
      ),
      this.done,
      this.problem,
      h(
        "div",
        { class: "recorder-foot" },
        h("button", { type: "button", class: "button large", text: "Cancel", onclick: close }),
        h("button", { type: "submit", class: "button large primary", text: "Continue" }),
      ),
    );
    this.element.addEventListener("submit", (event) => {
      event.preventDefault();
      this.submit();
    });
    this.element.addEventListener("input", () => {
      setHidden(this.problem, true);
      this.draw();
    });
  }

  focus(): void {
    this.title.focus({ preventScroll: true });
  }

  /** Begins anew: what was chosen before is chosen again. */
  begin(known: DatasetList | null): void {
    const { dataset, performer, script, pace } = this.memory.value;
    (pace === "voice" ? this.byVoice : this.byKey).checked = true;
    this.problem.hidden = true;
    this.shownScripts = "";
    this.show(known, dataset, performer, script);
  }

  /** What there is to choose from has become known; what was chosen meanwhile stays. */
  refresh(known: DatasetList | null): void {
    const { dataset, performer, script } = this.memory.value;
    this.show(known, this.dataset.value || dataset, this.performer.value || performer, this.script?.name ?? script);
  }

  /** `known`: null: nothing yet. */
  private show(known: DatasetList | null, dataset: string, performer: string, script: string): void {
    this.known = known;
    this.dataset.setNames(known?.datasets.map((one) => one.name) ?? [], dataset);
    this.drawPerformers(performer);
    setHidden(this.noScripts, known !== null && known.scripts.length > 0);
    setText(this.noScripts, known ? "The session has no script to record." : "Asking the session …");
    this.drawScripts(known?.scripts ?? [], script);
    this.draw();
  }

  setHearing(hearing: Hearing | null): void {
    const heard = isHeard(hearing);
    this.byVoice.disabled = !heard;
    if (!heard && this.byVoice.checked) this.byKey.checked = true;
    setText(
      this.voiceWords,
      heard
        ? "The next line comes when this one was spoken; the key works too."
        : hearing?.browser
          ? "No microphone is heard: let this browser's be heard first, under Output."
          : "No microphone is heard by this session.",
    );
  }

  private drawPerformers(preferred: string): void {
    const names = this.known?.datasets.find((one) => one.name === this.dataset.value)?.performers.map((one) => one.name) ?? [];
    this.performer.setNames(names, preferred);
  }

  /** The same ones stay, and with them the focus. */
  private drawScripts(scripts: readonly Script[], preferred: string): void {
    const key = JSON.stringify(scripts);
    if (key === this.shownScripts) return;
    this.shownScripts = key;
    const chosen = scripts.find((one) => one.name === preferred) ?? scripts.find((one) => navigator.language.split("-")[0] === one.language) ?? scripts[0];
    this.scripts.replaceChildren(...scripts.map((one) => scriptCard(one, one === chosen)));
  }

  private draw(): void {
    this.drawPerformers(this.performer.value);
    const words = this.known ? progressWords(this.known, this.dataset.value, this.performer.value, this.script) : "";
    setText(this.done, words);
    setHidden(this.done, words === "");
  }

  private get script(): Script | null {
    const checked = this.scripts.querySelector<HTMLInputElement>("input:checked");
    return this.known?.scripts.find((one) => one.name === checked?.value) ?? null;
  }

  private submit(): void {
    const { script } = this;
    const dataset = this.dataset.value;
    const performer = this.performer.value;
    const named = FOLDER_NAME.test(dataset);
    const missing = dataset === "" ? "Give the dataset a name." : !named ? "A dataset's name has letters from A to Z, digits, - and _ alone: it names a folder." : performer === "" ? "Say who performs: a name, or a code." : !script ? "Choose a script." : "";
    setText(this.problem, missing);
    setHidden(this.problem, missing === "");
    if (!named) this.dataset.focus();
    else if (performer === "") this.performer.focus();
    if (missing !== "" || !script) return;
    const pace: Pace = this.byVoice.checked ? "voice" : "key";
    this.memory.set({ dataset, performer, script: script.name, pace });
    this.onward({ dataset, script, performer, pace });
  }
}

function scriptCard(script: Script, checked: boolean): HTMLElement {
  const { lines, seconds } = wholeOf(script);
  const language = languageName(script.language);
  return h(
    "label",
    { class: "script-card" },
    h("input", { type: "radio", name: "recorder-script", value: script.name, checked }),
    h(
      "span",
      { class: "script-words" },
      h("span", { class: "script-head" }, h("strong", { text: script.title, dir: "auto" }), h("span", { class: "quiet", text: language })),
      h("span", { class: "script-blocks" }, ...blocksOf(script).map((one) => h("span", {}, `${titled(one.name) || "Lines"} `, h("span", { class: "quiet", text: `${lineCount(one.lines)}, ${aboutMinutes(one.seconds)}` })))),
      h("span", { class: "quiet", text: `${lineCount(lines)} in all, ${aboutMinutes(seconds)}` }),
    ),
  );
}
