/**
 * How the parts of a head take light, as `mien render` has it (render/shade.cpp). Skin lets light in and out again: red
 * furthest, so the edge of a shadow on it is soft and warm; and it has pores. Light arrives as far as a place lies open
 * to it. All are added to three.js' own physical material.
 */
import {
  Color, DoubleSide, FrontSide, MeshPhysicalMaterial, ShaderChunk, type Material, type Mesh, type MeshStandardMaterial, type Object3D,
  type WebGLProgramParametersWithUniforms,
} from "three";
import { materialsOf } from "./avatar";
import { OPENNESS } from "./openness";
import type { SkinPictures } from "./skin_pictures";
import { AROUND, LAMPS, vec3 } from "./studio";

/** How far light wraps round an edge to the dark side, by channel, in skin (render/shade.cpp). */
export const WRAP = new Color(0.2, 0.12, 0.09);

const LAMP_CALL = "RE_Direct( directLight, geometryPosition";
const [beforeLamps, lamps] = split(ShaderChunk.lights_fragment_begin, "getDirectionalLightInfo");
/** What a lamp sends arrives as far as `openness` says, where no shadow map says it; red light leaks into skin's shadows. */
const LAMPS_OPEN = `${beforeLamps}${lamps.replace(
  LAMP_CALL,
  `#if UNROLLED_LOOP_INDEX >= NUM_DIR_LIGHT_SHADOWS
		directLight.color *= leaked( vOpen[ 1 + UNROLLED_LOOP_INDEX ] );
		#endif
		${LAMP_CALL}`,
)}`;
/** Light from around, as far as it arrives; what pale surfaces throw at each other fills folds (Jimenez et al. 2016). */
const AMBIENT_OPEN = `{
  vec3 colour = diffuseColor.rgb;
  vec3 a = 2.0404 * colour - 0.3324, b = -4.7951 * colour + 0.6417, c = 2.7552 * colour + 0.6903;
  float arrives = max(vOpen.x, 0.0);
  reflectedLight.indirectDiffuse *= max(vec3(arrives), ((arrives * a + b) * arrives + c) * arrives);
  reflectedLight.indirectSpecular *= 0.8 * arrives;
}`;

function split(text: string, at: string): [string, string] {
  const place = text.indexOf(at);
  return [text.slice(0, place), text.slice(place)];
}

function wrapped(scatter: number): string {
  return ShaderChunk.lights_physical_pars_fragment.replace(
    "reflectedLight.directDiffuse += irradiance * diffuseBRDF",
    `vec3 wrap = ${scatter.toFixed(3)} * ${vec3(WRAP)};
	vec3 round = max(dot(geometryNormal, directLight.direction) + wrap, 0.0) / ((1.0 + wrap) * (1.0 + wrap)) * directLight.color;
	reflectedLight.directDiffuse += round * diffuseBRDF`,
  );
}

/** Fades out towards a cut that nobody wants to see. Heights in the mesh's own coordinates at rest. */
export interface Fade {
  top: number;
  bottom: number;
}

/** Where a bust ends: in a shirt, or, of a head without one, in its neck. */
interface Fades {
  cloth: Fade;
  skin: Fade | null;
}

/** Dresses a face of the program's own making, whose materials' names say what they are. */
export function dress(root: Object3D, ends: { cloth: Fade; skin: Fade }): void {
  let clothed = false;
  root.traverse((node) => {
    const mesh = node as Mesh;
    if (mesh.isMesh) clothed = clothed || materialsOf(mesh).some((material) => material.name === "cloth");
  });
  const fades: Fades = { cloth: ends.cloth, skin: clothed ? null : ends.skin };
  const made = new Map<Material, Material>();
  root.traverse((node) => {
    const mesh = node as Mesh;
    if (!mesh.isMesh) return;
    const dressed = materialsOf(mesh).map((material) => {
      const before = made.get(material);
      if (before) return before;
      const after = dressOne(material as MeshStandardMaterial, fades, irisAngleOf(mesh));
      made.set(material, after);
      return after;
    });
    mesh.material = dressed.length === 1 ? (dressed[0] as Material) : dressed;
    const thin = dressed.length === 1 && (dressed[0]?.name === "lash" || dressed[0]?.name === "strands");
    mesh.castShadow = !thin;
    mesh.receiveShadow = true;
    // Before anything moves them: where pores, fading and irises lie.
    const position = mesh.geometry.attributes["position"];
    if (position) mesh.geometry.setAttribute("rest", position);
    soften(mesh);
  });
}

