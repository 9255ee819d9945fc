// Numbers for people.

/** Three significant digits, with a power of ten only where zeros would be counted: 0.00123, 4560, 2×10⁹. */
export function significant(value: number, digits = 3): string {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-4) {
    const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
    return `${Number(mantissa)}×10${raised(exponent)}`;
  }
  const decimals = Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
  return String(Number(value.toFixed(Math.min(decimals, 12))));
}

/** Always so many decimals, so that a changing number keeps its width. */
export function fixed(value: number, decimals: number): string {
  return Number.isFinite(value) ? value.toFixed(decimals) : "–";
}

const RAISED = "⁰¹²³⁴⁵⁶⁷⁸⁹";

/** An exponent in raised digits: e-7 has ⁻⁷, e+11 has ¹¹. */
function raised(exponent: string): string {
  const digits = [...exponent.replace(/^\+/, "")];
  return digits.map((digit) => (digit === "-" ? "⁻" : RAISED[Number(digit)])).join("");
}

/** The number that someone types: as the page writes it, with an e, or with 10^; NaN if it is none. */
export function typedNumber(text: string): number {
  const plain = text.replaceAll("−", "-").trim();
  const power = /^(?:(.*\S)\s*[×·*]\s*)?10(?:\^([+-]?\d+)|([⁻⁺]?[⁰¹²³⁴-⁹]+))$/.exec(plain);
  if (power === null) return plain === "" ? NaN : Number(plain);
  const [, mantissa = "1", written, above = ""] = power;
  const lowered = [...above].map((sign) => ({ "⁻": "-", "⁺": "+" })[sign] ?? String(RAISED.indexOf(sign)));
  return Number(`${mantissa}e${written ?? lowered.join("")}`);
}

/** A unit with its powers raised: N/m^4 becomes N/m⁴. */
export function unitWords(unit: string): string {
  return unit.replace(/\^([234])/g, (_, power: string) => raised(power));
}

/** A value with its unit; pure numbers, whose unit is 1, stand alone. */
export function quantity(value: number, unit: string): string {
  return unit === "1" ? significant(value) : `${significant(value)} ${unitWords(unit)}`;
}

/** Text with its powers of ten as people write them: 1e9 N/m^4 becomes 10⁹ N/m⁴. */
export function plainPowers(text: string): string {
  const power = (_: string, mantissa: string, exponent: string) =>
    `${mantissa === "1" ? "" : `${mantissa}×`}10${raised(exponent)}`;
  return unitWords(text).replace(/(?<![\w.])(\d+(?:\.\d+)?)e([+-]?\d+)(?!\w)/g, power);
}

/** The paper that scenes and settings follow, for those who meet it first. */
export const PAPER =
  "Garre, Hernández, Gracia and Otaduy, Interactive Simulation of a Deformable Hand for Haptic Rendering, " +
  "IEEE World Haptics Conference 2011";

/** Names the paper where a scene only speaks of it. */
export function namePaper(text: string): string {
  return text.replace(/\bthe paper\b(?!['’])/, "the paper by Garre et al. (2011)");
}

export function seconds(value: number): string {
  return `${fixed(value, 2)} s`;
}

export function bytes(value: number): string {
  if (value < 1e3) return `${value} B`;
  if (value < 1e6) return `${fixed(value / 1e3, 0)} kB`;
  return `${significant(value / 1e6, value < 1e8 ? 2 : 3)} MB`;
}

/** For a file's name: letters, digits and dashes only. */
export function fileStem(text: string): string {
  const stem = text.toLowerCase().replace(/[^a-z0-9]+/g, "-");
  return stem.replace(/^-+|-+$/g, "").slice(0, 60) || "thenar";
}
