import { defineConfig } from "vite";

// `npm run dev` shows the page with changes at once and takes everything else from a session: a real `mien live`, or
// test/mock_session.mjs. Both are at this address unless MIEN_SESSION says otherwise.
const session = process.env.MIEN_SESSION ?? "http://127.0.0.1:8740";

export default defineConfig({
  base: "./",
  build: {
    target: "es2022",
    sourcemap: false,
    modulePreload: false,
    assetsInlineLimit: 100_000,
    chunkSizeWarningLimit: 1500,
    cssCodeSplit: false,
    rollupOptions: {
      // One html, one script, one style: they are embedded in the program by name.
      output: {
        inlineDynamicImports: true,
        entryFileNames: "page.js",
        assetFileNames: (asset) => (asset.names.some((name) => name.endsWith(".css")) ? "page.css" : "[name][extname]"),
      },
    },
  },
  server: {
    proxy: {
      "/ws": { target: session, ws: true },
      "/face.glb": session,
    },
  },
});
