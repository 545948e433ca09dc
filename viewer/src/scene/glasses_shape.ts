/**
 * The lines of a pair of glasses that carries sensors: rims that pass by those before the eyes, a bridge, temples, and hooks
 * about the ears that reach those at the jaw. Metres, frame H: +X the performer's left, +Y up, +Z out of the face.
 */
import { Box3, CatmullRomCurve3, Vector3 } from "three";

export interface GlassesShape {
  /** Closed, one a side. */
  rims: Vector3[][];
  /** Open: a bridge, two temples, and a hook a side that has sensors behind the front. */
  arms: Vector3[][];
}

/** Sensors this far behind the foremost are no part of the front, m. */
const FRONT_DEPTH = 0.045;
/** Points of a rim. */
const RIM_POINTS = 96;
/** How stiffly a rim keeps to an ellipse where few sensors tell its shape. */
const STIFFNESS = 0.35;
/** Sensors nearer to each other than this tell no rim's shape, m. */
const LEAST_HALF = 0.008;
/** A rim that no sensor tells of, on the performer's left. */
const PLAIN_RIM = { centre: new Vector3(0.037, 0.036, 0.104), width: 0.0235, height: 0.0205, wrap: 0.007 };
/** The way of the left temple over the built-in head: beside the eye, over the ear, behind it. */
const HINGE = new Vector3(0.0745, 0.0445, 0.082);
const OVER_EAR = new Vector3(0.0805, 0.0455, 0.004);
const BEHIND_EAR = [new Vector3(0.079, 0.038, -0.014), new Vector3(0.0765, 0.014, -0.025)];

export function glassesShape(places: readonly Vector3[]): GlassesShape {
  const front = Math.max(...places.map((place) => place.z)) - FRONT_DEPTH;
  const rims: Vector3[][] = [];
  const arms: Vector3[][] = [];
  const inner: Vector3[] = [];
  for (const side of [1, -1]) {
    const own = places.filter((place) => place.x * side > 0);
    const rim = rimThrough(own.filter((place) => place.z >= front), side);
    rims.push(rim);
    const high = rim.filter((point) => point.y > middle(rim).y);
    inner.push(extreme(high, (point) => -Math.abs(point.x)));
    const temple = smooth([
      extreme(high, (point) => Math.abs(point.x)), mirrored(HINGE, side), mirrored(OVER_EAR, side),
      ...BEHIND_EAR.map((point) => mirrored(point, side)),
    ]);
    arms.push(temple);
    const behind = own.filter((place) => place.z < front).sort((a, b) => b.y - a.y);
    if (behind.length > 0) arms.push(hook(temple, behind, side));
  }
  const [left, right] = inner;
  if (left && right) arms.push(bridge(left, right));
  return { rims, arms };
}

function mirrored(point: Vector3, side: number): Vector3 {
  return new Vector3(point.x * side, point.y, point.z);
}

function middle(points: readonly Vector3[]): Vector3 {
  return points.reduce((sum, point) => sum.add(point), new Vector3()).divideScalar(points.length);
}

function extreme(points: readonly Vector3[], of: (point: Vector3) => number): Vector3 {
  return points.reduce((best, point) => (of(point) > of(best) ? point : best));
}

function smooth(points: Vector3[]): Vector3[] {
  return new CatmullRomCurve3(points, false, "centripetal").getPoints(48);
}

/**
 * A closed curve of two waves a turn that passes near the points: rounder than one that goes through them, as frames are.
 * Points in any order.
 */
function rimThrough(points: readonly Vector3[], side: number): Vector3[] {
  const turns = Array.from({ length: RIM_POINTS }, (_, i) => (2 * Math.PI * i) / RIM_POINTS);
  const box = new Box3().setFromPoints([...points]);
  const centre = box.getCenter(new Vector3());
  const half = box.getSize(new Vector3()).divideScalar(2);
  if (points.length < 5 || Math.min(half.x, half.y) < LEAST_HALF) {
    const { centre: plain, width, height, wrap } = PLAIN_RIM;
    return turns.map((t) => {
      const out = Math.cos(t);
      return new Vector3(side * (plain.x + width * out), plain.y + height * Math.sin(t), plain.z - wrap * out - 0.003 * out * out);
    });
  }
  const angles = points.map((point) => Math.atan2((point.y - centre.y) / half.y, (point.x - centre.x) / half.x));
  const along = (read: (point: Vector3) => number) => fitWaves(angles, points.map(read));
  const [x, y, z] = [along((point) => point.x), along((point) => point.y), along((point) => point.z)];
  return turns.map((t) => new Vector3(waveAt(x, t), waveAt(y, t), waveAt(z, t)));
}

const WAVES = 5;

function wave(k: number, t: number): number {
  return k === 0 ? 1 : k === 1 ? Math.cos(t) : k === 2 ? Math.sin(t) : k === 3 ? Math.cos(2 * t) : Math.sin(2 * t);
}

function waveAt(waves: readonly number[], t: number): number {
  return waves.reduce((sum, weight, k) => sum + weight * wave(k, t), 0);
}

/** Least squares, the second wave held down. */
function fitWaves(angles: readonly number[], values: readonly number[]): number[] {
  const rows = Array.from({ length: WAVES }, (_, i) =>
    Array.from({ length: WAVES + 1 }, (_, j) =>
      angles.reduce((sum, t, n) => sum + wave(i, t) * (j < WAVES ? wave(j, t) : (values[n] ?? 0)), i === j ? (i < 3 ? 1e-6 : STIFFNESS) : 0),
    ),
  );
  return solved(rows);
}

/** Solves a small symmetric positive system, [A | b] by rows, by elimination. */
function solved(rows: number[][]): number[] {
  const n = rows.length;
  const cell = (i: number, j: number) => rows[i]?.[j] ?? 0;
  for (let i = 0; i < n; ++i) {
    for (let below = i + 1; below < n; ++below) {
      const factor = cell(below, i) / cell(i, i);
      rows[below] = (rows[below] ?? []).map((value, j) => value - factor * cell(i, j));
    }
  }
  const out = new Array<number>(n).fill(0);
  for (let i = n - 1; i >= 0; --i) {
    let rest = cell(i, n);
    for (let j = i + 1; j < n; ++j) rest -= cell(i, j) * (out[j] ?? 0);
    out[i] = rest / cell(i, i);
  }
  return out;
}

function bridge(left: Vector3, right: Vector3): Vector3[] {
  const peak = left.clone().add(right).divideScalar(2);
  // Over the nose: it stands out further than the frame.
  peak.y += 0.0035;
  peak.z += 0.006;
  return smooth([left, left.clone().lerp(peak, 0.5).setY((left.y + peak.y) / 2 + 0.0008), peak, right.clone().lerp(peak, 0.5).setY((right.y + peak.y) / 2 + 0.0008), right]);
}

/** From the temple before the ear down along the sensors, bowed outwards so that it does not cut through the cheek. */
function hook(temple: readonly Vector3[], sensors: readonly Vector3[], side: number): Vector3[] {
  const first = sensors[0] ?? new Vector3();
  const from = extreme(temple, (point) => -Math.abs(point.z - first.z));
  const way = [from.clone()];
  let before = from;
  for (const sensor of sensors) {
    const bow = before.clone().lerp(sensor, 0.5);
    bow.x += side * 0.13 * before.distanceTo(sensor);
    if (before !== from) way.push(bow);
    way.push(sensor.clone());
    before = sensor;
  }
  return smooth(way);
}
