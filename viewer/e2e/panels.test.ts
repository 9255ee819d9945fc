// Every layer, panel and input, worked as a visitor works them.

import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import type { Browser, Page } from "playwright-core";
import { afterAll, afterEach, beforeAll, expect, test } from "vitest";
import { LAYERS } from "../src/scene/layers";
import { grows, launch, open, read, until } from "./support/browser";
import { difference, histogram, picture } from "./support/pixels";
import { Server } from "./support/server";

let server: Server;
let browser: Browser;

beforeAll(async () => {
  server = await Server.start("bread-grasp");
  browser = await launch();
});

afterEach(async () => {
  for (const context of browser.contexts()) await context.close();
});

afterAll(async () => {
  await browser?.close();
  await server?.stop();
});

/** Opens a panel by its button. */
async function panel(page: Page, id: string): Promise<void> {
  const tab = page.locator(`.rail [aria-controls="panel-${id}"]`);
  if ((await tab.getAttribute("aria-expanded")) !== "true") await tab.click();
  await page.locator(`#panel-${id}`).waitFor();
}

/** Opens the page with the simulation running, whatever the visitor before left behind. */
async function running(hash = ""): Promise<Awaited<ReturnType<typeof open>>> {
  const opened = await open(browser, server.url, { hash });
  await until(opened.page, (t) => t.inControl);
  await read(opened.page, (t) => t.app.connection.send({ type: "run", paused: false }));
  return opened;
}

/** Opens the page at a moment of a scene and stops there. */
async function at(hash: string, pixelRatio = 0.5): Promise<Awaited<ReturnType<typeof open>>> {
  const opened = await open(browser, server.url, { hash, pixelRatio });
  const end = Date.now() + 60_000;
  while ((await opened.page.evaluate(() => document.documentElement.dataset["moment"])) !== "reached") {
    if (Date.now() > end) throw new Error(`the moment of ${hash} was not reached`);
    await opened.page.waitForTimeout(50);
  }
  return opened;
}

test("every layer changes the picture and can be taken back", { timeout: 240_000 }, async () => {
  // While the fingers press on the loaf there is something to see in each.
  const { page, problems } = await at("#scene=bread-grasp&t=1.9");
  await panel(page, "layers");
  const before = await picture(page);
  for (const layer of LAYERS) {
    const box = page.locator(`[data-layer="${layer}"]`);
    await box.click();
    // Bones show through the skin only where it is drawn translucent; all show at least some pixels.
    const changed = difference(before, await picture(page));
    expect(changed, `layer ${layer}`).toBeGreaterThan(0);
    await box.click();
    expect(difference(before, await picture(page)), `layer ${layer}, taken back`).toBeLessThan(1e-3);
  }
  expect(problems).toEqual([]);
});

test("pause, single step, reset and slow motion", async () => {
  const { page, problems } = await at("#scene=bread-grasp&t=1.0");
  const time = (): Promise<number> => read(page, (t) => t.snapshot!.time);
  const paused = await time();
  const step = await read(page, (t) => t.model!.time_step);
  await page.waitForTimeout(500);
  expect(await time()).toBe(paused);
  await page.getByRole("button", { name: /One step/ }).click();
  await expect.poll(time, { timeout: 60_000 }).toBeGreaterThan(paused);
  expect(await time()).toBeCloseTo(paused + step, 6);
  await page.getByRole("button", { name: /Back to the start/ }).click();
  await until(page, (t) => t.snapshot!.time < 0.1);
  await panel(page, "run");
  await page.getByRole("slider", { name: "Speed" }).fill("500");
  await until(page, (t) => t.app.connection.status!.speed < 0.5);
  const slow = await read(page, (t) => t.app.connection.status!.speed);
  await page.keyboard.press("p");
  await until(page, (t) => !t.app.connection.status!.paused);
  await until(page, (t) => t.snapshot!.time > 0.1);
  expect(await read(page, (t) => t.snapshot!.speed)).toBeLessThan(slow * 1.3);
  await read(page, (t) => t.app.connection.send({ type: "speed", value: 1 }));
  expect(problems).toEqual([]);
});

