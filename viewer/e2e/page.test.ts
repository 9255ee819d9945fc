// The page opens, draws, and what it draws moves; at every size and with several viewers.

import type { Browser } from "playwright-core";
import { afterAll, afterEach, beforeAll, expect, test } from "vitest";
import { grows, launch, open, read, until } from "./support/browser";
import { Server } from "./support/server";

let server: Server;
let browser: Browser;

beforeAll(async () => {
  server = await Server.start("bread-grasp");
  browser = await launch();
});

// A page left open by a test that failed would keep control from those after it.
afterEach(async () => {
  for (const context of browser.contexts()) await context.close();
});

afterAll(async () => {
  await browser?.close();
  expect(await server?.stop(), "Ctrl-C ends the program cleanly").toBe(0);
});

test("the page opens without an error and its mesh moves", async () => {
  const { page, problems } = await open(browser, server.url);
  // Of one snapshot: a step of a slow machine may come between two reads, and move the mesh far enough by itself.
  const { nodes: before, steps } = await read(page, (t) => ({
    nodes: Array.from(t.snapshot!.nodes.slice(0, 300)),
    steps: t.snapshot!.steps,
  }));
  // The scene may be at any place of its motion, and holds still now and then: it is watched for a whole turn.
  let moved = 0;
  const end = Date.now() + 60_000;
  while (moved <= 0.005 && Date.now() < end) {
    const after = await read(page, (t) => Array.from(t.snapshot!.nodes.slice(0, 300)));
    moved = Math.max(...after.map((x, i) => Math.abs(x - before[i]!)));
  }
  expect(moved).toBeGreaterThan(0.005);
  expect(moved).toBeLessThan(0.5);
  expect(await read(page, (t) => t.snapshot!.steps)).not.toBe(steps);
  // The model of the paper's size: a hand of 16 bones with a render surface near 23 640 triangles.
  const sizes = await read(page, (t) => ({
    bones: t.model!.hands[0]!.bone_count,
    triangles: t.model!.softs.find((s) => s.hand === 0)!.render.triangles.length / 3,
    bytes: t.app.connection.throughput.bytesPerSecond,
  }));
  expect(sizes.bones).toBe(16);
  expect(sizes.triangles).toBeGreaterThan(20_000);
  expect(problems).toEqual([]);
});

test("the hand grips the loaf: forces reach the page and balance its weight", async () => {
  const { page } = await open(browser, server.url);
  // While the loaf hangs still in the air (3.2 s to 4.4 s), friction of all digits carries it.
  await until(page, (t) => t.snapshot!.time > 3.5 && t.snapshot!.time < 4.3, 60);
  const { lift, pressing } = await read(page, (t) => {
    const snapshot = t.snapshot!;
    const bread = t.model!.softs.findIndex((soft) => soft.look === "bread") + 32768;
    const contacts = snapshot.contacts;
    const force = { x: 0, y: 0, z: 0 };
    let lift = 0;
    for (let i = 0; i < contacts.count; i++) {
      const sign = contacts.bodyA(i) === bread ? 1 : contacts.bodyB(i) === bread ? -1 : 0;
      contacts.force(i, force);
      lift += sign * force.y;
    }
    const pressing = Array.from(snapshot.fingers).filter((_, i) => i % 4 === 0);
    return { lift, pressing };
  });
  // A loaf of 130 x 56 x 56 mm at 250 kg/m3 weighs at most 1.0 N, a rounded one less.
  expect(lift).toBeGreaterThan(0.5);
  expect(lift).toBeLessThan(1.1);
  expect(pressing.filter((force) => force > 0.01).length).toBeGreaterThanOrEqual(2);
});

for (const [width, height] of [
  [1280, 720],
  [390, 844],
  [1920, 1080],
] as const) {
  test(`it fits ${width}×${height}`, async () => {
    const { page, problems } = await open(browser, server.url, { width, height });
    const layout = await page.evaluate(() => {
      const canvas = document.querySelector("canvas")!.getBoundingClientRect();
      return {
        overflow: document.documentElement.scrollWidth - window.innerWidth,
        canvas: (canvas.width * canvas.height) / (window.innerWidth * window.innerHeight),
      };
    });
    expect(layout.overflow).toBeLessThanOrEqual(0);
    expect(layout.canvas).toBeGreaterThan(0.4);
    expect(problems).toEqual([]);
  });
}

test("a second viewer watches: it sees the same and changes nothing", async () => {
  const first = await open(browser, server.url);
  await until(first.page, (t) => t.inControl);
  const second = await open(browser, server.url);
  expect(await read(second.page, (t) => t.inControl)).toBe(false);
  await read(second.page, (t) => t.app.connection.send({ type: "run", paused: true }));
  await until(second.page, (t) => t.errors.length > 0);
  await until(first.page, (t) => (t.app.connection.status?.viewers ?? 0) === 2);
  await grows(first.page, (t) => t.snapshotsReceived, 20);
  expect(await read(first.page, (t) => t.app.connection.status!.paused)).toBe(false);
  // Control can be handed over.
  await read(second.page, (t) => t.app.connection.send({ type: "control", take: true }));
  await until(second.page, (t) => t.inControl);
  await until(first.page, (t) => !t.inControl);
});
