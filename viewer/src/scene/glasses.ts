/**
 * Glasses that carry sensors: a frame, and each sensor as a small lamp, coloured by its health, whose beam says where it looks
 * and how much light comes back. What hangs on the head follows it; the skin moves beneath.
 */
import {
  BufferAttribute, CatmullRomCurve3, Color, ConeGeometry, Group, Mesh, MeshBasicMaterial, MeshPhysicalMaterial,
  Quaternion, SphereGeometry, TubeGeometry, Vector3, type Object3D,
} from "three";
import { healthOf, type Severity } from "../health";
import type { Link, RigSensor } from "../protocol";
import { disposeTree } from "./avatar";
import { glassesShape } from "./glasses_shape";

/** Sensors of this kind sit on glasses and look at the skin. */
const WORN_KIND = "eyewear";

/** Radii, m. */
const RIM = 0.0013;
const ARM = 0.0015;
const LAMP = 0.0019;
/** A beam's length, m, and its half angle: what such a part lights. */
const BEAM = 0.011;
const SPREAD_DEG = 20;

/** As theme.css has them for dots on a face. */
const COLOURS: Readonly<Record<Severity, number>> = { good: 0x63c29b, warn: 0xefb34a, bad: 0xff7d6b, idle: 0x9a9894 };

interface Lamp {
  sensor: RigSensor;
  lamp: Mesh<SphereGeometry, MeshBasicMaterial>;
  beam: Mesh<ConeGeometry, MeshBasicMaterial> | null;
  state: string;
}

export function isWorn(sensor: RigSensor): boolean {
  return sensor.kind === WORN_KIND && sensor.position !== null;
}

export class Glasses {
  readonly object = new Group();
  private lamps: Lamp[] = [];

  /** Makes them anew for a rig's worn sensors; none, and there is nothing to see. */
  setSensors(sensors: readonly RigSensor[]): void {
    disposeTree(this.object);
    this.object.clear();
    this.lamps = [];
    const worn = sensors.filter(isWorn);
    if (worn.length === 0) return;
    const shape = glassesShape(worn.map((sensor) => new Vector3(...(sensor.position ?? [0, 0, 0]))));
    const plastic = new MeshPhysicalMaterial({ color: 0x1b1d20, roughness: 0.38, clearcoat: 0.7, clearcoatRoughness: 0.25 });
    for (const rim of shape.rims) this.object.add(tube(rim, RIM, true, plastic));
    for (const arm of shape.arms) this.object.add(tube(arm, ARM, false, plastic));
    const ball = new SphereGeometry(LAMP, 16, 12);
    const cone = beamGeometry();
    for (const sensor of worn) this.lamps.push(this.makeLamp(sensor, ball, cone));
  }

  /** Where a sensor is in the scene; null for one that is not worn. */
  lampOf(sensor: string): Object3D | null {
    return this.lamps.find((one) => one.sensor.name === sensor)?.lamp ?? null;
  }

  /** Colours lamps by health; beams shine by how much of their light comes back. True when something changed. */
  setHealth(links: readonly Link[]): boolean {
    let changed = false;
    for (const one of this.lamps) {
      const link = links.find((candidate) => candidate.sensor === one.sensor.name);
      const severity = healthOf(link?.state ?? "unbound").severity;
      const level = Math.round(20 * (link?.level ?? 0)) / 20;
      const state = `${severity} ${level}`;
      if (state === one.state) continue;
      changed = true;
      one.state = state;
      one.lamp.material.color.set(COLOURS[severity]);
      if (!one.beam) continue;
      // One that says nothing shines no light that is known of.
      one.beam.visible = severity === "good" || severity === "warn";
      one.beam.material.color.set(COLOURS[severity]);
      one.beam.material.opacity = 0.3 + 0.7 * level;
    }
    return changed;
  }

  dispose(): void {
    this.object.removeFromParent();
    disposeTree(this.object);
  }

  private makeLamp(sensor: RigSensor, ball: SphereGeometry, cone: ConeGeometry): Lamp {
    const lamp = new Mesh(ball, new MeshBasicMaterial({ color: COLOURS.idle, toneMapped: false }));
    lamp.position.set(...(sensor.position ?? [0, 0, 0]));
    this.object.add(lamp);
    if (!sensor.aim) return { sensor, lamp, beam: null, state: "" };
    const beam = new Mesh(
      cone,
      new MeshBasicMaterial({ color: COLOURS.idle, transparent: true, vertexColors: true, depthWrite: false, toneMapped: false, opacity: 0.3 }),
    );
    beam.quaternion.copy(new Quaternion().setFromUnitVectors(ALONG, new Vector3(...sensor.aim)));
    beam.renderOrder = 2;
    lamp.add(beam);
    return { sensor, lamp, beam, state: "" };
  }
}

const ALONG = new Vector3(0, 0, 1);

function tube(points: Vector3[], radius: number, closed: boolean, material: MeshPhysicalMaterial): Mesh {
  const curve = new CatmullRomCurve3(points, closed, "centripetal");
  const mesh = new Mesh(new TubeGeometry(curve, points.length * 2, radius, 10, closed), material);
  mesh.castShadow = true;
  mesh.receiveShadow = true;
  mesh.frustumCulled = false;
  return mesh;
}

/** From the origin along +Z, fading out. */
function beamGeometry(): ConeGeometry {
  const cone = new ConeGeometry(BEAM * Math.tan((SPREAD_DEG * Math.PI) / 180), BEAM, 20, 8, true);
  cone.rotateX(-Math.PI / 2);
  cone.translate(0, 0, BEAM / 2);
  const places = cone.attributes["position"];
  const colours = new Float32Array(4 * (places?.count ?? 0));
  const white = new Color(0xffffff);
  for (let v = 0; places && v < places.count; ++v) {
    const far = Math.min(1, Math.max(0, places.getZ(v) / BEAM));
    colours.set([white.r, white.g, white.b, 0.75 * (1 - far) ** 1.6], 4 * v);
  }
  cone.setAttribute("color", new BufferAttribute(colours, 4));
  return cone;
}
