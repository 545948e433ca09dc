/**
 * The face in the middle of the page: which head is shown, what it is told, what stands beside it, and how honest it looks.
 */
import type { CalibrationStatus } from "./calibration_protocol";
import { withToken } from "./connection";
import { h, setHidden, setText } from "./dom";
import { fixed } from "./format";
import { restingPose, type Pose } from "./playout";
import { isAsking, type PromptStatus } from "./prompt_protocol";
import type { Status } from "./protocol";
import type { Session } from "./session";
import { shapeLabel } from "./shapes";
import type { Avatar } from "./scene/avatar";
import { CameraViews } from "./scene/camera_views";
import { SkinDifference, weightsApart } from "./scene/difference";
import { SensorDots } from "./scene/dots";
import { acceptDrops, pickFile } from "./scene/drop";
import { Glasses } from "./scene/glasses";
import { Headset } from "./scene/headset";
import { loadAvatar, refusal } from "./scene/load_avatar";
import { dropPictures, loadPictures, type SkinPictures } from "./scene/skin_pictures";
import { Stage } from "./scene/stage";
import { Signal } from "./signal";
import type { ViewState } from "./view_state";

/** What is beside the captured face. */
type Second = "none" | "truth" | "target";

/** The error read-out is renewed this often, ms. */
const READOUT_MS = 250;
/** The example's face comes about within a few times this, ms. */
const EASE_MS = 130;

export class FaceView {
  readonly element = h("div", { class: "face-view" });
  /** The file that stands in for the session's face; null while it is the session's own. */
  readonly ownFile = new Signal<string | null>(null);
  readonly loading = new Signal<boolean>(true);

  private readonly stage: Stage | null;
  private readonly glasses = new Glasses();
  private readonly headset = new Headset();
  private readonly dots: SensorDots;
  private readonly cameras: CameraViews;
  private readonly left = h("div", { class: "face-label", hidden: true });
  private readonly right = h("div", { class: "face-label", hidden: true });
  private readonly nextLabel = h("span");
  private readonly nextFace = h("div", { class: "next-face", hidden: true }, this.nextLabel);
  private readonly difference = h("div", { class: "difference", hidden: true });
  private readonly veil = h(
    "div",
    { class: "drop-veil", hidden: true },
    h("p", { text: "Drop a .glb or .vrm to wear it" }),
    h("p", { class: "quiet", text: "It stays in this browser." }),
  );
  private readonly coming = h("div", { class: "face-coming", role: "status", text: "The face is coming …" });

  /** Whether the session's face may still come: not from one that is gone or refuses this page. */
  private awaited = true;
  /** A face's bytes are here, and are being made into one. */
  private reading = false;
  private bytes: { data: ArrayBuffer; name: string; own: boolean } | null = null;
  private first: Avatar | null = null;
  private second: Avatar | null = null;
  private secondWanted: Second = "none";
  private secondLoading = false;
  private skin: SkinDifference | null = null;
  /** Of the face that `bytes` are; null until they are wanted. */
  private pictures: Promise<SkinPictures | null> | null = null;
  private readonly pose = restingPose();
  private readonly truth = restingPose();
  private readonly target = restingPose();
  private readonly next = restingPose();
  private lastReadout = 0;
  private lastTargetMs = 0;

  constructor(
    private readonly session: Session,
    private readonly view: ViewState,
  ) {
    const choose = (sensor: string) => {
      view.sensor.set(view.sensor.value === sensor ? null : sensor);
      if (view.sensor.value) {
        view.panel.set("sensors");
        view.panelOpen.set(true);
      }
    };
    this.dots = new SensorDots(this.glasses, choose);
    this.cameras = new CameraViews(this.headset, choose);
    const host = h("div", { class: "stage-host" });
    this.element.append(host, this.dots.element, this.cameras.element, this.left, this.right, this.nextFace, this.difference, this.coming, this.veil);
    this.loading.listen(() => this.showComing());
    session.connection.listen(({ kind }) => {
      // While it tries again nothing is known yet: a refused page would promise its face at every try.
      if (kind === "open") this.awaited = true;
      if (kind === "lost") this.awaited = false;
      this.showComing();
    });
    this.stage = this.makeStage(host);
    if (!this.stage) return;

    this.stage.onDraw = (now) => this.draw(now);
    this.stage.onDrawn = () => this.afterDraw();
    this.stage.onQuality = () => this.setPlain();
    this.stage.onLost = () => this.view.say("The graphics card was lost. The face comes back with it; all else goes on.", "bad");
    session.frame.listen((frame) => {
      if (frame) this.cameras.setFrame(frame);
      this.stage?.wake();
    });
    session.picture.listen((picture) => {
      if (picture && view.showPictures.value && !session.status.value?.replay) this.cameras.show(picture);
    });
    view.showPictures.listen((shown) => {
      if (!shown) this.cameras.clear();
    });
    session.hello.listen((hello) => {
      if (!hello) return;
      this.glasses.setSensors(hello.sensors);
      this.dots.setSensors(hello.sensors);
      this.headset.setSensors(hello.sensors);
      this.cameras.setSensors(hello.sensors);
      this.refreshDots();
      if (!this.bytes || this.bytes.own) void this.loadOwn(hello.face);
    });
    session.status.listen(() => {
      this.refreshDots();
      this.chooseSecond();
    });
    view.sensor.listen(() => this.refreshDots());
    view.showTruth.listen(() => this.chooseSecond());
    view.turnHead.listen(() => this.stage?.wake());
    view.showDots.listen((shown) => {
      setHidden(this.dots.element, !shown);
      setHidden(this.cameras.element, !shown);
      this.glasses.object.visible = shown;
      this.headset.object.visible = shown;
      this.stage?.wake();
    });
    acceptDrops(
      (file) => void this.wear(file),
      (hanging) => setHidden(this.veil, !hanging),
    );
  }

