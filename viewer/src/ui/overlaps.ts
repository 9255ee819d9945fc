// What the scene starts inside each other, in words.

import type { Overlap } from "../protocol/types";
import { significant } from "./format";

/** Most pairs of bodies that are named: what a person reads. */
const NAMED_MAX = 20;

/** One line for each pair of bodies, the deepest first; one for the rest if they are many. */
export function overlapLines(overlaps: readonly Overlap[]): string[] {
  const lines = overlaps.slice(0, NAMED_MAX).map(({ bodies: [a, b], depth, place }) => {
    const at = place.map((x) => (1e3 * x).toFixed(0)).join(", ");
    return `${a} and ${b} start ${significant(1e3 * depth, 2)} mm inside each other, at ${at} mm.`;
  });
  const more = overlaps.length - lines.length;
  if (more <= 0) return lines;
  return [...lines, more === 1 ? "One more pair does, no deeper." : `${more} more pairs do, no deeper.`];
}

/** All in one remark, or null. */
export function overlapRemark(overlaps: readonly Overlap[]): string | null {
  const [first] = overlapLines(overlaps);
  if (first === undefined) return null;
  const others = overlaps.length - 1;
  const more = others === 1 ? " One more pair does." : ` ${others} more pairs do.`;
  return others === 0 ? first : `${first}${more} The Run panel lists them.`;
}
