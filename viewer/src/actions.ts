/** What buttons and keys do: one place for both, so that they do the same. */
import type { CalibrationKind } from "./calibration_protocol";
import { type DatasetList, type DatasetWish, readDatasetList } from "./dataset_protocol";
import { type Pairing, readPairing } from "./network_protocol";
import { isAsking, type PromptDeed } from "./prompt_protocol";
import type { Command, Reply, ViewChange } from "./protocol";
import type { Session } from "./session";
import type { ViewState } from "./view_state";

/** The session reports a switch five times a second; what was just asked of it counts until then, this long, ms. */
const REPORTED_MS = 1000;

/** A switch of the session's, as it will be once it has done what was asked. */
class Switch {
  private asked: boolean | null = null;
  private presses = 0;

  /** The other way round than it stands or was asked to stand. */
  flip(reported: boolean): boolean {
    this.asked = !(this.asked ?? reported);
    return this.asked;
  }

  /** Before the command of a press goes out. What it gives wants the reply; after that what is reported counts again. */
  press(): (reply: Reply) => void {
    const press = ++this.presses;
    const forget = () => {
      if (press === this.presses) this.asked = null;
    };
    return (reply) => {
      if (reply.ok) window.setTimeout(forget, REPORTED_MS);
      else forget();
    };
  }
}

export class Actions {
  private readonly recording = new Switch();
  private readonly pause = new Switch();
  private readonly prompts = new Switch();

  constructor(
    private readonly session: Session,
    private readonly view: ViewState,
  ) {}

  /** Sends a command and says what went wrong, if anything did. */
  async send(command: Command): Promise<Reply> {
    const reply = await this.session.send(command);
    if (!reply.ok) this.view.say(reply.error || `The session refused: ${command.command}.`, "bad");
    return reply;
  }

  async toggleRecording(name = ""): Promise<void> {
    const on = this.recording.flip(this.session.status.value?.recording.on ?? false);
    const settle = this.recording.press();
    const reply = await this.send({ command: "record", on, name });
    settle(reply);
    if (reply.ok && !on) void this.session.refreshTakes();
  }

  async calibrate(kind: CalibrationKind = "short"): Promise<void> {
    if (this.session.status.value?.calibration.state === "running") return;
    await this.send({ command: "calibrate", kind });
  }

  /** Two guided minutes before the phone, from which the session learns the wearer. */
  async learnFromPhone(): Promise<void> {
    await this.send({ command: "learn_phone", do: "begin" });
  }

  async cancelLesson(): Promise<void> {
    await this.send({ command: "learn_phone", do: "cancel" });
  }

  async cancelCalibration(): Promise<void> {
    await this.send({ command: "cancel_calibration" });
  }

  /** What the cameras see is shown on this page from now on, or no more. */
  async showPictures(on: boolean): Promise<void> {
    // Hidden at once; shown when the session says yes.
    if (!on) this.view.showPictures.set(false);
    const reply = await this.send({ command: "pictures", on });
    if (reply.ok) this.view.showPictures.set(on);
  }

  async recentre(): Promise<void> {
    const reply = await this.send({ command: "recentre" });
    if (reply.ok) this.view.say("Hold a neutral face: it becomes the new neutral.", "good");
  }

  async togglePause(): Promise<void> {
    const replay = this.session.status.value?.replay;
    if (!replay) return;
    const paused = this.pause.flip(replay.paused);
    const settle = this.pause.press();
    settle(await this.send({ command: "replay", paused }));
  }

  /** In a replay the space bar pauses, and where poses are asked for; else it re-centres. */
  async space(): Promise<void> {
    const status = this.session.status.value;
    if (status?.replay) await this.togglePause();
    else if (isAsking(status?.prompts) && status.prompts.state !== "block") await this.togglePrompts();
    else await this.recentre();
  }

  /** The poses of a recording wait, or go on with the one that was interrupted. */
  async togglePrompts(): Promise<void> {
    const prompts = this.session.status.value?.prompts;
    if (!prompts || prompts.state === "over") return;
    const paused = this.prompts.flip(prompts.state === "paused");
    const settle = this.prompts.press();
    settle(await this.send({ command: "prompts", do: paused ? "pause" : "resume" }));
  }

  async skipPrompt(): Promise<void> {
    await this.steerPrompts("skip");
  }

  async steerPrompts(deed: PromptDeed): Promise<void> {
    await this.send({ command: "prompts", do: deed });
  }

  /** Which datasets there are, and what can be recorded for one. Null: refused, and that is said. */
  async listDatasets(): Promise<DatasetList | null> {
    const reply = await this.send({ command: "dataset", list: true });
    return reply.ok ? readDatasetList(reply.result) : null;
  }

  /** Never without an agreement: the type has no other. What stands against it is for who asked to say. */
  async beginDataset(begin: DatasetWish): Promise<Reply> {
    return await this.session.send({ command: "dataset", begin });
  }

  async endDataset(): Promise<boolean> {
    return (await this.send({ command: "dataset", end: true })).ok;
  }

  async playTake(take: string, dataset: string): Promise<boolean> {
    return (await this.send({ command: "replay", take, dataset })).ok;
  }

  async seek(seconds: number): Promise<void> {
    await this.send({ command: "replay", seek: Math.max(0, seconds) });
  }

  /** The next device that is tapped is bound to this sensor; the same again stops waiting. */
  async tap(sensor: string): Promise<void> {
    const waiting = this.session.status.value?.tap === sensor;
    await this.send({ command: "tap", sensor: waiting ? "" : sensor });
  }

  /** The next camera whose lens is covered is bound to this sensor; the same again stops waiting. */
  async cover(sensor: string): Promise<void> {
    const waiting = this.session.status.value?.cover.sensor === sensor;
    await this.send({ command: "cover", sensor: waiting ? "" : sensor });
  }

  async changeView(sensor: string, to: ViewChange): Promise<void> {
    await this.send({ command: "view", sensor, ...to });
  }

  /** What of its pictures the network sees of each camera becomes the rig file's. */
  async saveRig(): Promise<void> {
    const reply = await this.send({ command: "save_rig" });
    const file = reply.result?.["rig"];
    if (reply.ok) this.view.say(`Saved to ${typeof file === "string" ? file : "the rig"}.`, "good");
  }

  async bind(sensor: string, device: string): Promise<void> {
    await this.send({ command: "bind", sensor, device });
  }

  /** Of those who send as this sensor's device this one is heard. */
  async hear(sensor: string, source: string): Promise<void> {
    await this.send({ command: "hear", sensor, source });
  }

  /** The ports on every interface receive what comes in there alone; empty: everything again. */
  async listenOnly(only: string): Promise<void> {
    await this.send({ command: "listen", only });
  }

  /** The key for boards, made where there is none. Null: refused, and that is said. */
  async pair(): Promise<Pairing | null> {
    const reply = await this.send({ command: "pair" });
    return reply.ok ? readPairing(reply.result) : null;
  }

  async stopTap(): Promise<void> {
    await this.send({ command: "tap", sensor: "" });
  }

  async stopCover(): Promise<void> {
    await this.send({ command: "cover", sensor: "" });
  }
}