  /** Whether there is a picture at all. */
  get drawn(): boolean {
    return this.stage !== null;
  }

  resetView(): void {
    this.stage?.resetView();
  }

  orbit(azimuth: number, polar: number): void {
    this.stage?.orbit(azimuth, polar);
  }

  cover(margins: { top: number; right: number; bottom: number; left: number }): void {
    this.stage?.cover(margins);
  }

  pick(): void {
    pickFile((file) => void this.wear(file));
  }

  /** Shows a file of the person's own instead of the session's face. */
  async wear(file: File): Promise<void> {
    const why = refusal(file.name, file.size);
    if (why) {
      this.view.say(why, "bad");
      return;
    }
    const data = await file.arrayBuffer();
    if (await this.show({ data, name: file.name, own: false })) {
      this.ownFile.set(file.name);
      this.view.say(`${file.name}: ${this.first?.known ?? 0} of 53 shapes.`, "good");
    }
  }

  /** Back to the session's face. */
  async wearOwn(): Promise<void> {
    this.ownFile.set(null);
    this.bytes = null;
    await this.loadOwn(this.session.hello.value?.face ?? "/face.glb");
  }

  private makeStage(host: HTMLElement): Stage | null {
    try {
      return new Stage(
        host,
        () => matchMedia("(prefers-reduced-motion: reduce)").matches,
        new URLSearchParams(window.location.search).get("quality"),
      );
    } catch {
      this.loading.set(false);
      host.append(
        h(
          "div",
          { class: "no-webgl", role: "alert" },
          h("h2", { text: "No 3D here" }),
          h("p", { text: "This browser gives no WebGL 2, so the face cannot be drawn. Weights, sensors and all else work." }),
        ),
      );
      return null;
    }
  }

  private showComing(): void {
    setHidden(this.coming, !this.loading.value || !(this.awaited || this.reading));
  }

  private async loadOwn(path: string): Promise<void> {
    const url = withToken(path, window.location);
    if (url.origin !== window.location.origin) return;
    try {
      const answer = await fetch(url);
      if (!answer.ok) throw new Error(`The session did not give its face (${answer.status}).`);
      const data = await answer.arrayBuffer();
      if (this.bytes?.own && same(this.bytes.data, data)) return;
      await this.show({ data, name: "the session's face", own: true });
    } catch (error) {
      this.loading.set(false);
      this.view.say(error instanceof Error ? error.message : String(error), "bad");
    }
  }

  private async show(bytes: { data: ArrayBuffer; name: string; own: boolean }): Promise<boolean> {
    if (!this.stage) return false;
    this.reading = true;
    this.loading.set(true);
    try {
      const avatar = await loadAvatar(bytes.data, bytes.name, bytes.own);
      this.bytes = bytes;
      this.dropSecond();
      this.forgetPictures();
      this.glasses.object.removeFromParent();
      this.headset.object.removeFromParent();
      this.first?.dispose();
      this.first = avatar;
      avatar.worn.add(this.glasses.object, this.headset.object);
      this.skin = null;
      this.setPlain();
      this.stage.put("first", avatar.object);
      void avatar.settled?.then(() => this.stage?.wake());
      this.dots.setAvatar(avatar);
      this.chooseSecond();
      return true;
    } catch (error) {
      this.view.say(error instanceof Error ? error.message : String(error), "bad");
      return false;
    } finally {
      this.reading = false;
      this.loading.set(false);
    }
  }