test("a setting acts on the physics at once: things fall as the Moon would have them", async () => {
  const { page, problems } = await running("#scene=falling-box");
  await until(page, (t) => t.model!.scene === "falling-box");
  await panel(page, "physics");
  const row = page.locator(".setting", { has: page.locator('[data-setting="gravity"]') });
  const field = row.locator('input.value');
  await field.fill("1.62");
  await field.press("Enter");
  await until(page, (t) => t.app.connection.status!.settings.some((s) => s.key === "gravity" && s.value === 1.62));
  await page.getByRole("button", { name: /Back to the start/ }).click();
  const seen = await page.evaluate(async () => {
    const thenar = window.thenar;
    const box = thenar.model!.rigids.findIndex((rigid) => !rigid.fixed);
    const heights: [number, number][] = [];
    await new Promise<void>((done) => {
      const stop = thenar.app.connection.on("snapshot", (snapshot) => {
        heights.push([snapshot.time, snapshot.rigids[7 * box + 1]!]);
        if (snapshot.time > 0.25 && heights.length > 5 && snapshot.time < 0.5) {
          stop();
          done();
        }
        if (snapshot.time > 0.5) heights.length = 0;
      });
    });
    return { heights: heights.filter(([time]) => time <= 0.26), h: thenar.model!.time_step };
  });
  // Steps of backward Euler: y falls by g t (t + h) / 2.
  const [t0, y0] = seen.heights[0]!;
  const fallen = (t: number): number => (1.62 * t * (t + seen.h)) / 2;
  for (const [t, y] of seen.heights) expect(y0 - y).toBeCloseTo(fallen(t) - fallen(t0), 4);
  expect(seen.heights.length).toBeGreaterThan(3);
  await page.getByRole("button", { name: "Back to the scene's values" }).click();
  await until(page, (t) => t.app.connection.status!.settings.some((s) => s.key === "gravity" && Number(s.value) > 9.8));
  await read(page, (t) => t.app.connection.send({ type: "scene", name: "bread-grasp" }));
  await until(page, (t) => t.model!.scene === "bread-grasp");
  expect(problems).toEqual([]);
});

test("large numbers are written, taken and read aloud as people write them", async () => {
  const { page, problems } = await running("#scene=bread-grasp");
  await panel(page, "physics");
  const field = page.getByLabel("Flesh on bone, N/m⁴");
  await expect.poll(() => field.inputValue()).toMatch(/^\d(\.\d+)?×10[⁰¹²³⁴-⁹]+$/);
  const own = await field.inputValue();
  await field.fill("2×10¹⁰");
  await field.press("Enter");
  await until(page, (t) => t.app.connection.status!.settings.some((s) => s.label === "Flesh on bone" && s.value === 2e10));
  const slider = page.getByRole("slider", { name: "Flesh on bone" });
  expect(await slider.getAttribute("aria-valuetext")).toBe("2×10¹⁰ N/m⁴");
  expect(await page.getByRole("slider", { name: "Strength" }).getAttribute("aria-valuetext")).toBe("1");
  // Nothing in the panels has powers of ten or units as programs write them.
  expect(await page.locator("#panel-physics").textContent()).not.toMatch(/\de\d|\^\d/);
  await page.getByRole("button", { name: "Flesh on bone: back to the scene's value" }).click();
  await expect.poll(() => field.inputValue()).toBe(own);
  await panel(page, "run");
  await page.getByText(/After Fig\. 1, centre, of the paper by Garre et al\. \(2011\)/).waitFor();
  expect(problems).toEqual([]);
});

test("the visitor's hand takes over by mouse and keys, and gives it back", async () => {
  const { page, problems } = await running("#scene=bread-grasp&camera=scene");
  const wrist = (): Promise<number[]> =>
    read(page, (t) => Array.from(t.snapshot!.rigids.subarray(7 * t.model!.hands[0]!.bone_start, 7 * t.model!.hands[0]!.bone_start + 3)));
  await panel(page, "input");
  await page.getByRole("button", { name: "Open", exact: true }).click();
  await until(page, (t) => (t.snapshot!.flags & 32) !== 0);
  const start = await wrist();
  // Pick the hand where its wrist is drawn and pull it up by 150 pixels.
  const [x, y] = await page.evaluate(() => {
    const { stage } = window.thenar.app;
    const hand = window.thenar.model!.hands[0]!;
    const at = 7 * (hand.bone_start + 0);
    const p = window.thenar.snapshot!.rigids;
    const v = stage.world.localToWorld(stage.world.position.clone().set(p[at]!, p[at + 1]!, p[at + 2]!)).project(stage.camera);
    const box = stage.canvas.getBoundingClientRect();
    return [box.left + (box.width * (v.x + 1)) / 2, box.top + (box.height * (1 - v.y)) / 2] as const;
  });
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let i = 1; i <= 15; i++) {
    await page.mouse.move(x, y - 10 * i);
    await page.waitForTimeout(30);
  }
  await page.mouse.up();
  await expect.poll(async () => (await wrist())[1]! - start[1]!, { timeout: 20_000 }).toBeGreaterThan(0.03);
  // Closing by the slider curls the fingers: the index fingertip comes nearer to the palm.
  const reach = (): Promise<number> =>
    read(page, (t) => {
      const hand = t.model!.hands[0]!;
      const bone = hand.bones.findIndex((b) => b.name.endsWith("index-distal"));
      const [p, a, b] = [t.snapshot!.rigids, 7 * hand.bone_start, 7 * (hand.bone_start + bone)];
      return Math.hypot(p[a]! - p[b]!, p[a + 1]! - p[b + 1]!, p[a + 2]! - p[b + 2]!);
    });
  const openReach = await reach();
  await page.getByRole("slider", { name: "Grasp" }).fill("1000");
  await expect.poll(reach, { timeout: 20_000 }).toBeLessThan(openReach - 0.015);
  await page.keyboard.press("Escape");
  await until(page, (t) => (t.snapshot!.flags & 32) === 0);
  expect(problems).toEqual([]);
});

