/**
 * What a headset's cameras see, a small picture each, laid over the picture of the face beside what it looks at: the frame's
 * colour is the camera's health, and what is little known by it is dim. Ordinary buttons, as the sensors' dots are.
 */
import { Vector3 } from "three";
import { brightnessOf, confidenceOf, isCamera, shapesSeen } from "../camera_words";
import { h, setAttribute, setHidden, setText, svg } from "../dom";
import { sensorLabel } from "../format";
import { healthOf, REPLAYED } from "../health";
import type { CameraPicture } from "../picture_protocol";
import type { Frame, Link, RigSensor } from "../protocol";
import type { Headset } from "./headset";
import type { Place, Rect, Stage } from "./stage";

/** Beside the built-in face, m, frame H: by what stands there a picture keeps clear of it. */
const BESIDE = 0.135;
const EYE_HEIGHT = 0.045;
const MOUTH_HEIGHT = -0.045;
const DEPTH = 0.07;

/** Of a camera in these states the last picture is not of now. */
const GONE: readonly string[] = ["lost", "silent", "unbound"];

/** Every machine that has a browser has its lowest byte first. */
const OPAQUE = 0xff000000;

interface View {
  sensor: RigSensor;
  /** Its number in `hello`. */
  number: number;
  seen: readonly number[];
  element: HTMLButtonElement;
  canvas: HTMLCanvasElement;
  mark: HTMLElement;
  line: SVGElement;
  /** A picture came, and is of now. */
  pictured: boolean;
  anchor: Vector3;
}

/** The left and upper edge of a box of this size whose middle should be at (x, y), and which must stay within `rect`. */
export function keepWithin(rect: Rect, x: number, y: number, width: number, height: number): { left: number; top: number } {
  const within = (middle: number, size: number, from: number, room: number) =>
    Math.max(from, Math.min(from + room - size, middle - size / 2));
  return { left: within(x, width, rect.left, rect.width), top: within(y, height, rect.top, rect.height) };
}

/** Where beside the face a camera's picture hangs, frame H, m. */
export function anchorOf(sensor: Pick<RigSensor, "site" | "side">): Vector3 {
  const side = sensor.side === "R" ? -1 : 1;
  return new Vector3(side * BESIDE, sensor.site === "mouth" ? MOUTH_HEIGHT : EYE_HEIGHT, DEPTH);
}

export class CameraViews {
  private readonly lines = svg("svg", { class: "camera-lines", "aria-hidden": "true" });
  private readonly list = h("div", { class: "camera-list", role: "group", "aria-label": "Cameras of the headset" });
  readonly element = h("div", { class: "camera-views" }, this.list);
  private views: View[] = [];

  constructor(
    private readonly headset: Headset,
    private readonly choose: (sensor: string) => void,
  ) {
    this.element.prepend(this.lines);
  }

  setSensors(sensors: readonly RigSensor[]): void {
    this.list.replaceChildren();
    this.lines.replaceChildren();
    this.views = sensors.flatMap((sensor, number) => (isCamera(sensor) ? [this.make(sensor, number)] : []));
  }

  /** `links` null: the face comes from no device. */
  setHealth(links: readonly Link[] | null, chosen: string | null): void {
    for (const view of this.views) {
      const state = links?.find((one) => one.sensor === view.sensor.name)?.state ?? "unbound";
      const health = links ? healthOf(state) : REPLAYED;
      for (const element of [view.element, view.line]) setAttribute(element, "data-severity", health.severity);
      setAttribute(view.element, "data-state", links ? state : REPLAYED.label);
      setAttribute(view.element, "aria-label", `${sensorLabel(view.sensor.name)}: ${health.label}`);
      setAttribute(view.element, "aria-pressed", String(chosen === view.sensor.name));
      setText(view.mark, health.mark);
      if (view.pictured && GONE.includes(state)) this.blank(view);
    }
  }

  /** Dims what is little known. */
  setFrame(frame: Frame): void {
    for (const view of this.views) {
      view.canvas.style.opacity = brightnessOf(confidenceOf(view.seen, frame)).toFixed(2);
    }
  }

  show(picture: CameraPicture): void {
    const view = this.views.find((one) => one.number === picture.sensor);
    const pen = view?.canvas.getContext("2d");
    if (!view || !pen) return;
    if (view.canvas.width !== picture.width || view.canvas.height !== picture.height) {
      view.canvas.width = picture.width;
      view.canvas.height = picture.height;
    }
    const image = pen.createImageData(picture.width, picture.height);
    // Four bytes at once: a picture is shown ten times a second of every camera.
    const words = new Uint32Array(image.data.buffer);
    for (let i = 0; i < words.length; ++i) words[i] = OPAQUE | ((picture.pixels[i] ?? 0) * 0x010101);
    pen.putImageData(image, 0, 0);
    this.setPictured(view, true);
  }

  /** No picture is shown any more, nor kept. */
  clear(): void {
    for (const view of this.views) this.blank(view);
  }

  /** Lays them over the picture that has just been drawn. */
  update(stage: Stage, place: Place): void {
    if (this.views.length === 0) return;
    const rect = stage.rectOf(place);
    for (const view of this.views) {
      const camera = this.headset.cameraOf(view.sensor.name);
      if (!camera) continue;
      const { offsetWidth, offsetHeight } = view.element;
      stage.project(place, this.headset.object.localToWorld(point.copy(view.anchor)));
      const { left, top } = keepWithin(rect, point.x, point.y, offsetWidth, offsetHeight);
      view.element.style.transform = `translate(${Math.round(left)}px, ${Math.round(top)}px)`;
      stage.project(place, camera.getWorldPosition(point));
      const ends = { x1: point.x, y1: point.y, x2: left + offsetWidth / 2, y2: top + offsetHeight / 2 };
      for (const [name, value] of Object.entries(ends)) setAttribute(view.line, name, value.toFixed(0));
    }
  }

  private make(sensor: RigSensor, number: number): View {
    const canvas = h("canvas", { width: 96, height: 96, hidden: true });
    const mark = h("span", { class: "camera-mark" });
    const element = h(
      "button",
      { type: "button", class: "camera-view", onclick: () => this.choose(sensor.name) },
      canvas,
      h("span", { class: "camera-name" }, mark, h("span", { text: sensorLabel(sensor.name) })),
    );
    const line = svg("line", { class: "camera-line" });
    this.list.append(element);
    this.lines.append(line);
    return { sensor, number, seen: shapesSeen(sensor), element, canvas, mark, line, pictured: false, anchor: anchorOf(sensor) };
  }

  private blank(view: View): void {
    view.canvas.getContext("2d")?.clearRect(0, 0, view.canvas.width, view.canvas.height);
    this.setPictured(view, false);
  }

  private setPictured(view: View, pictured: boolean): void {
    view.pictured = pictured;
    setHidden(view.canvas, !pictured);
    setAttribute(view.element, "data-pictured", String(pictured));
  }
}

const point = new Vector3();
