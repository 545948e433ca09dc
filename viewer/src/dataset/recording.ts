/**
 * Recording a dataset, over the whole page: what, consent, the check before each block, the lines, and what came of it.
 * What runs is known from the session alone, so a page that is opened in the middle goes on in the middle.
 */
import type { Actions } from "../actions";
import { sessionWord } from "../chrome/session_word";
import type { DatasetList, DatasetWish, Script } from "../dataset_protocol";
import { performerOf } from "../dataset_protocol";
import { h, setAttribute, setHidden, setText } from "../dom";
import { clock } from "../format";
import type { BrowserCamera } from "../browser_camera";
import type { BrowserMicrophone } from "../microphone";
import { isAsking, type PromptStatus } from "../prompt_protocol";
import type { Status } from "../protocol";
import type { Session } from "../session";
import { CheckStep } from "./check_step";
import { ConsentStep } from "./consent_step";
import { LineLog, type PoorNews } from "./line_log";
import { Memory } from "./memory";
import { isRunning, type Step, stepOf } from "./step";
import { SummaryStep } from "./summary_step";
import { Teleprompter } from "./teleprompter";
import { type Choice, WhatStep } from "./what_step";
import { lineCount } from "./words";

const STEPS: readonly (readonly [string, readonly Step[]])[] = [
  ["What", ["what"]], ["Consent", ["consent"]], ["Check", ["check"]], ["Lines", ["lines"]], ["Done", ["summary"]],
];

/** Of more troubles the number is said: they are read in passing. */
const NAMED = 3;

/** What was poor with the line that is over, and what becomes of it. */
export function newsWords({ sentences, again }: PoorNews): string {
  const named = sentences.slice(0, NAMED).join(", ");
  const more = sentences.length - NAMED;
  return `The last line: ${named}${more > 0 ? ` and ${more} more` : ""}. It is asked for again ${again ? "at the end" : "the next time"}.`;
}

/** The script that the lines are of: the one that was chosen here, else the only one that has such a block. */
export function scriptOf(known: DatasetList | null, chosen: string, prompts: PromptStatus | null): Script | null {
  const fitting = (known?.scripts ?? []).filter((one) => (prompts?.language === "" || one.language === prompts?.language) && one.blocks.some((block) => block.name === prompts?.block));
  return fitting.find((one) => one.name === chosen) ?? (fitting.length === 1 ? (fitting[0] ?? null) : null);
}

export class Recording {
  readonly element = h("dialog", { class: "recorder", "aria-label": "Record a dataset" });
  /** In its place below the face while what runs is set aside. */
  readonly strip = h("div", { class: "record-strip", hidden: true });
  private readonly memory = new Memory();
  private readonly what: WhatStep;
  private readonly consent: ConsentStep;
  private readonly check: CheckStep;
  private readonly lines: Teleprompter;
  private readonly summary: SummaryStep;
  private readonly bodies: Readonly<Record<Step, { element: HTMLElement; focus(): void }>>;
  private readonly chip = h("span", { class: "chip", "data-tone": "idle" });
  /** Whether the face is on video, where the performer agreed to that. */
  private readonly film = h("span", { class: "recorder-film", role: "status", hidden: true });
  private readonly whose = h("span", { class: "recorder-whose", dir: "auto" });
  private readonly steps = h("ol", { class: "recorder-steps" }, ...STEPS.map(([name]) => h("li", { text: name })));
  private readonly aside = h("button", { type: "button", class: "button", text: "Show the page", onclick: () => this.setAside(true) });
  private readonly end = h("button", { type: "button", class: "button", text: "End …", onclick: () => this.confirm(true) });
  private readonly close = h("button", { type: "button", class: "button", text: "Close", onclick: () => this.dismiss() });
  private readonly trouble = h("p", { class: "recorder-trouble", role: "alert", hidden: true });
  private readonly endWords = h("p");
  private readonly stay = h("button", { type: "button", class: "button large", text: "Go on", onclick: () => this.confirm(false) });
  private readonly confirmation: HTMLElement;
  private readonly stripWords = h("span", { dir: "auto" });

  private asked: "what" | "consent" | null = null;
  private begun = "";
  private isAside = false;
  private step: Step | null = null;
  private known: DatasetList | null = null;
  private log: LineLog;
  private logged = "";
  /** The list that is being waited for, and the take that it was asked for last, once written. */
  private listing: Promise<void> | null = null;
  private listedAfter = "";
  private listedBefore = "";

