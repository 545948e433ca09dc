/** Before a block: what will be asked for, and whether sensors, phone and microphone are as they should be. */
import type { Actions } from "../actions";
import type { Script } from "../dataset_protocol";
import { h, KeyedList, setAttribute, setHidden, setText } from "../dom";
import { sensorLabel } from "../format";
import { healthOf, type Severity } from "../health";
import type { BrowserCamera } from "../browser_camera";
import type { BrowserMicrophone } from "../microphone";
import type { PromptStatus } from "../prompt_protocol";
import type { Link, Status } from "../protocol";
import type { Session } from "../session";
import { askedAgain } from "./line_log";
import { MicrophoneCheck } from "./microphone_check";
import { phonesOf, sensorsOf } from "./roles";
import { VideoCheck } from "./video_check";
import { aboutMinutes, blockSentence, blocksOf, lineCount, titled } from "./words";

const WORST_FIRST: readonly Severity[] = ["bad", "warn", "idle", "good"];

/** Sensors in the order in which they need a look. */
export function worstFirst(links: readonly Link[]): Link[] {
  const rank = (link: Link) => WORST_FIRST.indexOf(healthOf(link.state).severity);
  return [...links].sort((a, b) => rank(a) - rank(b));
}

/** How many lines this block has still, as far as that is known, and how long all of what is left takes. */
export function blockFacts(prompts: PromptStatus, script: Script | null): string {
  const left = Math.max(0, prompts.of - prompts.number + 1);
  const rest = `${lineCount(left)} in all from here, ${aboutMinutes(prompts.leftS)}`;
  if (prompts.attempt > 1) return `${lineCount(askedAgain(prompts))}, ${aboutMinutes(prompts.leftS)}`;
  const block = script ? blocksOf(script).find((one) => one.name === prompts.block) : undefined;
  if (!block) return rest;
  // Of a block that was begun another day fewer are left than the script has.
  const lines = Math.min(block.lines, left);
  return lines === left ? `${lineCount(lines)}, ${aboutMinutes(prompts.leftS)}` : `${lines === block.lines ? "" : "at most "}${lineCount(lines)}, ${aboutMinutes(block.seconds)}; ${rest}`;
}

export class CheckStep {
  readonly element = h("section", { class: "recorder-step", "aria-labelledby": "recorder-block" });
  private readonly title = h("h2", { id: "recorder-block", dir: "auto" });
  private readonly what = h("p", { class: "recorder-lead" });
  private readonly facts = h("p");
  private readonly news = h("p", { class: "recorder-note warn", role: "status", hidden: true });
  private readonly sensors = h("section", { class: "check-part" });
  private readonly summary = h("p");
  private readonly troubles: KeyedList<Link, LinkRow>;
  private readonly well: KeyedList<Link, WellMark>;
  private readonly calibration = h("p", { class: "quiet", hidden: true });
  private readonly phone = h("section", { class: "check-part" });
  private readonly noPhone = h("p", { text: "No phone is there: the recording will have no truth to learn from. Start one that sends to this session, or go on without." });
  private readonly phones: KeyedList<Link, LinkRow>;
  private readonly microphone: MicrophoneCheck;
  private readonly video: VideoCheck;
  private readonly begin: HTMLButtonElement;

  constructor(
    private readonly session: Session,
    actions: Actions,
    microphone: BrowserMicrophone,
    camera: BrowserCamera,
    wantsVideo: (on: boolean) => void,
  ) {
    this.video = new VideoCheck(camera, wantsVideo);
    this.microphone = new MicrophoneCheck(session, microphone);
    this.begin = h("button", { type: "button", class: "button large primary", onclick: () => void actions.steerPrompts("begin") }, "Begin the block ", h("kbd", { text: "Enter" }));
    const troubles = h("ul", { class: "check-list" });
    const well = h("ul", { class: "check-well", "aria-label": "Well" });
    const phones = h("ul", { class: "check-list" });
    this.troubles = new KeyedList(troubles, (link) => link.sensor, (link) => new LinkRow(link));
    this.well = new KeyedList(well, (link) => link.sensor, (link) => new WellMark(link));
    this.phones = new KeyedList(phones, (link) => link.sensor, (link) => new LinkRow(link));
    this.sensors.append(h("h3", { text: "Sensors" }), this.summary, troubles, well, this.calibration);
    this.phone.append(h("h3", { text: "Phone" }), this.noPhone, phones);
    this.element.append(
      this.title,
      this.what,
      this.facts,
      this.news,
      h("div", { class: "check-parts" }, this.sensors, h("div", { class: "check-column" }, this.phone, this.microphone.element, this.video.element)),
      h("div", { class: "recorder-foot" }, h("p", { class: "quiet", text: "What is not well is recorded all the same." }), this.begin),
    );
  }

