import { defineConfig } from "vitest/config";
import { mediapipe } from "./build/mediapipe.ts";

// Where the built page goes: the cargo build sets THENAR_PAGE_OUT; by hand it is viewer/dist.
const outDir = process.env["THENAR_PAGE_OUT"] ?? "dist";
// Which `thenar serve` the development server passes the socket on to.
const server = process.env["THENAR_SERVER"] ?? "http://127.0.0.1:8014";

export default defineConfig({
  base: "./",
  plugins: [mediapipe()],
  build: {
    outDir,
    emptyOutDir: true,
    target: "es2022",
    modulePreload: { polyfill: false },
    // The server's content security policy allows files of its own only, no data: addresses.
    assetsInlineLimit: 0,
    reportCompressedSize: false,
    chunkSizeWarningLimit: 1200,
  },
  // The thread that tracks hands loads MediaPipe's WebAssembly as a module.
  worker: { format: "es" },
  // The server takes a page of its own origin only.
  server: {
    proxy: { "/live": { target: server, ws: true, changeOrigin: true, rewriteWsOrigin: true } },
  },
  test: {
    include: ["test/**/*.test.ts", "src/**/*.test.ts"],
    environment: "node",
    // Machines that build beside are slow.
    testTimeout: 60_000,
  },
});
