// What a model says overlaps at the start, as it reaches a reader.

import { describe, expect, it } from "vitest";
import { decode } from "../../src/protocol/decode";
import { overlapLines, overlapRemark } from "../../src/ui/overlaps";
import { Arrays, encodeModel, encodeWorld, worldJson } from "../encode-world";

function overlaps(list: unknown) {
  const arrays = new Arrays();
  const message = decode(encodeModel({ ...worldJson(arrays), overlaps: list }, arrays, 1), null, 0);
  if (message.kind !== "model") throw new Error(message.kind);
  return message.model.overlaps;
}

const THUMB = { bodies: ["r (thumb)", "table"], depth: 0.0042, place: [0.06, 0.09, -0.0349] };

describe("what overlaps at the start", () => {
  it("is told with pair, depth and place", () => {
    expect(overlapLines(overlaps([THUMB]))).toEqual([
      "r (thumb) and table start 4.2 mm inside each other, at 60, 90, -35 mm.",
    ]);
    expect(overlapRemark(overlaps([THUMB]))).toBe(overlapLines(overlaps([THUMB]))[0]);
    expect(overlapRemark(overlaps([THUMB, THUMB]))).toMatch(/ One more pair does\. The Run panel lists them\.$/);
    expect(overlapRemark(overlaps([THUMB, THUMB, THUMB]))).toMatch(/ 2 more pairs do\./);
  });

  it("names twenty pairs and counts the rest", () => {
    const lines = overlapLines(overlaps(Array.from({ length: 23 }, () => THUMB)));
    expect(lines.length).toBe(21);
    expect(lines[20]).toBe("3 more pairs do, no deeper.");
    expect(overlapLines(overlaps(Array.from({ length: 21 }, () => THUMB)))[20]).toBe("One more pair does, no deeper.");
  });

  it("is nothing where nothing does", () => {
    expect(overlapRemark(overlaps([]))).toBeNull();
    const message = decode(encodeWorld(), null, 0);
    expect(message.kind === "model" && message.model.overlaps).toEqual([]);
  });

  it("is refused when broken", () => {
    expect(() => overlaps([{ ...THUMB, bodies: ["table"] }])).toThrow(/1 bodies instead of 2/);
    expect(() => overlaps([{ ...THUMB, depth: "deep" }])).toThrow(/depth/);
  });
});
