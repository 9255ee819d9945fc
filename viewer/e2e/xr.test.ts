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
