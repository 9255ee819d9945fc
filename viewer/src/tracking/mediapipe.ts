// MediaPipe Hands, loaded from the page's own files when somebody asks for the webcam.

import type { Hands, Results } from "@mediapipe/hands";

declare global {
  interface Window {
    Hands?: typeof Hands;
  }
}

const FOLDER = "mediapipe/";

const address = (file: string) => new URL(FOLDER + file, document.baseURI).href;

let script: Promise<void> | null = null;

/** It is an old-style script that puts its class on the window. */
function loadScript(): Promise<void> {
  script ??= new Promise<void>((resolve, reject) => {
    const element = document.createElement("script");
    element.src = address("hands.js");
    element.onload = () => resolve();
    element.onerror = () => {
      script = null;
      element.remove();
      reject(new Error("This page was built without webcam tracking."));
    };
    document.head.append(element);
  });
  return script;
}

/** Smallest WebAssembly module that uses a SIMD instruction. */
const SIMD = new Uint8Array([
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15,
  253, 98, 11,
]);

/** A tracker of up to two hands, ready to be sent pictures. */
export async function loadHands(onResults: (results: Results) => void): Promise<Hands> {
  if (!WebAssembly.validate(SIMD)) {
    throw new Error("This browser is too old for webcam tracking: it lacks WebAssembly SIMD.");
  }
  await loadScript();
  if (window.Hands === undefined) throw new Error("Webcam tracking did not load.");
  const hands = new window.Hands({ locateFile: address });
  hands.setOptions({
    maxNumHands: 2,
    modelComplexity: 0,
    minDetectionConfidence: 0.6,
    minTrackingConfidence: 0.5,
  });
  hands.onResults(onResults);
  await hands.initialize();
  return hands;
}
