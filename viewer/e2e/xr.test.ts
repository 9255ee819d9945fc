// WebXR through an emulated headset: both hands are tracked and scaled to their owner, a pinch is
// followed, fingers on the loaf report contact, and everything is let go at the end.

import type { Browser, Page } from "playwright-core";
import { afterAll, afterEach, beforeAll, expect, test } from "vitest";
import { grows, launch, open, read, until } from "./support/browser";
import { Server } from "./support/server";

let server: Server;
let browser: Browser;

beforeAll(async () => {
  server = await Server.start("bread-grasp");
  browser = await launch();
});

// A page that a failed test left behind would keep control.
afterEach(async () => {
  for (const context of browser.contexts()) await context.close();
});

afterAll(async () => {
  await browser?.close();
  await server?.stop();
});

type Side = "left" | "right";

/** Moves the place where a hand pinches to a point of the simulated world, m. */
async function place(page: Page, side: Side, x: number, y: number, z: number): Promise<void> {
  await page.evaluate(
    async ([side, x, y, z]) => (await window.thenar.emulate!()).place(side, x, y, z),
    [side, x, y, z] as const,
  );
}

async function pinch(page: Page, side: Side, value: number): Promise<void> {
  await page.evaluate(
    async ([side, value]) => (await window.thenar.emulate!()).pinch(side, value),
    [side, value] as const,
  );
}

/** From the simulated thumb's to the index finger's end, right hand, m. */
async function gap(page: Page): Promise<number> {
  return read(page, (t) => {
    const model = t.model!;
    const hand = model.hands.find((candidate) => candidate.side === "right")!;
    const end = (digit: string): number[] => {
      const last = hand.bones.reduce((found, bone, i) => (bone.digit === digit ? i : found), -1);
      const at = 7 * (hand.bone_start + last);
      const [px, py, pz, x, y, z, w] = Array.from(t.snapshot!.rigids.subarray(at, at + 7)) as [
        number, number, number, number, number, number, number,
      ];
      const [a, b, c] = hand.bones[last]!.ends_B[1];
      // v + 2 q × (q × v + w v)
      const [u0, u1, u2] = [y * c - z * b + w * a, z * a - x * c + w * b, x * b - y * a + w * c];
      return [px + a + 2 * (y * u2 - z * u1), py + b + 2 * (z * u0 - x * u2), pz + c + 2 * (x * u1 - y * u0)];
    };
    const [p, q] = [end("thumb"), end("index")];
    return Math.hypot(p[0]! - q[0]!, p[1]! - q[1]!, p[2]! - q[2]!);
  });
}

/** The middle of the loaf's top, m. */
async function loaf(page: Page): Promise<readonly [number, number, number]> {
  return read(page, (t) => {
    const bread = t.model!.softs.find((soft) => soft.look === "bread")!;
    const nodes = t.snapshot!.nodes.subarray(3 * bread.node_start, 3 * bread.node_start + bread.nodes.length);
    const axis = (k: number): number[] => Array.from(nodes).filter((_, i) => i % 3 === k);
    const mean = (values: number[]): number => values.reduce((sum, v) => sum + v, 0) / values.length;
    return [mean(axis(0)), Math.max(...axis(1)), mean(axis(2))] as const;
  });
}

/** Sum of the normal forces between the loaf and any hand, N. */
async function onLoaf(page: Page): Promise<number> {
  return read(page, (t) => {
    const bodies = t.model!.softs.map((soft) => (soft.look === "bread" ? "bread" : soft.hand !== null ? "hand" : ""));
    const kind = (body: number): string => (body < 32768 ? "rigid" : (bodies[body - 32768] ?? ""));
    const { contacts } = t.snapshot!;
    let force = 0;
    for (let i = 0; i < contacts.count; i++) {
      const pair = [kind(contacts.bodyA(i)), kind(contacts.bodyB(i))];
      if (pair.includes("bread") && pair.includes("hand")) force += contacts.normalForce(i);
    }
    return force;
  });
}

