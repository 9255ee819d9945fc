// The line under a dragged hand ends on what is highest below it.

import { Vector3 } from "three";
import { expect, it } from "vitest";
import { DropMark, fleshBelow } from "../src/scene/drop-mark";

it("flesh is met at its highest node near the vertical and below the place", () => {
  // Two nodes of something else, then: low, high, high but 30 mm aside, above the place.
  const nodes = Float32Array.from([0, 0.09, 0, 0, 0.09, 0, 0, 0.01, 0, 0.01, 0.05, 0, 0.03, 0.06, 0, 0, 0.2, 0]);
  expect(fleshBelow(new Vector3(0, 0.1, 0), nodes, 2, 6)).toBeCloseTo(0.05, 7);
  expect(fleshBelow(new Vector3(0, 0.04, 0), nodes, 2, 6)).toBeCloseTo(0.01, 7);
  expect(fleshBelow(new Vector3(0, 0.1, 0.5), nodes, 2, 6)).toBeNull();
});

it("the line goes from the place down to the surface, and shows only where there is one below", () => {
  const mark = new DropMark();
  mark.show(new Vector3(0.02, 0.1, 0.03), 0.04);
  expect(mark.group.visible).toBe(true);
  expect(mark.group.position.toArray()).toEqual([0.02, 0.04, 0.03]);
  expect(mark.group.children[0].scale.y).toBeCloseTo(0.06, 12);
  mark.show(new Vector3(0, 0.1, 0), null);
  expect(mark.group.visible).toBe(false);
  mark.show(new Vector3(0, 0.03, 0), 0.04);
  expect(mark.group.visible).toBe(false);
});