  focus(): void {
    this.begin.focus({ preventScroll: true });
  }

  /** `prompts`: of a block that waits; null while nothing is asked for yet. */
  update(status: Status, prompts: PromptStatus | null, script: Script | null): void {
    const again = prompts !== null && prompts.attempt > 1;
    setText(this.title, !prompts ? "Getting ready …" : again ? "Once more" : titled(prompts.block) || "Lines");
    setText(this.what, !prompts ? "The session is preparing the first line." : again ? "These lines were poor, and are asked for again. Then it is done." : blockSentence(prompts.block) || (prompts.say !== "" ? `It begins with: ${prompts.say}` : "Do or read what each line says."));
    setText(this.facts, prompts ? blockFacts(prompts, script) : "");
    this.begin.disabled = prompts === null;

    const hello = this.session.hello.value;
    const links = sensorsOf(hello, status);
    const bad = links.filter((link) => healthOf(link.state).severity !== "good");
    setText(this.summary, links.length > 0 ? `${links.length - bad.length} of ${links.length} are well.` : "This session has no sensors.");
    this.troubles.update(worstFirst(bad));
    this.well.update(links.filter((link) => !bad.includes(link)));
    const severities = bad.map((link) => healthOf(link.state).severity);
    setAttribute(this.sensors, "data-severity", WORST_FIRST.find((one) => severities.includes(one)) ?? "good");
    const calibrated = status.calibration.versions.some((one) => one.inForce);
    setText(this.calibration, calibrated ? "" : "Not calibrated yet, so the face stays neutral. It can be done now: show the page and press C.");
    setHidden(this.calibration, calibrated);

    const phones = phonesOf(hello, status);
    setHidden(this.noPhone, phones.length > 0);
    this.phones.update(worstFirst(phones));
    setAttribute(this.phone, "data-severity", phones.length === 0 ? "idle" : healthOf(worstFirst(phones)[0]?.state ?? "").severity);
    this.microphone.update(status);
    this.video.update(status);
  }

  /** What was poor with the line before the block; "": nothing. */
  tell(news: string): void {
    setText(this.news, news);
    setHidden(this.news, news === "");
  }
}

/** A sensor or phone with its state and what can be done about it. */
class LinkRow {
  readonly element: HTMLElement;
  private readonly pip = h("span", { class: "pip", "aria-hidden": "true" });
  private readonly state = h("span", { class: "check-state" });
  private readonly sentence = h("span", { class: "quiet" });

  constructor(link: Link) {
    this.element = h("li", { class: "check-row", "data-sensor": link.sensor }, this.pip, h("span", {}, h("strong", { text: sensorLabel(link.sensor) }), " ", this.state, this.sentence));
  }

  update(link: Link): void {
    const health = healthOf(link.state);
    setAttribute(this.element, "data-severity", health.severity);
    setText(this.pip, health.mark);
    setText(this.state, health.label);
    setText(this.sentence, health.sentence);
  }
}

class WellMark {
  readonly element: HTMLElement;

  constructor(link: Link) {
    this.element = h("li", { "data-severity": "good" }, h("span", { class: "pip", "aria-hidden": "true" }), sensorLabel(link.sensor));
  }

  update(): void {
    // Whoever is listed here is well: there is nothing more to say.
  }
}
