/** A headset: whether this page shows what its cameras see, where each half of the face comes from, and how far the eyes are open. */
import type { Actions } from "../actions";
import { HALVES, isCamera, opennessOf, originOf } from "../camera_words";
import { h, setAttribute, setHidden, setText } from "../dom";
import type { Session } from "../session";
import type { ViewState } from "../view_state";

const EYES = ["Left eye", "Right eye"] as const;

export class HeadsetSection {
  readonly element = h("section", { class: "headset", hidden: true });
  private readonly show = h("button", { type: "button", class: "button", "aria-pressed": "false" });
  private readonly note = h("p", { class: "quiet" });
  private readonly origins = HALVES.map(({ name }) => ({ name, word: h("dd") }));
  private readonly openness = EYES.map((name) => {
    const run = h("div", { class: "level-run" });
    return { name, run, bar: h("div", { class: "level", role: "meter", "aria-label": `${name}, open`, "aria-valuemin": "0", "aria-valuemax": "100" }, run) };
  });

  constructor(
    private readonly session: Session,
    private readonly view: ViewState,
    actions: Actions,
  ) {
    this.show.addEventListener("click", () => void actions.showPictures(!view.showPictures.value));
    this.element.append(
      h("h3", { text: "Headset" }),
      h("div", { class: "button-row" }, this.show),
      this.note,
      h(
        "dl",
        { class: "headset-facts" },
        ...this.origins.map(({ name, word }) => h("div", {}, h("dt", { text: name }), word)),
        ...this.openness.map(({ name, bar }) => h("div", {}, h("dt", { text: `${name} open` }), h("dd", {}, bar))),
      ),
    );
    session.hello.listen((hello) => setHidden(this.element, !hello?.sensors.some(isCamera)));
    // A connection that broke took the wish with it.
    session.hello.listen((hello) => {
      if (hello && view.showPictures.value) void actions.showPictures(true);
    });
    session.status.listen(() => this.updateButton());
    view.showPictures.listen(() => this.updateButton());
    session.frame.listen(() => this.updateFace());
    view.panel.listen(() => this.updateFace());
  }

  private updateButton(): void {
    const shown = this.view.showPictures.value;
    const pictures = this.session.status.value?.pictures ?? null;
    setText(this.show, shown ? "Hide pictures" : "Show pictures");
    setAttribute(this.show, "aria-pressed", String(shown));
    this.show.disabled = pictures === null && !shown;
    const others = Math.max(0, (pictures?.watchers ?? 0) - (shown ? 1 : 0));
    setText(
      this.note,
      pictures === null
        ? "No camera is asked for its pictures. Start the session with --listen http://HOST:PORT/."
        : others > 0
          ? `${others === 1 ? "Another page is" : `${others} other pages are`} shown what the cameras see.`
          : "Pictures of a face are shown only where they are asked for, and kept nowhere by that.",
    );
  }

  private updateFace(): void {
    const frame = this.session.frame.value;
    if (!frame || this.element.hidden || this.view.panel.value !== "sensors") return;
    HALVES.forEach(({ half }, i) => {
      const origin = originOf(frame.provenance, half);
      const word = this.origins[i]?.word;
      if (!word) return;
      setText(word, origin.word);
      setAttribute(word, "data-prov", origin.letter);
    });
    opennessOf(frame).forEach((open, i) => {
      const eye = this.openness[i];
      if (!eye) return;
      eye.run.style.transform = `scaleX(${open.toFixed(2)})`;
      setAttribute(eye.bar, "aria-valuenow", String(Math.round(100 * open)));
    });
  }
}
