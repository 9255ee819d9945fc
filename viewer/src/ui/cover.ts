// In a low window the bars at its lower edge lie on what there is to see: there the picture makes room.

import type { Stage } from "../scene/stage";

/** A canvas lower than this has no room for bars and objects one over the other, px: as the styles have it. */
const LOW = 560;

export interface Bar {
  /** From the top of the window, px. */
  readonly top: number;
  readonly height: number;
}

/** How much of a canvas lies behind the bars at its lower edge, px; hidden bars have no height. */
export function coveredBy(canvas: { readonly bottom: number; readonly height: number }, bars: readonly Bar[]): number {
  if (canvas.height > LOW) return 0;
  const tops = bars.filter(({ height }) => height > 0).map(({ top }) => top);
  return Math.max(0, Math.round(canvas.bottom - Math.min(canvas.bottom, ...tops)));
}

/** Keeps the picture clear of the bars, which follow one another; not while a pointer is down, so that what is dragged
 * stays under it. */
export function keepClear(stage: Stage, bars: readonly HTMLElement[]): void {
  const down = new Set<number>();
  const refresh = () => {
    if (down.size > 0) return;
    const boxes = bars.map((bar) => bar.getBoundingClientRect());
    stage.setCovered(coveredBy(stage.canvas.getBoundingClientRect(), boxes));
  };
  window.addEventListener("pointerdown", ({ pointerId }) => down.add(pointerId), { capture: true });
  for (const end of ["pointerup", "pointercancel"] as const) {
    const release = ({ pointerId }: PointerEvent) => {
      down.delete(pointerId);
      refresh();
    };
    window.addEventListener(end, release, { capture: true });
  }
  const observer = new ResizeObserver(refresh);
  for (const part of [stage.canvas, ...bars]) observer.observe(part);
}
