// Registers what tracks hands: headset, emulated headset, recorded motion, webcam.

import type { App } from "../app";
import { MotionSource } from "../tracking/motion-source";
import { WebcamSource } from "../tracking/webcam-source";
import type { Emulator } from "./emulate";
import "./xr.css";
import { EmulatedSource, XrSource, type XrReport } from "./source";

export interface Tracking {
  readonly motion: MotionSource;
  readonly webcam: WebcamSource;
  readonly xr: XrSource;
  readonly report: XrReport;
  /** Puts an emulated headset in place of the browser's own WebXR. */
  emulate(): Promise<Emulator>;
}

declare module "../app" {
  interface PageStatus {
    /** What tracks hands, for tests and the curious. */
    tracking?: Tracking;
    emulate?: () => Promise<Emulator>;
  }
}

export function installTracking(app: App): Tracking {
  const vr = new XrSource(app, "immersive-vr");
  const ar = new XrSource(app, "immersive-ar");
  const motion = new MotionSource(app);
  const webcam = new WebcamSource(app);
  app.inputs.register(motion);
  app.inputs.register(webcam);
  app.inputs.register(vr);
  const emulated = new EmulatedSource(app, emulate);
  app.inputs.register(emulated);

  let emulator: Promise<Emulator> | null = null;

  async function load(): Promise<Emulator> {
    const made = await (await import("./emulate")).Emulator.install(app);
    vr.emulator = made;
    await vr.probe();
    return made;
  }

  function emulate(): Promise<Emulator> {
    emulator ??= load().catch((error: unknown) => {
      emulator = null;
      throw error;
    });
    return emulator;
  }

  void vr.probe();
  // Rare on desks: its button comes only where there is such a device.
  void ar.probe().then(() => {
    if (ar.available) app.inputs.register(ar);
  });
  const tracking: Tracking = {
    motion,
    webcam,
    xr: vr,
    emulate,
    get report() {
      return (emulated.live === null ? vr : emulated).report;
    },
  };
  window.thenar.tracking = tracking;
  window.thenar.emulate = emulate;
  if (new URLSearchParams(window.location.search).has("emulate")) void emulate();
  return tracking;
}
