/** What the person at the page has chosen: kept while the page is open, and what is a habit also beyond. */
import { Signal } from "./signal";
import { shapeIndex } from "./shapes";

export const PANELS = ["weights", "sensors", "calibration", "takes", "output"] as const;
export type Panel = (typeof PANELS)[number];
export type ThemeChoice = "system" | "light" | "dark";

function remembered<T extends string>(key: string, among: readonly T[], otherwise: T): Signal<T> {
  let first = otherwise;
  try {
    const kept = localStorage.getItem(`mien.${key}`) as T | null;
    if (kept !== null && among.includes(kept)) first = kept;
  } catch {
    // A browser that keeps nothing: begin as always.
  }
  const signal = new Signal<T>(first);
  signal.listen((value) => {
    try {
      localStorage.setItem(`mien.${key}`, value);
    } catch {
      // As above.
    }
  });
  return signal;
}

export class ViewState {
  readonly theme = remembered<ThemeChoice>("theme", ["system", "light", "dark"], "system");
  /** Set when all colours have changed, by our switch or by the system's. */
  readonly colours = new Signal<null>(null);
  readonly panel = remembered<Panel>("panel", PANELS, "weights");
  readonly panelOpen = new Signal<boolean>(true);
  /** The shapes in the plot. */
  readonly plotted = new Signal<readonly number[]>([shapeIndex("jawOpen"), shapeIndex("mouthSmile_L"), shapeIndex("eyeBlink_L")]);
  /** The sensor that is looked at. */
  readonly sensor = new Signal<string | null>(null);
  readonly showDots = new Signal<boolean>(true);
  /** What a headset's cameras see: never without being asked for anew. */
  readonly showPictures = new Signal<boolean>(false);
  readonly turnHead = new Signal<boolean>(true);
  readonly showTruth = new Signal<boolean>(true);
  /** Nothing but the face. */
  readonly bare = new Signal<boolean>(false);
  readonly helpOpen = new Signal<boolean>(false);
  /** Texts for a moment, for what was asked from this page. */
  readonly notices = new Signal<{ text: string; tone: "plain" | "good" | "bad" } | null>(null);

  say(text: string, tone: "plain" | "good" | "bad" = "plain"): void {
    this.notices.set({ text, tone });
  }

  choose(panel: Panel): void {
    const same = this.panel.value === panel;
    this.panelOpen.set(same ? !this.panelOpen.value : true);
    this.panel.set(panel);
  }
}
