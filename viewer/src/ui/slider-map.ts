// A slider's position, 0 to 1000, against the value it stands for, on a linear or log scale.

export const SLIDER_STEPS = 1000;

export interface Range {
  readonly min: number;
  readonly max: number;
  readonly scale: "linear" | "log";
}

/** A log scale that reaches zero or below cannot be one. */
function isLog(range: Range): boolean {
  return range.scale === "log" && range.min > 0 && range.max > range.min;
}

export function clampTo(value: number, range: Range): number {
  return Math.min(range.max, Math.max(range.min, value));
}

export function toPosition(value: number, range: Range): number {
  if (!(range.max > range.min)) return 0;
  const v = clampTo(value, range);
  const share = isLog(range)
    ? Math.log(v / range.min) / Math.log(range.max / range.min)
    : (v - range.min) / (range.max - range.min);
  return SLIDER_STEPS * share;
}

/** The value at a position, rounded to what one slider step can tell apart. The ends are exact. */
export function fromPosition(position: number, range: Range): number {
  if (position <= 0) return range.min;
  if (position >= SLIDER_STEPS) return range.max;
  const share = position / SLIDER_STEPS;
  if (isLog(range)) {
    const value = range.min * (range.max / range.min) ** share;
    return clampTo(Number(value.toPrecision(3)), range);
  }
  const span = range.max - range.min;
  const unit = 10 ** Math.floor(Math.log10(span / SLIDER_STEPS));
  return clampTo(roundTo(range.min + span * share, unit), range);
}

function roundTo(value: number, unit: number): number {
  return Number((Math.round(value / unit) * unit).toPrecision(12));
}

/** Two values that differ by rounding only are the same: a value that went to the server and back in
 * another unit differs in its last bits. */
const ROUNDING = 1e-9;

export function sameValue(a: number | string, b: number | string): boolean {
  if (typeof a === "string" || typeof b === "string") return a === b;
  return a === b || Math.abs(a - b) <= ROUNDING * Math.max(Math.abs(a), Math.abs(b));
}
