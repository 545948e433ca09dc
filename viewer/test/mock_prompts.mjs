// What the mock session asks a performer for, one after the other: poses of a plain recording, or lines of a script's blocks.

/** Before the first, and after a pause, s. */
const LEAD_IN = 3;
/** In its first moments what is shown has hardly begun, s. */
const HARDLY_BEGUN = 1;

export const POSES = [
  { name: "neutral", say: "Look ahead, relax your face and hold still", seconds: 10, target: {} },
  { name: "brows up", say: "Raise your eyebrows", seconds: 3, target: { browInnerUp_L: 1, browInnerUp_R: 1, browOuterUp_L: 1, browOuterUp_R: 1, eyeWide_L: 0.3, eyeWide_R: 0.3 } },
  { name: "smile", say: "Smile as wide as you can", seconds: 3, target: { mouthSmile_L: 1, mouthSmile_R: 1, cheekSquint_L: 0.5, cheekSquint_R: 0.5 } },
  { name: "pucker", say: "Pucker your lips, as for a kiss", seconds: 3, target: { mouthPucker: 1 } },
  { name: "jaw open", say: "Open your mouth wide", seconds: 3, target: { jawOpen: 1 } },
];

export class MockPrompts {
  at = 0;
  seconds = -LEAD_IN;
  paused = false;
  /** The block that was begun last. */
  begun = "";
  /** What was poor with the line that was over last. */
  poor = [];
  /** What will be poor, by a line's name: a list of sentences for each attempt. */
  faults = {};
  /** Names of lines that were good. */
  well = new Set();

  constructor(prompts) {
    this.prompts = [...prompts];
  }

  get present() {
    return this.prompts[this.at];
  }

  get state() {
    if (!this.present) return "over";
    return this.paused ? "paused" : this.waits ? "block" : this.seconds < 0 ? "ready" : "running";
  }

  /** All lines that are asked for again wait together. */
  block(prompt) {
    return (prompt.attempt ?? 1) > 1 ? "again" : (prompt.block ?? "");
  }

  get waits() {
    const block = this.block(this.present);
    return block !== "" && block !== this.begun;
  }

  obey(what) {
    if (!this.present) throw new Error("no pose is being asked for");
    if (what === "skip") this.go(1);
    else if (what === "stop") this.at = this.prompts.length;
    else if (what === "begin") this.begin();
    else if (what === "next") this.next();
    else if (what === "again") this.repeat();
    else Object.assign(this, { paused: what === "pause", seconds: -LEAD_IN });
  }

  go(by, seconds = 0) {
    this.at += by;
    this.seconds = seconds;
  }

  begin() {
    if (!this.waits) throw new Error("no block waits to be begun");
    this.begun = this.block(this.present);
    this.seconds = -LEAD_IN;
  }

  next() {
    if (this.state !== "running" || !this.present.own_pace) throw new Error("nothing is shown at your own pace");
    this.finish();
  }

  repeat() {
    const before = this.prompts[this.at - 1];
    const hardly = this.state !== "running" || this.seconds < HARDLY_BEGUN;
    this.go(hardly && before && this.block(before) === this.block(this.present) ? -1 : 0, -HARDLY_BEGUN);
  }

  finish() {
    const line = this.present;
    this.poor = line.block ? (this.faults[line.name]?.shift() ?? []) : [];
    if (this.poor.length === 0) this.well.add(line.name);
    else if ((line.attempt ?? 1) < 3) this.prompts.push({ ...line, attempt: (line.attempt ?? 1) + 1 });
    this.go(1);
  }

  advance(seconds) {
    if (!this.present || this.paused || this.waits) return;
    this.seconds += seconds;
    if (!this.present.own_pace && this.seconds >= this.present.seconds) this.finish();
  }

  status() {
    const of = this.prompts.length;
    const prompt = this.present;
    const rest = { poor: this.poor, of };
    if (!prompt) return { ...rest, state: "over", name: "", say: "", text: "", block: "", emotion: "", language: "", own_pace: false, attempt: 1, again: 0, target: null, next: null, number: of, progress: 0, remaining_s: 0, left_s: 0 };
    const later = this.prompts.slice(this.at + 1);
    const [next] = later;
    const left = Math.max(0, prompt.seconds - this.seconds);
    return {
      ...rest, state: this.state, name: prompt.name, say: prompt.say ?? "", text: prompt.text ?? "", block: prompt.block ?? "", emotion: prompt.emotion ?? "", language: prompt.language ?? "",
      own_pace: prompt.own_pace === true, attempt: prompt.attempt ?? 1, again: later.filter((one) => (one.attempt ?? 1) > 1).length, target: prompt.target ?? {},
      next: next ? { name: next.name, text: next.text ?? "", target: next.target ?? {} } : null, number: this.at + 1,
      progress: Math.min(1, Math.max(0, this.seconds / prompt.seconds)), remaining_s: this.seconds < 0 ? -this.seconds : left,
      left_s: later.reduce((sum, one) => sum + one.seconds, left),
    };
  }
}
