// Loads modules of the page for node's test runner: Vite turns the TypeScript into JavaScript as it does for the browser.
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { after } from "node:test";
import { createServer } from "vite";

const root = join(dirname(fileURLToPath(import.meta.url)), "../..");
const server = await createServer({
  root,
  configFile: false,
  appType: "custom",
  logLevel: "error",
  optimizeDeps: { noDiscovery: true, include: [] },
  server: { middlewareMode: true, hmr: false, ws: false, watch: null },
});
after(() => server.close());

/** The module `src/NAME`. */
export function load(name) {
  return server.ssrLoadModule(`/src/${name}`);
}
