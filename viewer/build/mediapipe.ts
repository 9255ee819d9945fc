// Puts MediaPipe Hands into the page as plain files under mediapipe/, to be had offline. Only what the
// page asks for: SIMD WebAssembly and the lite models; 10.4 MB instead of 24.

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import type { Plugin } from "vite";

const PACKAGE = dirname(createRequire(import.meta.url).resolve("@mediapipe/hands/package.json"));
const PLAIN = [
  "hands.js",
  "hands.binarypb",
  "hand_landmark_lite.tflite",
  "hands_solution_simd_wasm_bin.js",
  "hands_solution_simd_wasm_bin.wasm",
];
const PACK = "hands_solution_packed_assets.data";
const LOADER = "hands_solution_packed_assets_loader.js";

interface PackedFile {
  readonly filename: string;
  readonly start: number;
  readonly end: number;
}

/** The pack holds two palm detectors; the full one is never used here. Data and loader that fit. */
function cutPack(): { data: Buffer; loader: string } {
  const data = readFileSync(join(PACKAGE, PACK));
  const loader = readFileSync(join(PACKAGE, LOADER), "utf8");
  const call = /loadPackage\((\{"files": .*\})\);/.exec(loader);
  if (call === null) throw new Error(`${LOADER} is not as expected.`);
  const { files } = JSON.parse(call[1]) as { files: PackedFile[] };
  const kept: PackedFile[] = [];
  const parts: Buffer[] = [];
  let size = 0;
  for (const { filename, start, end } of files) {
    if (filename.endsWith("palm_detection_full.tflite")) continue;
    kept.push({ filename, start: size, end: size + end - start });
    parts.push(data.subarray(start, end));
    size += end - start;
  }
  const described = JSON.stringify({ files: kept, remote_package_size: size });
  return {
    data: Buffer.concat(parts),
    loader: `// Changed: the full palm detector is left out.\n${loader.replace(call[1], described)}`,
  };
}

const NOTICE = `MediaPipe Hands 0.4.1675469240, Copyright The MediaPipe Authors (Google).
Licensed under the Apache License, Version 2.0: http://www.apache.org/licenses/LICENSE-2.0
Changed: ${PACK} and its loader are without the full palm detector.
`;

function files(): Map<string, Buffer | string> {
  const all = new Map<string, Buffer | string>(
    PLAIN.map((name) => [name, readFileSync(join(PACKAGE, name))]),
  );
  const { data, loader } = cutPack();
  return all.set(PACK, data).set(LOADER, loader).set("NOTICE.txt", NOTICE);
}

export function mediapipe(): Plugin {
  return {
    name: "mediapipe",
    generateBundle() {
      for (const [name, source] of files()) {
        this.emitFile({ type: "asset", fileName: `mediapipe/${name}`, source });
      }
    },
    configureServer(server) {
      const all = files();
      server.middlewares.use((request, response, next) => {
        const name = /\/mediapipe\/([\w.]+)$/.exec(request.url ?? "")?.[1];
        const file = name === undefined ? undefined : all.get(name);
        if (name === undefined || file === undefined) return next();
        const type = name.endsWith(".js") ? "text/javascript" : name.endsWith(".wasm") ? "application/wasm" : "application/octet-stream";
        response.setHeader("Content-Type", type).end(file);
      });
    },
  };
}