test("a headset's hands are tracked, followed, and feel the loaf", { timeout: 240_000 }, async () => {
  const { page, problems } = await open(browser, server.url);
  await until(page, (t) => t.inControl);
  // Neither emulator nor hand tracker is loaded before somebody asks.
  const loaded = () =>
    page.evaluate(() => performance.getEntriesByType("resource").map((entry) => entry.name));
  expect((await loaded()).filter((name) => /emulate|mediapipe/.test(name))).toEqual([]);
  await page.evaluate(async () => {
    await window.thenar.emulate!();
    await window.thenar.app.inputs.start("xr");
  });
  expect((await loaded()).some((name) => /emulate/.test(name))).toBe(true);
  await until(page, (t) => t.tracking!.report.tracked.length === 2);
  // Away from the loaf while the hands are measured and built.
  await place(page, "right", 0.1, 0.25, 0.1);
  await place(page, "left", -0.2, 0.25, 0.1);
  await until(page, (t) => t.app.connection.status?.hands === "both" && t.app.connection.status?.loading === null && t.model?.hands.length === 2, 120);
  const sizes = await read(page, (t) => t.model!.hands.map((hand) => [hand.length, t.tracking!.report.lengths[hand.side!]!]));
  for (const [built, measured] of sizes) expect(Math.abs(built! - measured!)).toBeLessThan(1e-4);

  // Free of the loaf, the simulated hand takes on the pinch: IWER's closes to some 2 mm at the
  // skin, so the ends of the bones come within two fingers' flesh.
  await until(page, (t) => (t.snapshot!.flags & 32) !== 0);
  await page.waitForTimeout(1500);
  const openGap = await gap(page);
  expect(openGap).toBeGreaterThan(0.035);
  // Beside a build a single pinch did not arrive once.
  const pinched = async (): Promise<number> => {
    await pinch(page, "right", 1);
    return gap(page);
  };
  await expect.poll(pinched, { timeout: 90_000 }).toBeLessThan(0.6 * openGap);
  // The pinched fingers press on the loaf, wherever it lies by now: it pushes back.
  await expect
    .poll(
      async () => {
        const [x, top, z] = await loaf(page);
        await place(page, "right", x, top - 0.015, z);
        return onLoaf(page);
      },
      { timeout: 60_000, interval: 150 },
    )
    .toBeGreaterThan(0.1);
  await until(page, (t) => {
    const hand = t.model!.hands.findIndex((candidate) => candidate.side === "right");
    const digits = t.snapshot!.fingers.subarray(24 * hand, 24 * hand + 24);
    return Math.max(...Array.from(digits).filter((_, i) => i % 4 === 0)) > 0.05;
  });

  // The desk shows the forces of the hands that are led.
  const docked = (): Promise<string[]> =>
    page.locator(".dock-hand").evaluateAll((titles) => titles.map((title) => title.textContent!).sort());
  await expect.poll(docked).toEqual(["Left hand", "Right hand"]);

  // One hand goes out of sight: it is lost, the other goes on.
  await page.evaluate(async () => (await window.thenar.emulate!()).show("left", false));
  await until(page, (t) => t.tracking!.report.tracked.join() === "right");
  await expect.poll(docked, { timeout: 20_000 }).toEqual(["Right hand"]);
  await page.evaluate(async () => (await window.thenar.emulate!()).show("left", true));
  await until(page, (t) => t.tracking!.report.tracked.length === 2);
  await page.evaluate(async () => (await window.thenar.emulate!()).show("right", false));
  await expect.poll(docked, { timeout: 20_000 }).toEqual(["Left hand"]);

  await page.evaluate(() => window.thenar.app.inputs.stop());
  await until(page, (t) => !t.tracking!.report.running && t.app.connection.status?.hands === "scene" && t.app.connection.status?.loading === null, 120);
  await until(page, (t) => (t.snapshot!.flags & 32) === 0);
  // The page is whole again: the canvas is back below the panels and draws.
  expect(await page.evaluate(() => document.querySelector(".emulator") === null)).toBe(true);
  await grows(page, (t) => t.framesDrawn, 3);
  expect(problems).toEqual([]);
  await page.close();
});

/** Moves a controller's handle to a point of the simulated world, m, thumb up and fingers ahead. */
async function hold(page: Page, side: Side, x: number, y: number, z: number): Promise<void> {
  await page.evaluate(
    async ([side, x, y, z]) => (await window.thenar.emulate!()).grip(side, x, y, z),
    [side, x, y, z] as const,
  );
}

async function press(page: Page, button: "trigger" | "squeeze", value: number): Promise<void> {
  await page.evaluate(
    async ([button, value]) => (await window.thenar.emulate!()).press("right", button, value),
    [button, value] as const,
  );
}

/** Where the simulated right palm is, and how far each fingertip is from it, thumb first, m. */
async function reach(page: Page): Promise<{ palm: number[]; digits: number[] }> {
  return read(page, (t) => {
    const model = t.model!;
    const hand = model.hands.find((candidate) => candidate.side === "right")!;
    const at = (bone: number): number[] => {
      const start = 7 * (hand.bone_start + bone);
      return Array.from(t.snapshot!.rigids.subarray(start, start + 3));
    };
    const palm = at(0);
    const digits = ["thumb", "index", "middle", "ring", "little"].map((digit) => {
      const last = hand.bones.reduce((found, bone, i) => (bone.digit === digit ? i : found), -1);
      return Math.hypot(...at(last).map((x, k) => x - palm[k]!));
    });
    return { palm, digits };
  });
}

