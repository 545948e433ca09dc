/**
 * What a headset has on the face: each camera where it sits, coloured by its health, and a ray from each eye along which it
 * looks. What hangs on the head follows it.
 */
import {
  CylinderGeometry, Group, Mesh, MeshBasicMaterial, MeshPhysicalMaterial, TorusGeometry, Vector3, type Object3D,
} from "three";
import { isCamera } from "../camera_words";
import { healthOf, type Severity } from "../health";
import type { Link, RigSensor } from "../protocol";
import { disposeTree } from "./avatar";

/** Radii and lengths of a camera's body and its lens, m. */
const BODY = 0.0047;
const BODY_LENGTH = 0.005;
const LENS = 0.0026;
const LENS_LENGTH = 0.009;

/** The left eyeball's middle on the built-in face, m, frame H; the right one is its mirror image. */
const EYE = new Vector3(0.031, 0.036, 0.0845);
/** A ray begins before the cornea, so far from the middle of the ball, and is so long, m. */
const RAY_FROM = 0.016;
const RAY_LENGTH = 0.085;
const RAY_RADIUS = 0.0009;
/** At its end a ring: of a ray that points at whoever looks on, it is all that is seen. m. */
const RING_RADIUS = 0.0042;
const RING_WIDTH = 0.0007;

/** As theme.css has them for dots on a face. */
const COLOURS: Readonly<Record<Severity, number>> = { good: 0x63c29b, warn: 0xefb34a, bad: 0xff7d6b, idle: 0x9a9894 };
const RAY_COLOUR = 0x1f7fd6;

const ALONG = new Vector3(0, 0, 1);

interface Body {
  sensor: RigSensor;
  object: Object3D;
  lens: Mesh<CylinderGeometry, MeshBasicMaterial>;
}

/** Where an eye looks: yaw to the performer's left, pitch up, radians. */
export function gazeDirection(yaw: number, pitch: number, out = new Vector3()): Vector3 {
  return out.set(Math.sin(yaw) * Math.cos(pitch), Math.sin(pitch), Math.cos(yaw) * Math.cos(pitch));
}

export class Headset {
  readonly object = new Group();
  private bodies: Body[] = [];
  private rays: Mesh<CylinderGeometry, MeshBasicMaterial>[] = [];

  /** Makes it anew for a rig's cameras; none, and there is nothing to see. */
  setSensors(sensors: readonly RigSensor[]): void {
    disposeTree(this.object);
    this.object.clear();
    const cameras = sensors.filter(isCamera);
    this.bodies = cameras.map((sensor) => this.makeBody(sensor));
    this.rays = cameras.length > 0 ? [1, -1].map((side) => this.makeRay(side)) : [];
  }

  /** Where a camera is in the scene; null for what is none. */
  cameraOf(sensor: string): Object3D | null {
    return this.bodies.find((one) => one.sensor.name === sensor)?.object ?? null;
  }

  /** Colours the lenses. True when something changed. */
  setHealth(links: readonly Link[]): boolean {
    let changed = false;
    for (const { sensor, lens } of this.bodies) {
      const colour = COLOURS[healthOf(links.find((one) => one.sensor === sensor.name)?.state ?? "unbound").severity];
      if (lens.material.color.getHex() === colour) continue;
      lens.material.color.set(colour);
      changed = true;
    }
    return changed;
  }

  /** Turns the rays: angles as in a frame. `confidence`, 0 to 1, dims them; null: where the eyes look is not known. */
  look(eyes: readonly [number, number, number, number], confidence: number | null): void {
    this.rays.forEach((ray, i) => {
      ray.visible = confidence !== null;
      ray.material.opacity = 0.3 + 0.7 * (confidence ?? 0);
      ray.quaternion.setFromUnitVectors(ALONG, gazeDirection(eyes[2 * i] ?? 0, eyes[2 * i + 1] ?? 0, direction));
    });
  }

  private makeBody(sensor: RigSensor): Body {
    const object = new Group();
    object.position.set(...(sensor.position ?? [0, 0, 0]));
    object.quaternion.setFromUnitVectors(ALONG, new Vector3(...(sensor.aim ?? [0, 0, -1])));
    const plastic = new MeshPhysicalMaterial({ color: 0x1b1d20, roughness: 0.38, clearcoat: 0.7, clearcoatRoughness: 0.25 });
    const lens = new Mesh(tube(LENS, LENS_LENGTH), new MeshBasicMaterial({ color: COLOURS.idle, toneMapped: false }));
    // Through the body, so that its colour is seen from behind the headset too.
    lens.position.z = 0.001;
    object.add(new Mesh(tube(BODY, BODY_LENGTH), plastic), lens);
    this.object.add(object);
    return { sensor, object, lens };
  }

  private makeRay(side: number): Mesh<CylinderGeometry, MeshBasicMaterial> {
    const stick = tube(RAY_RADIUS, RAY_LENGTH);
    stick.translate(0, 0, RAY_FROM + RAY_LENGTH / 2);
    const ray = new Mesh(stick, new MeshBasicMaterial({ color: RAY_COLOUR, transparent: true, depthWrite: false, toneMapped: false }));
    const ring = new Mesh(new TorusGeometry(RING_RADIUS, RING_WIDTH, 8, 32), ray.material);
    ring.position.z = RAY_FROM + RAY_LENGTH;
    ray.add(ring);
    ray.position.set(side * EYE.x, EYE.y, EYE.z);
    ray.visible = false;
    this.object.add(ray);
    return ray;
  }
}

/** Along +Z, its middle at the origin. */
function tube(radius: number, length: number): CylinderGeometry {
  return new CylinderGeometry(radius, radius, length, 24).rotateX(Math.PI / 2);
}

const direction = new Vector3();