  private setPlain(): void {
    const plain = this.stage?.plain ?? false;
    for (const avatar of [this.first, this.second]) {
      if (avatar && !(plain && avatar.setPlain)) this.stage?.lightRoom();
      avatar?.setPlain?.(plain);
      if (avatar) void avatar.settled?.then(() => this.bringPictures(avatar));
    }
  }

  /** Fetches them once the face is seen, and only for a look that shows them. */
  private async bringPictures(avatar: Avatar): Promise<void> {
    const paths = avatar.pictures;
    if (!paths || !avatar.wearPictures || (this.stage?.plain ?? true)) return;
    this.pictures ??= loadPictures(paths, (path) => withToken(path, window.location)).catch((error: unknown) => {
      this.view.say(error instanceof Error ? error.message : String(error), "bad");
      return null;
    });
    const wanted = this.pictures;
    const pictures = await wanted;
    // The next face, or the next change of the look, tries again.
    if (!pictures && this.pictures === wanted) this.pictures = null;
    if (!pictures || wanted !== this.pictures || (avatar !== this.first && avatar !== this.second)) return;
    avatar.wearPictures(pictures);
    this.stage?.wake();
  }

  private forgetPictures(): void {
    const known = this.pictures;
    this.pictures = null;
    this.first?.wearPictures?.(null);
    void known?.then((pictures) => pictures && dropPictures(pictures));
  }

  private dropSecond(): void {
    this.stage?.put("second", null);
    this.second?.dispose();
    this.second = null;
  }

  private refreshDots(): void {
    const status = this.session.status.value;
    const links = status?.replay ? null : (status?.links ?? []);
    this.dots.setHealth(links, this.view.sensor.value, status?.tap ?? null);
    this.cameras.setHealth(links, this.view.sensor.value);
    if (!links) this.cameras.clear();
    const coloured = [this.glasses.setHealth(links ?? []), this.headset.setHealth(links ?? [])];
    if (coloured.includes(true)) this.stage?.wake();
  }

  private chooseSecond(): void {
    const status = this.session.status.value;
    const guided = status?.calibration.state === "running";
    const prompts = guided ? null : promptsOf(status);
    const posed = prompts?.target != null;
    const nextPose = posed && prompts.next?.target ? prompts.next : null;
    const shown = posed || (guided && (status.calibration.target !== null || isMotion(status.calibration)));
    const truth = !guided && !posed && status?.replay?.hasTruth === true && this.view.showTruth.value;
    this.secondWanted = shown ? "target" : truth ? "truth" : "none";
    setText(this.left, !shown ? "Truth" : prompts && prompts.state !== "running" ? "Get ready" : "Do this");
    setText(this.right, shown ? "You" : "Capture");
    this.stage?.setInset(nextPose ? () => this.poseNext() : null);
    setHidden(this.nextFace, !nextPose);
    setText(this.nextLabel, nextPose ? `Next: ${nextPose.name}` : "");
    setHidden(this.left, this.secondWanted === "none");
    setHidden(this.right, this.secondWanted === "none");
    setHidden(this.difference, this.secondWanted !== "truth");
    this.element.dataset["second"] = this.secondWanted;
    void this.bringSecond();
    this.stage?.wake();
  }

  private async bringSecond(): Promise<void> {
    if (!this.stage || !this.first || !this.bytes) return;
    if (this.secondWanted === "none") {
      this.stage.put("second", null);
      return;
    }
    if (!this.second && !this.secondLoading) {
      this.secondLoading = true;
      const bytes = this.bytes;
      try {
        const avatar = await loadAvatar(bytes.data, bytes.name, bytes.own);
        if (this.bytes === bytes) {
          this.second = avatar;
          this.setPlain();
        }
        else avatar.dispose();
      } catch {
        // The same bytes made the first one: this can only be a lack of memory, and one face is enough.
      } finally {
        this.secondLoading = false;
      }
    }
    // What is wanted may have changed meanwhile; a status comes five times a second and asks again.
    if (this.second) this.stage.put("second", this.secondNow() === "none" ? null : this.second.object);
  }

  private secondNow(): Second {
    return this.secondWanted;
  }

  private draw(now: number): boolean {
    let more = this.session.playout.pose(now, this.pose, this.truth);
    if (!this.view.turnHead.value) still(this.pose), still(this.truth);
    this.first?.apply(this.pose);
    const seen = this.session.frame.value;
    this.headset.look(this.pose.eyes, seen && seen.eyesProvenance !== "n" ? seen.eyesConfidence : null);
    if (this.second && this.secondWanted === "truth") this.second.apply(this.truth);
    if (this.second && this.secondWanted === "target") {
      more = this.poseTarget(now) || more;
      this.second.apply(this.target);
    }
    return more;
  }

