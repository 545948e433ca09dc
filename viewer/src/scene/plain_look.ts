/**
 * The session's own face for a graphics card that is none: lit here, a vertex at a time, by the same lamps, and drawn by a
 * shader that only lays on colours. Without shadows, pores and soft edges of hair.
 */
import {
  BufferAttribute, BufferGeometry, DoubleSide, DynamicDrawUsage, FrontSide, Matrix4, Mesh, NearestFilter,
  NearestMipmapNearestFilter, Quaternion, ShaderMaterial, Uint32BufferAttribute, Vector3, type Material,
  type MeshStandardMaterial, type Object3D, type SkinnedMesh, type Texture,
} from "three";
import { numbersOf, type Attribute } from "./attributes";
import { materialsOf } from "./avatar";
import { atRest } from "./cpu_morph";
import { irisAngleOf, WRAP, type Fade } from "./materials";
import { OPENNESS } from "./openness";
import { GROUND, LAMPS, SKY, toned } from "./studio";

/** Hair whose head has turned by less than this since it was lit, rad, keeps its light. */
const KEEPS_LIGHT_RAD = 0.03;
/** Of the ribbons on the scalp, the outermost are drawn: this share. */
const HAIR_SHOWN = 0.55;
/** A ribbon's hair covers a pixel from this share on. */
const HAIR_COVERS = 0.45;
/** Of the light that folds keep off, what the skin beside them throws in (render/light_vertices.cpp). */
const BOUNCE = [0.3, 0.19, 0.15] as const;
/** Mirror reflection of skin: strength, and the exponent of its lobe. */
const GLOSS = 0.05;
const GLOSS_EXPONENT = 22;

/** An eye's uniforms, in its mesh's own coordinates: where its mirror shows the key lamp, and where its iris ends, rad. */
interface Glint {
  towards: { value: Vector3 };
  iris: { value: number };
}

/** A uniform: how the head's bone turns what hangs on it, in the mesh's own coordinates. */
interface Neck {
  value: Matrix4;
}

type Kind = "skin" | "hair" | "cloth" | "eye";

function kindOf(material: string): Kind {
  if (material === "strands") return "hair";
  if (material === "cloth") return "cloth";
  return /^(sclera|iris|pupil)$/.test(material) ? "eye" : "skin";
}

/** One mesh of the face, and what is drawn in its stead. */
interface Part {
  fine: Mesh;
  plain: Mesh;
  /** Of the fine mesh, at present. */
  places: Attribute;
  normals: Float32Array;
  colours: BufferAttribute;
  albedo: Float32Array;
  /** Whether shapes move it. */
  moves: boolean;
  glint: Glint;
  neck: Neck | null;
  /** What the light was found for: how it was turned, and which version of its places. */
  litBy: Quaternion | null;
  litAt: number;
}

export class PlainLook {
  private readonly parts: Part[] = [];
  private shown = false;

  /**
   * `root`: a head that was dressed, that CpuMorph moves, and whose openness may still be sought. `head` turns it; `cloth`:
   * where its shirt fades.
   */
  constructor(private readonly root: Object3D, private readonly head: Object3D | null, cloth: Fade) {
    const meshes: Mesh[] = [];
    root.traverse((node) => {
      const mesh = node as Mesh;
      if (mesh.isMesh && mesh.geometry.attributes[OPENNESS] && mesh.geometry.index) meshes.push(mesh);
    });
    for (const mesh of meshes) this.parts.push(makePart(mesh, cloth));
  }

  /** Whether it is drawn in place of the fine look. */
  show(shown: boolean): void {
    if (this.shown === shown) return;
    this.shown = shown;
    for (const part of this.parts) {
      // Not by `visible`, which would hide what hangs on it too.
      if (shown) part.fine.layers.disable(0);
      else part.fine.layers.enable(0);
      part.plain.visible = shown;
      part.litBy = null;
    }
  }

  /** Light must be found anew: openness has come. */
  relight(): void {
    for (const part of this.parts) part.litBy = null;
  }

