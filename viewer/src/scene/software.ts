/** Whether what draws is no graphics card but the processor. */

const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;

/** By the name that a WebGL context gives its renderer. */
export function isSoftware(renderer: string): boolean {
  return SOFTWARE.test(renderer);
}

/** Asks a context of its own, since samples at edges are chosen before the page's is made. False where there is none. */
export function drawsInSoftware(): boolean {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (!gl) return false;
  const names = gl.getExtension("WEBGL_debug_renderer_info");
  const name: unknown = gl.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return typeof name === "string" && isSoftware(name);
}
