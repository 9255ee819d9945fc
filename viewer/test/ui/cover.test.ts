import { expect, it } from "vitest";
import { coveredBy } from "../../src/ui/cover";

const LOW = { bottom: 390, height: 390 };

it("a low picture is covered from the highest bar that shows down to its edge", () => {
  const hidden = { top: 0, height: 0 };
  const [dock, clock] = [{ top: 280, height: 57 }, { top: 343, height: 41 }];
  expect(coveredBy(LOW, [hidden, dock, clock])).toBe(110);
  expect(coveredBy(LOW, [hidden, clock])).toBe(47);
  expect(coveredBy(LOW, [hidden])).toBe(0);
  // Bars below the picture, as beside the buttons of a phone, cover nothing.
  expect(coveredBy({ bottom: 142, height: 142 }, [{ top: 150, height: 41 }])).toBe(0);
});

it("a high picture has room for both", () => {
  expect(coveredBy({ bottom: 720, height: 720 }, [{ top: 560, height: 150 }])).toBe(0);
});
