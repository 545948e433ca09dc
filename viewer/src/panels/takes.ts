/** Recording a take, and the takes that can be played. */
import type { Actions } from "../actions";
import { h, KeyedList, setAttribute, setHidden, setText } from "../dom";
import { clock, fixed } from "../format";
import type { Take } from "../protocol";
import type { Session } from "../session";

export class TakesPanel {
  readonly element = h("div", { class: "panel takes-panel" });
  private readonly name = h("input", {
    type: "text", class: "field", placeholder: "Name, if you like", "aria-label": "Name of the take", maxlength: 80, spellcheck: "false", autocomplete: "off",
  });
  private readonly record = h("button", { type: "button", class: "button record" });
  private readonly about = h("p", { class: "summary" });
  private readonly room = h("p", { class: "quiet", hidden: true });
  private readonly error = h("p", { class: "error", role: "alert", hidden: true });

  /** `recordDataset` opens what asks a performer for lines. */
  constructor(session: Session, actions: Actions, recordDataset: () => void) {
    const list = h("ul", { class: "takes" });
    const empty = h("p", { class: "quiet", text: "No takes yet. What you record appears here; a dataset's takes are in its folder (mien dataset lists them)." });
    const refresh = h("button", { type: "button", class: "text-button", text: "Look again", onclick: () => void session.refreshTakes() });
    this.element.append(
      this.about,
      this.room,
      this.error,
      h("form", { class: "button-row", onsubmit: (event: Event) => {
        event.preventDefault();
        void actions.toggleRecording(this.name.value.trim());
      } }, this.name, this.record),
      h(
        "div",
        { class: "dataset-entry" },
        h("button", { type: "button", class: "button", text: "Record a dataset…", onclick: recordDataset }),
        h("p", { class: "quiet", text: "A performer reads lines from this page, before a phone if there is one." }),
      ),
      h("div", { class: "section-head" }, h("h3", { text: "Takes" }), refresh),
      list,
      empty,
    );
    this.record.type = "submit";
    const rows = new KeyedList<ListedTake, TakeRow>(list, (take) => take.name, (take) => new TakeRow(take, actions));
    let growing: string | null = null;
    const drawTakes = () => {
      const takes = session.takes.value;
      rows.update(takes.map((take) => ({ ...take, growing: take.name === growing })));
      setHidden(empty, takes.length > 0);
    };
    session.takes.listen(drawTakes);
    session.status.listen((status) => {
      if (!status) return;
      const { recording, replay, log } = status;
      const now = growingTake(recording);
      if (now !== growing) {
        growing = now;
        drawTakes();
      }
      setText(this.record, recording.on ? "Stop" : "Record");
      this.record.classList.toggle("on", recording.on);
      this.name.disabled = recording.on;
      setText(
        this.about,
        recording.on
          ? `Recording ${recording.path}: ${clock(recording.seconds)}, ${fixed(recording.megabytes, 1)} MB.`
          : "A take keeps all that the sensors said, so it can be played, measured and solved again.",
      );
      setText(this.room, log.hoursLeft === null ? "" : `The session's log has room for ${fixed(log.hoursLeft, 1)} h more.`);
      setHidden(this.room, log.hoursLeft === null);
      const error = recording.error || log.error;
      setText(this.error, error);
      setHidden(this.error, error === "");
      for (const row of list.children) row.classList.toggle("playing", row instanceof HTMLElement && row.dataset["take"] === replay?.take);
    });
  }
}

/** The name, in the list of takes, of the one that is being recorded; null while none is. */
export function growingTake(recording: { on: boolean; path: string }): string | null {
  if (!recording.on) return null;
  return recording.path.split(/[/\\]/).pop() || null;
}

/** What the list says of a take; not how long one that grows was when the list was made: the line above knows better. */
export function takeFacts(take: ListedTake): string {
  if (take.growing) return "being recorded";
  const parts = [
    take.error !== "" ? "cannot be read" : take.seconds === null ? "" : clock(take.seconds),
    take.megabytes === null ? "" : `${fixed(take.megabytes, 1)} MB`,
    recordedAt(take.recorded),
  ];
  return parts.filter((part) => part !== "").join(" · ");
}

interface ListedTake extends Take {
  growing: boolean;
}

class TakeRow {
  readonly element: HTMLElement;
  private readonly about = h("span", { class: "quiet" });
  private readonly play: HTMLButtonElement;

  constructor(take: Take, actions: Actions) {
    this.play = h("button", {
      type: "button", class: "button small", "aria-label": `Play ${take.name}`, text: "Play",
      onclick: () => void actions.send({ command: "replay", take: take.name }),
    });
    this.element = h(
      "li",
      { class: "take", "data-take": take.name },
      h("div", {}, h("strong", { text: take.name.replace(/\.mien$/, "") }), this.about),
      this.play,
    );
  }

  update(take: ListedTake): void {
    setText(this.about, takeFacts(take));
    this.play.disabled = take.growing;
    setAttribute(this.play, "title", take.growing ? "It can be played once it is written." : null);
    this.about.title = take.error;
  }
}

function recordedAt(text: string): string {
  const date = new Date(text);
  if (text === "" || Number.isNaN(date.getTime())) return text;
  return date.toLocaleString(undefined, { day: "numeric", month: "short", hour: "2-digit", minute: "2-digit" });
}
