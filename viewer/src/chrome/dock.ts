/** The panels beside the face (below it on a phone), behind tabs. */
import { h, setAttribute, setHidden } from "../dom";
import { calibrateIcon, outputIcon, sensorsIcon, takesIcon, weightsIcon } from "../icons";
import { PANELS, type Panel, type ViewState } from "../view_state";

const TITLES: Readonly<Record<Panel, string>> = {
  weights: "Weights", sensors: "Sensors", calibration: "Calibration", takes: "Takes", output: "Output",
};
const ICONS: Readonly<Record<Panel, () => SVGElement>> = {
  weights: weightsIcon, sensors: sensorsIcon, calibration: calibrateIcon, takes: takesIcon, output: outputIcon,
};

export class Dock {
  readonly element = h("aside", { class: "dock", "aria-label": "Panels" });

  constructor(view: ViewState, panels: Readonly<Record<Panel, HTMLElement>>) {
    const tabs = h("div", { class: "tabs", role: "tablist" });
    const body = h("div", { class: "dock-body" });
    const buttons = PANELS.map((name, i) => {
      const button = h(
        "button",
        {
          type: "button", role: "tab", id: `tab-${name}`, "aria-controls": `panel-${name}`, title: `${TITLES[name]} (${i + 1})`,
          onclick: () => view.choose(name),
        },
        ICONS[name](),
        h("span", { text: TITLES[name] }),
      );
      const panel = panels[name];
      panel.id = `panel-${name}`;
      panel.setAttribute("role", "tabpanel");
      panel.setAttribute("aria-labelledby", button.id);
      body.append(panel);
      tabs.append(button);
      return button;
    });
    tabs.addEventListener("keydown", (event) => {
      const step = event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0;
      if (step === 0) return;
      event.preventDefault();
      const at = (PANELS.indexOf(view.panel.value) + step + PANELS.length) % PANELS.length;
      view.panel.set(PANELS[at] ?? "weights");
      view.panelOpen.set(true);
      buttons[at]?.focus();
    });
    this.element.append(tabs, body);
    const show = () => {
      const open = view.panelOpen.value;
      PANELS.forEach((name, i) => {
        const chosen = open && view.panel.value === name;
        const button = buttons[i];
        if (button) {
          setAttribute(button, "aria-selected", String(chosen));
          button.tabIndex = view.panel.value === name ? 0 : -1;
        }
        setHidden(panels[name], !chosen);
      });
      document.documentElement.dataset["panel"] = open ? "open" : "closed";
    };
    view.panel.listen(show);
    view.panelOpen.listen(show);
  }
}
