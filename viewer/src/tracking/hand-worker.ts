// The thread that looks at pictures, with MediaPipe's hand landmarker: the page goes on drawing meanwhile.

import { HandLandmarker, type HandLandmarkerResult } from "@mediapipe/tasks-vision";
import type { FromTracker, ToTracker, TrackedHand } from "./hand-messages";
import { serveTracker, type Look } from "./hand-service";

/** From the landmarker's lists to hands. */
function handsOf({ landmarks, worldLandmarks, handedness }: HandLandmarkerResult): TrackedHand[] {
  const plain = ({ x, y, z }: { x: number; y: number; z: number }) => ({ x, y, z });
  return landmarks.flatMap((picture, i): TrackedHand[] => {
    const [likely] = handedness[i] ?? [];
    if (likely === undefined || worldLandmarks[i] === undefined) return [];
    // Of pictures as the camera sees them, not mirrored; MediaPipe Hands had it the other way round.
    const side = likely.categoryName === "Left" ? "left" : "right";
    return [{ side, score: likely.score, picture: picture.map(plain), metres: worldLandmarks[i].map(plain) }];
  });
}

/** Smallest WebAssembly module that uses a SIMD instruction. */
const SIMD = new Uint8Array([
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11,
]);

async function open(folder: string): Promise<Look> {
  if (!WebAssembly.validate(SIMD)) throw new Error("this browser is too old for it and lacks WebAssembly SIMD");
  const model = await fetch(`${folder}hand.task`, { method: "HEAD" });
  if (!model.ok) throw new Error("this page was built without it");
  const fileset = {
    wasmLoaderPath: `${folder}vision_wasm_module_internal.js`,
    wasmBinaryPath: `${folder}vision_wasm_module_internal.wasm`,
  };
  const tracker = await HandLandmarker.createFromOptions(fileset, {
    // The graphics card draws the page; a hand takes a processor some 20 ms.
    baseOptions: { modelAssetPath: `${folder}hand.task`, delegate: "CPU" },
    runningMode: "VIDEO",
    numHands: 2,
    minHandDetectionConfidence: 0.6,
    minHandPresenceConfidence: 0.5,
    minTrackingConfidence: 0.5,
  });
  return (picture, time) => handsOf(tracker.detectForVideo(picture, time));
}

const answer = (message: FromTracker) => self.postMessage(message);
const serve = serveTracker(open, answer);
self.addEventListener("message", ({ data }: MessageEvent<ToTracker>) => void serve(data));