  /** Lights what has moved since the last picture. */
  update(): void {
    if (!this.shown) return;
    this.root.updateWorldMatrix(true, true);
    for (const part of this.parts) {
      if (part.neck) bend(part.fine as SkinnedMesh, part.neck.value);
      const turning = (part.fine as SkinnedMesh).isSkinnedMesh && this.head ? this.head : part.fine;
      const turn = turning.getWorldQuaternion(new Quaternion());
      const version = versionOf(part.places);
      const keeps = part.moves ? 1e-3 : KEEPS_LIGHT_RAD;
      if (version === part.litAt && part.litBy && part.litBy.angleTo(turn) < keeps) continue;
      part.litBy = turn;
      part.litAt = version;
      light(part, turn);
    }
  }

  dispose(): void {
    for (const { plain } of this.parts) {
      plain.geometry.dispose();
      for (const material of materialsOf(plain)) {
        ((material as ShaderMaterial).uniforms["pattern"]?.value as Texture | null | undefined)?.dispose();
        material.dispose();
      }
    }
  }
}

function bend({ skeleton, bindMatrix, bindMatrixInverse }: SkinnedMesh, out: Matrix4): void {
  const [bone, rest] = [skeleton.bones[1], skeleton.boneInverses[1]];
  if (bone && rest) out.copy(bindMatrixInverse).multiply(bone.matrixWorld).multiply(rest).multiply(bindMatrix);
}

/** Grows whenever the attribute was written. */
function versionOf(attribute: Attribute): number {
  return "data" in attribute ? attribute.data.version : attribute.version;
}

function light(part: Part, turn: Quaternion): void {
  const back = turn.clone().invert();
  const local = (v: Vector3) => v.clone().applyQuaternion(back);
  const up = local(new Vector3(0, 1, 0));
  const view = local(new Vector3(0, 0, 1));
  const lamps = LAMPS.map(({ towards, radiance }) => {
    const l = local(towards);
    return { l, half: l.clone().add(view).normalize(), r: radiance.r / Math.PI, g: radiance.g / Math.PI, b: radiance.b / Math.PI };
  });
  const wrap = [WRAP.r, WRAP.g, WRAP.b] as const;
  const unwrap = wrap.map((w) => 1 / ((1 + w) * (1 + w))) as [number, number, number];
  const open = part.fine.geometry.attributes[OPENNESS]?.array as Uint8Array;
  const colours = part.colours.array as Uint8Array;
  const { normals, albedo } = part;
  const count = part.places.count;
  const shines = part.moves;
  part.glint.towards.value.copy((lamps[0] as (typeof lamps)[number]).half);
  for (let v = 0; v < count; ++v) {
    let x = normals[3 * v] as number, y = normals[3 * v + 1] as number, z = normals[3 * v + 2] as number;
    const size = 1 / (Math.sqrt(x * x + y * y + z * z) || 1);
    x *= size;
    y *= size;
    z *= size;
    const s = Math.min(1, Math.max(0, ((x * up.x + y * up.y + z * up.z) + 0.9) / 1.8));
    const sky = s * s * (3 - 2 * s);
    const arrives = (open[4 * v] as number) / 255;
    let r = (GROUND.r + sky * (SKY.r - GROUND.r)) * (arrives + (1 - arrives) * BOUNCE[0]);
    let g = (GROUND.g + sky * (SKY.g - GROUND.g)) * (arrives + (1 - arrives) * BOUNCE[1]);
    let b = (GROUND.b + sky * (SKY.b - GROUND.b)) * (arrives + (1 - arrives) * BOUNCE[2]);
    let shine = 0;
    for (let i = 0; i < lamps.length; ++i) {
      const lamp = lamps[i] as (typeof lamps)[number];
      const facing = x * lamp.l.x + y * lamp.l.y + z * lamp.l.z;
      if (facing < -wrap[0]) continue;
      const comes = (open[4 * v + 1 + i] as number) / 255;
      r += Math.max(0, facing + wrap[0]) * unwrap[0] * lamp.r * comes;
      g += Math.max(0, facing + wrap[1]) * unwrap[1] * lamp.g * comes;
      b += Math.max(0, facing + wrap[2]) * unwrap[2] * lamp.b * comes;
      if (!shines || facing <= 0) continue;
      const lobe = x * lamp.half.x + y * lamp.half.y + z * lamp.half.z;
      if (lobe > 0.8) shine += GLOSS * lobe ** GLOSS_EXPONENT * comes * lamp.g * Math.PI;
    }
    toned(
      r * (albedo[3 * v] as number) + shine,
      g * (albedo[3 * v + 1] as number) + shine,
      b * (albedo[3 * v + 2] as number) + shine,
      colours,
      4 * v,
    );
  }
  part.colours.needsUpdate = true;
}