  /** `notices` are shown here while the page beneath cannot be seen. */
  constructor(
    private readonly session: Session,
    private readonly actions: Actions,
    microphone: BrowserMicrophone,
    private readonly camera: BrowserCamera,
    private readonly notices: HTMLElement,
  ) {
    this.log = new LineLog(this.memory.value.poor);
    this.logged = this.memory.value.take;
    this.what = new WhatStep(this.memory, (choice) => this.askConsent(choice), () => this.dismiss());
    this.consent = new ConsentStep(this.memory, (wish) => this.begin(wish), () => this.open());
    this.check = new CheckStep(session, actions, microphone, camera, (on) => this.wantVideo(on));
    this.lines = new Teleprompter(actions, () => this.memory.value.pace === "voice", (number) => this.log.skip(number));
    this.summary = new SummaryStep(() => void this.watch(), () => this.recordOn(), () => this.dismiss());
    this.bodies = { what: this.what, consent: this.consent, check: this.check, lines: this.lines, summary: this.summary };
    this.confirmation = h(
      "div",
      { class: "recorder-confirm", role: "alertdialog", "aria-label": "End the recording?", hidden: true },
      this.endWords,
      h("div", { class: "button-row" }, h("button", { type: "button", class: "button large primary", text: "End the recording", onclick: () => void this.endNow() }), this.stay),
    );
    this.element.append(
      h("header", { class: "recorder-head" }, this.chip, this.film, this.whose, h("span", { class: "spring" }), this.steps, this.aside, this.end, this.close),
      this.trouble,
      h("div", { class: "recorder-body" }, this.confirmation, ...Object.values(this.bodies).map((body) => body.element)),
    );
    for (const body of Object.values(this.bodies)) setHidden(body.element, true);
    this.strip.append(h("span", { class: "record-dot", "aria-hidden": "true" }), this.stripWords, h("button", { type: "button", class: "button small", text: "Back to it", onclick: () => this.setAside(false) }));
    // The browser's own ways to close it, as a telephone's gesture.
    this.element.addEventListener("cancel", (event) => event.preventDefault());
    this.element.addEventListener("close", () => {
      // It is told of late: it may have been opened again, or we closed it.
      if (this.element.open || this.step === null || this.isAside) return;
      if (isRunning(this.step)) this.setAside(true);
      else this.dismiss();
    });
    window.addEventListener("keydown", (event) => this.press(event));
    session.status.listen((status) => this.update(status));
    session.connection.listen(() => this.update(session.status.value));
    session.events.listen((events) => {
      // The take is whole now: what the list says of it counts from now on.
      if (events[events.length - 1]?.kind === "recorded" && this.step === "summary") this.listedAfter = "";
      if (this.step === "summary") this.update(session.status.value);
    });
  }

  /** Whether it lies over the page. */
  get isOpen(): boolean {
    return this.element.open;
  }

  /** Where faces are to be seen, CSS pixels of the window; null where none are. */
  get faces(): DOMRect | null {
    return this.isOpen && this.step === "lines" && !this.lines.window.hidden ? this.lines.window.getBoundingClientRect() : null;
  }

  /** For who watches where it is. */
  get facesElement(): HTMLElement {
    return this.lines.window;
  }

  /** Opens it where it is: in what runs, or before. */
  open(): void {
    if (isRunning(this.step)) return this.setAside(false);
    this.rememberEnd();
    this.asked = "what";
    this.what.begin(this.known);
    void this.list().then(() => {
      if (this.asked === "what") this.what.refresh(this.known);
    });
    this.update(this.session.status.value);
  }

  /** Escape: closes where nothing runs; what runs is not ended by a slip. */
  escape(): void {
    if (!this.confirmation.hidden) this.confirm(false);
    else if (!isRunning(this.step)) this.dismiss();
  }

  /** Moves what moves between two messages; called at the display's rate while `isOpen`. */
  draw(nowMs: number): void {
    if (this.step === "lines") this.lines.draw(nowMs);
  }

