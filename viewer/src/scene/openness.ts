/**
 * How open each vertex of a head lies: to light from everywhere (ambient occlusion), and to each lamp. Found once, with
 * depth images of the head from many sides, drawn here and not by the graphics card, a few in each pause between pictures:
 * the first picture does not wait for it, and later ones pay four bytes a vertex. Found for the head at rest and with its
 * mouth open, of which a vertex keeps the more open: front teeth show their light as soon as lips part.
 */
import { BufferAttribute, Vector3, type Mesh, type Object3D } from "three";
import { materialsOf } from "./avatar";
import { atRest } from "./cpu_morph";
import { LAMPS } from "./studio";

/** The vertex attribute: ambient, then each lamp, 0 to 1. */
export const OPENNESS = "openness";

const SIDES = 24;
const SIDES_PER_LAMP = 4;
/** Texels of a depth image along a side, and how far one looks, m. */
const SIZE = 200;
const HALF_WIDTH_M = 0.2;
/** Vertices are lifted off their own surface by this, m, and blocked by what is nearer to the light than this. */
const LIFT_M = 0.0022;
const BIAS_M = 0.0012;
/** Hair lets this share of the light through; what is nearer to a place of hair than this belongs to the same lock. */
const THROUGH_HAIR = 0.4;
const OWN_LOCK_M = 0.005;
/** A mouth that shows what is in it. */
const OPEN_MOUTH: Readonly<Record<string, number>> = { jawOpen: 0.5, mouthSmile_L: 0.4, mouthSmile_R: 0.4 };
/** Work at a stretch, ms. */
const STRETCH_MS = 12;

/** Gives all meshes below `root` the attribute, open everywhere. */
export function addOpenness(root: Object3D): void {
  root.traverse((node) => {
    const mesh = node as Mesh;
    const count = mesh.isMesh ? (mesh.geometry.attributes["position"]?.count ?? 0) : 0;
    if (count > 0) mesh.geometry.setAttribute(OPENNESS, new BufferAttribute(new Uint8Array(4 * count).fill(255), 4, true));
  });
}

/** Finds it in the pauses between pictures; resolves when it is there, or when `stopped` says that nobody wants it. */
export async function findOpenness(root: Object3D, stopped: () => boolean): Promise<void> {
  const work = openness(root);
  for (;;) {
    await new Promise((resolve) => setTimeout(resolve, 0));
    const until = performance.now() + STRETCH_MS;
    while (performance.now() < until) if (stopped() || work.next().done) return;
  }
}

interface Part {
  mesh: Mesh;
  first: number;
  count: number;
  moves: boolean;
}

/** Corners in all vertices of the head, three a triangle. */
interface Blockers {
  solid: number[];
  hair: number[];
}

/** A step each time that it is asked. */
function* openness(root: Object3D): Generator<void> {
  root.updateWorldMatrix(true, true);
  const parts: Part[] = [];
  let count = 0;
  root.traverse((node) => {
    const mesh = node as Mesh;
    if (!mesh.isMesh || !mesh.geometry.attributes[OPENNESS]) return;
    const own = mesh.geometry.attributes["position"]?.count ?? 0;
    parts.push({ mesh, first: count, count: own, moves: (atRest(mesh).morphAttributes.position?.length ?? 0) > 0 });
    count += own;
  });
  const blockers = blockersOf(parts);
  const result = new Float32Array(4 * count);
  yield;
  for (const mouth of [{}, OPEN_MOUTH]) {
    const moved = mouth === OPEN_MOUTH;
    const posed = parts.filter((part) => !moved || part.moves);
    const points = new Float32Array(3 * count), normals = new Float32Array(3 * count);
    for (const part of parts) pose(part, root, moved ? OPEN_MOUTH : {}, points, normals);
    yield;
    const open = new Float32Array(4 * count);
    for (const [channel, sides] of [ball(SIDES), ...LAMPS.map((lamp) => disc(lamp.towards, lamp.radius))].entries()) {
      const weights = new Float32Array(count);
      for (const side of sides) {
        const seen = look(side, points, blockers, moved);
        for (const part of posed) gather(part, side, seen, points, normals, open, weights, channel);
        yield;
      }
      for (let i = 0; i < count; ++i) {
        const weight = weights[i] as number;
        const share = weight > 0 ? (open[4 * i + channel] as number) / weight : 1;
        if (!moved || share > (result[4 * i + channel] as number)) result[4 * i + channel] = share;
      }
    }
  }
  for (const part of parts) {
    smooth(part, result);
    if (!part.moves) spread(part, result);
    yield;
    const attribute = part.mesh.geometry.attributes[OPENNESS] as BufferAttribute;
    for (let i = 0; i < 4 * part.count; ++i) attribute.array[i] = Math.round(255 * (result[4 * part.first + i] as number));
    attribute.needsUpdate = true;
  }
}

