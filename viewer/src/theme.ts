/** Dark or light: as the system has it, or as the person chose. */
import { forgetInks } from "./ink";
import type { ViewState } from "./view_state";

export function applyTheme(view: ViewState): void {
  const changed = () => {
    forgetInks();
    view.colours.set(null);
  };
  view.theme.listen((choice) => {
    if (choice === "system") delete document.documentElement.dataset["theme"];
    else document.documentElement.dataset["theme"] = choice;
    changed();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", changed);
}
