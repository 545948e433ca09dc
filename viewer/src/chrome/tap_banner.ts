/** While a sensor waits to be tapped, or a camera's lens to be covered: which one, and how to stop. */
import type { Actions } from "../actions";
import { h, setHidden, setText } from "../dom";
import { sensorLabel } from "../format";
import type { Session } from "../session";

export class TapBanner {
  readonly element = h("div", { class: "tap-banner", role: "status", hidden: true });

  constructor(session: Session, actions: Actions) {
    const text = h("span");
    let covers = false;
    this.element.append(
      h("span", { class: "tap-pulse", "aria-hidden": "true" }),
      text,
      h("button", { type: "button", class: "button small", text: "Stop", onclick: () => void (covers ? actions.stopCover() : actions.stopTap()) }),
    );
    session.status.listen((status) => {
      const tap = status?.tap ?? null;
      const cover = status?.cover.sensor ?? null;
      covers = cover !== null;
      setHidden(this.element, tap === null && cover === null);
      if (cover !== null) setText(text, `Cover this camera's lens with a finger: ${sensorLabel(cover)}. Hold it for a second.`);
      else if (tap !== null) setText(text, `Tap the real sensor at ${sensorLabel(tap)}, two or three times.`);
    });
  }
}
