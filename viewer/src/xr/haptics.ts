// Where the visitor also holds something that can vibrate, it does so with the force of that hand.

import type { Side } from "../protocol/types";
import { forceShare } from "./forces";

/** Renewed this often, and as long, s. */
const PULSE_S = 0.03;

interface Vibrating {
  pulse(value: number, milliseconds: number): Promise<unknown>;
}

export class Haptics {
  private last = -Infinity;

  /** `force` in newtons of a whole hand; `time` in seconds. */
  update(sources: Iterable<XRInputSource>, force: (side: Side) => number, time: number): void {
    if (time - this.last < PULSE_S) return;
    this.last = time;
    for (const source of sources) {
      const vibrating = actuator(source);
      if (vibrating === null || source.handedness === "none") continue;
      const share = forceShare(force(source.handedness));
      // A pulse that comes too late or is refused is no more than a pulse missed.
      if (share > 0.05) vibrating.pulse(share, 1000 * PULSE_S).catch(() => undefined);
    }
  }
}

/** WebXR's `hapticActuators` is not in the published types of gamepads. */
function actuator(source: XRInputSource): Vibrating | null {
  const gamepad = source.gamepad as (Gamepad & { hapticActuators?: readonly Vibrating[] }) | undefined;
  const first = gamepad?.hapticActuators?.[0];
  return typeof first?.pulse === "function" ? first : null;
}
