// The server dies and comes back; the page says so and goes on by itself.

import type { Browser } from "playwright-core";
import { afterAll, beforeAll, expect, test } from "vitest";
import { grows, launch, open, until } from "./support/browser";
import { Server } from "./support/server";

let server: Server;
let browser: Browser;

beforeAll(async () => {
  server = await Server.start("table-press");
  browser = await launch();
});

afterAll(async () => {
  await browser?.close();
  await server?.stop();
});

test("the server is killed and comes back and the page recovers", async () => {
  const { page, problems } = await open(browser, server.url, { tolerate: /WebSocket|ERR_CONNECTION/ });
  await server.kill();
  await until(page, (t) => t.connection === "waiting" || t.connection === "connecting");
  await page.locator(".banner").filter({ visible: true }).waitFor();
  await server.restart();
  await until(page, (t) => t.connection === "open");
  await grows(page, (t) => t.snapshotsReceived, 10);
  await until(page, (t) => t.inControl);
  await page.locator(".banner").filter({ visible: true }).waitFor({ state: "detached" });
  await grows(page, (t) => t.framesDrawn, 3);
  expect(problems).toEqual([]);
  await page.close();
});
