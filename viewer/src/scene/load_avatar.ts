/** Bytes of a .glb, .gltf without other files, or .vrm into an avatar. What goes wrong becomes a sentence for the person. */
import { VRMLoaderPlugin, VRMUtils, type VRM } from "@pixiv/three-vrm";
import type { Group } from "three";
import { GLTFLoader, type GLTF } from "three/addons/loaders/GLTFLoader.js";
import type { Avatar } from "./avatar";
import { GltfAvatar } from "./gltf_avatar";
import { VrmAvatar } from "./vrm_avatar";

/** More than any head needs; a file beyond it would make the page crawl. */
export const MOST_BYTES = 256 * 1024 * 1024;
const MOST_VERTICES = 2_000_000;

const GLB_MAGIC = 0x46546c67;

/** Whether the first bytes are those of a .glb (and a .vrm, which is one). */
export function isGlb(bytes: ArrayBuffer): boolean {
  return bytes.byteLength >= 20 && new DataView(bytes).getUint32(0, true) === GLB_MAGIC;
}

/** Why a file of this name and size is not even opened; null where it may be. */
export function refusal(name: string, size: number): string | null {
  if (!/\.(glb|vrm|gltf)$/i.test(name)) {
    return `${name} is not a .glb or .vrm. Other formats can be converted to .glb in Blender.`;
  }
  if (size > MOST_BYTES) {
    return `${name} has ${Math.round(size / 1048576)} MB; this page opens faces of at most ${MOST_BYTES / 1048576} MB.`;
  }
  if (size === 0) return `${name} is empty.`;
  return null;
}

/** Throws an `Error` whose message is for the person. `own`: the session's own face. */
export async function loadAvatar(bytes: ArrayBuffer, name: string, own: boolean): Promise<Avatar> {
  const why = own ? null : refusal(name, bytes.byteLength);
  if (why) throw new Error(why);
  if (!isGlb(bytes) && !/\.gltf$/i.test(name)) throw new Error(`${name} is not a glTF binary, whatever its name says.`);
  const loader = new GLTFLoader();
  loader.register((parser) => new VRMLoaderPlugin(parser));
  let gltf: GLTF;
  try {
    gltf = await loader.parseAsync(bytes, "");
  } catch (error) {
    throw new Error(`${name} could not be read: ${error instanceof Error ? error.message : String(error)}`);
  }
  const scene: Group = gltf.scene;
  let vertices = 0;
  scene.traverse((node) => {
    const geometry = (node as { geometry?: { attributes?: { position?: { count: number } } } }).geometry;
    vertices += geometry?.attributes?.position?.count ?? 0;
  });
  if (vertices > MOST_VERTICES) {
    throw new Error(`${name} has ${(vertices / 1e6).toFixed(1)} million vertices; this page shows at most ${MOST_VERTICES / 1e6} million.`);
  }
  const vrm = gltf.userData["vrm"] as VRM | undefined;
  if (vrm) {
    VRMUtils.removeUnnecessaryVertices(vrm.scene);
    return new VrmAvatar(vrm, name);
  }
  return new GltfAvatar(scene, { name, own });
}