function makePart(fine: Mesh, cloth: Fade): Part {
  const from = fine.geometry;
  const source = from.attributes["position"] as Attribute;
  const count = source.count;
  const normals = from.attributes["normal"] as Attribute;
  const moves = (atRest(fine).morphAttributes.position?.length ?? 0) > 0;
  const geometry = new BufferGeometry();
  const colours = new BufferAttribute(new Uint8Array(4 * count).fill(255), 4, true).setUsage(DynamicDrawUsage);
  geometry.setAttribute("position", source);
  geometry.setAttribute("shade", colours);
  if (from.attributes["uv"]) geometry.setAttribute("uv", from.attributes["uv"]);
  const skinned = (fine as SkinnedMesh).isSkinnedMesh ? (fine as SkinnedMesh) : null;
  const neck: Neck | null = skinned && { value: new Matrix4() };
  // Of the two bones that giveNeck made the second is the head's.
  const shares = from.attributes["skinWeight"];
  if (shares) geometry.setAttribute("headShare", new BufferAttribute(Float32Array.from({ length: count }, (_, v) => shares.getY(v)), 1));

  const albedo = new Float32Array(3 * count).fill(1);
  const ownColour = from.attributes["color"];
  const groups = new Map<Kind, number[]>();
  let hair: MeshStandardMaterial | null = null;
  const materials = materialsOf(fine) as MeshStandardMaterial[];
  const index = from.index as BufferAttribute;
  const pieces = from.groups.length > 0 ? from.groups : [{ start: 0, count: index.count, materialIndex: 0 }];
  for (const { start, count: length, materialIndex } of pieces) {
    const material = materials[materialIndex ?? 0];
    if (!material || /edge|cornea|lash/.test(material.name)) continue;
    const kind = kindOf(material.name);
    if (kind === "hair") hair = material;
    const into = groups.get(kind) ?? [];
    groups.set(kind, into);
    for (let i = start; i < start + length; ++i) {
      const v = index.getX(i);
      into.push(v);
      albedo[3 * v] = material.color.r * (ownColour?.getX(v) ?? 1);
      albedo[3 * v + 1] = material.color.g * (ownColour?.getY(v) ?? 1);
      albedo[3 * v + 2] = material.color.b * (ownColour?.getZ(v) ?? 1);
      if (kind !== "cloth") continue;
      const share = Math.min(1, Math.max(0, (source.getY(v) - cloth.bottom) / (cloth.top - cloth.bottom)));
      colours.array[4 * v + 3] = Math.round(255 * share * share * (3 - 2 * share));
    }
  }
  const glint: Glint = { towards: { value: new Vector3(0, 0, 1) }, iris: { value: irisAngleOf(fine) } };
  const corners: number[] = [];
  const looks: Material[] = [];
  for (const [kind, unsorted] of groups) {
    const vertices = kind === "hair" ? outermost(unsorted, numbersOf(source), moves ? 1 : HAIR_SHOWN) : unsorted;
    geometry.addGroup(corners.length, vertices.length, looks.length);
    for (const v of vertices) corners.push(v);
    looks.push(paint(kind, hair, glint, neck));
  }
  geometry.setIndex(new Uint32BufferAttribute(corners, 1));

  const plain = new Mesh(geometry, looks);
  plain.name = `${fine.name}, plain`;
  plain.frustumCulled = false;
  plain.visible = false;
  fine.add(plain);
  return {
    fine, plain, colours, albedo, glint, neck, moves, litBy: null, litAt: -1, places: source,
    // Those that shapes turn are written where they lie.
    normals: normals.array instanceof Float32Array && !("data" in normals) ? normals.array : numbersOf(normals),
  };
}

