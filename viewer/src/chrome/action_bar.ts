/** The buttons below the face. */
import type { Actions } from "../actions";
import { h, setAttribute, setHidden, setText } from "../dom";
import type { FaceView } from "../face_view";
import { clock } from "../format";
import { calibrateIcon, recentreIcon, recordIcon, stopIcon, viewIcon } from "../icons";
import type { Session } from "../session";
import type { Signal } from "../signal";
import type { ViewState } from "../view_state";

export class ActionBar {
  readonly element = h("div", { class: "action-bar", role: "toolbar", "aria-label": "Session" });

  constructor(session: Session, view: ViewState, actions: Actions, face: FaceView) {
    const recordText = h("span", { text: "Record" });
    const record = h("button", { type: "button", class: "action record", onclick: () => void actions.toggleRecording() }, recordIcon(), recordText);
    const calibrate = h("button", { type: "button", class: "action", onclick: () => void actions.calibrate("short") }, calibrateIcon(), h("span", { text: "Calibrate" }));
    const recentre = h("button", { type: "button", class: "action", onclick: () => void actions.recentre() }, recentreIcon(), h("span", { text: "Re-centre" }));
    this.element.append(record, calibrate, recentre, this.makeMenu(view, face));

    let wasOn = false;
    session.status.listen((status) => {
      const on = status?.recording.on ?? false;
      if (on !== wasOn) {
        wasOn = on;
        record.replaceChildren(on ? stopIcon() : recordIcon(), recordText);
      }
      record.classList.toggle("on", on);
      setAttribute(record, "aria-label", on ? "Stop recording" : "Record");
      const ends = status?.recording.endsS;
      setText(recordText, on ? clock(status?.recording.seconds ?? 0) + (ends == null ? "" : ` of ${clock(ends)}`) : "Record");
      calibrate.disabled = status?.calibration.state === "running" || status?.replay != null;
      recentre.disabled = status?.replay != null;
      const advised = !recentre.disabled && status?.calibration.state === "done" && status.calibration.advisesRecentring;
      recentre.classList.toggle("advised", advised);
      setAttribute(recentre, "title", advised ? "Your sensors have drifted. Relax your face and press Space." : null);
    });
    const enable = () => {
      for (const button of [record, calibrate, recentre]) button.classList.toggle("away", !session.connected);
    };
    session.connection.listen(enable);
  }

  /** What is shown, and whose face. */
  private makeMenu(view: ViewState, face: FaceView): HTMLElement {
    const own = h("button", { type: "button", class: "menu-item", hidden: true, onclick: () => void face.wearOwn() }, h("span", { text: "The session's face again" }));
    face.ownFile.listen((name) => setHidden(own, name === null));
    const menu = h(
      "div",
      { class: "menu", hidden: true },
      tick("Sensors on the face", "D", view.showDots),
      tick("The head turns", "H", view.turnHead),
      tick("Truth beside capture", "T", view.showTruth),
      h("hr"),
      item("Camera to the front", "V", () => face.resetView()),
      item("Nothing but the face", "F", () => view.bare.set(true)),
      h("hr"),
      item("Wear a .glb or .vrm…", "", () => face.pick()),
      own,
    );
    const button = h(
      "button",
      { type: "button", class: "action", "aria-haspopup": "true", "aria-expanded": "false" },
      viewIcon(),
      h("span", { text: "View" }),
    );
    const open = (yes: boolean) => {
      setHidden(menu, !yes);
      button.setAttribute("aria-expanded", String(yes));
    };
    button.addEventListener("click", () => open(menu.hidden));
    menu.addEventListener("click", (event) => {
      if ((event.target as Element).closest(".menu-item:not([role=menuitemcheckbox])")) open(false);
    });
    const whole = h("div", { class: "menu-holder" }, button, menu);
    document.addEventListener("pointerdown", (event) => {
      if (!whole.contains(event.target as Node)) open(false);
    });
    whole.addEventListener("keydown", (event) => {
      if (event.key === "Escape" && !menu.hidden) {
        event.preventDefault();
        event.stopPropagation();
        open(false);
        button.focus();
      }
    });
    return whole;
  }
}

function item(label: string, key: string, act: () => void): HTMLElement {
  return h("button", { type: "button", class: "menu-item", onclick: act }, h("span", { text: label }), key !== "" && h("kbd", { text: key }));
}

function tick(label: string, key: string, signal: Signal<boolean>): HTMLElement {
  const button = h(
    "button",
    { type: "button", class: "menu-item", role: "menuitemcheckbox", onclick: () => signal.set(!signal.value) },
    h("span", { text: label }),
    h("kbd", { text: key }),
  );
  signal.listen((on) => button.setAttribute("aria-checked", String(on)));
  return button;
}

