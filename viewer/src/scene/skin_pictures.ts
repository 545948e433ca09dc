/**
 * Pictures of a face's skin, lips and eyes that lie beside the session's face: freckles, pores and irises that its
 * vertices are too few for. They are fetched once the face is seen, and all heads of one session share them.
 */
import { LinearMipmapLinearFilter, NoColorSpace, RepeatWrapping, SRGBColorSpace, Texture, type Material } from "three";

export interface SkinPictures {
  albedo: Texture;
  roughness: Texture;
  normal: Texture;
}

/** Where they lie, relative to the page. */
export type PicturePaths = Record<keyof SkinPictures, string>;

/** What an exported material says of them; null where it has none. */
export function picturePaths(material: Material): PicturePaths | null {
  const { albedo, roughness, normal } = material.userData as Partial<Record<keyof SkinPictures, unknown>>;
  if (typeof albedo !== "string" || typeof roughness !== "string" || typeof normal !== "string") return null;
  return { albedo, roughness, normal };
}

/** Throws what fetching throws, and where one is not there or is no picture. */
export async function loadPictures(paths: PicturePaths, urlOf: (path: string) => URL): Promise<SkinPictures> {
  const load = async (path: string, colour: boolean): Promise<Texture> => {
    const url = urlOf(path);
    if (url.origin !== window.location.origin) throw new Error(`${path} is not this session's.`);
    const answer = await fetch(url);
    if (!answer.ok) throw new Error(`The session did not give ${path} (${answer.status}).`);
    const texture = new Texture(await createImageBitmap(await answer.blob(), { colorSpaceConversion: "none" }));
    texture.flipY = false;
    texture.colorSpace = colour ? SRGBColorSpace : NoColorSpace;
    texture.wrapS = RepeatWrapping;
    texture.minFilter = LinearMipmapLinearFilter;
    texture.anisotropy = 4;
    texture.needsUpdate = true;
    return texture;
  };
  const loads = [load(paths.albedo, true), load(paths.roughness, false), load(paths.normal, false)] as const;
  try {
    const [albedo, roughness, normal] = await Promise.all(loads);
    return { albedo, roughness, normal };
  } catch (error) {
    for (const one of loads) void one.then((texture) => (texture.image as ImageBitmap).close()).catch(() => undefined);
    throw error;
  }
}

/** Gives back what the graphics card and the browser hold of them. */
export function dropPictures(pictures: SkinPictures): void {
  for (const texture of Object.values(pictures) as Texture[]) {
    texture.dispose();
    (texture.image as ImageBitmap).close();
  }
}