function paint(kind: Kind, hair: MeshStandardMaterial | null, glint: Glint, neck: Neck | null): Material {
  const pattern = kind === "hair" && hair?.map ? quick(hair.map) : null;
  return new ShaderMaterial({
    name: `plain ${kind}`,
    side: kind === "hair" ? DoubleSide : FrontSide,
    transparent: kind === "cloth",
    uniforms: {
      ...(kind === "eye" ? { towards: glint.towards, iris: glint.iris } : { pattern: { value: pattern } }),
      ...(neck ? { headTurn: neck } : {}),
    },
    defines: { ...(pattern ? { PATTERN: "" } : {}), ...(kind === "eye" ? { EYE: "" } : {}), ...(neck ? { NECK: "" } : {}) },
    vertexShader: `attribute vec4 shade;
varying vec4 vShade;
#ifdef PATTERN
varying vec2 vPlace;
#endif
#ifdef EYE
varying vec3 vRest;
#endif
#ifdef NECK
attribute float headShare;
uniform mat4 headTurn;
#endif
void main() {
  vShade = shade;
#ifdef PATTERN
  vPlace = uv;
#endif
#ifdef EYE
  vRest = position;
#endif
  vec3 place = position;
#ifdef NECK
  place = mix(place, (headTurn * vec4(place, 1.0)).xyz, headShare);
#endif
  gl_Position = projectionMatrix * modelViewMatrix * vec4(place, 1.0);
}`,
    // Colours come as the display wants them.
    fragmentShader: `varying vec4 vShade;
#ifdef PATTERN
uniform sampler2D pattern;
varying vec2 vPlace;
#endif
#ifdef EYE
uniform vec3 towards;
uniform float iris;
varying vec3 vRest;
#endif
void main() {
  gl_FragColor = vShade;
#ifdef EYE
  // Pupil, the iris' dark rim, and the key lamp in the cornea, as the fine look has them.
  vec3 outwards = normalize(vRest);
  float radius = acos(clamp(outwards.z, -1.0, 1.0)) / iris;
  gl_FragColor.rgb *= 1.0 - 0.45 * smoothstep(0.74, 0.9, radius) * (1.0 - smoothstep(0.97, 1.06, radius));
  gl_FragColor.rgb *= 0.12 + 0.88 * smoothstep(0.30, 0.37, radius);
  vec3 wet = normalize(outwards - vec3(0.0, 0.0, 0.4 * (1.0 - smoothstep(0.85, 1.15, radius))));
  gl_FragColor.rgb += 0.75 * smoothstep(0.982, 0.989, dot(wet, towards));
#endif
#ifdef PATTERN
  vec4 strand = texture2D(pattern, vPlace);
  if (strand.a < ${HAIR_COVERS.toFixed(2)}) discard;
  gl_FragColor.rgb *= sqrt(strand.r);
#endif
}`,
  });
}

/**
 * The ribbons that show most, the outermost first, so that most of what lies behind them is refused before it is coloured;
 * one follows another where a triangle shares no corner with the one before.
 */
export function outermost(corners: readonly number[], places: Float32Array, share: number): number[] {
  const middle = [0, 0, 0];
  for (const v of corners) for (let c = 0; c < 3; ++c) middle[c] = (middle[c] as number) + (places[3 * v + c] as number) / corners.length;
  const ribbons: { corners: number[]; away: number }[] = [];
  for (let t = 0; t < corners.length; t += 3) {
    const own = corners.slice(t, t + 3);
    const last = ribbons[ribbons.length - 1];
    const away = Math.max(...own.map((v) => Math.hypot(...middle.map((m, c) => (places[3 * v + c] as number) - m))));
    if (last && last.corners.slice(-3).some((v) => own.includes(v))) {
      last.corners.push(...own);
      last.away = Math.max(last.away, away);
    } else {
      ribbons.push({ corners: own, away });
    }
  }
  ribbons.sort((a, b) => b.away - a.away);
  return ribbons.slice(0, Math.ceil(share * ribbons.length)).flatMap((ribbon) => ribbon.corners);
}

/** The same picture without blending between its texels and sizes, which a processor is slow at. */
function quick(texture: Texture): Texture {
  const copy = texture.clone();
  copy.minFilter = NearestMipmapNearestFilter;
  copy.magFilter = NearestFilter;
  copy.anisotropy = 1;
  copy.needsUpdate = true;
  return copy;
}