function dressOne(from: MeshStandardMaterial, fades: Fades, irisAngle: number): Material {
  const material = new MeshPhysicalMaterial({
    name: from.name,
    color: from.color,
    map: from.map,
    vertexColors: from.vertexColors,
    roughness: from.roughness,
    metalness: 0,
    transparent: from.transparent,
    opacity: from.opacity,
    side: from.side === DoubleSide ? DoubleSide : FrontSide,
    shadowSide: DoubleSide,
  });
  // 0.04 is the reflectance that three.js gives where the intensity is 1. Lamps are wide, which widens their highlights.
  const surface = (reflectance: number, roughness: number) => {
    material.specularIntensity = reflectance / 0.04;
    material.roughness = Math.min(1, roughness + 0.1);
  };
  switch (from.name) {
    case "skin":
      surface(0.026, 0.46);
      dressForPictures(material, { scatter: 1, pores: 0.11, fade: fades.skin });
      break;
    case "lips":
      surface(0.03, 0.28);
      dressForPictures(material, { scatter: 1, pores: 0.05, fade: fades.skin });
      break;
    case "sclera":
    case "iris":
    case "pupil":
      surface(0, 0.5);
      dressForPictures(material, { scatter: 0.7, irisAngle });
      break;
    case "strands":
      surface(0.018, 0.5);
      material.side = DoubleSide;
      material.alphaTest = HAIR_CORE;
      finish(material, { scatter: 1, ribbon: true });
      break;
    case "cloth":
      surface(0.015, 0.95);
      material.transparent = true;
      finish(material, { fade: fades.cloth });
      break;
    case "teeth":
      surface(0.045, 0.22);
      finish(material, { scatter: 0.3 });
      break;
    case "gums":
    case "tongue":
    case "mouth_inside":
      surface(0.03, 0.33);
      finish(material, { scatter: 0.6 });
      break;
    case "lash":
      material.depthWrite = false;
      finish(material, {});
      break;
    default:
      surface(0.03, 0.5);
      finish(material, {});
      break;
  }
  return material;
}

/** Shows the pictures instead of the vertices' colours and of the shader's own pores; null: no longer. */
export function wearPictures(root: Object3D, pictures: SkinPictures | null): void {
  root.traverse((node) => {
    const mesh = node as Mesh;
    if (!mesh.isMesh) return;
    for (const material of materialsOf(mesh)) {
      if (!(material instanceof MeshPhysicalMaterial)) continue;
      const dressed = dressings.get(material);
      if (!dressed || material.map === (pictures?.albedo ?? null)) continue;
      const skin = dressed.pores !== undefined;
      material.map = pictures?.albedo ?? null;
      material.normalMap = skin ? (pictures?.normal ?? null) : null;
      // glTF's green points up in the picture, three.js' own tangents down it.
      material.normalScale.set(1, -1);
      material.roughnessMap = skin ? (pictures?.roughness ?? null) : null;
      // The lamps are wide: as in surface() above, where roughness is one number.
      material.roughness = pictures && skin ? 1.2 : dressed.roughness;
      material.vertexColors = !pictures;
      finish(material, pictures ? { ...dressed, pores: 0, pictured: true } : dressed);
      material.needsUpdate = true;
    }
  });
}

/** How the materials that a picture may show were finished without one. */
const dressings = new WeakMap<Material, Finish & { roughness: number }>();

function dressForPictures(material: MeshPhysicalMaterial, how: Finish): void {
  finish(material, how);
  dressings.set(material, { ...how, roughness: material.roughness });
}

/** Hair that covers at least this much of a pixel hides what is behind it; below, it is laid over. */
const HAIR_CORE = 0.75;

/** Lays the soft edges of ribbons of hair over their opaque core: the same triangles once more, blended. */
function soften(mesh: Mesh): void {
  const { geometry } = mesh;
  const materials = materialsOf(mesh);
  const strands = materials.findIndex((material) => material.name === "strands");
  const core = materials[strands];
  if (!(core instanceof MeshPhysicalMaterial) || !geometry.index) return;
  if (geometry.groups.length === 0) geometry.addGroup(0, geometry.index.count, 0);
  const edge = core.clone();
  edge.name = "strands edge";
  edge.alphaTest = 0.04;
  edge.transparent = true;
  edge.depthWrite = false;
  finish(edge, { scatter: 1, ribbon: true });
  for (const group of [...geometry.groups]) {
    if (group.materialIndex === strands) geometry.addGroup(group.start, group.count, materials.length);
  }
  mesh.material = [...materials, edge];
}