  private update(status: Status | null): void {
    const dataset = status?.dataset ?? null;
    const prompts = isAsking(status?.prompts) ? status.prompts : null;
    if (dataset && !dataset.over) this.follow(dataset.take);
    const news = status?.prompts ? this.log.see(status.prompts) : null;
    if (status?.prompts && dataset && this.log.changed(this.memory.value.poor)) this.memory.set({ poor: this.log.poor });
    if (news) {
      this.lines.tell(newsWords(news));
      this.check.tell(newsWords(news));
    }

    const before = this.step;
    let step = stepOf(status, this.asked, this.memory.value.dismissed ? this.memory.value.take : null);
    if (isRunning(step) || (this.begun !== "" && dataset?.take === this.begun)) {
      this.asked = null;
      this.begun = "";
      step = stepOf(status, null, this.memory.value.dismissed ? this.memory.value.take : null);
    }
    this.step = step;
    if (!isRunning(step)) this.isAside = false;
    this.followVideo(status);
    this.drawHead(status);
    if (step === "consent") this.consent.update(this.session.hello.value, status);
    if (step === "what") this.what.setHearing(status?.hearing ?? null);
    if (step === "check" && status) this.check.update(status, prompts, scriptOf(this.known, this.memory.value.script, prompts));
    if (step === "summary" && dataset && status) {
      if (!status.recording.on && this.listedAfter !== dataset.take) {
        this.listedAfter = dataset.take;
        void this.list().then(() => this.update(this.session.status.value));
      }
      const seen = this.memory.value.take === dataset.take;
      this.summary.update({ dataset, known: this.listedAfter === dataset.take && !this.listing ? this.known : null, before: seen ? this.memory.value.before : null, poor: seen ? this.log.poor : [] });
    }
    this.show(before);
    // Once it is shown: its type is made to fit its place.
    if (step === "lines" && prompts) this.lines.update(prompts);
  }

  private show(before: Step | null): void {
    const { step } = this;
    const shown = step !== null && !this.isAside;
    for (const [name, body] of Object.entries(this.bodies)) setHidden(body.element, name !== step);
    setHidden(this.strip, !this.isAside);
    const opens = shown && !this.element.open;
    if (opens) this.element.showModal();
    if (opens) this.element.prepend(this.notices);
    if (!shown && this.element.open) {
      this.element.close();
      document.querySelector(".stage")?.append(this.notices);
    }
    setAttribute(this.element, "data-step", step);
    setAttribute(document.documentElement, "data-recorder", shown ? step : null);
    if (!shown || !step || (!opens && step === before)) return;
    this.confirm(false);
    if (step !== "check") this.check.tell("");
    if (step !== "lines") this.lines.tell("");
    this.bodies[step].element.scrollTop = 0;
    this.bodies[step].focus();
  }

  private drawHead(status: Status | null): void {
    const { step } = this;
    const running = isRunning(step);
    const word = sessionWord(this.session.connection.value, status);
    const recording = status?.recording;
    const lost = word.tone === "bad";
    const off = running && !lost && !recording?.on;
    setText(this.chip, off ? "not recording" : recording?.on && !lost ? `recording ${clock(recording.seconds)}` : word.text);
    setAttribute(this.chip, "data-tone", off ? "bad" : word.tone);
    const video = status?.video;
    setHidden(this.film, !running || !video?.agreed);
    setText(this.film, video?.on && !lost ? "video" : "no video");
    setAttribute(this.film, "data-on", String(video?.on === true && !lost));
    const dataset = status?.dataset;
    setText(this.whose, running && dataset ? `${dataset.performer} · ${dataset.name}` : "");
    setHidden(this.aside, !running);
    setHidden(this.end, !running || !dataset);
    setHidden(this.close, running);
    STEPS.forEach(([, steps], i) => setAttribute(this.steps.children[i] as Element, "aria-current", step !== null && steps.includes(step) ? "step" : null));
    const trouble = lost && running
      ? "The connection to the session broke, and is tried again. What is being recorded goes on without this page."
      : lost ? "There is no connection to the session. It is tried again."
      : running ? recording?.error || status?.log.error || "" : "";
    setText(this.trouble, trouble);
    setHidden(this.trouble, trouble === "");
    const prompts = status?.prompts;
    setText(this.stripWords, prompts ? `${step === "check" ? "A block waits" : "Lines are asked for"}: ${Math.max(0, prompts.of - prompts.number + 1)} to go` : "A dataset is being recorded");
    const left = prompts ? Math.max(0, prompts.of - prompts.number + 1) : 0;
    setText(this.endWords, `End the recording for now? ${left > 0 ? `${lineCount(left)} ${left === 1 ? "is" : "are"} left: asked for the next time. ` : ""}What was recorded is kept.`);
  }

  /** A recording that runs: what this page saw of another is void, and what there was before it is asked for in time. */
  private follow(take: string): void {
    if (take !== this.logged) {
      this.logged = take;
      this.memory.beginTake(take);
      this.log = new LineLog(this.memory.value.poor);
    }
    // Once: a session that refuses is not asked five times a second.
    if (this.listedBefore === take) return;
    this.listedBefore = take;
    void this.list().then(() => {
      const dataset = this.session.status.value?.dataset;
      if (!dataset || dataset.over || dataset.take !== take || !this.known || this.memory.value.before !== null) return;
      // While its take grows the list has what was before it.
      this.memory.set({ before: performerOf(this.known, dataset.name, dataset.performer)?.lines ?? 0 });
    });
  }

