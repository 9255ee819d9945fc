// Icons as strokes in a 24 × 24 box.

import { svg } from "./dom";

export const ICONS = {
  run: "M6 4l14 8-14 8z",
  pause: "M8 5v14M16 5v14",
  step: "M5 5l9 7-9 7zM18 5v14",
  reset: "M4 4v6h6M4.6 14a8 8 0 1 0 1.3-7.2L4 10",
  input:
    "M8 12V5a1.6 1.6 0 0 1 3.2 0v5-6.400a1.600 1.600 0 0 1 3.200 0V11 5.500a1.600 1.600 0 0 1 3.200 0V14c0 4-2.400 7-6 7-3.200 0-4.600-1.600-6.200-4.600L3.800 13a1.500 1.500 0 0 1 2.500-1.600L8 13.500",
  layers: "M12 3l9 5-9 5-9-5zM3 12.500l9 5 9-5M3 17l9 5 9-5",
  forces: "M3 20V4M3 20h18M6 15l4-6 4 4 6-8",
  physics: "M4 7h9M17 7h3M4 17h3M11 17h9M15 4.500v5M9 14.500v5",
  record: "M12 4a8 8 0 1 0 0 16 8 8 0 0 0 0-16zM12 9a3 3 0 1 0 0 6 3 3 0 0 0 0-6z",
  picture: "M4 7h4l2-3h4l2 3h4v13H4zM12 9.500a4 4 0 1 0 0 8 4 4 0 0 0 0-8z",
  help: "M9 9a3 3 0 1 1 4.500 2.600c-1 .6-1.500 1.200-1.500 2.400M12 17.500v.1M12 3a9 9 0 1 0 0 18 9 9 0 0 0 0-18z",
} as const;

export function icon(path: string): SVGSVGElement {
  return svg(
    "svg",
    { viewBox: "0 0 24 24", width: 20, height: 20, "aria-hidden": "true", class: "icon" },
    svg("path", { d: path }),
  );
}
