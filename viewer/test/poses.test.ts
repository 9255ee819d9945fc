// Poses as the server reads them: offsets and lengths from docs/protocol.md.

import { describe, expect, it } from "vitest";
import { encodeAngles, encodeJoints, encodeLost } from "../src/protocol/poses";

describe("pose messages", () => {
  it("carry 25 joints in 816 bytes", () => {
    const joints = Float32Array.from({ length: 200 }, (_, i) => i / 8);
    const bytes = encodeJoints("right", 7, 12.5, joints);
    const view = new DataView(bytes);
    expect(bytes.byteLength).toBe(816);
    expect([0, 1, 2, 3].map((at) => view.getUint8(at))).toEqual([16, 3, 1, 0]);
    expect(view.getUint32(4, true)).toBe(7);
    expect(view.getFloat64(8, true)).toBe(12.5);
    // Joint 3 starts after 3 × 8 numbers of 4 bytes.
    expect(view.getFloat32(16 + 3 * 32, true)).toBe(3);
  });

  it("carry a wrist and 20 angles in 124 bytes", () => {
    const angles = Array.from({ length: 20 }, (_, i) => -i);
    const bytes = encodeAngles("left", 1, 0, [1, 2, 3, 0, 0, 0, 1], angles);
    const view = new DataView(bytes);
    expect(bytes.byteLength).toBe(124);
    expect([0, 2].map((at) => view.getUint8(at))).toEqual([17, 0]);
    expect(view.getFloat32(16 + 4 * 6, true)).toBe(1);
    expect(view.getFloat32(44 + 4 * 19, true)).toBe(-19);
  });

  it("say in 16 bytes that a hand is lost", () => {
    const bytes = encodeLost("right", 9, 2);
    expect(bytes.byteLength).toBe(16);
    expect(new DataView(bytes).getUint8(0)).toBe(18);
  });

  it("refuse another number of joints", () => {
    expect(() => encodeJoints("left", 1, 0, new Float32Array(199))).toThrow(RangeError);
  });
});