  /** This browser's camera records the take that runs, as long as the session lets it. */
  private followVideo(status: Status | null): void {
    const dataset = status?.dataset;
    if (!dataset || this.camera.state.value.kind !== "off" || !this.session.connected) return;
    if (this.memory.value.video && this.memory.value.take === dataset.take && !dataset.over && status.video?.agreed) void this.camera.start();
  }

  private wantVideo(on: boolean): void {
    this.memory.set({ video: on });
    this.camera.toggle();
  }

  private list(): Promise<void> {
    this.listing ??= this.actions.listDatasets().then((known) => {
      this.listing = null;
      if (known) this.known = known;
    });
    return this.listing;
  }

  private askConsent(choice: Choice): void {
    this.asked = "consent";
    this.consent.show(choice);
    this.update(this.session.status.value);
  }

  /** Gives what stands against it, or "". */
  private async begin(wish: DatasetWish): Promise<string> {
    const reply = await this.actions.beginDataset(wish);
    if (!reply.ok) return reply.error || "The session refused, and does not say why.";
    const take = reply.result?.["take"];
    this.begun = typeof take === "string" ? (take.split(/[/\\]/).pop() ?? "") : "";
    if (this.begun !== "") {
      this.memory.beginTake(this.begun);
      this.memory.set({ video: wish.video });
      // Whatever stood against it in another recording.
      this.camera.stop();
    }
    this.update(this.session.status.value);
    return "";
  }

  private confirm(open: boolean): void {
    if (this.confirmation.hidden === !open) return;
    setHidden(this.confirmation, !open);
    if (open) this.stay.focus();
    else if (this.step) this.bodies[this.step].focus();
  }

  private async endNow(): Promise<void> {
    if (await this.actions.endDataset()) this.confirm(false);
  }

  private setAside(aside: boolean): void {
    this.isAside = aside && isRunning(this.step);
    this.update(this.session.status.value);
  }

  /** Away with what is shown, where nothing runs. */
  private dismiss(): void {
    this.asked = null;
    this.rememberEnd();
    this.update(this.session.status.value);
  }

  /** The end of the last recording was seen. */
  private rememberEnd(): void {
    const dataset = this.session.status.value?.dataset;
    if (!dataset?.over) return;
    this.memory.beginTake(dataset.take);
    this.memory.set({ dismissed: true });
  }

  private async watch(): Promise<void> {
    const dataset = this.session.status.value?.dataset;
    if (dataset && (await this.actions.playTake(dataset.take, dataset.name))) this.dismiss();
  }

  /** The same once more: for another performer, or for what is left. */
  private recordOn(): void {
    const dataset = this.session.status.value?.dataset;
    if (dataset) this.memory.set({ dataset: dataset.name, performer: dataset.performer });
    this.open();
  }

  private press(event: KeyboardEvent): void {
    if (!this.isOpen || !isRunning(this.step) || event.defaultPrevented || event.repeat || event.ctrlKey || event.metaKey || event.altKey) return;
    // Another dialog may lie over this one.
    if (document.querySelector("dialog.help[open]")) return;
    const key = event.key.toLowerCase();
    // A button that has the focus has its own use for these two.
    const target = event.target instanceof Element ? event.target : null;
    if ((key === " " || key === "enter") && target?.closest("button, a, summary, input")) return;
    if (!this.confirmation.hidden) return;
    const act = this.step === "check" ? this.keyInCheck(key) : this.keyInLines(key);
    if (!act) return;
    event.preventDefault();
    act();
  }

  private keyInCheck(key: string): (() => void) | null {
    if (!/^(enter| |arrowright|pagedown)$/.test(key) || this.session.status.value?.prompts?.state !== "block") return null;
    return () => void this.actions.steerPrompts("begin");
  }

  private keyInLines(key: string): (() => void) | null {
    switch (key) {
      case "enter":
      case "arrowright":
      case "pagedown":
        return () => this.lines.goOn();
      case "arrowleft":
      case "pageup":
        return () => this.lines.repeat();
      case "s":
        return () => this.lines.skip();
      case " ":
        return () => void this.actions.togglePrompts();
      default:
        return null;
    }
  }
}
