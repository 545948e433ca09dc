/** The sensors as dots on the face, or over the lamps of what it wears: ordinary buttons laid over the picture, so that they can be focused, named and pressed. */
import { Quaternion, Vector3, type Mesh } from "three";
import { isCamera } from "../camera_words";
import { h, setAttribute, setText } from "../dom";
import { sensorLabel } from "../format";
import { healthOf, REPLAYED } from "../health";
import type { Link, RigSensor } from "../protocol";
import type { Avatar } from "./avatar";
import { isWorn, type Glasses } from "./glasses";
import { nearestVertices, normalAt, vertexAt } from "./skin_points";
import type { Place, Stage } from "./stage";

interface Dot {
  sensor: RigSensor;
  element: HTMLButtonElement;
  label: HTMLElement;
  mark: HTMLElement;
  vertex: number;
  x: number;
  y: number;
  shown: string;
}

export class SensorDots {
  readonly element = h("div", { class: "dots", role: "group", "aria-label": "Sensors on the face" });
  private dots: Dot[] = [];
  private avatar: Avatar | null = null;

  constructor(
    private readonly glasses: Glasses,
    private readonly choose: (sensor: string) => void,
  ) {}

  /** Makes a dot for each sensor of the rig that has a place; cameras have pictures instead. */
  setSensors(sensors: readonly RigSensor[]): void {
    this.element.replaceChildren();
    this.dots = sensors
      .filter((sensor) => sensor.position !== null && !isCamera(sensor))
      .map((sensor) => {
        const mark = h("span", { class: "dot-mark" });
        const label = h("span", { class: "dot-label", text: sensorLabel(sensor.name) });
        const element = h("button", { class: isWorn(sensor) ? "dot worn" : "dot", type: "button", onclick: () => this.choose(sensor.name) }, mark, label);
        this.element.append(element);
        return { sensor, element, label, mark, vertex: -1, x: NaN, y: NaN, shown: "" };
      });
    this.place();
  }

  /** The face on which they sit. On another than the built-in one: the same place relative to the part that moves. */
  setAvatar(avatar: Avatar | null): void {
    this.avatar = avatar;
    this.place();
  }

  /** `links` null: the face comes from no device, so the dots only show where its sensors sit. */
  setHealth(links: readonly Link[] | null, chosen: string | null, tapped: string | null): void {
    for (const dot of this.dots) {
      const state = links?.find((one) => one.sensor === dot.sensor.name)?.state ?? "unbound";
      const health = links ? healthOf(state) : REPLAYED;
      setAttribute(dot.element, "data-severity", health.severity);
      setAttribute(dot.element, "data-state", links ? state : REPLAYED.label);
      setAttribute(dot.element, "aria-label", `${sensorLabel(dot.sensor.name)}: ${health.label}`);
      setAttribute(dot.element, "aria-pressed", String(chosen === dot.sensor.name));
      dot.element.classList.toggle("tapped", tapped === dot.sensor.name);
      setText(dot.mark, health.mark);
    }
  }

  /** Lays the dots over the picture that has just been drawn. */
  update(stage: Stage, place: Place): void {
    const mesh = this.avatar?.face;
    for (const dot of this.dots) {
      if (!locate(dot, mesh ?? null, this.glasses)) {
        show(dot, "none");
        continue;
      }
      const facing = normal.dot(toCamera.copy(stage.camera.position).sub(point).normalize());
      stage.project(place, point);
      show(dot, facing > 0.12 ? "front" : facing > -0.25 ? "edge" : "behind");
      const x = Math.round(point.x * 2) / 2;
      const y = Math.round(point.y * 2) / 2;
      if (x !== dot.x || y !== dot.y) {
        dot.x = x;
        dot.y = y;
        dot.element.style.transform = `translate(${x}px, ${y}px)`;
      }
    }
  }

  private place(): void {
    const mesh = this.avatar?.face;
    if (!mesh) return;
    const places = this.dots.map((dot) => new Vector3(...(dot.sensor.position ?? [0, 0, 0])));
    this.avatar?.object.updateMatrixWorld(true);
    const vertices = nearestVertices(mesh, places);
    this.dots.forEach((dot, i) => {
      dot.vertex = isWorn(dot.sensor) ? -1 : (vertices[i] ?? -1);
    });
  }
}

const point = new Vector3();
const normal = new Vector3();
const toCamera = new Vector3();
const turn = new Quaternion();

/** Puts a dot's place and the direction out of the face there into `point` and `normal`; false where it has none. */
function locate(dot: Dot, mesh: Mesh | null, glasses: Glasses): boolean {
  const lamp = glasses.lampOf(dot.sensor.name);
  if (lamp) {
    lamp.getWorldPosition(point);
    const [x, y, z] = dot.sensor.aim ?? [0, 0, -1];
    normal.set(-x, -y, -z).applyQuaternion(lamp.getWorldQuaternion(turn));
    return true;
  }
  if (!mesh || dot.vertex < 0) return false;
  vertexAt(mesh, dot.vertex, point, true);
  normalAt(mesh, dot.vertex, normal);
  return true;
}

function show(dot: Dot, how: string): void {
  if (dot.shown === how) return;
  dot.shown = how;
  dot.element.dataset["seen"] = how;
  dot.element.tabIndex = how === "none" || how === "behind" ? -1 : 0;
}
