/** A camera's view by buttons: which part of its pictures the network sees, how it is turned, and that its rig keeps it. */
import type { Actions } from "../actions";
import { h, setHidden, setText } from "../dom";
import { describe, moved, turned, zoomed, type PictureView } from "../picture_view";
import type { Link, ViewChange } from "../protocol";

export class CameraView {
  readonly element = h("section", { class: "camera-buttons", hidden: true });
  private readonly what = h("p", { class: "quiet" });
  private sensor = "";
  private view: PictureView | null = null;

  constructor(private readonly actions: Actions) {
    const button = (name: string, text: string, does: (view: PictureView) => void) =>
      h("button", { type: "button", class: "button small", text, "aria-label": name, title: name, onclick: () => this.view && does(this.view) });
    const move = (name: string, text: string, right: number, down: number) =>
      button(name, text, (view) => this.change({ crop: moved(view, right, down) }));
    this.element.append(
      h("h4", { text: "What the network sees" }),
      this.what,
      h(
        "div",
        { class: "button-row" },
        button("Turn", "Turn", (view) => this.change({ turn_deg: turned(view) })),
        button("Mirror", "Mirror", (view) => this.change({ mirror: !view.mirror })),
        button("Closer", "Closer", (view) => this.change({ crop: zoomed(view, true) })),
        button("Wider", "Wider", (view) => this.change({ crop: zoomed(view, false) })),
      ),
      h(
        "div",
        { class: "button-row" },
        move("Look more to the left", "←", -1, 0),
        move("Look higher", "↑", 0, -1),
        move("Look lower", "↓", 0, 1),
        move("Look more to the right", "→", 1, 0),
        h("button", { type: "button", class: "button small", text: "Save to rig", onclick: () => void this.actions.saveRig() }),
      ),
      h("p", { class: "quiet", text: "Calibrate again when it is right. It lasts until the session ends, unless it is saved." }),
    );
  }

  /** Hidden for what is no camera. */
  update(link: Link): void {
    this.sensor = link.sensor;
    this.view = link.view;
    setHidden(this.element, link.view === null);
    if (link.view) setText(this.what, describe(link.view));
  }

  private change(to: ViewChange): void {
    void this.actions.changeView(this.sensor, to);
  }
}