/** Hair, and all but what is too thin for a depth image: brows and lashes. */
function blockersOf(parts: Part[]): Blockers {
  const blockers: Blockers = { solid: [], hair: [] };
  for (const { mesh, first, moves } of parts) {
    const index = mesh.geometry.index;
    if (!index) continue;
    const materials = materialsOf(mesh);
    const groups = mesh.geometry.groups.length > 0 ? mesh.geometry.groups : [{ start: 0, count: index.count, materialIndex: 0 }];
    for (const { start, count, materialIndex } of groups) {
      const name = materials[materialIndex ?? 0]?.name ?? "";
      if (/lash|cornea|edge/.test(name) || (name === "strands" && moves)) continue;
      const into = name === "strands" ? blockers.hair : blockers.solid;
      for (let i = start; i < start + count; ++i) into.push(first + index.getX(i));
    }
  }
  return blockers;
}

/** Where the vertices of a part are, and their normals, in the coordinates of `root`. */
function pose(part: Part, root: Object3D, weights: Readonly<Record<string, number>>, points: Float32Array, normals: Float32Array): void {
  const { mesh, first, count } = part;
  const { attributes, morphAttributes } = atRest(mesh);
  const place = root.matrixWorld.clone().invert().multiply(mesh.matrixWorld);
  const moves = Object.entries(weights).flatMap(([name, weight]) => {
    const target = mesh.morphTargetDictionary?.[name];
    return target === undefined ? [] : [{ target, weight }];
  });
  const p = new Vector3(), delta = new Vector3();
  for (const [source, targets, out, isNormal] of [
    [attributes["position"], morphAttributes.position, points, false],
    [attributes["normal"], morphAttributes.normal, normals, true],
  ] as const) {
    if (!source) continue;
    for (let i = 0; i < count; ++i) {
      p.fromBufferAttribute(source, i);
      for (const { target, weight } of moves) {
        const by = targets?.[target];
        if (by) p.addScaledVector(delta.fromBufferAttribute(by, i), weight);
      }
      if (isNormal) p.transformDirection(place);
      else p.applyMatrix4(place);
      p.toArray(out, 3 * (first + i));
    }
  }
}

/** A direction that light comes from, and the axes of the image that looks along it. */
interface Side {
  towards: Vector3;
  right: Vector3;
  up: Vector3;
}

function sideOf(towards: Vector3): Side {
  const right = new Vector3(towards.y, -towards.x, 0);
  if (right.lengthSq() < 1e-6) right.set(1, 0, 0);
  right.addScaledVector(towards, -right.dot(towards)).normalize();
  return { towards, right, up: new Vector3().crossVectors(towards, right) };
}

/** Evenly over the sphere, along a spiral. */
function ball(sides: number): Side[] {
  return Array.from({ length: sides }, (_, i) => {
    const y = 1 - (2 * i + 1) / sides;
    const across = Math.sqrt(1 - y * y);
    const turn = i * Math.PI * (3 - Math.sqrt(5));
    return sideOf(new Vector3(across * Math.cos(turn), y, across * Math.sin(turn)));
  });
}

/** Over a lamp's disc. */
function disc(towards: Vector3, radius: number): Side[] {
  const middle = sideOf(towards);
  return Array.from({ length: SIDES_PER_LAMP }, (_, i) => {
    const out = Math.tan(radius) * (i === 0 ? 0 : 0.75), turn = (2 * Math.PI * i) / (SIDES_PER_LAMP - 1);
    const at = towards.clone().addScaledVector(middle.right, out * Math.cos(turn)).addScaledVector(middle.up, out * Math.sin(turn));
    return sideOf(at.normalize());
  });
}

interface Depths {
  solid: Float32Array;
  hair: Float32Array;
}

/** How near to the light the nearest surface is at each texel, m along `side.towards`. */
function look(side: Side, points: Float32Array, blockers: Blockers, withoutHair: boolean): Depths {
  const { right, up, towards } = side;
  const count = points.length / 3;
  const screen = new Float32Array(points.length);
  const scale = SIZE / (2 * HALF_WIDTH_M);
  for (let i = 0; i < 3 * count; i += 3) {
    const x = points[i] as number, y = points[i + 1] as number, z = points[i + 2] as number;
    screen[i] = (x * right.x + y * right.y + z * right.z) * scale + SIZE / 2;
    screen[i + 1] = (x * up.x + y * up.y + z * up.z) * scale + SIZE / 2;
    screen[i + 2] = x * towards.x + y * towards.y + z * towards.z;
  }
  const draw = (corners: number[]) => {
    const image = new Float32Array(SIZE * SIZE).fill(-Infinity);
    for (let t = 0; t < corners.length; t += 3) {
      drawTriangle(image, screen, 3 * (corners[t] as number), 3 * (corners[t + 1] as number), 3 * (corners[t + 2] as number));
    }
    return image;
  };
  return { solid: draw(blockers.solid), hair: draw(withoutHair ? [] : blockers.hair) };
}

