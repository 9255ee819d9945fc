// A glove on the page, worked as its wearer works it: a simulated one behind a pseudo-terminal, armed,
// felt, stopped; and what becomes of its forces when the page goes.

import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import type { Browser, Page } from "playwright-core";
import { afterAll, afterEach, beforeAll, expect, test } from "vitest";
import { launch, open, read, until } from "./support/browser";
import { Server } from "./support/server";

const ADDRESS = /lucidgloves:/;
// Little to draw: a loop of 1 kHz wants the processor.
const LIGHT = { width: 800, height: 620, hash: "?quality=low#layers=bones" };
const GONE = "the page was closed, or its connection was lost";

let server: Server;
let browser: Browser;
/** What led to a stop is written here. */
const trips = mkdtempSync(join(tmpdir(), "thenar-trips-"));

beforeAll(async () => {
  // A hand that opens and closes over a table: thumb and index finger meet. With coarse flesh a busy
  // machine keeps pace.
  const set = ["--set", "hand.0.tets=600", "--trips", trips];
  server = await Server.start("table-press", ["--device", "simulated", ...set]);
  browser = await launch();
});

afterEach(async () => {
  for (const context of browser.contexts()) await context.close();
});

afterAll(async () => {
  await browser?.close();
  await server?.stop();
  rmSync(trips, { recursive: true });
});

const card = (page: Page) => page.getByRole("region", { name: "Devices" });
const headline = (page: Page) => card(page).locator("header strong").innerText();
const reason = (page: Page) => card(page).locator(".touch-reason").innerText();

/** Forces as the page shows them, N. */
async function forces(page: Page): Promise<number[]> {
  const texts = await card(page).locator(".touch-bars output").allInnerTexts();
  return texts.map((text) => Number(text.replace(" N", "")));
}

/** Waits until something holds of the page. */
async function wait(what: string, holds: () => Promise<boolean>, seconds = 60): Promise<void> {
  const end = Date.now() + seconds * 1000;
  while (!(await holds())) {
    if (Date.now() > end) throw new Error(`not within ${seconds} s: ${what}`);
    await new Promise((resolve) => setTimeout(resolve, 30));
  }
}

/** Arms as a person does. */
async function arm(page: Page): Promise<void> {
  await card(page).getByRole("button", { name: "Arm…" }).click();
  const dialog = page.getByRole("dialog", { name: "Let forces through?" });
  expect(await dialog.innerText()).toContain("Research use only");
  expect(await dialog.getByRole("checkbox").isChecked()).toBe(true);
  await dialog.getByRole("button", { name: "Arm", exact: true }).click();
}

/** Armed, with a force on some finger. The guards stop forces when a busy machine stalls the loop: then
 * it is armed again, as a person would. */
async function felt(page: Page): Promise<void> {
  await wait("a force", async () => {
    if (["Dry run", "Stopped"].includes(await headline(page))) {
      await arm(page);
      await wait("an answer", async () => (await headline(page)) !== "Arming…");
    }
    return (await forces(page)).some((force) => force > 0);
  });
}

test("a glove is armed, felt and stopped", { timeout: 240_000 }, async () => {
  const { page, problems } = await open(browser, server.url, LIGHT);
  await until(page, (t) => t.inControl);
  await card(page).waitFor();
  expect([await headline(page), await page.title()]).toEqual(["Dry run", "Thenar"]);
  await wait("the glove", async () => /connected · tracks, shows force/.test(await card(page).innerText()));
  expect(await card(page).locator(".touch-devices").innerText()).toMatch(ADDRESS);
  // Nothing goes out, whatever the fingers do.
  for (let k = 0; k < 20; k++) {
    expect((await forces(page)).every((force) => force === 0)).toBe(true);
    await page.waitForTimeout(100);
  }
  // Thinking better of it arms nothing.
  await card(page).getByRole("button", { name: "Arm…" }).click();
  await page.keyboard.press("Enter");
  expect(await headline(page)).toBe("Dry run");

  // Once by the button, once by the key, wherever the focus is.
  for (const stop of [
    () => card(page).getByRole("button", { name: /^Stop/ }).click(),
    async () => {
      await page.getByRole("button", { name: "Physics" }).click();
      await page.locator('#panel-physics input.value').first().focus();
      await page.keyboard.press("Escape");
    },
  ]) {
    let by = "";
    // A stall may be quicker than the test.
    while (!by.includes("Stop was asked for")) {
      await felt(page);
      expect([await headline(page), await page.title()]).not.toContain("Dry run");
      await stop();
      await wait("stopped", async () => (await headline(page)) === "Stopped");
      by = await reason(page);
    }
    expect(await page.title()).toBe("Thenar");
    await wait("zeros", async () => (await forces(page)).every((force) => force === 0), 2);
  }
  expect(problems).toEqual([]);
});

test("hiding everything but the picture hides no forces", async () => {
  const { page, problems } = await open(browser, server.url, { ...LIGHT, hash: "#ui=off&layers=bones" });
  await until(page, (t) => t.inControl);
  expect(await card(page).isVisible()).toBe(false);
  await read(page, (t) => t.app.connection.send({ type: "arm" }));
  await card(page).getByRole("button", { name: /^Stop/ }).click();
  await wait("stopped", async () => !(await card(page).isVisible()));
  expect(problems).toEqual([]);
});

test("forces end with the page that armed them", { timeout: 240_000 }, async () => {
  const watching = await open(browser, server.url, LIGHT);
  let why = "";
  // A stall may be quicker than the test.
  while (!why.includes(GONE)) {
    const wearer = await open(browser, server.url, LIGHT);
    await wearer.page.getByRole("button", { name: "Run" }).click();
    await read(wearer.page, (t) => t.app.connection.send({ type: "control", take: true }));
    await until(wearer.page, (t) => t.inControl);
    await felt(wearer.page);
    const keeper = card(watching.page).locator(".touch-keeper");
    await wait("who armed", async () => /^Viewer \d+ armed|^$/.test(await keeper.innerText()));
    await wearer.page.close();
    await wait("stopped", async () => (await headline(watching.page)) === "Stopped");
    why = await reason(watching.page);
    expect(wearer.problems).toEqual([]);
  }
  await wait("zeros", async () => (await forces(watching.page)).every((force) => force === 0), 2);
  expect(server.output).toMatch(/forces stopped: whoever armed it has gone/);
  expect(watching.problems).toEqual([]);
});