test("controllers lead the hands, and their buttons close them", { timeout: 240_000 }, async () => {
  const { page, problems } = await open(browser, server.url);
  await until(page, (t) => t.inControl);
  await page.evaluate(async () => {
    const emulator = await window.thenar.emulate!();
    emulator.hold(true);
    await window.thenar.app.inputs.start("xr");
  });
  await until(page, (t) => t.tracking!.report.tracked.length === 2);
  await until(page, (t) => t.app.connection.status?.hands === "both" && t.app.connection.status?.loading === null && t.model?.hands.length === 2, 120);
  await hold(page, "left", -0.25, 0.3, 0.15);
  await hold(page, "right", 0.15, 0.3, 0.15);
  await until(page, (t) => (t.snapshot!.flags & 32) !== 0);
  // The middle of the palm comes to the handle: within half a palm's length and its thickness.
  const away = async (): Promise<number> => {
    const { palm } = await reach(page);
    return Math.hypot(palm[0]! - 0.15, palm[1]! - 0.3, palm[2]! - 0.15);
  };
  await expect.poll(away, { timeout: 60_000 }).toBeLessThan(0.06);
  await page.waitForTimeout(1500);
  const straight = await reach(page);

  // The trigger bends the index finger, and leaves the middle one.
  const digit = async (k: number): Promise<number> => (await reach(page)).digits[k]!;
  await press(page, "trigger", 1);
  await expect.poll(() => digit(1), { timeout: 60_000 }).toBeLessThan(straight.digits[1]! - 0.015);
  expect(await digit(2)).toBeGreaterThan(straight.digits[2]! - 0.008);
  await press(page, "squeeze", 1);
  await expect.poll(() => digit(2), { timeout: 60_000 }).toBeLessThan(straight.digits[2]! - 0.015);
  await press(page, "trigger", 0);
  await press(page, "squeeze", 0);
  await expect.poll(() => digit(1), { timeout: 60_000 }).toBeGreaterThan(straight.digits[1]! - 0.005);

  // Lowered onto the loaf the hand presses, and is felt.
  await expect
    .poll(
      async () => {
        const [x, top, z] = await loaf(page);
        await hold(page, "right", x, top, z + 0.03);
        return onLoaf(page);
      },
      { timeout: 60_000, interval: 150 },
    )
    .toBeGreaterThan(0.1);

  // Laid down, they make way for bare hands.
  await page.evaluate(async () => (await window.thenar.emulate!()).hold(false));
  await place(page, "right", 0.15, 0.25, 0.15);
  await until(page, (t) => t.tracking!.report.lengths.right !== null && t.tracking!.report.tracked.length === 2, 60);
  await page.evaluate(() => window.thenar.app.inputs.stop());
  await until(page, (t) => !t.tracking!.report.running && t.app.connection.status?.hands === "scene" && t.app.connection.status?.loading === null, 120);
  expect(problems).toEqual([]);
  await page.close();
});

test("a recording brings its hands and plays them", { timeout: 240_000 }, async () => {
  const { page, problems } = await open(browser, server.url);
  await until(page, (t) => t.inControl);
  await page.evaluate(() => window.thenar.app.inputs.start("motion"));
  await until(page, (t) => (t.snapshot!.flags & 32) !== 0);
  // A built-in motion opens and closes the hand: its fingertip moves by centimetres.
  const tip = (): Promise<number[]> => read(page, (t) => {
    const hand = t.model!.hands[0]!;
    const at = 7 * (hand.bone_start + hand.bone_count - 1);
    return Array.from(t.snapshot!.rigids.subarray(at, at + 3));
  });
  const seen: number[][] = [];
  for (let i = 0; i < 12; i++) {
    seen.push(await tip());
    await page.waitForTimeout(400);
  }
  const travel = Math.max(...seen.map((p) => Math.hypot(...p.map((x, k) => x - seen[0]![k]!))));
  expect(travel).toBeGreaterThan(0.02);
  // A broken file is refused with its line, and what plays goes on.
  await page.evaluate(() => window.thenar.tracking!.motion.load(new File(["{}"], "bad.jsonl")));
  expect(await read(page, (t) => t.tracking!.motion.note)).toContain("bad.jsonl, line 1");
  expect(await read(page, (t) => t.app.inputs.active!.id)).toBe("motion");
  expect(problems).toEqual([]);
  await page.close();
});
