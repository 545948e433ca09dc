/**
 * How the parts of a head take light. Skin lets light in and out again: red furthest, so the edge of a shadow on it is soft
 * and warm; and it has pores. Both are added to three.js' own physical material.
 */
import {
  DoubleSide, FrontSide, MeshPhysicalMaterial, ShaderChunk, type Material, type Mesh, type MeshStandardMaterial, type Object3D,
  type WebGLProgramParametersWithUniforms,
} from "three";
import { materialsOf } from "./avatar";

/** How far round a curve each colour's light creeps: red about a third of the way. Tuned by eye. */
const CREEP = "vec3(0.2, 0.09, 0.05)";

const LIGHTS = ShaderChunk.lights_physical_pars_fragment.replace(
  "reflectedLight.directDiffuse += irradiance * diffuseBRDF",
  `vec3 creep = ${CREEP};
	vec3 crept = saturate((dot(geometryNormal, directLight.direction) + creep) / (1.0 + creep)) * directLight.color;
	reflectedLight.directDiffuse += crept * diffuseBRDF`,
);

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
      const after = dressOne(material as MeshStandardMaterial, fades);
      made.set(material, after);
      return after;
    });
    mesh.material = dressed.length === 1 ? (dressed[0] as Material) : dressed;
    const thin = dressed.length === 1 && (dressed[0]?.name === "lash" || dressed[0]?.name === "strands");
    mesh.castShadow = !thin;
    mesh.receiveShadow = true;
  });
}

function dressOne(from: MeshStandardMaterial, fades: Fades): Material {
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
  switch (from.name) {
    case "skin":
    case "lips":
      material.roughness = from.name === "lips" ? 0.42 : 0.55;
      material.specularIntensity = 0.7;
      material.sheen = 0.25;
      material.sheenRoughness = 0.5;
      material.sheenColor.set(0xd9a892);
      finishSkin(material, fades.skin, from.name === "skin" ? 0.11 : 0.05);
      break;
    case "sclera":
    case "iris":
    case "pupil":
      material.roughness = 0.32;
      material.clearcoat = 1;
      material.clearcoatRoughness = 0.04;
      break;
    case "hair":
      material.roughness = 0.62;
      material.specularIntensity = 0.5;
      break;
    case "strands":
      material.roughness = 0.58;
      material.specularIntensity = 0.45;
      material.side = DoubleSide;
      // Low: from afar a texel stands for several hairs and the skin between them, and a head of hair must stay full.
      material.alphaTest = 0.2;
      material.alphaToCoverage = true;
      finishHair(material);
      break;
    case "cloth":
      material.roughness = 0.95;
      material.specularIntensity = 0.25;
      finishCloth(material, fades.cloth);
      break;
    case "teeth":
      material.roughness = 0.25;
      break;
    case "lash":
      material.depthWrite = false;
      break;
    default:
      break;
  }
  return material;
}

/** Both sides of a ribbon of hair take light as the head's outside does: its normals say so, whichever side is seen. */
function finishHair(material: MeshPhysicalMaterial): void {
  material.onBeforeCompile = (shader) => {
    shader.fragmentShader = shader.fragmentShader.replace(
      "#include <normal_fragment_begin>",
      ShaderChunk.normal_fragment_begin.replace("gl_FrontFacing ? 1.0 : - 1.0", "1.0"),
    );
  };
  material.customProgramCacheKey = () => "hair";
}

/** Gives the fragments of a shader that is being made their place at rest, `vRest`, in the mesh's own coordinates. */
function addRest(shader: WebGLProgramParametersWithUniforms): void {
  shader.vertexShader = shader.vertexShader
    .replace("#include <common>", "#include <common>\nvarying vec3 vRest;")
    .replace("#include <begin_vertex>", "#include <begin_vertex>\nvRest = position;");
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

function finishCloth(material: MeshPhysicalMaterial, fade: Fade): void {
  material.transparent = true;
  material.onBeforeCompile = (shader) => {
    addRest(shader);
    addFade(shader, fade);
  };
  material.customProgramCacheKey = () => "cloth";
}

function finishSkin(material: MeshPhysicalMaterial, fade: Fade | null, pores: number): void {
  if (fade) material.transparent = true;
  material.onBeforeCompile = (shader) => {
    addRest(shader);
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
      )
      .replace("#include <lights_physical_pars_fragment>", LIGHTS);
    if (fade) addFade(shader, fade);
  };
  material.customProgramCacheKey = () => `skin ${pores} ${fade ? 1 : 0}`;
}