interface Finish {
  /** 1: light spreads under the surface as in skin; 0: not at all. */
  scatter?: number;
  /** Depth of pores; 0: smooth. */
  pores?: number;
  fade?: Fade | null;
  /** Both sides take light as the head's outside does: its normals say so, whichever side is seen. */
  ribbon?: boolean;
  /** A wet ball that looks along its mesh's +Z: mirrors the lamps. The angle from there to its iris' edge; 0: no eye. */
  irisAngle?: number;
  /** A picture shows the pupil and the iris' rim. */
  pictured?: boolean;
}

/** Completes the shader of a material by what three.js' own does not know. */
function finish(material: MeshPhysicalMaterial, { scatter = 0, pores = 0, fade = null, ribbon = false, irisAngle = 0, pictured = false }: Finish): void {
  if (fade) material.transparent = true;
  material.onBeforeCompile = (shader) => {
    addRest(shader);
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", `#include <common>\nattribute vec4 ${OPENNESS};\nvarying vec4 vOpen;`)
      .replace("#include <begin_vertex>", `#include <begin_vertex>\nvOpen = ${OPENNESS};`);
    shader.fragmentShader = shader.fragmentShader
      .replace("#include <common>", `#include <common>
varying vec4 vOpen;
vec3 leaked(float open) {
  open = max(open, 0.0);
  return vec3(mix(open, sqrt(open), ${scatter.toFixed(2)}), open, open);
}`)
      .replace("#include <lights_fragment_begin>", LAMPS_OPEN)
      .replace("#include <aomap_fragment>", AMBIENT_OPEN)
      .replace("#include <lights_physical_pars_fragment>", wrapped(scatter));
    if (ribbon) {
      shader.fragmentShader = shader.fragmentShader.replace(
        "#include <normal_fragment_begin>",
        ShaderChunk.normal_fragment_begin.replace("gl_FrontFacing ? 1.0 : - 1.0", "1.0"),
      );
    }
    if (pores > 0) addPores(shader, pores);
    if (irisAngle > 0) addEye(shader, irisAngle, pictured);
    if (fade) addFade(shader, fade);
  };
  material.customProgramCacheKey = () => `${scatter} ${pores} ${fade ? 1 : 0} ${ribbon} ${irisAngle} ${pictured}`;
}

/** Of an eye's mesh: the angle about its centre from +Z to where its iris ends, radians. */
export function irisAngleOf(mesh: Mesh): number {
  const { geometry } = mesh;
  const iris = materialsOf(mesh).findIndex((material) => material.name === "iris");
  const position = geometry.attributes["position"];
  let angle = 0;
  for (const { start, count, materialIndex } of geometry.groups) {
    if (materialIndex !== iris || !geometry.index || !position) continue;
    for (let i = start; i < start + count; ++i) {
      const v = geometry.index.getX(i);
      angle = Math.max(angle, Math.atan2(Math.hypot(position.getX(v), position.getY(v)), position.getZ(v)));
    }
  }
  return angle > 0.2 && angle < 0.9 ? angle : 0.5;
}

/**
 * A pupil and the iris' dark rim, which its few vertices cannot show and a picture does; and what a wet eye mirrors: the
 * lamps as discs, and the room. The cornea is a smaller sphere that stands out of the ball: its normals turn faster
 * (render/shade.cpp and surface_paint.cpp).
 */
function addEye(shader: WebGLProgramParametersWithUniforms, irisAngle: number, pictured: boolean): void {
  shader.vertexShader = shader.vertexShader
    .replace("#include <common>", "#include <common>\nvarying vec3 vAxis;")
    .replace("#include <begin_vertex>", "#include <begin_vertex>\nvAxis = normalMatrix * vec3(0.0, 0.0, 1.0);");
  const mirrored = LAMPS.map(({ radius }, i) => {
    // A disc of this radius that lights a wall to its radiance is brighter the smaller it is.
    const brightness = 1 / Math.max(0.02, Math.sin(radius) ** 2);
    return `comes += ${brightness.toFixed(3)} * directionalLights[${i}].color
    * (1.0 - smoothstep(${(0.88 * radius).toFixed(4)}, ${(1.12 * radius).toFixed(4)}, acos(clamp(dot(outwards, directionalLights[${i}].direction), -1.0, 1.0))));`;
  });
  shader.fragmentShader = shader.fragmentShader
    .replace("#include <common>", `#include <common>\nvarying vec3 vAxis;\n${AROUND}`)
    .replace(
      "#include <color_fragment>",
      `#include <color_fragment>
float angle = acos(clamp(normalize(vRest).z, -1.0, 1.0));
if (${!pictured}) {
  float radius = angle / ${irisAngle.toFixed(3)};
  diffuseColor.rgb *= 1.0 - 0.7 * smoothstep(0.74, 0.9, radius) * (1.0 - smoothstep(0.97, 1.06, radius));
  diffuseColor.rgb = max(diffuseColor.rgb * smoothstep(0.30, 0.37, radius), 0.004);
}`,
    )
    .replace(
      "#include <opaque_fragment>",
      `{
  vec3 wet = normalize(normal - 0.4 * (1.0 - smoothstep(0.85, 1.15, angle / ${irisAngle.toFixed(3)})) * normalize(vAxis));
  vec3 outwards = reflect(-geometryViewDir, wet);
  vec3 comes = 0.35 * around(inverseTransformDirection(outwards, viewMatrix));
  ${mirrored.join("\n  ")}
  float glancing = 1.0 - clamp(dot(wet, geometryViewDir), 0.0, 1.0);
  outgoingLight += (0.025 + 0.975 * pow(glancing, 5.0)) * smoothstep(0.02, 0.3, vOpen.x) * comes;
}
#include <opaque_fragment>`,
    );
}

