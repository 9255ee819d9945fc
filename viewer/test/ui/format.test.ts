import { describe, expect, it } from "vitest";
import { bytes, fileStem, fixed, namePaper, plainPowers, quantity, significant, typedNumber, unitWords } from "../../src/ui/format";

describe("numbers for people", () => {
  it("have three significant digits, and exponents only where zeros would be counted", () => {
    const said = [0.00123, 12.345, 4560, 0.1 + 0.2, 2e9, 2.346e-6, -0.5, 999999, 0, NaN].map((x) => significant(x));
    expect(said).toEqual(["0.00123", "12.3", "4560", "0.3", "2×10⁹", "2.35×10⁻⁶", "-0.5", "999999", "0", "–"]);
  });

  it("can be typed back in", () => {
    for (const x of [1e-9, 3.25e-5, 0.0167, 1, 12345, 5e6, 2.5e12]) {
      expect(Math.abs(typedNumber(significant(x, 4)) / x - 1)).toBeLessThan(5e-4);
    }
  });

  it("are taken as people type them, and nothing else is", () => {
    const typed = ["3.068×10¹¹", "2e9", "5 * 10^-6", "10^3", "−0.5", "1·10⁻²", " 42 ", "10⁹", "-2×10⁹"].map(typedNumber);
    expect(typed).toEqual([3.068e11, 2e9, 5e-6, 1000, -0.5, 0.01, 42, 1e9, -2e9]);
    for (const text of ["", " ", "soft", "1,5", "2×3", "2*100", "1.5²", "2e3×10²"]) expect(typedNumber(text)).toBeNaN();
  });

  it("stand with their unit, pure ones alone", () => {
    expect([quantity(3.068e11, "N/m^4"), quantity(0.8, "1")]).toEqual(["3.07×10¹¹ N/m⁴", "0.8"]);
  });

  it("keep their decimals, and sizes their units", () => {
    expect([fixed(1, 2), fixed(Infinity, 2), bytes(999), bytes(12_345), bytes(3.21e8)]).toEqual([
      "1.00", "–", "999 B", "12 kB", "321 MB",
    ]);
  });

  it("and names fit for files", () => {
    expect([fileStem("Bread grasp / ä!"), fileStem("../../x"), fileStem("")]).toEqual(["bread-grasp", "x", "thenar"]);
  });
});

it("units have raised powers", () => {
  expect(["N/m^4", "kg/m^3", "m/s^2", "kPa", "1"].map(unitWords)).toEqual(["N/m⁴", "kg/m³", "m/s²", "kPa", "1"]);
});

it("texts of the server have powers of ten as people write them", () => {
  expect(plainPowers("At 1e9 N/m^4 and 2.5e-3 s; e9 and 0x1e9 stay.")).toBe("At 10⁹ N/m⁴ and 2.5×10⁻³ s; e9 and 0x1e9 stay.");
});

it("a scene's figure is that of a paper with a name", () => {
  expect(namePaper("After Fig. 7 of the paper.")).toBe("After Fig. 7 of the paper by Garre et al. (2011).");
  expect(namePaper("The paper's pyramid is weaker.")).toBe("The paper's pyramid is weaker.");
});
