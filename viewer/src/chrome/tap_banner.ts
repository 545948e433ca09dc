/** While a sensor waits to be tapped: which one, and how to stop. */
import type { Actions } from "../actions";
import { h, setHidden, setText } from "../dom";
import { sensorLabel } from "../format";
import type { Session } from "../session";

export class TapBanner {
  readonly element = h("div", { class: "tap-banner", role: "status", hidden: true });

  constructor(session: Session, actions: Actions) {
    const text = h("span");
    this.element.append(
      h("span", { class: "tap-pulse", "aria-hidden": "true" }),
      text,
      h("button", { type: "button", class: "button small", text: "Stop", onclick: () => void actions.stopTap() }),
    );
    session.status.listen((status) => {
      const tap = status?.tap ?? null;
      setHidden(this.element, tap === null);
      if (tap !== null) setText(text, `Tap the real sensor at ${sensorLabel(tap)}, two or three times.`);
    });
  }
}