/** Gives the fragments of a shader that is being made their place at rest, `vRest`, in the mesh's own coordinates. */
function addRest(shader: WebGLProgramParametersWithUniforms): void {
  shader.vertexShader = shader.vertexShader
    .replace("#include <common>", "#include <common>\nattribute vec3 rest;\nvarying vec3 vRest;")
    .replace("#include <begin_vertex>", "#include <begin_vertex>\nvRest = rest;");
  shader.fragmentShader = shader.fragmentShader.replace("#include <common>", "#include <common>\nvarying vec3 vRest;");
}

/** What fades a material by its height at rest: to be called while its shader is made, after addRest. */
function addFade(shader: WebGLProgramParametersWithUniforms, fade: Fade): void {
  shader.uniforms["fadeTop"] = { value: fade.top };
  shader.uniforms["fadeBottom"] = { value: fade.bottom };
  shader.fragmentShader = shader.fragmentShader
    .replace("#include <common>", "#include <common>\nuniform float fadeTop;\nuniform float fadeBottom;")
    .replace(
      "#include <opaque_fragment>",
      "diffuseColor.a *= smoothstep(fadeBottom, fadeTop, vRest.y);\n#include <opaque_fragment>",
    );
}

/** Pores, as a slope of the surface. */
function addPores(shader: WebGLProgramParametersWithUniforms, pores: number): void {
  shader.fragmentShader = shader.fragmentShader
    .replace(
      "#include <common>",
      `#include <common>
float grain(vec3 p) {
  p = fract(p * vec3(0.1031, 0.1030, 0.0973));
  p += dot(p, p.yxz + 33.33);
  return fract((p.x + p.y) * p.z);
}
float smoothGrain(vec3 p) {
  vec3 i = floor(p), f = fract(p);
  f = f * f * (3.0 - 2.0 * f);
  return mix(mix(mix(grain(i), grain(i + vec3(1, 0, 0)), f.x), mix(grain(i + vec3(0, 1, 0)), grain(i + vec3(1, 1, 0)), f.x), f.y),
    mix(mix(grain(i + vec3(0, 0, 1)), grain(i + vec3(1, 0, 1)), f.x), mix(grain(i + vec3(0, 1, 1)), grain(i + vec3(1, 1, 1)), f.x), f.y), f.z);
}
float pores(vec3 rest) { return smoothGrain(rest * 900.0) + 0.6 * smoothGrain(rest * 1900.0); }`,
    )
    .replace(
      "#include <normal_fragment_maps>",
      `#include <normal_fragment_maps>
{
  // The slope of the pores' height along the screen, laid onto the surface; it fades where a pore is smaller than a pixel.
  float height = pores(vRest);
  vec3 across = dFdx(-vViewPosition), along = dFdy(-vViewPosition);
  vec3 r1 = cross(along, normal), r2 = cross(normal, across);
  float det = dot(across, r1);
  float texel = length(fwidth(vRest)) * 900.0;
  float depth = ${pores.toFixed(3)} * 0.0008 * (1.0 - smoothstep(0.4, 1.6, texel));
  vec3 slope = sign(det) * (dFdx(height) * r1 + dFdy(height) * r2);
  // At a grazing edge the screen says little of the surface: no pore tilts the light by more than this.
  vec3 tilt = depth * slope / max(abs(det), 1e-12);
  normal = normalize(normal - tilt * min(1.0, 0.3 / max(length(tilt), 1e-6)));
}`,
    );
}