test("one button lets go of what the hand grips, another grips or says why not", { timeout: 120_000 }, async () => {
  // The script has lifted the ball, and puts it down at 4.7 s.
  const { page, problems } = await at("#scene=ball-grip&t=3.2");
  const height = (): Promise<number> =>
    read(page, (t) => t.snapshot!.rigids[7 * t.model!.rigids.findIndex((rigid) => rigid.name === "ball") + 1]!);
  expect(await height()).toBeGreaterThan(0.08);
  await panel(page, "input");
  await page.getByRole("button", { name: "Let go (Shift J)" }).click();
  await page.keyboard.press("p");
  await until(page, (t) => t.snapshot!.time > 4.2);
  expect(await height()).toBeLessThan(0.03);
  // Where nothing is there is nothing to grip.
  await read(page, (t) => t.app.connection.send({ type: "scene", name: "free-motion" }));
  await until(page, (t) => t.model!.scene === "free-motion");
  await page.getByLabel("Kind of grip").selectOption("tripod");
  await page.getByRole("button", { name: "Grip what is under the hand (J)" }).click();
  await page.getByText(/nothing is within \d+ mm of the pads/).waitFor();
  expect(problems).toEqual([]);
});

test("scenes without a hand show what presses on their bodies", { timeout: 240_000 }, async () => {
  const { page, problems } = await running("#scene=gripper");
  const shown = page.locator("#panel-forces");
  const bodies = () => shown.locator(".numbers tbody th").allTextContents();
  const go = async (name: string): Promise<void> => {
    await page.evaluate((name) => window.thenar.app.connection.send({ type: "scene", name }), name);
    await expect.poll(() => read(page, (t) => t.model!.scene), { timeout: 60_000 }).toBe(name);
  };
  await until(page, (t) => t.model!.scene === "gripper" && t.snapshot !== null);
  await panel(page, "forces");
  await expect.poll(bodies).toEqual(["gripper", "ball"]);
  await shown.getByText("This scene has no hand. What presses on each body:").waitFor();
  expect(await shown.locator(".hand-diagram, tfoot").evaluateAll((parts) => parts.map((part) => part.checkVisibility()))).toEqual([false, false]);
  expect(await shown.locator(".legend span").allTextContents()).toEqual(["gripper", "ball"]);
  // What is not said in the language of newcomers explains itself.
  const rounds = shown.locator(".facts dt", { hasText: "Solver rounds" });
  expect(await rounds.getAttribute("title")).toContain("went over all contacts");
  // The ball lies on the table, and is then gripped: something always presses on it.
  const ball = shown.locator(".numbers tbody tr", { hasText: "ball" }).locator("td").first();
  await expect.poll(async () => Number(await ball.textContent()), { timeout: 60_000 }).toBeGreaterThan(0.1);
  // Rods in empty air: nothing to list.
  await go("finger-pendulum");
  await expect.poll(bodies).toEqual([]);
  await shown.getByText("This scene has no hand, and nothing in it touches.").waitFor();
  expect(await shown.getByLabel("Plot").locator("option").allTextContents()).toEqual(["Step time", "Energy"]);
  // Fingers again where there is a hand.
  await go("bread-grasp");
  await expect.poll(bodies).toEqual(["Palm", "Thumb", "Index", "Middle", "Ring", "Little"]);
  expect(await shown.locator(".hand-diagram").isVisible()).toBe(true);
  expect(problems).toEqual([]);
});

