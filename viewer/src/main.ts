/** Puts the page together. */
import "uplot/dist/uPlot.min.css";
// In this order: of equally specific rules the last one counts.
import "./style/theme.css";
import "./style/layout.css";
import "./style/face.css";
import "./style/over_face.css";
import "./style/guide.css";
import "./style/dock.css";
import "./style/help.css";
import "./style/narrow.css";
import "./style/panels.css";
import "./style/panel_weights.css";
import "./style/panel_sensors.css";
import "./style/headset.css";
import "./style/panel_calibration.css";
import "./style/panel_takes.css";
import "./style/panel_output.css";
import "./style/recorder.css";
import "./style/teleprompter.css";
import { Actions } from "./actions";
import { ActionBar } from "./chrome/action_bar";
import { Dock } from "./chrome/dock";
import { CalibrationGuide } from "./chrome/guide";
import { makeHelp } from "./chrome/help";
import { PromptGuide } from "./chrome/prompts";
import { Notices } from "./chrome/notices";
import { TapBanner } from "./chrome/tap_banner";
import { Timeline } from "./chrome/timeline";
import { Topbar } from "./chrome/topbar";
import { Recording } from "./dataset/recording";
import { h, setHidden } from "./dom";
import { FaceView } from "./face_view";
import { listenKeys, type Key } from "./keys";
import { BrowserCamera } from "./browser_camera";
import { BrowserMicrophone } from "./microphone";
import { CalibrationPanel } from "./panels/calibration";
import { OutputPanel } from "./panels/output";
import { SensorsPanel } from "./panels/sensors";
import { TakesPanel } from "./panels/takes";
import { WeightsPanel } from "./panels/weights";
import { Session } from "./session";
import { applyTheme } from "./theme";
import { PANELS, ViewState } from "./view_state";

const session = new Session();
const view = new ViewState();
const actions = new Actions(session, view);

applyTheme(view);
const face = new FaceView(session, view);
const topbar = new Topbar(session, view);
const guide = new CalibrationGuide(session, actions);
const prompts = new PromptGuide(session, actions);
const timeline = new Timeline(session, actions);
const notices = new Notices(session, view);
const microphone = new BrowserMicrophone(session);
const recording = new Recording(session, actions, microphone, new BrowserCamera(session), notices.element);
const weights = new WeightsPanel(session, view, actions);
const actionBar = new ActionBar(session, view, actions, face);
const dock = new Dock(view, {
  weights: weights.element,
  sensors: new SensorsPanel(session, view, actions).element,
  calibration: new CalibrationPanel(session, actions).element,
  takes: new TakesPanel(session, actions, () => recording.open()).element,
  output: new OutputPanel(session, view, actions, microphone).element,
});

const bottom = h("div", { class: "bottom" }, guide.element, prompts.element, recording.strip, new TapBanner(session, actions).element, timeline.element, actionBar.element);
const stage = h("main", { class: "stage" }, face.element, topbar.element, topbar.badge, notices.element, bottom);
document.body.append(h("div", { class: "app" }, stage, dock.element), recording.element);

const TURN = 0.15;
const keys: Key[] = [
  { keys: ["r"], shown: "R", does: "Record, or stop", act: () => void actions.toggleRecording() },
  { keys: ["p"], shown: "P", does: "Record a dataset: lines to read, a teleprompter", act: () => recording.open() },
  { keys: ["c"], shown: "C", does: "Calibrate", act: () => void actions.calibrate("short") },
  { keys: [" "], shown: "Space", does: "Re-centre; in a replay, and where poses are asked for: pause or go on", act: () => void actions.space() },
  ...PANELS.map((panel, i) => ({
    keys: [String(i + 1)],
    shown: i === 0 ? "1 2 3 4 5" : "",
    does: "Weights, sensors, calibration, takes, output; the same key again closes",
    act: () => view.choose(panel),
  })),
  { keys: ["v"], shown: "V", does: "Camera to the front", act: () => face.resetView() },
  { keys: ["arrowleft"], shown: "← → ↑ ↓", does: "Camera about the face", act: () => face.orbit(-TURN, 0) },
  { keys: ["arrowright"], shown: "", does: "", act: () => face.orbit(TURN, 0) },
  { keys: ["arrowup"], shown: "", does: "", act: () => face.orbit(0, -TURN) },
  { keys: ["arrowdown"], shown: "", does: "", act: () => face.orbit(0, TURN) },
  { keys: ["d"], shown: "D", does: "Sensors on the face, or not", act: () => view.showDots.set(!view.showDots.value) },
  { keys: ["h"], shown: "H", does: "The head turns, or looks straight ahead", act: () => view.turnHead.set(!view.turnHead.value) },
  { keys: ["t"], shown: "T", does: "Truth beside capture, where it is known", act: () => view.showTruth.set(!view.showTruth.value) },
  { keys: ["f"], shown: "F", does: "Nothing but the face", act: () => view.bare.set(!view.bare.value) },
  { keys: ["?"], shown: "?", does: "This list", act: () => view.helpOpen.set(!view.helpOpen.value) },
  { keys: ["escape"], shown: "Esc", does: "Cancels or closes what is open", act: escape },
];
listenKeys(keys);
document.body.append(makeHelp(keys, view));

function escape(): void {
  if (view.helpOpen.value) view.helpOpen.set(false);
  else if (recording.isOpen) recording.escape();
  else if (view.bare.value) view.bare.set(false);
  else if (guide.open) guide.close();
  else if (session.status.value?.tap) void actions.stopTap();
  else if (view.sensor.value !== null) view.sensor.set(null);
  else notices.clear();
}

view.bare.listen((bare) => {
  document.documentElement.dataset["bare"] = String(bare);
  setHidden(dock.element, bare);
});

/** The face keeps clear of what lies over it; measured whenever something of it may have changed size. */
function keepClear(): void {
  const faces = recording.faces;
  if (faces) {
    const all = stage.getBoundingClientRect();
    face.cover({ top: faces.top - all.top, right: all.right - faces.right, bottom: all.bottom - faces.bottom, left: faces.left - all.left });
    return;
  }
  const bare = view.bare.value;
  const tight = stage.clientHeight < 520;
  face.cover({ top: bare ? 0 : tight ? 40 : 52, right: 0, bottom: bare ? 0 : Math.max(tight ? 52 : 64, bottom.offsetHeight), left: 0 });
}
new ResizeObserver(keepClear).observe(bottom);
new ResizeObserver(keepClear).observe(stage);
new ResizeObserver(keepClear).observe(recording.facesElement);
view.bare.listen(() => requestAnimationFrame(keepClear));

// What moves between messages is drawn at the display's rate, and only while there is news or a ring runs down.
let scheduled = false;
function schedule(): void {
  if (scheduled) return;
  scheduled = true;
  requestAnimationFrame((now) => {
    scheduled = false;
    if (!weights.element.hidden) weights.draw(now);
    if (guide.open) guide.draw(now);
    if (prompts.open) prompts.draw(now);
    if (recording.isOpen) recording.draw(now);
    if (guide.open || prompts.open || recording.isOpen) schedule();
  });
}
session.frame.listen(schedule);
session.status.listen(schedule);
view.panel.listen(schedule);

session.open();
