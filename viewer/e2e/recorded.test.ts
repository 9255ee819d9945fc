// A recorded session on the page: the same hand and forces as when it was live, at its own pace, with
// places to go to; nothing that the page sends moves it.

import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import type { Browser, Page } from "playwright-core";
import { afterAll, afterEach, beforeAll, expect, test } from "vitest";
import { grows, launch, open, read, until } from "./support/browser";
import { Server, program } from "./support/server";

/** The hand presses on the table from 1 s to 2 s; with coarse flesh a busy machine keeps pace. */
const SECONDS = 2.5;

const folder = mkdtempSync(join(tmpdir(), "thenar-recorded-"));
const file = join(folder, "press.rec");
let server: Server;
let browser: Browser;

beforeAll(async () => {
  const args = ["record", "table-press", "--seconds", String(SECONDS), "--set", "hand.0.tets=200"];
  execFileSync(program(), [...args, "--quiet", "--out", file]);
  server = await Server.replay(file);
  browser = await launch();
});

afterEach(async () => {
  for (const context of browser.contexts()) await context.close();
});

afterAll(async () => {
  await browser?.close();
  expect(await server?.stop(), "Ctrl-C ends the program cleanly").toBe(0);
  rmSync(folder, { recursive: true });
});

const place = (page: Page) => page.getByRole("slider", { name: "Place in the recording" });
const pressing = (page: Page) =>
  read(page, (t) => Array.from(t.snapshot!.fingers).reduce((sum, force, i) => sum + (i % 4 === 0 ? force : 0), 0));

/** Goes to a place as a person does: the slider is dragged, which keys do, too. */
async function seek(page: Page, time: number): Promise<void> {
  await place(page).evaluate((slider, time) => {
    (slider as HTMLInputElement).value = String(time);
    slider.dispatchEvent(new Event("input", { bubbles: true }));
  }, time);
}

test("a recording plays, pauses, and goes to any place and back", async () => {
  const { page, problems } = await open(browser, server.url);
  await until(page, (t) => t.inControl);
  expect(await page.locator(".state").innerText()).toBe("Recorded: you control");
  // It goes on by itself, and the slider with it.
  await until(page, (t) => t.snapshot!.time > 0.3 && t.snapshot!.time < 1.5);
  await grows(page, (t) => t.snapshot!.time, 0.1);

  await page.getByRole("button", { name: "Pause (P)" }).click();
  await until(page, (t) => t.app.connection.status!.paused);
  // The hand presses the table: what is shown are the forces of that moment, every time.
  await seek(page, 1.5);
  await until(page, (t) => Math.abs(t.snapshot!.time - 1.5) < 0.01);
  const force = await pressing(page);
  expect(force).toBeGreaterThan(1);
  const contacts = await read(page, (t) => t.snapshot!.contacts.count);
  expect(contacts).toBeGreaterThan(3);
  const nodes = await read(page, (t) => Array.from(t.snapshot!.nodes.slice(0, 300)));
  await seek(page, 0.2);
  await until(page, (t) => Math.abs(t.snapshot!.time - 0.2) < 0.01);
  expect(await pressing(page)).toBeLessThan(0.01 * force);
  await seek(page, 1.5);
  await until(page, (t) => Math.abs(t.snapshot!.time - 1.5) < 0.01);
  expect(await pressing(page)).toBe(force);
  expect(await read(page, (t) => Array.from(t.snapshot!.nodes.slice(0, 300)))).toEqual(nodes);

  const time = await read(page, (t) => t.snapshot!.time);
  await page.getByRole("button", { name: "One step (.)" }).click();
  await expect.poll(() => read(page, (t) => t.snapshot!.time), { timeout: 60_000 }).toBeGreaterThan(time);
  const step = await read(page, (t) => t.model!.time_step);
  expect((await read(page, (t) => t.snapshot!.time)) - time).toBeCloseTo(step, 6);
  // From the end it begins again.
  await seek(page, 2.3);
  await page.getByRole("button", { name: "Go on (P)" }).click();
  await until(page, (t) => t.snapshot!.time > 2.4);
  await until(page, (t) => t.snapshot!.time < 1);
  expect(problems).toEqual([]);
});

test("nothing moves a recorded hand, and the page says why", async () => {
  const { page, problems } = await open(browser, server.url);
  await until(page, (t) => t.inControl);
  await page.getByRole("button", { name: "Physics" }).click();
  expect(await page.locator('#panel-physics input.value').first().isDisabled()).toBe(true);
  expect(await page.locator("#panel-physics").innerText()).toContain("This is a recording");
  const failed = await page.evaluate(async () => {
    const { inputs } = window.thenar.app;
    return inputs.start("mouse").then(
      () => "",
      (error: Error) => error.message,
    );
  });
  expect(failed).toContain("This is a recording");
  // Whoever sends it all the same is told by the server.
  await read(page, (t) => t.app.connection.send({ type: "set", key: "friction", value: 0.1 }));
  await until(page, (t) => t.errors.some((message) => message.includes("this is a recording")));
  expect(await read(page, (t) => t.connection)).toBe("open");
  expect(problems).toEqual([]);
});