test("a recording is replayed, saved and loaded again", async () => {
  const { page, problems } = await running();
  await panel(page, "record");
  await page.locator("#panel-record").getByRole("button", { name: "Record", exact: true }).click();
  await grows(page, (t) => t.snapshotsReceived, 60);
  await page.locator("#panel-record").getByRole("button", { name: /^Stop/ }).click();
  const [file] = await Promise.all([
    page.waitForEvent("download"),
    page.locator("#panel-record").getByRole("button", { name: "Save to a file" }).click(),
  ]);
  const path = (await file.path())!;
  expect(readFileSync(path).length).toBeGreaterThan(60 * 1000);
  await page.locator('#panel-record input[type="file"]').setInputFiles({
    name: "again.thenar-recording",
    mimeType: "application/octet-stream",
    buffer: readFileSync(path),
  });
  await until(page, (t) => !t.app.feed.live);
  const shown = await read(page, (t) => t.app.feed.snapshot!.time);
  await expect.poll(() => read(page, (t) => t.app.feed.snapshot!.time), { timeout: 20_000 }).not.toBe(shown);
  await page.getByRole("button", { name: "Back to live" }).click();
  await until(page, (t) => t.app.feed.live);
  // A file that is none is refused with its reason, and the page goes on.
  await page.locator('#panel-record input[type="file"]').setInputFiles({
    name: "no.thenar-recording",
    mimeType: "application/octet-stream",
    buffer: Buffer.from("this is no recording"),
  });
  await page.locator(".toast").first().waitFor();
  await grows(page, (t) => t.framesDrawn, 3);
  expect(problems).toEqual([]);
});

test("a picture is saved, and shows skin, bread and wood", async () => {
  const { page, problems } = await at("#scene=bread-grasp&t=3&ui=on", 1);
  await panel(page, "picture");
  const [file] = await Promise.all([
    page.waitForEvent("download"),
    page.getByRole("button", { name: "Save a picture" }).click(),
  ]);
  expect(file.suggestedFilename()).toMatch(/bread-grasp.*\.png$/);
  const png = readFileSync((await file.path())!);
  expect(png.subarray(1, 4).toString()).toBe("PNG");
  expect(png.readUInt32BE(16)).toBeGreaterThanOrEqual(640);
  const artefacts = fileURLToPath(new URL("./artefacts/", import.meta.url));
  mkdirSync(artefacts, { recursive: true });
  writeFileSync(`${artefacts}bread-grasp.png`, png);
  // Loosely: a good part is warm (skin, crust, wood), a part is the pale backdrop, none is empty.
  const { warm, pale, black } = histogram(await picture(page));
  expect(warm).toBeGreaterThan(0.15);
  expect(pale).toBeGreaterThan(0.1);
  expect(black).toBeLessThan(0.2);
  expect(problems).toEqual([]);
});

test("every panel opens by keyboard alone and names its parts", async () => {
  const { page, problems } = await running();
  const ids = await page.locator(".rail [aria-controls]").evaluateAll((tabs) =>
    tabs.map((tab) => tab.getAttribute("aria-controls")!.replace("panel-", "")),
  );
  expect(ids.length).toBeGreaterThanOrEqual(7);
  for (const id of ids) {
    const tab = page.locator(`.rail [aria-controls="panel-${id}"]`);
    await tab.focus();
    if ((await tab.getAttribute("aria-expanded")) !== "true") await page.keyboard.press("Enter");
    await page.locator(`#panel-${id}`).waitFor();
    // Whatever can be worked has a name for those who do not see it.
    const nameless = await page.locator(`#panel-${id}`).evaluate((panel) =>
      Array.from(panel.querySelectorAll<HTMLInputElement>("button, input, select"))
        .filter((e) => e.offsetParent !== null)
        .filter((e) => (e.ariaLabel ?? e.textContent ?? "").trim() === "" && (e.labels?.length ?? 0) === 0)
        .map((e) => e.outerHTML),
    );
    expect(nameless, `panel ${id}`).toEqual([]);
    // No figure is cut, however long.
    const cut = await page.locator(`#panel-${id} input.value`).evaluateAll((fields) =>
      (fields as HTMLInputElement[]).filter((e) => e.offsetParent !== null && e.scrollWidth > e.clientWidth).map((e) => e.value),
    );
    expect(cut, `panel ${id}`).toEqual([]);
  }
  expect(problems).toEqual([]);
});
