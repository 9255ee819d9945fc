// Puts what the webcam's hand tracker loads into the page, as plain files under mediapipe/, to be had offline: MediaPipe's
// WebAssembly, and the lite models of MediaPipe Hands in the bundle that its successor loads; 16 MB.

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import type { Plugin } from "vite";
import { handTask } from "./hand-task.ts";

const find = createRequire(import.meta.url).resolve;
const MODELS = dirname(find("@mediapipe/hands/package.json"));
const WASM = join(dirname(find("@mediapipe/tasks-vision")), "wasm");
const PLAIN = ["vision_wasm_module_internal.js", "vision_wasm_module_internal.wasm"];
const PACK = "hands_solution_packed_assets.data";
const LOADER = "hands_solution_packed_assets_loader.js";

interface PackedFile {
  readonly filename: string;
  readonly start: number;
  readonly end: number;
}

/** The lite palm detector lies in a pack beside a full one. */
function detector(): Buffer {
  const loader = readFileSync(join(MODELS, LOADER), "utf8");
  const call = /loadPackage\((\{"files": .*\})\);/.exec(loader);
  if (call === null) throw new Error(`${LOADER} is not as expected.`);
  const { files } = JSON.parse(call[1]) as { files: PackedFile[] };
  const found = files.find(({ filename }) => filename.endsWith("palm_detection_lite.tflite"));
  if (found === undefined) throw new Error(`${PACK} has no lite palm detector.`);
  return readFileSync(join(MODELS, PACK)).subarray(found.start, found.end);
}

/** The bundle of both models. */
export function task(): Buffer {
  return handTask(detector(), readFileSync(join(MODELS, "hand_landmark_lite.tflite")));
}

const NOTICE = `MediaPipe Tasks Vision 0.10.35 and the models of MediaPipe Hands 0.4.1675469240, Copyright The MediaPipe Authors (Google).
Licensed under the Apache License, Version 2.0: http://www.apache.org/licenses/LICENSE-2.0
Changed: hand.task bundles palm_detection_lite.tflite and hand_landmark_lite.tflite; both have metadata added.
`;

function files(): Map<string, Buffer | string> {
  const all = new Map<string, Buffer | string>(PLAIN.map((name) => [name, readFileSync(join(WASM, name))]));
  return all.set("hand.task", task()).set("NOTICE.txt", NOTICE);
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
        const name = /\/mediapipe\/([\w.]+)(?:\?.*)?$/.exec(request.url ?? "")?.[1];
        const file = name === undefined ? undefined : all.get(name);
        if (name === undefined || file === undefined) return next();
        const type = name.endsWith(".js") ? "text/javascript" : name.endsWith(".wasm") ? "application/wasm" : "application/octet-stream";
        response.setHeader("Content-Type", type).end(file);
      });
    },
  };
}