function drawTriangle(image: Float32Array, screen: Float32Array, a: number, b: number, c: number): void {
  const ax = screen[a] as number, ay = screen[a + 1] as number, az = screen[a + 2] as number;
  const bx = screen[b] as number, by = screen[b + 1] as number, bz = screen[b + 2] as number;
  const cx = screen[c] as number, cy = screen[c + 1] as number, cz = screen[c + 2] as number;
  const area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
  if (area === 0) return;
  const left = Math.max(0, Math.ceil(Math.min(ax, bx, cx) - 0.5)), end = Math.min(SIZE - 1, Math.floor(Math.max(ax, bx, cx) - 0.5));
  const top = Math.max(0, Math.ceil(Math.min(ay, by, cy) - 0.5)), last = Math.min(SIZE - 1, Math.floor(Math.max(ay, by, cy) - 0.5));
  for (let y = top; y <= last; ++y) {
    for (let x = left; x <= end; ++x) {
      const px = x + 0.5, py = y + 0.5;
      const u = ((bx - px) * (cy - py) - (by - py) * (cx - px)) / area;
      const v = ((cx - px) * (ay - py) - (cy - py) * (ax - px)) / area;
      const w = 1 - u - v;
      if (u < 0 || v < 0 || w < 0) continue;
      const z = u * az + v * bz + w * cz;
      if (z > (image[y * SIZE + x] as number)) image[y * SIZE + x] = z;
    }
  }
}

/** Adds to `open` what comes from this side to each vertex of the part, and to `weights` what could. */
function gather(part: Part, side: Side, seen: Depths, points: Float32Array, normals: Float32Array, open: Float32Array, weights: Float32Array, channel: number): void {
  const { right, up, towards } = side;
  const scale = SIZE / (2 * HALF_WIDTH_M);
  const clear = part.moves ? -LIFT_M : OWN_LOCK_M;
  for (let i = part.first; i < part.first + part.count; ++i) {
    const nx = normals[3 * i] as number, ny = normals[3 * i + 1] as number, nz = normals[3 * i + 2] as number;
    const cosine = nx * towards.x + ny * towards.y + nz * towards.z;
    const weight = channel === 0 ? cosine : 1;
    if (weight <= 0.05) continue;
    weights[i] = (weights[i] as number) + weight;
    const px = (points[3 * i] as number) + LIFT_M * nx;
    const py = (points[3 * i + 1] as number) + LIFT_M * ny;
    const pz = (points[3 * i + 2] as number) + LIFT_M * nz;
    const x = Math.floor((px * right.x + py * right.y + pz * right.z) * scale + SIZE / 2);
    const y = Math.floor((px * up.x + py * up.y + pz * up.z) * scale + SIZE / 2);
    let through = 1;
    if (x >= 0 && y >= 0 && x < SIZE && y < SIZE) {
      const depth = px * towards.x + py * towards.y + pz * towards.z + BIAS_M;
      if ((seen.solid[y * SIZE + x] as number) > depth) through = 0;
      else if ((seen.hair[y * SIZE + x] as number) > depth + clear) through = THROUGH_HAIR;
    }
    open[4 * i + channel] = (open[4 * i + channel] as number) + weight * through;
  }
}

/** Light goes on from hair to hair, and within an eyeball: neither is as dark as a depth image of it says. */
function spread({ first, count }: Part, values: Float32Array): void {
  for (let i = 4 * first; i < 4 * (first + count); ++i) values[i] = 0.5 + 0.5 * (values[i] as number);
}

/** Half of a vertex's own and half of its neighbours': light spreads in skin, and a depth image has texels. */
function smooth({ mesh, first, count }: Part, values: Float32Array): void {
  const index = mesh.geometry.index;
  if (!index) return;
  const sums = new Float32Array(4 * count), neighbours = new Uint16Array(count);
  for (let t = 0; t + 2 < index.count; t += 3) {
    const corners = [index.getX(t), index.getX(t + 1), index.getX(t + 2)];
    for (const a of corners) {
      for (const b of corners) {
        if (a === b) continue;
        neighbours[a] = (neighbours[a] as number) + 1;
        for (let k = 0; k < 4; ++k) sums[4 * a + k] = (sums[4 * a + k] as number) + (values[4 * (first + b) + k] as number);
      }
    }
  }
  for (let i = 0; i < count; ++i) {
    const n = neighbours[i] as number;
    if (n === 0) continue;
    for (let k = 0; k < 4; ++k) {
      const at = 4 * (first + i) + k;
      values[at] = 0.5 * (values[at] as number) + (0.5 * (sums[4 * i + k] as number)) / n;
    }
  }
}