  /** Eases the example into the face that is asked for, or lets it nod and shake as is asked. True while it moves. */
  private poseTarget(now: number): boolean {
    const status = this.session.status.value;
    const calibration = status?.calibration;
    const asked = calibration?.state === "running" ? calibration.target : promptsOf(status)?.target;
    const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
    // By the clock, so that a slow display eases as fast as a quick one.
    const ease = calm ? 1 : 1 - Math.exp(-Math.min(200, now - this.lastTargetMs) / EASE_MS);
    this.lastTargetMs = now;
    let moving = false;
    for (let k = 0; k < this.target.weights.length; ++k) {
      const wanted = asked?.[k] ?? 0;
      const before = this.target.weights[k] ?? 0;
      const after = before + (wanted - before) * ease;
      this.target.weights[k] = after;
      if (Math.abs(after - wanted) > 1e-3) moving = true;
    }
    // A nod begins downwards; a turn by a positive angle about +X bows the head, one about +Y turns it to its left.
    const angle = calm ? 0 : 0.3 * Math.sin(now / 420);
    const half = angle / 2;
    const nods = calibration?.step === "nod";
    const shakes = calibration?.step === "shake";
    this.target.head = [Math.cos(half), nods ? Math.sin(half) : 0, shakes ? Math.sin(half) : 0, 0];
    if (!nods && !shakes) this.target.head = [1, 0, 0, 0];
    return moving || nods || shakes;
  }

  /** The example, for the small picture of what comes next. */
  private poseNext(): void {
    const next = promptsOf(this.session.status.value)?.next;
    for (let k = 0; k < this.next.weights.length; ++k) this.next.weights[k] = next?.target?.[k] ?? 0;
    this.second?.apply(this.next);
  }

  private afterDraw(): void {
    if (!this.stage) return;
    this.dots.update(this.stage, "first");
    this.cameras.update(this.stage, "first");
    if (this.secondWanted === "none") return;
    for (const [label, place] of [[this.left, "second"], [this.right, "first"]] as const) {
      const rect = this.stage.rectOf(place);
      label.style.transform = `translate(${Math.round(rect.left + rect.width / 2)}px, ${Math.round(rect.top + 8)}px) translateX(-50%)`;
    }
    const inset = this.stage.insetRect();
    Object.assign(this.nextFace.style, { left: `${inset.left}px`, top: `${inset.top}px`, width: `${inset.width}px`, height: `${inset.height}px` });
    const now = performance.now();
    if (this.secondWanted === "truth" && now - this.lastReadout > READOUT_MS) {
      this.lastReadout = now;
      this.readOut();
    }
  }

  private readOut(): void {
    const frame = this.session.playout.newest;
    const mesh = this.first?.face;
    if (!frame?.truth || !mesh) {
      setText(this.difference, "");
      return;
    }
    mesh.updateWorldMatrix(true, false);
    this.skin ??= new SkinDifference(mesh, mesh.matrixWorld.getMaxScaleOnAxis());
    const apart = this.skin.between(frame.weights, frame.truth);
    const { mean, furthest } = weightsApart(frame.weights, frame.truth);
    const figures: [string, string][] = [
      [fixed(apart?.meanMm ?? null, 2), "mm of skin, mean"],
      [fixed(apart?.maxMm ?? null, 1), "mm, worst place"],
      [fixed(mean, 3), "weight, mean"],
      [furthest === null ? "No shape" : shapeLabel(furthest), furthest === null ? "off" : "furthest off"],
    ];
    if (this.difference.childElementCount !== figures.length) {
      this.difference.replaceChildren(
        ...figures.map(() => h("div", {}, h("span", { class: "figure" }), h("span", { class: "quiet" }))),
      );
    }
    figures.forEach(([figure, unit], i) => {
      const cell = this.difference.children[i];
      if (cell?.firstElementChild) setText(cell.firstElementChild, figure);
      if (cell?.lastElementChild) setText(cell.lastElementChild, unit);
    });
  }
}

/** What is asked for; null when nothing is any more, and before a block, when nobody is to do it yet. */
function promptsOf(status: Status | null | undefined): PromptStatus | null {
  return isAsking(status?.prompts) && status.prompts.state !== "block" ? status.prompts : null;
}

function isMotion(calibration: CalibrationStatus): boolean {
  return calibration.step === "nod" || calibration.step === "shake";
}

function still(pose: Pose): void {
  pose.head = [1, 0, 0, 0];
}

function same(a: ArrayBuffer, b: ArrayBuffer): boolean {
  if (a.byteLength !== b.byteLength) return false;
  const left = new Uint8Array(a);
  const right = new Uint8Array(b);
  return left.every((value, i) => value === right[i]);
}
