/** The page that says which key does what. */
import { h } from "../dom";
import type { Key } from "../keys";
import type { ViewState } from "../view_state";

export function makeHelp(keys: readonly Key[], view: ViewState): HTMLDialogElement {
  const rows = keys.filter((key) => key.shown !== "").map((key) =>
    h("div", {}, h("dt", {}, ...key.shown.split(" ").map((one) => h("kbd", { text: one }))), h("dd", { text: key.does })),
  );
  const dialog: HTMLDialogElement = h(
    "dialog",
    {
      class: "help",
      "aria-labelledby": "help-title",
      onclose: () => {
        view.helpOpen.set(false);
        // Some browsers leave the focus on its button, which nobody sees any more and which takes the space bar.
        if (dialog.contains(document.activeElement)) (document.activeElement as HTMLElement).blur();
      },
    },
    h(
      "form",
      { method: "dialog" },
      h("div", { class: "section-head" }, h("h2", { id: "help-title", text: "Keys" }), h("button", { class: "text-button", text: "Close" })),
      h("dl", { class: "keys" }, ...rows),
      h("p", {
        class: "quiet",
        text: "Drag the face to look from another side, scroll to come closer. Drop a .glb or .vrm anywhere to wear it. Press a bar to see it over time, and a dot on the face to see to its sensor.",
      }),
    ),
  );
  view.helpOpen.listen((open) => {
    if (open && !dialog.open) dialog.showModal();
    else if (!open && dialog.open) dialog.close();
  });
  return dialog;
}
