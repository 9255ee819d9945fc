// Numbers for people.

/** Three significant digits without an exponent where that can be read: 0.00123, 12.3, 4560. */
export function significant(value: number, digits = 3): string {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-4) {
    const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
    return `${Number(mantissa)}e${Number(exponent)}`;
  }
  const decimals = Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
  return String(Number(value.toFixed(Math.min(decimals, 12))));
}

/** Always so many decimals, so that a changing number keeps its width. */
export function fixed(value: number, decimals: number): string {
  return Number.isFinite(value) ? value.toFixed(decimals) : "–";
}

const RAISED: Readonly<Record<string, string>> = { "2": "²", "3": "³", "4": "⁴" };

/** A unit with its powers raised: N/m^4 becomes N/m⁴. */
export function unitWords(unit: string): string {
  return unit.replace(/\^([234])/g, (_, power: string) => RAISED[power]);
}

export function seconds(value: number): string {
  return `${fixed(value, 2)} s`;
}

export function bytes(value: number): string {
  if (value < 1e3) return `${value} B`;
  if (value < 1e6) return `${fixed(value / 1e3, 0)} kB`;
  return `${fixed(value / 1e6, 1)} MB`;
}

/** For a file's name: letters, digits and dashes only. */
export function fileStem(text: string): string {
  const stem = text.toLowerCase().replace(/[^a-z0-9]+/g, "-");
  return stem.replace(/^-+|-+$/g, "").slice(0, 60) || "thenar";
}
