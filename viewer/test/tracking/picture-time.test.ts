// Tracking says when it is too slow for this machine.

import { expect, it } from "vitest";
import { PictureTime } from "../../src/tracking/picture-time";

it("is silent while a hand can be led, and names the median where it cannot", () => {
  const time = new PictureTime();
  expect(time.remark()).toBe("");
  for (let i = 0; i < 5; i++) time.add(0.04);
  expect(time.remark()).toBe("");
  // One slow picture of five is a hiccup: the median is still 40 ms.
  time.add(4);
  expect(time.remark()).toBe("");
  for (let i = 0; i < 3; i++) time.add(3.1);
  expect(time.remark()).toContain("3 s a picture");
  // Half a second keeps its decimal.
  for (let i = 0; i < 5; i++) time.add(0.52);
  expect(time.remark()).toContain("0.5 s a picture");
  time.reset();
  expect(time.remark()).toBe("");
});
