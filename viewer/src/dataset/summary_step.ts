/** The end of a recording: how much of it there is, what was poor, and what was in the way, if anything was. */
import { type DatasetList, type DatasetStatus, performerOf } from "../dataset_protocol";
import { h, setHidden, setText } from "../dom";
import type { PoorLine } from "./memory";
import { lineCount } from "./words";

/** What is known of a recording that is over. */
export interface Ended {
  dataset: DatasetStatus;
  /** As it is now that the take is written; null while that is not known. */
  known: DatasetList | null;
  /** Lines that the performer had recorded well before; null where the page does not know. */
  before: number | null;
  poor: readonly PoorLine[];
}

/** How many lines it recorded well; null where that is not known. */
export function recordedWell({ dataset, known, before }: Ended): number | null {
  const now = performerOf(known, dataset.name, dataset.performer);
  return !now || before === null ? null : Math.min(dataset.lines, Math.max(0, now.lines - before));
}

/** What a recording has brought, in sentences. */
export function endedSentences(ended: Ended): string[] {
  const { dataset, known } = ended;
  const well = recordedWell(ended);
  const now = performerOf(known, dataset.name, dataset.performer);
  const sentences = [];
  if (well !== null) {
    const left = dataset.lines - well;
    sentences.push(`${well} of ${lineCount(dataset.lines)} ${well === 1 ? "is" : "are"} recorded well.`);
    sentences.push(left === 0 ? "Nothing of this script is left." : `${lineCount(left)} ${left === 1 ? "is" : "are"} left, and asked for the next time.`);
  }
  if (now) sentences.push(`${dataset.performer} has ${lineCount(now.lines)} in “${dataset.name}” now, in ${now.takes} ${now.takes === 1 ? "take" : "takes"}.`);
  return sentences;
}

export class SummaryStep {
  readonly element = h("section", { class: "recorder-step", "aria-labelledby": "recorder-over" });
  private readonly title = h("h2", { id: "recorder-over", tabindex: -1 });
  private readonly error = h("div", { class: "recorder-error", role: "alert", hidden: true });
  private readonly reason = h("p", { class: "recorder-reason" });
  private readonly kept = h("p");
  private readonly lead = h("p", { class: "recorder-lead" });
  private readonly take = h("p");
  private readonly takeName = h("span", { class: "mono" });
  private readonly poor = h("ul", { class: "poor-list" });
  private readonly poorPart = h("section", { hidden: true });
  private shownPoor = "";

  constructor(watch: () => void, more: () => void, close: () => void) {
    this.error.append(this.reason, this.kept);
    this.poorPart.append(h("h3", { text: "These were poor" }), this.poor);
    this.take.append("The take is ", this.takeName, ".");
    this.element.append(
      this.title,
      this.error,
      this.lead,
      this.take,
      this.poorPart,
      h(
        "div",
        { class: "recorder-foot" },
        h("button", { type: "button", class: "button large", text: "Watch the take", onclick: watch }),
        h("button", { type: "button", class: "button large", text: "Record on", onclick: more }),
        h("button", { type: "button", class: "button large primary", text: "Close", onclick: close }),
      ),
    );
  }

  focus(): void {
    this.title.focus({ preventScroll: true });
  }

  update(ended: Ended): void {
    const { dataset, poor } = ended;
    const failed = dataset.error !== "";
    const well = recordedWell(ended);
    setText(this.title, failed ? "The recording ended early" : well === dataset.lines ? "All of it is recorded" : "Recorded");
    setHidden(this.error, !failed);
    setText(this.reason, dataset.error);
    setText(this.kept, "What was recorded until then is kept, and can be played and learnt from. Make room, or see to what is said above; then record on: only what is missing is asked for.");
    setText(this.lead, endedSentences(ended).join(" ") || "The take is being written …");
    setHidden(this.take, dataset.take === "");
    setText(this.takeName, `${dataset.name}/${dataset.take}`);
    const key = JSON.stringify(poor);
    setHidden(this.poorPart, poor.length === 0);
    if (key === this.shownPoor) return;
    this.shownPoor = key;
    this.poor.replaceChildren(...poor.map((line) => h("li", {}, h("span", { dir: "auto", lang: line.language || null, text: line.what }), h("span", { class: "quiet", text: line.poor.join("; ") }))));
  }
}
