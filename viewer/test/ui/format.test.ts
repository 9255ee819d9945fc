import { describe, expect, it } from "vitest";
import { bytes, fileStem, fixed, significant, unitWords } from "../../src/ui/format";

describe("numbers for people", () => {
  it("have three significant digits, and exponents only where zeros would be counted", () => {
    const said = [0.00123, 12.345, 4560, 0.1 + 0.2, 2e9, 2.346e-6, -0.5, 999999, 0, NaN].map((x) => significant(x));
    expect(said).toEqual(["0.00123", "12.3", "4560", "0.3", "2e9", "2.35e-6", "-0.5", "999999", "0", "–"]);
  });

  it("can be typed back in", () => {
    for (const x of [1e-9, 3.25e-5, 0.0167, 1, 12345, 5e6, 2.5e12]) {
      expect(Math.abs(Number(significant(x, 4)) / x - 1)).toBeLessThan(5e-4);
    }
  });

  it("keep their decimals, and sizes their units", () => {
    expect([fixed(1, 2), fixed(Infinity, 2), bytes(999), bytes(12_345), bytes(3.21e8)]).toEqual([
      "1.00", "–", "999 B", "12 kB", "321.0 MB",
    ]);
  });

  it("and names fit for files", () => {
    expect([fileStem("Bread grasp / ä!"), fileStem("../../x"), fileStem("")]).toEqual(["bread-grasp", "x", "thenar"]);
  });
});

it("units have raised powers", () => {
  expect(["N/m^4", "kg/m^3", "m/s^2", "kPa", "1"].map(unitWords)).toEqual(["N/m⁴", "kg/m³", "m/s²", "kPa", "1"]);
});
