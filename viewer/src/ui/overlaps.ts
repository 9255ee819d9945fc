// What the scene starts inside each other, in words.

import type { Overlap } from "../protocol/types";
import { significant } from "./format";

/** One line for each pair of bodies. */
export function overlapLines(overlaps: readonly Overlap[]): string[] {
  return overlaps.map(({ bodies: [a, b], depth, place }) => {
    const at = place.map((x) => (1e3 * x).toFixed(0)).join(", ");
    return `${a} and ${b} start ${significant(1e3 * depth, 2)} mm inside each other, at ${at} mm.`;
  });
}

/** All in one remark, or null. */
export function overlapRemark(overlaps: readonly Overlap[]): string | null {
  const [first, ...rest] = overlapLines(overlaps);
  if (first === undefined) return null;
  const more = rest.length === 1 ? " One more pair does." : ` ${rest.length} more pairs do.`;
  return rest.length === 0 ? first : `${first}${more} The Run panel lists them.`;
}
