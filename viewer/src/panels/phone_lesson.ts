/** Learning the wearer from a phone: two guided minutes, and no phone afterwards. */
import type { Actions } from "../actions";
import { h, setAttribute, setHidden, setText } from "../dom";
import type { PhoneLesson } from "../lesson_protocol";
import type { Status } from "../protocol";
import type { Session } from "../session";

const HOW =
  "Two minutes: expressions, texts to read, and what you like, before the phone. Its face is held against what the sensors on your skin say; what that improves where it was not learnt is used from then on, without the phone. An earlier version undoes it.";

export class PhoneLessonSection {
  readonly element = h("section", { class: "phone-lesson", hidden: true });
  private readonly sentence = h("p", { "aria-live": "polite" });
  private readonly run = h("div", { class: "level-run" });
  private readonly bar = h("div", { class: "level", hidden: true, role: "progressbar", "aria-label": "Learnt of what was recorded", "aria-valuemin": 0, "aria-valuemax": 100 }, this.run);
  private readonly begin: HTMLButtonElement;
  private readonly cancel: HTMLButtonElement;
  private truths: readonly string[] = [];

  constructor(session: Session, actions: Actions) {
    this.begin = h("button", { type: "button", class: "button", onclick: () => void actions.learnFromPhone() }, "Learn with the phone");
    this.cancel = h("button", { type: "button", class: "button", hidden: true, onclick: () => void actions.cancelLesson() }, "Cancel");
    this.element.append(h("h3", { text: "A phone" }), h("p", { class: "quiet", text: HOW }), this.sentence, this.bar, h("div", { class: "button-row" }, this.begin, this.cancel));
    session.hello.listen((hello) => {
      this.truths = (hello?.sensors ?? []).filter((sensor) => sensor.role === "truth").map((sensor) => sensor.name);
      setHidden(this.element, this.truths.length === 0);
    });
    session.status.listen((status) => this.update(status));
  }

  private update(status: Status | null): void {
    if (!status) return;
    const lesson = status.phoneLesson;
    const runs = lesson?.state === "recording" || lesson?.state === "learning";
    const calibrated = status.calibration.versions.some((one) => one.inForce);
    const seen = status.links.some((link) => this.truths.includes(link.sensor) && (link.state === "good" || link.state === "late"));
    this.begin.disabled = runs || !calibrated || !seen || status.recording.on || status.replay !== null;
    setHidden(this.cancel, lesson?.state !== "recording");
    setHidden(this.bar, lesson?.state !== "learning");
    setAttribute(this.bar, "aria-valuenow", String(Math.round(100 * (lesson?.learnt ?? 0))));
    this.run.style.transform = `scaleX(${lesson?.learnt ?? 0})`;
    setText(this.sentence, this.say(lesson, calibrated, seen));
  }

  private say(lesson: PhoneLesson | null, calibrated: boolean, seen: boolean): string {
    if (lesson?.state === "recording") return "Do what is asked for, with your face before the phone.";
    if (lesson?.state === "learning") return "Learning from what was recorded: ten seconds or so, longer on a busy machine. The face goes on moving meanwhile.";
    if (!calibrated) return "Calibrate first.";
    if (!seen) return "The phone sees no face now. Hold it before you, and see to the light.";
    return asSentence(lesson?.sentence ?? "");
  }
}

/** The session's words begin small and have no full stop: they stand in lists and logs, too. */
function asSentence(words: string): string {
  return words === "" ? "" : `${words[0]?.toUpperCase()}${words.slice(1)}.`;
}
