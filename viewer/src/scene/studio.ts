/** The light of `mien render`'s studio (render/lights.cpp): key, fill and rim, a grey room around them, and its tone curve. */
import {
  Color, CustomToneMapping, DataTexture, DataUtils, DirectionalLight, EquirectangularReflectionMapping, HalfFloatType,
  LinearFilter, PMREMGenerator, ShaderChunk, Vector3, VSMShadowMap, type Scene, type Texture, type WebGLRenderer,
} from "three";

export interface Lamp {
  /** From the face to the lamp, unit, frame H at rest. */
  towards: Vector3;
  /** Linear RGB; lights a wall that faces it to this over pi. */
  radiance: Color;
  /** Half the angle that it fills, radians. */
  radius: number;
}

const lamp = (x: number, y: number, z: number, [r, g, b]: [number, number, number], radius: number): Lamp => ({
  towards: new Vector3(x, y, z).normalize(),
  radiance: new Color(r, g, b),
  radius,
});

/** Key from above the left, fill from the right, rim from behind: in the order of the shaders' directionalLights. */
export const LAMPS: readonly Lamp[] = [
  lamp(-0.62, 0.55, 0.7, [2.55, 2.4, 2.25], 0.3),
  lamp(0.9, 0.1, 0.6, [0.62, 0.66, 0.72], 0.5),
  lamp(0.7, 0.5, -0.7, [1.25, 1.28, 1.34], 0.35),
];
/** Light from above and from below, where no lamp is. */
export const SKY = new Color(0.3, 0.31, 0.33);
export const GROUND = new Color(0.13, 0.115, 0.105);

/** GLSL: light from a direction of the world, without the lamps. */
export const AROUND = `vec3 around(vec3 direction) {
  return mix(${vec3(GROUND)}, ${vec3(SKY)}, smoothstep(-0.9, 0.9, direction.y));
}`;

/** The renderer's tone curve (render/tone.h): the identity up to the knee, then a shoulder; very bright light bleeds to white. */
const TONE = `vec3 CustomToneMapping( vec3 color ) {
  color = max( color, 0.0 ) * toneMappingExposure;
  float brightest = max( color.r, max( color.g, color.b ) );
  color += 0.06 * max( 0.0, brightest - 0.7 ) * ( brightest - color );
  vec3 over = max( color - 0.45, 0.0 ) / 0.55;
  return min( color, 0.45 ) + 0.55 * over / ( 1.0 + over );
}`;

/** The same on linear light here: writes three bytes, as the display wants them, at `at`. */
export function toned(r: number, g: number, b: number, out: Uint8Array, at: number): void {
  const brightest = Math.max(r, g, b);
  const bleed = 0.06 * Math.max(0, brightest - 0.7);
  out[at] = byteOf(r + bleed * (brightest - r));
  out[at + 1] = byteOf(g + bleed * (brightest - g));
  out[at + 2] = byteOf(b + bleed * (brightest - b));
}

function byteOf(light: number): number {
  const over = Math.max(0, light - 0.45) / 0.55;
  const share = Math.min(Math.max(0, light), 0.45) + (0.55 * over) / (1 + over);
  return BYTES[Math.min(STEPS_OF_BYTES, Math.round(share * STEPS_OF_BYTES))] as number;
}

/** sRGB's curve (IEC 61966-2-1) of shares 0 to 1. */
const STEPS_OF_BYTES = 4096;
const BYTES = Uint8Array.from({ length: STEPS_OF_BYTES + 1 }, (_, i) => {
  const share = i / STEPS_OF_BYTES;
  return Math.round(255 * (share <= 0.0031308 ? 12.92 * share : 1.055 * share ** (1 / 2.4) - 0.055));
});

/** Adds the lamps to `scene`, makes the renderer ready for them, and gives the light that casts the shadows. */
export function furnishStudio(renderer: WebGLRenderer, scene: Scene): DirectionalLight {
  ShaderChunk.tonemapping_pars_fragment = ShaderChunk.tonemapping_pars_fragment.replace(
    "vec3 CustomToneMapping( vec3 color ) { return color; }",
    TONE,
  );
  renderer.toneMapping = CustomToneMapping;
  renderer.shadowMap.enabled = true;
  renderer.shadowMap.type = VSMShadowMap;

  const lights = LAMPS.map(({ towards, radiance }) => {
    const light = new DirectionalLight(radiance, 1);
    light.position.copy(towards).multiplyScalar(1.25);
    return light;
  });
  const key = lights[0] as DirectionalLight;
  key.castShadow = true;
  key.shadow.mapSize.set(512, 512);
  key.shadow.camera.left = key.shadow.camera.bottom = -0.24;
  key.shadow.camera.right = key.shadow.camera.top = 0.24;
  key.shadow.camera.near = 0.6;
  key.shadow.camera.far = 1.9;
  key.shadow.radius = 5;
  key.shadow.blurSamples = 12;
  key.shadow.bias = -0.0006;
  key.shadow.normalBias = 0.002;
  scene.add(...lights);
  return key;
}

/** What is around the face where no lamp is. To be made anew when a graphics card has lost all that it held. */
export function lightRoom(renderer: WebGLRenderer, scene: Scene): void {
  const generator = new PMREMGenerator(renderer);
  const sky = gradient();
  scene.environment?.dispose();
  scene.environment = generator.fromEquirectangular(sky).texture;
  sky.dispose();
  generator.dispose();
}

/** From the ground's light to the sky's, as an equirectangular image. */
function gradient(): Texture {
  const width = 4, height = 64;
  const data = new Uint16Array(width * height * 4);
  const colour = new Color();
  for (let row = 0; row < height; ++row) {
    const up = Math.sin(((row + 0.5) / height - 0.5) * Math.PI);
    const t = Math.min(1, Math.max(0, (up + 0.9) / 1.8));
    colour.lerpColors(GROUND, SKY, t * t * (3 - 2 * t));
    const texel = [colour.r, colour.g, colour.b, 1].map(DataUtils.toHalfFloat);
    for (let column = 0; column < width; ++column) data.set(texel, 4 * (row * width + column));
  }
  const texture = new DataTexture(data, width, height);
  texture.type = HalfFloatType;
  texture.mapping = EquirectangularReflectionMapping;
  texture.minFilter = texture.magFilter = LinearFilter;
  texture.needsUpdate = true;
  return texture;
}

export function vec3({ r, g, b }: Color): string {
  return `vec3(${r.toFixed(4)}, ${g.toFixed(4)}, ${b.toFixed(4)})`;
}
